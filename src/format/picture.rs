//! Image files to float images and back.
//!
//! Files are sRGB where they hold colour as whole numbers; inside all colour is linear light. Numbers that are no colour
//! (heights, normals, masks) are never decoded as sRGB.

use super::error::{FormatError, Problem};
use super::output::write_file;
use crate::exemplar::srgb;
use crate::exemplar::{Channel, Image};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{DynamicImage, ExtendedColorType, ImageDecoder, ImageEncoder, ImageFormat, ImageReader, Limits};
use std::io::Cursor;
use std::path::Path;

/// Widest and highest image that is read. Larger ones are of no use as exemplars.
const MOST_PIXELS_ACROSS: u32 = 32_768;
/// Most pixels of an image: 8192 x 8192, which as floats with their mip levels are 1 GiB a colour channel.
pub(super) const MOST_PIXELS: u64 = 1 << 26;
/// Most bytes a decoder may allocate: four floats a pixel of the largest image, and its own needs.
const MOST_BYTES: u64 = 20 * MOST_PIXELS;

/// How the numbers of a file stand for those of an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Transfer {
    /// Colour: whole numbers are sRGB, floats are linear.
    Srgb,
    /// 0 to 1 as it is.
    Linear,
    /// -1 to 1, stored as 0 to 1.
    Signed,
}

impl Transfer {
    /// How a channel is stored.
    pub(crate) const fn of(channel: Channel) -> Self {
        match channel {
            Channel::BaseColor | Channel::Emissive => Self::Srgb,
            Channel::Normal => Self::Signed,
            _ => Self::Linear,
        }
    }

    /// A stored 0 to 1 value of a whole-number format.
    fn decode(self, stored: f32) -> f32 {
        match self {
            Self::Srgb => srgb::decode(stored),
            Self::Linear => stored,
            Self::Signed => stored * 2.0 - 1.0,
        }
    }

    fn encode(self, value: f32) -> f32 {
        match self {
            Self::Srgb => srgb::encode(value),
            Self::Linear => value,
            Self::Signed => value * 0.5 + 0.5,
        }
    }
}

/// A decoded file: one or three components, and alpha if it has any.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Picture {
    pub(crate) image: Image,
    /// One component, raw. Absent if every pixel is opaque.
    pub(crate) alpha: Option<Image>,
}

/// Decodes a file of any supported kind; `format` overrides what its first bytes say.
pub(crate) fn decode(file: &[u8], format: Option<ImageFormat>, transfer: Transfer) -> Result<Picture, Problem> {
    let mut reader = ImageReader::new(Cursor::new(file));
    match format {
        Some(format) => reader.set_format(format),
        None => reader = reader.with_guessed_format().map_err(|e| Problem::damaged("", e.to_string()))?,
    }
    // The decoder fills up what is missing with grey and says nothing.
    if reader.format() == Some(ImageFormat::Jpeg) && !jpeg_ends(file) {
        return Err(Problem::damaged("", "the image cannot be decoded whole (it ends in the middle of the picture)"));
    }
    reader.limits(limits());
    let mut decoder = reader.into_decoder().map_err(|e| explain(&e))?;
    check_size(decoder.dimensions())?;
    // A file without readable metadata is upright.
    let orientation = decoder.orientation().ok();
    let mut image = DynamicImage::from_decoder(decoder).map_err(|e| explain(&e))?;
    if let Some(orientation) = orientation {
        image.apply_orientation(orientation);
    }
    to_picture(&image, transfer).ok_or_else(|| Problem::damaged("", "the image has no pixels"))
}

/// What a decoder may take.
pub(super) fn limits() -> Limits {
    let mut limits = Limits::default();
    limits.max_image_width = Some(MOST_PIXELS_ACROSS);
    limits.max_image_height = Some(MOST_PIXELS_ACROSS);
    limits.max_alloc = Some(MOST_BYTES);
    limits
}

/// Whether an image of this width and height is read.
pub(super) fn check_size((width, height): (u32, u32)) -> Result<(), Problem> {
    if u64::from(width) * u64::from(height) > MOST_PIXELS {
        return Err(too_large(&format!("has {width} x {height}")));
    }
    if width == 0 || height == 0 {
        return Err(Problem::damaged("", "the image has no pixels"));
    }
    Ok(())
}

/// True if a JPEG's picture comes to an end: its segments lead to a scan, and after that an end marker follows. (Within a
/// scan that pair of bytes cannot occur; before it, in a thumbnail, it may.)
fn jpeg_ends(file: &[u8]) -> bool {
    const END: [u8; 2] = [0xFF, 0xD9];
    const SCAN: u8 = 0xDA;
    let mut at = 2;
    while let Some(&[0xFF, marker, high, low]) = file.get(at..at + 4) {
        if marker == SCAN {
            return file[at..].windows(2).any(|pair| pair == END);
        }
        // Bytes of 0xFF may fill up before a marker.
        at += if marker == 0xFF { 1 } else { 2 + usize::from(u16::from_be_bytes([high, low])) };
    }
    false
}

pub(super) fn explain(error: &image::ImageError) -> Problem {
    match error {
        image::ImageError::Limits(_) => too_large("is larger"),
        image::ImageError::Unsupported(e) => Problem::new("", e.to_string(), "save it as PNG, 8 or 16 bit"),
        _ => Problem::damaged("", format!("the image cannot be decoded ({error})")),
    }
}

pub(super) fn too_large(this_one: &str) -> Problem {
    let most = MOST_PIXELS >> 20;
    let what = format!("images of up to {MOST_PIXELS_ACROSS} pixels across and {most} megapixels are read, this one {this_one}");
    Problem::new("", what, "scale it down")
}

/// Components and alpha as floats. `None` if the image has no pixels.
pub(super) fn to_picture(image: &DynamicImage, transfer: Transfer) -> Option<Picture> {
    match image {
        DynamicImage::ImageLuma8(i) => from_whole::<u8, 1>(i, image, transfer),
        DynamicImage::ImageLumaA8(i) => from_whole::<u8, 2>(i, image, transfer),
        DynamicImage::ImageRgb8(i) => from_whole::<u8, 3>(i, image, transfer),
        DynamicImage::ImageRgba8(i) => from_whole::<u8, 4>(i, image, transfer),
        DynamicImage::ImageLuma16(i) => from_whole::<u16, 1>(i, image, transfer),
        DynamicImage::ImageLumaA16(i) => from_whole::<u16, 2>(i, image, transfer),
        DynamicImage::ImageRgb16(i) => from_whole::<u16, 3>(i, image, transfer),
        DynamicImage::ImageRgba16(i) => from_whole::<u16, 4>(i, image, transfer),
        // Float files hold light as it is; normals in them are stored as in whole numbers.
        other => {
            let plain = if transfer == Transfer::Srgb { Transfer::Linear } else { transfer };
            let number = |f: f32| plain.decode(if f.is_finite() { f } else { 0.0 });
            if other.color().has_alpha() {
                planes::<f32, 4>(&other.to_rgba32f(), other, number, |a| a.clamp(0.0, 1.0))
            } else {
                planes::<f32, 3>(&other.to_rgb32f(), other, number, |a| a)
            }
        }
    }
}

fn from_whole<T: Copy + Into<usize>, const N: usize>(data: &[T], image: &DynamicImage, transfer: Transfer) -> Option<Picture> {
    let top = (1_usize << (8 * size_of::<T>())) - 1;
    let table: Vec<f32> = (0..=top).map(|k| transfer.decode(k as f32 / top as f32)).collect();
    planes::<T, N>(data, image, |k| table[k.into()], |k| k.into() as f32 / top as f32)
}

fn planes<T: Copy, const N: usize>(
    data: &[T],
    image: &DynamicImage,
    number: impl Fn(T) -> f32,
    opacity: impl Fn(T) -> f32,
) -> Option<Picture> {
    let (width, height) = (image.width(), image.height());
    let colors = if N >= 3 { 3 } else { 1 };
    let pixels = data.as_chunks::<N>().0;
    let values: Vec<f32> = pixels.iter().flat_map(|p| p[..colors].iter().map(|&v| number(v))).collect();
    let alpha = if colors == N { None } else { Some(pixels.iter().map(|p| opacity(p[colors])).collect::<Vec<f32>>()) };
    let alpha = alpha.filter(|a| a.iter().any(|&a| a < 1.0));
    Some(Picture { image: Image::new(width, height, colors, values)?, alpha: alpha.and_then(|a| Image::new(width, height, 1, a)) })
}

/// An image as PNG. Data channels get 16 bits a number where 8 would change any; colour always has 8.
pub(crate) fn encode_png(image: &Image, transfer: Transfer) -> Result<Vec<u8>, String> {
    let [width, height] = image.size();
    let data = image.data();
    // `as` saturates and takes NaN to 0.
    let bytes: Vec<u8> = data.iter().map(|&v| (transfer.encode(v) * 255.0).round() as u8).collect();
    let exact = || bytes.iter().zip(data).all(|(&b, &v)| transfer.decode(f32::from(b) / 255.0) == v);
    let shallow = transfer == Transfer::Srgb || exact();
    let (bytes, color) = match (shallow, image.components()) {
        (true, 1) => (bytes, ExtendedColorType::L8),
        (true, _) => (bytes, ExtendedColorType::Rgb8),
        (false, components) => {
            let deep: Vec<u16> = data.iter().map(|&v| (transfer.encode(v) * 65535.0).round() as u16).collect();
            (bytemuck::cast_slice(&deep).to_vec(), if components == 1 { ExtendedColorType::L16 } else { ExtendedColorType::Rgb16 })
        }
    };
    let mut png = Vec::new();
    PngEncoder::new_with_quality(&mut png, CompressionType::Default, FilterType::Adaptive)
        .write_image(&bytes, width, height, color)
        .map_err(|e| e.to_string())?;
    Ok(png)
}

/// Saves an image of linear light as an 8-bit sRGB PNG.
///
/// # Errors
/// If the file cannot be written; nothing is left behind then.
pub fn save_image(path: &Path, image: &Image) -> Result<(), FormatError> {
    save_channel(path, image, Channel::BaseColor)
}

/// Saves an image of a channel as PNG, its numbers as files of that channel hold them.
///
/// # Errors
/// As [`save_image`].
pub fn save_channel(path: &Path, image: &Image, channel: Channel) -> Result<(), FormatError> {
    let png = encode_png(image, Transfer::of(channel)).map_err(|what| FormatError::Write {
        path: path.to_owned(),
        what,
        remedy: "choose another size".into(),
    })?;
    write_file(path, |out| out.write_all(&png))
}
