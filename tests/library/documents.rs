//! Tests that documents name: each is there, so that a promise in a table is one that a test can break.

use std::path::Path;

/// `file.rs`: `name`, as `docs/reliability.md` names tests.
struct Named<'a> {
    file: &'a str,
    test: Option<&'a str>,
}

/// What stands between backticks in a part of a document, as files and the tests in them.
fn named(text: &str) -> Vec<Named<'_>> {
    let mut all = Vec::new();
    let mut file = None;
    for code in text.split('`').skip(1).step_by(2) {
        if code.ends_with(".rs") {
            file = Some(code);
            all.push(Named { file: code, test: None });
        } else if let Some(file) = file
            && code.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        {
            all.push(Named { file, test: Some(code) });
        }
    }
    all
}

/// What is wrong with what a part names: files that are not there, tests that are not in them.
fn missing(text: &str) -> Vec<String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut missing = Vec::new();
    for Named { file, test } in named(text) {
        // Paths are below `tests`, except those of the sources.
        let is_source = file.starts_with("src/") || file.starts_with("fuzz/");
        let base = if is_source { root.to_path_buf() } else { root.join("tests") };
        let Ok(source) = std::fs::read_to_string(base.join(file)) else {
            missing.push(format!("{file}: there is no such file"));
            continue;
        };
        let Some(test) = test else {
            if !is_source && !source.contains("#[test]") {
                missing.push(format!("{file}: there is no test in it"));
            }
            continue;
        };
        let is_test = source.split("#[test]").skip(1).any(|after| {
            after.split_once("fn ").is_some_and(|(_, name)| name.starts_with(&format!("{test}(")))
        });
        if !is_test {
            missing.push(format!("{file}: there is no test {test}"));
        }
    }
    missing
}

fn reliability() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/reliability.md");
    std::fs::read_to_string(path).unwrap()
}

/// Rows of the table in a section, without its head.
fn rows<'a>(text: &'a str, section: &str) -> Vec<&'a str> {
    let (_, section) = text.split_once(section).expect("the section");
    let section = section.split("\n## ").next().unwrap_or(section);
    section.lines().filter(|line| line.starts_with("| ")).skip(1).collect()
}

#[test]
fn each_row_of_bad_input_and_reference_checks_names_a_test_that_is_there() {
    let text = reliability();
    let (input, references) = (rows(&text, "## Bad input"), rows(&text, "## Reference checks"));
    assert!(input.len() > 20 && references.len() > 5, "{} and {}", input.len(), references.len());
    let mut wrong = Vec::new();
    for row in input.into_iter().chain(references) {
        let shown_by = row.trim_end_matches('|').rsplit('|').next().unwrap_or_default();
        if named(shown_by).is_empty() {
            wrong.push(format!("no test: {row}"));
        }
        wrong.extend(missing(shown_by));
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn tests_that_the_rest_of_the_document_names_are_there() {
    let text = reliability();
    // Sentences put a file and its tests into one pair of brackets.
    let wrong: Vec<String> = text
        .split('(')
        .skip(1)
        .filter_map(|part| part.split(')').next())
        .flat_map(missing)
        .collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn a_test_that_is_not_there_is_noticed() {
    assert!(missing("`library/limits.rs`: `past_the_time_limit_a_slice_ends_early`").is_empty());
    assert_eq!(missing("`library/limits.rs`: `methods`").len(), 1, "a function that is no test");
    assert_eq!(missing("`nowhere.rs`").len(), 1);
}
