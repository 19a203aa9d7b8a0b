//! Keeping the new mesh near the original, both ways.
//!
//! 1. Points of the original (its vertices, and places along its sharp edges) that lie farther from the new mesh than a share of an
//!    edge fell between the new vertices, like the tip of a spike. The face nearest to each is cut in three there.
//! 2. Faces of the new mesh whose middle, or the middle of whose side, lies that far from the original lead across a gap, as
//!    from one finger to the next. They are cut where the original is nearest.
//!
//! The farthest one comes first, and no two at neighbouring faces. These vertices stay fixed; repulsion goes on after that and takes out
//! as many others where they crowd.

use super::flips::flip_from;
use super::remove::{Scratch, shape, sides};
use super::surgery::Fan;
use super::{Role, Tiling};
use crate::mesh::nearest::{Hit, Nearest};
use crate::mesh::walk::at_origin;
use crate::mesh::{Mesh, NONE, SurfacePoint, next, prev};
use glam::DVec3;
use rayon::prelude::*;

/// Share of an edge beyond which a point is too far. Half an edge is what the result promises; samples see nearly all of it.
const TOO_FAR: f64 = 0.42;

/// An edge of the original that bends by more than 25 degrees (the cosine) is sampled along itself, with this many samples to a new edge:
/// new faces cut its corner.
const SHARP: f64 = 0.906;
const ALONG: f64 = 3.0;

/// A new face is looked at if the original at one of its corners looks another way by more than 30 degrees (the cosine): others lie
/// flat on it.
const BESIDE: f64 = 0.866;

/// A face that a new vertex makes may look away from those it replaces by no more than this (cosine), and must have this much
/// shape (1 if equilateral).
const LEAST_TURN: f64 = 0.0;
const LEAST_SHAPE: f64 = 0.06;

/// A flip must bring a face to this share of its distance.
const BETTER: f64 = 0.8;

/// What makes sure that the new mesh stays near the original.
pub(super) struct Reach<'m> {
    tree: Nearest<'m>,
    samples: Vec<SurfacePoint>,
}

/// A place where the surfaces are too far apart.
struct Gap {
    distance: f64,
    /// Decides between equal distances.
    number: u32,
    /// The new face to be cut, by itself or with one beside it.
    face: u32,
    /// Where the new vertex goes.
    at: SurfacePoint,
}

impl<'m> Reach<'m> {
    /// Prepares for new edges of a length.
    pub(super) fn new(original: &'m Mesh, edge: f64) -> Self {
        let vertices = original.vertex_half_edges().into_iter().filter(|&h| h != NONE).map(at_origin);
        let mut samples: Vec<SurfacePoint> = vertices.collect();
        for h in 0..original.opposite.len() as u32 {
            let o = original.opposite[h as usize];
            if o == NONE || o < h || original.normal(h / 3).dot(original.normal(o / 3)) > SHARP {
                continue;
            }
            let length = original.point(original.origin(h)).distance(original.point(original.origin(next(h))));
            let pieces = (length / edge * ALONG).ceil() as u32;
            for i in 1..pieces {
                let mut bary = DVec3::ZERO;
                bary[(h % 3) as usize] = 1.0 - f64::from(i) / f64::from(pieces);
                bary[(next(h) % 3) as usize] = f64::from(i) / f64::from(pieces);
                samples.push(SurfacePoint { face: h / 3, bary: bary.as_vec3() });
            }
        }
        Self { tree: Nearest::new(original), samples }
    }

    /// Puts at most `room` vertices where the surfaces lie too far apart. Returns how many places were mended, and the largest
    /// distance found before.
    pub(super) fn put_back(&self, t: &mut Tiling, room: usize, scratch: &mut Scratch) -> (usize, f64) {
        t.compact(None);
        let mesh = t.surgery.mesh();
        let too_far = TOO_FAR * t.edge;
        let mut gaps = self.missed(t, &mesh);
        gaps.par_extend((0..mesh.face_count() as u32).into_par_iter().filter_map(|f| self.astray(t, &mesh, f)));
        let farthest = gaps.iter().map(|g| g.distance).fold(0.0, f64::max);
        gaps.retain(|g| room > 0 && g.distance > too_far);
        gaps.sort_by(|a, b| b.distance.total_cmp(&a.distance).then(a.number.cmp(&b.number)));
        let mut taken = vec![false; mesh.face_count()];
        let (mut put, mut new) = (0, 0);
        for gap in gaps {
            if new >= room {
                break;
            }
            let around = sides(gap.face).into_iter().map(|h| t.surgery.opposite[h as usize]);
            if taken[gap.face as usize] || around.filter(|&o| o != NONE).any(|o| taken[(o / 3) as usize]) {
                continue;
            }
            if gap.number >= self.samples.len() as u32 && self.flip(t, &gap, &mut scratch.fan) {
                let beside = sides(gap.face).map(|h| t.surgery.opposite[h as usize]).into_iter().filter(|&o| o != NONE);
                beside.for_each(|o| taken[(o / 3) as usize] = true);
                taken[gap.face as usize] = true;
                put += 1;
                continue;
            }
            let point = t.original.position(gap.at);
            let m = match best_change(t, gap.face, point, &mut scratch.fan) {
                None => continue,
                Some(Change::CutFace) => t.surgery.split_face(gap.face, point),
                Some(Change::CutSide(h)) => t.surgery.split_edge(h, point),
                Some(Change::Move(v)) => v,
            };
            if m as usize == t.at.len() {
                new += 1;
                t.at.push(gap.at);
                t.role.push(Role::Fixed);
            } else {
                t.surgery.positions[m as usize] = point;
                t.at[m as usize] = gap.at;
                t.role[m as usize] = Role::Fixed;
            }
            t.surgery.fan(m, &mut scratch.fan);
            scratch.queue.clear();
            scratch.fan.spokes.iter().for_each(|&spoke| scratch.queue.push(next(spoke)));
            flip_from(&mut t.surgery, &mut scratch.queue, &mut scratch.fan);
            t.surgery.fan(m, &mut scratch.fan);
            taken.resize(t.surgery.faces.len(), true);
            scratch.fan.spokes.iter().for_each(|&spoke| taken[(spoke / 3) as usize] = true);
            put += 1;
        }
        (put, farthest)
    }

    /// Flips a side of a face that leads across a gap, if what takes its place lies nearer to the original and looks as it does.
    fn flip(&self, t: &mut Tiling, gap: &Gap, fan: &mut Fan) -> bool {
        let s = &t.surgery;
        let mut best = (BETTER * gap.distance, None);
        for h in sides(gap.face) {
            let Some([c, d]) = s.diagonal(h).filter(|_| !s.feature[h as usize]) else { continue };
            if s.are_joined(c, d, fan) {
                continue;
            }
            let [a, b, c, d] = [s.origin(h), s.target(h), c, d].map(|v| s.positions[v as usize]);
            let mut worst = self.tree.nearest((c + d) / 2.0).map_or(f64::INFINITY, |hit| hit.distance);
            for corners in [[a, d, c], [b, c, d]] {
                let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
                let hit = self.tree.nearest((corners[0] + corners[1] + corners[2]) / 3.0);
                let sound = |hit: &Hit| t.original.normal(hit.at.face).dot(normal) > 0.0;
                let sound = hit.filter(|hit| shape(corners[0], corners[1], corners[2]) > LEAST_SHAPE && sound(hit));
                worst = worst.max(sound.map_or(f64::INFINITY, |hit| hit.distance));
            }
            if worst < best.0 {
                best = (worst, Some(h));
            }
        }
        let Some(h) = best.1 else { return false };
        t.surgery.flip(h);
        true
    }

    /// Points of the original and the new faces nearest to them, none that lies on them.
    fn missed(&self, t: &Tiling, mesh: &Mesh) -> Vec<Gap> {
        let tree = Nearest::new(mesh);
        let one = |(i, &at): (usize, &SurfacePoint)| {
            let hit = tree.nearest(t.original.position(at))?;
            Some(Gap { distance: hit.distance, number: i as u32, face: hit.at.face, at })
        };
        self.samples.par_iter().enumerate().filter_map(one).collect()
    }

    /// Where a new face lies farthest from the original.
    fn astray(&self, t: &Tiling, mesh: &Mesh, face: u32) -> Option<Gap> {
        let normal = mesh.normal(face);
        let beside = |v: u32| t.original.normal(t.at[v as usize].face).dot(normal) < BESIDE;
        if !mesh.faces[face as usize].into_iter().any(beside) {
            return None;
        }
        let p = mesh.corners(face);
        let number = self.samples.len() as u32 + face;
        let at = |point: DVec3| self.tree.nearest(point).map(|hit| Gap { distance: hit.distance, number, face, at: hit.at });
        let sides = (0..3).map(|k| at((p[k] + p[(k + 1) % 3]) / 2.0));
        std::iter::once(at((p[0] + p[1] + p[2]) / 3.0))
            .chain(sides)
            .flatten()
            .reduce(|best, gap| if gap.distance > best.distance { gap } else { best })
    }
}

/// How a face takes in a vertex.
enum Change {
    /// Cut in three.
    CutFace,
    /// Its side, a half-edge, is cut in two, and with it the face beyond.
    CutSide(u32),
    /// Its corner, a vertex, comes to the place.
    Move(u32),
}

/// The change whose worst face is best; `None` if each turns a face over or makes one without width.
fn best_change(t: &Tiling, face: u32, point: DVec3, fan: &mut Fan) -> Option<Change> {
    let s = &t.surgery;
    // The worst of the faces between `point` and some half-edges; each must look where the face of its half-edge does.
    let worst = |rim: &mut dyn Iterator<Item = u32>| {
        let of = |h: u32| {
            let (a, b) = (s.positions[s.origin(h) as usize], s.positions[s.target(h) as usize]);
            let (old, new) = (s.area_vector(h / 3), (a - point).cross(b - point));
            if new.dot(old) > LEAST_TURN * new.length() * old.length() { shape(point, a, b) } else { 0.0 }
        };
        rim.map(of).fold(1.0, f64::min)
    };
    let mut best = (LEAST_SHAPE, None);
    let mut consider = |quality: f64, change: Change| {
        if quality > best.0 {
            best = (quality, Some(change));
        }
    };
    consider(worst(&mut sides(face).into_iter()), Change::CutFace);
    for h in sides(face) {
        let o = s.opposite[h as usize];
        if o != NONE && !s.feature[h as usize] {
            consider(worst(&mut [next(h), prev(h), next(o), prev(o)].into_iter()), Change::CutSide(h));
        }
        let v = s.origin(h);
        s.fan(v, fan);
        if t.role[v as usize] == Role::Free && fan.closed {
            consider(worst(&mut fan.spokes.iter().map(|&spoke| next(spoke))), Change::Move(v));
        }
    }
    best.1
}
