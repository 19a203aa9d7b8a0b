//! What hard edges cost a border: its own paste's beyond it, and those of others that it uncovers.

use super::super::cut::{CUT_STEPS, Cut};
use super::super::order::HardEdge;
use super::{COVERED, Comparison, GRID, Matcher, Plan, RINGS, distance};
use glam::{Vec2, Vec3};

/// Where something has less alpha than this it shows, and hides, nothing.
const FAINT: f32 = 0.02;

/// A place on a hard edge.
struct Sample {
    bary: Vec3,
    /// On the paste whose border is chosen, over its mask.
    at: Vec2,
    /// Length, in steps from way to way at the mask's edge: as paths are measured.
    length: f32,
}

/// Places along an edge of a face whose corners lie there over the mask.
fn samples(edge: u8, uv: [Vec2; 3]) -> impl Iterator<Item = Sample> {
    let (from, to) = (usize::from(edge), (usize::from(edge) + 1) % 3);
    let length = uv[from].distance(uv[to]);
    let steps = (length * GRID as f32).ceil().max(1.0);
    (0..steps as u32).map(move |step| {
        let t = (step as f32 + 0.5) / steps;
        let mut bary = Vec3::ZERO;
        (bary[from], bary[to]) = (1.0 - t, t);
        Sample { bary, at: uv[from].lerp(uv[to], t), length: length / steps * CUT_STEPS as f32 / 4.0 }
    })
}

impl Matcher<'_> {
    /// Lets the borders of a paste pay for the hard edges that they let show.
    pub(super) fn add_hard_edges(&self, k: u32, plan: &Plan, cuts: &[Option<Box<Cut>>], compared: &mut Comparison) {
        let mut below = Vec::new();
        for edge in &self.shown[k as usize] {
            self.leave(k, edge, plan, cuts, compared, &mut below);
        }
        let paste = &self.lapped.pastes[k as usize];
        for (&face, &uv) in paste.faces.iter().zip(&paste.uv) {
            for &(_, other, edge) in self.hidden.on(face).iter().filter(|e| e.1 < k) {
                self.uncover(k, (face, uv), (other, edge), plan, cuts, compared, &mut below);
            }
        }
    }

    /// A hard edge of the paste itself shows under borders that lie outside of it. Where nothing lies below it shows under all.
    fn leave(
        &self,
        k: u32,
        edge: &HardEdge,
        plan: &Plan,
        cuts: &[Option<Box<Cut>>],
        compared: &mut Comparison,
        below: &mut Vec<f32>,
    ) {
        let list = self.lists.of(edge.face);
        let own = list.partition_point(|&(paste, _)| paste < k);
        let Some(&entry) = list.get(own).filter(|entry| entry.0 == k) else { return };
        for Sample { bary, at, length } in samples(edge.edge, self.lapped.pastes[k as usize].uv[entry.1 as usize]) {
            let alpha = self.alpha(entry, bary, cuts);
            if alpha < FAINT {
                continue;
            }
            let [covered, least] = self.below(&list[..own], bary, cuts, below);
            if least < COVERED {
                continue;
            }
            let weight = self.seen(list, own, bary) * alpha * length;
            let error = self.difference(entry, bary, covered, below);
            let (way, out) = Cut::place(at);
            let inside = (0..RINGS).take_while(|&ring| distance(ring) + 0.5 * plan.soft <= out).count();
            // A way that is not cut leaves it whole.
            compared.add(way, inside.min(plan.uncut(way))..RINGS, weight, error);
        }
    }

    /// A hard edge of a paste below shows under borders that lie inside of it.
    #[allow(clippy::too_many_arguments, reason = "two pastes, a face, and what was found so far")]
    fn uncover(
        &self,
        k: u32,
        (face, uv): (u32, [Vec2; 3]),
        (other, edge): (u32, u8),
        plan: &Plan,
        cuts: &[Option<Box<Cut>>],
        compared: &mut Comparison,
        below: &mut Vec<f32>,
    ) {
        let list = self.lists.of(face);
        let [its, own] = [other, k].map(|k| list.partition_point(|&(paste, _)| paste < k));
        for Sample { bary, at, length } in samples(edge, uv) {
            // From the top: mostly something hides it all, and the rest need not be asked.
            let mut shows = 1.0;
            for (place, &entry) in list.iter().enumerate().take(own + 1).skip(its).rev() {
                let alpha = self.alpha(entry, bary, cuts);
                shows *= if place == own || place == its { alpha } else { 1.0 - alpha };
                if shows < FAINT {
                    break;
                }
            }
            if shows < FAINT {
                continue;
            }
            let covered = self.below(&list[..its], bary, cuts, below)[0];
            // What lies on its other side is what lies below it, if anything does.
            let error = if covered < 0.5 {
                let (one, another) = (self.shown(other, list[its].1, bary), self.shown(k, list[own].1, bary));
                one.iter().zip(another).map(|(a, b)| (a - b) * (a - b)).sum()
            } else {
                self.difference(list[its], bary, covered, below)
            };
            let (way, out) = Cut::place(at);
            let inside = (0..RINGS).take_while(|&ring| distance(ring) - 0.5 * plan.soft < out).count();
            compared.add(way, 0..inside.min(plan.uncut(way)), self.seen(list, own, bary) * shows * length, error);
        }
    }

    /// Alpha of a paste, cut as it is so far, at a point of its face.
    fn alpha(&self, (number, slot): (u32, u32), bary: Vec3, cuts: &[Option<Box<Cut>>]) -> f32 {
        let paste = &self.lapped.pastes[number as usize];
        let mask = &self.masks[paste.patch as usize];
        let [a, b, c] = paste.uv[slot as usize];
        let uv = a * bary.x + b * bary.y + c * bary.z;
        let pixel = uv * Vec2::from(mask.size().map(|s| s as f32));
        mask.alpha(pixel) * cuts[number as usize].as_deref().map_or(1.0, |cut| cut.alpha(uv, 0.0))
    }
}

impl Plan {
    /// The first ring of a way that stands for the mask's own border.
    fn uncut(&self, way: usize) -> usize {
        self.end[way].saturating_sub(1)
    }
}

impl Comparison {
    /// Lets borders at these rings of a way pay for a squared difference.
    fn add(&mut self, way: usize, rings: std::ops::Range<usize>, weight: f32, error: f32) {
        if self.hard.is_empty() {
            self.hard = vec![[[0.0; 2]; RINGS]; CUT_STEPS];
        }
        for ring in &mut self.hard[way][rings] {
            *ring = [ring[0] + weight * error, ring[1] + weight];
        }
    }
}
