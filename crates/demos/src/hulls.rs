//! Hulls as they are in a collider, drawn in the colours of the palette.

use std::collections::HashMap;

use bevy::asset::RenderAssetUsages;
use bevy::math::Affine3A;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use bevy_rapier3d::rapier::geometry::SharedShape;
use bevy_rapier3d::rapier::parry::shape::TypedShape;
use hullwright_formats::palette;

/// Faces of a hull whose normals have at least this cosine are one face: no edge is drawn between.
const SAME_FACE: f32 = 0.998;

/// How far over a mesh's surface its hulls are drawn: enough that the two don't flicker where they
/// coincide.
const DEPTH_BIAS: f32 = 120.0;

/// How far over their hull edges are drawn, as a share of their way from its middle: lines can't
/// have a depth of their own.
const EDGES_ABOVE: f32 = 0.004;

/// A convex part of a collider.
#[derive(Debug, Clone, Default)]
pub struct Piece {
    /// Corners, in the collider's space.
    pub points: Vec<Vec3>,
    /// Triangles, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

/// The convex parts of a collider's shape, in order; those that are neither hulls nor boxes are
/// left out.
pub fn pieces(shape: &SharedShape) -> Vec<Piece> {
    let part = |shape: &SharedShape| match shape.as_typed_shape() {
        TypedShape::ConvexPolyhedron(hull) => Some(hull.to_trimesh()),
        TypedShape::Cuboid(block) => Some(block.to_trimesh()),
        _ => None,
    };
    match shape.as_compound() {
        Some(compound) => compound
            .shapes()
            .iter()
            .filter_map(|(pose, shape)| {
                let (points, triangles) = part(shape)?;
                let points = points.into_iter().map(|point| *pose * point).collect();
                Some(Piece { points, triangles })
            })
            .collect(),
        None => {
            part(shape).map(|(points, triangles)| Piece { points, triangles }).into_iter().collect()
        }
    }
}

/// All pieces as one mesh with a colour for each, moved apart by `explosion` times the way of their
/// middle from the middle of all.
pub fn hulls_mesh(pieces: &[Piece], explosion: f32) -> Mesh {
    let (mut positions, mut normals, mut colours) = (Vec::new(), Vec::new(), Vec::new());
    for ((index, piece), way) in pieces.iter().enumerate().zip(ways(pieces, explosion)) {
        let [red, green, blue] = palette::linear(palette::colour(index));
        for corners in piece.corners() {
            let normal = normal(corners);
            for corner in corners {
                positions.push(corner + way);
                normals.push(normal);
                colours.push([red, green, blue, 1.0]);
            }
        }
    }
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, normals)
        .with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, colours)
}

/// The edges of all pieces as lines, moved apart in the same way.
pub fn edges_mesh(pieces: &[Piece], explosion: f32) -> Mesh {
    let mut positions = Vec::new();
    let mut indices: Vec<u32> = Vec::new();
    for (piece, way) in pieces.iter().zip(ways(pieces, explosion)) {
        let first = positions.len() as u32;
        let middle = piece.middle().unwrap_or_default();
        let above = |point: &Vec3| *point + EDGES_ABOVE * (*point - middle) + way;
        positions.extend(piece.points.iter().map(above));
        indices.extend(piece.sharp_edges().into_iter().flatten().map(|index| first + index));
    }
    let normals = vec![Vec3::Y; positions.len()];
    Mesh::new(PrimitiveTopology::LineList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, normals)
        .with_inserted_indices(Indices::U32(indices))
}

impl Piece {
    /// Moves it into another space.
    pub fn map(&mut self, map: &Affine3A) {
        self.points.iter_mut().for_each(|point| *point = map.transform_point3(*point));
        if map.matrix3.determinant() < 0.0 {
            self.triangles.iter_mut().for_each(|triangle| triangle.swap(0, 1));
        }
    }

    fn corners(&self) -> impl Iterator<Item = [Vec3; 3]> + '_ {
        self.triangles.iter().filter_map(|&[a, b, c]| {
            let point = |index: u32| self.points.get(index as usize).copied();
            Some([point(a)?, point(b)?, point(c)?])
        })
    }

    /// Edges between faces that are not in one plane, each once, sorted.
    fn sharp_edges(&self) -> Vec<[u32; 2]> {
        let mut normals: HashMap<[u32; 2], Vec<Vec3>> = HashMap::new();
        for (triangle, corners) in self.triangles.iter().zip(self.corners()) {
            let [a, b, c] = *triangle;
            for [from, to] in [[a, b], [b, c], [c, a]] {
                normals.entry([from.min(to), from.max(to)]).or_default().push(normal(corners));
            }
        }
        let is_flat = |normals: &[Vec3]| matches!(normals, [a, b] if a.dot(*b) > SAME_FACE);
        let sharp = normals.into_iter().filter(|(_, normals)| !is_flat(normals));
        let mut edges: Vec<_> = sharp.map(|(edge, _)| edge).collect();
        edges.sort_unstable();
        edges
    }

    fn middle(&self) -> Option<Vec3> {
        middle(self.points.iter().copied())
    }
}

/// Materials of hulls and their edges.
#[derive(Resource, Debug, Clone)]
pub struct HullMaterials {
    /// Hulls alone.
    pub solid: Handle<StandardMaterial>,
    /// Hulls over the mesh that they stand for.
    pub glass: Handle<StandardMaterial>,
    /// Edges.
    pub edges: Handle<StandardMaterial>,
}

impl FromWorld for HullMaterials {
    fn from_world(world: &mut World) -> Self {
        let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
        let hulls = StandardMaterial { perceptual_roughness: 0.8, reflectance: 0.2, ..default() };
        let glass = StandardMaterial {
            base_color: Color::WHITE.with_alpha(0.62),
            alpha_mode: AlphaMode::Blend,
            depth_bias: DEPTH_BIAS,
            ..hulls.clone()
        };
        let edges = StandardMaterial {
            base_color: Color::BLACK.with_alpha(0.55),
            alpha_mode: AlphaMode::Blend,
            unlit: true,
            ..default()
        };
        Self {
            solid: materials.add(hulls),
            glass: materials.add(glass),
            edges: materials.add(edges),
        }
    }
}

fn normal([a, b, c]: [Vec3; 3]) -> Vec3 {
    (b - a).cross(c - a).normalize_or_zero()
}

fn ways(pieces: &[Piece], explosion: f32) -> Vec<Vec3> {
    let all = pieces.iter().flat_map(|piece| piece.points.iter().copied());
    let centre = middle(all).unwrap_or_default();
    let way = |piece: &Piece| (piece.middle().unwrap_or(centre) - centre) * explosion;
    pieces.iter().map(way).collect()
}

/// Middle of the bounding box.
fn middle(points: impl Iterator<Item = Vec3>) -> Option<Vec3> {
    let bounds = points.fold(None, |bounds: Option<[Vec3; 2]>, point| match bounds {
        None => Some([point, point]),
        Some([low, high]) => Some([low.min(point), high.max(point)]),
    });
    bounds.map(|[low, high]| (low + high) / 2.0)
}
