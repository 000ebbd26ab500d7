//! What goes wrong in files: triangles lost, torn apart, or in any order.

use hullwright::TriangleMesh;

use super::disturb::{by_place, place};
use super::random::{Random, permutation};
use crate::shapes::Vector;

pub(super) fn shuffle(mesh: &mut TriangleMesh, random: &mut Random) {
    let count = mesh.positions.len();
    let order = permutation(count, random);
    let mut places = vec![0_u32; count];
    for (new, &old) in (0..).zip(&order) {
        places[old] = new;
    }
    mesh.positions = order.iter().map(|&old| mesh.positions[old]).collect();
    // Each triangle also starts at another corner.
    let renumbered = |triangle: [u32; 3], random: &mut Random| {
        let mut triangle =
            triangle.map(|vertex| places.get(vertex as usize).copied().unwrap_or(vertex));
        triangle.rotate_left((random.next() % 3) as usize);
        triangle
    };
    let order = permutation(mesh.triangles.len(), random);
    mesh.triangles = order.iter().map(|&old| renumbered(mesh.triangles[old], random)).collect();
    mesh.sidedness = order.iter().filter_map(|&old| mesh.sidedness.get(old).copied()).collect();
}

/// Keeps the triangles with these corners, or at random; without two, all of them.
pub(super) fn keep(
    mesh: &mut TriangleMesh,
    keeps: &mut dyn FnMut(&mut Random, [[f64; 3]; 3]) -> bool,
) {
    let random = &mut Random(1);
    let positions = &mesh.positions;
    let kept: Vec<bool> = mesh
        .triangles
        .iter()
        .map(|triangle| keeps(random, triangle.map(|vertex| positions[vertex as usize])))
        .collect();
    let (mut triangles, mut sides) = (kept.iter(), kept.iter());
    mesh.triangles.retain(|_| triangles.next() == Some(&true));
    mesh.sidedness.retain(|_| sides.next() == Some(&true));
}

pub(super) fn split(mesh: &TriangleMesh, share: f64) -> TriangleMesh {
    let positions = mesh.triangles.iter().flat_map(|triangle| {
        let corners = triangle.map(|vertex| Vector::from(mesh.positions[vertex as usize]));
        let centre = corners.iter().sum::<Vector>() / 3.0;
        corners.map(|corner| (corner + share * (centre - corner)).to_array())
    });
    let triangles = (0..mesh.triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]);
    TriangleMesh { positions: positions.collect(), triangles: triangles.collect(), ..mesh.clone() }
}

/// Collapses an edge of each triangle in a random order, unless one of its ends was collapsed
/// before. Vertices at the same place move together.
pub(super) fn decimate(mesh: &mut TriangleMesh) {
    let places = by_place(&mesh.positions);
    let mut is_used = vec![false; mesh.positions.len()];
    let sources = mesh.positions.clone();
    for index in permutation(mesh.triangles.len(), &mut Random(1)) {
        let ends = [0, 1].map(|k| sources[mesh.triangles[index][k] as usize]);
        let [from, to] = ends.map(|end| places[&place(end)].as_slice());
        if !is_used[from[0]] && !is_used[to[0]] {
            (is_used[from[0]], is_used[to[0]]) = (true, true);
            from.iter().for_each(|&vertex| mesh.positions[vertex] = ends[1]);
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::shapes::uv_sphere;
    use crate::tools::kinds::*;
    use crate::tools::variations::Variation;

    #[test]
    fn a_damaged_mesh_is_of_the_kind_that_its_damage_makes() {
        // Welded, closed, and of so many triangles that chance hits some.
        let mesh = uv_sphere(24, 1.0);
        assert_eq!(kinds(&mesh), [""; 0]);
        for damage in Variation::damages() {
            let (given, _) = damage.apply(&mesh);
            let found = kinds(&given);
            let expected: &[&str] = match damage {
                Variation::Lose => &[NOT_SOLID, OPEN],
                Variation::Cut => &[NOT_SOLID, OPEN],
                Variation::FlipHalf => &[NOT_SOLID, NOT_ORIENTED],
                Variation::Double => &[NOT_SOLID, SELF_INTERSECTING, NON_MANIFOLD],
                Variation::Merge(_) | Variation::Decimate => &[NOT_SOLID, DEGENERATE],
                Variation::Split(_) => &[NOT_SOLID, OPEN, SEVERAL_COMPONENTS],
                Variation::Join => &[NOT_SOLID, SELF_INTERSECTING],
                _ => &[],
            };
            assert!(expected.iter().all(|kind| found.contains(kind)), "{damage:?}: {found:?}");
            let may_stay_solid = matches!(damage, Variation::Jitter(_) | Variation::Scale(_));
            assert!(may_stay_solid || found[0] == NOT_SOLID, "{damage:?}");
            assert!(!given.triangles.is_empty() && given != mesh, "{damage:?}");
        }
        let (cut, _) = Variation::Cut.apply(&mesh);
        let share = cut.triangles.len() as f64 / mesh.triangles.len() as f64;
        assert!((0.3..0.7).contains(&share), "{share}");
        // Of a mesh whose triangles share no vertex as much is left.
        let (loose, _) = Variation::Split(0.0).apply(&mesh);
        let [loose, welded] = [loose, mesh].map(|mesh| kinds(&Variation::Decimate.apply(&mesh).0));
        assert_eq!(loose, welded);
    }
}
