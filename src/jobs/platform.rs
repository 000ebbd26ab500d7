//! What jobs take from the platform: of two folders with the same items the one that is built.

#[cfg(all(target_family = "wasm", target_os = "unknown"))]
pub(super) use super::browser::{
    DiskCache, DiskState, Elsewhere, Hashing, Runner, look, processors, with_lower_priority,
};
#[cfg(not(all(target_family = "wasm", target_os = "unknown")))]
pub(super) use super::native::{
    DiskCache, DiskState, Elsewhere, Hashing, Runner, look, processors, with_lower_priority,
};
