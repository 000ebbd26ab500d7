//! Curves of hulls against error, and what they say at equal error and at equal hulls.

use crate::statistics::geometric_mean;

/// What one setting gave on one mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    pub hulls: f64,
    /// Hausdorff distance as a share of the diagonal.
    pub error: f64,
}

/// Errors below this are the tolerance of `measure`, and count as this.
const LEAST_ERROR: f64 = 1e-6;

/// The settings of a method that no other of its settings beats, by hulls ascending and so by
/// error descending.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Curve {
    points: Vec<Point>,
}

impl Curve {
    pub fn new(points: impl IntoIterator<Item = Point>) -> Self {
        let mut all: Vec<Point> = points
            .into_iter()
            .filter(|point| point.hulls > 0.0)
            .map(|point| Point { error: point.error.max(LEAST_ERROR), ..point })
            .collect();
        all.sort_by(|a, b| a.hulls.total_cmp(&b.hulls).then(a.error.total_cmp(&b.error)));
        let mut front: Vec<Point> = Vec::new();
        for point in all {
            if front.last().is_none_or(|last| point.error < last.error) {
                front.push(point);
            }
        }
        Self { points: front }
    }

    /// Hulls needed for an error. For an error larger than any setting has, the fewest hulls, which
    /// do with less; `None` for one that no setting reaches.
    pub fn hulls_at(&self, error: f64) -> Option<f64> {
        let points = self.points.iter().rev().map(|point| (point.error, point.hulls));
        between(points, error.max(LEAST_ERROR))
    }

    /// Error reached with so many hulls: with more than any setting has, its least error; `None`
    /// for fewer than any has.
    pub fn error_at(&self, hulls: f64) -> Option<f64> {
        between(self.points.iter().map(|point| (point.hulls, point.error)), hulls)
    }
}

/// The value at `x` of points by ascending `x`: on the straight line between those around it, in
/// logarithms, since all are positive; the last one's beyond it.
fn between(points: impl Iterator<Item = (f64, f64)>, x: f64) -> Option<f64> {
    let mut before = None;
    for (x1, y1) in points {
        if x < x1 {
            let (x0, y0): (f64, f64) = before?;
            let share = (x / x0).ln() / (x1 / x0).ln();
            return Some(y0 * (y1 / y0).powf(share));
        }
        before = Some((x1, y1));
    }
    before.map(|(_, y)| y)
}

/// How one method stands against another on one mesh: geometric means over the other's settings
/// that it can be compared at. Below 1 is better.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Comparison {
    /// Hulls over theirs, at their errors.
    pub hulls: Option<f64>,
    /// Error over theirs, at their numbers of hulls.
    pub error: Option<f64>,
}

pub fn versus(ours: &Curve, theirs: &Curve) -> Comparison {
    let hulls = theirs.points.iter().filter_map(|p| Some(ours.hulls_at(p.error)? / p.hulls));
    let error = theirs.points.iter().filter_map(|p| Some(ours.error_at(p.hulls)? / p.error));
    Comparison { hulls: geometric_mean(hulls), error: geometric_mean(error) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(points: &[(f64, f64)]) -> Curve {
        Curve::new(points.iter().map(|&(hulls, error)| Point { hulls, error }))
    }

    #[test]
    fn a_curve_keeps_what_no_other_setting_beats() {
        let found = curve(&[(8.0, 0.02), (4.0, 0.08), (8.0, 0.03), (9.0, 0.02), (16.0, 0.01)]);
        let hulls: Vec<f64> = found.points.iter().map(|point| point.hulls).collect();
        assert_eq!(hulls, [4.0, 8.0, 16.0]);
    }

    #[test]
    fn at_equal_error_hulls_are_interpolated_in_logarithms() {
        let ours = curve(&[(4.0, 0.08), (16.0, 0.02)]);
        assert!((ours.hulls_at(0.04).unwrap() - 8.0).abs() < 1e-12);
        assert!((ours.hulls_at(0.02).unwrap() - 16.0).abs() < 1e-12);
        assert_eq!(ours.hulls_at(0.5), Some(4.0), "few hulls do with less than that");
        assert_eq!(ours.hulls_at(0.01), None, "no setting reaches it");
    }

    #[test]
    fn at_equal_hulls_the_error_is_interpolated_in_logarithms() {
        let ours = curve(&[(4.0, 0.08), (16.0, 0.02)]);
        assert!((ours.error_at(8.0).unwrap() - 0.04).abs() < 1e-12);
        assert_eq!(ours.error_at(100.0), Some(0.02));
        assert_eq!(ours.error_at(3.0), None);
    }

    #[test]
    fn a_single_setting_is_a_curve_too() {
        let ours = curve(&[(4.0, 0.08)]);
        assert_eq!(ours.hulls_at(0.08), Some(4.0));
        assert_eq!(ours.hulls_at(0.079), None);
        assert_eq!(ours.error_at(4.0), Some(0.08));
        assert_eq!(curve(&[]).hulls_at(1.0), None);
    }

    #[test]
    fn no_error_at_all_is_an_error_that_can_be_compared() {
        let exact = curve(&[(1.0, 0.0)]);
        assert_eq!(versus(&exact, &exact), Comparison { hulls: Some(1.0), error: Some(1.0) });
    }

    #[test]
    fn half_the_hulls_at_equal_error_is_a_half() {
        let theirs = curve(&[(8.0, 0.08), (32.0, 0.02)]);
        let ours = curve(&[(4.0, 0.08), (16.0, 0.02)]);
        let found = versus(&ours, &theirs);
        assert!((found.hulls.unwrap() - 0.5).abs() < 1e-12);
        // At 8 hulls 0.04 against 0.08, at 32 the least, 0.02 against 0.02.
        assert!((found.error.unwrap() - 0.5_f64.sqrt()).abs() < 1e-12);
    }
}
