//! Finalizing: pieces become hulls with thickness and few vertices, each verified against the
//! source and divided where it does not keep the bound. A single triangle may not keep it where a
//! hull must be thicker than the bound: then the report says so.
//!
//! Takes a cover, gives the hulls of the result. Lengths are fractions of the diagonal.
//!
//! | file | contents |
//! |---|---|
//! | `hull_simplification` | vertices are saved |
//! | `final_hull` | the final hull of some patches, and what it owns |
//! | `division` | pieces whose hull does not keep the bound are halved |
//! | `remerge` | hulls join again |
//! | `fill` | hulls are extended over what they leave hollow |

mod division;
mod fill;
pub(crate) mod final_hull;
mod hull_simplification;
mod remerge;

use super::cover::Cover;
use super::cover::coverage::assign_owners;
use super::patch::Piece;
use super::search::Search;
use super::uncovered::{HullDistance, PointBuckets, distance_outside, uncovered_distance};
use crate::error::Error;
use crate::parallel;
use division::{PieceHulls, hulls_of_piece};
use final_hull::{FinalHull, FinalHulls};
use hull_simplification::FinalizeContext;
use remerge::remerge;

/// Volume that saving a vertex may add, as a share of the mean volume of all pieces.
const VOLUME_PER_VERTEX: f64 = 1.2e-3;

/// The cover before the last round of dissolving is tried too, where verification divides the last
/// one into this many times as many hulls.
const DOUBTFUL: f64 = 1.25;

/// The hulls of a cover. Of the cover before the last round of dissolving where that serves better:
/// verification may divide what the round has won, or the round may leave surface uncovered, which
/// counts more than hulls. `None` where there are so many that the search is given up.
pub(crate) fn finalize(
    search: &Search<'_>,
    Cover { pieces, overlapping, before_last_round }: Cover,
) -> Result<Option<FinalHulls>, Error> {
    let &Search { patches, settings, control, .. } = search;
    let Some(last) = VerifiedPieces::new(*search, &pieces)? else { return Ok(None) };
    let Some(before) = before_last_round else { return last.finished(&overlapping).map(Some) };
    let verified_before =
        || VerifiedPieces::new(*search, &assign_owners(patches, &before, control)?);
    if last.hulls.len() as f64 > DOUBTFUL * before.len() as f64 && !control.is_past_deadline() {
        let verified = verified_before()?;
        let verified = verified.filter(|before| before.hulls.len() <= last.hulls.len());
        let finished = match verified {
            Some(verified) => verified.finished(&before),
            None => last.finished(&overlapping),
        };
        return finished.map(Some);
    }
    let last = last.finished(&overlapping)?;
    let is_uncovered = last.uncovered > settings.bound.max_uncovered();
    if !is_uncovered || control.is_past_deadline() {
        return Ok(Some(last));
    }
    let verified = verified_before()?;
    let finished = verified.map(|verified| verified.finished(&before)).transpose()?;
    let finished = finished.filter(|before| before.uncovered < last.uncovered);
    Ok(Some(finished.unwrap_or(last)))
}

/// The hulls of pieces: see [`hulls_of_piece`].
struct VerifiedPieces<'a> {
    context: FinalizeContext<'a>,
    hulls: Vec<FinalHull>,
    is_divided: bool,
    /// See [`FinalHulls::without_vertex_limit`].
    without_vertex_limit: usize,
}

impl<'a> VerifiedPieces<'a> {
    /// `None` where there are so many that the search is given up.
    fn new(search: Search<'a>, pieces: &[Piece]) -> Result<Option<Self>, Error> {
        let settings = search.settings;
        if settings.gives_up(pieces.len()) {
            return Ok(None);
        }
        let volume =
            pieces.iter().map(|piece| piece.hull.volume).sum::<f64>() / pieces.len().max(1) as f64;
        let context = FinalizeContext { search, volume_per_vertex: VOLUME_PER_VERTEX * volume };
        let size = |piece: &Piece| piece.patches.count();
        let parts =
            parallel::map_largest_first(pieces, size, |piece| hulls_of_piece(&context, piece));
        let parts: Option<Result<Vec<PieceHulls>, Error>> =
            parts.into_iter().map(Result::transpose).collect();
        let Some(parts) = parts.transpose()? else { return Ok(None) };
        let is_divided = parts.iter().any(|part| part.hulls.len() > 1);
        let without_limit = |part: &PieceHulls| match part.fits_without_limit {
            true => 1,
            false => part.hulls.len(),
        };
        let without_vertex_limit = parts.iter().map(without_limit).sum();
        let hulls: Vec<FinalHull> = parts.into_iter().flat_map(|part| part.hulls).collect();
        let is_given_up = settings.gives_up(hulls.len());
        let made = Self { context, hulls, is_divided, without_vertex_limit };
        Ok((!is_given_up).then_some(made))
    }

    /// The same, remerged where they were divided, and filled, with how far the surface is outside
    /// all of them. `overlapping` are the pieces before they shrank.
    fn finished(self, overlapping: &[Piece]) -> Result<FinalHulls, Error> {
        let Self { context, mut hulls, is_divided, without_vertex_limit } = self;
        if is_divided {
            hulls = remerge(&context, hulls)?;
        }
        fill::fill(&context, &mut hulls, overlapping)?;
        let uncovered = uncovered(&context.search, &hulls)?;
        let without_vertex_limit = without_vertex_limit.min(hulls.len());
        Ok(FinalHulls { hulls, uncovered, without_vertex_limit })
    }
}

/// No point of the source is farther than this outside all hulls.
fn uncovered(search: &Search<'_>, hulls: &[FinalHull]) -> Result<f64, Error> {
    let &Search { patches, settings, control, exact, .. } = search;
    let allowed = settings.bound.max_uncovered();
    // The hull of each part of the coarse surface, and by that of each exact triangle.
    let mut hull_of_part = vec![u32::MAX; patches.surface.triangles.len()];
    for (index, hull) in (0..).zip(hulls) {
        hull.owned.triangles(patches).for_each(|part| hull_of_part[part as usize] = index);
    }
    let mut owned: Vec<Vec<u32>> = vec![Vec::new(); hulls.len()];
    let mut open: Vec<(u32, u32)> = Vec::new();
    for (triangle, &part) in (0..).zip(&patches.detail.owners) {
        let hull = hull_of_part[part as usize];
        match owned.get_mut(hull as usize) {
            Some(own) => own.push(triangle),
            None => open.push((triangle, hull)),
        }
    }
    let distances = parallel::map_indices(hulls.len(), |index| {
        let points = PointBuckets::new(&exact.mesh.positions_of(owned[index].iter().copied()));
        distance_outside(&hulls[index].hull, &points, allowed, control)
    });
    let mut uncovered: f64 = 0.0;
    for (index, distance) in distances.into_iter().enumerate() {
        match distance? {
            distance if distance <= allowed => uncovered = uncovered.max(distance),
            // Other hulls may contain what this one has left out.
            _ => open.extend(owned[index].iter().map(|&triangle| (triangle, index as u32))),
        }
    }
    if !open.is_empty() {
        let distances: Vec<HullDistance> =
            hulls.iter().map(|hull| HullDistance::new(&hull.hull)).collect();
        let tolerance = uncovered.max(settings.bound.tolerance());
        uncovered = uncovered_distance(&exact.mesh, &open, &distances, tolerance, control)?;
    }
    Ok(uncovered + exact.most_moved())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounded::fixture::{Fixture, cubes, l_prism};
    use crate::bounded::merge::merge;
    use crate::mesh::shapes::cuboid;
    use crate::parameters::Parameters;

    fn finalized(fixture: &Fixture, cover: Cover) -> Option<FinalHulls> {
        finalize(&fixture.search(), cover).unwrap()
    }

    fn cover(pieces: Vec<Piece>, before_last_round: Option<Vec<Piece>>) -> Cover {
        Cover { pieces, overlapping: Vec::new(), before_last_round }
    }

    fn all(fixture: &Fixture) -> Piece {
        fixture.piece(0..fixture.patches.count() as u32)
    }

    #[test]
    fn a_box_is_one_hull_that_leaves_nothing_uncovered() {
        let fixture = Fixture::new(&cuboid([0.0; 3], [1.0; 3]), 0.02);
        let found = finalized(&fixture, cover(vec![all(&fixture)], None)).unwrap();
        assert_eq!([found.hulls.len(), found.without_vertex_limit], [1, 1]);
        assert_eq!(found.hulls[0].hull.points.len(), 8);
        assert!(found.uncovered < 1e-9, "{}", found.uncovered);
    }

    #[test]
    fn all_hulls_of_a_prism_keep_the_bound_and_cover_the_surface() {
        let fixture = Fixture::new(&l_prism(), 0.02);
        let cover = cover(vec![all(&fixture)], None);
        let FinalHulls { hulls, uncovered, .. } = finalized(&fixture, cover).unwrap();
        assert_eq!(hulls.len(), 2);
        assert!(hulls.iter().all(|hull| hull.keeps_bound(&fixture.settings)));
        assert!(uncovered <= fixture.settings.bound.max_uncovered());
    }

    #[test]
    fn where_verification_divides_the_last_cover_the_one_before_it_is_taken() {
        let fixture = Fixture::new(&cubes([0.0, 2.0]), 0.02);
        // One piece over the gap, which is divided. What there was before shows by its number.
        let single = || fixture.piece([0]);
        let cover = |before: Vec<Piece>| cover(vec![all(&fixture)], Some(before));
        let before = vec![single()];
        let last = VerifiedPieces::new(fixture.search(), &[all(&fixture)]).unwrap().unwrap();
        assert!(last.hulls.len() as f64 > DOUBTFUL && last.is_divided);
        let found = finalized(&fixture, cover(before)).unwrap();
        assert_eq!(found.hulls.len(), 1);
        let found = finalized(&fixture, cover(vec![single(), fixture.piece([1])])).unwrap();
        assert_eq!(found.hulls.len(), 2);
    }

    #[test]
    fn a_last_round_that_leaves_surface_uncovered_gives_way_to_the_cover_before_it() {
        let fixture = Fixture::new(&cubes([0.0, 2.0]), 0.02);
        let before_last_round = Some(merge(&fixture.search()).unwrap());
        let cover = cover(vec![fixture.piece([0])], before_last_round);
        let found = finalized(&fixture, cover).unwrap();
        assert_eq!(found.hulls.len(), 2);
        assert!(found.uncovered < 1e-9, "{}", found.uncovered);
    }

    #[test]
    fn surface_that_no_hull_owns_is_as_far_outside_as_from_the_nearest_hull() {
        let fixture = Fixture::new(&cubes([0.0, 2.0]), 0.02);
        let mut hulls = fixture.hulls_of_patches();
        assert!(uncovered(&fixture.search(), &hulls).unwrap() < 1e-9);
        hulls.truncate(1);
        // The far side of the second cube.
        let expected = 2.0 / fixture.prepared.normalization.diagonal;
        let found = uncovered(&fixture.search(), &hulls).unwrap();
        assert!((found - expected).abs() < 0.05 * expected, "{found}");
    }

    #[test]
    fn a_search_for_the_limit_is_given_up_with_more_hulls_than_it_allows() {
        let mut fixture =
            Fixture::with(&cubes([0.0, 2.0]), &Parameters::default().with_max_hulls(1));
        let pieces = || [0, 1].map(|patch| fixture.piece([patch])).to_vec();
        assert_eq!(finalized(&fixture, cover(pieces(), None)).unwrap().hulls.len(), 2);
        let pieces = pieces();
        fixture.settings = fixture.settings.with_bound(0.02);
        assert!(finalized(&fixture, cover(pieces, None)).is_none());
    }
}
