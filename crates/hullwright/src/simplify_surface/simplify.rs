//! The public function: a surface with few triangles, within a bound of another.

use std::cmp::Ordering;
use std::fmt;
use std::str::FromStr;

use super::distance::NO_GUESS;
use super::hidden::hidden;
use super::rounds::{Reduced, Repaired, Source, reduce};
use crate::control::{Control, Stage};
use crate::error::Error;
use crate::geometry::vector::{Vector, area_normal};
use crate::geometry::{MeshView, TriangleMesh};
use crate::mesh::canonical_order::{MeshOrder, rotated};
use crate::mesh::repair::{PreparedMesh, Repairs, Survey, compact, is_degenerate, prepare};
use crate::parallel;
use crate::parameters::{Field, Length, ParseError, check_positive, differing, items, parse};

/// What is taken off the bound and added to distances, as a fraction of the diagonal: more than the
/// rounding of what is measured.
pub(super) const ROUNDING: f64 = 1e-12;

/// How a surface is simplified. A [`Length`] converts into the defaults with that bound.
///
/// As text it is what differs from the defaults.
///
/// ```
/// use hullwright::{Length, SimplifyParameters};
///
/// let parameters: SimplifyParameters = "max_error=0.02m keep_hidden=true".parse()?;
/// assert_eq!(parameters, SimplifyParameters::new(Length::units(0.02)).with_keep_hidden(true));
/// assert_eq!(parameters.to_string(), "max_error=0.02m keep_hidden=true");
/// # Ok::<(), hullwright::ParseError>(())
/// ```
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SimplifyParameters {
    /// The largest distance between the two surfaces, from either to the other.
    pub max_error: Length,
    /// Whether triangles that nothing can touch stay.
    pub keep_hidden: bool,
}

impl SimplifyParameters {
    /// Within this bound. Triangles that nothing can touch go.
    pub const fn new(max_error: Length) -> Self {
        Self { max_error, keep_hidden: false }
    }

    /// Triangles that nothing can touch stay.
    #[must_use]
    pub const fn with_keep_hidden(mut self, keep_hidden: bool) -> Self {
        self.keep_hidden = keep_hidden;
        self
    }

    /// Checks the values.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] if the bound is not a positive number.
    pub fn validate(&self) -> Result<(), Error> {
        check_positive("max_error", self.max_error.value())
    }

    /// Every field as text.
    fn fields(&self) -> [Field; 2] {
        [("max_error", self.max_error.to_string()), ("keep_hidden", self.keep_hidden.to_string())]
    }
}

impl Default for SimplifyParameters {
    /// Within 0.5 % of the bounding box's diagonal.
    fn default() -> Self {
        Self::new(Length::Share(0.005))
    }
}

impl fmt::Display for SimplifyParameters {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&differing(&self.fields(), &Self::default().fields()))
    }
}

impl FromStr for SimplifyParameters {
    type Err = ParseError;

    /// Reads what [`Display`](fmt::Display) writes, on top of the defaults. The values are not
    /// checked: see [`validate`](Self::validate).
    fn from_str(text: &str) -> Result<Self, ParseError> {
        let mut parameters = Self::default();
        for item in items(text) {
            match item? {
                ("max_error", value) => parameters.max_error = value.parse()?,
                ("keep_hidden", value) => parameters.keep_hidden = parse(value, "true or false")?,
                (key, _) => return Err(ParseError::unknown_key(key, "max_error, keep_hidden")),
            }
        }
        Ok(parameters)
    }
}

impl From<Length> for SimplifyParameters {
    fn from(max_error: Length) -> Self {
        Self::new(max_error)
    }
}

/// A surface with few triangles, and how far it is from its source.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
pub struct SimplifiedSurface {
    /// The surface, in the input's units. Each vertex has the place of one of the source.
    pub mesh: TriangleMesh,
    /// For each triangle one of the source: the nearest to its centre. A material survives so.
    pub sources: Vec<u32>,
    /// The triangles of the source that nothing can touch, ascending. They are left out, and
    /// distances are measured without them.
    pub hidden: Vec<u32>,
    /// Distances and counts.
    pub report: SimplifyReport,
}

/// What [`simplify_surface`] has done. Lengths are in the input's units.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SimplifyReport {
    /// The bound. Both distances are at most this.
    pub bound: f64,
    /// How far any point of the result is from the source, as an upper bound.
    pub from_source: f64,
    /// How far any point of the source is from the result, as an upper bound.
    pub to_source: f64,
    /// Triangles given.
    pub source_triangles: usize,
    /// Vertices given.
    pub source_vertices: usize,
    /// Triangles of the result.
    pub triangles: usize,
    /// Vertices of the result.
    pub vertices: usize,
    /// Triangles left out because nothing can touch them.
    pub hidden_triangles: usize,
    /// What was left out or mended before.
    pub repairs: Repairs,
}

/// Makes a surface with few triangles that is within a bound of a mesh, closed or open, manifold or
/// not: for colliders of what never moves, and for all that needs a level's shape and not its
/// triangles.
///
/// No point of the result is farther from the mesh than the bound b, and no point of the mesh is
/// farther from the result. So sharp edges, silhouettes and openings are right within b: of a ball
/// of radius r + b that passed the mesh one of radius r passes the result, and no ball of radius
/// r + b passes the result where none of radius r passed the mesh. Distances are verified for whole
/// triangles, not for samples.
///
/// Vertices are places of the mesh's vertices. Closed components stay closed, except where
/// triangles are left out because nothing can touch them: those wholly within the solid of another
/// closed component whose triangles face outward (counter-clockwise). Where the bound is as small
/// as what repair moves, 0.0001 % of the diagonal, triangles stay as they were given. Degenerate
/// and non-finite triangles are left out and counted, as are all but one of duplicates, also of
/// those that are there both ways round. The order of triangles and vertices in the input and the
/// number of threads do not matter.
///
/// ```
/// use hullwright::{Control, Length, TriangleMesh, simplify_surface};
///
/// // A square of 32 triangles.
/// let at = |i: u32| [f64::from(i % 5), f64::from(i / 5), 0.0];
/// let positions: Vec<[f64; 3]> = (0..25).map(at).collect();
/// let corners = (0..20).filter(|i| i % 5 < 4);
/// let triangles: Vec<[u32; 3]> =
///     corners.flat_map(|i| [[i, i + 1, i + 6], [i, i + 6, i + 5]]).collect();
/// let square = TriangleMesh::new(positions, triangles);
/// let simplified = simplify_surface(&square, Length::units(0.02), &Control::new())?;
/// assert_eq!(simplified.mesh.triangles.len(), 2);
/// assert!(simplified.report.from_source <= 0.02 && simplified.report.to_source <= 0.02);
/// # Ok::<(), hullwright::Error>(())
/// ```
///
/// About O(n log n) for n triangles.
///
/// # Errors
/// [`Error::InvalidParameter`] for a bound that is not a positive number; [`Error::EmptyMesh`],
/// [`Error::TooLarge`], [`Error::IndexOutOfRange`], [`Error::SidednessCount`] and
/// [`Error::NothingUsable`] for a mesh; [`Error::Cancelled`] and [`Error::DeadlineExceeded`].
pub fn simplify_surface<'a>(
    mesh: impl Into<MeshView<'a>>,
    parameters: impl Into<SimplifyParameters>,
    control: &Control,
) -> Result<SimplifiedSurface, Error> {
    let (mesh, parameters) = (mesh.into(), parameters.into());
    parameters.validate()?;
    control.admit(mesh.triangles().len())?;
    parallel::with(control.is_parallel(), || simplify(mesh, &parameters, control))
}

fn simplify(
    mesh: MeshView<'_>,
    parameters: &SimplifyParameters,
    control: &Control,
) -> Result<SimplifiedSurface, Error> {
    control.report(Stage::Repair, 0.0);
    let prepared = prepare(mesh, MeshOrder::Place, control)?;
    let diagonal = prepared.normalization.diagonal;
    let bound = parameters.max_error.of_diagonal(diagonal);
    let is_turned = turned(mesh, &prepared);
    let is_hidden = match parameters.keep_hidden {
        true => vec![false; prepared.mesh.triangles.len()],
        false => hidden(&prepared, &is_turned, control)?,
    };
    let visible: Vec<u32> = (0..prepared.mesh.triangles.len() as u32)
        .filter(|&triangle| !is_hidden[triangle as usize])
        .collect();
    let triangles: Vec<[u32; 3]> =
        visible.iter().map(|&triangle| prepared.mesh.triangles[triangle as usize]).collect();
    let mut hidden: Vec<u32> = (0..prepared.mesh.triangles.len())
        .filter(|&triangle| is_hidden[triangle])
        .map(|triangle| prepared.source_triangles[triangle])
        .collect();
    hidden.sort_unstable();
    hidden.dedup();
    let (source, indices) = source(mesh, &prepared, &visible, &hidden);
    let repaired = Repaired { points: prepared.mesh.points(), triangles: &triangles };
    let limit = bound / diagonal - ROUNDING;
    let reduced = reduce(&source, repaired, limit, control)?;
    let is_turned = |origin: u32| is_turned[visible[origin as usize] as usize];
    let (surface, sources) = assembled(mesh, &prepared, (&source, &indices), &reduced, is_turned);
    let report = SimplifyReport {
        bound,
        from_source: (reduced.from_source + ROUNDING) * diagonal,
        to_source: (reduced.to_source + ROUNDING) * diagonal,
        source_triangles: mesh.triangles().len(),
        source_vertices: mesh.vertex_count(),
        triangles: surface.triangles.len(),
        vertices: surface.positions.len(),
        hidden_triangles: hidden.len(),
        repairs: prepared.repairs,
    };
    control.report(Stage::Simplify, 1.0);
    Ok(SimplifiedSurface { mesh: surface, sources, hidden, report })
}

/// The result with the places of the input, in an order that depends on places alone, and for each
/// triangle one of the input.
fn assembled(
    mesh: MeshView<'_>,
    prepared: &PreparedMesh,
    (source, indices): (&Source, &[u32]),
    reduced: &Reduced,
    is_turned: impl Fn(u32) -> bool,
) -> (TriangleMesh, Vec<u32>) {
    let mut triangles: Vec<([u32; 3], u32)> = Vec::new();
    let all = reduced.triangles.iter().zip(&reduced.origins).zip(&reduced.nearest);
    triangles.extend(all.map(|((&[a, b, c], &origin), &nearest)| {
        let corners = if is_turned(origin) { [b, a, c] } else { [a, b, c] };
        (corners, indices[nearest as usize])
    }));
    // Vertices of triangles that are as they were come after those of repair, by place.
    let mut positions: Vec<[f64; 3]> =
        prepared.source_vertices.iter().map(|&v| mesh.at(v).into()).collect();
    let place = |vertex: u32| -> [f64; 3] { mesh.at(vertex).into() };
    let kept = || reduced.kept.iter().map(|&index| (index, source.triangles[index as usize]));
    let places = Places::new(kept().flat_map(|(_, corners)| corners.map(place)).collect());
    let first = positions.len() as u32;
    for (index, corners) in kept() {
        let found = corners.map(|vertex| first + places.rank(place(vertex)));
        triangles.push((found, indices[index as usize]));
    }
    positions.extend(places.0);
    let mut triangles: Vec<([u32; 3], u32)> =
        triangles.into_iter().map(|(corners, index)| (rotated(corners), index)).collect();
    triangles.sort_unstable();
    let (mut corners, sources): (Vec<[u32; 3]>, Vec<u32>) = triangles.into_iter().unzip();
    let used = compact(&mut corners, positions.len());
    let positions = used.iter().map(|&vertex| positions[vertex as usize]).collect();
    (TriangleMesh::new(positions, corners), sources)
}

/// Some places, each once, in order.
struct Places(Vec<[f64; 3]>);

impl Places {
    fn new(mut places: Vec<[f64; 3]>) -> Self {
        places.sort_unstable_by(|&a, &b| compare_places(a, b));
        places.dedup_by(|a, b| compare_places(*a, *b).is_eq());
        Self(places)
    }

    /// How many are less than this one.
    fn rank(&self, place: [f64; 3]) -> u32 {
        self.0.partition_point(|&other| compare_places(other, place).is_lt()) as u32
    }
}

fn compare_places(a: [f64; 3], b: [f64; 3]) -> Ordering {
    let by_axis = |axis: usize| a[axis].total_cmp(&b[axis]);
    by_axis(0).then(by_axis(1)).then(by_axis(2))
}

/// For each repaired triangle whether repair has turned it around.
pub(super) fn turned(mesh: MeshView<'_>, prepared: &PreparedMesh) -> Vec<bool> {
    let normal = |[a, b, c]: [Vector; 3]| area_normal(a, b, c);
    let repaired = prepared.mesh.triangles.iter().map(|&t| normal(prepared.mesh.corners(t)));
    let given = prepared.source_triangles.iter().map(|&triangle| {
        let corners = mesh.triangles()[triangle as usize];
        normal(corners.map(|vertex| prepared.normalization.normalize(mesh.at(vertex))))
    });
    // Which way round one that is there both ways comes first depends on the input's order.
    let all = repaired.zip(given).zip(&prepared.is_both_ways);
    all.map(|((repaired, given), both_ways)| !both_ways && repaired.dot(given) < 0.0).collect()
}

/// The triangles that distances are measured from, and their indices in the input.
fn source(
    mesh: MeshView<'_>,
    prepared: &PreparedMesh,
    visible: &[u32],
    hidden: &[u32],
) -> (Source, Vec<u32>) {
    let mut repaired = vec![NO_GUESS; mesh.triangles().len()];
    for (index, &triangle) in (0_u32..).zip(visible) {
        repaired[prepared.source_triangles[triangle as usize] as usize] = index;
    }
    let mut indices = Survey::new(mesh).candidates;
    indices.retain(|index| hidden.binary_search(index).is_err());
    let points: Vec<Vector> =
        mesh.points().map(|point| prepared.normalization.normalize(point)).collect();
    // Without those that repair left out as degenerate, but with all that it moved by welding.
    indices.retain(|&index| !is_degenerate(&points, mesh.triangles()[index as usize]));
    // Whatever order the input has: in that of repair, others after them by place, and from the
    // least corner on.
    let place = |vertex: u32| -> [f64; 3] { mesh.at(vertex).into() };
    let least_first = |index: u32| {
        let corners = mesh.triangles()[index as usize];
        let compare = |&a: &usize, &b: &usize| compare_places(place(corners[a]), place(corners[b]));
        let least = (0..3).min_by(compare).unwrap_or_default();
        [0, 1, 2].map(|step| corners[(least + step) % 3])
    };
    let (in_order, others): (Vec<u32>, Vec<u32>) =
        indices.into_iter().partition(|&index| repaired[index as usize] != NO_GUESS);
    let of_others = others.iter().flat_map(|&index| least_first(index).map(place));
    let places = Places::new(of_others.collect());
    let by_repair = |&index: &u32| ([repaired[index as usize], 0, 0], index);
    let by_place =
        |&index: &u32| (least_first(index).map(|vertex| places.rank(place(vertex))), index);
    let mut in_order: Vec<([u32; 3], u32)> = in_order.iter().map(by_repair).collect();
    let mut others: Vec<([u32; 3], u32)> = others.iter().map(by_place).collect();
    in_order.sort_unstable();
    others.sort_unstable();
    let indices: Vec<u32> = in_order.into_iter().chain(others).map(|(_, index)| index).collect();
    let triangles = indices.iter().map(|&index| least_first(index)).collect();
    let repaired = indices.iter().map(|&index| repaired[index as usize]).collect();
    (Source { points, triangles, repaired }, indices)
}
