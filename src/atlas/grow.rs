//! Charts grown face by face, the paper's way, and laid flat with as little distortion as may be.
//!
//! Based on: Praun, Finkelstein, Hoppe 2000, section 4 (charts are grown like patches) and section 3.4; the flattening is the
//! rotation refit of [`crate::paste::fit`] (Liu et al. 2008).
//!
//! 1. From the largest face that is left, a disc ([`crate::mesh::disc`]) grows over the faces nearest to it, as long as their
//!    normals stay within a cone about the seed's and no face comes to lie on another one when all are looked at along the
//!    cone's axis: a spatial hash says so.
//! 2. A chart of a few faces is given to the neighbour with the longest common border into which it fits by the same two rules.
//! 3. Each chart is fitted, which evens out its distortion. A fit that turns a face over is dropped for the view along the axis,
//!    which turns none.

use super::AtlasError;
use super::charts::FlatCharts;
use crate::mesh::disc::{Disc, Grower, Joining, Rule, Scratch};
use crate::mesh::{Mesh, NONE};
use crate::paste::fit::{FitProblem, Fitter, IsotropicFit, Weights};
use crate::paste::frame::Frame;
use crate::progress::Progress;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::collections::HashMap;

/// How charts grow.
#[derive(Debug, Clone, PartialEq)]
pub struct GrowOptions {
    /// Half the opening of the cone of normals, radians. Wider cones make fewer charts with more stretch.
    pub cone: f64,
}

impl Default for GrowOptions {
    fn default() -> Self {
        Self { cone: 60_f64.to_radians() }
    }
}

/// Charts of at most so many faces are given to a neighbour if one takes them.
const SMALL: usize = 12;

/// A neighbour takes faces that lie this much further off its axis than its own, radians.
const TOLERANT: f64 = 15.0 * std::f64::consts::PI / 180.0;

/// Rounds of the fit; each turns every face's target to what it has.
const ROUNDS: u32 = 8;

/// Free space between charts in the plane, as a share of the largest chart's size.
const APART: f64 = 0.01;

/// Cuts a mesh into charts.
///
/// # Errors
/// If `progress` cancels.
pub fn grow(mesh: &Mesh, options: &GrowOptions, progress: &dyn Progress) -> Result<FlatCharts, AtlasError> {
    let faces = mesh.face_count();
    progress.stage("growing charts", faces as u64);
    let mut order: Vec<u32> = (0..faces as u32).collect();
    order.sort_by(|&a, &b| mesh.area(b).total_cmp(&mesh.area(a)).then(a.cmp(&b)));
    let mut chart = vec![NONE; faces];
    let mut charts: Vec<Chart> = Vec::new();
    let mut scratch = Scratch::new(mesh);
    let mut done = 0;
    for seed in order {
        if chart[seed as usize] != NONE {
            continue;
        }
        if progress.cancelled() {
            return Err(AtlasError::Cancelled);
        }
        let grown = Chart::grow(mesh, &chart, &mut scratch, seed, options.cone);
        grown.faces.iter().for_each(|&f| chart[f as usize] = charts.len() as u32);
        done += grown.faces.len();
        progress.done(done as u64);
        charts.push(grown);
    }
    give_away_small(mesh, &mut chart, &mut charts, options.cone + TOLERANT);
    progress.stage("laying charts flat", 0);
    let flat: Vec<Disc> = charts.par_iter().filter(|c| !c.faces.is_empty()).map(|c| c.flatten(mesh)).collect();
    Ok(side_by_side(mesh, flat))
}

/// A set of faces looked at along an axis.
struct Chart {
    faces: Vec<u32>,
    view: View,
    laid: Laid,
}

/// A parallel view: two axes across its direction.
#[derive(Clone, Copy)]
struct View {
    axis: DVec3,
    right: DVec3,
    up: DVec3,
}

impl View {
    fn new(axis: DVec3) -> Self {
        let right = axis.any_orthonormal_vector();
        Self { axis, right, up: axis.cross(right) }
    }

    fn place(&self, p: DVec3) -> DVec2 {
        DVec2::new(p.dot(self.right), p.dot(self.up))
    }

    fn face(&self, mesh: &Mesh, face: u32) -> [DVec2; 3] {
        mesh.corners(face).map(|p| self.place(p))
    }
}

/// Faces laid in a plane, found by place.
struct Laid {
    cell: f64,
    cells: HashMap<[i64; 2], Vec<u32>>,
}

impl Laid {
    fn new(cell: f64) -> Self {
        Self { cell: if cell > 0.0 { cell } else { 1.0 }, cells: HashMap::new() }
    }

    /// The cells that a triangle's box touches.
    fn reach(&self, t: &[DVec2; 3]) -> impl Iterator<Item = [i64; 2]> + use<> {
        let low = (t[0].min(t[1]).min(t[2]) / self.cell).floor();
        let high = (t[0].max(t[1]).max(t[2]) / self.cell).floor();
        let rows = low.y as i64..=high.y as i64;
        let (x0, x1) = (low.x as i64, high.x as i64);
        rows.flat_map(move |y| (x0..=x1).map(move |x| [x, y]))
    }

    fn insert(&mut self, face: u32, t: &[DVec2; 3]) {
        for cell in self.reach(t) {
            self.cells.entry(cell).or_default().push(face);
        }
    }

    /// True if a triangle lies on one that is laid already, more than by touching it.
    fn meets(&self, t: &[DVec2; 3], place: impl Fn(u32) -> [DVec2; 3]) -> bool {
        self.reach(t).any(|cell| self.cells.get(&cell).is_some_and(|faces| faces.iter().any(|&f| overlap(t, &place(f)))))
    }
}

/// True if two counter-clockwise triangles share more than their borders: no edge of either has all of the other on its right.
fn overlap(a: &[DVec2; 3], b: &[DVec2; 3]) -> bool {
    let parted = |a: &[DVec2; 3], b: &[DVec2; 3]| {
        (0..3).any(|k| {
            let (p, edge) = (a[k], a[(k + 1) % 3] - a[k]);
            // A rounding error beyond the edge is still on it.
            let slack = 1e-9 * edge.length_squared();
            b.iter().all(|q| edge.perp_dot(*q - p) <= slack)
        })
    };
    !parted(a, b) && !parted(b, a)
}

/// The rules by which a chart grows.
struct Cone<'a> {
    mesh: &'a Mesh,
    taken: &'a [u32],
    view: View,
    least_cosine: f64,
    centre: DVec2,
    laid: Laid,
}

impl Rule for Cone<'_> {
    fn distance(&mut self, disc: &Disc, a: u32, b: u32) -> Option<f64> {
        Some(((disc.uv[a as usize] + disc.uv[b as usize]) * 0.5).distance(self.centre))
    }

    fn admit(&mut self, _grower: &Grower<'_>, joining: &Joining) -> Option<DVec2> {
        let face = joining.face;
        let fits = self.taken[face as usize] == NONE && self.mesh.normal(face).dot(self.view.axis) > self.least_cosine;
        if !fits {
            return None;
        }
        let place = self.view.face(self.mesh, face);
        let free = !self.laid.meets(&place, |f| self.view.face(self.mesh, f));
        free.then(|| joining.new_corner.map_or(DVec2::ZERO, |k| place[k]))
    }

    fn joined(&mut self, _disc: &Disc, joining: &Joining) {
        self.laid.insert(joining.face, &self.view.face(self.mesh, joining.face));
    }
}

impl Chart {
    fn grow(mesh: &Mesh, taken: &[u32], scratch: &mut Scratch, seed: u32, cone: f64) -> Self {
        let view = View::new(mesh.normal(seed));
        let place = view.face(mesh, seed);
        let width = (mesh.area(seed) * 2.0).sqrt();
        let mut rule = Cone {
            mesh,
            taken,
            view,
            least_cosine: cone.cos(),
            centre: (place[0] + place[1] + place[2]) / 3.0,
            laid: Laid::new(width),
        };
        rule.laid.insert(seed, &place);
        let mut grower = Grower::new(mesh, scratch, seed, place);
        grower.grow(&mut rule);
        Self { faces: grower.into_disc().faces, view, laid: rule.laid }
    }

    /// Takes in faces that lie within a cone about the axis and on none of the chart's; false if any does not.
    fn take(&mut self, mesh: &Mesh, faces: &[u32], cone: f64) -> bool {
        let view = self.view;
        let fits = faces.iter().all(|&f| {
            mesh.normal(f).dot(view.axis) > cone.cos() && !self.laid.meets(&view.face(mesh, f), |other| view.face(mesh, other))
        });
        // The faces came from one chart: looked at from here they might lie on each other.
        let apart = faces
            .iter()
            .enumerate()
            .all(|(k, &f)| faces[k + 1..].iter().all(|&g| !overlap(&view.face(mesh, f), &view.face(mesh, g))));
        if fits && apart {
            for &f in faces {
                self.laid.insert(f, &view.face(mesh, f));
            }
            self.faces.extend(faces);
        }
        fits && apart
    }

    /// The chart's faces with their places in the plane.
    fn flatten(&self, mesh: &Mesh) -> Disc {
        let mut vertices: Vec<u32> = Vec::new();
        let mut index: HashMap<u32, u32> = HashMap::new();
        let corners = self
            .faces
            .iter()
            .map(|&f| {
                mesh.faces[f as usize].map(|v| {
                    *index.entry(v).or_insert_with(|| {
                        vertices.push(v);
                        vertices.len() as u32 - 1
                    })
                })
            })
            .collect();
        let seen: Vec<DVec2> = vertices.iter().map(|&v| self.view.place(mesh.point(v))).collect();
        let mut disc = Disc { faces: self.faces.clone(), corners, vertices, uv: seen.clone() };
        let frame = |&f: &u32| {
            let normal = mesh.normal(f);
            let up = (self.view.up - normal * self.view.up.dot(normal)).try_normalize()?;
            Frame::from_up(up, normal)
        };
        let frames: Option<Vec<Frame>> = self.faces.iter().map(frame).collect();
        if let Some(frames) = frames.filter(|_| self.faces.len() > 1) {
            let isotropic = Some(IsotropicFit::Rotations(ROUNDS));
            let problem = FitProblem { mesh, disc: &disc, frames: &frames, weights: Weights::Area, isotropic };
            let mut fitter = Fitter::new(&problem);
            disc.uv = fitter.draft(&disc);
            disc.uv = fitter.finish(&disc);
            let upright = (0..disc.faces.len()).all(|k| {
                let [a, b, c] = disc.face_uv(k);
                (b - a).perp_dot(c - a) > 0.0
            });
            if !upright {
                disc.uv = seen;
            }
        }
        disc
    }
}

/// Gives the faces of small charts to neighbours that take them.
fn give_away_small(mesh: &Mesh, chart: &mut [u32], charts: &mut [Chart], cone: f64) {
    for small in 0..charts.len() {
        let faces = charts[small].faces.clone();
        if faces.len() > SMALL {
            continue;
        }
        let mut borders: Vec<(u32, f64)> = Vec::new();
        for &f in &faces {
            for k in 0..3 {
                let other = mesh.neighbour(f, k);
                if other == NONE || chart[other as usize] == small as u32 {
                    continue;
                }
                let p = mesh.corners(f);
                let length = p[k as usize].distance(p[(k as usize + 1) % 3]);
                match borders.iter_mut().find(|(c, _)| *c == chart[other as usize]) {
                    Some((_, sum)) => *sum += length,
                    None => borders.push((chart[other as usize], length)),
                }
            }
        }
        borders.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        let taker = borders.iter().map(|&(c, _)| c).find(|&c| charts[c as usize].take(mesh, &faces, cone));
        if let Some(taker) = taker {
            faces.iter().for_each(|&f| chart[f as usize] = taker);
            charts[small].faces.clear();
        }
    }
}

/// All charts in one plane, in rows, none touching another.
fn side_by_side(mesh: &Mesh, charts: Vec<Disc>) -> FlatCharts {
    let bounds = |disc: &Disc| {
        let start = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        disc.uv.iter().fold(start, |(low, high), &p| (low.min(p), high.max(p)))
    };
    let room = charts.iter().map(&bounds).fold(DVec2::ZERO, |room, (low, high)| room.max(high - low)) * (1.0 + APART);
    let columns = (charts.len() as f64).sqrt().ceil().max(1.0) as usize;
    let mut out = FlatCharts { corners: vec![[0; 3]; mesh.face_count()], ..FlatCharts::default() };
    for (k, disc) in charts.into_iter().enumerate() {
        let to = DVec2::new((k % columns) as f64, (k / columns) as f64) * room - bounds(&disc).0;
        let base = out.vertices.len() as u32;
        for (&f, corners) in disc.faces.iter().zip(&disc.corners) {
            out.corners[f as usize] = corners.map(|v| base + v);
        }
        out.vertices.extend(&disc.vertices);
        out.uv.extend(disc.uv.iter().map(|&p| p + to));
    }
    out
}
