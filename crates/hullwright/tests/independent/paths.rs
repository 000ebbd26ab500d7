//! Where a ball can go, step by step, and how far hulls enter it there.

use super::nearest::Tree;
use super::oracle::{Convex, Point, Triangle, middle, minus, norm};

/// Halvings of a step whose middle is tested as well.
const HALVINGS: u32 = 4;

/// Places between which a ball moves: a lattice.
struct Places<'a> {
    tree: &'a Tree,
    low: Point,
    step: f64,
    radius: f64,
    counts: [usize; 3],
}

impl Places<'_> {
    fn at(&self, index: usize) -> Point {
        let [x, y, _] = self.counts;
        let place = [index % x, index / x % y, index / (x * y)];
        [0, 1, 2].map(|k| self.low[k] + place[k] as f64 * self.step)
    }

    fn neighbours(&self, index: usize) -> Vec<usize> {
        let [x, y, z] = self.counts;
        let place = [index % x, index / x % y, index / (x * y)];
        let range = |k: usize, most: usize| place[k].saturating_sub(1)..(place[k] + 2).min(most);
        let mut all = Vec::new();
        for k in range(2, z) {
            for j in range(1, y) {
                all.extend(range(0, x).map(|i| (k * y + j) * x + i));
            }
        }
        all
    }

    /// Whether a ball can move in a straight line between two places with these distances from the
    /// surface.
    fn is_free(&self, (a, to_a): (Point, f64), (b, to_b): (Point, f64), halvings: u32) -> bool {
        if to_a < self.radius || to_b < self.radius {
            return false;
        }
        if halvings == 0 || to_a + to_b >= 2.0 * self.radius + norm(minus(a, b)) {
            return true;
        }
        let between = middle(a, b);
        let halfway = (between, self.tree.distance(between));
        self.is_free((a, to_a), halfway, halvings - 1)
            && self.is_free(halfway, (b, to_b), halvings - 1)
    }
}

/// How far hulls enter a ball at the most, at any place that it reaches from far outside or from
/// given points in steps of a given size, and how many places these are. A ball whose centre is in
/// a hull is entered by its radius.
pub fn deepest_entry(
    surface: &[Triangle],
    hulls: &[Convex],
    radius: f64,
    step: f64,
    from: &[Point],
) -> (f64, usize) {
    let corners = || surface.iter().flat_map(|triangle| triangle.corners);
    let low = [0, 1, 2].map(|k| corners().map(|p| p[k]).fold(f64::INFINITY, f64::min));
    let high = [0, 1, 2].map(|k| corners().map(|p| p[k]).fold(f64::NEG_INFINITY, f64::max));
    let margin = radius + 2.0 * step;
    let counts = [0, 1, 2].map(|k| ((high[k] - low[k] + 2.0 * margin) / step).ceil() as usize + 1);
    let tree = &Tree::new(surface.to_vec());
    let places = Places { tree, low: low.map(|x| x - margin), step, radius, counts };
    let count = counts.iter().product();
    let mut distances = vec![f64::NAN; count];
    let distance = |index: usize, distances: &mut Vec<f64>| {
        if distances[index].is_nan() {
            distances[index] = tree.distance(places.at(index));
        }
        distances[index]
    };
    let nearest = |point: &Point| {
        let place = [0, 1, 2].map(|k| ((point[k] - places.low[k]) / step).round() as usize);
        (place[2] * counts[1] + place[1]) * counts[0] + place[0]
    };
    let mut stack: Vec<usize> = from.iter().map(nearest).chain([0]).collect();
    let mut is_reached = vec![false; count];
    stack.iter().for_each(|&start| is_reached[start] = true);
    let (mut deepest, mut reached) = (0.0_f64, 0);
    while let Some(index) = stack.pop() {
        reached += 1;
        let (here, to_here) = (places.at(index), distance(index, &mut distances));
        for hull in hulls {
            if hull.least_distance(here) < radius - deepest {
                deepest = deepest.max(radius - hull.outside(here));
            }
        }
        for other in places.neighbours(index) {
            if is_reached[other] {
                continue;
            }
            let there = (places.at(other), distance(other, &mut distances));
            if places.is_free((here, to_here), there, HALVINGS) {
                is_reached[other] = true;
                stack.push(other);
            }
        }
    }
    (deepest, reached)
}
