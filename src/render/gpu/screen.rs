//! Frames for somebody else's texture: a window's, or one that a user interface shows. What is drawn goes onto samples of our
//! own first, several a pixel, which the texture then gets the mean of.

use super::context::Gpu;
use super::error::GpuError;
use super::forward::{Forward, Seen};
use super::renderer::Renderer;
use super::subject::Subject;
use wgpu::{TextureFormat, TextureUsages, TextureView};

/// Depth of samples.
const DEPTH: TextureFormat = TextureFormat::Depth32Float;

/// Draws subjects onto texture views of one format.
#[derive(Debug)]
pub struct Screen {
    forward: Forward,
    gpu: Gpu,
    format: TextureFormat,
    samples: u32,
    targets: Option<Targets>,
}

/// Samples and depth for one size.
#[derive(Debug)]
struct Targets {
    size: [u32; 2],
    /// None: one sample a pixel goes straight to the view.
    color: Option<TextureView>,
    depth: TextureView,
}

impl Screen {
    /// For views of a format, with so many samples a pixel (1 or 4; more where the adapter can).
    ///
    /// # Errors
    /// If the device cannot draw onto that.
    pub fn new(renderer: &Renderer, format: TextureFormat, samples: u32) -> Result<Self, GpuError> {
        let forward = Forward::new(renderer, format, DEPTH, samples)?;
        Ok(Self { forward, gpu: renderer.gpu().clone(), format, samples, targets: None })
    }

    /// Draws what is seen of subjects over a colour onto a view of `size` pixels. Of no size nothing is drawn.
    ///
    /// The colour is linear light if the format is sRGB, else it is stored as it is.
    ///
    /// # Errors
    /// If the size is beyond the device's limits.
    pub fn draw(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        view: &TextureView,
        size: [u32; 2],
        behind: wgpu::Color,
        shown: &[(&Subject, &Seen)],
    ) -> Result<(), GpuError> {
        if size.contains(&0) {
            return Ok(());
        }
        let longest = self.gpu.limits.max_texture_dimension_2d;
        if size[0].max(size[1]) > longest {
            let what = format!("a frame of {} x {} pixels is too large", size[0], size[1]);
            let (needs, has) = (u64::from(size[0].max(size[1])), u64::from(longest));
            return Err(GpuError::Limit { what, needs, has, remedy: "make the window smaller" });
        }
        let targets = match self.targets.take().filter(|t| t.size == size) {
            Some(kept) => self.targets.insert(kept),
            None => self.targets.insert(Targets::new(&self.gpu, self.format, self.samples, size)),
        };
        let (onto, resolve_target) = targets.color.as_ref().map_or((view, None), |color| (color, Some(view)));
        let store = if resolve_target.is_some() { wgpu::StoreOp::Discard } else { wgpu::StoreOp::Store };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("screen"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: onto,
                depth_slice: None,
                resolve_target,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(behind), store },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &targets.depth,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store: wgpu::StoreOp::Discard }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        for (subject, seen) in shown {
            self.forward.draw(&mut pass, subject, seen);
        }
        Ok(())
    }
}

impl Targets {
    fn new(gpu: &Gpu, format: TextureFormat, samples: u32, size: [u32; 2]) -> Self {
        let target = |label, format| {
            let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: samples,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: TextureUsages::RENDER_ATTACHMENT,
                view_formats: &[],
            });
            texture.create_view(&wgpu::TextureViewDescriptor::default())
        };
        Self { size, color: (samples > 1).then(|| target("samples", format)), depth: target("depth", DEPTH) }
    }
}
