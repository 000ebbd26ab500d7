//! Skins of a glTF scene: where their joints put a mesh at rest.
//!
//! A vertex of a skinned mesh stands where its joints are, and the transform of the mesh's own node counts for nothing.
//! Exporters mostly bind a mesh where it stands, so that both agree but for rounding; then the node's transform is kept.

use glam::DAffine3;
use serde_json::Value;

use super::gltf_json::{entry, indices, key, optional_number};
use super::gltf_nodes::affine;
use crate::geometry::vector::{Vector, diagonal};

/// A skin moves a mesh if it moves a vertex by more than this fraction of the mesh's diagonal: rounding in single
/// precision moves it by less.
const LEAST_MOVE: f64 = 1e-4;

/// Reads an accessor's vectors, of four numbers and of sixteen.
pub(super) trait Vectors {
    fn fours(&mut self, accessor: usize) -> Result<Vec<[f64; 4]>, String>;
    fn matrices(&mut self, accessor: usize) -> Result<Vec<[f64; 16]>, String>;
}

/// What each joint does to a vertex.
pub(super) struct Skin(Vec<DAffine3>);

/// Where a primitive's vertices stand.
pub(super) struct Pose {
    pub(super) positions: Vec<Vector>,
    /// Left and right change places.
    pub(super) is_mirrored: bool,
}

impl Skin {
    pub(super) fn read(
        skins: &Value,
        index: usize,
        globals: &[Option<DAffine3>],
        vectors: &mut impl Vectors,
    ) -> Result<Self, String> {
        let skin = entry(skins, "skin", index)?;
        let joints = indices(skin, "joints")?;
        let inverse = match optional_number(skin, "inverseBindMatrices")? {
            Some(accessor) => Some(vectors.matrices(accessor)?),
            None => None,
        };
        let matrix = |(number, joint): (usize, &usize)| {
            let global = globals.get(*joint).copied().flatten().ok_or("a joint has no place")?;
            Ok(match &inverse {
                Some(list) => global * affine(list.get(number).ok_or("a joint has no matrix")?),
                None => global,
            })
        };
        Ok(Self(joints.iter().enumerate().map(matrix).collect::<Result<_, &str>>()?))
    }

    /// Where a primitive's vertices stand at rest; `None` for one that has no joints.
    pub(super) fn pose(
        &self,
        primitive: &Value,
        positions: &[[f64; 3]],
        vectors: &mut impl Vectors,
    ) -> Result<Option<Pose>, String> {
        let attributes = key(primitive, "attributes").unwrap_or(&Value::Null);
        let mut sums = vec![(Vector::ZERO, 0.0); positions.len()];
        let mut first_joints = Vec::new();
        for set in 0.. {
            let joints = optional_number(attributes, &format!("JOINTS_{set}"))?;
            let weights = optional_number(attributes, &format!("WEIGHTS_{set}"))?;
            let (Some(joints), Some(weights)) = (joints, weights) else { break };
            let (joints, weights) = (vectors.fours(joints)?, vectors.fours(weights)?);
            if joints.len() < positions.len() || weights.len() < positions.len() {
                return Err("there are fewer joints than vertices".into());
            }
            for (sum, (position, of)) in
                sums.iter_mut().zip(positions.iter().zip(joints.iter().zip(&weights)))
            {
                self.add((*position).into(), of, sum)?;
            }
            if set == 0 {
                first_joints = joints;
            }
        }
        if first_joints.is_empty() {
            return Ok(None);
        }
        let pose =
            |((sum, weight), (position, joints)): ((Vector, f64), (&[f64; 3], &[f64; 4]))| {
                // Without a weight the first joint has it all, as in renderers.
                let matrix = self.joint(joints[0])?;
                let place = match weight > 0.0 {
                    true => sum / weight,
                    false => matrix.transform_point3((*position).into()),
                };
                Ok(place)
            };
        let vertices = sums.into_iter().zip(positions.iter().zip(&first_joints));
        let places: Vec<Vector> = vertices.map(pose).collect::<Result<_, String>>()?;
        let matrix = first_joints.first().map(|joints| self.joint(joints[0])).transpose()?;
        let is_mirrored = matrix.is_some_and(|matrix| matrix.matrix3.determinant() < 0.0);
        Ok(Some(Pose { positions: places, is_mirrored }))
    }

    /// Adds what four joints do to a vertex, and their weights.
    fn add(
        &self,
        position: Vector,
        (joints, weights): (&[f64; 4], &[f64; 4]),
        (sum, weight): &mut (Vector, f64),
    ) -> Result<(), String> {
        for (joint, of_joint) in joints.iter().zip(weights) {
            if *of_joint > 0.0 {
                *sum += *of_joint * self.joint(*joint)?.transform_point3(position);
                *weight += of_joint;
            }
        }
        Ok(())
    }

    fn joint(&self, joint: f64) -> Result<&DAffine3, String> {
        self.0.get(joint as usize).ok_or_else(|| format!("its skin has no joint {joint}"))
    }
}

/// Whether a pose is elsewhere than the vertices that a node places.
pub(super) fn is_elsewhere(places: &[Vector], posed: &[Vector]) -> bool {
    let least = LEAST_MOVE * diagonal(places.iter().copied());
    places.iter().zip(posed).any(|(place, posed)| place.distance(*posed) > least)
}
