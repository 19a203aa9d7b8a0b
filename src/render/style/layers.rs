//! The pastes over a surface point, top first.

use crate::mesh::{Mesh, SurfacePoint};
use crate::paste::{FaceLists, LappedTexture};
use glam::Vec2;

/// Below this a paste does not count as there.
const FAINT: f32 = 1.0 / 255.0;

/// Looks up which pastes lie over surface points.
pub(super) struct Layers<'a> {
    mesh: &'a Mesh,
    lapped: &'a LappedTexture,
    pub(super) lists: FaceLists,
}

/// One paste over a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Layer {
    /// Its number in paint order.
    pub(super) paste: u32,
    /// Place in the face's list.
    pub(super) entry: usize,
    /// Its opacity at the point.
    pub(super) alpha: f32,
}

impl<'a> Layers<'a> {
    pub(super) fn new(mesh: &'a Mesh, lapped: &'a LappedTexture) -> Self {
        Self { mesh, lapped, lists: FaceLists::new(mesh.face_count(), &lapped.pastes) }
    }

    /// The pastes that are not transparent at a point, top first.
    pub(super) fn at(&self, point: SurfacePoint, footprint: f32) -> impl Iterator<Item = Layer> + '_ {
        let first = self.lists.start[point.face as usize] as usize;
        let area = self.mesh.area(point.face);
        self.lists.of(point.face).iter().enumerate().rev().filter_map(move |(i, &(paste, slot))| {
            let corners = self.corners(paste, slot)?;
            let mask = &self.lapped.patches[self.lapped.pastes[paste as usize].patch as usize].mask;
            let at = corners[0] * point.bary.x + corners[1] * point.bary.y + corners[2] * point.bary.z;
            // Mask pixels per sample: from the ratio of the face's areas.
            let pixels = 0.5 * (corners[1] - corners[0]).perp_dot(corners[2] - corners[0]).abs();
            let lod = (f64::from(footprint) * (f64::from(pixels) / area).sqrt()).max(1.0).log2();
            let alpha = mask.sample(at, lod as f32).x;
            (alpha > FAINT).then_some(Layer { paste, entry: first + i, alpha })
        })
    }

    /// Corners of a face under a paste, pixels of the patch's mask; `None` if the record is inconsistent.
    pub(super) fn corners(&self, paste: u32, slot: u32) -> Option<[Vec2; 3]> {
        let paste = self.lapped.pastes.get(paste as usize)?;
        let [w, h] = self.lapped.patches.get(paste.patch as usize)?.mask.size();
        paste.uv.get(slot as usize).map(|uv| uv.map(|p| p * Vec2::new(w as f32, h as f32)))
    }

    /// The topmost paste that hides most of what is below it.
    pub(super) fn top(&self, point: SurfacePoint, footprint: f32) -> Option<Layer> {
        self.at(point, footprint).find(|layer| layer.alpha >= 0.5)
    }
}
