//! Research harness.
use hullwright::io::read_mesh;
use hullwright::measure::{HullShape, MeasureOptions, measure};
use std::path::Path;

fn main() {
    let shared = std::env::args().nth(1).unwrap();
    let mode = std::env::args().nth(2).unwrap_or("default".into());
    let filter = std::env::args().nth(3).unwrap_or_default();
    let shared = Path::new(&shared);
    let tsv = std::fs::read_to_string(shared.join("peers/results.tsv")).unwrap();
    let mut rows = Vec::new();
    for line in tsv.lines().skip(1) {
        let c: Vec<&str> = line.split('\t').collect();
        if c[1].starts_with("coacd") {
            rows.push((
                c[0].to_string(),
                c[3].parse::<usize>().unwrap(),
                c[5].parse::<f64>().unwrap(),
                c[12].parse::<f64>().unwrap_or(f64::NAN),
            ));
        }
    }
    let quiet = std::env::var("QUIET").is_ok();
    let mut sums: Vec<Vec<f64>> = vec![Vec::new(); 12];
    let mut stage: std::collections::BTreeMap<&str, Vec<f64>> = Default::default();
    let mut counts_all: std::collections::BTreeMap<&str, Vec<f64>> = Default::default();
    for (name, coacd, haus, coiou) in rows {
        if !name.contains(&filter) {
            continue;
        }
        let flat = shared
            .join("peers/src")
            .join(name.replace('/', "_").rsplit_once('.').unwrap().0.to_string() + ".obj");
        let path = if flat.exists() { flat } else { shared.join("meshes").join(&name) };
        let file = read_mesh(&path).unwrap();
        let bound = if mode == "coacd" {
            haus
        } else if mode == "default" {
            0.02
        } else {
            mode.parse().unwrap()
        };
        let mut parameters = hullwright::Parameters::default();
        parameters.bounded.max_error = hullwright::Unit::Diagonals(bound);
        if let Ok(preset) = std::env::var("PRESET") {
            parameters.bounded.preset = match preset.as_str() {
                "fast" => hullwright::Preset::Fast,
                "fine" => hullwright::Preset::Fine,
                _ => hullwright::Preset::Balanced,
            };
        }
        parameters.parallel = std::env::var("SERIAL").is_err();
        let start = std::time::Instant::now();
        let result = hullwright::decompose(
            &file.positions,
            &file.triangles,
            &parameters,
            &hullwright::Control::new(),
        )
        .unwrap();
        let seconds = start.elapsed().as_secs_f64();
        let hulls = result.hulls;
        let report = result.report.bounded.unwrap();
        let times: Vec<(&str, f64)> =
            result.report.times.iter().map(|t| (t.stage.name(), t.seconds)).collect();
        let counts = vec![
            ("seeds", report.seeds),
            ("claimed-out", (report.phantom_max / result.report.diagonal * 1e5) as usize),
            ("claimed-in", (report.exposed_max / result.report.diagonal * 1e5) as usize),
        ];
        let shapes: Vec<HullShape> = hulls
            .iter()
            .map(|h| HullShape { points: &h.points, triangles: &h.triangles })
            .collect();
        let mut options = MeasureOptions::default();
        options.hull_samples = 20_000;
        options.mesh_samples = 10_000;
        options.volume_samples = 30_000;
        let m = measure(&file.positions, &file.triangles, &shapes, &options).unwrap();
        let vph = m.vertices as f64 / m.hulls as f64;
        if !quiet {
            println!(
                "{name:<50} {:>6} tri  hulls {:>3}/{coacd:<3} haus {:.4}/{haus:.4} out {:.4} in {:.4} hollow {:.3} iou {:.3}/{coiou:.3} v/h {vph:>5.1} {:>6.1} ms | {}",
                file.triangles.len(),
                m.hulls,
                m.hausdorff,
                m.phantom.max,
                m.exposed.max,
                m.hollow.unwrap_or(f64::NAN),
                m.iou.unwrap_or(f64::NAN),
                seconds * 1e3,
                counts.iter().map(|(n, c)| format!("{n} {c}")).collect::<Vec<_>>().join(" ")
            );
        }
        for (n, t) in times {
            stage.entry(n).or_default().push(t * 1e3);
        }
        for (n, t) in counts {
            counts_all.entry(n).or_default().push(t as f64);
        }
        let v = [
            m.hulls as f64,
            m.hausdorff,
            m.phantom.max,
            m.exposed.max,
            m.hollow.unwrap_or(f64::NAN),
            m.iou.unwrap_or(f64::NAN),
            vph,
            seconds * 1e3,
            m.hulls as f64 / coacd as f64,
            f64::from(m.hulls <= coacd),
            f64::from(
                m.phantom.max * result.report.diagonal > report.phantom_max * 1.0001
                    || m.exposed.max * result.report.diagonal
                        > report.exposed_max * 1.0001 + 1e-5 * result.report.diagonal
                    || report.phantom_max > report.bound,
            ),
        ];
        for (s, v) in sums.iter_mut().zip(v) {
            if v.is_finite() {
                s.push(v);
            }
        }
    }
    let mean = |v: &Vec<f64>| v.iter().sum::<f64>() / v.len() as f64;
    let median = |v: &Vec<f64>| {
        let mut v = v.clone();
        v.sort_by(f64::total_cmp);
        v[v.len() / 2]
    };
    let worst = |v: &Vec<f64>| v.iter().copied().fold(0.0, f64::max);
    let ratio = (sums[8].iter().map(|x| x.ln()).sum::<f64>() / sums[8].len() as f64).exp();
    println!(
        "hulls {:.2} (med {}) haus {:.4} out {:.4} in {:.5} (worst {:.4}) hollow {:.4} (worst {:.3}) iou {:.3} v/h {:.1} ms med {:.1} mean {:.1} max {:.0} ratio {:.3} nomore {:.0}% broken {}",
        mean(&sums[0]),
        median(&sums[0]),
        mean(&sums[1]),
        mean(&sums[2]),
        mean(&sums[3]),
        worst(&sums[3]),
        mean(&sums[4]),
        worst(&sums[4]),
        mean(&sums[5]),
        mean(&sums[6]),
        median(&sums[7]),
        mean(&sums[7]),
        worst(&sums[7]),
        ratio,
        100.0 * mean(&sums[9]),
        sums[10].iter().sum::<f64>()
    );
    println!(
        "{}",
        stage
            .iter()
            .map(|(n, v)| format!("{n} {:.2}/{:.2}", median(v), mean(v)))
            .collect::<Vec<_>>()
            .join("  ")
    );
    println!(
        "{}",
        counts_all
            .iter()
            .map(|(n, v)| format!("{n} {:.1}", mean(v)))
            .collect::<Vec<_>>()
            .join("  ")
    );
}
