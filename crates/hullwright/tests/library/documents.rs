//! What documents say is what is there: tests, links, paths, constants, and the hulls of the
//! bundled models.

use std::path::{Path, PathBuf};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// A Markdown file of the repository.
struct Document {
    path: PathBuf,
    text: String,
}

impl Document {
    fn read(path: impl AsRef<Path>) -> Self {
        let path = Path::new(ROOT).join(path);
        let text = std::fs::read_to_string(&path).unwrap();
        Self { path, text }
    }

    /// All that are about what is there.
    fn all() -> Vec<Self> {
        let folders = ["docs", "docs/bevy"].map(|folder| Path::new(ROOT).join(folder));
        let files = folders.iter().flat_map(|folder| std::fs::read_dir(folder).unwrap());
        let files = files.map(|file| file.unwrap().path());
        let pages = files.filter(|path| path.extension().is_some_and(|suffix| suffix == "md"));
        let others = ["README.md", "CHANGELOG.md", "CONTRIBUTING.md", "assets/README.md"];
        let mut all: Vec<Self> = others.map(Self::read).into_iter().collect();
        all.extend(pages.map(Self::read));
        assert!(all.len() >= 15, "{}", all.len());
        all
    }

    /// The text of a section, without its heading.
    fn section(&self, heading: &str) -> &str {
        let heading = format!("\n## {heading}\n");
        let (_, section) = self.text.split_once(&heading).expect(&heading);
        section.split("\n## ").next().unwrap_or(section)
    }

    /// The text without blocks of code.
    fn prose(&self) -> String {
        self.text.split("```").step_by(2).collect()
    }

    /// The headings as the last part of a link.
    fn anchors(&self) -> Vec<String> {
        let prose = self.prose();
        let headings = prose.lines().filter(|line| line.starts_with('#'));
        let letters = |heading: &str| {
            let plain = heading.trim_start_matches('#').trim().to_lowercase().replace(' ', "-");
            plain.chars().filter(|&c| c.is_alphanumeric() || c == '-' || c == '_').collect()
        };
        headings.map(letters).collect()
    }
}

/// Rows of the first table in a part of a document, without its head, each as its cells.
fn rows(text: &str) -> Vec<Vec<&str>> {
    let lines = text.lines().skip_while(|line| !line.starts_with("|---")).skip(1);
    let lines = lines.take_while(|line| line.starts_with('|'));
    lines.map(|line| line.trim_matches('|').split('|').map(str::trim).collect()).collect()
}

/// What stands between backticks, each with the text before it.
fn code(text: &str) -> Vec<(&str, &str)> {
    let parts: Vec<&str> = text.split('`').collect();
    parts.chunks_exact(2).map(|part| (part[0], part[1])).collect()
}

/// What is wrong with tests that a part of a document names: files that are not there, tests that
/// are not in them. Files are below the `tests` of a package, unless they are sources.
fn missing_tests(text: &str) -> Vec<String> {
    let mut missing = Vec::new();
    let mut file = None;
    for (_, code) in code(text) {
        if code.ends_with(".rs") {
            let is_source = code.contains("/src/") || code.starts_with("fuzz/");
            let folder = match code.split('/').next() {
                _ if is_source => "",
                Some("cli") => "crates/cli/tests",
                Some("io") => "crates/formats/tests",
                Some("physics") => "crates/rapier/tests",
                Some("bevy") => "tests",
                _ => "crates/hullwright/tests",
            };
            let path = Path::new(ROOT).join(folder).join(code);
            match std::fs::read_to_string(path) {
                Err(_) => missing.push(format!("{code}: there is no such file")),
                Ok(source) if !is_source && !source.contains("#[test]") => {
                    missing.push(format!("{code}: there is no test in it"));
                }
                Ok(source) => file = Some((code, source)),
            }
        } else if let Some((file, source)) = &file
            && code.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        {
            let is_test = source.split("#[test]").skip(1).any(|after| {
                let name = after.split_once("fn ").map_or("", |(_, name)| name);
                name.starts_with(&format!("{code}("))
            });
            if !is_test {
                missing.push(format!("{file}: there is no test {code}"));
            }
        }
    }
    missing
}

#[test]
fn each_row_of_bad_input_and_reference_checks_names_a_test_that_is_there() {
    let page = Document::read("docs/reliability.md");
    let (input, references) =
        (rows(page.section("Bad input")), rows(page.section("Reference checks")));
    assert!(input.len() > 20 && references.len() > 5, "{} and {}", input.len(), references.len());
    let mut wrong = Vec::new();
    for row in input.iter().chain(&references) {
        let shown_by = row.last().unwrap();
        if !shown_by.contains(".rs`") {
            wrong.push(format!("no test: {row:?}"));
        }
        wrong.extend(missing_tests(shown_by));
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn tests_that_the_rest_of_the_page_about_reliability_names_are_there() {
    let page = Document::read("docs/reliability.md");
    // Sentences put a file and its tests into one pair of brackets.
    let brackets = page.text.split('(').skip(1).filter_map(|part| part.split(')').next());
    let wrong: Vec<String> = brackets.flat_map(missing_tests).collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn a_test_that_is_not_there_is_noticed() {
    let limits = "`library/limits.rs`: `past_the_time_limit_a_slice_ends_early`";
    assert!(missing_tests(limits).is_empty());
    assert_eq!(missing_tests("`library/limits.rs`: `methods`").len(), 1, "no test");
    assert_eq!(missing_tests("`nowhere.rs`").len(), 1);
}

#[test]
fn links_lead_to_files_and_headings_that_are_there() {
    let mut wrong = Vec::new();
    for document in Document::all() {
        let prose = document.prose();
        let links = prose.split("](").skip(1).filter_map(|link| link.split(')').next());
        for link in links.filter(|link| !link.contains("://")) {
            let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
            let path = document.path.parent().unwrap().join(file);
            let path = if file.is_empty() { document.path.clone() } else { path };
            let is_there = match anchor {
                "" => path.exists(),
                anchor => path.is_file() && Document::read(path).anchors().contains(&anchor.into()),
            };
            if !is_there {
                wrong.push(format!("{}: {link}", document.path.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn sources_that_documents_name_are_there_and_have_what_is_named_after_them() {
    const FOLDERS: [&str; 10] = [
        "src", "tests", "crates", "docs", "examples", "assets", "fuzz", "viewer", "mutants", ".ci",
    ];
    let ignored = std::fs::read_to_string(Path::new(ROOT).join(".gitignore")).unwrap();
    let made: Vec<&str> = ignored.lines().chain(["fuzz/work"]).collect();
    let mut wrong = Vec::new();
    for document in Document::all() {
        let mut source = None;
        for (before, code) in code(&document.prose()) {
            let is_path = FOLDERS.iter().any(|folder| code.split('/').next() == Some(folder))
                && code.contains('/')
                && !code.contains([' ', '*', '{', '<']);
            // Programs make these: a fresh clone has none of them.
            let is_made = made.iter().any(|made| Path::new(code).starts_with(made));
            if is_path && !is_made {
                let path = Path::new(ROOT).join(code);
                if !path.exists() {
                    wrong.push(format!("{}: {code}", document.path.display()));
                }
                source = std::fs::read_to_string(path).ok().map(|text| (code, text));
            } else if let Some((file, text)) = &source
                && [": ", ", "].contains(&before)
                && !code.contains('/')
                && !code.split(['.', ':', '(']).all(|name| text.contains(name))
            {
                wrong.push(format!("{}: {file} has no {code}", document.path.display()));
            } else if ![": ", ", "].contains(&before) {
                source = None;
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// The numbers in a text, such as those of `4 to 16 %`, `1.5 million`, `20,000` and `0.04..=0.16`.
fn numbers(text: &str) -> Vec<f64> {
    let mut unit = if text.contains('%') { 0.01 } else { 1.0 };
    if text.contains("million") {
        unit *= 1e6;
    }
    let is_number = |c: char| c.is_ascii_digit() || "._,e-".contains(c);
    let words = text.split("..=").flat_map(|part| part.split(|c| !is_number(c)));
    words
        .filter_map(|word| word.replace([',', '_'], "").parse::<f64>().ok())
        .map(|x| x * unit)
        .collect()
}

/// The value of a constant of a source, or of one of its fields, as it is written.
fn constant<'a>(source: &'a str, name: &str) -> Option<&'a str> {
    let (name, field) = name.split_once('.').unwrap_or((name, ""));
    let (_, value) = source.split_once(&format!("const {name}:"))?;
    let (_, value) = value.split_once(';')?.0.split_once('=')?;
    match field {
        "" => Some(value),
        field => value.split_once(&format!("{field}: "))?.1.split([',', '}']).next(),
    }
}

/// The numbers in the page about the method, as it says them, and the constants of the source that
/// they are.
const CONSTANTS: [(&str, &[(&str, &str)]); 16] = [
    (
        "crates/hullwright/src/parameters.rs",
        &[("2 % of the diagonal", "DEFAULT_MAX_ERROR"), ("64 vertices", "DEFAULT_MAX_VERTICES")],
    ),
    (
        "crates/hullwright/src/bounded/settings.rs",
        &[
            ("0.001 ε", "EXACT_SHARE"),
            ("0.02 ε", "OF_FEW.coarse"),
            ("0.2 ε", "OF_MANY.coarse"),
            ("0.9 ε", "OF_FEW.search"),
            ("0.92 ε", "OF_MANY.search"),
            ("0.985 ε", "OF_FEW.last_round"),
            ("0.95 ε", "OF_MANY.last_round"),
            ("5 % of ε", "MAX_UNCOVERED"),
            ("15 % of ε", "MAX_UNCOVERED_UNDER_LIMIT"),
            ("longer than 4 ε", "LONGEST_EDGE"),
            ("4 to 16 % of the diagonal", "LONGEST_EDGE_LIMITS"),
            ("0.12 times the square root", "BALANCED.patch_size"),
            ("20,000 joint hulls", "BALANCED.dissolve_attempts"),
            ("0.35 times the square root", "FAST.patch_size"),
        ],
    ),
    ("crates/hullwright/src/solid/surface.rs", &[("0.52", "OPEN_INSIDE")]),
    ("crates/hullwright/src/solid/grid.rs", &[("1.5 million cells", "MAX_CELLS")]),
    ("crates/hullwright/src/solid/solid.rs", &[("2,400 triangles", "COARSE")]),
    (
        "crates/hullwright/src/bounded/patch_mesh.rs",
        &[("more than 1,200 components", "MOST_COMPONENTS")],
    ),
    (
        "crates/hullwright/src/bounded/facets.rs",
        &[("deeper than 1.5 ε", "LEAST_DEPTH"), ("48 planes", "MAX_PLANES")],
    ),
    (
        "crates/hullwright/src/solid/fit.rs",
        &[("0.4 times as large", "LENIENCE"), ("radius below 0.35 ε", "SMALL")],
    ),
    ("crates/hullwright/src/bounded/cover/grow.rs", &[("until 8 in turn", "MAX_REFUSED_IN_TURN")]),
    (
        "crates/hullwright/src/bounded/finalize/fill.rs",
        &[
            ("2,000 points", "POINTS"),
            ("4,000", "POINTS_INSIDE"),
            ("16 points at a time", "MAX_INSERTED"),
        ],
    ),
    (
        "crates/hullwright/src/hull/convex_hull.rs",
        &[("0.001 times their diagonal", "MINIMUM_THICKNESS")],
    ),
    ("crates/hullwright/src/bounded/finalize/mod.rs", &[("1.25 times as many", "DOUBTFUL")]),
    (
        "crates/hullwright/src/bounded/limit.rs",
        &[("4 searches", "SEARCHES"), ("0.85 times", "NEXT_BOUND")],
    ),
    (
        "crates/hullwright/src/solid/protrusion.rs",
        &[
            ("the resolution: 4 % of ε", "RESOLUTION"),
            ("0.5 % of ε", "FINE_RESOLUTION"),
            ("Below 0.25 ε", "UNRESOLVED"),
            ("0.75 ε if the solid is open", "UNRESOLVED_IN_OPEN"),
            ("200,000 parts", "MAX_PARTS"),
        ],
    ),
    ("crates/hullwright/src/solid/boundary.rs", &[("72 such edges", "FEW_EDGES")]),
    ("crates/hullwright/src/bounded/uncovered.rs", &[("up to 8 times", "MAX_DIVISIONS")]),
];

#[test]
fn constants_of_the_page_about_the_method_are_those_of_the_source() {
    let page = Document::read("docs/algorithm.md");
    let prose = page.text.split_whitespace().collect::<Vec<_>>().join(" ");
    for (file, constants) in CONSTANTS {
        let source = std::fs::read_to_string(Path::new(ROOT).join(file)).unwrap();
        for &(quote, name) in constants {
            let value = constant(&source, name).unwrap_or_else(|| panic!("{file} has no {name}"));
            let (said, is) = (numbers(quote), numbers(value));
            let is_same = said.len() == is.len()
                && said.iter().zip(&is).all(|(a, b)| (a - b).abs() <= 1e-9 * b.abs());
            assert!(!is.is_empty() && is_same, "{quote}: {name} is {value}");
            assert!(prose.contains(quote), "the text does not say: {quote}");
        }
    }
}

#[test]
fn documents_say_which_algorithm_version_they_are_about() {
    let version = format!("algorithm version {}", hullwright::ALGORITHM_VERSION);
    for path in ["CHANGELOG.md", "docs/gallery.md"] {
        assert!(Document::read(path).text.contains(&version), "{path}");
    }
}

mod hulls {
    use std::collections::HashMap;
    use std::path::Path;

    use hullwright::{Control, Decomposition, Parameters, decompose};

    use super::{Document, ROOT, rows};

    /// Decompositions of bundled models, each made once.
    #[derive(Default)]
    struct Decompositions(HashMap<(String, String), Decomposition>);

    impl Decompositions {
        fn of(&mut self, model: &str, bound: &str) -> &Decomposition {
            let key = (model.to_owned(), bound.replace(' ', ""));
            self.0.entry(key).or_insert_with_key(|(model, bound)| {
                let path = Path::new(ROOT).join(format!("assets/{model}.glb"));
                let parameters: Parameters = format!("max_error={bound}").parse().unwrap();
                let mesh = hullwright_formats::read_mesh(path).unwrap();
                decompose(&mesh, &parameters, &Control::new()).unwrap()
            })
        }

        fn hulls(&mut self, model: &str, bound: &str) -> String {
            format!("{} hulls", self.of(model, bound).hulls.len())
        }

        fn vertices(&mut self, model: &str) -> usize {
            self.of(model, "2%").hulls.iter().map(|hull| hull.shape.points.len()).sum()
        }
    }

    fn is_model(name: &str) -> bool {
        Path::new(ROOT).join(format!("assets/{name}.glb")).is_file()
    }

    #[test]
    fn documents_say_how_many_hulls_the_bundled_models_have() {
        let mut made = Decompositions::default();

        let page = Document::read("docs/algorithm.md");
        let table = page.section("The bound");
        let (_, head) = table.split_once("\n| bound |").unwrap();
        let models: Vec<&str> = head.lines().next().unwrap().split('|').map(str::trim).collect();
        assert!(models.len() > 3 && rows(table).len() > 3);
        for row in rows(table) {
            for (model, said) in models.iter().zip(&row[1..]) {
                assert_eq!(*said, made.hulls(model, row[0]), "{model} within {}", row[0]);
            }
        }
        let patches = format!("the dog has {} patches", made.of("dog", "2%").report.patches);
        assert!(page.text.contains(&patches), "{patches}");

        let page = Document::read("docs/bevy/bounds.md");
        let mug = rows(&page.text).into_iter().find(|row| row[0] == "mug").unwrap();
        for cell in &mug[1..] {
            let (bound, said) = cell.split_once(": ").unwrap();
            assert_eq!(said, made.hulls("mug", bound), "mug within {bound}");
        }

        let page = Document::read("docs/gallery.md");
        let mut count = 0;
        for entry in page.text.split("\n### ").skip(1) {
            let model = entry.lines().next().unwrap().replace(' ', "_");
            if is_model(&model) {
                let vertices = made.vertices(&model);
                let said =
                    format!("\nHullwright: {}, {vertices} vertices", made.hulls(&model, "2%"));
                assert!(entry.contains(&said), "{model}: not {said}");
                count += 1;
            }
        }
        assert_eq!(count, 14);
    }

    #[test]
    fn the_read_me_shows_what_the_command_and_the_demo_print() {
        let mut made = Decompositions::default();
        let text = Document::read("README.md").text;
        let mut demo = 0;
        for line in text.lines() {
            let words: Vec<&str> = line.split_whitespace().collect();
            if let [model, triangles, hulls, _, ..] = words[..]
                && is_model(model)
            {
                let found = made.of(model, "2%");
                assert_eq!(hulls, found.hulls.len().to_string(), "{model}");
                assert_eq!(triangles, found.run.source_triangles.to_string(), "{model}");
                demo += 1;
            }
        }
        assert_eq!(demo, 2);

        let (_, shown) = text.split_once("\ncargo hulls assets/").unwrap();
        let (model, _) = shown.split_once(".glb").unwrap();
        let row = shown.lines().skip_while(|line| !line.starts_with("hulls ")).nth(1).unwrap();
        let vertices = made.vertices(model).to_string();
        let found = made.of(model, "2%");
        let percent = |length: f64| format!("{:.3}", 100.0 * length / found.run.diagonal);
        let hulls = found.hulls.len().to_string();
        let (protrusion, uncovered) = (found.report.protrusion_max, found.report.uncovered_max);
        let words: Vec<&str> = row.split_whitespace().collect();
        assert_eq!(words[..2], [hulls, vertices]);
        assert_eq!(
            [words[4], words[6], words[8]],
            [found.report.bound, protrusion, uncovered].map(percent)
        );
    }
}
