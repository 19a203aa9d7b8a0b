//! Directions for faces that have none of their own, taken from their neighbours.
//!
//! 1. Ring by ring outward from the faces that have one: the mean of the known neighbours' directions, each carried over
//!    the common edge by parallel transport.
//! 2. Relaxation: every filled face takes the mean of all its neighbours, so that the lines where two fronts met even out.
//!
//! Both steps take each ring or sweep from the state before it, so that the order of faces does not show.

use crate::mesh::transport::{across, projected};
use crate::mesh::{Mesh, NONE};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Relaxation sweeps over the filled faces. A sweep spreads news by one face; regions wider than this keep the fronts'
/// directions in their middle, which are smooth but for the lines where fronts met.
const SWEEPS: usize = 32;

/// Sweeps end when no direction changes by more than this, radians.
const SETTLED: f32 = 1e-3;

/// A mean of unit directions shorter than this has no direction: the neighbours cancel.
const CANCELLED: f64 = 1e-6;

/// Gives every face with `directions` zero a unit direction in its plane and returns how many there were. A component
/// without any direction gets one at its largest face first, from whichever of `axes` lies flattest to that face.
pub fn fill(mesh: &Mesh, directions: &mut [Vec3], axes: [DVec3; 3]) -> usize {
    let missing: Vec<u32> = (0..mesh.face_count() as u32).filter(|&f| directions[f as usize] == Vec3::ZERO).collect();
    if missing.is_empty() {
        return 0;
    }
    seed_bare_components(mesh, directions, axes);
    let mut ring: Vec<u32> = missing.iter().copied().filter(|&f| has_known_neighbour(mesh, directions, f)).collect();
    let mut queued = vec![false; mesh.face_count()];
    while !ring.is_empty() {
        let found: Vec<Vec3> = ring.par_iter().map(|&f| from_neighbours(mesh, directions, f)).collect();
        for (&f, direction) in ring.iter().zip(found) {
            if directions[f as usize] == Vec3::ZERO {
                directions[f as usize] = direction;
            }
        }
        let mut next_ring = Vec::new();
        for &f in &ring {
            for g in (0..3).map(|k| mesh.neighbour(f, k)) {
                if g != NONE && directions[g as usize] == Vec3::ZERO && !queued[g as usize] {
                    queued[g as usize] = true;
                    next_ring.push(g);
                }
            }
        }
        ring = next_ring;
    }
    for _ in 0..SWEEPS {
        let relaxed: Vec<Vec3> = missing.par_iter().map(|&f| from_neighbours(mesh, directions, f)).collect();
        let mut change = 0.0_f32;
        for (&f, direction) in missing.iter().zip(relaxed) {
            change = change.max(direction.distance(directions[f as usize]));
            directions[f as usize] = direction;
        }
        if change < SETTLED {
            break;
        }
    }
    missing.len()
}

fn has_known_neighbour(mesh: &Mesh, directions: &[Vec3], face: u32) -> bool {
    (0..3).map(|k| mesh.neighbour(face, k)).any(|g| g != NONE && directions[g as usize] != Vec3::ZERO)
}

/// Mean direction of the neighbours that have one; where they cancel, the face's own, or else the first neighbour's.
fn from_neighbours(mesh: &Mesh, directions: &[Vec3], face: u32) -> Vec3 {
    let (mut sum, mut first) = (DVec3::ZERO, DVec3::ZERO);
    for h in 3 * face..3 * face + 3 {
        let o = mesh.opposite[h as usize];
        if o == NONE || directions[(o / 3) as usize] == Vec3::ZERO {
            continue;
        }
        if let Some(carried) = across(mesh, o, directions[(o / 3) as usize].as_dvec3()) {
            sum += carried;
            first = if first == DVec3::ZERO { carried } else { first };
        }
    }
    let own = directions[face as usize];
    if sum.length() > CANCELLED {
        sum.normalize().as_vec3()
    } else if own != Vec3::ZERO {
        own
    } else {
        first.normalize_or_zero().as_vec3()
    }
}

/// One direction in every component that has none.
fn seed_bare_components(mesh: &Mesh, directions: &mut [Vec3], axes: [DVec3; 3]) {
    let (component, count) = mesh.components();
    let mut known = vec![false; count];
    let mut largest = vec![(0.0, NONE); count];
    for f in 0..mesh.face_count() as u32 {
        let c = component[f as usize] as usize;
        known[c] |= directions[f as usize] != Vec3::ZERO;
        if largest[c].1 == NONE || mesh.area(f) > largest[c].0 {
            largest[c] = (mesh.area(f), f);
        }
    }
    for (_, face) in largest.into_iter().zip(known).filter_map(|(at, known)| (!known).then_some(at)) {
        let normal = mesh.normal(face);
        let flattest = axes
            .into_iter()
            .map(|a| projected(a, normal))
            .fold(DVec3::ZERO, |best, at| if at.length() > best.length() + 1e-3 { at } else { best });
        directions[face as usize] = flattest.normalize_or_zero().as_vec3();
    }
}
