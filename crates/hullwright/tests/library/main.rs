//! What the public functions promise.

// The unused rest is for other tests.
mod break_apart;
#[allow(dead_code)]
#[path = "../common/mod.rs"]
mod common;
mod decompose;
mod documents;
#[allow(dead_code)]
#[path = "../independent/mod.rs"]
mod independent;
mod limits;
mod mass_reference;
mod measure;
mod old_files;
mod simplify_surface;
mod surface_distances;
