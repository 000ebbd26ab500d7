//! Where a thing can be hung on a hook: the widest hole in one of its three shadows, or else the
//! deepest notch.

use bevy::prelude::*;

/// Cells along the longer side of a shadow: a hole of a fiftieth of the mesh is still some cells
/// wide.
const CELLS: usize = 160;

/// Empty cells around the shadow, so that all outside of it is one.
const BORDER: usize = 2;

/// A hole has to be this many cells wide for a hook to fit through.
const LEAST_CLEARANCE: f32 = 2.0;

/// How a thing is held so that a hook along z fits through it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Hang {
    /// Turns the thing.
    pub turn: Quat,
    /// Where the hook goes through after the turn, from the thing's middle, in metres.
    pub at: Vec3,
    /// Room around the hook, in metres; 0 if there is no hole and no notch.
    pub clearance: f32,
    /// Whether the hook is enclosed on all sides.
    pub is_hole: bool,
}

/// The shadow of a mesh along an axis: which cells of a grid are covered.
struct Shadow {
    covered: Vec<bool>,
    width: usize,
    height: usize,
    low: Vec2,
    cell: f32,
}

/// Looks along the three axes.
pub fn find_hang(triangles: &[[Vec3; 3]]) -> Hang {
    // What turns each axis into z.
    let views = [
        Quat::IDENTITY,
        Quat::from_rotation_y(std::f32::consts::FRAC_PI_2),
        Quat::from_rotation_x(std::f32::consts::FRAC_PI_2),
    ];
    let hangs = views.into_iter().filter_map(|view| hang_along(triangles, view));
    let better = |best: Hang, other: Hang| {
        let is_better = (other.is_hole, other.clearance) > (best.is_hole, best.clearance);
        if is_better { other } else { best }
    };
    hangs.fold(Hang::default(), better)
}

fn hang_along(triangles: &[[Vec3; 3]], view: Quat) -> Option<Hang> {
    let shadow = Shadow::cast(triangles, view)?;
    let clearances = shadow.clearances();
    let outside = shadow.outside();
    let widest = |is_wanted: &dyn Fn(usize) -> bool| {
        (0..shadow.covered.len())
            .filter(|&cell| !shadow.covered[cell] && is_wanted(cell))
            .max_by(|&a, &b| clearances[a].total_cmp(&clearances[b]).then(b.cmp(&a)))
            .filter(|&cell| clearances[cell] >= LEAST_CLEARANCE)
    };
    let (cell, open) = match widest(&|cell| !outside[cell]) {
        Some(hole) => (hole, None),
        None => {
            let notch = widest(&|cell| shadow.open_side(cell).is_some())?;
            (notch, shadow.open_side(notch))
        }
    };
    let place = shadow.place(cell);
    // The open side of a notch, or the way from the hole to the middle, goes down.
    let down = open.unwrap_or(-place);
    let roll = Quat::from_rotation_z(-std::f32::consts::FRAC_PI_2 - down.y.atan2(down.x));
    Some(Hang {
        turn: roll * view,
        at: roll * place.extend(0.0),
        clearance: clearances[cell] * shadow.cell,
        is_hole: open.is_none(),
    })
}

impl Shadow {
    fn cast(triangles: &[[Vec3; 3]], view: Quat) -> Option<Self> {
        let flat = |corners: &[Vec3; 3]| corners.map(|corner| (view * corner).truncate());
        let corners = || triangles.iter().flat_map(flat);
        let low = corners().reduce(Vec2::min)?;
        let high = corners().reduce(Vec2::max)?;
        let cell = (high - low).max_element() / CELLS as f32;
        if cell.is_nan() || cell <= 0.0 {
            return None;
        }
        let [width, height] =
            ((high - low) / cell).to_array().map(|side| side.ceil() as usize + 2 * BORDER);
        let low = low - cell * BORDER as f32;
        let mut shadow = Self { covered: vec![false; width * height], width, height, low, cell };
        for triangle in triangles {
            shadow.cover(flat(triangle));
        }
        Some(shadow)
    }

    /// Covers every cell that a triangle may touch.
    fn cover(&mut self, corners: [Vec2; 3]) {
        let corners = corners.map(|corner| (corner - self.low) / self.cell);
        let [a, b, c] = corners;
        let (low, high) = (a.min(b).min(c).floor(), a.max(b).max(c).floor());
        let side = (b - a).perp_dot(c - a).signum();
        let edges = [[a, b], [b, c], [c, a]];
        for y in low.y.max(0.0) as usize..=(high.y as usize).min(self.height - 1) {
            for x in low.x.max(0.0) as usize..=(high.x as usize).min(self.width - 1) {
                let middle = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
                // Half a cell's reach beyond each edge.
                let is_beyond = edges.iter().any(|[from, to]| {
                    let along = (to - from).normalize_or_zero();
                    side * along.perp_dot(middle - from) < -0.5 * (along.x.abs() + along.y.abs())
                });
                if !is_beyond {
                    self.covered[y * self.width + x] = true;
                }
            }
        }
    }

    /// The middle of a cell, in metres.
    fn place(&self, cell: usize) -> Vec2 {
        let (x, y) = (cell % self.width, cell / self.width);
        self.low + self.cell * Vec2::new(x as f32 + 0.5, y as f32 + 0.5)
    }

    /// For each cell about how many cells the nearest covered one is away, by two sweeps.
    fn clearances(&self) -> Vec<f32> {
        let far = (self.width + self.height) as f32;
        let mut clearance: Vec<f32> =
            self.covered.iter().map(|covered| if *covered { 0.0 } else { far }).collect();
        let diagonal = std::f32::consts::SQRT_2;
        let steps = [(-1, 0, 1.0), (0, -1, 1.0), (-1, -1, diagonal), (1, -1, diagonal)];
        for is_back in [false, true] {
            for count in 0..clearance.len() {
                let cell = if is_back { clearance.len() - 1 - count } else { count };
                for (x, y, length) in steps {
                    let sign = if is_back { -1 } else { 1 };
                    if let Some(other) = self.neighbour(cell, sign * x, sign * y) {
                        clearance[cell] = clearance[cell].min(clearance[other] + length);
                    }
                }
            }
        }
        clearance
    }

    fn neighbour(&self, cell: usize, x: isize, y: isize) -> Option<usize> {
        let x = (cell % self.width).checked_add_signed(x).filter(|x| *x < self.width)?;
        let y = (cell / self.width).checked_add_signed(y).filter(|y| *y < self.height)?;
        Some(y * self.width + x)
    }

    /// Which cells can be reached from outside.
    fn outside(&self) -> Vec<bool> {
        let mut outside = vec![false; self.covered.len()];
        let mut waiting = vec![0];
        while let Some(cell) = waiting.pop() {
            if self.covered[cell] || std::mem::replace(&mut outside[cell], true) {
                continue;
            }
            let ways = [(1, 0), (-1, 0), (0, 1), (0, -1)];
            waiting.extend(ways.into_iter().filter_map(|(x, y)| self.neighbour(cell, x, y)));
        }
        outside
    }

    /// The only direction in which nothing is seen from a cell, if it is the only one.
    fn open_side(&self, cell: usize) -> Option<Vec2> {
        let ways = [(1, 0), (-1, 0), (0, 1), (0, -1)];
        let is_open = |&(x, y): &(isize, isize)| {
            let mut at = Some(cell);
            while let Some(cell) = at {
                if self.covered[cell] {
                    return false;
                }
                at = self.neighbour(cell, x, y);
            }
            true
        };
        let mut open = ways.into_iter().filter(is_open);
        let (x, y) = open.next()?;
        open.next().is_none().then(|| Vec2::new(x as f32, y as f32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A frame of four bars in the x-y plane, open below if there is no `floor`.
    fn frame(floor: bool) -> Vec<[Vec3; 3]> {
        let bar = |low: Vec2, high: Vec2| {
            let corner = |x: f32, y: f32| Vec3::new(x, y, 0.0);
            let [a, b] = [corner(low.x, low.y), corner(high.x, low.y)];
            let [c, d] = [corner(high.x, high.y), corner(low.x, high.y)];
            [[a, b, c], [a, c, d]]
        };
        let mut bars = vec![
            bar(Vec2::new(-1.0, 0.8), Vec2::new(1.0, 1.0)),
            bar(Vec2::new(-1.0, -1.0), Vec2::new(-0.8, 1.0)),
            bar(Vec2::new(0.8, -1.0), Vec2::new(1.0, 1.0)),
        ];
        if floor {
            bars.push(bar(Vec2::new(-1.0, -1.0), Vec2::new(1.0, -0.8)));
        }
        bars.into_iter().flatten().collect()
    }

    #[test]
    fn a_frame_hangs_by_its_hole() {
        let hang = find_hang(&frame(true));
        assert!(hang.is_hole);
        assert!((hang.clearance - 0.8).abs() < 0.05, "{hang:?}");
    }

    #[test]
    fn an_arch_hangs_by_its_notch_with_the_open_side_down() {
        let hang = find_hang(&frame(false));
        assert!(!hang.is_hole && hang.clearance > 0.5, "{hang:?}");
        assert!((hang.turn * Vec3::NEG_Y).dot(Vec3::NEG_Y) > 0.99, "{hang:?}");
    }

    #[test]
    fn a_plate_does_not_hang() {
        let plate = [
            [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0)],
            [Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0), Vec3::Y],
        ];
        assert_eq!(find_hang(&plate).clearance, 0.0);
    }
}
