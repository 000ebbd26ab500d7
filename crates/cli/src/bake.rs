//! `hullwright bake`: scenes and meshes into files that a game loads instead of decomposing.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use hullwright::hulls_format::{BakedTriangles, HullScene, HullsFile, MeshHash, SceneLookup};
use hullwright::{Control, Error, Method};
use hullwright_cli::terminal::{Failure, count, print, print_error, print_warning};
use hullwright_formats::bake::{
    BakeJob, BakeOptions, bake_jobs, bake_triangles, extras_complaints,
};
use hullwright_formats::bake_surfaces::{SurfaceJob, surface_jobs};
use hullwright_formats::gltf_hulls::{EditedHulls, FoundHulls, HullForm, HullsInFile, MeshHulls};
use hullwright_formats::{Format, SceneMesh, read_scene, write_file};

use crate::arguments::{ParameterArguments, SCENE_SUFFIX, ThreadArguments, Uses};
use crate::decompose::{DEFAULT_DENSITY, hulls_file, wrote};
use crate::notes;
use crate::progress::LateBar;
use crate::report::vertices;

/// Bake scenes into .hullscene files: the hulls of every mesh, with errors and mass
#[derive(clap::Args)]
#[command(
    after_help = "One file per scene, named after it: each mesh in the space that it was modelled in (no \
    node's transform is applied), all its primitives together, known by its content. Names and extras \
    are followed as the Bevy plugin's `ConvexDecompositionHierarchy` follows them. What an earlier file \
    holds of the same content and parameters is kept. Of a folder, all glTF and GLB files below it; what \
    can't be baked is named at the end, and the rest is baked. With --into hulls go into the glTF or GLB \
    file itself, below the nodes that show the meshes; those that were edited by hand stay."
)]
pub struct Arguments {
    #[arg(help = format!("The scenes: {}, or folders", Format::suffix_list()), required = true, value_name = "SCENE")]
    scenes: Vec<PathBuf>,

    /// The directory that gets the files; it is made if it does not exist. Default: beside each
    /// scene
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,

    /// A .hulls file for each mesh, named after it, instead of one file per scene. Names and extras
    /// are ignored
    #[arg(long)]
    per_mesh: bool,

    /// Writes the hulls back into each glTF or GLB file, or with -o into a file of its name there:
    /// as colliders (KHR_physics_rigid_bodies), or with =ucx as meshes with Unreal's names
    #[arg(
        long,
        value_name = "FORM",
        value_enum,
        num_args = 0..=1,
        require_equals = true,
        hide_possible_values = true,
        default_missing_value = "physics",
        conflicts_with_all = ["per_mesh", "triangles"]
    )]
    into: Option<IntoForm>,

    /// Only meshes with an artist's name or extra, as `ConvexDecompositionHierarchy::tagged_only`
    #[arg(long, conflicts_with = "per_mesh")]
    tagged_only: bool,

    /// Also triangles of meshes, for what never moves. The plugin takes them from the file where a
    /// mesh is on the GPU only
    #[arg(long, conflicts_with = "per_mesh")]
    triangles: bool,

    /// What never moves, within this bound: 0.02m
    #[arg(long, value_name = "LENGTH", value_parser = parse_units, allow_hyphen_values = true,
        conflicts_with_all = ["per_mesh", "into"])]
    level_bound: Option<f32>,

    /// What never moves, by cells of this side: 10m
    #[arg(long, value_name = "LENGTH", value_parser = parse_units, allow_hyphen_values = true,
        conflicts_with_all = ["per_mesh", "into"])]
    cell_size: Option<f32>,

    /// Mass per cubed unit, with --per-mesh; in a scene the plugin's tags set it. Default: 1
    #[arg(long, value_name = "DENSITY", requires = "per_mesh", allow_negative_numbers = true)]
    density: Option<f64>,

    #[command(flatten)]
    threads: ThreadArguments,

    #[command(flatten)]
    parameters: ParameterArguments,
}

/// A positive length in the scene's unit, `0.02m` or `0.02`.
fn parse_units(text: &str) -> Result<f32, String> {
    let number = text.strip_suffix('m').unwrap_or(text).parse().ok();
    let number = number.filter(|x: &f32| x.is_finite() && *x > 0.0);
    number.ok_or_else(|| "a length is a positive number, such as 0.02m".into())
}

// With a line for each value all of the help would be twice as long.
/// How hulls stand in the file of their meshes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum IntoForm {
    Physics,
    Ucx,
}

/// A file to be baked.
struct InputFile {
    path: PathBuf,
    /// From the folder that was named to the one that the file is in.
    below: PathBuf,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let method = arguments.parameters.checked(&Uses::default())?.method;
    let (mut inputs, mut results) = (Vec::new(), Results::default());
    for path in &arguments.scenes {
        if !path.is_dir() {
            inputs.push(InputFile { path: path.clone(), below: PathBuf::new() });
            continue;
        }
        let before = inputs.len();
        match add_folder(path, Path::new(""), &mut inputs) {
            Err(reason) => results.failures.push(reason),
            Ok(()) if inputs.len() == before => {
                let reason = "there is no glTF or GLB file in it";
                results.failures.push(format!("{}: {reason}", path.display()));
            }
            Ok(()) => {}
        }
    }
    match (arguments.per_mesh, arguments.into) {
        (true, _) => bake_meshes(arguments, &inputs, &method, &mut results)?,
        (false, None) => bake_scenes(arguments, &inputs, &method, &mut results)?,
        (false, Some(form)) => {
            let form = match form {
                IntoForm::Physics => HullForm::Physics,
                IntoForm::Ucx => HullForm::Ucx,
            };
            bake_into(arguments, &inputs, (&method, form), &mut results)?;
        }
    }
    results.report()
}

/// What was done, and what could not be. One bad file of many does not end the work.
#[derive(Default)]
struct Results {
    lines: Vec<String>,
    failures: Vec<String>,
}

impl Results {
    /// Keeps what succeeded.
    fn keep<T>(&mut self, result: Result<T, String>) -> Option<T> {
        result.map_err(|reason| self.failures.push(reason)).ok()
    }

    /// Lines to standard output, then failures: all but the last here, the last as the program's
    /// own error.
    fn report(mut self) -> Result<(), Failure> {
        if !self.lines.is_empty() {
            print(&self.lines.join("\n"))?;
        }
        let last = self.failures.pop();
        self.failures.iter().for_each(|reason| print_error(reason));
        last.map_or(Ok(()), |reason| Err(Failure::Work(reason)))
    }
}

/// In the order of names, so that the same folder gives the same lines everywhere.
fn add_folder(folder: &Path, below: &Path, inputs: &mut Vec<InputFile>) -> Result<(), String> {
    let failure = |error: std::io::Error| format!("{}: {error}", folder.display());
    let entries = std::fs::read_dir(folder).map_err(failure)?;
    let mut paths =
        entries.map(|entry| Ok(entry?.path())).collect::<Result<Vec<_>, _>>().map_err(failure)?;
    paths.sort();
    for path in paths {
        // A link to a folder above would never end.
        if path.is_dir() && !path.is_symlink() {
            let name = path.file_name().unwrap_or_default();
            add_folder(&path, &below.join(name), inputs)?;
        } else if Format::from_path(&path) == Some(Format::Gltf) {
            inputs.push(InputFile { path, below: below.to_owned() });
        }
    }
    Ok(())
}

/// Where a file made of an input goes: beside it, or into the directory that was named, where
/// folders keep their structure.
fn output_of(arguments: &Arguments, input: &InputFile, name: &str) -> PathBuf {
    match &arguments.output {
        Some(directory) => directory.join(&input.below).join(name),
        None => input.path.with_file_name(name),
    }
}

fn make_directory(output: &Path) -> Result<(), String> {
    let Some(directory) = output.parent() else { return Ok(()) };
    std::fs::create_dir_all(directory).map_err(|error| format!("{}: {error}", directory.display()))
}

/// A scene, and what is to be done for it.
struct Scene<'a> {
    input: &'a InputFile,
    jobs: Vec<BakeJob>,
    triangles: Vec<BakedTriangles>,
    surfaces: Vec<SurfaceJob>,
    output: PathBuf,
}

impl Scene<'_> {
    fn parts(&self) -> usize {
        self.jobs.len() + self.surfaces.len()
    }
}

/// Each scene into a `.hullscene` file.
fn bake_scenes(
    arguments: &Arguments,
    inputs: &[InputFile],
    method: &Method,
    results: &mut Results,
) -> Result<(), Failure> {
    let options = BakeOptions::new(method.clone())
        .with_tagged_only(arguments.tagged_only)
        .with_triangles(arguments.triangles)
        .with_surfaces(arguments.level_bound.unwrap_or_default(), arguments.cell_size);
    let scenes = scenes(arguments, inputs, &options, results)?;
    let pool = arguments.threads.pool()?;
    let bar = LateBar::start();
    let parts = scenes.iter().map(Scene::parts).sum();
    let mut done = 0;
    for scene in &scenes {
        let control = |index: usize| {
            let control = bar.control_of_part(done + index, parts);
            control.with_parallel(arguments.threads.is_parallel())
        };
        pool.install(|| bake_scene(scene, control, results));
        done += scene.parts();
    }
    bar.finish();
    Ok(())
}

/// Reads all files that can be read.
fn scenes<'a>(
    arguments: &Arguments,
    inputs: &'a [InputFile],
    options: &BakeOptions,
    results: &mut Results,
) -> Result<Vec<Scene<'a>>, Failure> {
    let mut outputs = HashSet::new();
    let mut scenes = Vec::new();
    for input in inputs {
        let name = input.path.with_extension(SCENE_SUFFIX);
        let name = name.file_name().unwrap_or_default().to_string_lossy();
        let output = output_of(arguments, input, &name);
        if !outputs.insert(output.clone()) {
            let reason = format!("two scenes would be written to {}", output.display());
            return Err(Failure::Usage(reason));
        }
        if let Some(meshes) = results.keep(with_triangles(read_scene(&input.path), input)) {
            notes::warn(meshes.iter().flat_map(|mesh| &mesh.notes), &input.path);
            for complaint in extras_complaints(&meshes) {
                print_warning(&format!("{}, {complaint}", input.path.display()));
            }
            let triangles = bake_triangles(&meshes, options);
            let surfaces = surface_jobs(&meshes, options);
            let jobs = bake_jobs(meshes, options);
            scenes.push(Scene { input, jobs, triangles, surfaces, output });
        }
    }
    Ok(scenes)
}

/// What was read of an input, if there are triangles in it.
fn with_triangles(
    read: Result<Vec<SceneMesh>, Error>,
    input: &InputFile,
) -> Result<Vec<SceneMesh>, String> {
    match read {
        Err(error) => Err(error.to_string()),
        Ok(meshes) if meshes.is_empty() => {
            Err(format!("{}: it holds no triangles", input.path.display()))
        }
        Ok(meshes) => Ok(meshes),
    }
}

fn bake_scene(scene: &Scene<'_>, control: impl Fn(usize) -> Control, results: &mut Results) {
    let Scene { input, jobs, triangles, surfaces, output } = scene;
    // One that can't be read is replaced.
    let earlier = HullScene::read(output).ok();
    let mut meshes = Vec::new();
    let mut kept = 0;
    for (index, job) in jobs.iter().enumerate() {
        let known = earlier.as_ref().and_then(|earlier| {
            match earlier.look_up(MeshHash::of(&job.mesh), &job.parameters, &[]) {
                SceneLookup::Found(baked)
                    if baked.names == job.names
                        && baked.gltf_meshes == job.gltf_meshes
                        && baked.hulls.parts == job.parts.list =>
                {
                    Some(baked.clone())
                }
                _ => None,
            }
        });
        kept += usize::from(known.is_some());
        let baked = known.map_or_else(|| job.run(&control(index)), Ok).map_err(|error| {
            let name = job.names.first().map_or("", String::as_str);
            format!("{}, mesh `{name}`: {error}", input.path.display())
        });
        meshes.extend(results.keep(baked));
    }
    let mut made = Vec::new();
    for (index, job) in surfaces.iter().enumerate() {
        let surface = job.run(&control(jobs.len() + index));
        let surface = surface.map_err(|error| format!("{}: {error}", input.path.display()));
        made.extend(results.keep(surface));
    }
    let name = input.path.file_stem().unwrap_or_default().to_string_lossy();
    let baked = HullScene::new(name, meshes).with_triangles(triangles.clone()).with_surfaces(made);
    let written = make_directory(output)
        .and_then(|()| baked.to_bytes().map_err(|error| error.to_string()))
        .and_then(|bytes| write_file(output, &bytes).map_err(|error| error.to_string()));
    if results.keep(written).is_some() {
        results.lines.push(wrote_scene(scene, &baked, kept));
        let exceeded = baked.meshes.iter().filter_map(|baked| exceeded_bound(&baked.hulls));
        results.lines.extend(exceeded);
    }
}

/// Says by how much a mesh's hulls exceed their bound, and why.
fn exceeded_bound(file: &HullsFile) -> Option<String> {
    file.exceeded_bound().map(|line| format!("{}: {line}", file.name))
}

fn wrote_scene(scene: &Scene<'_>, baked: &HullScene, kept: usize) -> String {
    let hulls: usize = baked.meshes.iter().map(|baked| baked.hulls.hulls.len()).sum();
    let vertices: usize = baked.meshes.iter().map(|baked| vertices(&baked.hulls.hulls)).sum();
    let as_before = match kept {
        0 => String::new(),
        kept => format!(" ({kept} as before)"),
    };
    let triangles = match baked.triangles.iter().map(|of| of.triangles.len()).sum() {
        0 => String::new(),
        some => format!(", {}", count(some, "triangle", "triangles")),
    };
    let surfaces = match baked.surfaces.len() {
        0 => String::new(),
        some => {
            let before: usize = scene.surfaces.iter().map(|job| job.mesh.triangles.len()).sum();
            let after: usize = baked.surfaces.iter().map(|of| of.triangles.len()).sum();
            let some = count(some, "surface", "surfaces");
            format!(", {some} of {after} instead of {before} triangles")
        }
    };
    format!(
        "wrote {}: {}{as_before}, {}, {}{triangles}{surfaces}",
        scene.output.display(),
        count(baked.meshes.len(), "mesh", "meshes"),
        count(hulls, "hull", "hulls"),
        count(vertices, "vertex", "vertices")
    )
}

/// A file that gets the hulls of its meshes, and what it holds of them already.
struct IntoFile<'a> {
    input: &'a Path,
    jobs: Vec<(BakeJob, FoundHulls)>,
    file: HullsInFile,
    output: PathBuf,
}

/// Each scene's hulls into the file of the scene.
fn bake_into(
    arguments: &Arguments,
    inputs: &[InputFile],
    (method, form): (&Method, HullForm),
    results: &mut Results,
) -> Result<(), Failure> {
    let options =
        BakeOptions::new(method.clone()).with_tagged_only(arguments.tagged_only).with_written(true);
    let files = files_to_change(arguments, inputs, &options, results)?;
    let pool = arguments.threads.pool()?;
    let bar = LateBar::start();
    let parts = files.iter().map(|file| file.jobs.len()).sum();
    let mut done = 0;
    for file in files {
        let count = file.jobs.len();
        let control = |index: usize| {
            let control = bar.control_of_part(done + index, parts);
            control.with_parallel(arguments.threads.is_parallel())
        };
        pool.install(|| bake_into_file(file, form, control, results));
        done += count;
    }
    bar.finish();
    Ok(())
}

/// Reads all files that can be read, and says what of them stays without hulls.
fn files_to_change<'a>(
    arguments: &Arguments,
    inputs: &'a [InputFile],
    options: &BakeOptions,
    results: &mut Results,
) -> Result<Vec<IntoFile<'a>>, Failure> {
    let mut outputs = HashSet::new();
    let mut files = Vec::new();
    for input in inputs {
        let path = &input.path;
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let output = output_of(arguments, input, &name);
        if !outputs.insert(output.clone()) {
            let reason = format!("two scenes would be written to {}", output.display());
            return Err(Failure::Usage(reason));
        }
        if Format::from_path(path).is_some_and(|format| format != Format::Gltf) {
            let reason = "hulls can be written into glTF and GLB files only";
            results.failures.push(format!("{}: {reason}", path.display()));
            continue;
        }
        let Some(meshes) = results.keep(with_triangles(read_scene(path), input)) else { continue };
        let file = HullsInFile::read(path).map_err(|error| error.to_string());
        let Some(file) = results.keep(file) else { continue };
        notes::warn(meshes.iter().flat_map(|mesh| &mesh.notes), path);
        for complaint in extras_complaints(&meshes) {
            print_warning(&format!("{}, {complaint}", path.display()));
        }
        let jobs = bake_jobs(meshes, options).into_iter();
        let jobs: Vec<(BakeJob, FoundHulls)> = jobs
            .map(|job| {
                let found = file.found(&job);
                (job, found)
            })
            .collect();
        for (_, found) in &jobs {
            for node in &found.with_collider {
                let reason = "it has a collider or trigger of its own and gets no hulls";
                print_warning(&format!("{}, node `{node}`: {reason}", path.display()));
            }
            for edited in &found.edited {
                let (node, edited) = (&edited.node, edited_by_hand(edited));
                print_warning(&format!("{}, node `{node}`: {edited}", path.display()));
            }
        }
        if arguments.output.is_some()
            && let Some(other) = file.other_files().next()
        {
            let reason = format!("it names other files, such as {other}, which are not copied");
            print_warning(&format!("{}: {reason}", path.display()));
        }
        files.push(IntoFile { input: path, jobs, file, output });
    }
    Ok(files)
}

/// Says why hulls stay as they are, and what is wrong with them.
fn edited_by_hand(hulls: &EditedHulls) -> String {
    let mut said = match &hulls.read {
        Ok(_) => "its hulls were edited by hand: kept".to_owned(),
        Err(reason) => format!("its hulls are kept, though {reason}"),
    };
    if hulls.mesh_changed {
        said += ", but the mesh has changed since they were made";
    }
    for error in hulls.read.iter().flat_map(|read| &read.left_out) {
        said += &format!("; {error}");
    }
    said
}

fn bake_into_file(
    into: IntoFile<'_>,
    form: HullForm,
    control: impl Fn(usize) -> Control,
    results: &mut Results,
) {
    let IntoFile { input, jobs, file, output } = into;
    let mut written = WrittenInto::default();
    let mut meshes = Vec::new();
    for (index, (job, found)) in jobs.iter().enumerate() {
        let edited = found.edited.iter().filter_map(|edited| edited.read.as_ref().ok());
        let edited: Vec<&HullsFile> = edited.map(|read| &read.baked.hulls).collect();
        if found.open_nodes == 0 {
            written.add(&edited, found);
            continue;
        }
        let known = found.baked.clone().map(Ok);
        let baked = known.unwrap_or_else(|| job.run(&control(index))).map_err(|error| {
            let name = job.names.first().map_or("", String::as_str);
            format!("{}, mesh `{name}`: {error}", input.display())
        });
        if let Some(baked) = results.keep(baked) {
            written.add(&[&edited[..], &[&baked.hulls]].concat(), found);
            meshes.push(MeshHulls { nodes: &job.gltf_nodes, baked });
        }
    }
    let written_file = file.write(form, &meshes).map_err(|error| error.to_string());
    let written_file = written_file.and_then(|bytes| {
        // An unchanged file is not written again: that would make asset watchers reload it.
        if std::fs::read(&output).is_ok_and(|before| before == bytes) {
            return Ok(());
        }
        make_directory(&output)?;
        write_file(&output, &bytes).map_err(|error| error.to_string())
    });
    if results.keep(written_file).is_some() {
        results.lines.push(written.line(&output));
        results.lines.extend(written.exceeded);
    }
}

/// What was written into a file.
#[derive(Default)]
struct WrittenInto {
    meshes: usize,
    as_before: usize,
    edited: usize,
    hulls: usize,
    vertices: usize,
    exceeded: Vec<String>,
}

impl WrittenInto {
    /// Counts a mesh with its hulls, unless it has none.
    fn add(&mut self, files: &[&HullsFile], found: &FoundHulls) {
        let is_edited = !found.edited.is_empty();
        if files.is_empty() && !is_edited {
            return;
        }
        self.meshes += 1;
        self.as_before += usize::from(found.baked.is_some());
        self.edited += usize::from(is_edited);
        self.hulls += files.iter().map(|file| file.hulls.len()).sum::<usize>();
        self.vertices += files.iter().map(|file| vertices(&file.hulls)).sum::<usize>();
        self.exceeded.extend(files.iter().filter_map(|file| exceeded_bound(file)));
    }

    fn line(&self, output: &Path) -> String {
        let of_these = [(self.as_before, "as before"), (self.edited, "edited by hand")];
        let of_these: Vec<String> = of_these
            .iter()
            .filter(|(count, _)| *count > 0)
            .map(|(count, what)| format!("{count} {what}"))
            .collect();
        let of_these = match of_these[..] {
            [] => String::new(),
            _ => format!(" ({})", of_these.join(", ")),
        };
        format!(
            "wrote {}: {}{of_these}, {}, {}",
            output.display(),
            count(self.meshes, "mesh", "meshes"),
            count(self.hulls, "hull", "hulls"),
            count(self.vertices, "vertex", "vertices")
        )
    }
}

/// A file name longer than this is refused by some file systems, suffix and number included.
const LONGEST_NAME: usize = 200;

/// A mesh of its own.
struct MeshJob<'a> {
    input: &'a Path,
    mesh: SceneMesh,
    output: PathBuf,
}

/// Each mesh into a `.hulls` file of its own.
fn bake_meshes(
    arguments: &Arguments,
    inputs: &[InputFile],
    method: &Method,
    results: &mut Results,
) -> Result<(), Failure> {
    let density = arguments.density.unwrap_or(DEFAULT_DENSITY);
    if !(density.is_finite() && density > 0.0) {
        return Err(Failure::Usage(format!("the density must be positive, not {density}")));
    }
    let pool = arguments.threads.pool()?;
    let jobs = mesh_jobs(arguments, inputs, results);
    let bar = LateBar::start();
    for (index, job) in jobs.iter().enumerate() {
        let control = bar.control_of_part(index, jobs.len());
        let control = control.with_parallel(arguments.threads.is_parallel());
        let baked = pool.install(|| bake_mesh(job, density, method, &control)).map_err(|reason| {
            let MeshJob { input, mesh, .. } = job;
            format!("{}, mesh `{}`: {reason}", input.display(), mesh.name)
        });
        let lines = results.keep(baked).unwrap_or_default();
        results.lines.extend(lines);
    }
    bar.finish();
    Ok(())
}

/// Reads all files that can be read.
fn mesh_jobs<'a>(
    arguments: &Arguments,
    inputs: &'a [InputFile],
    results: &mut Results,
) -> Vec<MeshJob<'a>> {
    let mut names = HashSet::new();
    let mut jobs = Vec::new();
    for input in inputs {
        let meshes = results.keep(with_triangles(read_scene(&input.path), input));
        let meshes = meshes.unwrap_or_default();
        notes::warn(meshes.iter().flat_map(|mesh| &mesh.notes), &input.path);
        for mesh in meshes {
            let name = unique(&file_name(&mesh.name), &mut names);
            let output = output_of(arguments, input, &format!("{name}.hulls"));
            jobs.push(MeshJob { input: &input.path, mesh, output });
        }
    }
    jobs
}

/// The lines about what was written.
fn bake_mesh(
    job: &MeshJob<'_>,
    density: f64,
    method: &Method,
    control: &Control,
) -> Result<Vec<String>, String> {
    let SceneMesh { name, mesh, parts, .. } = &job.mesh;
    let decomposition = method.decompose(mesh, control).map_err(|error| error.to_string())?;
    let file = hulls_file(name.as_str(), mesh.view(), &decomposition, &method.solid(), density)
        .map_err(|error| error.to_string())?;
    let shares = parts.shares(mesh, &decomposition.hulls).map_err(|error| error.to_string())?;
    let file = file.with_parts(parts.list.clone(), shares);
    make_directory(&job.output)?;
    let bytes = file.to_bytes().map_err(|error| error.to_string())?;
    write_file(&job.output, &bytes).map_err(|error| error.to_string())?;
    let lines = [Some(wrote(&job.output, &file.hulls)), exceeded_bound(&file)];
    Ok(lines.into_iter().flatten().collect())
}

/// The name with what any file system may object to replaced.
fn file_name(name: &str) -> String {
    let is_harmless = |c: char| c.is_alphanumeric() || "-_. ()+".contains(c);
    let mut harmless = String::new();
    for c in name.chars() {
        let c = if is_harmless(c) { c } else { '_' };
        if harmless.len() + c.len_utf8() > LONGEST_NAME {
            break;
        }
        harmless.push(c);
    }
    let harmless = harmless.trim_matches([' ', '.']);
    if harmless.is_empty() { "mesh".into() } else { harmless.into() }
}

/// The name, with a number after it if it is taken. Upper and lower case are one to some file
/// systems.
fn unique(name: &str, taken: &mut HashSet<String>) -> String {
    let mut candidate = name.to_owned();
    let mut number = 1;
    while !taken.insert(candidate.to_lowercase()) {
        number += 1;
        candidate = format!("{name}_{number}");
    }
    candidate
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn file_names_are_harmless() {
        for (name, expected) in [
            ("Mug.001", "Mug.001"),
            ("../up/and\\away", "_up_and_away"),
            ("", "mesh"),
            ("..", "mesh"),
            ("Стул: 3?", "Стул_ 3_"),
        ] {
            assert_eq!(file_name(name), expected);
        }
        assert!(file_name(&"x".repeat(1000)).len() <= LONGEST_NAME);
    }

    #[test]
    fn names_are_used_once() {
        let mut taken = HashSet::new();
        let names = ["Cube", "cube", "Cube_2", "Cube"].map(|name| unique(name, &mut taken));
        assert_eq!(names, ["Cube", "cube_2", "Cube_2_2", "Cube_3"]);
    }
}
