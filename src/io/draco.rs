//! `KHR_draco_mesh_compression`: primitives whose triangles and vertices are a Draco stream.
//!
//! The crate `draco-core` decodes them. Its decoder of bitstreams older than 2.2 is left out,
//! since the extension names 2.2 alone, and so are point clouds, which no primitive holds. It makes
//! room for as many triangles as a stream announces, so that these are limited by what the file's
//! size justifies.

use draco_core::{DataType, DecodeLimits, DecoderBuffer, Mesh, MeshDecoder};
use draco_core::{PointAttribute, PointIndex};
use gltf::json::accessor::ComponentType;
use gltf::json::mesh::Primitive;
use gltf::json::{Index, buffer};

use super::gltf_data::{BYTES_PER_ELEMENT, ElementLayout, Views, number};
use super::meshopt::extension_number;

pub(super) const EXTENSION: &str = "KHR_draco_mesh_compression";

/// What a primitive says of its stream.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Reference {
    /// The buffer view of the stream.
    view: u32,
    /// The attribute of the stream that holds positions.
    attribute: u32,
    /// Whether positions that are integers stand for fractions.
    is_normalized: bool,
}

impl Reference {
    /// The stream of a primitive, if the primitive is compressed.
    pub(super) fn of(primitive: &Primitive, is_normalized: bool) -> Result<Option<Self>, String> {
        let extensions = primitive.extensions.as_ref();
        let Some(found) = extensions.and_then(|extensions| extensions.others.get(EXTENSION)) else {
            return Ok(None);
        };
        let parse = || {
            let view = extension_number(found, "bufferView")?;
            let attributes = found.get("attributes").ok_or("its `attributes` are missing")?;
            let attribute = extension_number(attributes, "POSITION")?;
            let narrow =
                |number| u32::try_from(number).map_err(|_| format!("{number} is too many"));
            Ok(Self { view: narrow(view)?, attribute: narrow(attribute)?, is_normalized })
        };
        parse().map(Some).map_err(|reason: String| format!("{EXTENSION}: {reason}"))
    }
}

/// What a stream holds. Each index is below the number of positions.
pub(super) struct DracoMesh {
    pub(super) positions: Vec<[f64; 3]>,
    /// Three for each triangle.
    pub(super) indices: Vec<u32>,
}

/// Decodes a stream, if that takes no more than what is left to grow.
pub(super) fn decode(reference: Reference, views: &mut Views<'_>) -> Result<DracoMesh, String> {
    let view: Index<buffer::View> = Index::new(reference.view);
    let (stream, allowance) = views.get_with_allowance(view)?;
    let geometry = decode_stream(stream, reference, allowance).map_err(|reason| {
        format!(
            "{EXTENSION}: buffer view {view}: {reason}; if other programs read the file, \
             `npx @gltf-transform/cli copy in.glb out.glb` writes it without Draco"
        )
    })?;
    let elements = geometry.positions.len() + geometry.indices.len() / 3;
    views.spend(elements.saturating_mul(BYTES_PER_ELEMENT));
    Ok(geometry)
}

fn decode_stream(
    stream: &[u8],
    reference: Reference,
    allowance: usize,
) -> Result<DracoMesh, String> {
    let most = (allowance / BYTES_PER_ELEMENT) as u64;
    let limits = DecodeLimits::default()
        .with_max_points(most)
        .with_max_faces(most)
        .with_max_decoded_bytes(allowance as u64);
    let mut mesh = Mesh::new();
    MeshDecoder::new()
        .decode(&mut DecoderBuffer::new(stream).with_limits(limits), &mut mesh)
        .map_err(|error| format!("its stream can't be decoded: {error}"))?;
    let attribute = mesh
        .attribute_by_unique_id(reference.attribute)
        .ok_or_else(|| format!("its stream has no attribute {}", reference.attribute))?;
    let count = mesh.num_points();
    let positions = positions(attribute, count, reference.is_normalized)?;
    let indices: Vec<u32> = mesh.faces().iter().flatten().map(|point| point.0).collect();
    match indices.iter().find(|index| **index as usize >= count) {
        Some(index) => Err(format!("its index {index} is beyond its {count} vertices")),
        None => Ok(DracoMesh { positions, indices }),
    }
}

fn positions(
    attribute: &PointAttribute,
    count: usize,
    is_normalized: bool,
) -> Result<Vec<[f64; 3]>, String> {
    let component = component(attribute.data_type())?;
    let layout = ElementLayout { component, components: 3, is_normalized };
    if usize::from(attribute.num_components()) != layout.components {
        return Err(format!("its positions have {} components", attribute.num_components()));
    }
    let length = component.size() * layout.components;
    let stride = usize::try_from(attribute.byte_stride()).unwrap_or(0).max(length);
    let data = attribute.buffer().data();
    let position = |point: usize| {
        let value = attribute.mapped_index(PointIndex(point as u32)).0 as usize;
        let start = value.checked_mul(stride)?;
        let element = data.get(start..start.checked_add(length)?)?;
        Some([0, 1, 2].map(|axis| number(element, axis, layout)))
    };
    (0..count)
        .map(|point| position(point).ok_or_else(|| format!("its vertex {point} has no position")))
        .collect()
}

/// The type as glTF has it.
fn component(data: DataType) -> Result<ComponentType, String> {
    match data {
        DataType::Int8 => Ok(ComponentType::I8),
        DataType::Uint8 => Ok(ComponentType::U8),
        DataType::Int16 => Ok(ComponentType::I16),
        DataType::Uint16 => Ok(ComponentType::U16),
        DataType::Float32 => Ok(ComponentType::F32),
        _ => Err(format!("its positions are of the type {data:?}, which glTF does not have")),
    }
}
