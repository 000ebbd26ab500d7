//! Where panels are in the picture, and where the viewer stands.

use super::UpAxis;

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
    /// Where the viewer stands, for all panels.
    pub view: View,
}
