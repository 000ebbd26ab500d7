//! Bakes what never moves of a scene: few triangles within a bound, of each node alone or of all in
//! a cell. The rules are those of the Bevy plugin.

use std::cell::LazyCell;
use std::collections::{BTreeMap, HashSet};
use std::rc::Rc;

use glam::{DAffine3, DMat3};
use hullwright::hulls_format::{BakedSurface, MeshHash, PlacedMesh};
use hullwright::{Control, Error, Length, TriangleMesh, simplify_surface};

use crate::bake::{ArtistTag, BakeOptions, artist_tag, meshes_with_pieces};
use crate::conventions::{SurfaceProperties, is_coarser_level, level_cell, read_surface};
use crate::mesh_file::{SceneMesh, SceneNode};
use crate::vector::{Vector, bounds};

/// A surface to bake.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceJob {
    /// How far it may be from its meshes, in units of the world; 0 for their own triangles.
    pub bound: f32,
    /// What it is made of.
    pub parts: Vec<PlacedMesh>,
    /// All meshes where they are, in single precision.
    pub mesh: TriangleMesh,
    /// For each triangle its primitive, counted over all parts.
    pub primitives: Vec<u32>,
}

/// A node's mesh, and where it is in its scene.
struct Placed<'a> {
    mesh: &'a SceneMesh,
    hash: MeshHash,
    place: DAffine3,
}

/// What there is to bake of a scene's nodes that may stand still, each alone, or with the others of
/// its cell: those that fit into one, and have neither a body nor a surface of their own. O(size).
///
/// Nodes are where the file's transforms put them; a game that scales the scene makes its surfaces
/// itself.
pub fn surface_jobs(meshes: &[SceneMesh], options: &BakeOptions) -> Vec<SurfaceJob> {
    let with_pieces = meshes_with_pieces(meshes);
    let nodes = || meshes.iter().flat_map(|mesh| &mesh.nodes);
    let names: HashSet<&str> = nodes().map(|node| node.name.as_str()).collect();
    // Many nodes may show one mesh.
    let with_hash = meshes.iter().flat_map(|mesh| {
        let hash = Rc::new(LazyCell::new(|| MeshHash::of(&mesh.mesh)));
        mesh.nodes.iter().map(move |node| (mesh, hash.clone(), node))
    });
    let mut cells: BTreeMap<([i32; 3], u32), Vec<Placed<'_>>> = BTreeMap::new();
    let mut jobs = Vec::new();
    for (mesh, hash, node) in with_hash {
        let Some(transform) = node.transform.map(affine) else { continue };
        let tag = artist_tag(mesh, node).filter(|_| options.follows_artists);
        let is_coarser = || is_coarser_level(&node.name, names.iter().copied());
        if !options.may_be_static(mesh, node, &with_pieces) || tag.is_none() && is_coarser() {
            continue;
        }
        let by_artist = match &tag {
            Some(ArtistTag::Extras(tag)) => tag.level_bound,
            _ => None,
        };
        let bound = by_artist.unwrap_or(options.level_bound);
        match options.cell_size.and_then(|size| Some((size, cell(mesh, &transform, size)?))) {
            Some((size, index)) if !stands_alone(mesh, node, tag.as_ref()) => {
                let middle = Vector::from(index.map(|x| (f64::from(x) + 0.5) * f64::from(size)));
                let place = DAffine3::from_translation(-middle) * transform;
                cells.entry((index, bound.to_bits())).or_default().push(Placed {
                    mesh,
                    hash: **hash,
                    place,
                });
            }
            _ if bound > 0.0 => {
                let place = without_rotation(&transform);
                jobs.push(SurfaceJob::new(bound, &[Placed { mesh, hash: **hash, place }]));
            }
            // Its triangles are the mesh's own.
            _ => {}
        }
    }
    let of_cells =
        cells.iter().map(|((_, bound), all)| SurfaceJob::new(f32::from_bits(*bound), all));
    jobs.extend(of_cells);
    jobs
}

impl SurfaceJob {
    fn new(bound: f32, all: &[Placed<'_>]) -> Self {
        let mut merged = TriangleMesh::default();
        let (mut parts, mut primitives) = (Vec::new(), Vec::new());
        let mut count = 0;
        for &Placed { mesh, hash, place } in all {
            let of_mesh = &mesh.parts;
            let own = of_mesh.list.len().max(1) as u32;
            let DAffine3 { matrix3, translation } = place;
            let columns = [matrix3.x_axis, matrix3.y_axis, matrix3.z_axis, translation];
            let place_in_single = columns.map(|column| column.to_array().map(|x| x as f32));
            parts.push(PlacedMesh { mesh: hash, primitives: own, place: place_in_single });
            let first = merged.positions.len() as u32;
            let single = |x: f64| f64::from(x as f32);
            let put = |point: &[f64; 3]| {
                let point = Vector::from(point.map(single));
                place.transform_point3(point).to_array().map(single)
            };
            merged.positions.extend(mesh.mesh.positions.iter().map(put));
            let is_mirrored = matrix3.determinant() < 0.0;
            merged.triangles.extend(mesh.mesh.triangles.iter().map(|triangle| {
                let [a, b, c] = triangle.map(|vertex| first + vertex);
                if is_mirrored { [a, c, b] } else { [a, b, c] }
            }));
            let of_triangles = of_mesh.of_triangles.iter().copied();
            let of_triangles = of_triangles.chain(std::iter::repeat(0));
            let of_triangles = of_triangles.take(mesh.mesh.triangles.len());
            primitives.extend(of_triangles.map(|primitive| count + primitive));
            count += own;
        }
        Self { bound, parts, mesh: merged, primitives }
    }

    /// Makes the surface. Costs are those of [`simplify_surface`](hullwright::simplify_surface()).
    ///
    /// # Errors
    /// As [`simplify_surface`](hullwright::simplify_surface()), but a mesh without any triangle
    /// that has an area keeps its triangles.
    pub fn run(&self, control: &Control) -> Result<BakedSurface, Error> {
        let made = match self.bound > 0.0 {
            true => simplify_surface(&self.mesh, self.bound_as_written(), control).map(Some),
            false => Ok(None),
        };
        let made = match made {
            Err(Error::NothingUsable { .. }) => None,
            made => made?,
        };
        let (mesh, sources) = match made {
            Some(made) => (made.mesh, made.sources),
            None => (self.mesh.clone(), (0..self.mesh.triangles.len() as u32).collect()),
        };
        let of = |source: u32| self.primitives.get(source as usize).copied().unwrap_or_default();
        let mut triangles: Vec<(u32, [u32; 3])> =
            sources.iter().map(|source| of(*source)).zip(mesh.triangles).collect();
        triangles.sort_by_key(|(primitive, _)| *primitive);
        let count = self.parts.iter().map(|part| part.primitives).sum();
        let ends = (0..count)
            .map(|primitive| triangles.partition_point(|(other, _)| *other <= primitive) as u32)
            .collect();
        let positions = mesh.positions.iter().map(|point| point.map(|x| x as f32)).collect();
        let triangles = triangles.into_iter().map(|(_, triangle)| triangle).collect();
        Ok(BakedSurface::new((self.parts.clone(), self.bound), (positions, triangles), ends))
    }

    /// 0.02 and not 0.0199999996, as the plugin has it.
    fn bound_as_written(&self) -> Length {
        Length::units(self.bound.to_string().parse().unwrap_or(f64::from(self.bound)))
    }
}

fn affine([x, y, z, translation]: [[f64; 3]; 4]) -> DAffine3 {
    let matrix3 = DMat3::from_cols(x.into(), y.into(), z.into());
    DAffine3 { matrix3, translation: translation.into() }
}

/// The cell of a node's mesh.
fn cell(mesh: &SceneMesh, transform: &DAffine3, size: f32) -> Option<[i32; 3]> {
    let points = mesh.mesh.positions.iter();
    let (low, high) = bounds(points.map(|point| transform.transform_point3((*point).into())));
    let single = |corner: Vector| corner.to_array().map(|x| x as f32);
    level_cell(single(low), single(high), size)
}

/// Whether a node has a body or a surface of its own.
fn stands_alone(mesh: &SceneMesh, node: &SceneNode, tag: Option<&ArtistTag<'_>>) -> bool {
    let has_body = matches!(tag, Some(ArtistTag::Extras(tag)) if tag.body.is_some());
    let mut extras = [&node.extras, &mesh.extras].into_iter().flatten();
    has_body || extras.any(|text| read_surface(text).0 != SurfaceProperties::default())
}

/// What a transform does but turn and move: its colliders are made in this space. As engines do,
/// mirroring counts as along x.
fn without_rotation(transform: &DAffine3) -> DAffine3 {
    let (_, rotation, _) = transform.to_scale_rotation_translation();
    let turned_back = DMat3::from_quat(rotation.inverse()) * transform.matrix3;
    // A scale of 0 has no rotation.
    let matrix3 = if rotation.is_finite() { turned_back } else { transform.matrix3 };
    DAffine3 { matrix3, translation: Vector::ZERO }
}
