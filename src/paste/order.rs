//! Ordering pastes so that hard edges hide, and removing what cannot be seen.
//!
//! Coverage does not depend on the order of pastes: what shows through a point is the product of what each lets through.
//! So once everything is covered the pastes may be sorted, those with the most hard edges to the bottom, where later
//! ones lie over them. Then, from the top down, each face keeps the pastes of which anything can be seen (LT 4).

use super::composite::paste_alpha;
use super::coverage::{FACES_A_TASK, Lattice, Tile};
use super::lapped::{FaceLists, LappedTexture, Paste};
use super::stencil::Stencil;
use crate::exemplar::{CoverageMask, TexturePatch};
use crate::mesh::{Mesh, SurfacePoint};
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

/// The hard edges of all pastes by face.
#[derive(Debug)]
pub(super) struct EdgesByFace {
    /// Face, paste and edge of each, in that order.
    all: Vec<(u32, u32, u8)>,
    /// Where those of each face begin, up to the last that has one, and one more.
    start: Vec<u32>,
}

impl EdgesByFace {
    pub(super) fn new(edges: &[Vec<HardEdge>]) -> Self {
        let of_paste = |(k, edges): (usize, &Vec<HardEdge>)| edges.iter().map(|e| (e.face, k as u32, e.edge)).collect::<Vec<_>>();
        let mut all: Vec<_> = edges.iter().enumerate().flat_map(of_paste).collect();
        all.par_sort_unstable();
        let mut start = Vec::with_capacity(all.last().map_or(0, |e| e.0 as usize + 2));
        for (place, &(face, ..)) in all.iter().enumerate() {
            start.resize(start.len().max(face as usize + 1), place as u32);
        }
        start.push(all.len() as u32);
        Self { all, start }
    }

    /// Face, paste and edge of those on a face.
    pub(super) fn on(&self, face: u32) -> &[(u32, u32, u8)] {
        match self.start.get(face as usize..) {
            Some([from, to, ..]) => &self.all[*from as usize..*to as usize],
            _ => &[],
        }
    }
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
            let alpha = edge_alpha(mask, &pixels[slot], edge);
            let p = mesh.corners(faces[slot]);
            let length = p[edge].distance(p[(edge + 1) % 3]) as f32;
            (alpha > FAINT).then_some(HardEdge { face: faces[slot], edge: edge as u8, weight: length * alpha })
        })
        .collect()
}

/// Mean alpha of a mask along an edge of a face, from this corner to the next; `pixels` are those of its corners.
pub(super) fn edge_alpha(mask: &CoverageMask, pixels: &[DVec2; 3], edge: usize) -> f32 {
    let (a, b) = (pixels[edge], pixels[(edge + 1) % 3]);
    edge_steps().map(|t| mask.alpha(a.lerp(b, f64::from(t)).as_vec2())).sum::<f32>() / EDGE_SAMPLES as f32
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

/// For each paste and hard edge: the world length that shows, weighted by the alpha that its paste has there and by what the pastes
/// above let through.
#[must_use]
pub fn visible_edges(
    mesh: &Mesh,
    patches: &[TexturePatch],
    pastes: &[Paste],
    lists: &FaceLists,
    edges: &[Vec<HardEdge>],
) -> Vec<Vec<f64>> {
    let shows = |(paste, edges): (usize, &Vec<HardEdge>)| {
        edges.iter().map(|e| visible_edge(mesh, patches, pastes, lists.of(e.face), (e.face, paste as u32, e.edge))).collect()
    };
    edges.par_iter().enumerate().map(shows).collect()
}

/// The same for one hard edge: its face, its paste and the face's edge. `list` names the pastes on the face and their places there, from
/// the bottom up.
pub(super) fn visible_edge(
    mesh: &Mesh,
    patches: &[TexturePatch],
    pastes: &[Paste],
    list: &[(u32, u32)],
    (face, paste, edge): (u32, u32, u8),
) -> f64 {
    along(mesh, (face, edge), |bary| shown_alpha(patches, pastes, list, paste, bary, |_| true))
}

/// The length of one hard edge, weighted alike, that shows without the paste `over` and does not with it.
pub(super) fn uncovered_edge(
    mesh: &Mesh,
    patches: &[TexturePatch],
    pastes: &[Paste],
    list: &[(u32, u32)],
    (face, paste, edge): (u32, u32, u8),
    over: u32,
) -> f64 {
    let Some(&(_, slot)) = list.iter().find(|e| e.0 == over) else { return 0.0 };
    along(mesh, (face, edge), |bary| match paste_alpha(patches, &pastes[over as usize], slot, bary) {
        hides if hides > 0.0 => hides * shown_alpha(patches, pastes, list, paste, bary, |p| p != over),
        _ => 0.0,
    })
}

/// Alpha of a paste at a point times what those above that `count` let through.
fn shown_alpha(
    patches: &[TexturePatch],
    pastes: &[Paste],
    list: &[(u32, u32)],
    paste: u32,
    bary: Vec3,
    count: impl Fn(u32) -> bool,
) -> f32 {
    let mut shown = 1.0;
    // From the top: what lies there mostly hides all, and the rest need not be asked.
    for &(number, slot) in list.iter().rev().take_while(|e| e.0 >= paste).filter(|e| count(e.0)) {
        let alpha = paste_alpha(patches, &pastes[number as usize], slot, bary);
        if number == paste {
            return shown * alpha;
        }
        shown *= 1.0 - alpha;
        if shown <= 0.0 {
            break;
        }
    }
    // A paste may have lost the face, where nothing of it shows.
    0.0
}

/// World length of a face's edge times the mean along it.
fn along(mesh: &Mesh, (face, edge): (u32, u8), value: impl Fn(Vec3) -> f32) -> f64 {
    let (a, b) = (usize::from(edge), (usize::from(edge) + 1) % 3);
    let at = |t| {
        let mut bary = Vec3::ZERO;
        (bary[a], bary[b]) = (1.0 - t, t);
        value(bary)
    };
    let p = mesh.corners(face);
    p[a].distance(p[b]) * f64::from(edge_steps().map(at).sum::<f32>() / EDGE_SAMPLES as f32)
}

/// Share of a hard edge that must show before it counts.
const SHOWN: f64 = 0.1;

/// The hard edges of each paste that show.
#[must_use]
pub fn shown_edges(mesh: &Mesh, lapped: &LappedTexture, lists: &FaceLists, edges: &[Vec<HardEdge>]) -> Vec<Vec<HardEdge>> {
    let shows = visible_edges(mesh, &lapped.patches, &lapped.pastes, lists, edges);
    let of_paste = |(edges, shows): (&Vec<HardEdge>, &Vec<f64>)| {
        edges.iter().zip(shows).filter(|(edge, shows)| **shows > SHOWN * f64::from(edge.weight)).map(|(edge, _)| *edge).collect()
    };
    edges.iter().zip(&shows).map(of_paste).collect()
}

/// These items in this order.
pub(super) fn permute<T>(items: Vec<T>, order: &[u32]) -> Vec<T> {
    let mut items: Vec<Option<T>> = items.into_iter().map(Some).collect();
    order.iter().filter_map(|&i| items[i as usize].take()).collect()
}

/// Mask pixels of a paste's face.
pub(super) fn mask_pixels(paste: &Paste, slot: u32, mask_size: [u32; 2]) -> [DVec2; 3] {
    let size = DVec2::new(f64::from(mask_size[0]), f64::from(mask_size[1]));
    paste.uv[slot as usize].map(|uv| uv.as_dvec2() * size)
}

/// What can be seen of each paste, and what cannot although it should.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Seen {
    /// For each paste, whether anything of each of its faces can be seen.
    faces: Vec<Vec<bool>>,
    /// Samples of coverage that the pastes on their face do not cover together, on faces with a cut.
    pub holes: Vec<SurfacePoint>,
}

impl Seen {
    /// Nothing has been looked at yet.
    #[must_use]
    pub fn new(pastes: &[Paste]) -> Self {
        Self { faces: pastes.iter().map(|p| vec![false; p.faces.len()]).collect(), holes: Vec::new() }
    }

    /// Looks at faces from the top down, again if that was done before. With `occluded` off pastes hide nothing, and only faces that a
    /// paste does not reach are not seen.
    #[allow(clippy::too_many_arguments, reason = "the surface, what lies on it, and how it is looked at")]
    pub fn look(
        &mut self,
        mesh: &Mesh,
        lapped: &LappedTexture,
        lists: &FaceLists,
        masks: &[CoverageMask],
        pitch: &(impl Fn(u32) -> f64 + Sync),
        occluded: bool,
        faces: &[u32],
    ) {
        let lay = |tile: &mut Tile, lattice: &Lattice, (paste, slot): (u32, u32)| {
            let paste = &lapped.pastes[paste as usize];
            let pixels = mask_pixels(paste, slot, lapped.patches[paste.patch as usize].mask.size());
            tile.cover(lattice, &Stencil::new(&masks[paste.patch as usize], paste.cut.as_deref()), pixels)
        };
        let on_face = |face: u32, keep: &mut Vec<bool>, holes: &mut Vec<SurfacePoint>| {
            let lattice = Lattice::new(&mesh.corners(face), pitch(face));
            let list = lists.of(face);
            let first = keep.len();
            keep.resize(first + list.len(), false);
            let mut tile = Tile::Bare;
            for (i, &entry) in list.iter().enumerate().rev() {
                let seen = lay(&mut tile, &lattice, entry);
                keep[first + i] = if occluded { seen } else { lay(&mut Tile::Bare, &lattice, entry) };
            }
            if list.iter().any(|e| lapped.pastes[e.0 as usize].cut.is_some()) {
                let mut open = |sample| holes.push(SurfacePoint { face, bary: lattice.point(sample) });
                match &tile {
                    Tile::Opaque => (),
                    Tile::Partial(samples) => (0..samples.len()).filter(|&k| samples[k] > 0).for_each(open),
                    Tile::Bare => (0..lattice.cells()).for_each(&mut open),
                }
            }
        };
        let parts: Vec<(Vec<bool>, Vec<SurfacePoint>)> = faces
            .par_chunks(FACES_A_TASK)
            .map(|chunk| {
                let (mut keep, mut holes) = (Vec::new(), Vec::new());
                chunk.iter().for_each(|&f| on_face(f, &mut keep, &mut holes));
                (keep, holes)
            })
            .collect();
        let entries = faces.iter().flat_map(|&face| lists.of(face));
        for (&(paste, slot), &keep) in entries.zip(parts.iter().flat_map(|(keep, _)| keep)) {
            self.faces[paste as usize][slot as usize] = keep;
        }
        self.holes = parts.into_iter().flat_map(|(_, holes)| holes).collect();
    }
}

/// Removes what nobody can see: faces of pastes, then pastes without faces. Returns for each paste kept its old index.
pub fn cull(lapped: &mut LappedTexture, seen: &Seen) -> Vec<u32> {
    for (paste, keep) in lapped.pastes.iter_mut().zip(&seen.faces) {
        retain(&mut paste.faces, keep);
        retain(&mut paste.uv, keep);
    }
    let left: Vec<u32> = (0..lapped.pastes.len() as u32).filter(|&p| !lapped.pastes[p as usize].faces.is_empty()).collect();
    lapped.pastes.retain(|p| !p.faces.is_empty());
    left
}

fn retain<T>(items: &mut Vec<T>, keep: &[bool]) {
    let mut at = keep.iter();
    items.retain(|_| at.next() == Some(&true));
    items.shrink_to_fit();
}
