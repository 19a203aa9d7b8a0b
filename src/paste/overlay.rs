//! Overlays: pastes laid over hard edges that show.
//!
//! Sorted by their hard edges, pastes hide most of each other's. What still shows lies mostly at the poles of the field, where every
//! paste that follows it must end. An exemplar that looks the same every way need not follow it: a paste laid over the pole that takes
//! the field's direction at its own seed and is free of it elsewhere is whole where others are shards. It is kept if it ends in fewer
//! hard edges than it hides, and goes to where the order by hard edges puts it.
//!
//! An exemplar with a direction keeps to the field, whose poles nothing that follows it can pass. So it too is laid straight over them,
//! but over nothing else: whoever steered it asked for that. The paper leaves hard edges to future work (section 6).
//!
//! 1. Find how much of each hard edge shows.
//! 2. Draw edges by that, and lay a paste at the middle of each ([`Loop::lay_over`]), one at a place.
//! 3. Again, a few rounds: where one paste was turned down, one beside it may do.

use super::PasteError;
use super::lapped::{FaceLists, Paste};
use super::layout::Loop;
use super::order::{HardEdge, mask_pixels, visible_edges};
use crate::field::{Guide, turning_points};
use crate::mesh::geodesic::Geodesic;
use crate::mesh::{Mesh, NONE, SurfacePoint};
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

/// Pastes that follow the field elsewhere are laid straight over hard edges no further than this from a pole, in exemplar widths: so
/// that it lies well inside them.
const POLE: f64 = 0.25;

/// Lays pastes over the hard edges that show of pastes sorted by them, and sorts again. `loose` says of each texture patch whether it
/// need not follow the field; others are laid over its poles alone. Returns how many were laid.
///
/// # Errors
/// If cancelled.
pub fn lay_over_hard_edges(work: &mut Loop, loose: &[bool], seed: u64, progress: &dyn Progress) -> Result<usize, PasteError> {
    let mesh = work.input().mesh;
    // Where every patch is loose poles do not matter.
    let polar = if loose.contains(&false) { near_poles(mesh, work.input().guide) } else { vec![true; mesh.face_count()] };
    if !loose.contains(&true) && !polar.contains(&true) {
        return Ok(0);
    }
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
            if shows > SHOWS * f64::from(edge.weight) && (polar[edge.face as usize] || loose.contains(&true)) {
                // Sorted by this, they stand as if drawn one after the other by how much they show.
                points.push((-(1.0 - random.unit()).ln() / shows, middle(edge.face, edge.edge)));
            }
        }
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let points: Vec<SurfacePoint> = points.into_iter().map(|(_, point)| point).collect();
        let masks = work.input().masks;
        let worth = |seed: SurfacePoint, paste: &Paste, edges: &[HardEdge]| {
            if !loose[paste.patch as usize] && !polar[seed.face as usize] {
                return false;
            }
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
        let new = work.lay_over(&points, &(0..patches.len()), &|_, _| true, &worth, progress)?;
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

/// By face, whether a pole of the field is near.
pub(super) fn near_poles(mesh: &Mesh, guide: &Guide) -> Vec<bool> {
    let mut near = vec![false; mesh.face_count()];
    let Some(field) = guide.field() else { return near };
    let first = mesh.vertex_half_edges();
    let at = |vertex: u32| {
        let corner = first[vertex as usize];
        (corner != NONE).then(|| {
            let mut bary = Vec3::ZERO;
            bary[corner as usize % 3] = 1.0;
            SurfacePoint { face: corner / 3, bary }
        })
    };
    let poles: Vec<SurfacePoint> = turning_points(mesh, field).into_iter().filter_map(|p| at(p.place)).collect();
    let reach = |face: u32| POLE * f64::from(guide.scale(face));
    let widest = (0..mesh.face_count() as u32).map(reach).fold(0.0, f64::max);
    let mut geodesic = Geodesic::new(mesh);
    geodesic.search(&poles, widest);
    geodesic.for_each_reached_face(|face| near[face as usize] = geodesic.face(face) <= reach(face));
    near
}
