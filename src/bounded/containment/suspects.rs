//! Where earlier hulls have protruded: those that are tested next are similar, and most of what
//! does not fit protrudes there, too.
//!
//! A suspect only says where to look first. What the tests answer does not depend on it.

use super::triangle::is_within_sides;
use crate::geometry::vector::{
    Vector, add, area_normal, bounds, dot, length_squared, scale, squared, subtract,
};

/// A suspect farther than this outside the box of all faces, in diagonals, is passed by: its line hardly ever
/// crosses one of them, and this is known in fewer steps.
const MARGIN: f64 = 0.02;

/// A line at a smaller sine to a face crosses it nowhere: where it does is not exact.
const LEAST_SLOPE: f64 = 0.01;

/// Suspects, the one that was met last first.
#[derive(Debug, Clone)]
pub(in crate::bounded) struct Suspects {
    list: Vec<Suspect>,
    /// More are not remembered.
    most: usize,
}

/// A point of a face that protruded, and the direction in which it did.
#[derive(Debug, Clone, Copy)]
struct Suspect {
    point: Vector,
    outward: Vector,
}

impl Suspects {
    /// Remembers the `most` last ones.
    pub(in crate::bounded) fn new(most: usize) -> Self {
        Self { list: Vec::new(), most }
    }

    /// Remembers a point of a face that protrudes there.
    pub(in crate::bounded) fn remember(&mut self, point: Vector, [a, b, c]: [Vector; 3]) {
        self.list.truncate(self.most - 1);
        self.list.insert(0, Suspect { point, outward: area_normal(a, b, c) });
    }

    /// The first of the faces that protrudes at a suspect, by its index. A face is asked at the point above or
    /// below a suspect. O(suspects · faces), and what `protrudes` takes.
    pub(in crate::bounded) fn find<T>(
        &mut self,
        faces: &[T],
        corners: impl Fn(&T) -> [Vector; 3],
        mut protrudes: impl FnMut([Vector; 3], Vector) -> bool,
    ) -> Option<usize> {
        let (min, max) = bounds(faces.iter().flat_map(&corners));
        for index in 0..self.list.len() {
            let Suspect { point, outward } = self.list[index];
            if (0..3).any(|k| point[k] < min[k] - MARGIN || point[k] > max[k] + MARGIN) {
                continue;
            }
            for (k, face) in faces.iter().enumerate() {
                let face = corners(face);
                let Some(hit) = crossing(face, point, outward) else { continue };
                if protrudes(face, hit) {
                    self.list[..=index].rotate_right(1);
                    self.list[0].point = hit;
                    return Some(k);
                }
            }
        }
        None
    }
}

/// Where a line crosses a triangle.
#[inline]
fn crossing([a, b, c]: [Vector; 3], point: Vector, direction: Vector) -> Option<Vector> {
    let normal = area_normal(a, b, c);
    let slope = dot(normal, direction);
    let flattest = squared(LEAST_SLOPE) * length_squared(normal) * length_squared(direction);
    if squared(slope) < flattest {
        return None;
    }
    let share = dot(normal, subtract(a, point)) / slope;
    let hit = add(point, scale(direction, share));
    is_within_sides([a, b, c], hit).then_some(hit)
}

#[cfg(test)]
mod tests {
    use super::*;

    const MOST: usize = 16;
    const FACE: [Vector; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

    fn moved(face: [Vector; 3], by: Vector) -> [Vector; 3] {
        face.map(|corner| add(corner, by))
    }

    #[test]
    fn a_face_is_asked_above_and_below_where_another_protruded() {
        let mut suspects = Suspects::new(MOST);
        suspects.remember([0.2, 0.3, 0.0], FACE);
        let faces = [
            moved(FACE, [5.0, 0.0, 0.0]),
            moved(FACE, [0.1, 0.1, -0.5]),
            moved(FACE, [0.0, 0.0, 0.5]),
        ];
        let mut asked = Vec::new();
        let found = suspects.find(
            &faces,
            |&face| face,
            |_, point| {
                asked.push(point);
                point[2] > 0.0
            },
        );
        assert_eq!(found, Some(2));
        assert_eq!(asked, [[0.2, 0.3, -0.5], [0.2, 0.3, 0.5]]);
    }

    #[test]
    fn the_suspect_that_was_met_last_is_asked_first_and_old_ones_are_forgotten() {
        let mut suspects = Suspects::new(MOST);
        for k in 0..2 * MOST {
            suspects.remember([0.01 * k as f64, 0.1, 0.0], FACE);
        }
        let asked_until = |suspects: &mut Suspects, x: f64| {
            let mut asked = 0;
            let found = suspects.find(
                &[FACE],
                |&face| face,
                |_, point| {
                    asked += 1;
                    (point[0] - x).abs() < 1e-9
                },
            );
            (found.is_some(), asked)
        };
        assert_eq!(asked_until(&mut suspects, 0.05), (false, MOST));
        assert_eq!(asked_until(&mut suspects, 0.2), (true, 12));
        assert_eq!(asked_until(&mut suspects, 0.2), (true, 1));
    }

    #[test]
    fn a_line_along_a_face_crosses_it_nowhere() {
        assert_eq!(crossing(FACE, [0.2, 0.2, 0.0], [1.0, 0.0, 0.0]), None);
        assert_eq!(crossing(FACE, [0.2, 0.2, 0.1], [1.0, 0.0, 0.0]), None);
    }
}
