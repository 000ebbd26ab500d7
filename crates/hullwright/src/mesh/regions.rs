//! Regions: the parts of space that faces bound, whichever way round the faces are.
//!
//! A face has two sides. Around an edge, faces follow each other by angle (Weiler's radial edge
//! structure, 1986), and the two sides that look at each other bound the same region; so do both
//! sides of a face that is alone at its edge. Sides connected in this way bound a region. Where
//! they face inward around a volume, it is enclosed.
//!
//! What encloses a region is a solid, even where faces are there both ways round and their winding
//! says nothing: see [`Regions::is_solid_behind`]. O(n log n) for n triangles.

use super::adjacency::{ParityForest, SortedHalfEdges, ascends};
use crate::geometry::vector::{Vector, area_normal};

/// A closed surface whose volume is below this share of area times extent is flat, and volumes
/// whose sum is below this share of their sizes cancel, as do areas: the sign of what is left is
/// rounding. The thinnest box that welding leaves has 1e-6.
pub(super) const FLAT: f64 = 1e-9;

/// The regions that some triangles bound.
pub(crate) struct Regions {
    /// For each triangle the region in front of it, and that behind it.
    of_sides: Vec<[usize; 2]>,
    /// For each region what is in it.
    kinds: Vec<Kind>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Enclosed,
    /// Between faces that lie on each other, or around a sheet.
    Flat,
    Outer,
}

impl Regions {
    /// Of triangles each of which is there once.
    pub(crate) fn new(points: &[Vector], triangles: &[[u32; 3]]) -> Self {
        // The side in front of triangle t is 2 t, that behind it 2 t + 1.
        let mut sides = ParityForest::new(2 * triangles.len());
        let mut around: Vec<(f64, u32)> = Vec::new();
        SortedHalfEdges::new(triangles, points.len()).for_each_edge(|edge| {
            around.clear();
            around.extend(edge.half_edges().map(|half_edge| (0.0, half_edge)));
            if edge.len() > 2 {
                set_angles(points, triangles, &mut around);
                around.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            }
            // Seen from the edge, a triangle that runs along it upward faces ascending angles.
            let side = |half_edge: u32, ascending: bool| {
                2 * (half_edge / 3) + u32::from(ascends(triangles, half_edge) != ascending)
            };
            for (&(_, own), &(_, next)) in around.iter().zip(around.iter().cycle().skip(1)) {
                sides.join(side(own, true), side(next, false), false);
            }
        });
        let (region_of_side, _, count) = sides.label();
        let of_sides: Vec<[usize; 2]> = region_of_side
            .chunks_exact(2)
            .map(|sides| [sides[0] as usize, sides[1] as usize])
            .collect();
        let (mut volumes, mut areas) = (vec![0.0; count], vec![0.0; count]);
        for (&triangle, &[front, back]) in triangles.iter().zip(&of_sides) {
            let [a, b, c] = triangle.map(|vertex| points[vertex as usize]);
            let volume = a.dot(b.cross(c));
            let area = area_normal(a, b, c).length();
            volumes[front] += volume;
            volumes[back] -= volume;
            areas[front] += area;
            areas[back] += area;
        }
        let kind = |(&volume, &area): (&f64, &f64)| match volume {
            volume if volume < -FLAT * area => Kind::Enclosed,
            volume if volume > FLAT * area => Kind::Outer,
            _ => Kind::Flat,
        };
        Self { of_sides, kinds: volumes.iter().zip(&areas).map(kind).collect() }
    }

    /// Whether the solid that a triangle bounds is behind it, or in front of it. `None` if there is
    /// the solid on both sides, or on neither.
    pub(crate) fn is_solid_behind(&self, triangle: usize) -> Option<bool> {
        let [front, back] =
            self.of_sides[triangle].map(|region| self.kinds[region] == Kind::Enclosed);
        (front != back).then_some(back)
    }

    /// Whether a triangle has the solid on one side, and on the other what is certainly outside.
    pub(crate) fn closes(&self, triangle: usize) -> bool {
        let kinds = self.of_sides[triangle].map(|region| self.kinds[region]);
        kinds.contains(&Kind::Enclosed) && kinds.contains(&Kind::Outer)
    }
}

/// Sets the angle of each triangle around the edge that its half-edge is of, seen along the edge
/// upward.
fn set_angles(points: &[Vector], triangles: &[[u32; 3]], around: &mut [(f64, u32)]) {
    let corners = |half_edge: u32| {
        let k = half_edge as usize % 3;
        let triangle = triangles[half_edge as usize / 3];
        [k, (k + 1) % 3, (k + 2) % 3].map(|k| triangle[k])
    };
    let [first, second, _] = corners(around[0].1);
    let low = points[first.min(second) as usize];
    let along = (points[first.max(second) as usize] - low).normalize_or_zero();
    let across = |half_edge: u32| {
        let arm = points[corners(half_edge)[2] as usize] - low;
        arm - along * along.dot(arm)
    };
    let start = across(around[0].1);
    let turned = along.cross(start);
    for (angle, half_edge) in around {
        let arm = across(*half_edge);
        *angle = libm::atan2(arm.dot(turned), arm.dot(start));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::TriangleMesh;
    use crate::mesh::shapes::{cuboid, join, turn};

    fn solids(mesh: &TriangleMesh) -> Vec<Option<bool>> {
        let regions = Regions::new(mesh.points(), &mesh.triangles);
        (0..mesh.triangles.len()).map(|triangle| regions.is_solid_behind(triangle)).collect()
    }

    fn cube() -> TriangleMesh {
        cuboid([0.0; 3], [1.0; 3])
    }

    /// The cube with triangles, over its vertices and one beside it.
    fn cube_and(triangles: &[[u32; 3]]) -> TriangleMesh {
        let mut mesh = cube();
        mesh.positions.push([-1.0, -1.0, 0.5]);
        mesh.triangles.extend(triangles);
        mesh
    }

    #[test]
    fn the_solid_is_on_one_side_of_what_encloses_it() {
        let nested = join(&[cube(), cuboid([0.2; 3], [0.8; 3])]);
        let mut open = cube();
        open.triangles.truncate(11);
        let mut mixed = cube();
        mixed.triangles[..6].iter_mut().for_each(|triangle| triangle.swap(0, 1));
        let halves = [vec![Some(false); 6], vec![Some(true); 6]].concat();
        // A fin on the edge from 0 to 4, and a wall between opposite edges, which divides the cube.
        let with_fin = [vec![Some(true); 12], vec![None]].concat();
        let with_wall = [vec![Some(true); 12], vec![None; 2]].concat();
        for (name, mesh, expected) in [
            ("a cube", cube(), vec![Some(true); 12]),
            ("inside out", turn(cube()), vec![Some(false); 12]),
            ("wound as it comes", mixed, halves),
            ("nested", nested, vec![Some(true); 24]),
            ("open", open, vec![None; 11]),
            ("with a fin", cube_and(&[[0, 4, 8]]), with_fin),
            ("with a wall", cube_and(&[[0, 3, 7], [0, 7, 4]]), with_wall),
        ] {
            assert_eq!(solids(&mesh), expected, "{name}");
        }
    }

    #[test]
    fn a_cap_closes_a_solid_and_none_lies_on_a_sheet() {
        // A fin, and a cap of its outline.
        let mesh = cube_and(&[[0, 4, 8], [4, 0, 8]]);
        let regions = Regions::new(mesh.points(), &mesh.triangles);
        let closing: Vec<bool> = (0..14).map(|triangle| regions.closes(triangle)).collect();
        assert_eq!(closing, [vec![true; 12], vec![false; 2]].concat());
    }
}
