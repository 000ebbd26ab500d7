//! `EXT_meshopt_compression` and `KHR_meshopt_compression`: buffer views that hold streams of
//! meshoptimizer's codecs.
//!
//! The first has only version 0 of the vertex codec, and no filter for colours. Here both are
//! read in the same way, as the library's own decoders do.

use gltf::json::{Buffer, buffer};
use meshoptimizer_rs::codec::{
    Mode, decode_filter_color, decode_filter_exp, decode_filter_oct, decode_filter_quat,
    decode_index_buffer, decode_index_sequence, decode_vertex_buffer,
};
use meshoptimizer_rs::{Error, Limits, Workspace};
use serde_json::Value;

use super::text::quote;

/// The names of the extension, before and after it was adopted by Khronos.
pub(super) const EXTENSIONS: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/// What is done to attributes after they are decoded.
#[derive(Clone, Copy, PartialEq)]
enum Filter {
    None,
    Octahedral,
    Quaternion,
    Exponential,
    Colour,
}

/// What a buffer view says of its stream.
pub(super) struct Compressed {
    pub(super) buffer: usize,
    pub(super) offset: usize,
    pub(super) length: usize,
    stride: usize,
    count: usize,
    mode: Mode,
    filter: Filter,
}

impl Compressed {
    /// The stream of a view, if the view is compressed.
    pub(super) fn of(view: &buffer::View) -> Result<Option<Self>, String> {
        let Some(extensions) = &view.extensions else {
            return Ok(None);
        };
        let found = EXTENSIONS.iter().find_map(|name| Some((name, extensions.others.get(*name)?)));
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
                "NONE" => Filter::None,
                "OCTAHEDRAL" => Filter::Octahedral,
                "QUATERNION" => Filter::Quaternion,
                "EXPONENTIAL" => Filter::Exponential,
                "COLOR" => Filter::Colour,
                _ => return Err(format!("the filter {} is unknown", quote(filter.as_bytes()))),
            },
        };
        if compressed.mode != Mode::Attributes && compressed.filter != Filter::None {
            return Err("only attributes can have a filter".into());
        }
        Ok(compressed)
    }

    /// The bytes that a stream stands for, if they are no more than `allowance`.
    pub(super) fn decode(&self, stream: &[u8], allowance: usize) -> Result<Vec<u8>, String> {
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
        match self.filter {
            Filter::None => {}
            Filter::Octahedral => decode_filter_oct(&mut bytes, count, stride, workspace)?,
            Filter::Quaternion => decode_filter_quat(&mut bytes, count, stride, workspace)?,
            Filter::Exponential => decode_filter_exp(&mut bytes, count, stride, workspace)?,
            Filter::Colour => decode_filter_color(&mut bytes, count, stride, workspace)?,
        }
        Ok(bytes)
    }
}

/// Whether a buffer stands only for what compressed views grow to.
pub(super) fn is_placeholder(buffer: &Buffer) -> bool {
    let Some(extensions) = &buffer.extensions else {
        return false;
    };
    EXTENSIONS.iter().any(|name| {
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
pub(super) fn extension_number(extension: &Value, key: &str) -> Result<usize, String> {
    optional_number(extension, key)?.ok_or_else(|| format!("its `{key}` is missing"))
}
