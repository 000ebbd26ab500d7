//! From what artists ask for, in names and extras, to tags.

use super::tag::{ConvexDecomposition, DecompositionShape};
use crate::conventions::{ColliderKind, NameTag};

/// What becomes of a node with a mesh.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Treatment {
    /// `None` for no collider.
    pub tag: Option<ConvexDecomposition>,
    pub is_drawn: bool,
    /// Whether it becomes a body that moves by itself, if it is none.
    pub is_body: bool,
}

impl From<Option<ConvexDecomposition>> for Treatment {
    fn from(tag: Option<ConvexDecomposition>) -> Self {
        Self { tag, is_drawn: true, is_body: false }
    }
}

/// What a name asks for; `base` is the tag that the scene has for such nodes.
pub(super) fn treatment(name_tag: NameTag, base: ConvexDecomposition) -> Treatment {
    let (tag, is_drawn, is_body) = match name_tag {
        NameTag::Collider(kind) => (made_of(kind, base), true, false),
        NameTag::ColliderOnly(kind) => (made_of(kind, base), false, false),
        NameTag::Body(kind) => (made_of(kind, base), true, true),
        // The mass of the whole is not that of a piece.
        NameTag::PieceOf { kind, .. } => (made_of(kind, base.with_mass(None)), false, false),
        NameTag::LeftOut => return Treatment { tag: None, is_drawn: false, is_body: false },
    };
    Treatment { tag: Some(tag), is_drawn, is_body }
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

/// The scene's tag with the settings of extras; `None` where these want no collider.
#[cfg(feature = "bevy_gltf")]
pub(super) fn with_extras(
    extras: &crate::conventions::ExtrasTag,
    base: ConvexDecomposition,
) -> Option<ConvexDecomposition> {
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
