//! What a glTF file says of the hulls that `hullwright bake --into` wrote into it, and the hulls
//! read back by it.
//!
//! The hulls of a node's mesh stand below a group, a child of the node. Its extras hold a record
//! under the key `hullwright`: what a [`HullsFile`] holds besides the hulls themselves, and a
//! digest of each, by which it is noticed that an artist edited one. There are strings, numbers,
//! lists of one kind and objects only, since Blender keeps extras as custom properties, which have
//! no null and no integers of 64 bits.
//!
//! ```json
//! {"hullwright": {
//!     "hulls": ["0f63c9fb5bb9e3b8", "a7d26a2c0e1f99d4"], "mesh": "9f…",
//!     "parameters": "max_error=1%", "algorithm_version": 29, "method": "bounded",
//!     "source_vertices": 512, "source_triangles": 1020,
//!     "diagonal": 0.21, "bound": 0.0021, "protrusion_max": 0.0018, "uncovered_max": 0.002,
//!     "mass_properties": {"mass": 0.0004, "centre": [0.0, 0.05, 0.0],
//!         "inertia": [1e-6, 1e-6, 1e-6, 0.0, 0.0, 0.0], "source": "mesh"},
//!     "components": [0, 1],
//!     "parts": [{"mesh": "mug", "primitive": 0, "material": "clay"},
//!         {"mesh": "mug", "primitive": 1, "material": "steel"}],
//!     "shares": [0, 0, 1.0, 1, 1, 0.75, 1, 0, 0.25]
//! }}
//! ```
//!
//! Mass is at a density of 1, inertia xx, yy, zz, xy, xz, yz. `components` are those of the hulls,
//! if one is not 0. `shares` are threes of hull, part and share, if there are several parts.

use std::collections::{HashMap, HashSet};

use hullwright::hull::rounded_hull;
use hullwright::hulls_format::{BakedMesh, HullsFile, MeshHash, MeshPart, VerifiedErrors};
use hullwright::{
    ConvexHull, Error, Hull, MassProperties, MassSource, MeshView, Method, PartShare, TriangleMesh,
    convex_hull, mass_properties,
};
use serde_json::{Map, Value, json};

use super::values::Complaint;
use crate::hulls_extras::{RECORD, record};

/// What a file says of the hulls of a mesh that were written into it.
///
/// ```
/// use hullwright::hulls_format::{BakedMesh, HullsFile};
/// use hullwright::{Control, Parameters, decompose};
/// use hullwright_formats::conventions::{HullsRecord, WrittenHull};
///
/// # let mesh = hullwright::TriangleMesh::new(
/// #     vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
/// #     vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
/// # );
/// let parameters = Parameters::default();
/// let made = decompose(&mesh, &parameters, &Control::new())?;
/// let baked = BakedMesh::new(&mesh, parameters, HullsFile::new("rock", &made));
/// let hulls: Vec<WrittenHull> =
///     made.hulls.iter().map(|hull| WrittenHull::of(&hull.shape)).collect::<Result<_, _>>()?;
/// let extras = HullsRecord::new(&baked, &hulls).to_extras();
///
/// let record = HullsRecord::from_extras(&extras).expect("a record")?;
/// let read = record.read_back("rock", &hulls)?;
/// assert!(!read.edited);
/// assert_eq!(read.baked.hash, baked.hash);
/// assert_eq!(read.baked.hulls.verified, baked.hulls.verified);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
pub struct HullsRecord {
    /// The [digest](hull_digest) of each hull as it was written.
    pub digests: Vec<String>,
    /// The content of the mesh that the hulls are of.
    pub mesh: MeshHash,
    /// What the mesh was decomposed with.
    pub parameters: Method,
    /// All that a file of the hulls holds, but the hulls and the name.
    about: HullsFile,
    /// The component of each hull; empty where all are 0.
    components: Vec<u32>,
}

/// A hull as a file holds it, in the space of the node that shows its mesh.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct WrittenHull {
    /// Vertices. A file may hold one several times, or some that no triangle uses.
    pub points: Vec<[f32; 3]>,
    /// Triangles over `points`, wound as the file has them.
    pub triangles: Vec<[u32; 3]>,
}

/// Hulls as they are in a file.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
pub struct ReadBack {
    /// The hulls, and what is known of them: as they were baked, apart from rounding to single
    /// precision and from the errors of single hulls, in that order.
    ///
    /// Where some were edited, all are in the order in which they were given, nothing is verified
    /// of them and it is not known what they are made of; mass properties are those of their union.
    pub baked: BakedMesh,
    /// Whether a hull is another than was written, is gone, or was added.
    pub edited: bool,
    /// What is wrong with the hulls that were left out, each an [`Error::UnusableHull`] with the
    /// index that it was given with.
    pub left_out: Vec<Error>,
}

/// A digest of a hull's points, in 16 hexadecimal digits: a program that writes the file anew may
/// reorder points and triangles, and give a point to each of the faces around it. O(n log n).
///
/// ```
/// use hullwright_formats::conventions::hull_digest;
///
/// let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-0.0, 0.0, 1.0]];
/// let [a, b, c, d] = points;
/// assert_eq!(hull_digest(&points), hull_digest(&[d, b, a, c, a]));
/// assert_ne!(hull_digest(&points), hull_digest(&[a, b, c, [0.0, 0.0, 1.001]]));
/// ```
pub fn hull_digest(points: &[[f32; 3]]) -> String {
    // The negative zero is the same place.
    let mut places: Vec<[u32; 3]> = points.iter().map(|p| p.map(|x| (x + 0.0).to_bits())).collect();
    places.sort_unstable();
    places.dedup();
    let points: Vec<[f32; 3]> = places.into_iter().map(|place| place.map(f32::from_bits)).collect();
    let spots: Vec<[u32; 3]> = (0..points.len() as u32).map(|index| [index; 3]).collect();
    let mut digest = MeshHash::of(MeshView::new(&points, &spots)).to_string();
    digest.truncate(DIGITS);
    digest
}

/// So many are in a digest. It guards against edits, not against forgery.
const DIGITS: usize = 16;

impl WrittenHull {
    /// A hull as it is written: in single precision, convex and with volume as it stands. Vertices
    /// and triangles keep their order where rounding leaves them convex, so that a collider of the
    /// written hull is that of the hull.
    ///
    /// # Errors
    /// As [`ConvexHull::to_single_precision`].
    pub fn of(hull: &ConvexHull) -> Result<Self, Error> {
        let as_it_is = rounded_hull(hull, [1.0; 3]);
        let (points, triangles) = as_it_is.map_or_else(|| hull.to_single_precision(), Ok)?;
        Ok(Self { points, triangles })
    }
}

impl HullsRecord {
    /// What a file says of `hulls`, which are those of `baked` as they are written.
    pub fn new(baked: &BakedMesh, hulls: &[WrittenHull]) -> Self {
        let mut about = baked.hulls.clone();
        about.name.clear();
        if let Some(mass) = &mut about.mass_properties {
            // Its two halves may differ by rounding, and one is written.
            mass.inertia = tensor(six(mass.inertia));
        }
        let components: Vec<u32> =
            about.hulls.drain(..).map(|hull| hull.provenance.component).collect();
        let are_known = components.iter().any(|component| *component != 0);
        Self {
            digests: hulls.iter().map(|hull| hull_digest(&hull.points)).collect(),
            mesh: baked.hash,
            parameters: baked.parameters.clone(),
            about,
            components: if are_known { components } else { Vec::new() },
        }
    }

    /// Reads the extras of a node, as JSON: `None` if there is no record among them, which makes
    /// the node a group of hulls; what is wrong with one that can't be read.
    pub fn from_extras(text: &str) -> Option<Result<Self, Complaint>> {
        let read = match record(text)? {
            Value::Object(record) => Self::read(&record),
            other => Err(format!("it is {}, and an object would be read", kind(&other))),
        };
        Some(read.map_err(|reason| format!("the record \"{RECORD}\" can't be read: {reason}")))
    }

    /// The extras of a group of hulls, as JSON.
    pub fn to_extras(&self) -> String {
        json!({ RECORD: self.to_json() }).to_string()
    }

    /// [`ALGORITHM_VERSION`](hullwright::ALGORITHM_VERSION) of the library that made the hulls.
    pub fn algorithm_version(&self) -> u32 {
        self.about.algorithm_version
    }

    /// The parts of the mesh that the hulls are made of; empty where none were given.
    pub fn parts(&self) -> &[MeshPart] {
        &self.about.parts
    }

    /// Whether a library of this version makes these hulls of a mesh with this content, by these
    /// parameters.
    pub fn is_of(&self, mesh: MeshHash, parameters: &Method) -> bool {
        self.about.is_current() && self.mesh == mesh && self.parameters == *parameters
    }

    /// The hulls that a file holds, and what the record says of them; `name` is that of the mesh.
    ///
    /// Hulls that are as they were written keep their points and triangles where these are a closed
    /// convex hull once places that a file holds several times are one. Of all others the convex
    /// hull of the points is taken. O(n log n), and some milliseconds for the mass properties of
    /// hulls that were edited.
    ///
    /// # Errors
    /// [`Error::NoHulls`] if there are none, [`Error::UnusableHull`] for the first if none can be
    /// used: it has no volume, or a coordinate that is not finite.
    pub fn read_back(&self, name: &str, hulls: &[WrittenHull]) -> Result<ReadBack, Error> {
        let written = self.match_digests(hulls);
        let (mut usable, mut left_out) = (Vec::new(), Vec::new());
        for (index, (hull, written)) in hulls.iter().zip(&written).enumerate() {
            match shape(hull, written.is_some()) {
                Ok(shape) => usable.push((*written, Hull::from(shape))),
                Err(reason) => left_out.push(Error::UnusableHull { hull: index, reason }),
            }
        }
        if usable.is_empty() {
            return Err(left_out.into_iter().next().unwrap_or(Error::NoHulls));
        }
        let all_written = usable.iter().all(|(written, _)| written.is_some());
        let edited = !all_written || usable.len() != self.digests.len();
        if !edited {
            usable.sort_by_key(|(written, _)| *written);
        }
        let hulls: Vec<Hull> = usable.into_iter().map(|(_, hull)| hull).collect();
        let mut file = self.about.clone();
        file.name = name.to_owned();
        if edited {
            file.verified = None;
            file.mass_properties = mass_of(&hulls);
            file.parts.clear();
            file.part_shares.clear();
        }
        file.hulls = hulls;
        if !edited {
            for (hull, component) in file.hulls.iter_mut().zip(&self.components) {
                hull.provenance.component = *component;
            }
        }
        let baked = BakedMesh::of_hash(self.mesh, self.parameters.clone(), file);
        Ok(ReadBack { baked, edited, left_out })
    }

    /// Which of the written hulls each of these is, if any. None is taken twice.
    fn match_digests(&self, hulls: &[WrittenHull]) -> Vec<Option<usize>> {
        let mut open: HashMap<&str, Vec<usize>> = HashMap::new();
        for (index, digest) in self.digests.iter().enumerate().rev() {
            open.entry(digest).or_default().push(index);
        }
        let find = |hull: &WrittenHull| open.get_mut(hull_digest(&hull.points).as_str())?.pop();
        hulls.iter().map(find).collect()
    }

    fn to_json(&self) -> Value {
        let HullsFile { method, diagonal, bound, verified, mass_properties, .. } = &self.about;
        let HullsFile { source_vertices, source_triangles, parts, part_shares, .. } = &self.about;
        let mut json = json!({
            "hulls": self.digests,
            "mesh": self.mesh.to_string(),
            "parameters": self.parameters.to_string(),
            "algorithm_version": whole(self.about.algorithm_version.into()),
            "method": method,
            "source_vertices": whole(*source_vertices),
            "source_triangles": whole(*source_triangles),
            "diagonal": diagonal,
        });
        if let Some(bound) = bound {
            json["bound"] = json!(bound);
        }
        if let Some(verified) = verified {
            json["protrusion_max"] = json!(verified.protrusion_max);
            json["uncovered_max"] = json!(verified.uncovered_max);
        }
        if let Some(mass) = mass_properties {
            json["mass_properties"] = json!({
                "mass": mass.mass,
                "centre": mass.centre,
                "inertia": six(mass.inertia),
                "source": mass.source.name(),
            });
        }
        if !self.components.is_empty() {
            let components = self.components.iter().map(|component| whole((*component).into()));
            json["components"] = components.collect();
        }
        if !parts.is_empty() {
            let part = |MeshPart { mesh, primitive, material, .. }: &MeshPart| json!({ "mesh": mesh, "primitive": primitive, "material": material });
            json["parts"] = parts.iter().map(part).collect();
        }
        if parts.len() > 1 {
            let of_hull = |(hull, shares): (usize, &Vec<PartShare>)| {
                let three = move |share: &PartShare| {
                    [whole(hull as u64), whole(share.part.into()), json!(share.share)]
                };
                shares.iter().flat_map(three).collect::<Vec<_>>()
            };
            json["shares"] = part_shares.iter().enumerate().flat_map(of_hull).collect();
        }
        json
    }

    fn read(record: &Map<String, Value>) -> Result<Self, String> {
        let digests = digests(record)?;
        let parameters = text(record, "parameters")?;
        let mut about = HullsFile::from_hulls("", Vec::new());
        about.algorithm_version = count(record, "algorithm_version", u32::MAX.into())? as u32;
        about.method = text(record, "method")?.to_owned();
        about.source_vertices = count(record, "source_vertices", MOST)?;
        about.source_triangles = count(record, "source_triangles", MOST)?;
        about.diagonal = needed(record, "diagonal", at_least_zero)?;
        about.bound = optional(record, "bound", at_least_zero)?;
        let protrusion = optional(record, "protrusion_max", at_least_zero)?;
        let uncovered = optional(record, "uncovered_max", at_least_zero)?;
        about.verified = protrusion.zip(uncovered).map(|(p, u)| VerifiedErrors::new(p, u));
        about.mass_properties = optional(record, "mass_properties", mass)?;
        let components = optional(record, "components", indices)?.unwrap_or_default();
        if !(components.is_empty() || components.len() == digests.len()) {
            return Err("it has not one of `components` for each hull".into());
        }
        let parts = optional(record, "parts", parts)?.unwrap_or_default();
        let shares = optional(record, "shares", numbers)?.unwrap_or_default();
        let shares = match parts.len() {
            0 => vec![],
            1 => vec![vec![PartShare { part: 0, share: 1.0 }]; digests.len()],
            several => read_shares(&shares, digests.len(), several)
                .ok_or("its `shares` are none of its hulls and parts")?,
        };
        (about.parts, about.part_shares) = (parts, shares);
        let wrong = |key: &str, error: &dyn std::fmt::Display| format!("its `{key}`: {error}");
        Ok(Self {
            mesh: text(record, "mesh")?.parse().map_err(|error| wrong("mesh", &error))?,
            parameters: parameters.parse().map_err(|error| wrong("parameters", &error))?,
            digests,
            about,
            components,
        })
    }
}

/// Counts beyond this are no whole numbers in JSON.
const MOST: u64 = 1 << 53;

/// A whole number, beyond 31 bits as a floating one.
fn whole(number: u64) -> Value {
    match i32::try_from(number) {
        Ok(number) => json!(number),
        Err(_) => json!(number as f64),
    }
}

fn kind(value: &Value) -> &'static str {
    match value {
        Value::Null => "null",
        Value::Bool(_) => "true or false",
        Value::Number(_) => "a number",
        Value::String(_) => "a text",
        Value::Array(_) => "a list",
        Value::Object(_) => "an object",
    }
}

/// A value that may be missing, and must be right where it is there.
fn optional<T>(
    record: &Map<String, Value>,
    key: &str,
    read: impl FnOnce(&Value) -> Option<T>,
) -> Result<Option<T>, String> {
    let Some(value) = record.get(key) else { return Ok(None) };
    match read(value) {
        Some(value) => Ok(Some(value)),
        None => Err(format!("its `{key}` is {}, which means nothing there", shown(value))),
    }
}

fn needed<T>(
    record: &Map<String, Value>,
    key: &str,
    read: impl FnOnce(&Value) -> Option<T>,
) -> Result<T, String> {
    optional(record, key, read)?.ok_or_else(|| format!("its `{key}` is missing"))
}

/// A value in a message: what is long by its kind.
fn shown(value: &Value) -> String {
    match value {
        Value::Null | Value::Bool(_) | Value::Number(_) => format!("`{value}`"),
        other => kind(other).to_owned(),
    }
}

fn text<'a>(record: &'a Map<String, Value>, key: &str) -> Result<&'a str, String> {
    let value = record.get(key).ok_or_else(|| format!("its `{key}` is missing"))?;
    value
        .as_str()
        .ok_or_else(|| format!("its `{key}` is {}, and a text would be read", shown(value)))
}

/// A whole number. Some programs write it as `8.0`.
fn count(record: &Map<String, Value>, key: &str, most: u64) -> Result<u64, String> {
    let is_count = |x: &f64| x.fract() == 0.0 && (0.0..=most as f64).contains(x);
    needed(record, key, |value| value.as_f64().filter(is_count).map(|x| x as u64))
}

fn index(value: &Value) -> Option<u32> {
    let number = value.as_f64().filter(|x| x.fract() == 0.0)?;
    (0.0..=f64::from(u32::MAX)).contains(&number).then_some(number as u32)
}

fn indices(value: &Value) -> Option<Vec<u32>> {
    value.as_array()?.iter().map(index).collect()
}

fn numbers(value: &Value) -> Option<Vec<f64>> {
    value.as_array()?.iter().map(finite).collect()
}

fn finite(value: &Value) -> Option<f64> {
    value.as_f64().filter(|x| x.is_finite())
}

fn at_least_zero(value: &Value) -> Option<f64> {
    finite(value).filter(|x| *x >= 0.0)
}

/// A list of texts, or one text, since not every version of Blender keeps lists of texts.
fn digests(record: &Map<String, Value>) -> Result<Vec<String>, String> {
    needed(record, "hulls", |value| match value {
        Value::String(text) => Some(text.split_whitespace().map(str::to_owned).collect()),
        Value::Array(list) => {
            list.iter().map(|digest| digest.as_str().map(str::to_owned)).collect()
        }
        _ => None,
    })
}

/// The numbers of a symmetric tensor: xx, yy, zz, xy, xz, yz.
fn six([[xx, xy, xz], [_, yy, yz], [_, _, zz]]: [[f64; 3]; 3]) -> [f64; 6] {
    [xx, yy, zz, xy, xz, yz]
}

fn tensor([xx, yy, zz, xy, xz, yz]: [f64; 6]) -> [[f64; 3]; 3] {
    [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
}

fn mass(value: &Value) -> Option<MassProperties> {
    let mass = value.get("mass").and_then(finite).filter(|mass| *mass > 0.0)?;
    let centre = value.get("centre").and_then(numbers)?.try_into().ok()?;
    let inertia = tensor(value.get("inertia").and_then(numbers)?.try_into().ok()?);
    let name = value.get("source")?.as_str()?;
    let source = MassSource::ALL.iter().copied().find(|source| source.name() == name)?;
    Some(MassProperties::new(mass, centre, inertia, source))
}

fn parts(value: &Value) -> Option<Vec<MeshPart>> {
    let part = |value: &Value| {
        let text = |key: &str| value.get(key)?.as_str();
        Some(MeshPart::new(text("mesh")?, index(value.get("primitive")?)?, text("material")?))
    };
    value.as_array()?.iter().map(part).collect()
}

/// How far the sum of a hull's shares may be from 1 after each was rounded to single precision.
const ROUNDING: f64 = 1e-6;

/// For each hull its shares of parts, which begin with the largest and add up to 1, or are none.
fn read_shares(threes: &[f64], hulls: usize, parts: usize) -> Option<Vec<Vec<PartShare>>> {
    let (threes, []) = threes.as_chunks::<3>() else { return None };
    let mut shares: Vec<Vec<PartShare>> = vec![Vec::new(); hulls];
    for &[hull, part, share] in threes {
        let is_index = |x: f64, count: usize| x.fract() == 0.0 && (0.0..count as f64).contains(&x);
        let is_sound = is_index(hull, hulls) && is_index(part, parts) && share > 0.0;
        let of_hull = shares.get_mut(hull as usize).filter(|_| is_sound)?;
        of_hull.push(PartShare { part: part as u32, share });
    }
    let is_sound = |of_hull: &Vec<PartShare>| {
        let sum: f64 = of_hull.iter().map(|share| share.share).sum();
        let is_whole = match of_hull.len() {
            0 => true,
            1 => sum == 1.0,
            _ => (sum - 1.0).abs() <= ROUNDING,
        };
        is_whole && of_hull.is_sorted_by(|a, b| a.share >= b.share)
    };
    shares.iter().all(is_sound).then_some(shares)
}

/// The hull that a file holds, or why it is none. `is_written` is for one that was not edited.
fn shape(hull: &WrittenHull, is_written: bool) -> Result<ConvexHull, &'static str> {
    if !hull.points.as_flattened().iter().all(|x| x.is_finite()) {
        return Err("a coordinate is not finite");
    }
    let points: Vec<[f64; 3]> = hull.points.iter().map(|point| point.map(f64::from)).collect();
    let around = convex_hull(&points).map_err(|error| match error {
        Error::NoHull { reason } => reason,
        _ => "its points have no convex hull",
    })?;
    let volume = around.volume();
    if !(volume > 0.0 && volume.is_finite()) {
        return Err("it has no volume");
    }
    let own = is_written.then(|| own_shape(hull)).flatten();
    Ok(own.filter(|own| is_as_convex(own, &around)).unwrap_or(around))
}

/// The hull with its own triangles, if they are closed and use all of its points: each place once,
/// in the order in which the file has them.
fn own_shape(hull: &WrittenHull) -> Option<ConvexHull> {
    let (mut points, mut places) = (Vec::new(), HashMap::new());
    let mut place = |point: &[f32; 3]| {
        let point = point.map(|x| x + 0.0);
        *places.entry(point.map(f32::to_bits)).or_insert_with(|| {
            points.push(point.map(f64::from));
            points.len() as u32 - 1
        })
    };
    let index_of: Vec<u32> = hull.points.iter().map(&mut place).collect();
    let index = |vertex: u32| index_of.get(vertex as usize).copied();
    let triangle = |[a, b, c]: &[u32; 3]| Some([index(*a)?, index(*b)?, index(*c)?]);
    let triangles: Vec<[u32; 3]> = hull.triangles.iter().map(triangle).collect::<Option<_>>()?;
    let mut edges = HashSet::new();
    let edges_of = |&[a, b, c]: &[u32; 3]| [[a, b], [b, c], [c, a]];
    // Each once, and each with the one that runs the other way.
    let are_new = triangles.iter().flat_map(edges_of).all(|[a, b]| a != b && edges.insert([a, b]));
    let is_closed = are_new && edges.iter().all(|[a, b]| edges.contains(&[*b, *a]));
    let mut is_used = vec![false; points.len()];
    for vertex in triangles.iter().flatten() {
        is_used[*vertex as usize] = true;
    }
    let uses_all = is_used.iter().all(|is_used| *is_used);
    (is_closed && uses_all).then_some(ConvexHull { points, triangles })
}

/// The mean depth of dents, as a fraction of the diagonal, that rounding to single precision may
/// leave in a hull: ten times what it does leave.
const DENTS: f64 = 1e-5;

/// Whether a closed hull is that around its points, up to rounding. A dent takes volume off.
fn is_as_convex(own: &ConvexHull, around: &ConvexHull) -> bool {
    let Some(bounds) = around.bounds() else { return false };
    let size: [f64; 3] = std::array::from_fn(|axis| bounds.max[axis] - bounds.min[axis]);
    let diagonal = size.iter().map(|x| x * x).sum::<f64>().sqrt();
    let area: f64 = around.corners().map(area).sum();
    let dents = around.volume() - own.volume();
    dents.abs() <= DENTS * diagonal * area
}

fn area([a, b, c]: [[f64; 3]; 3]) -> f64 {
    let side = |to: [f64; 3]| -> [f64; 3] { std::array::from_fn(|axis| to[axis] - a[axis]) };
    let [[ux, uy, uz], [vx, vy, vz]] = [side(b), side(c)];
    let normal = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
    normal.iter().map(|x| x * x).sum::<f64>().sqrt() / 2.0
}

/// The mass properties of the union of hulls, at a density of 1; `None` where they have none.
fn mass_of(hulls: &[Hull]) -> Option<MassProperties> {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for hull in hulls {
        let first = positions.len() as u32;
        positions.extend_from_slice(&hull.shape.points);
        triangles.extend(hull.shape.triangles.iter().map(|t| t.map(|vertex| first + vertex)));
    }
    let mut mass = mass_properties(&TriangleMesh::new(positions, triangles), &[], 1.0).ok()?;
    mass.source = MassSource::HullUnion;
    Some(mass)
}

#[cfg(test)]
mod tests {
    use hullwright::{Control, Parameters};

    use super::*;

    /// A box, by its least and largest corner.
    fn cuboid(low: [f64; 3], high: [f64; 3]) -> TriangleMesh {
        let corner = |i: usize| {
            [[low[0], high[0]][i & 1], [low[1], high[1]][i >> 1 & 1], [low[2], high[2]][i >> 2]]
        };
        let quads =
            [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
        TriangleMesh::new((0..8).map(corner).collect(), triangles.collect())
    }

    /// Two boxes with a gap between them, of two materials.
    fn bars() -> BakedMesh {
        let [mut mesh, other] =
            [cuboid([0.0; 3], [3.0, 1.1, 1.0]), cuboid([5.0, 0.0, 0.0], [6.0, 2.0, 0.7])];
        mesh.positions.extend(other.positions);
        mesh.triangles.extend(other.triangles.iter().map(|t| t.map(|vertex| vertex + 8)));
        let made = hullwright::decompose(&mesh, &Parameters::default(), &Control::new()).unwrap();
        assert_eq!(made.hulls.len(), 2);
        let share = |part: u32, share: f64| PartShare { part, share };
        let parts = vec![MeshPart::new("bars", 0, "steel"), MeshPart::new("bars", 1, "")];
        let shares = vec![vec![share(1, 0.7), share(0, 0.3)], vec![share(0, 1.0)]];
        let file = HullsFile::new("bars", &made)
            .with_mass_properties(mass_properties(&mesh, &made.hulls, 1.0).unwrap())
            .with_parts(parts, shares);
        BakedMesh::new(&mesh, "max_error=1%".parse::<Method>().unwrap(), file)
    }

    fn written(baked: &BakedMesh) -> Vec<WrittenHull> {
        baked.hulls.hulls.iter().map(|hull| WrittenHull::of(&hull.shape).unwrap()).collect()
    }

    fn record_of(baked: &BakedMesh, hulls: &[WrittenHull]) -> HullsRecord {
        let extras = HullsRecord::new(baked, hulls).to_extras();
        HullsRecord::from_extras(&extras).unwrap().unwrap()
    }

    /// What is promised to come back: all but the bounds, and what is said of single hulls.
    fn kept(mut baked: BakedMesh) -> BakedMesh {
        baked.bounds = None;
        let written = written(&baked);
        for (hull, written) in baked.hulls.hulls.iter_mut().zip(written) {
            hull.shape.points = written.points.iter().map(|p| p.map(f64::from)).collect();
            hull.shape.triangles = written.triangles;
            hull.errors = Default::default();
        }
        baked
    }

    #[test]
    fn hulls_come_back_as_they_were_baked_in_whatever_order_they_are_read() {
        let baked = bars();
        let mut hulls = written(&baked);
        let record = record_of(&baked, &hulls);
        assert_eq!(record, HullsRecord::new(&baked, &hulls));
        assert!(record.is_of(baked.hash, &baked.parameters));
        assert!(!record.is_of(baked.hash, &Method::default()));
        let expected = ReadBack { baked: kept(baked.clone()), edited: false, left_out: Vec::new() };
        assert_eq!(record.read_back("bars", &hulls), Ok(expected.clone()));
        hulls.reverse();
        assert_eq!(record.read_back("bars", &hulls), Ok(expected));
        assert_eq!(record.components, [1, 0]);
    }

    #[test]
    fn a_record_holds_what_blender_keeps_and_nothing_else() {
        fn check(value: &Value) {
            match value {
                Value::Null | Value::Bool(_) => panic!("{value}"),
                Value::Number(number) if number.is_f64() => {}
                Value::Number(number) => assert!(number.as_i64().unwrap().abs() < 1 << 31),
                Value::String(_) => {}
                Value::Array(list) => {
                    list.iter().for_each(check);
                    assert!(list.windows(2).all(|two| kind(&two[0]) == kind(&two[1])), "{value}");
                    assert!(!list.iter().any(Value::is_array), "{value}");
                }
                Value::Object(object) => object.values().for_each(check),
            }
        }
        let mut baked = bars();
        baked.hulls.source_vertices = (1 << 40) + 1;
        let hulls = written(&baked);
        check(&serde_json::from_str(&HullsRecord::new(&baked, &hulls).to_extras()).unwrap());
        assert_eq!(record_of(&baked, &hulls).about.source_vertices, (1 << 40) + 1);
    }

    #[test]
    fn numbers_come_back_to_the_last_bit() {
        let mut baked = bars();
        // Numbers whose last bit a careless reader loses.
        baked.hulls.diagonal = 31.245_270_191_439_438;
        baked.hulls.bound = Some(8.41e21);
        baked.hulls.verified = Some(VerifiedErrors::new(5e-324, f64::MAX));
        let hulls = written(&baked);
        let about = record_of(&baked, &hulls).about;
        assert_eq!(about.diagonal.to_bits(), 31.245_270_191_439_438_f64.to_bits());
        assert_eq!((about.bound, about.verified), (baked.hulls.bound, baked.hulls.verified));
    }

    #[test]
    fn a_file_that_was_exported_anew_holds_the_same_hulls() {
        let baked = bars();
        let hulls = written(&baked);
        let record = record_of(&baked, &hulls);
        // Each corner of each triangle has a point of its own, as with flat normals.
        let split = |hull: &WrittenHull| {
            let corners = hull.triangles.iter().rev().flatten();
            let points: Vec<_> = corners.map(|vertex| hull.points[*vertex as usize]).collect();
            let triangles = (0..points.len() as u32 / 3).map(|t| [3 * t + 1, 3 * t + 2, 3 * t]);
            WrittenHull { triangles: triangles.collect(), points }
        };
        let exported: Vec<WrittenHull> = hulls.iter().map(split).collect();
        let read = record.read_back("bars", &exported).unwrap();
        assert!(!read.edited);
        for (hull, written) in read.baked.hulls.hulls.iter().zip(&hulls) {
            assert_eq!(hull.shape.points.len(), written.points.len());
            assert_eq!(hull.shape.triangles.len(), written.triangles.len());
            let own: ConvexHull = hull.shape.clone();
            assert!((own.volume() - convex_hull(&own.points).unwrap().volume()).abs() < 1e-9);
        }
    }

    #[test]
    fn triangles_that_are_no_closed_hull_are_replaced_by_the_hull_of_the_points() {
        let baked = bars();
        let hulls = written(&baked);
        let record = record_of(&baked, &hulls);
        let whole = record.read_back("bars", &hulls).unwrap();
        let volume = whole.baked.hulls.hulls[0].shape.volume();
        let damages: [fn(&mut WrittenHull); 6] = [
            |hull| hull.triangles.truncate(11),
            |hull| hull.triangles[0] = [7, 8, 9],
            |hull| hull.triangles[0].swap(0, 1),
            |hull| hull.triangles.iter_mut().for_each(|triangle| triangle.swap(0, 1)),
            |hull| hull.triangles.push(hull.triangles[0]),
            |hull| hull.triangles.clear(),
        ];
        for damage in damages {
            let mut hulls = hulls.clone();
            damage(&mut hulls[0]);
            let read = record.read_back("bars", &hulls).unwrap();
            let shape = &read.baked.hulls.hulls[0].shape;
            assert!(!read.edited && read.left_out.is_empty());
            assert!((shape.volume() - volume).abs() < 1e-9 && shape.points.len() == 8);
            assert_eq!(read.baked.hulls.mass_properties, baked.hulls.mass_properties);
        }
    }

    #[test]
    fn an_edited_added_or_deleted_hull_is_noticed_and_what_was_verified_is_dropped() {
        let baked = bars();
        let hulls = written(&baked);
        let record = record_of(&baked, &hulls);
        let mut moved = hulls.clone();
        moved[1].points.iter_mut().for_each(|point| point[2] *= 2.0);
        let added = [&hulls[..], &hulls[..1]].concat();
        for (edited, count, volume) in
            [(moved, 2, 1.4 + 6.6), (hulls[..1].to_vec(), 1, 1.4), (added, 3, 1.4 + 3.3)]
        {
            let read = record.read_back("bars", &edited).unwrap();
            assert!(read.edited);
            let HullsFile { hulls, verified, parts, part_shares, mass_properties, .. } =
                &read.baked.hulls;
            assert_eq!((hulls.len(), *verified), (count, None));
            assert!(parts.is_empty() && part_shares.is_empty());
            // An overlap counts once.
            let mass = mass_properties.unwrap();
            assert!((mass.mass / volume - 1.0).abs() < 0.01, "{mass:?}");
            assert_eq!(mass.source, MassSource::HullUnion);
            assert!(read.baked.hulls.to_bytes().is_ok());
        }
    }

    #[test]
    fn a_hull_that_cannot_be_used_is_named_and_the_others_stay() {
        let baked = bars();
        let hulls = written(&baked);
        let record = record_of(&baked, &hulls);
        let flat = WrittenHull {
            points: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2]],
        };
        let mut infinite = hulls[0].clone();
        infinite.points[3][1] = f32::INFINITY;
        for (wrong, why) in [(flat, "plane"), (infinite, "finite"), (WrittenHull::default(), "")] {
            let read = record.read_back("bars", &[wrong.clone(), hulls[1].clone()]).unwrap();
            assert!(read.edited);
            assert_eq!(read.baked.hulls.hulls.len(), 1);
            assert!(matches!(
                read.left_out[..],
                [Error::UnusableHull { hull: 0, reason }] if reason.contains(why)
            ));
            let error = record.read_back("bars", &[wrong]).unwrap_err();
            assert!(matches!(error, Error::UnusableHull { hull: 0, .. }));
        }
        assert_eq!(record.read_back("bars", &[]), Err(Error::NoHulls));
    }

    #[test]
    fn extras_without_a_record_are_somebody_elses() {
        for text in ["", "{}", "{", r#"{"hulls": []}"#, r#"{"a": {"hullwright": {}}}"#] {
            assert_eq!(HullsRecord::from_extras(text), None, "{text}");
        }
    }

    #[test]
    fn a_record_that_lies_is_a_complaint_that_names_the_key() {
        let baked = bars();
        let sound = HullsRecord::new(&baked, &written(&baked)).to_json();
        for (key, value) in [
            ("hulls", json!(3)),
            ("hulls", json!([1])),
            ("mesh", json!("12")),
            ("mesh", json!(12)),
            ("parameters", json!("max_error=never")),
            ("algorithm_version", json!(-1)),
            ("algorithm_version", json!(1e300)),
            ("source_vertices", json!(0.5)),
            ("diagonal", json!("1")),
            ("bound", json!(null)),
            ("protrusion_max", json!(-1)),
            ("mass_properties", json!({})),
            (
                "mass_properties",
                json!({"mass": 0, "centre": [0, 0, 0], "inertia": [0, 0, 0, 0, 0, 0], "source": "mesh"}),
            ),
            (
                "mass_properties",
                json!({"mass": 1, "centre": [0, 0], "inertia": [0, 0, 0, 0, 0, 0], "source": "mesh"}),
            ),
            ("components", json!([1])),
            ("components", json!([1, -1])),
            ("parts", json!([{}])),
            ("shares", json!([0, 0, 1.0, 1])),
            ("shares", json!([2, 0, 1.0])),
            ("shares", json!([0, 2, 1.0])),
            ("shares", json!([1e300, 0, 1.0])),
            ("shares", json!([0, 0, 0.5])),
            ("shares", json!([0, 0, 0.25, 0, 1, 0.75])),
            ("shares", json!([0, 0, -1.0, 0, 1, 2.0])),
        ] {
            let mut record = sound.clone();
            record[key] = value.clone();
            let extras = json!({ RECORD: record }).to_string();
            let complaint = HullsRecord::from_extras(&extras).unwrap().unwrap_err();
            assert!(complaint.contains(&format!("`{key}`")), "{value}: {complaint}");
        }
        for key in ["hulls", "mesh", "parameters", "method", "diagonal", "source_triangles"] {
            let mut record = sound.clone();
            record.as_object_mut().unwrap().remove(key);
            let extras = json!({ RECORD: record }).to_string();
            let complaint = HullsRecord::from_extras(&extras).unwrap().unwrap_err();
            assert!(complaint.contains(&format!("`{key}` is missing")), "{complaint}");
        }
        for odd in [r#"{"hullwright": 3}"#, r#"{"hullwright": null}"#, r#"{"hullwright": []}"#] {
            assert!(matches!(HullsRecord::from_extras(odd), Some(Err(_))), "{odd}");
        }
    }

    #[test]
    fn digests_in_one_text_are_read_too() {
        let baked = bars();
        let hulls = written(&baked);
        let mut record = HullsRecord::new(&baked, &hulls).to_json();
        record["hulls"] = json!(record_of(&baked, &hulls).digests.join(" "));
        let extras = json!({ RECORD: record }).to_string();
        let read = HullsRecord::from_extras(&extras).unwrap().unwrap();
        assert_eq!(read, HullsRecord::new(&baked, &hulls));
    }
}
