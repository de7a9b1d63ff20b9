//! A picture in memory and as a PNG file.

/// Smallest width or height of a picture \[pixels\].
pub const MIN_SIDE: u32 = 16;

/// Largest width or height of a picture \[pixels\]: four times that many samples in memory stay below 2 GB.
pub const MAX_SIDE: u32 = 4096;

/// A picture, rows from the top, three bytes (sRGB) a pixel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Red, green, blue of each pixel.
    pub rgb: Vec<u8>,
}

impl Image {
    /// The picture as a PNG file.
    ///
    /// # Errors
    /// When the sizes do not fit the bytes.
    pub fn png(&self) -> Result<Vec<u8>, png::EncodingError> {
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, self.width, self.height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encoder.write_header()?.write_image_data(&self.rgb)?;
        Ok(file)
    }
}
