//! `cargo lab gallery`: pictures and figures of the bundled models and of shapes of trouble, ours
//! beside V-HACD's.

mod shapes;

use std::path::{Path, PathBuf};

use hullwright::measure::{MeasureOptions, Measurement, measure};
use hullwright::openings::close_openings;
use hullwright::{ALGORITHM_VERSION, Control, Hull, MeshView, Parameters, TriangleMesh, decompose};
use hullwright_cli::viewer::hulls_of;
use hullwright_formats::read_mesh;

use crate::pictures;
use crate::render::{Layout, Panel};
use crate::report;
use crate::terminal::{Failure, print};
use crate::tools::methods::Run;
use crate::tools::vhacd;

/// Draw the gallery: the bundled models and shapes of trouble, ours beside V-HACD's
///
/// Writes gallery.md and the pictures in gallery/ into a folder. The same input gives the same
/// files.
#[derive(clap::Args)]
pub struct Arguments {
    /// The folder that the gallery goes to
    #[arg(short, long, value_name = "DIR", default_value = "docs")]
    output: PathBuf,

    /// The folder of the bundled models
    #[arg(long, value_name = "DIR", default_value = "assets")]
    assets: PathBuf,
}

/// Width and height of a panel in pixels: three make a picture of 100 KB at most.
const PANEL: (usize, usize) = (300, 250);

/// How far hulls move away from the centre, as a share of their distance: so little that the shape
/// is still seen.
const EXPLOSION: f64 = 0.25;

/// The folder of the pictures.
const FOLDER: &str = "gallery";

const INTRODUCTION: &str = "Every bundled model, and a dozen shapes of trouble. From left to right: the mesh, \
    the hulls of the default method, and those of Parry's V-HACD with default parameters, moved apart. \
    `hullwright measure` samples the figures, V-HACD's in the same order: *error* is the larger of protrusion \
    and uncovered distance, as a percentage of the bounding-box diagonal; *IoU* is the volume of the \
    intersection over that of the union.";

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { output, assets } = arguments;
    report::create_folder(&output.join(FOLDER))?;
    let mut models = Vec::new();
    for (file, words) in MODELS {
        let mesh = read_mesh(assets.join(format!("{file}.glb")))?.mesh;
        models.push(Entry::new(&file.replace('_', " "), words, &mesh, output)?);
    }
    let mut troubles = Vec::new();
    for shape in shapes::all() {
        troubles.push(Entry::new(shape.name, shape.words, &shape.mesh, output)?);
    }
    let parts = [("Models", models), ("Shapes of trouble", troubles)];
    report::write(&output.join("gallery.md"), &markdown(&parts))?;
    Ok(())
}

/// The bundled models, and what they are.
const MODELS: [(&str, &str); 14] = [
    ("mug", "A cup with a wall, and a handle that a finger fits through."),
    ("bowl", "A thin shell whose inside stays open."),
    ("teapot", "Four closed parts that run into each other, as artists make them."),
    ("chair", "Ten boxes."),
    ("table", "Top and legs in one surface."),
    ("lamp", "One closed surface."),
    ("dog", "Smooth, with limbs at all angles."),
    ("gear", "Teeth that mesh, and a bore that an axle fits."),
    ("torus", "A hole all the way through a smooth body."),
    ("spring", "A helix: no plane cuts it well."),
    ("leaf", "An open sheet, without inside and thickness."),
    ("l_prism", "The least concave solid."),
    ("u_prism", "Three boxes, and a gap that stays open."),
    ("plus", "Four notches."),
];

/// A mesh, its picture, and what two methods made of it.
struct Entry {
    name: String,
    words: String,
    /// Below the folder of the gallery.
    picture: String,
    triangles: usize,
    ours: Measurement,
    vhacd: Option<Measurement>,
}

impl Entry {
    /// Decomposes a mesh by both methods, and draws what came of it.
    fn new(name: &str, words: &str, mesh: &TriangleMesh, output: &Path) -> Result<Self, Failure> {
        let (parameters, control) = (Parameters::default(), Control::new());
        let view = mesh.view();
        let ours = decompose(view, &parameters, &control)?.hulls;
        let theirs = vhacd_hulls(view);
        let judge = |hulls: &[Hull]| measure(view, hulls, &MeasureOptions::default(), &control);
        let panels = [
            Panel::closed_mesh(&close_openings(view, &parameters, &control)?),
            Panel::hulls(&ours).exploded(EXPLOSION),
            Panel::hulls(&theirs).exploded(EXPLOSION),
        ];
        let file = format!("{FOLDER}/{}.png", file_name(name));
        let elevation = Layout::default().view.elevation;
        pictures::write(&output.join(&file), vec![panels.to_vec()], PANEL, elevation)?;
        let entry = Self {
            name: name.into(),
            words: words.into(),
            picture: file,
            triangles: mesh.triangles.len(),
            ours: judge(&ours)?,
            vhacd: if theirs.is_empty() { None } else { Some(judge(&theirs)?) },
        };
        print(&format!("{name}: {} of ours, {} of V-HACD's", ours.len(), theirs.len()))?;
        Ok(entry)
    }

    /// A line for each method.
    fn lines(&self) -> Vec<String> {
        let [hulls, vertices, error, iou] = figures(&self.ours);
        let ours =
            format!("Hullwright: {hulls} hulls, {vertices} vertices, error {error}, IoU {iou}.");
        let vhacd = self.vhacd.as_ref();
        let vhacd = vhacd.map(|vhacd| format!("V-HACD: {}.", figures(vhacd).join(", ")));
        [ours].into_iter().chain(vhacd).collect()
    }
}

/// Hulls, vertices, error and intersection over union.
fn figures(of: &Measurement) -> [String; 4] {
    let iou = of.iou.map_or_else(|| "–".into(), percent);
    [of.hulls.to_string(), of.vertices.to_string(), percent(of.hausdorff), iou]
}

fn vhacd_hulls(mesh: MeshView<'_>) -> Vec<Hull> {
    let parameters = vhacd::parameters(&Run::VHACD_DEFAULT);
    parameters.map_or_else(Vec::new, |parameters| hulls_of(&vhacd::decompose(mesh, &parameters)))
}

fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

/// Plain letters: the name is part of an address.
fn file_name(name: &str) -> String {
    let plain = name.to_lowercase().replace('ö', "o");
    plain.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect()
}

type Parts = [(&'static str, Vec<Entry>); 2];

fn markdown(parts: &Parts) -> String {
    let how =
        format!("`cargo lab gallery` made this page, with algorithm version {ALGORITHM_VERSION}.");
    let mut text = format!("# Gallery\n\n{INTRODUCTION}\n\n{how}\n");
    for (title, entries) in parts {
        text += &format!("\n## {title}\n");
        for entry in entries {
            let Entry { name, words, picture, triangles, .. } = entry;
            text += &format!("\n### {name}\n\n{words} {triangles} triangles.\n\n");
            text += &format!("![{name}]({picture})\n\n");
            text += &format!("{}\n", entry.lines().join("  \n"));
        }
    }
    text
}
