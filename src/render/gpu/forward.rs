//! Subjects in somebody else's frame: drawn once, straight into a pass of theirs.

use super::canvas::Canvas;
use super::error::GpuError;
use super::renderer::Renderer;
use super::subject::Subject;
use crate::render::camera::Camera;
use crate::render::lens::Grid;
use crate::render::reference::DrawOptions;
use wgpu::{BindGroup, RenderPass, RenderPipeline, TextureFormat};

/// The single pass made for one kind of target.
///
/// Displayed light is written as it is onto an sRGB format and encoded onto any other. Ambient occlusion and background are
/// left to the program that owns the pass; depth is compared with and written to its own.
#[derive(Debug)]
pub struct Forward {
    pipeline: RenderPipeline,
    open: BindGroup,
}

/// A subject seen by a camera, ready to be drawn into passes.
#[derive(Debug)]
pub struct Seen(BindGroup);

impl Forward {
    /// For passes with such a colour and depth format and so many samples a pixel.
    ///
    /// # Errors
    /// If the device cannot draw onto that.
    pub fn new(renderer: &Renderer, color: TextureFormat, depth: TextureFormat, samples: u32) -> Result<Self, GpuError> {
        let pipeline = renderer.pipelines.forward(renderer.gpu(), color, depth, samples);
        renderer.gpu().check()?;
        Ok(Self { pipeline, open: renderer.open() })
    }

    /// Draws into a pass.
    pub fn draw(&self, pass: &mut RenderPass<'_>, subject: &Subject, seen: &Seen) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &seen.0, &[]);
        pass.set_bind_group(3, &self.open, &[]);
        subject.draw_faces(pass);
    }
}

impl Renderer {
    /// A subject as a camera sees it in a picture of `size` pixels. `depth` are the world distances, along the camera's forward
    /// axis, that depths 0 and 1 stand for; `None` lays them closely around the subject.
    #[must_use]
    pub fn see(&self, subject: &Subject, camera: &Camera, size: [u32; 2], options: &DrawOptions, depth: Option<[f64; 2]>) -> Seen {
        let grid = Grid { width: size[0].max(1), height: size[1].max(1), samples: 1 };
        let frame = self.frame(subject, camera, grid, options);
        let frame = match depth {
            Some(range) => frame.with_depth(range),
            None => frame,
        };
        Seen(self.scene(subject, &frame))
    }

    /// Draws a subject onto a canvas of one sample a pixel; nothing is darkened by its surroundings, nothing is behind it.
    pub fn encode(&self, encoder: &mut wgpu::CommandEncoder, subject: &Subject, seen: &Seen, canvas: &Canvas) {
        canvas.fill(self, encoder, subject, &seen.0, &self.white);
    }
}
