//! The same mesh in other words: turned, scaled, moved, jittered, shuffled; and damaged.

use glam::{DMat3, DQuat};
use hullwright::TriangleMesh;
use serde::{Deserialize, Serialize};

use super::damage::{decimate, keep, shuffle, split};
use super::disturb::{jitter, jitter_welded, slivers, walls};
use super::random::Random;
use crate::shapes::{Vector, bounds, join, middle, turn};

/// What is done to a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Variation {
    /// Nothing.
    None,
    /// A rotation, by its number.
    Rotation(u32),
    /// All coordinates times this.
    Scale(f64),
    /// Moved along the diagonal of space by this multiple of the mesh's diagonal.
    Offset(f64),
    /// The same, and then rounded to single precision.
    OffsetSingle(f64),
    /// Mirrored, with triangles as they are: inside out.
    Mirror,
    /// Mirrored, with triangles turned to match.
    MirrorTurned,
    /// Each coordinate of each vertex moved by up to this share of the diagonal, at random.
    Jitter(f64),
    /// The same, but vertices at the same place move together.
    JitterWelded(f64),
    /// Triangles and vertices in another order, by its number.
    Shuffle(u32),
    /// All triangles turned around.
    FlipAll,
    /// Half of the triangles, at random, turned around.
    FlipHalf,
    /// Every triangle twice.
    Double,
    /// Each triangle in three, one of them a needle whose height is this share of its longest edge.
    Slivers(f64),
    /// With a copy of the surface this share of the diagonal outside.
    Walls(f64),
    /// A tenth of the triangles, at random, left out.
    Lose,
    /// Vertices in the same cube of a lattice become one: its step is this share of the diagonal.
    Merge(f64),
    /// Each triangle with vertices of its own, shrunk by this share toward its centre.
    Split(f64),
    /// About half of the vertices moved to a neighbour each, whatever that does.
    Decimate,
    /// Only triangles on one side of a plane through the middle.
    Cut,
    /// Joined to itself turned around the middle.
    Join,
}

const ROTATIONS: u32 = 8;
const SCALES: [f64; 8] = [1e-12, 1e-9, 1e-6, 1e-3, 1e3, 1e6, 1e9, 1e12];
const OFFSETS: [f64; 4] = [1.0, 1e2, 1e4, 1e6];
/// At the last, rounding to single precision moves coordinates by up to 2.4e-4 of the diagonal.
const OFFSETS_SINGLE: [f64; 5] = [1.0, 1e1, 1e2, 1e3, 1e4];
const NOISES: [f64; 9] = [1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1];
const ASPECTS: [f64; 3] = [1e-9, 1e-6, 1e-3];
const WALLS: [f64; 8] = [1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2];

impl Variation {
    /// All of them, the mesh as it is first.
    pub fn all() -> Vec<Self> {
        let mut all = vec![Self::None];
        all.extend((0..ROTATIONS).map(Self::Rotation));
        all.extend(SCALES.map(Self::Scale));
        all.extend(OFFSETS.map(Self::Offset));
        all.extend(OFFSETS_SINGLE.map(Self::OffsetSingle));
        all.extend([Self::MirrorTurned, Self::Mirror, Self::FlipAll, Self::FlipHalf]);
        all.extend([Self::Shuffle(0), Self::Double]);
        all.extend(ASPECTS.map(Self::Slivers));
        all.extend(WALLS.map(Self::Walls));
        all.extend(NOISES.map(Self::JitterWelded));
        // Where vertices part by a tenth of the diagonal, nothing is left to compare.
        all.extend(NOISES.into_iter().filter(|&size| size < 0.1).map(Self::Jitter));
        all
    }

    /// Damage of every sort that files show, and sizes far from 1.
    pub fn damages() -> [Self; 11] {
        [
            Self::Lose,
            Self::FlipHalf,
            Self::Double,
            Self::Jitter(1e-2),
            Self::Merge(0.03),
            Self::Split(1e-3),
            Self::Decimate,
            Self::Cut,
            Self::Scale(1e-6),
            Self::Scale(1e6),
            Self::Join,
        ]
    }

    /// Its name in journals; nothing for the mesh as it is.
    pub fn name(self) -> String {
        match self {
            Self::None => String::new(),
            Self::Rotation(number) => format!("rotated {number}"),
            Self::Scale(factor) => format!("scaled by {factor:e}"),
            Self::Offset(distance) => format!("moved by {distance:e} diagonals"),
            Self::OffsetSingle(distance) => {
                format!("moved by {distance:e} diagonals, in single precision")
            }
            Self::Mirror => "mirrored, inside out".into(),
            Self::MirrorTurned => "mirrored".into(),
            Self::Jitter(size) => format!("jittered by {size:e} diagonals"),
            Self::JitterWelded(size) => format!("jittered, welded, by {size:e} diagonals"),
            Self::Shuffle(number) => format!("shuffled {number}"),
            Self::FlipAll => "all triangles flipped".into(),
            Self::FlipHalf => "half of the triangles flipped".into(),
            Self::Double => "every triangle twice".into(),
            Self::Slivers(aspect) => format!("slivers of aspect {aspect:e}"),
            Self::Walls(distance) => format!("walls {distance:e} diagonals apart"),
            Self::Lose => "a tenth of the triangles lost".into(),
            Self::Merge(step) => format!("vertices merged within {step} diagonals"),
            Self::Split(share) => format!("triangles split, smaller by {share:e}"),
            Self::Decimate => "decimated".into(),
            Self::Cut => "cut open".into(),
            Self::Join => "joined to itself turned".into(),
        }
    }

    /// The row of the table that it belongs to.
    pub fn kind(self) -> String {
        match self {
            Self::None => "as it is".into(),
            Self::Rotation(_) => "rotated".into(),
            Self::Shuffle(_) => "shuffled".into(),
            other => other.name(),
        }
    }

    /// What has a size, and the size: a line of a plot.
    pub fn size(self) -> Option<(&'static str, f64)> {
        match self {
            Self::Scale(factor) => Some(("scaled", factor)),
            Self::Offset(distance) => Some(("moved", distance)),
            Self::OffsetSingle(distance) => Some(("moved, single", distance)),
            Self::Jitter(size) => Some(("jittered", size)),
            Self::JitterWelded(size) => Some(("jittered, welded", size)),
            Self::Slivers(aspect) => Some(("slivers", aspect)),
            Self::Walls(distance) => Some(("walls", distance)),
            _ => None,
        }
    }

    /// The mesh as given to the method, and the mesh that its hulls are measured against: the one
    /// that was given, or the simplest of the same surface.
    pub fn apply(self, mesh: &TriangleMesh) -> (TriangleMesh, TriangleMesh) {
        let (low, high) = bounds(&mesh.positions);
        let diagonal = low.distance(high);
        let moved = |place: &dyn Fn([f64; 3]) -> [f64; 3]| {
            let positions = mesh.positions.iter().map(|&point| place(point)).collect();
            TriangleMesh { positions, ..mesh.clone() }
        };
        let offset = |distance: f64| distance * diagonal / 3.0_f64.sqrt();
        let mut given = mesh.clone();
        match self {
            Self::None => {}
            Self::Rotation(number) => {
                let rotation = rotation(number);
                given = moved(&|point| (rotation * Vector::from(point)).to_array());
            }
            Self::Scale(factor) => given = moved(&|point| point.map(|x| x * factor)),
            Self::Offset(distance) => given = moved(&|point| point.map(|x| x + offset(distance))),
            Self::OffsetSingle(distance) => {
                given = moved(&|point| point.map(|x| f64::from((x + offset(distance)) as f32)));
            }
            Self::Mirror => given = moved(&|[x, y, z]| [-x, y, z]),
            Self::MirrorTurned => given = turn(moved(&|[x, y, z]| [-x, y, z])),
            Self::Jitter(size) => jitter(&mut given, diagonal * size),
            Self::JitterWelded(size) => jitter_welded(&mut given, diagonal * size),
            Self::Shuffle(number) => shuffle(&mut given, &mut Random(1 + u64::from(number))),
            Self::FlipAll => given = turn(given),
            Self::FlipHalf => {
                let mut random = Random(1);
                for triangle in &mut given.triangles {
                    if random.unit() < 0.5 {
                        triangle.swap(1, 2);
                    }
                }
            }
            Self::Double => {
                given.triangles.extend_from_slice(&mesh.triangles);
                given.sidedness.extend_from_slice(&mesh.sidedness);
            }
            Self::Slivers(aspect) => given = slivers(mesh, aspect),
            Self::Walls(distance) => given = walls(mesh, diagonal * distance),
            Self::Lose => keep(&mut given, &mut |random, _| random.unit() > 0.1),
            Self::Merge(step) => {
                let step = step * diagonal;
                given = moved(&|point| point.map(|x| (x / step).round() * step));
            }
            Self::Split(share) => given = split(mesh, share),
            Self::Decimate => decimate(&mut given),
            Self::Cut => {
                let (middle, normal) = (middle(&mesh.positions), rotation(0).row(0));
                keep(&mut given, &mut |_, corners| {
                    let height = |point| normal.dot(Vector::from(point) - middle);
                    corners.map(height).iter().sum::<f64>() > 0.0
                });
            }
            Self::Join => {
                let (middle, rotation) = (middle(&mesh.positions), rotation(0));
                let turn = |point| middle + rotation * (Vector::from(point) - middle);
                given = join(&[mesh.clone(), moved(&|point| turn(point).to_array())]);
            }
        }
        let is_same = matches!(self, Self::None | Self::Shuffle(_) | Self::Double);
        let sound = if is_same { mesh.clone() } else { given.clone() };
        (given, sound)
    }
}

/// A rotation, evenly drawn (Shoemake, "Uniform random rotations", 1992).
fn rotation(number: u32) -> DMat3 {
    let mut random = Random(u64::from(number) + 1000);
    let share = random.unit();
    let [a, b] = [0, 1].map(|_| std::f64::consts::TAU * random.unit());
    let (s, t) = ((1.0 - share).sqrt(), share.sqrt());
    let [x, y, z, w] = [s * a.sin(), s * a.cos(), t * b.sin(), t * b.cos()];
    DMat3::from_quat(DQuat::from_xyzw(x, y, z, w))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::volume;

    fn tetrahedron() -> TriangleMesh {
        TriangleMesh::new(
            vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
        )
    }

    #[test]
    fn each_variation_has_a_name_of_its_own() {
        let all = Variation::all();
        let names: std::collections::BTreeSet<String> = all.iter().map(|v| v.name()).collect();
        assert_eq!(names.len(), all.len());
        assert_eq!(all.iter().filter(|v| matches!(v, Variation::Rotation(_))).count(), 8);
    }

    #[test]
    fn what_does_not_change_the_shape_keeps_the_volume() {
        let mesh = tetrahedron();
        for variation in Variation::all() {
            let (given, sound) = variation.apply(&mesh);
            let tolerance = match variation {
                // Half a unit in the last place of single precision, as a share of the mesh.
                Variation::OffsetSingle(distance) => distance.max(1.0) * 1e-6,
                Variation::Offset(_) => 1e-9,
                Variation::Jitter(size) | Variation::JitterWelded(size) => 100.0 * size,
                Variation::Walls(_) => continue,
                _ => 1e-12,
            };
            let expected = match variation {
                Variation::Scale(factor) => factor.powi(3) / 6.0,
                Variation::Mirror | Variation::FlipAll => -1.0 / 6.0,
                Variation::FlipHalf => continue,
                _ => 1.0 / 6.0,
            };
            // Far from the origin the parts of a volume cancel.
            let near = |mut mesh: TriangleMesh| {
                let first = Vector::from(mesh.positions[0]);
                mesh.positions.iter_mut().for_each(|p| *p = (Vector::from(*p) - first).to_array());
                volume(&mesh)
            };
            let found = near(sound);
            assert!((found / expected - 1.0).abs() < tolerance, "{variation:?}: {found}");
            let triangles = match variation {
                Variation::Double => 8,
                Variation::Slivers(_) => 12,
                _ => 4,
            };
            assert_eq!(given.triangles.len(), triangles, "{variation:?}");
        }
    }

    #[test]
    fn a_mirrored_mesh_is_turned_to_match_or_inside_out() {
        let mesh = tetrahedron();
        assert!(volume(&Variation::MirrorTurned.apply(&mesh).0) > 0.0);
        assert!(volume(&Variation::Mirror.apply(&mesh).0) < 0.0);
    }

    #[test]
    fn moved_in_single_precision_is_what_a_file_of_floats_holds() {
        let (given, sound) = Variation::OffsetSingle(1e4).apply(&tetrahedron());
        assert!(given.positions.as_flattened().iter().all(|&x| x == f64::from(x as f32)));
        assert!(given.positions[0][0] > 8000.0);
        assert_eq!(given, sound);
    }

    #[test]
    fn a_shuffle_is_another_order_of_the_same() {
        let (given, _) = Variation::Shuffle(0).apply(&tetrahedron());
        assert_ne!(given, tetrahedron());
        let mut positions = given.positions.clone();
        positions.sort_by(|a, b| a.partial_cmp(b).unwrap());
        let mut expected = tetrahedron().positions;
        expected.sort_by(|a, b| a.partial_cmp(b).unwrap());
        assert_eq!(positions, expected);
    }
}
