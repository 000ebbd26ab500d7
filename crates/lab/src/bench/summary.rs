//! Tables over all meshes: medians and means, success, and how methods stand against each other.

use std::collections::{BTreeMap, BTreeSet};

use super::curves::{Comparison, Curve, Point, versus};
use crate::report::table::{NOTHING, Table, number, number_or_nothing};
use crate::runs::judge::Judged;
use crate::runs::meshes;
use crate::runs::methods::Run;
use crate::runs::record::{Row, Status, Worked};
use crate::statistics::{geometric_mean, mean, median};

/// Rows by method and setting, methods in the order of the plan.
pub struct Results<'a> {
    pub rows: Vec<&'a Row>,
}

/// Ratios closer to 1 than this count as equal: the three digits of the tables would not show them.
const EQUAL: f64 = 0.005;

/// The order of methods in tables and plots.
pub const METHODS: [&str; 7] =
    ["bounded", "surface", "hacd", "vhacd", "vhacd4", "coacd", "coacd-files"];

impl<'a> Results<'a> {
    /// Of several rows of one mesh, method and setting, with different versions, the last counts.
    pub fn new(rows: &'a [Row]) -> Self {
        let place = |row: &Row| METHODS.iter().position(|&method| method == row.method);
        let mut latest: BTreeMap<(Option<usize>, &str, &str), &Row> = BTreeMap::new();
        for row in rows {
            latest.insert((place(row), &row.setting, &row.mesh), row);
        }
        Self { rows: latest.into_values().collect() }
    }

    pub fn meshes(&self) -> BTreeSet<&'a str> {
        self.rows.iter().map(|row| row.mesh.as_str()).collect()
    }

    /// What there is on the meshes that CoACD's hull files are for, if not on all.
    pub fn shared_with_files(&self) -> Option<Self> {
        let is_file = |row: &&&Row| row.method == "coacd-files" && row.done().is_some();
        let meshes: BTreeSet<&str> =
            self.rows.iter().filter(is_file).map(|row| row.mesh.as_str()).collect();
        if meshes.is_empty() || meshes == self.meshes() {
            return None;
        }
        let rows = self.rows.iter().filter(|row| meshes.contains(row.mesh.as_str()));
        Some(Self { rows: rows.copied().collect() })
    }

    pub fn methods(&self) -> Vec<&'a str> {
        let used: BTreeSet<&str> = self.rows.iter().map(|row| row.method.as_str()).collect();
        METHODS.into_iter().filter(|method| used.contains(method)).collect()
    }

    /// Methods with their settings, and the rows of each.
    pub fn variants(&self) -> Vec<((&'a str, &'a str), Vec<&'a Row>)> {
        let mut variants: Vec<((&str, &str), Vec<&Row>)> = Vec::new();
        for row in &self.rows {
            let name = (row.method.as_str(), row.setting.as_str());
            match variants.iter_mut().find(|(other, _)| *other == name) {
                Some((_, rows)) => rows.push(row),
                None => variants.push((name, vec![row])),
            }
        }
        let knob = |(method, setting): (&str, &str)| {
            let place = METHODS.iter().position(|&other| other == method);
            let numbers = setting.split([' ', ',']).filter_map(|word| word.parse::<f64>().ok());
            // V-HACD's resolution first, then its concavity.
            (place, numbers.rev().map(|x| (x * 1e6) as u64).collect::<Vec<_>>())
        };
        variants.sort_by_key(|(name, _)| knob(*name));
        variants
    }

    /// The curve of each method on each mesh.
    pub fn curves(&self) -> BTreeMap<&'a str, BTreeMap<&'a str, Curve>> {
        let mut points: BTreeMap<&str, BTreeMap<&str, Vec<Point>>> = BTreeMap::new();
        for row in &self.rows {
            let Some((_, judged)) = row.done() else { continue };
            let point = Point { hulls: judged.hulls as f64, error: judged.hausdorff };
            points.entry(&row.method).or_default().entry(&row.mesh).or_default().push(point);
        }
        let curves = |meshes: BTreeMap<&'a str, Vec<Point>>| {
            meshes.into_iter().map(|(mesh, points)| (mesh, Curve::new(points))).collect()
        };
        points.into_iter().map(|(method, meshes)| (method, curves(meshes))).collect()
    }

    pub fn tables(&self) -> Vec<Table> {
        let mut tables = vec![self.medians(), self.means(), self.against(), self.success()];
        if let Some(shared) = self.shared_with_files() {
            let count = shared.meshes().len();
            let mut table = shared.medians();
            table.title = "Medians where CoACD ran".into();
            table.note = format!("Over the {count} meshes of `coacd-files`, as far as done.");
            tables.push(table);
        }
        tables.extend(self.folders());
        tables.extend(self.where_others_win());
        tables
    }

    fn medians(&self) -> Table {
        self.figures("Medians", "Over all meshes that a setting has done.", |values| {
            median(values.to_vec())
        })
    }

    fn means(&self) -> Table {
        self.figures("Means", "Over all meshes that a setting has done.", mean)
    }

    fn figures(&self, title: &str, note: &str, of: fn(&[f64]) -> f64) -> Table {
        let mut header = vec!["method", "setting", "meshes"];
        header.extend(FIGURES.iter().map(|(name, _)| *name));
        let mut table = Table::new(title, note, &header);
        for ((method, setting), rows) in self.variants() {
            let done: Vec<_> = rows.iter().filter_map(|row| row.done()).collect();
            let mut cells = vec![method.to_owned(), setting.to_owned(), done.len().to_string()];
            for (_, figure) in FIGURES {
                let values: Vec<f64> = done.iter().filter_map(|(w, j)| figure(w, j)).collect();
                cells.push(number_or_nothing((!values.is_empty()).then(|| of(&values))));
            }
            table.rows.push(cells);
        }
        table
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
        for (ours, theirs) in self.pairs() {
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

    fn pairs(&self) -> Vec<(&'a str, &'a str)> {
        let methods = self.methods();
        let pair = |&ours: &&'a str| methods.iter().map(move |&theirs| (ours, theirs));
        methods.iter().flat_map(pair).filter(|(ours, theirs)| ours != theirs).collect()
    }

    fn success(&self) -> Table {
        let mut header = vec!["method", "setting", "meshes"];
        header.extend(Status::ALL.iter().map(|status| status.name()));
        header.extend(["hulls that are not convex", "without volume", "differs by threads"]);
        let note = "How runs ended. Hulls are convex up to 1e-6 of the diagonal.";
        let mut table = Table::new("Success", note, &header);
        for ((method, setting), rows) in self.variants() {
            let mut cells = vec![method.to_owned(), setting.to_owned(), rows.len().to_string()];
            for status in Status::ALL {
                cells.push(rows.iter().filter(|row| row.status == status).count().to_string());
            }
            let judged = || rows.iter().filter_map(|row| row.judged.as_ref());
            cells.push(judged().map(|j| j.non_convex_hulls).sum::<usize>().to_string());
            cells.push(judged().map(|j| j.non_positive_volumes).sum::<usize>().to_string());
            let worked = || rows.iter().filter_map(|row| row.worked.as_ref());
            cells.push(match worked().any(|worked| worked.same_with_all_threads.is_some()) {
                true => worked()
                    .filter(|worked| worked.same_with_all_threads == Some(false))
                    .count()
                    .to_string(),
                false => NOTHING.into(),
            });
            table.rows.push(cells);
        }
        table
    }

    /// Each method's default setting, folder by folder.
    fn folders(&self) -> Vec<Table> {
        let folder = |row: &Row| meshes::folder(&row.mesh).to_owned();
        let folders: BTreeSet<String> = self.rows.iter().map(|row| folder(row)).collect();
        let mut tables = Vec::new();
        for name in folders {
            let mut header = vec!["method", "setting", "meshes"];
            header.extend(FIGURES.iter().map(|(name, _)| *name));
            let title = format!("Medians in {name}");
            let mut table = Table::new(&title, "Each method's default setting.", &header);
            for ((method, setting), rows) in self.variants() {
                if !Run::parse(method, setting).is_some_and(|run| run.is_default()) {
                    continue;
                }
                let rows = rows.into_iter().filter(|row| folder(row) == name);
                let done: Vec<_> = rows.filter_map(Row::done).collect();
                let mut cells = vec![method.to_owned(), setting.to_owned(), done.len().to_string()];
                for (_, figure) in FIGURES {
                    let values: Vec<f64> = done.iter().filter_map(|(w, j)| figure(w, j)).collect();
                    let of = (!values.is_empty()).then(|| median(values));
                    cells.push(number_or_nothing(of));
                }
                table.rows.push(cells);
            }
            tables.push(table);
        }
        tables
    }

    /// Meshes on which another method needs fewer hulls than ours at equal error.
    fn where_others_win(&self) -> Option<Table> {
        let curves = self.curves();
        let own = curves.get("bounded").or_else(|| curves.get("surface"))?;
        let name = if curves.contains_key("bounded") { "bounded" } else { "surface" };
        let mut losses: Vec<(f64, String, String)> = Vec::new();
        for (other, meshes) in curves.iter().filter(|(method, _)| **method != name) {
            for (mesh, theirs) in meshes {
                let ratio = own.get(mesh).and_then(|own| versus(own, theirs).hulls);
                if let Some(ratio) = ratio
                    && ratio > 1.0 + EQUAL
                {
                    losses.push((ratio, (*mesh).to_owned(), (*other).to_owned()));
                }
            }
        }
        losses.sort_by(|a, b| b.0.total_cmp(&a.0).then_with(|| (&a.1, &a.2).cmp(&(&b.1, &b.2))));
        let note = format!(
            "{} pairs of a mesh and another method that needs fewer hulls than {name} at equal \
             error; the {} widest gaps.",
            losses.len(),
            losses.len().min(MOST_LOSSES)
        );
        let header = ["mesh", "other method", "our hulls over theirs at equal error"];
        let mut table = Table::new("Where others win", &note, &header);
        for (ratio, mesh, other) in losses.into_iter().take(MOST_LOSSES) {
            table.rows.push(vec![mesh, other, number(ratio)]);
        }
        Some(table)
    }
}

/// Rows of the table of losses, as many as fit a page; all of them are in `versus.csv`.
const MOST_LOSSES: usize = 40;

type Figure = fn(&Worked, &Judged) -> Option<f64>;

/// The columns of most tables.
pub const FIGURES: [(&str, Figure); 14] = [
    ("hulls", |_, judged| Some(judged.hulls as f64)),
    ("vertices", |_, judged| Some(judged.vertices as f64)),
    ("seconds", |worked, _| Some(worked.seconds)),
    ("seconds, all threads", |worked, _| worked.seconds_all_threads),
    ("MB", |worked, _| worked.peak_memory.map(|bytes| bytes as f64 / f64::from(1 << 20))),
    ("Hausdorff", |_, judged| Some(judged.hausdorff)),
    ("protrusion, mean", |_, judged| Some(judged.protrusion_mean)),
    ("protrusion, p99", |_, judged| Some(judged.protrusion_p99)),
    ("uncovered, mean", |_, judged| Some(judged.uncovered_mean)),
    ("uncovered, max", |_, judged| Some(judged.uncovered_max)),
    ("uncovered volume", |_, judged| judged.uncovered_volume),
    ("IoU", |_, judged| judged.iou),
    ("overlap", |_, judged| judged.overlap),
    ("cost", |worked, _| worked.cost),
];
