//! What becomes of flat openings in a surface.

use std::fmt;
use std::str::FromStr;

use super::ParseError;

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

impl Openings {
    /// The name on the command line.
    ///
    /// ```
    /// assert_eq!(hullwright::Openings::Auto.name(), "auto");
    /// ```
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Keep => "keep",
            Self::Close => "close",
        }
    }
}

impl fmt::Display for Openings {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.name())
    }
}

impl FromStr for Openings {
    type Err = ParseError;

    fn from_str(text: &str) -> Result<Self, ParseError> {
        let all = [Self::Auto, Self::Keep, Self::Close];
        let found = all.into_iter().find(|value| value.name() == text);
        found.ok_or_else(|| ParseError::new(text, "auto, keep or close"))
    }
}

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

impl UpAxis {
    /// The name on the command line.
    ///
    /// ```
    /// assert_eq!(hullwright::UpAxis::Z.name(), "z");
    /// ```
    pub fn name(self) -> &'static str {
        match self {
            Self::Y => "y",
            Self::Z => "z",
        }
    }

    /// Its place in a point's coordinates.
    pub(crate) fn index(self) -> usize {
        match self {
            Self::Y => 1,
            Self::Z => 2,
        }
    }
}

impl fmt::Display for UpAxis {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.name())
    }
}

impl FromStr for UpAxis {
    type Err = ParseError;

    fn from_str(text: &str) -> Result<Self, ParseError> {
        let all = [Self::Y, Self::Z];
        let found = all.into_iter().find(|value| value.name() == text);
        found.ok_or_else(|| ParseError::new(text, "y or z"))
    }
}
