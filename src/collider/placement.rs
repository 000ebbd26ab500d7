//! Where the engine puts an entity's collider, and what is left to bake into its points.
//!
//! An engine places a collider by a rotation and a translation. All else that the entity's
//! transform does, scale, mirroring and the shear that a non-uniform scale gives to turned
//! children, goes into the points, so that the collider lies where the mesh is drawn.

use bevy::ecs::system::{EntityCommands, SystemParam};
use bevy::math::{Affine3A, Mat3A, Vec3A};
use bevy::prelude::*;

use crate::engine::{Engine, Item, Motion};
use crate::tag::DecompositionShape;
use crate::tag::outcomes::SkipReason;
use crate::tag::settings::HullwrightSettings;

/// The part of an entity's transform that is baked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Placement {
    /// From the tagged entity's space to the collider's.
    pub map: Affine3A,
    /// With which the engine scales the collider that it is given, if it does.
    pub engine_scale: Vec3,
    /// Tells whether the scale has changed since.
    pub stretch: Stretch,
}

/// The scale and shear of a transform, whatever its rotation and translation.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Stretch {
    /// Products of the columns with each other.
    products: [f32; 6],
    is_mirrored: bool,
    /// Below a body, the axes along which transforms mirror: engines leave out what they turn in
    /// pairs.
    signs: [bool; 3],
}

/// Smaller changes are rounding errors of turned transforms. bevy_rapier draws the line there too.
const TOLERANCE: f32 = 1e-4;

/// Bits of a number's mantissa that a map keeps: steps of 1.2e-4, as [`TOLERANCE`].
const KEPT_BITS: u32 = 13;

/// Bits of the mantissa of an `f32`.
const MANTISSA_BITS: u32 = 23;

impl Stretch {
    /// The same as [`of`](Self::of) where nothing is above.
    pub(super) fn of_scale(scale: Vec3) -> Self {
        let Vec3 { x, y, z } = scale;
        let products = [x * x, y * y, z * z, 0.0, 0.0, 0.0];
        Self { products, is_mirrored: x * y * z < 0.0, signs: [false; 3] }
    }

    pub(super) fn of(transform: &GlobalTransform, signs: [bool; 3]) -> Self {
        let matrix = transform.affine().matrix3;
        let Mat3A { x_axis: x, y_axis: y, z_axis: z } = matrix;
        Self {
            products: [x.dot(x), y.dot(y), z.dot(z), x.dot(y), x.dot(z), y.dot(z)],
            is_mirrored: matrix.determinant() < 0.0,
            signs,
        }
    }

    /// The factors along the axes, as Bevy takes them from a transform; `None` if any is none.
    pub(super) fn scale(&self) -> Option<Vec3> {
        let [x, y, z, ..] = self.products.map(f32::sqrt);
        let scale = Vec3::new(if self.is_mirrored { -x } else { x }, y, z);
        scale.recip().is_finite().then_some(scale)
    }

    /// Whether two transforms differ in scale by more than rounding errors.
    pub(super) fn differs(&self, other: &Self) -> bool {
        // As it is with almost all that move.
        if self == other {
            return false;
        }
        let [x, y, z, ..] = self.products;
        // Products of lengths: twice the relative error of the lengths.
        let sizes = [x, y, z, (x * y).sqrt(), (x * z).sqrt(), (y * z).sqrt()];
        (self.is_mirrored, self.signs) != (other.is_mirrored, other.signs)
            || (self.products.iter().zip(other.products).zip(sizes))
                .any(|((a, b), size)| (a - b).abs() > 2.0 * TOLERANCE * size)
    }
}

/// Whether two maps differ by more than rounding errors.
pub(super) fn maps_differ(a: &Affine3A, b: &Affine3A) -> bool {
    let [a, b] = [a, b].map(|map| map.to_cols_array());
    let size = |of: &[f32]| of.iter().fold(0.0, |size: f32, x| size.max(x.abs()));
    let differ = |a: &[f32], b: &[f32], size: f32| {
        // What is no number differs from all else.
        let is_near = |a: f32, b: f32| a == b || (a - b).abs() <= 4.0 * TOLERANCE * size;
        a.iter().zip(b).any(|(a, b)| !is_near(*a, *b))
    };
    differ(&a[..9], &b[..9], size(&a[..9])) || differ(&a[9..], &b[9..], size(&a).max(size(&b)))
}

/// On what gives its physics components to the colliders below, beside bodies.
#[derive(Component, Debug, Clone, Copy, Default)]
pub(crate) struct GivesSurface;

/// What placements are computed from, and whether colliders ever move.
#[derive(SystemParam)]
pub(crate) struct Placements<'w, 's, E: Engine> {
    global: TransformHelper<'w, 's>,
    transforms: Query<'w, 's, &'static Transform>,
    parents: Query<'w, 's, &'static ChildOf>,
    bodies: Query<'w, 's, &'static <E as Engine>::Body>,
    sensors: Query<'w, 's, (), With<<E as Engine>::Sensor>>,
    givers: Query<'w, 's, (), With<GivesSurface>>,
    settings: Res<'w, HullwrightSettings>,
}

impl<E: Engine> Placements<'_, '_, E> {
    /// The body that moves an entity: its own or the nearest above it.
    pub(crate) fn body(&self, entity: Entity) -> Option<(Entity, Motion)> {
        let body = |entity| Some((entity, E::motion(self.bodies.get(entity).ok()?)));
        body(entity).or_else(|| self.parents.iter_ancestors(entity).find_map(body))
    }

    /// Those whose physics components a collider inherits, the nearest first: hierarchies on it and
    /// above it up to its body, and that.
    pub(super) fn givers(&self, entity: Entity) -> impl Iterator<Item = Entity> {
        let body = self.body(entity).map(|(body, _)| body);
        let up_to_body = (std::iter::once(entity).chain(self.parents.iter_ancestors(entity))).scan(
            false,
            move |is_past, entity| {
                let is_within = !*is_past;
                *is_past = body == Some(entity);
                is_within.then_some(entity)
            },
        );
        up_to_body.filter(move |giver| body == Some(*giver) || self.givers.contains(*giver))
    }

    /// Whether the engine would turn the body of an entity: it keeps a rotation and no mirroring,
    /// and Bevy takes any mirroring for one along x and a rotation.
    pub(super) fn has_mirrored_body(&self, entity: Entity) -> bool {
        let Some((body, kind)) = self.body(entity) else { return false };
        let scale = self.transforms.get(body).map_or(Vec3::ONE, |transform| transform.scale);
        kind != Motion::Fixed && (scale.y < 0.0 || scale.z < 0.0)
    }

    /// Whether a collider is a sensor, by itself or by what gives it its components.
    pub(super) fn is_sensor(&self, entity: Entity) -> bool {
        let is_sensor = |entity| self.sensors.contains(entity);
        is_sensor(entity) || self.givers(entity).any(is_sensor)
    }

    /// Why an entity gets its triangles: what never moves does. `None` for what its tag says.
    pub(super) fn why_triangles(
        &self,
        entity: Entity,
        shape: DecompositionShape,
    ) -> Option<SkipReason> {
        match shape {
            DecompositionShape::Triangles => return Some(SkipReason::TrianglesRequested),
            DecompositionShape::Auto if self.settings.exact_static_colliders => {}
            _ => return None,
        }
        if self.is_sensor(entity) {
            return None;
        }
        match self.body(entity) {
            None => Some(SkipReason::NoBody),
            Some((_, Motion::Fixed)) => Some(SkipReason::FixedBody),
            Some(_) => None,
        }
    }

    /// From an entity's space to that of one above it.
    pub(crate) fn relative(&self, entity: Entity, above: Entity) -> Affine3A {
        let put = |map, transform: &Transform| transform.compute_affine() * map;
        self.transforms_below(above, entity).fold(Affine3A::IDENTITY, put)
    }

    /// The transforms of an entity and those above it, up to one that is left out.
    fn transforms_below(&self, above: Entity, entity: Entity) -> impl Iterator<Item = &Transform> {
        std::iter::once(entity)
            .chain(self.parents.iter_ancestors(entity))
            .take_while(move |entity| *entity != above)
            .filter_map(|entity| self.transforms.get(entity).ok())
    }

    pub(super) fn placement(&self, entity: Entity) -> Placement {
        let stretch = self.stretch(entity);
        let map = match self.body(entity) {
            Some((body, _)) if body != entity => {
                let body_scale = without_rotation(&self.global_transform(body));
                let to_body = Affine3A::from_mat3(body_scale.into());
                let wanted = to_body * self.relative(entity, body);
                snap(self.offset(entity, body).inverse() * wanted, wanted.translation)
            }
            _ => snap(self.stretched(entity), Vec3A::ZERO),
        };
        let engine_scale = match E::SCALES_COLLIDERS {
            true => self.scale_of_all(entity),
            false => Vec3::ONE,
        };
        Placement { map, engine_scale, stretch }
    }

    /// All that a transform does but turn and move.
    pub(super) fn stretched(&self, entity: Entity) -> Affine3A {
        Affine3A::from_mat3(without_rotation(&self.global_transform(entity)).into())
    }

    /// The scale that an entity has now, also before Bevy propagates it.
    pub(super) fn stretch(&self, entity: Entity) -> Stretch {
        match (self.parents.contains(entity), self.transforms.get(entity)) {
            (false, Ok(transform)) => Stretch::of_scale(transform.scale),
            _ => self.stretch_of(entity, &self.global_transform(entity)),
        }
    }

    /// The same where the transform is known.
    pub(super) fn stretch_of(&self, entity: Entity, transform: &GlobalTransform) -> Stretch {
        let mut signs = [false; 3];
        if self.parents.contains(entity)
            && let Some((body, _)) = self.body(entity)
        {
            for transform in self.transforms_below(body, entity) {
                let mirrors = transform.scale.to_array().map(|factor| factor < 0.0);
                signs = [0, 1, 2].map(|axis| signs[axis] != mirrors[axis]);
            }
        }
        Stretch::of(transform, signs)
    }

    pub(crate) fn global_transform(&self, entity: Entity) -> GlobalTransform {
        self.global.compute_global_transform(entity).unwrap_or_default()
    }

    /// The product of the scales of an entity and all above it, along the local axes of each.
    fn scale_of_all(&self, entity: Entity) -> Vec3 {
        let all = std::iter::once(entity).chain(self.parents.iter_ancestors(entity));
        all.filter_map(|entity| self.transforms.get(entity).ok())
            .fold(Vec3::ONE, |scale, transform| transform.scale * scale)
    }

    /// Where the engine puts the collider of an entity below a body, in the body's frame: it
    /// multiplies the local transforms up to the body's scale.
    fn offset(&self, entity: Entity, body: Entity) -> Affine3A {
        let put = |offset, transform: &Transform| *transform * offset;
        let offset = self.transforms_below(body, entity).fold(Transform::IDENTITY, put);
        let scale = match E::SCALES_COLLIDERS {
            true => self.scale_of_all(body),
            false => self.transforms.get(body).map_or(Vec3::ONE, |transform| transform.scale),
        };
        let offset = Transform::from_scale(scale) * offset;
        Affine3A::from_rotation_translation(offset.rotation, offset.translation)
    }
}

/// Gives a collider the components of its surface that it does not have itself.
pub(crate) fn inherit_surface<E: Engine>(
    collider: Entity,
    placements: &Placements<E>,
    surfaces: &Query<E::Surface>,
    commands: &mut EntityCommands,
) {
    if let Ok(own) = surfaces.get(collider) {
        let givers = placements.givers(collider).filter(|giver| *giver != collider);
        let givers: Vec<Item<E::Surface>> =
            givers.filter_map(|giver| surfaces.get(giver).ok()).collect();
        E::inherit(&own, &givers, commands);
    }
}

/// The linear part of a transform in the frame of the rotation that engines take from it.
fn without_rotation(transform: &GlobalTransform) -> Mat3A {
    let (_, rotation, _) = transform.to_scale_rotation_translation();
    let matrix = transform.affine().matrix3;
    // A scale of zero has no rotation.
    if rotation.is_finite() { Mat3A::from_quat(rotation.inverse()) * matrix } else { matrix }
}

/// Removes rounding errors, so that equal scales have equal maps.
fn snap(map: Affine3A, reference: Vec3A) -> Affine3A {
    let matrix = map.matrix3;
    let size = matrix.to_cols_array().into_iter().fold(0.0, |size: f32, x| size.max(x.abs()));
    let round = |x: f32| if x.abs() <= TOLERANCE * size { 0.0 } else { round_mantissa(x) };
    let round_column = |column: Vec3A| Vec3A::from(column.to_array().map(round));
    let translation = map.translation;
    let is_error = translation.abs().max_element() <= TOLERANCE * reference.length();
    Affine3A {
        matrix3: Mat3A::from_cols(
            round_column(matrix.x_axis),
            round_column(matrix.y_axis),
            round_column(matrix.z_axis),
        ),
        translation: if is_error { Vec3A::ZERO } else { translation },
    }
}

fn round_mantissa(x: f32) -> f32 {
    let step = 1 << (MANTISSA_BITS - KEPT_BITS);
    let bits = x.to_bits();
    if x.is_finite() { f32::from_bits((bits + step / 2) & !(step - 1)) } else { x }
}
