//! What the stages of a search share.

use super::patch::Patches;
use super::settings::Settings;
use super::surfaces::{Solids, Surfaces};
use crate::control::Control;
use crate::mesh::simplification::Simplification;
use crate::solid::Solid;

/// The solid, the patches of its surface, and what they are searched under.
#[derive(Clone, Copy)]
pub(crate) struct Search<'a> {
    pub(crate) solid: &'a Solid,
    /// The exact surface, which is verified, and its solid.
    pub(crate) exact: &'a Simplification,
    pub(crate) exact_solid: &'a Solid,
    pub(crate) patches: &'a Patches,
    pub(crate) settings: &'a Settings,
    pub(crate) control: &'a Control,
}

impl<'a> Search<'a> {
    pub(crate) fn new(
        surfaces: &'a Surfaces,
        solids: &'a Solids,
        patches: &'a Patches,
        settings: &'a Settings,
        control: &'a Control,
    ) -> Self {
        let (solid, exact, exact_solid) = (&*solids.coarse, &*surfaces.exact, &*solids.exact);
        Self { solid, exact, exact_solid, patches, settings, control }
    }
}
