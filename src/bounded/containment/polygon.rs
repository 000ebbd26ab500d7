//! Convex polygons in a plane, of few vertices, without memory of their own.

/// A point of the plane.
pub(super) type Point = [f64; 2];

/// Vertices at most. Each cut adds one.
const MAX_VERTICES: usize = 9;

/// Points this near to a line, in diagonals, are on it: more than rounding, far less than any
/// bound.
pub(super) const ON_LINE: f64 = 1e-9;

/// A convex polygon, counter-clockwise.
#[derive(Debug, Clone, Copy)]
pub(super) struct Polygon {
    vertices: [Point; MAX_VERTICES],
    count: usize,
    /// Its box.
    low: Point,
    high: Point,
}

/// A polygon that has no room for another vertex.
pub(super) struct TooManyVertices;

impl Polygon {
    pub(super) const EMPTY: Self = Self {
        vertices: [[0.0; 2]; MAX_VERTICES],
        count: 0,
        low: [f64::INFINITY; 2],
        high: [f64::NEG_INFINITY; 2],
    };

    pub(super) fn push(&mut self, point: Point) -> Result<(), TooManyVertices> {
        let place = self.vertices.get_mut(self.count).ok_or(TooManyVertices)?;
        *place = point;
        self.count += 1;
        self.low = [0, 1].map(|axis| self.low[axis].min(point[axis]));
        self.high = [0, 1].map(|axis| self.high[axis].max(point[axis]));
        Ok(())
    }

    #[inline]
    pub(super) fn vertices(&self) -> &[Point] {
        &self.vertices[..self.count]
    }

    /// Its sides, from vertex to vertex.
    pub(super) fn sides(&self) -> impl Iterator<Item = (Point, Point)> + '_ {
        let vertices = self.vertices();
        (0..self.count).map(move |k| (vertices[k], vertices[(k + 1) % self.count]))
    }

    /// Twice the area, positive if it runs counter-clockwise.
    pub(super) fn doubled_area(&self) -> f64 {
        let origin = self.vertices[0];
        self.sides().map(|(p, q)| turn(origin, p, q)).sum()
    }

    pub(super) fn reverse(&mut self) {
        self.vertices[..self.count].reverse();
    }

    pub(super) fn centre(&self) -> Point {
        let sum = self.vertices().iter().fold([0.0; 2], |s, p| [s[0] + p[0], s[1] + p[1]]);
        sum.map(|x| x / self.count.max(1) as f64)
    }

    /// Whether the boxes of two polygons are apart.
    #[inline]
    pub(super) fn is_beside(&self, other: &Self) -> bool {
        (0..2).any(|axis| {
            self.high[axis] <= other.low[axis] + ON_LINE
                || other.high[axis] <= self.low[axis] + ON_LINE
        })
    }

    /// The two vertices that are the farthest apart along the longer axis of its box.
    pub(super) fn ends(&self) -> (Point, Point) {
        let extent = |axis: usize| self.high[axis] - self.low[axis];
        let axis = usize::from(extent(1) > extent(0));
        let order = |a: &&Point, b: &&Point| a[axis].total_cmp(&b[axis]);
        let low = self.vertices().iter().min_by(order).copied().unwrap_or_default();
        let high = self.vertices().iter().max_by(order).copied().unwrap_or_default();
        (low, high)
    }

    /// Whether it is no wider than `width`.
    pub(super) fn is_narrow(&self, width: f64) -> bool {
        let (from, to) = self.ends();
        let [x, y] = [to[0] - from[0], to[1] - from[1]];
        self.doubled_area() <= width * (x * x + y * y).sqrt()
    }

    /// Whether a line has the whole polygon on its right or on it.
    #[inline]
    pub(super) fn is_right_of(&self, line: &Line) -> bool {
        self.vertices().iter().all(|&point| line.height(point) <= ON_LINE)
    }

    /// The parts on the left and on the right of a line; `None` where there is none.
    pub(super) fn split(
        &self,
        line: &Line,
    ) -> Result<(Option<Self>, Option<Self>), TooManyVertices> {
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
pub(super) struct Line {
    point: Point,
    direction: Point,
}

impl Line {
    /// The line through two points; `None` if they are the same.
    pub(super) fn through((p, q): (Point, Point)) -> Option<Self> {
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
