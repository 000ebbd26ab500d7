//! What the documentation shows is what the examples run, and what it names is there.

use std::path::Path;

use bevy::prelude::*;
use bevy::reflect::Typed;
use bevy::reflect::structs::Struct;
use bevy_hullwright::prelude::*;

use crate::app::*;
use crate::engine::*;

/// A file of the repository.
fn read(path: &str) -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).unwrap()
}

/// The blocks of a page that begin with a fence.
fn blocks<'a>(page: &'a str, fence: &str) -> Vec<&'a str> {
    page.split(fence).skip(1).map(|block| block.split("```").next().unwrap()).collect()
}

#[test]
fn every_block_of_the_page_about_scenes_is_part_of_its_example() {
    let page = read("docs/bevy-scenes.md");
    let blocks = blocks(&page, "```rust\n");
    assert!(blocks.len() >= 4);
    for block in blocks {
        // Its first line names the file.
        let (file, block) = block.strip_prefix("// ").unwrap().split_once('\n').unwrap();
        assert!(read(file).contains(block), "{file} has no\n{block}");
    }
}

#[test]
fn every_row_of_the_table_of_what_is_skipped_names_a_counter() {
    let page = read("docs/bevy-scenes.md");
    let (_, section) = page.split_once("\n## What is skipped\n").unwrap();
    let rows = section.lines().skip_while(|line| !line.starts_with("|---")).skip(1);
    let rows: Vec<&str> = rows.take_while(|line| line.starts_with('|')).collect();
    assert!(rows.len() >= 13, "{rows:?}");
    let counters = DecompositionCounters::type_info().as_struct().unwrap();
    let report = HierarchyReport::type_info().as_struct().unwrap();
    for row in rows {
        let name = row.trim_end_matches(" |").rsplit("| ").next().unwrap().trim_matches('`');
        let is_known = match name.strip_prefix("HierarchyReport::") {
            Some(name) => report.field(name).is_some(),
            None => counters.field(name).is_some(),
        };
        assert!(is_known, "{row}");
    }
}

#[test]
fn the_table_of_settings_has_their_defaults() {
    let page = read("docs/bevy/settings.md");
    // Fields of another type have the same names.
    let (page, _) = page.split_once("## `HullwrightDebug`").unwrap();
    let settings = HullwrightSettings::default();
    let groups: [&dyn Struct; 4] = [&settings, &settings.budget, &settings.cache, &settings.skip];
    let groups = groups.map(|group| (group, group.get_represented_struct_info().unwrap()));
    let fields = groups.iter().flat_map(|(group, info)| {
        info.iter().enumerate().map(|(index, field)| (field, group.field_at(index).unwrap()))
    });
    let is_group = |name: &str| ["budget", "cache", "skip"].contains(&name);
    for (field, value) in fields.filter(|(field, _)| !is_group(field.name())) {
        let value = format!("{value:?}");
        let value = match value.as_str() {
            "Some(5s)" => "5 s",
            "1ms" => "1 ms",
            "100ms" => "0.1 s",
            "67108864" => "64 MiB",
            "268435456" => "256 MiB",
            "0.0" => "0",
            value => value,
        };
        let row = page.lines().rfind(|line| line.starts_with(&format!("| `{}` |", field.name())));
        let cell = row.unwrap().trim_end_matches(" |").rsplit("| ").next().unwrap();
        let cell =
            cell.replace('`', "").replace("FallbackCollider::", "").replace("Execution::", "");
        assert!(cell.split("; ").next() == Some(value), "{}: {cell}, not {value}", field.name());
    }
}

#[test]
fn the_first_program_prints_what_the_page_says() {
    let page = read("docs/bevy.md");
    let printed = page.split("It prints `").nth(1).unwrap().split('`').next().unwrap();
    let torus = Mesh::from(Torus::default());
    let (app, entity) = finished(torus, (RigidBody::Dynamic, ConvexDecomposition::default()));
    let (of, made_of) = seen(&app).with_collider[0];
    assert_eq!((of, format!("{made_of:?}").as_str()), (entity, printed));
}
