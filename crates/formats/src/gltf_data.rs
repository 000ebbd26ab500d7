//! The numbers behind a glTF document: buffers (the chunk of a GLB, data URIs, files beside it),
//! views of them, decompressed where they are compressed, accessors, and Draco streams.
//!
//! - `EXT_meshopt_compression` and `KHR_meshopt_compression`: views that hold streams of
//!   meshoptimizer's codecs. The first has only version 0 of the vertex codec, and no filter for
//!   colours. Both are read in the same way, as the library's own decoders do.
//! - `KHR_draco_mesh_compression`: primitives whose triangles and vertices are a Draco stream,
//!   decoded by the crate `draco-core`. Its decoder of bitstreams older than 2.2 is left out, since
//!   the extension names 2.2 alone, and so are point clouds, which no primitive holds. It makes
//!   room for as many triangles as a stream announces, so that these are limited by what the file's
//!   size justifies.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::{STANDARD, STANDARD_NO_PAD};
use draco_core::{DataType, DecodeLimits, DecoderBuffer, MeshDecoder, PointAttribute, PointIndex};
use meshoptimizer_rs::codec::{
    Mode, decode_filter_color, decode_filter_exp, decode_filter_oct, decode_filter_quat,
    decode_index_buffer, decode_index_sequence, decode_vertex_buffer,
};
use meshoptimizer_rs::{Error, Limits, Workspace};
use percent_encoding::percent_decode_str;

use super::gltf_json::{
    Document, entries, entry, extension, is_true, key, needed_number, optional_number, text,
};
use super::gltf_tree::Json;
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

/// What a document refers to, loaded and decompressed when geometry first needs it, so that a
/// missing file with nothing but images in it does no harm.
pub(super) struct Data<'a> {
    document: &'a Document<'a>,
    chunk: Option<&'a [u8]>,
    beside: Beside<'a>,
    /// Bytes of the file itself, without the buffers beside it.
    file_length: usize,
    buffers: Vec<Option<Cow<'a, [u8]>>>,
    /// Views by index: accessors share them, and meshes are placed many times.
    decompressed: BTreeMap<usize, Vec<u8>>,
    /// Bytes that all streams have grown to so far.
    growth: usize,
    /// Buffers whose base64 was mended.
    pub(super) mended: usize,
}

impl<'a> Data<'a> {
    pub(super) fn new(
        document: &'a Document<'a>,
        chunk: Option<&'a [u8]>,
        beside: Beside<'a>,
        file_length: usize,
    ) -> Self {
        Self {
            document,
            chunk,
            beside,
            file_length,
            buffers: vec![None; entries(&document.buffers).len()],
            decompressed: BTreeMap::new(),
            growth: 0,
            mended: 0,
        }
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
        let buffer = entry(&self.document.buffers, "buffer", index)?;
        let slot = self.buffers.get_mut(index).ok_or("there are fewer buffers")?;
        let loaded = match slot {
            Some(loaded) => loaded,
            None => {
                let load = || {
                    if text(buffer, "uri").is_none() && is_placeholder(buffer) {
                        return Err("it is a placeholder for compressed data and holds none".into());
                    }
                    let length = needed_number(buffer, "byteLength")?;
                    load(text(buffer, "uri"), length, self.chunk, self.beside)
                };
                let (bytes, is_mended) =
                    load().map_err(|reason: String| format!("buffer {index}: {reason}"))?;
                self.mended += usize::from(is_mended);
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

    fn find_view(&self, index: usize) -> Result<&'a Json<'a>, String> {
        entry(&self.document.buffer_views, "buffer view", index)
    }

    /// The bytes of a view.
    fn view(&mut self, index: usize) -> Result<&[u8], String> {
        let view = self.find_view(index)?;
        self.bytes_of(view, index).map_err(|reason| format!("buffer view {index}: {reason}"))
    }

    fn bytes_of(&mut self, view: &Json<'_>, index: usize) -> Result<&[u8], String> {
        let length = needed_number(view, "byteLength")?;
        let Some(compressed) = Compressed::of(view)? else {
            let offset = optional_number(view, "byteOffset")?.unwrap_or(0);
            return self.slice(needed_number(view, "buffer")?, offset, length);
        };
        let bytes = match self.decompressed.remove(&index) {
            Some(bytes) => bytes,
            None => self.decompress(&compressed, length)?,
        };
        Ok(self.decompressed.entry(index).or_insert(bytes))
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
        let view = stream.view;
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
    pub(super) fn positions(&mut self, index: usize) -> Result<Vec<[f64; 3]>, String> {
        let accessor = self.find_accessor(index)?;
        if Component::of(accessor) == Ok(Component::U32) {
            let reason =
                "positions are 32-bit integers, and floating-point or shorter ones would be read";
            return Err(at_accessor(index)(reason.into()));
        }
        self.vectors(index)
    }

    /// Vectors of N numbers, or matrices of 16.
    pub(super) fn vectors<const N: usize>(
        &mut self,
        index: usize,
    ) -> Result<Vec<[f64; N]>, String> {
        let accessor = self.find_accessor(index)?;
        let mut read = || {
            let kind = if N == 16 { "MAT4".to_owned() } else { format!("VEC{N}") };
            let component = Component::of_kind(accessor, &kind)?;
            let is_normalized = is_true(accessor, "normalized");
            let layout = ElementLayout { component, components: N, is_normalized };
            self.elements(accessor, layout, |element| vector(element, layout))
        };
        read().map_err(at_accessor(index))
    }

    /// The vertex indices that an accessor holds.
    pub(super) fn indices(&mut self, index: usize) -> Result<Vec<u32>, String> {
        let accessor = self.find_accessor(index)?;
        let mut read = || {
            let component = Component::of_kind(accessor, "SCALAR")?;
            component.check_is_index()?;
            let layout = ElementLayout { component, components: 1, is_normalized: false };
            self.elements(accessor, layout, |element| number(element, 0, layout) as u32)
        };
        read().map_err(at_accessor(index))
    }

    fn find_accessor(&self, index: usize) -> Result<&'a Json<'a>, String> {
        entry(&self.document.accessors, "accessor", index)
    }

    fn elements<T: Clone>(
        &mut self,
        accessor: &Json<'_>,
        layout: ElementLayout,
        decode: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>, String> {
        let count = needed_number(accessor, "count")?;
        let mut elements = match optional_number(accessor, "bufferView")? {
            Some(view) => {
                let offset = optional_number(accessor, "byteOffset")?.unwrap_or(0);
                self.strided(view, offset, count, layout)?.map(&decode).collect()
            }
            // Zeros, which the file need not hold.
            None if count.saturating_mul(layout.components.div_ceil(3)) > self.file_length => {
                return Err(format!(
                    "it announces {count} elements, but the file has only {} bytes",
                    self.file_length
                ));
            }
            None => vec![decode(&[]); count],
        };
        if let Some(sparse) = key(accessor, "sparse") {
            let (targets, values) = self.sparse(sparse, layout)?;
            for (target, value) in targets.into_iter().zip(values.map(&decode)) {
                *elements.get_mut(target).ok_or_else(|| {
                    format!("it has {count} elements, but changes number {target}")
                })? = value;
            }
        }
        Ok(elements)
    }

    /// The elements that a sparse accessor changes, and the bytes of what they become.
    fn sparse(
        &mut self,
        sparse: &Json<'_>,
        layout: ElementLayout,
    ) -> Result<(Vec<usize>, impl Iterator<Item = &[u8]>), String> {
        let count = needed_number(sparse, "count")?;
        let part = |name: &str| {
            let missing = || format!("the `{name}` of its `sparse` are missing");
            let part = key(sparse, name).ok_or_else(missing)?;
            let offset = optional_number(part, "byteOffset")?.unwrap_or(0);
            Ok::<_, String>((part, needed_number(part, "bufferView")?, offset))
        };
        let (indices, view, offset) = part("indices")?;
        let component = Component::of(indices)?;
        component.check_is_index()?;
        let index_layout = ElementLayout { component, components: 1, is_normalized: false };
        let targets = self
            .strided(view, offset, count, index_layout)?
            .map(|element| number(element, 0, index_layout) as usize)
            .collect();
        let (_, view, offset) = part("values")?;
        Ok((targets, self.strided(view, offset, count, layout)?))
    }

    /// The bytes of `count` elements; each is at least as long as the layout says.
    fn strided(
        &mut self,
        view: usize,
        offset: usize,
        count: usize,
        layout: ElementLayout,
    ) -> Result<impl Iterator<Item = &[u8]>, String> {
        let element_length = layout.component.size() * layout.components;
        let stride = match optional_number(self.find_view(view)?, "byteStride")? {
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

/// A type of number in a buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    /// That of an accessor, by its code.
    fn of(accessor: &Json<'_>) -> Result<Self, String> {
        Ok(match needed_number(accessor, "componentType")? {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            code => {
                return Err(format!(
                    "its `componentType` is {code}, and 5120 to 5123, 5125 or 5126 would be read"
                ));
            }
        })
    }

    /// The same, if the elements are of a kind such as `VEC3`.
    fn of_kind(accessor: &Json<'_>, kind: &str) -> Result<Self, String> {
        match text(accessor, "type") {
            Some(found) if found == kind => Self::of(accessor),
            found => {
                let found = quote(found.unwrap_or_default().as_bytes());
                Err(format!("its `type` is {found}, and {kind} would be read"))
            }
        }
    }

    fn check_is_index(self) -> Result<(), String> {
        match self {
            Self::U8 | Self::U16 | Self::U32 => Ok(()),
            _ => {
                Err("its indices are signed or have fractions, and unsigned integers would be read"
                    .into())
            }
        }
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }
}

/// Elements of one kind that lie in a buffer one after the other.
#[derive(Clone, Copy)]
struct ElementLayout {
    component: Component,
    components: usize,
    is_normalized: bool,
}

fn at_accessor(index: usize) -> impl Fn(String) -> String {
    move |reason| format!("accessor {index}: {reason}")
}

fn vector<const N: usize>(element: &[u8], layout: ElementLayout) -> [f64; N] {
    std::array::from_fn(|axis| number(element, axis, layout))
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
        Component::I8 => (f64::from(low as i8), f64::from(i8::MAX)),
        Component::U8 => (f64::from(low), f64::from(u8::MAX)),
        Component::I16 => (f64::from(i16::from_le_bytes([low, high])), f64::from(i16::MAX)),
        Component::U16 => (f64::from(u16::from_le_bytes([low, high])), f64::from(u16::MAX)),
        Component::U32 => (f64::from(u32::from_le_bytes(four)), f64::from(u32::MAX)),
        Component::F32 => return f64::from(f32::from_le_bytes(four)),
    };
    if layout.is_normalized { (value / greatest).max(-1.0) } else { value }
}

/// The bytes of a buffer, and whether they were mended.
fn load<'a>(
    uri: Option<&str>,
    length: usize,
    chunk: Option<&'a [u8]>,
    beside: Beside<'_>,
) -> Result<(Cow<'a, [u8]>, bool), String> {
    let (mut bytes, is_mended) = match uri {
        None => {
            let chunk = chunk.ok_or("it should be in the binary chunk, which is missing")?;
            (Cow::Borrowed(chunk), false)
        }
        Some(uri) => match uri.strip_prefix("data:") {
            Some(data) => decode_data(data).map(|(bytes, mended)| (Cow::Owned(bytes), mended))?,
            None => (Cow::Owned(read_beside(uri, length as u64, beside)?), false),
        },
    };
    let available = bytes.len();
    if available < length {
        return Err(format!("it should have {length} bytes, but only {available} are there"));
    }
    match &mut bytes {
        Cow::Borrowed(bytes) => *bytes = bytes.get(..length).unwrap_or(bytes),
        Cow::Owned(bytes) => bytes.truncate(length),
    }
    Ok((bytes, is_mended))
}

/// What follows `data:`, which is a media type, a comma, and the data; and whether it was mended.
fn decode_data(data: &str) -> Result<(Vec<u8>, bool), String> {
    let (media_type, data) = data
        .split_once(',')
        .ok_or("its data URI has no comma, and one before the data would be read")?;
    if !media_type.trim_end().to_ascii_lowercase().ends_with(";base64") {
        return Ok((percent_decode_str(data).collect(), false));
    }
    if let Ok(bytes) = STANDARD.decode(data) {
        return Ok((bytes, false));
    }
    // Mended: escapes, line breaks, the letters of URLs, no padding.
    let mut letters: Vec<u8> = percent_decode_str(data).collect();
    letters.retain(|letter| !letter.is_ascii_whitespace());
    while letters.pop_if(|letter| *letter == b'=').is_some() {}
    for letter in &mut letters {
        *letter = match *letter {
            b'-' => b'+',
            b'_' => b'/',
            other => other,
        };
    }
    let bytes = STANDARD_NO_PAD.decode(&letters);
    Ok((bytes.map_err(|error| format!("its base64 data: {error}"))?, true))
}

/// Whether a decoded URI names a file in the document's folder or below. Others are refused: an
/// uploaded file could name any file of the machine. Backslashes and drive letters count on every
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
    let missing = || format!("it is in another file, {quoted}, which is not at hand");
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
    fn of(view: &Json<'_>) -> Result<Option<Self>, String> {
        let found = MESHOPT.iter().find_map(|name| Some((name, extension(view, name)?)));
        let Some((name, extension)) = found else {
            return Ok(None);
        };
        Self::parse(extension).map(Some).map_err(|reason| format!("{name}: {reason}"))
    }

    fn parse(extension: &Json<'_>) -> Result<Self, String> {
        let mode = text(extension, "mode").ok_or("its `mode` is missing")?;
        let filter = text(extension, "filter").unwrap_or("NONE");
        let compressed = Self {
            buffer: needed_number(extension, "buffer")?,
            offset: optional_number(extension, "byteOffset")?.unwrap_or(0),
            length: needed_number(extension, "byteLength")?,
            stride: needed_number(extension, "byteStride")?,
            count: needed_number(extension, "count")?,
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
fn is_placeholder(buffer: &Json<'_>) -> bool {
    MESHOPT
        .iter()
        .any(|name| extension(buffer, name).is_some_and(|extension| is_true(extension, "fallback")))
}

/// The Draco stream of a primitive.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct DracoStream {
    /// The buffer view of the stream.
    view: usize,
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
    pub(super) fn of(primitive: &Json<'_>, is_normalized: bool) -> Result<Option<Self>, String> {
        let Some(found) = extension(primitive, DRACO) else {
            return Ok(None);
        };
        let parse = || {
            let view = needed_number(found, "bufferView")?;
            let attributes = key(found, "attributes").ok_or("its `attributes` are missing")?;
            let attribute = needed_number(attributes, "POSITION")?;
            let attribute = u32::try_from(attribute)
                .map_err(|_| format!("its stream has no attribute {attribute}"))?;
            Ok(Self { view, attribute, is_normalized })
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
        return Err(format!(
            "its positions have {} components, and three would be read",
            attribute.num_components()
        ));
    }
    let length = component.size() * layout.components;
    let stride = usize::try_from(attribute.byte_stride()).unwrap_or(0).max(length);
    let data = attribute.buffer().data();
    let position = |point: usize| {
        let value = attribute.mapped_index(PointIndex(point as u32)).0 as usize;
        let start = value.checked_mul(stride)?;
        let element = data.get(start..start.checked_add(length)?)?;
        Some(vector(element, layout))
    };
    (0..count)
        .map(|point| position(point).ok_or_else(|| format!("its vertex {point} has no position")))
        .collect()
}

/// The type as glTF has it.
fn component(data: DataType) -> Result<Component, String> {
    match data {
        DataType::Int8 => Ok(Component::I8),
        DataType::Uint8 => Ok(Component::U8),
        DataType::Int16 => Ok(Component::I16),
        DataType::Uint16 => Ok(Component::U16),
        DataType::Float32 => Ok(Component::F32),
        _ => Err(format!("its positions are of the type {data:?}, which glTF does not have")),
    }
}
