//! `.hulls`: one decomposition, written, and read without trust.

use std::path::Path;

use super::parts::{self, MeshPart, TOO_SHORT};
use crate::decomposition::{ALGORITHM_VERSION, Decomposition, Hull, HullErrors, Provenance};
use crate::hull::ConvexHull;
use crate::mass::{MassProperties, MassSource};
use crate::method::MethodReport;
use crate::part_shares::PartShare;

/// The newest version of the format of `.hulls` files that is read. A file without parts is written
/// in version 1, which older libraries read too.
pub const FORMAT_VERSION: u32 = 2;

const WITHOUT_PARTS: u32 = 1;

/// The same of `.hullscene` files, of which those without surfaces are written in version 3, and
/// those without parts, too, in version 2.
#[cfg(feature = "scene")]
pub const SCENE_FORMAT_VERSION: u32 = 4;

const MAGIC: [u8; 8] = *b"\x89HULLS\r\n";

pub(super) const SCENE_MAGIC: [u8; 8] = *b"\x89HULSC\r\n";

/// Magic number, two versions, length of the body.
pub(super) const HEADER: usize = 24;

pub(super) const CHECKSUM: usize = 4;

/// Hulls, and what a game needs of how they came about.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
pub struct HullsFile {
    /// The mesh's name; may be empty.
    pub name: String,
    /// [`ALGORITHM_VERSION`](crate::ALGORITHM_VERSION) of the library that decomposed.
    pub algorithm_version: u32,
    /// The method's name; empty where another tool made the hulls.
    pub method: String,
    /// Vertices of the mesh.
    pub source_vertices: u64,
    /// Triangles of the mesh.
    pub source_triangles: u64,
    /// Diagonal of the mesh's bounding box, in its units.
    pub diagonal: f64,
    /// The requested bound, in units; `None` if the method has none.
    pub bound: Option<f64>,
    /// What was verified against the mesh; `None` if the method verifies nothing.
    pub verified: Option<VerifiedErrors>,
    /// Mass properties of the mesh.
    pub mass_properties: Option<MassProperties>,
    /// The hulls. Which triangles of the mesh they stand for is not kept:
    /// [`source_triangles`](crate::Provenance::source_triangles) is empty.
    pub hulls: Vec<Hull>,
    /// The parts of the mesh that the hulls are made of; empty where none were given.
    pub parts: Vec<MeshPart>,
    /// For each hull its shares of the parts, of which [`part`](PartShare::part) is the index: the
    /// largest first, adding up to 1. A hull has none where the mesh's area is no number. The list
    /// is empty where there are no parts.
    pub part_shares: Vec<Vec<PartShare>>,
}

/// Distances that were verified against the mesh, in its units.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VerifiedErrors {
    /// No point of a hull's surface is farther outside the solid.
    pub protrusion_max: f64,
    /// No point of the mesh's surface is farther outside every hull.
    pub uncovered_max: f64,
}

impl VerifiedErrors {
    /// Of a protrusion and an uncovered distance.
    pub const fn new(protrusion_max: f64, uncovered_max: f64) -> Self {
        Self { protrusion_max, uncovered_max }
    }
}

/// Why a `.hulls` file can't be read or written.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum HullsFileError {
    /// The bytes don't begin as a `.hulls` file does.
    #[error("it is no .hulls file")]
    NotHulls,
    /// It holds a scene, where a single mesh is expected.
    #[error("it is a .hullscene file, which holds the meshes of a scene instead of one")]
    IsScene,
    /// The bytes don't begin as a `.hullscene` file does.
    #[error("it is no .hullscene file")]
    NotScene,
    /// It holds a single mesh, where a scene is expected.
    #[error(
        "it is a .hulls file, which holds one mesh and not what it was made from; bake the scene \
         anew, or load it as a single mesh"
    )]
    IsSingle,
    /// A newer library wrote it.
    #[error("its format has version {found}, but this library reads up to {newest}")]
    NewerVersion {
        /// The file's version.
        found: u32,
        /// The newest that can be read.
        newest: u32,
    },
    /// Its length is not the one that its header says.
    #[error("it has {found} bytes instead of {expected}")]
    WrongLength {
        /// The length by its header.
        expected: u64,
        /// The length that it has.
        found: u64,
    },
    /// Its bytes have changed since it was written.
    #[error("its checksum does not match: it is damaged")]
    Damaged,
    /// A value means nothing, though the checksum matches.
    #[error("{0}")]
    Invalid(&'static str),
    /// The file system refused.
    #[error("{path}: {reason}")]
    File {
        /// The path, as given.
        path: String,
        /// What it said.
        reason: String,
    },
    /// Something is wrong with the file at a path.
    #[error("{path}: {error}")]
    At {
        /// The path, as given.
        path: String,
        /// What is wrong.
        #[source]
        error: Box<HullsFileError>,
    },
}

impl HullsFile {
    /// What is worth keeping of a decomposition, without mass properties.
    pub fn new<R: Clone + Into<MethodReport>>(
        name: impl Into<String>,
        decomposition: &Decomposition<R>,
    ) -> Self {
        let Decomposition { hulls, run, report, .. } = decomposition;
        let report: MethodReport = report.clone().into();
        let bounded = report.bounded();
        Self {
            name: name.into(),
            algorithm_version: run.algorithm_version,
            method: report.name().into(),
            source_vertices: run.source_vertices as u64,
            source_triangles: run.source_triangles as u64,
            diagonal: run.diagonal,
            bound: bounded.map(|bounded| bounded.bound),
            verified: bounded.map(|bounded| VerifiedErrors {
                protrusion_max: bounded.protrusion_max,
                uncovered_max: bounded.uncovered_max,
            }),
            mass_properties: None,
            hulls: hulls.iter().cloned().map(without_sources).collect(),
            parts: Vec::new(),
            part_shares: Vec::new(),
        }
    }

    /// Hulls of any tool. How they were made is unknown: the algorithm's version and the mesh's
    /// counts are 0. Set the fields where you have them.
    ///
    /// ```
    /// use hullwright::hulls_format::HullsFile;
    /// use hullwright::{Hull, convex_hull};
    ///
    /// let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    /// let file = HullsFile::from_hulls("rock", vec![Hull::from(convex_hull(&points)?)]);
    /// assert_eq!((file.hulls.len(), file.method.as_str(), file.is_current()), (1, "", false));
    /// # Ok::<(), hullwright::Error>(())
    /// ```
    pub fn from_hulls(name: impl Into<String>, hulls: Vec<Hull>) -> Self {
        Self {
            name: name.into(),
            algorithm_version: 0,
            method: String::new(),
            source_vertices: 0,
            source_triangles: 0,
            diagonal: 0.0,
            bound: None,
            verified: None,
            mass_properties: None,
            hulls: hulls.into_iter().map(without_sources).collect(),
            parts: Vec::new(),
            part_shares: Vec::new(),
        }
    }

    /// The same with mass properties of the mesh.
    #[must_use]
    pub fn with_mass_properties(mut self, properties: MassProperties) -> Self {
        self.mass_properties = Some(properties);
        self
    }

    /// The same with what the hulls are made of: the parts of the mesh, and for each hull its
    /// shares of them, as [`part_shares`](crate::part_shares()) computes them. O(shares).
    ///
    /// Shares are rounded to single precision, as a file holds them. Of a single part each hull is
    /// wholly made, whatever the shares are.
    ///
    /// ```
    /// use hullwright::hulls_format::{HullsFile, MeshPart};
    /// use hullwright::{Control, Parameters, decompose, part_shares};
    ///
    /// # let mesh = hullwright::TriangleMesh::new(
    /// #     vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    /// #     vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    /// # );
    /// let parts = vec![MeshPart::new("rock", 0, "moss"), MeshPart::new("rock", 1, "granite")];
    /// let made = decompose(&mesh, &Parameters::default(), &Control::new())?;
    /// let shares = part_shares(&mesh, &[0, 1, 1, 1], &made.hulls)?;
    /// let bytes = HullsFile::new("rock", &made).with_parts(parts, shares).to_bytes()?;
    /// let of_a_hit = HullsFile::from_bytes(&bytes)?.part(0).map(|part| part.material.clone());
    /// assert_eq!(of_a_hit.as_deref(), Some("granite"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn with_parts(mut self, parts: Vec<MeshPart>, shares: Vec<Vec<PartShare>>) -> Self {
        self.part_shares = match parts.len() {
            1 => parts::of_one_part(self.hulls.len()),
            _ => parts::rounded(shares),
        };
        self.parts = parts;
        self
    }

    /// The part that most of a hull is made of; `None` where no parts were given, or `hull` is out
    /// of range.
    pub fn part(&self, hull: usize) -> Option<&MeshPart> {
        self.parts.get(self.shares(hull).first()?.part as usize)
    }

    /// The shares of a hull, the largest first; none where no parts were given, or `hull` is out of
    /// range.
    pub fn shares(&self, hull: usize) -> &[PartShare] {
        self.part_shares.get(hull).map_or(&[], Vec::as_slice)
    }

    /// Whether the library decomposes in the same way as the one that wrote the file.
    pub fn is_current(&self) -> bool {
        self.algorithm_version == ALGORITHM_VERSION
    }

    /// The bytes of the file. O(size).
    ///
    /// # Errors
    /// [`HullsFileError::Invalid`] if a hull, a text or a list has more parts than 32 bits count,
    /// or if shares are not what [`part_shares`](Self::part_shares) says.
    pub fn to_bytes(&self) -> Result<Vec<u8>, HullsFileError> {
        parts::check(self.parts.len(), &self.part_shares, self.hulls.len())
            .map_err(HullsFileError::Invalid)?;
        let version = if self.parts.is_empty() { WITHOUT_PARTS } else { FORMAT_VERSION };
        let mut bytes = begin(MAGIC, version, self.algorithm_version);
        text(&mut bytes, &self.name)?;
        text(&mut bytes, &self.method)?;
        bytes.extend(self.source_vertices.to_le_bytes());
        bytes.extend(self.source_triangles.to_le_bytes());
        number(&mut bytes, self.diagonal);
        optional(&mut bytes, self.bound);
        bytes.push(self.verified.is_some().into());
        if let Some(verified) = self.verified {
            number(&mut bytes, verified.protrusion_max);
            number(&mut bytes, verified.uncovered_max);
        }
        bytes.push(self.mass_properties.is_some().into());
        if let Some(properties) = &self.mass_properties {
            mass(&mut bytes, properties);
        }
        count(&mut bytes, self.hulls.len())?;
        for hull in &self.hulls {
            write_hull(&mut bytes, hull)?;
        }
        if !self.parts.is_empty() {
            parts::write(&mut bytes, &self.parts, &self.part_shares)
                .map_err(HullsFileError::Invalid)?;
        }
        Ok(seal(bytes))
    }

    /// Reads the bytes of a file. O(size).
    ///
    /// # Errors
    /// [`HullsFileError`] says what is wrong with them.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, HullsFileError> {
        let (versions, mut reader) = open(bytes, MAGIC, FORMAT_VERSION)?;
        let file = reader.file(versions)?;
        reader.end()?;
        Ok(file)
    }

    /// Reads a file.
    ///
    /// # Errors
    /// [`HullsFileError::File`] if it can't be read, [`HullsFileError::At`] if it does not hold
    /// what it should.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, HullsFileError> {
        read_bytes(path.as_ref(), Self::from_bytes)
    }
}

/// The same hull as a file keeps it.
pub(crate) fn without_sources(mut hull: Hull) -> Hull {
    hull.provenance.source_triangles = Vec::new();
    hull
}

impl HullsFileError {
    fn at(self, path: &Path) -> Self {
        Self::At { path: path.display().to_string(), error: Box::new(self) }
    }

    fn system(path: &Path, error: &std::io::Error) -> Self {
        Self::File { path: path.display().to_string(), reason: error.to_string() }
    }
}

/// Reads a file as `parse` reads its bytes. Errors name it.
pub(super) fn read_bytes<T>(path: &Path, parse: impl FnOnce(&[u8]) -> Read<T>) -> Read<T> {
    let bytes = std::fs::read(path).map_err(|error| HullsFileError::system(path, &error))?;
    parse(&bytes).map_err(|error| error.at(path))
}

/// A header whose length is still to be set.
pub(super) fn begin(magic: [u8; 8], format_version: u32, algorithm_version: u32) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(HEADER + CHECKSUM);
    bytes.extend(magic);
    bytes.extend(format_version.to_le_bytes());
    bytes.extend(algorithm_version.to_le_bytes());
    bytes.extend([0; 8]);
    bytes
}

/// The header's length, and the checksum.
pub(super) fn seal(mut bytes: Vec<u8>) -> Vec<u8> {
    let length = (bytes.len() - HEADER) as u64;
    bytes[HEADER - 8..HEADER].copy_from_slice(&length.to_le_bytes());
    let checksum = crc32fast::hash(&bytes);
    bytes.extend(checksum.to_le_bytes());
    bytes
}

fn write_hull(bytes: &mut Vec<u8>, hull: &Hull) -> Result<(), HullsFileError> {
    let Hull { shape, provenance, errors } = hull;
    bytes.extend(provenance.component.to_le_bytes());
    for value in [shape.volume(), errors.added_thickness, errors.simplification_growth] {
        number(bytes, value);
    }
    optional(bytes, errors.protrusion_max);
    count(bytes, shape.points.len())?;
    count(bytes, shape.triangles.len())?;
    shape.points.iter().flatten().for_each(|x| number(bytes, *x));
    bytes.extend(shape.triangles.iter().flatten().flat_map(|index| index.to_le_bytes()));
    Ok(())
}

fn mass(bytes: &mut Vec<u8>, properties: &MassProperties) {
    bytes.push(source_code(properties.source));
    number(bytes, properties.mass);
    properties.centre.iter().for_each(|x| number(bytes, *x));
    let [[xx, xy, xz], [_, yy, yz], [_, _, zz]] = properties.inertia;
    for value in [xx, yy, zz, xy, xz, yz] {
        number(bytes, value);
    }
}

/// Codes are never given to another source.
fn source_code(source: MassSource) -> u8 {
    match source {
        MassSource::Mesh => 0,
        MassSource::MeshUnion => 1,
        MassSource::HullUnion => 2,
        MassSource::ConvexHull => 3,
    }
}

pub(super) fn text(bytes: &mut Vec<u8>, text: &str) -> Result<(), HullsFileError> {
    count(bytes, text.len())?;
    bytes.extend(text.as_bytes());
    Ok(())
}

pub(super) fn count(bytes: &mut Vec<u8>, count: usize) -> Result<(), HullsFileError> {
    let count = u32::try_from(count)
        .map_err(|_| HullsFileError::Invalid("there is more of something than 32 bits count"))?;
    bytes.extend(count.to_le_bytes());
    Ok(())
}

#[cfg(feature = "scene")]
pub(super) fn numbers(bytes: &mut Vec<u8>, numbers: &[u32]) -> Result<(), HullsFileError> {
    count(bytes, numbers.len())?;
    bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
    Ok(())
}

#[cfg(feature = "scene")]
pub(super) fn points(bytes: &mut Vec<u8>, points: &[[f32; 3]]) {
    bytes.extend(points.as_flattened().iter().flat_map(|x| x.to_le_bytes()));
}

fn optional(bytes: &mut Vec<u8>, value: Option<f64>) {
    bytes.push(value.is_some().into());
    value.into_iter().for_each(|value| number(bytes, value));
}

fn number(bytes: &mut Vec<u8>, value: f64) {
    bytes.extend(value.to_le_bytes());
}

/// The bytes of a hull without points: a component, three numbers, no error, two counts.
const LEAST_HULL: usize = 4 + 3 * 8 + 1 + 2 * 4;

const POINT: usize = 3 * 8;

const TRIANGLE: usize = 3 * 4;

type Read<T> = Result<T, HullsFileError>;

/// Checks the header and the checksum. The versions of format and algorithm, and a reader of the
/// body.
pub(super) fn open(bytes: &[u8], magic: [u8; 8], newest: u32) -> Read<([u32; 2], Reader<'_>)> {
    if !bytes.starts_with(&magic) {
        let is_other = bytes.starts_with(&MAGIC) || bytes.starts_with(&SCENE_MAGIC);
        return Err(match (magic == SCENE_MAGIC, is_other) {
            (false, false) => HullsFileError::NotHulls,
            (false, true) => HullsFileError::IsScene,
            (true, false) => HullsFileError::NotScene,
            (true, true) => HullsFileError::IsSingle,
        });
    }
    let wrong_length =
        |expected| HullsFileError::WrongLength { expected, found: bytes.len() as u64 };
    if bytes.len() < HEADER + CHECKSUM {
        return Err(wrong_length((HEADER + CHECKSUM) as u64));
    }
    let mut header = Reader { rest: &bytes[magic.len()..HEADER] };
    let format = header.u32()?;
    if format > newest {
        return Err(HullsFileError::NewerVersion { found: format, newest });
    }
    valid(format > 0, "there is no version 0 of the format")?;
    let algorithm = header.u32()?;
    let expected = header.u64()?.saturating_add((HEADER + CHECKSUM) as u64);
    if expected != bytes.len() as u64 {
        return Err(wrong_length(expected));
    }
    let (content, checksum) = bytes.split_at(bytes.len() - CHECKSUM);
    if crc32fast::hash(content) != (Reader { rest: checksum }).u32()? {
        return Err(HullsFileError::Damaged);
    }
    Ok(([format, algorithm], Reader { rest: &content[HEADER..] }))
}

/// An error for a value that means nothing.
pub(super) fn valid(is_valid: bool, what: &'static str) -> Read<()> {
    if is_valid { Ok(()) } else { Err(HullsFileError::Invalid(what)) }
}

#[cfg(feature = "scene")]
pub(super) fn read_numbers(reader: &mut Reader<'_>) -> Read<Vec<u32>> {
    let numbers = reader.count(size_of::<u32>())?;
    (0..numbers).map(|_| reader.u32()).collect()
}

/// The rest of what is read.
pub(super) struct Reader<'a> {
    rest: &'a [u8],
}

impl<'a> Reader<'a> {
    /// Nothing may be left.
    pub(super) fn end(&self) -> Read<()> {
        valid(self.rest.is_empty(), "there is more after the last hull")
    }

    fn file(&mut self, [format, algorithm_version]: [u32; 2]) -> Read<HullsFile> {
        let name = self.text()?;
        let method = self.text()?;
        let source_vertices = self.u64()?;
        let source_triangles = self.u64()?;
        let diagonal = self.at_least_zero()?;
        let bound = self.optional(Self::at_least_zero)?;
        let verified = self.optional(|reader| {
            Ok(VerifiedErrors {
                protrusion_max: reader.at_least_zero()?,
                uncovered_max: reader.at_least_zero()?,
            })
        })?;
        let mass_properties = self.optional(Self::mass)?;
        let count = self.count(LEAST_HULL)?;
        let hulls = (0..count).map(|_| self.hull()).collect::<Read<_>>()?;
        let (parts, part_shares) = match format {
            WITHOUT_PARTS => (Vec::new(), Vec::new()),
            _ => parts::read(&mut self.rest, count).map_err(HullsFileError::Invalid)?,
        };
        Ok(HullsFile {
            name,
            algorithm_version,
            method,
            source_vertices,
            source_triangles,
            diagonal,
            bound,
            verified,
            mass_properties,
            hulls,
            parts,
            part_shares,
        })
    }

    fn hull(&mut self) -> Read<Hull> {
        let component = self.u32()?;
        let volume = self.at_least_zero()?;
        let added_thickness = self.at_least_zero()?;
        let simplification_growth = self.at_least_zero()?;
        let protrusion_max = self.optional(Self::at_least_zero)?;
        // Both before what they count: each is checked against all that is left.
        let points = self.count(POINT)?;
        let triangles = self.count(TRIANGLE)?;
        valid(volume != 0.0 && points >= 4 && triangles >= 4, "a hull has no volume")?;
        valid(self.rest.len() >= points * POINT + triangles * TRIANGLE, TOO_SHORT)?;
        let points = (0..points).map(|_| self.point()).collect::<Read<Vec<_>>>()?;
        let triangles = (0..triangles)
            .map(|_| Ok([self.u32()?, self.u32()?, self.u32()?]))
            .collect::<Read<Vec<_>>>()?;
        let exists = |index: &u32| (*index as usize) < points.len();
        let all_exist = triangles.as_flattened().iter().all(exists);
        valid(all_exist, "a triangle names a point that is not there")?;
        let shape = ConvexHull { points, triangles };
        // What is written is the shape's own volume, whatever the file says.
        let own = shape.volume();
        valid(own > 0.0 && own.is_finite(), "a hull has no volume")?;
        Ok(Hull {
            shape,
            provenance: Provenance { component, source_triangles: Vec::new() },
            errors: HullErrors { added_thickness, simplification_growth, protrusion_max },
        })
    }

    fn mass(&mut self) -> Read<MassProperties> {
        let source = match self.u8()? {
            0 => MassSource::Mesh,
            1 => MassSource::MeshUnion,
            2 => MassSource::HullUnion,
            3 => MassSource::ConvexHull,
            _ => return Err(HullsFileError::Invalid("it is unknown what the mass is of")),
        };
        let mass = self.at_least_zero()?;
        valid(mass != 0.0, "the mass is zero")?;
        let centre = self.point()?;
        let [[xx, yy, zz], [xy, xz, yz]] = [self.point()?, self.point()?];
        let inertia = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
        Ok(MassProperties { mass, centre, inertia, source })
    }

    pub(super) fn optional<T>(
        &mut self,
        read: impl FnOnce(&mut Self) -> Read<T>,
    ) -> Read<Option<T>> {
        match self.u8()? {
            0 => Ok(None),
            1 => read(self).map(Some),
            _ => Err(HullsFileError::Invalid("it is unknown whether a value is there")),
        }
    }

    pub(super) fn text(&mut self) -> Read<String> {
        let length = self.count(1)?;
        let text = std::str::from_utf8(self.take(length)?)
            .map_err(|_| HullsFileError::Invalid("a text is not UTF-8"))?;
        Ok(text.to_owned())
    }

    fn point(&mut self) -> Read<[f64; 3]> {
        Ok([self.finite()?, self.finite()?, self.finite()?])
    }

    /// A point in single precision.
    #[cfg(feature = "scene")]
    pub(super) fn single_point(&mut self) -> Read<[f32; 3]> {
        let mut single = || self.array().map(f32::from_le_bytes);
        let point = [single()?, single()?, single()?];
        valid(point.iter().all(|x| x.is_finite()), "a number is not finite").map(|()| point)
    }

    fn at_least_zero(&mut self) -> Read<f64> {
        let value = self.finite()?;
        valid(value >= 0.0, "a number is negative").map(|()| value)
    }

    fn finite(&mut self) -> Read<f64> {
        let value = f64::from_le_bytes(self.array()?);
        valid(value.is_finite(), "a number is not finite").map(|()| value)
    }

    /// A count of things that take at least `size` bytes each, for which there must be room.
    pub(super) fn count(&mut self, size: usize) -> Read<usize> {
        let count = self.u32()? as usize;
        valid(count <= self.rest.len() / size, TOO_SHORT).map(|()| count)
    }

    fn u8(&mut self) -> Read<u8> {
        self.array().map(u8::from_le_bytes)
    }

    pub(super) fn u32(&mut self) -> Read<u32> {
        self.array().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Read<u64> {
        self.array().map(u64::from_le_bytes)
    }

    pub(super) fn array<const N: usize>(&mut self) -> Read<[u8; N]> {
        let (array, rest) =
            self.rest.split_first_chunk().ok_or(HullsFileError::Invalid(TOO_SHORT))?;
        self.rest = rest;
        Ok(*array)
    }

    pub(super) fn take(&mut self, length: usize) -> Read<&'a [u8]> {
        let (taken, rest) =
            self.rest.split_at_checked(length).ok_or(HullsFileError::Invalid(TOO_SHORT))?;
        self.rest = rest;
        Ok(taken)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::LazyLock;

    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

    use super::*;
    use crate::control::Control;
    use crate::geometry::MeshView;
    use crate::mass::mass_properties;
    use crate::mesh::TriangleMesh;
    use crate::mesh::shapes::{cuboid, join};
    use crate::method::Method;
    use crate::surface::SurfaceParameters;

    fn bars() -> TriangleMesh {
        join(&[cuboid([0.0; 3], [3.0, 1.0, 1.0]), cuboid([5.0, 0.0, 0.0], [6.0, 2.0, 0.5])])
    }

    fn file(method: &Method) -> HullsFile {
        let TriangleMesh { positions, triangles, .. } = bars();
        let mesh = MeshView::new(&positions, &triangles);
        let decomposition = method.decompose(mesh, &Control::new()).unwrap();
        let properties = mass_properties(mesh, &decomposition.hulls, 2.0).unwrap();
        HullsFile::new("bars", &decomposition).with_mass_properties(properties)
    }

    fn full() -> HullsFile {
        static FULL: LazyLock<HullsFile> = LazyLock::new(|| file(&Method::default()));
        let mut file = FULL.clone();
        file.bound = Some(0.25);
        file.verified = Some(VerifiedErrors { protrusion_max: 0.125, uncovered_max: 0.0 });
        file
    }

    /// A hull of two parts, and one of the second part; the end of the body is about them.
    fn with_parts() -> HullsFile {
        let share = |part: u32, share: f64| PartShare { part, share };
        let parts = vec![MeshPart::new("bars", 0, "steel"), MeshPart::new("", 300, "")];
        full().with_parts(parts, vec![vec![share(1, 0.75), share(0, 0.25)], vec![share(1, 1.0)]])
    }

    /// The bytes with a checksum that matches, so that the reader goes on to the body.
    fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
        let end = bytes.len() - CHECKSUM;
        let checksum = crc32fast::hash(&bytes[..end]);
        bytes[end..].copy_from_slice(&checksum.to_le_bytes());
        bytes
    }

    fn changed(at: usize, by: &[u8]) -> Result<HullsFile, HullsFileError> {
        let mut bytes = full().to_bytes().unwrap();
        bytes[at..at + by.len()].copy_from_slice(by);
        HullsFile::from_bytes(&sealed(bytes))
    }

    #[test]
    fn what_is_written_is_read_again_exactly() {
        for file in [full(), file(&Method::default()), file(&SurfaceParameters::paper().into())] {
            assert_eq!(file.hulls.len(), 2);
            assert!(file.is_current());
            let bytes = file.to_bytes().unwrap();
            assert_eq!(HullsFile::from_bytes(&bytes), Ok(file));
        }
        let mut bare = full();
        (bare.bound, bare.verified, bare.mass_properties) = (None, None, None);
        bare.hulls.clear();
        assert_eq!(HullsFile::from_bytes(&bare.to_bytes().unwrap()), Ok(bare));
    }

    #[test]
    fn what_hulls_are_made_of_is_written_and_read_again_exactly() {
        let file = with_parts();
        let bytes = file.to_bytes().unwrap();
        assert!(bytes.starts_with(b"\x89HULLS\r\n\x02\0\0\0"));
        let before = full().to_bytes().unwrap().len() - CHECKSUM;
        let end = [
            &b"\x02\x04bars\0\x05steel\0\xAC\x02\0\x02\x01"[..],
            &0.75_f32.to_le_bytes(),
            b"\0",
            &0.25_f32.to_le_bytes(),
            b"\x01\x01",
        ];
        assert_eq!(bytes[before..bytes.len() - CHECKSUM], end.concat());
        let read = HullsFile::from_bytes(&bytes).unwrap();
        assert_eq!(read, file);
        assert_eq!(read.part(0), Some(&MeshPart::new("", 300, "")));
        assert_eq!(read.shares(0)[1], PartShare { part: 0, share: 0.25 });
        assert_eq!((read.part(2), read.shares(2)), (None, &[][..]));
        assert_eq!((full().part(0), full().shares(0)), (None, &[][..]));
    }

    #[test]
    fn shares_that_single_precision_cannot_hold_are_rounded_before_they_are_written() {
        let share = |part: u32, share: f64| PartShare { part, share };
        let parts = ["a", "b", "c"].map(|name| MeshPart::new(name, 0, "")).to_vec();
        let thirds = vec![share(2, 1.0 / 3.0), share(0, 1.0 / 3.0), share(1, 1.0 / 3.0)];
        let file = full().with_parts(parts, vec![thirds, vec![share(1, 1.0), share(0, 1e-60)]]);
        assert_eq!(file.shares(1), [share(1, 1.0)]);
        assert_eq!(HullsFile::from_bytes(&file.to_bytes().unwrap()), Ok(file));
    }

    #[test]
    fn a_single_part_costs_its_names_and_is_all_of_each_hull() {
        let file = full().with_parts(vec![MeshPart::new("bars", 0, "steel")], Vec::new());
        let whole = [PartShare { part: 0, share: 1.0 }];
        assert_eq!((file.shares(0), file.shares(1)), (&whole[..], &whole[..]));
        let bytes = file.to_bytes().unwrap();
        assert_eq!(bytes.len(), full().to_bytes().unwrap().len() + 4 + "barssteel".len());
        assert_eq!(HullsFile::from_bytes(&bytes), Ok(file));
    }

    #[test]
    fn shares_that_mean_nothing_are_neither_written_nor_read() {
        let file = with_parts();
        let refused = |change: &dyn Fn(&mut HullsFile)| {
            let mut file = file.clone();
            change(&mut file);
            file.to_bytes().unwrap_err().to_string()
        };
        assert!(refused(&|file| drop(file.part_shares.pop())).contains("one list of shares"));
        assert!(refused(&|file| file.parts.clear()).contains("one list of shares"));
        assert!(refused(&|file| file.part_shares[0][0].part = 2).contains("not there"));
        assert!(refused(&|file| file.part_shares[0].reverse()).contains("largest"));
        assert!(refused(&|file| file.part_shares[1][0].share = 0.5).contains("add up to 1"));

        let bytes = file.to_bytes().unwrap();
        let end = bytes.len() - CHECKSUM;
        let start = full().to_bytes().unwrap().len() - CHECKSUM;
        let first_hull = end - 13;
        let too_many = [0xFF, 0xFF, 0xFF, 0xFF, 0x0F];
        for (at, value, why) in [
            (end - 1, &[2][..], "a part that is not there"),
            (first_hull + 1, &[7], "a part that is not there"),
            (first_hull + 2, &f32::NAN.to_le_bytes(), "above 0 and at most 1"),
            (first_hull + 2, &f32::INFINITY.to_le_bytes(), "above 0 and at most 1"),
            (first_hull + 2, &1.5_f32.to_le_bytes(), "above 0 and at most 1"),
            (first_hull + 7, &0.0_f32.to_le_bytes(), "above 0 and at most 1"),
            (first_hull + 7, &0.251_f32.to_le_bytes(), "add up to 1"),
            (first_hull + 7, &0.9_f32.to_le_bytes(), "largest"),
            (first_hull, &too_many, "more than it holds"),
            (first_hull, &[1], "more after"),
            (start, &too_many, "more than it holds"),
            (start, &[3], "more than it holds"),
            (start, &[1], "more after"),
            (start, &[0], "more after"),
            (start + 1, &too_many, "more than it holds"),
            (start + 2, &[0xFF], "UTF-8"),
            (start, &[0xFF; 5], "more than 32 bits"),
            (start, &[0x80; 5], "more than 32 bits"),
        ] {
            let mut bytes = bytes.clone();
            bytes[at..at + value.len()].copy_from_slice(value);
            let result = HullsFile::from_bytes(&sealed(bytes));
            let is_refused =
                matches!(result, Err(HullsFileError::Invalid(what)) if what.contains(why));
            assert!(is_refused, "{why} at {at}: {result:?}");
        }
    }

    #[test]
    fn every_cut_of_what_hulls_are_made_of_is_noticed() {
        let bytes = with_parts().to_bytes().unwrap();
        let start = full().to_bytes().unwrap().len() - CHECKSUM;
        for length in start..bytes.len() - CHECKSUM {
            let mut short = [&bytes[..length], &[0; CHECKSUM]].concat();
            short[HEADER - 8..HEADER].copy_from_slice(&((length - HEADER) as u64).to_le_bytes());
            assert!(HullsFile::from_bytes(&sealed(short)).is_err(), "{length}");
        }
    }

    #[test]
    fn the_bounded_methods_promise_is_kept_with_the_hulls() {
        let file = file(&Method::default());
        assert!(file.bound.is_some_and(|bound| bound > 0.0));
        let paper = self::file(&SurfaceParameters::paper().into());
        assert_eq!((paper.bound, paper.verified), (None, None));
        assert_eq!(paper.method, "surface");
    }

    #[test]
    fn the_format_does_not_change_unnoticed() {
        let bytes = full().to_bytes().unwrap();
        let header = b"\x89HULLS\r\n\x01\0\0\0";
        assert!(bytes.starts_with(header));
        assert_eq!(&bytes[HEADER..HEADER + 8], b"\x04\0\0\0bars");
        // Names, counts, diagonal, bound, errors, mass properties, number of hulls; two boxes.
        let body =
            (4 + 4) + (4 + 7) + 16 + 8 + 9 + 17 + (2 + 10 * 8) + 4 + 2 * (45 + 8 * 24 + 12 * 12);
        assert_eq!(bytes.len(), HEADER + body + CHECKSUM);
    }

    #[test]
    fn every_cut_is_noticed() {
        let bytes = full().to_bytes().unwrap();
        for length in 0..bytes.len() {
            let error = HullsFile::from_bytes(&bytes[..length]).unwrap_err();
            let expected = if length < MAGIC.len() {
                matches!(error, HullsFileError::NotHulls)
            } else {
                matches!(error, HullsFileError::WrongLength { .. })
            };
            assert!(expected, "{length}: {error}");
            if length >= HEADER + CHECKSUM {
                // Length and checksum may be false with the rest.
                let mut short = bytes[..length].to_vec();
                let body = (length - HEADER - CHECKSUM) as u64;
                short[HEADER - 8..HEADER].copy_from_slice(&body.to_le_bytes());
                assert!(HullsFile::from_bytes(&sealed(short)).is_err(), "{length}");
            }
        }
        let mut longer = bytes;
        longer.push(0);
        assert!(matches!(HullsFile::from_bytes(&longer), Err(HullsFileError::WrongLength { .. })));
    }

    #[test]
    fn every_flipped_bit_is_noticed() {
        let bytes = full().to_bytes().unwrap();
        for bit in 0..8 * bytes.len() {
            let mut damaged = bytes.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            assert!(HullsFile::from_bytes(&damaged).is_err(), "bit {bit}");
        }
    }

    #[test]
    fn a_newer_file_is_refused_as_newer_whatever_else_it_holds() {
        let mut bytes = full().to_bytes().unwrap();
        bytes[8..12].copy_from_slice(&(FORMAT_VERSION + 1).to_le_bytes());
        bytes.truncate(60);
        let error = HullsFile::from_bytes(&bytes).unwrap_err();
        let (newest, found) = (FORMAT_VERSION, FORMAT_VERSION + 1);
        assert_eq!(error, HullsFileError::NewerVersion { found, newest });
        assert!(changed(8, &[0; 4]).is_err());
    }

    #[test]
    fn a_text_file_is_no_hulls_format() {
        for bytes in [&b""[..], b"o hull_0\nv 0 0 0\n", &[0x89]] {
            assert_eq!(HullsFile::from_bytes(bytes), Err(HullsFileError::NotHulls));
        }
    }

    #[test]
    fn false_counts_allocate_nothing() {
        let file = full();
        let hulls = HEADER + (4 + 4) + (4 + 7) + 16 + 8 + 9 + 17 + (2 + 10 * 8);
        assert_eq!(file.to_bytes().unwrap()[hulls..hulls + 4], 2_u32.to_le_bytes());
        let first_hull = hulls + 4;
        for count in [HEADER, hulls, first_hull + 37, first_hull + 41] {
            let result = changed(count, &u32::MAX.to_le_bytes());
            assert!(matches!(result, Err(HullsFileError::Invalid(_))), "{count}");
        }
    }

    #[test]
    fn numbers_and_indices_that_mean_nothing_are_refused() {
        let bytes = full().to_bytes().unwrap();
        let end = bytes.len() - CHECKSUM;
        let beyond = changed(end - 4, &8_u32.to_le_bytes());
        assert!(matches!(beyond, Err(HullsFileError::Invalid(why)) if why.contains("triangle")));
        let last_point = end - 12 * 12 - 8;
        for value in [f64::NAN, f64::INFINITY] {
            let result = changed(last_point, &value.to_le_bytes());
            assert!(matches!(result, Err(HullsFileError::Invalid(why)) if why.contains("finite")));
        }
        let volume = end - 12 * 12 - 8 * 24 - 8 - 9 - 24;
        assert!(changed(volume, &(-1.0_f64).to_le_bytes()).is_err());
        assert!(changed(volume, &0.0_f64.to_le_bytes()).is_err());
        assert!(changed(volume, &7.0_f64.to_le_bytes()).is_ok());
        assert!(changed(HEADER + 4, &[0xFF]).is_err(), "UTF-8");
    }

    #[test]
    fn files_are_read_and_errors_name_them() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("bars.hulls");
        std::fs::write(&path, full().to_bytes().unwrap()).unwrap();
        assert_eq!(HullsFile::read(&path), Ok(full()));

        std::fs::write(&path, b"not this").unwrap();
        let error = HullsFile::read(&path).unwrap_err().to_string();
        assert!(error.contains("bars.hulls") && error.contains("no .hulls file"), "{error}");
        let missing = directory.path().join("missing").join("x.hulls");
        assert!(matches!(HullsFile::read(&missing), Err(HullsFileError::File { .. })));
    }

    proptest! {
        #![proptest_config(ProptestConfig { rng_seed: RngSeed::Fixed(1), ..Default::default() })]

        #[test]
        fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
            let _ = HullsFile::from_bytes(&bytes);
            let start = full().to_bytes().unwrap()[..HEADER].to_vec();
            let mut sealed_bytes = [start, bytes.clone(), vec![0; CHECKSUM]].concat();
            sealed_bytes[HEADER - 8..HEADER].copy_from_slice(&(bytes.len() as u64).to_le_bytes());
            prop_assert!(HullsFile::from_bytes(&sealed(sealed_bytes)).is_err());
        }

        #[test]
        fn false_bytes_with_a_good_checksum_are_a_sound_file_or_an_error(
            changes in prop::collection::vec((HEADER..1000_usize, any::<u8>()), 1..8),
        ) {
            let mut bytes = with_parts().to_bytes().unwrap();
            for (at, value) in changes {
                let at = at.min(bytes.len() - CHECKSUM - 1);
                bytes[at] = value;
            }
            if let Ok(file) = HullsFile::from_bytes(&sealed(bytes)) {
                for hull in 0..file.hulls.len() {
                    prop_assert_eq!(file.part(hull).is_none(), file.shares(hull).is_empty());
                }
                for hull in &file.hulls {
                    prop_assert!(hull.shape.points.iter().flatten().all(|x| x.is_finite()));
                    let count = hull.shape.points.len() as u32;
                    prop_assert!(hull.shape.triangles.iter().flatten().all(|index| *index < count));
                }
                let again = HullsFile::from_bytes(&file.to_bytes().unwrap());
                prop_assert_eq!(again, Ok(file));
            }
        }
    }
}
