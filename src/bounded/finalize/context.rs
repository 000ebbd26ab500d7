//! What the stages of finalizing share.

use crate::bounded::patches::patch::Patches;
use crate::bounded::settings::Settings;
use crate::control::Control;
use crate::solid::Solid;

/// What final hulls are made from.
#[derive(Clone, Copy)]
pub(super) struct FinalizeContext<'a> {
    pub patches: &'a Patches,
    pub solid: &'a Solid,
    pub settings: &'a Settings,
    /// Volume that saving a vertex may add, in cubed diagonals.
    pub volume_per_vertex: f64,
    pub control: &'a Control,
}
