//! Shapes and mass properties for parry3d 0.31, the collision library under Rapier and Avian.
//!
//! ```
//! use hullwright::{Control, Parameters};
//!
//! # fn main() -> Result<(), hullwright_parry::ColliderError> {
//! # let mesh = hullwright::TriangleMesh::new(
//! #     vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
//! #     vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
//! # );
//! let hulls = hullwright::decompose(&mesh, &Parameters::default(), &Control::new())?.hulls;
//! let shape = hullwright_parry::shape(&hulls, [1.0; 3])?;
//!
//! // The mass, centre and inertia of the mesh, at 1000 kg/m³.
//! let mass = hullwright::mass_properties(&mesh, &hulls, 1000.0)?;
//! let mass = hullwright_parry::mass_properties(&mass, [1.0; 3])?;
//! assert!((mass.mass() - 1000.0 / 6.0).abs() < 0.1);
//! # let _ = shape;
//! # Ok(())
//! # }
//! ```
//!
//! rapier3d 0.36 and avian3d 0.8 take the same `SharedShape`, which any number of colliders may
//! share. For hulls of another tool there is [`shape_from_points`], for a `.hulls` file
//! [`shape_with_primitives`].

#![cfg_attr(docsrs, feature(doc_cfg))]

mod shape;

/// The version whose types are in the signatures.
pub use parry3d;
pub use shape::{
    ColliderError, convex_polyhedron, hull_from_shape, mass_properties, mesh_from_shape, shape,
    shape_from_points, shape_with_primitives, subshape_at, triangle_mesh,
};

/// The examples of the README run.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
