//! The meshes of a fragment: parts of those of the whole, with all that these have at their
//! vertices, and what closes cuts.

use std::collections::BTreeMap;

use bevy::asset::RenderAssetUsages;
use bevy::math::Affine3A;
use bevy::mesh::{Indices, PrimitiveTopology, VertexAttributeValues};
use bevy::platform::collections::HashMap;
use bevy::prelude::*;
use hullwright::{Fragment, FragmentVertex};

use crate::jobs::request::{MeshData, MeshPart};

/// What a fragment looks like, in the space of its body.
pub(super) struct Drawn {
    /// Of each part of the whole that it has something of, the one with the largest area first.
    pub surfaces: Vec<(usize, Mesh)>,
    pub cuts: Option<Mesh>,
}

/// Draws a fragment. O(fragment + meshes).
pub(super) fn draw(
    fragment: &Fragment,
    data: &MeshData,
    parts: &[MeshPart],
    map_before: &Affine3A,
    to_body: &Affine3A,
    meshes: &Assets<Mesh>,
) -> Drawn {
    let is_mirrored = to_body.matrix3.determinant() < 0.0;
    let place = |point: [f64; 3]| to_body.transform_point3(Vec3::from(point.map(|x| x as f32)));
    let mut of_parts: BTreeMap<usize, Vec<[u32; 3]>> = BTreeMap::new();
    for (triangle, &source) in fragment.triangles.iter().zip(&fragment.source_triangles) {
        of_parts.entry(data.part_of(source)).or_default().push(*triangle);
    }
    let mut first_vertex = 0;
    let mut surfaces: Vec<(f32, usize, Mesh)> = Vec::new();
    for (index, part) in parts.iter().enumerate() {
        let Some(source) = meshes.get(part.mesh) else { continue };
        if let Some(triangles) = of_parts.remove(&index) {
            let (used, triangles) = compact(&triangles, is_mirrored);
            let vertices: Vec<FragmentVertex> =
                used.iter().map(|&vertex| fragment.vertices[vertex as usize]).collect();
            let positions: Vec<Vec3> = vertices.iter().map(|of| place(of.position)).collect();
            let area = |[a, b, c]: [Vec3; 3]| (b - a).cross(c - a).length();
            let corners =
                triangles.iter().map(|triangle| triangle.map(|at| positions[at as usize]));
            let area = corners.map(area).sum();
            let from_mesh = *to_body * *map_before * part.to_input;
            let mesh = surface(source, first_vertex, &vertices, positions, &from_mesh);
            let mesh = mesh.map(|mesh| mesh.with_inserted_indices(indices(triangles)));
            surfaces.extend(mesh.map(|mesh| (area, index, mesh)));
        }
        first_vertex += source.count_vertices() as u32;
    }
    surfaces.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let cuts = (!fragment.cut_faces.triangles.is_empty()).then(|| {
        let positions = fragment.cut_faces.positions.iter().map(|point| place(*point)).collect();
        let turn = |[a, b, c]: [u32; 3]| if is_mirrored { [a, c, b] } else { [a, b, c] };
        cuts(positions, fragment.cut_faces.triangles.iter().copied().map(turn).collect())
    });
    Drawn { surfaces: surfaces.into_iter().map(|(_, part, mesh)| (part, mesh)).collect(), cuts }
}

/// The vertices that triangles use, and the triangles by their places among these.
fn compact(triangles: &[[u32; 3]], is_mirrored: bool) -> (Vec<u32>, Vec<[u32; 3]>) {
    let mut used = Vec::new();
    let mut places: HashMap<u32, u32> = HashMap::default();
    let compacted = triangles.iter().map(|triangle| {
        let [a, b, c] = triangle.map(|vertex| {
            *places.entry(vertex).or_insert_with(|| {
                used.push(vertex);
                used.len() as u32 - 1
            })
        });
        if is_mirrored { [a, c, b] } else { [a, b, c] }
    });
    let compacted = compacted.collect();
    (used, compacted)
}

fn indices(triangles: Vec<[u32; 3]>) -> Indices {
    Indices::U32(triangles.into_iter().flatten().collect())
}

/// The vertices of a part of a mesh, with all that the mesh has at its vertices. Numbers are worked
/// out between its corners; what is counted, as joints are, is that of the nearest corner.
fn surface(
    source: &Mesh,
    first_vertex: u32,
    vertices: &[FragmentVertex],
    positions: Vec<Vec3>,
    from_mesh: &Affine3A,
) -> Option<Mesh> {
    let corners = |of: &FragmentVertex| of.corners.map(|corner| (corner - first_vertex) as usize);
    let heaviest = |of: &FragmentVertex| {
        let by_weight = |a: &usize, b: &usize| of.weights[*a].total_cmp(&of.weights[*b]);
        corners(of)[(0..3).max_by(by_weight).unwrap_or(0)] as u32
    };
    let mut mesh = Mesh::new(PrimitiveTopology::TriangleList, source.asset_usage);
    for (attribute, values) in source.try_attributes().ok()? {
        mesh.insert_attribute(*attribute, values.clone());
    }
    mesh.insert_indices(Indices::U32(vertices.iter().map(heaviest).collect()));
    mesh.try_duplicate_vertices().ok()?;
    let normals = from_mesh.matrix3.inverse().transpose();
    let between: Vec<([usize; 3], [f32; 3])> =
        vertices.iter().map(|of| (corners(of), of.weights)).collect();
    for (attribute, values) in source.try_attributes().ok()? {
        let id = attribute.id;
        let values = match values {
            VertexAttributeValues::Float32(of) => VertexAttributeValues::Float32(
                mixed(&between, |at| [of[at]]).map(|[x]| x).collect(),
            ),
            VertexAttributeValues::Float32x2(of) => {
                VertexAttributeValues::Float32x2(mixed(&between, |at| of[at]).collect())
            }
            VertexAttributeValues::Float32x3(of) => {
                let mixed = mixed(&between, |at| of[at]);
                VertexAttributeValues::Float32x3(match id == Mesh::ATTRIBUTE_NORMAL.id {
                    true => mixed
                        .map(|normal| (normals * Vec3::from(normal)).normalize_or_zero().to_array())
                        .collect(),
                    false => mixed.collect(),
                })
            }
            VertexAttributeValues::Float32x4(of) => {
                let mixed = mixed(&between, |at| of[at]);
                VertexAttributeValues::Float32x4(match id == Mesh::ATTRIBUTE_TANGENT.id {
                    true => mixed.map(|tangent| turned(tangent, from_mesh)).collect(),
                    false => mixed.collect(),
                })
            }
            _ => continue,
        };
        mesh.insert_attribute(*attribute, values);
    }
    mesh.insert_attribute(Mesh::ATTRIBUTE_POSITION, positions);
    Some(mesh)
}

/// The weighted sums of values at corners.
fn mixed<const N: usize>(
    between: &[([usize; 3], [f32; 3])],
    value: impl Fn(usize) -> [f32; N],
) -> impl Iterator<Item = [f32; N]> {
    between.iter().map(move |(corners, weights)| {
        let mut sum = [0.0; N];
        for (corner, weight) in corners.iter().zip(weights) {
            for (sum, x) in sum.iter_mut().zip(value(*corner)) {
                *sum += x * weight;
            }
        }
        sum
    })
}

/// A tangent, whose fourth number says on which side the third axis is.
fn turned([x, y, z, side]: [f32; 4], from_mesh: &Affine3A) -> [f32; 4] {
    let matrix = from_mesh.matrix3;
    let Vec3 { x, y, z } = Vec3::from(matrix * bevy::math::Vec3A::new(x, y, z)).normalize_or_zero();
    let side = if matrix.determinant() < 0.0 { -side } else { side };
    [x, y, z, side.signum()]
}

/// Flat faces with texture coordinates along them.
fn cuts(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Mesh {
    let mut mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default());
    let mut normals = vec![Vec3::ZERO; positions.len()];
    for triangle in &triangles {
        let [a, b, c] = triangle.map(|corner| positions[corner as usize]);
        // Vertices of one cut are those of one plane, so each sum has its direction.
        triangle.iter().for_each(|&corner| normals[corner as usize] += (b - a).cross(c - a));
    }
    let normals: Vec<Vec3> = normals.into_iter().map(Vec3::normalize_or_zero).collect();
    let along = |(position, normal): (&Vec3, &Vec3)| {
        let (x, y) = match *normal == Vec3::ZERO {
            true => (Vec3::X, Vec3::Y),
            false => normal.any_orthonormal_pair(),
        };
        [x.dot(*position), y.dot(*position)]
    };
    let coordinates: Vec<[f32; 2]> = positions.iter().zip(&normals).map(along).collect();
    mesh.insert_attribute(Mesh::ATTRIBUTE_POSITION, positions);
    mesh.insert_attribute(Mesh::ATTRIBUTE_NORMAL, normals);
    mesh.insert_attribute(Mesh::ATTRIBUTE_UV_0, coordinates);
    mesh.with_inserted_indices(indices(triangles))
}
