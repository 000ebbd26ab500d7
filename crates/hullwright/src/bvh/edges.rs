//! A hierarchy over the edges where a surface ends, which bounds how fast its winding number
//! changes.

use super::closest_point::squared_gaps;
use super::tree::{Child, EMPTY, Leaf, STACK, Tree, WIDTH, child};
use crate::geometry::vector::{Vector, larger, smaller};

/// Edges whose box has a half diagonal below this share of its distance count as a whole: that is
/// too much by less than a factor of 4, of edges that are far away.
const FAR: f32 = 0.5;

/// More than what rounding to single precision takes from a slope, or adds to a distance.
const SLACK: f64 = 1.0 + 1e-4;

/// An edge, and how often it counts.
pub(crate) struct Edge {
    pub ends: [Vector; 2],
    pub weight: f64,
}

/// The hierarchy. See the module.
pub(crate) struct EdgeTree {
    /// Of triangles with two corners at the same place.
    tree: Tree,
    /// By node.
    groups: Vec<Sums>,
    /// The half diagonals of the children's boxes, by node.
    radii: Vec<[f32; WIDTH]>,
    /// By leaf.
    edges: Vec<Sums>,
}

/// Sums over the edges of up to four children, or of each edge of a leaf.
#[derive(Clone)]
struct Sums {
    /// Of lengths times weights.
    length: [f32; WIDTH],
    weight: [f32; WIDTH],
}

impl Sums {
    const NOTHING: Self = Self { length: [0.0; WIDTH], weight: [0.0; WIDTH] };

    /// Of all lanes.
    fn total(&self) -> [f32; 2] {
        [&self.length, &self.weight].map(|sums| sums.iter().sum())
    }
}

/// What has been added up so far, lane by lane.
struct Added {
    gradient: [f32; WIDTH],
    clearance: [f32; WIDTH],
}

impl Added {
    /// Adds a lane's edges, which are `away` at least.
    #[inline(always)]
    fn add(&mut self, lane: usize, sums: &Sums, away: f32) {
        let by_length = sums.length[lane] / away;
        self.gradient[lane] += smaller(by_length, 2.0 * sums.weight[lane]) / away;
        self.clearance[lane] = smaller(self.clearance[lane], away);
    }
}

impl EdgeTree {
    /// The hierarchy over n edges. O(n log n).
    pub(crate) fn new(edges: &[Edge]) -> Self {
        let ends: Vec<Vector> = edges.iter().flat_map(|edge| edge.ends).collect();
        let corners = (0..edges.len() as u32).map(|edge| [2 * edge, 2 * edge + 1, 2 * edge + 1]);
        let tree = Tree::new(&ends, &corners.collect::<Vec<[u32; 3]>>(), &|| false);
        let of_leaf = |leaf: &Leaf| {
            let mut sums = Sums::NOTHING;
            for (lane, &edge) in leaf.triangles.iter().enumerate() {
                if let Some(Edge { ends: [start, end], weight }) = edges.get(edge as usize) {
                    sums.length[lane] = (weight * start.distance(*end)) as f32;
                    sums.weight[lane] = *weight as f32;
                }
            }
            sums
        };
        let edges: Vec<Sums> = tree.leaves.iter().map(of_leaf).collect();
        let mut groups = vec![Sums::NOTHING; tree.nodes.len()];
        let mut radii = vec![[0.0; WIDTH]; tree.nodes.len()];
        // Nodes precede their children.
        for (index, node) in tree.nodes.iter().enumerate().rev() {
            for lane in 0..WIDTH {
                let [length, weight] = match child(node.children[lane]) {
                    Child::Empty => continue,
                    Child::Node(node) => groups[node].total(),
                    Child::Leaf(leaf) => edges[leaf].total(),
                };
                let extent = [0, 1, 2].map(|axis| node.max[axis][lane] - node.min[axis][lane]);
                let group = &mut groups[index];
                (group.length[lane], group.weight[lane]) = (length, weight);
                radii[index][lane] =
                    0.5 * extent.map(|side| side * side).iter().sum::<f32>().sqrt();
            }
        }
        Self { tree, groups, radii, edges }
    }

    /// A bound on the gradient of a winding number, and a lower bound on the distance to the
    /// nearest edge. Each edge adds its length over its squared distance, and two over its distance
    /// at most, times its weight. No edge is nearer than `nearest`. Where the sum exceeds `limit`,
    /// any sum above that may be returned. Typically O(log n).
    pub(crate) fn slope(&self, point: Vector, nearest: f64, limit: f64) -> [f64; 2] {
        let relative = (point - self.tree.centre).as_vec3().to_array();
        let (nearest, limit) = (larger(nearest as f32, f32::MIN_POSITIVE), limit / SLACK);
        let mut added = Added { gradient: [0.0; WIDTH], clearance: [f32::INFINITY; WIDTH] };
        let mut stack = [0_u32; STACK];
        let mut height = 1;
        let total = |added: &Added| f64::from(added.gradient.iter().sum::<f32>());
        while height > 0 && total(&added) <= limit {
            height -= 1;
            match child(stack[height]) {
                Child::Empty => {}
                Child::Leaf(leaf) => {
                    let (ends, sums) = (&self.tree.leaves[leaf], &self.edges[leaf]);
                    for lane in 0..WIDTH {
                        let away = distance_to_edge(ends, lane, relative) - self.tree.margin;
                        added.add(lane, sums, larger(away, nearest));
                    }
                }
                Child::Node(node) => {
                    let (boxes, sums) = (&self.tree.nodes[node], &self.groups[node]);
                    let gaps = squared_gaps(boxes, relative);
                    let mut is_near = [false; WIDTH];
                    for lane in 0..WIDTH {
                        let away = larger(gaps[lane].sqrt(), nearest);
                        is_near[lane] = self.radii[node][lane] > FAR * away;
                        // What is near is added edge by edge.
                        let away = if is_near[lane] { f32::INFINITY } else { away };
                        added.add(lane, sums, away);
                    }
                    for (lane, &reference) in boxes.children.iter().enumerate() {
                        if is_near[lane] && reference != EMPTY {
                            stack[height] = reference;
                            height += 1;
                        }
                    }
                }
            }
        }
        let clearance = added.clearance.into_iter().fold(f32::INFINITY, smaller);
        [total(&added) * SLACK, f64::from(clearance) / SLACK]
    }
}

/// The distance of a point to the edge of a lane.
#[inline(always)]
fn distance_to_edge(ends: &Leaf, lane: usize, point: [f32; 3]) -> f32 {
    let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let [start, end] = [0, 1].map(|end| [0, 1, 2].map(|axis| ends.corners[end][axis][lane]));
    let along = [0, 1, 2].map(|axis| end[axis] - start[axis]);
    let arm = [0, 1, 2].map(|axis| point[axis] - start[axis]);
    let squared = larger(dot(along, along), f32::MIN_POSITIVE);
    let share = smaller(larger(dot(arm, along) / squared, 0.0), 1.0);
    let across = [0, 1, 2].map(|axis| arm[axis] - share * along[axis]);
    dot(across, across).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::vector::{distance_to_segment, spread_in_box};

    /// Edges of many lengths and weights, anywhere in a box.
    fn scattered(count: usize) -> Vec<Edge> {
        let place = |number| spread_in_box(number, Vector::splat(-0.5), Vector::splat(0.5));
        let edge = |number: usize| {
            let start = place(number);
            let end = start + place(number + 1000) * 0.5_f64.powi(number as i32 % 8);
            Edge { ends: [start, end], weight: 1.0 + (number % 3) as f64 }
        };
        (0..count).map(edge).collect()
    }

    /// The sum over all edges, one by one, and the distance to the nearest.
    fn summed(edges: &[Edge], point: Vector, nearest: f64) -> [f64; 2] {
        edges.iter().fold([0.0, f64::INFINITY], |[sum, clearance], Edge { ends, weight }| {
            let away = distance_to_segment(point, *ends).max(nearest);
            let length = ends[0].distance(ends[1]);
            [sum + weight * (length / away).min(2.0) / away, clearance.min(away)]
        })
    }

    fn at_many_points(check: impl Fn(&[Edge], &EdgeTree, Vector)) {
        for count in [1, 3, 4, 5, 17, 300] {
            let edges = scattered(count);
            let tree = EdgeTree::new(&edges);
            for number in 0..200 {
                let number = f64::from(number);
                check(&edges, &tree, Vector::new(number.sin(), (2.3 * number).cos(), 0.4));
            }
        }
    }

    #[test]
    fn a_slope_is_at_least_the_sum_over_all_edges_and_at_most_four_times_that() {
        at_many_points(|edges, tree, point| {
            for nearest in [0.0, 0.01] {
                let [sum, clearance] = summed(edges, point, nearest);
                let [found, found_clearance] = tree.slope(point, nearest, f64::INFINITY);
                assert!((sum..=4.0 * sum).contains(&found), "{point:?}: {found} of {sum}");
                let least = clearance / 2.0;
                assert!((least..=clearance).contains(&found_clearance), "{found_clearance}");
            }
        });
    }

    #[test]
    fn where_the_sum_is_above_a_limit_the_slope_is_and_below_it_is_the_whole() {
        at_many_points(|edges, tree, point| {
            let [sum, _] = summed(edges, point, 0.0);
            let [whole, _] = tree.slope(point, 0.0, f64::INFINITY);
            assert!(tree.slope(point, 0.0, 0.5 * sum)[0] > 0.5 * sum);
            assert_eq!(tree.slope(point, 0.0, 1.001 * whole)[0], whole);
        });
    }

    #[test]
    fn on_an_edge_the_slope_is_infinite() {
        let edges = scattered(40);
        let tree = EdgeTree::new(&edges);
        let [slope, clearance] = tree.slope(edges[7].ends[0], 0.0, f64::INFINITY);
        assert!(slope > 1e30 && clearance < 1e-30, "{slope} {clearance}");
    }
}
