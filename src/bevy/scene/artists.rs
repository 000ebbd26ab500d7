//! Tags from names and extras, by which artists choose colliders.

use bevy_rapier3d::prelude::RigidBody;

use crate::bevy::tag::components::{ConvexDecomposition, DecompositionShape};
#[cfg(feature = "bevy_gltf")]
use crate::conventions::{Body, ExtrasTag};
use crate::conventions::{ColliderKind, NameTag};

/// What becomes of a node with a mesh.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Treatment {
    /// `None` for no collider.
    pub tag: Option<ConvexDecomposition>,
    pub is_drawn: bool,
    /// The body that it becomes, if it is none.
    pub body: Option<RigidBody>,
}

impl From<Option<ConvexDecomposition>> for Treatment {
    fn from(tag: Option<ConvexDecomposition>) -> Self {
        Self { tag, is_drawn: true, body: None }
    }
}

/// What becomes of a node with such a name; `base` is the tag that the scene has for such nodes.
pub(crate) fn treatment(name_tag: NameTag, base: ConvexDecomposition) -> Treatment {
    let (tag, is_drawn, body) = match name_tag {
        NameTag::Collider(kind) => (made_of(kind, base), true, None),
        NameTag::ColliderOnly(kind) => (made_of(kind, base), false, None),
        NameTag::Body(kind) => (made_of(kind, base), true, Some(RigidBody::Dynamic)),
        // The mass of the whole is not that of a piece.
        NameTag::PieceOf { kind, .. } => (made_of(kind, base.with_mass(None)), false, None),
        NameTag::LeftOut => return Treatment { tag: None, is_drawn: false, body: None },
    };
    Treatment { tag: Some(tag), is_drawn, body }
}

fn made_of(kind: ColliderKind, base: ConvexDecomposition) -> ConvexDecomposition {
    match kind {
        // As the scene says for what moves and what does not.
        ColliderKind::Decomposition => base,
        ColliderKind::Hulls => base.with_shape(DecompositionShape::Hulls),
        ColliderKind::Triangles => base.with_shape(DecompositionShape::Triangles),
        ColliderKind::ConvexHull => base.with_shape(DecompositionShape::ConvexHull),
        ColliderKind::Cuboid => base.with_shape(DecompositionShape::Cuboid),
        ColliderKind::Ball => base.with_shape(DecompositionShape::Ball),
        ColliderKind::Capsule => base.with_shape(DecompositionShape::Capsule),
    }
}

/// What becomes of a node with such extras; `base` is the tag that the scene has.
#[cfg(feature = "bevy_gltf")]
pub(crate) fn with_extras(extras: &ExtrasTag, base: ConvexDecomposition) -> Treatment {
    let body = extras.body.map(|body| match body {
        Body::Dynamic => RigidBody::Dynamic,
        Body::Fixed => RigidBody::Fixed,
        Body::Kinematic => RigidBody::KinematicPositionBased,
    });
    Treatment { tag: tag_of_extras(extras, base), is_drawn: true, body }
}

/// The scene's tag with the settings of extras; `None` where these exclude a collider.
#[cfg(feature = "bevy_gltf")]
fn tag_of_extras(extras: &ExtrasTag, base: ConvexDecomposition) -> Option<ConvexDecomposition> {
    let mut tag = made_of(extras.kind?, base);
    if let Some(max_error) = extras.max_error {
        tag.max_error = max_error.into();
    }
    if let Some(preset) = extras.preset {
        tag.preset = preset.into();
    }
    if let Some(openings) = extras.openings {
        tag.openings = openings.into();
    }
    tag.max_hulls = extras.max_hulls.or(tag.max_hulls);
    tag.max_vertices = extras.max_vertices.or(tag.max_vertices);
    tag.keep_cavities = extras.keep_cavities.unwrap_or(tag.keep_cavities);
    tag.density = extras.density.unwrap_or(tag.density);
    // One stands for the other.
    if extras.density.is_some() || extras.mass.is_some() {
        tag.mass = extras.mass;
    }
    tag.fallback_collider = extras.fallback.map(Into::into).or(tag.fallback_collider);
    Some(tag)
}
