//! glTF extras (custom properties in Blender) that give a mesh a collider and tune it:
//! `{"collider": "convex_decomposition", "max_error": 0.01, "density": 500}`. No entities here.

use std::str::FromStr;

use hullwright::{Length, Method, Openings, Preset};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::names::ColliderKind;
use super::surface::SURFACE_SETTINGS;
use super::values::{Complaint, boolean, named};

/// The key that makes extras ours.
const COLLIDER: &str = "collider";

/// The settings that may stand beside it, and what they take.
const SETTINGS: [(&str, &str); 12] = [
    ("max_error", "a positive number, a share of the diagonal, or a length such as \"0.02m\""),
    ("preset", "\"fast\", \"balanced\" or \"fine\""),
    ("max_hulls", "a whole number from 1"),
    ("max_vertices", "a whole number from 8"),
    ("keep_cavities", "true or false"),
    ("openings", "\"auto\", \"keep\" or \"close\""),
    ("probe_radius", "a length such as \"0.1m\""),
    ("level_bound", "a length such as \"0.02m\", or 0"),
    ("density", "a positive number"),
    ("mass", "a positive number"),
    ("fallback", "\"none\", \"convex_hull\" or \"bounding_box\""),
    ("body", "\"dynamic\", \"fixed\" or \"kinematic\""),
];

/// What `collider` may say.
const KINDS: [(&str, Option<ColliderKind>); 8] = [
    ("convex_decomposition", Some(ColliderKind::Decomposition)),
    ("hulls", Some(ColliderKind::Hulls)),
    ("triangles", Some(ColliderKind::Triangles)),
    ("convex_hull", Some(ColliderKind::ConvexHull)),
    ("cuboid", Some(ColliderKind::Cuboid)),
    ("ball", Some(ColliderKind::Ball)),
    ("capsule", Some(ColliderKind::Capsule)),
    ("none", None),
];

/// What `fallback` may say.
const FALLBACKS: [(&str, Fallback); 3] = [
    ("none", Fallback::None),
    ("convex_hull", Fallback::ConvexHull),
    ("bounding_box", Fallback::BoundingBox),
];

/// What `body` may say.
const BODIES: [(&str, Body); 3] =
    [("dynamic", Body::Dynamic), ("fixed", Body::Fixed), ("kinematic", Body::Kinematic)];

/// A collider until the entity's own is ready.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fallback {
    /// None.
    None,
    /// The convex hull of the mesh.
    ConvexHull,
    /// The box along the mesh's axes.
    BoundingBox,
}

/// A body that a mesh becomes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Body {
    /// One that moves by itself.
    Dynamic,
    /// One that never moves.
    Fixed,
    /// One that the game moves.
    Kinematic,
}

/// The collider that extras request. `None` leaves a setting to the scene.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ExtrasTag {
    /// What the collider is made of; `None` for no collider.
    pub kind: Option<ColliderKind>,
    /// The bound.
    pub max_error: Option<Length>,
    /// How much work is put into few hulls.
    pub preset: Option<Preset>,
    /// Most hulls, at least 1.
    pub max_hulls: Option<u32>,
    /// Most vertices of a hull, at least 8.
    pub max_vertices: Option<u32>,
    /// Whether cavities that nothing from outside can enter stay empty.
    pub keep_cavities: Option<bool>,
    /// What becomes of flat openings.
    pub openings: Option<Openings>,
    /// Half the thickness of the thinnest thing that moves, in units of the world; positive.
    pub probe_radius: Option<f32>,
    /// How far the triangles of what never moves may be from the mesh, in units of the world; 0 for
    /// those of the mesh.
    pub level_bound: Option<f32>,
    /// Mass per cubed unit; positive.
    pub density: Option<f32>,
    /// Mass, instead of a density; positive.
    pub mass: Option<f32>,
    /// The collider until the entity's own is ready.
    pub fallback: Option<Fallback>,
    /// The body that the mesh becomes, so that it moves on its own and not with what is above it.
    pub body: Option<Body>,
}

/// Reads extras. `None` if they say nothing about colliders, or are no JSON. Settings that are
/// wrong are left out, and each has a complaint, as has a key that is almost that of a setting.
/// Other keys are somebody else's, or those of [`read_surface`](super::read_surface).
///
/// ```
/// use hullwright::Length;
/// use hullwright_formats::conventions::read_extras;
///
/// let (tag, complaints) = read_extras(r#"{"collider": "hulls", "max_error": 0.01, "masss": 3}"#);
/// assert_eq!(tag.map(|tag| tag.max_error), Some(Some(Length::share(0.01))));
/// assert!(complaints[0].starts_with("\"masss\" is no setting of a collider"));
/// ```
pub fn read_extras(text: &str) -> (Option<ExtrasTag>, Vec<Complaint>) {
    let mut complaints = Vec::new();
    let Ok(Value::Object(extras)) = serde_json::from_str(text) else { return (None, complaints) };
    let Some(collider) = extras.get(COLLIDER) else {
        complaints.extend(settings_without_collider(&extras));
        return (None, complaints);
    };
    let Some(kind) = named(collider, &KINDS) else {
        let kinds: Vec<String> = KINDS.iter().map(|(name, _)| format!("\"{name}\"")).collect();
        complaints.push(format!("\"{COLLIDER}\" is {collider}; it may be {}", kinds.join(", ")));
        return (None, complaints);
    };
    let mut tag = ExtrasTag { kind, ..ExtrasTag::default() };
    for (key, value) in extras.iter().filter(|(key, _)| *key != COLLIDER) {
        let Some((_, expected)) = SETTINGS.iter().find(|(name, _)| name == key) else {
            let is_known = SURFACE_SETTINGS.iter().any(|(name, ..)| name == key);
            if is_known || !all_settings().any(|name| is_misspelt(key, name)) {
                continue;
            }
            complaints.push(format!("\"{key}\" is no setting of a collider; {}", all_keys()));
            continue;
        };
        if tag.set(key, value).is_none() {
            complaints
                .push(format!("\"{key}\" is {value}, and should be {expected}; {}", all_keys()));
        }
    }
    (Some(tag), complaints)
}

/// A complaint about settings that only we have, where the collider is missing.
fn settings_without_collider(extras: &Map<String, Value>) -> Option<Complaint> {
    let ours = ["max_error", "max_hulls", "max_vertices", "keep_cavities"];
    let has_body = extras.get("body").is_some_and(|body| named(body, &BODIES).is_some());
    let key = ours.into_iter().find(|key| extras.contains_key(*key));
    let key = key.or(has_body.then_some("body"))?;
    let missing = format!("add \"{COLLIDER}\": \"convex_decomposition\"");
    Some(format!("\"{key}\" says nothing without \"{COLLIDER}\": {missing}; {}", all_keys()))
}

/// Whether a key is a setting's with few letters wrong: at most two, and a third of them.
fn is_misspelt(key: &str, setting: &str) -> bool {
    let most = (setting.len() / 3).min(2);
    key.len().abs_diff(setting.len()) <= most && edits(key, setting) <= most
}

/// How many letters are inserted, removed or replaced between two words (Levenshtein 1966).
/// O(product of lengths).
fn edits(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, a) in a.chars().enumerate() {
        let mut diagonal = std::mem::replace(&mut row[0], i + 1);
        for (j, b) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(a != *b);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

fn all_settings() -> impl Iterator<Item = &'static str> {
    let of_surfaces = SURFACE_SETTINGS.iter().map(|(name, ..)| *name);
    SETTINGS.iter().map(|(name, _)| *name).chain(of_surfaces)
}

fn all_keys() -> String {
    let keys: Vec<&str> = std::iter::once(COLLIDER).chain(all_settings()).collect();
    format!("the keys are {}", keys.join(", "))
}

impl ExtrasTag {
    /// What its hulls are made with; `None` where no hulls are made. `base` is for what it says
    /// nothing of.
    pub fn parameters(&self, base: &Method) -> Option<Method> {
        let kind = self.kind?;
        let mut parameters = base.bounded_parameters();
        parameters.max_error = self.max_error.unwrap_or(parameters.max_error);
        parameters.preset = self.preset.unwrap_or(parameters.preset);
        parameters.openings = self.openings.unwrap_or(parameters.openings);
        parameters.keep_cavities = self.keep_cavities.unwrap_or(parameters.keep_cavities);
        parameters.max_hulls = self.max_hulls.map(|limit| limit as usize).or(parameters.max_hulls);
        // In single precision, as engines have it, but as it is written.
        let probe_radius = self.probe_radius.and_then(|radius| radius.to_string().parse().ok());
        parameters.probe_radius = probe_radius.map(Length::Units).or(parameters.probe_radius);
        let max_vertices = self.max_vertices.map(|limit| limit as usize);
        parameters.max_vertices = max_vertices.or(parameters.max_vertices);
        kind.parameters(&match base {
            Method::Bounded(_) => Method::Bounded(parameters),
            Method::Hull(_) => Method::Hull(parameters),
            Method::Surface(_) if kind == ColliderKind::ConvexHull => Method::Hull(parameters),
            Method::Surface(surface) => {
                let mut surface = surface.clone();
                surface.max_vertices = parameters.max_vertices;
                Method::Surface(surface)
            }
        })
    }

    /// `None` if the value means nothing.
    fn set(&mut self, key: &str, value: &Value) -> Option<()> {
        match key {
            "max_error" => self.max_error = Some(length(value)?),
            "preset" => self.preset = Some(parsed(value)?),
            "max_hulls" => self.max_hulls = Some(whole(value, 1)?),
            "max_vertices" => self.max_vertices = Some(whole(value, LEAST_VERTICES)?),
            "keep_cavities" => self.keep_cavities = Some(boolean(value)?),
            "openings" => self.openings = Some(parsed(value)?),
            "probe_radius" => self.probe_radius = Some(units(value)?),
            "level_bound" if value.as_f64() == Some(0.0) => self.level_bound = Some(0.0),
            "level_bound" => self.level_bound = Some(units(value)?),
            "density" => self.density = Some(positive(value)? as f32),
            "mass" => self.mass = Some(positive(value)? as f32),
            "fallback" => self.fallback = Some(named(value, &FALLBACKS)?),
            "body" => self.body = Some(named(value, &BODIES)?),
            _ => return None,
        }
        Some(())
    }
}

/// The least that [`Parameters::validate`](hullwright::Parameters::validate) accepts.
const LEAST_VERTICES: u32 = 8;

fn positive(value: &Value) -> Option<f64> {
    value.as_f64().filter(|x| x.is_finite() && *x > 0.0)
}

fn whole(value: &Value, least: u32) -> Option<u32> {
    // Blender writes some whole numbers as 8.0.
    let number = value.as_f64().filter(|x| x.fract() == 0.0 && *x >= f64::from(least))?;
    (number <= f64::from(u32::MAX)).then_some(number as u32)
}

fn length(value: &Value) -> Option<Length> {
    let length = match value {
        Value::String(text) => text.parse().ok()?,
        _ => Length::Share(positive(value)?),
    };
    let (Length::Share(number) | Length::Units(number)) = length;
    // Engines store settings in single precision: baked ones are rounded likewise, so that both are
    // equal.
    let number: f64 = (number as f32).to_string().parse().ok()?;
    let is_sound = number.is_finite() && number > 0.0;
    is_sound.then_some(match length {
        Length::Share(_) => Length::Share(number),
        Length::Units(_) => Length::Units(number),
    })
}

/// A length in units of the world, since a body that moves is no larger in a larger mesh.
fn units(value: &Value) -> Option<f32> {
    match length(value)? {
        Length::Units(units) => Some(units as f32),
        Length::Share(_) => None,
    }
}

fn parsed<T: FromStr>(value: &Value) -> Option<T> {
    value.as_str()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> ExtrasTag {
        let (tag, complaints) = read_extras(text);
        assert_eq!(complaints, Vec::<String>::new(), "{text}");
        tag.expect("a tag")
    }

    #[test]
    fn every_setting_is_read() {
        let tag = read(
            r#"{"collider": "convex_decomposition", "max_error": 0.01, "preset": "fine", "max_hulls": 8,
            "max_vertices": 32.0, "keep_cavities": 1, "openings": "keep", "probe_radius": "0.1m", "level_bound": "0.02m",
            "density": 500, "mass": 2.5,
            "fallback": "bounding_box", "body": "dynamic"}"#,
        );
        let expected = ExtrasTag {
            kind: Some(ColliderKind::Decomposition),
            max_error: Some(Length::Share(0.01)),
            preset: Some(Preset::Fine),
            max_hulls: Some(8),
            max_vertices: Some(32),
            keep_cavities: Some(true),
            openings: Some(Openings::Keep),
            probe_radius: Some(0.1),
            level_bound: Some(0.02),
            density: Some(500.0),
            mass: Some(2.5),
            fallback: Some(Fallback::BoundingBox),
            body: Some(Body::Dynamic),
        };
        assert_eq!(tag, expected);
    }

    #[test]
    fn a_bound_is_a_share_or_a_length() {
        for (text, length) in [
            ("0.01", Length::Share(0.01)),
            ("\"0.02m\"", Length::Units(0.02)),
            ("\"2%\"", Length::Share(0.02)),
        ] {
            let extras = format!(r#"{{"collider": "hulls", "max_error": {text}}}"#);
            assert_eq!(read(&extras).max_error, Some(length));
        }
    }

    #[test]
    fn every_kind_is_read() {
        for (name, kind) in KINDS {
            assert_eq!(read(&format!(r#"{{"collider": "{name}"}}"#)).kind, kind);
        }
    }

    #[test]
    fn a_wrong_value_is_left_out_and_the_complaint_lists_the_keys() {
        for (key, value) in [
            ("max_error", "0"),
            ("max_error", "\"0.02\""),
            ("max_error", "\"-1m\""),
            ("preset", "\"finest\""),
            ("max_hulls", "1.5"),
            ("max_hulls", "0"),
            ("max_vertices", "7"),
            ("keep_cavities", "\"yes\""),
            ("openings", "[]"),
            ("probe_radius", "0.1"),
            ("level_bound", "0.1"),
            ("level_bound", "-1"),
            ("level_bound", "\"1%\""),
            ("probe_radius", "\"6%\""),
            ("density", "-1"),
            ("mass", "null"),
            ("fallback", "\"box\""),
            ("body", "true"),
        ] {
            let text = format!(r#"{{"collider": "convex_decomposition", "{key}": {value}}}"#);
            let (tag, complaints) = read_extras(&text);
            let plain =
                ExtrasTag { kind: Some(ColliderKind::Decomposition), ..ExtrasTag::default() };
            assert_eq!(tag, Some(plain), "{text}");
            assert_eq!(complaints.len(), 1, "{text}");
            for (name, _) in SETTINGS {
                assert!(complaints[0].contains(name), "{complaints:?}");
            }
        }
    }

    #[test]
    fn an_unknown_key_is_named() {
        let (tag, complaints) = read_extras(r#"{"collider": "hulls", "maxerror": 0.01}"#);
        assert!(tag.is_some());
        assert!(complaints[0].starts_with("\"maxerror\" is no setting"), "{complaints:?}");
    }

    #[test]
    fn a_key_that_resembles_no_setting_is_somebody_elses() {
        for key in ["hp", "name", "loot_table", "max", "sound", "colour"] {
            let text = format!(r#"{{"collider": "hulls", "{key}": 3}}"#);
            assert_eq!(read_extras(&text).1, Vec::<String>::new(), "{key}");
        }
        for (key, setting) in [("max_eror", "max_error"), ("dencity", "density"), ("Mass", "mass")]
        {
            assert!(is_misspelt(key, setting), "{key}");
        }
    }

    #[test]
    fn an_unknown_collider_is_none_and_the_complaint_lists_those_that_there_are() {
        for value in ["3", "\"convex\"", "[]"] {
            let (tag, complaints) = read_extras(&format!(r#"{{"collider": {value}}}"#));
            assert_eq!(tag, None);
            assert!(complaints[0].contains("\"triangles\""), "{complaints:?}");
        }
    }

    #[test]
    fn extras_of_others_are_left_alone() {
        for text in [r#"{"mass": 1, "hp": 3}"#, r#"{"skein": []}"#, "[]", "", "{", "null"] {
            assert_eq!(read_extras(text), (None, Vec::new()), "{text}");
        }
    }

    #[test]
    fn a_setting_that_can_only_be_ours_complains_where_the_collider_is_missing() {
        for text in [r#"{"max_error": 0.01}"#, r#"{"body": "dynamic"}"#] {
            let (tag, complaints) = read_extras(text);
            assert_eq!((tag, complaints.len()), (None, 1));
            let missing = r#"add "collider": "convex_decomposition""#;
            assert!(complaints[0].contains(missing), "{complaints:?}");
        }
        // Somebody else's.
        assert_eq!(read_extras(r#"{"body": "female"}"#), (None, Vec::new()));
    }
}
