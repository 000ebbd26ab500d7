//! Parameters as text: `key=value`, separated by spaces, in the names of the fields.

use std::str::FromStr;

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
const NONE: &str = "none";

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

        impl std::fmt::Display for $type {
            fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                formatter.write_str(self.name())
            }
        }

        impl std::str::FromStr for $type {
            type Err = $crate::parameters::text::ParseError;

            fn from_str(text: &str) -> Result<Self, Self::Err> {
                match text {
                    $($name => Ok(Self::$variant),)+
                    _ => Err($crate::parameters::text::ParseError::new(text, $expected)),
                }
            }
        }
    };
}

pub(super) use named;
