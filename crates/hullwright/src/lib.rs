//! Approximate convex decomposition of triangle meshes, with a measured and bounded error.
//!
//! A physics engine moves convex bodies. A concave mesh becomes a moving body as a compound of
//! convex hulls. [`decompose`] makes few such hulls, and a [`Report`] that says how far they are
//! from the mesh: the default method keeps a bound that you choose, and verifies it against the
//! mesh.
//!
//! ```
//! use hullwright::{Control, Length, MeshView, Parameters, decompose};
//!
//! # fn main() -> Result<(), hullwright::Error> {
//! // An L: two boxes.
//! let outline = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0_f32]];
//! let positions: Vec<[f32; 3]> =
//!     [0.0, 1.0].iter().flat_map(|&z| outline.map(|[x, y]| [x, y, z])).collect();
//! let mut triangles = vec![[0, 2, 1], [0, 3, 2], [0, 4, 3], [0, 5, 4]];
//! triangles.extend([[6, 7, 8], [6, 8, 9], [6, 9, 10], [6, 10, 11]]);
//! triangles.extend((0..6).flat_map(|a| {
//!     let b = (a + 1) % 6;
//!     [[a, b, b + 6], [a, b + 6, a + 6]]
//! }));
//!
//! let mesh = MeshView::new(&positions, &triangles);
//! let parameters = Parameters::default().with_max_error(Length::share(0.02));
//! let result = decompose(mesh, &parameters, &Control::new())?;
//! assert_eq!(result.hulls.len(), 2);
//!
//! let report = result.report;
//! assert!(report.protrusion_max <= report.bound && report.uncovered_max <= report.bound);
//! for hull in &result.hulls {
//!     let (points, triangles) = hull.shape.to_single_precision()?;
//!     println!("{} vertices, {} triangles", points.len(), triangles.len());
//! }
//! # Ok(())
//! # }
//! ```
//!
//! # Where to start
//!
//! | you have | you want | use |
//! |---|---|---|
//! | a mesh, or a mesh file (crate `hullwright_formats`) | convex hulls | [`decompose`]; [`Decomposer`] in time slices |
//! | the same | the paper's own hulls; the one hull of all points; the choice as one value | [`surface::decompose`](surface::decompose()); [`single_hull()`]; [`Method`] |
//! | a decomposition, or hulls of any tool | fewer hulls | [`MergeTree`] |
//! | a mesh and hulls of any tool | their errors | [`measure::measure`]; point by point [`measure::MeasuredMesh`] |
//! | a mesh of several materials or primitives, and its hulls | what each hull is made of | [`part_shares()`] |
//! | a mesh and its hulls | fragments to draw and to move, one for each hull | [`break_apart()`] |
//! | a level, or any mesh that never moves | few triangles within a bound | [`simplify_surface()`] |
//! | two surfaces, one of which stands for the other | how far they are from each other at most | [`surface_distances()`] |
//! | a mesh | mass, centre and inertia; a report on its defects | [`mass_properties()`]; [`inspect`] |
//! | hulls | a file that games load | [`hulls_format`]; `hullwright_formats::bake` for a scene |
//! | a mesh, Rapier or Bevy | a collider with the mesh's mass | the crates `hullwright_rapier`, `bevy_hullwright` |
//! | a mesh and hulls | a picture, a page to look at them | the command `hullwright view`, or its crate `hullwright-cli` |
//!
//! # Methods
//!
//! - [`decompose`], the default: patches of the surface merge, under a bound on the error, into few
//!   hulls that cover the surface. The bound is verified against the source. `docs/algorithm.md` in
//!   the repository explains each stage, with pictures, and why the bound is sound.
//! - [`surface::decompose`](surface::decompose()): the method of the paper *A surface-based
//!   approach for 3D approximate convex decomposition*, with the paper's parameters. It promises no
//!   bound.
//! - [`single_hull()`]: no decomposition, but the one hull of all points.
//!
//! A [`Method`] is one of the three with its parameters.
//!
//! # Two distances
//!
//! - **Protrusion**: how far a hull is outside of the solid. Objects stop before they touch.
//! - **Uncovered distance**: how far the mesh's surface is outside of every hull. Objects sink in.
//!
//! Both are at most [`Parameters::max_error`], unless a limit on hulls forces more or a flat part
//! has to be thicker to be a hull; the report says how much. *Uncovered volume* is the share of the
//! solid that no hull holds. [`measure`] samples all three, for hulls of any tool.
//!
//! # Conventions
//!
//! - **Units** are the input's. A [`Length`] is a fraction of the diagonal of the bounding box of
//!   the vertices that triangles use, or a number of the input's units.
//! - **Winding**: right- and left-handed input both work. A closed mesh that encloses a negative
//!   volume is turned around. Triangles of hulls run counter-clockwise seen from outside, in a
//!   right-handed frame.
//! - **Precision**: everything is computed in `f64` on a copy that is moved to the origin and
//!   scaled to a diagonal of 1.
//! - **Determinism**: the same input and parameters give the same result, for any number of
//!   threads. Only a deadline ([`Control::with_deadline`]) makes a result depend on time.
//! - **Panics**: none, whatever the input. Every function that can fail returns a typed error:
//!   [`Error`], or that of its module ([`hulls_format::HullsFileError`], [`ParseError`]).
//!
//! # Features
//!
//! | feature | what it adds |
//! |---|---|
//! | `parallel` (default) | independent parts of the work run on rayon's pool; the result stays the same |
//! | `serde` | parameters, reports and measurements can be written and read, for example by serde_json |
//! | `scene` | meshes by content, scenes in one `.hullscene` file |
//! | `fill` | the surface of what a probe does not reach, for display |
//! | `nalgebra` | principal axes of inertia |
//! | `bevy_reflect` | [`Preset`] and [`Openings`] are reflected, for components of Bevy |
//!
//! # Inside
//!
//! Imports go down only: from the public functions to the two methods (`bounded`, `surface`), and
//! to what these share, from `solid` down to `geometry`. `CONTRIBUTING.md` in the
//! repository has the table.

#![cfg_attr(docsrs, feature(doc_cfg))]

mod bounded;
mod break_apart;
mod bvh;
mod control;
mod decompose;
mod decomposer;
mod decomposition;
mod error;
mod geometry;
pub mod hull;
pub mod hulls_format;
pub mod inspect;
mod least_hulls;
mod mass;
pub mod measure;
pub mod merge_tree;
mod mesh;
mod method;
pub mod openings;
mod parallel;
mod parameters;
mod part_shares;
mod probe;
mod simplify_surface;
mod solid;
mod sorting;
mod stages;
mod summary;
pub mod surface;
mod work;

pub use break_apart::{Fragment, FragmentVertex, break_apart};
pub use control::{Control, Progress, Stage};
pub use decompose::decompose;
pub use decomposer::Decomposer;
pub use decomposition::{
    ALGORITHM_VERSION, Decomposition, GroupedMesh, Hull, HullErrors, ProbeReport, Provenance,
    Report, RunReport, StageTime,
};
pub use error::{Error, FileError};
pub use geometry::{Bounds, Coordinate, MeshView, Sidedness, TriangleMesh};
pub use hull::{ConvexHull, convex_hull};
pub use least_hulls::{LeastHulls, least_hulls};
#[cfg(feature = "nalgebra")]
pub use mass::PrincipalInertia;
pub use mass::{MassProperties, MassSource, mass_properties, mass_properties_with};
pub use merge_tree::MergeTree;
pub use mesh::Repairs;
pub use method::{Method, MethodReport, single_hull};
pub use parameters::{Length, Openings, Parameters, ParseError, Preset, UpAxis};
pub use part_shares::{PartShare, part_shares};
pub use simplify_surface::{
    HiddenTriangles, MeasuredSurface, SimplifiedSurface, SimplifyParameters, SimplifyReport,
    SurfaceDistance, SurfaceDistances, simplify_surface, surface_distances,
};

/// The examples of the README run.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
