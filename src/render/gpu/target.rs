//! Textures that passes draw onto, and the way back of what is drawn.

use super::context::Gpu;
use super::error::GpuError;
use crate::render::picture::Picture;
use wgpu::{Extent3d, TextureFormat, TextureUsages};

/// A texture to draw onto and to read in later passes.
#[derive(Debug, Clone)]
pub(super) struct Target {
    pub(super) texture: wgpu::Texture,
    pub(super) view: wgpu::TextureView,
}

impl Target {
    pub(super) fn new(gpu: &Gpu, label: &str, size: [u32; 2], format: TextureFormat) -> Self {
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size: Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        Self { texture, view }
    }

    /// As an attachment: cleared to a number in all components first, or kept as it is.
    pub(super) fn attach(&self, clear: Option<f64>) -> Option<wgpu::RenderPassColorAttachment<'_>> {
        let load = clear.map_or(wgpu::LoadOp::Load, |v| wgpu::LoadOp::Clear(wgpu::Color { r: v, g: v, b: v, a: v }));
        let ops = wgpu::Operations { load, store: wgpu::StoreOp::Store };
        Some(wgpu::RenderPassColorAttachment { view: &self.view, depth_slice: None, resolve_target: None, ops })
    }

    /// As the depth of a pass, cleared or kept.
    pub(super) fn attach_depth(&self, clear: bool) -> Option<wgpu::RenderPassDepthStencilAttachment<'_>> {
        let load = if clear { wgpu::LoadOp::Clear(1.0) } else { wgpu::LoadOp::Load };
        let depth_ops = Some(wgpu::Operations { load, store: wgpu::StoreOp::Store });
        Some(wgpu::RenderPassDepthStencilAttachment { view: &self.view, depth_ops, stencil_ops: None })
    }
}

/// Finished pixels on their way back.
pub(super) struct ReadBack {
    buffer: wgpu::Buffer,
    size: [u32; 2],
    row_bytes: u32,
}

impl ReadBack {
    /// Copies the top left part of a texture of four bytes a pixel.
    pub(super) fn new(gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, texture: &wgpu::Texture, size: [u32; 2]) -> Self {
        let [width, height] = size;
        let row_bytes = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("read back"),
            size: u64::from(row_bytes) * u64::from(height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row_bytes), rows_per_image: None },
            },
            Extent3d { width, height, depth_or_array_layers: 1 },
        );
        Self { buffer, size, row_bytes }
    }

    /// Waits for the pixels.
    pub(super) fn picture(self, gpu: &Gpu) -> Result<Picture, GpuError> {
        let slice = self.buffer.slice(..);
        slice.map_async(wgpu::MapMode::Read, |_| ());
        gpu.wait()?;
        let data = slice.get_mapped_range().map_err(|e| GpuError::Refused { reason: e.to_string() })?;
        let [width, height] = self.size;
        let mut rgba = Vec::with_capacity(4 * width as usize * height as usize);
        for row in data.chunks_exact(self.row_bytes as usize) {
            rgba.extend_from_slice(&row[..4 * width as usize]);
        }
        Ok(Picture { width, height, rgba })
    }
}

/// The bytes of a texture of four bytes a pixel, rows from the top.
///
/// # Errors
/// If the device fails, or the texture cannot be copied from.
pub fn read_pixels(gpu: &Gpu, texture: &wgpu::Texture) -> Result<Vec<u8>, GpuError> {
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let back = ReadBack::new(gpu, &mut encoder, texture, [texture.width(), texture.height()]);
    gpu.queue.submit([encoder.finish()]);
    Ok(back.picture(gpu)?.rgba)
}

/// Begins a pass.
pub(super) fn begin<'e>(
    encoder: &'e mut wgpu::CommandEncoder,
    label: &str,
    colors: &[Option<wgpu::RenderPassColorAttachment<'_>>],
    depth: Option<wgpu::RenderPassDepthStencilAttachment<'_>>,
) -> wgpu::RenderPass<'e> {
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some(label),
        color_attachments: colors,
        depth_stencil_attachment: depth,
        ..Default::default()
    })
}
