//! The limit on hulls: hulls join, even beyond the bound, until few enough are left.
//!
//! Takes the final hulls of a pass, gives at most as many as the limit allows, and the bound of the
//! next pass.
//!
//! Joining one pair after the other ends with more error than a search under a larger bound, which
//! divides the surface anew. So the search is repeated under larger bounds, and of all results that
//! keep the limit the one with the least error stays. A search that ends with more hulls than the
//! limit is given up: its hulls, joined, are hardly ever the best.

use super::finalize::final_hull::{FinalHull, Owned};
use super::join_tree::JoinTree;
use super::search::Search;
use crate::error::Error;

/// Joins hulls until no more than `most` are left. See [`JoinTree::new`].
pub(crate) fn limit_hulls(
    search: &Search<'_>,
    hulls: &[FinalHull],
    most: usize,
) -> Result<Vec<FinalHull>, Error> {
    let &Search { exact_solid: solid, patches, settings, control, .. } = search;
    let leaves = hulls.iter().map(|hull| (hull.hull.clone(), hull.protrusion)).collect();
    let tree = JoinTree::new(leaves, most, solid, settings, control)?;
    let mut limited = Vec::new();
    for index in tree.state(tree.joins()) {
        let leaves = tree.leaves_below(index);
        let members: Vec<&FinalHull> = leaves.iter().filter_map(|&leaf| hulls.get(leaf)).collect();
        let Some(first) = members.first() else { continue };
        let node = &tree.nodes[index];
        let largest = |value: fn(&FinalHull) -> f64| {
            members.iter().map(|&hull| value(hull)).fold(0.0, f64::max)
        };
        let owned: Vec<&Owned> = members.iter().map(|hull| &hull.owned).collect();
        limited.push(FinalHull {
            hull: node.hull.clone(),
            owned: Owned::union(&owned, patches),
            added_thickness: largest(|hull| hull.added_thickness),
            simplification_growth: node.growth.max(largest(|hull| hull.simplification_growth)),
            protrusion: node.protrusion,
            uncovered: largest(|hull| hull.uncovered),
            component: first.component,
        });
    }
    Ok(limited)
}

/// Searches under larger bounds, at most: a trade of time for error.
const SEARCHES: usize = 4;

/// The next bound to try, as a share of the least error so far, while smaller ones are not known to
/// end with too many hulls.
const NEXT_BOUND: f64 = 0.85;

/// Less to gain than this factor is not worth a search.
const LEAST_GAIN: f64 = 1.01;

/// A bracket around the least bound that ends with few enough hulls.
pub(crate) struct BoundBracket {
    /// The largest bound that ended with too many hulls.
    refused: f64,
    /// Whether that is a bound of this search.
    is_near: bool,
    searches: usize,
}

impl BoundBracket {
    /// `bound` ended with too many hulls.
    pub(crate) fn new(bound: f64) -> Self {
        Self { refused: bound, is_near: false, searches: 0 }
    }

    /// `bound` ended with too many hulls, too.
    pub(crate) fn refuse(&mut self, bound: f64) {
        self.is_near |= bound > self.refused;
        self.refused = self.refused.max(bound);
    }

    /// The bound to try next, where `error` is the least so far; `None` if there is little to gain.
    pub(crate) fn next_bound(&mut self, error: f64) -> Option<f64> {
        if self.searches == SEARCHES || error < LEAST_GAIN * self.refused {
            return None;
        }
        self.searches += 1;
        // Three quarters of the way on a logarithmic scale: nearer to the error, fewer searches end
        // with too many hulls.
        let between = ((self.refused * error).sqrt() * error).sqrt();
        Some(if self.is_near { between } else { between.max(NEXT_BOUND * error) })
    }

    /// The share of the searches that is done, where `share` is that of the current one.
    pub(crate) fn progress(&self, share: f32) -> f32 {
        (self.searches.saturating_sub(1) as f32 + share) / SEARCHES as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounded::fixture::{Fixture, cubes};

    /// Three unit cubes, the last two of which are nearer to each other.
    const AT: [f64; 3] = [0.0, 2.2, 3.5];

    fn owned_by(hulls: &[FinalHull]) -> Vec<Vec<u32>> {
        hulls.iter().map(|hull| hull.owned.patches.iter().collect()).collect()
    }

    #[test]
    fn no_hulls_join_within_the_limit() {
        let fixture = Fixture::new(&cubes(AT), 0.02);
        let hulls = fixture.hulls_of_patches();
        for most in [3, 4] {
            let limited = limit_hulls(&fixture.search(), &hulls, most).unwrap();
            assert_eq!(owned_by(&limited), owned_by(&hulls));
        }
    }

    #[test]
    fn the_hulls_with_the_narrowest_gap_between_them_join_first() {
        let fixture = Fixture::new(&cubes(AT), 0.02);
        let hulls = fixture.hulls_of_patches();
        let limited = limit_hulls(&fixture.search(), &hulls, 2).unwrap();
        let is_at = |hull: &FinalHull, at: f64| {
            let low = hull.hull.points().iter().map(|point| point.x).fold(f64::INFINITY, f64::min);
            let low = low * fixture.prepared.normalization.diagonal;
            (low + fixture.prepared.normalization.centre.x - at).abs() < 1e-9
        };
        let [single, joint] = &limited[..] else { panic!("{} hulls", limited.len()) };
        assert!(is_at(single, AT[0]) && is_at(joint, AT[1]));
        assert_eq!(joint.owned.patches.count(), 2);
        // The middle of the gap is farthest from the solid.
        let half = 0.15 / fixture.prepared.normalization.diagonal;
        assert!(half <= joint.protrusion && joint.protrusion < 1.1 * half);
        assert_eq!(single.protrusion, 0.0);
    }

    #[test]
    fn one_hull_owns_what_all_owned_and_has_the_largest_of_their_errors() {
        let fixture = Fixture::new(&cubes(AT), 0.02);
        let mut hulls = fixture.hulls_of_patches();
        (hulls[1].uncovered, hulls[2].simplification_growth) = (0.003, 0.004);
        let limited = limit_hulls(&fixture.search(), &hulls, 1).unwrap();
        assert_eq!(owned_by(&limited), [[0, 1, 2]]);
        assert_eq!(limited[0].uncovered, 0.003);
        assert_eq!(limited[0].simplification_growth, 0.004);
        assert_eq!(limited[0].component, hulls[0].component);
    }

    #[test]
    fn no_search_follows_where_less_than_one_percent_is_to_gain() {
        assert_eq!(BoundBracket::new(0.02).next_bound(0.0201), None);
        assert!(BoundBracket::new(0.02).next_bound(0.0203).is_some());
    }

    #[test]
    fn at_most_four_searches_follow() {
        let mut bounds = BoundBracket::new(0.02);
        for _ in 0..4 {
            assert!(bounds.next_bound(0.3).is_some());
        }
        assert_eq!(bounds.next_bound(0.3), None);
        assert_eq!(bounds.progress(1.0), 1.0);
    }

    #[test]
    fn each_bound_is_between_the_largest_refused_one_and_the_least_error() {
        let mut bounds = BoundBracket::new(0.001);
        let error = 0.3;
        let first = bounds.next_bound(error).unwrap();
        // Far from the error all of three searches might be refused.
        assert_eq!(first, 0.85 * error);
        bounds.refuse(first);
        let second = bounds.next_bound(error).unwrap();
        assert!(first < second && second < error);
        // A smaller bound that ends with too many hulls changes nothing.
        bounds.refuse(0.01);
        assert_eq!(bounds.next_bound(error), Some(second));
    }
}
