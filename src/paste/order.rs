//! Ordering pastes so that hard edges hide, and removing what cannot be seen.
//!
//! Coverage does not depend on the order of pastes: what shows through a point is the product of what each lets through.
//! So once everything is covered the pastes may be sorted, those with the most hard edges to the bottom, where later
//! ones lie over them. Then, from the top down, each face keeps the pastes of which anything can be seen (LT 4).

use super::composite::paste_alpha;
use super::coverage::{Lattice, Tile};
use super::lapped::{FaceLists, LappedTexture, Paste};
use crate::exemplar::CoverageMask;
use crate::mesh::Mesh;
use glam::{DVec2, Vec3};
use rayon::prelude::*;

/// Places where a hard edge is looked at.
const EDGE_SAMPLES: u32 = 8;

/// A hard edge with less alpha than this on the mean is no edge an eye could find.
const FAINT: f32 = 0.02;

/// An edge of a paste's surface patch where its texture ends without falling off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HardEdge {
    /// The face on the paste's side.
    pub face: u32,
    /// That face's edge, from this corner to the next.
    pub edge: u8,
    /// World length times mean alpha.
    pub weight: f32,
}

/// The open edges of a paste where its alpha is not faint. `open` are (place among the paste's faces, edge).
#[must_use]
pub fn hard_edges(
    mesh: &Mesh,
    mask: &CoverageMask,
    faces: &[u32],
    pixels: &[[DVec2; 3]],
    open: &[(usize, usize)],
) -> Vec<HardEdge> {
    open.iter()
        .filter_map(|&(slot, edge)| {
            let (a, b) = (pixels[slot][edge], pixels[slot][(edge + 1) % 3]);
            let sum: f32 = edge_steps().map(|t| mask.alpha(a.lerp(b, f64::from(t)).as_vec2())).sum();
            let alpha = sum / EDGE_SAMPLES as f32;
            let p = mesh.corners(faces[slot]);
            let length = p[edge].distance(p[(edge + 1) % 3]) as f32;
            (alpha > FAINT).then_some(HardEdge { face: faces[slot], edge: edge as u8, weight: length * alpha })
        })
        .collect()
}

/// Places along an edge, 0 to 1.
fn edge_steps() -> impl Iterator<Item = f32> {
    (0..EDGE_SAMPLES).map(|i| (i as f32 + 0.5) / EDGE_SAMPLES as f32)
}

/// The order of pastes that puts those with the longest hard edges at the bottom; equal ones keep their order.
#[must_use]
pub fn by_hard_edges(edges: &[Vec<HardEdge>]) -> Vec<u32> {
    let length: Vec<f64> = edges.iter().map(|e| e.iter().map(|e| f64::from(e.weight)).sum()).collect();
    let mut order: Vec<u32> = (0..edges.len() as u32).collect();
    order.sort_by(|&a, &b| length[b as usize].total_cmp(&length[a as usize]));
    order
}

/// World length of hard edges that show, each weighted by its alpha and by what the pastes above let through.
#[must_use]
pub fn visible_length(lapped: &LappedTexture, lists: &FaceLists, edges: &[Vec<HardEdge>]) -> f64 {
    let shows = |(paste, edges): (usize, &Vec<HardEdge>)| -> f64 {
        let one = |edge: &HardEdge| {
            let above = lists.of(edge.face).iter().filter(|(p, _)| *p as usize > paste);
            let through = edge_steps().map(|t| {
                let mut bary = Vec3::ZERO;
                bary[edge.edge as usize] = 1.0 - t;
                bary[(edge.edge as usize + 1) % 3] = t;
                above
                    .clone()
                    .map(|&(p, slot)| 1.0 - paste_alpha(&lapped.patches, &lapped.pastes[p as usize], slot, bary))
                    .product::<f32>()
            });
            f64::from(edge.weight * through.sum::<f32>() / EDGE_SAMPLES as f32)
        };
        edges.iter().map(one).sum()
    };
    // Sums in index order, so that the last bits do not depend on the number of threads.
    let each: Vec<f64> = edges.par_iter().enumerate().map(shows).collect();
    each.iter().sum()
}

/// Mask pixels of a paste's face.
pub(super) fn mask_pixels(paste: &Paste, slot: u32, mask_size: [u32; 2]) -> [DVec2; 3] {
    let size = DVec2::new(f64::from(mask_size[0]), f64::from(mask_size[1]));
    paste.uv[slot as usize].map(|uv| uv.as_dvec2() * size)
}

/// Removes from each paste the faces that the ones above hide, and with `occluded` off only those that its mask does
/// not reach; then pastes without faces. Returns for each paste kept its old index.
pub fn cull(
    mesh: &Mesh,
    lapped: &mut LappedTexture,
    masks: &[CoverageMask],
    pitch: &(impl Fn(u32) -> f64 + Sync),
    occluded: bool,
) -> Vec<u32> {
    let lists = FaceLists::new(mesh.face_count(), &lapped.pastes);
    let keep_on_face = |face: u32, keep: &mut Vec<bool>| {
        let lattice = Lattice::new(&mesh.corners(face), pitch(face));
        let list = lists.of(face);
        let first = keep.len();
        keep.resize(first + list.len(), false);
        let mut tile = Tile::Bare;
        for (i, &(paste, slot)) in list.iter().enumerate().rev() {
            if !occluded {
                tile = Tile::Bare;
            }
            let paste = &lapped.pastes[paste as usize];
            let pixels = mask_pixels(paste, slot, lapped.patches[paste.patch as usize].mask.size());
            keep[first + i] = tile.cover(&lattice, &masks[paste.patch as usize], pixels);
        }
    };
    let faces: Vec<u32> = (0..mesh.face_count() as u32).collect();
    let kept: Vec<Vec<bool>> = faces
        .par_chunks(CULL_CHUNK)
        .map(|chunk| {
            let mut keep = Vec::new();
            chunk.iter().for_each(|&f| keep_on_face(f, &mut keep));
            keep
        })
        .collect();
    let mut keep_slot: Vec<Vec<bool>> = lapped.pastes.iter().map(|p| vec![false; p.faces.len()]).collect();
    for (&(paste, slot), keep) in lists.entries.iter().zip(kept.into_iter().flatten()) {
        keep_slot[paste as usize][slot as usize] = keep;
    }
    for (paste, keep) in lapped.pastes.iter_mut().zip(&keep_slot) {
        retain(&mut paste.faces, keep);
        retain(&mut paste.uv, keep);
    }
    let left: Vec<u32> = (0..lapped.pastes.len() as u32).filter(|&p| !lapped.pastes[p as usize].faces.is_empty()).collect();
    lapped.pastes.retain(|p| !p.faces.is_empty());
    left
}

/// Faces a task of culling takes: enough to outweigh the task's own cost.
const CULL_CHUNK: usize = 4096;

fn retain<T>(items: &mut Vec<T>, keep: &[bool]) {
    let mut at = keep.iter();
    items.retain(|_| at.next() == Some(&true));
    items.shrink_to_fit();
}
