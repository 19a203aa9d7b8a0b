//! The numbers that all passes of one picture, or of one tile of it, share.

use super::context::Gpu;
use super::shape::{Shape, Units};
use crate::exemplar::ChannelSet;
use crate::render::camera::{Camera, Projection};
use crate::render::ground::GroundShadow;
use crate::render::lens::Grid;
use crate::render::occlusion::RADIUS;
use crate::render::reference::{Background, DrawOptions};
use crate::render::shade::Lighting;
use glam::{DVec2, DVec3, Vec3};

/// The bit among the channels that stands for layers, `LAYERS` in shaders/frame.wgsl.
const LAYERS: u32 = 31;

/// A frame as the shaders have it: `Frame` in shaders/frame.wgsl.
#[derive(Debug, Clone)]
pub(super) struct Frame {
    units: Units,
    camera: Camera,
    /// Samples per unit on the picture plane; the picture's middle, in samples.
    scale: f64,
    middle: DVec2,
    /// Nearest and farthest depth, in units.
    depth: [f64; 2],
    /// Pixels of the picture, and samples along each side of one.
    size: [u32; 2],
    samples: u32,
    channels: u32,
    lighting: Lighting,
    bare: Vec3,
    parallax: f32,
    occlusion: f64,
    backdrop: Backdrop,
    /// Samples of this tile: its first, and how many.
    tile: [DVec2; 2],
}

#[derive(Debug, Clone, Copy)]
struct Backdrop {
    kind: u32,
    colour: Vec3,
    middle: Vec3,
    axes: [Vec3; 2],
    half: f64,
}

impl Frame {
    pub(super) fn new(shape: &Shape, channels: ChannelSet, camera: &Camera, grid: Grid, options: &DrawOptions) -> Self {
        let size = grid.size().map(|s| s as f64);
        let half = 0.5 * size[1];
        let units = shape.units;
        let scale = match camera.projection {
            Projection::Perspective(tangent) => half / tangent,
            Projection::Orthographic(height) => half / (height * units.scale),
        };
        let (kind, colour) = match options.background {
            Background::Transparent => (0, Vec3::ZERO),
            Background::Plain(colour) => (1, colour),
            Background::Studio => (2, Vec3::ZERO),
        };
        Self {
            units,
            camera: *camera,
            scale,
            middle: DVec2::new(0.5 * size[0], half),
            depth: depth_range(shape, camera),
            size: [grid.width, grid.height],
            samples: grid.samples,
            channels: channels.iter().map(|c| 1 << c as u32).sum(),
            lighting: options.lighting,
            bare: options.bare,
            parallax: 0.0,
            occlusion: 0.0,
            backdrop: Backdrop { kind, colour, middle: Vec3::ZERO, axes: [Vec3::ZERO; 2], half: 0.0 },
            tile: [DVec2::ZERO, DVec2::from(size)],
        }
    }

    /// Shows relief by parallax, as deep as this many exemplar widths.
    pub(super) fn with_parallax(mut self, depth: f32) -> Self {
        self.parallax = depth.max(0.0);
        self
    }

    /// Pastes lie in layers that are mixed by weights.
    pub(super) fn with_layers(mut self, soft: bool) -> Self {
        self.channels |= u32::from(soft) << LAYERS;
        self
    }

    /// Depths that the depth buffer tells apart, world units.
    pub(super) fn with_depth(mut self, [near, far]: [f64; 2]) -> Self {
        self.depth = [near, far].map(|d| d * self.units.scale);
        self
    }

    pub(super) fn with_shadow(mut self, shadow: &GroundShadow) -> Self {
        self.backdrop.middle = self.units.point(shadow.middle).as_vec3();
        self.backdrop.axes = shadow.axes.map(DVec3::as_vec3);
        self.backdrop.half = shadow.half * self.units.scale;
        self
    }

    /// A part of the picture, in pixels.
    pub(super) fn tile(&self, first: [u32; 2], size: [u32; 2]) -> Self {
        let samples = |v: [u32; 2]| DVec2::new(f64::from(v[0]), f64::from(v[1])) * f64::from(self.samples);
        Self { tile: [samples(first), samples(size)], ..self.clone() }
    }

    /// The whole picture with one sample a pixel: the one that [`crate::render::occlusion`] looks at. `diagonal` is that of
    /// the mesh's bounds, world units.
    pub(super) fn for_occlusion(&self, diagonal: f64) -> Self {
        let n = f64::from(self.samples);
        // The place of that sample within its pixel.
        let place = (f64::from(self.samples / 2) + 0.5) / n;
        let size = DVec2::new(f64::from(self.size[0]), f64::from(self.size[1]));
        let occlusion = RADIUS * diagonal * self.units.scale;
        let middle = self.middle / n - place + 0.5;
        Self { scale: self.scale / n, middle, samples: 1, tile: [DVec2::ZERO, size], occlusion, ..self.clone() }
    }

    /// Pixels of the picture.
    pub(super) const fn pixels(&self) -> [u32; 2] {
        self.size
    }

    /// In the shaders' layout.
    fn words(&self) -> Vec<u32> {
        let mut out = Vec::with_capacity(84);
        let mut row = |v: Vec3, w: u32| out.extend([v.x.to_bits(), v.y.to_bits(), v.z.to_bits(), w]);
        let camera = &self.camera;
        let perspective = matches!(camera.projection, Projection::Perspective(_));
        row(camera.right.as_vec3(), (self.scale as f32).to_bits());
        row(camera.up.as_vec3(), f32::from(u8::from(perspective)).to_bits());
        row(camera.forward.as_vec3(), self.parallax.to_bits());
        row(self.units.point(camera.eye).as_vec3(), self.channels);
        row(camera.world_up.as_vec3(), self.samples);
        row(self.bare, self.backdrop.kind);
        // From view coordinates to samples and on to -1 .. 1 over the tile, y up.
        let [first, size] = self.tile;
        let factor = 2.0 * self.scale / size;
        let shift = (self.middle - first) * 2.0 / size - 1.0;
        let [near, far] = self.depth;
        let range = far - near;
        let depth = if perspective { [far / range, -far * near / range] } else { [1.0 / range, -near / range] };
        let mut four = |v: [f64; 4]| out.extend(v.map(|v| (v as f32).to_bits()));
        four([factor.x, factor.y, shift.x, -shift.y]);
        four([depth[0], depth[1], first.x, first.y]);
        four([self.middle.x, self.middle.y, f64::from(self.size[0]), f64::from(self.size[1])]);
        let mut row = |v: Vec3, w: f64| out.extend([v.x, v.y, v.z, w as f32].map(f32::to_bits));
        for lamp in &self.lighting.lamps {
            let towards = camera.right * f64::from(lamp.towards.x) + camera.up * f64::from(lamp.towards.y)
                - camera.forward * f64::from(lamp.towards.z);
            row(towards.as_vec3(), 0.0);
            row(lamp.light, 0.0);
        }
        row(self.lighting.sky, self.occlusion);
        row(self.lighting.ground, self.backdrop.half);
        row(self.backdrop.colour, 0.0);
        row(self.backdrop.middle, 0.0);
        row(self.backdrop.axes[0], 0.0);
        row(self.backdrop.axes[1], 0.0);
        out
    }

    /// Brings it to the device.
    pub(super) fn upload(&self, gpu: &Gpu) -> wgpu::Buffer {
        let words = self.words();
        let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let size = 4 * words.len() as u64;
        let label = Some("frame");
        let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor { label, size, usage, mapped_at_creation: false });
        gpu.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(&words));
        buffer
    }
}

/// Depths between which the mesh lies, as the depth buffer needs them: it tells near things apart best if neither is far
/// beyond the mesh.
fn depth_range(shape: &Shape, camera: &Camera) -> [f64; 2] {
    let (low, high) = (shape.bounds.0.as_dvec3(), shape.bounds.1.as_dvec3());
    let eye = shape.units.point(camera.eye);
    let corners = (0..8).map(|k| {
        let pick = |bit: u32, low: f64, high: f64| if k >> bit & 1 == 0 { low } else { high };
        let corner = DVec3::new(pick(0, low.x, high.x), pick(1, low.y, high.y), pick(2, low.z, high.z));
        (corner - eye).dot(camera.forward)
    });
    let (near, far) = corners.fold((f64::INFINITY, f64::NEG_INFINITY), |(near, far), d| (near.min(d), far.max(d)));
    // Room for what single precision rounds off.
    let slack = 1e-3 * (1.0 + (far - near).abs());
    let near = (near - slack).max(camera.near * shape.units.scale);
    [near, (far + slack).max(near * 1.001 + slack)]
}
