//! Debug lines for what is near: colliders, and marks on entities that wait, are frozen or failed.

use bevy::camera::primitives::Aabb;
use bevy::color::{Color, Hsla, Srgba};
use bevy::ecs::system::SystemParam;
use bevy::math::Affine3A;
use bevy::prelude::*;
use hullwright_parry::parry3d::math::Pose;
use hullwright_parry::parry3d::shape::{SharedShape, TypedShape};

use crate::collider::work::{AttachedCollider, OwnCollider};
use crate::engine::Frozen;
use crate::tag::DecompositionFocus;
use crate::tag::outcomes::DecompositionStatus;

/// What is drawn; may be changed at any time.
#[derive(Resource, Reflect, Debug, Clone, Copy, PartialEq)]
#[reflect(Resource, Default, Clone, PartialEq)]
#[type_path = "hullwright"]
pub struct HullwrightDebug {
    /// Whether anything is. Default true.
    pub is_drawn: bool,
    /// Hulls, each in its own colour; in yellow where a new collider is made since mesh or scale
    /// changed. Default true.
    pub hulls: bool,
    /// Boxes, balls and capsules, in blue. Default true.
    pub primitives: bool,
    /// Triangles of what never moves, in green. Default false: their box.
    pub triangles: bool,
    /// The boxes of meshes that wait for their first collider: in grey, and in cyan where their
    /// body is frozen. Default true.
    pub waiting: bool,
    /// The boxes of meshes that failed, in red. Default true.
    pub failed: bool,
    /// What is farther than this from every [`DecompositionFocus`](crate::DecompositionFocus), or
    /// without one from every camera, is not drawn. Without either nothing is far. Default 50.
    pub radius: f32,
    /// Most lines per frame; what is nearest goes first. Default 20,000.
    pub max_lines: usize,
}

/// How far away single hulls can still be distinguished on a screen, in metres.
const DEFAULT_RADIUS: f32 = 50.0;

/// Bevy draws as many at a steady 60 Hz on small graphics chips.
const DEFAULT_MAX_LINES: usize = 20_000;

impl Default for HullwrightDebug {
    fn default() -> Self {
        Self {
            is_drawn: true,
            hulls: true,
            primitives: true,
            triangles: false,
            waiting: true,
            failed: true,
            radius: DEFAULT_RADIUS,
            max_lines: DEFAULT_MAX_LINES,
        }
    }
}

/// The lines' group, for their width and depth in Bevy's `GizmoConfigStore`.
#[derive(Default, Reflect, GizmoConfigGroup)]
#[type_path = "hullwright"]
pub struct HullGizmos;

const STALE: Color = Color::Srgba(Srgba::rgb(1.0, 0.85, 0.1));
const PRIMITIVE: Color = Color::Srgba(Srgba::rgb(0.3, 0.5, 1.0));
const TRIANGLES: Color = Color::Srgba(Srgba::rgb(0.3, 0.8, 0.3));
const WAITING: Color = Color::Srgba(Srgba::rgb(0.6, 0.6, 0.6));
const FROZEN: Color = Color::Srgba(Srgba::rgb(0.2, 0.9, 0.9));
const FAILED: Color = Color::Srgba(Srgba::rgb(1.0, 0.15, 0.1));

/// Turns of the colour wheel from one hull to the next: by the golden ratio neighbours differ and
/// no colour repeats soon.
const HUE_STEP: f32 = 0.618_034;

/// What may be drawn, and from where it is seen.
#[derive(SystemParam)]
pub(super) struct View<'w, 's> {
    tagged: Query<'w, 's, Tagged>,
    focuses: Query<'w, 's, &'static GlobalTransform, With<DecompositionFocus>>,
    cameras: Query<'w, 's, &'static GlobalTransform, With<Camera>>,
    parents: Query<'w, 's, &'static ChildOf>,
    children: Query<'w, 's, &'static Children>,
    frozen: Query<'w, 's, (), With<Frozen>>,
    boxes: Query<'w, 's, (&'static Aabb, &'static GlobalTransform)>,
}

type Tagged = (
    Entity,
    &'static DecompositionStatus,
    &'static GlobalTransform,
    Option<(&'static OwnCollider, &'static AttachedCollider)>,
);

impl View<'_, '_> {
    /// The squares of distances to the nearest viewer; none where there is no viewer.
    fn distance(&self, place: Vec3) -> f32 {
        let nearest = |viewers: &mut dyn Iterator<Item = &GlobalTransform>| {
            let distances = viewers.map(|viewer| viewer.translation().distance_squared(place));
            distances.reduce(f32::min)
        };
        let by_focus = nearest(&mut self.focuses.iter());
        by_focus.or_else(|| nearest(&mut self.cameras.iter())).unwrap_or(0.0)
    }

    /// The boxes of the meshes on an entity and below it.
    fn boxes_of(&self, entity: Entity) -> impl Iterator<Item = Affine3A> {
        let all = std::iter::once(entity).chain(self.children.iter_descendants(entity));
        all.filter_map(|entity| self.boxes.get(entity).ok()).map(|(bounds, transform)| {
            let size = Affine3A::from_scale((2.0 * bounds.half_extents).into());
            transform.affine() * Affine3A::from_translation(bounds.center.into()) * size
        })
    }

    fn is_frozen(&self, entity: Entity) -> bool {
        let mut above = std::iter::once(entity).chain(self.parents.iter_ancestors(entity));
        above.any(|entity| self.frozen.contains(entity))
    }
}

/// Draws the nearest first, until the lines are spent.
pub(super) fn draw(gizmos: Gizmos<HullGizmos>, debug: Res<HullwrightDebug>, view: View) {
    let mut pen = Pen { gizmos, left: debug.max_lines };
    let reach = debug.radius * debug.radius;
    let near = view.tagged.iter().map(|it| (view.distance(it.2.translation()), it));
    let mut near: Vec<_> = near.filter(|(distance, _)| *distance <= reach).collect();
    near.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    for (_, (entity, status, transform, collider)) in near {
        if pen.left == 0 {
            break;
        }
        if let Some((collider, attached)) = collider {
            let to_collider = attached.requested.request.to_collider();
            let to_world = transform.affine() * to_collider.inverse();
            pen.collider(&debug, &collider.shape, &to_world, !status.is_finished());
            continue;
        }
        let (is_asked_for, colour) = match status {
            DecompositionStatus::Failed(_) => (debug.failed, FAILED),
            status if status.is_finished() => continue,
            _ if view.is_frozen(entity) => (debug.waiting, FROZEN),
            _ => (debug.waiting, WAITING),
        };
        if is_asked_for {
            view.boxes_of(entity).for_each(|to_world| pen.unit_box(&to_world, colour));
        }
    }
}

/// Draws lines while there are some left.
struct Pen<'w, 's> {
    gizmos: Gizmos<'w, 's, HullGizmos>,
    left: usize,
}

/// Sides of the polygon that stands for a circle.
const CIRCLE: usize = 24;

impl Pen<'_, '_> {
    fn line(&mut self, a: Vec3, b: Vec3, colour: Color) {
        if let Some(left) = self.left.checked_sub(1) {
            self.left = left;
            self.gizmos.line(a, b, colour);
        }
    }

    /// A box of side 1 around the origin, whose corners are numbered by the bits of their sides.
    fn unit_box(&mut self, to_world: &Affine3A, colour: Color) {
        let side = |index: usize, bit: usize| if index >> bit & 1 == 1 { 0.5 } else { -0.5 };
        let corner = |index| {
            to_world.transform_point3(Vec3::new(side(index, 0), side(index, 1), side(index, 2)))
        };
        for (a, bit) in
            (0..8).flat_map(|a| [(a, 1), (a, 2), (a, 4)]).filter(|(a, bit)| a & bit == 0)
        {
            self.line(corner(a), corner(a | bit), colour);
        }
    }

    /// A circle around the third axis.
    fn circle(&mut self, to_world: &Affine3A, colour: Color) {
        let point = |step: usize| {
            let (sin, cos) = (step as f32 / CIRCLE as f32 * std::f32::consts::TAU).sin_cos();
            to_world.transform_point3(Vec3::new(cos, sin, 0.0))
        };
        (0..CIRCLE).for_each(|step| self.line(point(step), point(step + 1), colour));
    }

    fn collider(
        &mut self,
        debug: &HullwrightDebug,
        shape: &SharedShape,
        to_world: &Affine3A,
        is_stale: bool,
    ) {
        let single = [(Pose::IDENTITY, shape.clone())];
        let parts = shape.as_compound().map_or(&single[..], |compound| compound.shapes());
        let now = |colour| if is_stale { STALE } else { colour };
        for (index, (pose, part)) in parts.iter().enumerate() {
            let place = Affine3A::from_rotation_translation(pose.rotation, pose.translation);
            let to_world = *to_world * place;
            match part.as_typed_shape() {
                TypedShape::ConvexPolyhedron(hull) if debug.hulls => {
                    let hue = (index as f32 * HUE_STEP).fract() * 360.0;
                    let colour = now(Color::from(Hsla::hsl(hue, 0.9, 0.6)));
                    let (points, corners) = (hull.points(), hull.vertices_adj_to_face());
                    for face in hull.faces() {
                        let first = face.first_vertex_or_edge as usize;
                        let count = face.num_vertices_or_edges as usize;
                        let Some(corners) = corners.get(first..first + count) else { continue };
                        for (a, b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
                            // The face beyond the edge has it the other way round.
                            if let (true, Some(a), Some(b)) =
                                (a < b, points.get(*a as usize), points.get(*b as usize))
                            {
                                let [a, b] = [a, b].map(|point| to_world.transform_point3(*point));
                                self.line(a, b, colour);
                            }
                        }
                    }
                }
                TypedShape::TriMesh(mesh) if debug.triangles => {
                    for triangle in mesh.triangles() {
                        let corners = [triangle.a, triangle.b, triangle.c];
                        let [a, b, c] = corners.map(|point| to_world.transform_point3(point));
                        [(a, b), (b, c), (c, a)]
                            .into_iter()
                            .for_each(|(a, b)| self.line(a, b, now(TRIANGLES)));
                    }
                }
                TypedShape::TriMesh(_) => {
                    let bounds = part.compute_local_aabb();
                    let size = Affine3A::from_scale(bounds.extents());
                    let middle = Affine3A::from_translation(bounds.center());
                    self.unit_box(&(to_world * middle * size), now(TRIANGLES));
                }
                TypedShape::Cuboid(cuboid) if debug.primitives => {
                    let size = Affine3A::from_scale(2.0 * cuboid.half_extents);
                    self.unit_box(&(to_world * size), now(PRIMITIVE));
                }
                TypedShape::Ball(ball) if debug.primitives => {
                    let size = Affine3A::from_scale(Vec3::splat(ball.radius));
                    for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
                        let turn = Affine3A::from_quat(Quat::from_rotation_arc(Vec3::Z, axis));
                        self.circle(&(to_world * size * turn), now(PRIMITIVE));
                    }
                }
                TypedShape::Capsule(capsule) if debug.primitives => {
                    let axis = (capsule.segment.b - capsule.segment.a).normalize_or(Vec3::Y);
                    let turn = Quat::from_rotation_arc(Vec3::Z, axis);
                    let size = Vec3::splat(capsule.radius);
                    for end in [capsule.segment.a, capsule.segment.b] {
                        let place = Affine3A::from_scale_rotation_translation(size, turn, end);
                        self.circle(&(to_world * place), now(PRIMITIVE));
                    }
                    for side in [Vec3::X, Vec3::Y, Vec3::NEG_X, Vec3::NEG_Y] {
                        let out = turn * side * capsule.radius;
                        let [a, b] = [capsule.segment.a, capsule.segment.b]
                            .map(|end| to_world.transform_point3(end + out));
                        self.line(a, b, now(PRIMITIVE));
                    }
                }
                _ => {}
            }
        }
    }
}
