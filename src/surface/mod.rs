//! The paper's surface-based method, section 3, one stage per file.

pub(crate) mod cost;
pub(crate) mod decompose;
pub(crate) mod group_merging;
mod group_planes;
pub(crate) mod grouping;
pub(crate) mod pieces;
pub(crate) mod resolution_selection;
pub(crate) mod threshold_selection;
