//! Means, medians and fits.

/// The middle value, or the mean of the two in the middle; 0 of none.
pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    match (values.get(middle), values.len() % 2) {
        (Some(&upper), 0) => f64::midpoint(values[middle - 1], upper),
        (Some(&value), _) => value,
        (None, _) => 0.0,
    }
}

/// The least value that so large a share of all does not exceed; 0 of none.
pub fn quantile(values: &[f64], share: f64) -> f64 {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    let place = (share * values.len() as f64).ceil() as usize;
    values.get(place.clamp(1, values.len().max(1)) - 1).copied().unwrap_or(0.0)
}

/// 0 of none.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// Least and greatest value; inside out of none.
pub fn range(values: impl IntoIterator<Item = f64>) -> (f64, f64) {
    values
        .into_iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
}

/// `None` of nothing. Values must be positive.
pub fn geometric_mean(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0);
    for value in values {
        sum += value.ln();
        count += 1;
    }
    (count > 0).then(|| (sum / f64::from(count)).exp())
}

/// Slope and value at 1 of the straight line through points in logarithms, by least squares:
/// y = value · x^slope.
pub fn power_law(points: &[(f64, f64)]) -> Option<(f64, f64)> {
    let logs: Vec<(f64, f64)> = points
        .iter()
        .filter(|(x, y)| *x > 0.0 && *y > 0.0)
        .map(|(x, y)| (x.ln(), y.ln()))
        .collect();
    let count = logs.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| logs.iter().map(of).sum::<f64>() / count;
    let (mean_x, mean_y) = (mean(|p| p.0), mean(|p| p.1));
    let variance: f64 = logs.iter().map(|(x, _)| (x - mean_x).powi(2)).sum();
    let covariance: f64 = logs.iter().map(|(x, y)| (x - mean_x) * (y - mean_y)).sum();
    let slope = covariance / variance;
    slope.is_finite().then(|| (slope, (mean_y - slope * mean_x).exp()))
}

/// Slopes of the plane z = c + a x + b y by least squares, and the share of z's variance that it
/// explains.
pub fn plane(samples: &[[f64; 3]]) -> (f64, f64, f64) {
    let count = samples.len() as f64;
    let mean = [0, 1, 2].map(|axis| samples.iter().map(|s| s[axis]).sum::<f64>() / count);
    let covariance = |i: usize, j: usize| {
        samples.iter().map(|s| (s[i] - mean[i]) * (s[j] - mean[j])).sum::<f64>()
    };
    let (xx, xy, yy) = (covariance(0, 0), covariance(0, 1), covariance(1, 1));
    let (xz, yz, zz) = (covariance(0, 2), covariance(1, 2), covariance(2, 2));
    let determinant = xx * yy - xy * xy;
    let a = (xz * yy - yz * xy) / determinant;
    let b = (yz * xx - xz * xy) / determinant;
    (a, b, (a * xz + b * yz) / zz)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_and_means() {
        assert_eq!(median(vec![3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(vec![4.0, 1.0, 2.0, 3.0]), 2.5);
        assert_eq!(median(vec![]), 0.0);
        let values = [4.0, 1.0, 3.0, 2.0];
        assert_eq!(
            [0.0, 0.5, 0.51, 1.0].map(|share| quantile(&values, share)),
            [1.0, 2.0, 3.0, 4.0]
        );
        assert_eq!(quantile(&[], 0.5), 0.0);
        assert_eq!(mean(&[1.0, 2.0, 6.0]), 3.0);
        assert_eq!(mean(&[]), 0.0);
        assert_eq!(range([2.0, -1.0, 1.0]), (-1.0, 2.0));
        assert!((geometric_mean([1.0, 4.0]).unwrap() - 2.0).abs() < 1e-12);
        assert_eq!(geometric_mean([]), None);
    }

    #[test]
    fn a_power_law_is_found() {
        let points = [1.0, 10.0, 1000.0].map(|x: f64| (x, 3.0 * x.powf(1.5))).to_vec();
        let (slope, value) = power_law(&points).unwrap();
        assert!((slope - 1.5).abs() < 1e-12 && (value - 3.0).abs() < 1e-9);
        assert_eq!(power_law(&[(1.0, 1.0)]), None);
    }

    #[test]
    fn a_plane_is_found() {
        let samples: Vec<[f64; 3]> = (0..20)
            .map(|i| {
                let (x, y) = (f64::from(i % 5), f64::from(i * i % 7));
                [x, y, 4.0 + 1.5 * x - 0.5 * y]
            })
            .collect();
        let (a, b, share) = plane(&samples);
        assert!((a - 1.5).abs() < 1e-9 && (b + 0.5).abs() < 1e-9 && (share - 1.0).abs() < 1e-9);
    }
}
