//! A second look at coverage, by nothing but what was written down: points of the surface and the alpha of the pastes.
//!
//! The loop's cells promise that every point is opaque. The audit takes the alpha that is shown, bilinear in the masks
//! (rounded down to 8 bits) under the recorded coordinates, at every texel of the surface, and names the points where it
//! falls short. A face, or a run of texels, whose image lies wholly inside the opaque part of one paste's mask has no such
//! point and is not looked at more closely.

use super::coverage::{FACES_A_TASK, Image, Lattice};
use super::lapped::{FaceLists, Paste};
use super::order::mask_pixels;
use crate::exemplar::{CoverageMask, TexturePatch};
use crate::mesh::{Mesh, SurfacePoint};
use glam::DVec2;
use rayon::prelude::*;

/// Composite alpha below this is a hole an eye could find.
pub const LEAST_ALPHA: f32 = 0.98;

/// Alpha that counts as opaque, as in the coverage masks.
const OPAQUE: f32 = 254.0 / 255.0;

/// What an audit found.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Audit {
    /// Points looked at.
    pub samples: u64,
    /// The least composite alpha among them.
    pub least_alpha: f32,
    /// The worst point of each face with one below [`LEAST_ALPHA`].
    pub holes: Vec<SurfacePoint>,
}

/// Looks at every texel: cells of `pitch` world units on each face. `masks` belong to the patches.
#[must_use]
pub fn audit(
    mesh: &Mesh,
    patches: &[TexturePatch],
    masks: &[CoverageMask],
    pastes: &[Paste],
    pitch: &(impl Fn(u32) -> f64 + Sync),
) -> Audit {
    let lists = FaceLists::new(mesh.face_count(), pastes);
    let opaque = |&(paste, slot): &(u32, u32)| {
        let paste = &pastes[paste as usize];
        let pixel = mask_pixels(paste, slot, patches[paste.patch as usize].mask.size());
        let middle = (pixel[0] + pixel[1] + pixel[2]) / 3.0;
        let radius = pixel.iter().map(|p| p.distance(middle)).fold(0.0, f64::max);
        masks[paste.patch as usize].depth(middle.as_vec2()) >= radius as f32
    };
    let faces: Vec<u32> = (0..mesh.face_count() as u32).collect();
    let parts: Vec<Audit> = faces
        .par_chunks(FACES_A_TASK)
        .map(|chunk| {
            let mut part = Audit { least_alpha: 1.0, ..Audit::default() };
            for &face in chunk {
                let list = lists.of(face);
                let lattice = Lattice::new(&mesh.corners(face), pitch(face));
                if list.iter().any(opaque) {
                    part.samples += lattice.cells() as u64;
                    part.least_alpha = part.least_alpha.min(OPAQUE);
                    continue;
                }
                let layer = |&entry: &(u32, u32)| Layer::new(&lattice, patches, masks, pastes, entry);
                let layers: Vec<Layer> = list.iter().rev().map(layer).collect();
                part.look(face, &lattice, &layers);
            }
            part
        })
        .collect();
    parts.into_iter().fold(Audit { least_alpha: 1.0, ..Audit::default() }, |mut all, part| {
        all.samples += part.samples;
        all.least_alpha = all.least_alpha.min(part.least_alpha);
        all.holes.extend(part.holes);
        all
    })
}

/// Texels of a row that are tried together against a mask's depth before they are looked at one by one.
const RUN: u32 = 16;

/// A paste on a face.
struct Layer<'a> {
    mask: &'a CoverageMask,
    image: Image,
}

impl<'a> Layer<'a> {
    fn new(
        lattice: &Lattice,
        patches: &[TexturePatch],
        masks: &'a [CoverageMask],
        pastes: &[Paste],
        (paste, slot): (u32, u32),
    ) -> Self {
        let paste = &pastes[paste as usize];
        let corners = mask_pixels(paste, slot, patches[paste.patch as usize].mask.size());
        Self { mask: &masks[paste.patch as usize], image: Image::new(lattice, corners) }
    }

    /// True if the layer is opaque at all points of a rectangle on the lattice.
    fn hides(&self, middle: DVec2, half: DVec2) -> bool {
        self.mask.depth(self.image.at(middle)) >= self.image.radius(half)
    }

    fn alpha(&self, at: DVec2) -> f32 {
        self.mask.alpha(self.image.at(at))
    }
}

impl Audit {
    /// Looks at all samples of a face.
    fn look(&mut self, face: u32, lattice: &Lattice, layers: &[Layer]) {
        let (mut least, mut worst) = (f32::INFINITY, DVec2::ZERO);
        lattice.for_each_run(RUN, |run| {
            self.samples += u64::from(run.cells());
            if layers.iter().any(|layer| layer.hides(run.middle(), run.half())) {
                least = least.min(OPAQUE);
                return;
            }
            for at in run.samples() {
                let mut clear = 1.0;
                for layer in layers {
                    clear *= 1.0 - layer.alpha(at);
                    if clear < 1.0 - OPAQUE {
                        break;
                    }
                }
                if 1.0 - clear < least {
                    (least, worst) = (1.0 - clear, at);
                }
            }
        });
        self.least_alpha = self.least_alpha.min(least);
        if least < LEAST_ALPHA {
            self.holes.push(SurfacePoint { face, bary: lattice.bary(worst) });
        }
    }
}
