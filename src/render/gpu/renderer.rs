//! A device prepared to draw: its shaders, and what it is told how to draw.

use super::context::Gpu;
use super::error::GpuError;
use super::frame::Frame;
use super::pipelines::{KEY, Layouts, OPENNESS, Pipelines};
use super::subject::Subject;
use super::target::{Target, begin};
use crate::render::camera::Camera;
use crate::render::lens::Grid;
use crate::render::reference::DrawOptions;

/// The two ways of drawing pastes. Both give the same picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Path {
    /// Each face once, its pastes from the top down.
    #[default]
    Single,
    /// The pastes one after another, blended (LT 4).
    Layered,
}

/// How textures are filtered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Filter {
    /// Over a square with the sample's area on the surface, as the reference renderer does: for pictures with many
    /// samples in a pixel.
    #[default]
    Area,
    /// Along the sample's own shape on the surface, by the hardware: sharper at grazing angles with one sample a pixel.
    /// Software adapters filter over a square of the sample's longer side instead.
    Anisotropic,
}

/// How a renderer draws.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RendererOptions {
    /// How textures are filtered.
    pub filter: Filter,
    /// Depth to which relief is shown by parallax, in exemplar widths, for exemplars with a height; 0 shows none.
    pub parallax: f32,
}

/// Draws lapped textures on a device.
#[derive(Debug)]
pub struct Renderer {
    pub(super) gpu: Gpu,
    pub(super) layouts: Layouts,
    pub(super) pipelines: Pipelines,
    pub(super) options: RendererOptions,
    /// One pixel of 1.
    pub(super) white: Target,
    /// One pixel of no depth and face.
    pub(super) no_key: Target,
    /// Four zeroes.
    pub(super) zero: wgpu::Buffer,
}

impl Renderer {
    /// Prepares a device.
    ///
    /// # Errors
    /// If the device refuses our shaders.
    pub fn new(gpu: Gpu, options: RendererOptions) -> Result<Self, GpuError> {
        let layouts = Layouts::new(&gpu);
        let pipelines = Pipelines::new(&gpu, &layouts, options.filter == Filter::Anisotropic);
        let white = Target::new(&gpu, "white", [1, 1], OPENNESS);
        let no_key = Target::new(&gpu, "no key", [1, 1], KEY);
        let zero = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("zero"),
            size: 16,
            usage: wgpu::BufferUsages::UNIFORM,
            mapped_at_creation: false,
        });
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        begin(&mut encoder, "white", &[white.attach(Some(1.0))], None);
        gpu.queue.submit([encoder.finish()]);
        gpu.check()?;
        Ok(Self { gpu, layouts, pipelines, options, white, no_key, zero })
    }

    /// The device it draws on.
    #[must_use]
    pub const fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    pub(super) fn frame(&self, subject: &Subject, camera: &Camera, grid: Grid, options: &DrawOptions) -> Frame {
        let frame = Frame::new(&subject.shape, subject.patches.channels, camera, grid, options);
        frame.with_parallax(self.options.parallax).with_layers(subject.lists.soft)
    }

    /// What all passes of a frame are given.
    pub(super) fn scene(&self, subject: &Subject, frame: &Frame) -> wgpu::BindGroup {
        let uniform = frame.upload(&self.gpu);
        self.bind(
            &self.layouts.scene,
            &[uniform.as_entire_binding(), subject.shape.positions.as_entire_binding(), subject.lists.pastes.as_entire_binding()],
        )
    }

    pub(super) fn bind(&self, layout: &wgpu::BindGroupLayout, resources: &[wgpu::BindingResource<'_>]) -> wgpu::BindGroup {
        let entry = |(i, r): (usize, &_)| wgpu::BindGroupEntry { binding: i as u32, resource: Clone::clone(r) };
        let entries: Vec<wgpu::BindGroupEntry<'_>> = resources.iter().enumerate().map(entry).collect();
        self.gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
    }

    pub(super) fn bind_views(&self, layout: &wgpu::BindGroupLayout, targets: &[&Target]) -> wgpu::BindGroup {
        let views: Vec<wgpu::BindingResource<'_>> = targets.iter().map(|t| wgpu::BindingResource::TextureView(&t.view)).collect();
        self.bind(layout, &views)
    }

    /// Bindings of a picture on which nothing is darkened.
    pub(super) fn open(&self) -> wgpu::BindGroup {
        self.bind_views(&self.layouts.openness, &[&self.white])
    }

    pub(super) fn encoder(&self) -> wgpu::CommandEncoder {
        self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default())
    }
}
