//! Triangles of Bevy's meshes, checked.

use bevy::asset::AssetId;
use bevy::math::Affine3A;
use bevy::mesh::{Indices, Mesh, MeshAccessError, PrimitiveTopology, VertexAttributeValues};
use bevy::prelude::*;

use crate::{Error, MeshView};

use crate::bevy::tag::error::DecompositionError;

/// One of the meshes that make up an input, and where it sits in it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct MeshPart {
    pub mesh: AssetId<Mesh>,
    pub to_input: Affine3A,
}

/// An input: all meshes below a tagged entity.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct MeshData {
    pub positions: Vec<[f32; 3]>,
    pub triangles: Vec<[u32; 3]>,
}

impl MeshData {
    pub(crate) fn view(&self) -> MeshView<'_> {
        MeshView::new(&self.positions, &self.triangles)
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
    }
    if data.triangles.is_empty() {
        let vertices = data.positions.len();
        return Err(Error::EmptyMesh { vertices, triangles: 0 }.into());
    }
    Ok(data)
}

/// Adds the triangles of a mesh, moved by `map`. O(size).
pub(crate) fn append(
    data: &mut MeshData,
    mesh: &Mesh,
    map: &Affine3A,
) -> Result<(), DecompositionError> {
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
    match (indices, is_strip) {
        (None, false) => list(triangles, 0..count),
        (None, true) => strip(triangles, 0..count, None),
        (Some(Indices::U16(indices)), false) => {
            list(triangles, indices.iter().map(|i| (*i).into()))
        }
        (Some(Indices::U32(indices)), false) => list(triangles, indices.iter().copied()),
        (Some(Indices::U16(indices)), true) => {
            strip(triangles, indices.iter().map(|i| (*i).into()), Some(u16::MAX.into()));
        }
        (Some(Indices::U32(indices)), true) => {
            strip(triangles, indices.iter().copied(), Some(u32::MAX));
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

fn list(triangles: &mut Vec<[u32; 3]>, mut vertices: impl Iterator<Item = u32>) {
    triangles.reserve(vertices.size_hint().0 / 3);
    while let (Some(a), Some(b), Some(c)) = (vertices.next(), vertices.next(), vertices.next()) {
        triangles.push([a, b, c]);
    }
}

/// Every second triangle of a strip is wound the other way round. The index `restart` begins a new
/// one.
fn strip(triangles: &mut Vec<[u32; 3]>, vertices: impl Iterator<Item = u32>, restart: Option<u32>) {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_strip_turns_every_second_triangle_and_restarts() {
        let mut triangles = Vec::new();
        strip(&mut triangles, [0, 1, 2, 3, 9, 4, 5, 6].into_iter(), Some(9));
        assert_eq!(triangles, [[0, 1, 2], [2, 1, 3], [4, 5, 6]]);
    }

    #[test]
    fn a_list_leaves_out_an_unfinished_triangle() {
        let mut triangles = Vec::new();
        list(&mut triangles, 0..5);
        assert_eq!(triangles, [[0, 1, 2]]);
    }
}
