//! The keys of JSON that `docs/command.md` lists are those that are printed.

use std::collections::BTreeSet;

use serde_json::Value;

use crate::{Place, asset};

/// The keys of a section: what stands between backticks in the first column of its table.
fn documented(command: &str) -> BTreeSet<String> {
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/command.md");
    let page = std::fs::read_to_string(page).unwrap();
    let (_, section) = page.split_once(&format!("### `{command} --json`")).unwrap();
    let section = section.split("\n### ").next().unwrap();
    let rows = section.lines().filter(|line| line.starts_with("| `"));
    let cells = rows.map(|row| row.split('|').nth(1).unwrap());
    cells.flat_map(|cell| cell.split('`').skip(1).step_by(2)).map(String::from).collect()
}

/// The paths of all values. Stages depend on the method.
fn add_keys(value: &Value, path: &str, keys: &mut BTreeSet<String>) {
    match value {
        Value::Object(fields) if path == "stage_seconds" => {
            assert!(fields.values().all(Value::is_number));
            keys.insert(format!("{path}.*"));
        }
        Value::Object(fields) => {
            let dot = if path.is_empty() { "" } else { "." };
            fields
                .iter()
                .for_each(|(key, value)| add_keys(value, &format!("{path}{dot}{key}"), keys));
        }
        Value::Array(values) => {
            values.iter().for_each(|value| add_keys(value, &format!("{path}[]"), keys));
        }
        _ => {
            keys.insert(path.into());
        }
    }
}

#[test]
fn the_documented_keys_are_those_that_are_printed() {
    let cut = "solid cut\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n\
               endloop\nendfacet\n";
    let place = Place::new(&[("cut.stl", cut)]);
    let (open, solid) = (asset("props.glb"), asset("l_prism.glb"));
    place.succeed(&["decompose", &solid, "-o", "hulls.obj"]);
    for (command, lines) in [
        (
            "decompose",
            &[
                &["decompose", &open][..],
                &["decompose", "cut.stl"],
                &["decompose", &solid, "--method", "surface", "--search"],
                &["decompose", &solid, "--method", "hull"],
            ][..],
        ),
        ("curve", &[&["curve", &solid]]),
        ("measure", &[&["measure", &solid, "hulls.obj", "--verify"]]),
        ("measure --surface", &[&["measure", &solid, &open, "--surface"]]),
        ("simplify", &[&["simplify", &solid]]),
    ] {
        let mut printed = BTreeSet::new();
        for line in lines {
            add_keys(&place.json(line), "", &mut printed);
        }
        assert_eq!(printed, documented(command), "{command}");
    }
}
