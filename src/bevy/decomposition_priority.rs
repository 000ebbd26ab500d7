//! Which entities go first whatever their distance.

use bevy::prelude::*;

/// When more wait than run, those with a higher priority go first, then those nearest to a
/// [`DecompositionFocus`](crate::bevy::DecompositionFocus). Beside the tag; without it 0.
///
/// ```
/// use bevy::prelude::*;
/// use hullwright::bevy::prelude::*;
///
/// # let mut world = World::new();
/// // What the player holds first, the crowd in the background last.
/// world.spawn((ConvexDecomposition::default(), DecompositionPriority(1)));
/// world.spawn((ConvexDecomposition::default(), DecompositionPriority(-1)));
/// ```
#[derive(Component, Reflect, Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[reflect(Component, Default, Clone, PartialEq)]
#[type_path = "hullwright"]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DecompositionPriority(pub i32);
