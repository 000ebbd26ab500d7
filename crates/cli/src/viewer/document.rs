//! What the page reads, and how it is put into the page.

use std::io::Write;
use std::ops::Range;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use hullwright::UpAxis;
use hullwright::measure::FilledSurface;
use hullwright::openings::{ClosedMesh, Opening};
use hullwright_formats::Object;
use hullwright_formats::palette::{BALL, CAP, CLAY, Colour, FILLED, colour};
use serde::Serialize;

use super::subject::{Frame, Subject};
use crate::{Vector, bounds};

/// The viewer, as `npm run build` in `viewer/` makes it. The data comes before [`PLACE`].
const TEMPLATE: &str = include_str!("template.html");

/// Where in the template the data goes.
const PLACE: &str = "<!--data-->";

/// Distinguishable colours; hulls beyond them repeat them.
const COLOURS: usize = 128;

/// All that the page shows. Lengths are fractions of the diagonal unless said otherwise.
#[derive(Debug, Serialize)]
pub(super) struct Document {
    title: String,
    program: &'static str,
    /// In the mesh's units.
    diagonal: f64,
    bound: f64,
    up: &'static str,
    colours: Vec<Colour>,
    clay: Colour,
    cap: Colour,
    mesh: MeshEntry,
    /// With a probe, unless nothing is filled.
    filled: Option<FilledEntry>,
    /// Whether the one set is a surface that stands for the mesh, whose last triangles are hidden.
    is_simplified: bool,
    openings: Vec<Opening>,
    /// The names of the mesh's parts.
    names: Vec<String>,
    pub sets: Vec<SetEntry>,
    /// The triangles of each part, as the file has them.
    #[serde(skip)]
    pub objects: Vec<Range<usize>>,
}

#[derive(Debug, Serialize)]
pub(super) struct MeshEntry {
    /// As they came.
    pub source_vertices: usize,
    pub source_triangles: usize,
    /// How many of the triangles, the last ones, close openings, or are hidden.
    pub caps: usize,
    pub positions: Points,
    pub triangles: Array,
    pub divisions: Array,
}

/// What lengths are measured by, and which axis points up.
pub(super) struct Scale {
    /// In the mesh's units.
    pub diagonal: f64,
    /// As a fraction of it.
    pub bound: f64,
    pub up: UpAxis,
}

/// The surface of what a probe does not reach, and the probe.
#[derive(Debug, Serialize)]
struct FilledEntry {
    /// Of the probe, as a fraction of the diagonal.
    radius: f64,
    colour: Colour,
    ball: Colour,
    positions: Points,
    triangles: Array,
}

/// Hulls, joint hulls after them.
#[derive(Debug, Serialize)]
pub(super) struct SetEntry {
    pub name: String,
    pub facts: Vec<(String, String)>,
    /// How many of the hulls, the first ones, are no joint hulls.
    pub leaves: usize,
    /// Whether the errors of the states are verified, not sampled.
    pub is_verified: bool,
    pub hulls: Vec<HullEntry>,
    /// For each joint hull the two that it replaces.
    pub joins: Vec<[usize; 2]>,
    /// From all hulls down to one, a join each.
    pub states: Vec<StateEntry>,
    pub positions: Points,
    pub triangles: Array,
    pub divisions: Array,
    pub protrusion_most: f64,
    pub protrusions: Array,
    pub uncovered: UncoveredEntry,
}

#[derive(Debug, Serialize)]
pub(super) struct HullEntry {
    pub vertices: usize,
    pub triangles: usize,
    /// In cubed units.
    pub volume: f64,
    pub protrusion: f64,
    /// Whether the protrusion is verified, not sampled.
    pub is_verified: bool,
    /// The named parts of the mesh that it stands for.
    pub objects: Vec<usize>,
}

#[derive(Debug, Serialize)]
pub(super) struct StateEntry {
    pub hulls: usize,
    pub vertices: usize,
    pub error: f64,
    pub protrusion: f64,
    pub uncovered: f64,
    pub iou: Option<f64>,
}

#[derive(Debug, Serialize)]
pub(super) struct UncoveredEntry {
    pub most: f64,
    pub values: Array,
    pub change_joins: Array,
    pub change_samples: Array,
    pub change_values: Array,
}

impl Document {
    pub(super) fn new(title: String, subject: &Subject<'_>, geometry: &mut Geometry) -> Self {
        let ClosedMesh { mesh: surface, caps, openings, .. } = subject.mesh.closed();
        let points = surface.positions.iter().map(|&point| Vector::from(point));
        let mesh = MeshEntry {
            source_vertices: subject.source.vertex_count(),
            source_triangles: subject.source.triangles().len(),
            caps: *caps,
            positions: geometry.push_points(points, &subject.frame()),
            triangles: geometry.push_u32(surface.triangles.iter().flatten().copied()),
            divisions: geometry.push_u8(subject.divisions.iter().copied()),
        };
        let scale = Scale {
            diagonal: subject.mesh.diagonal(),
            bound: subject.bound(),
            up: subject.parameters.up_axis,
        };
        Self { openings: openings.clone(), ..Self::of_mesh(title, mesh, &scale) }
    }

    /// About a mesh alone.
    pub(super) fn of_mesh(title: String, mesh: MeshEntry, scale: &Scale) -> Self {
        Self {
            title,
            program: concat!("hullwright ", env!("CARGO_PKG_VERSION")),
            diagonal: scale.diagonal,
            bound: scale.bound,
            up: scale.up.name(),
            colours: (0..COLOURS).map(colour).collect(),
            clay: CLAY,
            cap: CAP,
            mesh,
            filled: None,
            is_simplified: false,
            openings: Vec::new(),
            names: Vec::new(),
            sets: Vec::new(),
            objects: Vec::new(),
        }
    }

    pub(super) fn show_filled(
        &mut self,
        FilledSurface { mesh, .. }: &FilledSurface,
        subject: &Subject<'_>,
        geometry: &mut Geometry,
    ) {
        let Some(radius) = subject.parameters.probe_radius else { return };
        if mesh.triangles.is_empty() {
            return;
        }
        let diagonal = subject.mesh.diagonal();
        let points = mesh.positions.iter().map(|&point| Vector::from(point));
        self.filled = Some(FilledEntry {
            radius: radius.of_diagonal(diagonal) / diagonal,
            colour: FILLED,
            ball: BALL,
            positions: geometry.push_points(points, &subject.frame()),
            triangles: geometry.push_u32(mesh.triangles.iter().flatten().copied()),
        });
    }

    /// The set stands for the mesh.
    pub(super) fn show_simplified(&mut self, set: SetEntry) {
        self.is_simplified = true;
        self.sets.push(set);
    }

    /// A single part is the whole, and is not worth a word.
    pub(super) fn name_objects(&mut self, objects: &[Object]) {
        if objects.len() > 1 {
            self.names = objects.iter().map(|object| object.name.clone()).collect();
            self.objects = objects.iter().map(|object| object.triangles.clone()).collect();
        }
    }
}

/// The page with its data.
pub(super) fn page(document: &Document, geometry: &Geometry) -> std::io::Result<String> {
    let data = harmless(&serde_json::to_string(document)?);
    let geometry = geometry.to_text()?;
    let (before, after) = TEMPLATE.split_once(PLACE).unwrap_or((TEMPLATE, ""));
    Ok(format!(
        "{before}<script type=\"application/json\" id=\"data\">{data}</script>\n\
         <script type=\"text/plain\" id=\"geometry\">{geometry}</script>{after}"
    ))
}

/// JSON in which no name can end the script element, or be taken for anything else by HTML or
/// JavaScript: all such letters only stand within strings, where an escape means the same.
fn harmless(json: &str) -> String {
    let mut text = String::with_capacity(json.len());
    for letter in json.chars() {
        match letter {
            '<' | '>' | '&' | '\u{2028}' | '\u{2029}' => {
                text.push_str(&format!("\\u{:04x}", u32::from(letter)));
            }
            _ => text.push(letter),
        }
    }
    text
}

/// Where an array begins in the bytes, and how many numbers it has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub(super) struct Array {
    pub offset: usize,
    pub count: usize,
}

/// Points as 16-bit shares of their bounding box: off by less than a hundred-thousandth of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Points {
    pub min: [f64; 3],
    pub size: [f64; 3],
    pub shares: Array,
}

/// Typed arrays have to begin at a multiple of the size of their numbers.
const ALIGNMENT: usize = 4;

/// The arrays of a page, one after the other. They are compressed and stored as text.
#[derive(Debug, Default)]
pub(super) struct Geometry {
    bytes: Vec<u8>,
}

impl Geometry {
    fn push<const N: usize>(&mut self, numbers: impl Iterator<Item = [u8; N]>) -> Array {
        self.bytes.resize(self.bytes.len().next_multiple_of(ALIGNMENT), 0);
        let offset = self.bytes.len();
        numbers.for_each(|number| self.bytes.extend(number));
        Array { offset, count: (self.bytes.len() - offset) / N }
    }

    pub(super) fn push_u8(&mut self, numbers: impl IntoIterator<Item = u8>) -> Array {
        self.push(numbers.into_iter().map(|number| [number]))
    }

    pub(super) fn push_u16(&mut self, numbers: impl IntoIterator<Item = u16>) -> Array {
        self.push(numbers.into_iter().map(u16::to_le_bytes))
    }

    pub(super) fn push_u32(&mut self, numbers: impl IntoIterator<Item = u32>) -> Array {
        self.push(numbers.into_iter().map(u32::to_le_bytes))
    }

    /// Points in units, as the page has them.
    pub(super) fn push_points(
        &mut self,
        points: impl Iterator<Item = Vector>,
        frame: &Frame,
    ) -> Points {
        let points: Vec<Vector> = points.map(|point| frame.normalized(point)).collect();
        let (mut min, max) = bounds(points.iter().copied());
        if points.is_empty() {
            min = Vector::ZERO;
        }
        let size = (max - min).max(Vector::splat(f64::MIN_POSITIVE));
        let share = |point: &Vector| {
            [0, 1, 2].map(|axis| {
                (f64::from(u16::MAX) * (point[axis] - min[axis]) / size[axis]).round() as u16
            })
        };
        let shares = self.push_u16(points.iter().flat_map(share));
        Points { min: min.to_array(), size: size.to_array(), shares }
    }

    pub(super) fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Deflated in zlib's format, in base64.
    fn to_text(&self) -> std::io::Result<String> {
        let mut encoder = ZlibEncoder::new(Vec::new(), Compression::best());
        encoder.write_all(&self.bytes)?;
        Ok(STANDARD.encode(encoder.finish()?))
    }
}
