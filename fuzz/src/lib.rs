//! What the fuzz targets do with bytes. `crates/hullwright/tests/fuzz_corpus.rs` of the crate above
//! includes this file, and replays the corpora on a stable compiler.
//!
//! Each target takes any bytes, makes of them what reaches deep, and panics where a promise is
//! broken.

#[allow(dead_code)]
#[path = "../../crates/hullwright/tests/independent/mod.rs"]
mod independent;
mod points;
mod readers;
mod shapes;
#[allow(dead_code)]
mod starts;

pub use readers::extras;
pub use readers::{gltf, hulls_file, obj, off, ply, stl};
#[allow(unused_imports)]
pub use shapes::hulls_of_soup;
pub use shapes::{hull, soup};
#[allow(unused_imports)]
pub use starts::starts;

pub type Target = fn(&[u8]);

/// The targets by name, as the folders of their corpora are called.
pub const TARGETS: &[(&str, Target)] = &[
    ("soup", soup),
    ("hull", hull),
    ("obj", obj),
    ("off", off),
    ("ply", ply),
    ("stl", stl),
    ("gltf", gltf),
    ("hulls_file", hulls_file),
    ("extras", extras),
];
