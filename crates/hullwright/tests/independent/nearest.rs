//! The distance to the nearest of many triangles, by a tree of boxes of its own.

use super::oracle::{Point, Triangle, minus, norm};

/// Triangles of a leaf: few enough that a leaf takes no longer than the boxes above it.
const LEAF: usize = 4;

struct Node {
    low: Point,
    high: Point,
    /// A range of triangles, or the second child of a node whose first child follows it.
    content: Content,
}

enum Content {
    Leaf { start: usize, end: usize },
    Inner { second: usize },
}

/// A tree over triangles.
pub struct Tree {
    triangles: Vec<Triangle>,
    nodes: Vec<Node>,
}

impl Tree {
    pub fn new(mut triangles: Vec<Triangle>) -> Self {
        let mut nodes = Vec::new();
        let count = triangles.len();
        build(&mut triangles, 0, count, &mut nodes);
        Self { triangles, nodes }
    }

    /// Infinite without any triangle. O(log n) for most points.
    pub fn distance(&self, point: Point) -> f64 {
        let mut best = f64::INFINITY;
        let mut stack = vec![(0, 0.0)];
        while let Some((index, at_least)) = stack.pop() {
            if at_least >= best {
                continue;
            }
            match self.nodes[index].content {
                Content::Leaf { start, end } => {
                    for triangle in &self.triangles[start..end] {
                        if triangle.least_distance(point) < best {
                            best = best.min(triangle.distance(point));
                        }
                    }
                }
                Content::Inner { second } => {
                    let mut children = [index + 1, second]
                        .map(|child| (child, self.distance_to_box(child, point)));
                    // The nearer one is on top.
                    children.sort_by(|a, b| b.1.total_cmp(&a.1));
                    stack.extend(children);
                }
            }
        }
        best
    }

    fn distance_to_box(&self, node: usize, point: Point) -> f64 {
        let Node { low, high, .. } = &self.nodes[node];
        norm([0, 1, 2].map(|k| (low[k] - point[k]).max(point[k] - high[k]).max(0.0)))
    }
}

fn build(triangles: &mut [Triangle], start: usize, end: usize, nodes: &mut Vec<Node>) {
    let corners = triangles[start..end].iter().flat_map(|triangle| triangle.corners);
    let nothing = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    let (low, high) = corners.fold(nothing, |(low, high): (Point, Point), point| {
        ([0, 1, 2].map(|k| low[k].min(point[k])), [0, 1, 2].map(|k| high[k].max(point[k])))
    });
    let node = nodes.len();
    nodes.push(Node { low, high, content: Content::Leaf { start, end } });
    if end - start <= LEAF {
        return;
    }
    let extent = minus(high, low);
    let axis = (0..3).max_by(|&a, &b| extent[a].total_cmp(&extent[b])).unwrap_or(0);
    let half = (end - start) / 2;
    triangles[start..end]
        .select_nth_unstable_by(half, |a, b| a.centre[axis].total_cmp(&b.centre[axis]));
    build(triangles, start, start + half, nodes);
    nodes[node].content = Content::Inner { second: nodes.len() };
    build(triangles, start + half, end, nodes);
}
