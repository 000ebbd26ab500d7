//! From a hull or a triangle that was hit to the entity whose mesh it is made of, and so to its
//! material, its name and its sounds.

use std::sync::Arc;

use bevy::prelude::*;
use hullwright::PartShare;
use hullwright::hulls_format::MeshPart;

use crate::jobs::cache::ColliderGeometry;

/// On an entity with a collider of the plugin's: what its hulls or triangles are made of.
///
/// A collider may be made of many meshes: a glTF mesh of several materials is an entity with a
/// `Mesh3d` for each. These are its parts. A ray, cast or contact says which *subshape* it met: the
/// index of the hull, or of the triangle. From there one call leads to the part:
///
/// ```
/// use bevy::prelude::*;
/// use bevy_hullwright::prelude::*;
///
/// #[derive(Component, Clone, Copy)]
/// enum Footsteps {
///     Stone,
///     Wood,
/// }
///
/// /// How it sounds where a foot met a subshape of a collider.
/// fn footsteps(
///     (collider, subshape): (Entity, u32),
///     parts: &Query<&ColliderParts>,
///     sounds: &Query<&Footsteps>,
/// ) -> Option<Footsteps> {
///     let part = parts.get(collider).ok()?.part(subshape)?;
///     sounds.get(part).ok().copied()
/// }
/// ```
///
/// Rapier's rays, casts and contacts have the subshape. Avian's have not: there
/// [`subshape_at`](crate::subshape_at) finds it by the point that was hit.
///
/// A collider of one part is made of that. A box, ball or capsule is made of all parts alike: then
/// no part is known. A [`BakedDecomposition`](crate::BakedDecomposition) has the parts of its file,
/// where as many meshes are there; and [`baked_part`](Self::baked_part) names them without any.
#[derive(Component, Debug, Clone)]
pub struct ColliderParts {
    entities: Vec<Entity>,
    geometry: Arc<ColliderGeometry>,
    /// Of a collider of some hulls these, by subshape.
    hulls: Option<Vec<u32>>,
}

impl ColliderParts {
    pub(super) fn new(entities: Vec<Entity>, geometry: Arc<ColliderGeometry>) -> Self {
        Self { entities, geometry, hulls: None }
    }

    /// The same collider, of other entities with the same meshes.
    pub(crate) fn of_others(&self, entities: &[Entity]) -> Option<Self> {
        let is_same = self.entities == entities;
        (!is_same).then(|| Self { entities: entities.to_vec(), ..self.clone() })
    }

    /// The same of some of the hulls.
    pub(crate) fn of_hulls(&self, hulls: &[u32]) -> Self {
        Self { hulls: Some(hulls.to_vec()), ..self.clone() }
    }

    /// Which hull of all a subshape of the collider is.
    fn hull(&self, subshape: u32) -> u32 {
        match self.hulls.as_deref() {
            None => subshape,
            Some(hulls) => {
                let hull = hulls.get(index_of_hull(hulls.len(), subshape));
                hull.copied().unwrap_or(NO_SUBSHAPE)
            }
        }
    }

    pub(crate) fn geometry(&self) -> &ColliderGeometry {
        &self.geometry
    }

    /// The place of a hull's largest part among the parts.
    pub(crate) fn index_of_part(&self, hull: u32) -> Option<u32> {
        let part = self.part(hull)?;
        self.entities.iter().position(|entity| *entity == part).map(|index| index as u32)
    }

    /// All parts: entities with a `Mesh3d`.
    pub fn entities(&self) -> &[Entity] {
        &self.entities
    }

    /// The part that a hull or a triangle is made of; of several the one with the largest share of
    /// the area. `None` if that is not known, or there is no such subshape. O(1) for hulls,
    /// O(log parts) for triangles.
    pub fn part(&self, subshape: u32) -> Option<Entity> {
        self.shares(subshape).next().map(|(entity, _)| entity)
    }

    /// The mesh, the primitive and the material, by their names in the scene's file, that a hull is
    /// made of, of several those with the largest share of its area: where hulls are baked, also
    /// without any mesh, as on a server. `None` elsewhere. O(1).
    pub fn baked_part(&self, subshape: u32) -> Option<&MeshPart> {
        let ColliderGeometry::Hulls(file, _) = &*self.geometry else { return None };
        file.part(index_of_hull(file.hulls.len(), self.hull(subshape)))
    }

    /// All parts that a hull or a triangle is made of, the largest first, with their shares of the
    /// area that it stands for. They add up to 1.
    pub fn shares(&self, subshape: u32) -> impl Iterator<Item = (Entity, f32)> + '_ {
        let subshape = self.hull(subshape);
        let (whole, of_hull) = match (&self.entities[..], &*self.geometry) {
            (&[only], geometry) => ((subshape < subshapes(geometry)).then_some(only), None),
            (_, ColliderGeometry::Triangles(data)) => {
                let is_there = (subshape as usize) < data.triangles.len();
                let part = is_there.then(|| self.entities.get(data.part_of(subshape))).flatten();
                (part.copied(), None)
            }
            (_, ColliderGeometry::Hulls(file, shares)) => {
                let shares = match shares.is_empty() && file.parts.len() == self.entities.len() {
                    true => &file.part_shares,
                    false => shares,
                };
                (None, shares.get(index_of_hull(shares.len(), subshape)))
            }
            (_, ColliderGeometry::Primitive(..)) => (None, None),
        };
        let of_hull = of_hull.into_iter().flatten().filter_map(|&PartShare { part, share }| {
            Some((*self.entities.get(part as usize)?, share as f32))
        });
        whole.map(|entity| (entity, 1.0)).into_iter().chain(of_hull)
    }
}

/// A single hull is no compound, whose subshape engines number as they like.
fn index_of_hull(hulls: usize, subshape: u32) -> usize {
    if hulls == 1 { 0 } else { subshape as usize }
}

/// No collider has so many.
const NO_SUBSHAPE: u32 = u32::MAX;

/// How many subshapes there are.
fn subshapes(geometry: &ColliderGeometry) -> u32 {
    let count = match geometry {
        ColliderGeometry::Hulls(file, _) if file.hulls.len() > 1 => file.hulls.len(),
        ColliderGeometry::Triangles(data) => data.triangles.len(),
        // A shape that is no compound, whose subshape engines number as they like.
        ColliderGeometry::Hulls(..) | ColliderGeometry::Primitive(..) => return NO_SUBSHAPE,
    };
    u32::try_from(count).unwrap_or(NO_SUBSHAPE)
}
