//! The graphics device as the window and its panes share it.

use crate::mesh::Mesh;
use crate::paste::LappedTexture;
use crate::render::gpu::{Canvas, Filter, Gpu, GpuError, Path, Renderer, RendererOptions, Screen, Subject, wgpu};
use crate::render::{Background, Camera, DrawOptions, Grid, Stage, View};
use egui::mutex::RwLock;
use glam::Vec3;
use std::sync::Arc;
use std::time::{Duration, Instant};
use wgpu::{Extent3d, TextureFormat, TextureUsages};

/// What pictures in the user interface are stored as: encoded light, as the interface itself is drawn.
const FORMAT: TextureFormat = TextureFormat::Rgba8Unorm;

/// Samples a pixel of live frames.
const SAMPLES: u32 = 4;

/// Draws subjects, and pictures into the user interface.
#[derive(Clone)]
pub struct Graphics {
    /// Draws subjects.
    pub renderer: Arc<Renderer>,
    painter: Arc<RwLock<egui_wgpu::Renderer>>,
}

impl std::fmt::Debug for Graphics {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Graphics").field("adapter", &self.renderer.gpu().adapter()).finish_non_exhaustive()
    }
}

impl Graphics {
    /// On a device, for a user interface that is drawn by `painter` on the same device.
    ///
    /// # Errors
    /// If the device refuses our shaders.
    pub fn new(gpu: Gpu, painter: Arc<RwLock<egui_wgpu::Renderer>>) -> Result<Self, GpuError> {
        let options = RendererOptions { filter: Filter::Anisotropic, ..RendererOptions::default() };
        Ok(Self { renderer: Arc::new(Renderer::new(gpu, options)?), painter })
    }

    /// What all panes draw by, warm: software adapters translate shaders when they first draw with them, which takes seconds, so a few
    /// pixels are drawn here.
    ///
    /// # Errors
    /// If the device cannot draw onto the format of pictures.
    pub fn screen(&self) -> Result<Screen, GpuError> {
        let (renderer, gpu) = (&self.renderer, self.renderer.gpu());
        let mut screen = Screen::new(renderer, FORMAT, SAMPLES)?;
        let corners = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
        // Three points make a mesh.
        let Ok(mesh) = Mesh::new(corners, vec![[0, 1, 2]]) else { return Ok(screen) };
        let options = DrawOptions::default();
        let subject = renderer.load(&Stage::new(&mesh, &options), &LappedTexture::default())?;
        let camera = View::default().frame(&mesh, 1.0);
        let size = [4, 4];
        let seen = renderer.see(&subject, &camera, size, &options, None);
        let target = gpu.device.create_texture(&pane_texture(size));
        let view = target.create_view(&wgpu::TextureViewDescriptor::default());
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        screen.draw(&mut encoder, &view, size, wgpu::Color::BLACK, &[(&subject, &seen)])?;
        gpu.queue.submit([encoder.finish()]);
        gpu.check()?;
        Ok(screen)
    }
}

/// What one pane is to show.
#[derive(Clone, Copy)]
pub struct Look<'a> {
    /// The subject, and others that stand in the same depth.
    pub subjects: &'a [&'a Subject],
    /// How its pastes are drawn.
    pub path: Path,
    /// From where.
    pub camera: &'a Camera,
    /// Light and background; the background is one colour.
    pub options: &'a DrawOptions,
    /// Depths between which everything lies.
    pub depth: [f64; 2],
}

/// A picture in the user interface that subjects are drawn onto.
#[derive(Default)]
pub struct Pane {
    target: Option<Target>,
    canvas: Option<([u32; 2], Canvas)>,
}

struct Target {
    size: [u32; 2],
    view: wgpu::TextureView,
    id: egui::TextureId,
    painter: Arc<RwLock<egui_wgpu::Renderer>>,
}

impl Drop for Target {
    fn drop(&mut self) {
        self.painter.write().free_texture(&self.id);
    }
}

impl std::fmt::Debug for Pane {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Pane").field("size", &self.target.as_ref().map(|t| t.size)).finish_non_exhaustive()
    }
}

impl Pane {
    /// What it shows now, for the user interface.
    #[must_use]
    pub fn picture(&self) -> Option<egui::TextureId> {
        self.target.as_ref().map(|t| t.id)
    }

    /// Forgets the canvas of the layered way, which belongs to one subject.
    pub fn forget(&mut self) {
        self.canvas = None;
    }

    /// Draws a look of `size` pixels, by `screen` unless paste by paste. Of no size nothing is drawn. How long the device took to take
    /// the commands in: drawing itself, where it is software.
    ///
    /// # Errors
    /// If it is beyond the device's limits, or the device fails.
    pub fn draw(
        &mut self,
        graphics: &Graphics,
        screen: &mut Screen,
        size: [u32; 2],
        look: &Look<'_>,
    ) -> Result<Duration, GpuError> {
        if size.contains(&0) {
            return Ok(Duration::ZERO);
        }
        let renderer = &graphics.renderer;
        let gpu = renderer.gpu();
        let size = size.map(|s| s.min(gpu.limits.max_texture_dimension_2d));
        if self.target.as_ref().is_none_or(|t| t.size != size) {
            self.target = Some(Target::new(graphics, size));
        }
        let Some(target) = &self.target else { return Ok(Duration::ZERO) };
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        match (look.path, look.subjects) {
            // With lines in the same depth the other way shows the same.
            (Path::Layered, [subject]) => {
                let canvas = match self.canvas.take().filter(|(s, _)| *s == size) {
                    Some((_, kept)) => kept,
                    None => Canvas::new(renderer, subject, size, Path::Layered)?,
                };
                let grid = Grid { width: size[0], height: size[1], samples: 1 };
                renderer.frame_onto(&mut encoder, subject, look.camera, grid, look.options, &canvas, &target.view);
                self.canvas = Some((size, canvas));
            }
            _ => {
                let see = |subject: &&Subject| renderer.see(subject, look.camera, size, look.options, Some(look.depth));
                let seen: Vec<_> = look.subjects.iter().map(see).collect();
                let shown: Vec<_> = look.subjects.iter().copied().zip(&seen).collect();
                screen.draw(&mut encoder, &target.view, size, behind(look.options.background), &shown)?;
            }
        }
        let begin = Instant::now();
        gpu.queue.submit([encoder.finish()]);
        let took = begin.elapsed();
        gpu.check().map(|()| took)
    }
}

/// The background as the interface stores colours.
fn behind(background: Background) -> wgpu::Color {
    let colour = match background {
        Background::Plain(colour) => colour.to_array().map(|c| f64::from(crate::exemplar::srgb::encode(c))),
        Background::Studio | Background::Transparent => return wgpu::Color::TRANSPARENT,
    };
    let [r, g, b] = colour;
    wgpu::Color { r, g, b, a: 1.0 }
}

/// The picture of a pane.
const fn pane_texture(size: [u32; 2]) -> wgpu::TextureDescriptor<'static> {
    wgpu::TextureDescriptor {
        label: Some("pane"),
        size: Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: FORMAT,
        usage: TextureUsages::RENDER_ATTACHMENT.union(TextureUsages::TEXTURE_BINDING),
        view_formats: &[],
    }
}

impl Target {
    fn new(graphics: &Graphics, size: [u32; 2]) -> Self {
        let device = &graphics.renderer.gpu().device;
        let texture = device.create_texture(&pane_texture(size));
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let painter = Arc::clone(&graphics.painter);
        let id = painter.write().register_native_texture(device, &view, wgpu::FilterMode::Linear);
        Self { size, view, id, painter }
    }
}
