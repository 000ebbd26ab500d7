//! The paper's method: *A surface-based approach for 3D approximate convex decomposition*.
//! `docs/paper.md` in the repository compares results, and says what was read into the paper.
//!
//! The surface is simplified to several resolutions. At each it is divided into nearly convex
//! groups under several thresholds, of which the concavity cost selects one. The hulls of its
//! groups are the pieces. The method promises no bound. HACD, which the paper compares itself with,
//! groups the surface in another way, and all else stays the same: [`SurfaceParameters::hacd`].
//!
//! ```
//! use hullwright::surface::{SurfaceParameters, decompose};
//! use hullwright::{Control, MeshView};
//!
//! # fn main() -> Result<(), hullwright::Error> {
//! let positions = [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
//! let mesh = MeshView::new(&positions, &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]);
//! let mut parameters = SurfaceParameters::paper();
//! parameters.maximum_resolutions = vec![500];
//! let result = decompose(mesh, &parameters, &Control::new())?;
//! assert_eq!((result.hulls.len(), result.report.pieces), (1, 1));
//! # Ok(())
//! # }
//! ```
//!
//! | file | section of the paper |
//! |---|---|
//! | `decompose` | the method, stage by stage; a row of its Table 1 |
//! | `parameters` | its symbols |
//! | `crate::mesh::simplify` | 3.2, simplification |
//! | `crate::mesh::grouping` | 3.4.1, convex grouping |
//! | `threshold_selection` | 3.4.2, selection among the planar thresholds |
//! | `hacd` | 4.2, the grouping of HACD in place of 3.4 |
//! | `cost` | 3.4.3, concavity cost |
//! | `resolution_selection` | 3.5, selection among the resolutions |
//! | `pieces` | 3.6, group merging, and hulls of the groups |

mod cost;
pub(crate) mod decompose;
mod hacd;
mod parameters;
pub(crate) mod pieces;
mod resolution_selection;
mod threshold_selection;

pub use cost::average_cost;
pub use decompose::{SurfaceReport, decompose};
pub use parameters::SurfaceParameters;
pub use resolution_selection::{ResolutionOutcome, ResolutionReport};
pub use threshold_selection::{ThresholdOutcome, ThresholdReport};
