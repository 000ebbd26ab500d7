//! Whether a hull keeps the bound, and no more: hulls that may join are only asked this.
//!
//! Most that protrude do so where another has protruded, so they are asked there first. Verdicts do
//! not depend on it.

use std::sync::Mutex;

use super::protrusion::{RESOLUTION, Search};
use crate::bounded::containment::solid::Solid;
use crate::bounded::containment::suspects::Suspects;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::Vector;
use crate::hull::ConvexHull;
use crate::parallel;

/// Places where hulls have protruded that are remembered for all of them.
const MAX_SUSPECTS: usize = 256;

/// Where hulls have protruded that were verified earlier, by any thread.
pub(in crate::bounded) struct SharedSuspects(Mutex<Suspects>);

impl Default for SharedSuspects {
    fn default() -> Self {
        Self(Mutex::new(Suspects::new(MAX_SUSPECTS)))
    }
}

/// Whether no point of the hull's faces is farther than the bound from the solid. Faster than the
/// protrusion: nothing below the bound is resolved, and it is asked first where others have protruded.
///
/// # Errors
/// [`Error::Cancelled`].
pub(in crate::bounded) fn keeps_bound(
    hull: &ConvexHull,
    solid: &Solid,
    bound: f64,
    suspects: &SharedSuspects,
    control: &Control,
) -> Result<bool, Error> {
    // Most hulls that protrude do so at one of few points.
    let fits = |face| solid.centre_fits(face, bound) && solid.quarters_fit(face, bound);
    let faces: Vec<[Vector; 3]> = hull.corners().collect();
    if !faces.iter().copied().all(fits) {
        return Ok(false);
    }
    let unresolved = (1.0 - RESOLUTION) * bound;
    let exceeds_at = |face, point| {
        let mut search = Search::new(solid, bound, bound, unresolved);
        search.may_exceed(point)
            && search.run(&[face], Some(point), control).is_ok()
            && search.known > bound
    };
    let mut suspects_now = parallel::lock(&suspects.0).clone();
    if suspects_now.find(&faces, |&face| face, exceeds_at).is_some() {
        return Ok(false);
    }
    let mut search = Search::new(solid, bound, bound, unresolved);
    let keeps = !search.cavities_exceed(hull) && search.run(&faces, None, control)? <= bound;
    if let (false, Some((point, face))) = (keeps, search.farthest) {
        parallel::lock(&suspects.0).remember(point, face);
    }
    Ok(keeps)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounded::containment::boundary::Boundary;
    use crate::bounded::finalize::verify::protrusion::protrusion;
    use crate::geometry::TriangleMesh;
    use crate::hull::convex_hull;
    use crate::mesh::shapes::{cuboid, hemisphere, join, torus};

    fn solid_of(mesh: &TriangleMesh, boundary: Boundary, bound: f64) -> Solid {
        let TriangleMesh { positions, triangles, .. } = mesh;
        Solid::of_surface(positions, triangles, boundary, bound, &Control::new()).unwrap()
    }

    fn keeps(hull: &ConvexHull, solid: &Solid, bound: f64, suspects: &SharedSuspects) -> bool {
        keeps_bound(hull, solid, bound, suspects, &Control::new()).unwrap()
    }

    #[test]
    fn a_hull_keeps_the_bound_exactly_if_it_protrudes_by_no_more() {
        let cube = |x: f64| cuboid([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]);
        let bound = 0.02;
        let solid = solid_of(&cube(0.0), Boundary::default(), bound);
        let suspects = SharedSuspects::default();
        for share in [0.0, 0.5, 0.9, 0.97, 0.99, 1.01, 1.03, 1.1, 2.0, 20.0] {
            let moved = convex_hull(&cube(share * bound).positions).unwrap();
            assert_eq!(keeps(&moved, &solid, bound, &suspects), share <= 1.0, "{share}");
        }
    }

    #[test]
    fn a_hull_that_protrudes_far_from_the_centres_of_its_faces_does_not_keep_the_bound() {
        let mesh = cuboid([0.0; 3], [1.0; 3]);
        let bound = 0.02;
        let solid = solid_of(&mesh, Boundary::default(), bound);
        let suspects = SharedSuspects::default();
        for share in [0.9, 0.97, 1.03, 1.5, 2.5] {
            let mut corners = mesh.positions.clone();
            // The centres of the faces are no higher than a third of this.
            corners.push([0.5, 0.5, 1.0 + share * bound]);
            let hull = convex_hull(&corners).unwrap();
            assert!(hull.corners().all(|face| solid.centre_fits(face, bound)));
            assert_eq!(keeps(&hull, &solid, bound, &suspects), share <= 1.0, "{share}");
        }
    }

    #[test]
    fn a_hull_that_contains_a_cavity_deeper_than_the_bound_does_not_keep_it() {
        let mesh = cuboid([0.0; 3], [1.0; 3]);
        let mut solid = solid_of(&mesh, Boundary::default(), 0.02);
        let hull = convex_hull(&mesh.positions).unwrap();
        assert!(keeps(&hull, &solid, 0.02, &SharedSuspects::default()));
        solid.cavities = vec![([0.5; 3], 0.1)];
        assert!(!keeps(&hull, &solid, 0.02, &SharedSuspects::default()));
    }

    /// Hulls of some neighbouring vertices, from few to many.
    fn hulls(mesh: &TriangleMesh) -> Vec<ConvexHull> {
        let count = mesh.positions.len();
        let starts = (0..count).step_by(count / 24 + 1);
        let windows = starts.flat_map(|start| [6, 12, 22, 34, 60].map(|size| (start, size)));
        windows
            .filter_map(|(start, size)| {
                let points: Vec<Vector> =
                    (start..start + size).map(|k| mesh.positions[k % count]).collect();
                convex_hull(&points).ok()
            })
            .collect()
    }

    #[test]
    fn no_verdict_depends_on_where_others_protruded() {
        let bound = 0.03;
        let two = join(&[torus(24, 12), cuboid([0.2, 0.2, -0.1], [0.5, 0.6, 0.9])]);
        let bowl = hemisphere(10);
        let rim = Boundary::new(&bowl.positions, &bowl.triangles);
        for (mesh, boundary) in [(two, Boundary::default()), (bowl, rim)] {
            let solid = solid_of(&mesh, boundary, bound);
            let suspects = SharedSuspects::default();
            let (mut kept, mut refused) = (0, 0);
            for hull in hulls(&mesh) {
                let alone = keeps(&hull, &solid, bound, &SharedSuspects::default());
                assert_eq!(keeps(&hull, &solid, bound, &suspects), alone);
                let found = protrusion(&hull, &solid, bound, bound, &Control::new()).unwrap();
                assert_eq!(found <= bound, alone, "{found}");
                if alone { kept += 1 } else { refused += 1 }
            }
            assert!(kept > 10 && refused > 10, "{kept} kept, {refused} refused");
        }
    }
}
