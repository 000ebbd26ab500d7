//! The key of extras by which a group of hulls is known that `hullwright bake --into` wrote.
//!
//! Readers of files leave such a group out, and what it says is read far above them: this is what
//! both share.

use serde_json::Value;

/// The key of a group's record.
pub(crate) const RECORD: &str = "hullwright";

/// The record in the extras of a node; `None` where there is none, or where they are no JSON.
pub(crate) fn record(extras: &str) -> Option<Value> {
    // Most extras are somebody else's, and need no second reading.
    if !extras.contains(RECORD) {
        return None;
    }
    match serde_json::from_str(extras) {
        Ok(Value::Object(mut extras)) => extras.remove(RECORD),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_is_what_stands_under_its_key_and_nowhere_deeper() {
        assert_eq!(
            record(r#"{"a": 1, "hullwright": {"b": 2}}"#),
            Some(serde_json::json!({"b": 2}))
        );
        for none in ["", "{", "[\"hullwright\"]", r#"{"a": {"hullwright": 1}}"#, "\"hullwright\""] {
            assert_eq!(record(none), None, "{none}");
        }
    }
}
