//! The mesh on the device: vertices, faces and smooth normals, to be pulled by the shaders.
//!
//! Shaders count in single precision, so positions are given relative to the middle of the mesh's bounds and in units of
//! their diagonal: meshes of any size and far from the origin look the same.

use super::context::Gpu;
use super::error::GpuError;
use crate::mesh::Mesh;
use glam::{DVec3, Vec2, Vec3};
use rayon::prelude::*;
use wgpu::BufferUsages;

/// Where the mesh's own coordinates lie in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Units {
    pub(super) middle: DVec3,
    /// Units per world unit.
    pub(super) scale: f64,
}

impl Units {
    pub(super) fn of(mesh: &Mesh) -> Self {
        let (low, high) = mesh.bounds();
        let diagonal = (high.as_dvec3() - low.as_dvec3()).length();
        let scale = if diagonal > 0.0 { diagonal.recip() } else { 1.0 };
        Self { middle: 0.5 * (low.as_dvec3() + high.as_dvec3()), scale }
    }

    pub(super) fn point(&self, p: DVec3) -> DVec3 {
        (p - self.middle) * self.scale
    }
}

/// No table has larger rows than this, and shaders want room for one.
const SMALLEST: usize = 64;

/// A buffer of 32-bit words for shaders to read; never empty.
pub(super) fn words(gpu: &Gpu, label: &str, data: &[u8]) -> wgpu::Buffer {
    let size = data.len().max(SMALLEST).next_multiple_of(4) as u64;
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false });
    if !data.is_empty() {
        gpu.queue.write_buffer(&buffer, 0, data);
    }
    buffer
}

/// The largest buffer a shader can be given, bytes.
pub(super) fn largest(gpu: &Gpu) -> u64 {
    gpu.limits.max_storage_buffer_binding_size.min(gpu.limits.max_buffer_size)
}

/// The vertices on the device.
#[derive(Debug)]
pub(super) struct Shape {
    pub(super) units: Units,
    pub(super) positions: wgpu::Buffer,
    pub(super) vertices: usize,
    /// Bounds in the mesh's own units.
    pub(super) bounds: (Vec3, Vec3),
}

impl Shape {
    pub(super) fn new(gpu: &Gpu, mesh: &Mesh) -> Result<Self, GpuError> {
        let units = Units::of(mesh);
        let needs = 12 * mesh.vertex_count() as u64;
        let has = largest(gpu);
        if needs > has {
            let what = "the mesh's vertices take more bytes than one binding".to_owned();
            return Err(GpuError::Limit { what, needs, has, remedy: "draw with the mode reference" });
        }
        let (data, bounds) = relative(&units, &mesh.positions);
        let positions = words(gpu, "positions", bytemuck::cast_slice(&data));
        Ok(Self { units, positions, vertices: mesh.vertex_count(), bounds })
    }

    /// Moves the vertices.
    pub(super) fn set(&mut self, gpu: &Gpu, positions: &[Vec3]) -> Result<(), GpuError> {
        if positions.len() != self.vertices {
            return Err(GpuError::Positions { found: positions.len(), expected: self.vertices });
        }
        let (data, bounds) = relative(&self.units, positions);
        gpu.queue.write_buffer(&self.positions, 0, bytemuck::cast_slice(&data));
        self.bounds = bounds;
        Ok(())
    }
}

fn relative(units: &Units, positions: &[Vec3]) -> (Vec<Vec3>, (Vec3, Vec3)) {
    let data: Vec<Vec3> = positions.par_iter().map(|p| units.point(p.as_dvec3()).as_vec3()).collect();
    let bounds = data.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), &p| (low.min(p), high.max(p)));
    (data, bounds)
}

/// Unit normals as two 16-bit numbers on the octahedron.
pub(super) fn octahedral(normals: &[[Vec3; 3]]) -> Vec<u32> {
    let pack = |n: Vec3| {
        let n = n / (n.x.abs() + n.y.abs() + n.z.abs()).max(f32::MIN_POSITIVE);
        let side = Vec2::new(1.0_f32.copysign(n.x), 1.0_f32.copysign(n.y));
        let p = if n.z < 0.0 { (1.0 - Vec2::new(n.y, n.x).abs()) * side } else { n.truncate() };
        let [x, y] = p.to_array().map(|v| u32::from((v * 32767.0).round() as i16 as u16));
        x | y << 16
    };
    normals.as_flattened().par_iter().map(|&n| pack(n)).collect()
}
