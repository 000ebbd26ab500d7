//! Work, counted in tests: presets are compared by it, since clocks are noisy. Elsewhere nothing is
//! counted.
//!
//! What takes most of the time counts, each about as much as it takes in instructions on props:
//! parts of faces that are tested or verified, cells of the grid that are filled, and points that
//! hulls grow by.

/// A part of a face that is tested, or verified.
pub(crate) const PART: u64 = 1;

/// A cell that is filled: a query of the tree.
pub(crate) const CELL: u64 = 8;

/// A point that a hull grows by.
pub(crate) const POINT: u64 = 3;

#[cfg(test)]
thread_local! {
    static DONE: std::cell::Cell<u64> = const { std::cell::Cell::new(0) };
}

/// Counts work.
#[inline]
pub(crate) fn count(_work: u64) {
    #[cfg(test)]
    DONE.set(DONE.get() + _work);
}

#[cfg(test)]
mod tests {
    use super::DONE;
    use crate::control::Control;
    use crate::decompose::decompose;
    use crate::geometry::vector::Vector;
    use crate::geometry::{MeshView, TriangleMesh};
    use crate::mesh::shapes::{cuboid, hemisphere, join, torus, turn, uv_sphere};
    use crate::parameters::{Length, Parameters, Preset};

    /// What a decomposition of a mesh takes on one thread.
    fn work(mesh: &TriangleMesh, bound: f64, preset: Preset) -> u64 {
        let parameters =
            Parameters::default().with_max_error(Length::share(bound)).with_preset(preset);
        DONE.set(0);
        let control = Control::new().with_parallel(false);
        decompose(MeshView::from(mesh), &parameters, &control).unwrap();
        DONE.get()
    }

    /// A top on four legs, which end within it.
    fn table() -> TriangleMesh {
        let leg = |x: f64, y: f64| cuboid([x, y, 0.0], [x + 0.1, y + 0.1, 0.75]);
        join(&[
            cuboid([0.0, 0.0, 0.7], [1.5, 1.0, 0.8]),
            leg(0.0, 0.0),
            leg(1.4, 0.0),
            leg(0.0, 0.9),
            leg(1.4, 0.9),
        ])
    }

    /// So many rings that few triangles are left for each.
    fn rings() -> TriangleMesh {
        let ring = |k: u32| {
            let place = Vector::from([k % 3, k / 3 % 3, k / 9].map(|step| 2.8 * f64::from(step)));
            let mut mesh = torus(20, 10);
            mesh.positions
                .iter_mut()
                .for_each(|point| *point = (Vector::from(*point) + place).to_array());
            mesh
        };
        join(&(0..27).map(ring).collect::<Vec<TriangleMesh>>())
    }

    #[test]
    fn fast_takes_no_more_work_than_balanced() {
        let meshes = [
            ("torus", torus(24, 12)),
            ("coarse torus", torus(9, 5)),
            ("bowl", hemisphere(12)),
            ("table", table()),
            ("turned table", turn(table())),
            ("heap", join(&[uv_sphere(10, [0.0; 3], 1.0), uv_sphere(8, [1.2, 0.3, 0.0], 0.8)])),
            ("dense torus", torus(80, 40)),
            ("rings", rings()),
        ];
        for (name, mesh) in meshes {
            for bound in [0.05, 0.02, 0.007] {
                let [fast, balanced] =
                    [Preset::Fast, Preset::Balanced].map(|preset| work(&mesh, bound, preset));
                assert!(fast > 0 && fast <= balanced, "{name} at {bound}: {fast}, {balanced}");
            }
        }
    }
}
