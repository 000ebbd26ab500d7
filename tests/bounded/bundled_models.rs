//! The bundled models: the promise, and how many hulls each has.

use crate::judge::{assert_promise, run};

/// Hulls of each model under the default parameters. A change is a change of the algorithm, and of
/// `ALGORITHM_VERSION`.
const HULLS: [(&str, usize); 15] = [
    ("bowl", 25),
    ("chair", 10),
    ("dog", 12),
    ("gear", 29),
    ("l_prism", 2),
    ("lamp", 15),
    ("leaf", 8),
    ("mug", 23),
    ("plus", 2),
    ("props", 14),
    ("spring", 48),
    ("table", 5),
    ("teapot", 8),
    ("torus", 9),
    ("u_prism", 3),
];

#[test]
fn the_promise_holds_with_as_many_hulls_as_before() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("assets");
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "glb") {
            continue;
        }
        let file = hullwright::io::read_mesh(&path).unwrap();
        let mesh = (file.mesh.positions, file.mesh.triangles);
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let result = run(&mesh);
        assert_promise(&name, &mesh, &result);
        found.push((name, result.hulls.len()));
    }
    found.sort();
    let expected: Vec<(String, usize)> =
        HULLS.into_iter().map(|(name, hulls)| (name.to_owned(), hulls)).collect();
    assert_eq!(found, expected);
}
