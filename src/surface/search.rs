//! Section 3.5: all thresholds at all resolutions, in slices.

use super::resolution_selection::{Level, first_cut_off};
use crate::control::Control;
use crate::error::Error;
use crate::mesh::PreparedMesh;
use crate::parameters::SurfaceParameters;

/// The resolutions, and how far each has got.
pub(crate) struct Search {
    pub prepared: PreparedMesh,
    pub levels: Vec<Level>,
    /// The length that counts as 1 for the thresholds, in diagonals.
    pub unit: f64,
}

impl Search {
    /// Tries the next threshold, or all that are left in parallel. Whether all is done.
    pub fn advance(
        &mut self,
        surface: &SurfaceParameters,
        control: &Control,
    ) -> Result<bool, Error> {
        #[cfg(feature = "parallel")]
        if control.is_parallel() && rayon::current_num_threads() > 1 {
            use rayon::prelude::*;
            let unit = self.unit;
            let past = || control.is_past_deadline();
            self.levels.par_iter_mut().try_for_each(|level| {
                while !level.is_finished() && !past() {
                    level.advance(surface, unit, control)?;
                }
                Ok(())
            })?;
            return Ok(self.levels.iter().all(Level::is_finished));
        }
        // A level that is cut off has no more to do, nor have those above it.
        let cut_off = first_cut_off(&self.levels, surface.resolution_cut_off)
            .map_or(self.levels.len(), |index| index + 1);
        match self.levels[..cut_off].iter_mut().find(|level| !level.is_finished()) {
            Some(level) => {
                level.advance(surface, self.unit, control)?;
                Ok(false)
            }
            None => Ok(true),
        }
    }

    /// Whether any threshold gave a grouping.
    pub fn has_candidate(&self) -> bool {
        self.levels.iter().any(|level| level.search.candidate().is_some())
    }

    /// The share of the thresholds that were tried.
    pub fn share_done(&self, surface: &SurfaceParameters) -> f32 {
        let all = self.levels.len() * surface.planar_thresholds.len();
        let done: usize = self.levels.iter().map(|level| level.search.reports.len()).sum();
        done as f32 / all.max(1) as f32
    }
}
