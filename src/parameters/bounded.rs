//! Parameters of the bounded method.

use std::fmt;
use std::str::FromStr;

use super::{Length, Openings, ParseError, UpAxis};
use crate::error::Error;

/// How much work the bounded method puts into few hulls. All keep the bound.
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

impl Preset {
    /// The preset's name on the command line.
    ///
    /// ```
    /// assert_eq!(hullwright::Preset::Balanced.name(), "balanced");
    /// ```
    pub fn name(self) -> &'static str {
        match self {
            Self::Fast => "fast",
            Self::Balanced => "balanced",
            Self::Fine => "fine",
        }
    }
}

impl fmt::Display for Preset {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.name())
    }
}

impl FromStr for Preset {
    type Err = ParseError;

    fn from_str(text: &str) -> Result<Self, ParseError> {
        let all = [Self::Fast, Self::Balanced, Self::Fine];
        let found = all.into_iter().find(|value| value.name() == text);
        found.ok_or_else(|| ParseError::new(text, "fast, balanced or fine"))
    }
}

/// Parameters of the bounded method.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
pub struct BoundedParameters {
    /// The bound: no point on the boundary of the hulls' union is farther than this outside the
    /// solid, and no point of the surface farther than this outside every hull. The solid is
    /// where the generalized winding number is above one half, and the surface itself. Triangles without
    /// area are no surface. Positive; less than 0.001 % of the diagonal counts as that, more than half as
    /// half. A flat sheet becomes a hull that is a thousandth of its own diagonal thick, also where that is
    /// more. Below 0.1 % it may take seconds. Default 2 % of the diagonal.
    pub max_error: Length,
    /// How much work is put into few hulls.
    pub preset: Preset,
    /// Most hulls, at least 1; `None` for no cap. A cap, not a budget: where the bound
    /// ends with more, hulls join or the search is repeated up to six times under larger bounds,
    /// whichever has less error, and
    /// [`BoundedReport::protrusion_max`](crate::BoundedReport::protrusion_max) says how far.
    pub max_hulls: Option<usize>,
    /// Whether cavities stay empty that can only be reached through mouths narrower than twice the
    /// bound, or not at all. Otherwise a hull may swallow them, since nothing from outside can
    /// tell. Those nowhere deeper than the bound always may fill. Default false.
    pub keep_cavities: bool,
    /// What becomes of flat openings, the sides that a modeller leaves out. Promises are about the mesh
    /// with those closed that are. Default [`Openings::Auto`].
    pub openings: Openings,
    /// Which axis points up, against gravity. Where faces are drawn from both sides, [`Openings::Auto`]
    /// closes openings in the lowest plane alone. Default [`UpAxis::Y`], as in glTF.
    pub up_axis: UpAxis,
}

/// What things may stand apart or sink in before a player sees it.
const DEFAULT_MAX_ERROR: Length = Length::Share(0.02);

impl BoundedParameters {
    pub(super) fn validate(&self) -> Result<(), Error> {
        if self.max_hulls == Some(0) {
            let reason = "must be at least 1".into();
            return Err(Error::InvalidParameter { name: "max_hulls", reason });
        }
        let error = self.max_error.value();
        if error.is_finite() && error > 0.0 {
            return Ok(());
        }
        let reason = format!("must be positive, not {error}");
        Err(Error::InvalidParameter { name: "max_error", reason })
    }
}

impl Default for BoundedParameters {
    fn default() -> Self {
        Self {
            max_error: DEFAULT_MAX_ERROR,
            preset: Preset::Balanced,
            max_hulls: None,
            keep_cavities: false,
            openings: Openings::Auto,
            up_axis: UpAxis::Y,
        }
    }
}
