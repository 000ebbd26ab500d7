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
