//! `cargo lab pictures`: the pictures of the documents.

// The unused rest is for tests.
#[allow(dead_code)]
#[path = "../../hullwright/tests/openings/cases.rs"]
mod cases;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use hullwright::openings::close_openings;
use hullwright::{
    Control, Decomposition, Error, Hull, Length, MeshView, Openings, Parameters, TriangleMesh,
    decompose,
};
use hullwright_formats::{palette, read_mesh};

use crate::render::{Layout, Panel, Part, render_with};
use crate::shapes::{cuboid, join};
use crate::terminal::{Failure, print};
use crate::{burst, fragments};

/// Draw the pictures of the documents
#[derive(clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    picture: Picture,
}

#[derive(clap::Subcommand)]
enum Picture {
    /// docs/algorithm.md: the stages, and three bounds
    Algorithm {
        #[arg(default_value = "docs/pictures")]
        folder: PathBuf,
    },
    /// docs/bevy/bounds.md: a mug, a building and a terrain, and their hulls within three bounds
    Bounds {
        #[arg(default_value = "docs/pictures/bevy-bounds.png")]
        output: PathBuf,
    },
    /// docs/openings.md: a row for each mesh, with its caps in red, the hulls with all openings
    /// kept, and those with openings closed
    Openings {
        output: PathBuf,
        #[arg(required = true)]
        meshes: Vec<PathBuf>,
    },
    /// docs/openings.md: the tests' cases, and a row of its tables for each
    OpeningCases {
        #[arg(default_value = "docs/pictures")]
        folder: PathBuf,
    },
    /// docs/probe.md: a mesh, its hulls without a probe, and with radii of 3, 6 and 12 %
    Probe {
        #[arg(default_value = "docs/pictures/probe.png")]
        output: PathBuf,
        #[arg(default_value = "assets/gear.glb")]
        mesh: PathBuf,
    },
    /// docs/bevy/hulls.md: each mesh, its hulls, and its fragments with their cuts in red
    Fragments {
        output: PathBuf,
        #[arg(required = true)]
        meshes: Vec<PathBuf>,
    },
    /// The README's animation: hulls close and fall as one body, and the mesh bursts into them
    Burst {
        #[arg(default_value = "docs/pictures/burst.png")]
        output: PathBuf,
        #[arg(default_value = "assets/dog.glb")]
        mesh: PathBuf,
    },
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    match &arguments.picture {
        Picture::Algorithm { folder } => algorithm(folder),
        Picture::Bounds { output } => bounds(output),
        Picture::Openings { output, meshes } => {
            let mut rows = Vec::new();
            for mesh in meshes {
                let (panels, counts) = openings(&read_mesh(mesh)?.mesh, 0.4)?;
                print(&format!("{}: {counts:?} hulls, openings kept and closed", mesh.display()))?;
                rows.push(panels.to_vec());
            }
            write(output, rows, (460, 340), FROM_BELOW)
        }
        Picture::OpeningCases { folder } => {
            opening_cases(&cases::solids(), FROM_BELOW, &folder.join("opening-cases-solid.png"))?;
            opening_cases(&cases::hollows(), FROM_ABOVE, &folder.join("opening-cases-hollow.png"))
        }
        Picture::Probe { output, mesh } => probe(output, mesh),
        Picture::Fragments { output, meshes } => {
            let elevation = Layout::default().view.elevation;
            write(output, fragments::rows(meshes)?, (310, 270), elevation)
        }
        Picture::Burst { output, mesh } => burst::draw(output, mesh),
    }
}

/// Degrees from which openings of solids are seen, and what is hollow.
const FROM_BELOW: f64 = -25.0;
const FROM_ABOVE: f64 = 35.0;

/// Writes rows of panels of a size in pixels, seen from so many degrees above.
pub fn write(
    path: &Path,
    rows: Vec<Vec<Panel>>,
    panel: (usize, usize),
    elevation: f64,
) -> Result<(), Failure> {
    let mut layout = Layout::default();
    let columns = rows.first().map_or(1, Vec::len);
    layout.columns = Some(columns);
    layout.separate_frames = true;
    layout.view.elevation = elevation;
    let (width, height) = (columns * panel.0, rows.len() * panel.1);
    let panels: Vec<Panel> = rows.into_iter().flatten().collect();
    render_with(&panels, width, height, &layout)?.write_png(path)?;
    print(&format!("wrote {}", path.display()))
}

/// The mesh with its caps in red, the hulls with all openings kept, those with openings closed,
/// moved apart, and the numbers of both.
fn openings(mesh: &TriangleMesh, apart: f64) -> Result<([Panel; 3], [usize; 2]), Error> {
    let (auto, control) = (Parameters::default(), Control::new());
    let closed = close_openings(mesh, &auto, &control)?;
    let keep = auto.clone().with_openings(Openings::Keep);
    let [kept, auto] = [decompose(mesh, &keep, &control)?, decompose(mesh, &auto, &control)?];
    let panels = [
        Panel::closed_mesh(&closed),
        Panel::hulls(&kept.hulls).exploded(apart),
        Panel::hulls(&auto.hulls).exploded(apart),
    ];
    Ok((panels, [kept.hulls.len(), auto.hulls.len()]))
}

/// Draws cases, two in a row, and prints what became of each.
fn opening_cases(
    cases: &[(&str, TriangleMesh)],
    elevation: f64,
    path: &Path,
) -> Result<(), Failure> {
    let mut panels = Vec::new();
    print("| case | hulls, openings kept | hulls | openings |\n|---|---|---|---|")?;
    for (name, mesh) in cases {
        let (of_case, [kept, closed]) = openings(mesh, 0.3)?;
        panels.extend(of_case);
        let found = decompose(mesh, &Parameters::default(), &Control::new())?.run.openings;
        let outcomes = found.iter().map(|opening| opening.outcome.describe());
        let outcomes = Vec::from_iter(outcomes.collect::<BTreeSet<_>>()).join("; ");
        let outcomes = if outcomes.is_empty() { "none" } else { &outcomes };
        print(&format!("| {name} | {kept} | {closed} | {outcomes} |"))?;
    }
    let rows = panels.chunks(6).map(<[_]>::to_vec).collect();
    write(path, rows, (220, 180), elevation)
}

/// Colours of triangles that are no more than told apart.
const SHADES: [palette::Colour; 3] = [[214, 208, 198], [176, 190, 204], [236, 232, 222]];

fn algorithm(folder: &Path) -> Result<(), Failure> {
    const APART: f64 = 0.45;
    const PANEL: (usize, usize) = (310, 270);
    let asset = |name: &str| read_mesh(Path::new("assets").join(name));
    let (table, mug, dog) =
        (asset("table.glb")?.mesh, asset("mug.glb")?.mesh, asset("dog.glb")?.mesh);
    let elevation = Layout::default().view.elevation;
    let (parameters, control) = (Parameters::default(), Control::new());
    let mut rows = Vec::new();
    for mesh in [&stairs(), &table, &dog] {
        let closed = close_openings(mesh, &parameters, &control)?;
        let Decomposition { hulls, grouped, .. } = decompose(mesh, &parameters, &control)?;
        print(&format!("{} hulls", hulls.len()))?;
        let divided = TriangleMesh::new(grouped.positions, grouped.triangles);
        rows.push(vec![
            Panel::closed_mesh(&closed),
            facets(&divided),
            Panel::labelled(&divided, &grouped.groups),
            Panel::hulls(&hulls).exploded(APART),
        ]);
    }
    write(&folder.join("algorithm-stages.png"), rows, PANEL, elevation)?;

    let bounds = [0.05, 0.02, 0.005].map(Length::share);
    let (of_mug, of_dog) =
        (under_bounds("mug", mug.view(), bounds)?, under_bounds("dog", dog.view(), bounds)?);
    let apart = |hulls: &Vec<Hull>| Panel::hulls(hulls).exploded(APART);
    let with_mesh = |hulls: &Vec<Hull>| {
        let mut panel = Panel::hulls(hulls);
        panel.parts.push(Part { mesh: dog.clone(), colour: palette::CLAY });
        panel
    };
    let rows = vec![
        of_mug.iter().map(apart).collect(),
        of_dog.iter().map(apart).collect(),
        of_dog.iter().map(with_mesh).collect(),
    ];
    write(&folder.join("algorithm-bounds.png"), rows, PANEL, elevation)
}

/// The hulls within each bound.
fn under_bounds(
    name: &str,
    mesh: MeshView<'_>,
    bounds: [Length; 3],
) -> Result<Vec<Vec<Hull>>, Failure> {
    let mut all = Vec::new();
    for bound in bounds {
        let parameters = Parameters::default().with_max_error(bound);
        let hulls = decompose(mesh, &parameters, &Control::new())?.hulls;
        print(&format!("{name} within {bound}: {} hulls", hulls.len()))?;
        all.push(hulls);
    }
    Ok(all)
}

/// A mesh whose triangles can be told apart.
fn facets(mesh: &TriangleMesh) -> Panel {
    let shade = |shade: usize| {
        let triangles = mesh.triangles.iter().skip(shade).step_by(SHADES.len()).copied().collect();
        let mesh = TriangleMesh::new(mesh.positions.clone(), triangles);
        Part { mesh, colour: SHADES[shade] }
    };
    Panel { parts: (0..SHADES.len()).map(shade).collect(), explosion: 0.0 }
}

/// Four steps, without the surface at their right end.
fn stairs() -> TriangleMesh {
    const STEPS: u32 = 4;
    let mut outline: Vec<[f64; 2]> = vec![[0.0, 0.0]];
    for step in 0..STEPS {
        let (z, y) = (f64::from(STEPS - step), f64::from(step + 1));
        outline.extend([[z, y - 1.0], [z, y]]);
    }
    outline.push([0.0, f64::from(STEPS)]);
    let count = outline.len() as u32;
    let ends = [0.0, 4.0].into_iter();
    let positions = ends.flat_map(|x| outline.iter().map(move |&[z, y]| [x, y, z])).collect();
    let around = (0..count).flat_map(|a| {
        let b = (a + 1) % count;
        [[a, b + count, b], [a, a + count, b + count]]
    });
    // The left end: all triangles have the corner that sees the whole outline.
    let left = (1..count - 1).map(|k| [0, k, k + 1]);
    TriangleMesh::new(positions, around.chain(left).collect())
}

fn bounds(output: &Path) -> Result<(), Failure> {
    let (five, two, one) = (Length::share(0.05), Length::share(0.02), Length::share(0.01));
    let mut rows = Vec::new();
    for (name, mesh, bounds) in [
        ("mug", read_mesh("assets/mug.glb")?.mesh, [five, two, one]),
        ("building", building(), [five, two, Length::units(0.05)]),
        ("terrain", terrain(), [five, two, one]),
    ] {
        let hulls = under_bounds(name, mesh.view(), bounds)?;
        let panels = hulls.iter().map(|hulls| Panel::hulls(hulls).exploded(0.25));
        rows.push(std::iter::once(Panel::mesh(&mesh)).chain(panels).collect());
    }
    write(output, rows, (300, 230), Layout::default().view.elevation)
}

/// A mesh, and its hulls by radius.
fn probe(output: &Path, mesh: &Path) -> Result<(), Failure> {
    let mesh = read_mesh(mesh)?.mesh;
    let mut panels = vec![Panel::mesh(&mesh)];
    for radius in [None, Some(0.03), Some(0.06), Some(0.12)] {
        let parameters = Parameters::default().with_probe_radius(radius.map(Length::share));
        let hulls = decompose(&mesh, &parameters, &Control::new())?.hulls;
        print(&format!("{parameters}: {} hulls", hulls.len()))?;
        panels.push(Panel::hulls(&hulls));
    }
    write(output, vec![panels], (300, 260), Layout::default().view.elevation)
}

/// A bungalow of two rooms, 8 by 6 metres, with walls of 20 cm and doors of 1 by 2 metres, in
/// metres. The roof is left out, so that one sees the rooms.
fn building() -> TriangleMesh {
    let walls = [
        ([0.0, -0.2, 0.0], [8.0, 0.0, 6.0]),
        ([0.0, 0.0, 0.0], [8.0, 2.6, 0.2]),
        ([0.0, 0.0, 0.2], [0.2, 2.6, 5.8]),
        ([7.8, 0.0, 0.2], [8.0, 2.6, 5.8]),
        // The front, with a door.
        ([0.0, 0.0, 5.8], [2.0, 2.6, 6.0]),
        ([3.0, 0.0, 5.8], [8.0, 2.6, 6.0]),
        ([2.0, 2.0, 5.8], [3.0, 2.6, 6.0]),
        // Between the rooms, with a door.
        ([4.9, 0.0, 0.2], [5.1, 2.6, 3.0]),
        ([4.9, 0.0, 4.0], [5.1, 2.6, 5.8]),
        ([4.9, 2.0, 3.0], [5.1, 2.6, 4.0]),
    ];
    join(&walls.map(|(low, high)| cuboid(low, high)))
}

/// Hills of 100 by 100 metres, a sheet without an underside, in metres.
fn terrain() -> TriangleMesh {
    const SIDE: u32 = 28;
    const STEP: f64 = 100.0 / (SIDE - 1) as f64;
    let place = |i: u32| {
        let (x, z) = (f64::from(i % SIDE) * STEP, f64::from(i / SIDE) * STEP);
        let height = 9.0 * (x / 15.0).sin() * (z / 19.0).cos() + 3.0 * (x / 5.0 + z / 7.0).sin();
        [x, height, z]
    };
    let squares = (0..SIDE - 1).flat_map(|z| (0..SIDE - 1).map(move |x| z * SIDE + x));
    let triangles = squares.flat_map(|a| {
        let (b, c, d) = (a + SIDE, a + 1, a + SIDE + 1);
        [[a, b, c], [c, b, d]]
    });
    TriangleMesh::new((0..SIDE * SIDE).map(place).collect(), triangles.collect())
}
