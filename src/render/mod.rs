//! Pictures of meshes and hulls, drawn without a GPU.
//!
//! A [`Panel`] holds what is seen together: a source mesh, its hulls, its hulls moved apart.
//! [`render`] draws panels side by side into a [`Picture`], which can be written as PNG:
//!
//! ```no_run
//! # fn main() -> Result<(), hullwright::Error> {
//! # let mesh = hullwright::MeshView::new(&[[0.0; 3]], &[[0, 0, 0]]);
//! use hullwright::render::{Panel, render};
//!
//! let hulls = hullwright::decompose(
//!     mesh, &Default::default(), &Default::default(),
//! )?.hulls;
//! let panels = [
//!     Panel::mesh(mesh),
//!     Panel::hulls(&hulls),
//!     Panel::hulls(&hulls).exploded(0.5),
//! ];
//! render(&panels, 1500, 500)?.write_png("hulls.png")?;
//! # Ok(()) }
//! ```
//!
//! It is a z-buffer with 9 samples per pixel, flat shading with soft light from over the viewer's
//! left shoulder, shade in corners, and quiet lines along edges. The same input gives the same
//! bytes.
//!
//! This file is long because a third of it is examples.

mod camera;
pub mod palette;
mod raster;
mod shade;

use std::path::Path;

#[cfg(feature = "parallel")]
use rayon::prelude::*;

use crate::error::Error;
use crate::geometry::vector::{Vector, add, maximum, minimum, scale, subtract};
use crate::geometry::{MeshView, TriangleMesh};
use crate::openings::ClosedMesh;
pub use crate::parameters::UpAxis;
use camera::{Camera, Projection};
pub use palette::Colour;
use raster::{SeenTriangle, rasterize};
use shade::{BACKGROUND, SUPERSAMPLING, Shader};

/// Greatest width and height of a picture, in pixels: the samples of a full square of it are
/// still under 1.5 GB.
const LARGEST_SIDE: usize = 4096;

/// Coordinates beyond this would overflow when squared: what uses them is not drawn.
const LARGEST_COORDINATE: f64 = 1e100;

/// Triangles of one colour that move together when a panel is exploded.
#[derive(Debug, Clone, Default)]
pub struct Part {
    /// What is drawn. Triangles with an index out of range, or with a coordinate that is not finite or
    /// beyond 1e100, are left out. Winding does not matter.
    pub mesh: TriangleMesh,
    /// Its colour in full light.
    pub colour: Colour,
}

impl Part {
    /// The corners of the triangles that can be drawn.
    fn corners(&self) -> impl Iterator<Item = [Vector; 3]> + Clone {
        self.mesh.triangles.iter().filter_map(|triangle| {
            let mut corners = [[0.0; 3]; 3];
            for (corner, index) in corners.iter_mut().zip(triangle) {
                let position = *self.mesh.positions.get(*index as usize)?;
                if !position.iter().all(|value| value.abs() <= LARGEST_COORDINATE) {
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
    ///
    /// ```
    /// # let mesh = hullwright::TriangleMesh::new(
    /// #     vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    /// #     vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    /// # );
    /// assert_eq!(hullwright::render::Panel::mesh(&mesh).parts.len(), 1);
    /// ```
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
    /// [`GroupedMesh::groups`](crate::GroupedMesh::groups). Label n has the colour of hull n.
    /// Triangles without a label are left out.
    ///
    /// ```
    /// # let mesh = hullwright::TriangleMesh::new(
    /// #     vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    /// #     vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    /// # );
    /// let panel = hullwright::render::Panel::labelled(&mesh, &[0, 0, 1, 1]);
    /// assert_eq!(panel.parts.len(), 2);
    /// ```
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
    ///
    /// ```
    /// # let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    /// let hull = hullwright::convex_hull(&points)?;
    /// let panel = hullwright::render::Panel::hulls(&[hull.clone(), hull]);
    /// assert_ne!(panel.parts[0].colour, panel.parts[1].colour);
    /// # Ok::<(), hullwright::Error>(())
    /// ```
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
    ///
    /// ```
    /// use hullwright::render::Panel;
    ///
    /// assert_eq!(Panel::default().exploded(0.5).explosion, 0.5);
    /// ```
    #[must_use]
    pub fn exploded(mut self, explosion: f64) -> Self {
        self.explosion = explosion;
        self
    }

    /// Each part with the way that it is moved.
    fn moved_parts(&self) -> Vec<(&Part, Vector)> {
        let all = self.parts.iter().flat_map(|part| part.corners().flatten());
        let Some(middle_of_all) = middle(all) else {
            return Vec::new();
        };
        let explosion = if self.explosion.is_finite() { self.explosion } else { 0.0 };
        let way = |part: &Part| {
            let middle = part.middle().unwrap_or(middle_of_all);
            scale(subtract(middle, middle_of_all), explosion)
        };
        self.parts.iter().map(|part| (part, way(part))).collect()
    }
}

/// Middle of the bounding box.
fn middle(points: impl Iterator<Item = Vector>) -> Option<Vector> {
    let bounds = points.fold(None, |bounds, point| match bounds {
        None => Some((point, point)),
        Some((min, max)) => Some((minimum(min, point), maximum(max, point))),
    });
    bounds.map(|(min, max)| scale(add(min, max), 0.5))
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
    /// Where the viewer stands, for all panels.
    pub view: View,
}

/// Pixels in sRGB, 8 bits per channel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    width: usize,
    height: usize,
    pixels: Vec<Colour>,
}

impl Picture {
    /// Width in pixels.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height in pixels.
    pub fn height(&self) -> usize {
        self.height
    }

    /// The colour of a pixel, counted from the top left; `None` outside.
    pub fn pixel(&self, column: usize, row: usize) -> Option<Colour> {
        let inside = column < self.width && row < self.height;
        inside.then(|| self.pixels.get(row * self.width + column).copied())?
    }

    /// All pixels, row by row from the top.
    pub fn pixels(&self) -> &[Colour] {
        &self.pixels
    }

    /// The bytes of a PNG file.
    ///
    /// # Errors
    /// [`Error::File`], without a path, if the encoder refuses.
    ///
    /// ```
    /// # let mesh = hullwright::TriangleMesh::new(
    /// #     vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    /// #     vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    /// # );
    /// let picture = hullwright::render::render(&[hullwright::render::Panel::mesh(&mesh)], 32, 32)?;
    /// assert!(picture.to_png()?.starts_with(b"\x89PNG"));
    /// # Ok::<(), hullwright::Error>(())
    /// ```
    pub fn to_png(&self) -> Result<Vec<u8>, Error> {
        let refused = |reason: String| Error::file(Path::new("PNG"), reason);
        let mut bytes = Vec::new();
        // Sides are at most `LARGEST_SIDE`.
        let mut encoder = png::Encoder::new(&mut bytes, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encoder.set_compression(png::Compression::High);
        let written = encoder.write_header().and_then(|mut writer| {
            writer.write_image_data(self.pixels.as_flattened())?;
            writer.finish()
        });
        written.map_err(|error| refused(error.to_string()))?;
        Ok(bytes)
    }

    /// Writes a PNG file.
    ///
    /// # Errors
    /// [`Error::File`] says what is wrong with the path.
    pub fn write_png(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        let path = path.as_ref();
        let bytes = self.to_png()?;
        crate::atomic_write::write(path, &bytes).map_err(|error| Error::file(path, error))
    }
}

/// Draws panels side by side in one row, from three quarters above. A picture is `width` by
/// `height` pixels.
///
/// # Errors
/// [`Error::InvalidParameter`] unless both sides are 1 to 4096 pixels.
///
/// ```
/// # let mesh = hullwright::TriangleMesh::new(
/// #     vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
/// #     vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
/// # );
/// let picture = hullwright::render::render(&[hullwright::render::Panel::mesh(&mesh)], 32, 16)?;
/// assert_eq!(picture.pixels().len(), 32 * 16);
/// # Ok::<(), hullwright::Error>(())
/// ```
pub fn render(panels: &[Panel], width: usize, height: usize) -> Result<Picture, Error> {
    render_with(panels, width, height, &Layout::default())
}

/// As [`render`], with a choice of layout and view. O(triangles + pixels).
///
/// # Errors
/// [`Error::InvalidParameter`] unless both sides are 1 to 4096 pixels.
///
/// ```
/// # let mesh = hullwright::TriangleMesh::new(
/// #     vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
/// #     vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
/// # );
/// use hullwright::render::{Layout, Panel, UpAxis, render_with};
///
/// let mut layout = Layout::default();
/// layout.view.up = UpAxis::Z;
/// let picture = render_with(&[Panel::mesh(&mesh)], 32, 16, &layout)?;
/// assert_eq!((picture.width(), picture.height()), (32, 16));
/// # Ok::<(), hullwright::Error>(())
/// ```
pub fn render_with(
    panels: &[Panel],
    width: usize,
    height: usize,
    layout: &Layout,
) -> Result<Picture, Error> {
    for (name, side) in [("width", width), ("height", height)] {
        if !(1..=LARGEST_SIDE).contains(&side) {
            return Err(Error::InvalidParameter {
                name,
                reason: format!("must be 1 to {LARGEST_SIDE} pixels, not {side}"),
            });
        }
    }
    let mut picture = Picture { width, height, pixels: vec![BACKGROUND; width * height] };
    let columns = layout.columns.unwrap_or(panels.len()).clamp(1, panels.len().max(1));
    let rows = panels.len().div_ceil(columns).max(1);
    let drawn: Vec<Vec<(&Part, Vector)>> = panels.iter().map(Panel::moved_parts).collect();
    let shares_frame = |panel: &Panel| !layout.separate_frames && panel.explosion == 0.0;
    let shared: Vec<Vector> = panels
        .iter()
        .zip(&drawn)
        .filter(|(panel, _)| shares_frame(panel))
        .flat_map(|(_, parts)| moved_points(parts))
        .collect();
    let (panel_width, panel_height) = (width / columns, height / rows);
    for (index, (panel, parts)) in panels.iter().zip(&drawn).enumerate() {
        let place = Place {
            left: index % columns * panel_width,
            top: index / columns * panel_height,
            width: panel_width,
            height: panel_height,
        };
        if shares_frame(panel) {
            draw_panel(&mut picture, &place, parts, &shared, &layout.view);
        } else {
            let own: Vec<Vector> = moved_points(parts).collect();
            draw_panel(&mut picture, &place, parts, &own, &layout.view);
        }
    }
    Ok(picture)
}

/// A panel's rectangle in the picture, in pixels.
struct Place {
    left: usize,
    top: usize,
    width: usize,
    height: usize,
}

fn moved_points<'p>(parts: &'p [(&Part, Vector)]) -> impl Iterator<Item = Vector> + 'p {
    parts
        .iter()
        .flat_map(|(part, way)| part.corners().flatten().map(move |corner| add(corner, *way)))
}

/// Draws parts, fitted so that all points of `frame` are in the panel.
fn draw_panel(
    picture: &mut Picture,
    place: &Place,
    parts: &[(&Part, Vector)],
    frame: &[Vector],
    view: &View,
) {
    // So many panels that none has a pixel.
    if place.width == 0 || place.height == 0 {
        return;
    }
    let (width, height) = (place.width * SUPERSAMPLING, place.height * SUPERSAMPLING);
    let camera = Camera::facing(frame.iter().copied(), view);
    let seen = frame.iter().map(|point| camera.see(*point));
    let projection = Projection::fitting(camera, seen, width, height);
    let mut triangles = Vec::new();
    for (index, (part, way)) in (0u32..).zip(parts) {
        triangles.extend(part.corners().map(|corners| {
            let corners = corners.map(|corner| camera.see(add(corner, *way)));
            SeenTriangle::new(corners, index, projection.viewer())
        }));
    }
    let samples = rasterize(&triangles, &projection, width, height);
    let colours = parts.iter().map(|(part, _)| part.colour);
    let shader = Shader::new(&samples, &triangles, &projection, colours);
    let mut pixels = vec![BACKGROUND; place.width * place.height];
    let draw_row = |(row, line): (usize, &mut [Colour])| {
        for (column, pixel) in line.iter_mut().enumerate() {
            *pixel = shader.pixel(column, row);
        }
    };
    #[cfg(feature = "parallel")]
    pixels.par_chunks_mut(place.width).enumerate().for_each(draw_row);
    #[cfg(not(feature = "parallel"))]
    pixels.chunks_mut(place.width).enumerate().for_each(draw_row);
    for (row, line) in pixels.chunks(place.width).enumerate() {
        let start = (place.top + row) * picture.width + place.left;
        picture.pixels[start..start + place.width].copy_from_slice(line);
    }
}

#[cfg(test)]
mod tests;
