//! The JSON of a glTF document: the parts that geometry needs, and what their keys hold.
//!
//! All else of a document is skipped as it is read, so that nothing is refused over animations, cameras or images. A key
//! of the wrong kind is an error once geometry needs it, and says what would be read.

use serde::Deserialize;
use serde_json::Value;

use super::text::quote;

/// What geometry may need. A part that the document lacks is null.
#[derive(Deserialize, Default)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct Document {
    asset: Value,
    pub(super) accessors: Value,
    pub(super) buffer_views: Value,
    pub(super) buffers: Value,
    pub(super) extensions_required: Value,
    pub(super) materials: Value,
    pub(super) meshes: Value,
    pub(super) nodes: Value,
    pub(super) scene: Value,
    pub(super) scenes: Value,
    pub(super) skins: Value,
}

impl Document {
    pub(super) fn parse(json: &[u8]) -> Result<Self, String> {
        if matches!(json.trim_ascii_start().first(), Some(first) if *first != b'{') {
            return Err("line 1: the JSON is no object, and one with `asset` would be read".into());
        }
        let document: Self = serde_json::from_slice(json).map_err(|error| {
            let reason = error.to_string();
            let reason = reason.split(" at line ").next().unwrap_or_default();
            let place = format!("line {}, column {}", error.line(), error.column());
            format!("{place}: it is no valid JSON: {reason}")
        })?;
        document.check_version()?;
        for part in [
            ("accessors", &document.accessors),
            ("bufferViews", &document.buffer_views),
            ("buffers", &document.buffers),
            ("extensionsRequired", &document.extensions_required),
            ("meshes", &document.meshes),
            ("nodes", &document.nodes),
            ("scenes", &document.scenes),
        ] {
            if !part.1.is_null() && !part.1.is_array() {
                return Err(wrong(part.0, part.1, "a list"));
            }
        }
        Ok(document)
    }

    fn check_version(&self) -> Result<(), String> {
        if self.asset.is_null() {
            return Err("it has no `asset`, so it is no glTF; glTF 2.0 would be read".into());
        }
        let version = self.asset.get("version");
        let text = version.and_then(Value::as_str).unwrap_or_default();
        let is_first = text.starts_with("1.") || text == "1";
        if is_first || self.meshes.is_object() {
            return Err(FIRST_VERSION.into());
        }
        Ok(())
    }
}

pub(super) const FIRST_VERSION: &str = "it is glTF 1.0, and glTF 2.0 would be read: \
     `npx gltf-pipeline -i old.gltf -o new.gltf` converts it";

/// The entries of a list; of anything else none.
pub(super) fn entries(list: &Value) -> &[Value] {
    list.as_array().map_or(&[], Vec::as_slice)
}

/// An entry of a part of the document.
pub(super) fn entry<'a>(list: &'a Value, what: &str, index: usize) -> Result<&'a Value, String> {
    let entries = entries(list);
    entries.get(index).ok_or_else(|| match entries.len() {
        0 => format!("there is no {what} {index}; the file has none"),
        count => format!("there is no {what} {index}; the file has 0 to {}", count - 1),
    })
}

/// A value as a message shows it, in short.
fn found(value: &Value) -> String {
    match value {
        Value::Array(_) => "a list".into(),
        Value::Object(_) => "an object".into(),
        Value::String(text) => quote(text.as_bytes()),
        other => quote(other.to_string().as_bytes()),
    }
}

fn wrong(key: &str, value: &Value, expected: &str) -> String {
    format!("its `{key}` is {}, and {expected} would be read", found(value))
}

/// What a key holds; null stands for a key that is not there.
pub(super) fn key<'a>(of: &'a Value, key: &str) -> Option<&'a Value> {
    of.get(key).filter(|value| !value.is_null())
}

/// An extension of an entry.
pub(super) fn extension<'a>(of: &'a Value, name: &str) -> Option<&'a Value> {
    key(key(of, "extensions")?, name)
}

/// A whole number, which may be missing. Some programs write it as `8.0`.
pub(super) fn optional_number(of: &Value, name: &str) -> Result<Option<usize>, String> {
    let Some(value) = key(of, name) else {
        return Ok(None);
    };
    match whole(value) {
        Some(number) => Ok(Some(number)),
        None => Err(wrong(name, value, WHOLE)),
    }
}

const WHOLE: &str = "a whole number from 0";

fn whole(value: &Value) -> Option<usize> {
    const MOST: f64 = (1_u64 << 53) as f64;
    let whole = |number: f64| number.fract() == 0.0 && (0.0..=MOST).contains(&number);
    let of_float = || value.as_f64().filter(|number| whole(*number)).map(|number| number as u64);
    usize::try_from(value.as_u64().or_else(of_float)?).ok()
}

/// A whole number, which must be there.
pub(super) fn needed_number(of: &Value, name: &str) -> Result<usize, String> {
    optional_number(of, name)?
        .ok_or_else(|| format!("its `{name}` is missing, and {WHOLE} would be read"))
}

/// A list, or none where the key is missing.
pub(super) fn list<'a>(of: &'a Value, name: &str) -> Result<&'a [Value], String> {
    match key(of, name) {
        None => Ok(&[]),
        Some(Value::Array(list)) => Ok(list),
        Some(other) => Err(wrong(name, other, "a list")),
    }
}

/// A list of indices, or none where the key is missing.
pub(super) fn indices(of: &Value, name: &str) -> Result<Vec<usize>, String> {
    let index = |value: &Value| whole(value).ok_or_else(|| wrong_in(name, value, WHOLE));
    list(of, name)?.iter().map(index).collect()
}

fn wrong_in(name: &str, value: &Value, expected: &str) -> String {
    format!("in its `{name}` stands {}, and {expected} would be read", found(value))
}

/// So many numbers in single precision, or `None` where the key is missing.
pub(super) fn numbers<const N: usize>(of: &Value, name: &str) -> Result<Option<[f64; N]>, String> {
    let Some(value) = key(of, name) else {
        return Ok(None);
    };
    let expected = format!("a list of {N} numbers");
    let Some(list) = value.as_array().filter(|list| list.len() == N) else {
        return Err(wrong(name, value, &expected));
    };
    let mut numbers = [0.0; N];
    for (number, value) in numbers.iter_mut().zip(list) {
        let double = value.as_f64().ok_or_else(|| wrong_in(name, value, "a number"))?;
        *number = f64::from(double as f32);
    }
    Ok(Some(numbers))
}

/// A text, which may be missing or of another kind.
pub(super) fn text<'a>(of: &'a Value, name: &str) -> Option<&'a str> {
    key(of, name)?.as_str()
}

pub(super) fn is_true(of: &Value, name: &str) -> bool {
    key(of, name).and_then(Value::as_bool) == Some(true)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn each_kind_that_a_key_should_not_hold_is_named_with_what_would_be_read() {
        for (value, shown) in [
            (json!("a"), "`a`"),
            (json!([1]), "a list"),
            (json!({}), "an object"),
            (json!(-1), "`-1`"),
            (json!(1.5), "`1.5`"),
            (json!(true), "`true`"),
        ] {
            let error = optional_number(&json!({ "mesh": value }), "mesh").unwrap_err();
            let expected =
                format!("its `mesh` is {shown}, and a whole number from 0 would be read");
            assert_eq!(error, expected);
        }
        for absent in [json!({}), json!({ "mesh": null }), json!(7)] {
            assert_eq!(optional_number(&absent, "mesh"), Ok(None));
            assert!(needed_number(&absent, "mesh").unwrap_err().contains("is missing"));
        }
        assert_eq!(optional_number(&json!({ "mesh": 8.0 }), "mesh"), Ok(Some(8)));
        assert!(numbers::<3>(&json!({ "scale": [1, 2] }), "scale").is_err());
        assert!(numbers::<1>(&json!({ "scale": ["1"] }), "scale").unwrap_err().contains("in its"));
    }

    #[test]
    fn a_document_that_is_no_gltf_2_says_what_it_is() {
        let reason = |json: &str| Document::parse(json.as_bytes()).err().unwrap();
        assert!(reason("{").starts_with("line 1, column 1: it is no valid JSON"));
        assert!(reason("x").contains("the JSON is no object"));
        assert!(reason("[1]").contains("the JSON is no object"));
        assert!(reason("3").contains("the JSON is no object"));
        assert!(reason("{}").contains("no `asset`"));
        for first in [
            r#"{"asset": {"version": "1.0"}}"#,
            r#"{"asset": {"version": "1.1"}, "nodes": {"a": {}}}"#,
            r#"{"asset": {}, "meshes": {"m": {}}}"#,
        ] {
            assert!(reason(first).starts_with("it is glTF 1.0"), "{first}");
        }
        let odd = r#"{"asset": {"version": "2.0"}, "nodes": 3}"#;
        assert_eq!(reason(odd), "its `nodes` is `3`, and a list would be read");
    }
}
