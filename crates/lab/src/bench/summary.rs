//! Tables over all meshes: medians and means, success, and how methods stand against each other.

use std::collections::{BTreeMap, BTreeSet};

use super::curves::{Comparison, Curve, Point, versus};
use crate::harness::row::Figure;
use crate::harness::{Row, Status};
use crate::report::{NOTHING, Table, number, number_or_nothing};
use crate::statistics::{geometric_mean, median};

/// Rows by method and setting, methods in the order of [`METHODS`].
pub struct Results<'a> {
    pub rows: Vec<&'a Row>,
}

/// Methods with their settings, and the rows of each.
pub type Variants<'a> = Vec<((&'a str, &'a str), Vec<&'a Row>)>;

/// Ratios closer to 1 than this count as equal: the three digits of the tables would not show them.
const EQUAL: f64 = 0.005;

/// The order of methods in tables and plots.
pub const METHODS: [&str; 6] =
    ["bounded", "surface", "hacd", "vhacd", "coacd-files", "cuacd-files"];

fn place(method: &str) -> Option<usize> {
    METHODS.iter().position(|&other| other == method)
}

impl<'a> Results<'a> {
    /// Of several rows of one mesh, method and setting, with different versions, the last counts.
    pub fn new(rows: &'a [Row]) -> Self {
        let mut latest: BTreeMap<(Option<usize>, &str, &str), &Row> = BTreeMap::new();
        for row in rows {
            latest.insert((place(&row.method), &row.setting, &row.mesh), row);
        }
        Self { rows: latest.into_values().collect() }
    }

    pub fn meshes(&self) -> BTreeSet<&'a str> {
        self.rows.iter().map(|row| row.mesh.as_str()).collect()
    }

    fn only(&self, is_wanted: impl Fn(&Row) -> bool) -> Self {
        Self { rows: self.rows.iter().copied().filter(|row| is_wanted(row)).collect() }
    }

    pub fn variants(&self) -> Variants<'a> {
        let mut variants: Variants<'a> = Vec::new();
        for row in &self.rows {
            let name = (row.method.as_str(), row.setting.as_str());
            match variants.iter_mut().find(|(other, _)| *other == name) {
                Some((_, rows)) => rows.push(row),
                None => variants.push((name, vec![row])),
            }
        }
        let order = |(method, setting): (&str, &str)| {
            let numbers = setting.split([' ', ',']).filter_map(|word| word.parse::<f64>().ok());
            // V-HACD's resolution first, then its concavity.
            (place(method), numbers.rev().map(|x| (x * 1e6) as u64).collect::<Vec<_>>())
        };
        variants.sort_by_key(|(name, _)| order(*name));
        variants
    }

    /// The curve of each method on each mesh.
    pub fn curves(&self) -> BTreeMap<&'a str, BTreeMap<&'a str, Curve>> {
        let mut points: BTreeMap<&str, BTreeMap<&str, Vec<Point>>> = BTreeMap::new();
        for row in self.rows.iter().filter(|row| row.is_done()) {
            let (Some(hulls), Some(error)) = (row.hulls, row.hausdorff) else { continue };
            let point = Point { hulls: hulls as f64, error };
            points.entry(&row.method).or_default().entry(&row.mesh).or_default().push(point);
        }
        let curves = |meshes: BTreeMap<&'a str, Vec<Point>>| {
            meshes.into_iter().map(|(mesh, points)| (mesh, Curve::new(points))).collect()
        };
        points.into_iter().map(|(method, meshes)| (method, curves(meshes))).collect()
    }

    /// Our method's name, and how it stands against each other method on each mesh.
    pub fn versus(&self) -> (&'static str, Vec<(&'a str, &'a str, Comparison)>) {
        let curves = self.curves();
        let name = if curves.contains_key("bounded") { "bounded" } else { "surface" };
        let mut found = Vec::new();
        let own = curves.get(name);
        for (&other, meshes) in curves.iter().filter(|(method, _)| **method != name) {
            for (&mesh, theirs) in meshes {
                let Some(own) = own.and_then(|own| own.get(mesh)) else { continue };
                found.push((mesh, other, versus(own, theirs)));
            }
        }
        (name, found)
    }

    pub fn tables(&self) -> Vec<Table> {
        let all = "Over all meshes that a setting has done.";
        let variants = self.variants();
        let mut tables =
            vec![medians("Medians", all, &variants), self.against(), success(&variants)];
        let folders: BTreeSet<&str> = self.rows.iter().map(|row| row.folder()).collect();
        for name in folders {
            let rows = self.only(|row| row.folder() == name && row.is_default()).variants();
            let title = format!("Medians in {name}");
            tables.push(medians(&title, "Each method's default setting.", &rows));
        }
        tables.push(self.where_others_win());
        tables
    }

    /// Ratios and wins of every method against every other.
    fn against(&self) -> Table {
        let header = [
            "method",
            "against",
            "meshes",
            "hulls at equal error",
            "fewer",
            "equal",
            "more",
            "not reached",
            "error at equal hulls",
            "less",
            "equal ",
            "more ",
            "not reached ",
        ];
        let note = "Ratios of the first method's curve to the other's settings, below 1 is better \
                    for the first: per mesh the geometric mean over the other's settings, then the \
                    geometric mean over meshes. Between two settings a curve is straight in \
                    logarithms; it is not drawn out beyond its ends, except that what does better \
                    than asked counts as it is. Not reached: no setting of the first comes so far.";
        let mut table = Table::new("Against each other", note, &header);
        let curves = self.curves();
        let pairs =
            METHODS.iter().flat_map(|ours| METHODS.iter().map(move |theirs| (ours, theirs)));
        for (&ours, &theirs) in pairs.filter(|(ours, theirs)| ours != theirs) {
            let (Some(own), Some(other)) = (curves.get(ours), curves.get(theirs)) else { continue };
            let both: Vec<Comparison> = other
                .iter()
                .filter_map(|(mesh, other)| Some(versus(own.get(mesh)?, other)))
                .collect();
            if both.is_empty() {
                continue;
            }
            let mut cells = vec![ours.to_owned(), theirs.to_owned(), both.len().to_string()];
            for of in [|v: &Comparison| v.hulls, |v: &Comparison| v.error] {
                let ratios: Vec<f64> = both.iter().filter_map(of).collect();
                let count = |is: &dyn Fn(f64) -> bool| ratios.iter().filter(|r| is(**r)).count();
                cells.push(number_or_nothing(geometric_mean(ratios.iter().copied())));
                cells.push(count(&|ratio| ratio < 1.0 - EQUAL).to_string());
                cells.push(count(&|ratio| (ratio - 1.0).abs() <= EQUAL).to_string());
                cells.push(count(&|ratio| ratio > 1.0 + EQUAL).to_string());
                cells.push((both.len() - ratios.len()).to_string());
            }
            table.rows.push(cells);
        }
        table
    }

    /// Meshes on which another method needs fewer hulls than ours at equal error.
    fn where_others_win(&self) -> Table {
        let (name, versus) = self.versus();
        let ratios =
            versus.into_iter().filter_map(|(mesh, method, v)| Some((v.hulls?, mesh, method)));
        let mut losses: Vec<_> = ratios.filter(|(ratio, ..)| *ratio > 1.0 + EQUAL).collect();
        losses.sort_by(|a, b| b.0.total_cmp(&a.0).then_with(|| (a.1, a.2).cmp(&(b.1, b.2))));
        let note = format!(
            "{} pairs of a mesh and another method that needs fewer hulls than {name} at equal \
             error; the {} widest gaps.",
            losses.len(),
            losses.len().min(MOST_LOSSES)
        );
        let header = ["mesh", "other method", "our hulls over theirs at equal error"];
        let mut table = Table::new("Where others win", &note, &header);
        for (ratio, mesh, other) in losses.into_iter().take(MOST_LOSSES) {
            table.rows.push(vec![mesh.into(), other.into(), number(ratio)]);
        }
        table
    }
}

/// Rows of the table of losses, as many as fit a page; all of them are in `versus.csv`.
const MOST_LOSSES: usize = 40;

fn medians(title: &str, note: &str, variants: &Variants<'_>) -> Table {
    let mut header = vec!["method", "setting", "meshes"];
    header.extend(FIGURES.iter().map(|(name, _)| *name));
    let mut table = Table::new(title, note, &header);
    for ((method, setting), rows) in variants {
        let done: Vec<&&Row> = rows.iter().filter(|row| row.is_done()).collect();
        let mut cells = vec![(*method).to_owned(), (*setting).to_owned(), done.len().to_string()];
        for (_, figure) in FIGURES {
            let values: Vec<f64> = done.iter().filter_map(|row| figure(row)).collect();
            cells.push(number_or_nothing((!values.is_empty()).then(|| median(values))));
        }
        table.rows.push(cells);
    }
    table
}

fn success(variants: &Variants<'_>) -> Table {
    let mut header = vec!["method", "setting", "meshes"];
    header.extend(Status::ALL.iter().map(|status| status.name()));
    header.extend(["hulls that are not convex", "without volume", "differs by threads"]);
    let note = "How runs ended. Hulls are convex up to 1e-6 of the diagonal.";
    let mut table = Table::new("Success", note, &header);
    for ((method, setting), rows) in variants {
        let mut cells = vec![(*method).to_owned(), (*setting).to_owned(), rows.len().to_string()];
        for status in Status::ALL {
            cells.push(rows.iter().filter(|row| row.status == status).count().to_string());
        }
        let sum =
            |of: fn(&Row) -> Option<usize>| rows.iter().filter_map(|row| of(row)).sum::<usize>();
        cells.push(sum(|row| row.non_convex_hulls).to_string());
        cells.push(sum(|row| row.hulls_without_volume).to_string());
        let same: Vec<bool> = rows.iter().filter_map(|row| row.same_with_all_threads).collect();
        cells.push(match same.is_empty() {
            true => NOTHING.into(),
            false => same.iter().filter(|same| !**same).count().to_string(),
        });
        table.rows.push(cells);
    }
    table
}

/// The columns of most tables.
const FIGURES: [Figure; 14] = [
    ("hulls", |row| Some(row.hulls? as f64)),
    ("vertices", |row| Some(row.vertices? as f64)),
    ("seconds", |row| row.seconds),
    ("seconds, all threads", |row| row.seconds_all_threads),
    ("MB", Row::megabytes),
    ("Hausdorff", |row| row.hausdorff),
    ("protrusion, mean", |row| row.protrusion_mean),
    ("protrusion, p99", |row| row.protrusion_p99),
    ("uncovered, mean", |row| row.uncovered_mean),
    ("uncovered, max", |row| row.uncovered_max),
    ("uncovered volume", |row| row.uncovered_volume),
    ("IoU", |row| row.iou),
    ("overlap", |row| row.overlap),
    ("cost", |row| row.cost),
];
