//! Writes hulls into the glTF file that holds their meshes, so that a game needs no second file and
//! an artist can edit them.
//!
//! ```
//! use hullwright::Control;
//! use hullwright_formats::bake::{BakeOptions, bake_jobs};
//! use hullwright_formats::gltf_hulls::{HullForm, HullsInFile, MeshHulls};
//!
//! let path = "../../assets/mug.glb";
//! let options = BakeOptions::default().with_written(true);
//! let jobs = bake_jobs(hullwright_formats::read_scene(path)?, &options);
//! let file = HullsInFile::read(path)?;
//! let mut meshes = Vec::new();
//! for job in &jobs {
//!     let baked = match file.found(job).baked {
//!         Some(as_before) => as_before,
//!         None => job.run(&Control::new())?,
//!     };
//!     meshes.push(MeshHulls { nodes: &job.gltf_nodes, baked });
//! }
//! let bytes = file.write(HullForm::Physics, &meshes)?;
//!
//! // What is in the file already is not made again.
//! let again = HullsInFile::from_bytes(&bytes)?;
//! assert!(jobs.iter().all(|job| again.found(job).baked.is_some()));
//! # Ok::<(), hullwright::Error>(())
//! ```
//!
//! # What is written
//!
//! Each node that shows a mesh gets a child, the group, whose extras hold a
//! [`HullsRecord`], and whose children are the hulls, in the node's own space:
//!
//! | form | a hull is |
//! |---|---|
//! | [`HullForm::Physics`] | a node with a collider of `KHR_physics_rigid_bodies`, the convex hull of the mesh of a node that is in no scene; nodes that show one mesh share it |
//! | [`HullForm::Ucx`] | a node `UCX_…` that shows the hull, which Unreal reads as a collider |
//!
//! Each hull is a mesh of one primitive in single precision, in a colour of the
//! [palette](crate::palette).
//!
//! All else stays as it was: keys and their order, unknown extensions, extras, binary data. What is
//! added stands at the end of each array, and at the end of the chunk of binary data of a GLB, or
//! in a buffer of its own. Where all that was added before is still at these ends as it was
//! written, and was not edited, it is taken off before hulls are written anew, so that the file
//! does not grow. Otherwise groups that are replaced are cut off from their nodes and stay, since
//! other parts of the file may refer to what comes after them.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use hullwright::Error;
use hullwright::hulls_format::{BakedMesh, MeshHash};
use serde_json::{Map, Value, json};

use crate::bake::BakeJob;
use crate::conventions::{Complaint, HullsRecord, ReadBack, WrittenHull, hull_digest};
use crate::gltf::{Chunks, HullGroups, RawHull, read_hull_groups};
use crate::gltf_data::Beside;
use crate::gltf_groups::{Group, PHYSICS};
use crate::read::decoded;
use crate::write::{
    FLOAT, INDICES, MOST_SHORT_INDICES, UNSIGNED_INT, UNSIGNED_SHORT, VERTICES, assemble, material,
};

/// How hulls stand in a file.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum HullForm {
    /// As colliders of `KHR_physics_rigid_bodies`, which nothing draws.
    #[default]
    Physics,
    /// As meshes that are named as Unreal has it. Programs without a rule for these names draw
    /// them.
    Ucx,
}

/// The hulls of a mesh to write.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshHulls<'a> {
    /// The indices of the nodes that show the mesh.
    pub nodes: &'a [u32],
    /// The hulls.
    pub baked: BakedMesh,
}

/// What a file holds of the mesh of a job.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FoundHulls {
    /// The hulls, if this version of the library makes the same of the same mesh.
    pub baked: Option<BakedMesh>,
    /// Hulls that were edited by hand, and those that can't be read: they stay, whatever is
    /// written.
    pub edited: Vec<EditedHulls>,
    /// The names of the nodes with a collider or trigger of their own, which get no hulls.
    pub with_collider: Vec<String>,
    /// How many nodes take hulls: all others that show the mesh.
    pub open_nodes: usize,
}

/// Hulls that someone edited by hand.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
pub struct EditedHulls {
    /// The name of the node that shows their mesh.
    pub node: String,
    /// The hulls; what is wrong if they can't be read.
    pub read: Result<ReadBack, Complaint>,
    /// Whether the mesh is another than the one that they were made of.
    pub mesh_changed: bool,
}

/// A glTF or GLB file, and the hulls that it holds.
#[derive(Debug, Clone)]
pub struct HullsInFile {
    path: String,
    bytes: Vec<u8>,
    root: Value,
    groups: Vec<KnownGroup>,
    /// The groups of the mesh that a node shows.
    by_parent: BTreeMap<usize, Vec<usize>>,
}

/// A group of hulls in a file.
#[derive(Debug, Clone)]
struct KnownGroup {
    node: usize,
    /// The node that shows the mesh; none of a group that was cut off.
    parent: Option<usize>,
    nodes: Vec<usize>,
    form: HullForm,
    content: Arc<Content>,
}

/// The hulls of groups and what is said of them: nodes that show one mesh have the same.
#[derive(Debug)]
struct Content {
    hulls: Arc<[WrittenHull]>,
    record: Result<HullsRecord, Complaint>,
    read: Result<ReadBack, Complaint>,
}

impl Content {
    /// The record of hulls that are as they were written.
    fn unedited(&self) -> Option<&HullsRecord> {
        let is_unedited = self.read.as_ref().is_ok_and(|read| !read.edited);
        self.record.as_ref().ok().filter(|_| is_unedited)
    }

    /// Whether the hulls were edited, or are in a form that can't be read. A group without any hull
    /// does not count: a program that does not know the extension dropped them.
    fn is_kept(&self) -> bool {
        self.unedited().is_none() && !self.hulls.is_empty()
    }
}

impl Content {
    fn read(name: &str, extras: &str, hulls: Arc<[WrittenHull]>) -> Self {
        let record =
            HullsRecord::from_extras(extras).unwrap_or_else(|| Err("there is no record".into()));
        let read = record
            .clone()
            .and_then(|record| record.read_back(name, &hulls).map_err(|error| error.to_string()));
        Self { hulls, record, read }
    }
}

impl HullsInFile {
    /// Reads a file, and what it holds of hulls.
    ///
    /// # Errors
    /// [`Error::File`] if it can't be read, is no glTF 2.0, or holds groups of hulls that can't be
    /// read.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        let bytes = std::fs::read(path).map_err(|error| Error::file(path, error))?;
        Self::parse(path.display().to_string(), bytes, path.parent().into())
            .map_err(|reason| Error::file(path, reason))
    }

    /// The same of a file that is already in memory, which names no buffers in other files.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, Error> {
        let path = "glTF in memory";
        Self::parse(path.into(), bytes.to_vec(), Beside::Nothing)
            .map_err(|reason| Error::file(Path::new(path), reason))
    }

    fn parse(path: String, bytes: Vec<u8>, beside: Beside<'_>) -> Result<Self, String> {
        let text = decoded(&bytes);
        let HullGroups { groups, extras, set_of, sets } = read_hull_groups(&text, beside)?;
        let root = serde_json::from_slice(Chunks::of(&text)?.json)
            .map_err(|error| format!("it is no valid JSON: {error}"))?;
        let written = |set: Vec<RawHull>| set.into_iter().map(written).collect();
        let sets: Vec<Arc<[WrittenHull]>> = sets.into_iter().map(written).collect();
        let shows_mesh = |parent: &usize| {
            list(&root, "nodes").get(*parent).is_some_and(|node| node.get("mesh").is_some())
        };
        let mut contents: BTreeMap<(usize, &str), Arc<Content>> = BTreeMap::new();
        let (mut told, mut by_parent) = (Vec::new(), BTreeMap::<usize, Vec<usize>>::new());
        for ((group, extras), set) in groups.into_iter().zip(&extras).zip(set_of) {
            let Group { node, parent, nodes, is_physics, .. } = group;
            let parent = parent.filter(shows_mesh);
            let content = contents.entry((set, extras)).or_insert_with(|| {
                let name = parent.map(|parent| base_name(&root, parent)).unwrap_or_default();
                let hulls = sets.get(set).cloned().unwrap_or_default();
                Arc::new(Content::read(&name, extras, hulls))
            });
            if let Some(parent) = parent {
                by_parent.entry(parent).or_default().push(told.len());
            }
            let form = if is_physics { HullForm::Physics } else { HullForm::Ucx };
            told.push(KnownGroup { node, parent, nodes, form, content: Arc::clone(content) });
        }
        Ok(Self { path, bytes, root, groups: told, by_parent })
    }

    /// What the file holds of a mesh. O(triangles, and the groups of its nodes).
    pub fn found(&self, job: &BakeJob) -> FoundHulls {
        let hash = MeshHash::of(&job.mesh);
        let mut found = FoundHulls::default();
        for node in job.gltf_nodes.iter().map(|node| *node as usize) {
            let edited = self.groups_of(node).filter(|group| group.content.is_kept());
            let before = found.edited.len();
            found.edited.extend(edited.map(|group| EditedHulls {
                node: base_name(&self.root, node),
                read: group.content.read.clone(),
                mesh_changed: group.content.record.as_ref().is_ok_and(|record| record.mesh != hash),
            }));
            if found.edited.len() > before {
                continue;
            }
            if has_collider(&self.root, node) {
                found.with_collider.push(base_name(&self.root, node));
                continue;
            }
            found.open_nodes += 1;
            let same = || {
                self.groups_of(node).find(|group| {
                    let is_same = |record: &HullsRecord| {
                        record.is_of(hash, &job.parameters) && record.parts() == job.parts.list
                    };
                    group.content.unedited().is_some_and(is_same)
                })
            };
            if found.baked.is_none() {
                let read = same().and_then(|group| group.content.read.as_ref().ok());
                found.baked = read.map(|read| read.baked.clone());
            }
        }
        found
    }

    /// The other files that the file names, as it names them: buffers and images. A copy elsewhere
    /// lacks them.
    pub fn other_files(&self) -> impl Iterator<Item = &str> {
        let named = ["buffers", "images"].into_iter().flat_map(|name| list(&self.root, name));
        let uris = named.filter_map(|of| of.get("uri")?.as_str());
        uris.filter(|uri| !uri.starts_with("data:"))
    }

    /// The bytes of the file with these hulls. Nodes whose hulls were edited keep them, nodes with
    /// a collider or trigger of their own get none, and hulls of other nodes that were not edited
    /// are taken out. A file that holds all of it already stays as it is. O(size).
    ///
    /// # Errors
    /// [`Error::File`] if the file is not what it should be where hulls are added, or would be too
    /// large; [`Error::NoHull`] if a hull is beyond the range of single precision.
    pub fn write(&self, form: HullForm, meshes: &[MeshHulls<'_>]) -> Result<Vec<u8>, Error> {
        let in_file = |reason: String| Error::file(Path::new(&self.path), reason);
        let mut in_place = BTreeSet::new();
        let mut all = Vec::new();
        for mesh in meshes {
            let exists = |node: &u32| (*node as usize) < list(&self.root, "nodes").len();
            if let Some(node) = mesh.nodes.iter().find(|node| !exists(node)) {
                return Err(in_file(format!("there is no node {node}")));
            }
            let addition = self.addition(mesh)?;
            for &node in &addition.nodes {
                let [group] = self.groups_of(node).collect::<Vec<_>>()[..] else { continue };
                let is_same = |record: &HullsRecord| *record == addition.record;
                if group.form == form && group.content.unedited().is_some_and(is_same) {
                    in_place.insert(group.node);
                }
            }
            all.push(addition);
        }
        let (stale, kept): (Vec<&KnownGroup>, Vec<&KnownGroup>) =
            self.groups.iter().partition(|group| {
                let is_replaced = group.parent.is_some() && !group.content.is_kept();
                is_replaced && !in_place.contains(&group.node)
            });
        let with_place: BTreeSet<usize> = kept.iter().filter_map(|group| group.parent).collect();
        let is_missing = |node: &usize| !with_place.contains(node);
        if stale.is_empty() && !all.iter().any(|addition| addition.nodes.iter().any(is_missing)) {
            return Ok(self.bytes.clone());
        }
        let text = decoded(&self.bytes);
        let chunks = Chunks::of(&text).map_err(in_file)?;
        let mut document = match self.stripped(&chunks) {
            Some(stripped) => stripped,
            None => {
                let mut document = Growing::of(&self.root, &chunks);
                for group in stale {
                    document.cut_off(group).map_err(in_file)?;
                }
                for addition in &mut all {
                    addition.nodes.retain(is_missing);
                }
                document
            }
        };
        document.add(form, &all).and_then(|()| document.into_bytes(&chunks)).map_err(in_file)
    }

    /// The groups of the mesh that a node shows.
    fn groups_of(&self, node: usize) -> impl Iterator<Item = &KnownGroup> {
        let groups = self.by_parent.get(&node).into_iter().flatten();
        groups.filter_map(|group| self.groups.get(*group))
    }

    /// What is to be added for a mesh, at the nodes that take hulls.
    fn addition(&self, mesh: &MeshHulls<'_>) -> Result<Addition, Error> {
        let MeshHulls { nodes, baked } = mesh;
        let nodes = nodes.iter().map(|node| *node as usize).filter(|node| {
            let is_kept = self.groups_of(*node).any(|group| group.content.is_kept());
            !is_kept && !has_collider(&self.root, *node)
        });
        let nodes: Vec<usize> = nodes.collect();
        // Hulls that come from the file are written as they stand there.
        let is_same = |group: &&KnownGroup| {
            let is_read = group.content.read.as_ref().is_ok_and(|read| {
                read.baked.hash == baked.hash
                    && read.baked.parameters == baked.parameters
                    && read.baked.hulls.hulls == baked.hulls.hulls
            });
            group.content.unedited().is_some() && is_read
        };
        let same = nodes.iter().find_map(|node| self.groups_of(*node).find(is_same));
        if let Some(group) = same
            && let Some(as_before) = group.as_before()
        {
            return Ok(Addition { nodes, ..as_before });
        }
        let hulls = &baked.hulls.hulls;
        let hulls: Vec<WrittenHull> =
            hulls.iter().map(|hull| WrittenHull::of(&hull.shape)).collect::<Result<_, _>>()?;
        Ok(Addition { nodes, record: HullsRecord::new(baked, &hulls), hulls })
    }
}

impl KnownGroup {
    /// What was added for a group that was not edited, hulls in the record's order.
    fn as_before(&self) -> Option<Addition> {
        let Content { hulls, .. } = &*self.content;
        let record = self.content.unedited()?.clone();
        let mut by_digest: BTreeMap<String, Vec<&WrittenHull>> = BTreeMap::new();
        for hull in hulls.iter().rev() {
            by_digest.entry(hull_digest(&hull.points)).or_default().push(hull);
        }
        let hull = |digest: &String| by_digest.get_mut(digest)?.pop().cloned();
        let hulls = record.digests.iter().map(hull).collect::<Option<_>>()?;
        Some(Addition { nodes: self.parent.into_iter().collect(), record, hulls })
    }
}

/// A hull as its mesh holds it.
fn written(hull: RawHull) -> WrittenHull {
    let RawHull { positions, triangles } = hull;
    let points = positions.iter().map(|point| point.map(|x| x as f32)).collect();
    WrittenHull { points, triangles }
}

/// Groups of one mesh that are added to a file.
struct Addition {
    nodes: Vec<usize>,
    record: HullsRecord,
    hulls: Vec<WrittenHull>,
}

/// Taking off what was added.
impl HullsInFile {
    /// The file without all groups, if all that was added with them is the end of its arrays, as it
    /// would be written, and nothing else refers to it.
    fn stripped(&self, chunks: &Chunks<'_>) -> Option<Growing> {
        let first = self.groups.first()?;
        let are_alike = self.groups.iter().all(|group| {
            group.form == first.form && group.parent.is_some() && group.content.unedited().is_some()
        });
        if !are_alike {
            return None;
        }
        let ends = Ends::of(&self.root, &self.groups)?;
        let whole = Growing::of(&self.root, chunks);
        let mut stripped = whole.without(&self.groups, &ends)?;
        if refers_beyond(&stripped.root, &ends) {
            return None;
        }
        // What is written anew must be what was there, so that nothing of someone else's is lost.
        let base = stripped.clone();
        stripped.add(first.form, &self.all_as_before()?).ok()?;
        // As text, since values with their keys in another order are equal.
        let text = |document: &Growing| document.root.to_string();
        let is_same = text(&stripped) == text(&whole) && stripped.binary == whole.binary;
        is_same.then_some(base)
    }

    /// All that was added, groups with the same hulls together, in the order of their nodes.
    fn all_as_before(&self) -> Option<Vec<Addition>> {
        let mut additions: Vec<Addition> = Vec::new();
        let mut by_content: BTreeMap<*const Content, usize> = BTreeMap::new();
        for group in &self.groups {
            let content = Arc::as_ptr(&group.content);
            match by_content.get(&content).and_then(|known| additions.get_mut(*known)) {
                Some(known) => known.nodes.extend(group.parent),
                None => {
                    by_content.insert(content, additions.len());
                    additions.push(group.as_before()?);
                }
            }
        }
        Some(additions)
    }
}

/// Where in each array what was added begins.
struct Ends {
    nodes: usize,
    meshes: usize,
    accessors: usize,
    views: usize,
    materials: usize,
    /// The buffer, and where in it.
    buffer: usize,
    bytes: usize,
}

impl Ends {
    /// `None` where what was added is not the end of each array.
    fn of(root: &Value, groups: &[KnownGroup]) -> Option<Self> {
        let nodes: BTreeSet<usize> =
            groups.iter().flat_map(|group| &group.nodes).copied().collect();
        let mesh = |node: &usize| list(root, "nodes").get(*node)?.get("mesh").map(index);
        let meshes: BTreeSet<usize> = nodes.iter().filter_map(mesh).collect::<Option<_>>()?;
        let (mut accessors, mut materials) = (BTreeSet::new(), BTreeSet::new());
        for mesh in &meshes {
            let primitive = list(root, "meshes").get(*mesh)?.get("primitives")?.get(0)?;
            accessors.insert(index(primitive.get("attributes")?.get("POSITION")?)?);
            accessors.insert(index(primitive.get("indices")?)?);
            materials.insert(index(primitive.get("material")?)?);
        }
        let (mut views, mut bytes, mut buffer) = (BTreeSet::new(), None, None);
        for accessor in &accessors {
            let view = index(list(root, "accessors").get(*accessor)?.get("bufferView")?)?;
            if !views.insert(view) {
                continue;
            }
            let view = list(root, "bufferViews").get(view)?;
            let start = index(view.get("byteOffset")?)?;
            bytes = Some(bytes.map_or(start, |before: usize| before.min(start)));
            let of = index(view.get("buffer")?)?;
            if *buffer.get_or_insert(of) != of {
                return None;
            }
        }
        let end = |name: &str, of: &BTreeSet<usize>| {
            let (first, count) = (*of.first()?, list(root, name).len());
            (of.len() == count.checked_sub(first)? && *of.last()? + 1 == count).then_some(first)
        };
        // Materials that were there before may be used, too.
        let all_materials = list(root, "materials");
        let is_used = |material: &usize| materials.contains(material);
        let used = (0..all_materials.len()).rev().take_while(is_used).count();
        Some(Self {
            nodes: end("nodes", &nodes)?,
            meshes: end("meshes", &meshes)?,
            accessors: end("accessors", &accessors)?,
            views: end("bufferViews", &views)?,
            materials: all_materials.len() - used,
            buffer: buffer?,
            bytes: bytes?,
        })
    }
}

/// Whether a document refers to something at or beyond these ends. Extensions name what they refer
/// to as the core does; a number that refers to nothing may be taken for one that does.
fn refers_beyond(value: &Value, ends: &Ends) -> bool {
    let one = |value: &Value, end: usize| index(value).is_some_and(|index| index >= end);
    let any = |list: &Value, end: usize| {
        list.as_array().is_some_and(|list| list.iter().any(|value| one(value, end)))
    };
    let values = |object: &Value, end: usize| {
        object.as_object().is_some_and(|object| object.values().any(|value| one(value, end)))
    };
    match value {
        Value::Array(list) => list.iter().any(|value| refers_beyond(value, ends)),
        Value::Object(object) => object.iter().any(|(key, value)| {
            let is_beyond = match key.as_str() {
                "extras" => return false,
                "node" | "skeleton" => one(value, ends.nodes),
                "nodes" | "children" | "joints" => any(value, ends.nodes),
                "mesh" => one(value, ends.meshes),
                "meshes" => any(value, ends.meshes),
                "indices" | "input" | "output" | "inverseBindMatrices" => {
                    one(value, ends.accessors)
                }
                "attributes" => values(value, ends.accessors),
                "targets" => match value {
                    Value::Array(list) => list.iter().any(|of| values(of, ends.accessors)),
                    _ => false,
                },
                "bufferView" => one(value, ends.views),
                "material" => one(value, ends.materials),
                "materials" => any(value, ends.materials),
                _ => false,
            };
            is_beyond || refers_beyond(value, ends)
        }),
        _ => false,
    }
}

/// A document to which hulls are added.
#[derive(Clone)]
struct Growing {
    root: Value,
    /// The chunk of binary data, where hulls go there.
    binary: Vec<u8>,
    is_glb: bool,
}

/// The extension that [`PHYSICS`] depends on.
const SHAPES: &str = "KHR_implicit_shapes";

/// More colours than hulls that touch each other; each is a material of the file.
const COLOURS: usize = 32;

/// The bytes of a position.
const POSITION: usize = 3 * size_of::<f32>();

impl Growing {
    fn of(root: &Value, chunks: &Chunks<'_>) -> Self {
        let binary = chunks.binary.unwrap_or_default().to_vec();
        Self { root: root.clone(), binary, is_glb: chunks.is_glb }
    }

    /// The file's bytes. Text is indented as it was.
    fn into_bytes(self, chunks: &Chunks<'_>) -> Result<Vec<u8>, String> {
        if self.is_glb {
            return assemble(self.root.to_string().into_bytes(), self.binary, chunks.others);
        }
        let first_line = chunks.json.split(|byte| *byte == b'\n').nth(1).unwrap_or_default();
        let is_blank = |byte: &&u8| matches!(byte, b' ' | b'\t');
        let indent: Vec<u8> = first_line.iter().take_while(is_blank).copied().collect();
        if !chunks.json.trim_ascii_end().contains(&b'\n') {
            return Ok(self.root.to_string().into_bytes());
        }
        let mut bytes = Vec::new();
        let formatter = serde_json::ser::PrettyFormatter::with_indent(&indent);
        let mut serializer = serde_json::Serializer::with_formatter(&mut bytes, formatter);
        serde::Serialize::serialize(&self.root, &mut serializer)
            .map_err(|error| error.to_string())?;
        if chunks.json.ends_with(b"\n") {
            bytes.push(b'\n');
        }
        Ok(bytes)
    }

    /// The same without groups, each array up to its end.
    fn without(&self, groups: &[KnownGroup], ends: &Ends) -> Option<Self> {
        let mut stripped = self.clone();
        for group in groups {
            stripped.cut_off(group).ok()?;
        }
        let root = stripped.root.as_object_mut()?;
        for (name, end) in [
            ("nodes", ends.nodes),
            ("meshes", ends.meshes),
            ("accessors", ends.accessors),
            ("bufferViews", ends.views),
            ("materials", ends.materials),
        ] {
            truncate(root, name, end);
        }
        let buffers = root.get_mut("buffers")?.as_array_mut()?;
        let buffer = buffers.get_mut(ends.buffer)?.as_object_mut()?;
        if !buffer.contains_key("uri") && stripped.is_glb && ends.buffer == 0 {
            stripped.binary.truncate(ends.bytes);
            buffer.insert("byteLength".into(), json!(ends.bytes));
            if ends.bytes == 0 {
                truncate(root, "buffers", 0);
            }
        } else if ends.buffer + 1 == buffers.len() && ends.bytes == 0 {
            truncate(root, "buffers", ends.buffer);
        } else {
            return None;
        }
        for name in [SHAPES, PHYSICS] {
            let Some(used) = stripped.root.get("extensionsUsed").and_then(Value::as_array) else {
                continue;
            };
            let is_last = used.last().and_then(Value::as_str) == Some(name);
            let count = used.len() - usize::from(is_last && !uses(&stripped.root, name));
            truncate(stripped.root.as_object_mut()?, "extensionsUsed", count);
        }
        Some(stripped)
    }

    /// Takes a group off the node that it hangs from.
    fn cut_off(&mut self, group: &KnownGroup) -> Result<(), String> {
        let Some(parent) = group.parent else { return Ok(()) };
        let parent = node_mut(&mut self.root, parent)?;
        if let Some(Value::Array(children)) = parent.get_mut("children") {
            children.retain(|child| index(child) != Some(group.node));
            if children.is_empty() {
                parent.shift_remove("children");
            }
        }
        Ok(())
    }

    /// Adds groups of hulls.
    fn add(&mut self, form: HullForm, additions: &[Addition]) -> Result<(), String> {
        let mut data = HullData::default();
        let views = list(&self.root, "bufferViews").len();
        let used: Vec<&Addition> =
            additions.iter().filter(|of| !of.nodes.is_empty() && !of.hulls.is_empty()).collect();
        if used.is_empty() {
            return Ok(());
        }
        let has_short = used.iter().flat_map(|of| &of.hulls).any(is_short);
        for addition in used {
            let first = addition.nodes.first().copied().unwrap_or_default();
            let base = base_name(&self.root, first);
            let mut shown = Vec::new();
            for (number, hull) in addition.hulls.iter().enumerate() {
                let name = match form {
                    HullForm::Physics => format!("{base}_hull_{number:02}"),
                    HullForm::Ucx => format!("UCX_{base}_{number:02}"),
                };
                let positions = self.push("accessors", data.positions(hull, views)?)?;
                let indices = data.indices(hull, views + 1, has_short);
                let indices = self.push("accessors", indices)?;
                let primitive = json!({
                    "attributes": { "POSITION": positions },
                    "indices": indices,
                    "material": self.material(number % COLOURS)?,
                });
                let mesh = json!({ "name": name, "primitives": [primitive] });
                let mesh = self.push("meshes", mesh)?;
                shown.push(match form {
                    HullForm::Physics => {
                        let shape = json!({ "name": format!("{name}_shape"), "mesh": mesh });
                        self.push("nodes", shape)?
                    }
                    HullForm::Ucx => mesh,
                });
            }
            for &node in &addition.nodes {
                self.add_group(form, node, &addition.record, &shown)?;
            }
        }
        self.add_data(data)?;
        if form == HullForm::Physics {
            for extension in [PHYSICS, SHAPES] {
                let used = array(&mut self.root, "extensionsUsed")?;
                if !used.iter().any(|name| name.as_str() == Some(extension)) {
                    used.push(json!(extension));
                }
            }
        }
        Ok(())
    }

    /// `shown` are nodes with shapes, or meshes.
    fn add_group(
        &mut self,
        form: HullForm,
        node: usize,
        record: &HullsRecord,
        shown: &[usize],
    ) -> Result<(), String> {
        let base = base_name(&self.root, node);
        let mut hulls = Vec::new();
        for (number, shown) in shown.iter().enumerate() {
            hulls.push(match form {
                HullForm::Physics => {
                    let geometry = json!({ "node": shown, "convexHull": true });
                    let hull = json!({
                        "name": format!("{base}_hull_{number:02}"),
                        "extensions": { PHYSICS: { "collider": { "geometry": geometry } } },
                    });
                    self.push("nodes", hull)?
                }
                HullForm::Ucx => {
                    let name = format!("UCX_{base}_{number:02}");
                    self.push("nodes", json!({ "name": name, "mesh": shown }))?
                }
            });
        }
        let extras: Value =
            serde_json::from_str(&record.to_extras()).map_err(|error| error.to_string())?;
        let group = json!({ "name": format!("{base}_hulls"), "extras": extras, "children": hulls });
        let group = self.push("nodes", group)?;
        let parent = node_mut(&mut self.root, node)?;
        let children = parent.entry("children").or_insert_with(|| json!([]));
        let children = children
            .as_array_mut()
            .ok_or_else(|| format!("node {node}: its `children` are no list"))?;
        children.push(json!(group));
        Ok(())
    }

    /// Appends to an array of the document. The index there.
    fn push(&mut self, name: &str, value: Value) -> Result<usize, String> {
        let array = array(&mut self.root, name)?;
        array.push(value);
        Ok(array.len() - 1)
    }

    /// The material of a colour, which the file may have already.
    fn material(&mut self, number: usize) -> Result<usize, String> {
        let material = material(&format!("hullwright_hull_{number}"), number);
        let known = list(&self.root, "materials").iter().position(|known| *known == material);
        known.map_or_else(|| self.push("materials", material), Ok)
    }

    /// Adds the bytes of hulls, and the views of them.
    fn add_data(&mut self, data: HullData) -> Result<(), String> {
        let (buffer, start) = self.place_for_data()?;
        let mut bytes = Vec::new();
        let HullData { positions, shorts, ints } = data;
        for (part, target) in [(positions, VERTICES), (shorts, INDICES), (ints, INDICES)] {
            if part.is_empty() {
                continue;
            }
            let mut view = json!({
                "buffer": buffer,
                "byteOffset": start + bytes.len(),
                "byteLength": part.len(),
            });
            if target == VERTICES {
                view["byteStride"] = json!(POSITION);
            }
            view["target"] = json!(target);
            self.push("bufferViews", view)?;
            bytes.extend(part);
            bytes.resize(bytes.len().next_multiple_of(4), 0);
        }
        let is_chunk = self.is_glb && buffer == 0;
        if !is_chunk {
            let uri = format!("data:application/octet-stream;base64,{}", STANDARD.encode(&bytes));
            self.push("buffers", json!({ "byteLength": bytes.len(), "uri": uri }))?;
            return Ok(());
        }
        self.binary.resize(start, 0);
        self.binary.extend(bytes);
        let length = json!(self.binary.len());
        let buffers = array(&mut self.root, "buffers")?;
        match buffers.first_mut() {
            None => buffers.push(json!({ "byteLength": length })),
            Some(first) => {
                let first = first.as_object_mut().ok_or("its first buffer is no object")?;
                first.insert("byteLength".into(), length);
            }
        }
        Ok(())
    }

    /// The buffer that the data goes to, and where in it: the end of the chunk of a GLB, if its
    /// first buffer is that chunk, or none yet, else a new buffer.
    fn place_for_data(&self) -> Result<(usize, usize), String> {
        let buffers = list(&self.root, "buffers");
        let Some(first) = buffers.first() else { return Ok((0, self.end_of_chunk(0)?)) };
        let is_chunk = self.is_glb && first.get("uri").is_none() && !self.binary.is_empty();
        if !is_chunk {
            return Ok((buffers.len(), 0));
        }
        let length = first.get("byteLength").and_then(index);
        Ok((0, self.end_of_chunk(length.ok_or("its first buffer has no `byteLength`")?)?))
    }

    fn end_of_chunk(&self, buffer: usize) -> Result<usize, String> {
        let chunk = self.binary.len();
        if buffer > chunk {
            return Err(format!("its first buffer has {buffer} bytes, but its chunk {chunk}"));
        }
        Ok(chunk.next_multiple_of(4))
    }
}

/// The bytes of hulls, by kind.
#[derive(Default)]
struct HullData {
    positions: Vec<u8>,
    shorts: Vec<u8>,
    ints: Vec<u8>,
}

fn is_short(hull: &WrittenHull) -> bool {
    hull.points.len() <= MOST_SHORT_INDICES
}

impl HullData {
    /// The accessor of a hull's points.
    fn positions(&mut self, hull: &WrittenHull, view: usize) -> Result<Value, String> {
        let pick = |pick: fn(f32, f32) -> f32| {
            let all = hull.points.iter().copied();
            all.reduce(|a, b| std::array::from_fn(|axis| pick(a[axis], b[axis])))
        };
        let bounds = pick(f32::min).zip(pick(f32::max));
        let (min, max) = bounds.ok_or("a hull has no points")?;
        let offset = self.positions.len();
        self.positions.extend(hull.points.as_flattened().iter().flat_map(|x| x.to_le_bytes()));
        Ok(json!({
            "bufferView": view,
            "byteOffset": offset,
            "componentType": FLOAT,
            "count": hull.points.len(),
            "type": "VEC3",
            "min": min,
            "max": max,
        }))
    }

    /// The accessor of a hull's triangles. `view` is the first of indices.
    fn indices(&mut self, hull: &WrittenHull, view: usize, has_short: bool) -> Value {
        let indices = hull.triangles.as_flattened().iter();
        let (view, offset, component) = if is_short(hull) {
            let offset = self.shorts.len();
            self.shorts.extend(indices.flat_map(|index| (*index as u16).to_le_bytes()));
            (view, offset, UNSIGNED_SHORT)
        } else {
            let offset = self.ints.len();
            self.ints.extend(indices.flat_map(|index| index.to_le_bytes()));
            (view + usize::from(has_short), offset, UNSIGNED_INT)
        };
        json!({
            "bufferView": view,
            "byteOffset": offset,
            "componentType": component,
            "count": hull.triangles.len() * 3,
            "type": "SCALAR",
        })
    }
}

/// The entries of an array of the document; of anything else none.
fn list<'a>(root: &'a Value, name: &str) -> &'a [Value] {
    root.get(name).and_then(Value::as_array).map_or(&[], Vec::as_slice)
}

/// An array of the document, which is made if it is missing.
fn array<'a>(root: &'a mut Value, name: &str) -> Result<&'a mut Vec<Value>, String> {
    let root = root.as_object_mut().ok_or("its JSON is no object")?;
    let entry = root.entry(name).or_insert(Value::Null);
    if entry.is_null() {
        *entry = json!([]);
    }
    entry.as_array_mut().ok_or_else(|| format!("its `{name}` is no list"))
}

/// Shortens an array of the document. One without entries may not be there.
fn truncate(root: &mut Map<String, Value>, name: &str, length: usize) {
    if let Some(Value::Array(array)) = root.get_mut(name) {
        array.truncate(length);
        if array.is_empty() {
            root.shift_remove(name);
        }
    }
}

fn node_mut(root: &mut Value, node: usize) -> Result<&mut Map<String, Value>, String> {
    let found = array(root, "nodes")?.get_mut(node).and_then(Value::as_object_mut);
    found.ok_or_else(|| format!("there is no node {node}"))
}

/// A whole number. Some programs write it as `8.0`.
fn index(value: &Value) -> Option<usize> {
    let number = value.as_f64().filter(|x| x.fract() == 0.0)?;
    (0.0..=f64::from(u32::MAX)).contains(&number).then_some(number as usize)
}

/// The name of a node, else of its mesh, else one of its number.
fn base_name(root: &Value, node: usize) -> String {
    let name = |of: &Value| {
        let name = of.get("name").and_then(Value::as_str)?;
        (!name.is_empty()).then(|| name.to_owned())
    };
    let found = list(root, "nodes").get(node);
    let mesh = || list(root, "meshes").get(found?.get("mesh").and_then(index)?);
    let named = found.and_then(name).or_else(|| mesh().and_then(name));
    named.unwrap_or_else(|| format!("node_{node}"))
}

/// Whether a node has a collider or trigger of its own.
fn has_collider(root: &Value, node: usize) -> bool {
    let extensions = list(root, "nodes").get(node).and_then(|node| node.get("extensions"));
    let has = |extension: &str, key: &str| {
        let found = extensions.and_then(|all| all.get(extension)?.get(key));
        found.is_some_and(|value| !value.is_null())
    };
    [PHYSICS, "OMI_physics_body"]
        .iter()
        .any(|extension| has(extension, "collider") || has(extension, "trigger"))
}

/// Whether an extension is used somewhere in a document.
fn uses(value: &Value, extension: &str) -> bool {
    match value {
        Value::Array(list) => list.iter().any(|value| uses(value, extension)),
        Value::Object(object) => {
            let is_used = |value: &Value| value.get(extension).is_some();
            object.get("extensions").is_some_and(is_used)
                || object.values().any(|value| uses(value, extension))
        }
        _ => false,
    }
}
