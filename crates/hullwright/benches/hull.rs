//! Our hull against Parry's on the same points, and what it takes to copy a hull and let it grow:
//! `cargo bench --package hullwright --bench hull`.

use std::hint::black_box;
use std::time::Instant;

use hullwright::hull::{HullBuilder, Shape};
use parry3d::math::Vector;

/// Rounds of each measurement; the median of them is printed.
const ROUNDS: usize = 31;

/// Hulls per round, so that a round takes about a millisecond.
const REPEATS: usize = 20;

fn main() {
    println!(
        "{:<18} {:>9} {:>9} {:>7} {:>12} {:>13}",
        "points", "ours µs", "Parry µs", "ratio", "+5 points µs", "+40 points µs"
    );
    for count in [50, 100, 200, 300] {
        row("sphere", count, sphere);
    }
    for count in [50, 100, 200, 300] {
        row("cube", count, cube);
    }
}

fn row(name: &str, count: usize, make: fn(&mut Random) -> [f64; 3]) {
    let mut random = Random(1);
    let points: Vec<[f64; 3]> = (0..count).map(|_| make(&mut random)).collect();
    // Some of them are farther out and replace faces.
    let more: Vec<[f64; 3]> = (0..40).map(|_| make(&mut random).map(|x| 1.02 * x)).collect();
    let single: Vec<Vector> =
        points.iter().map(|p| Vector::new(p[0] as f32, p[1] as f32, p[2] as f32)).collect();
    let mut builder = HullBuilder::new();
    assert_eq!(builder.build(&points), Shape::Solid);
    let (mut ours, mut theirs) = (Vec::new(), Vec::new());
    let mut grown = [5, 40].map(|count| (&more[..count], Vec::new()));
    // Side by side, so that a slow moment of the machine hits both.
    for _ in 0..ROUNDS {
        ours.push(seconds(|| {
            builder.build(black_box(&points));
            black_box(builder.extract());
        }));
        theirs.push(seconds(|| {
            black_box(parry3d::transformation::try_convex_hull(black_box(&single)).ok());
        }));
        builder.build(&points);
        let built = builder.clone();
        let mut scratch = built.clone();
        for (more, times) in &mut grown {
            times.push(seconds(|| {
                scratch.clone_from(black_box(&built));
                scratch.insert(black_box(more));
            }));
        }
    }
    let [ours, theirs] = [ours, theirs].map(median);
    let [five, forty] = grown.map(|(_, times)| median(times));
    let (name, ratio) = (format!("{count} in a {name}"), theirs / ours);
    println!("{name:<18} {ours:>9.2} {theirs:>9.2} {ratio:>6.1}x {five:>12.2} {forty:>13.2}");
}

fn seconds(mut work: impl FnMut()) -> f64 {
    let start = Instant::now();
    for _ in 0..REPEATS {
        work();
    }
    start.elapsed().as_secs_f64() * 1e6 / REPEATS as f64
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// A small generator (Steele, Lea, Flood 2014, "SplitMix64"), so that each run sees the same.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        2.0 * ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64 - 1.0
    }
}

fn cube(random: &mut Random) -> [f64; 3] {
    [random.next(), random.next(), random.next()]
}

fn sphere(random: &mut Random) -> [f64; 3] {
    loop {
        let point = cube(random);
        let length = point.iter().map(|x| x * x).sum::<f64>().sqrt();
        if length > 0.1 && length < 1.0 {
            return point.map(|x| x / length);
        }
    }
}
