//! Parameters of the default method, their limits, defaults and text.

#[cfg(feature = "bevy_reflect")]
use bevy_reflect::prelude::ReflectDefault;
use std::fmt;
use std::str::FromStr;

use crate::error::Error;

/// What the default method, [`decompose`](crate::decompose()), promises and how long it searches.
///
/// | parameter | raise it | lower it |
/// |---|---|---|
/// | [`max_error`](Self::max_error) | fewer hulls, less time | hulls follow the surface more closely |
/// | [`preset`](Self::preset) | `Fine`: some hulls fewer, three times the time | `Fast`: a fifth more hulls, two thirds of the time |
/// | [`max_hulls`](Self::max_hulls) | the bound is kept more often | fewer hulls, an error beyond the bound |
/// | [`max_vertices`](Self::max_vertices) | round hulls fit more closely | cheaper contacts |
/// | [`probe_radius`](Self::probe_radius) | fewer hulls: wider gaps fill | gaps stay open for thinner bodies |
///
/// Start from the default and set what differs:
///
/// ```
/// use hullwright::{Length, Parameters};
///
/// let parameters = Parameters::default().with_max_error(Length::share(0.01)).with_max_hulls(32);
/// assert_eq!(parameters.max_hulls, Some(32));
/// // As text they are the values that differ from the default, separated by spaces.
/// assert_eq!(parameters.to_string(), "max_error=1% max_hulls=32");
/// assert_eq!("max_error=1% max_hulls=32".parse(), Ok(parameters));
/// ```
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
pub struct Parameters {
    /// The bound: no point on the boundary of the hulls' union is farther than this outside the
    /// solid, and no point of the surface farther than this outside every hull. Unit: percent of
    /// the diagonal, or the mesh's own. Limits: above 0. Default: 2 %.
    ///
    /// The solid is where the generalized winding number is above one half, and the surface itself.
    /// Triangles without area are no surface. Less than 0.001 % of the diagonal counts as that,
    /// more than half as half. A flat sheet becomes a hull that is a thousandth of its own diagonal
    /// thick, even where that is more than the bound. Below 0.1 % a decomposition may take seconds.
    pub max_error: Length,
    /// How much time the search for few hulls takes. Default: `Balanced`.
    pub preset: Preset,
    /// The largest number of hulls; `None` for no limit. Limits: at least 1. Default: `None`.
    ///
    /// A limit, not a target. Where the bound needs more, hulls are joined beyond it, or the search
    /// is repeated up to four times under larger bounds, whichever has less error;
    /// [`Report::protrusion_max`](crate::Report::protrusion_max) says how much.
    pub max_hulls: Option<usize>,
    /// The largest number of vertices of a hull; `None` for no limit. Limits: at least 8. Default:
    /// 64.
    ///
    /// A hull with more is replaced by one that contains it and little more or, where the bound
    /// forbids that, by one that leaves out what protrudes least, or by several;
    /// [`HullErrors::simplification_growth`](crate::HullErrors::simplification_growth) says by how
    /// much it grew.
    pub max_vertices: Option<usize>,
    /// Whether cavities stay empty that can only be reached through mouths narrower than twice the
    /// bound, or not at all. Default: `false`.
    ///
    /// Otherwise a hull may fill them: nothing outside can get there. Those nowhere deeper than the
    /// bound may always be filled.
    pub keep_cavities: bool,
    /// What becomes of flat openings, the sides that a modeller leaves out. Default: `Auto`.
    ///
    /// Promises are about the mesh after that.
    pub openings: Openings,
    /// Which axis points up, against gravity. Default: `Y`, as in glTF.
    ///
    /// Where faces are drawn from both sides, [`Openings::Auto`] closes openings in the lowest
    /// plane alone.
    pub up_axis: UpAxis,
    /// The radius of the smallest ball that may meet the hulls: half the thickness of the thinnest
    /// thing that moves; `None` where nothing is known of that. Unit: percent of the diagonal, or
    /// the mesh's own. Limits: above 0. Default: `None`.
    ///
    /// Hulls may fill what no such ball can reach: no ball that comes from outside without touching
    /// the mesh is entered by a hull by more than [`max_error`](Self::max_error). Protrusion is
    /// then how far balls are entered, or the distance from the solid where that is less; a ball
    /// that is entered by more than half its radius does not count. The uncovered distance stays
    /// that from the mesh. `docs/probe.md` in the repository says which radius when. Not together
    /// with `keep_cavities`.
    pub probe_radius: Option<Length>,
    /// Where the probe starts beside the outside, in the mesh's coordinates: points of closed rooms
    /// that stay open. Limits: farther than the radius from the mesh, and outside the solid; only
    /// with `probe_radius`. Default: none.
    pub probe_from: Vec<[f64; 3]>,
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
            probe_radius: None,
            probe_from: Vec::new(),
        }
    }
}

/// The setters of fields, by which parameters are written as one expression.
macro_rules! setters {
    ($($setter:ident($field:ident: $type:ty);)+) => {
        impl Parameters {
            $(
                #[doc = concat!("Sets [`", stringify!($field), "`](Self::", stringify!($field), ").")]
                #[must_use]
                pub fn $setter(mut self, $field: $type) -> Self {
                    self.$field = $field.into();
                    self
                }
            )+
        }
    };
}

setters! {
    with_max_error(max_error: Length);
    with_preset(preset: Preset);
    with_max_hulls(max_hulls: impl Into<Option<usize>>);
    with_max_vertices(max_vertices: impl Into<Option<usize>>);
    with_keep_cavities(keep_cavities: bool);
    with_openings(openings: Openings);
    with_up_axis(up_axis: UpAxis);
    with_probe_radius(probe_radius: impl Into<Option<Length>>);
    with_probe_from(probe_from: impl Into<Vec<[f64; 3]>>);
}

impl Parameters {
    /// Checks every value.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] names the first field that is out of its limits.
    pub fn validate(&self) -> Result<(), Error> {
        check_max_vertices(self.max_vertices)?;
        if self.max_hulls == Some(0) {
            return Err(Error::parameter("max_hulls", "must be at least 1"));
        }
        check_positive("max_error", self.max_error.value())?;
        self.validate_probe()
    }

    fn validate_probe(&self) -> Result<(), Error> {
        let Some(radius) = self.probe_radius else {
            return match self.probe_from.is_empty() {
                true => Ok(()),
                false => Err(Error::parameter("probe_from", "needs a probe_radius")),
            };
        };
        check_positive("probe_radius", radius.value())?;
        if self.keep_cavities {
            let reason = "fills what nothing can reach, and keep_cavities forbids that";
            return Err(Error::parameter("probe_radius", reason));
        }
        let is_finite = |point: &[f64; 3]| point.iter().all(|x| x.is_finite());
        match self.probe_from.iter().position(|point| !is_finite(point)) {
            None => Ok(()),
            Some(index) => {
                Err(Error::parameter("probe_from", format!("point {index} is not finite")))
            }
        }
    }

    pub(crate) const KEYS: &'static str = "max_error, preset, max_hulls, max_vertices, keep_cavities, \
                                           openings, up_axis, probe_radius, probe_from";

    /// Every field as text.
    pub(crate) fn fields(&self) -> [Field; 9] {
        [
            ("max_error", self.max_error.to_string()),
            ("preset", self.preset.to_string()),
            ("max_hulls", limit_text(self.max_hulls)),
            ("max_vertices", limit_text(self.max_vertices)),
            ("keep_cavities", self.keep_cavities.to_string()),
            ("openings", self.openings.to_string()),
            ("up_axis", self.up_axis.to_string()),
            ("probe_radius", self.probe_radius.map_or(NONE.into(), |radius| radius.to_string())),
            ("probe_from", points_text(&self.probe_from)),
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
            "probe_radius" if value == NONE => self.probe_radius = None,
            "probe_radius" => self.probe_radius = Some(value.parse()?),
            "probe_from" => self.probe_from = parse_points(value)?,
            _ => return Ok(false),
        }
        Ok(true)
    }
}

/// The check of `max_vertices`, which all methods have.
pub(crate) fn check_max_vertices(max_vertices: Option<usize>) -> Result<(), Error> {
    match max_vertices {
        Some(limit) if limit < LEAST_MAX_VERTICES => {
            let reason = format!("must be at least {LEAST_MAX_VERTICES}, not {limit}");
            Err(Error::parameter("max_vertices", reason))
        }
        _ => Ok(()),
    }
}

/// An error for a parameter that is not a positive number.
pub(crate) fn check_positive(name: &'static str, value: f64) -> Result<(), Error> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    Err(Error::parameter(name, format!("must be positive, not {value}")))
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

/// A length: a fraction of the mesh's bounding-box diagonal, or in its own units.
///
/// As text it is `2%` or `0.02m`; the `m` stands for the mesh's units, also where
/// those are millimetres.
///
/// ```
/// use hullwright::Length;
///
/// assert_eq!("2%".parse(), Ok(Length::share(0.02)));
/// assert_eq!(Length::units(0.02).to_string(), "0.02m");
/// assert_eq!(Length::share(0.02).of_diagonal(5.0), 0.1);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Length {
    /// As a fraction of the bounding-box diagonal.
    Share(f64),
    /// In the mesh's units.
    Units(f64),
}

impl Length {
    /// A fraction of the bounding-box diagonal: 0.02 for 2 %.
    pub const fn share(share: f64) -> Self {
        Self::Share(share)
    }

    /// A length in the mesh's units.
    pub const fn units(length: f64) -> Self {
        Self::Units(length)
    }

    /// The same length in units, for a mesh with this `diagonal`.
    pub fn of_diagonal(self, diagonal: f64) -> f64 {
        match self {
            Self::Share(share) => share * diagonal,
            Self::Units(length) => length,
        }
    }

    /// The number alone.
    pub(crate) fn value(self) -> f64 {
        let (Self::Share(value) | Self::Units(value)) = self;
        value
    }
}

impl fmt::Display for Length {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Share(share) => write!(formatter, "{}%", shifted(&format!("{share:e}"), 2)),
            Self::Units(length) => write!(formatter, "{length}m"),
        }
    }
}

impl FromStr for Length {
    type Err = ParseError;

    fn from_str(text: &str) -> Result<Self, ParseError> {
        let expected = "a percentage of the diagonal (2%) or a length in the mesh's units (0.02m)";
        let wrong = || ParseError::new(text, expected);
        if let Some(percent) = text.strip_suffix('%') {
            let percent: f64 = percent.trim().parse().map_err(|_| wrong())?;
            return Ok(Self::Share(shifted(&format!("{percent:e}"), -2)));
        }
        let length = text.strip_suffix('m').ok_or_else(wrong)?;
        Ok(Self::Units(length.trim().parse().map_err(|_| wrong())?))
    }
}

/// A number in scientific notation times a power of ten, rounded once: a product in binary would
/// turn 0.55 % into 0.0055000000000000005.
fn shifted(number: &str, places: i32) -> f64 {
    let parts = number.split_once('e').and_then(|(digits, exponent)| {
        let exponent: i32 = exponent.parse().ok()?;
        format!("{digits}e{}", exponent + places).parse().ok()
    });
    parts.unwrap_or(f64::NAN)
}

/// The names of an enum's variants on the command line and in texts.
macro_rules! named {
    ($type:ident: $($variant:ident = $name:literal),+; $expected:literal) => {
        impl $type {
            /// The name on the command line.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)+
                }
            }
        }

        impl fmt::Display for $type {
            fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str(self.name())
            }
        }

        impl FromStr for $type {
            type Err = ParseError;

            fn from_str(text: &str) -> Result<Self, Self::Err> {
                match text {
                    $($name => Ok(Self::$variant),)+
                    _ => Err(ParseError::new(text, $expected)),
                }
            }
        }
    };
}

/// How much time the search for few hulls takes. All presets keep the bound.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(bevy_reflect::Reflect),
    reflect(Default, Clone, PartialEq)
)]
#[cfg_attr(feature = "bevy_reflect", type_path = "hullwright", type_name = "DecompositionPreset")]
pub enum Preset {
    /// Coarser patches and no dissolving: about a fifth more hulls in two thirds of the time. More
    /// of a solid may stay empty inside.
    #[cfg_attr(feature = "serde", serde(alias = "Fast"))]
    Fast,
    /// Few hulls: tens of milliseconds for most props, tenths of a second for most scans.
    #[cfg_attr(feature = "serde", serde(alias = "Balanced"))]
    #[default]
    Balanced,
    /// Three divisions of the surface are tried, and the one with the fewest hulls is taken: some
    /// hulls fewer, in about three times the time.
    #[cfg_attr(feature = "serde", serde(alias = "Fine"))]
    Fine,
}

named!(Preset: Fast = "fast", Balanced = "balanced", Fine = "fine"; "fast, balanced or fine");

/// What becomes of the openings of a mesh: the sides that a modeller leaves out since they are
/// never seen.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(bevy_reflect::Reflect),
    reflect(Default, Clone, PartialEq)
)]
#[cfg_attr(feature = "bevy_reflect", type_path = "hullwright", type_name = "DecompositionOpenings")]
pub enum Openings {
    /// A flat opening is closed where only the backs of faces are seen through it: there the
    /// surface is the skin of a solid. Containers, rooms and sheets stay as they are.
    #[cfg_attr(feature = "serde", serde(alias = "Auto"))]
    #[default]
    Auto,
    /// All stay open. What encloses nothing is a shell.
    #[cfg_attr(feature = "serde", serde(alias = "Keep"))]
    Keep,
    /// Every flat opening is closed, whatever is seen through it.
    #[cfg_attr(feature = "serde", serde(alias = "Close"))]
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

// As text, parameters are `key=value`, separated by spaces, in the names of the fields.

/// A text that is no value.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{text}`: {expected} is expected")]
pub struct ParseError {
    text: String,
    expected: String,
}

impl ParseError {
    pub(crate) fn new(text: &str, expected: impl Into<String>) -> Self {
        Self { text: text.into(), expected: expected.into() }
    }

    /// A key that is none of `keys`.
    pub(crate) fn unknown_key(key: &str, keys: &str) -> Self {
        Self::new(key, format!("one of {keys}"))
    }
}

/// The text of a limit that is not set.
pub(crate) const NONE: &str = "none";

/// Points as `x,y,z`, separated by semicolons.
fn points_text(points: &[[f64; 3]]) -> String {
    if points.is_empty() {
        return NONE.into();
    }
    let texts: Vec<String> = points.iter().map(|[x, y, z]| format!("{x},{y},{z}")).collect();
    texts.join(";")
}

fn parse_points(text: &str) -> Result<Vec<[f64; 3]>, ParseError> {
    let wrong = || ParseError::new(text, "points as x,y,z;x,y,z or none");
    let point = |text: &str| {
        let numbers: Result<Vec<f64>, _> = text.split(',').map(str::parse).collect();
        numbers.ok().and_then(|numbers| numbers.try_into().ok()).ok_or_else(wrong)
    };
    if text == NONE { Ok(Vec::new()) } else { text.split(';').map(point).collect() }
}

/// A key and its value.
pub(crate) type Field = (&'static str, String);

/// Those of `own` that differ from `default`, which has the same keys.
pub(crate) fn differing(own: &[Field], default: &[Field]) -> String {
    let differing = own.iter().zip(default).filter(|(own, default)| own.1 != default.1);
    let texts: Vec<String> = differing.map(|((key, value), _)| format!("{key}={value}")).collect();
    texts.join(" ")
}

/// The keys and values of a text.
pub(crate) fn items(text: &str) -> impl Iterator<Item = Result<(&str, &str), ParseError>> {
    text.split_whitespace()
        .map(|item| item.split_once('=').ok_or_else(|| ParseError::new(item, "key=value")))
}

pub(crate) fn parse<T: FromStr>(text: &str, expected: &str) -> Result<T, ParseError> {
    text.parse().map_err(|_| ParseError::new(text, expected))
}

/// A limit: a whole number, or `none`.
pub(crate) fn parse_limit(text: &str) -> Result<Option<usize>, ParseError> {
    if text == NONE { Ok(None) } else { parse(text, "a whole number or none").map(Some) }
}

pub(crate) fn limit_text(limit: Option<usize>) -> String {
    limit.map_or(NONE.into(), |limit| limit.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_goes_both_ways() {
        for length in [Length::share(0.02), Length::share(0.0055), Length::units(1e-3)] {
            assert_eq!(length.to_string().parse(), Ok(length), "{length}");
        }
        assert_eq!(Length::share(0.0055).to_string(), "0.55%");
    }

    #[test]
    fn a_number_without_a_unit_is_refused() {
        for text in ["2", "x%", "m", "%", ""] {
            let error = text.parse::<Length>().unwrap_err();
            assert!(error.to_string().contains("a percentage of the diagonal"), "{error}");
        }
    }
}
