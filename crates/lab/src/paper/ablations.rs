//! Section 4.3.2 and what else the paper says of its parameters: p, r, a, Q, ε, μ, the exponents
//! of its time, and `spot.obj` whole.

use hullwright::Stage;
use hullwright::surface::SurfaceParameters;

use super::{Figure, Found, Model, Paper, all_of, decomposed, hacd_of, paper_with};
use crate::plots::{Series, lines};
use crate::report::{Plot, Table, number};
use crate::statistics::median;
use crate::terminal::Failure;

/// The fixed r and p of section 4.3.2.
pub const RESOLUTION: usize = 500;
const PLANAR_THRESHOLD: f64 = 0.1;

/// Both values of ε that the section names.
const EPSILONS: [f64; 2] = [0.05, 0.1];

/// Pieces, cost and milliseconds as medians.
fn medians(found: &[Found]) -> [String; 3] {
    let figures: [fn(&Found) -> f64; 3] = [
        |found| found.decomposition.hulls.len() as f64,
        |found| found.decomposition.report.cost,
        |found| 1000.0 * found.seconds,
    ];
    figures.map(|figure| number(median(found.iter().map(figure).collect())))
}

/// A value of a parameter, and what it gives on each model.
type Runs = Vec<(f64, Vec<Found>)>;

fn sweep(
    models: &[Model],
    values: &[f64],
    parameters: impl Fn(f64) -> SurfaceParameters,
) -> Result<Runs, Failure> {
    values.iter().map(|&value| Ok((value, all_of(models, &parameters(value))?))).collect()
}

/// Pieces of each model over a parameter.
fn plot(
    papers: &[Paper],
    runs: &Runs,
    (file, title, x): (&'static str, &'static str, &str),
) -> Result<Plot, String> {
    let series = papers.iter().enumerate().map(|(index, paper)| {
        let point = |(value, found): &(f64, Vec<Found>)| {
            (*value, found[index].decomposition.hulls.len() as f64)
        };
        Series { name: paper.row.model.clone(), points: runs.iter().map(point).collect() }
    });
    let svg = lines(title, x, "pieces", &series.collect::<Vec<_>>())?;
    Ok(Plot { file, title, note: "A line for each model of Table 1.".into(), svg })
}

/// p at fixed r (Figure 5, right), then r at fixed p.
pub fn thresholds_and_resolutions(
    papers: &[Paper],
    models: &[Model],
) -> Result<(Vec<Table>, Vec<Plot>), Failure> {
    let paper = SurfaceParameters::paper();
    let runs = sweep(models, &paper.planar_thresholds, |p| at(p, RESOLUTION))?;
    let header = ["p", "pieces", "cost", "ms", "chosen under ε = 0.05", "under 0.1"];
    let note = "Medians over Table 1's ten meshes at r = 500, and on how many this p has the fewest pieces under ε.";
    let mut of_p = Table::new("4.3.2: p at fixed r (Figure 5, right)", note, &header);
    let chosen = |epsilon: f64, place: usize| {
        let of_model = |model: usize| {
            let candidates = runs.iter().enumerate().map(|(place, (_, found))| {
                let report = &found[model].decomposition.report;
                (place, report.resolutions[0].thresholds[0].pieces, report.cost)
            });
            candidates.filter(|found| found.2 < epsilon).min_by_key(|found| (found.1, found.0))
        };
        (0..models.len()).filter(|&model| of_model(model).is_some_and(|c| c.0 == place)).count()
    };
    for (place, (p, found)) in runs.iter().enumerate() {
        let counts = EPSILONS.map(|epsilon| chosen(epsilon, place).to_string());
        let cells = [p.to_string()].into_iter().chain(medians(found)).chain(counts);
        of_p.rows.push(cells.collect());
    }
    let resolutions: Vec<f64> = paper.maximum_resolutions.iter().map(|&r| r as f64).collect();
    let at_p = sweep(models, &resolutions, |r| at(PLANAR_THRESHOLD, r as usize))?;
    let note = "Medians over the same at p = 0.1.";
    let mut of_r = Table::new("4.3.2: r at fixed p", note, &["r", "pieces", "cost", "ms"]);
    for (r, found) in &at_p {
        of_r.rows.push([r.to_string()].into_iter().chain(medians(found)).collect());
    }
    let plots = vec![
        plot(papers, &runs, ("pieces-p.svg", "Pieces over p at r = 500", "p"))?,
        plot(papers, &at_p, ("pieces-r.svg", "Pieces over r at p = 0.1", "r"))?,
    ];
    Ok((vec![of_p, of_r], plots))
}

/// How often each a of equation (2) has the fewest pieces under ε (section 3.4.2).
pub fn angular_threshold(princeton: &[Model]) -> Result<Table, Failure> {
    let paper = SurfaceParameters::paper();
    let runs = sweep(princeton, &paper.planar_thresholds, |a| {
        paper_with(|one| one.angular_threshold = a)
    })?;
    let best = |model: usize| {
        let cost = |place: usize| runs[place].1[model].decomposition.report.cost;
        let hulls = |place: usize| runs[place].1[model].decomposition.hulls.len();
        let under = (0..runs.len()).filter(|&place| cost(place) < paper.concavity_cost_threshold);
        under.min_by_key(|&place| (hulls(place), place))
    };
    let note = "Medians over Princeton's meshes, and on how many this a has the fewest hulls under ε = 0.05; the \
                smallest of several.";
    let mut table = Table::new("3.4.2: a", note, &["a", "pieces", "cost", "ms", "chosen"]);
    for (place, (a, found)) in runs.iter().enumerate() {
        let chosen = (0..princeton.len()).filter(|&model| best(model) == Some(place)).count();
        let cells = [a.to_string()].into_iter().chain(medians(found));
        table.rows.push(cells.chain([chosen.to_string()]).collect());
    }
    Ok(table)
}

/// Q, ε and μ, each alone, on the ten meshes.
pub fn parameters(models: &[Model]) -> Result<Table, Failure> {
    let header = ["parameter", "value", "pieces", "cost", "ms"];
    let note =
        "Medians over Table 1's ten meshes; all else as in the paper: Q = 0.8, ε = 0.05, μ = 5.";
    let mut table = Table::new("4.3: Q, ε and μ", note, &header);
    type Change = fn(&mut SurfaceParameters, f64);
    let sweeps: [(&str, &[f64], Change); 3] = [
        ("Q", &[0.5, 0.65, 0.8, 0.9, 0.95], |one, value| one.simplification_quality = value),
        ("ε", &[0.01, 0.02, 0.05, 0.1, 0.2], |one, value| one.concavity_cost_threshold = value),
        ("μ", &[0.0, 2.0, 5.0, 10.0, 20.0], |one, value| one.resolution_cut_off = value as usize),
    ];
    for (name, values, change) in sweeps {
        let with = |value: f64| paper_with(|one| change(one, value));
        for (value, found) in sweep(models, values, with)? {
            let cells = [name.to_owned(), value.to_string()].into_iter().chain(medians(&found));
            table.rows.push(cells.collect());
        }
    }
    Ok(table)
}

/// The exponents of O(N / k): seconds as N to one power and k to another, by least squares of
/// logarithms. N is the sum of the polygons of all resolutions that were searched.
pub fn exponents(found: &[Found]) -> Table {
    let note = "Seconds in proportion to N and k to these powers, over Princeton's meshes; the paper has 1 and −1.";
    let mut table = Table::new("3.1: O(N / k)", note, &["what", "N", "k"]);
    let search: fn(&Found) -> f64 = |found| {
        let times = found.decomposition.run.times.iter();
        times.filter(|time| time.stage == Stage::Search).map(|time| time.seconds).sum()
    };
    let figures: [Figure; 2] = [("the search", search), ("the whole run", |found| found.seconds)];
    for (name, seconds) in figures {
        let rows = found.iter().map(|found| {
            let report = &found.decomposition.report;
            let searched = report.resolutions.iter().filter(|one| !one.thresholds.is_empty());
            let n: usize = searched.map(|one| one.polygons).sum();
            [n as f64, report.average_pieces, seconds(found)].map(f64::ln)
        });
        let rows: Vec<[f64; 3]> = rows.collect();
        let mean =
            |column: usize| rows.iter().map(|row| row[column]).sum::<f64>() / rows.len() as f64;
        let means = [0, 1, 2].map(mean);
        let product = |i: usize, j: usize| {
            rows.iter().map(|row| (row[i] - means[i]) * (row[j] - means[j])).sum::<f64>()
        };
        let determinant = product(0, 0) * product(1, 1) - product(0, 1) * product(0, 1);
        let n = (product(0, 2) * product(1, 1) - product(1, 2) * product(0, 1)) / determinant;
        let k = (product(1, 2) * product(0, 0) - product(0, 2) * product(0, 1)) / determinant;
        table.rows.push(vec![name.into(), format!("{n:.2}"), format!("{k:.2}")]);
    }
    table
}

/// One p and one r.
pub fn at(p: f64, r: usize) -> SurfaceParameters {
    paper_with(|one| (one.planar_thresholds, one.maximum_resolutions) = (vec![p], vec![r]))
}

/// The r with which Figure 5, left, ends.
pub fn within_900() -> SurfaceParameters {
    paper_with(|one| one.maximum_resolutions = vec![900])
}

/// Whole, without simplification: what Figure 5, left, shows.
pub fn whole(parameters: SurfaceParameters) -> SurfaceParameters {
    let mut whole = parameters;
    (whole.simplification_quality, whole.maximum_resolutions) = (1.0, vec![usize::MAX]);
    whole
}

/// Figure 5, left: `spot.obj` whole by both, and with r = 900.
pub fn spot(spot: &Model) -> Result<Table, Failure> {
    let note = "The paper: about 60 s whole, HACD more than 14.5 hours, 1.75 s with r = 900.";
    let header = ["what", "pieces", "cost", "seconds"];
    let mut table = Table::new("Spot (Figure 5, left)", note, &header);
    for (name, parameters) in [
        ("whole", whole(SurfaceParameters::paper())),
        ("whole, HACD, β = 0.05", whole(hacd_of(0.05))),
        ("r = 900", within_900()),
    ] {
        let Found { decomposition, seconds } = decomposed(&spot.mesh, &parameters)?;
        let (pieces, cost) = (decomposition.hulls.len(), decomposition.report.cost);
        table.rows.push(vec![name.into(), pieces.to_string(), number(cost), number(seconds)]);
    }
    Ok(table)
}
