//! Reports as text: the few lines that a person reads of a decomposition, a mesh, a measurement or
//! a file.
//!
//! Programs read the fields instead; the words may change. Lengths are percentages of the
//! bounding-box diagonal where it is known, else in the mesh's units.

use std::cmp::Reverse;
use std::fmt::{self, Display, Formatter};

#[cfg(feature = "scene")]
use crate::decomposition::ALGORITHM_VERSION;
use crate::decomposition::{Decomposition, Hull, Report, RunReport};
#[cfg(feature = "scene")]
use crate::hulls_format::HullScene;
use crate::hulls_format::HullsFile;
use crate::inspect::Inspection;
use crate::measure::{Distances, Measurement, VerifiedDistances};
use crate::merge_tree::CurvePoint;
use crate::mesh::Repairs;
use crate::method::MethodReport;
use crate::openings::{Opening, OpeningOutcome};
use crate::sorting::{sort_by, sort_by_key};
use crate::surface::SurfaceReport;

impl<R: Clone + Into<MethodReport>> Decomposition<R> {
    /// Says by how much hulls protrude beyond the bound, and why: a limit on hulls, or a flat part
    /// that has to be thicker to be a hull. `None` where the bound is kept, or the method has none.
    pub fn exceeded_bound(&self) -> Option<String> {
        let report: MethodReport = self.report.clone().into();
        let &Report { bound, protrusion_max, .. } = report.bounded()?;
        exceeded_bound(&self.hulls, bound, protrusion_max, self.run.diagonal)
    }

    /// Says how many hulls there would be without the limit on vertices, if those are fewer.
    pub fn forced_by_vertex_limit(&self) -> Option<String> {
        let report: MethodReport = self.report.clone().into();
        let without = report.bounded()?.hulls_without_vertex_limit;
        let is_fewer = without < self.hulls.len();
        is_fewer.then(|| format!("the vertex limit forces hulls: {without} without it"))
    }

    /// Says that patches are larger than others, if they are.
    fn across_folds(&self) -> Option<String> {
        let report: MethodReport = self.report.clone().into();
        let is_across = report.bounded()?.patches_across_folds;
        is_across
            .then(|| "the surface folds everywhere, or has many parts: larger patches, maybe a few more hulls"
                .into())
    }

    /// The [exceeded bound](Self::exceeded_bound), what the [vertex
    /// limit](Self::forced_by_vertex_limit) forces, whether [patches are
    /// larger](Report::patches_across_folds), then the run's [remarks](RunReport::remarks), one
    /// line each.
    pub fn remarks(&self) -> Vec<String> {
        let of_hulls = [self.exceeded_bound(), self.forced_by_vertex_limit(), self.across_folds()];
        of_hulls.into_iter().flatten().chain(self.run.remarks()).collect()
    }
}

impl HullsFile {
    /// As [`Decomposition::exceeded_bound`].
    pub fn exceeded_bound(&self) -> Option<String> {
        let protrusion = self.verified?.protrusion_max;
        exceeded_bound(&self.hulls, self.bound?, protrusion, self.diagonal)
    }
}

/// A protrusion that is reported may be larger than the true one by less than this factor.
const ROUNDED_UP: f64 = 1.1;

fn exceeded_bound(hulls: &[Hull], bound: f64, protrusion: f64, diagonal: f64) -> Option<String> {
    if protrusion <= bound {
        return None;
    }
    // A hull that would keep the bound without its thickness.
    let is_thick = |hull: &Hull| {
        let most = hull.errors.protrusion_max.unwrap_or(0.0);
        most - ROUNDED_UP * hull.errors.added_thickness <= bound
    };
    let reason = match hulls.iter().all(is_thick) {
        true => "a flat part has to be thicker to be a hull",
        false => "the limit on hulls forces it",
    };
    Some(format!("protrusion: {}, above the bound: {reason}", percentage(protrusion, diagonal)))
}

impl RunReport {
    /// What was repaired, what became of openings, and whether the deadline cut the work short, one
    /// line each; empty where there is nothing to say.
    pub fn remarks(&self) -> Vec<String> {
        let repaired = repairs(&self.repairs).map(|repairs| format!("repaired: {repairs}"));
        let openings = openings(&self.openings).map(|openings| format!("openings: {openings}"));
        let deadline = self.deadline_reached.then(|| "the deadline cut the search short".into());
        [repaired, openings, deadline].into_iter().flatten().collect()
    }
}

/// Hulls, errors, and remarks.
impl<R: Clone + Into<MethodReport>> Display for Decomposition<R> {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> fmt::Result {
        let report: MethodReport = self.report.clone().into();
        write!(formatter, "{}, {}", count_hulls(&self.hulls), count_vertices(&self.hulls))?;
        match &report {
            MethodReport::Bounded(report) => {
                let [bound, protrusion, uncovered] =
                    [report.bound, report.protrusion_max, report.uncovered_max]
                        .map(|length| percentage(length, self.run.diagonal));
                write!(
                    formatter,
                    "\nbound {bound}, protrusion at most {protrusion}, uncovered at most {uncovered}"
                )?;
            }
            MethodReport::Surface(report) => write!(formatter, "\n{report}")?,
            MethodReport::Hull => {}
        }
        self.remarks().iter().try_for_each(|line| write!(formatter, "\n{line}"))
    }
}

/// Lengths in the mesh's units.
impl Display for Report {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> fmt::Result {
        let [bound, protrusion, uncovered] =
            [self.bound, self.protrusion_max, self.uncovered_max].map(number);
        write!(
            formatter,
            "bound {bound}, protrusion at most {protrusion}, uncovered at most {uncovered}\n{}, {}",
            count(self.patches, "patch", "patches"),
            count(self.polygons, "triangle divided", "triangles divided")
        )
    }
}

impl Display for RunReport {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> fmt::Result {
        write!(
            formatter,
            "{}, {}, {} ({} closed), diagonal {}",
            count(self.source_vertices, "vertex", "vertices"),
            count(self.source_triangles, "triangle", "triangles"),
            count(self.components, "component", "components"),
            self.closed_components,
            number(self.diagonal)
        )?;
        self.remarks().iter().try_for_each(|line| write!(formatter, "\n{line}"))
    }
}

/// What was chosen, without the search tree.
impl Display for SurfaceReport {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> fmt::Result {
        let threshold = match (self.planar_threshold, self.concavity_threshold) {
            (Some(p), _) => format!("planar threshold {p}"),
            (None, beta) => format!("concavity threshold {}", beta.unwrap_or_default()),
        };
        write!(
            formatter,
            "{} ({:.1} on average), cost {:.4}, {}, resolution {}: {} of {}",
            count(self.pieces, "piece", "pieces"),
            self.average_pieces,
            self.cost,
            threshold,
            self.resolution,
            self.polygons,
            count(self.initial_polygons, "triangle", "triangles")
        )
    }
}

/// Without open and non-manifold edges: they stay, so they are no repair.
impl Display for Repairs {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> fmt::Result {
        formatter.write_str(repairs(self).as_deref().unwrap_or("none needed"))
    }
}

impl Display for OpeningOutcome {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.describe())
    }
}

/// Lengths in the mesh's units.
impl Display for CurvePoint {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> fmt::Result {
        let [protrusion, uncovered] = [self.protrusion_max, self.uncovered_max].map(number);
        write!(
            formatter,
            "{}: protrusion at most {protrusion}, uncovered at most {uncovered}",
            count(self.hulls, "hull", "hulls")
        )
    }
}

/// A row for each figure, and one for each of the largest openings. Lengths in the mesh's units.
impl Display for Inspection {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> fmt::Result {
        let counts = |given: usize, left: usize| {
            if given == left { given.to_string() } else { format!("{given}, {left} after repair") }
        };
        let closed = match self.closed_components {
            closed if closed == self.components => "yes".into(),
            0 => "no".into(),
            closed => format!("{closed} of {} components", self.components),
        };
        let volume = match self.volume {
            0.0 => "nothing is closed".into(),
            volume => number(volume),
        };
        let rows = [
            ("vertices", counts(self.source_vertices, self.vertices)),
            ("triangles", counts(self.source_triangles, self.triangles)),
            ("bounds from", point(self.bounds.min)),
            ("bounds to", point(self.bounds.max)),
            ("diagonal", number(self.diagonal)),
            ("area", number(self.area)),
            ("components", self.components.to_string()),
            ("open edges", self.repairs.open_edges.to_string()),
            ("non-manifold edges", self.repairs.non_manifold_edges.to_string()),
            ("closed", closed),
            ("openings", openings(&self.openings).unwrap_or_else(|| "none".into())),
            ("volume", volume),
            ("repairs", self.repairs.to_string()),
        ];
        formatter.write_str(&pairs(&rows))?;
        if self.openings.is_empty() {
            return Ok(());
        }
        let header = ["edges", "area", "middle", "opening"].map(String::from);
        let row = |opening: &Opening| {
            let &Opening { edges, area, centre, outcome } = opening;
            [edges.to_string(), number(area), point(centre), outcome.to_string()]
        };
        let mut largest: Vec<&Opening> = self.openings.iter().collect();
        sort_by(&mut largest, |a, b| b.area.total_cmp(&a.area));
        let rest = largest.split_off(largest.len().min(MOST_OPENINGS));
        let rows: Vec<[String; 4]> =
            std::iter::once(header).chain(largest.into_iter().map(row)).collect();
        write!(formatter, "\n\n{}", columns(&rows))?;
        match rest.len() {
            0 => Ok(()),
            smaller => write!(formatter, "\nand {smaller} smaller"),
        }
    }
}

/// A row for each figure.
impl Display for Measurement {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> fmt::Result {
        let of_all = |flagged: usize| format!("{flagged} of {}", self.hulls);
        let convex = match self.non_convex_hulls {
            0 => "all".into(),
            flagged => format!("not {}", of_all(flagged)),
        };
        let mut rows = vec![
            ("hulls", self.hulls.to_string()),
            ("vertices", self.vertices.to_string()),
            ("convex", format!("{convex}, off by at most {}", relative(self.worst_concavity))),
        ];
        for (name, flagged) in [
            ("not closed", self.open_hulls),
            ("no volume or wound inward", self.non_positive_volumes),
        ] {
            if flagged > 0 {
                rows.push((name, of_all(flagged)));
            }
        }
        if self.unusable_hulls > 0 {
            rows.push(("left out as unusable", self.unusable_hulls.to_string()));
        }
        let overlap = self.overlap.map(|overlap| format!("{overlap:.3}"));
        rows.extend([
            ("protrusion", self.protrusion.to_string()),
            ("uncovered", self.uncovered.to_string()),
            ("Hausdorff", relative(self.hausdorff)),
            ("uncovered volume", share(self.uncovered_volume)),
            ("volume IoU", share(self.iou)),
            ("overlap", overlap.unwrap_or_else(|| NOTHING.into())),
        ]);
        let samples = &self.samples;
        write!(
            formatter,
            "{}\n\nlengths are percentages of the mesh's diagonal, {}\n\
             points: {} on hulls ({} of them on the boundary of all), {} on the mesh, {} in space",
            pairs(&rows),
            number(self.diagonal),
            samples.hull,
            samples.boundary,
            samples.mesh,
            samples.volume
        )?;
        if self.iou.is_none() && self.open_edges > 0.0 {
            let open = 100.0 * self.open_edges;
            let reason = "of the mesh's edges are open, so it has no sure volume";
            write!(formatter, "\n{open:.1} % {reason}")?;
        }
        Ok(())
    }
}

impl Display for VerifiedDistances {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> fmt::Result {
        let [protrusion, uncovered, resolution] =
            [self.protrusion_max, self.uncovered_max, self.resolution].map(relative);
        write!(
            formatter,
            "verified: protrusion at most {protrusion} (too large by {resolution} at most), \
             uncovered at most {uncovered}"
        )
    }
}

impl Display for Distances {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> fmt::Result {
        let [mean, p99, max] = [self.mean, self.p99, self.max].map(relative);
        write!(formatter, "mean {mean}, 99 % below {p99}, largest {max}")
    }
}

/// A row for each figure, and for each part that hulls are made of.
impl Display for HullsFile {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> fmt::Result {
        let length = |value: f64| percentage(value, self.diagonal);
        let algorithm = match self.is_current() {
            true => self.algorithm_version.to_string(),
            false => format!("{}, another than this program's", self.algorithm_version),
        };
        let mut rows = vec![
            ("mesh", self.name.clone()),
            ("hulls", self.hulls.len().to_string()),
            ("vertices", vertices(&self.hulls).to_string()),
            ("source triangles", self.source_triangles.to_string()),
            ("diagonal", number(self.diagonal)),
            ("method", if self.method.is_empty() { NOTHING.into() } else { self.method.clone() }),
            ("algorithm version", algorithm),
        ];
        rows.extend(self.bound.map(|bound| ("bound", length(bound))));
        if let Some(verified) = self.verified {
            rows.push(("protrusion", format!("at most {}", length(verified.protrusion_max))));
            rows.push(("uncovered", format!("at most {}", length(verified.uncovered_max))));
        }
        if let Some(properties) = self.mass_properties {
            rows.push(("mass", number(properties.mass)));
            rows.push(("centre of mass", point(properties.centre)));
        }
        formatter.write_str(&pairs(&rows))?;
        self.exceeded_bound().iter().try_for_each(|line| write!(formatter, "\n{line}"))?;
        match self.parts.is_empty() {
            true => Ok(()),
            false => write!(formatter, "\n\n{}", columns(&parts(self))),
        }
    }
}

/// A row for each part of the mesh, with how many hulls are made of it more than of others.
fn parts(file: &HullsFile) -> Vec<[String; 4]> {
    let mut hulls = vec![0_usize; file.parts.len()];
    for most in file.part_shares.iter().filter_map(|shares| shares.first()) {
        hulls.get_mut(most.part as usize).into_iter().for_each(|hulls| *hulls += 1);
    }
    let header = ["hulls mostly of", "mesh", "primitive", "material"].map(String::from);
    let rows = file.parts.iter().zip(hulls).map(|(part, hulls)| {
        let primitive = part.primitive.to_string();
        [hulls.to_string(), part.mesh.clone(), primitive, part.material.clone()]
    });
    std::iter::once(header).chain(rows).collect()
}

/// A row for each mesh, and below them a line for each exceeded bound.
#[cfg(feature = "scene")]
impl Display for HullScene {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> fmt::Result {
        let meshes = &self.meshes;
        let hulls: usize = meshes.iter().map(|baked| baked.hulls.hulls.len()).sum();
        let others = meshes.iter().filter(|baked| !baked.hulls.is_current()).count();
        let algorithm = match others {
            0 => ALGORITHM_VERSION.to_string(),
            others => format!("another than this program's for {others} of {}", meshes.len()),
        };
        let triangles: usize = self.triangles.iter().map(|baked| baked.triangles.len()).sum();
        let mut rows = vec![
            ("scene", self.name.clone()),
            ("meshes", meshes.len().to_string()),
            ("hulls", hulls.to_string()),
            ("triangles for what never moves", triangles.to_string()),
        ];
        if !self.surfaces.is_empty() {
            let triangles = self.surfaces.iter().map(|surface| surface.triangles.len());
            rows.push(("simplified surfaces", self.surfaces.len().to_string()));
            rows.push(("triangles of these", triangles.sum::<usize>().to_string()));
        }
        rows.push(("algorithm version", algorithm));
        formatter.write_str(&pairs(&rows))?;
        let length = |file: &HullsFile, value: Option<f64>| {
            value.map_or_else(|| NOTHING.into(), |value| percentage(value, file.diagonal))
        };
        let table = meshes.iter().map(|baked| {
            let file = &baked.hulls;
            [
                file.hulls.len().to_string(),
                vertices(&file.hulls).to_string(),
                length(file, file.bound),
                length(file, file.verified.map(|verified| verified.protrusion_max)),
                length(file, file.verified.map(|verified| verified.uncovered_max)),
                baked.names.join(", "),
            ]
        });
        let header = ["hulls", "vertices", "bound", "protrusion", "uncovered", "mesh and nodes"];
        let table: Vec<[String; 6]> =
            std::iter::once(header.map(String::from)).chain(table).collect();
        if !meshes.is_empty() {
            write!(formatter, "\n\n{}", columns(&table))?;
        }
        for file in meshes.iter().map(|baked| &baked.hulls) {
            if let Some(line) = file.exceeded_bound() {
                write!(formatter, "\n{}: {line}", file.name)?;
            }
        }
        Ok(())
    }
}

/// Openings that are listed, the largest: scans have hundreds.
const MOST_OPENINGS: usize = 20;

/// Stands where there is no number.
const NOTHING: &str = "–";

/// What was repaired, if anything was.
fn repairs(repairs: &Repairs) -> Option<String> {
    let counts = [
        (repairs.welded_vertices, "vertex welded", "vertices welded"),
        (repairs.unused_vertices, "unused vertex dropped", "unused vertices dropped"),
        (
            repairs.non_finite_triangles,
            "triangle that is not finite dropped",
            "triangles that are not finite dropped",
        ),
        (
            repairs.degenerate_triangles,
            "triangle without area dropped",
            "triangles without area dropped",
        ),
        (repairs.duplicate_triangles, "duplicate triangle dropped", "duplicate triangles dropped"),
        (repairs.flipped_triangles, "triangle turned around", "triangles turned around"),
    ];
    let counts = counts.into_iter().filter(|(number, ..)| *number > 0);
    let texts: Vec<String> =
        counts.map(|(number, singular, plural)| count(number, singular, plural)).collect();
    (!texts.is_empty()).then(|| texts.join(", "))
}

/// How many openings were closed and left, and why, if there are any.
fn openings(openings: &[Opening]) -> Option<String> {
    let mut counts: Vec<(OpeningOutcome, usize)> = Vec::new();
    for opening in openings {
        match counts.iter_mut().find(|(outcome, _)| *outcome == opening.outcome) {
            Some((_, count)) => *count += 1,
            None => counts.push((opening.outcome, 1)),
        }
    }
    sort_by_key(&mut counts, |&(outcome, count)| (!outcome.is_closed(), Reverse(count)));
    let texts: Vec<String> =
        counts.iter().map(|(outcome, count)| format!("{count} {outcome}")).collect();
    (!texts.is_empty()).then(|| texts.join(", "))
}

fn vertices(hulls: &[Hull]) -> usize {
    hulls.iter().map(|hull| hull.shape.points.len()).sum()
}

fn count_hulls(hulls: &[Hull]) -> String {
    count(hulls.len(), "hull", "hulls")
}

fn count_vertices(hulls: &[Hull]) -> String {
    count(vertices(hulls), "vertex", "vertices")
}

fn count(number: usize, singular: &str, plural: &str) -> String {
    format!("{number} {}", if number == 1 { singular } else { plural })
}

/// A length as a percentage of the diagonal; in units where there is no diagonal.
fn percentage(length: f64, diagonal: f64) -> String {
    if diagonal > 0.0 { relative(length / diagonal) } else { number(length) }
}

/// Less is rounding: a tenth of what makes a hull not convex by default.
const ROUNDING: f64 = 1e-7;

/// A fraction of the diagonal as a percentage. Three digits after the point show what samples
/// resolve.
fn relative(length: f64) -> String {
    let percent = 100.0 * length;
    if length > ROUNDING && percent < 1e-3 {
        format!("{percent:.1e} %")
    } else {
        format!("{percent:.3} %")
    }
}

/// A fraction of a volume.
fn share(share: Option<f64>) -> String {
    share.map_or_else(|| NOTHING.into(), |share| format!("{:.1} %", 100.0 * share))
}

fn point([x, y, z]: [f64; 3]) -> String {
    format!("{}, {}, {}", number(x), number(y), number(z))
}

/// Six significant digits distinguish meshes.
const DIGITS: i32 = 6;

/// Plain within a few powers of ten, else with an exponent.
fn number(value: f64) -> String {
    let scientific = format!("{value:.*e}", DIGITS as usize - 1);
    let exponent = scientific.split_once('e').and_then(|(_, exponent)| exponent.parse().ok());
    let magnitude: i32 = exponent.unwrap_or_default();
    if !(-4..DIGITS + 3).contains(&magnitude) {
        return scientific;
    }
    let decimals = (DIGITS - 1 - magnitude).max(0) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

/// Names and values, one pair a line.
fn pairs(rows: &[(&str, String)]) -> String {
    let rows: Vec<[String; 2]> =
        rows.iter().map(|(name, value)| [(*name).to_owned(), value.clone()]).collect();
    columns(&rows)
}

/// Rows with their columns below each other, two spaces apart.
fn columns<const N: usize>(rows: &[[String; N]]) -> String {
    let width = |text: &str| text.chars().count();
    let widths: [usize; N] = std::array::from_fn(|column| {
        rows.iter().filter_map(|row| row.get(column)).map(|text| width(text)).max().unwrap_or(0)
    });
    let line = |row: &[String; N]| {
        let cells = row.iter().zip(widths);
        let padded = cells.map(|(text, width)| format!("{text:<width$}  ")).collect::<String>();
        padded.trim_end().to_owned()
    };
    rows.iter().map(line).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::Control;
    use crate::decompose::decompose;
    use crate::mesh::TriangleMesh;
    use crate::mesh::shapes::{cuboid, join};
    use crate::parameters::Parameters;

    /// Two boxes with a gap between them that no hull may bridge.
    fn apart() -> TriangleMesh {
        join(&[cuboid([0.0; 3], [1.0; 3]), cuboid([3.0, 0.0, 0.0], [4.0, 1.0, 1.0])])
    }

    #[test]
    fn numbers_have_six_digits_and_no_empty_decimals() {
        for (value, expected) in [
            (0.0, "0"),
            (2.0, "2"),
            (-0.123456789, "-0.123457"),
            (1234.56789, "1234.57"),
            (12345678.0, "12345678"),
            (1.5e-9, "1.50000e-9"),
            (-2e20, "-2.00000e20"),
        ] {
            assert_eq!(number(value), expected);
        }
    }

    #[test]
    fn lengths_are_percentages_and_tiny_ones_have_an_exponent() {
        let texts = [0.0, 0.018_77, 2.54e-6, 1e-9].map(relative);
        assert_eq!(texts, ["0.000 %", "1.877 %", "2.5e-4 %", "0.000 %"]);
        assert_eq!(percentage(0.5, 2.0), "25.000 %");
        assert_eq!(percentage(0.5, 0.0), "0.5");
        assert_eq!([share(Some(0.8842)), share(None)], ["88.4 %", "–"]);
    }

    #[test]
    fn a_decomposition_says_what_it_promises_and_what_a_limit_exceeds() {
        let (mesh, control) = (apart(), Control::new());
        let kept = decompose(&mesh, &Parameters::default(), &control).unwrap();
        let text = kept.to_string();
        assert!(text.starts_with("2 hulls, 16 vertices\nbound 2.000 %, protrusion"), "{text}");
        assert_eq!(kept.exceeded_bound(), None);
        assert_eq!(HullsFile::new("apart", &kept).exceeded_bound(), None);

        let limited = decompose(&mesh, &Parameters::default().with_max_hulls(1), &control).unwrap();
        let line = limited.exceeded_bound().unwrap();
        assert!(line.ends_with("above the bound: the limit on hulls forces it"), "{line}");
        assert!(limited.to_string().lines().any(|other| other == line));
        let file = HullsFile::new("apart", &limited);
        assert_eq!(file.exceeded_bound().as_ref(), Some(&line));
        assert!(file.to_string().lines().any(|other| other == line));
    }

    #[test]
    fn repairs_are_counted_in_words() {
        assert_eq!(Repairs::default().to_string(), "none needed");
        let some = Repairs { welded_vertices: 1, flipped_triangles: 2, ..Repairs::default() };
        assert_eq!(some.to_string(), "1 vertex welded, 2 triangles turned around");
    }
}
