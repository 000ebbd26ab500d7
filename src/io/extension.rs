//! Numbers in the JSON of glTF extensions that the crate `gltf` has no types for.

use serde_json::Value;

/// A whole number that may be missing.
pub(super) fn optional_number(extension: &Value, key: &str) -> Result<Option<usize>, String> {
    let Some(value) = extension.get(key) else {
        return Ok(None);
    };
    match value.as_u64().and_then(|number| usize::try_from(number).ok()) {
        Some(number) => Ok(Some(number)),
        None => Err(format!("its `{key}` should be a whole number")),
    }
}

/// A whole number that must be there.
pub(super) fn number(extension: &Value, key: &str) -> Result<usize, String> {
    optional_number(extension, key)?.ok_or_else(|| format!("its `{key}` is missing"))
}
