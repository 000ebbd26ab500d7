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
    ///
    /// ```
    /// # let mesh = hullwright::TriangleMesh::new(
    /// #     vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    /// #     vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    /// # );
    /// let picture = hullwright::render::render(&[hullwright::render::Panel::mesh(&mesh)], 32, 24)?;
    /// assert_eq!(picture.width(), 32);
    /// # Ok::<(), hullwright::Error>(())
    /// ```
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height in pixels.
    ///
    /// ```
    /// # let mesh = hullwright::TriangleMesh::new(
    /// #     vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    /// #     vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    /// # );
    /// let picture = hullwright::render::render(&[hullwright::render::Panel::mesh(&mesh)], 32, 24)?;
    /// assert_eq!(picture.height(), 24);
    /// # Ok::<(), hullwright::Error>(())
    /// ```
    pub fn height(&self) -> usize {
        self.height
    }

    /// The colour of a pixel, counted from the top left; `None` outside.
    ///
    /// ```
    /// # let mesh = hullwright::TriangleMesh::new(
    /// #     vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    /// #     vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    /// # );
    /// let picture = hullwright::render::render(&[hullwright::render::Panel::mesh(&mesh)], 32, 24)?;
    /// assert!(picture.pixel(31, 23).is_some() && picture.pixel(32, 0).is_none());
    /// # Ok::<(), hullwright::Error>(())
    /// ```
    pub fn pixel(&self, column: usize, row: usize) -> Option<Colour> {
        let inside = column < self.width && row < self.height;
        inside.then(|| self.pixels.get(row * self.width + column).copied())?
    }

    /// All pixels, row by row from the top.
    ///
    /// ```
    /// # let mesh = hullwright::TriangleMesh::new(
    /// #     vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    /// #     vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    /// # );
    /// let picture = hullwright::render::render(&[hullwright::render::Panel::mesh(&mesh)], 32, 24)?;
    /// assert_eq!(picture.pixels().len(), 32 * 24);
    /// # Ok::<(), hullwright::Error>(())
    /// ```
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
    ///
    /// ```
    /// # let mesh = hullwright::TriangleMesh::new(
    /// #     vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    /// #     vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    /// # );
    /// # let directory = tempfile::tempdir()?;
    /// # let path = directory.path().join("tetrahedron.png");
    /// let picture = hullwright::render::render(&[hullwright::render::Panel::mesh(&mesh)], 32, 32)?;
    /// picture.write_png(&path)?;
    /// assert_eq!(std::fs::read(&path)?, picture.to_png()?);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn write_png(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        let path = path.as_ref();
        let bytes = self.to_png()?;
        crate::atomic_write::write(path, &bytes).map_err(|error| Error::file(path, error))
    }
}
