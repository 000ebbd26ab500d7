//! What is seen: parts of one colour, in panels.

use hullwright::openings::ClosedMesh;
use hullwright::{MeshView, TriangleMesh, UpAxis};
use hullwright_formats::palette::{self, Colour};

use crate::Vector;

/// Coordinates beyond this would overflow when squared: what uses them is not drawn.
const LARGEST_COORDINATE: f64 = 1e100;

/// Triangles of one colour that move together when a panel is exploded.
#[derive(Debug, Clone, Default)]
pub struct Part {
    /// What is drawn. Triangles with an index out of range, or with a coordinate that is not finite
    /// or beyond 1e100, are left out. Winding does not matter.
    pub mesh: TriangleMesh,
    /// Its colour in full light.
    pub colour: Colour,
}

impl Part {
    /// The corners of the triangles that can be drawn.
    pub(super) fn corners(&self) -> impl Iterator<Item = [Vector; 3]> + Clone {
        self.mesh.triangles.iter().filter_map(|triangle| {
            let mut corners = [Vector::ZERO; 3];
            for (corner, index) in corners.iter_mut().zip(triangle) {
                let position = Vector::from(*self.mesh.positions.get(*index as usize)?);
                if !position.abs().cmple(Vector::splat(LARGEST_COORDINATE)).all() {
                    return None;
                }
                *corner = position;
            }
            Some(corners)
        })
    }

    fn middle(&self) -> Option<Vector> {
        middle(self.corners().flatten())
    }
}

/// What is seen together.
#[derive(Debug, Clone, Default)]
pub struct Panel {
    /// What is drawn.
    pub parts: Vec<Part>,
    /// How far parts are moved apart: the middle of each goes away from the middle of all by this
    /// many times their distance. 0 leaves them where they are.
    pub explosion: f64,
}

impl Panel {
    /// A mesh in [`palette::CLAY`].
    pub fn mesh<'a>(mesh: impl Into<MeshView<'a>>) -> Self {
        let mesh = mesh.into().to_owned();
        Self { parts: vec![Part { mesh, colour: palette::CLAY }], explosion: 0.0 }
    }

    /// A mesh in [`palette::CLAY`], the caps that close its openings in [`palette::CAP`].
    pub fn closed_mesh(closed: &ClosedMesh) -> Self {
        let ClosedMesh { mesh, caps, .. } = closed;
        let surface = mesh.triangles.len().saturating_sub(*caps);
        let part = |triangles: &[[u32; 3]], colour| Part {
            mesh: TriangleMesh::new(mesh.positions.clone(), triangles.to_vec()),
            colour,
        };
        let (surface, caps) = mesh.triangles.split_at(surface);
        Self { parts: vec![part(surface, palette::CLAY), part(caps, palette::CAP)], explosion: 0.0 }
    }

    /// A mesh in as many colours as there are labels: one label per triangle, such as
    /// [`GroupedMesh::groups`](hullwright::GroupedMesh::groups). Label n has the colour of hull n.
    /// Triangles without a label are left out.
    pub fn labelled<'a>(mesh: impl Into<MeshView<'a>>, labels: &[u32]) -> Self {
        let mesh = mesh.into();
        let mut labelled: Vec<(u32, [u32; 3])> =
            labels.iter().copied().zip(mesh.triangles().iter().copied()).collect();
        labelled.sort_by_key(|(label, _)| *label);
        let nowhere = [f64::NAN; 3];
        let part = |chunk: &[(u32, [u32; 3])]| {
            let corners = chunk.iter().flat_map(|(_, triangle)| triangle);
            let label = chunk.first().map_or(0, |(label, _)| *label);
            let triangles = (0..chunk.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]);
            let positions = corners.map(|&vertex| mesh.position(vertex).unwrap_or(nowhere));
            Part {
                mesh: TriangleMesh::new(positions.collect(), triangles.collect()),
                colour: palette::colour(label as usize),
            }
        };
        Self { parts: labelled.chunk_by(|a, b| a.0 == b.0).map(part).collect(), explosion: 0.0 }
    }

    /// Hulls in the colours of the palette, in order.
    pub fn hulls<'h, H>(hulls: &'h [H]) -> Self
    where
        &'h H: Into<MeshView<'h>>,
    {
        let part = |(index, hull): (usize, &'h H)| Part {
            mesh: hull.into().to_owned(),
            colour: palette::colour(index),
        };
        Self { parts: hulls.iter().enumerate().map(part).collect(), explosion: 0.0 }
    }

    /// The same with its parts moved apart; see [`explosion`](Self::explosion). 0.5 is a good
    /// value.
    #[must_use]
    pub fn exploded(mut self, explosion: f64) -> Self {
        self.explosion = explosion;
        self
    }

    /// Each part with the way that it is moved.
    pub(super) fn moved_parts(&self) -> Vec<(&Part, Vector)> {
        let all = self.parts.iter().flat_map(|part| part.corners().flatten());
        let Some(middle_of_all) = middle(all) else {
            return Vec::new();
        };
        let explosion = if self.explosion.is_finite() { self.explosion } else { 0.0 };
        let way = |part: &Part| {
            let middle = part.middle().unwrap_or(middle_of_all);
            (middle - middle_of_all) * explosion
        };
        self.parts.iter().map(|part| (part, way(part))).collect()
    }
}

/// Middle of the bounding box.
fn middle(points: impl Iterator<Item = Vector>) -> Option<Vector> {
    let bounds = points.fold(None, |bounds, point| match bounds {
        None => Some((point, point)),
        Some((min, max)) => Some((min.min(point), max.max(point))),
    });
    bounds.map(|(min, max)| (min + max) * 0.5)
}

/// Where the viewer stands.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Angle about the up axis in degrees: 0 looks at the front, greater ones from the right.
    pub azimuth: f64,
    /// Angle above the horizon in degrees.
    pub elevation: f64,
    /// Angle from one side of the scene's bounding sphere to the other, in degrees; clamped to
    /// 0.5 to 90. Small is like parallel projection.
    pub field_of_view: f64,
    /// Which axis points up.
    pub up: UpAxis,
}

impl Default for View {
    fn default() -> Self {
        Self { azimuth: 35.0, elevation: 26.0, field_of_view: 22.0, up: UpAxis::Y }
    }
}

/// How panels are laid out.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Layout {
    /// Panels per row; `None` for a single row.
    pub columns: Option<usize>,
    /// Whether each panel is fitted on its own. Otherwise all panels that are not exploded are
    /// shown at the same scale, so that they can be compared.
    pub separate_frames: bool,
    /// Whether the edges of all triangles are drawn, not only creases.
    pub wires: bool,
    /// Where the viewer stands, for all panels.
    pub view: View,
}
