//! The same mesh in other words: turned, scaled, moved, jittered, shuffled; and damaged.

use std::collections::HashMap;

use glam::{DMat3, DQuat};
use hullwright::TriangleMesh;
use serde::{Deserialize, Serialize};

use crate::shapes::{Vector, bounds, join, middle};

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
    /// Each coordinate moved by up to this share of the diagonal, at random.
    Jitter(f64),
    /// Triangles and vertices in another order, by its number.
    Shuffle(u32),
    /// All triangles turned around.
    FlipAll,
    /// Half of the triangles, at random, turned around.
    FlipHalf,
    /// Every triangle twice.
    Double,
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

/// Rotations of each mesh.
pub const ROTATIONS: u32 = 24;
const SCALES: [f64; 6] = [1e-9, 1e-6, 1e-3, 1e3, 1e6, 1e9];
const OFFSETS: [f64; 3] = [1.0, 100.0, 1e4];
const JITTERS: [f64; 2] = [1e-7, 1e-5];
const SHUFFLES: u32 = 2;

impl Variation {
    /// All of them, the mesh as it is first.
    pub fn all() -> Vec<Self> {
        let mut all = vec![Self::None];
        all.extend((0..ROTATIONS).map(Self::Rotation));
        all.extend(SCALES.map(Self::Scale));
        all.extend(OFFSETS.map(Self::Offset));
        all.extend(JITTERS.map(Self::Jitter));
        all.extend((0..SHUFFLES).map(Self::Shuffle));
        all.extend([Self::FlipAll, Self::FlipHalf, Self::Double]);
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
            Self::Offset(distance) => format!("moved by {distance} diagonals"),
            Self::Jitter(size) => format!("jittered by {size:e} diagonals"),
            Self::Shuffle(number) => format!("shuffled {number}"),
            Self::FlipAll => "all triangles flipped".into(),
            Self::FlipHalf => "half of the triangles flipped".into(),
            Self::Double => "every triangle twice".into(),
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

    /// The mesh as given to the method, and the sound mesh in the same place that its hulls are
    /// measured against.
    pub fn apply(self, mesh: &TriangleMesh) -> (TriangleMesh, TriangleMesh) {
        let (low, high) = bounds(&mesh.positions);
        let diagonal = low.distance(high);
        let moved = |place: &dyn Fn([f64; 3]) -> [f64; 3]| {
            let positions = mesh.positions.iter().map(|&point| place(point)).collect();
            TriangleMesh { positions, ..mesh.clone() }
        };
        let mut given = mesh.clone();
        match self {
            Self::None => {}
            Self::Rotation(number) => {
                let rotation = rotation(number);
                given = moved(&|point| (rotation * Vector::from(point)).to_array());
            }
            Self::Scale(factor) => given = moved(&|point| point.map(|x| x * factor)),
            Self::Offset(distance) => {
                let offset = distance * diagonal / 3.0_f64.sqrt();
                given = moved(&|point| point.map(|x| x + offset));
            }
            Self::Jitter(size) => {
                let mut random = Random(1);
                for x in given.positions.as_flattened_mut() {
                    *x += diagonal * size * (2.0 * random.unit() - 1.0);
                }
            }
            Self::Shuffle(number) => shuffle(&mut given, &mut Random(1 + u64::from(number))),
            Self::FlipAll => given.triangles.iter_mut().for_each(|t| t.swap(1, 2)),
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
        let is_in_place = matches!(
            self,
            Self::None | Self::Shuffle(_) | Self::FlipAll | Self::FlipHalf | Self::Double
        );
        let sound = if is_in_place { mesh.clone() } else { given.clone() };
        (given, sound)
    }
}

/// SplitMix64 (Steele, Lea, Flood 2014): the same numbers everywhere and always.
pub struct Random(u64);

impl Random {
    /// Numbers of seeds side by side have nothing in common.
    pub fn new(seed: u64) -> Self {
        Self(Self(seed).next())
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// At least `low`, and less than `end`.
    pub fn integer(&mut self, low: usize, end: usize) -> usize {
        low + (self.next() % (end - low) as u64) as usize
    }

    /// From 0 to 1.
    pub fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
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

fn shuffle(mesh: &mut TriangleMesh, random: &mut Random) {
    let count = mesh.positions.len();
    let order = permutation(count, random);
    let mut places = vec![0_u32; count];
    for (new, &old) in (0..).zip(&order) {
        places[old] = new;
    }
    mesh.positions = order.iter().map(|&old| mesh.positions[old]).collect();
    // Each triangle also starts at another corner.
    let renumbered = |triangle: [u32; 3], random: &mut Random| {
        let mut triangle =
            triangle.map(|vertex| places.get(vertex as usize).copied().unwrap_or(vertex));
        triangle.rotate_left((random.next() % 3) as usize);
        triangle
    };
    let order = permutation(mesh.triangles.len(), random);
    mesh.triangles = order.iter().map(|&old| renumbered(mesh.triangles[old], random)).collect();
    mesh.sidedness = order.iter().filter_map(|&old| mesh.sidedness.get(old).copied()).collect();
}

/// Fisher and Yates.
fn permutation(count: usize, random: &mut Random) -> Vec<usize> {
    let mut order: Vec<usize> = (0..count).collect();
    for last in (1..count).rev() {
        order.swap(last, (random.next() % (last as u64 + 1)) as usize);
    }
    order
}

/// Keeps the triangles with these corners, or at random; without two, all of them.
fn keep(mesh: &mut TriangleMesh, keeps: &mut dyn FnMut(&mut Random, [[f64; 3]; 3]) -> bool) {
    let random = &mut Random(1);
    let positions = &mesh.positions;
    let kept: Vec<bool> = mesh
        .triangles
        .iter()
        .map(|triangle| keeps(random, triangle.map(|vertex| positions[vertex as usize])))
        .collect();
    let (mut triangles, mut sides) = (kept.iter(), kept.iter());
    mesh.triangles.retain(|_| triangles.next() == Some(&true));
    mesh.sidedness.retain(|_| sides.next() == Some(&true));
}

fn split(mesh: &TriangleMesh, share: f64) -> TriangleMesh {
    let positions = mesh.triangles.iter().flat_map(|triangle| {
        let corners = triangle.map(|vertex| Vector::from(mesh.positions[vertex as usize]));
        let centre = corners.iter().sum::<Vector>() / 3.0;
        corners.map(|corner| (corner + share * (centre - corner)).to_array())
    });
    let triangles = (0..mesh.triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]);
    TriangleMesh { positions: positions.collect(), triangles: triangles.collect(), ..mesh.clone() }
}

/// Collapses an edge of each triangle in a random order, unless one of its ends was collapsed
/// before. Vertices at the same place move together.
fn decimate(mesh: &mut TriangleMesh) {
    let mut places: HashMap<[u64; 3], Vec<usize>> = HashMap::new();
    for (vertex, point) in mesh.positions.iter().enumerate() {
        places.entry(point.map(f64::to_bits)).or_default().push(vertex);
    }
    let mut is_used = vec![false; mesh.positions.len()];
    let sources = mesh.positions.clone();
    for index in permutation(mesh.triangles.len(), &mut Random(1)) {
        let ends = [0, 1].map(|k| sources[mesh.triangles[index][k] as usize]);
        let [from, to] = ends.map(|end| places[&end.map(f64::to_bits)].as_slice());
        if !is_used[from[0]] && !is_used[to[0]] {
            (is_used[from[0]], is_used[to[0]]) = (true, true);
            from.iter().for_each(|&vertex| mesh.positions[vertex] = ends[1]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::{uv_sphere, volume};
    use crate::tools::kinds::*;

    fn tetrahedron() -> TriangleMesh {
        TriangleMesh::new(
            vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
        )
    }

    #[test]
    fn there_are_24_rotations_and_all_that_was_asked_for() {
        let all = Variation::all();
        assert_eq!(all.iter().filter(|v| matches!(v, Variation::Rotation(_))).count(), 24);
        assert_eq!(all.len(), 41);
    }

    #[test]
    fn rotating_moving_and_shuffling_keep_the_volume() {
        let mesh = tetrahedron();
        for variation in Variation::all() {
            let (given, sound) = variation.apply(&mesh);
            let expected = match variation {
                Variation::Scale(factor) => factor.powi(3) / 6.0,
                _ => 1.0 / 6.0,
            };
            let tolerance = if matches!(variation, Variation::Offset(_)) { 1e-3 } else { 1e-4 };
            assert!((volume(&sound) / expected - 1.0).abs() < tolerance, "{variation:?}");
            match variation {
                Variation::FlipAll => assert!(volume(&given) < 0.0),
                Variation::Double => assert_eq!(given.triangles.len(), 8),
                _ => assert_eq!(given.triangles.len(), 4),
            }
        }
    }

    #[test]
    fn a_damaged_mesh_is_of_the_kind_that_its_damage_makes() {
        // Welded, closed, and of so many triangles that chance hits some.
        let mesh = uv_sphere(24, 1.0);
        assert_eq!(kinds(&mesh), [""; 0]);
        for damage in Variation::damages() {
            let (given, _) = damage.apply(&mesh);
            let found = kinds(&given);
            let expected: &[&str] = match damage {
                Variation::Lose => &[NOT_SOLID, OPEN],
                Variation::Cut => &[NOT_SOLID, OPEN],
                Variation::FlipHalf => &[NOT_SOLID, NOT_ORIENTED],
                Variation::Double => &[NOT_SOLID, SELF_INTERSECTING, NON_MANIFOLD],
                Variation::Merge(_) | Variation::Decimate => &[NOT_SOLID, DEGENERATE],
                Variation::Split(_) => &[NOT_SOLID, OPEN, SEVERAL_COMPONENTS],
                Variation::Join => &[NOT_SOLID, SELF_INTERSECTING],
                _ => &[],
            };
            assert!(expected.iter().all(|kind| found.contains(kind)), "{damage:?}: {found:?}");
            let may_stay_solid = matches!(damage, Variation::Jitter(_) | Variation::Scale(_));
            assert!(may_stay_solid || found[0] == NOT_SOLID, "{damage:?}");
            assert!(!given.triangles.is_empty() && given != mesh, "{damage:?}");
        }
        let (cut, _) = Variation::Cut.apply(&mesh);
        let share = cut.triangles.len() as f64 / mesh.triangles.len() as f64;
        assert!((0.3..0.7).contains(&share), "{share}");
        // Of a mesh whose triangles share no vertex as much is left.
        let (loose, _) = Variation::Split(0.0).apply(&mesh);
        let [loose, welded] = [loose, mesh].map(|mesh| kinds(&Variation::Decimate.apply(&mesh).0));
        assert_eq!(loose, welded);
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
