//! Pictures of meshes and hulls, drawn without a GPU.
//!
//! A [`Panel`] holds what is seen together: a source mesh, its hulls, its hulls moved apart.
//! [`render`] draws panels side by side into a [`Picture`], which can be written as PNG:
//!
//! ```no_run
//! # fn main() -> Result<(), hullwright::Error> {
//! # let mesh = hullwright::MeshView::new(&[[0.0; 3]], &[[0, 0, 0]]);
//! use hullwright_cli::render::{Panel, render};
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

mod camera;
mod panel;
mod raster;
mod shade;

use std::path::Path;

use hullwright::Error;
use hullwright_formats::palette::Colour;
use hullwright_formats::write_file;
use rayon::prelude::*;

use crate::{Vector, unwritable};
use camera::{Camera, Projection};
pub use panel::{Layout, Panel, Part, View};
use raster::{SeenTriangle, rasterize};
use shade::{BACKGROUND, SUPERSAMPLING, Shader};

/// Greatest width and height of a picture, in pixels: the samples of a full square of it are
/// still under 1.5 GB.
const LARGEST_SIDE: usize = 4096;

/// Draws panels side by side in one row, from three quarters above. A picture is `width` by
/// `height` pixels.
///
/// # Errors
/// [`Error::InvalidParameter`] unless both sides are 1 to 4096 pixels.
pub fn render(panels: &[Panel], width: usize, height: usize) -> Result<Picture, Error> {
    render_with(panels, width, height, &Layout::default())
}

/// As [`render`], with a choice of layout and view. O(triangles + pixels).
///
/// # Errors
/// [`Error::InvalidParameter`] unless both sides are 1 to 4096 pixels.
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
            draw_panel(&mut picture, &place, parts, &shared, layout);
        } else {
            let own: Vec<Vector> = moved_points(parts).collect();
            draw_panel(&mut picture, &place, parts, &own, layout);
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
    parts.iter().flat_map(|(part, way)| part.corners().flatten().map(move |corner| corner + *way))
}

/// Draws parts, fitted so that all points of `frame` are in the panel.
fn draw_panel(
    picture: &mut Picture,
    place: &Place,
    parts: &[(&Part, Vector)],
    frame: &[Vector],
    layout: &Layout,
) {
    // So many panels that none has a pixel.
    if place.width == 0 || place.height == 0 {
        return;
    }
    let (width, height) = (place.width * SUPERSAMPLING, place.height * SUPERSAMPLING);
    let camera = Camera::facing(frame.iter().copied(), &layout.view);
    let seen = frame.iter().map(|point| camera.see(*point));
    let projection = Projection::fitting(camera, seen, width, height);
    let mut triangles = Vec::new();
    for (index, (part, way)) in (0u32..).zip(parts) {
        triangles.extend(part.corners().map(|corners| {
            let corners = corners.map(|corner| camera.see(corner + *way));
            SeenTriangle::new(corners, index, projection.viewer())
        }));
    }
    let samples = rasterize(&triangles, &projection, width, height);
    let colours = parts.iter().map(|(part, _)| part.colour);
    let mut shader = Shader::new(&samples, &triangles, &projection, colours);
    shader.wires = layout.wires;
    let mut pixels = vec![BACKGROUND; place.width * place.height];
    let draw_row = |(row, line): (usize, &mut [Colour])| {
        for (column, pixel) in line.iter_mut().enumerate() {
            *pixel = shader.pixel(column, row);
        }
    };
    pixels.par_chunks_mut(place.width).enumerate().for_each(draw_row);
    for (row, line) in pixels.chunks(place.width).enumerate() {
        let start = (place.top + row) * picture.width + place.left;
        picture.pixels[start..start + place.width].copy_from_slice(line);
    }
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
    pub fn to_png(&self) -> Result<Vec<u8>, Error> {
        let mut bytes = Vec::new();
        // Sides are at most [`LARGEST_SIDE`].
        let mut encoder = png::Encoder::new(&mut bytes, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encoder.set_compression(png::Compression::High);
        let written = encoder.write_header().and_then(|mut writer| {
            writer.write_image_data(self.pixels.as_flattened())?;
            writer.finish()
        });
        written.map_err(|error| unwritable("PNG", error))?;
        Ok(bytes)
    }

    /// Writes a PNG file.
    ///
    /// # Errors
    /// [`Error::File`] says what is wrong with the path.
    pub fn write_png(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        write_file(path, &self.to_png()?)
    }
}

#[cfg(test)]
mod tests;
