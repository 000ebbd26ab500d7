//! Conflicts between patches: a point between two of them is outside the solid by more than the
//! bound, so that no hull that fits contains both.
//!
//! Merging asks for some pairs, one after the other, and what comes after it for all of them. So other threads
//! go through all pairs while it runs, and whoever needs a pair first finds out.

use std::sync::atomic::{AtomicU64, Ordering};

use super::patch::{Patch, Patches};
use crate::bounded::patch_set::PatchSet;
use crate::control::Control;
use crate::error::Error;
use crate::parallel;
use crate::solid::Solid;

/// Bits of a word.
const BITS: usize = u64::BITS as usize;

/// Conflicts, found out on demand.
pub(in crate::bounded) struct Conflicts<'a> {
    patches: &'a [Patch],
    solid: &'a Solid,
    bound: f64,
    /// A square of bits: right of the diagonal whether two patches conflict, left of it whether that is known.
    words: Vec<AtomicU64>,
}

impl<'a> Conflicts<'a> {
    /// Of none it is known. O(n²) bits for n patches.
    pub fn new(Patches { patches, .. }: &'a Patches, solid: &'a Solid, bound: f64) -> Self {
        let mut words = Vec::new();
        words.resize_with((patches.len() * patches.len()).div_ceil(BITS), || AtomicU64::new(0));
        Self { patches, solid, bound, words }
    }

    fn bit(&self, row: usize, column: usize) -> (&AtomicU64, u64) {
        let bit = row * self.patches.len() + column;
        (&self.words[bit / BITS], 1 << (bit % BITS))
    }

    /// Whether two patches conflict.
    pub fn between(&self, a: u32, b: u32) -> bool {
        let (first, second) = (a.min(b) as usize, a.max(b) as usize);
        let (conflict, conflict_bit) = self.bit(first, second);
        let (known, known_bit) = self.bit(second, first);
        if known.load(Ordering::Acquire) & known_bit != 0 {
            return conflict.load(Ordering::Relaxed) & conflict_bit != 0;
        }
        let is_conflict = self.find_out(first, second);
        if is_conflict {
            conflict.fetch_or(conflict_bit, Ordering::Relaxed);
        }
        known.fetch_or(known_bit, Ordering::Release);
        is_conflict
    }

    #[cold]
    fn find_out(&self, first: usize, second: usize) -> bool {
        let [first, second] = [first, second].map(|index| &self.patches[index].representatives);
        let separated = |&p| second.iter().any(|&q| self.solid.separates(p, q, self.bound));
        first.iter().any(separated)
    }

    /// Whether a patch of one set conflicts with one of another.
    pub fn between_sets(&self, a: &PatchSet, b: &PatchSet) -> bool {
        a.iter().any(|first| b.iter().any(|second| self.between(first, second)))
    }

    /// Blocks without conflicts among their patches. Other blocks are dissolved: a hull whose faces all
    /// lie on the surface can still swallow empty space.
    pub fn agreeing(&self, blocks: &[Vec<u32>]) -> Vec<Vec<u32>> {
        let agrees = |block: &&Vec<u32>| {
            let mut pairs =
                (1..).zip(*block).flat_map(|(next, &a)| block[next..].iter().map(move |&b| (a, b)));
            !pairs.any(|(a, b)| self.between(a, b))
        };
        let (blocks, others): (Vec<_>, Vec<_>) = blocks.iter().partition(agrees);
        let single = others.into_iter().flatten().map(|&patch| vec![patch]);
        blocks.into_iter().cloned().chain(single).collect()
    }

    /// For each patch those that it conflicts with. O(n²) segments between representatives.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn all(&self, control: &Control) -> Result<Vec<PatchSet>, Error> {
        let count = self.patches.len();
        let rows = parallel::map_indices(count, |index| {
            control.check()?;
            let others = index as u32 + 1..count as u32;
            let conflicts = others.filter(|&other| self.between(index as u32, other));
            Ok(PatchSet::of(count, conflicts))
        });
        let mut conflicts: Vec<PatchSet> = rows.into_iter().collect::<Result<_, Error>>()?;
        for index in 0..count {
            let row: Vec<u32> = conflicts[index].iter().filter(|&o| o as usize > index).collect();
            for other in row {
                conflicts[other as usize].insert(index as u32);
            }
        }
        Ok(conflicts)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::vector::Vector;
    use crate::mesh::TriangleMesh;
    use crate::mesh::shapes::{cuboid, join};
    use crate::solid::Boundary;

    const BOUND: f64 = 0.02;

    /// Two cubes that are more than a cube apart, and a patch for each triangle.
    fn two_cubes() -> (Solid, Patches) {
        let mesh = join(&[cuboid([0.0; 3], [0.2; 3]), cuboid([0.45, 0.0, 0.0], [0.65, 0.2, 0.2])]);
        let TriangleMesh { positions, triangles, .. } = &mesh;
        let solid =
            Solid::of_surface(positions, triangles, Boundary::default(), BOUND, &Control::new());
        let patch = |corners: &[u32; 3]| {
            let representatives: Vec<Vector> =
                corners.iter().map(|&vertex| positions[vertex as usize]).collect();
            Patch { representatives, ..Patch::default() }
        };
        let count = triangles.len() as u32;
        let patches = Patches {
            patches: triangles.iter().map(patch).collect(),
            neighbours: Vec::new(),
            blocks: Vec::new(),
            conflicts: Vec::new(),
            surface: std::sync::Arc::default(),
            parents: std::sync::Arc::default(),
            mesh: mesh.clone(),
            labels: (0..count).collect(),
        };
        (solid.unwrap(), patches)
    }

    #[test]
    fn patches_conflict_where_there_is_a_gap_between_them() {
        let (solid, patches) = two_cubes();
        let conflicts = Conflicts::new(&patches, &solid, BOUND);
        let half = patches.count() as u32 / 2;
        for a in 0..half {
            for b in a + 1..2 * half {
                assert_eq!(conflicts.between(a, b), b >= half, "{a} and {b}");
            }
        }
    }

    #[test]
    fn what_is_asked_first_changes_no_conflict() {
        let (solid, patches) = two_cubes();
        let all = |asked: &[(u32, u32)]| {
            let conflicts = Conflicts::new(&patches, &solid, BOUND);
            let first: Vec<bool> = asked.iter().map(|&(a, b)| conflicts.between(a, b)).collect();
            let all = conflicts.all(&Control::new()).unwrap();
            for (&(a, b), is_conflict) in asked.iter().zip(first) {
                assert_eq!(all[a as usize].contains(b), is_conflict);
                assert_eq!(all[b as usize].contains(a), is_conflict);
            }
            all
        };
        assert_eq!(all(&[]), all(&[(23, 0), (3, 20), (2, 1), (0, 23)]));
    }

    #[test]
    fn blocks_with_a_conflict_fall_into_single_patches() {
        let (solid, patches) = two_cubes();
        let conflicts = Conflicts::new(&patches, &solid, BOUND);
        let blocks = [vec![0, 1, 12], vec![2, 3], vec![13]];
        let agreeing = [vec![2, 3], vec![13], vec![0], vec![1], vec![12]];
        assert_eq!(conflicts.agreeing(&blocks), agreeing);
    }
}
