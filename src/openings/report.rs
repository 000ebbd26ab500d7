//! What became of each opening.

use super::boundary::Loop;
use super::cap::Cap;
use crate::geometry::vector::Vector;
use crate::mesh::PreparedMesh;

/// An opening of the mesh: a loop of open edges, with the loops that are holes in its cap.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Opening {
    /// Open edges around it, those of holes included.
    pub edges: usize,
    /// Area of its cap, in squared units. Where there is no cap, the length of the vector area.
    pub area: f64,
    /// Middle of its vertices, in units.
    pub centre: [f64; 3],
    /// Whether it was closed, or why not.
    pub outcome: OpeningOutcome,
}

/// What became of an opening.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum OpeningOutcome {
    /// A cap closes it.
    Closed,
    /// A cap closes it, within the solid, where nothing can touch it.
    ClosedWithin,
    /// Left: its vertices are farther from a plane than the bound.
    NotFlat,
    /// Left: its outline crosses itself, or has more than 10,000 vertices.
    NotSimple,
    /// Left: a cap would lie on the surface around it, at less than 30° in the median.
    Sheet,
    /// Left: the surface goes through the cap.
    Cut,
    /// Left: its surface is drawn from both sides, and it does not lie in the lowest plane.
    TwoSided,
    /// Left: the fronts of faces are seen through it, or a way out.
    SeenInto,
    /// Left: what is beyond it is inside already, and would not be with a cap.
    SolidBeyond,
    /// Left: most of the boundary of its component stays open.
    Fragment,
}

impl OpeningOutcome {
    /// Whether a cap closes it.
    pub fn is_closed(self) -> bool {
        matches!(self, Self::Closed | Self::ClosedWithin)
    }

    /// In words.
    pub fn describe(self) -> &'static str {
        match self {
            Self::Closed => "closed",
            Self::ClosedWithin => "closed within the solid",
            Self::NotFlat => "left: not flat within the bound",
            Self::NotSimple => "left: its outline crosses itself",
            Self::Sheet => "left: a cap would lie on the sheet around it",
            Self::Cut => "left: the surface goes through it",
            Self::TwoSided => "left: drawn from both sides, and not at the bottom",
            Self::SeenInto => "left: the inside is seen through it",
            Self::SolidBeyond => "left: the solid goes on beyond it",
            Self::Fragment => "left: most of the part around it stays open",
        }
    }
}

impl Opening {
    pub(super) fn left(own: &Loop, prepared: &PreparedMesh, outcome: OpeningOutcome) -> Self {
        let points: Vec<Vector> =
            own.vertices.iter().map(|&v| prepared.mesh.points()[v as usize]).collect();
        let centre = mean(&points);
        let next = points.iter().cycle().skip(1);
        let twice = points
            .iter()
            .zip(next)
            .fold(Vector::ZERO, |sum, (&a, &b)| sum + (a - centre).cross(b - centre));
        Self::new(points.len(), 0.5 * twice.length(), centre, prepared, outcome)
    }

    pub(super) fn of_cap(
        cap: &Cap,
        loops: &[Loop],
        prepared: &PreparedMesh,
        outcome: OpeningOutcome,
    ) -> Self {
        let vertices = cap.loops.iter().flat_map(|&index| &loops[index].vertices);
        let points: Vec<Vector> =
            vertices.map(|&vertex| prepared.mesh.points()[vertex as usize]).collect();
        Self::new(points.len(), cap.area, mean(&points), prepared, outcome)
    }

    /// Area and centre are normalised.
    fn new(
        edges: usize,
        area: f64,
        centre: Vector,
        prepared: &PreparedMesh,
        outcome: OpeningOutcome,
    ) -> Self {
        let normalization = &prepared.normalization;
        let area = area * normalization.diagonal * normalization.diagonal;
        Self { edges, area, centre: normalization.restore(centre).to_array(), outcome }
    }
}

fn mean(points: &[Vector]) -> Vector {
    let sum = points.iter().fold(Vector::ZERO, |sum, &point| sum + point);
    sum * (1.0 / points.len().max(1) as f64)
}
