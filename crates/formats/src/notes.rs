//! What a reader left out or mended: one note for each kind, with how often.

use std::fmt::{self, Display, Formatter};

/// What kind of thing a reader left out or mended.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum NoteKind {
    /// Nodes that `KHR_node_visibility` hides, left out with all that is below them.
    HiddenNodes,
    /// A default scene that does not exist; all scenes are read.
    MissingScenes,
    /// Lists of indices whose last ones make no whole triangle, left out.
    IncompleteTriangles,
    /// Base64 without padding, with line breaks or with escapes.
    MendedBase64,
    /// Skins whose joints move or scale all of the mesh at rest, applied.
    AppliedSkins,
    /// The same, not applied, since the mesh is read in the space that it was modelled in.
    IgnoredSkins,
    /// Skins whose joints pose the mesh at rest, not applied.
    PosingSkins,
    /// Skins that can't be read, not applied.
    UnreadableSkins,
    /// Morph targets that have a weight at rest, not applied.
    IgnoredMorphTargets,
    /// Lines `end solid`, `end facet` and `end loop`, which should be one word.
    DividedEnds,
    /// Lines `solid` and `endsolid` that are doubled or missing.
    UnpairedSolids,
    /// Bytes after the triangles that a header counts.
    TrailingBytes,
    /// Properties that a header names twice, of which the first counts.
    RepeatedProperties,
}

impl NoteKind {
    /// A name that stays the same when the words change: for programs.
    pub fn name(self) -> &'static str {
        self.name_and_words().0
    }

    /// The name, and what follows a count of one, and of several.
    fn name_and_words(self) -> (&'static str, &'static str, &'static str) {
        match self {
            Self::HiddenNodes => (
                "hidden_nodes",
                "node hidden by KHR_node_visibility: left out",
                "nodes hidden by KHR_node_visibility: left out",
            ),
            Self::MissingScenes => (
                "missing_scenes",
                "default scene that does not exist: all scenes are read",
                "default scenes that do not exist: all scenes are read",
            ),
            Self::IncompleteTriangles => (
                "incomplete_triangles",
                "list of indices that ends within a triangle: the rest is left out",
                "lists of indices that end within a triangle: the rest is left out",
            ),
            Self::MendedBase64 => (
                "mended_base64",
                "buffer whose base64 lacks padding, or has line breaks or escapes: mended",
                "buffers whose base64 lacks padding, or has line breaks or escapes: mended",
            ),
            Self::AppliedSkins => (
                "applied_skins",
                "skin whose joints move or scale the mesh at rest: applied",
                "skins whose joints move or scale the mesh at rest: applied",
            ),
            Self::IgnoredSkins => (
                "ignored_skins",
                "skin whose joints move or scale the mesh at rest: not applied, hulls are of the mesh as modelled",
                "skins whose joints move or scale the mesh at rest: not applied, hulls are of the mesh as modelled",
            ),
            Self::PosingSkins => (
                "posing_skins",
                "skin whose joints pose the mesh at rest: not applied",
                "skins whose joints pose the mesh at rest: not applied",
            ),
            Self::UnreadableSkins => (
                "unreadable_skins",
                "skin that can't be read: not applied",
                "skins that can't be read: not applied",
            ),
            Self::IgnoredMorphTargets => (
                "ignored_morph_targets",
                "mesh with morph targets that have a weight at rest: not applied",
                "meshes with morph targets that have a weight at rest: not applied",
            ),
            Self::DividedEnds => (
                "divided_ends",
                "line such as `end solid`: read as one word",
                "lines such as `end solid`: read as one word",
            ),
            Self::UnpairedSolids => (
                "unpaired_solids",
                "line `solid` or `endsolid` doubled or missing: mended",
                "lines `solid` or `endsolid` doubled or missing: mended",
            ),
            Self::TrailingBytes => (
                "trailing_bytes",
                "byte after the triangles that the header counts: left out",
                "bytes after the triangles that the header counts: left out",
            ),
            Self::RepeatedProperties => (
                "repeated_properties",
                "property that the header names twice: the first counts",
                "properties that the header names twice: the first counts",
            ),
        }
    }
}

/// What a reader left out or mended, and how often. As text, one line.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Note {
    /// What.
    pub kind: NoteKind,
    /// How often, at least once.
    pub count: usize,
}

impl Display for Note {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> fmt::Result {
        let (_, one, several) = self.kind.name_and_words();
        write!(formatter, "{} {}", self.count, if self.count == 1 { one } else { several })
    }
}

/// Counts more of a kind, of which there is one note.
pub(super) fn add(notes: &mut Vec<Note>, kind: NoteKind, count: usize) {
    if count == 0 {
        return;
    }
    match notes.iter_mut().find(|note| note.kind == kind) {
        Some(note) => note.count = note.count.saturating_add(count),
        None => notes.push(Note { kind, count }),
    }
}

/// The notes of several meshes as those of one, in the order of the first of each kind.
pub fn sum_notes<'a>(notes: impl IntoIterator<Item = &'a Note>) -> Vec<Note> {
    let mut sum = Vec::new();
    for note in notes {
        add(&mut sum, note.kind, note.count);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_kind_is_said_once_with_its_count() {
        let mut notes = Vec::new();
        add(&mut notes, NoteKind::HiddenNodes, 0);
        assert!(notes.is_empty());
        add(&mut notes, NoteKind::HiddenNodes, 1);
        add(&mut notes, NoteKind::TrailingBytes, 1);
        add(&mut notes, NoteKind::HiddenNodes, 2);
        let lines: Vec<String> = notes.iter().map(Note::to_string).collect();
        assert_eq!(
            lines,
            [
                "3 nodes hidden by KHR_node_visibility: left out",
                "1 byte after the triangles that the header counts: left out"
            ]
        );
        assert_eq!(sum_notes(notes.iter().chain(&notes))[0].count, 6);
    }
}
