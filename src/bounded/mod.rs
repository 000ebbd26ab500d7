//! The default method's stages: few hulls under a bound on the error that is verified against the source.
//! `src/decompose.rs` runs them one after the other.
//!
//! | stage | file | what it does |
//! |---|---|---|
//! | solid | `clustering/` | very dense meshes are searched through reduced ones |
//! | | `containment/` | whether hulls stay within the bound of the solid |
//! | | `cells/`, `refine`, `patches/patch_mesh` | the mesh that is divided: cut where its shape asks for it, long triangles halved |
//! | patches | `patches/` | the surface is divided into patches |
//! | merge | `piece`, `merge` | patches join into pieces |
//! | cover | `set_cover/` | few pieces cover all patches, then shrink to those that they own |
//! | finalize | `finalize/` | pieces become verified hulls with few vertices |
//! | limit | `hierarchy/`, `max_hulls` | hulls join beyond the bound, down to a cap; larger bounds are searched |
//!
//! What several stages use: `settings` (the bound, shares of it, and presets), `search` (solid, patches, settings
//! and control), `deadline`, `growing_hull`, `patch_set`, `work` (counted in tests), and `output` (results in the
//! input's units). `decomposition_hierarchy` joins the hulls of a finished decomposition, on demand.

mod cells;
mod clustering;
pub(crate) mod containment;
pub(crate) mod deadline;
pub(crate) mod decomposition_hierarchy;
pub(crate) mod finalize;
mod growing_hull;
mod hierarchy;
pub(crate) mod max_hulls;
pub(crate) mod merge;
pub(crate) mod output;
mod patch_set;
pub(crate) mod patches;
mod piece;
mod refine;
pub(crate) mod search;
pub(crate) mod set_cover;
pub(crate) mod settings;
mod work;
