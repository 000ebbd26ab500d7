//! Parameters of the default method, their limits, defaults and text.

mod choices;
mod length;
mod text;

use std::fmt;
use std::str::FromStr;

use crate::error::Error;

pub use choices::{Openings, Preset, UpAxis};
pub use length::Length;
pub use text::ParseError;
pub(crate) use text::{Field, differing, items, limit_text, parse, parse_limit};

/// What [`decompose`](crate::decompose()) is asked for.
///
/// | parameter | raise it | lower it |
/// |---|---|---|
/// | [`max_error`](Self::max_error) | fewer hulls, less time | hulls follow the surface more closely |
/// | [`preset`](Self::preset) | `Fine`: some hulls fewer, three times the time | `Fast`: a fifth more hulls, two thirds of the time |
/// | [`max_hulls`](Self::max_hulls) | the bound is kept more often | fewer hulls, an error beyond the bound |
/// | [`max_vertices`](Self::max_vertices) | round hulls fit more closely | cheaper contacts |
///
/// Start from the default and set what differs:
///
/// ```
/// use hullwright::{Length, Parameters};
///
/// let parameters = Parameters::default().max_error(Length::share(0.01)).max_hulls(32);
/// assert_eq!(parameters.max_hulls, Some(32));
/// // As text they are the values that differ from the default, separated by spaces.
/// assert_eq!(parameters.to_string(), "max_error=1% max_hulls=32");
/// assert_eq!("max_error=1% max_hulls=32".parse(), Ok(parameters));
/// ```
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
pub struct Parameters {
    /// The bound: no point on the boundary of the hulls' union is farther than this outside the solid, and no
    /// point of the surface farther than this outside every hull.
    /// Unit: percent of the diagonal, or the mesh's own. Limits: above 0. Default: 2 %.
    ///
    /// The solid is where the generalized winding number is above one half, and the surface itself. Triangles
    /// without area are no surface. Less than 0.001 % of the diagonal counts as that, more than half as half.
    /// A flat sheet becomes a hull that is a thousandth of its own diagonal thick, even where that is more than
    /// the bound. Below 0.1 % a decomposition may take seconds.
    pub max_error: Length,
    /// How much time the search for few hulls takes. Default: `Balanced`.
    pub preset: Preset,
    /// The largest number of hulls; `None` for no limit. Limits: at least 1. Default: `None`.
    ///
    /// A limit, not a target. Where the bound needs more, hulls are joined beyond it, or the search is
    /// repeated up to six times under larger bounds, whichever has less error;
    /// [`Report::protrusion_max`](crate::Report::protrusion_max) says how much.
    pub max_hulls: Option<usize>,
    /// The largest number of vertices of a hull; `None` for no limit. Limits: at least 8. Default: 64.
    ///
    /// A hull with more is replaced by one that contains it and little more or, where the bound forbids that,
    /// by one that leaves out what protrudes least, or by several;
    /// [`HullErrors::simplification_growth`](crate::HullErrors::simplification_growth) says by how much it
    /// grew.
    pub max_vertices: Option<usize>,
    /// Whether cavities stay empty that can only be reached through mouths narrower than twice the bound, or
    /// not at all. Default: `false`.
    ///
    /// Otherwise a hull may fill them: nothing outside can get there. Those nowhere deeper than the bound may
    /// always be filled.
    pub keep_cavities: bool,
    /// What becomes of flat openings, the sides that a modeller leaves out. Default: `Auto`.
    ///
    /// Promises are about the mesh after that.
    pub openings: Openings,
    /// Which axis points up, against gravity. Default: `Y`, as in glTF.
    ///
    /// Where faces are drawn from both sides, [`Openings::Auto`] closes openings in the lowest plane alone.
    pub up_axis: UpAxis,
}

/// The largest gap or overlap that players will not notice.
const DEFAULT_MAX_ERROR: Length = Length::Share(0.02);

/// A physics engine's cost grows with the vertices of a hull, and 64 still follow a round shape.
pub(crate) const DEFAULT_MAX_VERTICES: usize = 64;

/// With fewer vertices not even a box would do.
const LEAST_MAX_VERTICES: usize = 8;

impl Default for Parameters {
    fn default() -> Self {
        Self {
            max_error: DEFAULT_MAX_ERROR,
            preset: Preset::Balanced,
            max_hulls: None,
            max_vertices: Some(DEFAULT_MAX_VERTICES),
            keep_cavities: false,
            openings: Openings::Auto,
            up_axis: UpAxis::Y,
        }
    }
}

impl Parameters {
    /// Sets [`max_error`](Self::max_error).
    #[must_use]
    pub fn max_error(mut self, max_error: Length) -> Self {
        self.max_error = max_error;
        self
    }

    /// Sets [`preset`](Self::preset).
    #[must_use]
    pub fn preset(mut self, preset: Preset) -> Self {
        self.preset = preset;
        self
    }

    /// Sets [`max_hulls`](Self::max_hulls): a number or `None`.
    #[must_use]
    pub fn max_hulls(mut self, max_hulls: impl Into<Option<usize>>) -> Self {
        self.max_hulls = max_hulls.into();
        self
    }

    /// Sets [`max_vertices`](Self::max_vertices): a number or `None`.
    #[must_use]
    pub fn max_vertices(mut self, max_vertices: impl Into<Option<usize>>) -> Self {
        self.max_vertices = max_vertices.into();
        self
    }

    /// Sets [`keep_cavities`](Self::keep_cavities).
    #[must_use]
    pub fn keep_cavities(mut self, keep_cavities: bool) -> Self {
        self.keep_cavities = keep_cavities;
        self
    }

    /// Sets [`openings`](Self::openings).
    #[must_use]
    pub fn openings(mut self, openings: Openings) -> Self {
        self.openings = openings;
        self
    }

    /// Sets [`up_axis`](Self::up_axis).
    #[must_use]
    pub fn up_axis(mut self, up_axis: UpAxis) -> Self {
        self.up_axis = up_axis;
        self
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] names the first field that is out of its limits.
    pub fn validate(&self) -> Result<(), Error> {
        check_max_vertices(self.max_vertices)?;
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

    pub(crate) const KEYS: &'static str =
        "max_error, preset, max_hulls, max_vertices, keep_cavities, openings, up_axis";

    /// Every field as text.
    pub(crate) fn fields(&self) -> [Field; 7] {
        [
            ("max_error", self.max_error.to_string()),
            ("preset", self.preset.to_string()),
            ("max_hulls", limit_text(self.max_hulls)),
            ("max_vertices", limit_text(self.max_vertices)),
            ("keep_cavities", self.keep_cavities.to_string()),
            ("openings", self.openings.to_string()),
            ("up_axis", self.up_axis.to_string()),
        ]
    }

    /// Sets a field from text. Whether there is one of that name.
    pub(crate) fn set(&mut self, key: &str, value: &str) -> Result<bool, ParseError> {
        match key {
            "max_error" => self.max_error = value.parse()?,
            "preset" => self.preset = value.parse()?,
            "max_hulls" => self.max_hulls = parse_limit(value)?,
            "max_vertices" => self.max_vertices = parse_limit(value)?,
            "keep_cavities" => self.keep_cavities = parse(value, "true or false")?,
            "openings" => self.openings = value.parse()?,
            "up_axis" => self.up_axis = value.parse()?,
            _ => return Ok(false),
        }
        Ok(true)
    }
}

/// The check of `max_vertices`, which all methods have.
pub(crate) fn check_max_vertices(max_vertices: Option<usize>) -> Result<(), Error> {
    match max_vertices {
        Some(limit) if limit < LEAST_MAX_VERTICES => Err(Error::InvalidParameter {
            name: "max_vertices",
            reason: format!("must be at least {LEAST_MAX_VERTICES}, not {limit}"),
        }),
        _ => Ok(()),
    }
}

impl fmt::Display for Parameters {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&differing(&self.fields(), &Self::default().fields()))
    }
}

impl FromStr for Parameters {
    type Err = ParseError;

    /// Reads what [`Display`](fmt::Display) writes, on top of the defaults. The values are not
    /// checked: see [`validate`](Self::validate).
    fn from_str(text: &str) -> Result<Self, ParseError> {
        let mut parameters = Self::default();
        for item in items(text) {
            let (key, value) = item?;
            if !parameters.set(key, value)? {
                return Err(ParseError::unknown_key(key, Self::KEYS));
            }
        }
        Ok(parameters)
    }
}
