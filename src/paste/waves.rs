//! Which pastes are worked on at once: in an order that says what is known when each has its turn, those that share no face are independent.

use super::lapped::{FaceLists, Paste};

/// Faces of one paste that are not worth sharing out any further: where a wave has fewer pastes than there are processors, their faces are.
pub(super) const LEAST_FACES: usize = 8;

/// Pastes in the order in which they are met from one of them, over shared faces; so for each part of the surface.
pub(super) fn outwards(lists: &FaceLists, pastes: &[Paste]) -> Vec<u32> {
    let mut met = vec![false; pastes.len()];
    let mut order: Vec<u32> = Vec::with_capacity(pastes.len());
    let mut looked = vec![false; lists.start.len()];
    for first in 0..pastes.len() {
        if std::mem::replace(&mut met[first], true) {
            continue;
        }
        let mut next = order.len();
        order.push(first as u32);
        while let Some(&k) = order.get(next) {
            next += 1;
            for &face in &pastes[k as usize].faces {
                if std::mem::replace(&mut looked[face as usize], true) {
                    continue;
                }
                let others = lists.of(face).iter().map(|&(paste, _)| paste);
                order.extend(others.filter(|&p| !std::mem::replace(&mut met[p as usize], true)));
            }
        }
    }
    order
}

/// Pastes in waves: each shares no face with one of its own wave, and those before it in the order that share one with it are
/// in earlier waves.
pub(super) fn waves(face_count: usize, pastes: &[Paste], order: &[u32]) -> Vec<Vec<u32>> {
    let mut reached = vec![0_usize; face_count];
    let mut waves: Vec<Vec<u32>> = Vec::new();
    for &k in order {
        let faces = &pastes[k as usize].faces;
        let wave = faces.iter().map(|&f| reached[f as usize]).max().unwrap_or(0);
        faces.iter().for_each(|&f| reached[f as usize] = wave + 1);
        if wave == waves.len() {
            waves.push(Vec::new());
        }
        waves[wave].push(k);
    }
    waves
}
