//! Convex hulls, in double precision, that a physics engine can take as they are.
//!
//! [`convex_hull`] takes one set of points; a [`HullBuilder`] keeps its memory between hulls, and
//! its hull can grow. Flat, linear and point-like sets get a small thickness
//! ([`MINIMUM_THICKNESS`]), so that every hull has volume.
//!
//! ```
//! use hullwright::hull::{HullBuilder, Shape, solid_hull};
//!
//! let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
//! let mut builder = HullBuilder::new();
//! assert_eq!(builder.build(&square), Shape::Flat);
//!
//! // Against the outward normal, so that the upper side stays in place.
//! let (plate, added) = solid_hull(&mut builder, &square, [0.0, 0.0, 1.0], 0.01)?;
//! assert_eq!((plate.points.len(), added), (8, 0.01));
//!
//! builder.insert(&[[0.5, 0.5, 1.0], [0.5, 0.5, 0.2]]);
//! assert_eq!(builder.extract().0.len(), 9);
//! # Ok::<(), hullwright::Error>(())
//! ```
//!
//! | file | contents |
//! |---|---|
//! | `convex_hull` | the polyhedron; hulls of points with volume, also in `f32` |
//! | `growing_hull` | [`HullBuilder`], and the hull that grows during the search |
//! | `quickhull`, `face` | the first simplex, and the steps by which a hull grows; its triangles |
//! | `simplification` | fewer vertices |
//! | `primitive` | boxes, balls and capsules in place of hulls |

mod convex_hull;
mod face;
pub(crate) mod growing_hull;
mod primitive;
mod quickhull;
mod simplification;

pub use convex_hull::{
    ConvexHull, MINIMUM_THICKNESS, SinglePrecisionHull, convex_hull, rounded_hull,
    single_precision, solid_hull,
};
pub(crate) use convex_hull::{LEAST_THICKNESS, joint_hull};
pub use growing_hull::{DEFAULT_TOLERANCE, HullBuilder};
pub use primitive::{Primitive, Slack, fit_primitive};
pub use quickhull::Shape;
pub(crate) use simplification::{collapse_edges, limit_vertices, most_prominent, prominent};
