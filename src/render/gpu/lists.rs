//! Paste lists on the device, in pages.
//!
//! A page is a run of faces whose lists fit one binding; a mesh with few pastes has one. Which paste lies over which matters
//! only among those on the same face, so pages can be drawn one after another, in both ways of drawing.
//!
//! Where layers are mixed by weights or have bases, a marker stands on top of each layer's pastes on a face: an entry without a paste,
//! with the layer's weights and base at the face's corners in place of texture coordinates. Where faces have colours of their own, these stand
//! on top of everything, in entries without a paste as well.

use super::context::Gpu;
use super::error::GpuError;
use super::shape::{largest, octahedral, words};
use crate::mesh::Mesh;
use crate::paste::cut::CUT_STEPS;
use crate::paste::{AGREES, FaceLists, LappedTexture, Layer, Paste};
use glam::{Vec3, Vec4};
use rayon::prelude::*;
use std::ops::Range;
use wgpu::util::DeviceExt;

/// 32-bit words of one entry: paste, face, and three texture coordinates.
const ENTRY_WORDS: usize = 8;
/// A cut in fours of words.
const CUT_FOURS: u32 = CUT_STEPS as u32 / 8;
/// Bytes that a face takes in the largest of the tables that grow with faces.
const FACE_BYTES: u64 = 12;

/// What stands for the paste in a layer's marker, as in shaders/paste.wgsl.
const MARKER: u32 = u32::MAX;
/// What stands for the paste where a face has colours of its own.
const TINT: u32 = u32::MAX - 1;

/// The layers of a lapped texture, if any are mixed by weights or have bases.
struct Soft<'a> {
    layers: &'a [Layer],
    /// One past the last paste of each.
    ends: Vec<u32>,
}

impl<'a> Soft<'a> {
    fn new(layers: &'a [Layer]) -> Option<Self> {
        let add = |end: &mut u32, layer: &Layer| {
            *end += layer.pastes;
            Some(*end)
        };
        let soft = layers.iter().any(|layer| !(layer.weights.is_empty() && layer.base.is_empty()));
        soft.then(|| Self { layers, ends: layers.iter().scan(0, add).collect() })
    }

    fn layer(&self, paste: u32) -> usize {
        self.ends.partition_point(|&end| end <= paste)
    }

    /// The runs of a face's list that belong to one layer.
    fn runs<'l>(&'l self, list: &'l [(u32, u32)]) -> impl Iterator<Item = &'l [(u32, u32)]> {
        list.chunk_by(|a, b| self.layer(a.0) == self.layer(b.0))
    }

    fn marker(&self, face: u32, paste: u32) -> [u32; ENTRY_WORDS] {
        let layer = self.layers.get(self.layer(paste));
        let weights = layer.and_then(|l| l.weights.get(face as usize)).copied().unwrap_or([1.0; 3]);
        let base = layer.and_then(|l| l.base.get(face as usize));
        let [a, b, c] = weights.map(|w| (w.clamp(0.0, 1.0) * 65535.0).round() as u32);
        let [[d, e, f], [g, h, i], [j, k, l]] = base.copied().unwrap_or_default().map(|corner| corner.map(u32::from));
        [MARKER, u32::from(base.is_some()), a | b << 16, c | d << 16, e | f << 16, g | h << 16, i | j << 16, k | l << 16]
    }
}

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
    /// Layers are mixed by weights, so there are markers.
    pub(super) soft: bool,
}

/// The pastes, eight words each, and after them the cuts, two bytes a step. The first word is a patch, and above it how far the paste is from
/// agreeing with what lies below. A paste names where its cut begins, in fours of words;
/// 0: it has none. Then come its shift, and the cosine and sine of its turn.
fn paste_table(pastes: &[Paste]) -> Vec<u32> {
    let mut table = Vec::with_capacity(8 * pastes.len());
    let mut next = 2 * pastes.len() as u32;
    for paste in pastes {
        let at = if paste.cut.is_some() { next } else { 0 };
        next += if paste.cut.is_some() { CUT_FOURS } else { 0 };
        let apart = u32::from(AGREES - paste.agreement);
        table.extend([u32::from(paste.patch) | apart << 16, at, paste.offset.x.to_bits(), paste.offset.y.to_bits()]);
        let turn = paste.turn.rotation();
        table.extend([turn.x.to_bits(), turn.y.to_bits(), 0, 0]);
    }
    for cut in pastes.iter().filter_map(|p| p.cut.as_ref()) {
        table.extend(cut.steps().as_chunks::<2>().0.iter().map(|[a, b]| u32::from_le_bytes([a[0], a[1], b[0], b[1]])));
    }
    table
}

/// A face's own colours as an entry: four numbers of 16 bits a corner, of 0 to 1.
fn tint(face: u32, corners: &[Vec4; 3]) -> [u32; ENTRY_WORDS] {
    let mut entry = [TINT, face, 0, 0, 0, 0, 0, 0];
    for (at, color) in entry[2..].as_chunks_mut::<2>().0.iter_mut().zip(corners) {
        let [r, g, b, a] = color.to_array().map(|v| (v.clamp(0.0, 1.0) * 65535.0).round() as u32);
        *at = [r | g << 16, b | a << 16];
    }
    entry
}

/// Where each face's list begins if layers have markers.
fn with_markers(lists: &FaceLists, soft: &Soft<'_>) -> Vec<u32> {
    let faces = lists.start.len().saturating_sub(1) as u32;
    let length = |face: u32| (lists.of(face).len() + soft.runs(lists.of(face)).count()) as u32;
    let lengths: Vec<u32> = (0..faces).into_par_iter().map(length).collect();
    let mut sum = 0;
    let add = |length: u32| {
        sum += length;
        sum
    };
    std::iter::once(0).chain(lengths.into_iter().map(add)).collect()
}

impl Lists {
    pub(super) fn new(
        gpu: &Gpu,
        layout: &wgpu::BindGroupLayout,
        mesh: &Mesh,
        normals: &[[Vec3; 3]],
        lapped: &LappedTexture,
        tints: Option<&[[Vec4; 3]]>,
    ) -> Result<Self, GpuError> {
        let pastes = &lapped.pastes;
        let lists = FaceLists::new(mesh.face_count(), pastes);
        let soft = Soft::new(&lapped.layers);
        let mut start = match &soft {
            None => lists.start.clone(),
            Some(soft) => with_markers(&lists, soft),
        };
        if tints.is_some() {
            start.iter_mut().zip(0..).for_each(|(begin, faces)| *begin += faces);
        }
        let mut pages = Vec::new();
        for faces in split(&start, largest(gpu))? {
            let range = faces.start as usize..faces.end as usize;
            let starts = start[range.start..=range.end].iter().map(|s| s - start[range.start]).collect();
            let tints = tints.map(|tints| &tints[range.clone()]);
            pages.push(Page::new(gpu, layout, mesh, &normals[range], pastes, &lists, soft.as_ref(), tints, starts, faces));
            // Each page's tables go to the device before the next ones are made, so that memory holds one page at a time.
            gpu.queue.submit([]);
        }
        let table = paste_table(pastes);
        let needs = 4 * table.len() as u64;
        if needs > largest(gpu) {
            let what = "the pastes take more bytes than one binding".to_owned();
            return Err(GpuError::Limit { what, needs, has: largest(gpu), remedy: "paste at a larger scale" });
        }
        Ok(Self { pages, pastes: words(gpu, "pastes", bytemuck::cast_slice(&table)), soft: soft.is_some() })
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
    #[allow(clippy::too_many_arguments, reason = "all the tables that a page is cut from")]
    fn new(
        gpu: &Gpu,
        layout: &wgpu::BindGroupLayout,
        mesh: &Mesh,
        normals: &[[Vec3; 3]],
        pastes: &[Paste],
        lists: &FaceLists,
        soft: Option<&Soft<'_>>,
        tints: Option<&[[Vec4; 3]]>,
        starts: Vec<u32>,
        faces: Range<u32>,
    ) -> Self {
        let range = faces.start as usize..faces.end as usize;
        let of_faces: Vec<Vec<u32>> = range
            .clone()
            .into_par_iter()
            .map(|face| {
                let entry = |&(paste, slot): &(u32, u32)| {
                    let [a, b, c] = pastes[paste as usize].uv[slot as usize];
                    let uv = [a.x, a.y, b.x, b.y, c.x, c.y].map(f32::to_bits);
                    [[paste, (face - range.start) as u32].as_slice(), &uv].concat()
                };
                let list = lists.of(face as u32);
                let mut of_face: Vec<u32> = match soft {
                    None => list.iter().flat_map(entry).collect(),
                    Some(soft) => {
                        let marked = |run: &[(u32, u32)]| {
                            let marker = soft.marker(face as u32, run[0].0);
                            run.iter().flat_map(entry).chain(marker).collect::<Vec<u32>>()
                        };
                        soft.runs(list).flat_map(marked).collect()
                    }
                };
                let own = |tints: &[[Vec4; 3]]| tint((face - range.start) as u32, &tints[face - range.start]);
                of_face.extend(tints.map(own).iter().flatten());
                of_face
            })
            .collect();
        let entries = of_faces.concat();
        let all = 0..(entries.len() / ENTRY_WORDS) as u32;
        let mut order: Vec<u32> = all.filter(|&e| entries[e as usize * ENTRY_WORDS] != MARKER).collect();
        let count = order.len();
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
