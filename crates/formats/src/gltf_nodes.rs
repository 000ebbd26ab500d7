//! Nodes of a glTF scene: their transforms, whether they are hidden, and their instances.

use glam::{DAffine3, DMat3, DMat4};

use super::gltf_extensions::{INSTANCING, VISIBILITY};
use super::gltf_json::{entries, extension, indices, key, numbers, optional_number};
use super::gltf_tree::Json;
use crate::vector::Vector;

/// Whether a node and all that is below it is hidden.
pub(super) fn is_hidden(node: &Json<'_>) -> bool {
    let visible = extension(node, VISIBILITY).and_then(|extension| key(extension, "visible"));
    visible == Some(&Json::Bool(false))
}

/// Of a 4×4 matrix the last row is taken as (0, 0, 0, 1).
pub(super) fn transform(node: &Json<'_>) -> Result<DAffine3, String> {
    Ok(match numbers(node, "matrix")? {
        Some(matrix) => affine(&matrix),
        None => transform_from_parts(
            numbers(node, "translation")?.unwrap_or_default(),
            numbers(node, "rotation")?.unwrap_or(NO_ROTATION),
            numbers(node, "scale")?.unwrap_or(NO_SCALE),
        ),
    })
}

/// A matrix by columns.
pub(super) fn affine(matrix: &[f64; 16]) -> DAffine3 {
    DAffine3::from_mat4(DMat4::from_cols_array(matrix))
}

const NO_ROTATION: [f64; 4] = [0.0, 0.0, 0.0, 1.0];
const NO_SCALE: [f64; 3] = [1.0; 3];

/// First scaled, then rotated by a quaternion (x, y, z, w), then moved.
fn transform_from_parts(translation: [f64; 3], rotation: [f64; 4], size: [f64; 3]) -> DAffine3 {
    let [x, y, z, w] = rotation;
    let length_squared = x * x + y * y + z * z + w * w;
    // A quaternion of length 0 or infinite turns nothing.
    let s = if length_squared.is_normal() { 2.0 / length_squared } else { 0.0 };
    let columns = [
        [1.0 - s * (y * y + z * z), s * (x * y + z * w), s * (x * z - y * w)],
        [s * (x * y - z * w), 1.0 - s * (x * x + z * z), s * (y * z + x * w)],
        [s * (x * z + y * w), s * (y * z - x * w), 1.0 - s * (x * x + y * y)],
    ];
    let [a, b, c] = [0, 1, 2].map(|axis| Vector::from(columns[axis]) * size[axis]);
    DAffine3 { matrix3: DMat3::from_cols(a, b, c), translation: Vector::from(translation) }
}

/// Accessors of a node's instances.
pub(super) struct Instances {
    pub(super) translation: Option<usize>,
    pub(super) rotation: Option<usize>,
    pub(super) scale: Option<usize>,
}

impl Instances {
    /// `None` for a node that stands once.
    pub(super) fn of(node: &Json<'_>) -> Result<Option<Self>, String> {
        let attributes = extension(node, INSTANCING).and_then(|found| key(found, "attributes"));
        let Some(attributes) = attributes else { return Ok(None) };
        let accessor = |name| optional_number(attributes, name);
        let instances = Self {
            translation: accessor("TRANSLATION")?,
            rotation: accessor("ROTATION")?,
            scale: accessor("SCALE")?,
        };
        let is_used = [instances.translation, instances.rotation, instances.scale];
        Ok(is_used.iter().any(Option::is_some).then_some(instances))
    }
}

/// The transforms of instances; of lists that are not there each element is the identity's.
pub(super) fn instance_transforms(
    translation: Option<Vec<[f64; 3]>>,
    rotation: Option<Vec<[f64; 4]>>,
    scale: Option<Vec<[f64; 3]>>,
) -> Result<Vec<DAffine3>, String> {
    let [t, r, s] = [
        translation.as_ref().map(Vec::len),
        rotation.as_ref().map(Vec::len),
        scale.as_ref().map(Vec::len),
    ];
    let count = t.or(r).or(s).unwrap_or(0);
    if [t, r, s].into_iter().flatten().any(|length| length != count) {
        return Err("its accessors are of different lengths, and one length would be read".into());
    }
    let at = |index: usize| {
        let translation = translation.as_ref().and_then(|list| list.get(index));
        let rotation = rotation.as_ref().and_then(|list| list.get(index));
        let scale = scale.as_ref().and_then(|list| list.get(index));
        transform_from_parts(
            translation.copied().unwrap_or_default(),
            rotation.copied().unwrap_or(NO_ROTATION),
            scale.copied().unwrap_or(NO_SCALE),
        )
    };
    Ok((0..count).map(at).collect())
}

/// Which nodes are below another.
pub(super) fn are_children(nodes: &[Json<'_>]) -> Vec<bool> {
    let mut is_child = vec![false; nodes.len()];
    for child in nodes.iter().flat_map(|node| indices(node, "children").unwrap_or_default()) {
        if let Some(is_child) = is_child.get_mut(child) {
            *is_child = true;
        }
    }
    is_child
}

/// The transforms of all nodes to their scene; `None` where a node is in no tree, or above it one
/// can't be read. O(nodes).
pub(super) fn global_transforms(nodes: &Json<'_>) -> Vec<Option<DAffine3>> {
    let nodes = entries(nodes);
    let roots = are_children(nodes).into_iter().enumerate().filter(|(_, is_child)| !is_child);
    let mut open: Vec<(usize, DAffine3)> =
        roots.map(|(root, _)| (root, DAffine3::IDENTITY)).collect();
    let mut globals = vec![None; nodes.len()];
    while let Some((index, parent)) = open.pop() {
        let (Some(node), Some(slot @ None)) = (nodes.get(index), globals.get_mut(index)) else {
            continue;
        };
        let Ok(local) = transform(node) else { continue };
        let global = parent * local;
        *slot = Some(global);
        let children = indices(node, "children").unwrap_or_default();
        open.extend(children.into_iter().map(|child| (child, global)));
    }
    globals
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scale_comes_before_rotation_and_translation() {
        let half = f64::from(std::f32::consts::FRAC_1_SQRT_2);
        let quarter_turn_about_z = [0.0, 0.0, half, half];
        let transform =
            transform_from_parts([10.0, 0.0, 0.0], quarter_turn_about_z, [2.0, 1.0, -1.0]);
        let placed = transform.transform_point3(Vector::new(1.0, 0.0, 5.0));
        assert!(placed.distance(Vector::new(10.0, 2.0, -5.0)) < 1e-6);
    }

    #[test]
    fn an_unnormalised_quaternion_only_turns() {
        let transform = transform_from_parts([0.0; 3], [0.0, 0.0, 3.0, 0.0], [1.0; 3]);
        let placed = transform.transform_point3(Vector::new(1.0, 2.0, 3.0));
        assert_eq!(placed, Vector::new(-1.0, -2.0, 3.0));
        assert_eq!(transform_from_parts([0.0; 3], [0.0; 4], [1.0; 3]), DAffine3::IDENTITY);
    }

    #[test]
    fn nodes_that_are_no_tree_have_no_place_and_take_no_time() {
        let nodes = r#"[
            {"translation": [1, 0, 0], "children": [1, 1, 9]},
            {"translation": [0, 2, 0]},
            {"children": [3]},
            {"children": [2]},
            {"children": [5], "scale": "large"},
            {}
        ]"#;
        let nodes = Json::parse(nodes.as_bytes()).unwrap();
        let places: Vec<Option<Vector>> =
            global_transforms(&nodes).iter().map(|at| at.map(|at| at.translation)).collect();
        let (first, second) = (Vector::new(1.0, 0.0, 0.0), Vector::new(1.0, 2.0, 0.0));
        assert_eq!(places, [Some(first), Some(second), None, None, None, None]);
    }
}
