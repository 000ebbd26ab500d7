//! What is asked for: every parameter, with the paper's symbol, its default and its checks.

mod bounded;
mod length;
mod openings;
mod surface;
mod text;

use std::fmt;
use std::str::FromStr;

use crate::error::Error;

pub use bounded::{BoundedParameters, Preset};
pub use length::Length;
pub use openings::{Openings, UpAxis};
pub use surface::SurfaceParameters;
pub use text::ParseError;

/// Which method decomposes the mesh.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Method {
    /// Hullwright's own: the paper's groups, merged, grown and dissolved into few hulls under a
    /// bound on the error that is verified against the source.
    #[default]
    Bounded,
    /// The paper's surface-based method: groups of the simplified surface, chosen by concavity
    /// cost over all thresholds and resolutions.
    Surface,
    /// No decomposition: the one hull of all points that triangles use, whatever the bound. Of the other
    /// parameters only [`Parameters::max_vertices`] counts. Nothing is verified.
    Hull,
}

impl Method {
    /// The method's name on the command line.
    ///
    /// ```
    /// assert_eq!(hullwright::Method::Bounded.name(), "bounded");
    /// ```
    pub fn name(self) -> &'static str {
        match self {
            Self::Bounded => "bounded",
            Self::Surface => "surface",
            Self::Hull => "hull",
        }
    }
}

impl fmt::Display for Method {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.name())
    }
}

impl FromStr for Method {
    type Err = ParseError;

    fn from_str(text: &str) -> Result<Self, ParseError> {
        let all = [Self::Bounded, Self::Surface, Self::Hull];
        let found = all.into_iter().find(|value| value.name() == text);
        found.ok_or_else(|| ParseError::new(text, "bounded, surface or hull"))
    }
}

/// What [`decompose`](crate::decompose) is asked to do.
///
/// Start from [`Parameters::default`] or [`Parameters::paper`] and set what differs:
///
/// ```
/// use hullwright::{Length, Parameters, Preset};
///
/// let parameters = Parameters::default()
///     .max_error(Length::share(0.01))
///     .max_hulls(32)
///     .preset(Preset::Fine);
/// assert!(parameters.validate().is_ok());
/// ```
///
/// As text they are the values that differ from the default, separated by spaces:
///
/// ```
/// use hullwright::{Length, Parameters};
///
/// let parameters: Parameters = "max_error=1% max_hulls=32".parse()?;
/// assert_eq!(parameters, Parameters::default().max_error(Length::share(0.01)).max_hulls(32));
/// assert_eq!(parameters.to_string(), "max_error=1% max_hulls=32");
/// # Ok::<(), hullwright::ParseError>(())
/// ```
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
pub struct Parameters {
    /// The method.
    pub method: Method,
    /// Parameters of [`Method::Bounded`].
    pub bounded: BoundedParameters,
    /// Parameters of [`Method::Surface`].
    pub surface: SurfaceParameters,
    /// Most vertices that a hull may have, at least 8; `None` for no cap. A hull over the cap is
    /// replaced by one that contains it and little more or, where the bounded method's bound
    /// forbids that, by one that leaves out what protrudes least, or by several;
    /// [`HullErrors::simplification_growth`](crate::HullErrors::simplification_growth) says by how much. Default 64; `None`
    /// in [`Parameters::paper`].
    pub max_vertices: Option<usize>,
}

/// A physics engine's cost grows with the vertices of a hull, and 64 still follow a round shape.
const DEFAULT_MAX_VERTICES: usize = 64;

/// With fewer vertices not even a box would do.
const LEAST_MAX_VERTICES: usize = 8;

impl Parameters {
    /// Exactly the paper: its method, its values, hulls as they are.
    ///
    /// ```
    /// use hullwright::{Method, Parameters};
    ///
    /// assert_eq!(Parameters::paper().method, Method::Surface);
    /// ```
    pub fn paper() -> Self {
        Self {
            method: Method::Surface,
            bounded: BoundedParameters::default(),
            surface: SurfaceParameters::paper(),
            max_vertices: None,
        }
    }

    /// Sets the method.
    ///
    /// ```
    /// use hullwright::{Method, Parameters};
    ///
    /// assert_eq!(Parameters::default().method(Method::Surface).method, Method::Surface);
    /// ```
    #[must_use]
    pub fn method(mut self, method: Method) -> Self {
        self.method = method;
        self
    }

    /// Sets the bound of the bounded method: see [`BoundedParameters::max_error`].
    ///
    /// ```
    /// use hullwright::{Length, Parameters};
    ///
    /// // 5 mm, if the mesh is in metres.
    /// let parameters = Parameters::default().max_error(Length::units(0.005));
    /// assert_eq!(parameters.bounded.max_error, Length::Units(0.005));
    /// ```
    #[must_use]
    pub fn max_error(mut self, max_error: Length) -> Self {
        self.bounded.max_error = max_error;
        self
    }

    /// Sets how much work the bounded method does.
    ///
    /// ```
    /// use hullwright::{Parameters, Preset};
    ///
    /// assert_eq!(Parameters::default().preset(Preset::Fine).bounded.preset, Preset::Fine);
    /// ```
    #[must_use]
    pub fn preset(mut self, preset: Preset) -> Self {
        self.bounded.preset = preset;
        self
    }

    /// Sets the cap on hulls, or `None`: see [`BoundedParameters::max_hulls`].
    ///
    /// ```
    /// let parameters = hullwright::Parameters::default().max_hulls(16);
    /// assert_eq!(parameters.bounded.max_hulls, Some(16));
    /// assert_eq!(parameters.max_hulls(None).bounded.max_hulls, None);
    /// ```
    #[must_use]
    pub fn max_hulls(mut self, max_hulls: impl Into<Option<usize>>) -> Self {
        self.bounded.max_hulls = max_hulls.into();
        self
    }

    /// Sets the cap on the vertices of a hull, or `None`.
    ///
    /// ```
    /// let parameters = hullwright::Parameters::default();
    /// assert_eq!(parameters.max_vertices, Some(64));
    /// assert_eq!(parameters.max_vertices(None).max_vertices, None);
    /// ```
    #[must_use]
    pub fn max_vertices(mut self, max_vertices: impl Into<Option<usize>>) -> Self {
        self.max_vertices = max_vertices.into();
        self
    }

    /// Sets what becomes of openings: see [`BoundedParameters::openings`].
    ///
    /// ```
    /// use hullwright::{Openings, Parameters};
    ///
    /// assert_eq!(Parameters::default().openings(Openings::Keep).bounded.openings, Openings::Keep);
    /// ```
    #[must_use]
    pub fn openings(mut self, openings: Openings) -> Self {
        self.bounded.openings = openings;
        self
    }

    /// Sets which axis points up: see [`BoundedParameters::up_axis`].
    ///
    /// ```
    /// use hullwright::{Parameters, UpAxis};
    ///
    /// assert_eq!(Parameters::default().up_axis(UpAxis::Z).bounded.up_axis, UpAxis::Z);
    /// ```
    #[must_use]
    pub fn up_axis(mut self, up_axis: UpAxis) -> Self {
        self.bounded.up_axis = up_axis;
        self
    }

    /// Sets whether narrow cavities stay empty: see [`BoundedParameters::keep_cavities`].
    ///
    /// ```
    /// assert!(hullwright::Parameters::default().keep_cavities(true).bounded.keep_cavities);
    /// ```
    #[must_use]
    pub fn keep_cavities(mut self, keep_cavities: bool) -> Self {
        self.bounded.keep_cavities = keep_cavities;
        self
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] names the first field whose value means nothing.
    ///
    /// ```
    /// use hullwright::{Length, Parameters};
    ///
    /// assert!(Parameters::default().max_error(Length::share(-1.0)).validate().is_err());
    /// ```
    pub fn validate(&self) -> Result<(), Error> {
        if let Some(cap) = self.max_vertices
            && cap < LEAST_MAX_VERTICES
        {
            return Err(Error::InvalidParameter {
                name: "max_vertices",
                reason: format!("must be at least {LEAST_MAX_VERTICES}, not {cap}"),
            });
        }
        self.bounded.validate()?;
        self.surface.validate()
    }
}

impl Default for Parameters {
    fn default() -> Self {
        Self { method: Method::Bounded, max_vertices: Some(DEFAULT_MAX_VERTICES), ..Self::paper() }
    }
}
