//! `hullwright view`: a page to look at a mesh and its hulls from all sides, or at what it is after
//! simplification; or a picture of both.

use std::path::{Path, PathBuf};
use std::time::Instant;

use hullwright::hulls_format::VerifiedErrors;
use hullwright::inspect::inspect;
use hullwright::measure::{MeasureOptions, verify};
use hullwright::{
    Control, Error, Hull, MergeTree, Method, Parameters, SimplifyParameters, least_hulls,
};
use hullwright_cli::render::{Layout, Panel, Picture, render_with};
use hullwright_cli::terminal::{Failure, count, print, time};
use hullwright_cli::viewer::{HullSet, Page, hulls_of};
use hullwright_formats::{MeshFile, read_hulls, write_file};

use crate::arguments::{
    Chosen, ParameterArguments, ThreadArguments, Uses, mesh_help, parse_method,
};
use crate::notes::read_with_warnings;
use crate::progress::{LateBar, waiting};
use crate::view_simplified::{Before, DEFAULT_BOUND};

/// Write a page, or a picture, that shows a mesh and its hulls
#[derive(clap::Args)]
#[command(
    after_help = "The page is one HTML file that opens in any browser and loads nothing: the mesh, its hulls, \
    a slider from all hulls down to one, errors as colours, other methods or other tools' hulls side by \
    side. Press ? on the page for its keys. A picture has the mesh, its hulls, and the hulls moved apart; \
    a row for each method or tool. With --simplified both show the triangles before and after."
)]
pub struct Arguments {
    #[arg(help = mesh_help())]
    mesh: PathBuf,

    /// Write to this file: .html for a page, .png for a picture. Default: a page in the current
    /// folder, named after the mesh
    #[arg(short, long, value_name = "PAGE")]
    output: Option<PathBuf>,

    /// Open the page in the default browser, or the picture in its viewer
    #[arg(long)]
    open: bool,

    /// Show another method too: bounded, surface (the paper's) or hull; may be repeated
    #[arg(long, value_name = "METHOD", value_parser = parse_method)]
    compare: Vec<Method>,

    /// Show the hulls of any tool too: a .hulls file, or one per object of the file: obj, stl, gltf
    /// or glb; may be repeated
    #[arg(long, value_name = "FILE")]
    hulls: Vec<PathBuf>,

    /// Show the mesh before and after simplification, within --max-error, 0.5% (default); or with
    /// =FILE before and after any tool
    #[arg(
        long,
        value_name = "FILE",
        num_args = 0..=1,
        require_equals = true,
        conflicts_with_all = ["compare", "hulls", "no_merge"]
    )]
    simplified: Option<Option<PathBuf>>,

    /// With --simplified: keep triangles that nothing can touch
    #[arg(long, requires = "simplified")]
    keep_hidden: bool,

    /// Say how few hulls are possible with the errors of those shown, as a lower bound: a second or
    /// two each
    #[arg(long, conflicts_with = "simplified")]
    least: bool,

    /// No slider: hulls are not joined, which takes long for many hundreds of them
    #[arg(long)]
    no_merge: bool,

    #[command(flatten)]
    threads: ThreadArguments,

    #[command(flatten)]
    parameters: ParameterArguments,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if let Some(other) = &arguments.simplified {
        return show_simplified(arguments, other.as_deref());
    }
    let uses = Uses { others: &arguments.compare, bound: true };
    let chosen = arguments.parameters.checked(&uses)?;
    let output = output(arguments)?;
    let file = read_with_warnings(&arguments.mesh)?;
    // All files first, so that a misspelt name ends the work before it begins.
    let mut others = Vec::new();
    for path in &arguments.hulls {
        others.push(Shown::read(path)?);
    }
    let pool = arguments.threads.pool()?;
    let bar = LateBar::start();
    let control = bar.control().with_parallel(arguments.threads.is_parallel());
    let is_picture = is_picture(&output);
    let merges = !arguments.no_merge && !is_picture;
    let least = arguments.least;
    let work = Work { file: &file, chosen: &chosen, merges, least, control: &control };
    let drawn = pool.install(|| {
        let sets = work.sets(&arguments.compare, others)?;
        let drawn = match is_picture {
            true => work.picture(&sets)?.to_png(),
            false => {
                work.page(file_name(&arguments.mesh), &sets)?.to_html().map(String::into_bytes)
            }
        };
        Ok::<_, Error>((drawn?, sets))
    });
    bar.finish();
    let (drawn, sets) = drawn.map_err(|error| format!("{}: {error}", arguments.mesh.display()))?;
    waiting("writing", || write_file(&output, &drawn))?;
    let hulls = |set: &Shown| {
        let least = set
            .least
            .map_or_else(String::new, |least| format!(" ({least} at least for its errors)"));
        format!("{}: {}{least}", set.name, count(set.hulls.len(), "hull", "hulls"))
    };
    let summary: Vec<String> = sets.iter().map(hulls).collect();
    print(&format!("wrote {}: {}", output.display(), summary.join(", ")))?;
    for set in &sets {
        if let Some(line) = &set.exceeded_bound {
            print(&format!("{}: {line}", set.name))?;
        }
    }
    open_written(arguments, &output)
}

/// Opens what was written, under `--open`.
fn open_written(arguments: &Arguments, output: &Path) -> Result<(), Failure> {
    if arguments.open {
        open::that_detached(output)
            .map_err(|error| format!("{}: nothing opens it: {error}", output.display()))?;
    }
    Ok(())
}

/// The mesh before and after simplification, or beside a file of any tool.
fn show_simplified(arguments: &Arguments, other: Option<&Path>) -> Result<(), Failure> {
    let (bound, up) = arguments.parameters.of_surface()?;
    let parameters = SimplifyParameters::new(bound.unwrap_or(DEFAULT_BOUND))
        .with_keep_hidden(arguments.keep_hidden);
    parameters.validate().map_err(|error| Failure::Usage(error.to_string()))?;
    let output = output(arguments)?;
    let file = read_with_warnings(&arguments.mesh)?;
    let result = other.map(read_with_warnings).transpose()?;
    let before = Before { title: file_name(&arguments.mesh), file: &file, parameters, up };
    let pool = arguments.threads.pool()?;
    let bar = LateBar::start();
    let control = bar.control().with_parallel(arguments.threads.is_parallel());
    let drawn = pool.install(|| {
        let after = match (other, result) {
            (Some(path), Some(result)) => before.compared(path, result.mesh)?,
            _ => before.simplified(&control)?,
        };
        let drawn = match is_picture(&output) {
            true => before.picture(&after)?.to_png()?,
            false => before.page(&after, &control)?.into_bytes(),
        };
        Ok::<_, Error>((drawn, after.summary(&file)))
    });
    bar.finish();
    let (drawn, summary) = drawn.map_err(|error| {
        let path = other.filter(|_| inspect(&file).is_ok()).unwrap_or(&arguments.mesh);
        format!("{}: {error}", path.display())
    })?;
    waiting("writing", || write_file(&output, &drawn))?;
    print(&format!("wrote {}: {summary}", output.display()))?;
    open_written(arguments, &output)
}

fn is_picture(output: &Path) -> bool {
    output.extension().is_some_and(|suffix| suffix.eq_ignore_ascii_case("png"))
}

/// Where it goes, if there is such a folder.
fn output(arguments: &Arguments) -> Result<PathBuf, Failure> {
    let default = || PathBuf::from(file_name(&arguments.mesh)).with_extension("html");
    let output = arguments.output.clone().unwrap_or_else(default);
    let suffix = output.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    if !["html", "htm", "png"].contains(&&*suffix) {
        return Err(Failure::Usage(format!("{}: its suffix is not html or png", output.display())));
    }
    match output.parent() {
        Some(folder) if folder != Path::new("") && !folder.is_dir() => {
            Err(format!("{}: there is no such folder", folder.display()).into())
        }
        _ => Ok(output),
    }
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// Hulls of a method, or of some tool.
struct Shown {
    name: String,
    hulls: Vec<Hull>,
    tree: Option<MergeTree>,
    fact: Option<(&'static str, String)>,
    /// Both errors, where the method verifies them.
    errors: Option<VerifiedErrors>,
    /// How few hulls are possible.
    least: Option<usize>,
    exceeded_bound: Option<String>,
}

impl Shown {
    /// Hulls of a file, as far as they can be used.
    fn read(path: &Path) -> Result<Self, Failure> {
        let named = waiting("reading", || read_hulls(path))?;
        let hulls = hulls_of(&named);
        if hulls.is_empty() {
            return Err(format!("{}: none of its hulls can be used", path.display()).into());
        }
        let left_out = named.len() - hulls.len();
        let fact = (left_out > 0).then(|| ("left out as unusable:", left_out.to_string()));
        let name = file_name(path);
        let (tree, errors, least, exceeded_bound) = (None, None, None, None);
        Ok(Self { name, hulls, tree, fact, errors, least, exceeded_bound })
    }

    /// How few hulls are possible with errors like these, which are verified if they are not.
    fn least(
        &self,
        file: &MeshFile,
        solid: &Parameters,
        control: &Control,
    ) -> Result<usize, Error> {
        let errors = match self.errors {
            Some(errors) => errors,
            None => verify(file, &self.hulls, &MeasureOptions::from(solid), control)?.in_units(),
        };
        Ok(least_hulls(file, errors, solid, control)?.hulls)
    }
}

/// Pixels of a picture's panel, where there are few rows.
const PANEL: usize = 500;

/// Panels in a row: the mesh, its hulls, its hulls moved apart.
const COLUMNS: usize = 3;

/// Most pixels of a picture from top to bottom.
const HIGHEST: usize = 4096;

/// How far hulls move away from the centre, as a fraction of their distance.
const EXPLOSION: f64 = 0.5;

/// What a page or a picture is made of.
struct Work<'a> {
    file: &'a MeshFile,
    chosen: &'a Chosen,
    /// Whether hulls are joined down to one.
    merges: bool,
    /// Whether the least possible number of hulls is looked for.
    least: bool,
    control: &'a Control,
}

impl<'a> Work<'a> {
    /// The hulls of the chosen method, of others, and of files.
    fn sets(&self, others: &[Method], files: Vec<Shown>) -> Result<Vec<Shown>, Error> {
        let &Self { file, chosen, merges, least, control } = self;
        let solid = chosen.solid();
        let main = std::iter::once(chosen.method.clone());
        let mut sets = Vec::new();
        for method in main.chain(others.iter().map(|method| chosen.like(method))) {
            let start = Instant::now();
            let result = method.decompose(file, control)?;
            let seconds = start.elapsed().as_secs_f64();
            let name = match &method {
                Method::Bounded(parameters) => format!("bounded, {}", parameters.max_error),
                _ => method.name().to_owned(),
            };
            let tree = match merges && method == chosen.method {
                true => Some(MergeTree::new(file, &result, &solid, control)?),
                false => None,
            };
            let fact = Some(("time", time(seconds)));
            let exceeded_bound = result.exceeded_bound();
            let errors = result.report.bounded().map(|report| {
                // None of the method's results under this bound may have fewer.
                let protrusion = report.protrusion_max.max(report.bound);
                VerifiedErrors::new(protrusion, report.uncovered_max)
            });
            let hulls = result.hulls;
            sets.push(Shown { name, hulls, tree, fact, errors, least: None, exceeded_bound });
        }
        sets.extend(files);
        if least {
            for set in &mut sets {
                set.least = Some(set.least(file, &solid, control)?);
            }
        }
        for set in sets.iter_mut().filter(|set| merges && set.tree.is_none()) {
            set.tree = Some(MergeTree::from_hulls(file, &set.hulls, &solid, control)?);
        }
        Ok(sets)
    }

    fn page(&self, title: String, sets: &[Shown]) -> Result<Page<'a>, Error> {
        let page = Page::new(title, self.file, &self.chosen.solid(), self.control)?;
        let mut page = page.objects(&self.file.objects);
        for Shown { name, hulls, tree, fact, least, .. } in sets {
            let mut set = HullSet::new(name, hulls);
            if let Some(tree) = tree {
                set = set.tree(tree);
            }
            if let Some((name, value)) = fact {
                set = set.fact(*name, value);
            }
            if let Some(least) = least {
                // It is about all hulls of the set, wherever the slider stands.
                let needed = format!("at least {}", count(*least, "hull", "hulls"));
                set = set.fact("needed for all hulls' errors", needed);
            }
            page.add(set, self.control)?;
        }
        Ok(page)
    }

    fn picture(&self, sets: &[Shown]) -> Result<Picture, Error> {
        let row = |Shown { hulls, .. }: &Shown| {
            [Panel::mesh(self.file), Panel::hulls(hulls), Panel::hulls(hulls).exploded(EXPLOSION)]
        };
        let panels: Vec<Panel> = sets.iter().flat_map(row).collect();
        let rows = sets.len().max(1);
        let side = PANEL.min(HIGHEST / rows).max(1);
        let mut layout = Layout::default();
        layout.columns = Some(COLUMNS);
        layout.view.up = self.chosen.solid().up_axis;
        render_with(&panels, COLUMNS * side, rows * side, &layout)
    }
}
