//! The numbers behind a glTF document: buffers (the chunk of a GLB, data URIs, files beside it), views of them,
//! decompressed where they are compressed, accessors, and Draco streams.
//!
//! The crate's own iterators panic where an accessor reaches beyond its buffer, where a stride is shorter than
//! an element, or where a type is unknown. Here each number is checked instead.
//!
//! - `EXT_meshopt_compression` and `KHR_meshopt_compression`: views that hold streams of meshoptimizer's codecs. The
//!   first has only version 0 of the vertex codec, and no filter for colours. Both are read in the same way, as the
//!   library's own decoders do.
//! - `KHR_draco_mesh_compression`: primitives whose triangles and vertices are a Draco stream, decoded by the crate
//!   `draco-core`. Its decoder of bitstreams older than 2.2 is left out, since the extension names 2.2 alone, and so
//!   are point clouds, which no primitive holds. It makes room for as many triangles as a stream announces, so that
//!   these are limited by what the file's size justifies.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::Path;

use base64::Engine;
use draco_core::{DataType, DecodeLimits, DecoderBuffer, MeshDecoder, PointAttribute, PointIndex};
use gltf::json::accessor::{
    Accessor, ComponentType, GenericComponentType, IndexComponentType, Type,
};
use gltf::json::mesh::Primitive;
use gltf::json::validation::Checked;
use gltf::json::{Buffer, Index, Root, buffer};
use meshoptimizer_rs::codec::{
    Mode, decode_filter_color, decode_filter_exp, decode_filter_oct, decode_filter_quat,
    decode_index_buffer, decode_index_sequence, decode_vertex_buffer,
};
use meshoptimizer_rs::{Error, Limits, Workspace};
use percent_encoding::percent_decode_str;
use serde_json::Value;

use super::text::quote;

/// The names of meshoptimizer's extension, before and after it was adopted by Khronos.
pub(super) const MESHOPT: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

pub(super) const DRACO: &str = "KHR_draco_mesh_compression";

/// All streams of a file together may grow to this many bytes, however short they are: a million
/// elements, since short streams of simple meshes grow most.
const GROWTH_FOR_FREE: usize = 1 << 24;

/// Streams may grow to this many bytes more for each byte that was read. No stream of
/// meshoptimizer's vertex codec of version 0 can grow more. Those of version 1 and of Draco do so
/// only where almost all of a large mesh is regular, such as a flat grid.
const GROWTH_PER_BYTE: usize = 64;

/// What a vertex, or a triangle, counts as: three numbers of four bytes, and some more, since
/// a decoder needs room to work. That of Draco takes up to 70 bytes for a triangle.
const BYTES_PER_ELEMENT: usize = 16;

/// Where the files are that a document names.
#[derive(Clone, Copy)]
pub(super) enum Beside<'a> {
    Nothing,
    Folder(&'a Path),
    /// By decoded paths, relative to the document.
    Files(&'a dyn Fn(&str) -> Option<Vec<u8>>),
}

impl<'a> From<Option<&'a Path>> for Beside<'a> {
    fn from(folder: Option<&'a Path>) -> Self {
        folder.map_or(Self::Nothing, Self::Folder)
    }
}

/// What a document refers to, loaded and decompressed when geometry first needs it, so that a missing file with
/// nothing but images in it does no harm.
pub(super) struct Data<'a> {
    root: &'a Root,
    chunk: Option<&'a [u8]>,
    beside: Beside<'a>,
    /// Bytes of the file itself, without the buffers beside it.
    file_length: usize,
    buffers: Vec<Option<Cow<'a, [u8]>>>,
    /// Views by index: accessors share them, and meshes are placed many times.
    decompressed: BTreeMap<usize, Vec<u8>>,
    /// Bytes that all streams have grown to so far.
    growth: usize,
}

impl<'a> Data<'a> {
    pub(super) fn new(
        root: &'a Root,
        chunk: Option<&'a [u8]>,
        beside: Beside<'a>,
        file_length: usize,
    ) -> Self {
        let buffers = vec![None; root.buffers.len()];
        Self { root, chunk, beside, file_length, buffers, decompressed: BTreeMap::new(), growth: 0 }
    }

    fn bytes_read(&self) -> usize {
        self.file_length + self.buffers.iter().flatten().map(|bytes| bytes.len()).sum::<usize>()
    }

    /// One for each byte that was read, and for each element that was decompressed.
    pub(super) fn elements_read(&self) -> usize {
        self.bytes_read() + self.growth / BYTES_PER_ELEMENT
    }

    /// How many bytes streams may still grow to.
    fn allowance(&self) -> usize {
        let most = self.bytes_read().saturating_mul(GROWTH_PER_BYTE);
        most.saturating_add(GROWTH_FOR_FREE).saturating_sub(self.growth)
    }

    /// The bytes of a buffer, as many as the document announces.
    fn buffer(&mut self, index: usize) -> Result<&[u8], String> {
        let missing = || format!("there is no buffer {index}");
        let Some(slot) = self.buffers.get_mut(index) else {
            return Err(missing());
        };
        let loaded = match slot {
            Some(loaded) => loaded,
            None => {
                let buffer = self.root.buffers.get(index).ok_or_else(missing)?;
                if buffer.uri.is_none() && is_placeholder(buffer) {
                    return Err(format!(
                        "buffer {index}: it is a placeholder for compressed data and holds none"
                    ));
                }
                let length = buffer.byte_length.0;
                let bytes = load(buffer.uri.as_deref(), length, self.chunk, self.beside)
                    .map_err(|reason| format!("buffer {index}: {reason}"))?;
                slot.insert(bytes)
            }
        };
        Ok(loaded)
    }

    /// A part of a buffer.
    fn slice(&mut self, index: usize, offset: usize, length: usize) -> Result<&[u8], String> {
        let buffer = self.buffer(index)?;
        let end = offset.checked_add(length);
        end.and_then(|end| buffer.get(offset..end)).ok_or_else(|| {
            format!("it reaches beyond the {} bytes of its buffer {index}", buffer.len())
        })
    }

    fn find_view(&self, index: Index<buffer::View>) -> Result<&'a buffer::View, String> {
        self.root.get(index).ok_or_else(|| format!("buffer view {index}: it does not exist"))
    }

    /// The bytes of a view.
    fn view(&mut self, index: Index<buffer::View>) -> Result<&[u8], String> {
        let view = self.find_view(index)?;
        let at_view = |reason: String| format!("buffer view {index}: {reason}");
        let length = size(view.byte_length.0).map_err(at_view)?;
        let Some(compressed) = Compressed::of(view).map_err(at_view)? else {
            let offset = size(view.byte_offset.unwrap_or_default().0).map_err(at_view)?;
            return self.slice(view.buffer.value(), offset, length).map_err(at_view);
        };
        let bytes = match self.decompressed.remove(&index.value()) {
            Some(bytes) => bytes,
            None => self.decompress(&compressed, length).map_err(at_view)?,
        };
        Ok(self.decompressed.entry(index.value()).or_insert(bytes))
    }

    fn decompress(&mut self, compressed: &Compressed, length: usize) -> Result<Vec<u8>, String> {
        let Compressed { buffer, offset, length: stream_length, .. } = *compressed;
        // The first call loads the buffer, which the allowance depends on.
        self.slice(buffer, offset, stream_length)?;
        let allowance = self.allowance();
        let stream = self.slice(buffer, offset, stream_length)?;
        let bytes = compressed.decode(stream, allowance)?;
        if bytes.len() != length {
            return Err(format!("it should have {length} bytes, but {} were made", bytes.len()));
        }
        self.growth = self.growth.saturating_add(bytes.len());
        Ok(bytes)
    }

    /// What a Draco stream holds, if decoding it takes no more than what is left to grow.
    pub(super) fn draco(&mut self, stream: DracoStream) -> Result<DracoMesh, String> {
        let view: Index<buffer::View> = Index::new(stream.view);
        // The first call loads the buffer, which the allowance depends on.
        self.view(view)?;
        let allowance = self.allowance();
        let mesh = stream.decode(self.view(view)?, allowance).map_err(|reason| {
            format!(
                "{DRACO}: buffer view {view}: {reason}; if other programs read the file, \
                 `npx @gltf-transform/cli copy in.glb out.glb` writes it without Draco"
            )
        })?;
        let elements = mesh.positions.len() + mesh.indices.len() / 3;
        self.growth = self.growth.saturating_add(elements.saturating_mul(BYTES_PER_ELEMENT));
        Ok(mesh)
    }

    /// The positions that an accessor holds: floating-point, or integers as the extension
    /// `KHR_mesh_quantization` allows.
    pub(super) fn positions(&mut self, index: Index<Accessor>) -> Result<Vec<[f64; 3]>, String> {
        let read = |data: &mut Self| {
            let (accessor, component) = data.find_accessor(index, Type::Vec3)?;
            if component == ComponentType::U32 {
                return Err("positions can't be 32-bit integers".into());
            }
            let layout =
                ElementLayout { component, components: 3, is_normalized: accessor.normalized };
            data.elements(accessor, layout, |element| {
                [0, 1, 2].map(|axis| number(element, axis, layout))
            })
        };
        read(self).map_err(at_accessor(index))
    }

    /// The vertex indices that an accessor holds.
    pub(super) fn indices(&mut self, index: Index<Accessor>) -> Result<Vec<u32>, String> {
        let read = |data: &mut Self| {
            let (accessor, component) = data.find_accessor(index, Type::Scalar)?;
            if !is_index(component) {
                return Err("indices must be unsigned integers".into());
            }
            let layout = ElementLayout { component, components: 1, is_normalized: false };
            data.elements(accessor, layout, |element| number(element, 0, layout) as u32)
        };
        read(self).map_err(at_accessor(index))
    }

    fn find_accessor(
        &self,
        index: Index<Accessor>,
        expected: Type,
    ) -> Result<(&'a Accessor, ComponentType), String> {
        let root = self.root;
        let accessor = root.get(index).ok_or("it does not exist")?;
        let Checked::Valid(GenericComponentType(component)) = accessor.component_type else {
            return Err("its component type is unknown".into());
        };
        if !matches!(accessor.type_, Checked::Valid(found) if found == expected) {
            return Err(format!("its type should be {expected:?}"));
        }
        Ok((accessor, component))
    }

    fn elements<T: Clone>(
        &mut self,
        accessor: &Accessor,
        layout: ElementLayout,
        decode: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>, String> {
        let count = size(accessor.count.0)?;
        let mut elements = match accessor.buffer_view {
            Some(view) => {
                let offset = size(accessor.byte_offset.unwrap_or_default().0)?;
                self.strided(view, offset, count, layout)?.map(&decode).collect()
            }
            // Zeros, which the file need not hold.
            None if count > self.file_length => {
                return Err(format!(
                    "it announces {count} elements, but the file has only {} bytes",
                    self.file_length
                ));
            }
            None => vec![decode(&[]); count],
        };
        if let Some(sparse) = &accessor.sparse {
            let Checked::Valid(IndexComponentType(component)) = sparse.indices.component_type
            else {
                return Err("the type of its sparse indices is unknown".into());
            };
            let index_layout = ElementLayout { component, components: 1, is_normalized: false };
            let changes = size(sparse.count.0)?;
            let offset = size(sparse.indices.byte_offset.0)?;
            let targets: Vec<usize> = self
                .strided(sparse.indices.buffer_view, offset, changes, index_layout)?
                .map(|element| number(element, 0, index_layout) as usize)
                .collect();
            let offset = size(sparse.values.byte_offset.0)?;
            let values = self.strided(sparse.values.buffer_view, offset, changes, layout)?;
            for (target, value) in targets.into_iter().zip(values.map(&decode)) {
                *elements.get_mut(target).ok_or_else(|| {
                    format!("it has {count} elements, but changes number {target}")
                })? = value;
            }
        }
        Ok(elements)
    }

    /// The bytes of `count` elements; each is at least as long as the layout says.
    fn strided(
        &mut self,
        view: Index<buffer::View>,
        offset: usize,
        count: usize,
        layout: ElementLayout,
    ) -> Result<impl Iterator<Item = &[u8]>, String> {
        let element_length = layout.component.size() * layout.components;
        let stride = match self.find_view(view)?.byte_stride.map(|stride| stride.0) {
            None | Some(0) => element_length,
            Some(stride) if stride < element_length => {
                return Err(format!(
                    "buffer view {view}: a stride of {stride} bytes is too short for elements of \
                     {element_length}"
                ));
            }
            Some(stride) => stride,
        };
        let bytes = self.view(view)?;
        let length = bytes.len();
        let needed = match count.checked_sub(1) {
            None => Some(offset),
            Some(others) => others
                .checked_mul(stride)
                .and_then(|length| length.checked_add(element_length)?.checked_add(offset)),
        };
        if needed.is_none_or(|needed| needed > length) {
            return Err(format!(
                "its {count} elements reach beyond the {length} bytes of buffer view {view}"
            ));
        }
        Ok(bytes.get(offset..).unwrap_or_default().chunks(stride).take(count))
    }
}

fn size(number: u64) -> Result<usize, String> {
    usize::try_from(number).map_err(|_| format!("{number} bytes are too many"))
}

/// Elements of one kind that lie in a buffer one after the other.
#[derive(Clone, Copy)]
struct ElementLayout {
    component: ComponentType,
    components: usize,
    is_normalized: bool,
}

fn at_accessor(index: Index<Accessor>) -> impl Fn(String) -> String {
    move |reason| format!("accessor {index}: {reason}")
}

fn is_index(component: ComponentType) -> bool {
    matches!(component, ComponentType::U8 | ComponentType::U16 | ComponentType::U32)
}

/// A component of an element. What is not there is 0, as in an accessor without a buffer view.
fn number(element: &[u8], index: usize, layout: ElementLayout) -> f64 {
    let at = index * layout.component.size();
    let bytes = element.get(at..).unwrap_or_default();
    let mut four = [0; 4];
    for (target, byte) in four.iter_mut().zip(bytes) {
        *target = *byte;
    }
    let [low, high, ..] = four;
    // Normalised integers stand for -1 to 1 or 0 to 1.
    let (value, greatest) = match layout.component {
        ComponentType::I8 => (f64::from(low as i8), f64::from(i8::MAX)),
        ComponentType::U8 => (f64::from(low), f64::from(u8::MAX)),
        ComponentType::I16 => (f64::from(i16::from_le_bytes([low, high])), f64::from(i16::MAX)),
        ComponentType::U16 => (f64::from(u16::from_le_bytes([low, high])), f64::from(u16::MAX)),
        ComponentType::U32 => (f64::from(u32::from_le_bytes(four)), f64::from(u32::MAX)),
        ComponentType::F32 => return f64::from(f32::from_le_bytes(four)),
    };
    if layout.is_normalized { (value / greatest).max(-1.0) } else { value }
}

fn load<'a>(
    uri: Option<&str>,
    length: u64,
    chunk: Option<&'a [u8]>,
    beside: Beside<'_>,
) -> Result<Cow<'a, [u8]>, String> {
    let mut bytes = match uri {
        None => Cow::Borrowed(chunk.ok_or("it should be in the binary chunk, which is missing")?),
        Some(uri) => Cow::Owned(match uri.strip_prefix("data:") {
            Some(data) => decode_data(data)?,
            None => read_beside(uri, length, beside)?,
        }),
    };
    let available = bytes.len();
    if available as u64 >= length {
        match &mut bytes {
            Cow::Borrowed(bytes) => *bytes = bytes.get(..length as usize).unwrap_or(bytes),
            Cow::Owned(bytes) => bytes.truncate(length as usize),
        }
        Ok(bytes)
    } else {
        Err(format!("it should have {length} bytes, but only {available} are there"))
    }
}

/// What follows `data:`, which is a media type, a comma, and the data.
fn decode_data(data: &str) -> Result<Vec<u8>, String> {
    let (media_type, data) = data.split_once(',').ok_or("its data URI has no comma")?;
    if media_type.ends_with(";base64") {
        base64::engine::general_purpose::STANDARD
            .decode(data)
            .map_err(|error| format!("its base64 data: {error}"))
    } else {
        Ok(percent_decode_str(data).collect())
    }
}

/// Whether a decoded URI names a file in the document's folder or below. Others are refused: an uploaded
/// file could name any file of the machine. Backslashes and drive letters count on every
/// platform, so that a document is read on all or on none.
fn stays_beside(name: &str) -> bool {
    !name.contains(':')
        && !name.starts_with(['/', '\\'])
        && name.split(['/', '\\']).all(|part| part != "..")
        && !Path::new(name).is_absolute()
}

/// Reads no more than `length` bytes of a file whose path is relative to the document.
fn read_beside(uri: &str, length: u64, beside: Beside<'_>) -> Result<Vec<u8>, String> {
    let name = percent_decode_str(uri).decode_utf8_lossy();
    let quoted = quote(name.as_bytes());
    if !stays_beside(&name) {
        return Err(format!("{quoted} is no path of a file beside or below the document"));
    }
    let missing = || format!("it is in another file, {quoted}");
    let path = match beside {
        Beside::Nothing => return Err(missing()),
        Beside::Files(files) => return files(&name).ok_or_else(missing),
        Beside::Folder(folder) => folder.join(name.as_ref()),
    };
    let read = || {
        // Opening a pipe would block until something is written into it.
        if !path.metadata()?.is_file() {
            return Err(std::io::Error::other("this is no file"));
        }
        let mut bytes = Vec::new();
        File::open(&path)?.take(length).read_to_end(&mut bytes)?;
        Ok(bytes)
    };
    read().map_err(|error| format!("{quoted}: {error}"))
}

/// What is done to `count` attributes of `stride` bytes after they are decoded.
type Filter = fn(&mut [u8], usize, usize, &mut Workspace) -> Result<(), Error>;

/// The stream of a compressed buffer view.
struct Compressed {
    buffer: usize,
    offset: usize,
    length: usize,
    stride: usize,
    count: usize,
    mode: Mode,
    filter: Option<Filter>,
}

impl Compressed {
    /// The stream of a view, if the view is compressed.
    fn of(view: &buffer::View) -> Result<Option<Self>, String> {
        let Some(extensions) = &view.extensions else {
            return Ok(None);
        };
        let found = MESHOPT.iter().find_map(|name| Some((name, extensions.others.get(*name)?)));
        let Some((name, extension)) = found else {
            return Ok(None);
        };
        Self::parse(extension).map(Some).map_err(|reason| format!("{name}: {reason}"))
    }

    fn parse(extension: &Value) -> Result<Self, String> {
        let word = |key| extension.get(key).and_then(Value::as_str);
        let mode = word("mode").ok_or("its `mode` is missing")?;
        let filter = word("filter").unwrap_or("NONE");
        let compressed = Self {
            buffer: extension_number(extension, "buffer")?,
            offset: optional_number(extension, "byteOffset")?.unwrap_or(0),
            length: extension_number(extension, "byteLength")?,
            stride: extension_number(extension, "byteStride")?,
            count: extension_number(extension, "count")?,
            mode: Mode::parse(mode)
                .map_err(|_| format!("the mode {} is unknown", quote(mode.as_bytes())))?,
            filter: match filter {
                "NONE" => None,
                "OCTAHEDRAL" => Some(decode_filter_oct),
                "QUATERNION" => Some(decode_filter_quat),
                "EXPONENTIAL" => Some(decode_filter_exp),
                "COLOR" => Some(decode_filter_color),
                _ => return Err(format!("the filter {} is unknown", quote(filter.as_bytes()))),
            },
        };
        if compressed.mode != Mode::Attributes && compressed.filter.is_some() {
            return Err("only attributes can have a filter".into());
        }
        Ok(compressed)
    }

    /// The bytes that a stream stands for, if they are no more than `allowance`.
    fn decode(&self, stream: &[u8], allowance: usize) -> Result<Vec<u8>, String> {
        let Self { count, stride, .. } = *self;
        if count.checked_mul(stride).is_none_or(|bytes| bytes > allowance) {
            return Err(format!(
                "it announces {count} elements of {stride} bytes, which a file of this size may \
                 not grow to"
            ));
        }
        let mut workspace = Workspace::new(Limits { max_bytes: allowance, ..Limits::default() });
        self.decode_within(stream, &mut workspace).map_err(|error| {
            format!(
                "its stream does not decompress to {count} elements of {stride} bytes as {:?}: \
                 {error}",
                self.mode
            )
        })
    }

    fn decode_within(&self, stream: &[u8], workspace: &mut Workspace) -> Result<Vec<u8>, Error> {
        let Self { count, stride, .. } = *self;
        let decode = match self.mode {
            Mode::Attributes => decode_vertex_buffer,
            Mode::Triangles => decode_index_buffer,
            Mode::Indices => decode_index_sequence,
        };
        let mut bytes = decode(count, stride, stream, workspace)?;
        if let Some(filter) = self.filter {
            filter(&mut bytes, count, stride, workspace)?;
        }
        Ok(bytes)
    }
}

/// Whether a buffer stands only for what compressed views grow to.
fn is_placeholder(buffer: &Buffer) -> bool {
    let Some(extensions) = &buffer.extensions else {
        return false;
    };
    MESHOPT.iter().any(|name| {
        let fallback = extensions.others.get(*name).and_then(|extension| extension.get("fallback"));
        fallback.and_then(Value::as_bool) == Some(true)
    })
}

/// A whole number of an extension, which may be missing. The crate `gltf` has no types for extensions.
fn optional_number(extension: &Value, key: &str) -> Result<Option<usize>, String> {
    let Some(value) = extension.get(key) else {
        return Ok(None);
    };
    match value.as_u64().and_then(|number| usize::try_from(number).ok()) {
        Some(number) => Ok(Some(number)),
        None => Err(format!("its `{key}` should be a whole number")),
    }
}

/// A whole number of an extension, which must be there.
fn extension_number(extension: &Value, key: &str) -> Result<usize, String> {
    optional_number(extension, key)?.ok_or_else(|| format!("its `{key}` is missing"))
}

/// The Draco stream of a primitive.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct DracoStream {
    /// The buffer view of the stream.
    view: u32,
    /// The attribute of the stream that holds positions.
    attribute: u32,
    /// Whether positions that are integers stand for fractions.
    is_normalized: bool,
}

/// What a Draco stream holds. Each index is below the number of positions.
pub(super) struct DracoMesh {
    pub(super) positions: Vec<[f64; 3]>,
    /// Three for each triangle.
    pub(super) indices: Vec<u32>,
}

impl DracoStream {
    /// The stream of a primitive, if the primitive is compressed.
    pub(super) fn of(primitive: &Primitive, is_normalized: bool) -> Result<Option<Self>, String> {
        let extensions = primitive.extensions.as_ref();
        let Some(found) = extensions.and_then(|extensions| extensions.others.get(DRACO)) else {
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
        parse().map(Some).map_err(|reason: String| format!("{DRACO}: {reason}"))
    }

    fn decode(self, stream: &[u8], allowance: usize) -> Result<DracoMesh, String> {
        let most = (allowance / BYTES_PER_ELEMENT) as u64;
        let limits = DecodeLimits::default()
            .with_max_points(most)
            .with_max_faces(most)
            .with_max_decoded_bytes(allowance as u64);
        let mut mesh = draco_core::Mesh::new();
        MeshDecoder::new()
            .decode(&mut DecoderBuffer::new(stream).with_limits(limits), &mut mesh)
            .map_err(|error| format!("its stream can't be decoded: {error}"))?;
        let attribute = mesh
            .attribute_by_unique_id(self.attribute)
            .ok_or_else(|| format!("its stream has no attribute {}", self.attribute))?;
        let count = mesh.num_points();
        let positions = draco_positions(attribute, count, self.is_normalized)?;
        let indices: Vec<u32> = mesh.faces().iter().flatten().map(|point| point.0).collect();
        match indices.iter().find(|index| **index as usize >= count) {
            Some(index) => Err(format!("its index {index} is beyond its {count} vertices")),
            None => Ok(DracoMesh { positions, indices }),
        }
    }
}

fn draco_positions(
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
