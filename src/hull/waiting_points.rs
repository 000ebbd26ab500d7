//! The points that wait in front of a growing hull's faces: each waits in front of one that it sees, and each
//! face knows the farthest of its own.

use super::builder::HullBuilder;
use super::columns::{Block, LANES};
use super::face::{
    CERTAINLY_BEHIND, Face, Given, Heights, NONE, Plane, RETIRED, Waiting, half_edge,
};
use crate::geometry::vector::{Vector, length_squared};

/// A face that a point is in front of.
#[derive(Debug, Clone, Copy)]
pub(super) struct InFront {
    pub face: u32,
    pub height: f64,
    /// Whether the distance is more than the tolerance.
    pub is_beyond: bool,
}

/// The first of some planes that a point is farther in front of than the tolerance; if there is
/// none, the one that it is nearest to being in front of.
#[inline]
pub(super) fn in_front_of(point: Vector, planes: &[Plane], heights: Heights) -> Option<InFront> {
    let mut best = None;
    let mut least = -CERTAINLY_BEHIND;
    for (face, plane) in (0..).zip(planes) {
        let height = plane.height(point);
        if height < heights.low {
            continue;
        }
        if heights.is_beyond(height, plane) {
            return Some(InFront { face, height, is_beyond: true });
        }
        let distance = height * inverse_root(length_squared(plane.normal));
        if distance > least {
            least = distance;
            best = Some(InFront { face, height, is_beyond: false });
        }
    }
    best
}

impl HullBuilder {
    /// The tetrahedron over four points in general position.
    pub(super) fn start(&mut self, [a, b, c, d]: [u32; 4]) {
        let given = Given { points: &self.originals, factor: self.factor };
        // Turned so that d lies behind the base.
        let (b, c) = if given.is_in_front([a, b, c], d) { (c, b) } else { (b, c) };
        let triangles = [[a, b, c], [a, c, d], [c, b, d], [b, a, d]];
        // Edge k of each face and the same edge of its neighbour.
        let twins = [
            [(3, 0), (2, 0), (1, 0)],
            [(0, 2), (2, 2), (3, 1)],
            [(0, 1), (3, 2), (1, 1)],
            [(0, 0), (1, 2), (2, 1)],
        ];
        self.planes.clear();
        let mut planes = [RETIRED.plane; 4];
        for ((vertices, twins), plane) in triangles.into_iter().zip(twins).zip(&mut planes) {
            let [first, second, last] = vertices;
            let edges = [first, second].map(|end| given.edge(last, end));
            let mut face = Face::spanned(vertices, edges, self.points[last as usize]);
            face.twins = twins.map(|(other, edge)| half_edge(other, edge));
            *plane = face.plane;
            self.planes.push(face.plane);
            self.faces.push(face);
            self.waiting.push(Waiting::none(0, 0));
        }
        let columns = std::mem::take(&mut self.columns);
        for (first, block) in (0..).step_by(LANES).zip(&columns.blocks) {
            self.share_out_block(first, block, &planes, [a, b, c, d]);
        }
        self.columns = columns;
    }

    /// Lets a few points that follow each other wait in front of the faces of the tetrahedron.
    #[inline]
    pub(super) fn share_out_block(
        &mut self,
        first: u32,
        [x, y, z]: &Block,
        planes: &[Plane; 4],
        corners: [u32; 4],
    ) {
        let heights: [[f64; LANES]; 4] = std::array::from_fn(|face| {
            std::array::from_fn(|lane| planes[face].height([x[lane], y[lane], z[lane]]))
        });
        // The rest of the last block stands for no points.
        for (lane, point) in (0..LANES).zip(first..self.points.len() as u32) {
            let height = |face: usize| heights[face][lane];
            let Some(face) = (0..4).find(|&face| height(face) >= self.heights.low) else {
                continue;
            };
            // A corner is not that high over any face.
            let found = if height(face) > self.heights.high {
                Some(InFront { face: face as u32, height: height(face), is_beyond: true })
            } else if corners.contains(&point) {
                None
            } else {
                in_front_of([x[lane], y[lane], z[lane]], planes, self.heights)
            };
            if let Some(found) = found {
                self.attach(point, found);
            }
        }
    }

    /// The first face that a point is farther in front of than the tolerance, in a hull that has
    /// stopped growing.
    pub(super) fn first_face_beyond(&self, position: Vector) -> Option<InFront> {
        let threshold = self.threshold;
        for (index, face) in (0..).zip(&self.faces) {
            let height = face.plane.height(position);
            if height > 0.0 && height * face.inverse > threshold {
                return Some(InFront { face: index, height, is_beyond: true });
            }
        }
        None
    }

    /// Lets the points from the given index on wait in front of faces, if they are in front of any.
    pub(super) fn assign_to_any(&mut self, first: usize) {
        self.planes.clear();
        for face in &self.faces {
            self.planes.push(face.plane);
        }
        for point in first..self.points.len() {
            if let Some(found) = in_front_of(self.points[point], &self.planes, self.heights) {
                self.attach(point as u32, found);
            }
        }
    }

    /// Lets a point wait in front of a face.
    #[inline]
    pub(super) fn attach(&mut self, point: u32, InFront { face, height, is_beyond }: InFront) {
        let waiting = &mut self.waiting[face as usize];
        self.next_waiting[point as usize] = waiting.first;
        waiting.first = point;
        if !is_beyond {
            self.has_close_points = true;
        } else if height > waiting.height
            && !(self.only_marked && self.marks[point as usize] == NONE)
        {
            if waiting.furthest == NONE {
                self.work.push(face);
            }
            waiting.height = height;
            waiting.furthest = point;
        }
    }

    /// Lets the points in `lines`, but for one, wait in front of the faces `visible` instead, whose
    /// planes are `planes`.
    pub(super) fn share_out(&mut self, except: u32) {
        // Borrowed one by one, so that the compiler need not look them up again and again.
        let (points, next_waiting) = (self.points.as_slice(), self.next_waiting.as_mut_slice());
        let (waiting, marks) = (self.waiting.as_mut_slice(), self.marks.as_slice());
        let (places, planes) = (self.visible.as_slice(), self.planes.as_slice());
        let (heights, only_marked) = (self.heights, self.only_marked);
        for &head in &self.lines {
            let mut next = head;
            while next != NONE {
                let point = next;
                next = next_waiting[point as usize];
                if point == except {
                    continue;
                }
                let Some(found) = in_front_of(points[point as usize], planes, heights) else {
                    continue;
                };
                let place = places[found.face as usize];
                let waiting = &mut waiting[place as usize];
                next_waiting[point as usize] = waiting.first;
                waiting.first = point;
                if !found.is_beyond {
                    self.has_close_points = true;
                } else if found.height > waiting.height
                    && !(only_marked && marks[point as usize] == NONE)
                {
                    if waiting.furthest == NONE {
                        self.work.push(place);
                    }
                    waiting.height = found.height;
                    waiting.furthest = point;
                }
            }
        }
    }

    /// Lets each waiting point count, marked or not.
    pub(super) fn consider_all_waiting(&mut self) {
        for (index, face) in (0..).zip(&self.faces) {
            let waiting = &mut self.waiting[index as usize];
            let mut point = waiting.first;
            while point != NONE {
                let height = face.plane.height(self.points[point as usize]);
                if height > waiting.height && self.heights.is_beyond(height, &face.plane) {
                    waiting.height = height;
                    waiting.furthest = point;
                }
                point = self.next_waiting[point as usize];
            }
            if waiting.furthest != NONE {
                self.work.push(index);
            }
        }
    }
}

/// One over the root of a number that is not negative; 0 for next to nothing.
///
/// Newton's method from a guess that halves and negates the exponent (Lomont, "Fast inverse square
/// root", 2003): several such run at once, while a processor takes roots and divides one by one.
#[inline]
pub(super) fn inverse_root(number: f64) -> f64 {
    /// Lomont's constant for double precision.
    const GUESS: u64 = 0x5FE6_EC85_E7DE_30DA;
    /// The guess is good to 4 bits and more, and each step doubles that.
    const STEPS: usize = 4;
    let mut root = f64::from_bits(GUESS.wrapping_sub(number.to_bits() >> 1));
    for _ in 0..STEPS {
        root *= 1.5 - 0.5 * number * root * root;
    }
    if number > f64::MIN_POSITIVE { root } else { 0.0 }
}
