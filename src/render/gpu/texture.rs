//! Images on the device: array layers whose mip levels are the ones the library built.

use super::context::Gpu;
use super::error::GpuError;
use crate::exemplar::{Image, MipChain, srgb};
use crate::render::picture::to_byte;
use glam::Vec3;
use wgpu::{Extent3d, TextureFormat};

/// An image with its levels, for reading by shaders.
pub(super) struct Layers<'g> {
    gpu: &'g Gpu,
    pub(super) texture: wgpu::Texture,
    pixel_bytes: u32,
}

impl<'g> Layers<'g> {
    pub(super) fn new(
        gpu: &'g Gpu,
        label: &str,
        size: [u32; 2],
        layers: u32,
        levels: u32,
        format: TextureFormat,
    ) -> Result<Self, GpuError> {
        // OpenGL has no arrays of one layer: such a texture would be read as black; and wgpu takes squares by the half dozen for cubes.
        let layers = match gpu.device.adapter_info().backend {
            wgpu::Backend::Gl if size[0] == size[1] && layers.is_multiple_of(6) => layers + 1,
            wgpu::Backend::Gl => layers.max(2),
            _ => layers,
        };
        let limits = &gpu.limits;
        if layers > limits.max_texture_array_layers {
            let what = format!("the {label} fill too many layers of {} x {} pixels", size[0], size[1]);
            let (needs, has) = (u64::from(layers), u64::from(limits.max_texture_array_layers));
            return Err(GpuError::Limit { what, needs, has, remedy: "use fewer or smaller ones" });
        }
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size: Extent3d { width: size[0], height: size[1], depth_or_array_layers: layers },
            mip_level_count: levels,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        Ok(Self { gpu, texture, pixel_bytes: format.block_copy_size(None).unwrap_or(4) })
    }

    /// Size of a level.
    pub(super) fn level(&self, level: u32) -> [u32; 2] {
        [self.texture.width(), self.texture.height()].map(|s| (s >> level).max(1))
    }

    /// Fills a level of a layer.
    pub(super) fn write(&self, layer: u32, level: u32, data: &[u8]) {
        let [width, height] = self.level(level);
        self.gpu.queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                texture: &self.texture,
                mip_level: level,
                origin: wgpu::Origin3d { x: 0, y: 0, z: layer },
                aspect: wgpu::TextureAspect::All,
            },
            data,
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(width * self.pixel_bytes), rows_per_image: None },
            Extent3d { width, height, depth_or_array_layers: 1 },
        );
    }

    /// The whole of it, as an array.
    pub(super) fn view(&self) -> wgpu::TextureView {
        let dimension = Some(wgpu::TextureViewDimension::D2Array);
        self.texture.create_view(&wgpu::TextureViewDescriptor { dimension, ..Default::default() })
    }

    pub(super) fn bytes(&self) -> u64 {
        let level = |l: u32| self.level(l).iter().map(|&s| u64::from(s)).product::<u64>();
        let pixels: u64 = (0..self.texture.mip_level_count()).map(level).sum();
        pixels * u64::from(self.pixel_bytes) * u64::from(self.texture.depth_or_array_layers())
    }
}

/// How numbers become bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Code {
    /// Linear light as sRGB.
    Light,
    /// 0 to 1 as it is.
    Plain,
    /// -1 to 1.
    Signed,
}

impl Code {
    fn byte(self, value: f32) -> u8 {
        match self {
            Self::Light => to_byte(srgb::encode(value)),
            Self::Plain => to_byte(value),
            Self::Signed => to_byte(0.5 * value + 0.5),
        }
    }
}

/// A part of a pixel: where its numbers come from, which bytes of four they fill, and what stands there without them.
pub(super) struct Part<'a> {
    pub(super) chain: Option<&'a MipChain>,
    pub(super) code: Code,
    /// First byte and number of bytes.
    pub(super) bytes: [usize; 2],
    pub(super) otherwise: u8,
}

/// Fills all levels of a layer. Level 0 takes level `drop` of the images; beyond an image's edge its last pixels are
/// repeated.
pub(super) fn fill(layers: &Layers<'_>, layer: u32, drop: u32, parts: &[Part<'_>]) {
    for level in 0..layers.texture.mip_level_count() {
        let [width, height] = layers.level(level);
        let mut data = vec![255_u8; 4 * width as usize * height as usize];
        for part in parts {
            let [first, count] = part.bytes;
            let image: Option<&Image> = part.chain.map(|chain| {
                let last = chain.levels().len() - 1;
                &chain.levels()[((level + drop) as usize).min(last)]
            });
            for y in 0..height {
                for x in 0..width {
                    let value = image.map(|image| image.pixel(i64::from(x), i64::from(y)));
                    let at = 4 * (y as usize * width as usize + x as usize) + first;
                    let bytes = value.map_or([part.otherwise; 3], |v: Vec3| v.to_array().map(|c| part.code.byte(c)));
                    data[at..at + count].copy_from_slice(&bytes[..count]);
                }
            }
        }
        layers.write(layer, level, &data);
    }
}
