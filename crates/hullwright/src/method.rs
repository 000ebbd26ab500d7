//! A method and its parameters as one value, for programs that let users choose: the command, the
//! plugin's tag, baked files and caches. And the simplest method, one hull.

use std::fmt;
use std::str::FromStr;

use crate::control::{Control, Stage};
use crate::decompose;
use crate::decomposer::{Decomposer, Input, admit, run_to_end};
use crate::decomposition::{Decomposition, Report};
use crate::error::Error;
use crate::geometry::MeshView;
use crate::mesh::PreparedMesh;
use crate::mesh::canonical_order::MeshOrder;
use crate::mesh::grouping::Grouping;
use crate::mesh::repair::prepare as repair;
use crate::parameters::{
    Field, Length, Openings, Parameters, ParseError, check_max_vertices, differing, items,
};
use crate::stages::{HULL as HULL_STAGES, PREPARED, Stages};
use crate::surface::pieces::Pieces;
use crate::surface::{self, SurfaceParameters, SurfaceReport};

/// A method with its parameters.
///
/// As text it is the method's name, unless it is the default, and the values that differ from the
/// method's default:
///
/// ```
/// use hullwright::surface::SurfaceParameters;
/// use hullwright::{Method, Parameters};
///
/// let method = Method::from(Parameters::default().with_max_hulls(32));
/// assert_eq!(method.to_string(), "max_hulls=32");
/// assert_eq!("max_hulls=32".parse(), Ok(method));
/// let paper = Method::from(SurfaceParameters::paper());
/// assert_eq!(paper.to_string(), "method=surface max_vertices=none");
/// ```
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Method {
    /// The default method: [`decompose`](crate::decompose()).
    Bounded(Parameters),
    /// The paper's method, and HACD within its frame:
    /// [`surface::decompose`](crate::surface::decompose()).
    Surface(SurfaceParameters),
    /// The one hull of all points, whatever the bound: [`single_hull()`]. `max_vertices`
    /// holds for it. The other parameters describe the solid that its mass is computed from.
    Hull(Parameters),
}

/// What a method reports of its own.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum MethodReport {
    /// Of the default method.
    Bounded(Report),
    /// Of the paper's method.
    Surface(SurfaceReport),
    /// Of the one hull of all points, which is not verified.
    Hull,
}

const BOUNDED: &str = "bounded";
const SURFACE: &str = "surface";
const HACD: &str = "hacd";
const HULL: &str = "hull";

/// By β, which only HACD has.
fn surface_name(concavity_threshold: Option<f64>) -> &'static str {
    concavity_threshold.map_or(SURFACE, |_| HACD)
}

impl Method {
    /// The method's name on the command line and in files.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Bounded(_) => BOUNDED,
            Self::Surface(surface) => surface_name(surface.concavity_threshold),
            Self::Hull(_) => HULL,
        }
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] names the first parameter that is out of its limits.
    pub fn validate(&self) -> Result<(), Error> {
        match self {
            Self::Bounded(parameters) | Self::Hull(parameters) => parameters.validate(),
            Self::Surface(parameters) => parameters.validate(),
        }
    }

    /// Parameters by which [`mass_properties_with`](crate::mass_properties_with()),
    /// [`MergeTree`](crate::MergeTree) and the command's pages see the mesh as this method does.
    /// The paper's method closes no opening and leaves nothing out.
    pub fn solid(&self) -> Parameters {
        match self {
            Self::Bounded(parameters) | Self::Hull(parameters) => parameters.clone(),
            Self::Surface(parameters) => Parameters::default()
                .with_openings(Openings::Keep)
                .with_keep_cavities(true)
                .with_max_vertices(parameters.max_vertices),
        }
    }

    /// Bytes that are the same for the same parameters only: for the keys of caches. They stay the
    /// same as long as no parameter is added. In place of another method's parameters stand the
    /// defaults.
    pub fn fingerprint(&self) -> Vec<u8> {
        // The patterns name all fields: a new one does not compile until it is written here.
        let bounded = self.bounded_parameters();
        let surface = match self {
            Self::Surface(surface) => surface.clone(),
            Self::Bounded(_) | Self::Hull(_) => SurfaceParameters::default(),
        };
        let Parameters {
            max_error,
            preset,
            max_hulls,
            max_vertices,
            keep_cavities,
            openings,
            up_axis,
            probe_radius,
            probe_from,
        } = &bounded;
        let SurfaceParameters {
            simplification_quality,
            maximum_resolutions,
            planar_thresholds,
            angular_threshold,
            concavity_cost_threshold,
            concavity_threshold,
            resolution_cut_off,
            unit,
            significant_diagonal,
            max_vertices: _,
        } = &surface;
        let mut bytes = Fingerprint::default();
        bytes.text(self.name());
        bytes.length(max_error);
        bytes.text(preset.name());
        bytes.limit(*max_hulls);
        bytes.number(u64::from(*keep_cavities));
        bytes.text(openings.name());
        bytes.text(up_axis.name());
        bytes.real(*simplification_quality);
        bytes.number(maximum_resolutions.len() as u64);
        maximum_resolutions.iter().for_each(|resolution| bytes.number(*resolution as u64));
        bytes.number(planar_thresholds.len() as u64);
        planar_thresholds.iter().for_each(|threshold| bytes.real(*threshold));
        bytes.real(*angular_threshold);
        bytes.real(*concavity_cost_threshold);
        bytes.number(*resolution_cut_off as u64);
        bytes.length(unit);
        bytes.real(*significant_diagonal);
        bytes.limit(*max_vertices);
        if let Some(radius) = probe_radius {
            bytes.length(radius);
            probe_from.iter().flatten().for_each(|coordinate| bytes.real(*coordinate));
        }
        concavity_threshold.iter().for_each(|threshold| bytes.real(*threshold));
        bytes.0
    }

    /// The parameters of the default method, as far as this method has them.
    pub fn bounded_parameters(&self) -> Parameters {
        match self {
            Self::Bounded(parameters) | Self::Hull(parameters) => parameters.clone(),
            Self::Surface(surface) => Parameters::default().with_max_vertices(surface.max_vertices),
        }
    }

    /// Decomposes a mesh by this method.
    ///
    /// # Errors
    /// As [`decompose`](crate::decompose()).
    pub fn decompose<'a>(
        &self,
        mesh: impl Into<MeshView<'a>>,
        control: &Control,
    ) -> Result<Decomposition<MethodReport>, Error> {
        let mesh = mesh.into();
        self.validate()?;
        admit(mesh, control)?;
        run_to_end(self.pipeline(mesh, control))
    }

    /// The same in time slices.
    ///
    /// # Errors
    /// As [`Decomposer::new`].
    pub fn decomposer<'a>(
        &self,
        mesh: impl Into<MeshView<'a>>,
        control: &Control,
    ) -> Result<Decomposer<MethodReport>, Error> {
        let mesh = mesh.into();
        self.validate()?;
        admit(mesh, control)?;
        let (method, mesh, control) = (self.clone(), mesh.to_owned(), control.clone());
        Ok(Decomposer::of(async move { method.pipeline(mesh.view(), &control).await }))
    }

    async fn pipeline(
        &self,
        mesh: MeshView<'_>,
        control: &Control,
    ) -> Result<Decomposition<MethodReport>, Error> {
        Ok(match self {
            Self::Bounded(parameters) => {
                decompose::pipeline(mesh, parameters, control).await?.into_method_report()
            }
            Self::Surface(parameters) => {
                surface::decompose::pipeline(mesh, parameters, control).await?.into_method_report()
            }
            Self::Hull(parameters) => {
                hull_of_all(mesh, parameters.max_vertices, control).await?.into_method_report()
            }
        })
    }
}

impl<R: Into<MethodReport>> Decomposition<R> {
    fn into_method_report(self) -> Decomposition<MethodReport> {
        let Self { hulls, grouped, run, report } = self;
        Decomposition { hulls, grouped, run, report: report.into() }
    }
}

impl MethodReport {
    /// The name of the [`Method`].
    pub fn name(&self) -> &'static str {
        match self {
            Self::Bounded(_) => BOUNDED,
            Self::Surface(report) => surface_name(report.concavity_threshold),
            Self::Hull => HULL,
        }
    }

    /// What the default method verified.
    pub fn bounded(&self) -> Option<&Report> {
        match self {
            Self::Bounded(report) => Some(report),
            Self::Surface(_) | Self::Hull => None,
        }
    }

    /// The search of the paper's method.
    pub fn surface(&self) -> Option<&SurfaceReport> {
        match self {
            Self::Surface(report) => Some(report),
            Self::Bounded(_) | Self::Hull => None,
        }
    }
}

impl Default for Method {
    fn default() -> Self {
        Self::Bounded(Parameters::default())
    }
}

/// The variant that holds a value of a type.
macro_rules! from {
    ($($type:ty => $whole:ident::$variant:ident),+) => {
        $(impl From<$type> for $whole {
            fn from(part: $type) -> Self {
                Self::$variant(part)
            }
        })+
    };
}

from!(
    Parameters => Method::Bounded,
    SurfaceParameters => Method::Surface,
    Report => MethodReport::Bounded,
    SurfaceReport => MethodReport::Surface
);

impl From<()> for MethodReport {
    fn from((): ()) -> Self {
        Self::Hull
    }
}

impl fmt::Display for Method {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (own, default): (Vec<Field>, Vec<Field>) = match self {
            Self::Bounded(own) | Self::Hull(own) => {
                (own.fields().into(), Parameters::default().fields().into())
            }
            Self::Surface(own) => {
                let is_hacd = own.concavity_threshold.is_some();
                let default = if is_hacd { SurfaceParameters::hacd() } else { Default::default() };
                (own.fields().into(), default.fields().into())
            }
        };
        let parameters = differing(&own, &default);
        match self {
            Self::Bounded(_) => formatter.write_str(&parameters),
            _ if parameters.is_empty() => write!(formatter, "method={}", self.name()),
            _ => write!(formatter, "method={} {parameters}", self.name()),
        }
    }
}

impl FromStr for Method {
    type Err = ParseError;

    /// Reads what [`Display`](fmt::Display) writes, on top of the method's defaults. Parameters of
    /// another method are read and dropped. The values are not checked: see
    /// [`validate`](Self::validate).
    fn from_str(text: &str) -> Result<Self, ParseError> {
        let mut name = BOUNDED;
        let mut parameters = Parameters::default();
        let mut surface = SurfaceParameters::default();
        for item in items(text) {
            let (key, value) = item?;
            if key == "method" {
                name = value;
                continue;
            }
            // Both have some of the keys.
            let is_known = [parameters.set(key, value)?, surface.set(key, value)?];
            if !is_known.contains(&true) {
                let keys = format!("method, {}, {}", Parameters::KEYS, SurfaceParameters::KEYS);
                return Err(ParseError::unknown_key(key, &keys));
            }
        }
        match name {
            BOUNDED => Ok(Self::Bounded(parameters)),
            SURFACE => {
                Ok(Self::Surface(SurfaceParameters { concavity_threshold: None, ..surface }))
            }
            HACD => {
                let default = SurfaceParameters::hacd().concavity_threshold;
                surface.concavity_threshold = surface.concavity_threshold.or(default);
                Ok(Self::Surface(surface))
            }
            HULL => Ok(Self::Hull(parameters)),
            _ => Err(ParseError::new(name, "bounded, surface, hacd or hull")),
        }
    }
}

/// The one hull of all points that triangles use, with at most `max_vertices` vertices, whatever
/// the error: nothing is verified. O(n log n).
///
/// # Errors
/// As [`decompose`](crate::decompose()).
///
/// ```
/// # let mesh = hullwright::TriangleMesh::new(
/// #     vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
/// #     vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
/// # );
/// let result = hullwright::single_hull(&mesh, Some(64), &hullwright::Control::new())?;
/// assert_eq!(result.hulls.len(), 1);
/// # Ok::<(), hullwright::Error>(())
/// ```
pub fn single_hull<'a>(
    mesh: impl Into<MeshView<'a>>,
    max_vertices: Option<usize>,
    control: &Control,
) -> Result<Decomposition<()>, Error> {
    let mesh = mesh.into();
    check_max_vertices(max_vertices)?;
    admit(mesh, control)?;
    run_to_end(hull_of_all(mesh, max_vertices, control))
}

/// With a yield between stages.
async fn hull_of_all(
    mesh: MeshView<'_>,
    max_vertices: Option<usize>,
    control: &Control,
) -> Result<Decomposition<()>, Error> {
    let mut stages = Stages::new(control);
    // Neither a cap nor what lies inside changes the hull of all points.
    let repaired = stages.run(Stage::Repair, || repair(mesh, MeshOrder::Place, control)).await?;
    let input = Input::as_it_is(mesh, repaired);
    stages.begin(HULL_STAGES, PREPARED..1.0);
    let PreparedMesh { mesh, components, normalization, .. } = &input.prepared;
    let grouping = Grouping { labels: vec![0; mesh.triangles.len()], count: 1 };
    let whole = Pieces { mesh, components, grouping: &grouping };
    let hulls = whole.finish(&input.prepared, max_vertices, &mut stages).await?;
    let grouped = whole.grouped_mesh(normalization);
    Ok(Decomposition { hulls, grouped, run: input.report(stages, false), report: () })
}

/// Fields as bytes, unambiguously: different fields never give the same bytes.
#[derive(Default)]
struct Fingerprint(Vec<u8>);

impl Fingerprint {
    fn number(&mut self, number: u64) {
        self.0.extend(number.to_le_bytes());
    }

    fn real(&mut self, real: f64) {
        self.number(real.to_bits());
    }

    fn text(&mut self, text: &str) {
        self.number(text.len() as u64);
        self.0.extend(text.as_bytes());
    }

    fn limit(&mut self, limit: Option<usize>) {
        self.number(u64::from(limit.is_some()));
        self.number(limit.unwrap_or_default() as u64);
    }

    fn length(&mut self, length: &Length) {
        let (kind, value) = match length {
            Length::Share(value) => (0, value),
            Length::Units(value) => (1, value),
        };
        self.number(kind);
        self.real(*value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::{Preset, UpAxis};

    #[test]
    fn text_goes_both_ways() {
        let bounded = Parameters::default()
            .with_max_error(Length::units(0.01))
            .with_preset(Preset::Fine)
            .with_max_hulls(3)
            .with_max_vertices(None)
            .with_keep_cavities(true);
        let mut surface = SurfaceParameters::paper();
        surface.planar_thresholds = vec![0.25];
        let mut hacd = SurfaceParameters::hacd();
        hacd.concavity_threshold = Some(0.1);
        for method in [
            Method::default(),
            bounded.clone().into(),
            surface.into(),
            hacd.into(),
            Method::Hull(bounded),
        ] {
            assert_eq!(method.to_string().parse(), Ok(method));
        }
    }

    /// Texts that files and caches hold since before `Method` had parameters.
    const TEXTS: [&str; 12] = [
        "",
        "max_error=1% max_hulls=32",
        "max_error=0.02m preset=fine keep_cavities=true openings=close up_axis=z",
        "max_vertices=none",
        "max_error=0.55% preset=fast max_hulls=1 max_vertices=8 openings=keep",
        "method=surface max_vertices=none",
        "method=surface",
        "method=surface maximum_resolutions=250,500 planar_thresholds=0.01,0.25 unit=1.5m",
        "method=surface max_vertices=32 simplification_quality=0.5 angular_threshold=0.02 \
         concavity_cost_threshold=0.1 resolution_cut_off=0 unit=50% significant_diagonal=0.25",
        "method=hull",
        "method=hull max_vertices=16 openings=keep",
        "method=hull max_error=0.1m keep_cavities=true up_axis=z",
    ];

    #[test]
    fn texts_of_earlier_versions_are_read_and_written_as_they_are() {
        for text in TEXTS {
            let method: Method = text.parse().unwrap();
            assert_eq!(method.to_string(), text);
        }
        assert_eq!(TEXTS[5].parse(), Ok(Method::from(SurfaceParameters::paper())));
        let surface = SurfaceParameters {
            maximum_resolutions: vec![250, 500],
            planar_thresholds: vec![0.01, 0.25],
            unit: Length::units(1.5),
            ..SurfaceParameters::default()
        };
        assert_eq!(TEXTS[7].parse(), Ok(Method::Surface(surface)));
        let hull = Parameters::default().with_max_vertices(16).with_openings(Openings::Keep);
        assert_eq!(TEXTS[10].parse(), Ok(Method::Hull(hull)));
    }

    #[test]
    fn parameters_of_another_method_are_dropped() {
        let texts = [
            ("method=surface max_error=1%", "method=surface"),
            ("method=surface concavity_threshold=0.1", "method=surface"),
            ("method=hacd concavity_threshold=0.05", "method=hacd"),
            ("unit=2m", ""),
        ];
        for (text, kept) in texts {
            assert_eq!(text.parse::<Method>(), kept.parse());
        }
    }

    #[test]
    fn a_wrong_key_or_value_is_named_with_what_is_expected() {
        for (text, expected) in [
            ("max_hull=3", "max_hulls"),
            ("max_hull=3", "significant_diagonal"),
            ("max_hulls=many", "a whole number or none"),
            ("preset=best", "fast, balanced or fine"),
            ("planar_thresholds=1,x", "a number"),
            ("method=volume", "bounded, surface, hacd or hull"),
            ("keep_cavities", "key=value"),
        ] {
            let error = text.parse::<Method>().unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
    }

    #[test]
    fn other_parameters_have_another_fingerprint() {
        let bounded = [
            Parameters::default(),
            Parameters { openings: Openings::Close, ..Parameters::default() },
            Parameters { up_axis: UpAxis::Z, ..Parameters::default() },
            Parameters { max_error: Length::share(0.03), ..Parameters::default() },
            Parameters { max_error: Length::units(0.02), ..Parameters::default() },
            Parameters { preset: Preset::Fast, ..Parameters::default() },
            Parameters { max_hulls: Some(0), ..Parameters::default() },
            Parameters { keep_cavities: true, ..Parameters::default() },
            Parameters::default().with_probe_radius(Length::units(0.1)),
            Parameters::default().with_probe_radius(Length::share(0.1)),
            Parameters::default()
                .with_probe_radius(Length::share(0.1))
                .with_probe_from(vec![[0.0; 3]]),
            Parameters { max_vertices: None, ..Parameters::default() },
        ];
        let surface = SurfaceParameters::default;
        let surface = [
            surface(),
            SurfaceParameters { simplification_quality: 0.7, ..surface() },
            SurfaceParameters { maximum_resolutions: vec![1], ..surface() },
            SurfaceParameters { planar_thresholds: vec![1.0], ..surface() },
            SurfaceParameters { angular_threshold: 0.5, ..surface() },
            SurfaceParameters { concavity_cost_threshold: 0.5, ..surface() },
            SurfaceParameters::hacd(),
            SurfaceParameters { concavity_threshold: Some(0.1), ..surface() },
            SurfaceParameters { resolution_cut_off: 4, ..surface() },
            SurfaceParameters { unit: Length::units(1.0), ..surface() },
            SurfaceParameters { significant_diagonal: 0.5, ..surface() },
            SurfaceParameters { max_vertices: None, ..surface() },
        ];
        let mut methods: Vec<Method> = bounded.clone().map(Method::Bounded).into();
        methods.extend(bounded.map(Method::Hull));
        methods.extend(surface.map(Method::Surface));
        let count = methods.len();
        let mut fingerprints: Vec<Vec<u8>> = methods.iter().map(Method::fingerprint).collect();
        fingerprints.sort_unstable();
        fingerprints.dedup();
        assert_eq!(fingerprints.len(), count);
    }
}
