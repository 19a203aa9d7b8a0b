//! Image files of a bake: which channels go into which, and their bytes.

use crate::exemplar::{Channel, Image, srgb};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use rayon::prelude::*;

/// An image file of a page.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Slot {
    /// Base colour, with opacity as alpha.
    Color,
    /// Occlusion, roughness and metallic as red, green and blue.
    Orm,
    /// Tangent-space normal.
    Normal,
    /// Emitted light.
    Emissive,
    /// Height, 16 bits.
    Height,
    /// Roughness alone, for formats that have no packed maps.
    Roughness,
    /// Metallic alone.
    Metallic,
    /// Occlusion alone.
    Occlusion,
    /// Opacity alone.
    Opacity,
}

impl Slot {
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Color => "color",
            Self::Orm => "orm",
            Self::Normal => "normal",
            Self::Emissive => "emissive",
            Self::Height => "height",
            Self::Roughness => "roughness",
            Self::Metallic => "metallic",
            Self::Occlusion => "occlusion",
            Self::Opacity => "opacity",
        }
    }
}

/// The image of a channel.
fn image_of(images: &[(Channel, Image)], channel: Channel) -> Option<&Image> {
    images.iter().find(|(c, _)| *c == channel).map(|(_, image)| image)
}

/// The image files that a page of such images needs in glTF.
pub(crate) fn slots(images: &[(Channel, Image)]) -> Vec<Slot> {
    let has = |c: Channel| image_of(images, c).is_some();
    let packed = has(Channel::Occlusion) || has(Channel::Roughness) || has(Channel::Metallic);
    [
        (Slot::Color, has(Channel::BaseColor)),
        (Slot::Orm, packed),
        (Slot::Normal, has(Channel::Normal)),
        (Slot::Emissive, has(Channel::Emissive)),
        (Slot::Height, has(Channel::Height)),
    ]
    .into_iter()
    .filter_map(|(slot, there)| there.then_some(slot))
    .collect()
}

const NOT_THERE: &str = "the bake lacks a channel that it is to write";

/// An image in bytes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Pixels {
    pub(crate) size: [u32; 2],
    pub(crate) color: ExtendedColorType,
    /// Rows from the top; numbers of 16 bits in the machine's own order.
    pub(crate) bytes: Vec<u8>,
}

impl Pixels {
    /// The bytes of one image file.
    ///
    /// # Errors
    /// If a channel is not there.
    pub(crate) fn new(images: &[(Channel, Image)], slot: Slot) -> Result<Self, String> {
        let get = |channel: Channel| image_of(images, channel).ok_or_else(|| NOT_THERE.to_owned());
        let light = |image: &Image, i: usize| [0, 1, 2].map(|c| srgb::to_byte(image.data()[3 * i + c]));
        let single = |channel: Channel| {
            let image = get(channel)?;
            Ok(raster::<1>(image.size(), ExtendedColorType::L8, |i| [byte(image.data()[i])]))
        };
        Ok(match slot {
            Slot::Color => {
                let color = get(Channel::BaseColor)?;
                match image_of(images, Channel::Opacity) {
                    None => raster::<3>(color.size(), ExtendedColorType::Rgb8, |i| light(color, i)),
                    Some(opacity) => raster::<4>(color.size(), ExtendedColorType::Rgba8, |i| {
                        let [r, g, b] = light(color, i);
                        [r, g, b, byte(opacity.data()[i])]
                    }),
                }
            }
            Slot::Emissive => {
                let color = get(Channel::Emissive)?;
                raster::<3>(color.size(), ExtendedColorType::Rgb8, |i| light(color, i))
            }
            Slot::Normal => {
                let normal = get(Channel::Normal)?;
                raster::<3>(normal.size(), ExtendedColorType::Rgb8, |i| {
                    [0, 1, 2].map(|c| byte(0.5 + 0.5 * normal.data()[3 * i + c]))
                })
            }
            Slot::Orm => {
                let size = images.first().ok_or(NOT_THERE)?.1.size();
                let parts = [Channel::Occlusion, Channel::Roughness, Channel::Metallic].map(|c| image_of(images, c));
                raster::<3>(size, ExtendedColorType::Rgb8, |i| parts.map(|p| p.map_or(255, |image| byte(image.data()[i]))))
            }
            Slot::Height => {
                let height = get(Channel::Height)?;
                raster::<2>(height.size(), ExtendedColorType::L16, |i| ((height.data()[i] * 65535.0).round() as u16).to_ne_bytes())
            }
            Slot::Roughness => return single(Channel::Roughness),
            Slot::Metallic => return single(Channel::Metallic),
            Slot::Occlusion => return single(Channel::Occlusion),
            Slot::Opacity => return single(Channel::Opacity),
        })
    }

    /// As PNG. Atlases are large: speed before the last percent of size.
    ///
    /// # Errors
    /// If it cannot be encoded.
    pub(crate) fn png(&self) -> Result<Vec<u8>, String> {
        let mut png = Vec::new();
        PngEncoder::new_with_quality(&mut png, CompressionType::Fast, FilterType::Adaptive)
            .write_image(&self.bytes, self.size[0], self.size[1], self.color)
            .map_err(|e| e.to_string())?;
        Ok(png)
    }
}

fn byte(value: f32) -> u8 {
    // `as` saturates and takes NaN to 0.
    (value * 255.0).round() as u8
}

/// An image given pixel by pixel.
fn raster<const N: usize>(size: [u32; 2], color: ExtendedColorType, pixel: impl Fn(usize) -> [u8; N] + Sync) -> Pixels {
    let [width, height] = size.map(|s| s as usize);
    let mut bytes = vec![0; N * width * height];
    bytes.par_chunks_mut(N * width).enumerate().for_each(|(y, line)| {
        for (x, out) in line.as_chunks_mut::<N>().0.iter_mut().enumerate() {
            *out = pixel(y * width + x);
        }
    });
    Pixels { size, color, bytes }
}
