//! The bounded method: few hulls under a bound on the error that is verified against the source.
//!
//! The paper's groups are divided into patches. Patches are merged into pieces, and few pieces are
//! chosen that cover all patches. Their hulls are simplified, verified, and divided where they do
//! not keep the bound.
//!
//! | file | stage |
//! |---|---|
//! | `settings` | the bound, shares of it, and presets |
//! | `search` | what the stages share: solid, patches, settings, control |
//! | `clustering`, `vertex_clusters` | very dense meshes are searched through reduced ones |
//! | `containment/` | whether hulls stay within the bound of the solid |
//! | `patch_mesh` | the mesh that is divided: simplified, or cut into facets |
//! | `refine` | long triangles are halved, where the shape does not say where to cut |
//! | `facets`, `cuts` | coarse meshes are cut where their shape requires it |
//! | `patches`, `patch` | the surface is divided into patches |
//! | `growing_hull`, `joins`, `work` | no stages: hulls that grow, pairs that may join, and counted work |
//! | `merge` | patches join into pieces |
//! | `cover/` | few pieces cover all patches, then shrink to those that they own |
//! | `finalize/` | pieces become verified hulls with few vertices |
//! | `join_tree`, `witness` | hulls join beyond the bound, the pair that protrudes least first |
//! | `limit` | the cap on hulls: joins, and searches under larger bounds |
//! | `output` | results in the input's units |

mod clustering;
mod containment;
mod cover;
mod cuts;
mod facets;
mod finalize;
mod growing_hull;
pub(crate) mod join_tree;
mod joins;
mod limit;
mod merge;
pub(crate) mod output;
mod patch;
mod patch_mesh;
mod patches;
mod refine;
mod search;
mod settings;
mod vertex_clusters;
mod witness;
mod work;

use std::time::Duration;

use crate::clock::Instant;
use crate::control::{Control, Stage};
use crate::error::Error;
use crate::mesh::PreparedMesh;
use crate::parallel;
use crate::parameters::Parameters;
use clustering::cluster;
use containment::solid::Solid;
use cover::{Cover, cover};
use finalize::final_hull::FinalHulls;
use finalize::finalize;
use limit::{BoundSearch, limit_hulls};
use merge::merge;
use output::BoundedResult;
use patch::{Patches, Piece};
use patch_mesh::PatchMesh;
use patches::divide_into_patches;
use search::Search;
use settings::Settings;

/// Coordinates are rounded to 2^-38 diagonals. A mesh in other units, which differs in the last
/// bits, then breaks ties of symmetric shapes the same way.
const ROUNDING: f64 = (1_u64 << 38) as f64;

/// Shares of the work of one pass before its stages, by their usual times on meshes of 10,000
/// triangles. Repair comes first and takes the first share.
const PREPARE_AT: f32 = 0.1;
const PATCHES_AT: f32 = 0.3;
const MERGE_AT: f32 = 0.45;
const COVER_AT: f32 = 0.6;
const FINALIZE_AT: f32 = 0.9;

/// Before a deadline, as much time as the stages before merging have taken, times this, is kept for finalizing, which
/// takes 0.4 to 1 times as long.
const KEPT_FOR_FINALIZING: f64 = 1.0;

/// Where less time is left than preparing has taken, times this, the surface is divided as by the fastest preset.
const HURRIED_BELOW: f64 = 2.3;

/// The pipeline, stage by stage, for each of the preset's passes.
pub(crate) struct Run {
    prepared: PreparedMesh,
    /// One for each pass. Those under larger bounds, for the cap on hulls, are added as they come.
    settings: Vec<Settings>,
    /// The current pass: some presets divide the surface more than once.
    pass: usize,
    /// The fewest hulls so far; under the cap on hulls those with the least error.
    best: Option<Box<(Patches, FinalHulls)>>,
    /// Where the preset's passes ended with too many hulls.
    bound_search: Option<BoundSearch>,
    state: State,
    /// What the stages before merging have taken in the current pass.
    before_merging: Duration,
    /// Whether the search ended before it was done.
    is_cut_short: bool,
}

/// What the next step starts from.
enum State {
    /// The solid, if an earlier pass has built it.
    Prepare(Option<Box<Solid>>),
    Divide(Box<(Solid, PatchMesh)>),
    Merge(Box<(Solid, Patches)>),
    Cover(Box<(Solid, Patches, Vec<Piece>)>),
    Finalize(Box<(Solid, Patches, Cover)>),
    Done,
}

impl Run {
    pub(crate) fn new(mut prepared: PreparedMesh, parameters: &Parameters) -> Self {
        for coordinate in prepared.mesh.positions.as_flattened_mut() {
            *coordinate = (*coordinate * ROUNDING).round() / ROUNDING;
        }
        let settings = Settings::of_preset(parameters, prepared.normalization.diagonal);
        let state = State::Prepare(None);
        Self {
            prepared,
            settings,
            pass: 0,
            best: None,
            bound_search: None,
            state,
            before_merging: Duration::ZERO,
            is_cut_short: false,
        }
    }

    /// Whether the search ended before it was done, since a deadline was near.
    pub(crate) fn is_cut_short(&self) -> bool {
        self.is_cut_short
    }

    /// The stage of the next step, and the share of the work before it.
    pub(crate) fn stage(&self) -> (Stage, f32) {
        let (stage, share) = match self.state {
            State::Prepare(_) => (Stage::Simplify, PREPARE_AT),
            State::Divide(_) => (Stage::Patches, PATCHES_AT),
            State::Merge(_) => (Stage::Merge, MERGE_AT),
            State::Cover(_) => (Stage::SetCover, COVER_AT),
            State::Finalize(_) | State::Done => (Stage::Hulls, FINALIZE_AT),
        };
        match &self.bound_search {
            None => (stage, (self.pass as f32 + share) / self.settings.len() as f32),
            Some(search) => (stage, FINALIZE_AT + (1.0 - FINALIZE_AT) * search.progress(share)),
        }
    }

    /// Runs the next stage. `None` while there are more.
    ///
    /// # Errors
    /// [`Error::Cancelled`], [`Error::Simplification`], and [`Error::Finished`] after the result or
    /// an error.
    pub(crate) fn step(&mut self, control: &Control) -> Result<Option<BoundedResult>, Error> {
        match parallel::with(control.is_parallel(), || self.next(control)) {
            // A further pass ends at the deadline, wherever it is.
            Err(Error::DeadlineExceeded) if control.check().is_ok() => {
                let best = self.best.take().ok_or(Error::DeadlineExceeded)?;
                self.is_cut_short = true;
                Ok(Some(self.result(&best.0, &best.1)))
            }
            other => other,
        }
    }

    fn next(&mut self, control: &Control) -> Result<Option<BoundedResult>, Error> {
        let Some(settings) = self.settings.get_mut(self.pass) else { return Err(Error::Finished) };
        let unlimited = control;
        let limited =
            if self.best.is_some() { control.with_hard_deadline() } else { control.clone() };
        let control = &limited;
        control.check()?;
        self.state = match std::mem::replace(&mut self.state, State::Done) {
            State::Prepare(solid) => {
                let began = Instant::now();
                let state = prepare(&self.prepared, solid, settings, control)?;
                self.before_merging = began.elapsed();
                State::Divide(Box::new(state))
            }
            State::Divide(state) => {
                let (solid, patch_mesh) = *state;
                let began = Instant::now();
                let needed = self.before_merging.mul_f64(HURRIED_BELOW);
                if control.time_left().is_some_and(|left| left < needed) {
                    if self.best.is_some() {
                        return Err(Error::DeadlineExceeded);
                    }
                    *settings = settings.hurried();
                    self.is_cut_short = true;
                }
                let patches = divide_into_patches(patch_mesh, &solid, settings, control)?;
                self.before_merging += began.elapsed();
                State::Merge(Box::new((solid, patches)))
            }
            State::Merge(state) => {
                let (solid, patches) = *state;
                let pieces =
                    merge(&Search { solid: &solid, patches: &patches, settings, control })?;
                State::Cover(Box::new((solid, patches, pieces)))
            }
            State::Cover(state) => {
                let (solid, patches, pieces) = *state;
                let kept = self.before_merging.mul_f64(KEPT_FOR_FINALIZING);
                let until_cut = control.with_sooner_deadline(kept);
                let search =
                    Search { solid: &solid, patches: &patches, settings, control: &until_cut };
                let cover = cover(&search, pieces)?;
                self.is_cut_short |= until_cut.is_past_deadline();
                State::Finalize(Box::new((solid, patches, cover)))
            }
            State::Finalize(state) => {
                let (solid, patches, cover) = *state;
                let search = Search { solid: &solid, patches: &patches, settings, control };
                let hulls = finalize(&search, cover)?;
                return self.end_pass(solid, patches, hulls, unlimited);
            }
            State::Done => return Err(Error::Finished),
        };
        Ok(None)
    }

    /// Keeps the better result, and goes on to the next pass or returns.
    fn end_pass(
        &mut self,
        solid: Solid,
        patches: Patches,
        hulls: FinalHulls,
        control: &Control,
    ) -> Result<Option<BoundedResult>, Error> {
        if self.bound_search.is_some() {
            return self.end_pass_under_cap(&solid, patches, hulls, control);
        }
        let is_better =
            self.best.as_ref().is_none_or(|best| hulls.hulls.len() < best.1.hulls.len());
        if is_better {
            self.best = Some(Box::new((patches, hulls)));
        }
        if self.pass + 1 < self.settings.len() && !control.is_past_deadline() {
            self.pass += 1;
            self.state = State::Prepare(Some(Box::new(solid)));
            return Ok(None);
        }
        let Some(best) = self.best.take() else { return Err(Error::Finished) };
        let (patches, hulls) = *best;
        let settings = &self.settings[self.pass];
        if settings.max_hulls.is_some_and(|most| hulls.hulls.len() > most) {
            self.bound_search = Some(BoundSearch::new(settings.bound.protrusion()));
            return self.end_pass_under_cap(&solid, patches, hulls, control);
        }
        Ok(Some(self.result(&patches, &hulls)))
    }

    /// Joins hulls down to the cap, keeps the result with less error, and goes on to a pass under a
    /// larger bound or returns.
    fn end_pass_under_cap(
        &mut self,
        solid: &Solid,
        patches: Patches,
        mut hulls: FinalHulls,
        control: &Control,
    ) -> Result<Option<BoundedResult>, Error> {
        let settings = &self.settings[self.pass];
        let (Some(most), Some(search)) = (settings.max_hulls, &mut self.bound_search) else {
            return Err(Error::Finished);
        };
        if hulls.hulls.len() > most {
            search.refuse(settings.bound.protrusion());
            let search = Search { solid, patches: &patches, settings, control };
            hulls.hulls = limit_hulls(&search, &hulls.hulls, most)?;
        }
        if self.best.as_ref().is_none_or(|best| hulls.error() < best.1.error()) {
            self.best = Some(Box::new((patches, hulls)));
        }
        let Some(best) = self.best.take() else { return Err(Error::Finished) };
        if !control.is_past_deadline()
            && let Some(bound) = search.next_bound(best.1.error())
        {
            let settings = settings.with_bound(bound);
            self.settings.push(settings);
            self.pass = self.settings.len() - 1;
            self.best = Some(best);
            self.state = State::Prepare(None);
            return Ok(None);
        }
        Ok(Some(self.result(&best.0, &best.1)))
    }

    fn result(&mut self, patches: &Patches, hulls: &FinalHulls) -> BoundedResult {
        let prepared = std::mem::take(&mut self.prepared);
        BoundedResult::new(prepared, patches, hulls, self.settings[0].bound.protrusion())
    }
}

/// The solid, unless an earlier pass has built it, and the mesh that is to be divided.
fn prepare(
    prepared: &PreparedMesh,
    solid: Option<Box<Solid>>,
    settings: &Settings,
    control: &Control,
) -> Result<(Solid, PatchMesh), Error> {
    let clustered = match &solid {
        Some(solid) => solid.clustered.clone(),
        None => cluster(prepared, settings, control)?,
    };
    let (solid, patch_mesh) = parallel::join(
        || match solid {
            Some(solid) => Ok(*solid),
            None => Solid::new(prepared, clustered.clone(), settings, control),
        },
        || PatchMesh::new(prepared, clustered.as_deref(), settings, control),
    );
    Ok((solid?, patch_mesh?))
}
