//! Writes the bytes of a `.hulls` file.

use super::{CHECKSUM, FORMAT_VERSION, HEADER, HullsFile, HullsFileError, MAGIC};
use crate::decomposition::Hull;
use crate::mass::{MassProperties, MassSource};

pub(super) fn to_bytes(file: &HullsFile) -> Result<Vec<u8>, HullsFileError> {
    let mut bytes = begin(MAGIC, file.algorithm_version);
    text(&mut bytes, &file.name)?;
    text(&mut bytes, &file.method)?;
    bytes.extend(file.source_vertices.to_le_bytes());
    bytes.extend(file.source_triangles.to_le_bytes());
    number(&mut bytes, file.diagonal);
    optional(&mut bytes, file.bound);
    bytes.push(file.verified.is_some().into());
    if let Some(verified) = file.verified {
        number(&mut bytes, verified.protrusion_max);
        number(&mut bytes, verified.uncovered_max);
    }
    bytes.push(file.mass_properties.is_some().into());
    if let Some(properties) = &file.mass_properties {
        mass(&mut bytes, properties);
    }
    count(&mut bytes, file.hulls.len())?;
    for hull in &file.hulls {
        write_hull(&mut bytes, hull)?;
    }

    Ok(seal(bytes))
}

/// A header whose length is not known yet.
pub(super) fn begin(magic: [u8; 8], algorithm_version: u32) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(HEADER + CHECKSUM);
    bytes.extend(magic);
    bytes.extend(FORMAT_VERSION.to_le_bytes());
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

fn optional(bytes: &mut Vec<u8>, value: Option<f64>) {
    bytes.push(value.is_some().into());
    value.into_iter().for_each(|value| number(bytes, value));
}

fn number(bytes: &mut Vec<u8>, value: f64) {
    bytes.extend(value.to_le_bytes());
}
