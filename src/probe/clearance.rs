//! How near the centre of a ball can come to a point.
//!
//! Cells of the grid that may hold centres are divided in eight, and those parts again, where a point is compared with
//! them. A part with a half diagonal δ, whose middle m is D away from the closest point q of the surface, holds no centre
//! if D + δ < r. Otherwise its centres lie in the part itself, and beyond a plane: they are r away from q at least, and
//! off the line from q to m by δ at most.
//!
//! ```text
//!         ┌───────┐
//!         │ · · · │   centres:   (y - q) · n ≥ √(r² - δ²),   n from q to m
//!     ────│───m───│────
//!         │   │   │
//!         └───│───┘
//!   ▓▓▓▓▓▓▓▓▓▓q▓▓▓▓▓▓▓▓▓▓
//! ```
//!
//! Both bound the distance of a point from below. Parts are divided until no nearer one is left, or they are small. What
//! is found depends on the point alone: so does the least of these bounds over all small parts, and it changes no
//! faster than the point moves.

use std::sync::OnceLock;

use super::reach::{Cell, ProbeSettings, Reach};
use crate::bvh::Bvh;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{Vector, squared};

/// Half the side of a part that is not divided, as a fraction of the bound: what is lost is at most a diagonal of such a
/// part.
const LEAST_HALF: f64 = 0.05;

/// A ball that is entered farther than this, as a fraction of the radius, shows nothing: only the distance from the mesh
/// counts. Otherwise a ball smaller than the bound could vanish in hulls.
const MOST_ENTERED: f64 = 0.5;

/// More than the rounding of distances, as a fraction of the diagonal.
const ROUNDING: f64 = 1e-9;

/// Children of a part from the nearest to a point to the farthest, as differences from the nearest.
const NEAREST_FIRST: [usize; 8] = [0, 1, 2, 4, 3, 5, 6, 7];

/// A part of a cell.
struct Part {
    /// The closest point of the surface to its middle, and how far that is.
    nearest: Vector,
    distance: f64,
    triangle: u32,
    children: OnceLock<Box<[Part; 8]>>,
}

impl Part {
    fn new(tree: &Bvh, middle: Vector, guess: u32) -> Self {
        let children = OnceLock::new();
        match tree.closest_point_near(middle, f64::INFINITY, guess) {
            Some(found) => Self {
                nearest: found.point,
                distance: found.distance,
                triangle: found.triangle,
                children,
            },
            None => {
                Self { nearest: middle, distance: f64::INFINITY, triangle: u32::MAX, children }
            }
        }
    }
}

/// A cube by its middle and half its side.
#[derive(Clone, Copy)]
struct Cube {
    middle: Vector,
    half: f64,
}

impl Cube {
    fn squared_distance(&self, point: Vector) -> f64 {
        ((point - self.middle).abs() - Vector::splat(self.half)).max(Vector::ZERO).length_squared()
    }

    fn child(&self, index: usize) -> Self {
        let half = 0.5 * self.half;
        let side = |axis: usize| if index >> axis & 1 == 1 { half } else { -half };
        Self { middle: self.middle + Vector::new(side(0), side(1), side(2)), half }
    }
}

/// A ball that moves from outside, and whether it can enter a point. See the module.
pub(crate) struct Probe {
    pub radius: f64,
    /// Centres are this far from the solid's own surface at least.
    clear: f64,
    /// Half the side of a part that is not divided.
    least_half: f64,
    reach: Reach,
    /// For each cell that may hold centres its place among `parts`.
    places: Vec<u32>,
    parts: Vec<OnceLock<Part>>,
}

/// A search for the nearest centre.
struct Search<'a> {
    tree: &'a Bvh,
    point: Vector,
    /// The least bound so far.
    nearest: f64,
    /// Once the bound is below this, it is near enough.
    enough: f64,
}

impl Probe {
    /// The probe around a surface whose points are at most `displacement` away from the source, under a bound on how
    /// far balls may be entered.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn new(
        tree: &Bvh,
        bounds: (Vector, Vector),
        &ProbeSettings { radius, ref from }: &ProbeSettings,
        displacement: f64,
        bound: f64,
        control: &Control,
    ) -> Result<Self, Error> {
        let clear = radius - displacement - ROUNDING;
        let reach = Reach::new(tree, bounds, radius, clear, from, control)?;
        let mut count = 0;
        let mut number = |cell: &Cell| {
            let place = count;
            count += u32::from(*cell == Cell::Partial);
            place
        };
        let places = reach.cells.iter().map(&mut number).collect();
        let mut parts = Vec::new();
        parts.resize_with(count as usize, OnceLock::new);
        let least_half = LEAST_HALF * bound.min(radius);
        Ok(Self { radius, clear, least_half, reach, places, parts })
    }

    /// Whether no ball is entered at a point by more than `bound`, and none by more than half its radius.
    pub fn allows(&self, tree: &Bvh, point: Vector, bound: f64) -> bool {
        let needed = self.radius - bound.min(self.most_entered());
        self.clearance(tree, point, needed, needed) >= needed
    }

    /// How far balls are entered at a point, at most; `None` if that may be more than half their radius.
    pub fn entered(&self, tree: &Bvh, point: Vector) -> Option<f64> {
        let least = self.radius - self.most_entered();
        let clearance = self.clearance(tree, point, self.radius, least);
        (clearance >= least).then_some(self.radius - clearance)
    }

    /// Balls that are entered farther than this show nothing.
    pub fn most_entered(&self) -> f64 {
        MOST_ENTERED * self.radius
    }

    /// How far balls are entered that can be entered farther by `more`; `None` as in [`entered`](Self::entered).
    pub fn entered_around(&self, entered: f64, more: f64) -> Option<f64> {
        let most = entered + more;
        (most <= self.most_entered()).then_some(most)
    }

    /// No centre is nearer to a point. At most `most`; any value below `enough` if that is not reached.
    fn clearance(&self, tree: &Bvh, point: Vector, most: f64, enough: f64) -> f64 {
        let reach = &self.reach;
        let half = 0.5 * reach.size;
        let own = reach.place(point);
        if reach.cells[reach.index(own)] == Cell::Open {
            return 0.0;
        }
        let (low, high) = (reach.place(point - most), reach.place(point + most));
        let mut near: Vec<(f64, u32, Vector)> = Vec::new();
        let mut nearest = squared(most);
        for z in low[2]..=high[2] {
            for y in low[1]..=high[1] {
                for x in low[0]..=high[0] {
                    let index = reach.index([x, y, z]);
                    let cell = reach.cells[index];
                    if cell == Cell::Closed {
                        continue;
                    }
                    let middle = reach.centre([x, y, z]);
                    let distance = Cube { middle, half }.squared_distance(point);
                    if distance >= nearest {
                        continue;
                    }
                    if cell == Cell::Partial {
                        near.push((distance, self.places[index], middle));
                        continue;
                    }
                    nearest = distance;
                    if nearest < squared(enough) {
                        return nearest.sqrt();
                    }
                }
            }
        }
        near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut search = Search { tree, point, nearest: nearest.sqrt(), enough };
        for (distance, place, middle) in near {
            if distance.sqrt() >= search.nearest || search.nearest < enough {
                break;
            }
            let Some(part) = self.parts.get(place as usize) else { continue };
            let part = part.get_or_init(|| Part::new(tree, middle, u32::MAX));
            self.descend(part, Cube { middle, half }, 0.0, &mut search);
        }
        search.nearest
    }

    fn descend(&self, part: &Part, cube: Cube, bound: f64, search: &mut Search<'_>) {
        let point = search.point;
        let radius = cube.half * 3f64.sqrt();
        if part.distance + radius < self.clear {
            return;
        }
        let mut bound = bound.max(cube.squared_distance(point).sqrt());
        if radius < self.clear && radius < part.distance && part.distance < f64::INFINITY {
            let along = (cube.middle - part.nearest) / part.distance;
            let plane = (squared(self.clear) - squared(radius)).sqrt();
            bound = bound.max(plane - along.dot(point - part.nearest));
        }
        if bound >= search.nearest {
            return;
        }
        let to_middle = point.distance(cube.middle);
        if cube.half <= self.least_half {
            search.nearest = bound;
        } else if part.distance >= self.clear && to_middle < search.enough {
            search.nearest = to_middle.min(search.nearest);
        } else {
            let children = part.children.get_or_init(|| {
                let child = |k| Part::new(search.tree, cube.child(k).middle, part.triangle);
                Box::new(std::array::from_fn(child))
            });
            let side = |axis: usize| usize::from(point[axis] > cube.middle[axis]) << axis;
            let nearest = side(0) | side(1) | side(2);
            for index in NEAREST_FIRST.map(|difference| nearest ^ difference) {
                self.descend(&children[index], cube.child(index), bound, search);
                if search.nearest < search.enough {
                    return;
                }
            }
        }
    }
}
