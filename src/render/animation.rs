//! Pictures that follow one another, in one file.

use super::RenderError;
use super::picture::Picture;

fn failed(reason: impl ToString) -> RenderError {
    RenderError::Encode { reason: reason.to_string() }
}

/// Pictures that are written as they come, one after another, into one file's bytes. They are not kept.
pub struct Film<'a> {
    size: [u32; 2],
    /// Pictures that were announced and have not come.
    missing: u32,
    to: Encoder<'a>,
}

enum Encoder<'a> {
    Apng(Box<png::Writer<&'a mut Vec<u8>>>),
    Gif(Box<image::codecs::gif::GifEncoder<&'a mut Vec<u8>>>, image::Delay),
}

impl<'a> Film<'a> {
    /// An animated PNG of `count` pictures that repeats for ever, `per_second` of them each second: all colours, opacity, larger
    /// than a GIF.
    ///
    /// # Errors
    /// If there are no pictures or no pixels.
    pub fn apng(bytes: &'a mut Vec<u8>, size: [u32; 2], count: u32, per_second: u16) -> Result<Self, RenderError> {
        let mut encoder = png::Encoder::new(bytes, size[0], size[1]);
        encoder.set_color(png::ColorType::Rgba);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encoder.set_animated(count, 0).map_err(failed)?;
        encoder.set_frame_delay(1, per_second.max(1)).map_err(failed)?;
        Ok(Self { size, missing: count, to: Encoder::Apng(Box::new(encoder.write_header().map_err(failed)?)) })
    }

    /// A GIF that repeats for ever, `per_second` pictures each second: 256 colours a picture, opacity all or nothing.
    ///
    /// # Errors
    /// If it cannot begin.
    pub fn gif(bytes: &'a mut Vec<u8>, size: [u32; 2], per_second: u16) -> Result<Self, RenderError> {
        /// How hard the palette is looked for, 1 (most) to 30: beyond 10 bands are seen.
        const EFFORT: i32 = 10;
        let mut encoder = image::codecs::gif::GifEncoder::new_with_speed(bytes, EFFORT);
        encoder.set_repeat(image::codecs::gif::Repeat::Infinite).map_err(failed)?;
        let delay = image::Delay::from_numer_denom_ms(1000, u32::from(per_second.max(1)));
        Ok(Self { size, missing: 0, to: Encoder::Gif(Box::new(encoder), delay) })
    }

    /// Writes the next picture.
    ///
    /// # Errors
    /// If it has another size, a side longer than the 65,535 pixels that a GIF can have, or there are more than were announced.
    pub fn push(&mut self, picture: &Picture) -> Result<(), RenderError> {
        if [picture.width, picture.height] != self.size {
            return Err(failed("the frames differ in size"));
        }
        match &mut self.to {
            Encoder::Apng(writer) => {
                self.missing = self.missing.checked_sub(1).ok_or_else(|| failed("more frames came than were announced"))?;
                writer.write_image_data(&picture.rgba).map_err(failed)
            }
            Encoder::Gif(encoder, delay) => {
                let buffer = image::RgbaImage::from_raw(picture.width, picture.height, picture.rgba.clone());
                let buffer = buffer.ok_or_else(|| failed("a frame has too few pixels"))?;
                encoder.encode_frame(image::Frame::from_parts(buffer, 0, 0, *delay)).map_err(failed)
            }
        }
    }

    /// Ends the file.
    ///
    /// # Errors
    /// If fewer pictures came than were announced.
    pub fn finish(self) -> Result<(), RenderError> {
        if self.missing > 0 {
            return Err(failed("fewer frames came than were announced"));
        }
        match self.to {
            Encoder::Apng(writer) => writer.finish().map_err(failed),
            Encoder::Gif(..) => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::AnimationDecoder;

    #[test]
    fn frames_come_back_in_their_order() {
        let frames: Vec<Picture> = (0..3).map(|k| Picture::filled(9, 5, [80 * k, 255 - 80 * k, 7, 255])).collect();
        let mut files = [Vec::new(), Vec::new()];
        let [first, second] = &mut files;
        for mut film in [Film::apng(first, [9, 5], 3, 24).unwrap(), Film::gif(second, [9, 5], 24).unwrap()] {
            frames.iter().for_each(|frame| film.push(frame).unwrap());
            film.finish().unwrap();
        }
        let [first, second] = files.map(std::io::Cursor::new);
        let png = image::codecs::png::PngDecoder::new(first).unwrap();
        let gif = image::codecs::gif::GifDecoder::new(second).unwrap();
        let decoded = [png.apng().unwrap().into_frames().collect_frames(), gif.into_frames().collect_frames()];
        for (decoded, bound) in decoded.into_iter().zip([0, 4]) {
            let decoded = decoded.unwrap();
            assert_eq!(decoded.len(), 3, "all frames");
            for (back, frame) in decoded.iter().zip(&frames) {
                let far = back.buffer().as_raw().iter().zip(&frame.rgba).map(|(a, b)| a.abs_diff(*b)).max();
                assert!(far <= Some(bound), "colours within {bound}: {far:?}");
            }
        }
    }

    #[test]
    fn what_is_no_film_is_refused() {
        let picture = Picture::filled(9, 5, [0; 4]);
        let mut bytes = Vec::new();
        assert!(Film::apng(&mut bytes, [9, 5], 0, 24).is_err(), "nothing to show");
        let mut film = Film::apng(&mut bytes, [9, 5], 2, 24).unwrap();
        assert!(film.push(&Picture::filled(2, 2, [0; 4])).is_err(), "two sizes");
        film.push(&picture).unwrap();
        assert!(film.finish().is_err(), "one is missing");
    }
}
