//! Pictures that follow one another, in one file.

use super::RenderError;
use super::picture::Picture;

fn failed(reason: impl ToString) -> RenderError {
    RenderError::Encode { reason: reason.to_string() }
}

fn same_size(frames: &[Picture]) -> Result<&Picture, RenderError> {
    let first = frames.first().ok_or_else(|| failed("there are no frames"))?;
    let same = frames.iter().all(|f| (f.width, f.height) == (first.width, first.height));
    if same { Ok(first) } else { Err(failed("the frames differ in size")) }
}

/// An animated PNG that repeats for ever, `per_second` pictures each second: all colours, opacity, larger than a GIF.
///
/// # Errors
/// If there are no pictures, or they differ in size.
pub fn apng(frames: &[Picture], per_second: u16) -> Result<Vec<u8>, RenderError> {
    let first = same_size(frames)?;
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, first.width, first.height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder.set_animated(frames.len() as u32, 0).map_err(failed)?;
    encoder.set_frame_delay(1, per_second.max(1)).map_err(failed)?;
    let mut writer = encoder.write_header().map_err(failed)?;
    for frame in frames {
        writer.write_image_data(&frame.rgba).map_err(failed)?;
    }
    writer.finish().map_err(failed)?;
    Ok(bytes)
}

/// A GIF that repeats for ever, `per_second` pictures each second: 256 colours a picture, opacity all or nothing.
///
/// # Errors
/// If there are no pictures, they differ in size, or a side is longer than the 65,535 pixels that a GIF can have.
pub fn gif(frames: &[Picture], per_second: u16) -> Result<Vec<u8>, RenderError> {
    /// How hard the palette is looked for, 1 (most) to 30: beyond 10 bands are seen.
    const EFFORT: i32 = 10;
    same_size(frames)?;
    let mut bytes = Vec::new();
    let mut encoder = image::codecs::gif::GifEncoder::new_with_speed(&mut bytes, EFFORT);
    encoder.set_repeat(image::codecs::gif::Repeat::Infinite).map_err(failed)?;
    let delay = image::Delay::from_numer_denom_ms(1000, u32::from(per_second.max(1)));
    for frame in frames {
        let buffer = image::RgbaImage::from_raw(frame.width, frame.height, frame.rgba.clone());
        let buffer = buffer.ok_or_else(|| failed("a frame has too few pixels"))?;
        encoder.encode_frame(image::Frame::from_parts(buffer, 0, 0, delay)).map_err(failed)?;
    }
    drop(encoder);
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::AnimationDecoder;

    #[test]
    fn frames_come_back_in_their_order() {
        let frames: Vec<Picture> = (0..3).map(|k| Picture::filled(9, 5, [80 * k, 255 - 80 * k, 7, 255])).collect();
        let png = image::codecs::png::PngDecoder::new(std::io::Cursor::new(apng(&frames, 24).unwrap())).unwrap();
        let gif = image::codecs::gif::GifDecoder::new(std::io::Cursor::new(gif(&frames, 24).unwrap())).unwrap();
        let decoded = [png.apng().unwrap().into_frames().collect_frames(), gif.into_frames().collect_frames()];
        for (decoded, bound) in decoded.into_iter().zip([0, 4]) {
            let decoded = decoded.unwrap();
            assert_eq!(decoded.len(), 3, "all frames");
            for (back, frame) in decoded.iter().zip(&frames) {
                let far = back.buffer().as_raw().iter().zip(&frame.rgba).map(|(a, b)| a.abs_diff(*b)).max();
                assert!(far <= Some(bound), "colours within {bound}: {far:?}");
            }
        }
        assert!(apng(&[], 24).is_err() && super::gif(&[], 24).is_err(), "nothing to show");
        assert!(apng(&[frames[0].clone(), Picture::filled(2, 2, [0; 4])], 24).is_err(), "two sizes");
    }
}
