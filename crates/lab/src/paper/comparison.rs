//! Section 4.3.1 and Figure 4: HACD, V-HACD, and shapes that are hollow.

use hullwright::SurfaceParameters;

use super::work::{Found, Shared, judge, surface};
use crate::bench::methods::Run;
use crate::bench::record::{Judged, Worked};
use crate::bench::table::{NOTHING, Table, number, number_or_nothing};
use crate::bench::worker::median;

/// β, which the paper doesn't give.
const THRESHOLDS: [f64; 4] = [0.02, 0.05, 0.1, 0.2];

/// Cost, time, resolution and pieces of the paper's method and of HACD.
pub fn hacd(shared: &Shared) -> Result<Vec<Table>, String> {
    let paper = SurfaceParameters::paper();
    let mut pairs: Vec<Vec<(Found, Found)>> = THRESHOLDS.map(|_| Vec::new()).into();
    let mut capped = [0; THRESHOLDS.len()];
    for mesh in &shared.some_of_princeton {
        let file = shared.read(&mesh.name)?;
        for (place, threshold) in THRESHOLDS.into_iter().enumerate() {
            match shared.hacd(&file, threshold, &paper)? {
                Some(found) => pairs[place].push((surface(&file, &paper)?, found)),
                None => capped[place] += 1,
            }
        }
    }
    let header = [
        "beta",
        "meshes",
        "capped",
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
    for ((threshold, pairs), capped) in THRESHOLDS.iter().zip(&pairs).zip(capped) {
        let mut row = vec![threshold.to_string(), pairs.len().to_string(), capped.to_string()];
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
    let header =
        ["model", "method", "asked for", "hulls", "Hausdorff", "phantom, mean", "IoU", "seconds"];
    let has_library = !shared.peers.versions[1].is_empty();
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
    let row = |name: &str, method: &str, asked: String, judged: &Judged, seconds: f64| {
        vec![
            name.to_owned(),
            method.to_owned(),
            asked,
            judged.hulls.to_string(),
            number(judged.hausdorff),
            number(judged.phantom_mean),
            number_or_nothing(judged.iou),
            number(seconds),
        ]
    };
    for paper_row in &shared.table1 {
        let name = paper_row.name();
        let file = shared.read(&paper_row.mesh)?;
        let ours = surface(&file, &SurfaceParameters::paper())?;
        let judged = Judged::from(&judge(&file, &ours.hulls)?);
        table.rows.push(row(&name, "surface", NOTHING.into(), &judged, ours.seconds));
        for (method, is_parry) in [("V-HACD in Parry", true), ("V-HACD 4", false)] {
            if !is_parry && !has_library {
                continue;
            }
            let pieces = ours.pieces as u32;
            let run_with = |hulls| {
                let run = if is_parry { Run::VhacdHulls { hulls } } else { Run::Vhacd4 { hulls } };
                shared.apart(&run, &paper_row.mesh)
            };
            match run_with(pieces)? {
                Some((worked, equal)) => {
                    table.rows.push(row(&name, method, pieces.to_string(), &equal, worked.seconds));
                }
                None => {
                    let mut cells = vec![NOTHING.to_owned(); header.len()];
                    cells.splice(..3, [name.clone(), method.into(), pieces.to_string()]);
                    if let Some(last) = cells.last_mut() {
                        *last = "not within the caps".into();
                    }
                    table.rows.push(cells);
                }
            }
            let mut last: Option<(u32, Worked, Judged)> = None;
            for hulls in HULLS {
                let Some((worked, found)) = run_with(hulls)? else { continue };
                let is_enough = found.hausdorff <= judged.hausdorff;
                last = Some((hulls, worked, found));
                if is_enough {
                    break;
                }
            }
            if let Some((hulls, worked, found)) = last {
                let is_enough = found.hausdorff <= judged.hausdorff;
                let asked = format!("{hulls} *{}", if is_enough { "" } else { " never" });
                table.rows.push(row(&name, method, asked, &found, worked.seconds));
            }
        }
    }
    Ok(vec![table])
}

/// Figure 4's hollow shapes: does the hollow stay open?
pub fn hollow(shared: &Shared) -> Result<Vec<Table>, String> {
    let header = ["mesh", "method", "hulls", "IoU", "phantom, mean", "Hausdorff", "volume ratio"];
    let note = "Princeton's cups. A hollow that is filled shows as a volume of the hulls' union far \
                above that of the solid (volume ratio), and as a low IoU.";
    let mut table = Table::new("Figure 4: hollow shapes", note, &header);
    for mesh in shared.of_kind("cup")? {
        let file = shared.read(&mesh)?;
        let paper = SurfaceParameters::paper();
        let mut add = |method: &str, judged: &Judged| {
            // Of the joint volume the share s is in both: union / solid follows from IoU and from
            // what of the solid is hollow, since (1 − hollow) solid = IoU (solid + union − both).
            let ratio = judged.iou.zip(judged.hollow).map(|(iou, hollow)| {
                let both = 1.0 - hollow;
                both / iou - 1.0 + both
            });
            table.rows.push(vec![
                mesh.clone(),
                method.to_owned(),
                judged.hulls.to_string(),
                number_or_nothing(judged.iou),
                number(judged.phantom_mean),
                number(judged.hausdorff),
                number_or_nothing(ratio),
            ]);
        };
        let ours = surface(&file, &paper)?;
        add("surface", &Judged::from(&judge(&file, &ours.hulls)?));
        for threshold in [0.05, 0.1] {
            if let Some(found) = shared.hacd(&file, threshold, &paper)? {
                let judged = Judged::from(&judge(&file, &found.hulls)?);
                add(&format!("hacd, beta {threshold}"), &judged);
            }
        }
        if let Some((_, judged)) = shared.apart(&Run::VHACD_DEFAULT, &mesh)? {
            add("V-HACD in Parry", &judged);
        }
    }
    Ok(vec![table])
}
