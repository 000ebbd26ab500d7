//! Which entities go first whatever their distance.

use bevy::prelude::*;

/// When more wait than run, those with a higher priority go first, then those nearest to a
/// [`DecompositionFocus`](crate::bevy::DecompositionFocus). Beside the tag; without it 0.
#[derive(Component, Reflect, Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[reflect(Component, Default, Clone, PartialEq)]
#[type_path = "hullwright"]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DecompositionPriority(pub i32);
