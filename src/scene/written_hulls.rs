//! Hulls that `hullwright bake --into` has written into a glTF file: the collider of the mesh that
//! they are of, without any work. What an artist has edited since wins.

use bevy::ecs::entity::EntityHashSet;
use bevy::ecs::system::SystemParam;
use bevy::gltf::GltfExtras;
use bevy::mesh::VertexAttributeValues;
use bevy::platform::collections::HashMap;
use bevy::prelude::*;
use hullwright::hulls_format::{HullScene, MeshHash};
use hullwright_formats::conventions::{HullsRecord, WrittenHull};

use super::complaints::Complaints;
use super::gltf_physics::{ColliderMesh, DeclaredMeshes, GltfPhysics, HullsInFile};
use crate::jobs::baked::BakedScene;
use crate::tag::NoConvexDecomposition;

/// Groups of hulls, and the meshes below them.
#[derive(SystemParam)]
pub(super) struct WrittenHulls<'w, 's> {
    extras: Query<'w, 's, &'static GltfExtras>,
    physics: Query<'w, 's, &'static GltfPhysics>,
    meshes_on: Query<'w, 's, &'static Mesh3d>,
    transforms: Query<'w, 's, &'static Transform>,
    names: Query<'w, 's, &'static Name>,
    parents: Query<'w, 's, &'static ChildOf>,
    children: Query<'w, 's, &'static Children>,
    meshes: Res<'w, Assets<Mesh>>,
    scenes: ResMut<'w, Assets<BakedScene>>,
}

/// Hulls that several nodes share.
type Known = HashMap<(MeshHash, Vec<String>), Handle<BakedScene>>;

impl WrittenHulls<'_, '_> {
    /// Puts the hulls of the groups among `nodes` on the nodes that they are of. Returns the groups
    /// whose hulls are taken.
    pub(super) fn take(
        &mut self,
        commands: &mut Commands,
        nodes: &[Entity],
        complaints: &mut Complaints,
    ) -> EntityHashSet {
        let mut groups = EntityHashSet::default();
        let mut known = Known::default();
        for &group in nodes {
            let Ok(extras) = self.extras.get(group) else { continue };
            let Some(record) = HullsRecord::from_extras(&extras.value) else { continue };
            let whole = self.parents.get(group).map(ChildOf::parent);
            let taken = match (record, whole) {
                (Err(wrong), _) => Err(wrong),
                (_, Err(_)) => Err("the hulls are of no node".into()),
                (Ok(record), Ok(whole)) => {
                    let read = self.read(group, whole, &record, &mut known, complaints);
                    read.map(|hulls| (whole, hulls))
                }
            };
            match taken {
                Err(wrong) => complaints.add(wrong, group),
                Ok((whole, hulls)) => {
                    groups.insert(group);
                    commands.entity(whole).try_insert(hulls);
                    commands.entity(group).try_insert(NoConvexDecomposition);
                    let below = self.children.iter_descendants(group);
                    for mesh in below.filter(|entity| self.meshes_on.contains(*entity)) {
                        commands.entity(mesh).try_insert((ColliderMesh, Visibility::Hidden));
                    }
                }
            }
        }
        groups
    }

    fn read(
        &mut self,
        group: Entity,
        whole: Entity,
        record: &HullsRecord,
        known: &mut Known,
        complaints: &mut Complaints,
    ) -> Result<HullsInFile, String> {
        let hulls = self.hulls(group)?;
        let name = self.names.get(whole).map_or("", Name::as_str);
        let read = record.read_back(name, &hulls).map_err(|error| error.to_string())?;
        for error in read.left_out {
            complaints.add(error.to_string(), group);
        }
        let new = || self.scenes.add(BakedScene::new(HullScene::new(name, vec![read.baked])));
        if read.edited {
            log::info!("the hulls of {whole} ({name}) were edited since they were baked");
            return Ok(HullsInFile { scene: new(), is_edited: true });
        }
        let key = (record.mesh, record.digests.clone());
        let scene = known.entry(key).or_insert_with(new).clone();
        Ok(HullsInFile { scene, is_edited: false })
    }

    /// The hulls below a group, in the space of the node that it is below.
    fn hulls(&self, group: Entity) -> Result<Vec<WrittenHull>, String> {
        let of_group = self.transforms.get(group).copied().unwrap_or_default();
        let mut hulls = Vec::new();
        for child in self.children.get(group).into_iter().flatten().copied() {
            let of_child = of_group * self.transforms.get(child).copied().unwrap_or_default();
            let declared = self.physics.get(child).map(|physics| &physics.collider);
            let mut placed = match declared {
                Ok(DeclaredMeshes::Placed(placed)) => placed.clone(),
                _ => Vec::new(),
            };
            if placed.is_empty() {
                let all = std::iter::once(child).chain(self.children.iter_descendants(child));
                placed.extend(all.filter_map(|entity| {
                    let mesh = self.meshes_on.get(entity).ok()?.0.clone();
                    let place = self.transforms.get(entity).copied().unwrap_or_default();
                    Some((mesh, if entity == child { Transform::IDENTITY } else { place }))
                }));
            }
            let mut hull = WrittenHull::default();
            for (mesh, place) in placed {
                self.add(&mesh, of_child * place, &mut hull)?;
            }
            if !hull.points.is_empty() {
                hulls.push(hull);
            }
        }
        Ok(hulls)
    }

    fn add(
        &self,
        mesh: &Handle<Mesh>,
        place: Transform,
        hull: &mut WrittenHull,
    ) -> Result<(), String> {
        let gone = || "the hulls in the file are on the GPU only".to_owned();
        let mesh = self.meshes.get(mesh).ok_or_else(gone)?;
        let positions = mesh.try_attribute(Mesh::ATTRIBUTE_POSITION).map_err(|_| gone())?;
        let VertexAttributeValues::Float32x3(positions) = positions else { return Err(gone()) };
        let first = hull.points.len() as u32;
        let is_there = place == Transform::IDENTITY;
        let put = |point: &[f32; 3]| match is_there {
            true => *point,
            false => place.transform_point(Vec3::from(*point)).to_array(),
        };
        hull.points.extend(positions.iter().map(put));
        let indices: Vec<u32> = match mesh.indices() {
            Some(indices) => indices.iter().map(|index| index as u32).collect(),
            None => (0..positions.len() as u32).collect(),
        };
        let is_inside = |index: &u32| (*index as usize) < positions.len();
        let triangles = indices.as_chunks::<3>().0.iter();
        let triangles = triangles.filter(|triangle| triangle.iter().all(is_inside));
        hull.triangles.extend(triangles.map(|triangle| triangle.map(|index| first + index)));
        Ok(())
    }
}
