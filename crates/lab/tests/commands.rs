//! Promises of `cargo lab`, by running the program.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;
use tempfile::TempDir;

fn lab(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hullwright_lab")).args(arguments).output().expect("it starts")
}

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn errors(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A folder of its own with an L prism, `props/l.obj`, and a report.
struct Place {
    root: TempDir,
    meshes: String,
    report: String,
}

impl Place {
    fn new() -> Self {
        let root = tempfile::tempdir().unwrap();
        let folder = root.path().join("props");
        std::fs::create_dir(&folder).unwrap();
        let mut obj = String::new();
        for z in [0, 1] {
            for [x, y] in [[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]] {
                obj += &format!("v {x} {y} {z}\n");
            }
        }
        obj += "f 6 5 4 3 2 1\nf 7 8 9 10 11 12\n";
        for a in 0..6 {
            let b = (a + 1) % 6;
            obj += &format!("f {} {} {} {}\n", a + 1, b + 1, b + 7, a + 7);
        }
        std::fs::write(folder.join("l.obj"), obj).unwrap();
        let report = root.path().join("report").display().to_string();
        Self { meshes: folder.display().to_string(), report, root }
    }

    /// Adds a file that is no mesh.
    fn with_a_broken_file(self) -> Self {
        std::fs::write(Path::new(&self.meshes).join("broken.off"), "OFF\n3 1 0\n0 0 0\n").unwrap();
        self
    }

    /// Runs a command on the meshes, into the report, and it succeeds.
    fn run(&self, command: &str, arguments: &[&str]) -> String {
        let all = [&[command, &self.meshes, "-o", &self.report], arguments].concat();
        let output = lab(&all);
        assert!(output.status.success(), "{}", errors(&output));
        text(&output)
    }

    /// A file of the report.
    fn file(&self, name: &str) -> String {
        std::fs::read_to_string(Path::new(&self.report).join(name)).expect(name)
    }

    fn summary(&self) -> Value {
        serde_json::from_str(&self.file("summary.json")).unwrap()
    }
}

#[test]
fn a_benchmark_is_written_and_does_nothing_twice() {
    let place = Place::new();
    let only = ["--only", "surface,vhacd"];
    assert!(place.run("bench", &only).contains("props/l.obj"));
    let journal = place.file("runs.jsonl");
    assert!(journal.lines().count() > 1);
    assert!(journal.lines().all(|line| line.contains("\"status\":\"done\"")), "{journal}");
    for file in ["benchmark.md", "runs.csv", "summary.json", "error-time.svg"] {
        assert!(!place.file(file).is_empty(), "{file}");
    }
    assert_eq!(place.run("bench", &only), "", "nothing was left to do");
    assert_eq!(place.file("runs.jsonl"), journal);

    // A run that is missing is done, and only that.
    let lines: Vec<&str> = journal.lines().collect();
    let path = Path::new(&place.report).join("runs.jsonl");
    std::fs::write(path, lines[1..].join("\n") + "\n").unwrap();
    assert_eq!(place.run("bench", &only).lines().count(), 1);
}

#[test]
fn a_run_at_its_limit_is_a_row_and_not_the_end() {
    let place = Place::new();
    place.run("bench", &["--only", "surface", "--time-limit", "0"]);
    let journal = place.file("runs.jsonl");
    assert!(journal.contains("\"status\":\"time_out\""), "{journal}");
}

#[test]
fn what_is_no_mesh_is_a_row_with_its_reason() {
    let place = Place::new().with_a_broken_file();
    place.run("bench", &["--only", "surface"]);
    let table = place.file("runs.csv");
    let broken = table.lines().find(|line| line.starts_with("props/broken.off")).unwrap();
    assert!(broken.contains(",error,"), "{broken}");
    assert!(table.lines().any(|line| line.starts_with("props/l.obj") && line.contains(",done,")));
}

#[test]
fn a_folder_without_meshes_is_an_error() {
    let place = Place::new();
    let empty = place.root.path().join("empty");
    std::fs::create_dir(&empty).unwrap();
    let output = lab(&["bench", empty.to_str().unwrap(), "-o", &place.report]);
    assert_eq!(output.status.code(), Some(1));
}

#[test]
fn stability_says_that_nothing_failed_on_an_l_prism() {
    let place = Place::new();
    place.run("stability", &["--only", "surface"]);
    let words = place.file("stability.md");
    assert!(words.contains("Failures: 0. Broken promises: 0."), "{words}");
    assert_eq!(place.file("runs.jsonl").lines().count(), 60);
    for file in ["hulls-shape.svg", "time-shape.svg", "hulls-place.svg", "time-place.svg"] {
        assert!(
            words.contains(file) && place.file(file).contains("jittered") == file.contains("shape")
        );
    }
}

#[test]
fn growth_names_each_kind_and_ends_at_the_most_triangles_or_a_limit() {
    let place = Place::new();
    // A kind that takes longer ends there, which is no failure.
    let limits = ["--most", "1000", "--time-limit", "10"];
    let output = lab(&[&["growth", "-o", &place.report], &limits[..]].concat());
    assert!(output.status.success(), "{}", errors(&output));
    let summary = place.summary();
    let rows = |table: usize| summary["tables"][table]["rows"].as_array().unwrap();
    assert_eq!(rows(0).len(), 7);
    for row in rows(0) {
        let sizes = rows(1).iter().filter(|size| size["kind"] == row["kind"]);
        assert!(sizes.clone().count() >= 1 || row["ended at"].is_string(), "{row}");
        for size in sizes {
            assert!(size["triangles"].as_f64().unwrap() <= 1100.0, "{size}");
            assert!(size["hulls"].as_f64().unwrap() >= 1.0, "{size}");
            assert!(size["verified error over the bound"].as_f64().unwrap() <= 1.0, "{size}");
        }
    }
    for file in ["growth.md", "growth-time.svg", "growth-memory.svg"] {
        assert!(place.file(file).contains("triangles"), "{file}");
    }

    let none = lab(&["growth", "-o", &place.report, "--most", "1000", "--time-limit", "0"]);
    assert_eq!(none.status.code(), Some(0), "{}", errors(&none));
    assert!(place.file("growth.md").contains("1000: time-out, over 0 s"));
}

#[test]
fn what_is_measured_stands_under_the_names_of_the_manual() {
    let place = Place::new();
    place.run("bench", &["--only", "bounded,surface"]);
    let table = place.file("runs.csv");
    let header: Vec<&str> = table.lines().next().unwrap().split(',').collect();
    for column in ["protrusion_max", "uncovered_max", "uncovered_volume", "samples_space"] {
        assert!(header.contains(&column), "{header:?}");
    }
    let summary = place.summary();
    let row = &summary["tables"][0]["rows"][0];
    assert_eq!(row["method"], "bounded");
    for column in ["protrusion, mean", "uncovered, max", "uncovered volume", "seconds"] {
        assert!(row[column].is_number(), "{column}: {row}");
    }
    let versus = place.file("versus.csv");
    assert!(versus.lines().any(|line| line.starts_with("props/l.obj,surface,")), "{versus}");
}

#[test]
fn stages_print_a_line_for_each_mesh() {
    let place = Place::new();
    let output = lab(&["stages", &format!("{}/l.obj", place.meshes)]);
    assert!(output.status.success(), "{}", errors(&output));
    let shown = text(&output);
    let line = shown.lines().find(|line| line.contains("l.obj")).expect(&shown);
    assert!(line.contains("20 triangles"), "{line}");
}

#[test]
fn a_sweep_tells_what_became_of_each_mesh_goes_on_and_says_what_has_changed() {
    let place = Place::new().with_a_broken_file();
    // The L and the broken file, eleven damaged copies of the L, and three random meshes.
    let options = ["--random", "3", "--jobs", "2"];
    let shown = place.run("sweep", &options);
    assert!(shown.contains("| all | 16 | 15 | 1 | 0 | 0 |"), "{shown}");
    let summary = place.summary();
    let rows = summary["tables"][0]["rows"].as_array().unwrap();
    let number = |kind: &str, column: &str| {
        let row = rows.iter().find(|row| row["kind"] == kind).expect(kind);
        row[column].as_f64().unwrap_or(f64::NAN)
    };
    assert_eq!(number("no mesh in the file", "refused with a reason"), 1.0);
    assert_eq!(number("solid", "meshes") + number("not solid", "meshes"), 15.0);
    // As it is, scaled twice.
    assert!(number("solid", "meshes") >= 3.0);
    for column in ["crashed", "stopped", "not sound", "beyond the bound"] {
        assert_eq!(number("all", column), 0.0, "{column}");
    }
    let table = place.file("sweep.csv");
    let l = table.lines().find(|line| line.starts_with("props/l.obj,")).unwrap();
    assert!(l.contains(",done,") && l.contains(",20,,2,"), "{l}");
    assert!(place.run("sweep", &options).trim_start().starts_with("###"), "nothing was left to do");

    // As if the L, of 20 triangles and a solid, had been one hull before.
    let before = place.root.path().join("before.csv");
    std::fs::write(&before, table.replacen(",20,,2,", ",20,,1,", 1)).unwrap();
    place.run("sweep", &["--random", "3", "--compare", before.to_str().unwrap()]);
    let words = place.file("sweep.md");
    assert!(words.contains("| props/l.obj | hulls | 1 | 2 |"), "{words}");
}

#[test]
fn targets_compare_hulls_with_those_of_other_tools() {
    let place = Place::new();
    std::fs::rename(&place.meshes, place.root.path().join("meshes")).unwrap();
    std::fs::create_dir(place.root.path().join("peers")).unwrap();
    let table = "mesh\tmethod\tseconds\thulls\thaus\tiou\nl.obj\tcoacd-1.0\t9.5\t4\t0.03\t0.9\n";
    std::fs::write(place.root.path().join("peers/results.tsv"), table).unwrap();
    let data = place.root.path().to_str().unwrap();
    for bound in ["0.02", "coacd", "vhacd", "coacd-hulls"] {
        let output = lab(&["targets", data, "--bound", bound]);
        assert!(output.status.success(), "{}", errors(&output));
        let shown = text(&output);
        assert!(shown.contains("| no more hulls than theirs | 100 % of 1 |"), "{bound}: {shown}");
        assert!(shown.contains("| broken promises | 0 |"), "{shown}");
    }
    let meshes = format!("{data}/meshes");
    let props = text(&lab(&["targets", data, "--meshes", &meshes, "--props"]));
    assert!(props.contains("| meshes | 0 |"), "of 20 triangles it is no prop: {props}");
}

#[test]
fn a_folder_without_the_tables_is_one_line_on_standard_error() {
    let place = Place::new();
    let folder = place.root.path().to_str().unwrap();
    for (arguments, table) in [
        (&["paper", folder, "-o", &place.report][..], "paper/table1.tsv"),
        (&["targets", folder], "peers/results.tsv"),
    ] {
        let output = lab(arguments);
        assert_eq!(output.status.code(), Some(1));
        let error = errors(&output);
        assert_eq!(error.lines().count(), 1, "{error}");
        assert!(error.starts_with("error: ") && error.contains(table), "{error}");
    }
    assert_eq!(lab(&["no-such-command"]).status.code(), Some(2));
}

#[test]
fn the_papers_experiments_are_repeated_in_one_run() {
    let place = Place::new();
    let prism = std::fs::read(Path::new(&place.meshes).join("l.obj")).unwrap();
    for (folder, file) in [("meshes/princeton", "21.obj"), ("meshes/common", "spot.obj")] {
        std::fs::create_dir_all(place.root.path().join(folder)).unwrap();
        std::fs::write(place.root.path().join(folder).join(file), &prism).unwrap();
    }
    std::fs::create_dir(place.root.path().join("paper")).unwrap();
    let table = "model\tmesh\tpieces\taverage_pieces\tseconds\tcost\tp\tr\tpolygons\tinitial_polygons\n\
                 1\tprinceton/21.obj\t2\t2\t1\t0\t0.01\t250\t20\t20\n";
    std::fs::write(place.root.path().join("paper/table1.tsv"), table).unwrap();
    let output = lab(&["paper", place.root.path().to_str().unwrap(), "-o", &place.report]);
    assert!(output.status.success(), "{}", errors(&output));
    let report = place.file("paper-experiments.md");
    // Two convex pieces of 20 polygons at the first r, which all readings find.
    assert!(report.contains("| 1 (princeton/21.obj) | closest | 2 | 2.0 |"), "{report}");
    assert!(report.contains("| the closest | 1 | 1 | 1 | 1 | 1 | 1 | **0.01 250** |"), "{report}");
    for name in ["HACD (Figure 3)", "hollow shapes", "V-HACD", "p at fixed r", "O(N / k)", "Spot"] {
        assert!(report.contains(name), "{name} in\n{report}");
    }
    for figure in 2..=5 {
        let file = Path::new(&place.report).join(format!("figure-{figure}.png"));
        assert!(file.metadata().unwrap().len() > 1000, "{figure}");
    }
}

#[test]
fn a_level_is_drawn_from_its_seed_and_simplified_within_the_bound() {
    let place = Place::new();
    let level = |name: &str, seed: &str| {
        let file = place.root.path().join(name);
        let assets = concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets");
        let size = ["--props", "30", "--terrain-triangles", "5000", "--bodies", "20"];
        let rest = ["--balls", "100", "--seed", seed, "--write", file.to_str().unwrap()];
        let all = [&["level", assets, "-o", &place.report], &size[..], &rest].concat();
        let output = lab(&all);
        assert!(output.status.success(), "{}", errors(&output));
        std::fs::read(file).unwrap()
    };
    let first = level("first.glb", "7");
    assert_ne!(first, level("other.glb", "8"));
    assert_eq!(first, level("again.glb", "7"));
    let file = gltf::Gltf::from_slice(&first).unwrap();
    assert_eq!(file.nodes().filter(|node| node.mesh().is_some()).count(), 30 + 256);
    assert!(file.meshes().len() < 30 + 256, "props share meshes");
    let corners: usize = file
        .nodes()
        .filter_map(|node| node.mesh())
        .map(|mesh| {
            mesh.primitives()
                .filter_map(|part| part.indices())
                .map(|list| list.count())
                .sum::<usize>()
        })
        .sum();

    let summary = place.summary();
    let rows = |table: usize| summary["tables"][table]["rows"].as_array().unwrap();
    let row = |what: &str| rows(0).iter().find(|row| row["what"] == what).expect(what);
    assert_eq!(row("triangles")["before"], (corners / 3) as f64);
    for what in ["triangles", "triangles of terrain", "triangles of props", "colliders"] {
        assert!(row(what)["ratio"].as_f64().unwrap() < 1.0, "{what}: {}", row(what));
    }
    let zero = |row: &&Value| {
        ["bodies too deep", "bodies fallen through"].iter().any(|what| row["what"] == *what)
    };
    for row in rows(2).iter().filter(zero) {
        assert_eq!(
            (&row["before"], &row["after"]),
            (&Value::from(0.0), &Value::from(0.0)),
            "{row}"
        );
    }
    assert_eq!(rows(2).iter().filter(zero).count(), 6);
    for row in rows(3) {
        assert_eq!(row["number"], 100.0, "{row}");
        assert_eq!(row["beyond the bound"], 0.0, "{row}");
    }
}
