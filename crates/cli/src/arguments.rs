//! The parameters of a decomposition as command line arguments.

use std::path::Path;

use hullwright::io::Format;
use hullwright::surface::SurfaceParameters;
use hullwright::{Length, Method, Openings, Parameters, Preset, UpAxis};
use hullwright_cli::terminal::Failure;

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
    #[arg(long, value_name = "WHICH", default_value_t)]
    openings: Openings,

    /// The bound that hulls are made with: an opening counts as flat within it
    #[arg(long, value_name = "ERROR", default_value = "2%")]
    max_error: Length,

    /// Which axis points up, y or z; as in `decompose`
    #[arg(long, value_name = "AXIS", default_value_t)]
    up_axis: UpAxis,
}

impl SolidArguments {
    pub fn parameters(&self) -> Parameters {
        let &Self { openings, max_error, up_axis } = self;
        Parameters::default().openings(openings).max_error(max_error).up_axis(up_axis)
    }
}

/// Above the options of the paper's method, which come last.
pub const SURFACE_HEADING: &str = "The paper's method (--method surface)";

/// The parameters of a decomposition.
#[derive(clap::Args)]
#[command(next_help_heading = "Parameters")]
pub struct ParameterArguments {
    /// bounded (default), surface (the paper's) or hull (that of all points)
    #[arg(long, value_name = "NAME", value_parser = parse_method)]
    method: Option<Method>,

    /// The bound: 2% (default) of the bounding-box diagonal, or 0.02m in the mesh's unit
    #[arg(long, value_name = "ERROR", allow_hyphen_values = true)]
    max_error: Option<Length>,

    /// Limit on hulls, or none (default); it may force them above the bound, as `decompose` says
    #[arg(long, value_name = "N", value_parser = parse_limit, allow_hyphen_values = true)]
    max_hulls: Option<Limit>,

    /// Limit on the vertices of a hull: 64 (default), at least 8, or none
    #[arg(long, value_name = "N", value_parser = parse_limit, allow_hyphen_values = true)]
    max_vertices: Option<Limit>,

    /// balanced (default); fast: a fifth more hulls in two thirds of the time; fine: some fewer in
    /// three times the time
    #[arg(long, value_name = "NAME")]
    preset: Option<Preset>,

    /// Flat openings, the sides that a modeller leaves out: auto (default) closes those through
    /// which only the backs of faces are seen; keep; close
    #[arg(long, value_name = "WHICH")]
    openings: Option<Openings>,

    /// y (default) or z: auto closes double-sided openings at the bottom alone
    #[arg(long, value_name = "AXIS")]
    up_axis: Option<UpAxis>,

    /// Cavities stay empty whose mouths are narrower than twice the bound
    #[arg(long)]
    keep_cavities: bool,

    /// Hulls may fill what no ball of this radius can reach from outside: half the thickness of the thinnest thing that
    /// moves, 6% of the diagonal or 0.1m
    #[arg(long, value_name = "RADIUS", allow_hyphen_values = true)]
    probe_radius: Option<Length>,

    /// Where such a ball starts too, as x,y,z: a point in a closed room that stays open
    #[arg(long, value_name = "POINT", value_parser = parse_point, allow_hyphen_values = true)]
    probe_from: Vec<[f64; 3]>,

    #[command(flatten)]
    surface: SurfaceArguments,
}

/// Those of the paper's method.
#[derive(clap::Args)]
#[command(next_help_heading = SURFACE_HEADING)]
struct SurfaceArguments {
    /// Exactly the paper: its values, and no limit on vertices
    #[arg(long)]
    paper: bool,

    /// Simplification target: the triangle count times Q, until it is at most R. Paper: 0.8
    #[arg(long, value_name = "Q", allow_negative_numbers = true)]
    simplification_quality: Option<f64>,

    /// In triangles. Paper: 250,500,1000,2000,3000
    #[arg(long, value_name = "R", value_delimiter = ',')]
    maximum_resolutions: Option<Vec<usize>>,

    /// In the unit of --unit. Paper: 0.01,0.2,0.4,0.6,0.8,1
    #[arg(long, value_name = "P", value_delimiter = ',', allow_negative_numbers = true)]
    planar_thresholds: Option<Vec<f64>>,

    /// In the unit of --unit. Paper: 0.01
    #[arg(long, value_name = "A", allow_negative_numbers = true)]
    angular_threshold: Option<f64>,

    /// Cost that is low enough, per group diagonal. Paper: 0.05
    #[arg(long, value_name = "ε", allow_negative_numbers = true)]
    concavity_cost_threshold: Option<f64>,

    /// With fewer pieces, skip the rest; 0: never skip. Paper: 5
    #[arg(long, value_name = "μ")]
    resolution_cut_off: Option<usize>,

    /// The unit: 0.446d (default) of the diagonal, or 1.5 of the mesh's
    #[arg(long, value_name = "LENGTH", value_parser = parse_unit, allow_negative_numbers = true)]
    unit: Option<Length>,

    /// Groups of one or two polygons are merged if smaller than this fraction (default 0.1) of the diagonal
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true)]
    significant_diagonal: Option<f64>,
}

/// A limit on hulls or vertices: `None` where there is none. (A plain `Option` would mean to clap that the
/// argument may be missing.)
#[derive(Debug, Clone, Copy, PartialEq)]
struct Limit(Option<usize>);

/// What the arguments say.
#[derive(Debug, PartialEq)]
pub struct Chosen {
    /// What decomposes the mesh.
    pub method: Method,
    parameters: Parameters,
    surface: SurfaceParameters,
}

impl Chosen {
    /// The method of the same name with the parameters of the arguments.
    pub fn like(&self, method: &Method) -> Method {
        match method {
            Method::Bounded(_) => Method::Bounded(self.parameters.clone()),
            Method::Surface(_) => Method::Surface(self.surface.clone()),
            Method::Hull(_) => Method::Hull(self.parameters.clone()),
        }
    }

    /// The solid as the method sees it. Errors are shown against the bound, whatever the method.
    pub fn solid(&self) -> Parameters {
        self.method.solid().max_error(self.parameters.max_error)
    }
}

impl ParameterArguments {
    /// What is chosen, if all values are in range.
    pub fn checked(&self) -> Result<Chosen, Failure> {
        let chosen = self.chosen();
        let checks = [chosen.parameters.validate(), chosen.surface.validate()];
        checks
            .into_iter()
            .collect::<Result<(), _>>()
            .map_err(|error| Failure::Usage(error.to_string()))?;
        Ok(chosen)
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
        set(&mut surface.resolution_cut_off, &given.resolution_cut_off);
        set(&mut surface.unit, &given.unit);
        set(&mut surface.significant_diagonal, &given.significant_diagonal);
        let mut chosen = Chosen { method: Method::default(), parameters, surface };
        chosen.method = match &self.method {
            Some(method) => chosen.like(method),
            None if given.paper => Method::Surface(chosen.surface.clone()),
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
        Method::Hull(Parameters::default()),
    ];
    let found = all.into_iter().find(|method| method.name() == text);
    found.ok_or_else(|| format!("`{text}`: bounded, surface or hull is expected"))
}

fn set<T: Clone>(field: &mut T, argument: &Option<T>) {
    if let Some(value) = argument {
        field.clone_from(value);
    }
}

fn parse_unit(text: &str) -> Result<Length, String> {
    let (number, unit): (&str, fn(f64) -> Length) = match text.strip_suffix('d') {
        Some(number) => (number, Length::Share),
        None => (text, Length::Units),
    };
    let length =
        number.parse().map_err(|_| "a number is expected, with or without `d` after it")?;
    Ok(unit(length))
}

fn parse_limit(text: &str) -> Result<Limit, String> {
    if text == "none" {
        return Ok(Limit(None));
    }
    let limit = text.parse().map_err(|_| "a whole number or `none` is expected")?;
    Ok(Limit(Some(limit)))
}

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
        assert_eq!(method("--method hull"), Method::Hull(Parameters::default()));
        let bounded = Parameters::default().max_vertices(None);
        assert_eq!(method("--paper --method bounded"), bounded.into());
    }

    #[test]
    fn every_parameter_can_be_set() {
        let line = "--max-error 5% --max-hulls 3 --preset fine --keep-cavities --openings keep --up-axis z \
             --probe-radius 6% --probe-from 1,-2,0.5 \
             --simplification-quality 0.5 --maximum-resolutions 100,200 \
             --planar-thresholds 0.1,0.3 --angular-threshold 0.02 \
             --concavity-cost-threshold 0.1 --resolution-cut-off 7 --unit 0.446d \
             --significant-diagonal 0.2 --max-vertices none";
        let parameters = Parameters::default()
            .max_error(Length::Share(0.05))
            .max_hulls(3)
            .preset(Preset::Fine)
            .max_vertices(None)
            .keep_cavities(true)
            .openings(Openings::Keep)
            .up_axis(UpAxis::Z)
            .probe_radius(Length::Share(0.06))
            .probe_from([[1.0, -2.0, 0.5]]);
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
        assert_eq!(parse("--unit 1.5").unwrap().surface.unit, Length::Units(1.5));
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
            "--unit d",
            "--max-vertices many",
            "--max-hulls -3",
            "--planar-thresholds 1,x",
        ] {
            assert!(parse(line).is_err(), "{line}");
        }
    }

    #[test]
    fn values_out_of_range_reach_the_library_which_names_them() {
        let chosen = parse("--angular-threshold -1").unwrap();
        assert!(chosen.surface.validate().unwrap_err().to_string().contains("angular_threshold"));
    }
}
