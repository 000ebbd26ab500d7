//! Promises of `cargo lab`, by running the program.

use std::path::Path;
use std::process::{Command, Output};

fn lab(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hullwright_lab")).args(arguments).output().expect("it starts")
}

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// An L prism, as a file in a folder of its own.
fn folder_with_a_mesh(root: &Path) -> String {
    let folder = root.join("props");
    std::fs::create_dir(&folder).unwrap();
    let outline = [[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]];
    let mut obj = String::new();
    for z in [0, 1] {
        for [x, y] in outline {
            obj += &format!("v {x} {y} {z}\n");
        }
    }
    obj += "f 6 5 4 3 2 1\nf 7 8 9 10 11 12\n";
    for a in 0..6 {
        let b = (a + 1) % 6;
        obj += &format!("f {} {} {} {}\n", a + 1, b + 1, b + 7, a + 7);
    }
    std::fs::write(folder.join("l.obj"), obj).unwrap();
    folder.display().to_string()
}

#[test]
fn a_benchmark_is_written_and_does_nothing_twice() {
    let root = tempfile::tempdir().unwrap();
    let meshes = folder_with_a_mesh(root.path());
    let report = root.path().join("report");
    let arguments = ["bench", &meshes, "-o", report.to_str().unwrap(), "--only", "surface,hacd"];
    let first = lab(&arguments);
    assert!(first.status.success(), "{}", String::from_utf8_lossy(&first.stderr));
    assert!(text(&first).contains("props/l.obj"));
    let journal = std::fs::read_to_string(report.join("runs.jsonl")).unwrap();
    assert!(journal.lines().count() > 1);
    assert!(journal.lines().all(|line| line.contains("\"status\":\"done\"")), "{journal}");
    for file in ["index.html", "benchmark.md", "runs.csv", "summary.json", "error-time.svg"] {
        assert!(report.join(file).is_file(), "{file}");
    }

    let second = lab(&arguments);
    assert!(second.status.success());
    assert_eq!(text(&second), "", "nothing was left to do");
    assert_eq!(std::fs::read_to_string(report.join("runs.jsonl")).unwrap(), journal);

    // A run that is missing is done, and only that.
    let lines: Vec<&str> = journal.lines().collect();
    std::fs::write(report.join("runs.jsonl"), lines[1..].join("\n") + "\n").unwrap();
    let third = lab(&arguments);
    assert_eq!(text(&third).lines().count(), 1);
}

#[test]
fn a_benchmark_links_a_page_for_each_mesh_with_both_tools_side_by_side() {
    let root = tempfile::tempdir().unwrap();
    let meshes = folder_with_a_mesh(root.path());
    let report = root.path().join("report");
    let folder = report.to_str().unwrap();
    let output = lab(&["bench", &meshes, "-o", folder, "--only", "surface", "--pages"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let index = std::fs::read_to_string(report.join("index.html")).unwrap();
    assert!(index.contains("<a href=\"pages/props_l.obj.html\">props/l.obj</a>"));
    let page = std::fs::read_to_string(report.join("pages/props_l.obj.html")).unwrap();
    assert!(page.contains("Hullwright, 2%") && page.contains("V-HACD in Parry"));
}

#[test]
fn a_page_shows_our_hulls_and_those_of_other_tools() {
    let root = tempfile::tempdir().unwrap();
    let mesh = format!("{}/l.obj", folder_with_a_mesh(root.path()));
    let hulls = root.path().join("peers/coacd");
    std::fs::create_dir_all(&hulls).unwrap();
    std::fs::copy(&mesh, hulls.join("props_l.obj")).unwrap();
    let table = "mesh\tmethod\tseconds\thulls\nprops/l.obj\tcoacd-1.0\t9.5\t1\n";
    std::fs::write(root.path().join("peers/results.tsv"), table).unwrap();
    let page = root.path().join("l.html");
    let tools = root.path().to_str().unwrap();
    let output = lab(&["view", &mesh, "-o", page.to_str().unwrap(), "--external-tools", tools]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = std::fs::read_to_string(page).unwrap();
    for tool in ["Hullwright, 2%", "V-HACD in Parry", "CoACD"] {
        assert!(text.contains(&format!("\"name\":\"{tool}\"")), "{tool}");
    }
    assert!(text.contains("9.50 s"), "the time of the table");
}

#[test]
fn a_run_at_its_limit_is_a_row_and_not_the_end() {
    let root = tempfile::tempdir().unwrap();
    let meshes = folder_with_a_mesh(root.path());
    let report = root.path().join("report");
    let folder = report.to_str().unwrap();
    let output = lab(&["bench", &meshes, "-o", folder, "--only", "surface", "--time-limit", "0"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let journal = std::fs::read_to_string(report.join("runs.jsonl")).unwrap();
    assert!(journal.contains("\"status\":\"time_out\""), "{journal}");
}

#[test]
fn what_is_no_mesh_is_a_row_with_its_reason() {
    let root = tempfile::tempdir().unwrap();
    let meshes = folder_with_a_mesh(root.path());
    std::fs::write(Path::new(&meshes).join("broken.off"), "OFF\n3 1 0\n0 0 0\n").unwrap();
    let report = root.path().join("report");
    let output = lab(&["bench", &meshes, "-o", report.to_str().unwrap(), "--only", "surface"]);
    assert!(output.status.success());
    let table = std::fs::read_to_string(report.join("runs.csv")).unwrap();
    let broken = table.lines().find(|line| line.starts_with("props/broken.off")).unwrap();
    assert!(broken.contains(",error,"), "{broken}");
    assert!(table.lines().any(|line| line.starts_with("props/l.obj") && line.contains(",done,")));
}

#[test]
fn a_folder_without_meshes_is_an_error() {
    let root = tempfile::tempdir().unwrap();
    let empty = root.path().display().to_string();
    let report = root.path().join("report");
    let output = lab(&["bench", &empty, "-o", report.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(1));
}

#[test]
fn stability_says_that_nothing_failed_on_an_l_prism() {
    let root = tempfile::tempdir().unwrap();
    let meshes = folder_with_a_mesh(root.path());
    let report = root.path().join("report");
    let folder = report.to_str().unwrap();
    let output = lab(&["stability", &meshes, "-o", folder, "--only", "surface"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let words = std::fs::read_to_string(report.join("stability.md")).unwrap();
    assert!(words.contains("Failures: 0. Broken promises: 0."), "{words}");
    let journal = std::fs::read_to_string(report.join("runs.jsonl")).unwrap();
    assert_eq!(journal.lines().count(), 41);
}

#[test]
fn what_is_measured_stands_under_the_names_of_the_manual() {
    let root = tempfile::tempdir().unwrap();
    let meshes = folder_with_a_mesh(root.path());
    let report = root.path().join("report");
    let folder = report.to_str().unwrap();
    let arguments = ["bench", &meshes, "-o", folder, "--only", "bounded,surface"];
    assert!(lab(&arguments).status.success());
    let table = std::fs::read_to_string(report.join("runs.csv")).unwrap();
    let header: Vec<&str> = table.lines().next().unwrap().split(',').collect();
    for column in ["protrusion_max", "uncovered_max", "uncovered_volume", "samples_space"] {
        assert!(header.contains(&column), "{header:?}");
    }
    let summary = std::fs::read_to_string(report.join("summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    let row = &summary["tables"][0]["rows"][0];
    assert_eq!(row["method"], "bounded");
    for column in ["protrusion, mean", "uncovered, max", "uncovered volume", "seconds"] {
        assert!(row[column].is_number(), "{column}: {row}");
    }
    let versus = std::fs::read_to_string(report.join("versus.csv")).unwrap();
    assert!(versus.lines().any(|line| line.starts_with("props/l.obj,surface,")), "{versus}");
}

#[test]
fn the_other_experiments_print_a_line_for_each_mesh() {
    let root = tempfile::tempdir().unwrap();
    let folder = folder_with_a_mesh(root.path());
    let mesh = format!("{folder}/l.obj");
    for (arguments, expected) in
        [(["stages", &mesh], "20 triangles"), (["corpus", &folder], "of the bound")]
    {
        let output = lab(&arguments);
        assert!(output.status.success(), "{arguments:?}");
        let shown = text(&output);
        let line = shown.lines().find(|line| line.contains("l.obj")).expect(&shown);
        assert!(line.contains(expected), "{line}");
    }
    let shown = text(&lab(&["corpus", &folder]));
    assert!(!shown.contains("BROKEN"), "{shown}");
}

#[test]
fn a_sweep_tells_what_became_of_each_mesh_goes_on_and_says_what_has_changed() {
    let root = tempfile::tempdir().unwrap();
    let meshes = folder_with_a_mesh(root.path());
    std::fs::write(Path::new(&meshes).join("broken.off"), "OFF\n3 1 0\n0 0 0\n").unwrap();
    let report = root.path().join("report");
    let folder = report.to_str().unwrap();
    let first = lab(&["sweep", &meshes, "-o", folder]);
    assert!(first.status.success(), "{}", String::from_utf8_lossy(&first.stderr));
    let summary = std::fs::read_to_string(report.join("summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    let all = &summary["tables"][0]["rows"][1];
    let of = |column: &str| all[column].as_f64().unwrap_or(f64::NAN);
    assert_eq!([of("meshes"), of("done"), of("refused"), of("hulls")], [2.0, 1.0, 1.0, 2.0]);
    for column in ["crashed", "timed out", "open", "not convex", "broken promises"] {
        assert_eq!(of(column), 0.0, "{column}");
    }
    let table = std::fs::read_to_string(report.join("sweep.csv")).unwrap();
    let l = table.lines().find(|line| line.starts_with("props/l.obj,")).unwrap();
    assert!(l.contains(",done,"), "{l}");

    assert_eq!(text(&lab(&["sweep", &meshes, "-o", folder])), "", "nothing was left to do");

    // As if the L, of 20 triangles, had been one hull before.
    let before = root.path().join("before.csv");
    assert!(l.contains(",20,2,"), "{l}");
    std::fs::write(&before, table.replace(",20,2,", ",20,1,")).unwrap();
    let compared = ["sweep", &meshes, "-o", folder, "--compare", before.to_str().unwrap()];
    assert!(lab(&compared).status.success());
    let words = std::fs::read_to_string(report.join("sweep.md")).unwrap();
    assert!(words.contains("| props/l.obj | hulls | 1 | 2 |"), "{words}");
}

#[test]
fn targets_are_met_mesh_by_mesh_against_other_tools() {
    let root = tempfile::tempdir().unwrap();
    let folder = folder_with_a_mesh(root.path());
    std::fs::rename(folder, root.path().join("meshes")).unwrap();
    std::fs::create_dir(root.path().join("peers")).unwrap();
    let table = "mesh\tmethod\tseconds\thulls\thaus\tiou\nl.obj\tcoacd-1.0\t9.5\t4\t0.03\t0.9\n";
    std::fs::write(root.path().join("peers/results.tsv"), table).unwrap();
    let data = root.path().to_str().unwrap();
    for bound in ["0.02", "coacd", "vhacd", "coacd-hulls"] {
        let output = lab(&["targets", data, "--bound", bound]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let shown = text(&output);
        assert!(shown.contains("| no more hulls than theirs | 100 % of 1 |"), "{bound}: {shown}");
        assert!(shown.contains("| broken promises | 0 |"), "{shown}");
    }
    let meshes = format!("{data}/meshes");
    let props = lab(&["targets", data, "--meshes", &meshes, "--props"]);
    assert!(text(&props).contains("| meshes | 0 |"), "of 20 triangles it is no prop");
}

#[test]
fn a_folder_without_the_tables_is_one_line_on_standard_error() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().to_str().unwrap();
    let report = format!("{folder}/report");
    for (arguments, table) in [
        (&["paper", folder, "-o", &report][..], "paper/table1.tsv"),
        (&["targets", folder], "peers/results.tsv"),
    ] {
        let output = lab(arguments);
        assert_eq!(output.status.code(), Some(1));
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(error.lines().count(), 1, "{error}");
        assert!(error.starts_with("error: ") && error.contains(table), "{error}");
    }
    assert_eq!(lab(&["no-such-command"]).status.code(), Some(2));
}

/// Scripts that stand for two builds: they write what they are told to the file that is their last
/// argument.
#[cfg(unix)]
#[test]
fn two_builds_are_identical_only_if_all_bytes_are() {
    use std::os::unix::fs::PermissionsExt;

    let root = tempfile::tempdir().unwrap();
    let meshes = folder_with_a_mesh(root.path());
    let build = |name: &str, script: &str| {
        let path = root.path().join(name);
        std::fs::write(&path, format!("#!/bin/sh\n{script}\n")).unwrap();
        std::fs::set_permissions(&path, PermissionsExt::from_mode(0o755)).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let write = |text: &str| format!("for last; do :; done; echo {text} > \"$last\"");
    let [one, same, other] =
        [("one", "a"), ("same", "a"), ("other", "b")].map(|(name, text)| build(name, &write(text)));
    let refusing = build("refusing", "exit 1");

    let equal = lab(&["identical", &one, &same, &meshes]);
    assert_eq!(equal.status.code(), Some(0));
    assert!(text(&equal).contains("2 the same, 0 refused by both, 0 different"));
    let refused = lab(&["identical", &refusing, &refusing, &meshes]);
    assert!(text(&refused).contains("0 the same, 2 refused by both"));
    for second in [other, refusing] {
        let different = lab(&["identical", &one, &second, &meshes]);
        assert_eq!(different.status.code(), Some(1));
        assert!(text(&different).contains("props/l.obj, bounded: different"));
    }
}
