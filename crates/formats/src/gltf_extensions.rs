//! Which extensions a file may require: those that are read, and those that move no vertex.

use super::gltf_data::{DRACO, MESHOPT};
use super::text::quote;

pub(super) const VISIBILITY: &str = "KHR_node_visibility";
pub(super) const INSTANCING: &str = "EXT_mesh_gpu_instancing";

/// Those that are read, besides meshoptimizer's.
const READ: [&str; 4] = ["KHR_mesh_quantization", DRACO, VISIBILITY, INSTANCING];

/// Those that don't change where vertices are: physics, behaviour, animation, metadata, avatars,
/// levels of detail, and triangles' properties.
const HARMLESS: [&str; 26] = [
    "AGI_stk_metadata",
    "ASOBO_normal_map_convention",
    "ASOBO_tags",
    "BLENDER_physics",
    "CESIUM_primitive_outline",
    "EXT_instance_features",
    "EXT_mesh_features",
    "EXT_mesh_manifold",
    "EXT_structural_metadata",
    "FB_geometry_metadata",
    "GODOT_single_root",
    "GRIFFEL_bim_data",
    "KHR_animation_pointer",
    "KHR_gaussian_splatting",
    "KHR_implicit_shapes",
    "KHR_interactivity",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "MOZ_hubs_components",
    "MOZ_lightmap",
    "MSFT_audio_emitter",
    "MSFT_collision_primitives",
    "MSFT_lod",
    "MSFT_physics",
    "MSFT_rigid_bodies",
    "VRM",
];

/// The same, by the beginning of their name: materials, textures, lights, cameras, and whole
/// families.
const HARMLESS_FAMILIES: [&str; 19] = [
    "ADOBE_materials_",
    "EXT_camera",
    "EXT_lights_",
    "EXT_materials_",
    "EXT_texture_",
    "KHR_audio",
    "KHR_camera",
    "KHR_lights_",
    "KHR_materials_",
    "KHR_physics_",
    "KHR_technique",
    "KHR_texture_",
    "KHR_xmp",
    "MOZ_texture_",
    "MSFT_packing_",
    "MSFT_texture_",
    "NV_materials_",
    "OMI_",
    "VRMC_",
];

/// Refuses what may hide or move geometry, by its name.
pub(super) fn check_required(extension: &str) -> Result<(), String> {
    let is_known = READ.contains(&extension)
        || MESHOPT.contains(&extension)
        || HARMLESS.contains(&extension)
        || HARMLESS_FAMILIES.iter().any(|family| extension.starts_with(family));
    if is_known {
        return Ok(());
    }
    Err(format!(
        "it requires the extension {}, which may change where vertices are and can't be read; export it without",
        quote(extension.as_bytes())
    ))
}
