//! Closed meshes of very many triangles are searched through reduced ones.
//!
//! | file | contents |
//! |---|---|
//! | `clustered` | the reduced mesh, and distances to what it represents |
//! | `vertex_clusters` | which vertices become one, and which vertex replaces the others |

mod clustered;
mod vertex_clusters;

pub(crate) use clustered::{Clustered, cluster};
