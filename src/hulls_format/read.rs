//! Reads the bytes of a `.hulls` file, and believes nothing.

use super::{
    CHECKSUM, FORMAT_VERSION, HEADER, HullsFile, HullsFileError, MAGIC, SCENE_MAGIC, VerifiedErrors,
};
use crate::decomposition::{Hull, HullErrors, Provenance};
use crate::hull::ConvexHull;
use crate::mass::{MassProperties, MassSource};

/// The bytes of a hull without points: a component, three numbers, no error, two counts.
const LEAST_HULL: usize = 4 + 3 * 8 + 1 + 2 * 4;

const POINT: usize = 3 * 8;

const TRIANGLE: usize = 3 * 4;

type Result<T> = std::result::Result<T, HullsFileError>;

pub(super) fn from_bytes(bytes: &[u8]) -> Result<HullsFile> {
    if bytes.starts_with(&SCENE_MAGIC) {
        return Err(HullsFileError::IsScene);
    }
    let (algorithm_version, mut reader) = open(bytes, MAGIC)?;
    let file = reader.file(algorithm_version)?;
    reader.end()?;
    Ok(file)
}

/// Checks the header and the checksum. The algorithm's version, and a reader of the body.
pub(super) fn open(bytes: &[u8], magic: [u8; 8]) -> Result<(u32, Reader<'_>)> {
    if !bytes.starts_with(&magic) {
        return Err(HullsFileError::NotHulls);
    }
    let wrong_length =
        |expected| HullsFileError::WrongLength { expected, found: bytes.len() as u64 };
    if bytes.len() < HEADER + CHECKSUM {
        return Err(wrong_length((HEADER + CHECKSUM) as u64));
    }
    let mut header = Reader { rest: &bytes[magic.len()..HEADER] };
    let version = header.u32()?;
    if version > FORMAT_VERSION {
        return Err(HullsFileError::NewerVersion { found: version });
    }
    if version == 0 {
        return Err(HullsFileError::Invalid("there is no version 0 of the format"));
    }
    let algorithm_version = header.u32()?;
    let expected = header.u64()?.saturating_add((HEADER + CHECKSUM) as u64);
    if expected != bytes.len() as u64 {
        return Err(wrong_length(expected));
    }
    let (content, mut checksum) = {
        let (content, checksum) = bytes.split_at(bytes.len() - CHECKSUM);
        (content, Reader { rest: checksum })
    };
    if crc32fast::hash(content) != checksum.u32()? {
        return Err(HullsFileError::Damaged);
    }
    Ok((algorithm_version, Reader { rest: &content[HEADER..] }))
}

/// The rest of what is read.
pub(super) struct Reader<'a> {
    rest: &'a [u8],
}

impl<'a> Reader<'a> {
    /// Nothing may be left.
    pub(super) fn end(&self) -> Result<()> {
        if self.rest.is_empty() {
            Ok(())
        } else {
            Err(HullsFileError::Invalid("there is more after the last hull"))
        }
    }

    fn file(&mut self, algorithm_version: u32) -> Result<HullsFile> {
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
        let hulls = (0..count).map(|_| self.hull()).collect::<Result<_>>()?;
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
        })
    }

    fn hull(&mut self) -> Result<Hull> {
        let component = self.u32()?;
        let volume = self.at_least_zero()?;
        let added_thickness = self.at_least_zero()?;
        let simplification_growth = self.at_least_zero()?;
        let protrusion_max = self.optional(Self::at_least_zero)?;
        // Both before what they count: each is checked against all that is left.
        let points = self.count(POINT)?;
        let triangles = self.count(TRIANGLE)?;
        if volume == 0.0 || points < 4 || triangles < 4 {
            return Err(HullsFileError::Invalid("a hull has no volume"));
        }
        if self.rest.len() < points * POINT + triangles * TRIANGLE {
            return Err(TOO_SHORT);
        }
        let points = (0..points).map(|_| self.point()).collect::<Result<Vec<_>>>()?;
        let triangles = (0..triangles)
            .map(|_| Ok([self.u32()?, self.u32()?, self.u32()?]))
            .collect::<Result<Vec<_>>>()?;
        if triangles.as_flattened().iter().any(|index| *index as usize >= points.len()) {
            return Err(HullsFileError::Invalid("a triangle names a point that is not there"));
        }
        Ok(Hull {
            shape: ConvexHull { points, triangles },
            provenance: Provenance { component, source_triangles: Vec::new() },
            errors: HullErrors { added_thickness, simplification_growth, protrusion_max },
        })
    }

    fn mass(&mut self) -> Result<MassProperties> {
        let source = match self.u8()? {
            0 => MassSource::Mesh,
            1 => MassSource::MeshUnion,
            2 => MassSource::HullUnion,
            3 => MassSource::ConvexHull,
            _ => return Err(HullsFileError::Invalid("it is unknown what the mass is of")),
        };
        let mass = self.at_least_zero()?;
        if mass == 0.0 {
            return Err(HullsFileError::Invalid("the mass is zero"));
        }
        let centre = self.point()?;
        let [[xx, yy, zz], [xy, xz, yz]] = [self.point()?, self.point()?];
        let inertia = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
        Ok(MassProperties { mass, centre, inertia, source })
    }

    fn optional<T>(&mut self, read: impl FnOnce(&mut Self) -> Result<T>) -> Result<Option<T>> {
        match self.u8()? {
            0 => Ok(None),
            1 => read(self).map(Some),
            _ => Err(HullsFileError::Invalid("it is unknown whether a value is there")),
        }
    }

    pub(super) fn text(&mut self) -> Result<String> {
        let length = self.count(1)?;
        let text = std::str::from_utf8(self.take(length)?)
            .map_err(|_| HullsFileError::Invalid("a text is not UTF-8"))?;
        Ok(text.to_owned())
    }

    fn point(&mut self) -> Result<[f64; 3]> {
        Ok([self.finite()?, self.finite()?, self.finite()?])
    }

    fn at_least_zero(&mut self) -> Result<f64> {
        let value = self.finite()?;
        if value >= 0.0 { Ok(value) } else { Err(HullsFileError::Invalid("a number is negative")) }
    }

    fn finite(&mut self) -> Result<f64> {
        let value = f64::from_le_bytes(self.array()?);
        if value.is_finite() {
            Ok(value)
        } else {
            Err(HullsFileError::Invalid("a number is not finite"))
        }
    }

    /// A count of things that take at least `size` bytes each, for which there must be room.
    pub(super) fn count(&mut self, size: usize) -> Result<usize> {
        let count = self.u32()? as usize;
        if count <= self.rest.len() / size { Ok(count) } else { Err(TOO_SHORT) }
    }

    fn u8(&mut self) -> Result<u8> {
        self.array().map(u8::from_le_bytes)
    }

    fn u32(&mut self) -> Result<u32> {
        self.array().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Result<u64> {
        self.array().map(u64::from_le_bytes)
    }

    pub(super) fn array<const N: usize>(&mut self) -> Result<[u8; N]> {
        let (array, rest) = self.rest.split_first_chunk().ok_or(TOO_SHORT)?;
        self.rest = rest;
        Ok(*array)
    }

    pub(super) fn take(&mut self, length: usize) -> Result<&'a [u8]> {
        let (taken, rest) = self.rest.split_at_checked(length).ok_or(TOO_SHORT)?;
        self.rest = rest;
        Ok(taken)
    }
}

const TOO_SHORT: HullsFileError = HullsFileError::Invalid("it counts more than it holds");
