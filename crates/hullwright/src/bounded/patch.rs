//! Patches of the surface, sets of them, and pieces: sets of patches with their hulls.
//!
//! Sets are bits, so that conflicts and covers are compared word by word.

use std::ops::Index;

use fixedbitset::FixedBitSet;

use super::detail::Detail;
use crate::geometry::vector::{Vector, bounds};
use crate::hull::growing_hull::GrowingHull;
use crate::mesh::TriangleMesh;

/// A part of the surface that the search does not divide.
#[derive(Debug, Clone, Default)]
pub(crate) struct Patch {
    /// Vertices of its hull, except those nearer to it than the patch tolerance; all of its points
    /// where it is flat.
    pub points: Vec<Vector>,
    /// Two of `points` that are far apart; of a coarse mesh the centre, too.
    pub representatives: Vec<Vector>,
    /// Sum of its triangles' area normals, each twice as long as the triangle's area.
    pub outward: Vector,
    pub area: f64,
    pub min: Vector,
    pub max: Vector,
    /// The triangles of [`Patches::surface`] that it represents.
    pub triangles: Vec<u32>,
    pub component: u32,
}

impl Patch {
    pub fn set_points(&mut self, points: Vec<Vector>) {
        (self.min, self.max) = bounds(points.iter().copied());
        self.representatives = far_pair(&points);
        self.points = points;
    }
}

/// The patches of a surface.
pub(crate) struct Patches {
    pub patches: Vec<Patch>,
    /// Whether they are larger: across the folds of a surface that folds everywhere, or of several
    /// components where there are many.
    pub are_across_folds: bool,
    /// Pairs of patches that share an edge.
    pub neighbours: Vec<(u32, u32)>,
    /// A partition of the patches: parts of one group whose joint hull fits. Merging starts from
    /// them, where there are no conflicts among their patches.
    pub seeds: Vec<Vec<u32>>,
    /// For each patch those that are not joined with it: a point between the two is outside by more
    /// than the search's bound.
    pub conflicts: Vec<PatchSet>,
    /// The coarse surface, cut, or its long triangles halved.
    pub surface: TriangleMesh,
    /// For each triangle of `surface` the coarse triangle that it is a part of.
    pub parents: Vec<u32>,
    /// The exact surface, and what of it the triangles of `surface` stand for.
    pub detail: Detail,
    /// The mesh that was divided, and for each of its triangles its patch.
    pub mesh: TriangleMesh,
    pub labels: Vec<u32>,
}

impl Patches {
    pub fn count(&self) -> usize {
        self.patches.len()
    }

    /// The set of all patches.
    pub fn all(&self) -> PatchSet {
        PatchSet::new(self.count(), 0..self.count() as u32)
    }
}

impl Index<u32> for Patches {
    type Output = Patch;

    #[inline]
    fn index(&self, patch: u32) -> &Patch {
        &self.patches[patch as usize]
    }
}

/// Two points that are far apart: the farthest from the first point, and the farthest from that.
pub(super) fn far_pair(points: &[Vector]) -> Vec<Vector> {
    let farthest = |from: Vector| {
        points.iter().copied().max_by(|&a, &b| a.distance(from).total_cmp(&b.distance(from)))
    };
    let first = points.first().and_then(|&point| farthest(point));
    let second = first.and_then(farthest);
    first.into_iter().chain(second).collect()
}

/// A set of patches, given by their indices.
#[derive(Debug, Clone, Default, PartialEq, Eq, Hash)]
pub(crate) struct PatchSet(FixedBitSet);

impl PatchSet {
    /// The empty set, for patches `0..count`.
    pub fn empty(count: usize) -> Self {
        Self(FixedBitSet::with_capacity(count))
    }

    /// Some of the patches `0..count`.
    pub fn new(count: usize, patches: impl IntoIterator<Item = u32>) -> Self {
        let mut set = Self::empty(count);
        patches.into_iter().for_each(|patch| set.insert(patch));
        set
    }

    #[inline]
    pub fn insert(&mut self, patch: u32) {
        self.0.insert(patch as usize);
    }

    #[inline]
    pub fn remove(&mut self, patch: u32) {
        self.0.remove(patch as usize);
    }

    #[inline]
    pub fn contains(&self, patch: u32) -> bool {
        self.0.contains(patch as usize)
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_clear()
    }

    pub fn intersects(&self, other: &Self) -> bool {
        !self.0.is_disjoint(&other.0)
    }

    pub fn union_with(&mut self, other: &Self) {
        self.0.union_with(&other.0);
    }

    pub fn intersect_with(&mut self, other: &Self) {
        self.0.intersect_with(&other.0);
    }

    pub fn difference_with(&mut self, other: &Self) {
        self.0.difference_with(&other.0);
    }

    /// Number of members.
    pub fn count(&self) -> usize {
        self.0.count_ones(..)
    }

    /// The members, ascending.
    pub fn iter(&self) -> impl Iterator<Item = u32> + '_ {
        self.0.ones().map(|patch| patch as u32)
    }
}

/// Patches and their hull, which can go on growing.
#[derive(Debug, Clone)]
pub(crate) struct Piece {
    pub patches: PatchSet,
    pub hull: GrowingHull,
    /// Vertices of the hull, where other pieces are going to join it; empty otherwise.
    pub vertices: Vec<Vector>,
}

impl Piece {
    /// The hull of some patches.
    pub fn new(patches: &Patches, set: &PatchSet) -> Self {
        let mut points = Vec::new();
        let mut outward = Vector::ZERO;
        for patch in set.iter() {
            let patch = &patches[patch];
            points.extend_from_slice(&patch.points);
            outward += patch.outward;
        }
        let hull = GrowingHull::new(&points, outward);
        Self { patches: set.clone(), hull, vertices: Vec::new() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounded::fixture::{Fixture, cubes, l_prism};

    /// More than a word of bits has.
    const COUNT: usize = 70;

    fn set(members: impl IntoIterator<Item = u32>) -> PatchSet {
        PatchSet::new(COUNT, members)
    }

    #[test]
    fn a_set_lists_each_member_once_and_ascending() {
        let mut some = set([69, 3, 64, 3, 0]);
        assert_eq!(some.iter().collect::<Vec<u32>>(), [0, 3, 64, 69]);
        assert_eq!(some.count(), 4);
        some.remove(64);
        assert!(!some.contains(64) && some.contains(69) && !some.is_empty());
        assert!(PatchSet::empty(COUNT).is_empty());
    }

    #[test]
    fn sets_unite_intersect_and_differ_as_their_members_do() {
        let is_even = |patch: &u32| patch.is_multiple_of(2);
        let is_third = |patch: &u32| patch.is_multiple_of(3);
        let (even, thirds) = (set((0..70).filter(is_even)), set((0..70).filter(is_third)));
        let changed = |change: fn(&mut PatchSet, &PatchSet)| {
            let mut changed = even.clone();
            change(&mut changed, &thirds);
            changed
        };
        let expected = |keep: fn(bool, bool) -> bool| {
            set((0..70).filter(|patch| keep(is_even(patch), is_third(patch))))
        };
        assert_eq!(changed(PatchSet::union_with), expected(|a, b| a || b));
        assert_eq!(changed(PatchSet::intersect_with), expected(|a, b| a && b));
        assert_eq!(changed(PatchSet::difference_with), expected(|a, b| a && !b));
    }

    #[test]
    fn sets_intersect_if_they_share_a_member() {
        let (some, others) = (set([1, 66]), set([2, 65]));
        assert!(!some.intersects(&others) && !some.intersects(&PatchSet::empty(COUNT)));
        assert!(some.intersects(&set([66])) && set([66]).intersects(&some));
    }

    #[test]
    fn two_points_that_are_far_apart_are_ends_of_a_row() {
        let row: Vec<Vector> = [4.0, 7.0, 0.0, 9.0, 2.0].map(|x| Vector::new(x, 0.0, 0.0)).to_vec();
        assert_eq!(far_pair(&row).iter().map(|point| point.x).collect::<Vec<f64>>(), [9.0, 0.0]);
        assert!(far_pair(&[]).is_empty());
    }

    #[test]
    fn a_patch_has_the_box_of_its_points() {
        let mut patch = Patch::default();
        patch.set_points(vec![Vector::new(1.0, 5.0, -1.0), Vector::new(2.0, 3.0, 0.0)]);
        assert_eq!(patch.min, Vector::new(1.0, 3.0, -1.0));
        assert_eq!(patch.max, Vector::new(2.0, 5.0, 0.0));
        assert_eq!(patch.representatives.len(), 2);
    }

    #[test]
    fn a_piece_has_the_hull_of_all_its_patches() {
        let fixture = Fixture::new(&cubes([0.0, 2.0]), 0.02);
        let unit = fixture.prepared.normalization.diagonal.powi(-3);
        for (members, volume) in [(vec![0], 1.0), (vec![1], 1.0), (vec![0, 1], 3.0)] {
            let piece = fixture.piece(members.iter().copied());
            assert!((piece.hull.volume / unit - volume).abs() < 1e-3, "{}", piece.hull.volume);
            assert_eq!(piece.patches.iter().collect::<Vec<u32>>(), members);
        }
        let fixture = Fixture::new(&l_prism(), 0.02);
        let whole = fixture.piece(0..fixture.patches.count() as u32);
        assert!((whole.hull.volume * 27.0 - 3.5).abs() < 1e-3, "{}", whole.hull.volume);
        // The surface is closed.
        assert!(whole.hull.outward.length() < 1e-12);
    }
}
