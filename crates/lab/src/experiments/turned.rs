//! `cargo lab turned`: hulls of meshes that are turned, over those of the mesh as it is.

use std::path::PathBuf;

use hullwright::io::read_mesh;
use hullwright::{Control, Length, MeshView, Openings, Parameters, decompose};
use hullwright_cli::terminal::{Failure, print};

use crate::runs::meshes::{find, folder};
use crate::stability::variations::{Mesh, ROTATIONS, Variation};
use crate::statistics::{mean, range};

/// Count hulls of turned meshes, over those of the mesh as it is
///
/// Openings are kept, since gravity says which are closed.
#[derive(clap::Args)]
pub struct Arguments {
    /// Meshes, and folders of meshes
    #[arg(required = true, value_name = "DIR")]
    folders: Vec<PathBuf>,

    /// Rotations of each mesh
    #[arg(long, value_name = "COUNT", default_value_t = ROTATIONS)]
    rotations: u32,

    /// Give turned meshes the bound of the mesh as it is, in its units: their bounding boxes have other diagonals
    #[arg(long)]
    same_bound: bool,
}

/// What counts as about as many hulls.
const ABOUT: std::ops::RangeInclusive<f64> = 0.8..=1.25;

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let parameters = Parameters::default().openings(Openings::Keep);
    let control = Control::new();
    // For each folder its ratios, in the order of the meshes.
    let mut ratios: Vec<(String, Vec<f64>)> = Vec::new();
    for mesh in find(&arguments.folders)? {
        let Ok(file) = read_mesh(&mesh.path) else { continue };
        let given = Mesh { positions: file.mesh.positions, triangles: file.mesh.triangles };
        let found = |mesh: &Mesh, parameters: &Parameters| {
            decompose(MeshView::new(&mesh.positions, &mesh.triangles), parameters, &control)
        };
        let Ok(as_it_is) = found(&given, &parameters) else { continue };
        let upright = as_it_is.hulls.len();
        let parameters = match arguments.same_bound {
            true => parameters.clone().max_error(Length::units(as_it_is.report.bound)),
            false => parameters.clone(),
        };
        let mut turned = Vec::new();
        for number in 0..arguments.rotations {
            let mesh = Variation::Rotation(number).apply(&given).0;
            turned.push(found(&mesh, &parameters)?.hulls.len());
        }
        let own: Vec<f64> = turned.iter().map(|&count| count as f64 / upright as f64).collect();
        let (least, most) = range(own.iter().copied());
        if !(ABOUT.contains(&least) && ABOUT.contains(&most)) {
            print(&format!(
                "{upright:4} hulls, turned {least:.2} to {most:.2} times, {:.2} in the mean  {}",
                mean(&own),
                mesh.name
            ))?;
        }
        match ratios.iter_mut().find(|entry| entry.0 == folder(&mesh.name)) {
            Some(entry) => entry.1.extend(own),
            None => ratios.push((folder(&mesh.name).to_owned(), own)),
        }
    }
    let all: Vec<f64> = ratios.iter().flat_map(|entry| &entry.1).copied().collect();
    ratios.push(("all".into(), all));
    for (name, ratios) in ratios {
        let within = ratios.iter().filter(|&ratio| ABOUT.contains(ratio)).count();
        let same = ratios.iter().filter(|&&ratio| ratio == 1.0).count();
        let (least, most) = range(ratios.iter().copied());
        let share = |count: usize| 100.0 * count as f64 / ratios.len().max(1) as f64;
        print(&format!(
            "{name}: {} turned runs, {:.1} % within {} to {} times the hulls, {:.1} % the same number; \
             {least:.2} to {most:.2} at the ends, {:.3} in the mean",
            ratios.len(),
            share(within),
            ABOUT.start(),
            ABOUT.end(),
            share(same),
            mean(&ratios)
        ))?;
    }
    Ok(())
}
