//! `hullwright view`: a page to look at a mesh and its hulls from all sides.

use std::path::{Path, PathBuf};
use std::time::Instant;

use hullwright::io::{MeshFile, read_hulls, read_mesh};
use hullwright::viewer::{HullSet, Page, hulls_of};
use hullwright::{Control, Decomposition, Hull, MergeTree, Method, MethodReport};

use crate::arguments::{Chosen, ParameterArguments, ThreadArguments, mesh_help, parse_method};
use crate::output::{Failure, print, time};
use crate::progress::{LateBar, waiting};

/// Write a page that shows a mesh and its hulls, and opens in any browser
///
/// One HTML file that loads nothing: the mesh, its hulls, a slider from all hulls down to one, errors
/// as colours, other methods or other tools' hulls side by side. Press ? on the page for its keys.
#[derive(clap::Args)]
pub struct Arguments {
    #[arg(help = mesh_help())]
    mesh: PathBuf,

    /// Write the page to this file. Default: named after the mesh, in the current folder
    #[arg(short, long, value_name = "PAGE")]
    output: Option<PathBuf>,

    /// Open the page in the default browser
    #[arg(long)]
    open: bool,

    /// Show another method side by side: surface (the paper's) or bounded; may be repeated
    #[arg(long, value_name = "METHOD", value_parser = parse_method)]
    compare: Vec<Method>,

    /// Show the hulls of any tool side by side: a .hulls file, or one per object of the file: obj, stl,
    /// gltf or glb; may be repeated
    #[arg(long, value_name = "FILE")]
    hulls: Vec<PathBuf>,

    /// No slider: hulls are not joined, which takes long for many hundreds of them
    #[arg(long)]
    no_merge: bool,

    #[command(flatten)]
    threads: ThreadArguments,

    #[command(flatten)]
    parameters: ParameterArguments,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let chosen = arguments.parameters.checked()?;
    let output = output(arguments)?;
    let file = waiting("reading", || read_mesh(&arguments.mesh))?;
    // All files first, so that a misspelt name ends the work before it begins.
    let mut others = Vec::new();
    for path in &arguments.hulls {
        others.push(Other::read(path)?);
    }
    let pool = arguments.threads.pool()?;
    let bar = LateBar::start();
    let control = bar.control().with_parallel(arguments.threads.is_parallel());
    let work = Work { arguments, file: &file, chosen: &chosen, control: &control };
    let page = pool.install(|| work.page(&others));
    bar.finish();
    let (page, summary) = page.map_err(|error| format!("{}: {error}", arguments.mesh.display()))?;
    waiting("writing", || page.write(&output))?;
    print(&format!("wrote {}: {summary}", output.display()))?;
    if arguments.open {
        open::that_detached(&output)
            .map_err(|error| format!("{}: no browser opens it: {error}", output.display()))?;
    }
    Ok(())
}

/// Where the page goes, if there is such a folder.
fn output(arguments: &Arguments) -> Result<PathBuf, Failure> {
    let default = || PathBuf::from(file_name(&arguments.mesh)).with_extension("html");
    let output = arguments.output.clone().unwrap_or_else(default);
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

/// Hulls of some tool.
struct Other {
    name: String,
    hulls: Vec<Hull>,
    /// How many of the file's can't be used.
    left_out: usize,
}

impl Other {
    fn read(path: &Path) -> Result<Self, Failure> {
        let named = waiting("reading", || read_hulls(path))?;
        let hulls = hulls_of(&named);
        if hulls.is_empty() {
            return Err(format!("{}: none of its hulls can be used", path.display()).into());
        }
        Ok(Self { name: file_name(path), left_out: named.len() - hulls.len(), hulls })
    }
}

/// What a page is made of.
struct Work<'a> {
    arguments: &'a Arguments,
    file: &'a MeshFile,
    chosen: &'a Chosen,
    control: &'a Control,
}

impl<'a> Work<'a> {
    /// The page, and what is on it in words.
    fn page(&self, others: &[Other]) -> Result<(Page<'a>, String), hullwright::Error> {
        let &Self { arguments, file, chosen, control } = self;
        let page = Page::new(file_name(&arguments.mesh), file, &chosen.solid(), control)?;
        let mut page = page.objects(&file.objects);
        let mut summary = Vec::new();
        let others_of_ours = arguments.compare.iter().map(|method| chosen.like(method));
        for method in std::iter::once(chosen.method.clone()).chain(others_of_ours) {
            let (result, seconds) = self.decompose(&method)?;
            let name = match &method {
                Method::Bounded(parameters) => format!("bounded, {}", parameters.max_error),
                _ => method.name().to_owned(),
            };
            summary.push(format!("{name}: {}", hulls(result.hulls.len())));
            let tree = match (arguments.no_merge, method == chosen.method) {
                (true, _) => None,
                (false, true) => Some(MergeTree::new(file, &result, &chosen.solid(), control)?),
                (false, false) => self.tree_of(&result.hulls)?,
            };
            let set = HullSet::new(name, &result.hulls).fact("time", time(seconds));
            page.add(with_tree(set, tree.as_ref()), control)?;
        }
        for Other { name, hulls: other, left_out } in others {
            summary.push(format!("{name}: {}", hulls(other.len())));
            let tree = self.tree_of(other)?;
            let mut set = HullSet::new(name, other);
            if *left_out > 0 {
                set = set.fact("left out as unusable:", left_out.to_string());
            }
            page.add(with_tree(set, tree.as_ref()), control)?;
        }
        Ok((page, summary.join(", ")))
    }

    fn decompose(
        &self,
        method: &Method,
    ) -> Result<(Decomposition<MethodReport>, f64), hullwright::Error> {
        let start = Instant::now();
        let result = method.decompose(self.file, self.control)?;
        Ok((result, start.elapsed().as_secs_f64()))
    }

    /// The joins of hulls that the main method did not make.
    fn tree_of(&self, hulls: &[Hull]) -> Result<Option<MergeTree>, hullwright::Error> {
        if self.arguments.no_merge {
            return Ok(None);
        }
        MergeTree::from_hulls(self.file, hulls, &self.chosen.solid(), self.control).map(Some)
    }
}

fn with_tree<'a>(set: HullSet<'a>, tree: Option<&'a MergeTree>) -> HullSet<'a> {
    match tree {
        Some(tree) => set.tree(tree),
        None => set,
    }
}

fn hulls(number: usize) -> String {
    crate::output::count(number, "hull", "hulls")
}
