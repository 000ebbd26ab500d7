//! What readers and writers of files promise.
#![cfg(feature = "io")]

mod compressed;
#[path = "../common/glb.rs"]
mod glb;
mod gltf;
mod hostile;
mod writers;
