//! The loop that halves the faces of hulls until each part is decided, by the search's rules or by verification's.
//!
//! Distance is 1-Lipschitz. So the distance at the centre of a part whose corners are at most r from it often decides the
//! whole part. What a [`Policy`] leaves undecided is halved across its longest side. A large face along the surface would
//! be halved many times: in a coarse solid it is first taken apart into what lies along triangles and what remains.

use super::remainder::Remainder;
use super::solid::Solid;
use super::surface::Side;
use crate::geometry::vector::{Vector, area_normal, squared};
use crate::probe::Extent;

/// The corners of a face, or of a part of one.
pub(super) type Face = [Vector; 3];

/// A part of a face.
pub(super) struct Part {
    pub corners: Face,
    pub centre: Vector,
    /// The greatest distance of a corner from the centre.
    pub radius: f64,
}

impl Part {
    #[inline]
    pub fn new(corners: Face) -> Self {
        let centre = centre(corners);
        let [a, b, c] = corners.map(|corner| centre.distance_squared(corner));
        Self { corners, centre, radius: a.max(b).max(c).sqrt() }
    }

    /// The part for a probe, as if it were `factor` times as large.
    pub fn extent(&self, factor: f64) -> Extent {
        Extent::of_part(self.centre, self.corners, factor)
    }
}

/// What is to be done about a part.
pub(super) enum Verdict {
    /// It does not matter any more.
    Settled,
    /// Its parts have to be judged.
    Open,
    /// The question is answered. The policy holds the answer.
    Stop,
}

/// The rules by which parts are decided.
pub(super) trait Policy {
    fn judge(&mut self, part: &Part) -> Verdict;

    /// What is this near to a triangle of the surface is settled.
    fn near(&self) -> f64;

    /// Judges what no triangle crosses, and is outside a closed solid as a whole, by its centre.
    fn judge_outside(&mut self, centre: Vector) -> Verdict;
}

/// Memory that is used again.
#[derive(Default)]
pub(crate) struct Scratch {
    /// Parts that are not judged yet, and whether the surface may cross them.
    pub(super) stack: Vec<(Face, bool)>,
    remainder: Remainder,
}

/// Halves faces until each part is settled, or the policy stops; then the rest stays on the stack. If `around` is a point
/// of a face, only the parts that contain it are judged, a few of hundreds.
pub(super) fn subdivide(
    solid: &Solid,
    faces: impl Iterator<Item = Face>,
    around: Option<Vector>,
    policy: &mut impl Policy,
    Scratch { stack, remainder }: &mut Scratch,
) {
    let matters = |&part: &Face| around.is_none_or(|point| is_within_sides(part, point));
    stack.clear();
    stack.extend(faces.map(|face| (face, solid.is_coarse())));
    while let Some((corners, may_be_crossed)) = stack.pop() {
        let part = Part::new(corners);
        match policy.judge(&part) {
            Verdict::Settled => continue,
            Verdict::Stop => return,
            Verdict::Open => {}
        }
        let is_taken_apart =
            may_be_crossed && remainder.find(corners, part.radius, policy.near(), solid.tree());
        if !is_taken_apart {
            stack.extend(
                halves(corners).into_iter().filter(matters).map(|half| (half, may_be_crossed)),
            );
            continue;
        }
        for (centre, triangles) in remainder.parts() {
            let mut triangles = triangles.filter(matters).peekable();
            if triangles.peek().is_none() {
                continue;
            }
            if solid.is_closed() {
                if solid.side(centre) == Side::Inside {
                    continue;
                }
                match policy.judge_outside(centre) {
                    Verdict::Settled => continue,
                    Verdict::Stop => return,
                    Verdict::Open => {}
                }
            }
            stack.extend(triangles.map(|part| (part, false)));
        }
    }
}

#[inline]
pub(crate) fn centre([a, b, c]: [Vector; 3]) -> Vector {
    (a + b + c) * (1.0 / 3.0)
}

/// The halves of a triangle across its longest side.
#[inline]
pub(super) fn halves([a, b, c]: [Vector; 3]) -> [[Vector; 3]; 2] {
    let squared = |a: Vector, b: Vector| a.distance_squared(b);
    let (ab, bc, ca) = (squared(a, b), squared(b, c), squared(c, a));
    if ab >= bc && ab >= ca {
        let middle = (a + b) * 0.5;
        [[a, middle, c], [middle, b, c]]
    } else if bc >= ca {
        let middle = (b + c) * 0.5;
        [[a, b, middle], [a, middle, c]]
    } else {
        let middle = (c + a) * 0.5;
        [[a, b, middle], [middle, b, c]]
    }
}

/// Whether a point of a triangle's plane is in the triangle.
#[inline]
pub(super) fn is_within_sides([a, b, c]: [Vector; 3], point: Vector) -> bool {
    let normal = area_normal(a, b, c);
    [area_normal(a, b, point), area_normal(b, c, point), area_normal(c, a, point)]
        .into_iter()
        .all(|part| part.dot(normal) >= 0.0)
}

/// A suspect farther than this outside the box of all faces, as a fraction of the diagonal, is skipped: its line hardly ever
/// crosses one of them, and this is known in fewer steps.
const MARGIN: f64 = 0.02;

/// A line at a smaller sine to a face crosses it nowhere: where it does is not exact.
const LEAST_SLOPE: f64 = 0.01;

/// Where earlier hulls have protruded: those that are tested next are similar, and most of what
/// does not fit protrudes there, too. The one that was met last comes first.
///
/// A suspect only says where to look first. No answer depends on it.
#[derive(Debug, Clone)]
pub(super) struct Suspects {
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
    pub(super) fn new(most: usize) -> Self {
        Self { list: Vec::new(), most }
    }

    /// Remembers a point of a face that protrudes there.
    pub(super) fn remember(&mut self, point: Vector, [a, b, c]: [Vector; 3]) {
        self.list.truncate(self.most - 1);
        self.list.insert(0, Suspect { point, outward: area_normal(a, b, c) });
    }

    /// The first of the faces that protrudes at a suspect, by its index. A face is tested at the point above or
    /// below a suspect. `min` and `max` are the corners of a box around all of them. O(suspects · faces), and what
    /// `protrudes` takes.
    pub(super) fn find<T>(
        &mut self,
        faces: &[T],
        [min, max]: [Vector; 2],
        corners: impl Fn(&T) -> [Vector; 3],
        mut protrudes: impl FnMut([Vector; 3], Vector) -> bool,
    ) -> Option<usize> {
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
    let slope = normal.dot(direction);
    let flattest = squared(LEAST_SLOPE) * normal.length_squared() * direction.length_squared();
    if squared(slope) < flattest {
        return None;
    }
    let share = normal.dot(a - point) / slope;
    let hit = point + direction * share;
    is_within_sides([a, b, c], hit).then_some(hit)
}

#[cfg(test)]
mod tests {
    use super::*;

    const MOST: usize = 16;
    const FACE: [Vector; 3] = [Vector::ZERO, Vector::X, Vector::Y];

    fn moved(face: [Vector; 3], by: Vector) -> [Vector; 3] {
        face.map(|corner| corner + by)
    }

    #[test]
    fn a_face_is_tested_above_and_below_where_another_protruded() {
        let mut suspects = Suspects::new(MOST);
        suspects.remember(Vector::new(0.2, 0.3, 0.0), FACE);
        let faces = [
            moved(FACE, Vector::new(5.0, 0.0, 0.0)),
            moved(FACE, Vector::new(0.1, 0.1, -0.5)),
            moved(FACE, Vector::new(0.0, 0.0, 0.5)),
        ];
        let mut tested = Vec::new();
        let found = suspects.find(
            &faces,
            [Vector::ZERO, Vector::splat(9.0)],
            |&face| face,
            |_, point| {
                tested.push(point);
                point[2] > 0.0
            },
        );
        assert_eq!(found, Some(2));
        assert_eq!(tested, [[0.2, 0.3, -0.5], [0.2, 0.3, 0.5]].map(Vector::from));
    }

    #[test]
    fn the_suspect_that_was_met_last_is_tested_first_and_old_ones_are_forgotten() {
        let mut suspects = Suspects::new(MOST);
        for k in 0..2 * MOST {
            suspects.remember(Vector::new(0.01 * k as f64, 0.1, 0.0), FACE);
        }
        let tested_until = |suspects: &mut Suspects, x: f64| {
            let mut tested = 0;
            let found = suspects.find(
                &[FACE],
                [Vector::ZERO, Vector::ONE],
                |&face| face,
                |_, point| {
                    tested += 1;
                    (point[0] - x).abs() < 1e-9
                },
            );
            (found.is_some(), tested)
        };
        assert_eq!(tested_until(&mut suspects, 0.05), (false, MOST));
        assert_eq!(tested_until(&mut suspects, 0.2), (true, 12));
        assert_eq!(tested_until(&mut suspects, 0.2), (true, 1));
    }

    #[test]
    fn a_line_along_a_face_crosses_it_nowhere() {
        assert_eq!(crossing(FACE, Vector::new(0.2, 0.2, 0.0), Vector::X), None);
        assert_eq!(crossing(FACE, Vector::new(0.2, 0.2, 0.1), Vector::X), None);
    }
}
