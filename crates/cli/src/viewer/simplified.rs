//! A page about a mesh before and after simplification: triangles, and distances point by point.

use std::collections::HashMap;

use hullwright::{
    Control, Error, MeasuredSurface, MeshView, SurfaceDistances, TriangleMesh, UpAxis,
};

use super::document::{
    self, Document, Geometry, HullEntry, MeshEntry, Scale, SetEntry, StateEntry, UncoveredEntry,
};
use super::subject::{Frame, bytes, corners, divisions, map_places, points, points_of};
use crate::{Vector, bounds, unwritable};

/// Points on either surface, unless its corners alone are more.
const MOST_SAMPLES: usize = 150_000;

/// A surface with fewer triangles, and how far it is from its source.
#[derive(Debug, Clone)]
pub struct Simplified<'a> {
    /// Stands above the figures.
    pub name: String,
    /// The surface.
    pub mesh: MeshView<'a>,
    /// Distances from the source, which is the first surface of them.
    pub distances: &'a SurfaceDistances,
    /// Distances are shown against this bound, in the mesh's units.
    pub bound: f64,
    /// Names and values that are shown with the figures.
    pub facts: Vec<(String, String)>,
    /// Which axis points up.
    pub up: UpAxis,
}

/// A page about a mesh and a surface with fewer triangles.
pub struct SimplifiedPage {
    document: Document,
    geometry: Geometry,
}

impl SimplifiedPage {
    /// Measures distances point by point, on rayon's current pool.
    ///
    /// # Errors
    /// As [`MeasuredSurface::new`].
    pub fn new(
        title: impl Into<String>,
        source: MeshView<'_>,
        simplified: Simplified<'_>,
        control: &Control,
    ) -> Result<Self, Error> {
        let Simplified { name, mesh, distances, bound, facts, up } = simplified;
        let before = MeasuredSurface::new(source, control)?;
        let after = MeasuredSurface::new(mesh, control)?;
        let corners = welded(source, &[]).0.positions.into_iter().map(Vector::from);
        let (low, high) = bounds(corners);
        let frame = Frame { centre: low * 0.5 + high * 0.5, diagonal: distances.diagonal };
        let mut geometry = Geometry::default();

        let of_source = Lattice::new(source, &distances.hidden_of_a, &after, &frame);
        let of_result = Lattice::new(mesh, &distances.hidden_of_b, &before, &frame);
        let entry = MeshEntry {
            source_vertices: source.vertex_count(),
            source_triangles: source.triangles().len(),
            caps: of_source.hidden,
            positions: geometry.push_points(of_source.places(), &frame),
            triangles: geometry.push_u32(of_source.indices()),
            divisions: geometry.push_u8(of_source.divisions.iter().copied()),
        };
        let (most, values) = bytes(&of_source.distances);
        let uncovered = UncoveredEntry {
            most,
            values: geometry.push_u8(values),
            change_joins: geometry.push_u16([]),
            change_samples: geometry.push_u32([]),
            change_values: geometry.push_u8([]),
        };
        let [to_source, from_source] = [distances.from_a_to_b, distances.from_b_to_a]
            .map(|distance| distance.at_most / frame.diagonal);
        let state = StateEntry {
            hulls: 1,
            vertices: of_result.mesh.positions.len(),
            error: to_source.max(from_source),
            protrusion: from_source,
            uncovered: to_source,
            iou: None,
        };
        let shape = HullEntry {
            vertices: of_result.mesh.positions.len(),
            triangles: of_result.mesh.triangles.len(),
            volume: 0.0,
            protrusion: from_source,
            is_verified: true,
            objects: Vec::new(),
        };
        let (protrusion_most, protrusions) = bytes(&of_result.distances);
        let set = SetEntry {
            name,
            facts,
            leaves: 1,
            is_verified: true,
            hulls: vec![shape],
            joins: Vec::new(),
            states: vec![state],
            positions: geometry.push_points(of_result.places(), &frame),
            triangles: geometry.push_u32(of_result.indices()),
            divisions: geometry.push_u8(of_result.divisions.iter().copied()),
            protrusion_most,
            protrusions: geometry.push_u8(protrusions),
            uncovered,
        };
        let scale = Scale { diagonal: frame.diagonal, bound: bound / frame.diagonal, up };
        let mut document = Document::of_mesh(title.into(), entry, &scale);
        document.show_simplified(set);
        Ok(Self { document, geometry })
    }

    /// The page as text: one file that loads nothing.
    ///
    /// # Errors
    /// [`Error::File`], without a path, if the figures can't be written as text.
    pub fn to_html(&self) -> Result<String, Error> {
        document::page(&self.document, &self.geometry).map_err(|error| unwritable("page", error))
    }
}

/// A mesh as the page draws it, and distances at points of its triangles.
struct Lattice {
    mesh: TriangleMesh,
    /// How many of the triangles, the last ones, are hidden.
    hidden: usize,
    divisions: Vec<u8>,
    /// As fractions of the diagonal; 0 on hidden triangles.
    distances: Vec<f64>,
}

impl Lattice {
    fn new(source: MeshView<'_>, hidden: &[u32], other: &MeasuredSurface, frame: &Frame) -> Self {
        let (mesh, hidden) = welded(source, hidden);
        let corners = corners(&mesh.positions, &mesh.triangles);
        let divisions = divisions(&corners, frame.diagonal, MOST_SAMPLES);
        let shown = mesh.triangles.len() - hidden;
        let of_shown = points(&corners[..shown], &divisions[..shown]);
        let mut distances =
            map_places(&of_shown, |point| other.distance(point.into()) / frame.diagonal);
        let rest: usize = divisions[shown..].iter().map(|&parts| points_of(parts)).sum();
        distances.resize(distances.len() + rest, 0.0);
        Self { mesh, hidden, divisions, distances }
    }

    fn places(&self) -> impl Iterator<Item = Vector> {
        self.mesh.positions.iter().map(|&position| position.into())
    }

    fn indices(&self) -> impl Iterator<Item = u32> {
        self.mesh.triangles.iter().flatten().copied()
    }
}

/// The finite triangles of a mesh, the hidden ones last, and how many these are. Vertices at one
/// place become one: edges of files that have a vertex for each face are no borders.
fn welded(source: MeshView<'_>, hidden: &[u32]) -> (TriangleMesh, usize) {
    let mut numbers: HashMap<[u64; 3], u32> = HashMap::new();
    let mut mesh = TriangleMesh::default();
    let place = |vertex: &u32| source.position(*vertex).filter(|p| p.iter().all(|x| x.is_finite()));
    let (mut shown, mut last) = (Vec::new(), Vec::new());
    for (index, triangle) in (0_u32..).zip(source.triangles()) {
        let [Some(a), Some(b), Some(c)] = triangle.each_ref().map(place) else { continue };
        let corners = [a, b, c].map(|position| {
            // Adding 0 makes one place of both zeros.
            *numbers.entry(position.map(|x| (x + 0.0).to_bits())).or_insert_with(|| {
                mesh.positions.push(position);
                mesh.positions.len() as u32 - 1
            })
        });
        let is_hidden = hidden.binary_search(&index).is_ok();
        if is_hidden { last.push(corners) } else { shown.push(corners) }
    }
    let count = last.len();
    mesh.triangles = shown;
    mesh.triangles.append(&mut last);
    (mesh, count)
}
