//! Parameters that are one of a few names.

use super::text::named;

/// How much time the search for few hulls takes. All presets keep the bound.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Preset {
    /// Coarser patches and no dissolving: about a fifth more hulls in two thirds of the time. More of a solid
    /// may stay empty inside.
    Fast,
    /// Few hulls: tens of milliseconds for most props, tenths of a second for most scans.
    #[default]
    Balanced,
    /// Three divisions of the surface are tried, and the one with the fewest hulls is taken: some
    /// hulls fewer, in about three times the time.
    Fine,
}

named!(Preset: Fast = "fast", Balanced = "balanced", Fine = "fine"; "fast, balanced or fine");

/// What becomes of the openings of a mesh: the sides that a modeller leaves out since nobody sees them.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Openings {
    /// A flat opening is closed where only the backs of faces are seen through it: there the surface
    /// is the skin of a solid. Containers, rooms and sheets stay as they are.
    #[default]
    Auto,
    /// All stay open. What encloses nothing is a shell.
    Keep,
    /// Every flat opening is closed, whatever is seen through it.
    Close,
}

named!(Openings: Auto = "auto", Keep = "keep", Close = "close"; "auto, keep or close");

/// Which axis of the mesh's coordinates points up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum UpAxis {
    /// The second coordinate: in glTF, Bevy and most engines.
    #[default]
    Y,
    /// The third: in Blender, robotics and CAD.
    Z,
}

named!(UpAxis: Y = "y", Z = "z"; "y or z");

impl UpAxis {
    /// Its place in a point's coordinates.
    pub(crate) fn index(self) -> usize {
        match self {
            Self::Y => 1,
            Self::Z => 2,
        }
    }
}
