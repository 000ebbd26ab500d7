//! Parameters as text: `key=value`, separated by spaces, in the words of the fields.

use std::fmt;
use std::str::FromStr;

use super::{Length, Parameters};

/// A text that is no value.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{text}`: {expected} is expected")]
pub struct ParseError {
    text: String,
    expected: String,
}

impl ParseError {
    pub(super) fn new(text: &str, expected: impl Into<String>) -> Self {
        Self { text: text.into(), expected: expected.into() }
    }
}

/// The keys there are.
const KEYS: &str = "method, max_error, preset, max_hulls, max_vertices, keep_cavities, openings, up_axis, \
                    simplification_quality, maximum_resolutions, planar_thresholds, \
                    angular_threshold, concavity_cost_threshold, resolution_cut_off, unit, \
                    significant_diagonal";

/// A cap that is not there.
const NONE: &str = "none";

impl fmt::Display for Parameters {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let default = fields(&Self::default());
        let own = fields(self);
        let differing = own.into_iter().zip(default).filter(|(own, default)| own.1 != default.1);
        let texts: Vec<String> =
            differing.map(|((key, value), _)| format!("{key}={value}")).collect();
        formatter.write_str(&texts.join(" "))
    }
}

fn fields(parameters: &Parameters) -> [(&'static str, String); 16] {
    let Parameters { method, bounded, surface, max_vertices } = parameters;
    let cap = |cap: Option<usize>| cap.map_or(NONE.into(), |cap| cap.to_string());
    [
        ("method", method.to_string()),
        ("max_error", bounded.max_error.to_string()),
        ("preset", bounded.preset.to_string()),
        ("max_hulls", cap(bounded.max_hulls)),
        ("max_vertices", cap(*max_vertices)),
        ("keep_cavities", bounded.keep_cavities.to_string()),
        ("openings", bounded.openings.to_string()),
        ("up_axis", bounded.up_axis.to_string()),
        ("simplification_quality", surface.simplification_quality.to_string()),
        ("maximum_resolutions", list(&surface.maximum_resolutions)),
        ("planar_thresholds", list(&surface.planar_thresholds)),
        ("angular_threshold", surface.angular_threshold.to_string()),
        ("concavity_cost_threshold", surface.concavity_cost_threshold.to_string()),
        ("resolution_cut_off", surface.resolution_cut_off.to_string()),
        ("unit", surface.unit.to_string()),
        ("significant_diagonal", surface.significant_diagonal.to_string()),
    ]
}

fn list(values: &[impl ToString]) -> String {
    let texts: Vec<String> = values.iter().map(ToString::to_string).collect();
    texts.join(",")
}

impl FromStr for Parameters {
    type Err = ParseError;

    /// Reads what [`Display`](fmt::Display) writes, on top of the defaults. The values are not
    /// checked: see [`validate`](Parameters::validate).
    fn from_str(text: &str) -> Result<Self, ParseError> {
        let mut parameters = Self::default();
        for item in text.split_whitespace() {
            let (key, value) =
                item.split_once('=').ok_or_else(|| ParseError::new(item, "key=value"))?;
            set(&mut parameters, key, value)?;
        }
        Ok(parameters)
    }
}

fn set(parameters: &mut Parameters, key: &str, value: &str) -> Result<(), ParseError> {
    let Parameters { method, bounded, surface, max_vertices } = parameters;
    match key {
        "method" => *method = value.parse()?,
        "max_error" => bounded.max_error = value.parse()?,
        "preset" => bounded.preset = value.parse()?,
        "max_hulls" => bounded.max_hulls = cap(value)?,
        "max_vertices" => *max_vertices = cap(value)?,
        "openings" => bounded.openings = value.parse()?,
        "up_axis" => bounded.up_axis = value.parse()?,
        "keep_cavities" => bounded.keep_cavities = parse(value, "true or false")?,
        "simplification_quality" => surface.simplification_quality = number(value)?,
        "maximum_resolutions" => surface.maximum_resolutions = numbers(value)?,
        "planar_thresholds" => surface.planar_thresholds = numbers(value)?,
        "angular_threshold" => surface.angular_threshold = number(value)?,
        "concavity_cost_threshold" => surface.concavity_cost_threshold = number(value)?,
        "resolution_cut_off" => surface.resolution_cut_off = number(value)?,
        "unit" => surface.unit = value.parse::<Length>()?,
        "significant_diagonal" => surface.significant_diagonal = number(value)?,
        _ => return Err(ParseError::new(key, format!("one of {KEYS}"))),
    }
    Ok(())
}

fn parse<T: FromStr>(text: &str, expected: &str) -> Result<T, ParseError> {
    text.parse().map_err(|_| ParseError::new(text, expected))
}

fn number<T: FromStr>(text: &str) -> Result<T, ParseError> {
    parse(text, "a number")
}

fn numbers<T: FromStr>(text: &str) -> Result<Vec<T>, ParseError> {
    text.split(',').map(number).collect()
}

fn cap(text: &str) -> Result<Option<usize>, ParseError> {
    if text == NONE { Ok(None) } else { parse(text, "a whole number or none").map(Some) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::Preset;

    #[test]
    fn text_goes_both_ways() {
        let bounded = Parameters::default()
            .max_error(Length::units(0.01))
            .preset(Preset::Fine)
            .max_hulls(3)
            .max_vertices(None)
            .keep_cavities(true);
        let mut paper = Parameters::paper();
        paper.surface.planar_thresholds = vec![0.25];
        for parameters in [Parameters::default(), bounded, paper] {
            assert_eq!(parameters.to_string().parse(), Ok(parameters));
        }
        assert_eq!(Parameters::default().to_string(), "");
    }

    #[test]
    fn a_wrong_key_or_value_is_named_with_what_is_expected() {
        for (text, expected) in [
            ("max_hull=3", "max_hulls"),
            ("max_hulls=many", "a whole number or none"),
            ("preset=best", "fast, balanced or fine"),
            ("keep_cavities", "key=value"),
        ] {
            let error = text.parse::<Parameters>().unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
    }
}
