//! Skins of a glTF scene: where their joints put a mesh at rest.
//!
//! A vertex of a skinned mesh stands where its joints are, and the transform of the mesh's own node
//! counts for nothing. Exporters mostly bind a mesh where it stands, so that both agree except for
//! rounding. An armature with a scale or a rotation of its own moves all of the mesh. A pose moves
//! limbs; a collider is better made of the mesh as it was modelled.

use glam::DAffine3;

use super::gltf_json::{indices, key, optional_number};
use super::gltf_nodes::affine;
use super::gltf_tree::Json;
use crate::vector::{Vector, diagonal};

/// A skin poses a mesh if it moves a vertex by more than this fraction of the mesh's diagonal:
/// rounding in single precision moves it by less.
const LEAST_MOVE: f64 = 1e-4;

/// A skin moves all of a mesh if it moves vertices by more than this fraction of the diagonal, on
/// average. Arms that hang where they were modelled outstretched make half of it.
const LEAST_MOVE_OF_ALL: f64 = 0.1;

/// Reads an accessor's vectors, of four numbers and of sixteen.
pub(super) trait Vectors {
    fn fours(&mut self, accessor: usize) -> Result<Vec<[f64; 4]>, String>;
    fn matrices(&mut self, accessor: usize) -> Result<Vec<[f64; 16]>, String>;
}

/// What each joint does to a vertex.
pub(super) struct Skin(Vec<DAffine3>);

/// What the joints do to a vertex.
#[derive(Clone, Default)]
struct Blend {
    /// Of where each joint puts it, times the joint's weight.
    sum: Vector,
    weight: f64,
    /// The first joint, which has all the weight where there is none, as in renderers.
    first: f64,
}

/// Where a primitive's vertices stand.
pub(super) struct Pose {
    pub(super) positions: Vec<Vector>,
    /// Left and right change places.
    pub(super) is_mirrored: bool,
}

impl Skin {
    pub(super) fn read(
        skin: &Json<'_>,
        globals: &[Option<DAffine3>],
        vectors: &mut impl Vectors,
    ) -> Result<Self, String> {
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
        primitive: &Json<'_>,
        positions: &[[f64; 3]],
        vectors: &mut impl Vectors,
    ) -> Result<Option<Pose>, String> {
        let attributes = key(primitive, "attributes").unwrap_or(&Json::Null);
        let mut blends = vec![Blend::default(); positions.len()];
        for set in 0.. {
            let joints = optional_number(attributes, &format!("JOINTS_{set}"))?;
            let weights = optional_number(attributes, &format!("WEIGHTS_{set}"))?;
            let (Some(joints), Some(weights)) = (joints, weights) else {
                if set == 0 {
                    return Ok(None);
                }
                break;
            };
            let (joints, weights) = (vectors.fours(joints)?, vectors.fours(weights)?);
            if joints.len() < positions.len() || weights.len() < positions.len() {
                return Err("there are fewer joints than vertices".into());
            }
            let vertices = blends.iter_mut().zip(positions);
            for ((blend, position), (joints, weights)) in vertices.zip(joints.iter().zip(&weights))
            {
                if set == 0 {
                    blend.first = joints[0];
                }
                self.add(blend, (*position).into(), (joints, weights))?;
            }
        }
        let place = |(blend, position): (&Blend, &[f64; 3])| match blend.weight > 0.0 {
            true => Ok(blend.sum / blend.weight),
            false => Ok(self.joint(blend.first)?.transform_point3((*position).into())),
        };
        let places: Result<_, String> = blends.iter().zip(positions).map(place).collect();
        let first = blends.first().map(|blend| self.joint(blend.first)).transpose()?;
        let is_mirrored = first.is_some_and(|matrix| matrix.matrix3.determinant() < 0.0);
        Ok(Some(Pose { positions: places?, is_mirrored }))
    }

    /// Adds what four joints do to a vertex.
    fn add(
        &self,
        blend: &mut Blend,
        position: Vector,
        (joints, weights): (&[f64; 4], &[f64; 4]),
    ) -> Result<(), String> {
        for (joint, weight) in joints.iter().zip(weights).filter(|(_, weight)| **weight > 0.0) {
            blend.sum += *weight * self.joint(*joint)?.transform_point3(position);
            blend.weight += weight;
        }
        Ok(())
    }

    fn joint(&self, joint: f64) -> Result<&DAffine3, String> {
        self.0.get(joint as usize).ok_or_else(|| format!("its skin has no joint {joint}"))
    }
}

/// What a skin does to a mesh at rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Effect {
    Nothing,
    Pose,
    MoveOfAll,
}

impl Effect {
    /// By where a node places vertices, and where joints put them.
    pub(super) fn of(places: &[Vector], posed: &[Vector]) -> Self {
        let diagonal = diagonal(places.iter().copied());
        let moves = || places.iter().zip(posed).map(|(place, posed)| place.distance(*posed));
        if moves().sum::<f64>() > LEAST_MOVE_OF_ALL * diagonal * places.len() as f64 {
            return Self::MoveOfAll;
        }
        match moves().any(|by| by > LEAST_MOVE * diagonal) {
            true => Self::Pose,
            false => Self::Nothing,
        }
    }
}
