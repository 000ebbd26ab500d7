//! Points that need a hull each, since no two can be in one: a large clique of the graph of
//! conflicts.
//!
//! The search is local, as in Pullan and Hoos, "Dynamic local search for the maximum clique
//! problem" (2006): a point joins that is apart from all others, or takes the place of the one that
//! it is not apart from; where neither is possible the set changes at random, from a fixed seed.

use super::open_space::OpenSpace;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::Vector;
use crate::parallel;

/// Points between two others that are looked at, the one halfway first. As shares of the way:
/// powers of the golden ratio, since fractions of whole numbers would all lie in the bars of a
/// grating.
const BETWEEN: [f64; 7] = [0.5, 0.382, 0.618, 0.236, 0.764, 0.146, 0.854];

/// Points of a round, at most: all pairs of them are looked at.
const MOST: usize = 700;

/// Rounds of the search. Each takes points into account that nearly fit the set found before.
const ROUNDS: usize = 4;

/// Steps of a round's search.
const STEPS: usize = 4_000;

/// Steps after which a point that gave way may come back.
const AWAY: usize = 10;

/// Points that may be apart from each other.
pub(super) struct Conflicts<'a> {
    points: Vec<Vector>,
    space: &'a OpenSpace<'a>,
    /// The points of this round, by their indices.
    chosen: Vec<usize>,
    /// For each pair of chosen points whether they are apart.
    is_apart: Vec<Vec<bool>>,
}

impl<'a> Conflicts<'a> {
    /// Looks at points far from each other first.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn new(
        points: Vec<Vector>,
        space: &'a OpenSpace<'a>,
        control: &Control,
    ) -> Result<Self, Error> {
        let first = farthest_first(&points, MOST);
        let mut conflicts = Self { points, space, chosen: Vec::new(), is_apart: Vec::new() };
        conflicts.add(&first, control)?;
        Ok(conflicts)
    }

    /// As many points as are found that are all apart from each other.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn apart(mut self, control: &Control) -> Result<Vec<Vector>, Error> {
        let mut best = self.largest(&[]);
        for _ in 1..ROUNDS {
            let more = self.nearly_apart(&best, control)?;
            if more.is_empty() {
                break;
            }
            self.keep(&mut best);
            self.add(&more, control)?;
            best = self.largest(&best);
        }
        Ok(best.into_iter().map(|rank| self.points[self.chosen[rank]]).collect())
    }

    fn are_apart(&self, a: Vector, b: Vector) -> bool {
        BETWEEN.iter().any(|&share| self.space.excludes(a.lerp(b, share)))
    }

    /// Adds points, and looks at all their pairs.
    fn add(&mut self, more: &[usize], control: &Control) -> Result<(), Error> {
        let before = self.chosen.len();
        self.chosen.extend(more);
        let rows = parallel::map_indices(more.len(), |rank| {
            control.check()?;
            let at = self.points[more[rank]];
            let others = &self.chosen[..before + rank];
            Ok(others.iter().map(|&other| self.are_apart(at, self.points[other])).collect())
        });
        for row in rows {
            let row: Vec<bool> = row?;
            for (other, &is_apart) in self.is_apart.iter_mut().zip(&row) {
                other.push(is_apart);
            }
            self.is_apart.push([&row[..], &[false]].concat());
        }
        Ok(())
    }

    /// Forgets all points but a set of them, whose ranks change.
    fn keep(&mut self, set: &mut [usize]) {
        self.chosen = set.iter().map(|&rank| self.chosen[rank]).collect();
        let row = |&rank: &usize| set.iter().map(|&other| self.is_apart[rank][other]).collect();
        self.is_apart = set.iter().map(row).collect();
        set.iter_mut().enumerate().for_each(|(new, rank)| *rank = new);
    }

    /// Points that are apart from all of a set but one, or from all: those that are most alone.
    fn nearly_apart(&self, set: &[usize], control: &Control) -> Result<Vec<usize>, Error> {
        let members: Vec<Vector> = set.iter().map(|&rank| self.points[self.chosen[rank]]).collect();
        let missing = parallel::map_indices(self.points.len(), |index| {
            control.check()?;
            let point = self.points[index];
            let mut missing = 0;
            for &member in &members {
                missing += usize::from(!self.are_apart(point, member));
                if missing > 1 {
                    break;
                }
            }
            Ok(missing)
        });
        let mut found = Vec::new();
        for (index, missing) in missing.into_iter().enumerate() {
            // Members themselves are not apart from one point: themselves.
            if missing? <= 1 && !set.iter().any(|&rank| self.chosen[rank] == index) {
                found.push(index);
            }
        }
        let places: Vec<Vector> = found.iter().map(|&index| self.points[index]).collect();
        Ok(farthest_first(&places, MOST).into_iter().map(|rank| found[rank]).collect())
    }

    /// The largest set found of chosen points that are all apart, from one to begin with.
    fn largest(&self, start: &[usize]) -> Vec<usize> {
        let count = self.chosen.len();
        let mut search = Search::new(&self.is_apart);
        start.iter().for_each(|&rank| search.insert(rank));
        let mut best = start.to_vec();
        let mut random = 0x9e37_79b9_7f4a_7c15_u64;
        for step in 0..STEPS {
            let Some(next) = search.next(step) else {
                // SplitMix64's multiplier: any full-period sequence will do.
                random = random.wrapping_mul(0xbf58_476d_1ce4_e5b9).wrapping_add(1);
                if count == 0 {
                    break;
                }
                let rank = (random >> 33) as usize % count;
                if !search.is_member[rank] {
                    search.insert_instead(rank, step);
                }
                continue;
            };
            search.insert_instead(next, step);
            if search.members.len() > best.len() {
                best.clone_from(&search.members);
            }
        }
        best.sort_unstable();
        best
    }
}

/// A set of points that are all apart, and for each point how many members it is not apart from.
struct Search<'a> {
    is_apart: &'a [Vec<bool>],
    members: Vec<usize>,
    is_member: Vec<bool>,
    missing: Vec<u32>,
    /// The step from which on a point may come back.
    from: Vec<usize>,
}

impl<'a> Search<'a> {
    fn new(is_apart: &'a [Vec<bool>]) -> Self {
        let count = is_apart.len();
        let (is_member, missing, from) = (vec![false; count], vec![0; count], vec![0; count]);
        Self { is_apart, members: Vec::new(), is_member, missing, from }
    }

    fn insert(&mut self, rank: usize) {
        self.members.push(rank);
        self.is_member[rank] = true;
        for (missing, &is_apart) in self.missing.iter_mut().zip(&self.is_apart[rank]) {
            *missing += u32::from(!is_apart);
        }
    }

    /// Inserts a point in place of all that it is not apart from.
    fn insert_instead(&mut self, rank: usize, step: usize) {
        let row = &self.is_apart[rank];
        let (kept, gone): (Vec<usize>, Vec<usize>) =
            self.members.iter().partition(|&&member| row[member]);
        self.members = kept;
        for member in gone {
            self.is_member[member] = false;
            self.from[member] = step + AWAY;
            for (missing, &is_apart) in self.missing.iter_mut().zip(&self.is_apart[member]) {
                *missing -= u32::from(!is_apart);
            }
        }
        self.insert(rank);
    }

    /// The point to insert next: one that joins, else one that takes the place of another; of
    /// several the one that waited longest.
    fn next(&self, step: usize) -> Option<usize> {
        let may_come = |&rank: &usize| !self.is_member[rank] && self.from[rank] <= step;
        let candidates = (0..self.missing.len()).filter(may_come);
        candidates
            .filter(|&rank| self.missing[rank] <= 1)
            .min_by_key(|&rank| (self.missing[rank], self.from[rank], rank))
    }
}

/// So many points, each the farthest from those before it.
fn farthest_first(points: &[Vector], count: usize) -> Vec<usize> {
    if points.is_empty() {
        return Vec::new();
    }
    let mut distances = vec![f64::INFINITY; points.len()];
    let (mut order, mut next) = (Vec::new(), 0);
    while order.len() < count.min(points.len()) {
        order.push(next);
        let last = points[next];
        let mut farthest = (0.0, next);
        for (index, (distance, point)) in distances.iter_mut().zip(points).enumerate() {
            *distance = distance.min(point.distance_squared(last));
            if *distance > farthest.0 {
                farthest = (*distance, index);
            }
        }
        if farthest.0 <= 0.0 {
            break;
        }
        next = farthest.1;
    }
    order
}
