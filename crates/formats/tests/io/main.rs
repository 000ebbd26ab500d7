//! What readers and writers of files promise.

mod compressed;
#[path = "../common/glb.rs"]
mod glb;
mod gltf;
mod hostile;
mod hulls;
mod parts;
mod writers;
