//! Section 4.3.1 and Figure 4: HACD, V-HACD, and shapes that are hollow.

use hullwright::surface::SurfaceParameters;

use super::work::{Found, Shared, judge_default, surface};
use crate::report::table::{NOTHING, Table, number, number_or_nothing};
use crate::runs::data_folder::PaperRow;
use crate::runs::judge::Judged;
use crate::runs::methods::Run;
use crate::runs::record::Worked;
use crate::statistics::median;

/// β, which the paper doesn't give: around its ε.
const THRESHOLDS: [f64; 4] = [0.02, 0.05, 0.1, 0.2];

/// Cost, time, resolution and pieces of the paper's method and of HACD.
pub fn hacd(shared: &Shared) -> Result<Vec<Table>, String> {
    let paper = SurfaceParameters::paper();
    let mut pairs: Vec<Vec<(Found, Found)>> = THRESHOLDS.map(|_| Vec::new()).into();
    let mut over_limit = [0; THRESHOLDS.len()];
    for mesh in &shared.some_of_princeton {
        let file = shared.read(&mesh.name)?;
        for (place, threshold) in THRESHOLDS.into_iter().enumerate() {
            match shared.hacd(&file, threshold, &paper)? {
                Some(found) => pairs[place].push((surface(&file, &paper)?, found)),
                None => over_limit[place] += 1,
            }
        }
    }
    let header = [
        "beta",
        "meshes",
        "over the limit",
        "surface: cost",
        "hacd: cost",
        "surface costs less",
        "surface: seconds",
        "hacd: seconds",
        "surface is faster",
        "surface: r",
        "hacd: r",
        "hacd's r is smaller",
        "surface: pieces",
        "hacd: pieces",
        "hacd has fewer",
    ];
    let note = "Medians over Princeton meshes, and on what share of them a claim of the paper \
                holds: its method has the lower cost and takes less time in each case, HACD has \
                smaller resolutions and fewer pieces in some cases. β is not given in the paper, so \
                it is swept; the unit of α is the average diagonal of a triangle.";
    let mut table = Table::new("4.3.1: HACD", note, &header);
    let figures: [fn(&Found) -> f64; 4] = [
        |found| found.cost,
        |found| found.seconds,
        |found| found.resolution as f64,
        |found| found.pieces as f64,
    ];
    for ((threshold, pairs), over_limit) in THRESHOLDS.iter().zip(&pairs).zip(over_limit) {
        let mut row = vec![threshold.to_string(), pairs.len().to_string(), over_limit.to_string()];
        for (place, figure) in figures.into_iter().enumerate() {
            let ours: Vec<f64> = pairs.iter().map(|(ours, _)| figure(ours)).collect();
            let theirs: Vec<f64> = pairs.iter().map(|(_, theirs)| figure(theirs)).collect();
            // The paper claims lower cost and time for its own, and less of the rest for HACD.
            let claims_ours = place < 2;
            let holds = ours
                .iter()
                .zip(&theirs)
                .filter(|(ours, theirs)| if claims_ours { ours < theirs } else { theirs < ours });
            let share = 100.0 * holds.count() as f64 / pairs.len().max(1) as f64;
            row.extend([number(median(ours.clone())), number(median(theirs))]);
            row.push(format!("{share:.0} %"));
        }
        table.rows.push(row);
    }
    Ok(vec![table])
}

/// Numbers of hulls to try until features appear.
const HULLS: [u32; 6] = [4, 8, 16, 32, 64, 128];

/// V-HACD at the same number of pieces, and at the least at which its error is no larger.
pub fn vhacd(shared: &Shared) -> Result<Vec<Table>, String> {
    let header = [
        "model",
        "method",
        "asked for",
        "hulls",
        "Hausdorff",
        "protrusion, mean",
        "IoU",
        "seconds",
    ];
    let has_library = !shared.tools.versions[1].is_empty();
    let note = format!(
        "V-HACD asked for as many hulls as the paper's method has, and for the fewest of {HULLS:?} \
         whose Hausdorff error is no larger than its: that is when features are there (*). Parry \
         turns the number into a depth of cuts, a power of two, and has no merging. {}",
        if has_library {
            "V-HACD 4 is that of the package vhacdx, with its default fill mode, flood fill."
        } else {
            "V-HACD 4 was not there."
        }
    );
    let mut table = Table::new("4.3.1: V-HACD", &note, &header);
    for paper_row in &shared.table1 {
        let file = shared.read(&paper_row.mesh)?;
        let ours = surface(&file, &SurfaceParameters::paper())?;
        let judged = judge_default(&file, &ours.hulls)?;
        let name = paper_row.name();
        table.rows.push(cells(&name, "surface", NOTHING.into(), &judged, ours.seconds));
        let parry: Version = ("V-HACD in Parry", |hulls| Run::VhacdHulls { hulls });
        let library: Version = ("V-HACD 4", |hulls| Run::Vhacd4 { hulls });
        for version in [Some(parry), has_library.then_some(library)].into_iter().flatten() {
            table.rows.extend(vhacd_rows(shared, paper_row, version, ours.pieces, &judged)?);
        }
    }
    Ok(vec![table])
}

/// A version of V-HACD: its name, and a run that asks it for a number of hulls.
type Version = (&'static str, fn(u32) -> Run);

/// A row with as many hulls as the paper's method has, and one with as many as its error takes.
fn vhacd_rows(
    shared: &Shared,
    paper_row: &PaperRow,
    (method, run): Version,
    pieces: usize,
    ours: &Judged,
) -> Result<Vec<Vec<String>>, String> {
    let name = paper_row.name();
    let run_with = |hulls| shared.apart(&run(hulls), &paper_row.mesh);
    let asked = pieces.to_string();
    let mut rows = vec![match run_with(pieces as u32)? {
        Some((worked, equal)) => cells(&name, method, asked, &equal, worked.seconds),
        None => {
            let nothing = [NOTHING; 4].map(String::from);
            let names = [name.clone(), method.into(), asked];
            names.into_iter().chain(nothing).chain(["not within the limits".into()]).collect()
        }
    }];
    let mut last: Option<(u32, Worked, Judged)> = None;
    for hulls in HULLS {
        let Some((worked, found)) = run_with(hulls)? else { continue };
        let is_enough = found.hausdorff <= ours.hausdorff;
        last = Some((hulls, worked, found));
        if is_enough {
            break;
        }
    }
    if let Some((hulls, worked, found)) = last {
        let never = if found.hausdorff <= ours.hausdorff { "" } else { " never" };
        rows.push(cells(&name, method, format!("{hulls} *{never}"), &found, worked.seconds));
    }
    Ok(rows)
}

fn cells(name: &str, method: &str, asked: String, judged: &Judged, seconds: f64) -> Vec<String> {
    vec![
        name.to_owned(),
        method.to_owned(),
        asked,
        judged.hulls.to_string(),
        number(judged.hausdorff),
        number(judged.protrusion_mean),
        number_or_nothing(judged.iou),
        number(seconds),
    ]
}

/// Figure 4's hollow shapes: does their inside stay open?
pub fn hollow_shapes(shared: &Shared) -> Result<Vec<Table>, String> {
    let header =
        ["mesh", "method", "hulls", "IoU", "protrusion, mean", "Hausdorff", "volume ratio"];
    let note = "Princeton's cups. An inside that is filled shows as a volume of the hulls' union far \
                above that of the solid (volume ratio), and as a low IoU.";
    let mut table = Table::new("Figure 4: hollow shapes", note, &header);
    for mesh in shared.folder.meshes_of_kind("cup")? {
        let file = shared.read(&mesh)?;
        let paper = SurfaceParameters::paper();
        let mut add = |method: &str, judged: &Judged| {
            // Of the joint volume the share s is in both: union / solid follows from IoU and from
            // the share u of the solid in no hull, since (1 − u) solid = IoU (solid + union − both).
            let ratio = judged.iou.zip(judged.uncovered_volume).map(|(iou, uncovered)| {
                let both = 1.0 - uncovered;
                both / iou - 1.0 + both
            });
            table.rows.push(vec![
                mesh.clone(),
                method.to_owned(),
                judged.hulls.to_string(),
                number_or_nothing(judged.iou),
                number(judged.protrusion_mean),
                number(judged.hausdorff),
                number_or_nothing(ratio),
            ]);
        };
        let ours = surface(&file, &paper)?;
        add("surface", &judge_default(&file, &ours.hulls)?);
        for threshold in [0.05, 0.1] {
            if let Some(found) = shared.hacd(&file, threshold, &paper)? {
                let judged = judge_default(&file, &found.hulls)?;
                add(&format!("hacd, beta {threshold}"), &judged);
            }
        }
        if let Some((_, judged)) = shared.apart(&Run::VHACD_DEFAULT, &mesh)? {
            add("V-HACD in Parry", &judged);
        }
    }
    Ok(vec![table])
}
