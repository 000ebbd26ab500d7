//! A length, relative to the mesh or in its own units.

use std::fmt;
use std::str::FromStr;

use super::text::ParseError;

/// A length: a share of the mesh's bounding-box diagonal, or a number of its own units.
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
    /// This many bounding-box diagonals.
    Share(f64),
    /// This many of the mesh's units.
    Units(f64),
}

impl Length {
    /// A share of the bounding-box diagonal: 0.02 for 2 %.
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
        let expected = "a share of the diagonal (2%) or a length in the mesh's units (0.02m)";
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
            assert!(error.to_string().contains("a share of the diagonal"), "{error}");
        }
    }
}
