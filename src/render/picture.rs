//! Finished pictures: eight bits a channel, and their way into a PNG file.

use super::RenderError;
use glam::Vec3;

/// An sRGB picture with straight (not premultiplied) alpha.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Red, green, blue, alpha of each pixel, rows from the top.
    pub rgba: Vec<u8>,
}

impl Picture {
    /// A picture of one colour.
    #[must_use]
    pub fn filled(width: u32, height: u32, colour: [u8; 4]) -> Self {
        Self { width, height, rgba: colour.repeat(width as usize * height as usize) }
    }

    /// A pixel; transparent black outside.
    #[must_use]
    pub fn pixel(&self, x: u32, y: u32) -> [u8; 4] {
        if x >= self.width || y >= self.height {
            return [0; 4];
        }
        let i = 4 * (y as usize * self.width as usize + x as usize);
        [self.rgba[i], self.rgba[i + 1], self.rgba[i + 2], self.rgba[i + 3]]
    }

    /// Lays a colour (sRGB, 0 to 1) over a pixel with an opacity; outside nothing happens.
    pub fn blend(&mut self, x: i64, y: i64, colour: Vec3, opacity: f32) {
        if x < 0 || y < 0 || x >= i64::from(self.width) || y >= i64::from(self.height) || opacity <= 0.0 {
            return;
        }
        let i = 4 * (y as usize * self.width as usize + x as usize);
        let below = f32::from(self.rgba[i + 3]) / 255.0;
        let above = opacity.min(1.0);
        let alpha = above + below * (1.0 - above);
        for (k, c) in colour.to_array().into_iter().enumerate() {
            let old = f32::from(self.rgba[i + k]) / 255.0;
            self.rgba[i + k] = to_byte((c * above + old * below * (1.0 - above)) / alpha);
        }
        self.rgba[i + 3] = to_byte(alpha);
    }

    /// Copies another picture in, its top left corner at (x, y); what does not fit is cut off.
    pub fn paste(&mut self, other: &Self, x: u32, y: u32) {
        let columns = other.width.min(self.width.saturating_sub(x)) as usize;
        for row in 0..other.height.min(self.height.saturating_sub(y)) {
            let from = 4 * row as usize * other.width as usize;
            let to = 4 * ((y + row) as usize * self.width as usize + x as usize);
            self.rgba[to..to + 4 * columns].copy_from_slice(&other.rgba[from..from + 4 * columns]);
        }
    }

    /// The picture as the bytes of a PNG file.
    ///
    /// # Errors
    /// If the encoder refuses it.
    pub fn png(&self) -> Result<Vec<u8>, RenderError> {
        use image::ImageEncoder;
        use image::codecs::png::{CompressionType, FilterType, PngEncoder};
        let mut bytes = Vec::new();
        let encoder = PngEncoder::new_with_quality(&mut bytes, CompressionType::Default, FilterType::Adaptive);
        let opaque = self.rgba.as_chunks::<4>().0.iter().all(|p| p[3] == 255);
        let (data, colour) = if opaque {
            let rgb: Vec<u8> = self.rgba.as_chunks::<4>().0.iter().flat_map(|p| [p[0], p[1], p[2]]).collect();
            (rgb, image::ExtendedColorType::Rgb8)
        } else {
            (self.rgba.clone(), image::ExtendedColorType::Rgba8)
        };
        encoder.write_image(&data, self.width, self.height, colour).map_err(|e| RenderError::Encode { reason: e.to_string() })?;
        Ok(bytes)
    }
}

/// 0 to 1 as a byte, rounded.
#[inline]
#[must_use]
pub fn to_byte(value: f32) -> u8 {
    (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn png_bytes_read_back_as_the_same_pixels() {
        let mut picture = Picture::filled(7, 5, [10, 20, 30, 255]);
        for alpha in [255, 90] {
            picture.rgba[4 * 8 + 3] = alpha;
            let back = image::load_from_memory(&picture.png().unwrap()).unwrap().to_rgba8();
            assert_eq!(back.as_raw(), &picture.rgba, "alpha {alpha}");
        }
    }

    #[test]
    fn pasting_outside_cuts_off() {
        let mut sheet = Picture::filled(4, 4, [0, 0, 0, 255]);
        sheet.paste(&Picture::filled(3, 3, [9; 4]), 2, 3);
        assert_eq!([sheet.pixel(1, 3), sheet.pixel(2, 3), sheet.pixel(3, 3)], [[0, 0, 0, 255], [9; 4], [9; 4]], "bottom row");
    }
}
