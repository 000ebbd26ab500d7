//! Triangles that nothing can touch: those that lie wholly within the solid of another closed
//! component, as the foot of a chest within a floor, or against it, as the sides of two tiles.
//!
//! A point about which a closed surface winds cannot be reached without passing that surface. So a
//! triangle is hidden if a closed component winds about one of its points, and if the triangle is
//! apart from all of that component's triangles. A triangle of a solid is touched from outside, so
//! what counts is its place a little outside of it. Only components whose triangles face outward,
//! as they were given, are solids: those that face inward are rooms, and what is within a room can
//! be touched, whatever is around it.

use crate::bvh::Bvh;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{Vector, area_normal, centre, larger, smaller};
use crate::mesh::PreparedMesh;
use crate::parallel;
use crate::sorting::sort_by_key;

/// What is this near to a surface may touch it, as a fraction of the diagonal: twice what welding
/// moves.
const TOUCHES: f64 = 2e-6;

/// How far outside of a solid its triangles are touched, as a fraction of the diagonal: what fits
/// between two solids that are nearer to each other is no thing.
const OUTSIDE: f64 = 4.0 * TOUCHES;

/// Directions of the rays that have to agree. They are oblique, since sides of many shapes are
/// along axes, and a ray along a side may pass it by.
const DIRECTIONS: [Vector; 3] = [
    Vector::new(0.862_3, 0.331_7, 0.382_6),
    Vector::new(-0.417_1, 0.751_9, -0.510_5),
    Vector::new(0.228_7, -0.596_3, -0.769_5),
];

/// Triangles between two checks for cancellation.
const PER_TASK: usize = 1024;

/// What closed components are.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Solid,
    Room,
    Open,
}

/// For each triangle whether it is hidden. `is_turned` says which of them repair has turned around.
///
/// # Errors
/// [`Error::Cancelled`], [`Error::DeadlineExceeded`].
pub(super) fn hidden(
    prepared: &PreparedMesh,
    is_turned: &[bool],
    control: &Control,
) -> Result<Vec<bool>, Error> {
    let triangles = &prepared.mesh.triangles;
    let kinds = kinds(prepared, is_turned);
    let closed: Vec<u32> = (0..triangles.len() as u32)
        .filter(|&triangle| kinds[component(prepared, triangle)] != Kind::Open)
        .collect();
    if prepared.closed.len() < 2 || !kinds.contains(&Kind::Solid) {
        return Ok(vec![false; triangles.len()]);
    }
    let of_closed: Vec<[u32; 3]> = closed.iter().map(|&t| triangles[t as usize]).collect();
    let tree = Bvh::with_control(prepared.mesh.points(), &of_closed, control)?;
    let solids = Solids { prepared, kinds, is_turned, closed, tree };
    let tasks = parallel::map_indices(triangles.len().div_ceil(PER_TASK), |task| {
        control.check()?;
        let own = task * PER_TASK..triangles.len().min((task + 1) * PER_TASK);
        Ok(own.map(|triangle| solids.hide(triangle as u32)).collect::<Vec<bool>>())
    });
    let tasks = tasks.into_iter().collect::<Result<Vec<_>, Error>>()?;
    Ok(tasks.concat())
}

fn component(prepared: &PreparedMesh, triangle: u32) -> usize {
    prepared.components[triangle as usize] as usize
}

/// What each component is, as it was given.
fn kinds(prepared: &PreparedMesh, is_turned: &[bool]) -> Vec<Kind> {
    let mut volumes = vec![0.0; prepared.closed.len()];
    let mut turned = vec![(false, false); prepared.closed.len()];
    for (triangle, &is_turned) in (0_u32..).zip(is_turned) {
        let component = component(prepared, triangle);
        let [a, b, c] = prepared.mesh.corners(prepared.mesh.triangles[triangle as usize]);
        let volume = a.dot(b.cross(c));
        volumes[component] += if is_turned { -volume } else { volume };
        if is_turned { turned[component].0 = true } else { turned[component].1 = true }
    }
    let all = prepared.closed.iter().zip(volumes).zip(turned);
    all.map(|((&is_closed, volume), turned)| match is_closed && turned != (true, true) {
        true if volume > 0.0 => Kind::Solid,
        true => Kind::Room,
        false => Kind::Open,
    })
    .collect()
}

struct Solids<'a> {
    prepared: &'a PreparedMesh,
    kinds: Vec<Kind>,
    is_turned: &'a [bool],
    /// Triangles of the tree, by their index in the mesh.
    closed: Vec<u32>,
    tree: Bvh,
}

impl Solids<'_> {
    /// Whether a triangle is hidden.
    fn hide(&self, triangle: u32) -> bool {
        let own = component(self.prepared, triangle);
        if self.kinds[own] == Kind::Room {
            return false;
        }
        let corners = self.touched_from(triangle, own);
        let around = self.around(centre(corners), own);
        let is_solid = |&(component, _): &(usize, i32)| self.kinds[component] == Kind::Solid;
        // Within a room, or not known.
        if around.is_empty() || !around.iter().all(is_solid) {
            return false;
        }
        let touched = self.touched(corners);
        around.iter().any(|&(component, turns)| turns > 0 && !touched.contains(&component))
    }

    /// Where a triangle is touched: a solid's from outside.
    fn touched_from(&self, triangle: u32, own: usize) -> [Vector; 3] {
        let mesh = &self.prepared.mesh;
        let corners @ [a, b, c] = mesh.corners(mesh.triangles[triangle as usize]);
        if self.kinds[own] != Kind::Solid {
            return corners;
        }
        let normal = area_normal(a, b, c).normalize_or_zero();
        let outward = if self.is_turned[triangle as usize] { -normal } else { normal };
        corners.map(|corner| corner + OUTSIDE * outward)
    }

    /// The closed components but one that wind about a point, and how often. Where rays do not
    /// agree, none.
    fn around(&self, point: Vector, own: usize) -> Vec<(usize, i32)> {
        let by_ray = |direction: Vector| {
            let mut turns: Vec<(usize, i32)> = Vec::new();
            self.tree.visit_hits([point, direction], 0.0, &mut |hit| {
                let triangle = self.closed[hit.triangle as usize];
                let component = component(self.prepared, triangle);
                let is_back = hit.is_back != self.is_turned[triangle as usize];
                if component != own {
                    turns.push((component, if is_back { 1 } else { -1 }));
                }
                f64::INFINITY
            });
            sort_by_key(&mut turns, |turn| *turn);
            let of_each = turns.chunk_by(|a, b| a.0 == b.0);
            let sums = of_each.map(|all| (all[0].0, all.iter().map(|&(_, turn)| turn).sum()));
            sums.filter(|&(_, sum): &(usize, i32)| sum != 0).collect::<Vec<_>>()
        };
        let [first, others @ ..] = DIRECTIONS;
        let around = by_ray(first);
        // Most points are around nothing.
        let is_known = around.is_empty() || others.into_iter().all(|other| by_ray(other) == around);
        if is_known { around } else { Vec::new() }
    }

    /// The closed components that a triangle may touch.
    fn touched(&self, corners: [Vector; 3]) -> Vec<usize> {
        let low = corners[0].min(corners[1]).min(corners[2]);
        let high = corners[0].max(corners[1]).max(corners[2]);
        let mesh = &self.prepared.mesh;
        let near = self.tree.triangles_near_box(low, high, TOUCHES);
        let near = near.into_iter().map(|triangle| self.closed[triangle as usize]);
        let near = near.filter(|&other| {
            !are_apart(corners, mesh.corners(mesh.triangles[other as usize]), TOUCHES)
        });
        let mut touched: Vec<usize> = near.map(|other| component(self.prepared, other)).collect();
        touched.dedup();
        touched
    }
}

/// Whether a plane between two triangles keeps them farther apart than a length. Planes across the
/// axes, along each triangle, through its sides, and along a side of each are tried (the separating
/// axes of two triangles).
fn are_apart(a: [Vector; 3], b: [Vector; 3], length: f64) -> bool {
    let sides = |[a, b, c]: [Vector; 3]| [b - a, c - b, a - c];
    let (of_a, of_b) = (sides(a), sides(b));
    let normals = [of_a[0].cross(of_a[1]), of_b[0].cross(of_b[1])];
    let along = of_a.into_iter().flat_map(|side| of_b.map(|other| side.cross(other)));
    let through = of_a.map(|side| side.cross(normals[0])).into_iter();
    let through = through.chain(of_b.map(|side| side.cross(normals[1])));
    let axes = [Vector::X, Vector::Y, Vector::Z].into_iter().chain(normals);
    axes.chain(through).chain(along).any(|axis| {
        let axis = axis.normalize_or_zero();
        let extent = |corners: [Vector; 3]| {
            let [x, y, z] = corners.map(|corner| axis.dot(corner));
            (smaller(smaller(x, y), z), larger(larger(x, y), z))
        };
        let (a, b) = (extent(a), extent(b));
        a.0 - b.1 > length || b.0 - a.1 > length
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::canonical_order::MeshOrder;
    use crate::mesh::repair::prepare;
    use crate::mesh::shapes::{cuboid, join, turn};

    /// How many triangles are hidden. Nothing is turned around.
    fn count(parts: &[crate::geometry::TriangleMesh]) -> usize {
        let prepared = prepare(join(parts).view(), MeshOrder::Place, &Control::new()).unwrap();
        assert_eq!(prepared.repairs.flipped_triangles, 0);
        let is_turned = vec![false; prepared.mesh.triangles.len()];
        let hidden = hidden(&prepared, &is_turned, &Control::new()).unwrap();
        hidden.into_iter().filter(|&is_hidden| is_hidden).count()
    }

    #[test]
    fn only_what_is_wholly_within_a_solid_is_hidden() {
        let solid = cuboid([0.0; 3], [1.0; 3]);
        let within = cuboid([0.2; 3], [0.4; 3]);
        assert_eq!(count(&[solid.clone(), within.clone()]), 12);
        assert_eq!(count(&[solid.clone(), cuboid([2.0; 3], [3.0; 3])]), 0);
        assert_eq!(count(&[solid.clone(), cuboid([0.2; 3], [1.2; 3])]), 0);
        // What touches the surface from within stays.
        assert_eq!(count(&[solid.clone(), cuboid([0.2, 0.2, 0.0], [0.4; 3])]), 10 - 8);
        let cavity = turn(cuboid([0.1; 3], [0.9; 3]));
        assert_eq!(count(&[solid, cavity, within]), 0);
    }

    #[test]
    fn what_lies_against_another_solid_is_hidden() {
        let chest = |height: f64| cuboid([0.0, 0.0, height], [1.0, 1.0, height + 1.0]);
        let floor = cuboid([-9.0, -9.0, -1.0], [9.0, 9.0, 0.0]);
        assert_eq!(count(&[floor.clone(), chest(0.0)]), 2);
        assert_eq!(count(&[floor, chest(0.01)]), 0);
        // Of the higher wall a part of the side can be touched.
        let wall = cuboid([1.0, -1.0, -1.0], [2.0, 2.0, 2.0]);
        assert_eq!(count(&[wall, chest(0.0)]), 2);
    }

    #[test]
    fn triangles_are_apart_where_a_plane_is_between_them() {
        let triangle = [Vector::ZERO, Vector::X, Vector::Y];
        let moved = |by: Vector| triangle.map(|corner| corner + by);
        assert!(are_apart(triangle, moved(Vector::Z * 0.1), 0.05));
        assert!(!are_apart(triangle, moved(Vector::Z * 0.1), 0.2));
        assert!(!are_apart(triangle, moved(Vector::X * 0.5), 0.0));
        assert!(are_apart(triangle, moved(Vector::X + Vector::Y), 0.1));
    }
}
