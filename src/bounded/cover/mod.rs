//! Cover: few pieces that together contain all patches.
//!
//! Takes the pieces of merging, gives fewer of them, each patch with one owner. A set cover by local search.
//!
//! | file | contents |
//! |---|---|
//! | `grow` | each piece takes the patches that fit |
//! | `coverage` | pieces that others cover are dropped; each patch stays with one piece |
//! | `dissolve` | pieces leave their patches to others and disappear |
//! | `fill` | pieces extend over what they have left hollow |

pub(super) mod coverage;
mod dissolve;
mod fill;
mod grow;

use super::patch::Piece;
use super::search::Search;
use crate::error::Error;
use crate::parallel;
use crate::solid::FitTester;
use coverage::{area, assign_owners, drop_redundant};
use dissolve::dissolve;
use fill::fill;
use grow::grow;

/// Share of the first round's budget that the last round of dissolving may spend: more than nearly
/// all meshes need. Without a budget, a mesh of 464 hulls took ten times as long.
const LAST_ROUND_BUDGET: f64 = 0.1;

/// Few pieces that cover all patches.
pub(crate) struct Cover {
    /// Each patch belongs to one of them.
    pub pieces: Vec<Piece>,
    /// The pieces before the last round of dissolving, if it dissolved any. They overlap.
    pub before_last_round: Option<Vec<Piece>>,
}

/// Covers all patches with fewer pieces.
pub(crate) fn cover(search: &Search<'_>, pieces: Vec<Piece>) -> Result<Cover, Error> {
    if pieces.len() < 2 {
        return Ok(Cover { pieces, before_last_round: None });
    }
    let &Search { solid, patches, settings, control } = search;
    let mut pieces = grow_all(search, pieces)?;
    drop_redundant(patches, &mut pieces);
    let budget = settings.dissolve_attempts;
    dissolve(search, &mut pieces, settings.bound.search(), budget)?;
    let before = pieces.clone();
    let budget = (LAST_ROUND_BUDGET * budget as f64) as usize;
    dissolve(search, &mut pieces, settings.bound.last_round(), budget)?;
    let before_last_round = (pieces.len() < before.len()).then_some(before);
    let mut owned = assign_owners(patches, &pieces, control)?;
    if solid.is_coarse() && solid.is_closed() {
        fill(&mut owned, &pieces, search)?;
    }
    Ok(Cover { pieces: owned, before_last_round })
}

/// Pieces that have taken the patches that fit, those of the largest area first. One that others cover by
/// then is left out.
fn grow_all(search: &Search<'_>, mut pieces: Vec<Piece>) -> Result<Vec<Piece>, Error> {
    let &Search { solid, patches, settings, control } = search;
    let all = patches.all();
    let grow_one = |piece: &Piece| {
        control.check()?;
        let mut piece = piece.clone();
        if !control.is_past_deadline() {
            let mut tester = FitTester::new(solid, settings.bound.search());
            grow(patches, &mut piece, &all, &mut tester, control)?;
        }
        Ok(piece)
    };
    pieces.sort_by(|a, b| area(patches, &b.patches).total_cmp(&area(patches, &a.patches)));
    let covered = parallel::fold_ahead(
        &pieces,
        (all.clone(), Vec::new()),
        |(open, _), piece| piece.patches.intersects(open),
        grow_one,
        |(open, grown), piece| {
            open.difference_with(&piece.patches);
            grown.push(piece);
        },
    );
    covered.map(|(_, grown)| grown)
}
