//! What colliders are made from: requests of entities, the keys of inputs and results, and the
//! triangles of Bevy's meshes.

use std::sync::Arc;

use bevy::asset::{AssetId, RenderAssetUsages, UntypedAssetId};
use bevy::math::Affine3A;
use bevy::mesh::{Indices, MeshAccessError, PrimitiveTopology, VertexAttributeValues};
use bevy::prelude::*;
use hullwright::hulls_format::MeshHash;
use hullwright::{ConvexHull, Error, MeshView, TriangleMesh};
use sha2::{Digest, Sha256};

use crate::tag::outcomes::{DecompositionError, HullSource, SkipReason};
use crate::tag::parameters::Goal;

/// The collider that an entity requests.
#[derive(Debug)]
pub(crate) struct ColliderRequest {
    pub input: Arc<InputId>,
    pub parts: Vec<MeshPart>,
    /// `None` for baked hulls.
    pub goal: Option<Goal>,
    /// Baked into the mesh before the work.
    pub map_before: Affine3A,
    /// Baked into the result.
    pub map: Affine3A,
}

impl ColliderRequest {
    /// Why it is for triangles instead of hulls.
    pub(crate) fn why_triangles(&self) -> Option<SkipReason> {
        self.goal.as_ref()?.why_triangles()
    }

    /// From the entity's space to the collider's.
    pub(crate) fn to_collider(&self) -> Affine3A {
        self.map * self.map_before
    }

    pub(crate) fn map_key(&self) -> MapKey {
        MapKey::new(&self.map)
    }
}

/// Names what a collider is made from without looking into it.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) enum InputId {
    Meshes {
        parts: Vec<(AssetId<Mesh>, MapKey)>,
        /// Hash of what to make of them.
        goal: [u8; 32],
        /// Applied before the work.
        map_before: MapKey,
        /// The baked scene in which their hulls may be found.
        scene: Option<UntypedAssetId>,
        /// Which content all these have had since it changed last.
        edition: u64,
    },
    /// Hulls of a baked scene, whatever mesh they were made from.
    Baked {
        scene: UntypedAssetId,
        /// The name of the mesh; `None` for the only one.
        mesh: Option<String>,
        edition: u64,
    },
}

impl InputId {
    pub(crate) fn uses(&self, asset: UntypedAssetId) -> bool {
        match self {
            Self::Meshes { parts, scene, .. } => {
                *scene == Some(asset) || parts.iter().any(|(mesh, _)| mesh.untyped() == asset)
            }
            Self::Baked { scene, .. } => *scene == asset,
        }
    }

    /// Whether both differ in the scale that is applied before the work at most.
    pub(crate) fn is_same_unscaled(&self, other: &Self) -> bool {
        match (self, other) {
            (
                Self::Meshes { parts, goal, map_before: _, scene, edition },
                Self::Meshes {
                    parts: parts2,
                    goal: goal2,
                    map_before: _,
                    scene: scene2,
                    edition: edition2,
                },
            ) => (parts, goal, scene, edition) == (parts2, goal2, scene2, edition2),
            _ => self == other,
        }
    }

    /// The baked scene in which its hulls are, or may be.
    pub(crate) fn scene(&self) -> Option<UntypedAssetId> {
        match self {
            Self::Meshes { scene, .. } => *scene,
            Self::Baked { scene, .. } => Some(*scene),
        }
    }

    /// The asset that stands for it in messages: its first mesh, or its baked scene.
    pub(crate) fn asset(&self) -> Option<UntypedAssetId> {
        match self {
            Self::Meshes { parts, .. } => parts.first().map(|(mesh, _)| mesh.untyped()),
            Self::Baked { scene, .. } => Some(*scene),
        }
    }
}

/// A map, as exact as it is applied.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct MapKey([u32; 12]);

impl MapKey {
    pub(crate) fn new(map: &Affine3A) -> Self {
        Self(map.to_cols_array().map(f32::to_bits))
    }
}

/// Names a collider's geometry by what it is made from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum ContentKey {
    Mesh {
        mesh: MeshHash,
        /// What is made of it: see [`Goal::hash`].
        goal: [u8; 32],
        /// Where its parts end, where there are several: hulls of the same triangles in other parts
        /// are made of others.
        parts: Option<[u8; 32]>,
        /// The baked scene that it comes from, which may have other hulls than a decomposition
        /// makes.
        scene: Option<UntypedAssetId>,
    },
    /// A mesh of a baked scene.
    Baked { scene: UntypedAssetId, index: usize },
}

impl ContentKey {
    /// What is made of a mesh. O(1).
    pub(super) fn of_mesh(mesh: MeshHash, goal: &Goal) -> Self {
        Self::Mesh { mesh, goal: goal.hash(), parts: None, scene: None }
    }

    /// The same content, as a baked scene has it.
    pub(super) fn in_scene(mut self, of: UntypedAssetId) -> Self {
        if let Self::Mesh { scene, .. } = &mut self {
            *scene = Some(of);
        }
        self
    }

    /// The same content, whatever its parts.
    pub(super) fn whole(mut self) -> Self {
        if let Self::Mesh { parts, .. } = &mut self {
            *parts = None;
        }
        self
    }

    /// The same content in parts.
    pub(super) fn in_parts(mut self, data: &MeshData) -> Self {
        if let Self::Mesh { parts, .. } = &mut self {
            let ends = || data.part_ends.iter().flat_map(|end| end.to_le_bytes());
            *parts = (data.part_ends.len() > 1)
                .then(|| Sha256::digest(ends().collect::<Vec<u8>>()).into());
        }
        self
    }

    /// The baked scene that it comes from.
    pub(crate) fn scene(&self) -> Option<UntypedAssetId> {
        match self {
            Self::Mesh { scene, .. } => *scene,
            Self::Baked { scene, .. } => Some(*scene),
        }
    }

    /// What caches outside of memory call it; `None` for what comes from a baked scene.
    pub(super) fn name(&self) -> Option<String> {
        let Self::Mesh { mesh, goal, scene: None, .. } = self else { return None };
        let mut hasher = Sha256::new_with_prefix(mesh.as_bytes());
        hasher.update(goal);
        Some(MeshHash::from_bytes(hasher.finalize().into()).to_string())
    }

    pub(crate) fn is_baked(&self) -> bool {
        self.scene().is_some()
    }

    /// Where hulls come from that are known without any work.
    pub(super) fn source_of_known(&self) -> HullSource {
        if self.is_baked() { HullSource::Baked } else { HullSource::Shared }
    }
}

/// One of the meshes that make up an input, and where it sits in it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct MeshPart {
    pub mesh: AssetId<Mesh>,
    pub to_input: Affine3A,
}

/// The triangles of an input: all meshes below a tagged entity.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct MeshData {
    pub positions: Vec<[f32; 3]>,
    pub triangles: Vec<[u32; 3]>,
    /// For each part how many triangles there are up to its end; empty where parts are not known.
    pub part_ends: Vec<u32>,
}

impl MeshData {
    /// The part that a triangle belongs to.
    pub(crate) fn part_of(&self, triangle: u32) -> usize {
        self.part_ends.partition_point(|end| *end <= triangle)
    }

    pub(crate) fn view(&self) -> MeshView<'_> {
        MeshView::new(&self.positions, &self.triangles)
    }

    /// The points that triangles use, as far as they are finite.
    pub(crate) fn used_points(&self) -> impl Iterator<Item = [f32; 3]> {
        let corners = self.triangles.iter().flatten();
        let points = corners.filter_map(|vertex| self.positions.get(*vertex as usize).copied());
        points.filter(|point| point.iter().all(|x| x.is_finite()))
    }
}

/// All parts as one mesh, moved by `map`. O(size).
pub(crate) fn read_parts(
    parts: &[MeshPart],
    map: &Affine3A,
    meshes: &Assets<Mesh>,
) -> Result<MeshData, DecompositionError> {
    let mut data = MeshData::default();
    for part in parts {
        let mesh = meshes.get(part.mesh).ok_or(DecompositionError::NotLoaded)?;
        append(&mut data, mesh, &(*map * part.to_input))?;
        data.part_ends.push(u32::try_from(data.triangles.len()).unwrap_or(u32::MAX));
    }
    if data.triangles.is_empty() {
        let vertices = data.positions.len();
        return Err(Error::EmptyMesh { vertices, triangles: 0 }.into());
    }
    Ok(data)
}

/// The meshes of parts as they are, those in one place as one, and their places. O(size).
pub(super) fn read_placed(
    parts: &[MeshPart],
    meshes: &Assets<Mesh>,
) -> Result<Vec<(MeshData, Affine3A)>, DecompositionError> {
    let in_one_place = parts.chunk_by(|a, b| a.to_input == b.to_input);
    let read = |parts: &[MeshPart]| {
        let first = parts.first().ok_or(DecompositionError::NotLoaded)?;
        let mut data = MeshData::default();
        for part in parts {
            let mesh = meshes.get(part.mesh).ok_or(DecompositionError::NotLoaded)?;
            append(&mut data, mesh, &Affine3A::IDENTITY)?;
            data.part_ends.push(u32::try_from(data.triangles.len()).unwrap_or(u32::MAX));
        }
        Ok((data, first.to_input))
    };
    in_one_place.map(read).collect()
}

/// Adds the triangles of a mesh, moved by `map`. O(size).
fn append(data: &mut MeshData, mesh: &Mesh, map: &Affine3A) -> Result<(), DecompositionError> {
    let positions = match mesh.try_attribute(Mesh::ATTRIBUTE_POSITION) {
        Ok(VertexAttributeValues::Float32x3(positions)) => positions,
        Ok(_) | Err(MeshAccessError::NotFound) => return Err(DecompositionError::NoPositions),
        Err(MeshAccessError::ExtractedToRenderWorld) => {
            return Err(DecompositionError::RenderWorldOnly);
        }
    };
    let indices = mesh.try_indices_option().map_err(|_| DecompositionError::RenderWorldOnly)?;
    let is_strip = match mesh.primitive_topology() {
        PrimitiveTopology::TriangleList => false,
        PrimitiveTopology::TriangleStrip => true,
        PrimitiveTopology::PointList => return Err(DecompositionError::NotTriangles("points")),
        PrimitiveTopology::LineList | PrimitiveTopology::LineStrip => {
            return Err(DecompositionError::NotTriangles("lines"));
        }
    };
    let too_large = |count| Error::TooLarge { what: "vertices", count, limit: u32::MAX as usize };
    let all = data.positions.len() + positions.len();
    let first = u32::try_from(data.positions.len()).map_err(|_| too_large(all))?;
    let count = u32::try_from(positions.len()).map_err(|_| too_large(all))?;

    let start = data.triangles.len();
    let triangles = &mut data.triangles;
    match indices {
        None => fill(triangles, is_strip, 0..count, None),
        Some(Indices::U16(indices)) => {
            let restart = Some(u16::MAX.into());
            fill(triangles, is_strip, indices.iter().map(|i| (*i).into()), restart);
        }
        Some(Indices::U32(indices)) => {
            fill(triangles, is_strip, indices.iter().copied(), Some(u32::MAX));
        }
    }
    for (index, triangle) in data.triangles[start..].iter_mut().enumerate() {
        if let Some(&index_out_of_range) = triangle.iter().find(|vertex| **vertex >= count) {
            return Err(Error::IndexOutOfRange {
                triangle: index,
                index: index_out_of_range,
                vertices: positions.len(),
            }
            .into());
        }
        *triangle = triangle.map(|vertex| first.saturating_add(vertex));
        // What is mirrored is wound the other way round.
        if map.matrix3.determinant() < 0.0 {
            triangle.swap(1, 2);
        }
    }
    if *map == Affine3A::IDENTITY {
        data.positions.extend_from_slice(positions);
    } else {
        let place = |point: &[f32; 3]| map.transform_point3(Vec3::from(*point)).to_array();
        data.positions.extend(positions.iter().map(place));
    }
    Ok(())
}

/// Adds the triangles of a list or a strip. Every second triangle of a strip is wound the other way
/// round. The index `restart` begins a new one.
fn fill(
    triangles: &mut Vec<[u32; 3]>,
    is_strip: bool,
    mut vertices: impl Iterator<Item = u32>,
    restart: Option<u32>,
) {
    if !is_strip {
        triangles.reserve(vertices.size_hint().0 / 3);
        while let (Some(a), Some(b), Some(c)) = (vertices.next(), vertices.next(), vertices.next())
        {
            triangles.push([a, b, c]);
        }
        return;
    }
    let mut length = 0;
    let (mut a, mut b) = (0, 0);
    for c in vertices {
        if Some(c) == restart {
            length = 0;
            continue;
        }
        length += 1;
        if length >= 3 {
            triangles.push(if length % 2 == 1 { [a, b, c] } else { [b, a, c] });
        }
        (a, b) = (b, c);
    }
}

/// The triangles of a list or a strip, with or without indices. O(size).
///
/// # Errors
/// [`DecompositionError`] says what keeps the mesh from being read: points or lines, positions in
/// another format, data that is in the render world alone.
pub fn triangle_mesh(mesh: &Mesh) -> Result<TriangleMesh, DecompositionError> {
    let mut data = MeshData::default();
    append(&mut data, mesh, &Affine3A::IDENTITY)?;
    Ok(TriangleMesh::from_points::<f32, _>(data.positions, data.triangles))
}

/// A hull to be drawn: flat-shaded triangles, with normals, in single precision. O(triangles).
///
/// ```
/// let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// let mesh = bevy_hullwright::mesh_of_hull(&hullwright::convex_hull(&points)?);
/// assert_eq!(mesh.count_vertices(), 12);
/// # Ok::<(), hullwright::Error>(())
/// ```
pub fn mesh_of_hull(hull: &ConvexHull) -> Mesh {
    let corners: Vec<[f32; 3]> =
        hull.corners().flatten().map(|point| point.map(|x| x as f32)).collect();
    let mut mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, corners);
    mesh.compute_flat_normals();
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_strip_turns_every_second_triangle_and_restarts_and_a_list_leaves_out_an_unfinished_one() {
        let mut strip = Vec::new();
        fill(&mut strip, true, [0, 1, 2, 3, 9, 4, 5, 6].into_iter(), Some(9));
        assert_eq!(strip, [[0, 1, 2], [2, 1, 3], [4, 5, 6]]);
        let mut list = Vec::new();
        fill(&mut list, false, 0..5, None);
        assert_eq!(list, [[0, 1, 2]]);
    }
}
