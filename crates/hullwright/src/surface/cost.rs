//! The concavity cost [3.4.3], equation (3):
//!
//! cost(S) = max over M in S of ‖M − P_S(M)‖ / D_S
//!
//! S are the vertices of a group, P_S(M) is where the ray from M along its normal leaves the
//! convex hull of S, and D_S is the diagonal of the bounding box of S. The normal of M is taken
//! *with respect to the group*: the mean of the unit normals of the group's own triangles at M,
//! without weights, which gives the costs of the paper's Table 1.

use crate::decomposition::GroupedMesh;
use crate::error::Error;
use crate::geometry::MeshView;
use crate::geometry::plane::Plane;
use crate::geometry::vector::{Vector, area_normal, as_arrays, diagonal};
use crate::hull::{ConvexHull, HullBuilder, Shape};
use crate::mesh::TriangleMesh;
use crate::mesh::grouping::{group_vertices, members};

/// Groups of at most this many polygons are left out of the average.
pub(super) const TOO_SMALL_TO_COUNT: usize = 2;

/// A plane that the ray runs along cannot be left through it.
const PARALLEL: f64 = 1e-9;

/// Normals whose sum is shorter than this share of their number cancel out: what is left is
/// rounding, and points anywhere.
const CANCELLED: f64 = 1e-9;

/// Far more than a division and a product are rounded by.
const ROUNDING: f64 = 1e-12;

/// What is reused from one group to the next.
#[derive(Debug, Clone, Default)]
pub struct CostScratch {
    builder: HullBuilder,
    /// For each vertex of the mesh that is in the group its place there.
    places: Vec<u32>,
    /// For each vertex of the group the sum of the unit normals of the group's triangles at it, and
    /// the number of them.
    normals: Vec<(Vector, f64)>,
    /// For each vertex of the group a face of the hull that it is a corner of.
    faces: Vec<Option<u32>>,
}

/// Cost of a group, 0 for flat ones: they are their own hull. O(vertices · hull faces).
pub fn cost(mesh: &TriangleMesh, group: &[u32], scratch: &mut CostScratch) -> f64 {
    let vertices = group_vertices(mesh, group);
    let points: Vec<Vector> =
        vertices.iter().map(|&vertex| mesh.points()[vertex as usize]).collect();
    if scratch.builder.build(as_arrays(&points)) != Shape::Solid {
        return 0.0;
    }
    let planes = ConvexHull::from(scratch.builder.extract()).face_planes();
    scratch.add_normals(mesh, group, &vertices);
    scratch.builder.faces_of_points(&mut scratch.faces);
    let mut greatest: f64 = 0.0;
    for ((&(normal, count), &point), &face) in
        scratch.normals.iter().zip(&points).zip(&scratch.faces)
    {
        if is_cancelled(normal, count) {
            continue;
        }
        let normal = normal.normalize_or_zero();
        // A vertex of the hull is on its face, and leaves there at once if the face is ahead.
        let own = face.and_then(|face| planes.get(face as usize));
        let exit = own.map_or(f64::INFINITY, |&plane| exit_through(point, normal, plane));
        if exit > greatest {
            greatest = greatest.max(distance_to_exit(point, normal, &planes, greatest));
        }
    }
    greatest / diagonal(points.iter().copied())
}

/// The cost of Table 1 for any grouped mesh: the average of equation (3) over the groups of more
/// than two triangles; 0 without any. O(vertices · hull faces) per group.
///
/// # Errors
/// [`Error::IndexOutOfRange`]; [`Error::InvalidParameter`] where the number of groups is not that
/// of the triangles, or a group has a number that is no triangle's.
pub fn average_cost(grouped: &GroupedMesh) -> Result<f64, Error> {
    let GroupedMesh { positions, triangles, groups } = grouped;
    MeshView::new(positions, triangles).check_indices()?;
    let invalid = |reason: String| Error::InvalidParameter { name: "groups", reason };
    let most = triangles.len();
    if groups.len() != most {
        return Err(invalid(format!("{} groups for {most} triangles", groups.len())));
    }
    let count = groups.iter().max().map_or(0, |&label| label as usize + 1);
    if count > most {
        return Err(invalid(format!("group {} of {most} triangles", count - 1)));
    }
    let mesh = TriangleMesh::new(positions.clone(), triangles.clone());
    let mut scratch = CostScratch::default();
    let (mut sum, mut counted) = (0.0, 0_u32);
    for group in members(groups, count).iter().filter(|group| group.len() > TOO_SMALL_TO_COUNT) {
        sum += cost(&mesh, group, &mut scratch);
        counted += 1;
    }
    Ok(sum / f64::from(counted.max(1)))
}

impl CostScratch {
    /// Sums up the normals of the vertices with respect to the group.
    fn add_normals(&mut self, mesh: &TriangleMesh, group: &[u32], vertices: &[u32]) {
        if self.places.len() < mesh.positions.len() {
            self.places.resize(mesh.positions.len(), 0);
        }
        for (place, &vertex) in (0..).zip(vertices) {
            self.places[vertex as usize] = place;
        }
        self.normals.clear();
        self.normals.resize(vertices.len(), (Vector::ZERO, 0.0));
        for &triangle in group {
            let corners = mesh.triangles[triangle as usize];
            let [a, b, c] = corners.map(|vertex| mesh.points()[vertex as usize]);
            let normal = area_normal(a, b, c).normalize_or_zero();
            for vertex in corners {
                let (sum, count) = &mut self.normals[self.places[vertex as usize] as usize];
                *sum += normal;
                *count += 1.0;
            }
        }
    }
}

/// Whether the triangles at a vertex cancel out, by the sum of their unit normals and how many they
/// are: then it has no normal, and so no distance.
pub(super) fn is_cancelled(normal: Vector, count: f64) -> bool {
    normal.length() <= CANCELLED * count
}

/// How far a ray from a point inside a hull runs until it leaves. Where that is at most `enough` an
/// upper bound that is at most `enough` may be returned, since only the greatest distance counts.
pub(super) fn distance_to_exit(
    point: Vector,
    direction: Vector,
    planes: &[Plane],
    enough: f64,
) -> f64 {
    let mut nearest = f64::INFINITY;
    // Most planes are left later than the nearest so far, which is decided without a division.
    let mut beyond = f64::INFINITY;
    for &plane in planes {
        let Plane { normal, offset } = plane;
        if offset - normal.dot(point) > beyond * normal.dot(direction).max(0.0) {
            continue;
        }
        nearest = nearest.min(exit_through(point, direction, plane));
        if nearest <= enough {
            return nearest;
        }
        beyond = nearest * (1.0 + ROUNDING);
    }
    // Past no plane at all: the ray runs along all faces.
    if nearest.is_finite() { nearest } else { 0.0 }
}

/// How far a ray runs until it passes a plane; infinite if it never does.
#[inline]
fn exit_through(point: Vector, direction: Vector, Plane { normal, offset }: Plane) -> f64 {
    let towards = normal.dot(direction);
    if towards > PARALLEL {
        ((offset - normal.dot(point)) / towards).max(0.0)
    } else {
        f64::INFINITY
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::cuboid;

    fn whole(mesh: &TriangleMesh) -> f64 {
        let all: Vec<u32> = (0..mesh.triangles.len() as u32).collect();
        cost(mesh, &all, &mut CostScratch::default())
    }

    #[test]
    fn a_convex_group_costs_nothing() {
        assert!(whole(&cuboid([0.0; 3], [1.0; 3])) < 1e-9);
    }

    #[test]
    fn a_flat_group_costs_nothing() {
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let triangles = vec![[0, 1, 2], [0, 2, 3]];
        assert_eq!(whole(&TriangleMesh::new(positions, triangles)), 0.0);
    }

    #[test]
    fn a_vertex_between_triangles_back_to_back_has_no_distance_whatever_the_rounding() {
        // A tetrahedron around the end of a fin, both of whose sides are there.
        let tip = Vector::new(0.31, 0.27, 0.17);
        let positions =
            [Vector::ZERO, Vector::X, Vector::Y, Vector::Z, tip, Vector::new(0.4, 0.2, 0.3)];
        let mut triangles = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        triangles.extend([[0, 4, 5], [4, 0, 5]]);
        for factor in [1.0, 1e-6, 0.3, 7e5] {
            let positions = positions.iter().map(|&point| point * factor).map(Into::into).collect();
            let found = whole(&TriangleMesh {
                positions,
                triangles: triangles.clone(),
                ..TriangleMesh::default()
            });
            assert!(found < 1e-9, "{factor}: {found}");
        }
    }

    #[test]
    fn the_average_is_over_the_groups_and_what_is_no_group_is_refused() {
        let TriangleMesh { positions, triangles, .. } = cuboid([0.0; 3], [1.0; 3]);
        let grouped = GroupedMesh { positions, triangles, groups: vec![0; 12] };
        assert!(average_cost(&grouped).unwrap() < 1e-9);
        for groups in [vec![0; 11], vec![12; 12]] {
            let refused = average_cost(&GroupedMesh { groups, ..grouped.clone() });
            assert!(matches!(refused, Err(Error::InvalidParameter { .. })), "{refused:?}");
        }
        let mut broken = grouped;
        broken.triangles[3][1] = 99;
        let expected = Error::IndexOutOfRange { triangle: 3, index: 99, vertices: 8 };
        assert_eq!(average_cost(&broken), Err(expected));
    }

    #[test]
    fn a_valley_costs_its_depth_over_its_diagonal() {
        // Two unit slopes down to a valley 0.5 deep along y, 2 wide.
        let (depth, width): (f64, f64) = (0.5, 2.0);
        let positions = vec![
            [-1.0, 0.0, depth],
            [0.0, 0.0, 0.0],
            [1.0, 0.0, depth],
            [-1.0, 1.0, depth],
            [0.0, 1.0, 0.0],
            [1.0, 1.0, depth],
        ];
        let triangles = vec![[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]];
        let diagonal = (width * width + 1.0 + depth * depth).sqrt();
        let cost = whole(&TriangleMesh::new(positions, triangles));
        // The normal at the valley's ends is not upright, for the triangles differ in number.
        assert!(cost >= depth / diagonal - 1e-9, "{cost}");
        assert!(cost <= 1.2 * depth / diagonal, "{cost}");
    }
}
