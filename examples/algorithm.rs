//! Draws the pictures of `docs/algorithm.md` into a folder:
//! `cargo run --release --package hullwright-cli --example algorithm -- docs/pictures`.

use std::error::Error;
use std::path::Path;

use hullwright::io::{palette, read_mesh};
use hullwright::{
    Control, Decomposition, Hull, Length, MeshView, Parameters, TriangleMesh, close_openings,
    decompose,
};
use hullwright_cli::render::{Layout, Panel, Part, render_with};

/// Size of a panel in pixels.
const PANEL: (usize, usize) = (310, 270);

/// How far hulls move away from the centre, as a share of their distance.
const EXPLOSION: f64 = 0.45;

/// The bounds that are compared.
const BOUNDS: [f64; 3] = [0.05, 0.02, 0.005];

/// Colours of triangles that are no more than told apart.
const SHADES: [palette::Colour; 3] = [[214, 208, 198], [176, 190, 204], [236, 232, 222]];

fn main() -> Result<(), Box<dyn Error>> {
    let Some(folder) = std::env::args().nth(1) else {
        return Err("usage: algorithm FOLDER".into());
    };
    let asset = |name: &str| {
        let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets");
        read_mesh(assets.join(name))
    };
    let (stairs, table) = (stairs(), asset("table.glb")?);
    let (mug, dog) = (asset("mug.glb")?, asset("dog.glb")?);
    let rows = [stairs.view(), (&table).into(), (&dog).into()];
    let rows: Result<Vec<_>, _> = rows.into_iter().map(stages).collect();
    write(&folder, "algorithm-stages.png", rows?)?;
    let apart = |hulls: &[Hull]| Panel::hulls(hulls).exploded(EXPLOSION);
    let with_mesh = |hulls: &[Hull]| {
        let mut panel = Panel::hulls(hulls);
        let mesh = MeshView::from(&dog).to_owned();
        panel.parts.push(Part { mesh, colour: palette::CLAY });
        panel
    };
    let (of_mug, of_dog) = (under_bounds((&mug).into())?, under_bounds((&dog).into())?);
    let rows = vec![
        of_mug.iter().map(|hulls| apart(hulls)).collect(),
        of_dog.iter().map(|hulls| apart(hulls)).collect(),
        of_dog.iter().map(|hulls| with_mesh(hulls)).collect(),
    ];
    write(&folder, "algorithm-bounds.png", rows)
}

/// The mesh with its caps, the mesh that is divided, its triangles by hulls, and the hulls moved apart.
fn stages(mesh: MeshView<'_>) -> Result<Vec<Panel>, hullwright::Error> {
    let (parameters, control) = (Parameters::default(), Control::new());
    let closed = close_openings(mesh, &parameters, &control)?;
    let Decomposition { hulls, grouped, .. } = decompose(mesh, &parameters, &control)?;
    println!("{} hulls", hulls.len());
    let divided = TriangleMesh::new(grouped.positions, grouped.triangles);
    Ok(vec![
        Panel::closed_mesh(&closed),
        facets(&divided),
        Panel::labelled(&divided, &grouped.groups),
        Panel::hulls(&hulls).exploded(EXPLOSION),
    ])
}

/// The hulls under each bound.
fn under_bounds(mesh: MeshView<'_>) -> Result<Vec<Vec<Hull>>, hullwright::Error> {
    let of = |&bound: &f64| {
        let parameters = Parameters::default().max_error(Length::share(bound));
        let result = decompose(mesh, &parameters, &Control::new())?;
        println!("{} %: {} hulls", 100.0 * bound, result.hulls.len());
        Ok(result.hulls)
    };
    BOUNDS.iter().map(of).collect()
}

/// A mesh whose triangles can be told apart.
fn facets(mesh: &TriangleMesh) -> Panel {
    let shade = |shade: usize| {
        let of_shade = mesh.triangles.iter().enumerate().filter(|(t, _)| t % SHADES.len() == shade);
        let triangles = of_shade.map(|(_, &triangle)| triangle).collect();
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

/// Writes rows of panels.
fn write(folder: &str, name: &str, rows: Vec<Vec<Panel>>) -> Result<(), Box<dyn Error>> {
    let mut layout = Layout::default();
    let columns = rows.first().map_or(1, Vec::len);
    layout.columns = Some(columns);
    layout.separate_frames = true;
    let (width, height) = (columns * PANEL.0, rows.len() * PANEL.1);
    let panels: Vec<Panel> = rows.into_iter().flatten().collect();
    let path = Path::new(folder).join(name);
    render_with(&panels, width, height, &layout)?.write_png(&path)?;
    println!("wrote {}", path.display());
    Ok(())
}
