//! Bakes the meshes of a scene into one file, so that a game decomposes nothing when it
//! starts.
//!
//! ```
//! use hullwright_formats::bake::{BakeOptions, bake_jobs};
//! use hullwright::hulls_format::HullScene;
//! use hullwright::Control;
//!
//! let meshes = hullwright_formats::read_scene("../../assets/props.glb")?;
//! let jobs = bake_jobs(meshes, &BakeOptions::default());
//! # let jobs = &jobs[..1];
//! let meshes = jobs.iter().map(|job| job.run(&Control::new())).collect::<Result<_, _>>()?;
//! let scene = HullScene::new("props", meshes);
//! # let directory = tempfile::tempdir()?;
//! # let path = directory.path().join("props.hullscene");
//! hullwright_formats::write_file(path, &scene.to_bytes()?)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::collections::hash_map::Entry;
use std::collections::{HashMap, HashSet};

use hullwright::hulls_format::{BakedMesh, BakedTriangles, HullsFile, MeshHash};
use hullwright::{Control, Error, Method, TriangleMesh, mass_properties_with};

use crate::conventions::{
    Body, ColliderKind, ExtrasTag, NameTag, is_coarser_level, mesh_tag, node_tag, read_extras,
    whole_of, without_copy_number,
};
use crate::mesh_file::{MeshParts, SceneMesh, SceneNode};

/// What is baked of a scene.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
pub struct BakeOptions {
    /// For meshes without an artist's own parameters.
    pub parameters: Method,
    /// Whether only meshes are baked that an artist's name or extra tags. Default false.
    pub tagged_only: bool,
    /// Whether triangles are baked too, for what never moves. Default false.
    pub triangles: bool,
    /// Whether names and extras are followed, see [`conventions`](crate::conventions). Default
    /// true.
    pub follows_artists: bool,
    /// Whether meshes are baked too whose hulls their file holds, as
    /// [`HullsInFile`](crate::gltf_hulls::HullsInFile) writes them. Default false.
    pub written: bool,
    /// How far the triangles of what never moves may be from its mesh, in units of the world, where
    /// the artist says nothing of it; 0 for the mesh's own. Default 0.
    pub level_bound: f32,
    /// The side of a cell, in units of the world: what never moves and fits into one is baked with
    /// the others there. Default `None`.
    pub cell_size: Option<f32>,
}

impl Default for BakeOptions {
    fn default() -> Self {
        Self {
            parameters: Method::default(),
            tagged_only: false,
            triangles: false,
            follows_artists: true,
            written: false,
            level_bound: 0.0,
            cell_size: None,
        }
    }
}

impl BakeOptions {
    /// All meshes, with these parameters, or this method, where the artist gives none.
    pub fn new(parameters: impl Into<Method>) -> Self {
        Self { parameters: parameters.into(), ..Self::default() }
    }

    /// The same for tagged meshes only, or for all.
    #[must_use]
    pub fn with_tagged_only(mut self, tagged_only: bool) -> Self {
        self.tagged_only = tagged_only;
        self
    }

    /// The same with or without meshes whose hulls their file holds.
    #[must_use]
    pub fn with_written(mut self, written: bool) -> Self {
        self.written = written;
        self
    }

    /// The same with a bound and with cells for [what never moves](crate::bake_surfaces).
    #[must_use]
    pub fn with_surfaces(mut self, level_bound: f32, cell_size: Option<f32>) -> Self {
        (self.level_bound, self.cell_size) = (level_bound, cell_size);
        self
    }

    /// The same with or without triangles.
    #[must_use]
    pub fn with_triangles(mut self, triangles: bool) -> Self {
        self.triangles = triangles;
        self
    }
}

/// A mesh to bake, with one set of parameters.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
pub struct BakeJob {
    /// The mesh's name, and those of the nodes that show it.
    pub names: Vec<String>,
    /// The indices of the meshes with this content in the glTF file.
    pub gltf_meshes: Vec<u32>,
    /// The indices of the nodes that show one of them in the glTF file.
    pub gltf_nodes: Vec<u32>,
    /// The mesh, in single precision, as engines have it.
    pub mesh: TriangleMesh,
    /// What its triangles are made of: the parts of the first of the meshes with this content,
    /// whatever those of the others are.
    pub parts: MeshParts,
    /// What it is decomposed with.
    pub parameters: Method,
}

/// What there is to bake of a scene's meshes, each content with its parameters once, in their
/// order.
///
/// Meshes with the same triangles are one content, also if they differ in their materials or are
/// cut into other primitives: their hulls are said to be made of the parts of the first.
///
/// A mesh is baked with the parameters of each node that shows it; one that no node shows with
/// those of its own name and extras, since a game may spawn it. A node whose file holds the hulls
/// of its mesh counts only if the options say so.
pub fn bake_jobs(meshes: Vec<SceneMesh>, options: &BakeOptions) -> Vec<BakeJob> {
    let with_pieces = meshes_with_pieces(&meshes);
    let node_names: Vec<String> =
        meshes.iter().flat_map(|mesh| &mesh.nodes).map(|node| node.name.clone()).collect();
    let mut jobs: Vec<BakeJob> = Vec::new();
    let mut by_content: HashMap<MeshHash, Vec<usize>> = HashMap::new();
    for mut mesh in meshes {
        in_single_precision(&mut mesh.mesh);
        let hash = MeshHash::of(&mesh.mesh);
        let alone = [SceneNode::default()];
        let nodes = if mesh.nodes.is_empty() { &alone[..] } else { &mesh.nodes };
        for node in nodes {
            let said = options.by_artist(&mesh, node, &with_pieces);
            let is_coarser = || is_coarser_level(&node.name, node_names.iter().map(String::as_str));
            let parameters = said.unwrap_or_else(|| {
                let is_baked = !options.tagged_only && !is_coarser();
                is_baked.then(|| options.parameters.clone())
            });
            let Some(parameters) = parameters else { continue };
            let known = by_content.entry(hash).or_default();
            let same = known.iter().copied().find(|job| jobs[*job].parameters == parameters);
            let job = same.unwrap_or_else(|| {
                known.push(jobs.len());
                jobs.push(BakeJob {
                    names: Vec::new(),
                    gltf_meshes: Vec::new(),
                    gltf_nodes: Vec::new(),
                    mesh: mesh.mesh.clone(),
                    parts: mesh.parts.clone(),
                    parameters,
                });
                jobs.len() - 1
            });
            let indices = &mut jobs[job].gltf_meshes;
            indices.extend(mesh.index.filter(|index| !indices.contains(index)));
            jobs[job].gltf_nodes.extend(node.index);
            for name in [&mesh.name, &node.name] {
                let names = &mut jobs[job].names;
                if !name.is_empty() && !names.contains(name) {
                    names.push(name.clone());
                }
            }
        }
    }
    jobs
}

/// The triangles of the glTF meshes of a scene that may stand still, each content once, if the
/// options say so: not of what the artist gives hulls, another shape, a body that moves, or no
/// collider. O(size).
pub fn bake_triangles(meshes: &[SceneMesh], options: &BakeOptions) -> Vec<BakedTriangles> {
    if !options.triangles {
        return Vec::new();
    }
    let with_pieces = meshes_with_pieces(meshes);
    let mut baked: Vec<BakedTriangles> = Vec::new();
    let mut by_content: HashMap<MeshHash, usize> = HashMap::new();
    for mesh in meshes {
        let alone = [SceneNode::default()];
        let mut nodes = if mesh.nodes.is_empty() { &alone[..] } else { &mesh.nodes }.iter();
        let (Some(index), true) =
            (mesh.index, nodes.any(|node| options.may_be_static(mesh, node, &with_pieces)))
        else {
            continue;
        };
        match by_content.entry(MeshHash::of(&mesh.mesh)) {
            Entry::Occupied(known) => baked[*known.get()].gltf_meshes.push(index),
            Entry::Vacant(new) => {
                new.insert(baked.len());
                baked.push(BakedTriangles::new(&mesh.mesh, vec![index]));
            }
        }
    }
    baked
}

/// What is wrong with the extras of a scene's meshes and nodes, each with the name of what has it.
/// O(meshes).
pub fn extras_complaints(meshes: &[SceneMesh]) -> Vec<String> {
    let of = |name: &str, extras: &Option<String>| -> Vec<String> {
        let wrong = extras.as_deref().map(|text| read_extras(text).1).unwrap_or_default();
        wrong.into_iter().map(|text| format!("extras of `{name}`: {text}")).collect()
    };
    let of_mesh = |mesh: &SceneMesh| {
        let nodes = mesh.nodes.iter().flat_map(|node| of(&node.name, &node.extras));
        of(&mesh.name, &mesh.extras).into_iter().chain(nodes).collect::<Vec<_>>()
    };
    meshes.iter().flat_map(of_mesh).collect()
}

impl BakeJob {
    /// Decomposes the mesh. Its mass properties are at a density of 1, and its hulls have the
    /// parts that they are made of, if the mesh's file names them.
    ///
    /// # Errors
    /// As [`decompose`](hullwright::decompose()).
    pub fn run(&self, control: &Control) -> Result<BakedMesh, Error> {
        let made = self.parameters.decompose(&self.mesh, control)?;
        let solid = self.parameters.solid();
        let mass = mass_properties_with(&self.mesh, &made.hulls, 1.0, &solid)?;
        let name = self.names.first().cloned().unwrap_or_default();
        let shares = self.parts.shares(&self.mesh, &made.hulls)?;
        let hulls = HullsFile::new(name, &made)
            .with_mass_properties(mass)
            .with_parts(self.parts.list.clone(), shares);
        Ok(BakedMesh::new(&self.mesh, self.parameters.clone(), hulls)
            .with_names(self.names.clone())
            .with_gltf_meshes(self.gltf_meshes.clone()))
    }
}

impl BakeOptions {
    /// What the artist says: nothing, or what a mesh is decomposed with, which is `None` for what
    /// gets no hulls of its own. The rules are those of the plugin's hierarchy.
    fn by_artist(
        &self,
        mesh: &SceneMesh,
        node: &SceneNode,
        with_pieces: &HashSet<String>,
    ) -> Option<Option<Method>> {
        if node.has_hulls && !self.written {
            return Some(None);
        }
        if !self.follows_artists {
            return None;
        }
        if is_left_out(mesh, node, with_pieces) {
            return Some(None);
        }
        Some(match artist_tag(mesh, node)? {
            ArtistTag::Extras(tag) => tag.parameters(&self.parameters),
            ArtistTag::Name(tag) => tag.kind().and_then(|kind| kind.parameters(&self.parameters)),
        })
    }

    /// Whether a node's mesh gets its triangles where nothing moves it, or always.
    pub(crate) fn may_be_static(
        &self,
        mesh: &SceneMesh,
        node: &SceneNode,
        with_pieces: &HashSet<String>,
    ) -> bool {
        if node.has_hulls && !self.written {
            return false;
        }
        if !self.follows_artists {
            return true;
        }
        let (kind, is_moved) = match artist_tag(mesh, node) {
            Some(ArtistTag::Extras(tag)) => {
                (tag.kind, matches!(tag.body, Some(Body::Dynamic | Body::Kinematic)))
            }
            Some(ArtistTag::Name(tag)) => (tag.kind(), matches!(tag, NameTag::Body(_))),
            None => ((!self.tagged_only).then_some(ColliderKind::Decomposition), false),
        };
        matches!(kind, Some(ColliderKind::Decomposition | ColliderKind::Triangles))
            && !is_moved
            && !is_left_out(mesh, node, with_pieces)
    }
}

/// How an artist tags a node's mesh.
pub(crate) enum ArtistTag<'a> {
    Extras(ExtrasTag),
    Name(NameTag<'a>),
}

/// By extras, those of the node first, or else by name. [`extras_complaints`] has what is wrong in
/// them.
pub(crate) fn artist_tag<'a>(mesh: &'a SceneMesh, node: &'a SceneNode) -> Option<ArtistTag<'a>> {
    let mut extras = [&node.extras, &mesh.extras].into_iter().flatten();
    let by_extras = extras.find_map(|text| read_extras(text).0);
    let by_name = || node_tag(&node.name).or_else(|| mesh_tag(&mesh.name));
    by_extras.map(ArtistTag::Extras).or_else(|| by_name().map(ArtistTag::Name))
}

/// Whether the artist says that a mesh has no collider of its own.
fn is_left_out(mesh: &SceneMesh, node: &SceneNode, with_pieces: &HashSet<String>) -> bool {
    let has_pieces = |name: &&str| {
        with_pieces.contains(*name) || with_pieces.contains(without_copy_number(name))
    };
    node_tag(&node.name) == Some(NameTag::LeftOut)
        || [node.name.as_str(), mesh.name.as_str()].iter().any(has_pieces)
}

/// Meshes whose pieces the artist made.
pub(crate) fn meshes_with_pieces(meshes: &[SceneMesh]) -> HashSet<String> {
    let names = || {
        meshes.iter().flat_map(|mesh| {
            let of_nodes = mesh.nodes.iter().map(|node| node.name.as_str());
            of_nodes.chain(std::iter::once(mesh.name.as_str()))
        })
    };
    let all: HashSet<&str> = names().map(without_copy_number).collect();
    let wholes = names().filter_map(|name| match node_tag(name)? {
        NameTag::PieceOf { rest, .. } => Some(whole_of(rest, |name| all.contains(name)).to_owned()),
        _ => None,
    });
    wholes.collect()
}

/// Engines hold single precision, and not which sides are drawn; their meshes have the same hulls.
fn in_single_precision(mesh: &mut TriangleMesh) {
    for x in mesh.positions.as_flattened_mut() {
        *x = f64::from(*x as f32);
    }
    mesh.sidedness.clear();
}
