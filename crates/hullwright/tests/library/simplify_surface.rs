//! What a simplified surface promises.

use hullwright::{
    Control, Error, Length, MeshView, SimplifiedSurface, SimplifyParameters, TriangleMesh,
    simplify_surface,
};

use crate::common::{Mesh, Point, Random, ball, bundled_models, cuboid, join, torus, turned, view};
use crate::independent::nearest::Tree;
use crate::independent::oracle::{Triangle, cross, middle, minus, norm};
use crate::independent::sampling::spread;

fn simplified<'a>(mesh: impl Into<MeshView<'a>>, bound: Length) -> SimplifiedSurface {
    simplify_surface(mesh, bound, &Control::new()).unwrap()
}

/// A square in a plane as a grid of n by n cells, without those for which `leaves_out` holds.
fn grid(n: u32, place: impl Fn(f64, f64) -> Point, leaves_out: impl Fn(u32, u32) -> bool) -> Mesh {
    let share = |i: u32| f64::from(i) / f64::from(n);
    let rows = (0..=n).flat_map(|j| (0..=n).map(move |i| (i, j)));
    let positions = rows.map(|(i, j)| place(share(i), share(j))).collect();
    let mut triangles = Vec::new();
    for (i, j) in (0..n).flat_map(|j| (0..n).map(move |i| (i, j))) {
        if !leaves_out(i, j) {
            let a = j * (n + 1) + i;
            triangles.extend([[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]);
        }
    }
    (positions, triangles)
}

/// A cube whose faces are cut into n by n cells.
fn fine_cube(n: u32) -> Mesh {
    let none = |_, _| false;
    let faces = [
        grid(n, |u, v| [v, u, 0.0], none),
        grid(n, |u, v| [u, v, 1.0], none),
        grid(n, |u, v| [u, 0.0, v], none),
        grid(n, |u, v| [v, 1.0, u], none),
        grid(n, |u, v| [0.0, v, u], none),
        grid(n, |u, v| [1.0, u, v], none),
    ];
    join(&faces)
}

fn area(triangle: &Triangle) -> f64 {
    let [a, b, c] = triangle.corners;
    0.5 * norm(cross(minus(b, a), minus(c, a)))
}

/// The greatest distance that samples find of one surface from another.
fn sampled(of: &[Triangle], from: &[Triangle], count: f64) -> f64 {
    let tree = Tree::new(from.to_vec());
    let area: f64 = of.iter().map(area).sum();
    let special = of.iter().flat_map(|triangle| {
        let [a, b, c] = triangle.corners;
        [a, b, c, middle(a, b), middle(b, c), middle(c, a), triangle.centre]
    });
    let all = special.chain(spread(of, count / area));
    all.map(|point| tree.distance(point)).fold(0.0, f64::max)
}

/// Checks all promises on distances against samples.
#[track_caller]
fn assert_within(source: &TriangleMesh, result: &SimplifiedSurface, what: &str) {
    let report = &result.report;
    assert!(report.from_source <= report.bound && report.to_source <= report.bound, "{what}");
    assert_eq!(result.sources.len(), result.mesh.triangles.len(), "{what}");
    let is_source = |&index: &u32| (index as usize) < source.triangles.len();
    assert!(result.sources.iter().all(is_source), "{what}");
    let left = (0..).zip(&source.triangles).filter(|(index, _)| !result.hidden.contains(index));
    let left: Vec<[u32; 3]> = left.map(|(_, &triangle)| triangle).collect();
    let mut given = Triangle::all(&source.positions, &left);
    // Triangles without an area are left out.
    let longest = |axis: usize| {
        let all = given.iter().flat_map(|triangle| triangle.corners).map(|corner| corner[axis]);
        all.clone().fold(f64::MIN, f64::max) - all.fold(f64::MAX, f64::min)
    };
    let extent = longest(0).max(longest(1)).max(longest(2));
    given.retain(|triangle| {
        let [a, b, c] = triangle.corners;
        let sides = [[a, b], [b, c], [c, a]].map(|[a, b]| norm(minus(b, a)));
        let longest = sides.into_iter().fold(0.0, f64::max);
        2.0 * area(triangle) > 1e-7 * extent * longest
    });
    let made = Triangle::all(&result.mesh.positions, &result.mesh.triangles);
    let rounding = 1e-9
        * report
            .bound
            .max(source.positions.as_flattened().iter().fold(0.0, |m, x| x.abs().max(m)) * 1e-5);
    let from_source = sampled(&made, &given, 2000.0);
    assert!(from_source <= report.from_source + rounding, "{what}: {from_source}, {report:?}");
    let to_source = sampled(&given, &made, 2000.0);
    assert!(to_source <= report.to_source + rounding, "{what}: {to_source}, {report:?}");
}

fn owned((positions, triangles): Mesh) -> TriangleMesh {
    TriangleMesh::new(positions, triangles)
}

#[test]
fn a_finely_cut_cube_becomes_twelve_triangles() {
    for bound in [Length::share(0.01), Length::share(0.0001), Length::share(0.05)] {
        let cube = owned(fine_cube(20));
        let result = simplified(&cube, bound);
        assert_eq!((result.mesh.triangles.len(), result.mesh.positions.len()), (12, 8));
        assert_within(&cube, &result, "a cube");
        assert_eq!(result.report.source_triangles, 4800);
    }
}

#[test]
fn a_plane_keeps_its_hole_and_its_border() {
    let is_hole = |i, j| (8..12).contains(&i) && (5..12).contains(&j);
    let plane = owned(grid(20, |u, v| [u, v, 0.0], is_hole));
    let result = simplified(&plane, Length::share(0.01));
    assert_eq!(result.mesh.positions.len(), 8);
    assert_eq!(result.mesh.triangles.len(), 8);
    assert_within(&plane, &result, "a plane");
}

#[test]
fn a_sphere_has_few_triangles_within_the_bound() {
    let sphere = owned(ball(48, 96));
    let result = simplified(&sphere, Length::share(0.005));
    assert!(10 * result.mesh.triangles.len() < sphere.triangles.len());
    assert_within(&sphere, &result, "a sphere");
    let coarser = simplified(&sphere, Length::share(0.02));
    assert!(coarser.mesh.triangles.len() < result.mesh.triangles.len());
}

#[test]
fn two_boxes_that_touch_stay_as_they_are() {
    let boxes =
        owned(join(&[cuboid([0.0; 3], [1.0; 3]), cuboid([1.0, 0.0, 0.0], [2.0, 1.0, 1.0])]));
    let result = simplified(&boxes, Length::share(0.01));
    assert!(result.hidden.is_empty());
    assert_eq!(result.mesh.positions.len(), 12);
    assert_within(&boxes, &result, "two boxes");
}

#[test]
fn what_is_wholly_within_a_solid_is_hidden_and_listed() {
    // A finely cut chest that stands into a floor: what is below the floor's top goes.
    let lift = |(positions, triangles): Mesh| {
        (positions.into_iter().map(|[x, y, z]| [x, y, z - 0.47]).collect::<Vec<_>>(), triangles)
    };
    let floor = cuboid([-2.0, -2.0, -1.0], [3.0, 3.0, 0.0]);
    let level = owned(join(&[floor.clone(), lift(fine_cube(10))]));
    let result = simplified(&level, Length::share(0.001));
    // The bottom, and four rows of ten cells on each of the four sides.
    assert_eq!(result.hidden.len(), 200 + 4 * 4 * 20);
    assert!(result.hidden.iter().all(|&triangle| triangle >= 12));
    assert_eq!(result.report.hidden_triangles, result.hidden.len());
    assert_within(&level, &result, "a chest");
    let all = SimplifyParameters::new(Length::share(0.001)).with_keep_hidden(true);
    let kept = simplify_surface(&level, all, &Control::new()).unwrap();
    assert!(kept.hidden.is_empty());
    assert_eq!(kept.mesh.triangles.len(), 24);
}

#[test]
fn what_is_within_a_room_is_never_hidden() {
    let chest = cuboid([0.4; 3], [0.6; 3]);
    let room = turned(&cuboid([0.0; 3], [1.0; 3]));
    let house = cuboid([-0.1; 3], [1.1; 3]);
    for level in [
        join(&[room.clone(), chest.clone()]),
        join(&[house, room.clone(), chest.clone()]),
        join(&[turned(&chest), room]),
    ] {
        let result = simplified(view(&level), Length::share(0.001));
        assert!(result.hidden.is_empty());
        assert_eq!(result.mesh.triangles.len(), level.1.len());
    }
}

#[test]
fn triangles_keep_the_side_that_they_face() {
    let volume = |mesh: &TriangleMesh| -> f64 {
        let corners = |t: &[u32; 3]| t.map(|v| mesh.positions[v as usize]);
        let six = mesh.triangles.iter().map(corners).map(|[a, b, c]| {
            a[0] * (b[1] * c[2] - b[2] * c[1])
                + a[1] * (b[2] * c[0] - b[0] * c[2])
                + a[2] * (b[0] * c[1] - b[1] * c[0])
        });
        six.sum::<f64>() / 6.0
    };
    let inward = owned(turned(&fine_cube(5)));
    let before = volume(&inward);
    let after = volume(&simplified(&inward, Length::share(0.01)).mesh);
    assert!((before - after).abs() < 1e-9, "{before}, {after}");
}

#[test]
fn a_triangle_remembers_one_that_was_there() {
    let level = owned(join(&[fine_cube(6), cuboid([3.0; 3], [4.0; 3])]));
    let result = simplified(&level, Length::share(0.001));
    for (triangle, &source) in result.mesh.triangles.iter().zip(&result.sources) {
        let is_far = result.mesh.positions[triangle[0] as usize][0] > 2.0;
        assert_eq!(is_far, source as usize >= level.triangles.len() - 12);
    }
}

#[test]
fn samples_find_nothing_beyond_the_bound_on_the_bundled_models() {
    for (name, mesh) in bundled_models() {
        for share in [0.002, 0.02] {
            let result = simplified(&mesh, Length::share(share));
            assert!(result.mesh.triangles.len() <= mesh.triangles.len(), "{name}");
            assert_within(&mesh, &result, &format!("{name}, {share}"));
        }
    }
}

/// A random soup: loose triangles, triangles among few points, crossing boxes with holes.
fn soup(random: &mut Random, kind: usize) -> TriangleMesh {
    let count = 4 + random.below(60);
    match kind % 4 {
        0 => {
            let positions = (0..3 * count).map(|_| random.point()).collect();
            owned((positions, (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect()))
        }
        1 => {
            let positions: Vec<Point> =
                (0..count).map(|_| random.point().map(|x| (2.0 * x).round())).collect();
            let corner = |random: &mut Random| random.below(count) as u32;
            let triangles = (0..2 * count)
                .map(|_| [corner(random), corner(random), corner(random)])
                .chain([[0, 1, 2]]);
            let triangles = triangles.collect();
            owned((positions, triangles))
        }
        2 => {
            let flat = |point: Point| [point[0], point[1], 1e-7 * point[2]];
            let positions: Vec<Point> = (0..count).map(|_| flat(random.point())).collect();
            let corner = |random: &mut Random| random.below(count) as u32;
            let triangles =
                (0..2 * count).map(|_| [corner(random), corner(random), corner(random)]).collect();
            owned((positions, triangles))
        }
        _ => {
            let boxes: Vec<Mesh> = (0..2 + count % 6)
                .map(|_| {
                    let low = random.point();
                    cuboid(low, low.map(|x| x + 0.6))
                })
                .collect();
            let mut mesh = join(&boxes);
            mesh.1.retain(|_| random.below(7) > 0);
            owned(mesh)
        }
    }
}

#[test]
fn samples_find_nothing_beyond_the_bound_on_random_soups() {
    let mut random = Random(7);
    for number in 0..500 {
        let mesh = soup(&mut random, number);
        let share = [0.0000001, 0.001, 0.02, 0.1, 2.0][number / 4 % 5];
        match simplify_surface(&mesh, Length::share(share), &Control::new()) {
            Ok(result) => assert_within(&mesh, &result, &format!("soup {number}, {share}")),
            Err(Error::NothingUsable { .. }) => {}
            Err(error) => panic!("soup {number}: {error}"),
        }
    }
}

/// The same with triangles and vertices the other way round, and other corners first.
fn shuffled(mesh: &TriangleMesh) -> TriangleMesh {
    let mut shuffled = mesh.clone();
    shuffled.triangles.reverse();
    shuffled.triangles.iter_mut().for_each(|triangle| triangle.rotate_left(1));
    let last = shuffled.positions.len() as u32 - 1;
    shuffled.positions.reverse();
    shuffled.triangles.as_flattened_mut().iter_mut().for_each(|vertex| *vertex = last - *vertex);
    shuffled
}

#[test]
fn the_order_of_triangles_and_vertices_and_threads_do_not_matter() {
    let mesh = owned(join(&[torus(), fine_cube(4)]));
    let models = bundled_models().into_iter().map(|(_, mesh)| mesh);
    for mesh in models.chain([mesh]) {
        let first = simplified(&mesh, Length::share(0.01));
        assert_eq!(first.mesh, simplified(&shuffled(&mesh), Length::share(0.01)).mesh);
        let alone = Control::new().with_parallel(false);
        assert_eq!(simplify_surface(&mesh, Length::share(0.01), &alone).unwrap(), first);
    }
}

#[test]
fn closed_components_stay_closed() {
    let shifted = |(positions, triangles): Mesh| {
        (positions.into_iter().map(|[x, y, z]| [x + 3.0, y, z]).collect(), triangles)
    };
    let mesh = owned(join(&[torus(), shifted(ball(48, 96)), shifted(shifted(fine_cube(6)))]));
    for share in [0.001, 0.01, 0.1, 0.5] {
        let result = simplified(&mesh, Length::share(share));
        let sides = result.mesh.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        let mut sides: Vec<[u32; 2]> = sides.collect();
        sides.sort_unstable();
        let before = sides.len();
        sides.dedup();
        assert_eq!(sides.len(), before, "{share}");
        assert!(sides.iter().all(|&[a, b]| sides.binary_search(&[b, a]).is_ok()), "{share}");
        assert!(sides.len() >= 3 * 3 * 4, "{share}");
    }
}

#[test]
fn what_can_not_be_simplified_is_refused() {
    let (cube, control) = (owned(fine_cube(2)), Control::new());
    for bound in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let result = simplify_surface(&cube, Length::units(bound), &control);
        assert!(matches!(result, Err(Error::InvalidParameter { name: "max_error", .. })));
    }
    let empty = simplify_surface(&TriangleMesh::default(), Length::share(0.01), &control);
    assert!(matches!(empty, Err(Error::EmptyMesh { .. })));
    let limited = Control::new().with_max_triangles(10);
    let result = simplify_surface(&cube, Length::share(0.01), &limited);
    assert!(matches!(result, Err(Error::TooLarge { .. })));
    control.cancel();
    let cancelled = simplify_surface(&cube, Length::share(0.01), &control);
    assert_eq!(cancelled, Err(Error::Cancelled));
}

#[test]
fn hostile_numbers_are_left_out_or_simplified() {
    let mut mesh = owned(fine_cube(3));
    let first = mesh.positions.len() as u32;
    mesh.positions.extend([[f64::NAN; 3], [f64::INFINITY, 0.0, 0.0], [1.0, 1.0, 1e308]]);
    mesh.triangles.extend([[0, 1, first], [0, 1, first + 1], [0, 1, first + 2], [0, 0, 1]]);
    let result = simplified(&mesh, Length::share(0.01));
    assert_eq!(result.mesh.triangles.len(), 12);
    assert_eq!(result.report.repairs.non_finite_triangles, 3);
    assert_eq!(result.report.repairs.degenerate_triangles, 1);
    for scale in [1e-200, 1e-12, 1e12, 1e150] {
        let mut scaled = owned(fine_cube(3));
        scaled.positions.as_flattened_mut().iter_mut().for_each(|x| *x *= scale);
        assert_eq!(simplified(&scaled, Length::share(0.01)).mesh.triangles.len(), 12);
        // Bounds that are far too small or too large.
        assert!(simplify_surface(&scaled, Length::units(1.0), &Control::new()).is_ok());
        assert!(simplify_surface(&scaled, Length::share(1e-300), &Control::new()).is_ok());
        assert!(simplify_surface(&scaled, Length::share(1e300), &Control::new()).is_ok());
    }
}
