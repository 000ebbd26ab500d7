//! Values of extras as programs write them.

use serde_json::Value;

/// What is wrong with extras, in one line that names the keys that there are.
pub type Complaint = String;

/// Blender's older custom properties have no booleans, but 0 and 1.
pub(super) fn boolean(value: &Value) -> Option<bool> {
    match value.as_f64() {
        Some(0.0) => Some(false),
        Some(1.0) => Some(true),
        _ => value.as_bool(),
    }
}

/// The value of a name in a table.
pub(super) fn named<T: Copy>(value: &Value, table: &[(&str, T)]) -> Option<T> {
    let name = value.as_str()?;
    table.iter().find(|(known, _)| *known == name).map(|(_, value)| *value)
}
