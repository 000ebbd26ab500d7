//! What closes a cut: polygons over loops in a plane.
//!
//! They are triangulated by ear clipping (crate `earcut`), loops that run the other way as holes.
//! Whatever loops are like, also where they cross, the triangles have their edges and no others, so
//! that what is cut stays closed and volumes add up.

use std::collections::{HashMap, HashSet};

use earcut::Earcut;

/// Ear clipping takes the square of the number of vertices at worst; more are a surface in tatters.
const MOST_VERTICES: usize = 20_000;

/// Edges in a plane that close.
pub(super) struct Loop {
    pub vertices: Vec<u32>,
    /// The same in two axes of the plane. Counter-clockwise around what is solid.
    pub points: Vec<[f64; 2]>,
    /// The connected part of the mesh.
    pub component: u32,
}

/// Triangles whose edges are those of the loops, apart from edges between two of them. O(n²) at
/// worst for n vertices.
pub(super) fn cover(loops: &[Loop]) -> Vec<[u32; 3]> {
    let areas: Vec<f64> = loops.iter().map(|own| signed_area(&own.points)).collect();
    let mut holes: Vec<Vec<usize>> = vec![Vec::new(); loops.len()];
    let mut alone = Vec::new();
    for (hole, own) in loops.iter().enumerate().filter(|(index, _)| areas[*index] < 0.0) {
        let is_around = |outer: &usize| {
            areas[*outer] > -areas[hole]
                && own.points.first().is_some_and(|&point| holds(&loops[*outer].points, point))
        };
        let around = (0..loops.len()).filter(is_around);
        // One of the same part first: others may cross it.
        let rank = |outer: &usize| (loops[*outer].component != own.component, areas[*outer]);
        let by_rank = |a: &usize, b: &usize| {
            let (a, b) = (rank(a), rank(b));
            a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
        };
        match around.min_by(by_rank) {
            Some(outer) => holes[outer].push(hole),
            None => alone.push(hole),
        }
    }
    let mut triangles = Vec::new();
    for outer in (0..loops.len()).filter(|&index| areas[index] >= 0.0) {
        let own: Vec<&Loop> = [outer].iter().chain(&holes[outer]).map(|&at| &loops[at]).collect();
        triangulate(&own, 1.0, &mut triangles);
    }
    for hole in alone {
        triangulate(&[&loops[hole]], -1.0, &mut triangles);
    }
    triangles
}

/// Triangles over a loop and its holes. Where ear clipping finds none with their edges, fans over
/// each.
fn triangulate(loops: &[&Loop], sign: f64, triangles: &mut Vec<[u32; 3]>) {
    let vertices: Vec<u32> = loops.iter().flat_map(|own| own.vertices.iter().copied()).collect();
    let found = match vertices.len() {
        ..=MOST_VERTICES => clip_ears(loops, sign),
        _ => None,
    };
    let found = found.unwrap_or_else(|| fans(loops));
    let name = |index: u32| vertices[index as usize];
    triangles.extend(found.into_iter().map(|triangle| triangle.map(name)));
}

/// By numbers of vertices in all loops. `None` where the edges are not those of the loops.
fn clip_ears(loops: &[&Loop], sign: f64) -> Option<Vec<[u32; 3]>> {
    let points: Vec<[f64; 2]> = loops.iter().flat_map(|own| own.points.iter().copied()).collect();
    let next = next_in_loops(loops);
    let mut holes = Vec::new();
    let mut start = 0;
    for own in &loops[..loops.len() - 1] {
        start += own.vertices.len() as u32;
        holes.push(start);
    }
    let mut found: Vec<u32> = Vec::new();
    Earcut::new().earcut(points.iter().copied(), &holes, &mut found);
    let mut triangles = found.as_chunks::<3>().0.to_vec();
    let corners = |triangle: &[u32; 3]| triangle.map(|index| points[index as usize]);
    let area: f64 = triangles.iter().map(|triangle| signed_area(&corners(triangle))).sum();
    if area * sign < 0.0 {
        triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    }
    add_passed_over(&mut triangles, &next)?;
    let mut inner: HashMap<[u32; 2], i32> = HashMap::new();
    for [a, b] in triangles.iter().flat_map(sides) {
        *inner.entry([a.min(b), a.max(b)]).or_default() += if a < b { 1 } else { -1 };
    }
    for (a, &b) in (0_u32..).zip(&next) {
        *inner.entry([a.min(b), a.max(b)]).or_default() -= if a < b { 1 } else { -1 };
    }
    inner.values().all(|&count| count == 0).then_some(triangles)
}

/// For each vertex the one after it in its loop.
fn next_in_loops(loops: &[&Loop]) -> Vec<u32> {
    let mut next = Vec::new();
    for own in loops {
        let (start, count) = (next.len() as u32, own.vertices.len() as u32);
        next.extend((1..count).map(|index| start + index).chain([start]));
    }
    next
}

/// Ear clipping passes over vertices on a straight line. Triangles at such a line are divided, so
/// that they meet all of them. `None` where an edge leads along no loop.
fn add_passed_over(triangles: &mut Vec<[u32; 3]>, next: &[u32]) -> Option<()> {
    let mut edges: HashSet<[u32; 2]> = triangles.iter().flat_map(sides).collect();
    let mut at = 0;
    while let Some(&triangle) = triangles.get(at) {
        let [a, b, c] = triangle;
        let passes =
            |[from, to]: &[u32; 2]| next[*from as usize] != *to && !edges.contains(&[*to, *from]);
        let Some([from, to]) = sides(&triangle).into_iter().find(passes) else {
            at += 1;
            continue;
        };
        let apex = [a, b, c].into_iter().find(|&corner| corner != from && corner != to)?;
        let mut chain = vec![from];
        while let Some(&last) = chain.last().filter(|&&last| last != to) {
            let after = next[last as usize];
            if after == apex || chain.len() > next.len() {
                return None;
            }
            chain.push(after);
        }
        let fan: Vec<[u32; 3]> = chain.windows(2).map(|side| [side[0], side[1], apex]).collect();
        edges.extend(fan.iter().flat_map(sides));
        triangles.splice(at..=at, fan);
        if triangles.len() > 2 * next.len() {
            return None;
        }
    }
    Some(())
}

/// A fan over each loop: triangles that overlap where it is not convex, but with its edges and its
/// area.
fn fans(loops: &[&Loop]) -> Vec<[u32; 3]> {
    let mut triangles = Vec::new();
    let mut start = 0;
    for own in loops {
        let count = own.vertices.len() as u32;
        triangles.extend((start + 2..start + count).map(|index| [start, index - 1, index]));
        start += count;
    }
    triangles
}

fn sides(&[a, b, c]: &[u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

fn signed_area(points: &[[f64; 2]]) -> f64 {
    let after = points.iter().cycle().skip(1);
    let sum: f64 = points.iter().zip(after).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum();
    sum / 2.0
}

/// Whether a point is inside, by the crossings of a ray along the first axis.
fn holds(outline: &[[f64; 2]], point: [f64; 2]) -> bool {
    let after = outline.iter().cycle().skip(1);
    let crossings = outline.iter().zip(after).filter(|(a, b)| {
        (a[1] > point[1]) != (b[1] > point[1]) && {
            let share = (point[1] - a[1]) / (b[1] - a[1]);
            point[0] < a[0] + share * (b[0] - a[0])
        }
    });
    crossings.count() % 2 == 1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(vertices: std::ops::Range<u32>, points: &[[f64; 2]]) -> Loop {
        Loop { vertices: vertices.collect(), points: points.to_vec(), component: 0 }
    }

    /// The directed edges that no triangle on the other side has.
    fn rim(triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
        let all: Vec<[u32; 2]> = triangles.iter().flat_map(sides).collect();
        let mut rim: Vec<[u32; 2]> =
            all.iter().copied().filter(|&[a, b]| !all.contains(&[b, a])).collect();
        rim.sort();
        rim
    }

    fn edges(loops: &[Loop]) -> Vec<[u32; 2]> {
        let of_loop = |own: &Loop| {
            let after = own.vertices.iter().cycle().skip(1);
            own.vertices.iter().zip(after).map(|(&a, &b)| [a, b]).collect::<Vec<_>>()
        };
        let mut edges: Vec<[u32; 2]> = loops.iter().flat_map(of_loop).collect();
        edges.sort();
        edges
    }

    const SQUARE: [[f64; 2]; 4] = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]];
    const HOLE: [[f64; 2]; 4] = [[1.0, 1.0], [1.0, 3.0], [3.0, 3.0], [3.0, 1.0]];

    #[test]
    fn a_square_with_a_hole_has_a_ring_of_triangles() {
        let loops = [ring(0..4, &SQUARE), ring(4..8, &HOLE)];
        let triangles = cover(&loops);
        assert_eq!(triangles.len(), 8);
        assert_eq!(rim(&triangles), edges(&loops));
    }

    #[test]
    fn vertices_on_straight_lines_are_kept_so_that_nothing_cracks() {
        let outline = [
            [0.0, 0.0],
            [1.0, 0.0],
            [2.0, 0.0],
            [4.0, 0.0],
            [4.0, 1.0],
            [4.0, 4.0],
            [1.0, 4.0],
            [0.0, 4.0],
            [0.0, 3.0],
            [0.0, 2.0],
        ];
        let loops = [ring(0..10, &outline), ring(10..14, &HOLE)];
        assert_eq!(rim(&cover(&loops)), edges(&loops));
        // Also with no area at all, and where a vertex is twice at a place.
        let line = [ring(0..4, &[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [1.0, 0.0]])];
        assert_eq!(rim(&cover(&line)), edges(&line));
    }

    #[test]
    fn a_loop_that_crosses_itself_keeps_its_edges_and_its_area() {
        let bow = [[0.0, 0.0], [4.0, 4.0], [4.0, 0.0], [0.0, 3.0]];
        let loops = [ring(0..4, &bow)];
        let triangles = cover(&loops);
        assert_eq!(rim(&triangles), edges(&loops));
        let area: f64 = triangles
            .iter()
            .map(|triangle| signed_area(&triangle.map(|index| bow[index as usize])))
            .sum();
        assert!((area - signed_area(&bow)).abs() < 1e-12);
    }

    #[test]
    fn a_hole_in_nothing_is_filled_the_other_way_round() {
        let loops = [ring(0..4, &HOLE)];
        assert_eq!(rim(&cover(&loops)), edges(&loops));
    }
}
