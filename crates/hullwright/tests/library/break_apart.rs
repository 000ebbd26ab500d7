//! Fragments of a broken mesh: nothing is lost, nothing cracks, and nothing overlaps.

use std::collections::BTreeMap;

use glam::DVec3;
use hullwright::{
    Control, ConvexHull, Fragment, Hull, Parameters, TriangleMesh, break_apart, convex_hull,
    decompose,
};

use crate::common::{self, bundled_models};

fn cuboid(low: [f64; 3], high: [f64; 3]) -> TriangleMesh {
    let (positions, triangles) = common::cuboid(low, high);
    TriangleMesh::new(positions, triangles)
}

fn fragments(mesh: &TriangleMesh, hulls: &[Hull]) -> Vec<Fragment> {
    let each_alone: Vec<u32> = (0..hulls.len() as u32).collect();
    break_apart(mesh, hulls, &each_alone, &Control::new()).unwrap()
}

fn area(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> f64 {
    let area = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|corner| DVec3::from(positions[corner as usize]));
        (b - a).cross(c - a).length() / 2.0
    };
    triangles.iter().map(area).sum()
}

fn volume(mesh: &TriangleMesh) -> f64 {
    let of = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|corner| DVec3::from(mesh.positions[corner as usize]));
        a.dot(b.cross(c)) / 6.0
    };
    mesh.triangles.iter().map(of).sum::<f64>().abs()
}

/// Surface and cuts as one mesh.
fn whole(fragment: &Fragment) -> TriangleMesh {
    let mut positions: Vec<[f64; 3]> =
        fragment.vertices.iter().map(|vertex| vertex.position).collect();
    let first = positions.len() as u32;
    positions.extend(&fragment.cut_faces.positions);
    let cuts = fragment.cut_faces.triangles.iter().map(|triangle| triangle.map(|at| at + first));
    TriangleMesh::new(positions, fragment.triangles.iter().copied().chain(cuts).collect())
}

/// Edges that have more triangles on one side than on the other. Vertices at one place, bit by bit
/// in single precision, as it is drawn, are one.
fn open_edges(mesh: &TriangleMesh) -> usize {
    let mut counts: BTreeMap<[[u32; 3]; 2], i32> = BTreeMap::new();
    let place = |corner: u32| mesh.positions[corner as usize].map(|x| (x as f32 + 0.0).to_bits());
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(place);
        for (a, b) in [(a, b), (b, c), (c, a)] {
            *counts.entry([a.min(b), a.max(b)]).or_default() += if a < b { 1 } else { -1 };
        }
    }
    counts.into_iter().filter(|([a, b], count)| a != b && *count != 0).count()
}

#[test]
fn fragments_of_the_bundled_models_have_their_area_and_their_volume_and_are_closed() {
    let mut closed = 0;
    for (name, mesh) in bundled_models() {
        let mesh = TriangleMesh::new(mesh.positions, mesh.triangles);
        let hulls = decompose(&mesh, &Parameters::default(), &Control::new()).unwrap().hulls;
        let fragments = fragments(&mesh, &hulls);
        assert!(fragments.len() <= hulls.len() && fragments.len() > 1, "{name}");
        let outer: f64 = fragments
            .iter()
            .map(|fragment| {
                let positions: Vec<[f64; 3]> =
                    fragment.vertices.iter().map(|v| v.position).collect();
                area(&positions, &fragment.triangles)
            })
            .sum();
        let expected = area(&mesh.positions, &mesh.triangles);
        assert!((outer / expected - 1.0).abs() < 1e-5, "{name}: area {outer} of {expected}");
        let open: usize = fragments.iter().map(|fragment| open_edges(&whole(fragment))).sum();
        let of_source = open_edges(&mesh);
        if of_source == 0 {
            closed += 1;
            assert_eq!(open, 0, "{name}");
            let sum: f64 = fragments.iter().map(|fragment| fragment.volume).sum();
            assert!((sum / volume(&mesh) - 1.0).abs() < 1e-5, "{name}: volume");
            for fragment in &fragments {
                assert!((fragment.volume / volume(&whole(fragment)) - 1.0).abs() < 1e-3, "{name}");
            }
        }
    }
    assert_eq!(closed, 13);
}

/// Whether a plane along a face of one of two hulls, or along an edge of each, is between them.
fn are_apart(first: &ConvexHull, second: &ConvexHull) -> bool {
    let reach = |hull: &ConvexHull, normal: DVec3| {
        let heights = hull.points.iter().map(|point| normal.dot(DVec3::from(*point)));
        heights.fold(f64::NEG_INFINITY, f64::max)
    };
    let edges = |hull: &ConvexHull| -> Vec<DVec3> {
        let sides = hull.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        let ascending = sides.filter(|[a, b]| a < b);
        let along = |[a, b]: [u32; 2]| {
            DVec3::from(hull.points[b as usize]) - DVec3::from(hull.points[a as usize])
        };
        ascending.map(along).collect()
    };
    let faces = first.planes().into_iter().map(|(normal, _)| DVec3::from(normal));
    let faces = faces.chain(second.planes().into_iter().map(|(normal, _)| -DVec3::from(normal)));
    let of_second = edges(second);
    let both = edges(first)
        .into_iter()
        .flat_map(|own| of_second.iter().map(move |other| own.cross(*other)).collect::<Vec<_>>());
    let both = both.flat_map(|normal| [normal, -normal]);
    faces
        .chain(both.map(DVec3::normalize_or_zero))
        .any(|normal| normal != DVec3::ZERO && reach(first, normal) < -reach(second, -normal))
}

#[test]
fn colliders_of_fragments_do_not_touch_each_other() {
    for (name, mesh) in bundled_models() {
        let hulls = decompose(&mesh, &Parameters::default(), &Control::new()).unwrap().hulls;
        let fragments = fragments(&mesh, &hulls);
        let hulls: Vec<&ConvexHull> =
            fragments.iter().flat_map(|fragment| &fragment.colliders).collect();
        for (index, first) in hulls.iter().enumerate() {
            for (other, second) in hulls.iter().enumerate().skip(index + 1) {
                assert!(are_apart(first, second), "{name}: {index} and {other}");
            }
        }
        // And yet hold nearly all of what is closed.
        let of = |hulls: &[&ConvexHull]| hulls.iter().map(|hull| hull.volume()).sum::<f64>();
        let is_whole = open_edges(&mesh) > 0 || of(&hulls) > 0.9 * volume(&mesh);
        assert!(is_whole, "{name}: {} of {}", of(&hulls), volume(&mesh));
    }
}

#[test]
fn hulls_of_one_group_are_one_fragment_without_cuts_between_them() {
    // Three boxes in a row, as one.
    let mesh = cuboid([0.0; 3], [3.0, 1.0, 1.0]);
    let hulls: Vec<Hull> = [0.0, 1.0, 2.0]
        .map(|x| convex_hull(&cuboid([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]).positions).unwrap().into())
        .to_vec();
    let fragments = break_apart(&mesh, &hulls, &[4, 4, 9], &Control::new()).unwrap();
    let [pair, single] = &fragments[..] else { panic!("{} fragments", fragments.len()) };
    assert_eq!((pair.group, single.group), (4, 9));
    assert_eq!((&pair.hulls[..], &single.hulls[..]), (&[0, 1][..], &[2][..]));
    assert_eq!([pair.colliders.len(), single.colliders.len()], [2, 1]);
    assert!((pair.volume - 2.0).abs() < 1e-12 && (single.volume - 1.0).abs() < 1e-12);
    for fragment in &fragments {
        let TriangleMesh { positions, triangles, .. } = &fragment.cut_faces;
        assert!((area(positions, triangles) - 1.0).abs() < 1e-12);
        assert!(positions.iter().all(|point| (point[0] - 2.0).abs() < 1e-12));
    }
}

#[test]
fn an_open_mesh_that_counts_as_solid_has_whole_cuts_and_stays_open() {
    // Two boxes in a row without an underside, as one.
    let mut mesh = cuboid([0.0; 3], [2.0, 1.0, 1.0]);
    let is_below = |triangle: &[u32; 3]| {
        triangle.iter().all(|&corner| mesh.positions[corner as usize][2] == 0.0)
    };
    let open: Vec<[u32; 3]> =
        mesh.triangles.iter().copied().filter(|triangle| !is_below(triangle)).collect();
    assert_eq!(open.len(), 10);
    mesh.triangles = open;
    let hulls: Vec<Hull> = [0.0, 1.0]
        .map(|x| convex_hull(&cuboid([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]).positions).unwrap().into())
        .to_vec();
    for fragment in fragments(&mesh, &hulls) {
        let TriangleMesh { positions, triangles, .. } = &fragment.cut_faces;
        assert!((area(positions, triangles) - 1.0).abs() < 1e-9);
        // The lower edge of the cut may be in two.
        assert!((4..=5).contains(&open_edges(&whole(&fragment))));
        assert!((fragment.volume - 1.0).abs() < 1e-9);
    }
}

#[test]
fn overlaps_are_shared_out_in_their_middle() {
    let mesh = cuboid([0.0; 3], [2.0, 1.0, 1.0]);
    let hulls: Vec<Hull> = [[0.0, 1.4], [0.8, 2.0]]
        .map(|[low, high]| {
            convex_hull(&cuboid([low, 0.0, 0.0], [high, 1.0, 1.0]).positions).unwrap().into()
        })
        .to_vec();
    let volumes: Vec<f64> =
        fragments(&mesh, &hulls).iter().map(|fragment| fragment.volume).collect();
    assert!((volumes[0] - 1.1).abs() < 1e-12 && (volumes[1] - 0.9).abs() < 1e-12, "{volumes:?}");
}

#[test]
fn a_value_at_the_vertices_of_the_mesh_goes_on_over_cuts() {
    for (name, mesh) in bundled_models() {
        let hulls = decompose(&mesh, &Parameters::default(), &Control::new()).unwrap().hulls;
        let (low, high) = mesh.positions.iter().fold((f64::MAX, f64::MIN), |(low, high), of| {
            of.iter().fold((low, high), |(low, high), &x| (low.min(x), high.max(x)))
        });
        for vertex in fragments(&mesh, &hulls).iter().flat_map(|fragment| &fragment.vertices) {
            assert!((vertex.weights.iter().sum::<f32>() - 1.0).abs() < 1e-6, "{name}");
            for (axis, &x) in vertex.position.iter().enumerate() {
                let corners = vertex.corners.map(|corner| mesh.positions[corner as usize][axis]);
                let sum: f64 =
                    corners.iter().zip(vertex.weights).map(|(x, w)| x * f64::from(w)).sum();
                assert!((sum - x).abs() < 1e-5 * (high - low), "{name}: {vertex:?}");
            }
        }
    }
}

#[test]
fn groups_that_are_missing_and_vertices_that_are_not_there_are_errors() {
    let mut mesh = cuboid([0.0; 3], [1.0; 3]);
    let hulls = [Hull::from(convex_hull(&mesh.positions).unwrap())];
    let error = break_apart(&mesh, &hulls, &[], &Control::new()).unwrap_err();
    assert!(error.to_string().contains("0 groups were given for 1 hulls"), "{error}");
    mesh.triangles[3][1] = 99;
    let error = break_apart(&mesh, &hulls, &[0], &Control::new()).unwrap_err();
    assert_eq!(error.code(), "index_out_of_range");
    let control = Control::new();
    control.cancel();
    mesh.triangles.clear();
    assert_eq!(break_apart(&mesh, &hulls, &[0], &control).unwrap_err().code(), "cancelled");
}
