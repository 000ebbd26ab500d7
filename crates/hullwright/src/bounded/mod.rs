//! The default method's stages: few hulls under a bound on the error that is verified against the
//! source. `crates/hullwright/src/decompose.rs` runs them one after the other.
//!
//! | stage | file | what it does |
//! |---|---|---|
//! | simplify | `surfaces`, [`crate::mesh::simplification`] | the exact surface, and the coarse one without detail |
//! | solid | `surfaces`, [`crate::solid`] | whether hulls stay within the bound |
//! | patches | `patch_mesh` | the mesh that is divided: the coarse surface cut into facets, or simplified |
//! | | `bundles` | of a surface of many components near ones become one patch |
//! | | `facets`, `cuts` | surfaces of few triangles are cut where their shape requires it |
//! | | `patches`, `detail` | the coarse surface is divided into patches, which contain its detail |
//! | merge | `merge` | patches join into pieces |
//! | cover | `cover/` | few pieces cover all patches, then shrink to those that they own |
//! | finalize | `finalize/` | pieces become verified hulls with few vertices |
//! | limit | `limit` | the limit on hulls: joins, and the larger bounds of further searches |
//!
//! | used by several stages | |
//! |---|---|
//! | `settings` | the bound, shares of it, and presets |
//! | `search` | surfaces, solids, patches, settings and control |
//! | `patch` | patches, sets of them, and pieces |
//! | `deadline` | what is left out where time is short |
//! | `joins` | pairs that may join |
//! | `join_tree` | hulls join beyond the bound, the pair that protrudes least first |
//! | `uncovered` | how far the exact surface lies outside the hulls |
//! | `verifier` | both errors of finished hulls |
//! | `output` | results in the input's units |

mod bundles;
pub(crate) mod cover;
mod cuts;
pub(crate) mod deadline;
mod detail;
mod facets;
pub(crate) mod finalize;
#[cfg(test)]
mod fixture;
pub(crate) mod join_tree;
mod joins;
pub(crate) mod limit;
pub(crate) mod merge;
pub(crate) mod output;
pub(crate) mod patch;
pub(crate) mod patch_mesh;
pub(crate) mod patches;
pub(crate) mod search;
pub(crate) mod settings;
pub(crate) mod surfaces;
mod uncovered;
pub(crate) mod verifier;
