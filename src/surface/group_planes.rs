//! The planes of a forming group [3.4.1], and whether a vertex is too far in front of any.
//!
//! Nearly all the time of grouping goes into that, and most of it is spared without changing an
//! answer: planes only ever join a group, so a vertex that was refused stays refused, and one that
//! was behind all planes need only be held against those that came since. Those it is held against
//! in three steps, each for what the one before leaves in doubt: bounds for several planes,
//! single precision with room for its rounding, double precision.

use crate::geometry::vector::{Vector, add, dot, length_squared, scale, subtract};

/// The plane of a polygon: its points have this scalar product with the unit normal.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plane {
    pub normal: Vector,
    pub offset: f64,
}

impl Plane {
    #[inline]
    pub(super) fn distance(&self, point: Vector) -> f64 {
        dot(self.normal, point) - self.offset
    }
}

/// Planes that are compared in one go, so that the compiler can use wide registers.
const BLOCK: usize = 8;

/// Blocks whose bounds are looked at in one go.
const ROW: usize = 4;

/// The planes of the forming group, and what is known of vertices held against them.
pub(super) struct Planes {
    threshold: f64,
    /// In blocks: normals by coordinate, then offsets. The rest of the last block is behind
    /// everything.
    blocks: Vec<[[f64; BLOCK]; 4]>,
    /// What mostly suffices to tell that nothing is in the way.
    rows: Vec<Row>,
    count: usize,
    /// The block that refused last will often refuse again.
    refusing: Option<usize>,
    group: u32,
    /// For each vertex the last group that it was held against, and with how many blocks, all of
    /// them full, it got on.
    known: Vec<(u32, u32)>,
    /// The least distance of all that were too large.
    least_refusal: f64,
}

/// In place of a group: none yet.
const NO_GROUP: u32 = u32::MAX;

/// In place of a number of blocks: the group has refused the vertex.
const REFUSED: u32 = u32::MAX;

impl Planes {
    pub(super) fn new(threshold: f64, vertices: usize) -> Self {
        Self {
            threshold,
            blocks: Vec::new(),
            rows: Vec::new(),
            count: 0,
            refusing: None,
            group: NO_GROUP,
            known: vec![(NO_GROUP, 0); vertices],
            least_refusal: f64::INFINITY,
        }
    }

    /// Forgets the planes of the group before.
    pub(super) fn start_group(&mut self, group: u32) {
        self.group = group;
        self.blocks.clear();
        self.rows.clear();
        self.count = 0;
        self.refusing = None;
    }

    /// Adds a plane, and a point of it.
    #[inline]
    pub(super) fn push(&mut self, Plane { normal: [x, y, z], offset }: Plane, point: Vector) {
        let place = self.count % BLOCK;
        let lane = self.count / BLOCK % ROW;
        if place == 0 {
            let none = [0.0; BLOCK];
            self.blocks.push([none, none, none, [f64::INFINITY; BLOCK]]);
            if lane == 0 {
                self.rows.push(Row::EMPTY);
            }
        }
        if let (Some(block), Some(row)) = (self.blocks.last_mut(), self.rows.last_mut()) {
            for (axis, value) in [x, y, z, offset].into_iter().enumerate() {
                block[axis][place] = value;
                row.blocks[lane][axis][place] = value as f32;
            }
            row.bounds.height[lane] = f32::INFINITY;
            if place + 1 == BLOCK {
                row.bounds.set(lane, block, point);
            }
        }
        self.count += 1;
    }

    /// Whether no plane has the vertex farther than the threshold in front of it.
    #[inline]
    pub(super) fn allow(&mut self, vertex: u32, position: Vector) -> bool {
        let (group, known) = &mut self.known[vertex as usize];
        if *group != self.group {
            (*group, *known) = (self.group, 0);
        }
        if *known == REFUSED {
            return false;
        }
        let start = *known as usize;
        let likely = self.refusing.filter(|&place| place >= start);
        let refusal = likely
            .and_then(|place| Some((place, self.refusal(place, position)?)))
            .or_else(|| self.first_refusal(start, position));
        if let Some((place, farthest)) = refusal {
            self.refusing = Some(place);
            self.least_refusal = self.least_refusal.min(farthest);
            self.known[vertex as usize].1 = REFUSED;
            return false;
        }
        self.known[vertex as usize].1 = (self.count / BLOCK) as u32;
        true
    }

    /// The least distance by which a vertex was refused so far, in any group.
    pub(super) fn least_refusal(&self) -> f64 {
        self.least_refusal
    }

    /// How far the point is in front of a plane of a block, if that is too far.
    #[inline]
    fn refusal(&self, place: usize, position: Vector) -> Option<f64> {
        let farthest = farthest(&self.blocks[place], position);
        (farthest > self.threshold).then_some(farthest)
    }

    /// The first block from `start` on with a plane that has the point too far in front of it, and
    /// how far.
    fn first_refusal(&self, start: usize, position: Vector) -> Option<(usize, f64)> {
        let point = position.map(|x| x as f32);
        let threshold = (self.threshold - ROUNDING) as f32;
        for (index, row) in self.rows.iter().enumerate().skip(start / ROW) {
            let excess = row.bounds.excess(point, threshold);
            if largest(excess) <= 0.0 {
                continue;
            }
            #[expect(clippy::needless_range_loop, reason = "by value the whole loop is slower")]
            for lane in 0..ROW {
                let place = index * ROW + lane;
                if excess[lane] > 0.0
                    && place >= start
                    && is_any_above(&row.blocks[lane], point, threshold)
                    && let Some(farthest) = self.refusal(place, position)
                {
                    return Some((place, farthest));
                }
            }
        }
        None
    }
}

/// A few blocks in single precision.
struct Row {
    bounds: Bounds,
    blocks: [[[f32; BLOCK]; 4]; ROW],
}

impl Row {
    const EMPTY: Self = {
        let none = [0.0; BLOCK];
        Self { bounds: Bounds::EMPTY, blocks: [[none, none, none, [f32::INFINITY; BLOCK]]; ROW] }
    };
}

/// Distances from the planes of a block are bounded by that from a plane between them; here for
/// a few blocks side by side, in single precision and with room for its rounding.
///
/// With a mean normal m and a point c, n · x − o = m · (x − c) + (n − m) · (x − c) + (n · c − o),
/// where the second term is at most the spread of the normals times ‖x − c‖.
struct Bounds {
    /// Mean normals by coordinate.
    normal: [[f32; ROW]; 3],
    centre: [[f32; ROW]; 3],
    /// Greatest squared ‖n − m‖.
    squared_spread: [f32; ROW],
    /// Greatest n · c − o. Infinite where a block is not full, and less than anything where there is
    /// none.
    height: [f32; ROW],
}

/// What a threshold is lowered by in single precision: far above the rounding errors of coordinates
/// of the order of 1, far below any usual threshold.
const ROUNDING: f64 = 1e-5;

impl Bounds {
    const EMPTY: Self = Self {
        normal: [[0.0; ROW]; 3],
        centre: [[0.0; ROW]; 3],
        squared_spread: [0.0; ROW],
        height: [f32::NEG_INFINITY; ROW],
    };

    /// Sets the bound of a block that is full. The centre should be near its planes.
    fn set(&mut self, lane: usize, [x, y, z, offset]: &[[f64; BLOCK]; 4], centre: Vector) {
        let normals: [Vector; BLOCK] = std::array::from_fn(|lane| [x[lane], y[lane], z[lane]]);
        let sum = normals.iter().fold([0.0; 3], |sum, &normal| add(sum, normal));
        let normal = scale(sum, 1.0 / BLOCK as f64);
        let spread = |&other: &Vector| length_squared(subtract(other, normal));
        let height = normals.iter().zip(offset).map(|(&n, o)| dot(n, centre) - o);
        for axis in 0..3 {
            self.normal[axis][lane] = normal[axis] as f32;
            self.centre[axis][lane] = centre[axis] as f32;
        }
        self.squared_spread[lane] = normals.iter().map(spread).fold(0.0, f64::max) as f32;
        self.height[lane] = height.fold(f64::NEG_INFINITY, f64::max) as f32;
    }

    /// For each block a number that is positive unless no distance can be above the threshold.
    #[inline]
    fn excess(&self, [x, y, z]: [f32; 3], threshold: f32) -> [f32; ROW] {
        std::array::from_fn(|lane| {
            let arm =
                [x - self.centre[0][lane], y - self.centre[1][lane], z - self.centre[2][lane]];
            let along = self.normal[0][lane] * arm[0]
                + self.normal[1][lane] * arm[1]
                + self.normal[2][lane] * arm[2];
            let squared = arm[0] * arm[0] + arm[1] * arm[1] + arm[2] * arm[2];
            let room = threshold - self.height[lane] - along;
            self.squared_spread[lane] * squared - room * room.abs()
        })
    }
}

/// The distance of a point from the plane of a block that it is farthest in front of.
#[inline]
fn farthest([x, y, z, offset]: &[[f64; BLOCK]; 4], point: Vector) -> f64 {
    let mut distances = [0.0; BLOCK];
    for lane in 0..BLOCK {
        distances[lane] =
            x[lane] * point[0] + y[lane] * point[1] + z[lane] * point[2] - offset[lane];
    }
    // Halves, not one after the other: a chain of comparisons would not use wide registers.
    let [a, b, c, d, e, f, g, h] = distances;
    let larger = |a: f64, b: f64| if a > b { a } else { b };
    let quarters = [larger(a, e), larger(b, f), larger(c, g), larger(d, h)];
    larger(larger(quarters[0], quarters[2]), larger(quarters[1], quarters[3]))
}

/// Whether a distance of a point from the planes of a block is above the threshold.
#[inline]
fn is_any_above([x, y, z, offset]: &[[f32; BLOCK]; 4], point: [f32; 3], threshold: f32) -> bool {
    let mut any = false;
    for lane in 0..BLOCK {
        let distance = x[lane] * point[0] + y[lane] * point[1] + z[lane] * point[2] - offset[lane];
        // Not a choice between ways, which would be taken lane by lane.
        any |= distance > threshold;
    }
    any
}

#[inline]
fn largest([a, b, c, d]: [f32; 4]) -> f32 {
    larger(larger(a, c), larger(b, d))
}

#[inline]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}
