//! What users say of entities, and what they are told.

pub(crate) mod components;
pub(crate) mod decomposition_priority;
pub(crate) mod describe;
pub(crate) mod error;
pub(crate) mod events;
pub(crate) mod outcomes;
pub(crate) mod parameters;
pub(crate) mod settings;
pub(crate) mod status;
