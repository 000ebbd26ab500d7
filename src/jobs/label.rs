//! Meshes that are found in a baked scene by their asset path and label,
//! `level.glb#Mesh3/Primitive0`, since their content is on the GPU alone, or is not to be hashed.
//! They are compared by their number of triangles and by their bounding box. Not by vertices: where
//! normals or textures have a seam, readers split them in ways of their own.

use std::collections::BTreeSet;

use bevy::asset::RenderAssetUsages;
use bevy::ecs::system::SystemParam;
use bevy::math::Affine3A;
use bevy::mesh::{Indices, PrimitiveTopology, VertexAttributeValues};
use bevy::platform::collections::HashMap;
use bevy::prelude::*;
use hullwright::Method;
use hullwright::hulls_format::HullScene;

use super::baked::BakedScene;
use super::request::{ColliderRequest, MeshPart};
use crate::tag::parameters::Goal;

/// What meshes look like from outside whose data the renderer takes away, worked out while it is
/// there.
#[derive(Resource, Debug, Default)]
pub(super) struct Outlines(HashMap<AssetId<Mesh>, Outline>);

/// Runs after Bevy has sent the events of new assets, and before the renderer takes their data.
/// O(size) for each mesh that is for the GPU only.
pub(super) fn note_outlines(
    mut outlines: ResMut<Outlines>,
    mut events: MessageReader<AssetEvent<Mesh>>,
    meshes: Res<Assets<Mesh>>,
) {
    for event in events.read() {
        match event {
            AssetEvent::Added { id } | AssetEvent::Modified { id } => {
                let mesh = meshes.get(*id).filter(|mesh| is_for_gpu_only(mesh));
                if let Some(outline) = mesh.and_then(Outline::of) {
                    outlines.0.insert(*id, outline);
                }
            }
            AssetEvent::Removed { id } | AssetEvent::Unused { id } => {
                outlines.0.remove(id);
            }
            AssetEvent::LoadedWithDependencies { .. } => {}
        }
    }
}

/// Whether a mesh's data is taken away, or has been.
pub(crate) fn is_for_gpu_only(mesh: &Mesh) -> bool {
    !mesh.asset_usage.contains(RenderAssetUsages::MAIN_WORLD)
}

/// What a mesh looks like from outside.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Outline {
    triangles: u64,
    /// The least and the largest coordinates of the corners of triangles.
    bounds: [[f32; 3]; 2],
}

impl Outline {
    /// Of a mesh whose data is there. O(size).
    fn of(mesh: &Mesh) -> Option<Self> {
        let positions = mesh.try_attribute(Mesh::ATTRIBUTE_POSITION).ok()?;
        let VertexAttributeValues::Float32x3(positions) = positions else { return None };
        let indices = mesh.try_indices_option().ok()?;
        let corners = indices.map_or(positions.len(), Indices::len) as u64;
        let triangles = match mesh.primitive_topology() {
            PrimitiveTopology::TriangleList => corners / 3,
            PrimitiveTopology::TriangleStrip => corners.saturating_sub(2),
            _ => return None,
        };
        let mut bounds = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
        let mut add = |corner: &[f32; 3]| bounds = union(bounds, [*corner; 2]);
        match indices {
            None => positions.iter().for_each(add),
            Some(indices) => {
                indices.iter().filter_map(|index| positions.get(index)).for_each(&mut add);
            }
        }
        Some(Self { triangles, bounds })
    }

    /// Whether a baked mesh looks the same, or what differs.
    fn compare(&self, triangles: u64, bounds: Option<[[f32; 3]; 2]>) -> Result<(), &'static str> {
        match () {
            () if self.triangles != triangles => {
                Err("its number of triangles has changed since it was baked")
            }
            () if Some(self.bounds) != bounds => {
                Err("its bounding box has changed since it was baked")
            }
            () => Ok(()),
        }
    }
}

/// What is known of meshes without their data.
#[derive(SystemParam)]
pub(super) struct Labels<'w> {
    outlines: Res<'w, Outlines>,
    server: Option<Res<'w, AssetServer>>,
}

impl Labels<'_> {
    /// The place in a baked scene of what a request is for, or why it has none.
    pub(super) fn find(
        &self,
        request: &ColliderRequest,
        scene: &BakedScene,
        meshes: &Assets<Mesh>,
    ) -> Result<usize, &'static str> {
        let goal = request.goal.as_ref().ok_or(NOT_ONE_MESH)?;
        let mesh = self.gltf_mesh(request, scene)?;
        let outline = |part: &MeshPart| {
            let own = meshes.get(part.mesh).and_then(Outline::of);
            own.or_else(|| self.outlines.0.get(&part.mesh).copied())
        };
        let outlines = request.parts.iter().map(outline).collect::<Option<Vec<_>>>();
        let all = outlines.ok_or("it is not made of triangles")?.into_iter().reduce(|a, b| {
            Outline { triangles: a.triangles + b.triangles, bounds: union(a.bounds, b.bounds) }
        });
        let outline = all.ok_or(NOT_ONE_MESH)?;
        match goal {
            Goal::Hulls(method) => place_of_hulls(scene, mesh, method, &outline),
            Goal::Triangles { .. } => place_of_triangles(scene.scene(), mesh, &outline),
            Goal::Primitive(_) => Err("it is to have a box, ball or capsule"),
        }
    }

    /// The index of the one glTF mesh whose primitives a request has, none of them transformed.
    fn gltf_mesh(
        &self,
        request: &ColliderRequest,
        scene: &BakedScene,
    ) -> Result<u32, &'static str> {
        let is_as_it_is = |map: &Affine3A| *map == Affine3A::IDENTITY;
        let mut maps = request.parts.iter().map(|part| &part.to_input);
        if !(is_as_it_is(&request.map_before) && maps.all(is_as_it_is)) {
            return Err(NOT_ONE_MESH);
        }
        let server = self.server.as_ref().ok_or("there are no asset paths")?;
        let (mut found, mut primitives) = (None, BTreeSet::new());
        for part in &request.parts {
            let path = server.get_path(part.mesh).ok_or("it has no asset path")?;
            if path.path().file_stem() != Some(scene.scene().name.as_ref()) {
                return Err("its asset path is not that of the scene");
            }
            let label = path.label().and_then(indices).ok_or("its label is none of a glTF mesh")?;
            let (mesh, primitive) = label;
            if *found.get_or_insert(mesh) != mesh || !primitives.insert(primitive) {
                return Err(NOT_ONE_MESH);
            }
        }
        found.ok_or(NOT_ONE_MESH)
    }
}

fn place_of_hulls(
    scene: &BakedScene,
    mesh: u32,
    method: &Method,
    outline: &Outline,
) -> Result<usize, &'static str> {
    let all = scene.scene().meshes.iter().enumerate();
    let mut of_mesh = all.filter(|(_, baked)| baked.gltf_meshes.contains(&mesh)).peekable();
    of_mesh.peek().ok_or(NOT_THERE)?;
    let found = of_mesh.find(|(_, baked)| baked.parameters == *method);
    let (index, baked) = found.ok_or("it was baked with other parameters")?;
    if !scene.is_usable(baked) {
        return Err("another version of Hullwright baked it");
    }
    outline.compare(baked.hulls.source_triangles, baked.bounds).map(|()| index)
}

fn place_of_triangles(
    scene: &HullScene,
    mesh: u32,
    outline: &Outline,
) -> Result<usize, &'static str> {
    let mut all = scene.triangles.iter().enumerate();
    let found = all.find(|(_, baked)| baked.gltf_meshes.contains(&mesh));
    let (index, baked) = found.ok_or("its triangles were not baked with `--triangles`")?;
    let place = scene.meshes.len() + index;
    outline.compare(baked.triangles.len() as u64, baked.bounds()).map(|()| place)
}

const NOT_THERE: &str = "no mesh with its label was baked";

const NOT_ONE_MESH: &str = "it is not one mesh of a file, at its own scale";

/// The numbers in the label of a primitive, `Mesh3/Primitive0`.
fn indices(label: &str) -> Option<(u32, u32)> {
    let (mesh, primitive) = label.split_once('/')?;
    let number = |text: &str, before| text.strip_prefix(before)?.parse().ok();
    Some((number(mesh, "Mesh")?, number(primitive, "Primitive")?))
}

/// Coordinates that are no numbers are left out.
fn union([low, high]: [[f32; 3]; 2], [other_low, other_high]: [[f32; 3]; 2]) -> [[f32; 3]; 2] {
    let pick = |a: [f32; 3], b: [f32; 3], pick: fn(f32, f32) -> f32| {
        [0, 1, 2].map(|axis| pick(a[axis], b[axis]))
    };
    [pick(low, other_low, f32::min), pick(high, other_high, f32::max)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_label_names_a_mesh_and_a_primitive() {
        assert_eq!(indices("Mesh12/Primitive3"), Some((12, 3)));
        for other in ["Mesh0", "Scene0", "Mesh0/MorphTargets", "Meshes/Primitive0", ""] {
            assert_eq!(indices(other), None, "{other}");
        }
    }

    #[test]
    fn corners_of_triangles_are_looked_at_and_other_vertices_are_not() {
        let corners = [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 2.0], [0.0, 3.0, -1.0], [9.0, 9.0, 9.0]];
        let mesh = |topology, indices| {
            Mesh::new(topology, RenderAssetUsages::default())
                .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, corners.to_vec())
                .with_inserted_indices(Indices::U16(indices))
        };
        let bounds = [[0.0, 0.0, -1.0], [1.0, 3.0, 2.0]];
        for (topology, triangles) in
            [(PrimitiveTopology::TriangleList, 2), (PrimitiveTopology::TriangleStrip, 4)]
        {
            let mesh = mesh(topology, vec![0, 1, 2, 2, 1, 0]);
            assert_eq!(Outline::of(&mesh), Some(Outline { triangles, bounds }));
        }
        assert_eq!(Outline::of(&mesh(PrimitiveTopology::LineList, vec![0, 1])), None);
        let mut taken = mesh(PrimitiveTopology::TriangleList, vec![0, 1, 2]);
        taken.take_gpu_data().unwrap();
        assert_eq!(Outline::of(&taken), None);
    }
}
