//! Colliders and mass properties for rapier3d 0.36, without an engine.
//!
//! bevy_rapier3d 0.37 re-exports the same Rapier: what is made here fits there.
//!
//! ```
//! use hullwright::{Control, Parameters};
//! use rapier3d::prelude::*;
//!
//! # fn main() -> Result<(), hullwright_rapier::ColliderError> {
//! # let mesh = hullwright::TriangleMesh::new(
//! #     vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
//! #     vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
//! # );
//! let density = 1000.0;
//! let parameters = Parameters::default();
//! let collider = hullwright_rapier::collider_from_mesh(&mesh, density, &parameters)?;
//!
//! let mut bodies = RigidBodySet::new();
//! let mut colliders = ColliderSet::new();
//! let body = bodies.insert(RigidBodyBuilder::dynamic());
//! colliders.insert_with_parent(collider, body, &mut bodies);
//! # Ok(())
//! # }
//! ```
//!
//! For a decomposition that is kept, or read from a `.hulls` file, there are [`collider`] and
//! [`shape`]; for hulls of another tool, [`shape_from_points`]. A `SharedShape` may be shared by
//! any number of colliders.
//!
//! What hangs on something round, as a mug on a hook, swings on without end in Rapier, whatever its
//! collider is made of: contacts are kept where they were while bodies move by less than 5 cm. Set
//! `IntegrationParameters::normalized_contact_recycle_distance` to 0.001 there, and damp its
//! turning a little.

#![cfg_attr(docsrs, feature(doc_cfg))]

mod dispatcher;
mod seams;

use hullwright::{Control, Hull, MassProperties, MeshView, Parameters};
use rapier3d::geometry::ColliderBuilder;

pub use dispatcher::ContactDispatcher;
/// What Rapier takes as it is: its shapes and mass properties are Parry's.
pub use hullwright_parry::{
    ColliderError, convex_polyhedron, hull_from_shape, mass_properties, mesh_from_shape, shape,
    shape_from_points, shape_with_primitives, triangle_mesh,
};

/// A collider of all hulls with the mass properties of the source mesh, both scaled: see
/// [`shape`](shape()) and [`mass_properties`](mass_properties()).
///
/// ```
/// # let mesh = hullwright::TriangleMesh::new(
/// #     vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
/// #     vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
/// # );
/// # let parameters = hullwright::Parameters::default();
/// # let hulls = hullwright::decompose(&mesh, &parameters, &hullwright::Control::new())?.hulls;
/// let properties = hullwright::mass_properties(&mesh, &hulls, 600.0)?;
/// let collider = hullwright_rapier::collider(&hulls, &properties, [1.0; 3])?.build();
/// assert!((collider.mass() - 100.0).abs() < 1e-3);
/// # Ok::<(), hullwright_rapier::ColliderError>(())
/// ```
///
/// # Errors
/// As [`shape`](shape()) and [`mass_properties`](mass_properties()).
pub fn collider(
    hulls: &[Hull],
    properties: &MassProperties,
    scale: [f32; 3],
) -> Result<ColliderBuilder, ColliderError> {
    let properties = mass_properties(properties, scale)?;
    Ok(ColliderBuilder::new(shape(hulls, scale)?).mass_properties(properties))
}

/// Decomposes a mesh and makes a collider of it, with the mass properties of the mesh at a
/// `density` (mass per cubed unit).
///
/// # Errors
/// [`ColliderError::Mesh`] as [`decompose`](hullwright::decompose) and
/// [`mass_properties`](hullwright::mass_properties()), else as [`collider`].
pub fn collider_from_mesh<'a>(
    mesh: impl Into<MeshView<'a>>,
    density: f64,
    parameters: &Parameters,
) -> Result<ColliderBuilder, ColliderError> {
    let mesh = mesh.into();
    let hulls = hullwright::decompose(mesh, parameters, &Control::new())?.hulls;
    let properties = hullwright::mass_properties_with(mesh, &hulls, density, parameters)?;
    collider(&hulls, &properties, [1.0; 3])
}

/// The examples of the README run.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
