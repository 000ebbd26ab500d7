//! Convex hulls, in double precision, that a physics engine can take as they are.
//!
//! [`convex_hull`] answers for one set of points; a [`HullBuilder`] keeps its memory between
//! hulls and can go on growing a hull. Flat, linear and point-like sets get a small thickness
//! ([`MINIMUM_THICKNESS`]), so that every hull has volume.

mod builder;
mod collapse;
mod columns;
mod convex_hull;
mod extent;
mod face;
mod grow;
pub(crate) mod growing_hull;
mod max_vertices;
mod primitive;
mod query;
mod redundant;
mod sharp_edges;
mod simplex;
mod single_precision;
mod thickness;
mod waiting_points;

pub use builder::{DEFAULT_TOLERANCE, HullBuilder};
pub(crate) use collapse::collapse_edges;
pub use convex_hull::{ConvexHull, convex_hull};
pub(crate) use max_vertices::{cap_vertices, coarser, most_prominent};
pub use primitive::{Primitive, Slack, fit_primitive};
pub use simplex::Shape;
pub use single_precision::{SinglePrecisionHull, single_precision};
pub(crate) use thickness::{LEAST_THICKNESS, joint_hull};
pub use thickness::{MINIMUM_THICKNESS, solid_hull};
