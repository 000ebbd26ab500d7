//! Principal moments and axes of an inertia tensor: nalgebra's symmetric eigendecomposition, in
//! double precision (feature `nalgebra`).

use nalgebra::{Matrix3, Rotation3, SymmetricEigen, UnitQuaternion};

use crate::geometry::vector::Vector;

/// Principal moments of inertia, and the frame of their axes.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PrincipalInertia {
    /// Moments about the principal axes, ascending; none negative.
    pub moments: [f64; 3],
    /// The axes, unit vectors that form a right-handed frame in this order.
    pub axes: [[f64; 3]; 3],
    /// The rotation that takes the coordinate axes to `axes`, as a quaternion (x, y, z, w).
    pub rotation: [f64; 4],
}

/// Far more steps than three rows ever took; an unbounded loop could hang on what is not finite.
const MOST_STEPS: usize = 1000;

pub(super) fn principal_inertia(inertia: [Vector; 3]) -> PrincipalInertia {
    let matrix = Matrix3::from_fn(|i, j| (inertia[i][j] + inertia[j][i]) / 2.0);
    let size = matrix.amax();
    // A diagonal tensor needs no turning: noise would turn it.
    let eigen = (size.is_finite() && size > 0.0)
        .then(|| SymmetricEigen::try_new(matrix / size, f64::EPSILON, MOST_STEPS))
        .flatten();
    let (values, vectors) = match eigen {
        Some(eigen) => (eigen.eigenvalues * size, eigen.eigenvectors),
        None => (matrix.diagonal(), Matrix3::identity()),
    };
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let mut columns = order.map(|index| vectors.column(index).into_owned());
    for column in &mut columns[..2] {
        // Of the two directions of an axis, the one along the coordinate axis that is nearest.
        if column[column.iamax()] < 0.0 {
            *column = -*column;
        }
    }
    columns[2] = columns[0].cross(&columns[1]);
    let rotation = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&columns));
    let quaternion = UnitQuaternion::from_rotation_matrix(&rotation);
    PrincipalInertia {
        moments: order.map(|index| values[index].max(0.0)),
        axes: columns.map(Into::into),
        rotation: quaternion.coords.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turned_box_finds_its_axes_again() {
        let turned = Rotation3::from_euler_angles(0.3, -0.7, 1.1);
        let wanted = [1.0, 2.0, 5.0];
        let diagonal = Matrix3::from_diagonal(&wanted.into());
        let tensor = turned.matrix() * diagonal * turned.matrix().transpose();
        let rows = [0, 1, 2].map(|i| Vector::from([0, 1, 2].map(|j| tensor[(i, j)])));
        let found = principal_inertia(rows);
        for (moment, expected) in found.moments.into_iter().zip(wanted) {
            assert!((moment - expected).abs() < 1e-12);
        }
        for (axis, column) in found.axes.into_iter().zip(turned.matrix().column_iter()) {
            assert!((column.dot(&nalgebra::Vector3::from(axis)).abs() - 1.0).abs() < 1e-12);
        }
        let quaternion =
            UnitQuaternion::from_quaternion(nalgebra::Quaternion::from(found.rotation));
        for (axis, unit) in found.axes.into_iter().zip(Matrix3::identity().column_iter()) {
            assert!((quaternion * unit - nalgebra::Vector3::from(axis)).norm() < 1e-12);
        }
    }

    #[test]
    fn what_is_round_or_has_no_size_still_gets_a_frame() {
        for tensor in [[Vector::ZERO; 3], [Vector::NAN; 3]] {
            let found = principal_inertia(tensor);
            assert!((found.rotation.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-12);
        }
        let round = principal_inertia(
            [[2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]].map(Vector::from),
        );
        assert_eq!((round.moments, round.rotation), ([2.0; 3], [0.0, 0.0, 0.0, 1.0]));
    }
}
