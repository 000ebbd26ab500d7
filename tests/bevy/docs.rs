//! What the documentation shows is what the examples run.

use std::path::Path;

/// The blocks of Rust in a page, each with the file that its first line names.
fn blocks(page: &str) -> Vec<(&str, &str)> {
    let blocks = page.split("```rust\n").skip(1);
    let whole = blocks.map(|block| block.split("```").next().unwrap());
    whole.map(|block| block.strip_prefix("// ").unwrap().split_once('\n').unwrap()).collect()
}

#[test]
fn every_block_of_the_page_about_scenes_is_part_of_its_example() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = std::fs::read_to_string(root.join("docs/bevy-scenes.md")).unwrap();
    let blocks = blocks(&page);
    assert!(blocks.len() >= 4);
    for (file, block) in blocks {
        let example = std::fs::read_to_string(root.join(file)).unwrap();
        assert!(example.contains(block), "{file} has no\n{block}");
    }
}
