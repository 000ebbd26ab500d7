//! Colliders by the names of nodes and meshes.

use hullwright::{Method, Parameters};

/// What a collider is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColliderKind {
    /// Hulls within the bound, or the triangles of what never moves.
    Decomposition,
    /// Hulls within the bound, also of what never moves.
    Hulls,
    /// The triangles themselves.
    Triangles,
    /// One hull around everything.
    ConvexHull,
    /// The box along the mesh's axes.
    Cuboid,
    /// The ball around that box's middle.
    Ball,
    /// The capsule along that box's longest side.
    Capsule,
}

impl ColliderKind {
    /// What hulls of this kind are made with; `None` where no hulls are made. `base` is for what
    /// the artist says nothing of.
    pub fn parameters(self, base: &Method) -> Option<Method> {
        match self {
            Self::Decomposition | Self::Hulls => Some(base.clone()),
            Self::ConvexHull => {
                let Parameters { max_vertices, openings, .. } = base.bounded_parameters();
                Some(Method::Hull(
                    Parameters::default().with_max_vertices(max_vertices).with_openings(openings),
                ))
            }
            Self::Triangles | Self::Cuboid | Self::Ball | Self::Capsule => None,
        }
    }
}

/// The collider that a name requests.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NameTag<'a> {
    /// A collider for this mesh, which is still drawn.
    Collider(ColliderKind),
    /// A collider instead of this mesh, which is not drawn.
    ColliderOnly(ColliderKind),
    /// A collider for this mesh, which is a body that moves by itself.
    Body(ColliderKind),
    /// The mesh is itself a piece of the collider of another, and not drawn. [`whole_of`] says
    /// which.
    PieceOf {
        /// What follows the prefix.
        rest: &'a str,
        /// What the piece is.
        kind: ColliderKind,
    },
    /// No mesh of the game, with all below it: neither collided with nor drawn.
    LeftOut,
}

impl NameTag<'_> {
    /// What the collider is made of; `None` for no collider.
    pub fn kind(self) -> Option<ColliderKind> {
        match self {
            Self::Collider(kind) | Self::ColliderOnly(kind) | Self::Body(kind) => Some(kind),
            Self::PieceOf { kind, .. } => Some(kind),
            Self::LeftOut => None,
        }
    }
}

/// Suffixes of nodes, each after those that contain it. Of Godot's others, `-occ` and `-vcol` leave
/// a mesh as it is, and `-vehicle`, `-wheel`, `-loop` and `-cycle` are about other things than
/// colliders.
const NODE_SUFFIXES: [(&str, NameTag<'static>); 10] = [
    ("noimp", NameTag::LeftOut),
    ("colonly", NameTag::ColliderOnly(ColliderKind::Triangles)),
    ("convcolonly", NameTag::ColliderOnly(ColliderKind::ConvexHull)),
    ("convdecomponly", NameTag::ColliderOnly(ColliderKind::Decomposition)),
    ("rigid", NameTag::Body(ColliderKind::ConvexHull)),
    MESH_SUFFIXES[0],
    MESH_SUFFIXES[1],
    MESH_SUFFIXES[2],
    ("navmesh", NameTag::LeftOut),
    ("occonly", NameTag::LeftOut),
];

/// Suffixes that Godot also reads from the names of meshes.
const MESH_SUFFIXES: [(&str, NameTag<'static>); 3] = [
    ("col", NameTag::Collider(ColliderKind::Triangles)),
    ("convcol", NameTag::Collider(ColliderKind::ConvexHull)),
    ("convdecomp", NameTag::Collider(ColliderKind::Decomposition)),
];

/// Unreal's prefixes: `UCX_Chair`, or `UCX_Chair_01` where there are several.
const PREFIXES: [(&str, ColliderKind); 4] = [
    ("UCX_", ColliderKind::ConvexHull),
    ("UBX_", ColliderKind::Cuboid),
    ("USP_", ColliderKind::Ball),
    ("UCP_", ColliderKind::Capsule),
];

/// The collider that the name of a node requests.
///
/// ```
/// use hullwright_formats::conventions::{ColliderKind, NameTag, node_tag};
///
/// assert_eq!(node_tag("chair-convdecomp"), Some(NameTag::Collider(ColliderKind::Decomposition)));
/// assert_eq!(node_tag("chair"), None);
/// ```
pub fn node_tag(name: &str) -> Option<NameTag<'_>> {
    piece_tag(name).or_else(|| suffix_tag(name, &NODE_SUFFIXES))
}

/// The collider that the name of a mesh requests, where that of its node requests none.
pub fn mesh_tag(name: &str) -> Option<NameTag<'_>> {
    piece_tag(name).or_else(|| suffix_tag(name, &MESH_SUFFIXES))
}

fn piece_tag(name: &str) -> Option<NameTag<'_>> {
    let name = without_copy_number(name);
    PREFIXES.iter().find_map(|(prefix, kind)| {
        let (head, rest) = name.split_at_checked(prefix.len())?;
        let is_piece = head.eq_ignore_ascii_case(prefix) && !rest.is_empty();
        is_piece.then_some(NameTag::PieceOf { rest, kind: *kind })
    })
}

fn suffix_tag(name: &str, suffixes: &[(&str, NameTag<'static>)]) -> Option<NameTag<'static>> {
    // Godot writes `_` for the dot of a copy's number.
    let is_number = |c: char| c.is_ascii_digit() || c <= ' ' || c == '_' || c == '.';
    let name = name.trim_end_matches(is_number).to_ascii_lowercase();
    let has = |suffix: &str| {
        let before = name.strip_suffix(suffix);
        // Where a dollar marks it, it may stand anywhere.
        before.is_some_and(|before| before.ends_with(['-', '_']))
            || name.match_indices(suffix).any(|(at, _)| name[..at].ends_with('$'))
    };
    suffixes.iter().find(|(suffix, _)| has(suffix)).map(|(_, tag)| *tag)
}

/// The mesh that a piece belongs to: that of the whole rest of its name, else of the rest up to its
/// last underscore, whatever comes after it. `exists` says whether there is a mesh of a name.
pub fn whole_of(rest: &str, exists: impl Fn(&str) -> bool) -> &str {
    match rest.rsplit_once('_') {
        Some((head, _)) if !exists(rest) => head,
        _ => rest,
    }
}

/// Blender gives a copy the name of the original with `.001`.
pub fn without_copy_number(name: &str) -> &str {
    match name.rsplit_once('.') {
        Some((rest, number)) if is_number(number) => rest,
        _ => name,
    }
}

/// The level of detail that a name ends in, and what comes before it: `tree_LOD2` is level 2 of
/// `tree`. `None` for a name without.
///
/// ```
/// use hullwright_formats::conventions::level_of_detail;
///
/// assert_eq!(level_of_detail("tree_LOD2"), Some(("tree", 2)));
/// assert_eq!(level_of_detail("tree"), None);
/// ```
pub fn level_of_detail(name: &str) -> Option<(&str, u32)> {
    let name = without_copy_number(name);
    let before_number = name.trim_end_matches(|c: char| c.is_ascii_digit());
    let level = name.get(before_number.len()..)?.parse().ok()?;
    let at = before_number.len().checked_sub(LEVEL.len())?;
    let (stem, mark) = before_number.split_at_checked(at)?;
    let stem = stem.strip_suffix(['_', '-', '.', ' '])?;
    (mark.eq_ignore_ascii_case(LEVEL) && !stem.is_empty()).then_some((stem, level))
}

/// What stands before the number of a level of detail, as Unreal, Unity and Blender's exporters
/// write it.
const LEVEL: &str = "lod";

/// Whether a name is that of a coarser level of detail of a mesh that `others` have, too. A coarse
/// level alone is all that there is of the mesh.
pub fn is_coarser_level<'a>(name: &str, others: impl IntoIterator<Item = &'a str>) -> bool {
    let Some((stem, level)) = level_of_detail(name) else { return false };
    others.into_iter().any(|other| match level_of_detail(other) {
        Some((of, finer)) => finer < level && of.eq_ignore_ascii_case(stem),
        None => level > 0 && without_copy_number(other).eq_ignore_ascii_case(stem),
    })
}

fn is_number(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn suffixes_are_read_as_godot_4_does() {
        use ColliderKind::{ConvexHull, Decomposition, Triangles};
        for (name, tag) in [
            ("chair-col", NameTag::Collider(Triangles)),
            ("chair-convcol", NameTag::Collider(ConvexHull)),
            ("chair-colonly", NameTag::ColliderOnly(Triangles)),
            ("chair-convcolonly", NameTag::ColliderOnly(ConvexHull)),
            ("chair-rigid", NameTag::Body(ConvexHull)),
            ("chair-noimp", NameTag::LeftOut),
            ("chair-navmesh", NameTag::LeftOut),
            ("chair-occonly", NameTag::LeftOut),
            ("chair-convdecomp", NameTag::Collider(Decomposition)),
            ("chair-convdecomponly", NameTag::ColliderOnly(Decomposition)),
        ] {
            let (chair, suffix) = name.split_once('-').unwrap();
            for spelled in [
                name.to_owned(),
                format!("{chair}_{suffix}"),
                format!("{chair}${suffix}"),
                name.to_uppercase(),
                format!("{name}.003"),
                format!("{name}_2"),
                format!("{name} 7 "),
                format!("{chair}${suffix}-leg"),
            ] {
                assert_eq!(node_tag(&spelled), Some(tag), "{spelled}");
            }
        }
    }

    #[test]
    fn a_level_of_detail_is_coarser_where_there_is_a_finer_one() {
        for (name, expected) in [
            ("tree_LOD0", Some(("tree", 0))),
            ("old tree_lod12", Some(("old tree", 12))),
            ("tree-LOD1.003", Some(("tree", 1))),
            ("tree_LOD", None),
            ("LOD1", None),
            ("melodies1", None),
            ("tree_LOD99999999999", None),
            ("ß_LOD1", Some(("ß", 1))),
            ("ßlod1", None),
        ] {
            assert_eq!(level_of_detail(name), expected, "{name}");
        }
        assert!(is_coarser_level("tree_LOD1", ["rock", "tree_LOD0"]));
        assert!(is_coarser_level("tree_LOD2", ["Tree"]));
        for others in [&["tree_LOD2"][..], &["bush_LOD0"], &[]] {
            assert!(!is_coarser_level("tree_LOD1", others.iter().copied()), "{others:?}");
        }
        // Both are the finest.
        assert!(!is_coarser_level("tree_LOD0", ["tree", "tree_LOD0"]));
    }

    #[test]
    fn other_names_ask_for_nothing() {
        for name in [
            "chair",
            "convcol",
            "col",
            "",
            "-",
            "$",
            "_",
            "123",
            "protocol",
            "chair-col-leg",
            "chair-occ",
            "chair-vehicle",
            "chair.col",
            "stühle",
            "UCX_",
            "UCX",
            "ucs_chair",
            "Ü_x",
        ] {
            assert_eq!(node_tag(name), None, "{name}");
        }
    }

    #[test]
    fn a_meshs_name_asks_for_a_collider_beside_it_only() {
        assert_eq!(mesh_tag("chair-convcol"), Some(NameTag::Collider(ColliderKind::ConvexHull)));
        for name in ["chair-colonly", "chair-rigid", "chair-noimp"] {
            assert_eq!(mesh_tag(name), None, "{name}");
        }
    }

    #[test]
    fn a_prefix_names_the_mesh_that_it_is_a_piece_of() {
        for (name, rest, kind) in [
            ("UCX_chair", "chair", ColliderKind::ConvexHull),
            ("UBX_chair_01", "chair_01", ColliderKind::Cuboid),
            ("usp_chair_2.001", "chair_2", ColliderKind::Ball),
            ("UCP_chair_leg", "chair_leg", ColliderKind::Capsule),
        ] {
            assert_eq!(node_tag(name), Some(NameTag::PieceOf { rest, kind }));
        }
    }

    #[test]
    fn a_piece_belongs_to_the_longest_name_that_there_is() {
        let exists = |name: &str| ["chair", "chair_leg", "box_01"].contains(&name);
        for (rest, whole) in [
            ("chair", "chair"),
            ("chair_01", "chair"),
            ("chair_top", "chair"),
            ("chair_leg", "chair_leg"),
            ("chair_leg_03", "chair_leg"),
            ("box_01", "box_01"),
            ("lamp", "lamp"),
        ] {
            assert_eq!(whole_of(rest, exists), whole);
        }
    }
}
