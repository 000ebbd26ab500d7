//! Concave triangle meshes into few convex hulls, fast and with a measured error.
//!
//! Game physics can't move a concave body: the engine wants convex pieces.
//! [`decompose`] takes positions and triangles and returns convex hulls with an honest
//! [`Report`].
//!
//! # Conventions
//!
//! - **Units** are the input's. Lengths that are *relative* say so: they are divided by the
//!   diagonal of the bounding box of the vertices that triangles use.
//! - **Winding**: right- and left-handed input both work, since a closed mesh that encloses a
//!   negative volume is turned around. Triangles of the output are wound counter-clockwise seen
//!   from outside (in a right-handed frame), so that normals point outward.
//! - **Precision**: everything is computed in `f64` on a copy that is moved to the origin and
//!   scaled to a diagonal of 1; results are returned in the input's units.
//! - **Determinism**: the same input and parameters give the same result, for any number of
//!   threads. Only a deadline ([`Control::with_deadline`]) may make a result depend on time.
//!
//! # Module map
//!
//! | module | stage | paper |
//! |---|---|---|
//! | `mesh::repair` | weld, drop, orient, split into components | – |
//! | `mesh::adjacency` | triangles, vertices, the 3n adjacency list | 3.3 |
//! | `mesh::simplify` | simplification quality Q and maximum resolution r | 3.2 |
//! | `surface::grouping` | convex polygon grouping | 3.4.1 |
//! | `surface::threshold_selection` | the search over planar thresholds p | 3.4.2 |
//! | `surface::cost` | concavity cost, equation (3) | 3.4.3 |
//! | `surface::resolution_selection` | the search over maximum resolutions R | 3.5 |
//! | `surface::group_merging` | small groups join their neighbours | 3.6 |
//! | `hacd` (feature `bench`) | HACD, which the paper compares itself with | 4.2 |
//! | `bounded` | the default method: seeds, merging, growing, dissolving, verification | – |
//! | `merge_tree` | fewer hulls afterwards, without a new run | – |
//! | `hull` | convex hulls of the groups, thickness of flat ones, vertex cap | 3.6 |
//! | `field` | distance to the surface, generalized winding number | – |
//! | `measure` | judges any set of hulls against a mesh | – |
//! | `mass` | mass, centre and inertia of the source mesh | – |
//! | `hulls_format` | `.hulls`: a decomposition in a file | – |
//! | `inspect` | what a mesh holds, without decomposing it | – |
//! | `io` (feature) | readers and writers of mesh files | – |
//! | `rapier` (feature) | colliders and mass properties for rapier3d 0.36 | – |
//! | `bevy` (feature) | the plugin for Bevy 0.20 with bevy_rapier3d 0.37 | – |
//! | `picture` (feature `io`) | draws meshes and hulls into a PNG, without a GPU | – |

#[cfg(feature = "fs")]
mod atomic_write;
#[cfg(feature = "bevy")]
pub mod bevy;
mod bounded;
mod bvh;
mod clock;
mod control;
mod decompose;
mod decomposition;
mod error;
mod geometry;
#[cfg(feature = "bench")]
pub mod hacd;
pub mod hull;
pub mod hulls_format;
mod inspect;
#[cfg(feature = "io")]
pub mod io;
mod mass;
pub mod measure;
mod merge_tree;
mod mesh;
mod parallel;
mod parameters;
#[cfg(feature = "rapier")]
pub mod rapier;
#[cfg(feature = "io")]
pub mod render;
mod surface;

pub use control::{Control, Progress, Stage};
pub use decompose::{Decomposer, decompose};
pub use decomposition::{
    ALGORITHM_VERSION, BoundedReport, Decomposition, GroupedMesh, Hull, HullErrors, Provenance,
    Report, ResolutionOutcome, ResolutionReport, StageTime, SurfaceReport, ThresholdOutcome,
    ThresholdReport,
};
pub use error::{Error, FileError};
pub use geometry::{Bounds, Coordinate, MeshView, Sidedness, TriangleMesh};
pub use hull::{ConvexHull, SinglePrecisionHull, convex_hull};
pub use inspect::{Inspection, inspect};
#[cfg(feature = "nalgebra")]
pub use mass::PrincipalInertia;
pub use mass::{MassProperties, MassSource, mass_properties};
pub use merge_tree::{CurvePoint, MergeTree};
pub use mesh::repair::Repairs;
pub use parameters::{
    BoundedParameters, Length, Method, Parameters, ParseError, Preset, SurfaceParameters,
};
#[cfg(feature = "rapier")]
pub use rapier::ColliderError;
