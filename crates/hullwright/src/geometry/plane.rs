//! Planes by a unit normal.

use super::vector::{Vector, area_normal};

/// The points whose scalar product with the normal is the offset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Plane {
    /// A unit vector; zero for a triangle without area.
    pub normal: Vector,
    pub offset: f64,
}

impl Plane {
    /// The plane of a triangle; zero if that has no area.
    pub fn of([a, b, c]: [Vector; 3]) -> Self {
        let normal = area_normal(a, b, c);
        let area = normal.length();
        if area > 0.0 {
            let normal = normal * (1.0 / area);
            Self { normal, offset: normal.dot(a) }
        } else {
            Self { normal: Vector::ZERO, offset: 0.0 }
        }
    }

    /// The distance of a point, negative behind the plane.
    #[inline]
    pub fn height(&self, point: Vector) -> f64 {
        self.normal.dot(point) - self.offset
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_are_distances_in_front_of_a_triangle() {
        let corners =
            [Vector::new(0.0, 0.0, 2.0), Vector::new(3.0, 0.0, 2.0), Vector::new(0.0, 1.0, 2.0)];
        let plane = Plane::of(corners);
        assert_eq!(plane, Plane { normal: Vector::Z, offset: 2.0 });
        assert_eq!(plane.height(Vector::new(9.0, 9.0, 5.0)), 3.0);
        assert_eq!(plane.height(Vector::ZERO), -2.0);
    }

    #[test]
    fn what_has_no_area_has_no_plane() {
        let line = [Vector::ZERO, Vector::X, Vector::X * 2.0];
        assert_eq!(Plane::of(line), Plane { normal: Vector::ZERO, offset: 0.0 });
    }
}
