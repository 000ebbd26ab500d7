//! The hulls of the bundled models are the same bits wherever they are computed: for any number of
//! threads, with and without the feature `parallel`, with and without optimisation.
//!
//! After a change of the method, `UPDATE_DIGESTS=1 cargo test --package hullwright --test digests`
//! writes the digests anew.

// The unused rest is for other tests.
#[allow(dead_code)]
mod common;

use std::fmt::Write;

use hullwright::{Control, Decomposition, Parameters, decompose};

const DIGESTS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/digests.txt");

/// FNV-1a: a digest for comparison needs no more.
struct Digest(u64);

impl Digest {
    fn add(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
}

/// Of all points and triangles, in their order.
fn digest(decomposition: &Decomposition) -> String {
    let mut digest = Digest(0xcbf2_9ce4_8422_2325);
    for hull in &decomposition.hulls {
        for x in hull.shape.points.as_flattened() {
            digest.add(&x.to_bits().to_le_bytes());
        }
        for vertex in hull.shape.triangles.as_flattened() {
            digest.add(&vertex.to_le_bytes());
        }
        digest.add(b"hull");
    }
    format!("{:016x}", digest.0)
}

/// One line per model: its name and its digest.
fn digests(control: &Control) -> String {
    let mut lines = String::new();
    for (name, mesh) in common::bundled_models() {
        let result = decompose(&mesh, &Parameters::default(), control).unwrap();
        writeln!(lines, "{name} {}", digest(&result)).unwrap();
    }
    lines
}

#[test]
fn the_hulls_of_the_bundled_models_are_those_on_record() {
    let serial = digests(&Control::new().with_parallel(false));
    if std::env::var_os("UPDATE_DIGESTS").is_some() {
        std::fs::write(DIGESTS, &serial).unwrap();
    }
    let known = std::fs::read_to_string(DIGESTS).unwrap();
    assert_eq!(serial, known, "one thread");
}

#[cfg(feature = "parallel")]
#[test]
fn the_hulls_of_the_bundled_models_are_the_same_for_one_to_four_threads() {
    let known = digests(&Control::new().with_parallel(false));
    for threads in 1..=4 {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        assert_eq!(pool.install(|| digests(&Control::new())), known, "{threads} threads");
    }
}
