//! Pruning: pastes that the others make needless are left out.
//!
//! Pastes are laid where nothing lies yet, one after the other; later ones often finish what an earlier one was laid for, and what is
//! left of that is a sliver with borders on all sides. The paper keeps them all.
//!
//! 1. Find the area that shows of each paste.
//! 2. From the least up, a paste is left out if all samples of coverage on its faces stay opaque without it, not more faces are drawn
//!    there in all, and no more hard edges show. Pastes that share no face are looked at in parallel.
//! 3. Pastes that the audit asked for are kept: it looks closer than the samples.

use super::coverage::{FACES_A_TASK, Lattice, Tile};
use super::lapped::{FaceLists, Paste};
use super::layout::{Layout, LayoutInput};
use super::order::{EdgesByFace, HardEdge, mask_pixels, permute, uncovered_edge, visible_edge};
use super::stencil::Stencil;
use super::waves::waves;
use rayon::prelude::*;
use std::ops::Range;

/// Faces whose hard edges are looked at before it is asked whether too many show already.
const AT_A_TIME: usize = 16 * FACES_A_TASK;

/// Leaves out what is needless of pastes in paint order, but for those whose place in the order in which they were laid is among
/// `kept`. Returns how many were left out.
pub fn prune(input: &LayoutInput, layout: &mut Layout, kept: Range<u32>) -> usize {
    let count = layout.pastes.len();
    let pruner = Pruner {
        input,
        pastes: &layout.pastes,
        edges: &layout.edges,
        lists: FaceLists::new(input.mesh.face_count(), &layout.pastes),
        by_face: EdgesByFace::new(&layout.edges),
    };
    let shows = pruner.shown_area();
    let mut order: Vec<u32> = (0..count as u32).filter(|&k| !kept.contains(&layout.seedings[k as usize].laid)).collect();
    order.sort_by(|&a, &b| shows[a as usize].total_cmp(&shows[b as usize]));
    let mut gone = vec![false; count];
    for wave in waves(input.mesh.face_count(), &layout.pastes, &order) {
        let needless: Vec<bool> = wave.par_iter().map(|&k| pruner.needless(k, &gone)).collect();
        wave.iter().zip(needless).for_each(|(&k, needless)| gone[k as usize] = needless);
    }
    let left: Vec<u32> = (0..count as u32).filter(|&k| !gone[k as usize]).collect();
    let Layout { pastes, seedings, edges, .. } = layout;
    *pastes = permute(std::mem::take(pastes), &left);
    *seedings = permute(std::mem::take(seedings), &left);
    *edges = permute(std::mem::take(edges), &left);
    count - left.len()
}

struct Pruner<'a> {
    input: &'a LayoutInput<'a>,
    pastes: &'a [Paste],
    edges: &'a [Vec<HardEdge>],
    lists: FaceLists,
    by_face: EdgesByFace,
}

impl Pruner<'_> {
    fn lattice(&self, face: u32) -> Lattice {
        Lattice::new(&self.input.mesh.corners(face), f64::from(self.input.pitch[face as usize]))
    }

    /// Lays pastes on a face from the top down until it is opaque; `seen` hears of each whether anything of it shows. Returns whether
    /// the face is opaque.
    fn look(&self, face: u32, list: impl Iterator<Item = (u32, u32)>, mut seen: impl FnMut(u32, bool, &Tile)) -> bool {
        let lattice = self.lattice(face);
        let mut tile = Tile::Bare;
        for (number, slot) in list {
            let paste = &self.pastes[number as usize];
            let mask = &self.input.masks[paste.patch as usize];
            let pixels = mask_pixels(paste, slot, self.input.patches[paste.patch as usize].mask.size());
            let shows = tile.cover(&lattice, &Stencil::new(mask, None), pixels);
            seen(number, shows, &tile);
            if tile == Tile::Opaque {
                return true;
            }
        }
        false
    }

    /// The area that shows of each paste.
    fn shown_area(&self) -> Vec<f64> {
        let faces: Vec<u32> = (0..self.input.mesh.face_count() as u32).collect();
        let of_face = |&face: &u32, shown: &mut Vec<(u32, f64)>| {
            let cells = self.lattice(face).cells();
            let part = self.input.mesh.area(face) / cells as f64;
            let mut open = cells;
            self.look(face, self.lists.of(face).iter().rev().copied(), |number, shows, tile| {
                let left = tile.uncovered(|| cells);
                if shows {
                    shown.push((number, (open - left) as f64 * part));
                }
                open = left;
            });
        };
        let parts: Vec<Vec<(u32, f64)>> = faces
            .par_chunks(FACES_A_TASK)
            .map(|chunk| {
                let mut shown = Vec::new();
                chunk.iter().for_each(|face| of_face(face, &mut shown));
                shown
            })
            .collect();
        let mut sums = vec![0.0; self.pastes.len()];
        parts.into_iter().flatten().for_each(|(number, area)| sums[number as usize] += area);
        sums
    }

    /// True if a paste may be left out as those that are gone already were. Where pastes are large few share a wave, so their faces are
    /// looked at in parallel.
    fn needless(&self, k: u32, gone: &[bool]) -> bool {
        let faces = &self.pastes[k as usize].faces;
        let with = |face: u32| self.lists.of(face).iter().copied().filter(|e| !gone[e.0 as usize]);
        // How many pastes are drawn on some faces, if these are opaque.
        let drawn = |faces: &[u32], counts: &(dyn Fn(u32) -> bool + Sync)| {
            let mut drawn = 0_i64;
            let mut list: Vec<(u32, u32)> = Vec::new();
            let opaque = faces.iter().all(|&face| {
                list.clear();
                list.extend(with(face).filter(|e| counts(e.0)));
                self.look(face, list.iter().rev().copied(), |_, shows, _| drawn += i64::from(shows))
            });
            opaque.then_some(drawn)
        };
        let tasks = || faces.par_chunks(FACES_A_TASK);
        let without = tasks().map(|faces| drawn(faces, &|paste| paste != k)).try_reduce(|| 0, |a, b| Some(a + b));
        let Some(without) = without else { return false };
        // Opaque without it, they are with it.
        let before: i64 = tasks().filter_map(|faces| drawn(faces, &|_| true)).sum();
        without <= before && self.uncovers_no_more_than(self.own_edges(k, &with), k, &with)
    }

    /// Length of a paste's own hard edges that shows.
    fn own_edges<L: Iterator<Item = (u32, u32)>>(&self, k: u32, with: &(impl Fn(u32) -> L + Sync)) -> f64 {
        let LayoutInput { mesh, patches, .. } = *self.input;
        let shows = |e: &HardEdge| visible_edge(mesh, patches, self.pastes, &with(e.face).collect::<Vec<_>>(), (e.face, k, e.edge));
        let lengths: Vec<f64> = self.edges[k as usize].par_iter().with_min_len(FACES_A_TASK).map(shows).collect();
        lengths.into_iter().sum()
    }

    /// True if no more than that length of other pastes' hard edges shows without a paste and does not with it.
    fn uncovers_no_more_than<L: Iterator<Item = (u32, u32)>>(&self, most: f64, k: u32, with: &(impl Fn(u32) -> L + Sync)) -> bool {
        let on_face = |&face: &u32| -> Vec<f64> {
            let edges = self.by_face.on(face);
            let below = &edges[..edges.partition_point(|e| e.1 < k)];
            if below.is_empty() {
                return Vec::new();
            }
            let list: Vec<(u32, u32)> = with(face).collect();
            let LayoutInput { mesh, patches, .. } = *self.input;
            below.iter().map(|&edge| uncovered_edge(mesh, patches, self.pastes, &list, edge, k)).collect()
        };
        let mut sum = 0.0;
        // A few tasks at a time: mostly the first faces tell.
        self.pastes[k as usize].faces.chunks(AT_A_TIME).all(|faces| {
            let lengths: Vec<Vec<f64>> = faces.par_iter().with_min_len(FACES_A_TASK).map(on_face).collect();
            sum += lengths.iter().flatten().sum::<f64>();
            sum <= most
        })
    }
}
