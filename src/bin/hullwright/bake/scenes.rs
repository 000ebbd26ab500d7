//! `hullwright bake`: each scene into a `.hullscene` file.

use std::collections::HashSet;
use std::path::PathBuf;

use hullwright::bake::{BakeJob, BakeOptions, bake_jobs};
use hullwright::hulls_format::{HullScene, MeshHash, SceneLookup};
use hullwright::io::read_scene;
use hullwright::{Control, Method};

use super::{Arguments, Source, make_directory, output_of, report};
use crate::hulls::vertices;
use crate::output::{Failure, count};
use crate::progress::LateBar;

/// The suffix of a baked scene.
const SUFFIX: &str = "hullscene";

struct Scene<'a> {
    source: &'a Source,
    jobs: Vec<BakeJob>,
    output: PathBuf,
}

pub fn run(arguments: &Arguments, sources: &[Source], method: &Method) -> Result<(), Failure> {
    let options = BakeOptions::new(method.clone()).tagged_only(arguments.tagged_only);
    let scenes = scenes(arguments, sources, &options)?;
    let pool = arguments.threads.pool()?;
    let bar = LateBar::start();
    let parts = scenes.iter().map(|scene| scene.jobs.len()).sum();
    let (mut lines, mut failures) = (Vec::new(), Vec::new());
    let mut done = 0;
    for scene in &scenes {
        let control = |index: usize| {
            let control = bar.control_of_part(done + index, parts);
            control.with_parallel(arguments.threads.is_parallel())
        };
        match pool.install(|| bake(scene, control, &mut failures)) {
            Ok(line) => lines.push(line),
            Err(reason) => failures.push(reason),
        }
        done += scene.jobs.len();
    }
    bar.finish();
    report(&lines, failures)
}

/// Reads all files, so that a misspelt name ends the work before it begins.
fn scenes<'a>(
    arguments: &Arguments,
    sources: &'a [Source],
    options: &BakeOptions,
) -> Result<Vec<Scene<'a>>, Failure> {
    let mut outputs = HashSet::new();
    let mut scenes = Vec::new();
    for source in sources {
        let meshes = read_scene(&source.path)?;
        if meshes.is_empty() {
            return Err(format!("{}: it holds no triangles", source.path.display()).into());
        }
        let name = source.path.with_extension(SUFFIX);
        let name = name.file_name().unwrap_or_default().to_string_lossy();
        let output = output_of(arguments, source, &name);
        if !outputs.insert(output.clone()) {
            let reason = format!("two scenes would be written to {}", output.display());
            return Err(Failure::Usage(reason));
        }
        scenes.push(Scene { source, jobs: bake_jobs(meshes, options), output });
    }
    Ok(scenes)
}

fn bake(
    scene: &Scene<'_>,
    control: impl Fn(usize) -> Control,
    failures: &mut Vec<String>,
) -> Result<String, String> {
    let Scene { source, jobs, output } = scene;
    // One that can't be read is replaced.
    let earlier = HullScene::read(output).ok();
    let mut meshes = Vec::new();
    let mut kept = 0;
    for (index, job) in jobs.iter().enumerate() {
        let known = earlier.as_ref().and_then(|earlier| {
            match earlier.look_up(MeshHash::of(&job.mesh), &job.parameters, &[]) {
                SceneLookup::Found(baked) if baked.names == job.names => Some(baked.clone()),
                _ => None,
            }
        });
        kept += usize::from(known.is_some());
        match known.map_or_else(|| job.run(&control(index)), Ok) {
            Ok(baked) => meshes.push(baked),
            Err(error) => {
                let name = job.names.first().map_or("", String::as_str);
                failures.push(format!("{}, mesh `{name}`: {error}", source.path.display()));
            }
        }
    }
    let name = source.path.file_stem().unwrap_or_default().to_string_lossy();
    let baked = HullScene::new(name, meshes);
    make_directory(output)?;
    baked.write(output).map_err(|error| error.to_string())?;
    Ok(wrote(scene, &baked, kept))
}

fn wrote(scene: &Scene<'_>, baked: &HullScene, kept: usize) -> String {
    let hulls: usize = baked.meshes.iter().map(|baked| baked.hulls.hulls.len()).sum();
    let vertices: usize = baked.meshes.iter().map(|baked| vertices(&baked.hulls.hulls)).sum();
    let as_before = match kept {
        0 => String::new(),
        kept => format!(" ({kept} as before)"),
    };
    format!(
        "wrote {}: {}{as_before}, {}, {}",
        scene.output.display(),
        count(baked.meshes.len(), "mesh", "meshes"),
        count(hulls, "hull", "hulls"),
        count(vertices, "vertex", "vertices")
    )
}
