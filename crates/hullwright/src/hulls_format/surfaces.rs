//! Simplified surfaces of a scene, each found by what it is made of.

use crate::sorting::sort_by_key;
use sha2::{Digest, Sha256};

use super::file::{HullsFileError, Reader, count, numbers, points, read_numbers, valid};
use super::mesh_hash::MeshHash;

/// A mesh, and where it is in a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlacedMesh {
    /// Its content, where it is not placed.
    pub mesh: MeshHash,
    /// Of how many primitives its triangles are.
    pub primitives: u32,
    /// Where it is: the columns of a linear map, then a translation.
    pub place: [[f32; 3]; 4],
}

/// The triangles that some meshes of a scene have together, for what never moves: as
/// [`simplify_surface`](crate::simplify_surface()) makes them, or those of the meshes.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
pub struct BakedSurface {
    /// How far they may be from the meshes, in units of the world; 0 for their own triangles.
    pub bound: f32,
    /// What it is made of.
    pub parts: Vec<PlacedMesh>,
    /// Finite coordinates.
    pub positions: Vec<[f32; 3]>,
    /// Indices of positions, sorted by parts and their primitives.
    pub triangles: Vec<[u32; 3]>,
    /// For each primitive of each part how many triangles there are up to its end.
    pub ends: Vec<u32>,
}

/// How far entries of two places may differ, as a fraction of the largest of their kind: programs
/// multiply the transforms of nodes in single precision, in another order, and of levels that are
/// much larger than a cell.
const TOLERANCE: f32 = 1e-4;

impl PlacedMesh {
    /// Whether both are the same mesh in the same place.
    fn is(&self, other: &Self) -> bool {
        let size = |columns: &[[f32; 3]]| {
            columns.as_flattened().iter().fold(0.0_f32, |size, x| size.max(x.abs()))
        };
        let are_near = |a: &[[f32; 3]], b: &[[f32; 3]], size: f32| {
            let mut all = a.as_flattened().iter().zip(b.as_flattened());
            all.all(|(a, b)| (a - b).abs() <= TOLERANCE * size)
        };
        let (linear, whole) = (size(&self.place[..3]), size(&self.place));
        (self.mesh, self.primitives) == (other.mesh, other.primitives)
            && are_near(&self.place[..3], &other.place[..3], linear)
            && are_near(&self.place[3..], &other.place[3..], whole)
    }
}

/// What surfaces of the same meshes within the same bound have in common, wherever the meshes are,
/// in any order. O(n log n) for n parts.
pub fn surface_key(parts: &[PlacedMesh], bound: f32) -> [u8; 32] {
    let mut meshes: Vec<MeshHash> = parts.iter().map(|part| part.mesh).collect();
    meshes.sort_unstable();
    let mut hasher = Sha256::new_with_prefix(bound.to_le_bytes());
    meshes.iter().for_each(|mesh| hasher.update(mesh.as_bytes()));
    hasher.finalize().into()
}

impl BakedSurface {
    /// A surface of parts, for whose primitives `ends` says how many triangles there are up to the
    /// end of each.
    pub fn new(
        (parts, bound): (Vec<PlacedMesh>, f32),
        (positions, triangles): (Vec<[f32; 3]>, Vec<[u32; 3]>),
        ends: Vec<u32>,
    ) -> Self {
        Self { bound, parts, positions, triangles, ends }
    }

    /// For each of some parts, in any order, its index among those of the surface; `None` if it is
    /// made of others. O(n log n) for n parts, as long as few of one mesh are in one place.
    pub fn order_of(&self, parts: &[PlacedMesh]) -> Option<Vec<u32>> {
        if parts.len() != self.parts.len() {
            return None;
        }
        let mut by_mesh: Vec<u32> = (0..self.parts.len() as u32).collect();
        let mesh_of = |index: &u32| self.parts[*index as usize].mesh;
        sort_by_key(&mut by_mesh, mesh_of);
        let mut is_taken = vec![false; parts.len()];
        let find = |part: &PlacedMesh| {
            let start = by_mesh.partition_point(|index| mesh_of(index) < part.mesh);
            let same = by_mesh[start..].iter().take_while(|index| mesh_of(index) == part.mesh);
            let mut same = same.map(|index| *index as usize);
            let found = same.find(|index| !is_taken[*index] && self.parts[*index].is(part))?;
            is_taken[found] = true;
            Some(found as u32)
        };
        parts.iter().map(find).collect()
    }

    /// The triangles of each primitive of a part, one list for each. O(parts).
    pub fn triangles_of(&self, part: u32) -> impl Iterator<Item = &[[u32; 3]]> {
        let before = self.parts.iter().take(part as usize);
        let first: usize = before.map(|part| part.primitives as usize).sum();
        let primitives = self.parts.get(part as usize).map_or(0, |part| part.primitives as usize);
        (first..first + primitives).filter_map(|index| {
            let start =
                index.checked_sub(1).map_or(Some(0), |last| self.ends.get(last).copied())?;
            self.triangles.get(start as usize..*self.ends.get(index)? as usize)
        })
    }

    pub(super) fn write(&self, bytes: &mut Vec<u8>) -> Result<(), HullsFileError> {
        bytes.extend(self.bound.to_le_bytes());
        count(bytes, self.parts.len())?;
        for part in &self.parts {
            bytes.extend(part.mesh.as_bytes());
            bytes.extend(part.primitives.to_le_bytes());
            points(bytes, &part.place);
        }
        count(bytes, self.positions.len())?;
        points(bytes, &self.positions);
        numbers(bytes, self.triangles.as_flattened())?;
        numbers(bytes, &self.ends)
    }

    pub(super) fn read(reader: &mut Reader<'_>) -> Result<Self, HullsFileError> {
        let bound = f32::from_le_bytes(reader.array()?);
        valid(bound.is_finite() && bound >= 0.0, "a bound is none")?;
        let parts = reader.count(PART)?;
        let parts = (0..parts).map(|_| part(reader)).collect::<Result<Vec<_>, _>>()?;
        let positions = reader.count(size_of::<[f32; 3]>())?;
        let positions =
            (0..positions).map(|_| reader.single_point()).collect::<Result<Vec<_>, _>>()?;
        let corners = read_numbers(reader)?;
        let (triangles, rest) = corners.as_chunks::<3>();
        valid(rest.is_empty(), "a triangle lacks a corner")?;
        let all_exist = corners.iter().all(|corner| (*corner as usize) < positions.len());
        valid(all_exist, "a triangle names a point that is not there")?;
        let ends = read_numbers(reader)?;
        let primitives: u64 = parts.iter().map(|part| u64::from(part.primitives)).sum();
        let last = ends.last().map_or(0, |end| *end as usize);
        let are_right = ends.len() as u64 == primitives && last == triangles.len();
        valid(are_right && ends.is_sorted(), "it is unknown of what a triangle is made")?;
        Ok(Self { bound, parts, positions, triangles: triangles.to_vec(), ends })
    }
}

/// The bytes of a part: a hash, a number and four points.
const PART: usize = 32 + 4 + 4 * 3 * size_of::<f32>();

/// The bytes of a surface of nothing: a bound and four lengths.
pub(super) const LEAST_SURFACE: usize = 5 * 4;

fn part(reader: &mut Reader<'_>) -> Result<PlacedMesh, HullsFileError> {
    let mesh = MeshHash::from_bytes(reader.array()?);
    let primitives = reader.u32()?;
    let mut point = || reader.single_point();
    Ok(PlacedMesh { mesh, primitives, place: [point()?, point()?, point()?, point()?] })
}

#[cfg(test)]
mod tests {
    use super::super::scene::HullScene;
    use super::*;

    fn placed(mesh: u8, x: f32) -> PlacedMesh {
        let place = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [x, 0.0, 0.0]];
        PlacedMesh { mesh: MeshHash::from_bytes([mesh; 32]), primitives: 1, place }
    }

    /// Three triangles: of the first part one, of the second none and one, of the third one.
    fn surface() -> BakedSurface {
        let parts =
            vec![placed(1, 0.0), PlacedMesh { primitives: 2, ..placed(2, 5.0) }, placed(1, 9.0)];
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let triangles = vec![[0, 1, 2], [0, 1, 3], [1, 2, 3]];
        BakedSurface::new((parts, 0.02), (positions, triangles), vec![1, 1, 2, 3])
    }

    fn scene() -> HullScene {
        HullScene::new("level", Vec::new()).with_surfaces(vec![surface()])
    }

    #[test]
    fn a_surface_is_written_and_read_and_a_file_without_one_is_of_an_older_version() {
        let bytes = scene().to_bytes().unwrap();
        assert!(bytes.starts_with(b"\x89HULSC\r\n\x04\0\0\0"));
        assert_eq!(HullScene::from_bytes(&bytes), Ok(scene()));
        let without = HullScene::new("level", Vec::new()).to_bytes().unwrap();
        assert!(without.starts_with(b"\x89HULSC\r\n\x02\0\0\0"));
    }

    #[test]
    fn it_is_found_by_its_parts_in_any_order_and_with_rounded_places() {
        let surface = surface();
        let [first, second, third] = surface.parts[..].try_into().unwrap();
        let rounded = PlacedMesh { place: placed(1, 9.000_01).place, ..third };
        assert_eq!(surface.order_of(&[rounded, first, second]), Some(vec![2, 0, 1]));
        assert_eq!(surface.order_of(&[first, first, second]), None);
        assert_eq!(surface.order_of(&[first, second]), None);
        assert_eq!(surface.order_of(&[placed(1, 9.01), first, second]), None);
        assert_eq!(surface.order_of(&[placed(2, 5.0), first, third]), None);
        let key = surface_key(&surface.parts, 0.02);
        assert_eq!(surface_key(&[third, first, second], 0.02), key);
        assert_ne!(surface_key(&[third, first, second], 0.03), key);
        assert_ne!(surface_key(&[first, second], 0.02), key);
    }

    #[test]
    fn each_primitive_has_its_triangles() {
        let surface = surface();
        let of = |part| surface.triangles_of(part).map(<[_]>::len).collect::<Vec<_>>();
        assert_eq!([of(0), of(1), of(2), of(3)], [vec![1], vec![0, 1], vec![1], vec![]]);
        assert_eq!(surface.triangles_of(2).next(), Some(&[[1, 2, 3]][..]));
    }

    #[test]
    fn what_is_wrong_in_a_surface_is_an_error() {
        let wrong = |change: &dyn Fn(&mut BakedSurface)| {
            let mut surface = surface();
            change(&mut surface);
            let scene = HullScene::new("", Vec::new()).with_surfaces(vec![surface]);
            HullScene::from_bytes(&scene.to_bytes().unwrap()).unwrap_err()
        };
        let invalid = |error| matches!(error, HullsFileError::Invalid(_));
        assert!(invalid(wrong(&|of| of.bound = f32::NAN)));
        assert!(invalid(wrong(&|of| of.bound = -1.0)));
        assert!(invalid(wrong(&|of| of.triangles[0][1] = 4)));
        assert!(invalid(wrong(&|of| of.positions[3][0] = f32::INFINITY)));
        assert!(invalid(wrong(&|of| of.parts[0].place[3][0] = f32::NAN)));
        assert!(invalid(wrong(&|of| of.ends = vec![1, 1, 3])));
        assert!(invalid(wrong(&|of| of.ends = vec![2, 1, 2, 3])));
        assert!(invalid(wrong(&|of| of.ends = vec![1, 1, 2, 9])));
        assert!(invalid(wrong(&|of| of.parts[1].primitives = u32::MAX)));
    }
}
