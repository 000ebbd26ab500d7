//! Whether caps are worth it: on a mesh of fragments they are not.

use super::boundary::Loop;
use super::cap::Cap;
use super::report::OpeningOutcome;
use crate::mesh::PreparedMesh;

/// Where caps close less than this share of what stays open, by length, there is little to win: a mesh of
/// fragments takes a few hulls more with a few caps.
const LEAST_CLOSED: f64 = 0.1;

/// Leaves the caps of components most of whose boundary, by length, stays open, and all of them where nearly
/// all of the mesh's boundary does: with a few caps such a mesh is no solid.
pub(super) fn leave_fragments(
    prepared: &PreparedMesh,
    loops: &[Loop],
    is_crack: &[bool],
    caps: &mut [(Cap, OpeningOutcome)],
) {
    let mut outcomes = vec![OpeningOutcome::NotFlat; loops.len()];
    for (cap, outcome) in caps.iter() {
        cap.loops.iter().for_each(|&index| outcomes[index] = *outcome);
    }
    let component_of = |own: &Loop| {
        let neighbour = own.neighbours.first().copied().unwrap_or_default();
        prepared.components[neighbour as usize] as usize
    };
    let components = prepared.closed.len();
    let (mut closed, mut left) = (vec![0.0; components], vec![0.0; components]);
    let mut within = 0.0;
    for ((own, outcome), _) in loops.iter().zip(outcomes).zip(is_crack).filter(|own| !own.1) {
        let length = own.length(&prepared.mesh.positions);
        match outcome {
            OpeningOutcome::SolidBeyond | OpeningOutcome::ClosedWithin => within += length,
            OpeningOutcome::Closed => closed[component_of(own)] += length,
            _ => left[component_of(own)] += length,
        }
    }
    let sum = |lengths: &[f64]| lengths.iter().sum::<f64>();
    let all_left = sum(&left) + if sum(&left) > 0.0 { within } else { 0.0 };
    let is_little = sum(&closed) < LEAST_CLOSED * all_left;
    for (cap, outcome) in caps.iter_mut() {
        let is_fragment = cap.loops.iter().any(|&index| {
            let component = component_of(&loops[index]);
            left[component] > closed[component]
        });
        if outcome.is_closed() && (is_fragment || is_little) {
            *outcome = OpeningOutcome::Fragment;
        }
    }
}
