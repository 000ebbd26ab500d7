//! The bytes of glTF buffer views, decompressed where they are compressed.

use std::collections::BTreeMap;

use gltf::json::{Index, Root, buffer};

use super::buffers::Buffers;
use super::meshopt::Compressed;

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
