//! The input as the pipeline works on it: repaired, normalised, simplified.

pub(crate) mod adjacency;
pub(crate) mod canonical_order;
pub(crate) mod connectivity;
mod degenerate;
pub(crate) mod grouping;
mod orientation;
mod prepared;
pub(crate) mod refine;
pub(crate) mod repair;
#[cfg(test)]
pub(crate) mod shapes;
pub(crate) mod simplify;
pub(crate) mod weld;

pub use crate::geometry::TriangleMesh;
pub(crate) use prepared::{CAP, HIDDEN_CAP};
pub use prepared::{Normalization, PreparedMesh, Repairs};

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

    use super::adjacency::{Adjacency, NO_NEIGHBOUR};
    use super::canonical_order::MeshOrder;
    use super::degenerate::is_degenerate;
    use super::repair::prepare;
    use super::simplify::simplify;
    use super::*;
    use crate::control::Control;
    use crate::error::Error;

    /// Triangles of few points on a coarse grid: full of everything that is wrong with meshes.
    fn soup() -> impl Strategy<Value = TriangleMesh> {
        let point = prop::array::uniform3((0..4_i32).prop_map(f64::from));
        let points = prop::collection::vec(point, 3..20);
        points.prop_flat_map(|positions| {
            let index = 0..positions.len() as u32;
            let triangles = prop::collection::vec(prop::array::uniform3(index), 1..120);
            triangles.prop_map(move |triangles| TriangleMesh::new(positions.clone(), triangles))
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig { rng_seed: RngSeed::Fixed(1), ..Default::default() })]

        #[test]
        fn any_soup_is_repaired_or_refused(soup in soup()) {
            let result = prepare(soup.view(), MeshOrder::Place, &Control::new());
            let prepared = match result {
                Ok(prepared) => prepared,
                Err(error) => {
                    let is_expected = matches!(error, Error::NothingUsable { .. });
                    prop_assert!(is_expected);
                    return Ok(());
                }
            };
            let PreparedMesh { mesh, components, closed, repairs, .. } = prepared;
            prop_assert!(!mesh.triangles.iter().any(|&t| is_degenerate(mesh.points(), t)));
            prop_assert_eq!(mesh.positions.len(), prepared.source_vertices.len());

            let adjacency = Adjacency::new(&mesh);
            for (entry, &other) in adjacency.neighbours.iter().enumerate() {
                let own = entry as u32 / 3;
                if other == NO_NEIGHBOUR {
                    prop_assert!(!closed[components[own as usize] as usize]);
                } else {
                    prop_assert!(adjacency.triangle_neighbours(other).contains(&own));
                    prop_assert_eq!(components[own as usize], components[other as usize]);
                }
            }
            if closed.iter().all(|&closed| closed) {
                prop_assert_eq!(repairs.open_edges + repairs.non_manifold_edges, 0);
            }

            let simplified = simplify(&mesh, &components, mesh.triangles.len() / 3, &Control::new()).expect("within the limits");
            for component in 0..closed.len() as u32 {
                prop_assert!(simplified.components.contains(&component));
            }
        }

        #[test]
        fn repairing_again_changes_nothing(soup in soup()) {
            let repair = |mesh: &TriangleMesh| {
                prepare(mesh.view(), MeshOrder::Place, &Control::new())
            };
            if let Ok(once) = repair(&soup) {
                let twice = repair(&once.mesh).expect("usable once, usable twice");
                prop_assert_eq!(&twice.mesh.triangles, &once.mesh.triangles);
                prop_assert_eq!(&twice.components, &once.components);
                prop_assert_eq!(&twice.closed, &once.closed);
                prop_assert_eq!(twice.repairs.flipped_triangles, 0);
            }
        }
    }
}
