//! The fuzz targets, on a stable compiler: what they have found is replayed, and each is given
//! bytes that nobody chose.

#[path = "../../../fuzz/src/lib.rs"]
mod targets;

use std::path::Path;

/// Inputs by chance, beside the corpora.
const RANDOM: u64 = 100;

fn replay(name: &str, target: targets::Target) -> usize {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus");
    let seeds = std::fs::read_to_string(corpus.join(name).with_extension("seeds")).unwrap();
    for seed in seeds.lines() {
        let (seed, digits) = seed.split_once(' ').unwrap();
        // The name of what fails.
        println!("{name} {seed}");
        let byte = |at: usize| u8::from_str_radix(&digits[at..at + 2], 16).unwrap();
        target(&(0..digits.len()).step_by(2).map(byte).collect::<Vec<u8>>());
    }
    seeds.lines().count()
}

#[test]
fn what_fuzzing_has_found_stays_mended() {
    for (name, target) in targets::TARGETS {
        assert!(replay(name, *target) > 0, "{name} has no corpus");
    }
}

/// Of the starts for the fuzzer a few, which take a second; `FUZZ_STARTS` writes them all into
/// `fuzz/work`.
#[test]
fn starts_are_decomposed_or_have_a_hull_and_break_nothing() {
    const EVERY: usize = 9;
    let starts = targets::starts();
    if std::env::var_os("FUZZ_STARTS").is_some() {
        for (index, (name, bytes)) in starts.iter().enumerate() {
            let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/work").join(name);
            std::fs::create_dir_all(&folder).unwrap();
            std::fs::write(folder.join(format!("start-{index:03}")), bytes).unwrap();
        }
    }
    for (index, (name, bytes)) in starts.iter().enumerate().step_by(EVERY) {
        println!("{name} {index}");
        let (_, target) = targets::TARGETS.iter().find(|target| target.0 == *name).unwrap();
        target(bytes);
        assert!(*name != "soup" || targets::hulls_of_soup(bytes) > 0, "{index} is nothing");
    }
}

#[test]
fn bytes_that_nobody_chose_break_nothing() {
    for (name, target) in targets::TARGETS {
        let mut state = 0x9e37_79b9_7f4a_7c15_u64;
        for round in 0..RANDOM {
            let bytes: Vec<u8> = (0..round * 5)
                .map(|_| {
                    // Xorshift (Marsaglia 2003).
                    state ^= state << 13;
                    state ^= state >> 7;
                    state ^= state << 17;
                    (state >> 32) as u8
                })
                .collect();
            println!("{name} {round}");
            target(&bytes);
        }
    }
}
