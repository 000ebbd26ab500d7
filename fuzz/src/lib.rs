//! What the fuzz targets do with bytes. `tests/fuzz_corpus.rs` of the crate above includes this file, and
//! replays the corpora on a stable compiler.
//!
//! Each target takes any bytes, makes of them what reaches deep, and panics where a promise is broken.

#[allow(dead_code)]
#[path = "../../tests/independent/mod.rs"]
mod independent;
mod points;
#[cfg(feature = "io")]
mod readers;
mod shapes;
#[allow(dead_code)]
mod starts;

#[cfg(all(feature = "io", feature = "bake"))]
pub use readers::extras;
#[cfg(feature = "io")]
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
    #[cfg(feature = "io")]
    ("obj", obj),
    #[cfg(feature = "io")]
    ("off", off),
    #[cfg(feature = "io")]
    ("ply", ply),
    #[cfg(feature = "io")]
    ("stl", stl),
    #[cfg(feature = "io")]
    ("gltf", gltf),
    #[cfg(feature = "io")]
    ("hulls_file", hulls_file),
    #[cfg(all(feature = "io", feature = "bake"))]
    ("extras", extras),
];
