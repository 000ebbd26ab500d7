//! The JSON of a glTF document as a tree of the keys that geometry needs.
//!
//! All other keys are skipped as they are read, and text stays where it is in the file: a document
//! has mostly keys of materials, animations and bounds. An object has few keys therefore, whatever
//! the file holds.

use std::borrow::Cow;
use std::fmt::{self, Formatter};

use serde::de::{Deserialize, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde_json::value::RawValue;

/// Custom properties, which are kept as they are written.
const EXTRAS: &str = "extras";

/// The keys that are kept, the shorter first, so that few texts are compared to find one.
const KEYS: [&str; 68] = [
    "uri",
    "mesh",
    "mode",
    "name",
    "node",
    "skin",
    "type",
    "SCALE",
    "asset",
    "count",
    "nodes",
    "scale",
    "scene",
    "skins",
    "buffer",
    EXTRAS,
    "filter",
    "joints",
    "matrix",
    "meshes",
    "scenes",
    "sparse",
    "values",
    "buffers",
    "indices",
    "targets",
    "version",
    "visible",
    "weights",
    "JOINTS_0",
    "JOINTS_1",
    "JOINTS_2",
    "JOINTS_3",
    "POSITION",
    "ROTATION",
    "children",
    "collider",
    "fallback",
    "geometry",
    "material",
    "rotation",
    "WEIGHTS_0",
    "WEIGHTS_1",
    "WEIGHTS_2",
    "WEIGHTS_3",
    "accessors",
    "materials",
    "attributes",
    "bufferView",
    "byteLength",
    "byteOffset",
    "byteStride",
    "extensions",
    "normalized",
    "primitives",
    "TRANSLATION",
    "bufferViews",
    "doubleSided",
    "translation",
    "componentType",
    "extensionsRequired",
    "KHR_node_visibility",
    "inverseBindMatrices",
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "KHR_meshopt_compression",
    "KHR_physics_rigid_bodies",
    "KHR_draco_mesh_compression",
];

/// A value. A whole number that is not negative is exact.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Json<'a> {
    Null,
    Bool(bool),
    Whole(u64),
    Number(f64),
    Text(Cow<'a, str>),
    List(Vec<Json<'a>>),
    /// Known keys, of each the last value.
    Object(Vec<(&'static str, Json<'a>)>),
    Extras(&'a str),
}

impl<'a> Json<'a> {
    pub(super) fn parse(text: &'a [u8]) -> Result<Self, String> {
        serde_json::from_slice(text).map_err(|error| {
            let reason = error.to_string();
            let reason = reason.split(" at line ").next().unwrap_or_default();
            let place = format!("line {}, column {}", error.line(), error.column());
            format!("{place}: it is no valid JSON: {reason}")
        })
    }

    /// What a key of an object holds.
    pub(super) fn get(&self, key: &str) -> Option<&Self> {
        let Self::Object(entries) = self else { return None };
        entries.iter().find(|(known, _)| *known == key).map(|(_, value)| value)
    }

    pub(super) fn as_str(&self) -> Option<&str> {
        match self {
            Self::Text(text) => Some(text),
            _ => None,
        }
    }

    pub(super) fn as_list(&self) -> Option<&[Self]> {
        match self {
            Self::List(list) => Some(list),
            _ => None,
        }
    }

    pub(super) fn as_f64(&self) -> Option<f64> {
        match self {
            Self::Whole(number) => Some(*number as f64),
            Self::Number(number) => Some(*number),
            _ => None,
        }
    }
}

impl<'de: 'a, 'a> Deserialize<'de> for Json<'a> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(JsonVisitor)
    }
}

struct JsonVisitor;

impl<'de> Visitor<'de> for JsonVisitor {
    type Value = Json<'de>;

    fn expecting(&self, formatter: &mut Formatter<'_>) -> fmt::Result {
        formatter.write_str("any value")
    }

    fn visit_unit<E: Error>(self) -> Result<Json<'de>, E> {
        Ok(Json::Null)
    }

    fn visit_bool<E: Error>(self, value: bool) -> Result<Json<'de>, E> {
        Ok(Json::Bool(value))
    }

    fn visit_u64<E: Error>(self, number: u64) -> Result<Json<'de>, E> {
        Ok(Json::Whole(number))
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<Json<'de>, E> {
        Ok(Json::Number(number as f64))
    }

    fn visit_f64<E: Error>(self, number: f64) -> Result<Json<'de>, E> {
        Ok(Json::Number(number))
    }

    fn visit_borrowed_str<E: Error>(self, text: &'de str) -> Result<Json<'de>, E> {
        Ok(Json::Text(Cow::Borrowed(text)))
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Json<'de>, E> {
        Ok(Json::Text(Cow::Owned(text.to_owned())))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Json<'de>, A::Error> {
        let mut values = Vec::new();
        while let Some(value) = list.next_element()? {
            values.push(value);
        }
        Ok(Json::List(values))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Json<'de>, A::Error> {
        let mut entries: Vec<(&'static str, Json<'de>)> = Vec::new();
        while let Some(Key(key)) = map.next_key()? {
            let value = match key {
                None => {
                    map.next_value::<IgnoredAny>()?;
                    continue;
                }
                Some(EXTRAS) => match map.next_value::<&RawValue>()?.get() {
                    "null" => Json::Null,
                    text => Json::Extras(text),
                },
                Some(_) => map.next_value()?,
            };
            let Some(key) = key else { continue };
            match entries.iter_mut().find(|(known, _)| *known == key) {
                Some((_, before)) => *before = value,
                None => entries.push((key, value)),
            }
        }
        Ok(Json::Object(entries))
    }
}

/// A key that is kept, or `None`.
struct Key(Option<&'static str>);

impl<'de> Deserialize<'de> for Key {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_str(KeyVisitor)
    }
}

fn kept(key: &str) -> Option<&'static str> {
    let order = |known: &&str| known.len().cmp(&key.len()).then_with(|| (*known).cmp(key));
    KEYS.binary_search_by(order).ok().and_then(|at| KEYS.get(at).copied())
}

struct KeyVisitor;

impl Visitor<'_> for KeyVisitor {
    type Value = Key;

    fn expecting(&self, formatter: &mut Formatter<'_>) -> fmt::Result {
        formatter.write_str("a key")
    }

    fn visit_str<E: Error>(self, key: &str) -> Result<Key, E> {
        Ok(Key(kept(key)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_in_order_so_that_each_is_found() {
        assert!(KEYS.iter().all(|key| kept(key) == Some(*key)));
        assert_eq!((kept(""), kept("Mesh"), kept("min")), (None, None, None));
    }

    #[test]
    fn what_is_needed_is_kept_and_the_rest_is_skipped() {
        let text = r#"{"nodes": [{"mesh": 1, "name": "a\n", "camera": {"mesh": 2}, "scale": [1, -2, 0.5]}],
            "animations": [[[]]], "extras": {"b":  [ 1.50 ]}, "mesh": null, "mesh": 18446744073709551615}"#;
        let json = Json::parse(text.as_bytes()).unwrap();
        let node = &json.get("nodes").and_then(Json::as_list).unwrap()[0];
        assert_eq!(node.get("name").and_then(Json::as_str), Some("a\n"));
        assert_eq!(node.get("camera"), None);
        let scale: Vec<f64> = node
            .get("scale")
            .and_then(Json::as_list)
            .unwrap()
            .iter()
            .filter_map(Json::as_f64)
            .collect();
        assert_eq!(scale, [1.0, -2.0, 0.5]);
        assert_eq!(json.get("mesh"), Some(&Json::Whole(u64::MAX)));
        assert_eq!(json.get("extras"), Some(&Json::Extras(r#"{"b":  [ 1.50 ]}"#)));
        assert_eq!(json.get("animations"), None);
        for broken in ["", "{", "[1,]", "{\"a\" 1}", "{} 1", "{\"nodes\": 1e999}", "nan"] {
            let error = Json::parse(broken.as_bytes()).unwrap_err();
            assert!(error.contains("it is no valid JSON: "), "{error}");
        }
        let deep = "[".repeat(100_000);
        assert!(Json::parse(deep.as_bytes()).unwrap_err().contains("recursion limit"));
    }
}
