//! CuACD on a graphics card beside the default method on one thread of the same machine, as a table
//! has it that was measured in one run, by an evaluator of its own.

use std::collections::BTreeMap;

use crate::report::{NOTHING, Table, number_or_nothing};
use crate::statistics::{geometric_mean, mean};
use crate::tools::data_folder::ToolResult;
use crate::tools::methods::Tool;

/// The meshes of one row of the table, by what their names begin with.
const SETS: [(&str, &[&str]); 2] =
    [("Princeton and glTF", &["princeton/", "gltf/"]), ("V-HACD's scans", &["vhacd61/"])];

/// `None` without results.
pub fn table(results: &[ToolResult]) -> Option<Table> {
    let mut methods: BTreeMap<&str, BTreeMap<&str, &ToolResult>> = BTreeMap::new();
    for result in results {
        methods.entry(&result.method).or_default().insert(&result.mesh, result);
    }
    let name = *methods.keys().find(|method| method.starts_with(Tool::Cuacd.name()))?;
    let theirs = &methods[name];
    let header = [
        "meshes",
        "number",
        "method",
        "seconds: mean",
        "time over CuACD's: geometric mean",
        "hulls: mean",
        "Hausdorff: mean",
        "no more hulls at no more distance",
        "nearer",
        "uncovered: mean",
        "IoU: mean of closed",
    ];
    let note = "From `peers/cuacd.tsv`: one run on one machine, CuACD on an H100, the default method on one thread \
                of a processor; its names say the algorithm version. Fractions of the diagonal.";
    let mut table = Table::new("Beside CuACD", note, &header);
    for (set, prefixes) in SETS {
        for (&method, own) in &methods {
            let pairs: Vec<(&ToolResult, &ToolResult)> = own
                .iter()
                .filter(|(mesh, _)| prefixes.iter().any(|prefix| mesh.starts_with(prefix)))
                .filter_map(|(mesh, &own)| Some((own, *theirs.get(mesh)?)))
                .collect();
            if pairs.is_empty() {
                continue;
            }
            let mean_of = |of: &dyn Fn(&ToolResult) -> Option<f64>| {
                let values: Vec<f64> = pairs.iter().filter_map(|(own, _)| of(own)).collect();
                (!values.is_empty()).then(|| mean(&values))
            };
            let count = |is: &dyn Fn(&ToolResult, &ToolResult) -> bool| {
                pairs.iter().filter(|(own, theirs)| is(own, theirs)).count().to_string()
            };
            let is_other = method != name;
            let ratios = pairs.iter().map(|(own, theirs)| own.seconds / theirs.seconds);
            let nearer = |own: &ToolResult, theirs: &ToolResult| own.hausdorff < theirs.hausdorff;
            let dominates = |own: &ToolResult, theirs: &ToolResult| {
                own.hulls <= theirs.hulls && own.hausdorff <= theirs.hausdorff
            };
            let if_other = |text: String| if is_other { text } else { NOTHING.into() };
            table.rows.push(vec![
                set.into(),
                pairs.len().to_string(),
                method.into(),
                number_or_nothing(mean_of(&|row| Some(row.seconds))),
                if_other(number_or_nothing(geometric_mean(ratios))),
                number_or_nothing(mean_of(&|row| Some(row.hulls as f64))),
                number_or_nothing(mean_of(&|row| row.hausdorff)),
                if_other(count(&dominates)),
                if_other(count(&nearer)),
                number_or_nothing(mean_of(&|row| row.uncovered)),
                number_or_nothing(mean_of(&|row| row.iou)),
            ]);
        }
    }
    Some(table)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn result(mesh: &str, method: &str, seconds: f64, hulls: usize, hausdorff: f64) -> ToolResult {
        let (mesh, method) = (mesh.into(), method.into());
        let hausdorff = Some(hausdorff);
        ToolResult { mesh, method, seconds, hulls, hausdorff, uncovered: Some(0.0), iou: None }
    }

    #[test]
    fn results_are_compared_mesh_by_mesh_and_only_where_both_are_there() {
        assert_eq!(table(&[]), None);
        let found = table(&[
            result("princeton/1.off", "cuacd-0.1", 1.0, 10, 0.02),
            result("gltf/a.glb", "cuacd-0.1", 4.0, 10, 0.02),
            result("princeton/1.off", "ours", 0.25, 10, 0.01),
            result("gltf/a.glb", "ours", 4.0, 11, 0.01),
            result("gltf/b.glb", "ours", 100.0, 11, 0.01),
        ])
        .unwrap();
        let [theirs, ours] = &found.rows[..] else { panic!("{found:?}") };
        assert_eq!((&theirs[2][..], &theirs[4][..], &theirs[7][..]), ("cuacd-0.1", "–", "–"));
        assert_eq!((&ours[1][..], &ours[4][..]), ("2", "0.500"), "0.25 and 1");
        assert_eq!((&ours[7][..], &ours[8][..]), ("1", "2"));
    }
}
