//! Overlays: pastes laid over hard edges that show.
//!
//! Sorted by their hard edges, pastes hide most of each other's. What still shows lies mostly where patches bend too far or meet
//! themselves, and at the poles of the field, where every paste that follows it must end. A paste laid over such an edge, with its seed
//! on it, often ends elsewhere. It is kept if it ends in fewer hard edges than it hides, and goes to where the order by hard edges puts
//! it.
//!
//! An exemplar that looks the same every way need not follow the field: its overlays take the field's direction at their own seed and
//! are free of it elsewhere, so they lie whole over poles where others are shards. Any other exemplar keeps to the field, at poles too:
//! laid straight over a pole it lies across the field on all sides of it, which is seen much sooner than the edges that it hides.
//!
//! The paper leaves hard edges to future work (section 6).
//!
//! 1. Find how much of each hard edge shows.
//! 2. Draw edges by that, and lay a paste at the middle of each ([`Loop::lay_over`]), one at a place.
//! 3. Again, a few rounds: where one paste was turned down, one beside it may do.

use super::PasteError;
use super::lapped::{FaceLists, Paste};
use super::layout::Loop;
use super::order::{HardEdge, mask_pixels, visible_edges};
use crate::mesh::SurfacePoint;
use crate::progress::Progress;
use crate::random::Random;
use glam::Vec3;

/// Rounds at most. The first lays most of them.
const ROUNDS: usize = 3;

/// The first of the random streams that rounds draw from; the loop of pasting has number 0.
const STREAM: u64 = 1000;

/// Hard edges of a new paste must be less than this share of what it hides.
const WORTH: f64 = 0.6;

/// Edges of which less than this share shows are left alone.
pub(super) const SHOWS: f64 = 0.1;

/// Lays pastes over the hard edges that show of pastes sorted by them, and sorts again. `loose` says of each texture patch whether it
/// need not follow the field. Returns the number of pastes laid.
///
/// # Errors
/// If cancelled.
pub fn lay_over_hard_edges(work: &mut Loop, loose: &[bool], seed: u64, progress: &dyn Progress) -> Result<usize, PasteError> {
    let mesh = work.input().mesh;
    let mut laid = 0;
    for round in 0..ROUNDS {
        let (patches, pastes, edges) = (work.input().patches, work.pastes(), work.edges());
        let lists = FaceLists::new(mesh.face_count(), pastes);
        let shows = visible_edges(mesh, patches, pastes, &lists, edges);
        let mut on_face = vec![0.0; mesh.face_count()];
        let mut random = Random::new(seed, STREAM + round as u64);
        let mut points: Vec<(f64, SurfacePoint)> = Vec::new();
        for (edge, &shows) in edges.iter().flatten().zip(shows.iter().flatten()) {
            on_face[edge.face as usize] += shows;
            if shows > SHOWS * f64::from(edge.weight) {
                // Sorted by this, they stand as if drawn one after the other by how much they show.
                points.push((-(1.0 - random.unit()).ln() / shows, middle(edge.face, edge.edge)));
            }
        }
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let points: Vec<SurfacePoint> = points.into_iter().map(|(_, point)| point).collect();
        let masks = work.input().masks;
        let worth = |_: SurfacePoint, paste: &Paste, edges: &[HardEdge]| {
            let size = patches[paste.patch as usize].mask.size();
            let hides = |(slot, &face): (usize, &u32)| match on_face[face as usize] {
                0.0 => 0.0,
                shows => {
                    let [a, b, c] = mask_pixels(paste, slot as u32, size);
                    shows * f64::from(masks[paste.patch as usize].alpha(((a + b + c) / 3.0).as_vec2()))
                }
            };
            let hidden: f64 = paste.faces.iter().enumerate().map(hides).sum();
            edges.iter().map(|e| f64::from(e.weight)).sum::<f64>() < WORTH * hidden
        };
        let new = work.lay_over(&points, &(0..patches.len()), &|_, patch| loose[patch], &worth, progress)?;
        laid += new;
        work.sort_by_hard_edges();
        if new == 0 {
            break;
        }
    }
    Ok(laid)
}

/// The middle of a face's edge.
pub(super) fn middle(face: u32, edge: u8) -> SurfacePoint {
    let mut bary = Vec3::splat(0.5);
    bary[(usize::from(edge) + 2) % 3] = 0.0;
    SurfacePoint { face, bary }
}
