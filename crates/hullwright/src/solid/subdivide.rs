//! The loop that halves the faces of hulls until each part is decided, by the search's rules or by
//! verification's.
//!
//! Distance is 1-Lipschitz. So the distance at the centre of a part whose corners are at most r
//! from it often decides the whole part. What a [`Policy`] leaves undecided is halved across its
//! longest side. A large face along the surface would be halved many times: in a coarse solid it is
//! first taken apart into what lies along triangles and what remains.

use super::remainder::Remainder;
use super::solid::Solid;
use super::surface::Side;
use crate::geometry::vector::{Vector, centre, halves_of_triangle, larger};
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
        Self { corners, centre, radius: larger(larger(a, b), c).sqrt() }
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

/// Halves faces until each part is settled, or the policy stops; then the rest stays on the stack.
pub(super) fn subdivide(
    solid: &Solid,
    faces: impl Iterator<Item = Face>,
    policy: &mut impl Policy,
    Scratch { stack, remainder }: &mut Scratch,
) {
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
            stack.extend(halves_of_triangle(corners).map(|half| (half, may_be_crossed)));
            continue;
        }
        for (centre, triangles) in remainder.parts() {
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
