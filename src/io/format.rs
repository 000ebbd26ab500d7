//! The formats of files, and the suffixes that name them: the one list of both.

use std::path::Path;

/// A format of mesh files.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Format {
    /// Wavefront OBJ.
    Obj,
    /// Object File Format, also with colours or normals (COFF, NOFF, STOFF).
    Off,
    /// Polygon File Format, text or binary of either byte order.
    Ply,
    /// Stereolithography, text or binary.
    Stl,
    /// glTF 2.0 as JSON, or as GLB: the content tells.
    Gltf,
}

impl Format {
    /// All formats.
    pub const ALL: &'static [Self] = &[Self::Obj, Self::Off, Self::Ply, Self::Stl, Self::Gltf];

    /// The format that a file name's suffix stands for, in upper or lower case.
    pub fn from_path(path: impl AsRef<Path>) -> Option<Self> {
        let suffix = path.as_ref().extension()?;
        let names = |known: &&str| suffix.eq_ignore_ascii_case(known);
        Self::ALL.iter().copied().find(|format| format.suffixes().iter().any(names))
    }

    /// The format's name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Obj => "OBJ",
            Self::Off => "OFF",
            Self::Ply => "PLY",
            Self::Stl => "STL",
            Self::Gltf => "glTF",
        }
    }

    /// The suffixes that stand for it, in lower case, without a dot.
    pub fn suffixes(self) -> &'static [&'static str] {
        match self {
            Self::Obj => &["obj"],
            Self::Off => &["off"],
            Self::Ply => &["ply"],
            Self::Stl => &["stl"],
            Self::Gltf => &["gltf", "glb"],
        }
    }

    /// The suffixes of all formats, for a message.
    pub fn suffix_list() -> String {
        or_list(
            Self::ALL.iter().flat_map(|format| format.suffixes()).map(|&suffix| suffix.to_owned()),
        )
    }
}

/// A format that hulls can be written in.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum HullFormat {
    /// Wavefront OBJ.
    Obj,
    /// Binary glTF 2.0.
    Glb,
}

impl HullFormat {
    /// All formats.
    pub const ALL: &'static [Self] = &[Self::Obj, Self::Glb];

    /// The format that a file name's suffix stands for, in upper or lower case.
    pub fn from_path(path: impl AsRef<Path>) -> Option<Self> {
        let suffix = path.as_ref().extension()?;
        Self::ALL.iter().copied().find(|format| suffix.eq_ignore_ascii_case(format.suffix()))
    }

    /// The suffix that stands for it, in lower case, without a dot.
    pub fn suffix(self) -> &'static str {
        match self {
            Self::Obj => "obj",
            Self::Glb => "glb",
        }
    }

    /// The suffixes of all formats, for a message.
    pub fn suffix_list() -> String {
        or_list(Self::ALL.iter().map(|format| format!(".{}", format.suffix())))
    }
}

/// Words as in "a, b or c".
fn or_list(words: impl Iterator<Item = String>) -> String {
    let words: Vec<String> = words.collect();
    match words.split_last() {
        Some((last, [])) => last.clone(),
        Some((last, before)) => format!("{} or {last}", before.join(", ")),
        None => String::new(),
    }
}
