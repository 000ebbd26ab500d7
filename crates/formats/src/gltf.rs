//! glTF 2.0 and GLB: the triangles of the scene.
//!
//! Only what geometry needs is read, each index checked. Typed readers of whole documents refuse
//! files over animations, cameras or materials, and panic on accessors beyond their buffer. Nodes
//! must form trees; a node that is reached twice is an error, which also stops cycles. Compressed
//! data is preferred to an uncompressed copy beside it.

use std::borrow::Cow;
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

use glam::DAffine3;
use hullwright::Sidedness;
use hullwright::hulls_format::MeshPart;

use super::gltf_data::{Beside, Data, DracoMesh, DracoStream};
use super::gltf_extensions::{INSTANCING, check_required};
use super::gltf_groups::{Group, Groups, HullNode};
use super::gltf_json::{
    Document, FIRST_VERSION, entries, entry, indices, is_true, key, list, needed_number,
    optional_number, text, whole,
};
use super::gltf_nodes::{
    Instances, are_children, global_transforms, instance_transforms, is_hidden, transform,
};
use super::gltf_skins::{Effect, Pose, Skin, Vectors};
use super::gltf_tree::Json;
use super::mesh_file::{MeshFile, SceneMesh, SceneNode, name_of_part, next_index, split_objects};
use super::notes::{Note, NoteKind};

/// A small file can place a mesh any number of times. A scene may have this many vertices and
/// this many triangles, and one more for each byte that was read and for each element that was
/// decompressed, so that what a file holds can always be placed at least once.
const PLACED_FOR_FREE: usize = 1 << 22;

/// A GLB begins with a magic number, its version and its length, each of four bytes.
pub(super) const GLB_HEADER: usize = 12;

/// A chunk begins with its length and its kind, each of four bytes.
const CHUNK_HEADER: usize = 8;

/// All meshes of the scene, each node's transform applied.
pub(super) fn read(bytes: &[u8], beside: Beside<'_>) -> Result<MeshFile, String> {
    read_with(bytes, beside, |scene| {
        scene.read()?;
        scene.file.notes = scene.take_notes();
        Ok(())
    })
}

/// Each mesh of the document once, in its own space, whether a scene shows it or not, with its
/// extras and those of its nodes.
pub(super) fn read_scene(bytes: &[u8], beside: Beside<'_>) -> Result<Vec<SceneMesh>, String> {
    let mut told = Vec::new();
    let file = read_with(bytes, beside, |scene| {
        let groups = &Groups::of(scene.document)?;
        let with_hulls: BTreeSet<usize> =
            groups.list.iter().filter_map(|group| group.parent).collect();
        let nodes_of = nodes_of_meshes(scene.document);
        let transforms = global_transforms(&scene.document.nodes);
        for (index, mut nodes) in nodes_of.into_iter().enumerate() {
            // Hulls of another mesh are none of their own.
            let is_shown = !nodes.is_empty();
            nodes.retain(|(node, _)| !groups.contain(*node));
            if is_shown && nodes.is_empty() {
                continue;
            }
            let (objects, parts) = (scene.file.objects.len(), scene.file.parts.list.len());
            scene.add_own_space(index)?;
            scene.note_skins(index, &nodes);
            let notes = scene.take_notes();
            // A mesh without triangles is no object.
            if scene.file.objects.len() > objects {
                let extras = entries(&scene.document.meshes).get(index).and_then(extras);
                let scene_node = |(index, node)| SceneNode {
                    index: Some(index as u32),
                    has_hulls: with_hulls.contains(&index),
                    transform: transforms.get(index).copied().flatten().map(columns),
                    ..scene_node(node)
                };
                let nodes = nodes.into_iter().map(scene_node).collect();
                let parts = parts..scene.file.parts.list.len();
                told.push((Some(index as u32), parts, extras, nodes, notes));
            }
        }
        Ok(())
    })?;
    let meshes = split_objects(&file).into_iter().zip(&file.objects).zip(told);
    let meshes = meshes.map(|((named, object), (index, parts, extras, nodes, notes))| SceneMesh {
        name: named.name,
        index,
        mesh: named.mesh,
        parts: file.parts.slice(parts, object.triangles.clone()),
        extras,
        nodes,
        notes,
    });
    Ok(meshes.collect())
}

/// The groups of hulls of a document.
#[derive(Default)]
pub(super) struct HullGroups {
    pub(super) groups: Vec<Group>,
    /// The extras of each group.
    pub(super) extras: Vec<String>,
    /// For each group the index of its hulls among `sets`: groups of nodes that show one mesh have
    /// the same.
    pub(super) set_of: Vec<usize>,
    pub(super) sets: Vec<Vec<RawHull>>,
}

/// A hull as its mesh holds it, in the space of the node that shows the mesh.
#[derive(Clone)]
pub(super) struct RawHull {
    pub(super) positions: Vec<[f64; 3]>,
    pub(super) triangles: Vec<[u32; 3]>,
}

/// The groups of hulls of a document, in the order of their nodes.
pub(super) fn read_hull_groups(bytes: &[u8], beside: Beside<'_>) -> Result<HullGroups, String> {
    let mut read = HullGroups::default();
    read_with(bytes, beside, |scene| {
        let groups = Groups::of(scene.document)?;
        let mut known: BTreeMap<Vec<(usize, [u64; 12])>, usize> = BTreeMap::new();
        for group in groups.list {
            let place =
                |hull: &HullNode| (hull.mesh, hull.transform.to_cols_array().map(f64::to_bits));
            let set = match known.entry(group.hulls.iter().map(place).collect()) {
                Entry::Occupied(known) => *known.get(),
                Entry::Vacant(new) => {
                    let at_group = |reason| format!("hulls at node {}: {reason}", group.node);
                    let hulls = group.hulls.iter().map(|hull| scene.raw_hull(hull));
                    read.sets.push(hulls.collect::<Result<_, _>>().map_err(at_group)?);
                    *new.insert(read.sets.len() - 1)
                }
            };
            let node = entry(&scene.document.nodes, "node", group.node)?;
            read.extras.push(extras(node).unwrap_or_default());
            read.set_of.push(set);
            read.groups.push(group);
        }
        Ok(())
    })?;
    Ok(read)
}

fn read_with(
    bytes: &[u8],
    beside: Beside<'_>,
    read: impl FnOnce(&mut Scene<'_>) -> Result<(), String>,
) -> Result<MeshFile, String> {
    let Chunks { json, binary: chunk, .. } = Chunks::of(bytes)?;
    let document = Document::parse(json)?;
    for extension in entries(&document.extensions_required) {
        check_required(extension.as_str().unwrap_or_default())?;
    }
    let mut scene = Scene {
        document: &document,
        data: Data::new(&document, chunk, beside, bytes.len()),
        decompressed: BTreeMap::new(),
        globals: None,
        parts: BTreeMap::new(),
        morphed: BTreeSet::new(),
        looked_up: 0,
        file: MeshFile::default(),
    };
    read(&mut scene)?;
    Ok(scene.file)
}

/// The parts of a file.
#[derive(Clone, Copy)]
pub(super) struct Chunks<'a> {
    pub(super) json: &'a [u8],
    /// The chunk of binary data of a GLB, if there is one.
    pub(super) binary: Option<&'a [u8]>,
    /// The other chunks of a GLB, with their headers.
    pub(super) others: &'a [u8],
    pub(super) is_glb: bool,
}

impl<'a> Chunks<'a> {
    pub(super) fn of(bytes: &'a [u8]) -> Result<Self, String> {
        match bytes.starts_with(b"glTF") {
            true => split_glb(bytes),
            false => Ok(Self { json: bytes, binary: None, others: &[], is_glb: false }),
        }
    }
}

fn split_glb(bytes: &[u8]) -> Result<Chunks<'_>, String> {
    let header = bytes.first_chunk::<GLB_HEADER>().map(|header| header.as_chunks::<4>().0);
    let Some(&[_, version, length]) = header else {
        return Err(format!("GLB: it ends within its header of {GLB_HEADER} bytes"));
    };
    match u32::from_le_bytes(version) {
        2 => {}
        1 => return Err(FIRST_VERSION.into()),
        other => {
            return Err(format!("GLB: its version is {other}, and version 2 would be read"));
        }
    }
    let length = u32::from_le_bytes(length) as usize;
    if length < GLB_HEADER || length > bytes.len() {
        return Err(format!("its header announces {length} bytes, but it has {}", bytes.len()));
    }
    let (json, rest) = split_chunk(&bytes[GLB_HEADER..length], b"JSON")?;
    let json = json.ok_or("GLB: its first chunk is of another kind, and JSON would be read")?;
    let (binary, others) = split_chunk(rest, b"BIN\0")?;
    // Some exporters fill the chunk up with zeros, not with spaces.
    let end = json.iter().rposition(|byte| *byte != 0).map_or(0, |last| last + 1);
    Ok(Chunks { json: &json[..end], binary, others, is_glb: true })
}

/// The first chunk, if it is of this kind, and what follows it.
fn split_chunk<'a>(
    bytes: &'a [u8],
    kind: &[u8; 4],
) -> Result<(Option<&'a [u8]>, &'a [u8]), String> {
    let Some((header, rest)) = bytes.split_first_chunk::<CHUNK_HEADER>() else {
        return Ok((None, bytes));
    };
    let [a, b, c, d, found @ ..] = *header;
    if found != *kind {
        return Ok((None, bytes));
    }
    let length = u32::from_le_bytes([a, b, c, d]) as usize;
    match rest.split_at_checked(length) {
        Some((chunk, rest)) => Ok((Some(chunk), rest)),
        None => Err(format!(
            "GLB: a chunk announces {length} bytes, but {} follow its header",
            rest.len()
        )),
    }
}

struct Scene<'a> {
    document: &'a Document<'a>,
    data: Data<'a>,
    /// A mesh may be placed many times, and a Draco stream may be used by many primitives.
    decompressed: BTreeMap<DracoStream, Rc<DracoMesh>>,
    /// The transforms of all nodes, once a skin needs them.
    globals: Option<Rc<[Option<DAffine3>]>>,
    /// The parts of primitives, which are known by the numbers of mesh and primitive.
    parts: BTreeMap<(usize, usize), u32>,
    /// Meshes with morph targets that have a weight at rest.
    morphed: BTreeSet<usize>,
    /// Elements that were read for skins and instances.
    looked_up: usize,
    file: MeshFile,
}

/// Where vertices come from.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Source {
    Accessor(usize),
    Draco(DracoStream),
}

/// The vertices of a mesh that are in the scene already: where the first is, and how many there
/// are.
type Placed = BTreeMap<Source, (u32, usize)>;

impl Scene<'_> {
    /// All meshes, in the order of the node trees.
    fn read(&mut self) -> Result<(), String> {
        let nodes = entries(&self.document.nodes);
        if nodes.is_empty() {
            for index in 0..entries(&self.document.meshes).len() {
                self.add_mesh(index, None, &DAffine3::IDENTITY)?;
            }
            return Ok(());
        }
        let groups = Groups::of(self.document)?;
        let mut is_reached = vec![false; nodes.len()];
        for tree in self.trees()? {
            if is_reached.get(tree) == Some(&true) {
                // Scenes may share trees, and a scene may name one twice.
                continue;
            }
            let mut open = vec![(tree, DAffine3::IDENTITY)];
            while let Some((index, parent)) = open.pop() {
                let node = entry(&self.document.nodes, "node", index)?;
                if std::mem::replace(&mut is_reached[index], true) {
                    return Err(format!(
                        "node {index} has two parents or is inside of itself, and a tree would be read"
                    ));
                }
                // Hulls are no part of the mesh that they are of.
                if groups.contain(index) {
                    continue;
                }
                if is_hidden(node) {
                    self.file.note(NoteKind::HiddenNodes, 1);
                    continue;
                }
                let at_node = |reason: String| format!("node {index}: {reason}");
                let transform = parent * transform(node).map_err(at_node)?;
                self.add_node(node, &transform).map_err(at_node)?;
                let children = indices(node, "children").map_err(at_node)?;
                open.extend(children.into_iter().rev().map(|child| (child, transform)));
            }
        }
        Ok(())
    }

    /// The mesh of a node, once or as its instances.
    fn add_node(&mut self, node: &Json<'_>, transform: &DAffine3) -> Result<(), String> {
        let Some(mesh) = optional_number(node, "mesh")? else { return Ok(()) };
        let name = text(node, "name");
        if has_weight(node) {
            self.note_morph(mesh);
        }
        let Some(instances) = Instances::of(node)? else {
            let start = self.file.mesh.triangles.len();
            let placed = self.add_mesh(mesh, name, transform)?;
            if let Ok(Some(skin)) = optional_number(node, "skin") {
                self.apply_skin((skin, mesh), transform, &placed, start);
            }
            return Ok(());
        };
        let instances =
            self.instances(&instances).map_err(|reason| format!("{INSTANCING}: {reason}"))?;
        for instance in instances {
            let (vertices, triangles) =
                (self.file.mesh.positions.len(), self.file.mesh.triangles.len());
            self.add_mesh(mesh, name, &(*transform * instance))?;
            // Nothing any number of times, which would take time without end.
            if vertices == self.file.mesh.positions.len()
                && triangles == self.file.mesh.triangles.len()
            {
                break;
            }
        }
        Ok(())
    }

    fn instances(&mut self, of: &Instances) -> Result<Vec<DAffine3>, String> {
        let translation = of.translation.map(|index| self.vectors(index)).transpose()?;
        let rotation = of.rotation.map(|index| self.vectors(index)).transpose()?;
        let scale = of.scale.map(|index| self.vectors(index)).transpose()?;
        instance_transforms(translation, rotation, scale)
    }

    fn raw_hull(&mut self, hull: &HullNode) -> Result<RawHull, String> {
        let mesh = &self.file.mesh;
        let (vertex, triangle) = (mesh.positions.len(), mesh.triangles.len());
        self.add_mesh(hull.mesh, None, &hull.transform)?;
        let mesh = &self.file.mesh;
        let triangles = mesh.triangles.iter().skip(triangle);
        let first = vertex as u32;
        Ok(RawHull {
            positions: mesh.positions.iter().skip(vertex).copied().collect(),
            triangles: triangles.map(|corners| corners.map(|index| index - first)).collect(),
        })
    }

    fn add_own_space(&mut self, index: usize) -> Result<(), String> {
        let name = mesh_name(entry(&self.document.meshes, "mesh", index)?, index);
        self.add_mesh(index, Some(&name), &DAffine3::IDENTITY).map(drop)
    }

    /// The roots of the default scene, or else of all scenes, or else of all nodes.
    fn trees(&mut self) -> Result<Vec<usize>, String> {
        let Document { nodes, scenes, scene, .. } = self.document;
        let scenes = entries(scenes);
        let roots = |(index, scene): (usize, &Json<'_>)| {
            indices(scene, "nodes").map_err(|reason| format!("scene {index}: {reason}"))
        };
        if let Some(default) = whole(scene)
            && let Some(found) = scenes.get(default)
        {
            return roots((default, found));
        }
        if *scene != Json::Null {
            self.file.note(NoteKind::MissingScenes, 1);
        }
        if !scenes.is_empty() {
            let all: Vec<Vec<usize>> =
                scenes.iter().enumerate().map(roots).collect::<Result<_, _>>()?;
            return Ok(all.concat());
        }
        let is_child = are_children(entries(nodes));
        let roots = is_child.iter().enumerate().filter(|(_, is_child)| !**is_child);
        Ok(roots.map(|(index, _)| index).collect())
    }

    fn add_mesh(
        &mut self,
        index: usize,
        node_name: Option<&str>,
        transform: &DAffine3,
    ) -> Result<Placed, String> {
        let mesh = entry(&self.document.meshes, "mesh", index)?;
        let start = self.file.mesh.triangles.len();
        // Primitives often share their vertices, each with a material of its own.
        let mut placed = Placed::new();
        let primitives =
            list(mesh, "primitives").map_err(|reason| format!("mesh {index}: {reason}"))?;
        for (number, primitive) in primitives.iter().enumerate() {
            self.add_primitive(primitive, transform, &mut placed)
                .and_then(|()| self.close_part((index, number), primitive))
                .map_err(|reason| format!("mesh {index}, primitive {number}: {reason}"))?;
        }
        if has_weight(mesh) {
            self.note_morph(index);
        }
        let name = node_name.or(text(mesh, "name")).unwrap_or_default();
        self.file.close_object(name, start);
        Ok(placed)
    }

    fn add_primitive(
        &mut self,
        primitive: &Json<'_>,
        transform: &DAffine3,
        placed: &mut Placed,
    ) -> Result<(), String> {
        let Some(mode) = Mode::of(primitive)? else { return Ok(()) };
        let attributes = key(primitive, "attributes").unwrap_or(&Json::Null);
        let Some(accessor) = optional_number(attributes, "POSITION")? else { return Ok(()) };
        let is_normalized = entries(&self.document.accessors)
            .get(accessor)
            .is_some_and(|accessor| is_true(accessor, "normalized"));
        let stream = DracoStream::of(primitive, is_normalized)?;
        let geometry = stream.map(|stream| self.decompressed(stream)).transpose()?;
        let source = stream.map_or(Source::Accessor(accessor), Source::Draco);
        let (first, count) = match placed.get(&source) {
            Some(known) => *known,
            None => {
                let positions = match &geometry {
                    Some(geometry) => Cow::Borrowed(&geometry.positions),
                    None => Cow::Owned(self.data.positions(accessor)?),
                };
                let count = positions.len();
                self.check_growth("vertices", self.file.mesh.positions.len(), count)?;
                let first = next_index(&self.file.mesh.positions, count)?;
                let places = positions.iter().map(|&p| transform.transform_point3(p.into()));
                self.file.mesh.positions.extend(places.map(|place| place.to_array()));
                placed.insert(source, (first, count));
                (first, count)
            }
        };
        // Draco holds triangles one by one, in whatever mode the primitive announces them.
        let mode = if geometry.is_some() { Mode::Triangles } else { mode };
        let indices = match (&geometry, optional_number(primitive, "indices")?) {
            (Some(geometry), _) => Cow::Borrowed(&geometry.indices),
            (None, Some(accessor)) => Cow::Owned(self.data.indices(accessor)?),
            (None, None) => Cow::Owned((0..count as u32).collect()),
        };
        if let Some(index) = indices.iter().find(|index| **index as usize >= count) {
            return Err(format!("index {index} is beyond its {count} vertices"));
        }
        // Strips and fans have about as many triangles as indices.
        let corners = if mode == Mode::Triangles { 3 } else { 1 };
        let more = indices.len() / corners;
        self.check_growth("triangles", self.file.mesh.triangles.len(), more)?;
        let is_cut_off = match mode {
            Mode::Triangles => !indices.len().is_multiple_of(3),
            Mode::Strip | Mode::Fan => matches!(indices.len(), 1 | 2),
        };
        self.file.note(NoteKind::IncompleteTriangles, usize::from(is_cut_off));
        // Left and right change places.
        let is_mirrored = transform.matrix3.determinant() < 0.0;
        self.file.mesh.triangles.extend(mode.triangles(&indices).map(|triangle| {
            let [a, b, c] = triangle.map(|index| first + index);
            if is_mirrored { [a, c, b] } else { [a, b, c] }
        }));
        // Without a material a renderer draws one side.
        let sidedness = match material(self.document, primitive) {
            Some(material) if is_true(material, "doubleSided") => Sidedness::Two,
            _ => Sidedness::One,
        };
        self.file.mesh.sidedness.resize(self.file.mesh.triangles.len(), sidedness);
        Ok(())
    }

    /// Gives the triangles of a primitive, which are the last, their part.
    fn close_part(&mut self, id: (usize, usize), primitive: &Json<'_>) -> Result<(), String> {
        let triangles = self.file.mesh.triangles.len();
        let parts = &mut self.file.parts;
        if parts.of_triangles.len() == triangles {
            return Ok(());
        }
        let part = match self.parts.get(&id) {
            Some(known) => *known,
            None => {
                let (mesh, number) = id;
                let name = mesh_name(entry(&self.document.meshes, "mesh", mesh)?, mesh);
                let material = material(self.document, primitive);
                let material = material.and_then(|material| text(material, "name"));
                let [name, material] = [&name, material.unwrap_or_default()].map(name_of_part);
                let part = parts.add(MeshPart::new(name, number as u32, material));
                self.parts.insert(id, part);
                part
            }
        };
        parts.of_triangles.resize(triangles, part);
        Ok(())
    }

    fn decompressed(&mut self, stream: DracoStream) -> Result<Rc<DracoMesh>, String> {
        if let Some(geometry) = self.decompressed.get(&stream) {
            return Ok(Rc::clone(geometry));
        }
        let geometry = Rc::new(self.data.draco(stream)?);
        self.decompressed.insert(stream, Rc::clone(&geometry));
        Ok(geometry)
    }

    /// Refuses to let an array of the scene grow too long.
    fn check_growth(&mut self, what: &str, present: usize, more: usize) -> Result<(), String> {
        let most = PLACED_FOR_FREE + self.data.elements_read();
        if present + more > most {
            return Err(format!("placed here once more, the scene has over {most} {what}"));
        }
        Ok(())
    }

    /// What was left out or mended since the last call.
    fn take_notes(&mut self) -> Vec<Note> {
        self.file.note(NoteKind::MendedBase64, std::mem::take(&mut self.data.mended));
        let morphed = std::mem::take(&mut self.morphed).len();
        self.file.note(NoteKind::IgnoredMorphTargets, morphed);
        std::mem::take(&mut self.file.notes)
    }

    /// Notes a mesh that has morph targets for its weights.
    fn note_morph(&mut self, mesh: usize) {
        if self.morphed.contains(&mesh) {
            return;
        }
        let primitives = entries(&self.document.meshes).get(mesh);
        let primitives = primitives.and_then(|mesh| list(mesh, "primitives").ok());
        let has_targets =
            |primitive: &Json<'_>| list(primitive, "targets").is_ok_and(|t| !t.is_empty());
        if primitives.into_iter().flatten().any(has_targets) {
            self.morphed.insert(mesh);
        }
    }
}

/// Skins. What can't be read of them is left out, since the mesh is there without.
impl Scene<'_> {
    /// Puts the vertices of a mesh, and turns its triangles from `start`, as its skin's joints say,
    /// if they move all of it.
    fn apply_skin(
        &mut self,
        (skin, mesh): (usize, usize),
        transform: &DAffine3,
        placed: &Placed,
        start: usize,
    ) {
        let Some(poses) = self.noted_poses((skin, mesh), transform, NoteKind::AppliedSkins) else {
            return;
        };
        let is_mirrored = transform.matrix3.determinant() < 0.0;
        if poses.first().is_some_and(|(_, pose)| pose.is_mirrored != is_mirrored) {
            let triangles = self.file.mesh.triangles.iter_mut().skip(start);
            triangles.for_each(|triangle| triangle.swap(1, 2));
        }
        for (accessor, pose) in poses {
            let Some((first, _)) = placed.get(&Source::Accessor(accessor)) else { continue };
            let first = *first as usize;
            let slots = self.file.mesh.positions.iter_mut().skip(first);
            for (slot, position) in slots.zip(pose.positions) {
                *slot = position.to_array();
            }
        }
    }

    /// Notes the first skin of a mesh that moves it, since in its own space the mesh stands as it
    /// was modelled.
    fn note_skins(&mut self, mesh: usize, nodes: &[(usize, &Json<'_>)]) {
        let skinned = |(index, node): &(usize, &Json<'_>)| {
            Some((*index, optional_number(node, "skin").ok().flatten()?))
        };
        let Some((node, skin)) = nodes.iter().find_map(skinned) else { return };
        let Some(transform) = self.globals().get(node).copied().flatten() else { return };
        let _ = self.noted_poses((skin, mesh), &transform, NoteKind::IgnoredSkins);
    }

    /// Where a skin puts the primitives of a mesh if it moves all of the mesh, and a note of what
    /// it does. `move_of_all` is the kind for that.
    fn noted_poses(
        &mut self,
        (skin, mesh): (usize, usize),
        transform: &DAffine3,
        move_of_all: NoteKind,
    ) -> Option<Vec<(usize, Pose)>> {
        let (kind, poses) = match self.rest_poses(skin, mesh, transform) {
            Ok((Effect::Nothing, _)) => return None,
            Ok((Effect::Pose, _)) => (NoteKind::PosingSkins, None),
            Ok((Effect::MoveOfAll, poses)) => (move_of_all, Some(poses)),
            Err(_) => (NoteKind::UnreadableSkins, None),
        };
        self.file.note(kind, 1);
        poses
    }

    /// Where a skin puts the primitives of a mesh, and what it does to what the transform places.
    fn rest_poses(
        &mut self,
        skin: usize,
        mesh: usize,
        transform: &DAffine3,
    ) -> Result<(Effect, Vec<(usize, Pose)>), String> {
        let mesh = entry(&self.document.meshes, "mesh", mesh)?;
        let globals = self.globals();
        let skin = entry(&self.document.skins, "skin", skin)?;
        self.spend(list(skin, "joints")?.len())?;
        let skin = Skin::read(skin, &globals, self)?;
        let mut poses = Vec::new();
        let (mut places, mut posed) = (Vec::new(), Vec::new());
        let mut sources = BTreeSet::new();
        for primitive in list(mesh, "primitives")? {
            let attributes = key(primitive, "attributes").unwrap_or(&Json::Null);
            let Some(accessor) = optional_number(attributes, "POSITION")? else { continue };
            if Mode::of(primitive)?.is_none() || !sources.insert(accessor) {
                continue;
            }
            if DracoStream::of(primitive, false)?.is_some() {
                return Err("its joints are compressed".into());
            }
            self.look_up(accessor)?;
            let positions = self.data.positions(accessor)?;
            let Some(pose) = skin.pose(primitive, &positions, self)? else { continue };
            if !pose.positions.iter().all(|position| position.is_finite()) {
                return Err("it puts a vertex nowhere".into());
            }
            places.extend(positions.iter().map(|&p| transform.transform_point3(p.into())));
            posed.extend_from_slice(&pose.positions);
            poses.push((accessor, pose));
        }
        Ok((Effect::of(&places, &posed), poses))
    }

    fn globals(&mut self) -> Rc<[Option<DAffine3>]> {
        let nodes = &self.document.nodes;
        Rc::clone(self.globals.get_or_insert_with(|| global_transforms(nodes).into()))
    }

    /// Counts the elements of an accessor that skins and instances may use any number of times.
    fn look_up(&mut self, accessor: usize) -> Result<(), String> {
        let count = needed_number(entry(&self.document.accessors, "accessor", accessor)?, "count")?;
        self.spend(count).map_err(|reason| format!("accessor {accessor}: {reason}"))
    }

    fn spend(&mut self, elements: usize) -> Result<(), String> {
        self.looked_up = self.looked_up.saturating_add(elements);
        match self.looked_up > PLACED_FOR_FREE + self.data.elements_read() {
            true => Err("it is used more often than the file's size allows".into()),
            false => Ok(()),
        }
    }

    fn vectors<const N: usize>(&mut self, accessor: usize) -> Result<Vec<[f64; N]>, String> {
        self.look_up(accessor)?;
        self.data.vectors(accessor)
    }
}

impl Vectors for Scene<'_> {
    fn fours(&mut self, accessor: usize) -> Result<Vec<[f64; 4]>, String> {
        self.vectors(accessor)
    }

    fn matrices(&mut self, accessor: usize) -> Result<Vec<[f64; 16]>, String> {
        self.vectors(accessor)
    }
}

/// Whether morph targets have a weight at rest.
fn has_weight(of: &Json<'_>) -> bool {
    list(of, "weights").unwrap_or_default().iter().any(|weight| weight.as_f64() != Some(0.0))
}

fn extras(of: &Json<'_>) -> Option<String> {
    match key(of, "extras") {
        Some(Json::Extras(text)) => Some((*text).to_owned()),
        _ => None,
    }
}

/// The name of a mesh, or one of its number.
fn mesh_name<'a>(mesh: &'a Json<'_>, index: usize) -> Cow<'a, str> {
    let name = text(mesh, "name").filter(|name| !name.is_empty());
    name.map_or_else(|| format!("mesh_{index}").into(), Cow::Borrowed)
}

fn material<'a>(document: &'a Document<'a>, primitive: &Json<'_>) -> Option<&'a Json<'a>> {
    let index = optional_number(primitive, "material").ok().flatten()?;
    entries(&document.materials).get(index)
}

fn columns(transform: DAffine3) -> [[f64; 3]; 4] {
    let DAffine3 { matrix3, translation } = transform;
    [matrix3.x_axis, matrix3.y_axis, matrix3.z_axis, translation].map(Into::into)
}

fn scene_node(node: &Json<'_>) -> SceneNode {
    let name = text(node, "name").unwrap_or_default().to_owned();
    SceneNode { name, extras: extras(node), ..SceneNode::default() }
}

/// The nodes that show each mesh, with their indices.
fn nodes_of_meshes<'a>(document: &'a Document<'a>) -> Vec<Vec<(usize, &'a Json<'a>)>> {
    let mut nodes_of = vec![Vec::new(); entries(&document.meshes).len()];
    for (index, node) in entries(&document.nodes).iter().enumerate() {
        let mesh = optional_number(node, "mesh").ok().flatten();
        if let Some(nodes) = mesh.and_then(|mesh| nodes_of.get_mut(mesh)) {
            nodes.push((index, node));
        }
    }
    nodes_of
}

/// How indices make triangles.
#[derive(Clone, Copy, PartialEq)]
enum Mode {
    Triangles,
    Strip,
    Fan,
}

impl Mode {
    /// `None` for points and lines.
    fn of(primitive: &Json<'_>) -> Result<Option<Self>, String> {
        match optional_number(primitive, "mode")?.unwrap_or(4) {
            0..=3 => Ok(None),
            4 => Ok(Some(Self::Triangles)),
            5 => Ok(Some(Self::Strip)),
            6 => Ok(Some(Self::Fan)),
            other => Err(format!("its `mode` is {other}, and 0 to 6 would be read")),
        }
    }

    /// The triangles of a list, strip or fan of indices. The last ones that make none are left out.
    fn triangles(self, indices: &[u32]) -> Box<dyn Iterator<Item = [u32; 3]> + '_> {
        match (self, indices) {
            (Self::Fan, [centre, rim @ ..]) => {
                Box::new(rim.windows(2).map(|pair| [*centre, pair[0], pair[1]]))
            }
            (Self::Strip, _) => {
                // Every other triangle of a strip is wound the other way.
                Box::new(indices.windows(3).enumerate().map(|(number, corners)| {
                    let (second, third) = if number % 2 == 0 { (1, 2) } else { (2, 1) };
                    [corners[0], corners[second], corners[third]]
                }))
            }
            _ => Box::new(indices.as_chunks::<3>().0.iter().copied()),
        }
    }
}
