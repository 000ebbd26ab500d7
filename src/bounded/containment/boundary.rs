//! The edges where a surface ends, and how fast the winding number changes near them.
//!
//! The gradient of the winding number is that of the solid angle of the boundary curve. It is the
//! field of a current along that curve (Biot and Savart): each edge adds at most its length over its
//! squared distance, and at most two over its distance, over 4π. What triangles lie between the
//! edges does not matter, nor how many, nor which way they face. So the sum over the edges bounds the
//! gradient anywhere, but on the surface, where the number jumps.
//!
//! Edges far away count by groups: a sum takes O(log n) typically.

use std::f64::consts::TAU;

use crate::geometry::vector::{Vector, add, distance, dot, length, scale, subtract};

/// A group whose radius is below this share of the distance to its ball counts as a whole: that is
/// too much by less than a factor of 4, of edges that are far away.
const FAR: f64 = 0.5;

/// Edges in a group that are summed one by one.
const LEAF: usize = 4;

/// A full solid angle.
const FULL: f64 = 2.0 * TAU;

/// An edge that more triangles run along one way than the other.
struct Edge {
    start: Vector,
    along: Vector,
    /// By how many more triangles, over a full solid angle.
    weight: f64,
}

impl Edge {
    fn middle(&self) -> Vector {
        add(self.start, scale(self.along, 0.5))
    }

    fn distance(&self, point: Vector) -> f64 {
        let arm = subtract(point, self.start);
        let squared = dot(self.along, self.along);
        let share =
            if squared > 0.0 { (dot(arm, self.along) / squared).clamp(0.0, 1.0) } else { 0.0 };
        length(subtract(arm, scale(self.along, share)))
    }
}

/// A ball around some edges.
struct Group {
    centre: Vector,
    radius: f64,
    /// Sums over the edges: of lengths times weights, and of weights.
    length: f64,
    weight: f64,
    /// Edges, in their order.
    edges: std::ops::Range<usize>,
    /// The first of the groups after those within this one; the next one is the first within it.
    after: usize,
}

/// The boundary of a surface. See the module.
#[derive(Default)]
pub(in crate::bounded) struct Boundary {
    edges: Vec<Edge>,
    /// A tree: each group is followed by those within it.
    groups: Vec<Group>,
}

impl Boundary {
    /// O(n log n).
    pub(in crate::bounded) fn new(positions: &[Vector], triangles: &[[u32; 3]]) -> Self {
        let mut directed: Vec<(u32, u32, i64)> = triangles
            .iter()
            .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)])
            .map(|(a, b)| (a.min(b), a.max(b), if a < b { 1 } else { -1 }))
            .collect();
        directed.sort_unstable();
        let same = directed.chunk_by(|first, second| (first.0, first.1) == (second.0, second.1));
        let mut edges: Vec<Edge> = same
            .filter_map(|edge| {
                let excess: i64 = edge.iter().map(|half| half.2).sum();
                let &(start, end, _) = edge.first()?;
                let (&start, &end) = (positions.get(start as usize)?, positions.get(end as usize)?);
                let weight = excess.unsigned_abs() as f64 / FULL;
                (excess != 0).then(|| Edge { start, along: subtract(end, start), weight })
            })
            .collect();
        let mut groups = Vec::new();
        let count = edges.len();
        if count > 0 {
            build(&mut edges, 0..count, &mut groups);
        }
        Self { edges, groups }
    }

    /// Whether the surface ends nowhere: then the winding number is whole, and changes only across
    /// the surface.
    pub(in crate::bounded) fn is_empty(&self) -> bool {
        self.edges.is_empty()
    }

    /// An upper bound on the gradient of the winding number at a point, or any value above `limit`
    /// if it exceeds that. `clearance` is a lower bound on the distance to the surface.
    ///
    /// At a point that is nearer than a share s of `clearance`, the gradient is at most the result
    /// over (1 - s)².
    pub(in crate::bounded) fn gradient(&self, point: Vector, clearance: f64, limit: f64) -> f64 {
        let mut sum = 0.0;
        let mut next = 0;
        while let Some(group) = self.groups.get(next) {
            let away = (distance(point, group.centre) - group.radius).max(clearance);
            if group.radius <= FAR * away {
                sum += share(group.length, group.weight, away);
                next = group.after;
            } else if group.edges.len() <= LEAF {
                for edge in self.edges.get(group.edges.clone()).into_iter().flatten() {
                    let away = edge.distance(point).max(clearance);
                    sum += share(edge.weight * length(edge.along), edge.weight, away);
                }
                next = group.after;
            } else {
                next += 1;
            }
            if sum > limit {
                return sum;
            }
        }
        sum
    }
}

/// What edges that are `away` at least add to the gradient.
fn share(length: f64, weight: f64, away: f64) -> f64 {
    (length / away).min(2.0 * weight) / away
}

/// Appends the groups over a range of edges, which are put in order.
fn build(edges: &mut [Edge], range: std::ops::Range<usize>, groups: &mut Vec<Group>) {
    let Some(own) = edges.get_mut(range.clone()) else { return };
    let count = own.len();
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for edge in own.iter() {
        for end in [edge.start, add(edge.start, edge.along)] {
            low = [0, 1, 2].map(|axis| low[axis].min(end[axis]));
            high = [0, 1, 2].map(|axis| high[axis].max(end[axis]));
        }
    }
    let extent = subtract(high, low);
    let place = groups.len();
    groups.push(Group {
        centre: scale(add(low, high), 0.5),
        radius: 0.5 * length(extent),
        length: own.iter().map(|edge| edge.weight * length(edge.along)).sum(),
        weight: own.iter().map(|edge| edge.weight).sum(),
        edges: range.clone(),
        after: place + 1,
    });
    if count <= LEAF {
        return;
    }
    let axis = (0..3).max_by(|&a, &b| extent[a].total_cmp(&extent[b])).unwrap_or(0);
    let half = count / 2;
    own.select_nth_unstable_by(half, |a, b| a.middle()[axis].total_cmp(&b.middle()[axis]));
    build(edges, range.start..range.start + half, groups);
    build(edges, range.start + half..range.end, groups);
    let after = groups.len();
    if let Some(group) = groups.get_mut(place) {
        group.after = after;
    }
}
