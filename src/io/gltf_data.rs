//! The numbers behind a glTF document: buffers (the chunk of a GLB, data URIs, files beside it), views of them,
//! decompressed where they are compressed, and accessors.
//!
//! The crate's own iterators panic where an accessor reaches beyond its buffer, where a stride is shorter than
//! an element, or where a type is unknown. Here each number is checked instead.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::Path;

use base64::Engine;
use gltf::json::accessor::{
    Accessor, ComponentType, GenericComponentType, IndexComponentType, Type,
};
use gltf::json::validation::Checked;
use gltf::json::{Index, Root, buffer};
use percent_encoding::percent_decode_str;

use super::meshopt::{Compressed, is_placeholder};
use super::text::quote;

/// Buffers are loaded when geometry first needs them, so that a missing file with nothing but
/// images in it does no harm.
pub(super) struct Buffers<'a> {
    root: &'a Root,
    chunk: Option<&'a [u8]>,
    directory: Option<&'a Path>,
    loaded: Vec<Option<Cow<'a, [u8]>>>,
}

impl<'a> Buffers<'a> {
    pub(super) fn new(
        root: &'a Root,
        chunk: Option<&'a [u8]>,
        directory: Option<&'a Path>,
    ) -> Self {
        Self { root, chunk, directory, loaded: vec![None; root.buffers.len()] }
    }

    fn bytes_loaded(&self) -> usize {
        self.loaded.iter().flatten().map(|bytes| bytes.len()).sum()
    }

    /// The bytes of a buffer, as many as the document says.
    fn get(&mut self, index: usize) -> Result<&[u8], String> {
        let missing = || format!("there is no buffer {index}");
        let Some(slot) = self.loaded.get_mut(index) else {
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
                let bytes = load(buffer.uri.as_deref(), length, self.chunk, self.directory)
                    .map_err(|reason| format!("buffer {index}: {reason}"))?;
                slot.insert(bytes)
            }
        };
        Ok(loaded)
    }

    /// A part of a buffer.
    fn slice(&mut self, index: usize, offset: usize, length: usize) -> Result<&[u8], String> {
        let buffer = self.get(index)?;
        let end = offset.checked_add(length);
        end.and_then(|end| buffer.get(offset..end)).ok_or_else(|| {
            format!("it reaches beyond the {} bytes of its buffer {index}", buffer.len())
        })
    }
}

fn load<'a>(
    uri: Option<&str>,
    length: u64,
    chunk: Option<&'a [u8]>,
    directory: Option<&Path>,
) -> Result<Cow<'a, [u8]>, String> {
    let mut bytes = match uri {
        None => Cow::Borrowed(chunk.ok_or("it should be in the binary chunk, which is missing")?),
        Some(uri) => Cow::Owned(match uri.strip_prefix("data:") {
            Some(data) => decode_data(data)?,
            None => read_beside(uri, length, directory)?,
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
fn read_beside(uri: &str, length: u64, directory: Option<&Path>) -> Result<Vec<u8>, String> {
    let name = percent_decode_str(uri).decode_utf8_lossy();
    let quoted = quote(name.as_bytes());
    if !stays_beside(&name) {
        return Err(format!("{quoted} is no path of a file beside or below the document"));
    }
    let directory = directory.ok_or_else(|| format!("it is in another file, {quoted}"))?;
    let path = directory.join(name.as_ref());
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

/// All streams of a file together may grow to this many bytes, however short they are: a million
/// elements, since short streams of simple meshes grow most.
const GROWTH_FOR_FREE: usize = 1 << 24;

/// Streams may grow to this many bytes more for each byte that was read. No stream of
/// meshoptimizer's vertex codec of version 0 can grow more. Those of version 1 and of Draco do so
/// only where almost all of a large mesh is regular, such as a flat grid.
const GROWTH_PER_BYTE: usize = 64;

/// What a vertex, or a triangle, counts as: three numbers of four bytes, and some more, since
/// a decoder needs room to work. That of Draco takes up to 70 bytes for a triangle.
pub(super) const BYTES_PER_ELEMENT: usize = 16;

pub(super) struct Views<'a> {
    root: &'a Root,
    buffers: Buffers<'a>,
    file_length: usize,
    /// Accessors share views, and meshes are placed many times.
    decompressed: BTreeMap<usize, Vec<u8>>,
    /// Bytes that all streams have grown to so far.
    growth: usize,
}

impl<'a> Views<'a> {
    pub(super) fn new(root: &'a Root, buffers: Buffers<'a>, file_length: usize) -> Self {
        Self { root, buffers, file_length, decompressed: BTreeMap::new(), growth: 0 }
    }

    /// Bytes of the file itself, without the buffers beside it.
    pub(super) fn file_length(&self) -> usize {
        self.file_length
    }

    fn bytes_read(&self) -> usize {
        self.file_length + self.buffers.bytes_loaded()
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

    /// Counts what a stream has grown to.
    pub(super) fn spend(&mut self, bytes: usize) {
        self.growth = self.growth.saturating_add(bytes);
    }

    pub(super) fn stride(&self, index: Index<buffer::View>) -> Result<Option<usize>, String> {
        Ok(self.find(index)?.byte_stride.map(|stride| stride.0))
    }

    fn find(&self, index: Index<buffer::View>) -> Result<&'a buffer::View, String> {
        self.root.get(index).ok_or_else(|| format!("buffer view {index}: it does not exist"))
    }

    /// The bytes of a view.
    pub(super) fn get(&mut self, index: Index<buffer::View>) -> Result<&[u8], String> {
        let view = self.find(index)?;
        let at_view = |reason: String| format!("buffer view {index}: {reason}");
        let length = size(view.byte_length.0).map_err(at_view)?;
        let Some(compressed) = Compressed::of(view).map_err(at_view)? else {
            let offset = size(view.byte_offset.unwrap_or_default().0).map_err(at_view)?;
            return self.buffers.slice(view.buffer.value(), offset, length).map_err(at_view);
        };
        let bytes = match self.decompressed.remove(&index.value()) {
            Some(bytes) => bytes,
            None => self.decompress(&compressed, length).map_err(at_view)?,
        };
        Ok(self.decompressed.entry(index.value()).or_insert(bytes))
    }

    /// The bytes of a view, and how many bytes may be made of them.
    pub(super) fn get_with_allowance(
        &mut self,
        index: Index<buffer::View>,
    ) -> Result<(&[u8], usize), String> {
        // The first call loads the buffer, which the allowance depends on.
        self.get(index)?;
        let allowance = self.allowance();
        Ok((self.get(index)?, allowance))
    }

    fn decompress(&mut self, compressed: &Compressed, length: usize) -> Result<Vec<u8>, String> {
        let Compressed { buffer, offset, length: stream_length, .. } = *compressed;
        // The first call loads the buffer, which the allowance depends on.
        self.buffers.slice(buffer, offset, stream_length)?;
        let allowance = self.allowance();
        let stream = self.buffers.slice(buffer, offset, stream_length)?;
        let bytes = compressed.decode(stream, allowance)?;
        if bytes.len() != length {
            return Err(format!("it should have {length} bytes, but {} were made", bytes.len()));
        }
        self.spend(bytes.len());
        Ok(bytes)
    }
}

pub(super) fn size(number: u64) -> Result<usize, String> {
    usize::try_from(number).map_err(|_| format!("{number} bytes are too many"))
}

/// Elements of one kind that lie in a buffer one after the other.
#[derive(Clone, Copy)]
pub(super) struct ElementLayout {
    pub(super) component: ComponentType,
    pub(super) components: usize,
    pub(super) is_normalized: bool,
}

pub(super) struct Accessors<'a> {
    root: &'a Root,
    views: Views<'a>,
}

impl<'a> Accessors<'a> {
    pub(super) fn new(root: &'a Root, views: Views<'a>) -> Self {
        Self { root, views }
    }

    pub(super) fn views(&mut self) -> &mut Views<'a> {
        &mut self.views
    }

    /// The positions that an accessor holds: floating-point, or integers as the extension
    /// `KHR_mesh_quantization` allows.
    pub(super) fn positions(&mut self, index: Index<Accessor>) -> Result<Vec<[f64; 3]>, String> {
        let read = |accessors: &mut Self| {
            let (accessor, component) = accessors.find(index, Type::Vec3)?;
            if component == ComponentType::U32 {
                return Err("positions can't be 32-bit integers".into());
            }
            let layout =
                ElementLayout { component, components: 3, is_normalized: accessor.normalized };
            accessors.elements(accessor, layout, |element| {
                [0, 1, 2].map(|axis| number(element, axis, layout))
            })
        };
        read(self).map_err(at_accessor(index))
    }

    /// The vertex indices that an accessor holds.
    pub(super) fn indices(&mut self, index: Index<Accessor>) -> Result<Vec<u32>, String> {
        let read = |accessors: &mut Self| {
            let (accessor, component) = accessors.find(index, Type::Scalar)?;
            if !is_index(component) {
                return Err("indices must be unsigned integers".into());
            }
            let layout = ElementLayout { component, components: 1, is_normalized: false };
            accessors.elements(accessor, layout, |element| number(element, 0, layout) as u32)
        };
        read(self).map_err(at_accessor(index))
    }

    fn find(
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
            None if count > self.views.file_length() => {
                return Err(format!(
                    "it announces {count} elements, but the file has only {} bytes",
                    self.views.file_length()
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
        let stride = match self.views.stride(view)? {
            None | Some(0) => element_length,
            Some(stride) if stride < element_length => {
                return Err(format!(
                    "buffer view {view}: a stride of {stride} bytes is too short for elements of \
                     {element_length}"
                ));
            }
            Some(stride) => stride,
        };
        let bytes = self.views.get(view)?;
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

fn at_accessor(index: Index<Accessor>) -> impl Fn(String) -> String {
    move |reason| format!("accessor {index}: {reason}")
}

fn is_index(component: ComponentType) -> bool {
    matches!(component, ComponentType::U8 | ComponentType::U16 | ComponentType::U32)
}

/// A component of an element. What is not there is 0, as in an accessor without a buffer view.
pub(super) fn number(element: &[u8], index: usize, layout: ElementLayout) -> f64 {
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
