//! What the public functions promise.

// The unused rest is for other tests.
mod break_apart;
#[allow(dead_code)]
#[path = "../common/mod.rs"]
mod common;
mod decompose;
mod documents;
mod limits;
mod mass_reference;
mod measure;
mod old_files;
