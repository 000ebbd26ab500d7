//! What users set on an entity, and what is reported about it: the tag, the exclusion, the focus,
//! the priority.

pub(super) mod outcomes;
pub(super) mod parameters;
pub(super) mod settings;
pub(super) mod template;

use bevy::prelude::*;
use hullwright::Method;

use self::outcomes::{
    ColliderAbsent, ColliderReady, DecompositionCancelled, DecompositionCounters,
    DecompositionFailed, DecompositionReady, DecompositionSkipped, DecompositionStatus,
};
use self::settings::{FallbackCollider, HullwrightSettings};
/// The library's `Openings` and `Preset` under the plugin's names.
pub use hullwright::{Openings as DecompositionOpenings, Preset as DecompositionPreset};

/// Gives the entity a collider of convex hulls, made in the background from the meshes on it and
/// below it, all as one input.
///
/// It may come before the mesh is loaded, before `Mesh3d` exists, or sit on a parent whose
/// children hold the meshes, as the nodes of a glTF scene do. Below it, what has a tag or the
/// physics engine's `RigidBody` of its own or [`NoConvexDecomposition`] is left out, with all its
/// children, and so is what is `Disabled`.
///
/// The collider follows what it is made of: meshes that come, change or go, the scale, the tag
/// itself. An entity to which the game gives a `Collider` of its own, at any time, is skipped. The
/// tag may be removed once the collider is there; the collider stays.
///
/// ```
/// use bevy_hullwright::prelude::*;
///
/// let mug = ConvexDecomposition::default().with_max_error(0.01).with_max_hulls(16);
/// let house = ConvexDecomposition::default().with_max_error(MaxError::Metres(0.1));
/// # assert_eq!(mug.max_error, MaxError::Share(0.01));
/// # assert_eq!(house.max_hulls, None);
/// ```
#[derive(Component, Reflect, Debug, Clone, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[type_path = "hullwright"]
#[require(DecompositionStatus, Transform)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
pub struct ConvexDecomposition {
    /// The bound: no point of the hulls is farther than this outside the solid, and no point of the
    /// surface farther outside every hull. Verified. Default 2 % of the mesh's diagonal.
    pub max_error: MaxError,
    /// How much work is put into few hulls.
    pub preset: DecompositionPreset,
    /// Most hulls, at least 1; `None` for no limit. Where it forces hulls to join beyond the bound,
    /// those that protrude least do. Default `None`.
    pub max_hulls: Option<u32>,
    /// Most vertices of a hull, at least 8; `None` for no limit. Default 64.
    pub max_vertices: Option<u32>,
    /// Whether cavities that nothing from outside can enter stay empty. Default false.
    pub keep_cavities: bool,
    /// What becomes of flat openings, the sides that a modeller leaves out. One primitive of a
    /// larger glTF mesh keeps them: the others close it. Default [`DecompositionOpenings::Auto`].
    pub openings: DecompositionOpenings,
    /// Half the thickness of the thinnest thing that moves, in metres of the world; positive. Hulls
    /// may fill what no ball of that radius can reach: fewer hulls. Not with cavities that are
    /// kept. `None` for what [`HullwrightSettings`](crate::HullwrightSettings) says. Default
    /// `None`.
    pub probe_radius: Option<f32>,
    /// How far the triangles of what never moves may be from the mesh, and the mesh from them, in
    /// metres of the world: then there are few of them, and it is verified. 0 for the mesh's own
    /// triangles. `None` for what [`HullwrightSettings`](crate::HullwrightSettings) says. Default
    /// `None`.
    pub level_bound: Option<f32>,
    /// What the collider is made of. Default [`DecompositionShape::Auto`].
    pub shape: DecompositionShape,
    /// Mass per cubed unit of the world; positive. Default 1.
    pub density: f32,
    /// The mass of the whole collider in the world, whatever its scale, instead of the density;
    /// positive. Default `None`.
    pub mass: Option<f32>,
    /// Which hulls have a collider of their own, on a child with a
    /// [`HullCollider`](crate::HullCollider), instead of all together one on the entity. What is
    /// made of triangles or is a box, ball or capsule has no children. Default `None`.
    pub children: Option<HullGrouping>,
    /// The collider until the entity's own is ready; `None` for what
    /// [`HullwrightSettings`](crate::HullwrightSettings) says.
    pub fallback_collider: Option<FallbackCollider>,
    /// The library's own parameters, or another of its methods with its parameters, instead of all
    /// settings of the decomposition. Not in scenes, since they are not reflected. Default `None`.
    #[reflect(ignore)]
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub parameters: Option<Method>,
}

/// How far hulls and mesh may be apart.
#[derive(Reflect, Debug, Clone, Copy, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
#[type_path = "hullwright"]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum MaxError {
    /// This share of the mesh's bounding-box diagonal, before the entity's scale.
    Share(f32),
    /// This many units of the world, whatever the scale. A changed scale is a new decomposition.
    Metres(f32),
}

/// Smaller gaps between a prop and its collider go unnoticed in play.
const DEFAULT_MAX_ERROR: MaxError = MaxError::Share(0.02);

impl Default for MaxError {
    fn default() -> Self {
        DEFAULT_MAX_ERROR
    }
}

/// A number is a share: 0.02 is 2 %.
impl From<f32> for MaxError {
    fn from(share: f32) -> Self {
        Self::Share(share)
    }
}

/// What a collider is made of.
#[derive(Reflect, Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[reflect(Default, Clone, PartialEq)]
#[type_path = "hullwright"]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum DecompositionShape {
    /// Hulls. The triangles where nothing moves: on a fixed body, and without any body, unless it
    /// is a sensor: triangles have no inside.
    /// [`HullwrightSettings::exact_static_colliders`](crate::HullwrightSettings::exact_static_colliders)
    /// switches that off.
    #[default]
    Auto,
    /// Hulls, also where nothing moves.
    Hulls,
    /// The triangles, with internal edges fixed, whatever moves. On a body that moves the physics
    /// engine weighs them, by their volume at a density of 1, and what gets inside stays there.
    Triangles,
    /// One hull around everything, whatever the bound.
    ConvexHull,
    /// The box along the mesh's axes.
    Cuboid,
    /// The ball around that box's middle.
    Ball,
    /// The capsule along that box's longest side.
    Capsule,
}

/// Which hulls are taken together.
#[derive(Reflect, Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[reflect(Default, Clone, PartialEq)]
#[type_path = "hullwright"]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum HullGrouping {
    /// Each is alone.
    #[default]
    EachHull,
    /// Those that are made of one part, an entity with a `Mesh3d`: as a rule, of one material. Of
    /// several parts the one with the largest share counts.
    EachPart,
}

/// The default of bevy_rapier and of Avian, so that a body with a decomposed collider beside one of
/// the engine's own shapes weighs as expected.
pub const DEFAULT_DENSITY: f32 = 1.0;

/// A physics engine's cost grows with the vertices of a hull, and 64 still follow a round shape.
const DEFAULT_MAX_VERTICES: u32 = 64;

impl Default for ConvexDecomposition {
    fn default() -> Self {
        Self {
            max_error: DEFAULT_MAX_ERROR,
            preset: DecompositionPreset::Balanced,
            max_hulls: None,
            max_vertices: Some(DEFAULT_MAX_VERTICES),
            keep_cavities: false,
            openings: DecompositionOpenings::Auto,
            probe_radius: None,
            level_bound: None,
            shape: DecompositionShape::Auto,
            density: DEFAULT_DENSITY,
            mass: None,
            children: None,
            fallback_collider: None,
            parameters: None,
        }
    }
}

/// Setters: the same tag with another value in one field.
macro_rules! setters {
    ($tag:ident: $($(#[doc = $doc:literal])* $setter:ident($field:ident: $type:ty) = $value:expr;)*) => {
        impl $tag {
            $($(#[doc = $doc])*
            #[must_use]
            pub fn $setter(mut self, $field: $type) -> Self {
                self.$field = $value;
                self
            })*
        }
    };
}

pub(crate) use setters;

setters! { ConvexDecomposition:
    /// The same within another bound. A number is a share of the mesh's diagonal.
    with_max_error(max_error: impl Into<MaxError>) = max_error.into();
    /// The same with more or less work.
    with_preset(preset: DecompositionPreset) = preset;
    /// The same with a limit on hulls; `None` for no limit.
    with_max_hulls(max_hulls: impl Into<Option<u32>>) = max_hulls.into();
    /// The same with a limit on the vertices of a hull; `None` for no limit.
    with_max_vertices(max_vertices: impl Into<Option<u32>>) = max_vertices.into();
    /// The same with cavities that stay empty, or not.
    with_keep_cavities(keep_cavities: bool) = keep_cavities;
    /// The same with openings that are closed or kept.
    with_openings(openings: DecompositionOpenings) = openings;
    /// The same with the radius of what moves, in metres of the world; `None` for that of the
    /// settings.
    with_probe_radius(probe_radius: impl Into<Option<f32>>) = probe_radius.into();
    /// The same with few triangles within a bound, in metres of the world, where nothing moves; 0
    /// for the mesh's own, `None` for the bound of the settings.
    with_level_bound(level_bound: impl Into<Option<f32>>) = level_bound.into();
    /// The same made of something else.
    with_shape(shape: DecompositionShape) = shape;
    /// The same with a mass instead of a density; `None` for the density.
    with_mass(mass: impl Into<Option<f32>>) = mass.into();
    /// The same with a density.
    with_density(density: f32) = density;
    /// The same with a child for each hull, or for each group of hulls, that has its collider: for
    /// friction, sensors or events of their own. The body's mass, centre and inertia stay.
    as_children(children: HullGrouping) = Some(children);
    /// The same with another collider until its own is ready.
    with_fallback_collider(fallback_collider: FallbackCollider) = Some(fallback_collider);
    /// The same with the library's own parameters, or another of its methods with its parameters,
    /// which replace all settings of the decomposition:
    /// `.with_parameters(SurfaceParameters::paper())`, or `SurfaceParameters::hacd()` for what is
    /// known to fit HACD. Neither has a bound, and HACD fills what is hollow: games have no reason
    /// for them but to compare.
    with_parameters(parameters: impl Into<Method>) = Some(parameters.into());
}

impl From<DecompositionPreset> for ConvexDecomposition {
    fn from(preset: DecompositionPreset) -> Self {
        Self::default().with_preset(preset)
    }
}

/// Keeps the entity and all below it out of every decomposition.
#[derive(Component, Reflect, Debug, Clone, Copy, PartialEq, Eq, Default)]
#[reflect(Component, Default, Clone, PartialEq)]
#[type_path = "hullwright"]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct NoConvexDecomposition;

/// Where the player is: when more wait than run, those nearest to such an entity go first.
#[derive(Component, Reflect, Debug, Clone, Copy, PartialEq, Eq, Default)]
#[reflect(Component, Default, Clone, PartialEq)]
#[type_path = "hullwright"]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DecompositionFocus;

/// When more wait than run, those with a higher priority go first, then those nearest to a
/// [`DecompositionFocus`](crate::DecompositionFocus). Beside the tag; without it 0.
#[derive(Component, Reflect, Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[reflect(Component, Default, Clone, PartialEq)]
#[type_path = "hullwright"]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DecompositionPriority(pub i32);

/// Registers tags, settings, statuses and events, so that scenes, editors and extras can name them.
pub(super) struct TagPlugin;

impl Plugin for TagPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<HullwrightSettings>()
            .init_resource::<DecompositionCounters>()
            .register_type::<ConvexDecomposition>()
            .register_type::<NoConvexDecomposition>()
            .register_type::<DecompositionFocus>()
            .register_type::<DecompositionPriority>()
            .register_type::<DecompositionStatus>()
            .register_type::<ColliderReady>()
            .register_type::<ColliderAbsent>()
            .register_type::<DecompositionReady>()
            .register_type::<DecompositionSkipped>()
            .register_type::<DecompositionFailed>()
            .register_type::<DecompositionCancelled>()
            .register_type::<DecompositionCounters>()
            .register_type::<HullwrightSettings>();
    }
}

#[cfg(all(test, feature = "serde"))]
mod tests {
    use super::*;

    fn written_and_read<T: serde::Serialize + serde::de::DeserializeOwned>(value: &T) -> T {
        serde_json::from_str(&serde_json::to_string(value).unwrap()).unwrap()
    }

    #[test]
    fn tags_are_written_and_read() {
        let tag = ConvexDecomposition::from(DecompositionPreset::Fine)
            .with_density(3.0)
            .with_max_error(MaxError::Metres(0.02))
            .with_max_hulls(7)
            .with_max_vertices(None)
            .with_keep_cavities(true)
            .with_openings(DecompositionOpenings::Close)
            .with_probe_radius(0.1)
            .with_level_bound(0.02)
            .with_shape(DecompositionShape::Capsule)
            .with_mass(2.0)
            .as_children(HullGrouping::EachPart)
            .with_fallback_collider(FallbackCollider::ConvexHull);
        let by_the_paper =
            tag.clone().with_parameters(hullwright::surface::SurfaceParameters::paper());
        for tag in [tag, by_the_paper] {
            assert_eq!(written_and_read(&tag), tag);
        }
        assert_eq!(written_and_read(&NoConvexDecomposition), NoConvexDecomposition);
        assert_eq!(written_and_read(&DecompositionFocus), DecompositionFocus);
    }

    #[test]
    fn what_is_left_out_has_its_default() {
        let tag: ConvexDecomposition = serde_json::from_str(r#"{"density": 2.0}"#).unwrap();
        assert_eq!(tag, ConvexDecomposition::default().with_density(2.0));
    }
}
