//! Whole pictures on the device, in tiles.
//!
//! 1. Ambient occlusion, at one sample a pixel: surface points, obscurance, smoothing.
//! 2. The samples of a tile, on a [`Canvas`].
//! 3. Samples are averaged to pixels over the background.

use super::canvas::Canvas;
use super::error::GpuError;
use super::frame::Frame;
use super::pipelines::{DEPTH, OPENNESS, PIXELS, POINTS};
use super::renderer::{Path, Renderer};
use super::subject::Subject;
use super::target::{ReadBack, Target, begin};
use crate::render::camera::Camera;
use crate::render::ground::GroundShadow;
use crate::render::lens::Grid;
use crate::render::picture::Picture;
use crate::render::reference::{Background, DrawOptions, Stage};
use wgpu::{BindGroup, Color, CommandEncoder, LoadOp, Operations, RenderPassColorAttachment, StoreOp, TextureView};

/// Samples along the side of a tile: bounds the memory of a picture of any size.
const TILE: u32 = 3072;

impl Renderer {
    /// A picture of a subject in its studio. The stage must be the one that the subject was loaded from or follows.
    ///
    /// # Errors
    /// If the picture has no size or is too large, or the device fails.
    pub fn draw(&self, subject: &Subject, stage: &Stage<'_>, camera: &Camera, grid: Grid, path: Path) -> Result<Picture, GpuError> {
        grid.check()?;
        self.gpu.check()?;
        let longest = self.gpu.limits.max_texture_dimension_2d;
        let longer = grid.width.max(grid.height);
        if stage.options.occlusion && longer > longest {
            let (needs, has) = (u64::from(longer), u64::from(longest));
            let what = "the picture has too many pixels on a side".to_owned();
            return Err(GpuError::Limit { what, needs, has, remedy: "draw it smaller, or with the mode reference" });
        }
        let mut frame = self.frame(subject, camera, grid, &stage.options);
        let shadow = (stage.options.background == Background::Studio).then(|| stage.shadow(camera.world_up));
        if let Some(shadow) = &shadow {
            frame = frame.with_shadow(shadow);
        }
        let hidden = self.shadow_map(shadow.as_deref());
        let openness = self.openness(subject, stage, &frame);
        let side = (TILE.min(longest) / grid.samples).max(1);
        let mut picture = Picture::filled(grid.width, grid.height, [0; 4]);
        let mut canvas: Option<Canvas> = None;
        for y in (0..grid.height).step_by(side as usize) {
            for x in (0..grid.width).step_by(side as usize) {
                let size = [side.min(grid.width - x), side.min(grid.height - y)];
                let fits = canvas.take().filter(|c| c.size == size.map(|s| s * grid.samples));
                let canvas = canvas.insert(match fits {
                    Some(kept) => kept,
                    None => Canvas::new(self, subject, size.map(|s| s * grid.samples), path)?,
                });
                let tile = frame.tile([x, y], size);
                let drawn = self.tile(subject, &tile, size, canvas, &openness, &hidden)?;
                picture.paste(&drawn, x, y);
            }
        }
        Ok(picture)
    }

    fn shadow_map(&self, shadow: Option<&GroundShadow>) -> Target {
        let cells = shadow.map_or(&[][..], |s| s.cells());
        let side = (cells.len() as f64).sqrt() as u32;
        let format = wgpu::TextureFormat::R32Float;
        let size = wgpu::Extent3d { width: side.max(1), height: side.max(1), depth_or_array_layers: 1 };
        let texture = self.gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("shadow"),
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        if side > 0 {
            let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * side), rows_per_image: None };
            self.gpu.queue.write_texture(texture.as_image_copy(), bytemuck::cast_slice(cells), layout, size);
        }
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        Target { texture, view }
    }

    /// Openness of each pixel, or one pixel of 1.
    fn openness(&self, subject: &Subject, stage: &Stage<'_>, frame: &Frame) -> Target {
        if !stage.options.occlusion {
            return self.white.clone();
        }
        let (low, high) = stage.mesh.bounds();
        let frame = frame.for_occlusion((high - low).as_dvec3().length());
        let size = frame.pixels();
        let scene = self.scene(subject, &frame);
        let target = |label, format| Target::new(&self.gpu, label, size, format);
        let (points, depth) = (target("points", POINTS), target("depth", DEPTH));
        let (raw, smooth) = (target("obscured", OPENNESS), target("openness", OPENNESS));
        let mut encoder = self.encoder();
        {
            let mut pass = begin(&mut encoder, "points", &[points.attach(Some(0.0))], depth.attach_depth(true));
            pass.set_pipeline(&self.pipelines.points);
            pass.set_bind_group(0, &scene, &[]);
            subject.draw_faces(&mut pass);
        }
        let full = |encoder: &mut CommandEncoder, onto: &Target, pipeline, group: &BindGroup| {
            let mut pass = begin(encoder, "occlusion", &[onto.attach(Some(1.0))], None);
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &scene, &[]);
            pass.set_bind_group(3, group, &[]);
            pass.draw(0..3, 0..1);
        };
        let group = self.bind_views(&self.layouts.obscure, &[&points]);
        full(&mut encoder, &raw, &self.pipelines.obscure, &group);
        let group = self.bind_views(&self.layouts.smooth, &[&points, &raw]);
        full(&mut encoder, &smooth, &self.pipelines.smooth, &group);
        self.gpu.queue.submit([encoder.finish()]);
        smooth
    }

    /// A tile of `size` pixels.
    fn tile(
        &self,
        subject: &Subject,
        frame: &Frame,
        size: [u32; 2],
        canvas: &Canvas,
        openness: &Target,
        hidden: &Target,
    ) -> Result<Picture, GpuError> {
        let scene = self.scene(subject, frame);
        let pixels = Target::new(&self.gpu, "pixels", size, PIXELS);
        let mut encoder = self.encoder();
        canvas.fill(self, &mut encoder, subject, &scene, openness);
        self.finish(&mut encoder, &scene, canvas, hidden, &pixels.view);
        let back = ReadBack::new(&self.gpu, &mut encoder, &pixels.texture, size);
        self.gpu.queue.submit([encoder.finish()]);
        back.picture(&self.gpu)
    }

    /// Samples averaged to pixels over the background, onto a view.
    fn finish(&self, encoder: &mut CommandEncoder, scene: &BindGroup, canvas: &Canvas, hidden: &Target, view: &TextureView) {
        let group = self.bind_views(&self.layouts.finish, &[&canvas.light, hidden]);
        let ops = Operations { load: LoadOp::Clear(Color::TRANSPARENT), store: StoreOp::Store };
        let onto = RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops };
        let mut pass = begin(encoder, "finish", &[Some(onto)], None);
        pass.set_pipeline(&self.pipelines.finish);
        pass.set_bind_group(0, scene, &[]);
        pass.set_bind_group(3, &group, &[]);
        pass.draw(0..3, 0..1);
    }

    /// A frame by way of a canvas, of as many samples a pixel as its size has, onto a view of the format `Rgba8Unorm` and of
    /// `grid`'s pixels: sRGB with straight alpha. Nothing is darkened by its surroundings; no shadow lies on the ground.
    #[allow(clippy::too_many_arguments, reason = "what is drawn, how, and onto what")]
    pub fn frame_onto(
        &self,
        encoder: &mut CommandEncoder,
        subject: &Subject,
        camera: &Camera,
        grid: Grid,
        options: &DrawOptions,
        canvas: &Canvas,
        view: &TextureView,
    ) {
        let scene = self.scene(subject, &self.frame(subject, camera, grid, options));
        canvas.fill(self, encoder, subject, &scene, &self.white);
        self.finish(encoder, &scene, canvas, &self.white, view);
    }
}
