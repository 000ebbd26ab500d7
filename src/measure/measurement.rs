//! How closely to look, and what is found.

use super::hulls::HullCheck;
use crate::error::Error;
use crate::parameters::{Length, Openings, Parameters, UpAxis};

/// How closely [`measure`](super::measure) looks.
///
/// Start from [`MeasureOptions::default`] and set fields.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
pub struct MeasureOptions {
    /// Points on the surface of all hulls, at least one. Default 50,000.
    pub hull_samples: usize,
    /// Points on the mesh, at least one. Default 50,000.
    pub mesh_samples: usize,
    /// Points in the bounding box of mesh and hulls. Default 200,000.
    pub volume_samples: usize,
    /// Farthest that a vertex of a convex hull may lie in front of a face of it, as a share of the
    /// mesh's diagonal. Default 1e-6: what rounding to `f32` does.
    pub convexity_tolerance: f64,
    /// Where it is given, points are independent random ones with this seed. That shows how far
    /// figures of other tools scatter, which mostly sample so. Default `None`: evenly spread.
    pub random_seed: Option<u64>,
    /// What becomes of openings. Take what the hulls were made with: everything is judged against the mesh
    /// with those closed that are. Default [`Openings::Auto`].
    pub openings: Openings,
    /// How far an opening's vertices may be from a plane. Take the bound that the hulls were made with.
    /// Default 2 % of the diagonal.
    pub flatness: Length,
    /// Which axis points up: see [`Parameters::up_axis`](crate::Parameters::up_axis).
    pub up_axis: UpAxis,
    /// Whether closed components that nothing can reach stay: see
    /// [`Parameters::keep_cavities`](crate::Parameters::keep_cavities). Default false.
    pub keep_cavities: bool,
}

impl Default for MeasureOptions {
    fn default() -> Self {
        Self {
            hull_samples: 50_000,
            mesh_samples: 50_000,
            volume_samples: 200_000,
            convexity_tolerance: 1e-6,
            random_seed: None,
            openings: Openings::Auto,
            flatness: Parameters::default().max_error,
            up_axis: UpAxis::Y,
            keep_cavities: false,
        }
    }
}

/// Judges against the mesh as a decomposition with these parameters sees it.
impl From<&Parameters> for MeasureOptions {
    fn from(parameters: &Parameters) -> Self {
        let &Parameters { openings, max_error: flatness, up_axis, keep_cavities, .. } = parameters;
        Self { openings, flatness, up_axis, keep_cavities, ..Self::default() }
    }
}

impl MeasureOptions {
    pub(super) fn validate(&self) -> Result<(), Error> {
        for (name, count) in
            [("hull_samples", self.hull_samples), ("mesh_samples", self.mesh_samples)]
        {
            if count == 0 {
                return Err(Error::InvalidParameter { name, reason: "must not be 0".into() });
            }
        }
        let tolerance = self.convexity_tolerance;
        if tolerance.is_finite() && tolerance >= 0.0 {
            return Ok(());
        }
        let reason = format!("must be at least 0, not {tolerance}");
        Err(Error::InvalidParameter { name: "convexity_tolerance", reason })
    }
}

/// Distances of sampled points, as shares of the mesh's diagonal.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Distances {
    /// Their average.
    pub mean: f64,
    /// The distance that 1 % of the points exceed.
    pub p99: f64,
    /// The greatest.
    pub max: f64,
}

impl Distances {
    pub(super) fn of(mut values: Vec<f64>) -> Self {
        const HUNDREDTHS: usize = 99;

        values.sort_unstable_by(f64::total_cmp);
        let Some(&max) = values.last() else {
            return Self::default();
        };
        let p99 = values[(values.len() - 1) * HUNDREDTHS / 100];
        Self { mean: values.iter().sum::<f64>() / values.len() as f64, p99, max }
    }
}

/// What became of the sampled points.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SampleCounts {
    /// Points on the surface of all hulls.
    pub hull: usize,
    /// Those of them that are not inside another hull: they give [`Measurement::protrusion`].
    pub boundary: usize,
    /// Points on the mesh: they give [`Measurement::uncovered`].
    pub mesh: usize,
    /// Points in the bounding box of mesh and hulls.
    pub volume: usize,
    /// Those of them in the solid: they give [`Measurement::uncovered_volume`].
    pub solid: usize,
    /// Those of them in a hull: they give [`Measurement::overlap`].
    pub in_hulls: usize,
    /// Those of them in the solid or in a hull: they give [`Measurement::iou`].
    pub union: usize,
}

/// How well hulls stand for a mesh. Lengths are shares of [`diagonal`](Self::diagonal).
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Measurement {
    /// Hulls that can be judged.
    pub hulls: usize,
    /// Hulls that can't, and are left out: without triangles, with an index out of range, or with
    /// a coordinate that is not finite or more than 1e9 diagonals away.
    pub unusable_hulls: usize,
    /// Vertices of all hulls.
    pub vertices: usize,
    /// Hulls with a vertex in front of one of their own faces by more than
    /// [`MeasureOptions::convexity_tolerance`](super::MeasureOptions::convexity_tolerance).
    pub non_convex_hulls: usize,
    /// The farthest that any vertex lies in front of a face of its own hull.
    pub worst_concavity: f64,
    /// Hulls whose triangles do not close up, or are not wound the same way all over.
    pub open_hulls: usize,
    /// Hulls that enclose no or, being wound inward, a negative volume.
    pub non_positive_volumes: usize,
    /// How far the boundary of the hulls lies outside the solid.
    pub protrusion: Distances,
    /// How far the mesh lies outside all hulls.
    pub uncovered: Distances,
    /// The larger of the two maxima.
    pub hausdorff: f64,
    /// Share of the solid that no hull holds. `None` where more than 0.5 % of the mesh's edges
    /// are open, or no point is in the solid.
    pub uncovered_volume: Option<f64>,
    /// Volume that solid and hulls share, over the volume of both together. `None` where more
    /// than 0.5 % of the mesh's edges are open, or no point is in either.
    pub iou: Option<f64>,
    /// Sum of the hulls' volumes over the volume of their union. `None` where no point is in a
    /// hull.
    pub overlap: Option<f64>,
    /// Share of the mesh's edges that only one triangle uses, its vertices welded by position.
    pub open_edges: f64,
    /// Diagonal of the bounding box of the vertices that triangles use, in the mesh's units.
    pub diagonal: f64,
    /// What became of the sampled points.
    pub samples: SampleCounts,
    /// Every hull on its own, in the order given; `None` for those that can't be judged.
    pub checks: Vec<Option<HullCheck>>,
}
