//! Set cover: few pieces that together contain all patches.
//!
//! | file | contents |
//! |---|---|
//! | `coverage` | how many pieces cover each patch |
//! | `grow` | each piece takes the patches that it can |
//! | `redundancy` | pieces all of whose patches others cover are dropped |
//! | `dissolve` | pieces hand their patches to others and disappear |
//! | `assign_owners` | each patch stays with one piece |
//! | `fill` | pieces extend over what they have left hollow |

pub(super) mod assign_owners;
mod coverage;
mod dissolve;
mod fill;
mod grow;
mod redundancy;

use super::containment::fit_tester::FitTester;
use super::containment::solid::Solid;
use super::patches::patch::Patches;
use super::piece::Piece;
use super::settings::Settings;
use crate::control::Control;
use crate::error::Error;
use crate::parallel;
use assign_owners::assign_owners;
use dissolve::dissolve;
use fill::fill;
use grow::grow;
use redundancy::{area, drop_redundant};

/// Share of the first round's budget that the last round of dissolving may spend: more than nearly
/// all meshes need. Without a budget, a mesh of 464 hulls took ten times as long.
const LAST_ROUND_BUDGET: f64 = 0.1;

/// Few pieces that cover all patches.
pub(crate) struct SetCover {
    /// Each patch belongs to one of them.
    pub pieces: Vec<Piece>,
    /// The pieces before the last round of dissolving, if it dissolved any. They overlap.
    pub before_last_round: Option<Vec<Piece>>,
}

/// Covers all patches with fewer pieces.
///
/// # Errors
/// [`Error::Cancelled`].
pub(crate) fn cover(
    patches: &Patches,
    pieces: Vec<Piece>,
    solid: &Solid,
    settings: &Settings,
    control: &Control,
) -> Result<SetCover, Error> {
    if pieces.len() < 2 {
        return Ok(SetCover { pieces, before_last_round: None });
    }
    let mut pieces = grow_all(patches, pieces, solid, settings, control)?;
    drop_redundant(patches, &mut pieces);
    let budget = settings.dissolve_attempts;
    dissolve(patches, &mut pieces, solid, settings.bound.search(), budget, control)?;
    let before = pieces.clone();
    let budget = (LAST_ROUND_BUDGET * budget as f64) as usize;
    dissolve(patches, &mut pieces, solid, settings.bound.last_round(), budget, control)?;
    let before_last_round = (pieces.len() < before.len()).then_some(before);
    let mut owned = assign_owners(patches, &pieces, control)?;
    if solid.is_coarse() && solid.is_closed() {
        fill(&mut owned, &pieces, solid, settings.bound.search(), control)?;
    }
    Ok(SetCover { pieces: owned, before_last_round })
}

/// Pieces that have taken the patches that they can, those of the largest area first. One that others cover by
/// then is left out.
///
/// # Errors
/// [`Error::Cancelled`].
fn grow_all(
    patches: &Patches,
    mut pieces: Vec<Piece>,
    solid: &Solid,
    settings: &Settings,
    control: &Control,
) -> Result<Vec<Piece>, Error> {
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
