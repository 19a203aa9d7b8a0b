//! Images that hold several pictures: animated GIF, PNG and WebP files, sheets of sprites, files that are numbered.

use super::error::Problem;
use super::picture::{MOST_PIXELS, Picture, Transfer, check_size, explain, limits, to_picture, too_large};
use crate::exemplar::Image;
use image::codecs::gif::GifDecoder;
use image::codecs::png::PngDecoder;
use image::codecs::webp::WebPDecoder;
use image::metadata::Orientation;
use image::{AnimationDecoder, DynamicImage, Frame, ImageDecoder, ImageError, ImageFormat};
use std::ffi::OsString;
use std::io::Cursor;
use std::path::{Path, PathBuf};

/// A picture of several, and how long its file shows it, in seconds; `None` if the file does not say.
pub(super) type Timed = (Picture, Option<f64>);

/// The pictures of an animated file; none if it holds a single one, or is of a kind that cannot hold more.
pub(super) fn decode_frames(file: &[u8], format: Option<ImageFormat>, transfer: Transfer) -> Result<Vec<Timed>, Problem> {
    let damaged = |e: ImageError| Problem::damaged("", format!("the animation cannot be decoded ({e})"));
    let (frames, orientation) = match format {
        Some(ImageFormat::Gif) => {
            let mut decoder = GifDecoder::new(Cursor::new(file)).map_err(damaged)?;
            let orientation = bound(&mut decoder)?;
            (decoder.into_frames(), orientation)
        }
        Some(ImageFormat::Png) => {
            let mut decoder = PngDecoder::with_limits(Cursor::new(file), limits()).map_err(|e| explain(&e))?;
            if !decoder.is_apng().map_err(damaged)? {
                return Ok(Vec::new());
            }
            let orientation = bound(&mut decoder)?;
            (decoder.apng().map_err(damaged)?.into_frames(), orientation)
        }
        Some(ImageFormat::WebP) => {
            let mut decoder = WebPDecoder::new(Cursor::new(file)).map_err(damaged)?;
            if !decoder.has_animation() {
                return Ok(Vec::new());
            }
            let orientation = bound(&mut decoder)?;
            (decoder.into_frames(), orientation)
        }
        _ => return Ok(Vec::new()),
    };
    let mut pixels = 0;
    let mut out = Vec::new();
    for frame in frames {
        let frame = frame.map_err(damaged)?;
        pixels += u64::from(frame.buffer().width()) * u64::from(frame.buffer().height());
        if pixels > MOST_PIXELS {
            return Err(too_large(&format!("has that in its first {} pictures", out.len() + 1)));
        }
        let seconds = seconds_of(&frame);
        let mut image = DynamicImage::ImageRgba8(frame.into_buffer());
        image.apply_orientation(orientation);
        out.push((to_picture(&image, transfer).ok_or_else(|| Problem::damaged("", "a picture has no pixels"))?, seconds));
    }
    Ok(if out.len() > 1 { out } else { Vec::new() })
}

/// Keeps a decoder to the limits of still images before it sets memory aside; how its pictures are turned.
fn bound(decoder: &mut impl ImageDecoder) -> Result<Orientation, Problem> {
    decoder.set_limits(limits()).map_err(|e| explain(&e))?;
    check_size(decoder.dimensions())?;
    // A file without readable metadata is upright.
    Ok(decoder.orientation().unwrap_or(Orientation::NoTransforms))
}

fn seconds_of(frame: &Frame) -> Option<f64> {
    let (milliseconds, per) = frame.delay().numer_denom_ms();
    // Files that ask for no time mean "as fast as is usual".
    (milliseconds > 0 && per > 0).then(|| f64::from(milliseconds) / f64::from(per) / 1000.0)
}

/// The part of an image under a cell of a sheet of `cells` across and down.
pub(super) fn sprite(sheet: &Image, cells: [u32; 2], number: u32) -> Image {
    let [w, h] = [sheet.size()[0] / cells[0], sheet.size()[1] / cells[1]];
    let at = |x: u32, y: u32| sheet.pixel(i64::from(number % cells[0] * w + x), i64::from(number / cells[0] * h + y));
    if sheet.components() == 3 { Image::from_fn(w, h, at) } else { Image::grey_from_fn(w, h, |x, y| at(x, y).x) }
}

/// The files of a sequence that begins with this one: those beside it whose names differ in their last number alone, which rises
/// from one to the next.
pub(super) fn sequence(first: &Path) -> Result<Vec<PathBuf>, Problem> {
    let remedy = "name the first of files like fire_01.png, fire_02.png";
    let stem = first.file_stem().and_then(|s| s.to_str()).unwrap_or_default();
    let digits = stem.bytes().rev().take_while(u8::is_ascii_digit).count();
    let (name, number) = stem.split_at(stem.len() - digits);
    let Ok(start) = number.parse::<u64>() else {
        return Err(Problem::new("", "its name does not end in a number, so it begins no sequence", remedy));
    };
    let file = |k: u64| {
        // The name may have dots of its own, so the extension is added, not set.
        let mut file = OsString::from(format!("{name}{k:0digits$}"));
        if let Some(extension) = first.extension() {
            file.push(".");
            file.push(extension);
        }
        first.with_file_name(file)
    };
    let files: Vec<PathBuf> = (start..=u64::MAX).map(file).take_while(|path| path.is_file()).collect();
    if files.len() > 1 {
        return Ok(files);
    }
    let next = start.checked_add(1).map_or_else(|| "number".to_owned(), |k| file(k).display().to_string());
    Err(Problem::new("", format!("there is no {next} after it, so it begins no sequence"), remedy))
}
