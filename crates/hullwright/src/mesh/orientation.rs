//! Winding: consistent within each shell, outward where a shell encloses a volume.
//!
//! 1. Within a shell that has two sides, the minority by area is turned around.
//! 2. If the solid shells together enclose a negative volume, the whole mesh is turned around:
//!    the input is left-handed. Those that are there both ways round count only where there are no
//!    others.
//! 3. A solid shell whose volume is still negative is turned around, unless it is a cavity: unless
//!    it lies inside others.
//!
//! A face that is there both ways round is a sheet, unless it bounds a solid, whichever way its
//! winding is.

use robust::{Coord, orient2d};

use super::adjacency::{Connectivity, ShellKind, SortedHalfEdges};
use super::regions::{FLAT, Regions};
use crate::geometry::vector::{Vector, area_normal};
use crate::sorting::{sort_by, sort_by_key};

/// A shell with holes counts as solid if its volume differs by less than this share of itself
/// wherever in its bounding box the holes' lids meet, and however large lids on so long a border
/// can be. Small holes pass. A box without a lid (0.2)
/// does not: either of its sides may be the outer one.
const NEARLY_CLOSED: f64 = 0.1;

/// Turns triangles around as the module's head says. Returns for each whether it was.
///
/// Linear time, and for cavities that times the logarithm of their number.
pub(crate) fn orient(
    positions: &[Vector],
    triangles: &mut [[u32; 3]],
    connectivity: &Connectivity,
    is_both_ways: &[bool],
) -> Vec<bool> {
    let mut turned = make_consistent(positions, triangles, connectivity);
    let mut solids = Solids::measure(positions, triangles, connectivity, &turned);
    let is_two_sided = two_sided_shells(connectivity, is_both_ways);
    let sum_of = |two_sided: bool| -> f64 {
        let volumes = solids.volumes.iter().zip(&is_two_sided);
        volumes.filter(|(_, is)| **is == two_sided).map(|(volume, _)| volume).sum()
    };
    let one_sided = sum_of(false);
    let sum = if one_sided == 0.0 { sum_of(true) } else { one_sided };
    let sum_of_sizes: f64 = solids.volumes.iter().map(|volume| volume.abs()).sum();
    if sum < -FLAT * sum_of_sizes {
        turned.iter_mut().for_each(|turned| *turned = !*turned);
        solids.volumes.iter_mut().for_each(|volume| *volume = -*volume);
    }
    if solids.volumes.iter().any(|&volume| volume < 0.0) {
        let inverted = inverted_solids(positions, triangles, connectivity, &turned, &solids);
        for (turned, &shell) in turned.iter_mut().zip(&connectivity.shells) {
            *turned ^= inverted[shell as usize];
        }
    }
    for (triangle, _) in triangles.iter_mut().zip(&turned).filter(|(_, turned)| **turned) {
        triangle.swap(1, 2);
    }
    turned
}

/// For each shell whether all of it is there both ways round.
fn two_sided_shells(connectivity: &Connectivity, is_both_ways: &[bool]) -> Vec<bool> {
    let mut is_two_sided = vec![true; connectivity.kinds.len()];
    for (&shell, &both_ways) in connectivity.shells.iter().zip(is_both_ways) {
        is_two_sided[shell as usize] &= both_ways;
    }
    is_two_sided
}

/// For each triangle whether it is a sheet: there both ways round, and the boundary of no solid.
/// Shells that are there both ways round and bound one are turned outward.
///
/// O(n log n) for n triangles of components with some that are there both ways round.
pub(crate) fn find_sheets(
    positions: &[Vector],
    triangles: &mut [[u32; 3]],
    connectivity: &Connectivity,
    is_both_ways: &[bool],
) -> Vec<bool> {
    let mut has_both_ways = vec![false; connectivity.closed.len()];
    for (&component, &both_ways) in connectivity.components.iter().zip(is_both_ways) {
        has_both_ways[component as usize] |= both_ways;
    }
    let is_own = |&t: &usize| has_both_ways[connectivity.components[t] as usize];
    let own: Vec<usize> = (0..triangles.len()).filter(is_own).collect();
    let mut is_sheet = is_both_ways.to_vec();
    if own.is_empty() {
        return is_sheet;
    }
    let corners: Vec<[u32; 3]> = own.iter().map(|&t| triangles[t]).collect();
    let regions = Regions::new(positions, &corners);
    let is_two_sided = two_sided_shells(connectivity, is_both_ways);
    for (index, t) in own.into_iter().enumerate() {
        let Some(is_behind) = regions.is_solid_behind(index) else { continue };
        is_sheet[t] = false;
        if !is_behind && is_two_sided[connectivity.shells[t] as usize] {
            triangles[t].swap(1, 2);
        }
    }
    is_sheet
}

fn corners(positions: &[Vector], triangle: [u32; 3]) -> [Vector; 3] {
    triangle.map(|vertex| positions[vertex as usize])
}

/// For each triangle whether it must be turned to agree with most of its shell.
fn make_consistent(
    positions: &[Vector],
    triangles: &[[u32; 3]],
    connectivity: &Connectivity,
) -> Vec<bool> {
    let reversed = &connectivity.reversed;
    if !reversed.contains(&true) {
        return vec![false; triangles.len()];
    }
    // Area of what agrees with the first triangle of the shell, and of what does not.
    let mut areas = vec![[0.0; 2]; connectivity.kinds.len()];
    for (t, &triangle) in triangles.iter().enumerate() {
        let [a, b, c] = corners(positions, triangle);
        let area = area_normal(a, b, c).length();
        areas[connectivity.shells[t] as usize][usize::from(reversed[t])] += area;
    }
    connectivity
        .shells
        .iter()
        .zip(reversed)
        .map(|(&shell, &reversed)| {
            let [agrees, reverse] = areas[shell as usize];
            let agrees_with_majority = reversed == (reverse > agrees * (1.0 + FLAT));
            connectivity.kinds[shell as usize] != ShellKind::Twisted && !agrees_with_majority
        })
        .collect()
}

/// For each shell the length of its open edges.
fn borders(positions: &[Vector], triangles: &[[u32; 3]], connectivity: &Connectivity) -> Vec<f64> {
    let mut borders = vec![0.0; connectivity.kinds.len()];
    if connectivity.open_edges == 0 {
        return borders;
    }
    SortedHalfEdges::new(triangles, positions.len()).for_each_edge(|edge| {
        if edge.len() == 1 {
            let (triangle, k) = (edge.half_edge(0) as usize / 3, edge.half_edge(0) as usize % 3);
            let [a, b] = [k, (k + 1) % 3].map(|k| positions[triangles[triangle][k] as usize]);
            borders[connectivity.shells[triangle] as usize] += a.distance(b);
        }
    });
    borders
}

/// What the shells enclose.
struct Solids {
    /// For each shell six times its signed volume, or 0 where it encloses none.
    volumes: Vec<f64>,
    /// Bounding boxes of the shells.
    boxes: Vec<[Vector; 2]>,
}

impl Solids {
    fn measure(
        positions: &[Vector],
        triangles: &[[u32; 3]],
        connectivity: &Connectivity,
        turned: &[bool],
    ) -> Self {
        let count = connectivity.kinds.len();
        let mut boxes = vec![[Vector::INFINITY, Vector::NEG_INFINITY]; count];
        for (&triangle, &shell) in triangles.iter().zip(&connectivity.shells) {
            let [low, high] = &mut boxes[shell as usize];
            for corner in corners(positions, triangle) {
                *low = low.min(corner);
                *high = high.max(corner);
            }
        }
        let mut volumes = vec![0.0; count];
        let mut vector_areas = vec![Vector::ZERO; count];
        let mut areas = vec![0.0; count];
        for (t, &triangle) in triangles.iter().enumerate() {
            let shell = connectivity.shells[t] as usize;
            let [low, high] = boxes[shell];
            let centre = (low + high) * 0.5;
            let [a, b, c] = corners(positions, triangle);
            let sign = if turned[t] { -1.0 } else { 1.0 };
            let normal = area_normal(a, b, c) * sign;
            volumes[shell] += normal.dot(a - centre);
            vector_areas[shell] += normal;
            areas[shell] += normal.length();
        }
        let borders = borders(positions, triangles, connectivity);
        for shell in 0..count {
            let [low, high] = boxes[shell];
            let half = (high - low) * 0.5;
            // The lids of a tube cancel, so the length of its border counts too: no lids on it are
            // larger than a circle.
            let largest_lid = 2.0 * borders[shell] * borders[shell] / (4.0 * std::f64::consts::PI);
            let uncertain =
                vector_areas[shell].map(f64::abs).dot(half).max(largest_lid * half.length());
            let has_volume = volumes[shell].abs() > FLAT * areas[shell] * half.length();
            let solid = match connectivity.kinds[shell] {
                ShellKind::Closed => has_volume,
                ShellKind::Open => has_volume && uncertain < NEARLY_CLOSED * volumes[shell].abs(),
                ShellKind::Twisted => false,
            };
            if !solid {
                volumes[shell] = 0.0;
            }
        }
        Self { volumes, boxes }
    }

    fn box_contains(&self, outer: usize, inner: usize) -> bool {
        let ([low, high], [inner_low, inner_high]) = (self.boxes[outer], self.boxes[inner]);
        low.cmple(inner_low).all() && inner_high.cmple(high).all()
    }
}

/// A solid of negative volume, and the origin of the ray along x that finds what it lies in.
struct Query {
    shell: usize,
    origin: Vector,
}

/// For each shell whether it is a solid of negative volume that lies in nothing.
fn inverted_solids(
    positions: &[Vector],
    triangles: &[[u32; 3]],
    connectivity: &Connectivity,
    turned: &[bool],
    solids: &Solids,
) -> Vec<bool> {
    let mut queries: Vec<Query> = Vec::new();
    let mut has_query = vec![false; solids.volumes.len()];
    for (&triangle, &shell) in triangles.iter().zip(&connectivity.shells) {
        let shell = shell as usize;
        if solids.volumes[shell] < 0.0 && !has_query[shell] {
            has_query[shell] = true;
            let [a, b, c] = corners(positions, triangle);
            let origin = (a + (b + c)) * (1.0 / 3.0);
            queries.push(Query { shell, origin });
        }
    }
    sort_by(&mut queries, |a, b| a.origin[1].total_cmp(&b.origin[1]));

    // For each crossing of a ray: query, shell, and its share in the winding number.
    let mut crossings: Vec<(usize, usize, i32)> = Vec::new();
    for (t, &triangle) in triangles.iter().enumerate() {
        let shell = connectivity.shells[t] as usize;
        if solids.volumes[shell] == 0.0 {
            continue;
        }
        let [a, mut b, mut c] = corners(positions, triangle);
        if turned[t] {
            std::mem::swap(&mut b, &mut c);
        }
        let low = a.min(b.min(c));
        let high = a.max(b.max(c));
        let first = queries.partition_point(|query| query.origin[1] < low[1]);
        for (index, query) in queries.iter().enumerate().skip(first) {
            if query.origin[1] > high[1] {
                break;
            }
            let misses = query.origin[2] < low[2]
                || query.origin[2] > high[2]
                || query.origin[0] > high[0]
                || query.shell == shell
                || !solids.box_contains(shell, query.shell);
            if !misses {
                let share = crossing(query.origin, [a, b, c]);
                if share != 0 {
                    crossings.push((index, shell, share));
                }
            }
        }
    }

    // What encloses is larger, so that it is decided first whether that is turned around.
    sort_by_key(&mut crossings, |crossing| *crossing);
    let mut order: Vec<usize> = (0..queries.len()).collect();
    sort_by(&mut order, |&a, &b| {
        let volume = |index: usize| solids.volumes[queries[index].shell];
        volume(a).total_cmp(&volume(b)).then(a.cmp(&b))
    });
    let mut inverted = vec![false; solids.volumes.len()];
    for index in order {
        let start = crossings.partition_point(|crossing| crossing.0 < index);
        let winding: i32 = crossings[start..]
            .iter()
            .take_while(|crossing| crossing.0 == index)
            .map(|&(_, shell, share)| if inverted[shell] { -share } else { share })
            .sum();
        inverted[queries[index].shell] = winding <= 0;
    }
    inverted
}

/// What a triangle adds to the winding number of `origin`: 1 if the ray from there along x leaves
/// through its back, -1 if it enters through its front, 0 if it misses.
///
/// Rays through edges and vertices count once: the ray is moved by an infinitesimal (δ, δ²) in y
/// and z, and the sides of edges are exact.
fn crossing(origin: Vector, [a, b, c]: [Vector; 3]) -> i32 {
    let side = side_of(a, b, origin);
    if side == 0 || side != side_of(b, c, origin) || side != side_of(c, a, origin) {
        return 0;
    }
    let in_front = area_normal(a, b, c).dot(origin - a);
    let ahead = if side > 0 { in_front < 0.0 } else { in_front > 0.0 };
    if ahead { side } else { 0 }
}

/// On which side of the line from `from` to `to` the point lies, all seen along x.
fn side_of(from: Vector, to: Vector, point: Vector) -> i32 {
    let flat = |v: Vector| Coord { x: v[1], y: v[2] };
    let sign = |x: f64| i32::from(x > 0.0) - i32::from(x < 0.0);
    let exact = sign(orient2d(flat(from), flat(to), flat(point)));
    if exact != 0 {
        exact
    } else if from[2] != to[2] {
        sign(from[2] - to[2])
    } else {
        sign(to[1] - from[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::vector::as_vectors;
    use crate::mesh::TriangleMesh;
    use crate::mesh::shapes::{cuboid, hemisphere, join, mobius_strip, torus, turn, uv_sphere};

    fn oriented(mesh: &TriangleMesh) -> (TriangleMesh, usize) {
        let mut mesh = mesh.clone();
        let connectivity = Connectivity::new(&mesh.triangles, mesh.positions.len());
        let once = vec![false; mesh.triangles.len()];
        let turned = orient(as_vectors(&mesh.positions), &mut mesh.triangles, &connectivity, &once);
        (mesh, turned.iter().filter(|&&turned| turned).count())
    }

    fn volume(mesh: &TriangleMesh) -> f64 {
        let corners = mesh.triangles.iter().map(|&t| corners(mesh.points(), t));
        corners.map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
    }

    fn cube(half: f64) -> TriangleMesh {
        cuboid([-half; 3], [half; 3])
    }

    /// How many triangles are turned.
    fn turned(mesh: &TriangleMesh) -> usize {
        oriented(mesh).1
    }

    #[test]
    fn solids_become_outward_and_cavities_inward() {
        let hollow = join(&[cube(1.0), turn(cube(0.5))]);
        let nested = |inner| join(&[inner, turn(cube(0.5)), cube(1.0)]);
        let beside = cuboid([3.0, -0.5, -0.5], [4.0, 0.5, 0.5]);
        let (ring, sphere) = (torus(12, 12), uv_sphere(12, [0.0; 3], 0.1));
        let spheres = sphere.triangles.len();
        let in_the_hole = volume(&ring) + volume(&sphere);
        let mut boxes = vec![cube(1.0)];
        for i in 0..10 {
            let x = f64::from(i) * 0.18 - 0.9;
            boxes.push(turn(cuboid([x, -0.1, -0.1], [x + 0.09, 0.1, 0.1])));
            boxes.push(turn(cuboid([x, 1.9, -0.1], [x + 0.09, 2.1, 0.1])));
        }
        for (name, mesh, expected_turned, expected_volume) in [
            ("an outward box", cube(1.0), 0, 8.0),
            ("an inward box", turn(cube(1.0)), 12, 8.0),
            ("a cavity", hollow.clone(), 0, 7.0),
            ("a cavity, inside out", turn(hollow), 24, 7.0),
            ("a solid in a cavity", nested(cube(0.25)), 0, 7.125),
            ("an inward one in a cavity", nested(turn(cube(0.25))), 12, 7.125),
            ("an inward box beside another", join(&[cube(1.0), turn(beside)]), 12, 9.0),
            ("in the hole of a ring", join(&[ring, turn(sphere)]), spheres, in_the_hole),
            ("many cavities and many inverted boxes", join(&boxes), 10 * 12, 8.0),
        ] {
            let (mesh, turned) = oriented(&mesh);
            assert_eq!(turned, expected_turned, "{name}");
            assert!((volume(&mesh) - expected_volume).abs() < 1e-12, "{name}");
        }
    }

    #[test]
    fn random_winding_becomes_outward() {
        let mut sphere = uv_sphere(16, [0.0; 3], 1.0);
        let whole = volume(&sphere);
        for (t, triangle) in sphere.triangles.iter_mut().enumerate() {
            if (t * t + t / 3) % 5 < 2 {
                triangle.swap(0, 2);
            }
        }
        let (mesh, turned) = oriented(&sphere);
        assert!(turned > 0);
        assert!((volume(&mesh) - whole).abs() < 1e-12);
    }

    fn open_box() -> TriangleMesh {
        let mut open = cube(1.0);
        open.triangles.truncate(10);
        open
    }

    /// Open at both ends.
    fn tube() -> TriangleMesh {
        let sides = 16;
        let mut tube = TriangleMesh::default();
        for side in 0..sides {
            let angle = f64::from(side) * std::f64::consts::TAU / f64::from(sides);
            tube.positions.extend([0.0, 4.0].map(|z| [angle.cos(), angle.sin(), z]));
            let [a, b] = [2 * side, 2 * ((side + 1) % sides)];
            tube.triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
        }
        tube
    }

    #[test]
    fn what_encloses_no_volume_for_certain_keeps_its_sides() {
        // A square seen from both sides, with different diagonals: the sign of its volume is
        // rounding, and once turned it would be turned again.
        let corners = [[0.1, 0.2], [0.7, 0.3], [0.6, 0.9], [0.2, 0.7]];
        let flat = TriangleMesh::new(
            corners.map(|[x, y]| [x, y, 0.3 * x + 0.7 * y]).to_vec(),
            vec![[0, 1, 2], [0, 2, 3], [1, 0, 3], [3, 2, 1]],
        );
        for mesh in [open_box(), flat, hemisphere(12), tube(), mobius_strip(12)] {
            assert_eq!(oriented(&mesh), (mesh.clone(), 0));
            assert_eq!(turned(&turn(mesh)), 0);
        }
        // The bore of a barrel whose rim has cracks: both ends' lids cancel, and it was taken for a
        // solid that is inside out.
        assert_eq!(turned(&join(&[cube(8.0), turn(tube())])), 0);
    }

    #[test]
    fn a_small_hole_does_not_hide_which_side_is_out() {
        let mut sphere = uv_sphere(16, [0.0; 3], 1.0);
        sphere.triangles.truncate(sphere.triangles.len() - 3);
        assert_eq!(turned(&sphere), 0);
        let (mesh, turned) = oriented(&turn(sphere.clone()));
        assert_eq!(turned, sphere.triangles.len());
        assert!(volume(&mesh) > 0.0);
    }

    #[test]
    fn an_open_sheet_turns_with_the_left_handed_mesh_that_it_belongs_to() {
        let mut sheet = cuboid([2.0, 0.0, 0.0], [3.0, 1.0, 1.0]);
        sheet.triangles.truncate(2);
        assert_eq!(turned(&turn(join(&[cube(1.0), sheet]))), 14);
    }

    #[test]
    fn the_majority_by_area_leads_an_open_shell() {
        let mut open = open_box();
        open.triangles[0].swap(1, 2);
        open.triangles[7].swap(1, 2);
        assert_eq!(oriented(&open), (open_box(), 2));
    }
}
