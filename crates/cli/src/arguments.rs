//! The parameters of a decomposition as command line arguments.

use std::path::Path;

use hullwright::surface::SurfaceParameters;
use hullwright::{Length, Method, Openings, Parameters, Preset, UpAxis};
use hullwright_cli::terminal::Failure;
use hullwright_formats::Format;

/// Says which files an argument takes.
pub fn mesh_help() -> String {
    format!("The mesh: {}", Format::suffix_list())
}

/// How many threads work.
#[derive(clap::Args)]
pub struct ThreadArguments {
    /// Number of threads. Default: all processors
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS))]
    threads: Option<u16>,
}

/// More threads than any machine has, and few enough to be started.
const MOST_THREADS: i64 = 1024;

impl ThreadArguments {
    pub fn is_parallel(&self) -> bool {
        self.threads != Some(1)
    }

    /// A pool of so many threads, or of as many as there are processors.
    pub fn pool(&self) -> Result<rayon::ThreadPool, Failure> {
        let mut pool = rayon::ThreadPoolBuilder::new();
        if let Some(threads) = self.threads {
            pool = pool.num_threads(usize::from(threads));
        }
        Ok(pool.build().map_err(|error| format!("the threads can't be started: {error}"))?)
    }
}

/// How the solid of a mesh is seen.
#[derive(clap::Args)]
pub struct SolidArguments {
    /// What becomes of flat openings: auto (default), keep or close; as in `decompose`
    #[arg(long, value_name = "WHICH")]
    openings: Option<Openings>,

    /// The bound that hulls are made with, 2% (default) or 0.02m: an opening counts as flat within
    /// it
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true)]
    max_error: Option<Length>,

    /// Which axis points up, y (default) or z; as in `decompose`
    #[arg(long, value_name = "AXIS")]
    up_axis: Option<UpAxis>,
}

impl SolidArguments {
    /// What they say, if all values are in range.
    pub fn parameters(&self) -> Result<Parameters, Failure> {
        let mut parameters = Parameters::default();
        set(&mut parameters.openings, &self.openings);
        set(&mut parameters.max_error, &self.max_error);
        set(&mut parameters.up_axis, &self.up_axis);
        parameters.validate().map_err(|error| Failure::Usage(error.to_string()))?;
        Ok(parameters)
    }

    /// An error for each of them, where there is no solid.
    pub fn refuse(&self, reason: &str) -> Result<(), Failure> {
        let given = [
            ("openings", self.openings.is_some()),
            ("max-error", self.max_error.is_some()),
            ("up-axis", self.up_axis.is_some()),
        ];
        match given.iter().find(|(_, is_given)| *is_given) {
            Some((option, _)) => Err(Failure::Usage(format!("--{option} has no effect: {reason}"))),
            None => Ok(()),
        }
    }
}

/// Above the options of the paper's methods, which come last.
pub const SURFACE_HEADING: &str = "The paper's method (--method surface, or hacd), with defaults";

/// The parameters of a decomposition.
#[derive(clap::Args)]
#[command(next_help_heading = "Parameters")]
pub struct ParameterArguments {
    /// bounded (default), surface (the paper's), hacd or hull (that of all points)
    #[arg(long, value_name = "NAME", value_parser = parse_method)]
    method: Option<Method>,

    /// The bound: 2% (default) of the bounding-box diagonal, or 0.02m in the mesh's unit
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true)]
    max_error: Option<Length>,

    /// Limit on hulls, or none (default); may force them above the bound
    #[arg(long, value_name = "N", value_parser = parse_limit, allow_hyphen_values = true)]
    max_hulls: Option<Limit>,

    /// Limit on a hull's vertices: 64 (default), at least 8, or none
    #[arg(long, value_name = "N", value_parser = parse_limit, allow_hyphen_values = true)]
    max_vertices: Option<Limit>,

    /// fast: a fifth more hulls in two thirds of the time; balanced (default); fine: some fewer in
    /// three times the time
    #[arg(long, value_name = "NAME")]
    preset: Option<Preset>,

    /// Flat openings: auto (default) closes those that show only the backs of faces; keep; close
    #[arg(long, value_name = "WHICH")]
    openings: Option<Openings>,

    /// y (default) or z: the way up, for openings
    #[arg(long, value_name = "AXIS")]
    up_axis: Option<UpAxis>,

    /// Leave cavities empty whose mouths are narrower than twice the bound
    #[arg(long)]
    keep_cavities: bool,

    /// Fill what no ball of this radius can reach: 6% of the diagonal or 0.1m
    #[arg(long, value_name = "RADIUS", allow_hyphen_values = true)]
    probe_radius: Option<Length>,

    /// A point x,y,z where it starts too
    #[arg(long, value_name = "POINT", value_parser = parse_point, allow_hyphen_values = true)]
    probe_from: Vec<[f64; 3]>,

    #[command(flatten)]
    surface: SurfaceArguments,
}

/// Those of the paper's method.
#[derive(clap::Args)]
#[command(next_help_heading = SURFACE_HEADING)]
struct SurfaceArguments {
    /// As in the paper: no limit on vertices
    #[arg(long)]
    paper: bool,

    /// Fraction left by each step: 0.8
    #[arg(long, value_name = "Q", allow_negative_numbers = true)]
    simplification_quality: Option<f64>,

    /// Most triangles: 250,500,1000,2000,3000
    #[arg(long, value_name = "R", value_delimiter = ',')]
    maximum_resolutions: Option<Vec<usize>>,

    /// In units: 0.01,0.2,0.4,0.6,0.8,1
    #[arg(long, value_name = "P", value_delimiter = ',', allow_negative_numbers = true)]
    planar_thresholds: Option<Vec<f64>>,

    /// In units: 0.01
    #[arg(long, value_name = "A", allow_negative_numbers = true)]
    angular_threshold: Option<f64>,

    /// Highest cost, per group diagonal: 0.05
    #[arg(long, value_name = "ε", allow_negative_numbers = true)]
    concavity_cost_threshold: Option<f64>,

    /// Of hacd, likewise: 0.05
    #[arg(long, value_name = "β", allow_negative_numbers = true)]
    concavity_threshold: Option<f64>,

    /// Fewer pieces end it: 5; 0: never
    #[arg(long, value_name = "μ")]
    resolution_cut_off: Option<usize>,

    /// Unit of P and A: 44.6% of the diagonal
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    unit: Option<Length>,

    /// Smaller groups of 1 or 2 faces merge: 10%
    #[arg(long, value_name = "SHARE", value_parser = parse_share, allow_hyphen_values = true)]
    significant_diagonal: Option<f64>,
}

/// A limit on hulls or vertices: `None` where there is none. (A plain `Option` would mean to clap
/// that the argument may be missing.)
#[derive(Debug, Clone, Copy, PartialEq)]
struct Limit(Option<usize>);

/// What the arguments say.
#[derive(Debug, PartialEq)]
pub struct Chosen {
    /// What decomposes the mesh.
    pub method: Method,
    parameters: Parameters,
    /// With β only where it was given, whatever the method.
    surface: SurfaceParameters,
}

impl Chosen {
    /// The method of the same name with the parameters of the arguments.
    pub fn like(&self, method: &Method) -> Method {
        match method {
            Method::Bounded(_) => Method::Bounded(self.parameters.clone()),
            Method::Surface(of) => {
                let mut surface = self.surface.clone();
                let given = surface.concavity_threshold.take();
                surface.concavity_threshold =
                    of.concavity_threshold.map(|default| given.unwrap_or(default));
                Method::Surface(surface)
            }
            Method::Hull(_) => Method::Hull(self.parameters.clone()),
        }
    }

    /// The solid as the method sees it. Errors are shown against the bound, whatever the method.
    pub fn solid(&self) -> Parameters {
        self.method.solid().with_max_error(self.parameters.max_error)
    }
}

/// What a command does besides decomposing by the chosen method.
#[derive(Default)]
pub struct Uses<'a> {
    /// It decomposes by these methods too.
    pub others: &'a [Method],
    /// It shows errors against the bound, whatever the method.
    pub bound: bool,
}

const BOUNDED: &str = "bounded";
const SURFACE: &str = "surface";
const HACD: &str = "hacd";
const HULL: &str = "hull";

/// The methods that have the parameters of the solid: the one hull takes its mass from it.
const WITH_SOLID: &[&str] = &[BOUNDED, HULL];

impl ParameterArguments {
    /// What is chosen, if all values are in range and each belongs to a method that is used.
    pub fn checked(&self, uses: &Uses<'_>) -> Result<Chosen, Failure> {
        let chosen = self.chosen();
        let checks = [chosen.parameters.validate(), chosen.surface.validate()];
        checks
            .into_iter()
            .collect::<Result<(), _>>()
            .map_err(|error| Failure::Usage(error.to_string()))?;
        let mut used = vec![chosen.method.name()];
        used.extend(uses.others.iter().map(Method::name));
        let belongs = |option: &str, methods: &[&str]| {
            (option == "max-error" && uses.bound) || methods.iter().any(|own| used.contains(own))
        };
        match self.given().into_iter().find(|(option, methods)| !belongs(option, methods)) {
            Some((option, methods)) => Err(foreign(option, methods, &used)),
            None => Ok(chosen),
        }
    }

    /// The bound and the axis that points up, where nothing else may be given: nothing is
    /// decomposed.
    pub fn of_surface(&self) -> Result<(Option<Length>, UpAxis), Failure> {
        let others =
            [("method", self.method.is_some()), ("max-vertices", self.max_vertices.is_some())];
        let given = self.given().into_iter().map(|(option, _)| option);
        let others = others.iter().filter(|(_, is_given)| *is_given).map(|(option, _)| *option);
        match given.chain(others).find(|option| !["max-error", "up-axis"].contains(option)) {
            Some(option) => {
                Err(Failure::Usage(format!("--{option} has no effect: nothing is decomposed")))
            }
            None => Ok((self.max_error, self.up_axis.unwrap_or_default())),
        }
    }

    /// The options that were given, each with the methods that have it. All have a limit on
    /// vertices.
    fn given(&self) -> Vec<(&'static str, &'static [&'static str])> {
        let of_surface = &self.surface;
        let solid = [
            ("max-error", self.max_error.is_some()),
            ("openings", self.openings.is_some()),
            ("up-axis", self.up_axis.is_some()),
            ("keep-cavities", self.keep_cavities),
        ];
        let bounded = [
            ("max-hulls", self.max_hulls.is_some()),
            ("preset", self.preset.is_some()),
            ("probe-radius", self.probe_radius.is_some()),
            ("probe-from", !self.probe_from.is_empty()),
        ];
        let frame = [
            ("paper", of_surface.paper),
            ("simplification-quality", of_surface.simplification_quality.is_some()),
            ("maximum-resolutions", of_surface.maximum_resolutions.is_some()),
            ("resolution-cut-off", of_surface.resolution_cut_off.is_some()),
            ("significant-diagonal", of_surface.significant_diagonal.is_some()),
        ];
        let surface = [
            ("planar-thresholds", of_surface.planar_thresholds.is_some()),
            ("angular-threshold", of_surface.angular_threshold.is_some()),
            ("concavity-cost-threshold", of_surface.concavity_cost_threshold.is_some()),
            ("unit", of_surface.unit.is_some()),
        ];
        let hacd = [("concavity-threshold", of_surface.concavity_threshold.is_some())];
        let of_methods: [&[&str]; 5] =
            [WITH_SOLID, &[BOUNDED], &[SURFACE, HACD], &[SURFACE], &[HACD]];
        let options = [&solid[..], &bounded, &frame, &surface, &hacd].into_iter().zip(of_methods);
        let given = options.flat_map(|(options, methods)| {
            let given = options.iter().filter(|(_, is_given)| *is_given);
            given.map(move |&(option, _)| (option, methods))
        });
        given.collect()
    }

    fn chosen(&self) -> Chosen {
        let given = &self.surface;
        let (mut parameters, mut surface) = (Parameters::default(), SurfaceParameters::default());
        if given.paper {
            surface = SurfaceParameters::paper();
            parameters.max_vertices = surface.max_vertices;
        }
        if let Some(Limit(limit)) = self.max_vertices {
            (parameters.max_vertices, surface.max_vertices) = (limit, limit);
        }
        set(&mut parameters.max_error, &self.max_error);
        set(&mut parameters.max_hulls, &self.max_hulls.map(|Limit(limit)| limit));
        set(&mut parameters.preset, &self.preset);
        set(&mut parameters.openings, &self.openings);
        set(&mut parameters.up_axis, &self.up_axis);
        parameters.keep_cavities |= self.keep_cavities;
        parameters.probe_radius = self.probe_radius;
        parameters.probe_from.clone_from(&self.probe_from);
        set(&mut surface.simplification_quality, &given.simplification_quality);
        set(&mut surface.maximum_resolutions, &given.maximum_resolutions);
        set(&mut surface.planar_thresholds, &given.planar_thresholds);
        set(&mut surface.angular_threshold, &given.angular_threshold);
        set(&mut surface.concavity_cost_threshold, &given.concavity_cost_threshold);
        surface.concavity_threshold = given.concavity_threshold;
        set(&mut surface.resolution_cut_off, &given.resolution_cut_off);
        set(&mut surface.unit, &given.unit);
        set(&mut surface.significant_diagonal, &given.significant_diagonal);
        let mut chosen = Chosen { method: Method::default(), parameters, surface };
        chosen.method = match &self.method {
            Some(method) => chosen.like(method),
            None if given.paper => chosen.like(&SurfaceParameters::paper().into()),
            None => Method::Bounded(chosen.parameters.clone()),
        };
        chosen
    }
}

/// A point as `x,y,z`.
pub fn parse_point(text: &str) -> Result<[f64; 3], String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(str::parse).collect();
    let point = numbers.ok().and_then(|numbers| numbers.try_into().ok());
    point.ok_or_else(|| format!("`{text}`: a point as x,y,z is expected"))
}

/// The method of a name, with its defaults.
pub fn parse_method(text: &str) -> Result<Method, String> {
    let all = [
        Method::Bounded(Parameters::default()),
        Method::Surface(SurfaceParameters::default()),
        Method::Surface(SurfaceParameters::hacd()),
        Method::Hull(Parameters::default()),
    ];
    let found = all.into_iter().find(|method| method.name() == text);
    found.ok_or_else(|| format!("`{text}`: bounded, surface, hacd or hull is expected"))
}

fn set<T: Clone>(field: &mut T, argument: &Option<T>) {
    if let Some(value) = argument {
        field.clone_from(value);
    }
}

/// An error for an option of other methods than those that are used.
fn foreign(option: &str, methods: &[&str], used: &[&str]) -> Failure {
    let (methods, used) = (methods.join(" or "), used.join(" and "));
    Failure::Usage(format!("--{option} is for --method {methods}, not for {used}"))
}

/// Refuses to show the search of a method that has none.
pub fn check_is_surface(method: &Method) -> Result<(), Failure> {
    match method {
        Method::Surface(_) => Ok(()),
        _ => Err(foreign("search", &[SURFACE, HACD], &[method.name()])),
    }
}

/// The fraction of the diagonal of a percentage.
fn parse_share(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(Length::Share(share)) => Ok(share),
        _ => Err("a percentage of the diagonal (10%) is expected".into()),
    }
}

fn parse_limit(text: &str) -> Result<Limit, String> {
    if text == "none" {
        return Ok(Limit(None));
    }
    let limit = text.parse().map_err(|_| "a whole number or `none` is expected")?;
    Ok(Limit(Some(limit)))
}

/// Whether a path ends as baked scenes do.
pub fn is_scene_file(path: &Path) -> bool {
    path.extension().is_some_and(|suffix| suffix.eq_ignore_ascii_case(SCENE_SUFFIX))
}

/// The suffix of a baked scene.
pub const SCENE_SUFFIX: &str = "hullscene";

/// Refuses an output that is the input: the mesh would be lost.
pub fn check_not_input(output: &Path, input: &Path) -> Result<(), Failure> {
    let same = std::fs::canonicalize(output).ok().zip(std::fs::canonicalize(input).ok());
    match same {
        Some((output, input)) if output == input => {
            Err(Failure::Usage(format!("{}: the mesh itself is there", input.display())))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Only {
        #[command(flatten)]
        arguments: ParameterArguments,
    }

    fn parse(line: &str) -> Result<Chosen, String> {
        Only::try_parse_from(std::iter::once("test").chain(line.split_whitespace()))
            .map(|only| only.arguments.chosen())
            .map_err(|error| error.to_string())
    }

    fn method(line: &str) -> Method {
        parse(line).unwrap().method
    }

    #[test]
    fn without_arguments_the_defaults_hold() {
        assert_eq!(method(""), Method::default());
        assert_eq!(method("--paper"), SurfaceParameters::paper().into());
        assert_eq!(method("--method surface"), SurfaceParameters::default().into());
        assert_eq!(method("--method hacd"), SurfaceParameters::hacd().into());
        let mut hacd = SurfaceParameters::hacd();
        (hacd.concavity_threshold, hacd.max_vertices) = (Some(0.1), None);
        assert_eq!(method("--method hacd --concavity-threshold 0.1 --paper"), hacd.into());
        assert_eq!(method("--method hull"), Method::Hull(Parameters::default()));
        let bounded = Parameters::default().with_max_vertices(None);
        assert_eq!(method("--paper --method bounded"), bounded.into());
    }

    #[test]
    fn every_parameter_can_be_set() {
        let line = "--max-error 5% --max-hulls 3 --preset fine --keep-cavities --openings keep --up-axis z \
             --probe-radius 6% --probe-from 1,-2,0.5 \
             --simplification-quality 0.5 --maximum-resolutions 100,200 \
             --planar-thresholds 0.1,0.3 --angular-threshold 0.02 \
             --concavity-cost-threshold 0.1 --resolution-cut-off 7 --unit 44.6% \
             --significant-diagonal 20% --max-vertices none";
        let parameters = Parameters::default()
            .with_max_error(Length::Share(0.05))
            .with_max_hulls(3)
            .with_preset(Preset::Fine)
            .with_max_vertices(None)
            .with_keep_cavities(true)
            .with_openings(Openings::Keep)
            .with_up_axis(UpAxis::Z)
            .with_probe_radius(Length::Share(0.06))
            .with_probe_from([[1.0, -2.0, 0.5]]);
        let mut surface = SurfaceParameters::paper();
        surface.simplification_quality = 0.5;
        surface.maximum_resolutions = vec![100, 200];
        surface.planar_thresholds = vec![0.1, 0.3];
        surface.angular_threshold = 0.02;
        surface.concavity_cost_threshold = 0.1;
        surface.resolution_cut_off = 7;
        surface.unit = Length::Share(0.446);
        surface.significant_diagonal = 0.2;
        let (bounded, hull) =
            (Method::Bounded(parameters.clone()), Method::Hull(parameters.clone()));
        assert_eq!(method(line), bounded);
        assert_eq!(method(&format!("--method hull {line}")), hull);
        let chosen = parse(&format!("--method surface {line}")).unwrap();
        assert_eq!(chosen.method, Method::Surface(surface.clone()));
        assert_eq!(chosen.like(&Method::default()), bounded);
        assert_eq!(chosen.solid().max_error, Length::Share(0.05));
        assert_eq!(parse("--max-error 0.02m").unwrap().parameters.max_error, Length::Units(0.02));
        assert_eq!(parse("--unit 1.5m").unwrap().surface.unit, Length::Units(1.5));
        assert_eq!(parse("--max-hulls none").unwrap().parameters.max_hulls, None);
        assert_eq!(parse("--paper --max-vertices 32").unwrap().surface.max_vertices, Some(32));
    }

    #[test]
    fn what_is_no_value_is_refused() {
        for line in [
            "--method volume",
            "--preset best",
            "--max-error 2",
            "--max-error x%",
            "--unit 1.5",
            "--significant-diagonal 0.1",
            "--max-vertices many",
            "--max-hulls -3",
            "--planar-thresholds 1,x",
        ] {
            assert!(parse(line).is_err(), "{line}");
        }
    }

    #[test]
    fn an_option_of_a_method_that_is_not_used_is_refused_by_name() {
        let refused = |line: &str, uses: &Uses<'_>| {
            let words = std::iter::once("test").chain(line.split_whitespace());
            match Only::try_parse_from(words).unwrap().arguments.checked(uses) {
                Ok(_) => None,
                Err(Failure::Usage(reason) | Failure::Work(reason)) => Some(reason),
            }
        };
        let alone = Uses::default();
        for (line, reason) in [
            (
                "--method surface --max-hulls 3",
                "--max-hulls is for --method bounded, not for surface",
            ),
            (
                "--method surface --max-error 1%",
                "--max-error is for --method bounded or hull, not for surface",
            ),
            (
                "--paper --openings keep",
                "--openings is for --method bounded or hull, not for surface",
            ),
            ("--method hull --preset fast", "--preset is for --method bounded, not for hull"),
            ("--unit 1m", "--unit is for --method surface, not for bounded"),
            (
                "--method bounded --paper",
                "--paper is for --method surface or hacd, not for bounded",
            ),
            ("--method hacd --unit 1m", "--unit is for --method surface, not for hacd"),
            (
                "--method surface --concavity-threshold 0.1",
                "--concavity-threshold is for --method hacd, not for surface",
            ),
        ] {
            assert_eq!(refused(line, &alone).as_deref(), Some(reason));
        }
        for line in ["--method hull --openings keep --max-vertices 8", "--paper --unit 1m"] {
            assert_eq!(refused(line, &alone), None);
        }
        let surface = [Method::Surface(SurfaceParameters::default())];
        let comparing = Uses { others: &surface, bound: true };
        assert_eq!(refused("--unit 1m --max-hulls 3", &comparing), None);
        assert_eq!(refused("--method surface --max-error 1%", &comparing), None);
        assert!(refused("--method surface --max-hulls 3", &comparing).is_some());
    }

    #[test]
    fn values_out_of_range_reach_the_library_which_names_them() {
        let chosen = parse("--angular-threshold -1").unwrap();
        assert!(chosen.surface.validate().unwrap_err().to_string().contains("angular_threshold"));
    }
}
