//! Coverage drawn by a graphics adapter (LT 3.6), for [`crate::paste`] to ask instead of the processor.
//!
//! Masks go to the device once. Then, for each batch of faces, what is transparent so far goes there, a compute pass lays the
//! patches over it, and what is left comes back. Results are the processor's, sample for sample, but for edge ties: where a
//! sample's place on a mask, in single precision, falls on the other side of the border between two of its pixels, or of the
//! distance within which it counts as opaque.

use super::context::Gpu;
use super::error::GpuError;
use super::pipelines::module;
use super::shape::{largest, words};
use crate::exemplar::CoverageMask;
use crate::paste::coverage_backend::{CoverageBackend, CoverageDrawer, CoveredFace};
use bytemuck::{Pod, Zeroable};
use std::ops::Range;
use wgpu::BufferUsages;

/// Invocations of a group, and groups along the first side of a dispatch, as in shaders/coverage.wgsl.
const GROUP: u32 = 64;
const ACROSS: u32 = 32768;

/// Runs drawn at once; what they take stays below every adapter's limits.
const MOST_RUNS: usize = 1 << 20;

/// Draws coverage on a device.
#[derive(Debug, Clone)]
pub struct GpuCoverage {
    gpu: Gpu,
    pipeline: wgpu::ComputePipeline,
}

impl GpuCoverage {
    /// Prepares a device.
    ///
    /// # Errors
    /// If it cannot compute, or refuses the shader.
    pub fn new(gpu: Gpu) -> Result<Self, GpuError> {
        if gpu.limits.max_compute_workgroup_size_x < GROUP || gpu.limits.max_storage_buffers_per_shader_stage < 6 {
            let what = "coverage is drawn in groups".to_owned();
            let (needs, has) = (u64::from(GROUP), u64::from(gpu.limits.max_compute_workgroup_size_x));
            return Err(GpuError::Limit { what, needs, has, remedy: "let the processor draw it (--coverage cpu)" });
        }
        let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("coverage"),
            layout: None,
            module: &module(&gpu, "coverage"),
            entry_point: Some("cover"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        gpu.check()?;
        Ok(Self { gpu, pipeline })
    }
}

impl CoverageBackend for GpuCoverage {
    fn prepare(&self, masks: &[CoverageMask]) -> Result<Box<dyn CoverageDrawer>, String> {
        let (mut table, mut pixels): (Vec<[u32; 4]>, Vec<[u32; 2]>) = (Vec::new(), Vec::new());
        for mask in masks {
            let [width, height] = mask.size();
            table.push([pixels.len() as u32, width, height, 0]);
            pixels.extend(mask.words());
            let (needs, has) = (8 * pixels.len() as u64, largest(&self.gpu));
            if needs > has {
                return Err(format!("the masks take {needs} bytes, and {} holds {has} at once", self.gpu.adapter()));
            }
        }
        let masks = words(&self.gpu, "masks", bytemuck::cast_slice(&table));
        let pixels = words(&self.gpu, "mask pixels", bytemuck::cast_slice(&pixels));
        self.gpu.check().map_err(|e| e.to_string())?;
        Ok(Box::new(Drawer { of: self.clone(), masks, pixels }))
    }
}

/// The masks of a job on the device.
#[derive(Debug)]
struct Drawer {
    of: GpuCoverage,
    masks: wgpu::Buffer,
    pixels: wgpu::Buffer,
}

/// `Face` of the shader.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Face {
    apex: [f32; 2],
    rows: u32,
    first: u32,
    overlays: u32,
    unused: u32,
}

/// `Overlay` of the shader.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Over {
    image: [[f32; 2]; 3],
    mask: u32,
    radius: f32,
    level: u32,
    unused: u32,
}

/// Faces whose runs are drawn at once.
fn parts(faces: &[CoveredFace]) -> Vec<Range<usize>> {
    let (mut parts, mut start, mut runs) = (Vec::new(), 0, 0);
    for (k, face) in faces.iter().enumerate() {
        let mine = face.runs().count();
        if runs + mine > MOST_RUNS && k > start {
            parts.push(start..k);
            (start, runs) = (k, 0);
        }
        runs += mine;
    }
    if start < faces.len() {
        parts.push(start..faces.len());
    }
    parts
}

impl CoverageDrawer for Drawer {
    fn cover(&self, faces: &[CoveredFace]) -> Result<Vec<Box<[u8]>>, String> {
        let mut drawn = Vec::with_capacity(faces.len());
        for part in parts(faces) {
            drawn.extend(self.draw(&faces[part]).map_err(|e| e.to_string())?);
        }
        Ok(drawn)
    }
}

impl Drawer {
    fn draw(&self, faces: &[CoveredFace]) -> Result<Vec<Box<[u8]>>, GpuError> {
        let gpu = &self.of.gpu;
        let (mut table, mut overlays, mut runs): (Vec<Face>, Vec<Over>, Vec<[u32; 4]>) = (Vec::new(), Vec::new(), Vec::new());
        let mut samples: Vec<[u8; 8]> = Vec::new();
        for (k, face) in faces.iter().enumerate() {
            let (first, count) = (overlays.len() as u32, face.over.len() as u32);
            table.push(Face { apex: face.apex.to_array(), rows: face.rows.len() as u32, first, overlays: count, unused: 0 });
            overlays.extend(face.over.iter().map(|o| Over {
                image: [o.origin, o.along, o.up].map(|v| v.to_array()),
                mask: o.mask,
                radius: o.radius,
                level: o.level,
                unused: 0,
            }));
            let mut at = 0;
            for (row, first, cells) in face.runs() {
                runs.push([k as u32, row, first, cells + 16 * face.rows[row as usize]]);
                let mut eight = [0; 8];
                eight[..cells as usize].copy_from_slice(&face.samples[at..at + cells as usize]);
                samples.push(eight);
                at += cells as usize;
            }
        }
        if runs.is_empty() {
            return Ok(vec![Box::default(); faces.len()]);
        }
        // The shader counts the runs by the length of their buffer.
        runs.resize(runs.len().max(4), [0; 4]);
        let size = 8 * runs.len() as u64;
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let buffer = |label, usage| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false })
        };
        let state = buffer("samples", usage);
        gpu.queue.write_buffer(&state, 0, bytemuck::cast_slice(&samples));
        let back = buffer("samples read back", BufferUsages::MAP_READ | BufferUsages::COPY_DST);
        let tables = [
            words(gpu, "runs", bytemuck::cast_slice(&runs)),
            words(gpu, "covered faces", bytemuck::cast_slice(&table)),
            words(gpu, "overlays", bytemuck::cast_slice(&overlays)),
        ];
        let all = tables.iter().chain([&self.masks, &self.pixels, &state]);
        let entries: Vec<wgpu::BindGroupEntry<'_>> =
            all.enumerate().map(|(k, b)| wgpu::BindGroupEntry { binding: k as u32, resource: b.as_entire_binding() }).collect();
        let layout = self.of.pipeline.get_bind_group_layout(0);
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout: &layout, entries: &entries });
        let groups = (runs.len() as u32).div_ceil(GROUP);
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass =
                encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("coverage"), timestamp_writes: None });
            pass.set_pipeline(&self.of.pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.dispatch_workgroups(groups.min(ACROSS), groups.div_ceil(ACROSS), 1);
        }
        encoder.copy_buffer_to_buffer(&state, 0, &back, 0, size);
        gpu.queue.submit([encoder.finish()]);
        let slice = back.slice(..);
        slice.map_async(wgpu::MapMode::Read, |_| ());
        gpu.wait()?;
        let data = slice.get_mapped_range().map_err(|e| GpuError::Refused { reason: e.to_string() })?;
        let mut eights = data.chunks_exact(8);
        let of_face = |face: &CoveredFace| {
            let mut out = Vec::with_capacity(face.samples.len());
            for ((_, _, cells), eight) in face.runs().zip(&mut eights) {
                out.extend_from_slice(&eight[..cells as usize]);
            }
            out.into_boxed_slice()
        };
        Ok(faces.iter().map(of_face).collect())
    }
}
