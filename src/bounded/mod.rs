//! The default method's stages: few hulls under a bound on the error that is verified against the source.
//! `src/decompose.rs` runs them one after the other.
//!
//! | stage | file | what it does |
//! |---|---|---|
//! | solid | `clustering`, `vertex_clusters` | very dense meshes are searched through reduced ones |
//! | | `containment/` | whether hulls stay within the bound of the solid |
//! | | `patch_mesh` | the mesh that is divided: simplified, or cut into facets |
//! | | `facets`, `cuts` | coarse meshes are cut where their shape requires it |
//! | | `refine` | long triangles are halved, where the shape does not say where to cut |
//! | patches | `patches`, `patch` | the surface is divided into patches |
//! | merge | `merge` | patches join into pieces |
//! | cover | `cover/` | few pieces cover all patches, then shrink to those that they own |
//! | finalize | `finalize/` | pieces become verified hulls with few vertices |
//! | limit | `limit` | the limit on hulls: joins, and searches under larger bounds |
//!
//! | used by several stages | |
//! |---|---|
//! | `settings` | the bound, shares of it, and presets |
//! | `search` | solid, patches, settings and control |
//! | `deadline` | what is left out where time is short |
//! | `growing_hull`, `joins`, `work` | hulls that grow, pairs that may join, and counted work |
//! | `join_tree`, `witness` | hulls join beyond the bound, the pair that protrudes least first |
//! | `output` | results in the input's units |

mod clustering;
pub(crate) mod containment;
pub(crate) mod cover;
mod cuts;
pub(crate) mod deadline;
mod facets;
pub(crate) mod finalize;
mod growing_hull;
pub(crate) mod join_tree;
mod joins;
pub(crate) mod limit;
pub(crate) mod merge;
pub(crate) mod output;
pub(crate) mod patch;
mod patch_mesh;
pub(crate) mod patches;
mod refine;
pub(crate) mod search;
pub(crate) mod settings;
mod vertex_clusters;
mod witness;
mod work;
