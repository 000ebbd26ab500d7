//! What remains of a face without what lies along the surface: parts that no triangle crosses.
//!
//! A triangle of the surface covers what lies below or above it, within some height. What no
//! triangle covers is not crossed by the surface, since where a triangle crosses the face it covers
//! it. In a closed solid each remaining part is therefore inside or outside as a whole, and one
//! point decides which. Nothing here depends on the bound: large faces of coarse meshes are decided
//! by the few triangles that are near them.
//!
//! Large triangles are taken off first. Those at right angles to the face cover nothing, but parts
//! must end at them: they come last, when little is left that they could divide.
//!
//! O(triangles near the face · parts).
//!
//! The limits below trade the time of this against that of halving. What they give was measured on
//! 196 shared and bundled meshes of up to 2,400 triangles, in processor time of whole
//! decompositions; 2,507 hulls are theirs.

use std::ops::RangeInclusive;

use crate::bvh::{Bvh, Slab};
use crate::geometry::vector::{Vector, area_normal, bounds, larger, smaller};

/// A face near more triangles is halved first: subtracting many triangles takes longer. The limit
/// is a share of the parts that halving down to the height would end with, within a range.
const TRIANGLES_PER_PART: f64 = 0.25;

/// The range. A quarter or four times as many change the time by 1 %, and no number of hulls.
const MAX_TRIANGLES: RangeInclusive<f64> = 24.0..=256.0;

/// A face of a smaller radius, as a multiple of the height, is halved: it ends with few parts.
const MIN_RADIUS: f64 = 24.0;

/// A face that falls into more parts is halved instead: each further triangle takes time for all of
/// them. A limit that few faces meet: 16 or 256 change no number of hulls, and the time by less
/// than 1 %.
const MAX_PARTS: usize = 64;

/// Parts and triangles narrower than this, as a fraction of the diagonal, have no area: their
/// points are as near to a neighbouring part.
const NARROW: f64 = 4.0 * ON_LINE;

/// A face of a smaller height over its longest side, as a fraction of the diagonal, is halved
/// instead: rounding by 1e-16 of the diagonal turns its normal by about [`ON_LINE`].
const NEEDLE: f64 = 1e-7;

/// Scratch memory, and the remaining parts of the last face.
#[derive(Default)]
pub(super) struct Remainder {
    triangles: Vec<[Vector; 3]>,
    shadows: Vec<Shadow>,
    parts: Vec<Polygon>,
    other: Vec<Polygon>,
    sides: Vec<Line>,
    frame: Frame,
}

/// What a triangle covers of a face's plane.
struct Shadow {
    polygon: Polygon,
    /// Twice its area; negative infinity if it is so narrow that it covers nothing.
    size: f64,
}

/// Coordinates in a face's plane.
#[derive(Default, Clone, Copy)]
struct Frame {
    origin: Vector,
    axes: [Vector; 2],
    normal: Vector,
}

impl Frame {
    /// `None` for a needle.
    fn new([a, b, c]: [Vector; 3]) -> Option<Self> {
        let normal = area_normal(a, b, c);
        let longest =
            [b - a, c - b, a - c].into_iter().max_by(|p, q| p.length().total_cmp(&q.length()))?;
        if normal.length() <= NEEDLE * longest.length() {
            return None;
        }
        let (normal, along) = (normal.normalize_or_zero(), longest.normalize_or_zero());
        Some(Self { origin: a, axes: [along, normal.cross(along)], normal })
    }

    fn flat(&self, point: Vector) -> Point {
        let arm = point - self.origin;
        self.axes.map(|axis| axis.dot(arm))
    }

    fn restore(&self, [x, y]: Point) -> Vector {
        self.origin + (self.axes[0] * x + self.axes[1] * y)
    }
}

impl Remainder {
    /// Finds the parts of a face that no triangle covers within `height`, up to a billionth of a
    /// diagonal. `false` if halving the face seems faster: then nothing is known. `radius` is that
    /// of the face.
    pub(super) fn find(&mut self, face: [Vector; 3], radius: f64, height: f64, bvh: &Bvh) -> bool {
        self.parts.clear();
        if radius < MIN_RADIUS * height {
            return false;
        }
        let parts = (radius / height) * (radius / height);
        let (least, largest) = (*MAX_TRIANGLES.start(), *MAX_TRIANGLES.end());
        let most = (TRIANGLES_PER_PART * parts).clamp(least, largest) as usize;
        let height = height - NARROW * MAX_PARTS as f64;
        let Some(frame) = Frame::new(face) else { return false };
        self.frame = frame;
        if height <= 0.0 {
            return false;
        }
        let (min, max) = bounds(face);
        let slab = Slab {
            min: min.map(|x| x - height),
            max: max.map(|x| x + height),
            normal: frame.normal,
            offset: frame.normal.dot(frame.origin),
            half_width: height,
        };
        if !bvh.triangles_in_slab(&slab, most, &mut self.triangles) {
            return false;
        }
        let mut whole = Polygon::EMPTY;
        for corner in face {
            if whole.push(frame.flat(corner)).is_err() {
                return false;
            }
        }
        self.parts.push(whole);
        if self.cast_shadows(&whole, height).is_err() {
            return false;
        }
        let shadows = std::mem::take(&mut self.shadows);
        let is_done =
            shadows.iter().all(|shadow| self.parts.is_empty() || self.subtract(shadow).is_ok());
        self.shadows = shadows;
        is_done
    }

    /// What the triangles cover of a face, the largest first.
    fn cast_shadows(&mut self, face: &Polygon, height: f64) -> Result<(), TooComplex> {
        self.shadows.clear();
        for &corners in &self.triangles {
            let polygon = self.shadow(corners, height)?;
            if polygon.vertices().len() < 2 {
                continue;
            }
            let is_narrow = polygon.is_narrow(NARROW);
            let is_apart = face.is_beside(&polygon) && !is_narrow
                || face.sides().filter_map(Line::through).any(|side| polygon.is_right_of(&side));
            if !is_apart {
                let size = if is_narrow { f64::NEG_INFINITY } else { polygon.doubled_area() };
                self.shadows.push(Shadow { polygon, size });
            }
        }
        self.shadows.sort_by(|a, b| b.size.total_cmp(&a.size));
        Ok(())
    }

    /// The parts of the last face: the centre of each, and triangles that it consists of.
    pub(super) fn parts(
        &self,
    ) -> impl Iterator<Item = (Vector, impl Iterator<Item = [Vector; 3]> + '_)> + '_ {
        self.parts.iter().map(|part| {
            let at = |k: usize| self.frame.restore(part.vertices()[k]);
            let fan = (1..part.vertices().len().saturating_sub(1))
                .map(move |k| [at(0), at(k), at(k + 1)]);
            (self.frame.restore(part.centre()), fan)
        })
    }

    /// Takes away from all parts what a triangle covers.
    fn subtract(&mut self, shadow: &Shadow) -> Result<(), TooComplex> {
        let Shadow { polygon: shadow, size } = shadow;
        let is_narrow = *size < 0.0;
        self.sides.clear();
        if is_narrow {
            let (from, to) = shadow.ends();
            self.sides.extend([(from, to), (to, from)].into_iter().filter_map(Line::through));
        } else {
            self.sides.extend(shadow.sides().filter_map(Line::through));
        }
        let sides = &self.sides;
        if sides.is_empty() {
            // The tip of a triangle is a point: it neither covers nor divides anything.
            return Ok(());
        }
        self.other.clear();
        let mut index = 0;
        while let Some(part) = self.parts.get(index) {
            let is_apart = part.is_beside(shadow) && !is_narrow
                || sides.iter().any(|side| part.is_right_of(side))
                || part.sides().filter_map(Line::through).any(|side| shadow.is_right_of(&side));
            if is_apart {
                index += 1;
                continue;
            }
            let mut rest = Some(self.parts.swap_remove(index));
            for side in sides {
                let Some(polygon) = rest else { break };
                let (covered, uncovered) = polygon.split(side)?;
                self.other.extend(uncovered.filter(|part| !part.is_narrow(NARROW)));
                rest = covered;
            }
        }
        self.parts.append(&mut self.other);
        if self.parts.len() > MAX_PARTS { Err(TooComplex) } else { Ok(()) }
    }

    /// The part of a triangle that is at most `height` from the plane, projected onto it.
    fn shadow(&self, corners: [Vector; 3], height: f64) -> Result<Polygon, TooComplex> {
        let heights = corners.map(|corner| self.frame.normal.dot(corner - self.frame.origin));
        let points = corners.map(|corner| self.frame.flat(corner));
        let mut shadow = Polygon::EMPTY;
        for k in 0..3 {
            let next = (k + 1) % 3;
            let (from, to) = (heights[k], heights[next]);
            let at = |level: f64| {
                let share = (level - from) / (to - from);
                [0, 1].map(|axis| points[k][axis] + share * (points[next][axis] - points[k][axis]))
            };
            if from.abs() <= height {
                shadow.push(points[k])?;
            }
            // Along a side, levels are crossed in the order of its direction.
            let levels = if from < to { [-height, height] } else { [height, -height] };
            for level in levels {
                if (from < level && level < to) || (to < level && level < from) {
                    shadow.push(at(level))?;
                }
            }
        }
        if shadow.doubled_area() < 0.0 {
            shadow.reverse();
        }
        Ok(shadow)
    }
}

/// A point of a face's plane.
type Point = [f64; 2];

/// Vertices at most: a triangle within a slab has up to seven, and a cut adds one to a polygon.
/// Others are too complex.
const MAX_VERTICES: usize = 9;

/// Points this near to a line, as a fraction of the diagonal, are on it: more than rounding, far
/// less than any bound.
const ON_LINE: f64 = 1e-9;

/// A convex polygon in a plane, counter-clockwise, of few vertices and without memory of its own.
#[derive(Debug, Clone, Copy)]
struct Polygon {
    vertices: [Point; MAX_VERTICES],
    count: usize,
    /// Its box.
    low: Point,
    high: Point,
}

/// A polygon has no room for another vertex, or a face falls into too many parts.
struct TooComplex;

impl Polygon {
    const EMPTY: Self = Self {
        vertices: [[0.0; 2]; MAX_VERTICES],
        count: 0,
        low: [f64::INFINITY; 2],
        high: [f64::NEG_INFINITY; 2],
    };

    fn push(&mut self, point: Point) -> Result<(), TooComplex> {
        let place = self.vertices.get_mut(self.count).ok_or(TooComplex)?;
        *place = point;
        self.count += 1;
        self.low = [0, 1].map(|axis| smaller(self.low[axis], point[axis]));
        self.high = [0, 1].map(|axis| larger(self.high[axis], point[axis]));
        Ok(())
    }

    #[inline]
    fn vertices(&self) -> &[Point] {
        &self.vertices[..self.count]
    }

    /// Its sides, from vertex to vertex.
    fn sides(&self) -> impl Iterator<Item = (Point, Point)> + '_ {
        let vertices = self.vertices();
        (0..self.count).map(move |k| (vertices[k], vertices[(k + 1) % self.count]))
    }

    /// Twice the area, positive if it runs counter-clockwise.
    fn doubled_area(&self) -> f64 {
        let origin = self.vertices[0];
        self.sides().map(|(p, q)| turn(origin, p, q)).sum()
    }

    fn reverse(&mut self) {
        self.vertices[..self.count].reverse();
    }

    fn centre(&self) -> Point {
        let sum = self.vertices().iter().fold([0.0; 2], |s, p| [s[0] + p[0], s[1] + p[1]]);
        sum.map(|x| x / self.count.max(1) as f64)
    }

    /// Whether the boxes of two polygons are apart.
    #[inline]
    fn is_beside(&self, other: &Self) -> bool {
        (0..2).any(|axis| {
            self.high[axis] <= other.low[axis] + ON_LINE
                || other.high[axis] <= self.low[axis] + ON_LINE
        })
    }

    /// The two vertices that are the farthest apart along the longer axis of its box.
    fn ends(&self) -> (Point, Point) {
        let extent = |axis: usize| self.high[axis] - self.low[axis];
        let axis = usize::from(extent(1) > extent(0));
        let order = |a: &&Point, b: &&Point| a[axis].total_cmp(&b[axis]);
        let low = self.vertices().iter().min_by(order).copied().unwrap_or_default();
        let high = self.vertices().iter().max_by(order).copied().unwrap_or_default();
        (low, high)
    }

    /// Whether it is no wider than `width`.
    fn is_narrow(&self, width: f64) -> bool {
        let (from, to) = self.ends();
        let [x, y] = [to[0] - from[0], to[1] - from[1]];
        self.doubled_area() <= width * (x * x + y * y).sqrt()
    }

    /// Whether a line has the whole polygon on its right or on it.
    #[inline]
    fn is_right_of(&self, line: &Line) -> bool {
        self.vertices().iter().all(|&point| line.height(point) <= ON_LINE)
    }

    /// The parts on the left and on the right of a line; `None` where there is none.
    fn split(&self, line: &Line) -> Result<(Option<Self>, Option<Self>), TooComplex> {
        let mut heights = [0.0; MAX_VERTICES];
        let (mut any_left, mut any_right) = (false, false);
        for (height, &point) in heights.iter_mut().zip(self.vertices()) {
            *height = line.height(point);
            any_left |= *height > ON_LINE;
            any_right |= *height < -ON_LINE;
        }
        if !any_right {
            return Ok((any_left.then_some(*self), None));
        }
        if !any_left {
            return Ok((None, Some(*self)));
        }
        let (mut left, mut right) = (Self::EMPTY, Self::EMPTY);
        for k in 0..self.count {
            let next = (k + 1) % self.count;
            let (p, q) = (self.vertices[k], self.vertices[next]);
            let (from, to) = (heights[k], heights[next]);
            if from >= -ON_LINE {
                left.push(p)?;
            }
            if from <= ON_LINE {
                right.push(p)?;
            }
            let is_crossed = from > ON_LINE && to < -ON_LINE || from < -ON_LINE && to > ON_LINE;
            if is_crossed {
                let share = from / (from - to);
                let middle = [0, 1].map(|axis| p[axis] + share * (q[axis] - p[axis]));
                left.push(middle)?;
                right.push(middle)?;
            }
        }
        Ok((Some(left), Some(right)))
    }
}

/// A line by a point on it and its direction, of unit length.
#[derive(Clone, Copy)]
struct Line {
    point: Point,
    direction: Point,
}

impl Line {
    /// The line through two points; `None` if they are the same.
    fn through((p, q): (Point, Point)) -> Option<Self> {
        let along = [q[0] - p[0], q[1] - p[1]];
        let length = (along[0] * along[0] + along[1] * along[1]).sqrt();
        (length > ON_LINE).then(|| Self { point: p, direction: along.map(|x| x / length) })
    }

    /// The distance from the line, positive on its left.
    #[inline]
    fn height(&self, point: Point) -> f64 {
        self.direction[0] * (point[1] - self.point[1])
            - self.direction[1] * (point[0] - self.point[0])
    }
}

fn turn(a: Point, b: Point, c: Point) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::{cuboid, join, uv_sphere};

    /// A point of a triangle by two shares.
    fn point_of([a, b, c]: [Vector; 3], mut u: f64, mut v: f64) -> Vector {
        if u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        a + ((b - a) * u + (c - a) * v)
    }

    fn contains([a, b, c]: [Vector; 3], point: Vector) -> bool {
        let whole = area_normal(a, b, c).length();
        let parts = [[point, b, c], [a, point, c], [a, b, point]]
            .map(|[a, b, c]| area_normal(a, b, c).length());
        parts.iter().sum::<f64>() <= whole + 1e-9
    }

    #[test]
    fn what_is_covered_is_near_and_what_remains_is_on_one_side() {
        let mesh = join(&[
            cuboid([-0.4, -0.3, -0.1], [0.4, 0.3, 0.1]),
            uv_sphere(8, [0.1, 0.0, 0.2], 0.15),
            cuboid([0.0, -0.05, 0.1], [0.1, 0.05, 0.4]),
        ]);
        let bvh = Bvh::new(mesh.points(), &mesh.triangles);
        let mut remainder = Remainder::default();
        let share = |k: u32, step: f64| (0.5 + step * f64::from(k)).fract();
        let mut found = 0;
        for index in 0..300_u32 {
            let corner = |k: u32| {
                Vector::from(
                    [0.754_877, 0.569_840, 0.430_159].map(|step| share(7 * index + k, step) - 0.5),
                )
            };
            // Every other face lies in a side of the box.
            let mut face = [corner(1), corner(2), corner(3)];
            if index % 2 == 0 {
                face = face.map(|corner: Vector| corner.with_z(0.1));
            }
            let height = 0.01;
            if !remainder.find(face, 1.0, height, &bvh) {
                continue;
            }
            found += 1;
            let parts: Vec<(Vector, Vec<[Vector; 3]>)> =
                remainder.parts().map(|(centre, fan)| (centre, fan.collect())).collect();
            for sample in 0..200 {
                let point = point_of(face, share(sample, 0.754_877), share(sample, 0.569_840));
                let nearest = bvh.closest_point(point, f64::INFINITY).unwrap().point;
                let own = parts
                    .iter()
                    .find(|(_, fan)| fan.iter().any(|&triangle| contains(triangle, point)));
                match own {
                    None => assert!(point.distance(nearest) <= height, "{index}, {sample}"),
                    Some(&(centre, _)) => {
                        let is_clear = point.distance(nearest) > 1e-6;
                        assert!(!is_clear || bvh.encloses(point) == bvh.encloses(centre));
                    }
                }
            }
        }
        assert!(found > 150, "{found}");
    }

    #[test]
    fn where_only_the_tip_of_a_triangle_touches_its_slab_a_face_is_not_covered() {
        let height = 0.01;
        // As far into the slab as rounding goes.
        let tip = height - NARROW * MAX_PARTS as f64 - 1e-11;
        let positions = [[0.1, 0.1, tip], [0.2, 0.1, 1.0], [0.1, 0.2, 1.0]].map(Vector::from);
        let bvh = Bvh::new(&positions, &[[0, 1, 2]]);
        let face = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]].map(Vector::from);
        let mut remainder = Remainder::default();
        assert!(remainder.find(face, 1.5, height, &bvh));
        let area = |[a, b, c]: [Vector; 3]| area_normal(a, b, c).length();
        let left: f64 = remainder.parts().flat_map(|(_, fan)| fan.map(area)).sum();
        assert!((left - area(face)).abs() < 1e-9, "{left}");
    }
}
