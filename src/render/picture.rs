//! Pixels, and the PNG file made of them.

use std::path::Path;

use super::palette::Colour;
use crate::error::Error;

/// Pixels in sRGB, 8 bits per channel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) pixels: Vec<Colour>,
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
        let refused = |reason: String| Error::file(Path::new("PNG"), reason);
        let mut bytes = Vec::new();
        // Sides are at most `super::LARGEST_SIDE`.
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
