//! Growing a disc of faces around a seed and laying it flat: one idea for pasting, charts and neighbourhoods.
//!
//! Based on: Praun, Finkelstein, Hoppe 2000, section 3.3.
//!
//! 1. Start with one face.
//! 2. Take the nearest open edge of the disc from a heap. The face beyond may join if the disc stays a disc: it shares
//!    one edge and brings a new vertex, or it shares two. (One edge and an old vertex would close a ring; three would
//!    close a sphere.) That keeps the Euler characteristic at 1 with a single boundary loop.
//! 3. The [`Rule`] says how far an edge is, or that growth ends there, and where the corners of a face lie in the plane,
//!    or that the face must stay out.
//!
//! A face that was refused is tried again when another of its edges becomes open, because its place may then differ.

use super::{Mesh, NONE, next, prev};
use glam::DVec2;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// A disc of faces with a position in the plane for each of its vertices.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Disc {
    /// Faces of the mesh in the order of joining; the first is the seed.
    pub faces: Vec<u32>,
    /// For each face its corners as indices into `vertices` and `uv`, in the face's own order.
    pub corners: Vec<[u32; 3]>,
    /// Vertices of the mesh.
    pub vertices: Vec<u32>,
    /// Where each vertex lies in the plane.
    pub uv: Vec<DVec2>,
}

impl Disc {
    /// Plane positions of a face's corners; `index` counts the disc's faces.
    #[inline]
    #[must_use]
    pub fn face_uv(&self, index: usize) -> [DVec2; 3] {
        self.corners[index].map(|v| self.uv[v as usize])
    }
}

/// A face about to join.
#[derive(Debug, Clone, Copy)]
pub struct Joining {
    /// The face of the mesh.
    pub face: u32,
    /// Which of its corners is not in the disc yet; `None` if all are.
    pub new_corner: Option<usize>,
    /// Its corners as indices into the disc's vertices; the new corner's is the index it would get.
    pub corners: [u32; 3],
    /// For each edge `k` of the face, the disc face across as an index into `Disc::faces`, or [`NONE`].
    pub across: [u32; 3],
}

/// What the grower asks.
pub trait Rule {
    /// How far the edge from disc vertex `a` to `b` (indices into `Disc::vertices`) is from the centre, or `None` if
    /// growth need not cross it.
    fn distance(&mut self, disc: &Disc, a: u32, b: u32) -> Option<f64>;

    /// Where the face's new vertex lies in the plane (ignored if there is none), or `None` if the face must stay out.
    /// Called again for the same face if more of its edges become open.
    fn admit(&mut self, grower: &Grower, joining: &Joining) -> Option<DVec2>;

    /// The face was taken in; it is now the last of the disc.
    fn joined(&mut self, _disc: &Disc, _joining: &Joining) {}
}

/// Marks of the faces and vertices in the disc at hand; reusable, so that growing costs only what it touches.
#[derive(Debug, Clone, Default)]
pub struct Scratch {
    epoch: u32,
    face: Vec<Mark>,
    vertex: Vec<Mark>,
}

#[derive(Debug, Clone, Copy, Default)]
struct Mark {
    epoch: u32,
    index: u32,
}

impl Scratch {
    /// Room for discs on a mesh.
    #[must_use]
    pub fn new(mesh: &Mesh) -> Self {
        Self { epoch: 0, face: vec![Mark::default(); mesh.face_count()], vertex: vec![Mark::default(); mesh.vertex_count()] }
    }

    fn begin(&mut self) {
        if self.epoch == u32::MAX {
            self.face.fill(Mark::default());
            self.vertex.fill(Mark::default());
            self.epoch = 0;
        }
        self.epoch += 1;
    }

    fn find(marks: &[Mark], epoch: u32, at: u32) -> u32 {
        let mark = marks[at as usize];
        if mark.epoch == epoch { mark.index } else { NONE }
    }
}

/// A disc that grows.
#[derive(Debug)]
pub struct Grower<'a> {
    mesh: &'a Mesh,
    scratch: &'a mut Scratch,
    disc: Disc,
    heap: BinaryHeap<Reverse<(Distance, u32)>>,
}

/// A finite distance with a total order.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Distance(f64);

impl Eq for Distance {}

impl Ord for Distance {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

impl PartialOrd for Distance {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl<'a> Grower<'a> {
    /// A disc of one face whose corners lie at `uv`. `scratch` must have been made for the same mesh.
    #[must_use]
    pub fn new(mesh: &'a Mesh, scratch: &'a mut Scratch, seed: u32, uv: [DVec2; 3]) -> Self {
        scratch.begin();
        let corners = mesh.faces[seed as usize];
        let disc = Disc { faces: vec![seed], corners: vec![[0, 1, 2]], vertices: corners.to_vec(), uv: uv.to_vec() };
        scratch.face[seed as usize] = Mark { epoch: scratch.epoch, index: 0 };
        for (index, &v) in corners.iter().enumerate() {
            scratch.vertex[v as usize] = Mark { epoch: scratch.epoch, index: index as u32 };
        }
        Self { mesh, scratch, disc, heap: BinaryHeap::new() }
    }

    /// The disc so far.
    #[must_use]
    pub const fn disc(&self) -> &Disc {
        &self.disc
    }

    /// The positions in the plane, to move between two rounds of growth.
    pub fn uv_mut(&mut self) -> &mut [DVec2] {
        &mut self.disc.uv
    }

    /// Hands the disc out.
    #[must_use]
    pub fn into_disc(self) -> Disc {
        self.disc
    }

    /// The index of a face of the mesh among the disc's, or [`NONE`].
    #[inline]
    #[must_use]
    pub fn index_of(&self, face: u32) -> u32 {
        Scratch::find(&self.scratch.face, self.scratch.epoch, face)
    }

    /// The index of a vertex of the mesh among the disc's, or [`NONE`].
    #[inline]
    #[must_use]
    pub fn vertex_index(&self, vertex: u32) -> u32 {
        Scratch::find(&self.scratch.vertex, self.scratch.epoch, vertex)
    }

    /// Grows until no open edge is left that the rule would cross. May be called again after `uv_mut`. Returns how many
    /// faces joined.
    pub fn grow(&mut self, rule: &mut impl Rule) -> usize {
        self.heap.clear();
        for index in 0..self.disc.faces.len() {
            self.open_edges(index, rule);
        }
        let before = self.disc.faces.len();
        while let Some(Reverse((_, h))) = self.heap.pop() {
            let beyond = self.mesh.opposite[h as usize];
            if self.index_of(beyond / 3) == NONE {
                self.try_join(beyond / 3, rule);
            }
        }
        self.disc.faces.len() - before
    }

    /// Half-edges of disc faces with a mesh face beyond that is not in the disc, as (index of the disc face, edge of it).
    pub fn open_border(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.disc.faces.iter().enumerate().flat_map(move |(index, &face)| {
            (0..3).filter_map(move |k| {
                let beyond = self.mesh.neighbour(face, k);
                (beyond != NONE && self.index_of(beyond) == NONE).then_some((index, k as usize))
            })
        })
    }

    /// How the face beyond an open edge would join, or `None` if the disc would then end to be one.
    #[must_use]
    pub fn joining_over(&self, index: usize, edge: usize) -> Option<Joining> {
        match self.mesh.neighbour(self.disc.faces[index], edge as u32) {
            NONE => None,
            beyond => self.joining(beyond),
        }
    }

    fn open_edges(&mut self, index: usize, rule: &mut impl Rule) {
        let (face, corners) = (self.disc.faces[index], self.disc.corners[index]);
        for k in 0..3 {
            let h = 3 * face + k;
            let beyond = self.mesh.opposite[h as usize];
            if beyond == NONE || self.index_of(beyond / 3) != NONE {
                continue;
            }
            if let Some(d) = rule.distance(&self.disc, corners[k as usize], corners[(k as usize + 1) % 3]) {
                self.heap.push(Reverse((Distance(d), h)));
            }
        }
    }

    /// How a face would join, or `None` if the disc would end to be one.
    fn joining(&self, face: u32) -> Option<Joining> {
        let across = [0, 1, 2].map(|k| match self.mesh.neighbour(face, k) {
            NONE => NONE,
            beyond => self.index_of(beyond),
        });
        let mut corners = self.mesh.faces[face as usize].map(|v| self.vertex_index(v));
        let new_corner = match across.iter().filter(|&&a| a != NONE).count() {
            1 => {
                let edge = across.iter().position(|&a| a != NONE)?;
                let corner = prev(edge as u32) as usize;
                if corners[corner] != NONE {
                    return None;
                }
                corners[corner] = self.disc.vertices.len() as u32;
                Some(corner)
            }
            2 => None,
            _ => return None,
        };
        Some(Joining { face, new_corner, corners, across })
    }

    fn try_join(&mut self, face: u32, rule: &mut impl Rule) {
        let Some(joining) = self.joining(face) else { return };
        let Some(uv) = rule.admit(self, &joining) else { return };
        let epoch = self.scratch.epoch;
        if let Some(corner) = joining.new_corner {
            let v = self.mesh.faces[face as usize][corner];
            self.scratch.vertex[v as usize] = Mark { epoch, index: self.disc.vertices.len() as u32 };
            self.disc.vertices.push(v);
            self.disc.uv.push(uv);
        }
        let index = self.disc.faces.len();
        self.scratch.face[face as usize] = Mark { epoch, index: index as u32 };
        self.disc.faces.push(face);
        self.disc.corners.push(joining.corners);
        rule.joined(&self.disc, &joining);
        self.open_edges(index, rule);
    }
}

/// Tests that faces form a disc: connected, Euler characteristic 1, one boundary loop; for tests and checks.
///
/// # Errors
/// A sentence saying what they form instead.
pub fn check_disc(mesh: &Mesh, faces: &[u32]) -> Result<(), String> {
    let mut sorted = faces.to_vec();
    sorted.sort_unstable();
    let inside = |f: u32| f != NONE && sorted.binary_search(&f).is_ok();
    if sorted.windows(2).any(|w| w[0] == w[1]) {
        return Err("a face occurs twice".into());
    }
    let mut vertices: Vec<u32> = sorted.iter().flat_map(|&f| mesh.faces[f as usize]).collect();
    vertices.sort_unstable();
    vertices.dedup();
    let border: Vec<u32> =
        sorted.iter().flat_map(|&f| 3 * f..3 * f + 3).filter(|&h| !inside(mesh.neighbour(h / 3, h % 3))).collect();
    let edges = (3 * sorted.len() - border.len()) / 2 + border.len();
    let euler = vertices.len() as i64 - edges as i64 + sorted.len() as i64;
    if euler != 1 {
        return Err(format!("Euler characteristic {euler} instead of 1"));
    }
    // Walk the boundary from any of its half-edges; a disc's is a single loop.
    let Some(&start) = border.first() else { return Err("no boundary".into()) };
    let (mut h, mut walked) = (start, 0);
    loop {
        walked += 1;
        h = next(h);
        while inside(mesh.neighbour(h / 3, h % 3)) {
            h = next(mesh.opposite[h as usize]);
        }
        if h == start {
            break;
        }
        if walked > border.len() {
            return Err("the boundary walk does not close".into());
        }
    }
    if walked != border.len() {
        return Err(format!("a boundary loop of {walked} of {} edges: several loops", border.len()));
    }
    Ok(())
}
