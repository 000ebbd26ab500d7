//! Formats, and what files hold.

use std::ops::Range;
use std::path::Path;

use hullwright::hulls_format::MeshPart;
use hullwright::{Error, Hull, MeshView, PartShare, TriangleMesh, part_shares};

use super::notes::{self, Note, NoteKind};

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
    /// glTF 2.0, as JSON or as GLB, by content.
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

    fn name_and_suffixes(self) -> (&'static str, &'static [&'static str]) {
        match self {
            Self::Obj => ("OBJ", &["obj"]),
            Self::Off => ("OFF", &["off"]),
            Self::Ply => ("PLY", &["ply"]),
            Self::Stl => ("STL", &["stl"]),
            Self::Gltf => ("glTF", &["gltf", "glb"]),
        }
    }

    /// The format's name.
    pub fn name(self) -> &'static str {
        self.name_and_suffixes().0
    }

    /// The suffixes that stand for it, in lower case, without a dot.
    pub fn suffixes(self) -> &'static [&'static str] {
        self.name_and_suffixes().1
    }

    /// The suffixes of all formats, for a message.
    pub fn suffix_list() -> String {
        let suffixes = Self::ALL.iter().flat_map(|format| format.suffixes());
        or_list(suffixes.map(|&suffix| suffix.to_owned()))
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

/// Suffixes of files that meshes are written to.
const MESH_SUFFIXES: [&str; 5] = ["obj", "glb", "off", "ply", "stl"];

/// Whether a file name's suffix is one that meshes can be written to, in upper or lower case.
pub fn is_mesh_output(path: impl AsRef<Path>) -> bool {
    let is_written = |suffix: &std::ffi::OsStr| {
        MESH_SUFFIXES.iter().any(|written| suffix.eq_ignore_ascii_case(written))
    };
    path.as_ref().extension().is_some_and(is_written)
}

/// The suffixes of all formats that meshes can be written in, for a message.
pub fn mesh_suffix_list() -> String {
    or_list(MESH_SUFFIXES.iter().map(|suffix| format!(".{suffix}")))
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

/// Whether a file name's suffix is `hulls`, in upper or lower case.
pub fn is_hulls_file(path: impl AsRef<Path>) -> bool {
    path.as_ref().extension().is_some_and(|suffix| suffix.eq_ignore_ascii_case("hulls"))
}

/// A named part of a mesh file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Object {
    /// Its name in the file; empty where it has none.
    pub name: String,
    /// Its part of the triangles of [`MeshFile::mesh`]; not empty.
    pub triangles: Range<usize>,
}

/// What a mesh file holds, in its own units, neither welded nor repaired.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MeshFile {
    /// All vertices and triangles. A coordinate may be infinite or not a number if it is so in the
    /// file; each index is below the number of positions.
    pub mesh: TriangleMesh,
    /// The parts that hold triangles, in the file's order, which together hold all triangles: the
    /// objects of an OBJ (its groups, where it has no object), the solids of an STL, the nodes with
    /// a mesh of a glTF scene, each of its instances. A file of another format is a single part.
    pub objects: Vec<Object>,
    /// What the triangles are made of, as far as the file says: the primitives of a glTF's meshes,
    /// each once, however often it is placed; the materials of an OBJ's objects.
    pub parts: MeshParts,
    /// What was left out or mended, one note for each kind.
    pub notes: Vec<Note>,
}

impl<'a> From<&'a MeshFile> for MeshView<'a> {
    fn from(file: &'a MeshFile) -> Self {
        file.mesh.view()
    }
}

impl MeshFile {
    /// Ends an object whose triangles began at `start`; one without triangles is left out.
    pub(super) fn close_object(&mut self, name: impl Into<String>, start: usize) {
        let triangles = start..self.mesh.triangles.len();
        if !triangles.is_empty() {
            let name = name.into();
            self.objects.push(Object { name, triangles });
        }
    }

    /// Counts what was left out or mended.
    pub(super) fn note(&mut self, kind: NoteKind, count: usize) {
        notes::add(&mut self.notes, kind, count);
    }
}

/// Which triangles of a mesh are of which of its parts; empty where its file says nothing of parts.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct MeshParts {
    /// The parts that hold triangles. Of a name no more than 256 bytes are kept.
    pub list: Vec<MeshPart>,
    /// For each triangle the index of its part; empty where there are no parts.
    pub of_triangles: Vec<u32>,
}

impl MeshParts {
    /// What hulls of the mesh are made of, for
    /// [`HullsFile::with_parts`](hullwright::hulls_format::HullsFile::with_parts); empty where
    /// there are no parts. Costs are those of [`part_shares`](hullwright::part_shares()).
    ///
    /// # Errors
    /// As [`part_shares`](hullwright::part_shares()), for another mesh.
    pub fn shares<'a>(
        &self,
        mesh: impl Into<MeshView<'a>>,
        hulls: &[Hull],
    ) -> Result<Vec<Vec<PartShare>>, Error> {
        match self.list.is_empty() {
            true => Ok(Vec::new()),
            false => part_shares(mesh, &self.of_triangles, hulls),
        }
    }

    /// Adds a part, and returns its index.
    pub(super) fn add(&mut self, part: MeshPart) -> u32 {
        self.list.push(part);
        self.list.len() as u32 - 1
    }

    /// Some parts, and the triangles that hold just these.
    pub(super) fn slice(&self, parts: Range<usize>, triangles: Range<usize>) -> Self {
        let first = parts.start as u32;
        let of_triangles = self.of_triangles.get(triangles).unwrap_or_default().iter();
        Self {
            list: self.list.get(parts).unwrap_or_default().to_vec(),
            of_triangles: of_triangles.map(|part| part.saturating_sub(first)).collect(),
        }
    }
}

/// A name as parts have it. Each part has it anew: of one that is long they could fill any memory.
pub(super) fn name_of_part(name: &str) -> &str {
    const LONGEST: usize = 256;
    &name[..name.floor_char_boundary(LONGEST)]
}

/// A mesh, or a hull of a hull set, by itself, in the file's units.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedMesh {
    /// Its name in the file; empty where it has none.
    pub name: String,
    /// Vertices, each of which is used by a triangle, and triangles as the file winds them.
    pub mesh: TriangleMesh,
}

impl<'a> From<&'a NamedMesh> for MeshView<'a> {
    fn from(named: &'a NamedMesh) -> Self {
        named.mesh.view()
    }
}

/// Gives each object its own vertices, in the order in which its triangles use them.
pub(super) fn split_objects(file: &MeshFile) -> Vec<NamedMesh> {
    const UNSEEN: u32 = u32::MAX;
    let mut new_index = vec![UNSEEN; file.mesh.positions.len()];
    let own = |object: &Object| {
        let source = &file.mesh.triangles[object.triangles.clone()];
        let mut positions = Vec::new();
        let triangles = source
            .iter()
            .map(|triangle| {
                triangle.map(|vertex| {
                    let index = &mut new_index[vertex as usize];
                    if *index == UNSEEN {
                        *index = positions.len() as u32;
                        positions.push(file.mesh.positions[vertex as usize]);
                    }
                    *index
                })
            })
            .collect();
        for vertex in source.iter().flatten() {
            new_index[*vertex as usize] = UNSEEN;
        }
        let sidedness = file.mesh.sidedness.get(object.triangles.clone());
        let sidedness = sidedness.unwrap_or_default().to_vec();
        let mesh = TriangleMesh { positions, triangles, sidedness };
        NamedMesh { name: object.name.clone(), mesh }
    };
    file.objects.iter().map(own).collect()
}

/// The index of the first of `more` new vertices, if all of them can have an index.
pub(super) fn next_index(positions: &[[f64; 3]], more: usize) -> Result<u32, String> {
    match u32::try_from(positions.len().saturating_add(more)) {
        Ok(_) => Ok(positions.len() as u32),
        Err(_) => Err(format!("it has more than {} vertices", u32::MAX)),
    }
}

/// A mesh of a scene, in the space that it was modelled in, with the names and extras that artists
/// gave it.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
pub struct SceneMesh {
    /// Its name; `mesh_` and its index where it has none.
    pub name: String,
    /// Its index among the meshes of the glTF file; `None` from a file of another format.
    pub index: Option<u32>,
    /// All its primitives together, each vertex used by a triangle.
    pub mesh: TriangleMesh,
    /// Which triangles are of which primitive, and so of which material.
    pub parts: MeshParts,
    /// Its extras: custom properties, as JSON.
    pub extras: Option<String>,
    /// The nodes that show it, in the file's order, of all scenes.
    pub nodes: Vec<SceneNode>,
    /// What was left out or mended of it, one note for each kind.
    pub notes: Vec<Note>,
}

/// A node that shows a mesh.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SceneNode {
    /// Its name; may be empty.
    pub name: String,
    /// Its index among the nodes of the glTF file; `None` from a file of another format.
    pub index: Option<u32>,
    /// Its extras: custom properties, as JSON.
    pub extras: Option<String>,
    /// Whether the file holds hulls of its mesh, as
    /// [`HullsInFile`](crate::gltf_hulls::HullsInFile) writes them.
    pub has_hulls: bool,
    /// Where it is in its scene: the columns of a linear map, then a translation. `None` where it
    /// is in no tree of nodes, or the file has none.
    pub transform: Option<[[f64; 3]; 4]>,
}
