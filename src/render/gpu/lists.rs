//! Paste lists on the device, in pages.
//!
//! A page is a run of faces whose lists fit one binding; a mesh with few pastes has one. Which paste lies over which matters
//! only among those on the same face, so pages can be drawn one after another, in both ways of drawing.

use super::context::Gpu;
use super::error::GpuError;
use super::shape::{largest, octahedral, words};
use crate::mesh::Mesh;
use crate::paste::{FaceLists, Paste};
use glam::Vec3;
use rayon::prelude::*;
use std::ops::Range;
use wgpu::util::DeviceExt;

/// 32-bit words of one entry: paste, face, and three texture coordinates.
const ENTRY_WORDS: usize = 8;
/// Bytes that a face takes in the largest of the tables that grow with faces.
const FACE_BYTES: u64 = 12;

/// A run of faces with their pastes.
#[derive(Debug)]
pub(super) struct Page {
    pub(super) faces: Range<u32>,
    /// Faces of pastes, each of which `layered` draws.
    pub(super) entries: u32,
    normals: wgpu::Buffer,
    pub(super) tables: wgpu::BindGroup,
    /// The first face, for passes that number faces.
    pub(super) first: wgpu::Buffer,
    bytes: u64,
}

/// All pastes on the device.
#[derive(Debug)]
pub(super) struct Lists {
    pub(super) pages: Vec<Page>,
    pub(super) pastes: wgpu::Buffer,
}

impl Lists {
    pub(super) fn new(
        gpu: &Gpu,
        layout: &wgpu::BindGroupLayout,
        mesh: &Mesh,
        normals: &[[Vec3; 3]],
        pastes: &[Paste],
    ) -> Result<Self, GpuError> {
        let lists = FaceLists::new(mesh.face_count(), pastes);
        let mut pages = Vec::new();
        for faces in split(&lists.start, largest(gpu))? {
            pages.push(Page::new(gpu, layout, mesh, &normals[faces.start as usize..faces.end as usize], pastes, &lists, faces));
            // Each page's tables go to the device before the next ones are made, so that memory holds one page at a time.
            gpu.queue.submit([]);
        }
        let table: Vec<u32> =
            pastes.iter().flat_map(|p| [u32::from(p.patch), 0, p.offset.x.to_bits(), p.offset.y.to_bits()]).collect();
        let needs = 4 * table.len() as u64;
        if needs > largest(gpu) {
            let what = "the pastes take more bytes than one binding".to_owned();
            return Err(GpuError::Limit { what, needs, has: largest(gpu), remedy: "paste at a larger scale" });
        }
        Ok(Self { pages, pastes: words(gpu, "pastes", bytemuck::cast_slice(&table)) })
    }

    /// New smooth normals at the corners of all faces.
    pub(super) fn set_normals(&self, gpu: &Gpu, normals: &[[Vec3; 3]]) {
        for page in &self.pages {
            let data = octahedral(&normals[page.faces.start as usize..page.faces.end as usize]);
            gpu.queue.write_buffer(&page.normals, 0, bytemuck::cast_slice(&data));
        }
    }

    pub(super) fn bytes(&self) -> u64 {
        self.pages.iter().map(|page| page.bytes).sum::<u64>() + self.pastes.size()
    }
}

impl Page {
    fn new(
        gpu: &Gpu,
        layout: &wgpu::BindGroupLayout,
        mesh: &Mesh,
        normals: &[[Vec3; 3]],
        pastes: &[Paste],
        lists: &FaceLists,
        faces: Range<u32>,
    ) -> Self {
        let range = faces.start as usize..faces.end as usize;
        let base = lists.start[range.start];
        let starts: Vec<u32> = lists.start[range.start..=range.end].iter().map(|s| s - base).collect();
        let of_faces: Vec<Vec<u32>> = range
            .clone()
            .into_par_iter()
            .map(|face| {
                let entry = |&(paste, slot): &(u32, u32)| {
                    let [a, b, c] = pastes[paste as usize].uv[slot as usize];
                    let uv = [a.x, a.y, b.x, b.y, c.x, c.y].map(f32::to_bits);
                    [[paste, (face - range.start) as u32].as_slice(), &uv].concat()
                };
                lists.of(face as u32).iter().flat_map(entry).collect()
            })
            .collect();
        let entries = of_faces.concat();
        let count = entries.len() / ENTRY_WORDS;
        let mut order: Vec<u32> = (0..count as u32).collect();
        order.par_sort_unstable_by_key(|&e| (entries[e as usize * ENTRY_WORDS], e));

        let corners = words(gpu, "faces", bytemuck::cast_slice(&mesh.faces[range]));
        let normals = words(gpu, "normals", bytemuck::cast_slice(&octahedral(normals)));
        let starts = words(gpu, "starts", bytemuck::cast_slice(&starts));
        let entries = words(gpu, "entries", bytemuck::cast_slice(&entries));
        let order = words(gpu, "order", bytemuck::cast_slice(&order));
        let buffers = [&corners, &normals, &starts, &entries, &order];
        let bound: Vec<wgpu::BindGroupEntry<'_>> = buffers
            .iter()
            .enumerate()
            .map(|(i, buffer)| wgpu::BindGroupEntry { binding: i as u32, resource: buffer.as_entire_binding() })
            .collect();
        let tables = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some("page"), layout, entries: &bound });
        let first = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("first face"),
            contents: bytemuck::cast_slice(&[faces.start, 0, 0, 0]),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        let bytes = buffers.iter().map(|b| b.size()).sum();
        Self { faces, entries: count as u32, normals, tables, first, bytes }
    }
}

/// Cuts the faces into runs whose tables are at most `most` bytes each. `start` says where each face's list begins.
fn split(start: &[u32], most: u64) -> Result<Vec<Range<u32>>, GpuError> {
    let entry_bytes = 4 * ENTRY_WORDS as u64;
    let faces = start.len().saturating_sub(1);
    let mut runs = Vec::new();
    let mut first = 0;
    while first < faces {
        let entries = |end: usize| u64::from(start[end] - start[first]);
        let room = (most / FACE_BYTES).saturating_sub(1).min((faces - first) as u64) as usize;
        let end = first + start[first..=first + room].partition_point(|&s| u64::from(s - start[first]) * entry_bytes <= most) - 1;
        if end == first {
            let what = format!("the pastes on face {first} take more bytes than one binding");
            let needs = entries(first + 1) * entry_bytes;
            return Err(GpuError::Limit { what, needs, has: most, remedy: "paste at a larger scale" });
        }
        runs.push(first as u32..end as u32);
        first = end;
    }
    Ok(runs)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_face_is_in_one_page_that_fits() {
        // Lists of 0 to 4 pastes.
        let mut start = vec![0];
        (0..1000_u32).for_each(|f| start.push(start[f as usize] + f % 5));
        for most in [160, 200, 1000, 12_000, 1 << 20] {
            let pages = split(&start, most).unwrap();
            assert_eq!(pages.first().map(|p| p.start), Some(0), "from the first face");
            assert_eq!(pages.last().map(|p| p.end), Some(1000), "to the last");
            assert!(pages.windows(2).all(|w| w[0].end == w[1].start), "without gaps");
            for page in &pages {
                let entries = u64::from(start[page.end as usize] - start[page.start as usize]);
                assert!(entries * 32 <= most && page.len() as u64 * 12 <= most, "{page:?} fits {most} bytes");
            }
        }
        assert_eq!(split(&start, 1 << 20).unwrap().len(), 1, "one page where all fits");
        assert!(matches!(split(&start, 100), Err(GpuError::Limit { needs: 128, .. })), "a list of four that cannot fit");
    }
}
