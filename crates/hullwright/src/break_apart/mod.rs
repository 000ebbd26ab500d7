//! A mesh broken into fragments, one for each hull: to be drawn, and to be moved.
//!
//! | file | contents |
//! |---|---|
//! | `division` | planes that divide hulls |
//! | `cut` | a mesh cut by a plane |
//! | `cap` | polygons that close a cut |

mod cap;
mod cut;
mod division;

use std::collections::{BTreeMap, HashMap, HashSet};

use self::cut::{Cutter, Face, Origin};
use self::division::Division;
use crate::control::Control;
use crate::decomposition::Hull;
use crate::error::Error;
use crate::geometry::plane::Plane;
use crate::geometry::vector::{Vector, as_arrays, bounds, mean, six_volumes};
use crate::geometry::{MeshView, TriangleMesh};
use crate::hull::{ConvexHull, HullBuilder, MINIMUM_THICKNESS, most_prominent, solid_hull};
use crate::mesh::adjacency::{Connectivity, SortedHalfEdges};
use crate::mesh::weld::weld;
use crate::openings::close_openings;
use crate::parameters::Parameters;

/// A part of a mesh that was broken apart.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
pub struct Fragment {
    /// The number that its hulls have.
    pub group: u32,
    /// The indices of its hulls.
    pub hulls: Vec<u32>,
    /// Vertices of its part of the mesh's surface.
    pub vertices: Vec<FragmentVertex>,
    /// Triangles of its part of the mesh's surface.
    pub triangles: Vec<[u32; 3]>,
    /// For each of these the triangle of the mesh that it is a part of.
    pub source_triangles: Vec<u32>,
    /// What closes it where it was cut. Each face has vertices of its own, so that it is flat in
    /// any light.
    pub cut_faces: TriangleMesh,
    /// Hulls of its points, to collide with: convex cells keep them apart from those of all other
    /// fragments.
    pub colliders: Vec<ConvexHull>,
    /// What it encloses, in cubed units, where it is closed; of its colliders where it is open.
    pub volume: f64,
}

/// A vertex of a fragment: a place on a triangle of the mesh, so that normals, texture coordinates
/// and whatever else the mesh has at its vertices can be worked out there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FragmentVertex {
    /// Where it is.
    pub position: [f64; 3],
    /// Three vertices of the mesh. At a vertex of the mesh all three are this one.
    pub corners: [u32; 3],
    /// Their weights, which add up to 1: a value at the vertex is the weighted sum of theirs.
    pub weights: [f32; 3],
}

/// Vertices nearer to a plane count as in it, as a fraction of the diagonal of the bounding box:
/// single precision can't resolve less.
const IN_PLANE: f64 = 1e-7;

/// Physics engines take time with the number of vertices of a hull, and fragments are many.
const MOST_COLLIDER_VERTICES: usize = 64;

/// Colliders have this size of what is in their cells. Physics engines see hulls that touch as
/// overlapping by up to several percent, in whatever direction, and push them apart.
const SIZE: f64 = 0.99;

/// Breaks a mesh into fragments, one for each hull, or for each group of hulls with one number.
///
/// Planes divide the hulls until each is alone. Each lies along a face of one of two neighbours, in
/// the middle of where they overlap or at an end of that, and of all such planes the one comes
/// first that leaves least of the hulls' volume on the wrong side. So space is shared out where
/// hulls overlap, and hulls that differ a little are cut in nearly the same places. The mesh is cut
/// by them. Cuts are closed, for each connected part of the mesh on its own, also of an open mesh
/// where [`openings`](crate::openings) take it for solid; openings stay open. Triangles of all
/// fragments together have the area of the mesh, and closed fragments its volume.
///
/// ```
/// use hullwright::{Control, Parameters, TriangleMesh, break_apart, decompose};
///
/// # fn main() -> Result<(), hullwright::Error> {
/// # let outline = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
/// # let positions = [0.0, 1.0].iter().flat_map(|&z| outline.map(|[x, y]| [x, y, z])).collect();
/// # let mut triangles = vec![[0, 2, 1], [0, 3, 2], [0, 4, 3], [0, 5, 4]];
/// # triangles.extend([[6, 7, 8], [6, 8, 9], [6, 9, 10], [6, 10, 11]]);
/// # triangles.extend((0..6).flat_map(|a| {
/// #     let b = (a + 1) % 6;
/// #     [[a, b, b + 6], [a, b + 6, a + 6]]
/// # }));
/// let l_shape = TriangleMesh::new(positions, triangles); // of volume 3
/// let hulls = decompose(&l_shape, &Parameters::default(), &Control::new())?.hulls;
/// let each_alone = [0, 1];
/// let fragments = break_apart(&l_shape, &hulls, &each_alone, &Control::new())?;
/// assert_eq!(fragments.len(), 2);
/// let volume: f64 = fragments.iter().map(|fragment| fragment.volume).sum();
/// assert!((volume - 3.0).abs() < 1e-9);
/// # Ok(())
/// # }
/// ```
///
/// A fragment without anything to draw is left out. Fragments are in the order of their groups.
///
/// O(t log h + h²) for t triangles and h hulls, as long as planes halve both.
///
/// # Errors
/// [`Error::InvalidParameter`] if there is not one number for each hull, [`Error::IndexOutOfRange`]
/// if a triangle has a vertex that is not there, and [`Error::Cancelled`]. Triangles with a corner
/// that is not finite are left out.
pub fn break_apart<'a>(
    mesh: impl Into<MeshView<'a>>,
    hulls: &[Hull],
    groups: &[u32],
    control: &Control,
) -> Result<Vec<Fragment>, Error> {
    let mesh = mesh.into();
    if groups.len() != hulls.len() {
        let (given, count) = (groups.len(), hulls.len());
        let reason = format!("{given} groups were given for {count} hulls");
        return Err(Error::parameter("groups", reason));
    }
    let (mut cutter, faces) = prepare(mesh, control)?;
    let shapes: Vec<&ConvexHull> = hulls.iter().map(|hull| &hull.shape).collect();
    let division = Division::new(&shapes, groups, control)?;
    let mut parts: BTreeMap<u32, Part> = BTreeMap::new();
    let mut undivided = vec![Cell { hulls: (0..hulls.len()).collect(), faces, is_drawn: false }];
    while let Some(Cell { hulls: own, faces, mut is_drawn }) = undivided.pop() {
        control.check()?;
        let Some(&first) = own.first().filter(|_| !faces.is_empty()) else { continue };
        let group = groups[first];
        let division = division.divide(&own);
        // What stays together is not cut; its colliders are.
        if !is_drawn && (division.is_none() || own.iter().all(|&hull| groups[hull] == group)) {
            let part = parts.entry(group).or_default();
            part.hulls.extend(own.iter().map(|&hull| hull as u32));
            part.faces.extend(&faces);
            is_drawn = true;
        }
        match division {
            Some((plane, [below, above])) => {
                let [low, high] = match cutter.reach(&faces, &plane) {
                    (_, high) if high <= cutter.thinnest => [faces, Vec::new()],
                    (low, _) if -low <= cutter.thinnest => [Vec::new(), faces],
                    _ => cutter.cut(faces, &plane),
                };
                undivided.push(Cell { hulls: above, faces: high, is_drawn });
                undivided.push(Cell { hulls: below, faces: low, is_drawn });
            }
            None => {
                let collider = cutter.collider(&faces, control)?;
                parts.entry(group).or_default().colliders.extend(collider);
            }
        }
    }
    let fragment = |(group, part): (u32, Part)| cutter.fragment(mesh, group, part);
    Ok(parts.into_iter().map(fragment).collect())
}

/// Convex, with the hulls that share it and what is in it of the mesh.
struct Cell {
    hulls: Vec<usize>,
    faces: Vec<Face>,
    /// Whether a fragment has its faces, since all its hulls belong together.
    is_drawn: bool,
}

/// What a fragment is made of.
#[derive(Default)]
struct Part {
    hulls: Vec<u32>,
    faces: Vec<Face>,
    colliders: Vec<ConvexHull>,
}

/// The mesh with vertices at one place as one, and with what closes its openings.
fn prepare(mesh: MeshView<'_>, control: &Control) -> Result<(Cutter, Vec<Face>), Error> {
    mesh.check_indices()?;
    let mut points: Vec<Vector> = mesh.points().collect();
    let face =
        |(at, corners): (u32, &[u32; 3])| Face { corners: *corners, origin: Origin::Source(at) };
    let mut faces: Vec<Face> = (0..).zip(mesh.triangles()).map(face).collect();
    let (cutter, welded) = Cutter::new(points.clone(), &faces, control)?;
    if cutter.is_closed {
        return Ok((cutter, welded));
    }
    let caps = caps(mesh, control)?;
    if caps.is_empty() {
        return Ok((cutter, welded));
    }
    for cap in caps {
        let first = points.len() as u32;
        points.extend(cap);
        faces.push(Face { corners: [first, first + 1, first + 2], origin: Origin::Opening });
    }
    Cutter::new(points, &faces, control)
}

/// What closes the openings of a mesh that has some, where [`decompose`](crate::decompose()) takes
/// it for solid: so cuts go through the solid, and not through its surface alone.
fn caps(mesh: MeshView<'_>, control: &Control) -> Result<Vec<[Vector; 3]>, Error> {
    let closed = close_openings(mesh, &Parameters::default(), control)?;
    let surface = closed.mesh.triangles.len().saturating_sub(closed.caps);
    let (surface, outer) = closed.mesh.triangles.split_at(surface);
    // Those within the solid, where one part is stuck into another.
    let sorted = |triangle: &[u32; 3]| {
        let mut corners = *triangle;
        corners.sort_unstable();
        corners
    };
    let known: HashSet<[u32; 3]> = surface.iter().chain(outer).map(sorted).collect();
    let inner = closed.solid.iter().filter(|triangle| !known.contains(&sorted(triangle)));
    let corners = |triangle: &[u32; 3]| {
        triangle.map(|corner| Vector::from(closed.mesh.positions[corner as usize]))
    };
    Ok(outer.iter().chain(inner).map(corners).collect())
}

/// Whether each edge has as many faces on the one side as on the other.
fn is_closed(faces: &[Face]) -> bool {
    let mut counts: HashMap<[u32; 2], i32> = HashMap::new();
    for &Face { corners: [a, b, c], .. } in faces {
        for [a, b] in [[a, b], [b, c], [c, a]] {
            *counts.entry([a.min(b), a.max(b)]).or_default() += if a < b { 1 } else { -1 };
        }
    }
    counts.values().all(|&count| count == 0)
}

impl Cutter {
    /// Faces over points, with points at one place as one.
    fn new(
        points: Vec<Vector>,
        faces: &[Face],
        control: &Control,
    ) -> Result<(Self, Vec<Face>), Error> {
        let (min, max) = bounds(points.iter().copied().filter(|point| point.is_finite()));
        let diagonal = min.distance(max);
        let scale = if diagonal > 0.0 && diagonal.is_finite() { diagonal.recip() } else { 1.0 };
        let middle = (min + max) / 2.0;
        let normalised: Vec<Vector> =
            points.iter().map(|&point| (point - middle) * scale).collect();
        let welded = weld(&normalised, control)?;
        let mut own = Vec::with_capacity(faces.len());
        for &Face { corners, origin } in faces {
            let corners = corners.map(|corner| welded[corner as usize]);
            let [a, b, c] = corners;
            let is_finite = corners.iter().all(|&corner| points[corner as usize].is_finite());
            if is_finite && a != b && b != c && c != a {
                own.push(Face { corners, origin });
            }
        }
        let faces = own;
        let corners: Vec<[u32; 3]> = faces.iter().map(|face| face.corners).collect();
        let mut components = vec![0; points.len()];
        let half_edges = SortedHalfEdges::new(&corners, points.len());
        let connectivity = Connectivity::of(&corners, &half_edges);
        for (corners, component) in corners.iter().zip(connectivity.components) {
            corners.iter().for_each(|&corner| components[corner as usize] = component);
        }
        let volume =
            six_volumes(corners.iter().map(|of| of.map(|corner| normalised[corner as usize])));
        let (tolerance, thinnest) = (IN_PLANE * diagonal, MINIMUM_THICKNESS * diagonal);
        let is_inside_out = volume < 0.0;

        let is_closed = is_closed(&faces);
        let cutter = Self {
            points,
            components,
            welded,
            tolerance,
            thinnest,
            is_inside_out,
            is_closed,
            cuts: 0,
        };
        Ok((cutter, faces))
    }

    /// How far faces reach below and above a plane.
    fn reach(&self, faces: &[Face], plane: &Plane) -> (f64, f64) {
        let heights = faces.iter().flat_map(|face| self.corners(face)).map(|at| plane.height(at));
        heights.fold((0.0, 0.0), |(low, high), height| (height.min(low), height.max(high)))
    }

    /// The hull of what is in a cell; `None` where that is no more than a spot.
    fn collider(&self, faces: &[Face], control: &Control) -> Result<Option<ConvexHull>, Error> {
        let mut vertices: Vec<u32> = faces.iter().flat_map(|face| face.corners).collect();
        vertices.sort_unstable();
        vertices.dedup();
        let points: Vec<Vector> =
            vertices.iter().map(|&vertex| self.points[vertex as usize]).collect();
        let mut builder = HullBuilder::new();
        let Ok((hull, _)) = solid_hull(&mut builder, as_arrays(&points), [0.0; 3], 0.0) else {
            return Ok(None);
        };
        // Of points of the hull, so that it does not leave the cell.
        let fewer = match hull.points.len() {
            ..=MOST_COLLIDER_VERTICES => None,
            _ => most_prominent(&mut builder, hull.points(), MOST_COLLIDER_VERTICES, control)?,
        };
        let mut hull = fewer.unwrap_or(hull);
        let centre = mean(hull.points());
        for point in &mut hull.points {
            *point = (centre + (Vector::from(*point) - centre) * SIZE).to_array();
        }
        Ok(Some(hull))
    }

    fn fragment(&self, mesh: MeshView<'_>, group: u32, part: Part) -> Fragment {
        let Part { mut hulls, faces, colliders } = part;
        hulls.sort_unstable();
        let mut fragment = Fragment {
            group,
            hulls,
            vertices: Vec::new(),
            triangles: Vec::new(),
            source_triangles: Vec::new(),
            cut_faces: TriangleMesh::default(),
            volume: 0.0,
            colliders,
        };
        let mut of_surface: HashMap<(u32, Option<u32>), u32> = HashMap::new();
        let mut of_cuts: HashMap<(u32, u32), u32> = HashMap::new();
        for &Face { corners, origin } in &faces {
            match origin {
                Origin::Source(triangle) => {
                    let corners = corners.map(|corner| {
                        let vertex = self.vertex(mesh, triangle, corner);
                        // What a cut made is shared within a triangle alone: its neighbours may
                        // have other normals there.
                        let key = match vertex.corners {
                            [a, b, c] if a == b && b == c => (a, None),
                            _ => (corner, Some(triangle)),
                        };
                        *of_surface.entry(key).or_insert_with(|| {
                            fragment.vertices.push(vertex);
                            fragment.vertices.len() as u32 - 1
                        })
                    });
                    fragment.triangles.push(corners);
                    fragment.source_triangles.push(triangle);
                }
                Origin::Opening => {}
                Origin::Cut(cut) => {
                    let positions = &mut fragment.cut_faces.positions;
                    let corners = corners.map(|corner| {
                        *of_cuts.entry((corner, cut)).or_insert_with(|| {
                            positions.push(self.points[corner as usize].to_array());
                            positions.len() as u32 - 1
                        })
                    });
                    fragment.cut_faces.triangles.push(corners);
                }
            }
        }
        fragment.volume = match self.is_closed {
            true => {
                let sign = if self.is_inside_out { -1.0 } else { 1.0 };
                let origin = faces.first().map_or(Vector::ZERO, |of| self.corners(of)[0]);
                let faces = faces.iter().map(|face| self.corners(face).map(|at| at - origin));
                sign * six_volumes(faces) / 6.0
            }
            false => fragment.colliders.iter().map(ConvexHull::volume).sum(),
        };
        fragment
    }

    fn corners(&self, face: &Face) -> [Vector; 3] {
        face.corners.map(|corner| self.points[corner as usize])
    }

    /// A corner of a part of a triangle.
    fn vertex(&self, mesh: MeshView<'_>, triangle: u32, corner: u32) -> FragmentVertex {
        let point = self.points[corner as usize];
        let source = mesh.triangles()[triangle as usize];
        let ends = source.map(|vertex| self.points[vertex as usize]);
        // Of vertices that are one here each keeps its own values.
        let same = (0..3).find(|&k| self.welded[source[k] as usize] == corner);
        let (corners, weights) = match same {
            Some(k) => ([source[k]; 3], [1.0, 0.0, 0.0]),
            None => (source, weights(ends, point).map(|weight| weight as f32)),
        };
        FragmentVertex { position: point.to_array(), corners, weights }
    }
}

/// The weights of a triangle's corners at a point in its plane.
fn weights([a, b, c]: [Vector; 3], point: Vector) -> [f64; 3] {
    let (ab, ac, ap) = (b - a, c - a, point - a);
    let (bb, bc, cc) = (ab.dot(ab), ab.dot(ac), ac.dot(ac));
    let (pb, pc) = (ap.dot(ab), ap.dot(ac));
    let area = bb * cc - bc * bc;
    if area <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let of_b = ((cc * pb - bc * pc) / area).clamp(0.0, 1.0);
    let of_c = ((bb * pc - bc * pb) / area).clamp(0.0, 1.0 - of_b);
    [1.0 - of_b - of_c, of_b, of_c]
}
