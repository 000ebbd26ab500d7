//! Names and extras by which artists ask for colliders: Godot's `-convcol`, Unreal's `UCX_`, and
//! `{"collider": "convex_decomposition"}` in glTF extras (custom properties in Blender).

/// What a name asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NameTag<'a> {
    /// A decomposition of this mesh.
    Decompose,
    /// The mesh is itself a convex piece of the collider of the mesh with this name.
    PieceOf(&'a str),
}

/// Godot's import suffixes. There `-convcolonly` also removes the drawn mesh; here both only ask for
/// a collider.
const SUFFIXES: [&str; 2] = ["-convcol", "-convcolonly"];

/// Unreal's prefix: `UCX_Chair`, or `UCX_Chair_01` where there are several.
const PREFIX: &str = "UCX_";

/// What a name asks for, if anything.
pub fn name_tag(name: &str) -> Option<NameTag<'_>> {
    let name = without_copy_number(name);
    if let Some(rest) = name.strip_prefix(PREFIX) {
        return Some(NameTag::PieceOf(without_piece_number(rest)));
    }
    SUFFIXES.iter().any(|suffix| name.ends_with(suffix)).then_some(NameTag::Decompose)
}

/// Blender gives a copy the name of the original with `.001`.
pub fn without_copy_number(name: &str) -> &str {
    match name.rsplit_once('.') {
        Some((rest, number)) if is_number(number) => rest,
        _ => name,
    }
}

fn without_piece_number(name: &str) -> &str {
    match name.rsplit_once('_') {
        Some((rest, number)) if is_number(number) => rest,
        _ => name,
    }
}

fn is_number(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit())
}

/// What extras ask for: whether to decompose. `None` if they say nothing, or are no JSON.
#[cfg(any(feature = "bevy_gltf", feature = "io"))]
pub fn extras_tag(extras: &str) -> Option<bool> {
    let value: serde_json::Value = serde_json::from_str(extras).ok()?;
    match value.get("collider")?.as_str()? {
        "convex_decomposition" => Some(true),
        "none" => Some(false),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn suffixes_ask_for_a_decomposition() {
        for name in ["chair-convcol", "chair-convcol.003", "chair-convcolonly"] {
            assert_eq!(name_tag(name), Some(NameTag::Decompose));
        }
        for name in ["chair", "convcol", "chair-convcol-lamp", "chair-col", ""] {
            assert_eq!(name_tag(name), None);
        }
    }

    #[test]
    fn a_prefix_names_the_mesh_that_it_is_a_piece_of() {
        for name in ["UCX_chair", "UCX_chair_01", "UCX_chair_2.001"] {
            assert_eq!(name_tag(name), Some(NameTag::PieceOf("chair")));
        }
        assert_eq!(name_tag("UCX_chair_leg_03"), Some(NameTag::PieceOf("chair_leg")));
    }

    #[cfg(any(feature = "bevy_gltf", feature = "io"))]
    #[test]
    fn extras_ask_for_or_against_it() {
        assert_eq!(extras_tag(r#"{"collider": "convex_decomposition", "hp": 3}"#), Some(true));
        assert_eq!(extras_tag(r#"{"collider": "none"}"#), Some(false));
        for extras in [r#"{"collider": 3}"#, r#"{"mass": 1}"#, "[]", "", "{"] {
            assert_eq!(extras_tag(extras), None);
        }
    }
}
