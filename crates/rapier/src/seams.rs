//! Contacts with edges and faces that lie inside of a compound are dropped.
//!
//! Each part of a compound is convex and reports contacts by its own surface. Where parts meet,
//! some of that surface is no surface of the whole: the sides of two tiles that touch, and the
//! edges between them. What slides over the seam is held by a normal that points backward. Such a
//! contact is known by its normal: a point `p` of a part is where the whole touches something in
//! the direction `n` only if no other part goes on from `p` in that direction. In terms of convex
//! geometry, `n` must lie in the normal cone at `p` of each part that `p` belongs to.

use rapier3d::parry::bounding_volume::Aabb;
use rapier3d::parry::math::{Pose, Real, Vector};
use rapier3d::parry::query::ContactManifold;
use rapier3d::parry::shape::{Compound, ConvexPolyhedron, Shape};

/// How far from a part's surface a point still belongs to it, as a share of the compound's extent.
/// Parts that are meant to touch differ by the rounding of `f32`, and by what tools that write them
/// cut off.
const TOLERANCE: Real = 1e-4;

/// The same as a share of the extent of what touches the compound: a marble on the floor of a
/// castle must not take the foot of a wall for the floor.
const TOLERANCE_OF_OTHER: Real = 0.01;

/// The sine of the angle by which a normal may leave a normal cone: a fifth of a degree, more than
/// normals of neighbouring faces differ by rounding.
const LARGEST_SINE: Real = 0.0035;

/// Rounds of projection onto the planes at a point. Three planes at right angles need one.
const ROUNDS: usize = 4;

/// Which of the two shapes of a pair.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    First,
    Second,
}

impl Side {
    fn other(self) -> Self {
        match self {
            Self::First => Self::Second,
            Self::Second => Self::First,
        }
    }

    fn part<M, C>(self, manifold: &ContactManifold<M, C>) -> u32 {
        match self {
            Self::First => manifold.subshape1,
            Self::Second => manifold.subshape2,
        }
    }
}

/// Drops the contacts of `other` with what lies inside of a compound, the `side` of a pair. Of
/// contacts that exclude each other the deepest stays, so that every body keeps one. O(n²) in
/// the manifolds with contacts.
pub(super) fn drop_inner_contacts<M, C>(
    compound: &Compound,
    other: &dyn Shape,
    side: Side,
    manifolds: &mut [ContactManifold<M, C>],
) {
    let mut order: Vec<(Real, usize)> = manifolds
        .iter()
        .enumerate()
        .filter_map(|(index, manifold)| Some((smallest_distance(manifold)?, index)))
        .collect();
    if order.len() < 2 {
        return;
    }
    let tolerance = (TOLERANCE * extent(compound.local_aabb()))
        .min(TOLERANCE_OF_OTHER * extent(&other.compute_local_aabb()));
    // The farthest first; what is dropped is no reason to drop another.
    order.sort_by(|a, b| b.0.total_cmp(&a.0));
    for (_, index) in order {
        let manifold = &manifolds[index];
        let is_inner = manifolds.iter().any(|other| {
            let other_part = side.part(other);
            !other.points.is_empty()
                && side.part(manifold) != other_part
                && side.other().part(manifold) == side.other().part(other)
                && is_inside(compound, side, manifold, other_part, tolerance)
        });
        if is_inner {
            manifolds[index].points.clear();
        }
    }
}

fn extent(bounds: &Aabb) -> Real {
    (bounds.maxs - bounds.mins).max_element()
}

/// The distance of the deepest contact of a manifold, nothing where it has none.
fn smallest_distance<M, C>(manifold: &ContactManifold<M, C>) -> Option<Real> {
    manifold.points.iter().map(|point| point.dist).min_by(Real::total_cmp)
}

/// Whether all points of a manifold belong to another part of the compound, in whose normal cones
/// the manifold's normal does not lie.
fn is_inside<M, C>(
    compound: &Compound,
    side: Side,
    manifold: &ContactManifold<M, C>,
    other_part: u32,
    tolerance: Real,
) -> bool {
    let pose = match side {
        Side::First => manifold.subshape_pos1(),
        Side::Second => manifold.subshape_pos2(),
    };
    let normal = if side == Side::First { manifold.local_n1 } else { manifold.local_n2 };
    let Some((other_pose, other)) = compound.shapes().get(other_part as usize) else {
        return false;
    };
    let to_other = other_pose.inverse() * pose.copied().unwrap_or(Pose::IDENTITY);
    let normal = to_other.rotation * normal;
    manifold.points.iter().all(|point| {
        let point = if side == Side::First { point.local_p1 } else { point.local_p2 };
        goes_on(&**other, to_other.transform_point(point), normal, tolerance)
    })
}

/// Whether a convex shape has a point, and goes on from there in a direction.
fn goes_on(shape: &dyn Shape, point: Vector, direction: Vector, tolerance: Real) -> bool {
    let mut rest = direction;
    // The direction's projection onto the cone of all ways from the point into the shape: what is
    // left lies in the normal cone.
    for _ in 0..ROUNDS {
        let Some(next) = project(shape, point, rest, tolerance) else {
            return false;
        };
        rest = next;
    }
    rest.length() > LARGEST_SINE
}

/// Takes from a direction what leads out of the shape through the faces at a point. `None` where
/// the point does not belong to the shape.
fn project(shape: &dyn Shape, point: Vector, direction: Vector, tolerance: Real) -> Option<Vector> {
    let mut rest = direction;
    let mut apply = |normal: Vector, distance: Real| {
        let is_beside = distance > tolerance;
        if !is_beside && distance > -tolerance {
            rest -= normal * normal.dot(rest).max(0.0);
        }
        !is_beside
    };
    let belongs = if let Some(polyhedron) = shape.as_convex_polyhedron() {
        planes(polyhedron).all(|(normal, on_face)| apply(normal, normal.dot(point - on_face)))
    } else {
        let half = shape.as_cuboid()?.half_extents;
        [Vector::X, Vector::Y, Vector::Z].into_iter().all(|axis| {
            let (position, half) = (axis.dot(point), axis.dot(half));
            apply(axis, position - half) && apply(-axis, -position - half)
        })
    };
    belongs.then_some(rest)
}

/// The normal of each face, and a point of it.
fn planes(polyhedron: &ConvexPolyhedron) -> impl Iterator<Item = (Vector, Vector)> {
    polyhedron.faces().iter().filter_map(|face| {
        let vertex = polyhedron.vertices_adj_to_face().get(face.first_vertex_or_edge as usize)?;
        Some((face.normal, *polyhedron.points().get(*vertex as usize)?))
    })
}
