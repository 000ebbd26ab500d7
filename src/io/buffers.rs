//! The bytes behind a glTF document: the chunk of a GLB, data URIs, files beside it.

use std::borrow::Cow;
use std::fs::File;
use std::io::Read;
use std::path::Path;

use base64::Engine;
use gltf::json::Root;
use percent_encoding::percent_decode_str;

use super::meshopt::is_placeholder;
use super::text::quote;

/// Buffers are loaded when geometry first asks for them, so that a missing file with nothing but
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

    pub(super) fn bytes_loaded(&self) -> usize {
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
    pub(super) fn slice(
        &mut self,
        index: usize,
        offset: usize,
        length: usize,
    ) -> Result<&[u8], String> {
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

/// Whether a decoded URI names a file in the document's folder or below. Others are refused: a file that
/// somebody uploads could name any file of the machine. Backslashes and drive letters count on every
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
        // Opening a pipe would wait for somebody to write into it.
        if !path.metadata()?.is_file() {
            return Err(std::io::Error::other("this is no file"));
        }
        let mut bytes = Vec::new();
        File::open(&path)?.take(length).read_to_end(&mut bytes)?;
        Ok(bytes)
    };
    read().map_err(|error| format!("{quoted}: {error}"))
}
