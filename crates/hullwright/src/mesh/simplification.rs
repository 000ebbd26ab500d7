//! A mesh of fewer triangles in place of a repaired one, and how far it is from that.
//!
//! | value | what it is | what it is for |
//! |---|---|---|
//! | exact | triangles in one plane merged | all that is verified |
//! | coarse | detail below the bound gone | the search |
//!
//! Both keep what repair and openings have decided: which components are closed, which triangles
//! are sheets, where caps are.

use std::borrow::Cow;

use super::adjacency::{Adjacency, NO_NEIGHBOUR};
use super::canonical_order::rotated;
use super::collapse::{Collapsed, FLAT, collapse};
use super::flip::flip_diagonals;
use super::repair::{PreparedMesh, compact, with_sheets_both_ways};
use crate::bvh::Bvh;
use crate::bvh::closest_point::{EXACT, closest_point_on_triangle};
use crate::control::Control;
use crate::error::Error;
use crate::geometry::TriangleMesh;
use crate::geometry::vector::{Vector, centre, larger, squared};

/// Rounds of collapses and flips for the exact mesh: a flip makes way for a collapse that was
/// stuck, rarely more than twice.
const MAX_ROUNDS: usize = 6;

/// What may move at first, as fractions of the tolerance: flat places go before those that bend,
/// which saves a tenth of the triangles.
const SHARES: [f64; 2] = [0.25, 1.0];

/// A pass that removes a smaller fraction of the triangles is the last.
const WORTH_ANOTHER: f64 = 0.02;

/// Distances below this are rounding.
const ROUNDING: f64 = 1e-12;

/// Steps from the triangle that a collapse has left to the one that is closest.
const MAX_STEPS: usize = 8;

/// A mesh that stands for another, triangle by triangle. Lengths are fractions of the diagonal.
#[derive(Debug, Clone)]
pub(crate) struct Simplification {
    pub mesh: TriangleMesh,
    /// For each triangle its component.
    pub components: Vec<u32>,
    /// For each component whether it is closed.
    pub closed: Vec<bool>,
    /// For each triangle whether it is there both ways round.
    pub is_sheet: Vec<bool>,
    /// Triangles that close openings within the solid.
    pub hidden_caps: Vec<[u32; 3]>,
    /// For each triangle of the mesh that it stands for the one that stands for it.
    pub owners: Vec<u32>,
    /// For each vertex its index in that mesh.
    pub vertices: Vec<u32>,
    /// For each triangle how far what it stands for is from it at most.
    pub moved: Vec<f64>,
}

impl Simplification {
    /// The repaired mesh itself.
    pub(crate) fn unchanged(prepared: &PreparedMesh) -> Self {
        Self {
            mesh: prepared.mesh.clone(),
            components: prepared.components.clone(),
            closed: prepared.closed.clone(),
            is_sheet: prepared.sheets(),
            hidden_caps: prepared.hidden_caps.clone(),
            owners: (0..prepared.mesh.triangles.len() as u32).collect(),
            vertices: (0..prepared.mesh.positions.len() as u32).collect(),
            moved: vec![0.0; prepared.mesh.triangles.len()],
        }
    }

    /// The repaired mesh with triangles in one plane merged, so that a plain shape is the same
    /// however finely it was cut. No point moves by more than the tolerance. O(n) for n triangles.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub(crate) fn exact(
        prepared: &PreparedMesh,
        tolerance: f64,
        control: &Control,
    ) -> Result<Self, Error> {
        let before = Self::unchanged(prepared);
        if !has_planes(&before.mesh, tolerance) {
            return Ok(before);
        }
        let is_locked = before.locked();
        let mut collapsed = Collapsed::unchanged(&before.mesh.triangles);
        for _ in 0..MAX_ROUNDS {
            let count = collapsed.triangles.len();
            let points = before.mesh.points();
            collapse(&mut collapsed, points, &is_locked, tolerance, (&[1.0], 0.0), control)?;
            let origins = std::mem::take(&mut collapsed.origins);
            let is_sheet = |triangle: u32| before.is_sheet[origins[triangle as usize] as usize];
            let flips = flip_diagonals(&mut collapsed, points, tolerance, |a, b| {
                is_sheet(a) == is_sheet(b)
            });
            collapsed.origins = origins;
            if flips == 0 || collapsed.triangles.len() == count {
                break;
            }
        }
        Ok(before.replaced(collapsed))
    }

    /// The same without the detail that collapses within the tolerance remove. O(n) for n
    /// triangles.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub(crate) fn coarser(&self, tolerance: f64, control: &Control) -> Result<Self, Error> {
        let is_locked = self.locked();
        let mut collapsed = Collapsed::unchanged(&self.mesh.triangles);
        collapse(
            &mut collapsed,
            self.mesh.points(),
            &is_locked,
            tolerance,
            (&SHARES, WORTH_ANOTHER),
            control,
        )?;
        Ok(self.replaced(collapsed))
    }

    /// Whether it is the same as the mesh that it stands for.
    pub(crate) fn is_unchanged(&self) -> bool {
        self.owners.len() == self.mesh.triangles.len() && self.most_moved() == 0.0
    }

    /// How far the surface has moved at most, both ways.
    pub(crate) fn most_moved(&self) -> f64 {
        self.moved.iter().copied().fold(0.0, larger)
    }

    /// The triangles by whose winding number a point is inside.
    pub(crate) fn triangles_of_solid(&self) -> Cow<'_, [[u32; 3]]> {
        with_sheets_both_ways(&self.mesh.triangles, &self.is_sheet, &self.hidden_caps)
    }

    /// Vertices that stay: those of caps within the solid, and where a sheet meets what is none.
    fn locked(&self) -> Vec<bool> {
        let mut is_locked = vec![false; self.mesh.positions.len()];
        for &vertex in self.hidden_caps.as_flattened() {
            is_locked[vertex as usize] = true;
        }
        if self.is_sheet.contains(&true) {
            let mut kinds = vec![(false, false); self.mesh.positions.len()];
            for (triangle, &is_sheet) in self.mesh.triangles.iter().zip(&self.is_sheet) {
                for &vertex in triangle {
                    let kind = &mut kinds[vertex as usize];
                    if is_sheet { kind.0 = true } else { kind.1 = true }
                }
            }
            for (is_locked, kinds) in is_locked.iter_mut().zip(kinds) {
                *is_locked |= kinds == (true, true);
            }
        }
        is_locked
    }

    /// The mesh that collapses have left, in an order that depends on places alone.
    fn replaced(&self, collapsed: Collapsed) -> Self {
        let Collapsed { mut triangles, origins, owners, moved } = collapsed;
        let count = triangles.len();
        let mut order: Vec<u32> = (0..count as u32).collect();
        triangles.iter_mut().for_each(|triangle| *triangle = rotated(*triangle));
        order.sort_unstable_by_key(|&triangle| triangles[triangle as usize]);
        let mut places = vec![0; count];
        for (place, &triangle) in (0..).zip(&order) {
            places[triangle as usize] = place;
        }
        let origin = |triangle: &u32| origins[*triangle as usize] as usize;
        let components = order.iter().map(|t| self.components[origin(t)]).collect();
        let is_sheet = order.iter().map(|t| self.is_sheet[origin(t)]).collect();
        let moved: Vec<f64> = order.iter().map(|&triangle| moved[triangle as usize]).collect();
        let triangles: Vec<[u32; 3]> =
            order.iter().map(|&triangle| triangles[triangle as usize]).collect();
        let mut owners: Vec<u32> = owners.iter().map(|&owner| places[owner as usize]).collect();
        // Vertices that nothing uses any more go; those of hidden caps are in use.
        let mut all = [triangles.as_slice(), &self.hidden_caps].concat();
        let left = compact(&mut all, self.mesh.positions.len());
        let hidden_caps = all.split_off(count);
        let positions = left.iter().map(|&vertex| self.mesh.positions[vertex as usize]).collect();
        let mesh = TriangleMesh::new(positions, all);
        let most = moved.iter().copied().fold(ROUNDING, larger);
        settle_owners(&self.mesh, (&mesh, &left), &mut owners, most);
        let closed = self.closed.clone();
        Self { mesh, components, closed, is_sheet, hidden_caps, owners, vertices: left, moved }
    }
}

/// Triangles that share a plane with a neighbour, as a fraction of all, from which on merging them
/// is worth its time.
const LEAST_IN_PLANES: f64 = 0.2;

/// Whether so many triangles lie in a plane with a neighbour that merging them makes a difference.
/// A curved surface, however finely it is cut, has few.
fn has_planes(mesh: &TriangleMesh, tolerance: f64) -> bool {
    let adjacency = Adjacency::new(mesh);
    let points = mesh.points();
    let in_plane = |triangle: u32| {
        let corners = mesh.triangles[triangle as usize];
        let normal = adjacency.normals[triangle as usize];
        let origin = points[corners[0] as usize];
        adjacency.triangle_neighbours(triangle).into_iter().any(|other| {
            other != NO_NEIGHBOUR
                && mesh.triangles[other as usize].iter().all(|&vertex| {
                    normal.dot(points[vertex as usize] - origin).abs() <= FLAT * tolerance
                })
        })
    };
    let count = (0..mesh.triangles.len() as u32).filter(|&triangle| in_plane(triangle)).count();
    count as f64 >= LEAST_IN_PLANES * mesh.triangles.len() as f64
}

/// Collapses leave owners that may be next to the closest triangle: from there on, each step goes
/// to a neighbour that is closer to the centre of what is owned.
fn settle_owners(
    source: &TriangleMesh,
    (mesh, vertices): (&TriangleMesh, &[u32]),
    owners: &mut [u32],
    most: f64,
) {
    if source.triangles.len() == mesh.triangles.len() {
        return;
    }
    let adjacency = Adjacency::new(mesh);
    let mut tree = None;
    let distance = |point: Vector, triangle: u32| {
        let corners = mesh.corners(mesh.triangles[triangle as usize]);
        let [a, b, c] = corners.map(|corner| corner - point);
        closest_point_on_triangle(a, b, c).length_squared()
    };
    for (triangle, owner) in source.triangles.iter().zip(owners) {
        let corners = mesh.triangles[*owner as usize].map(|vertex| vertices[vertex as usize]);
        if triangle.iter().all(|vertex| corners.contains(vertex)) {
            continue;
        }
        let middle = centre(source.corners(*triangle));
        let mut least = distance(middle, *owner);
        for _ in 0..MAX_STEPS {
            if least == 0.0 {
                break;
            }
            let neighbours = adjacency.triangle_neighbours(*owner);
            let others = neighbours.into_iter().filter(|&other| other != NO_NEIGHBOUR);
            let best = others
                .map(|other| (distance(middle, other), other))
                .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            match best {
                Some((closer, other)) if closer < least => (least, *owner) = (closer, other),
                _ => break,
            }
        }
        // Where several triangles share the closest corner, no step gets closer.
        if least > squared(most) {
            let tree = tree.get_or_insert_with(|| Bvh::new(mesh.points(), &mesh.triangles));
            if let Some(closest) = tree.closest_point_near(middle, EXACT, *owner) {
                *owner = closest.triangle;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::vector::area_normal;
    use crate::mesh::adjacency::Connectivity;
    use crate::mesh::canonical_order::MeshOrder;
    use crate::mesh::repair::prepare;
    use crate::mesh::shapes::{cuboid, uv_sphere};

    const TOLERANCES: [f64; 2] = [2e-5, 2e-7];

    /// How a square is cut into triangles. All have as many points on each side.
    #[derive(Debug, Clone, Copy)]
    enum Cut {
        /// By a grid.
        Even,
        /// By lines from one side to the other.
        Slivers,
        /// From the centre.
        Fan,
    }

    /// A mesh whose triangles share no vertices.
    #[derive(Default)]
    struct Soup(TriangleMesh);

    impl Soup {
        fn push(&mut self, corners: [Vector; 3]) {
            let first = self.0.positions.len() as u32;
            self.0.positions.extend(corners.map(|corner| corner.to_array()));
            self.0.triangles.push([first, first + 1, first + 2]);
        }

        /// A square with a corner and two sides, each side in `n` parts.
        fn square(&mut self, corner: Vector, [right, up]: [Vector; 2], (cut, n): (Cut, u32)) {
            let share = |i: u32| f64::from(i) / f64::from(n);
            let at = |i: u32, j: u32| corner + right * share(i) + up * share(j);
            match cut {
                Cut::Even => {
                    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                        self.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
                        self.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
                    }
                }
                Cut::Slivers => {
                    for i in 0..n {
                        self.push([at(0, 1), at(i, 0), at(i + 1, 0)]);
                        self.push([at(n, n - 1), at(i + 1, n), at(i, n)]);
                    }
                    for j in 1..n {
                        self.push([at(0, j), at(n, j - 1), at(n, j)]);
                    }
                    for j in 1..n {
                        self.push([at(0, j), at(n, j), at(0, j + 1)]);
                    }
                }
                Cut::Fan => {
                    let middle = corner + (right + up) * 0.5;
                    for i in 0..n {
                        self.push([middle, at(i, 0), at(i + 1, 0)]);
                        self.push([middle, at(n, i), at(n, i + 1)]);
                        self.push([middle, at(i + 1, n), at(i, n)]);
                        self.push([middle, at(0, i + 1), at(0, i)]);
                    }
                }
            }
        }

        /// A prism of height 1 over squares of the plane, without what is between two of them.
        fn prism(squares: &[[i32; 2]], cut: (Cut, u32)) -> Self {
            let mut soup = Self::default();
            let [x, y, z] = [Vector::X, Vector::Y, Vector::Z];
            for &[i, j] in squares {
                let low = Vector::new(f64::from(i), f64::from(j), 0.0);
                soup.square(low, [y, x], cut);
                soup.square(low + z, [x, y], cut);
                for (beyond, corner, along) in [
                    ([i, j - 1], low, x),
                    ([i + 1, j], low + x, y),
                    ([i, j + 1], low + x + y, -x),
                    ([i - 1, j], low + y, -y),
                ] {
                    if !squares.contains(&beyond) {
                        soup.square(corner, [along, z], cut);
                    }
                }
            }
            soup
        }

        fn prepared(self) -> PreparedMesh {
            prepare(self.0.view(), MeshOrder::Place, &Control::new()).unwrap()
        }
    }

    const BOX: &[[i32; 2]] = &[[0, 0]];
    const L: &[[i32; 2]] = &[[0, 0], [1, 0], [0, 1]];
    const U: &[[i32; 2]] = &[[0, 0], [1, 0], [2, 0], [0, 1], [2, 1]];

    /// Exact; the centre of each triangle is within the tolerance of its owner's plane.
    fn exact(prepared: &PreparedMesh, tolerance: f64) -> Simplification {
        let exact = Simplification::exact(prepared, tolerance, &Control::new()).unwrap();
        assert!(exact.most_moved() <= tolerance);
        assert_eq!(exact.owners.len(), prepared.mesh.triangles.len());
        for (triangle, &owner) in prepared.mesh.triangles.iter().zip(&exact.owners) {
            let corners = |mesh: &TriangleMesh, triangle: [u32; 3]| {
                triangle.map(|vertex| mesh.points()[vertex as usize])
            };
            let [a, b, c] = corners(&exact.mesh, exact.mesh.triangles[owner as usize]);
            let middle = centre(corners(&prepared.mesh, *triangle));
            let normal = area_normal(a, b, c).normalize();
            assert!(normal.dot(middle - a).abs() <= tolerance + 1e-12);
        }
        for (position, &vertex) in exact.mesh.positions.iter().zip(&exact.vertices) {
            assert_eq!(*position, prepared.mesh.positions[vertex as usize]);
        }
        exact
    }

    fn has_place(mesh: &TriangleMesh, place: Vector) -> bool {
        mesh.points().iter().any(|point| point.distance(place) < 1e-12)
    }

    #[test]
    fn a_plain_shape_is_the_same_however_its_faces_are_cut() {
        for (squares, corners) in [(BOX, 8), (L, 12), (U, 16)] {
            for tolerance in TOLERANCES {
                let coarse = exact(&Soup::prism(squares, (Cut::Even, 1)).prepared(), tolerance);
                assert_eq!(coarse.mesh.positions.len(), corners);
                for cut in [Cut::Even, Cut::Slivers, Cut::Fan] {
                    for n in [2, 5, 8] {
                        let prepared = Soup::prism(squares, (cut, n)).prepared();
                        let fine = exact(&prepared, tolerance);
                        let what = format!("{corners} corners, {cut:?} {n}, {tolerance}");
                        assert_eq!(fine.mesh.positions.len(), corners, "{what}");
                        for (a, b) in fine.mesh.points().iter().zip(coarse.mesh.points()) {
                            assert!(a.distance(*b) < 1e-12, "{what}");
                        }
                        assert_eq!(fine.mesh.triangles, coarse.mesh.triangles, "{what}");
                    }
                }
            }
        }
    }

    #[test]
    fn owners_are_in_the_plane_of_what_they_own() {
        for (squares, cut) in [(L, (Cut::Even, 17)), (L, (Cut::Even, 18)), (U, (Cut::Fan, 15))] {
            for tolerance in TOLERANCES {
                exact(&Soup::prism(squares, cut).prepared(), tolerance);
            }
        }
    }

    #[test]
    fn what_is_closed_stays_closed() {
        for squares in [BOX, L, U] {
            let prepared = Soup::prism(squares, (Cut::Slivers, 6)).prepared();
            let exact = exact(&prepared, 2e-5);
            let mesh = &exact.mesh;
            assert_eq!((prepared.closed, &exact.closed), (vec![true], &vec![true]));
            assert_eq!(Connectivity::new(&mesh.triangles, mesh.positions.len()).closed, [true]);
            assert_eq!(mesh.triangles.len(), 2 * mesh.positions.len() - 4);
        }
    }

    #[test]
    fn corners_of_hidden_caps_stay() {
        let mut prepared = Soup::prism(BOX, (Cut::Even, 6)).prepared();
        let points = prepared.mesh.points();
        let cap: Vec<u32> = (0..points.len() as u32).step_by(29).take(3).collect();
        let places = [cap[0], cap[1], cap[2]].map(|vertex| points[vertex as usize]);
        prepared.hidden_caps = vec![[cap[0], cap[1], cap[2]]];
        let exact = exact(&prepared, 2e-5);
        assert!(exact.mesh.positions.len() <= 11);
        let left = exact.hidden_caps[0].map(|vertex| exact.mesh.points()[vertex as usize]);
        assert_eq!(left, places);
    }

    /// A box with a fin that is there both ways round upon it.
    fn with_fin() -> Soup {
        let mut soup = Soup::prism(BOX, (Cut::Even, 8));
        let (corner, sides) = (Vector::new(0.25, 0.5, 1.0), [Vector::X * 0.5, Vector::Z * 0.5]);
        soup.square(corner, sides, (Cut::Even, 4));
        soup.square(corner, [sides[1], sides[0]], (Cut::Even, 4));
        soup
    }

    #[test]
    fn corners_where_a_sheet_meets_a_solid_stay() {
        let prepared = with_fin().prepared();
        let exact = exact(&prepared, 2e-5);
        for i in 0..=4 {
            let place = Vector::new(0.25 + 0.125 * f64::from(i), 0.5, 1.0);
            assert!(has_place(&exact.mesh, prepared.normalization.normalize(place)), "{i}");
        }
        let sheets = exact.is_sheet.iter().filter(|&&is_sheet| is_sheet).count();
        assert!((5..32).contains(&sheets), "{sheets}");
    }

    #[test]
    fn what_is_between_the_seam_and_the_corners_of_a_sheet_goes() {
        let exact = exact(&with_fin().prepared(), 2e-5);
        // Eight corners of the box, five of the seam, two of the fin.
        assert_eq!(exact.mesh.positions.len(), 15);
    }

    #[test]
    fn a_curved_surface_is_left_as_it_is() {
        let mut source = uv_sphere(32, [0.0; 3], 1.0);
        // Twisted, since four corners of the sphere are in one plane.
        for position in &mut source.positions {
            let turned = glam::DQuat::from_rotation_z(position[2]) * Vector::from(*position);
            *position = turned.to_array();
        }
        let prepared = prepare(source.view(), MeshOrder::Place, &Control::new()).unwrap();
        for tolerance in TOLERANCES {
            assert!(!has_planes(&prepared.mesh, tolerance));
            let exact = exact(&prepared, tolerance);
            assert!(exact.is_unchanged() && exact.mesh == prepared.mesh);
            let coarser = exact.coarser(0.01, &Control::new()).unwrap();
            assert!(!coarser.is_unchanged() && coarser.most_moved() <= 0.01);
            assert!(2 * coarser.mesh.triangles.len() < prepared.mesh.triangles.len());
        }
    }

    #[test]
    fn a_box_of_twelve_triangles_keeps_its_corners() {
        let source = cuboid([0.0; 3], [1.0, 2.0, 3.0]);
        let prepared = prepare(source.view(), MeshOrder::Place, &Control::new()).unwrap();
        let exact = exact(&prepared, 2e-5);
        assert_eq!(exact.mesh.positions, prepared.mesh.positions);
        assert_eq!(exact.owners.len(), 12);
    }
}
