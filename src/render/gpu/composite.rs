//! What pastes show at points of the surface, asked of a graphics adapter: for [`crate::atlas::bake()`] to bake from instead of
//! the processor's [`Composite`].
//!
//! The mesh, its pastes and the exemplars go to the device once; then points go there many at a time, a compute pass
//! composites the pastes at each, and texels come back. Which points those are, edges, gutters and borders are the baker's
//! business either way, so the two bakes differ only by what the device stores in 8 bits: exemplars, heights among them, and
//! masks.

use super::context::Gpu;
use super::error::GpuError;
use super::frame::Frame;
use super::lists::{Lists, Page};
use super::patches::PatchTextures;
use super::pipelines::{Layouts, module};
use super::renderer::Filter;
use super::shape::{Shape, largest};
use crate::exemplar::ChannelSet;
use crate::mesh::{Mesh, SurfacePoint};
use crate::paste::{Composite, CompositeBackend, LappedTexture};
use crate::render::camera::View;
use crate::render::lens::Grid;
use crate::render::reference::DrawOptions;
use crate::surface::{SurfaceTexture, Texel};
use glam::Vec3;
use std::sync::{Arc, Mutex, PoisonError};

/// Invocations of a group, as in shaders/texels.wgsl.
const GROUP: usize = 64;

/// Points asked about at once, if the adapter takes so many.
const MOST: usize = 1 << 15;

/// A point, then its texel, in the shader's words.
type Words = [u32; 8];

/// Composites pastes on a device.
#[derive(Debug, Clone)]
pub struct GpuComposite {
    gpu: Gpu,
    layouts: Arc<Layouts>,
    pipeline: wgpu::ComputePipeline,
}

impl GpuComposite {
    /// Prepares a device.
    ///
    /// # Errors
    /// If it cannot compute, or refuses the shader.
    pub fn new(gpu: Gpu) -> Result<Self, GpuError> {
        let limits = &gpu.limits;
        for (what, needs, has) in [
            ("texels are composited in groups", GROUP as u32, limits.max_compute_workgroup_size_x),
            ("texels are composited from tables", 8, limits.max_storage_buffers_per_shader_stage),
        ] {
            if has < needs {
                let (needs, has) = (u64::from(needs), u64::from(has));
                return Err(GpuError::Limit { what: what.to_owned(), needs, has, remedy: "let the processor bake" });
            }
        }
        let layouts = Layouts::new(&gpu);
        let groups = [&layouts.scene, &layouts.page, &layouts.patches, &layouts.points].map(Some);
        let descriptor = wgpu::PipelineLayoutDescriptor { label: Some("texels"), bind_group_layouts: &groups, immediate_size: 0 };
        let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("texels"),
            layout: Some(&gpu.device.create_pipeline_layout(&descriptor)),
            module: &module(&gpu, "texels"),
            entry_point: Some("composite"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        gpu.check()?;
        Ok(Self { gpu, layouts: Arc::new(layouts), pipeline })
    }

    fn bind(&self, layout: &wgpu::BindGroupLayout, buffers: &[&wgpu::Buffer]) -> wgpu::BindGroup {
        let entries: Vec<wgpu::BindGroupEntry<'_>> = buffers
            .iter()
            .enumerate()
            .map(|(i, buffer)| wgpu::BindGroupEntry { binding: i as u32, resource: buffer.as_entire_binding() })
            .collect();
        self.gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some("texels"), layout, entries: &entries })
    }

    fn bring<'a>(&self, mesh: &'a Mesh, lapped: &'a LappedTexture) -> Result<OnDevice<'a>, GpuError> {
        let (gpu, layouts) = (&self.gpu, &self.layouts);
        let patches = PatchTextures::new(gpu, &layouts.patches, Filter::Area, &lapped.exemplars, &lapped.patches)?;
        if let Some(warning) = patches.warnings().first() {
            let (needs, has) = (0, u64::from(gpu.limits.max_texture_dimension_2d));
            return Err(GpuError::Limit { what: warning.clone(), needs, has, remedy: "let the processor bake" });
        }
        let shape = Shape::new(gpu, mesh)?;
        // Points have the normals of their faces; smooth ones are not looked at.
        let lists = Lists::new(gpu, &layouts.page, mesh, &vec![[Vec3::Z; 3]; mesh.face_count()], lapped, None)?;
        // Of the frame only the channels matter.
        let grid = Grid { width: 1, height: 1, samples: 1 };
        let frame = Frame::new(&shape, patches.channels, &View::default().frame(mesh, 1.0), grid, &DrawOptions::default());
        let frame = frame.with_layers(lists.soft).upload(gpu);
        let scene = self.bind(&layouts.scene, &[&frame, &shape.positions, &lists.pastes]);
        let most = MOST.min(largest(gpu) as usize / size_of::<Words>()).max(GROUP) / GROUP * GROUP;
        let size = (most * size_of::<Words>()) as u64;
        let buffer = |label, usage| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false })
        };
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
        let state = buffer("points", usage);
        let back = buffer("texels read back", wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);
        let points = self.bind(&layouts.points, &[&state]);
        gpu.check()?;
        let composite = Composite::new(mesh, lapped);
        let scale = shape.units.scale;
        let buffers = Mutex::new([state, back]);
        Ok(OnDevice { composite, of: self.clone(), scale, lists, patches, scene, points, most, buffers })
    }
}

impl CompositeBackend for GpuComposite {
    fn load<'a>(&self, mesh: &'a Mesh, lapped: &'a LappedTexture) -> Result<Box<dyn SurfaceTexture + 'a>, String> {
        Ok(Box::new(self.bring(mesh, lapped).map_err(|e| e.to_string())?))
    }
}

/// A lapped texture on the device. Single points are composited by the processor: they are not worth the way.
struct OnDevice<'a> {
    composite: Composite<'a>,
    of: GpuComposite,
    /// Units per world unit.
    scale: f64,
    lists: Lists,
    patches: PatchTextures,
    scene: wgpu::BindGroup,
    points: wgpu::BindGroup,
    /// Points asked about at once.
    most: usize,
    /// Points on the device, and their way back: one batch at a time, since threads that draw at once wait for each other anyway.
    buffers: Mutex<[wgpu::Buffer; 2]>,
}

impl SurfaceTexture for OnDevice<'_> {
    fn channels(&self) -> ChannelSet {
        self.composite.channels()
    }

    fn texel(&self, at: SurfacePoint, footprint: f32) -> Texel {
        self.composite.texel(at, footprint)
    }

    fn texels(&self, points: &[(SurfacePoint, f32)], shown: &mut [Texel]) -> Result<(), String> {
        for page in &self.lists.pages {
            let mine: Vec<usize> = (0..points.len()).filter(|&i| page.faces.contains(&points[i].0.face)).collect();
            for some in mine.chunks(self.most) {
                let asked = |&i: &usize| self.asked(page, points[i]);
                let words = self.answered(page, some.iter().map(asked).collect()).map_err(|e| e.to_string())?;
                for (&i, words) in some.iter().zip(&words) {
                    shown[i] = texel(*words);
                }
            }
        }
        Ok(())
    }
}

impl OnDevice<'_> {
    fn asked(&self, page: &Page, (at, footprint): (SurfacePoint, f32)) -> Words {
        let width = (f64::from(footprint) * self.scale) as f32;
        let [y, z, width] = [at.bary.y, at.bary.z, width].map(f32::to_bits);
        [at.face - page.faces.start, y, z, width, 0, 0, 0, 0]
    }

    fn answered(&self, page: &Page, mut words: Vec<Words>) -> Result<Vec<Words>, GpuError> {
        let gpu = &self.of.gpu;
        let count = words.len();
        // The last group is filled up with points of the first face.
        words.resize(count.next_multiple_of(GROUP), [0; 8]);
        let buffers = self.buffers.lock().unwrap_or_else(PoisonError::into_inner);
        let [state, back] = &*buffers;
        gpu.queue.write_buffer(state, 0, bytemuck::cast_slice(&words));
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let descriptor = wgpu::ComputePassDescriptor { label: Some("texels"), timestamp_writes: None };
            let mut pass = encoder.begin_compute_pass(&descriptor);
            pass.set_pipeline(&self.of.pipeline);
            for (group, bindings) in [&self.scene, &page.tables, &self.patches.bindings, &self.points].into_iter().enumerate() {
                pass.set_bind_group(group as u32, bindings, &[]);
            }
            pass.dispatch_workgroups((words.len() / GROUP) as u32, 1, 1);
        }
        let size = size_of_val(words.as_slice()) as u64;
        encoder.copy_buffer_to_buffer(state, 0, back, 0, size);
        gpu.queue.submit([encoder.finish()]);
        let slice = back.slice(..size);
        slice.map_async(wgpu::MapMode::Read, |_| ());
        gpu.wait()?;
        let refused = |e: wgpu::MapRangeError| GpuError::Refused { reason: e.to_string() };
        words.copy_from_slice(bytemuck::cast_slice(&slice.get_mapped_range().map_err(refused)?));
        back.unmap();
        Ok(words)
    }
}

/// A texel of its words.
fn texel(words: Words) -> Texel {
    let half = |k: usize| (words[k / 2] >> (16 * (k % 2))) as u16;
    let whole = |k: usize| f32::from(half(k)) / 65535.0;
    let signed = |k: usize| f32::from(half(k) as i16) / 32767.0;
    let three = |k: usize| Vec3::new(whole(k), whole(k + 1), whole(k + 2));
    Texel {
        base_color: three(0),
        alpha: whole(3),
        normal: Vec3::new(signed(4), signed(5), signed(6)).normalize_or_zero(),
        height: signed(7),
        roughness: whole(8),
        metallic: whole(9),
        occlusion: whole(10),
        opacity: whole(11),
        emissive: three(12),
    }
}
