//! Figures 2 to 5 of the paper, on our meshes.

use std::path::Path;

use hullwright::TriangleMesh;
use hullwright::surface::SurfaceParameters;

use super::ablations::{RESOLUTION, at, whole, within_900};
use super::comparisons::vhacd_of;
use super::{Model, decomposed, hacd_of, paper_with};
use crate::pictures::write;
use crate::render::{Layout, Panel};
use crate::terminal::Failure;

/// Pixels of a panel, and how far hulls stand apart.
const PANEL: (usize, usize) = (190, 165);
const APART: f64 = 0.25;

/// Into hollow things one looks from above.
const FROM_ABOVE: f64 = 35.0;

/// The groups of a mesh, and their hulls.
fn panels(mesh: &TriangleMesh, parameters: &SurfaceParameters) -> Result<[Panel; 2], Failure> {
    let found = decomposed(mesh, parameters)?.decomposition;
    let simplified = TriangleMesh::new(found.grouped.positions, found.grouped.triangles);
    let groups = Panel::labelled(&simplified, &found.grouped.groups);
    Ok([groups, Panel::hulls(&found.hulls).exploded(APART)])
}

/// The files, and what is in them.
pub const FIGURES: [(&str, &str); 4] = [
    ("figure-2.png", "Figure 2: two cups, their groups before and after merging, their hulls"),
    (
        "figure-3.png",
        "Figure 3: the models of Table 1, their groups and hulls, and the hulls of HACD",
    ),
    (
        "figure-4.png",
        "Figure 4: cups, by the paper's method, HACD, and V-HACD with a limit of as many pieces",
    ),
    (
        "figure-5.png",
        "Figure 5: spot whole by the paper's method, by HACD, and with r = 900, groups and hulls; \
         below, three models at r = 500 under each p",
    ),
];

/// Draws them, for models, cups and spot.
pub fn draw(folder: &Path, models: &[Model], cups: &[Model], spot: &Model) -> Result<(), Failure> {
    let (paper, hacd) = (SurfaceParameters::paper(), hacd_of(0.05));
    let elevation = Layout::default().view.elevation;
    let mut rows = Vec::new();
    for cup in cups.iter().take(2) {
        let unmerged = paper_with(|one| one.significant_diagonal = 0.0);
        let [before, _] = panels(&cup.mesh, &unmerged)?;
        let [after, hulls] = panels(&cup.mesh, &paper)?;
        rows.push(vec![Panel::mesh(&cup.mesh), before, after, hulls]);
    }
    let [two, three, four, five] = FIGURES.map(|(file, _)| folder.join(file));
    write(&two, rows, PANEL, FROM_ABOVE)?;
    let mut rows = Vec::new();
    for pair in models.chunks(2) {
        let mut row = Vec::new();
        for model in pair {
            let ([groups, hulls], [_, theirs]) =
                (panels(&model.mesh, &paper)?, panels(&model.mesh, &hacd)?);
            row.extend([Panel::mesh(&model.mesh), groups, hulls, theirs]);
        }
        rows.push(row);
    }
    write(&three, rows, PANEL, elevation)?;
    let mut rows = Vec::new();
    for cup in cups.iter().take(4) {
        let found = decomposed(&cup.mesh, &paper)?.decomposition;
        let [_, theirs] = panels(&cup.mesh, &hacd)?;
        let (equal, _) = vhacd_of(&cup.mesh, found.hulls.len() as u32);
        let [ours, equal] = [Panel::hulls(&found.hulls), Panel::hulls(&equal)];
        rows.push(vec![Panel::mesh(&cup.mesh), ours, Panel { explosion: 0.0, ..theirs }, equal]);
    }
    write(&four, rows, PANEL, FROM_ABOVE)?;
    let mut row = vec![Panel::mesh(&spot.mesh)];
    for parameters in [whole(paper.clone()), whole(hacd), within_900()] {
        row.extend(panels(&spot.mesh, &parameters)?);
    }
    let mut rows = vec![row];
    for model in models.iter().take(3) {
        let mut row = vec![Panel::mesh(&model.mesh)];
        for &p in &paper.planar_thresholds {
            let [_, hulls] = panels(&model.mesh, &at(p, RESOLUTION))?;
            row.push(hulls);
        }
        rows.push(row);
    }
    write(&five, rows, PANEL, elevation)
}
