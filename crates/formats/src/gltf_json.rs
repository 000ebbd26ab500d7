//! What the keys of a glTF document hold.
//!
//! Nothing is refused over what geometry does not need. A key of the wrong kind is an error once
//! geometry needs it, and says what would be read.

use super::gltf_tree::Json;
use super::text::quote;

/// A document by its parts. A part that it lacks is null.
pub(super) struct Document<'a> {
    asset: Json<'a>,
    pub(super) accessors: Json<'a>,
    pub(super) buffer_views: Json<'a>,
    pub(super) buffers: Json<'a>,
    pub(super) extensions_required: Json<'a>,
    pub(super) materials: Json<'a>,
    pub(super) meshes: Json<'a>,
    pub(super) nodes: Json<'a>,
    pub(super) scene: Json<'a>,
    pub(super) scenes: Json<'a>,
    pub(super) skins: Json<'a>,
}

impl<'a> Document<'a> {
    pub(super) fn parse(json: &'a [u8]) -> Result<Self, String> {
        if json.trim_ascii().is_empty() {
            return Err("it is empty, and glTF 2.0 would be read".into());
        }
        let Json::Object(mut parts) = Json::parse(json)? else {
            return Err("line 1: the JSON is no object, and one with `asset` would be read".into());
        };
        let mut part = |name: &str| {
            let found = parts.iter().position(|(key, _)| *key == name);
            found.map_or(Json::Null, |at| parts.swap_remove(at).1)
        };
        let document = Self {
            asset: part("asset"),
            accessors: part("accessors"),
            buffer_views: part("bufferViews"),
            buffers: part("buffers"),
            extensions_required: part("extensionsRequired"),
            materials: part("materials"),
            meshes: part("meshes"),
            nodes: part("nodes"),
            scene: part("scene"),
            scenes: part("scenes"),
            skins: part("skins"),
        };
        document.check_version()?;
        for (name, part) in [
            ("accessors", &document.accessors),
            ("bufferViews", &document.buffer_views),
            ("buffers", &document.buffers),
            ("extensionsRequired", &document.extensions_required),
            ("meshes", &document.meshes),
            ("nodes", &document.nodes),
            ("scenes", &document.scenes),
        ] {
            if !matches!(part, Json::Null | Json::List(_)) {
                return Err(wrong(name, part, "a list"));
            }
        }
        Ok(document)
    }

    fn check_version(&self) -> Result<(), String> {
        if self.asset == Json::Null {
            return Err("it has no `asset`, so it is no glTF; glTF 2.0 would be read".into());
        }
        let version = self.asset.get("version");
        let text = version.and_then(Json::as_str).unwrap_or_default();
        let is_first = text.starts_with("1.") || text == "1";
        if is_first || matches!(self.meshes, Json::Object(_)) {
            return Err(FIRST_VERSION.into());
        }
        Ok(())
    }
}

pub(super) const FIRST_VERSION: &str = "it is glTF 1.0, and glTF 2.0 would be read: \
     `npx gltf-pipeline -i old.gltf -o new.gltf` converts it";

/// The entries of a list; of anything else none.
pub(super) fn entries<'b, 'a>(list: &'b Json<'a>) -> &'b [Json<'a>] {
    list.as_list().unwrap_or_default()
}

/// An entry of a part of the document.
pub(super) fn entry<'b, 'a>(
    list: &'b Json<'a>,
    what: &str,
    index: usize,
) -> Result<&'b Json<'a>, String> {
    let entries = entries(list);
    entries.get(index).ok_or_else(|| match entries.len() {
        0 => format!("there is no {what} {index}; the file has none"),
        count => format!("there is no {what} {index}; the file has 0 to {}", count - 1),
    })
}

/// A value as a message shows it, in short.
fn found(value: &Json<'_>) -> String {
    match value {
        Json::Null => "null".into(),
        Json::Bool(value) => format!("`{value}`"),
        Json::Whole(number) => format!("`{number}`"),
        Json::Number(number) => format!("`{number}`"),
        Json::Text(text) => quote(text.as_bytes()),
        Json::List(_) => "a list".into(),
        Json::Object(_) | Json::Extras(_) => "an object".into(),
    }
}

fn wrong(key: &str, value: &Json<'_>, expected: &str) -> String {
    format!("its `{key}` is {}, and {expected} would be read", found(value))
}

/// What a key holds; null stands for a key that is not there.
pub(super) fn key<'b, 'a>(of: &'b Json<'a>, key: &str) -> Option<&'b Json<'a>> {
    of.get(key).filter(|value| **value != Json::Null)
}

/// An extension of an entry.
pub(super) fn extension<'b, 'a>(of: &'b Json<'a>, name: &str) -> Option<&'b Json<'a>> {
    key(key(of, "extensions")?, name)
}

/// A whole number, which may be missing. Some programs write it as `8.0`.
pub(super) fn optional_number(of: &Json<'_>, name: &str) -> Result<Option<usize>, String> {
    let Some(value) = key(of, name) else {
        return Ok(None);
    };
    match whole(value) {
        Some(number) => Ok(Some(number)),
        None => Err(wrong(name, value, WHOLE)),
    }
}

const WHOLE: &str = "a whole number from 0";

/// A value as a whole number, if it is one.
pub(super) fn whole(value: &Json<'_>) -> Option<usize> {
    const MOST: f64 = (1_u64 << 53) as f64;
    match *value {
        Json::Whole(number) => usize::try_from(number).ok(),
        Json::Number(number) if number.fract() == 0.0 && (0.0..=MOST).contains(&number) => {
            usize::try_from(number as u64).ok()
        }
        _ => None,
    }
}

/// A whole number, which must be there.
pub(super) fn needed_number(of: &Json<'_>, name: &str) -> Result<usize, String> {
    optional_number(of, name)?
        .ok_or_else(|| format!("its `{name}` is missing, and {WHOLE} would be read"))
}

/// A list, or none where the key is missing.
pub(super) fn list<'b, 'a>(of: &'b Json<'a>, name: &str) -> Result<&'b [Json<'a>], String> {
    match key(of, name) {
        None => Ok(&[]),
        Some(Json::List(list)) => Ok(list),
        Some(other) => Err(wrong(name, other, "a list")),
    }
}

/// A list of indices, or none where the key is missing.
pub(super) fn indices(of: &Json<'_>, name: &str) -> Result<Vec<usize>, String> {
    let index = |value: &Json<'_>| whole(value).ok_or_else(|| wrong_in(name, value, WHOLE));
    list(of, name)?.iter().map(index).collect()
}

fn wrong_in(name: &str, value: &Json<'_>, expected: &str) -> String {
    format!("in its `{name}` stands {}, and {expected} would be read", found(value))
}

/// So many numbers in single precision, or `None` where the key is missing.
pub(super) fn numbers<const N: usize>(
    of: &Json<'_>,
    name: &str,
) -> Result<Option<[f64; N]>, String> {
    let Some(value) = key(of, name) else {
        return Ok(None);
    };
    let expected = format!("a list of {N} numbers");
    let Some(list) = value.as_list().filter(|list| list.len() == N) else {
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
pub(super) fn text<'b>(of: &'b Json<'_>, name: &str) -> Option<&'b str> {
    key(of, name)?.as_str()
}

pub(super) fn is_true(of: &Json<'_>, name: &str) -> bool {
    key(of, name) == Some(&Json::Bool(true))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn json(text: &str) -> Json<'_> {
        Json::parse(text.as_bytes()).unwrap()
    }

    #[test]
    fn each_kind_that_a_key_should_not_hold_is_named_with_what_would_be_read() {
        for (value, shown) in [
            ("\"a\"", "`a`"),
            ("[1]", "a list"),
            ("{}", "an object"),
            ("-1", "`-1`"),
            ("1.5", "`1.5`"),
            ("true", "`true`"),
        ] {
            let text = format!("{{\"mesh\": {value}}}");
            let error = optional_number(&json(&text), "mesh").unwrap_err();
            let expected =
                format!("its `mesh` is {shown}, and a whole number from 0 would be read");
            assert_eq!(error, expected);
        }
        for absent in ["{}", "{\"mesh\": null}", "7"] {
            assert_eq!(optional_number(&json(absent), "mesh"), Ok(None));
            assert!(needed_number(&json(absent), "mesh").unwrap_err().contains("is missing"));
        }
        assert_eq!(optional_number(&json("{\"mesh\": 8.0}"), "mesh"), Ok(Some(8)));
        assert!(numbers::<3>(&json("{\"scale\": [1, 2]}"), "scale").is_err());
        let error = numbers::<1>(&json("{\"scale\": [\"1\"]}"), "scale").unwrap_err();
        assert_eq!(error, "in its `scale` stands `1`, and a number would be read");
    }

    #[test]
    fn a_document_that_is_no_gltf_2_says_what_it_is() {
        let reason = |json: &str| Document::parse(json.as_bytes()).err().unwrap();
        assert!(reason("{").starts_with("line 1, column 1: it is no valid JSON"));
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
