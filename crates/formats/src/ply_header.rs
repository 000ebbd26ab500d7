//! The header of a PLY file: its encoding, and its elements with their properties, in the file's
//! order.
//!
//! Lines may end with CR alone, be indented or be empty. A name that stands twice stays twice,
//! since the data of both follow.

use std::collections::HashSet;

use super::text::{at_line, name, number, quote, words};

/// How numbers are written after the header.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Text,
    LittleEndian,
    BigEndian,
}

/// A type of number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn of(word: &[u8]) -> Result<Self, String> {
        Ok(match word {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return Err(format!("{} is no type such as `float` or `int`", quote(word))),
        })
    }

    /// In bytes.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

/// What a property holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Number(Scalar),
    List { length: Scalar, of: Scalar },
}

#[derive(Debug, PartialEq, Eq)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) kind: Kind,
}

#[derive(Debug, PartialEq, Eq)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: usize,
    pub(super) properties: Vec<Property>,
}

#[derive(Debug)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    pub(super) lines: usize,
}

impl Header {
    /// The header, and what follows it.
    pub(super) fn split(bytes: &[u8]) -> Result<(Self, &[u8]), String> {
        let mut lines = HeaderLines::new(bytes);
        match lines.next() {
            Some((_, line)) if line == b"ply" => {}
            other => {
                let found = quote(other.map_or(&[], |(_, line)| line));
                return Err(format!("line 1: {found} stands where `ply` would be read"));
            }
        }
        let mut encoding = None;
        let mut elements: Vec<Element> = Vec::new();
        while let Some((number, line)) = lines.next() {
            if line == b"end_header" {
                let encoding =
                    encoding.ok_or("the header has no line such as `format ascii 1.0`")?;
                return Ok((Self { encoding, elements, lines: number }, lines.rest));
            }
            read_line(line, &mut encoding, &mut elements).map_err(at_line(number))?;
        }
        Err(format!("line {}: the header ends without `end_header`", lines.number))
    }

    pub(super) fn element(&self, name: &str) -> Option<&Element> {
        self.elements.iter().find(|element| element.name == name)
    }

    /// How many properties have the name of one before in their element.
    pub(super) fn repeated_properties(&self) -> usize {
        let repeated = |element: &Element| {
            let mut seen = HashSet::new();
            element.properties.iter().filter(|property| !seen.insert(&property.name)).count()
        };
        self.elements.iter().map(repeated).sum()
    }
}

/// Trimmed lines with their numbers. What ends the first line ends all of them, so that no byte of
/// the data after a CR is taken for the LF of a line's end.
struct HeaderLines<'a> {
    rest: &'a [u8],
    end: u8,
    number: usize,
}

impl<'a> HeaderLines<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        let at = bytes.iter().position(|byte| matches!(byte, b'\r' | b'\n')).unwrap_or(0);
        let is_old = bytes.get(at) == Some(&b'\r') && bytes.get(at + 1) != Some(&b'\n');
        Self { rest: bytes, end: if is_old { b'\r' } else { b'\n' }, number: 0 }
    }
}

impl<'a> Iterator for HeaderLines<'a> {
    type Item = (usize, &'a [u8]);

    fn next(&mut self) -> Option<Self::Item> {
        if self.rest.is_empty() {
            return None;
        }
        self.number += 1;
        let end = self.rest.iter().position(|byte| *byte == self.end).unwrap_or(self.rest.len());
        let (line, rest) = self.rest.split_at(end);
        self.rest = rest.get(1..).unwrap_or_default();
        Some((self.number, line.trim_ascii()))
    }
}

fn read_line(
    line: &[u8],
    encoding: &mut Option<Encoding>,
    elements: &mut Vec<Element>,
) -> Result<(), String> {
    let mut words = words(line);
    let unreadable = || {
        let lines = "`element vertex 8`, `property float x` or `end_header`";
        Err(format!("{} stands where a line such as {lines} would be read", quote(line)))
    };
    match words.next() {
        None | Some(b"comment" | b"obj_info") => {}
        Some(b"format") => *encoding = Some(read_format(words.next().unwrap_or_default())?),
        Some(b"element") => {
            let (Some(word), Some(count)) = (words.next(), words.next()) else {
                return unreadable();
            };
            elements.push(Element {
                name: name(word),
                count: number(count)?,
                properties: Vec::new(),
            });
        }
        Some(b"property") => {
            let Some(element) = elements.last_mut() else {
                return Err(format!("{} stands before any element", quote(line)));
            };
            let Some(property) = read_property(words)? else { return unreadable() };
            element.properties.push(property);
        }
        Some(_) => return unreadable(),
    }
    Ok(())
}

fn read_format(word: &[u8]) -> Result<Encoding, String> {
    match word {
        b"ascii" => Ok(Encoding::Text),
        b"binary_little_endian" => Ok(Encoding::LittleEndian),
        b"binary_big_endian" => Ok(Encoding::BigEndian),
        _ => Err(format!(
            "the format is {}; `ascii`, `binary_little_endian` and `binary_big_endian` would be read",
            quote(word)
        )),
    }
}

/// What follows `property`; `None` where words are missing.
fn read_property<'a>(
    mut words: impl Iterator<Item = &'a [u8]>,
) -> Result<Option<Property>, String> {
    let mut next = || words.next();
    let Some(first) = next() else { return Ok(None) };
    let kind = if first == b"list" {
        let (Some(length), Some(of)) = (next(), next()) else { return Ok(None) };
        Kind::List { length: Scalar::of(length)?, of: Scalar::of(of)? }
    } else {
        Kind::Number(Scalar::of(first)?)
    };
    Ok(next().map(|word| Property { name: name(word), kind }))
}
