//! The samples of a picture: displayed light, by either way over the pastes.
//!
//! `single`: each face drawn once, its pastes walked from the top down, then lit. `layered` (LT 4): depth first, then the
//! pastes in paint order where depth is equal, blending the material; one more pass lights the sum. Since both light the same
//! sum, both give the same picture.
//!
//! Translucent materials repeat that from the nearest surface to the farthest: each time depth is drawn behind that of the
//! time before, and light is laid under what is there. So order is exact.

use super::error::GpuError;
use super::pipelines::{DEPTH, KEY, LIGHT, MATERIAL};
use super::renderer::{Path, Renderer};
use super::subject::Subject;
use super::target::{Target, begin};
use crate::exemplar::{Channel, ChannelSet};
use crate::render::reference::MAX_LAYERS;
use wgpu::{BindGroup, CommandEncoder};

/// Bytes that one group of blended material takes a sample.
const GROUP_BYTES: u64 = 8;

/// What the samples of a subject are drawn onto.
#[derive(Debug)]
pub struct Canvas {
    pub(super) size: [u32; 2],
    /// Displayed light times opacity, and opacity.
    pub(super) light: Target,
    depth: Target,
    /// Depth and face of this and the former surface, for translucent materials.
    keys: Option<[Target; 2]>,
    /// The material being blended, for `layered`.
    material: Option<Material>,
}

/// Groups of blended material.
#[derive(Debug)]
struct Material {
    pipeline: wgpu::RenderPipeline,
    /// Base colour, normal, gloss, emission, opacity; those that the subject has.
    groups: [Option<Target>; MATERIAL],
}

/// The groups of blended material that channels need.
fn groups(channels: ChannelSet) -> [bool; MATERIAL] {
    let any = |list: &[Channel]| list.iter().any(|&c| channels.has(c));
    [
        true,
        any(&[Channel::Normal]),
        any(&[Channel::Roughness, Channel::Metallic, Channel::Occlusion]),
        any(&[Channel::Emissive]),
        any(&[Channel::Opacity]),
    ]
}

impl Canvas {
    /// For `size` samples of a subject.
    ///
    /// # Errors
    /// If it would be larger than the device allows.
    pub fn new(renderer: &Renderer, subject: &Subject, size: [u32; 2], path: Path) -> Result<Self, GpuError> {
        let gpu = renderer.gpu();
        let longest = gpu.limits.max_texture_dimension_2d;
        let longer = size[0].max(size[1]);
        if size.contains(&0) || longer > longest {
            let what = format!("{} x {} samples cannot be drawn at once", size[0], size[1]);
            let (needs, has) = (u64::from(longer), u64::from(longest));
            return Err(GpuError::Limit { what, needs, has, remedy: "draw at least one, and no more on a side than that" });
        }
        let channels = subject.patches.channels;
        let target = |label, format| Target::new(gpu, label, size, format);
        let material = match path {
            Path::Single => None,
            Path::Layered => {
                let there = groups(channels);
                let needs = GROUP_BYTES * there.iter().filter(|t| **t).count() as u64;
                let has = u64::from(gpu.limits.max_color_attachment_bytes_per_sample);
                if needs > has {
                    let what = "the material's channels take too many bytes a sample to be blended in layers".to_owned();
                    return Err(GpuError::Limit { what, needs, has, remedy: "draw with the mode single" });
                }
                let pipeline = renderer.pipelines.layered(gpu, there);
                Some(Material { pipeline, groups: there.map(|there| there.then(|| target("material", LIGHT))) })
            }
        };
        let keys = channels.has(Channel::Opacity).then(|| [target("key", KEY), target("key", KEY)]);
        Ok(Self { size, light: target("light", LIGHT), depth: target("depth", DEPTH), keys, material })
    }

    /// The finished samples: displayed linear light times opacity, and opacity, as 16-bit floats.
    #[must_use]
    pub const fn view(&self) -> &wgpu::TextureView {
        &self.light.view
    }

    /// Draws all samples.
    pub(super) fn fill(
        &self,
        renderer: &Renderer,
        encoder: &mut CommandEncoder,
        subject: &Subject,
        scene: &BindGroup,
        openness: &Target,
    ) {
        let draw = Draw { canvas: self, renderer, subject, scene };
        match &self.keys {
            None => draw.surface(encoder, None, openness),
            Some(keys) => {
                for layer in 0..MAX_LAYERS {
                    draw.behind(encoder, keys, layer);
                    // Only the nearest surface is darkened by its surroundings.
                    let openness = if layer == 0 { openness } else { &renderer.white };
                    draw.surface(encoder, Some(layer), openness);
                }
            }
        }
    }
}

/// One subject on one canvas.
struct Draw<'a> {
    canvas: &'a Canvas,
    renderer: &'a Renderer,
    subject: &'a Subject,
    scene: &'a BindGroup,
}

impl Draw<'_> {
    /// Depth of the next surface behind the former one.
    fn behind(&self, encoder: &mut CommandEncoder, keys: &[Target; 2], layer: usize) {
        let pipelines = &self.renderer.pipelines;
        let (before, pipeline) =
            if layer == 0 { (&self.renderer.no_key, &pipelines.key) } else { (&keys[(layer + 1) % 2], &pipelines.key_behind) };
        let mut pass = begin(encoder, "behind", &[keys[layer % 2].attach(Some(0.0))], self.canvas.depth.attach_depth(true));
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, self.scene, &[]);
        for page in &self.subject.lists.pages {
            let group = self.renderer.bind(
                &self.renderer.layouts.depth,
                &[wgpu::BindingResource::TextureView(&before.view), page.first.as_entire_binding()],
            );
            pass.set_bind_group(3, &group, &[]);
            pass.set_bind_group(1, &page.tables, &[]);
            pass.draw(0..3 * page.faces.len() as u32, 0..1);
        }
    }

    /// One surface: the nearest, or the `layer`th whose depth is drawn already.
    fn surface(&self, encoder: &mut CommandEncoder, layer: Option<usize>, openness: &Target) {
        let pipelines = &self.renderer.pipelines;
        let clear = (layer.unwrap_or(0) == 0).then_some(0.0);
        let Some(material) = &self.canvas.material else {
            let (pipeline, fresh) = layer.map_or((&pipelines.single, true), |_| (&pipelines.single_under, false));
            let open = self.renderer.bind_views(&self.renderer.layouts.openness, &[openness]);
            self.light(encoder, pipeline, &open, clear, fresh);
            return;
        };
        if layer.is_none() {
            let mut pass = begin(encoder, "depth", &[], self.canvas.depth.attach_depth(true));
            pass.set_pipeline(&pipelines.depth);
            pass.set_bind_group(0, self.scene, &[]);
            let group = self.renderer.bind(
                &self.renderer.layouts.depth,
                &[wgpu::BindingResource::TextureView(&self.renderer.no_key.view), self.renderer.zero.as_entire_binding()],
            );
            pass.set_bind_group(3, &group, &[]);
            self.subject.draw_faces(&mut pass);
        }
        self.blend(encoder, material);
        let black = &self.renderer.white;
        let read: Vec<&Target> =
            std::iter::once(openness).chain(material.groups.iter().map(|g| g.as_ref().unwrap_or(black))).collect();
        let group = self.renderer.bind_views(&self.renderer.layouts.light, &read);
        self.light(encoder, &pipelines.light, &group, clear, false);
    }

    /// The pastes in paint order.
    fn blend(&self, encoder: &mut CommandEncoder, material: &Material) {
        let colors = material.groups.each_ref().map(|g| g.as_ref().and_then(|target| target.attach(Some(0.0))));
        let mut pass = begin(encoder, "layered", &colors, self.canvas.depth.attach_depth(false));
        pass.set_pipeline(&material.pipeline);
        pass.set_bind_group(0, self.scene, &[]);
        pass.set_bind_group(2, &self.subject.patches.bindings, &[]);
        for page in &self.subject.lists.pages {
            pass.set_bind_group(1, &page.tables, &[]);
            pass.draw(0..3 * page.entries, 0..1);
        }
    }

    /// Faces drawn onto the canvas's light; `fresh` begins with no depth.
    fn light(
        &self,
        encoder: &mut CommandEncoder,
        pipeline: &wgpu::RenderPipeline,
        group: &BindGroup,
        clear: Option<f64>,
        fresh: bool,
    ) {
        let canvas = self.canvas;
        let mut pass = begin(encoder, "light", &[canvas.light.attach(clear)], canvas.depth.attach_depth(fresh));
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, self.scene, &[]);
        pass.set_bind_group(3, group, &[]);
        self.subject.draw_faces(&mut pass);
    }
}
