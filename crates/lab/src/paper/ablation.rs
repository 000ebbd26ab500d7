//! Section 4.3.2 and what the paper claims in passing: p, r, a, the complexity, Q, ε and μ.

use hullwright::surface::SurfaceParameters;

use super::work::{Found, Shared, judge_default, surface};
use crate::report::table::{NOTHING, Table, number};
use crate::statistics::{median, plane};

/// High enough that no threshold is given up before its cost is known.
const NEVER_ABORTS: f64 = 1e6;

/// p swept at r = 500: pieces, cost, seconds of the search, and what ε = 0.05 and 0.1 choose.
pub fn planar_threshold(shared: &Shared) -> Result<Vec<Table>, String> {
    let header = ["model", "p", "pieces", "cost", "seconds of the search", "chosen at"];
    let note = "r = 500 and one p at a time. The paper: time rises with p, since larger groups have \
                more planes to compare with; ε = 0.05 and 0.1 choose differently on its model 2.";
    let mut table = Table::new("4.3.2: p", note, &header);
    let thresholds = SurfaceParameters::paper().planar_thresholds;
    let mut times: Vec<Vec<f64>> = vec![Vec::new(); thresholds.len()];
    for (name, mesh) in shared.ten()? {
        let mut tried: Vec<(f64, Found)> = Vec::new();
        for (place, &p) in thresholds.iter().enumerate() {
            let mut parameters = single(500, p);
            parameters.concavity_cost_threshold = NEVER_ABORTS;
            let found = surface(&mesh, &parameters)?;
            times[place].push(found.search_seconds);
            tried.push((p, found));
        }
        let chosen = |epsilon: f64| -> Option<f64> {
            let under = tried.iter().filter(|(_, found)| found.cost < epsilon);
            let fewest = under.min_by_key(|(_, found)| found.pieces);
            let cheapest = || tried.iter().min_by(|a, b| a.1.cost.total_cmp(&b.1.cost));
            fewest.or_else(cheapest).map(|(p, _)| *p)
        };
        for (p, found) in &tried {
            let at: Vec<String> = [0.05, 0.1]
                .into_iter()
                .filter(|epsilon| chosen(*epsilon) == Some(*p))
                .map(|epsilon| format!("ε = {epsilon}"))
                .collect();
            table.rows.push(vec![
                name.clone(),
                p.to_string(),
                found.pieces.to_string(),
                number(found.cost),
                number(found.search_seconds),
                if at.is_empty() { NOTHING.into() } else { at.join(", ") },
            ]);
        }
    }
    for (p, times) in thresholds.iter().zip(times) {
        let seconds = number(median(times));
        let cells = ["median", &p.to_string(), NOTHING, NOTHING, &seconds, NOTHING];
        table.rows.push(cells.map(String::from).into());
    }
    Ok(vec![table])
}

/// r swept at p = 0.1.
pub fn resolution(shared: &Shared) -> Result<Vec<Table>, String> {
    let header = ["model", "r", "polygons", "pieces", "cost", "seconds"];
    let mut table = Table::new("4.3.2: r", "p = 0.1 and one r at a time.", &header);
    for (name, mesh) in shared.ten()? {
        for r in SurfaceParameters::paper().maximum_resolutions {
            let mut parameters = single(r, 0.1);
            parameters.concavity_cost_threshold = NEVER_ABORTS;
            let found = surface(&mesh, &parameters)?;
            table.rows.push(vec![
                name.clone(),
                r.to_string(),
                found.polygons.to_string(),
                found.pieces.to_string(),
                number(found.cost),
                number(found.seconds),
            ]);
        }
    }
    Ok(vec![table])
}

/// a swept over the values of equation (2).
pub fn angular_threshold(shared: &Shared) -> Result<Vec<Table>, String> {
    let header = ["a", "median pieces", "median cost", "median seconds", "chosen on"];
    let note = "The whole search with one a at a time, over all Princeton meshes. Chosen: fewest pieces \
                among those with a cost under ε, the first of equals, as for p. The paper chose \
                0.01 in most instances, with negligible differences in the rest.";
    let mut table = Table::new("3.4.2: a", note, &header);
    let values = SurfaceParameters::paper().planar_thresholds;
    let mut found: Vec<Vec<Found>> = Vec::new();
    for mesh in &shared.princeton {
        let file = shared.read(&mesh.name)?;
        let run = |&a: &f64| {
            let mut parameters = SurfaceParameters::paper();
            parameters.angular_threshold = a;
            surface(&file, &parameters)
        };
        found.push(values.iter().map(run).collect::<Result<_, _>>()?);
    }
    let epsilon = SurfaceParameters::paper().concavity_cost_threshold;
    let chosen: Vec<Option<usize>> = found
        .iter()
        .map(|tried| {
            let under = tried.iter().enumerate().filter(|(_, found)| found.cost < epsilon);
            under.min_by_key(|(_, found)| found.pieces).map(|(place, _)| place)
        })
        .collect();
    for (place, a) in values.iter().enumerate() {
        let count = chosen.iter().filter(|chosen| **chosen == Some(place)).count();
        let of = |figure: fn(&Found) -> f64| {
            number(median(found.iter().map(|tried| figure(&tried[place])).collect()))
        };
        table.rows.push(vec![
            a.to_string(),
            of(|found| found.pieces as f64),
            of(|found| found.cost),
            of(|found| found.seconds),
            format!("{count} of {}", found.len()),
        ]);
    }
    Ok(vec![table])
}

/// Measured time against the claimed O(N / k).
pub fn complexity(shared: &Shared) -> Result<Vec<Table>, String> {
    let (mut samples, mut whole) = (Vec::new(), Vec::new());
    for mesh in &shared.princeton {
        let file = shared.read(&mesh.name)?;
        let found = surface(&file, &SurfaceParameters::paper())?;
        let sizes = [found.initial_polygons as f64, found.average_pieces, found.seconds];
        whole.push(sizes.map(|size| size.max(1e-7).ln()));
        for r in [500, 1000, 2000, 3000] {
            for p in [0.01, 0.2, 1.0] {
                let mut parameters = single(r, p);
                parameters.concavity_cost_threshold = NEVER_ABORTS;
                let found = surface(&file, &parameters)?;
                samples.push([
                    (found.polygons as f64).ln(),
                    (found.pieces as f64).ln(),
                    found.search_seconds.max(1e-7).ln(),
                ]);
            }
        }
    }
    let note = format!(
        "Least squares of ln t = c + a ln N + b ln k: over {} runs with one r and one p each, t the \
         seconds of the search alone, N the polygons of r and k the pieces; and over {} whole runs with \
         the paper's defaults, t all seconds, N the initial polygons and k the paper's average. The \
         paper claims O(N / k), so a = 1 and b = −1.",
        samples.len(),
        whole.len()
    );
    let mut table = Table::new("3.1: O(N / k)", &note, &["what", "claimed", "search", "whole run"]);
    let (search, whole) = (plane(&samples), plane(&whole));
    for (name, claimed, search, whole) in [
        ("exponent of N", "1", search.0, whole.0),
        ("exponent of k", "-1", search.1, whole.1),
        ("share of the variance explained", NOTHING, search.2, whole.2),
    ] {
        table.rows.push(vec![name.into(), claimed.into(), number(search), number(whole)]);
    }
    Ok(vec![table])
}

/// Q, ε and μ, one at a time.
pub fn sensitivity(shared: &Shared) -> Result<Vec<Table>, String> {
    let header = ["what", "pieces", "cost", "seconds", "Hausdorff"];
    let note = "Medians over the ten meshes of Table 1; everything else as in the paper (Q = 0.8, \
                ε = 0.05, μ = 5).";
    let mut table = Table::new("Sensitivity to Q, ε and μ", note, &header);
    let mut settings: Vec<(String, SurfaceParameters)> = Vec::new();
    let mut add = |name: String, set: &dyn Fn(&mut SurfaceParameters)| {
        let mut parameters = SurfaceParameters::paper();
        set(&mut parameters);
        settings.push((name, parameters));
    };
    for q in [0.5, 0.7, 0.8, 0.9, 0.95] {
        add(format!("Q = {q}"), &|parameters| parameters.simplification_quality = q);
    }
    for epsilon in [0.01, 0.025, 0.05, 0.1, 0.2] {
        let name = format!("ε = {epsilon}");
        add(name, &|parameters| parameters.concavity_cost_threshold = epsilon);
    }
    for mu in [0, 3, 5, 10, 20] {
        add(format!("μ = {mu}"), &|parameters| parameters.resolution_cut_off = mu);
    }
    let ten = shared.ten()?;
    for (name, parameters) in settings {
        let (mut found, mut errors) = (Vec::new(), Vec::new());
        for (_, mesh) in &ten {
            let one = surface(mesh, &parameters)?;
            errors.push(judge_default(mesh, &one.hulls)?.hausdorff);
            found.push(one);
        }
        let of = |figure: fn(&Found) -> f64| number(median(found.iter().map(figure).collect()));
        table.rows.push(vec![
            name,
            of(|found| found.pieces as f64),
            of(|found| found.cost),
            of(|found| found.seconds),
            number(median(errors)),
        ]);
    }
    Ok(vec![table])
}

/// One r and one p.
fn single(r: usize, p: f64) -> SurfaceParameters {
    let mut parameters = SurfaceParameters::paper();
    parameters.maximum_resolutions = vec![r];
    parameters.planar_thresholds = vec![p];
    parameters
}
