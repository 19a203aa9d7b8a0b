//! Re-tiling: the same surface with another number of vertices, evenly spread.
//!
//! Based on: Turk, "Re-tiling polygonal surfaces", SIGGRAPH 1992.
//!
//! 1. Spread the new vertices over the faces by area (`sites`); boundaries and, on request, creases get theirs along
//!    themselves (`features`).
//! 2. Tessellate old and new vertices together, face by face (`tessellate`).
//! 3. Take out the old vertices (`remove`).
//! 4. Let the new ones repel each other over the original surface (`repulsion`).
//! 5. Look how far the old vertices lie from the new mesh, and put back those that nothing stands for (`reach`).
//!
//! The paper repels the points before it makes a mesh of them, with forces over a radius and neighbouring faces laid flat. With
//! the mesh made first, its own edges say who is whose neighbour: also where two sheets lie close, and at the cost of a
//! walk around each vertex. The topology is that of the original at every moment, since each change of the mesh is
//! one that cannot alter it.

mod features;
mod flips;
mod reach;
mod remove;
mod repulsion;
mod sites;
mod statistics;
mod surgery;
mod tessellate;

pub use statistics::{Evenness, evenness};

use super::walk::at_origin;
use super::{Mesh, MeshError, NONE, SurfacePoint};
use crate::progress::Progress;
use remove::Scratch;
use serde::Serialize;
use surgery::Surgery;

/// More vertices than this are refused: their faces would not fit what the rest of the program reads.
pub const MAX_VERTICES: usize = 25_000_000;

/// How to re-tile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RetileOptions {
    /// Vertices of the new mesh.
    pub vertices: usize,
    /// Keep edges over which the surface bends by more than this, radians. Boundaries are always kept.
    pub crease: Option<f64>,
    /// Rounds of repulsion that also move vertices from crowded to roomy places; a few without follow.
    pub rounds: usize,
    /// Seed of where the new vertices start.
    pub seed: u64,
}

impl Default for RetileOptions {
    fn default() -> Self {
        Self { vertices: 10_000, crease: None, rounds: 7, seed: 1 }
    }
}

/// Why a mesh cannot be re-tiled.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RetileError {
    /// Fewer vertices than the topology needs.
    #[error(
        "{asked} vertices are too few: the mesh has {components} parts and {loops} boundary loops, which need at least {least} to stay what they are"
    )]
    TooFew {
        /// Vertices asked for.
        asked: usize,
        /// Vertices needed.
        least: usize,
        /// Connected components.
        components: usize,
        /// Boundary loops.
        loops: usize,
    },
    /// More vertices than the program handles.
    #[error("{asked} vertices are too many: at most {MAX_VERTICES} are supported, which take about 15 GB of memory")]
    TooMany {
        /// Vertices asked for.
        asked: usize,
    },
    /// A crease angle that is none.
    #[error("the crease angle is {0} radians: give one between 0 and a half turn")]
    Crease(f64),
    /// The sink asked to stop.
    #[error("stopped")]
    Cancelled,
    /// The mesh cannot be built.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}

/// What [`retile`] did.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct RetileStatistics {
    /// Vertices asked for.
    pub asked: usize,
    /// Vertices of the new mesh.
    pub vertices: usize,
    /// Vertices on boundaries and creases.
    pub on_lines: usize,
    /// Vertices of the original that could not be taken out and stayed.
    pub kept_old: usize,
    /// Vertices of the original put back because the new mesh lay too far from them.
    pub put_back: usize,
    /// Largest distance of a vertex of the original from the new mesh, world units.
    pub farthest: f64,
    /// Edges, angles and valences of the new mesh.
    pub evenness: Evenness,
}

/// A re-tiled mesh.
#[derive(Debug, Clone)]
pub struct Retiled {
    /// The mesh. Vertices and faces are in the order of a space-filling curve.
    pub mesh: Mesh,
    /// Where each of its vertices lies on the original.
    pub at: Vec<SurfacePoint>,
    /// What was done.
    pub statistics: RetileStatistics,
}

/// What a vertex is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Role {
    /// A vertex of the original that is to go.
    Old,
    /// A new vertex that moves.
    Free,
    /// A vertex on a line, or put back; it stays where it is.
    Fixed,
}

/// A mesh on its way from the original to the new one.
struct Tiling<'m> {
    original: &'m Mesh,
    surgery: Surgery,
    at: Vec<SurfacePoint>,
    role: Vec<Role>,
    /// Vertices asked for.
    count: usize,
    /// The mean edge that so many give, world units.
    edge: f64,
    kept_old: usize,
}

impl Tiling<'_> {
    /// Forgets what has been taken out.
    fn compact(&mut self, order: Option<Vec<u32>>) {
        let kept = self.surgery.compact(order);
        self.at = kept.iter().map(|&v| self.at[v as usize]).collect();
        self.role = kept.iter().map(|&v| self.role[v as usize]).collect();
    }
}

/// Fewest vertices of a closed component, and of a boundary loop.
const LEAST_CLOSED: usize = 4;
const LEAST_LOOP: usize = 3;

/// At most this share of the vertices goes to boundaries and creases.
const LINES_SHARE: f64 = 0.5;

/// Rounds of repulsion alone that end it, in which what was moved from crowded to roomy places settles; and their largest number,
/// if old vertices are missed or the number of vertices is not yet what was asked for.
const SETTLING: usize = 3;
const MOST_SETTLING: usize = 14;
/// After so many of them nothing moves any more, so that what is put back for one place spoils no other, and this ends; the count may
/// then be off by one in so many.
const MOVING: usize = 9;
const NEARLY: usize = 150;

/// Re-tiles a mesh. Linear in old and new vertices together.
///
/// # Errors
/// If so many vertices cannot make this surface, or `progress` cancels.
pub fn retile(mesh: &Mesh, options: &RetileOptions, progress: &dyn Progress) -> Result<Retiled, RetileError> {
    progress.stage("spreading vertices", 0);
    let mut t = start(mesh, options)?;
    let mut scratch = Scratch::default();
    cancelled(progress)?;
    progress.stage("removing old vertices", 0);
    remove::remove_old(&mut t, &mut scratch);
    t.compact(Some(sites::along_curve(t.surgery.alive(), |v| t.surgery.positions[v as usize].as_vec3())));
    progress.stage("repelling vertices", options.rounds as u64);
    for round in 0..options.rounds {
        cancelled(progress)?;
        repulsion::relax(&mut t, &mut scratch);
        repulsion::relocate(&mut t, false, &mut scratch);
        progress.done(round as u64 + 1);
    }
    progress.stage("comparing surfaces", 0);
    let mut put_back = 0;
    let mut farthest = 0.0;
    let reach = reach::Reach::new(mesh, t.edge);
    for round in 0..MOST_SETTLING {
        cancelled(progress)?;
        if round < MOVING {
            repulsion::relax(&mut t, &mut scratch);
        }
        let mut put = 0;
        if round > 0 {
            let spare = if round < MOVING { usize::MAX } else { t.count + t.count / NEARLY };
            let room = spare.saturating_sub(t.surgery.alive_vertices());
            (put, farthest) = reach.put_back(&mut t, if round + 1 < MOST_SETTLING { room } else { 0 }, &mut scratch);
            put_back += put;
        }
        let off = t.surgery.alive_vertices().abs_diff(t.count);
        let counts = if round < MOVING { off > 0 } else { off * NEARLY > t.count };
        let moved = counts && repulsion::relocate(&mut t, true, &mut scratch) > 0;
        if round + 1 >= SETTLING && put == 0 && !moved {
            break;
        }
    }
    // Relocation has scattered the numbers; whoever walks the mesh wants neighbours near in memory.
    t.compact(Some(sites::along_curve(t.surgery.alive(), |v| t.surgery.positions[v as usize].as_vec3())));
    let new = t.surgery.mesh();
    let on_lines = (0..new.vertex_count() as u32).filter(|&v| remove::is_on_line(&t.surgery, v, &mut scratch.fan)).count();
    let statistics = RetileStatistics {
        asked: options.vertices,
        vertices: new.vertex_count(),
        on_lines,
        kept_old: t.kept_old,
        put_back,
        farthest,
        evenness: evenness(&new),
    };
    Ok(Retiled { mesh: new, at: t.at, statistics })
}

fn cancelled(progress: &dyn Progress) -> Result<(), RetileError> {
    if progress.cancelled() { Err(RetileError::Cancelled) } else { Ok(()) }
}

/// The mutual tessellation, each vertex with its role.
fn start<'m>(mesh: &'m Mesh, options: &RetileOptions) -> Result<Tiling<'m>, RetileError> {
    let asked = options.vertices;
    if asked > MAX_VERTICES {
        return Err(RetileError::TooMany { asked });
    }
    if let Some(crease) = options.crease.filter(|c| !(*c > 0.0 && *c < std::f64::consts::PI)) {
        return Err(RetileError::Crease(crease));
    }
    let (component, components) = mesh.components();
    let mut areas = vec![0.0; components];
    (0..mesh.face_count() as u32).for_each(|f| areas[component[f as usize] as usize] += mesh.area(f));
    let loops = loops(mesh, &component, components);
    let least: Vec<usize> = loops.iter().map(|&n| if n == 0 { LEAST_CLOSED } else { n * LEAST_LOOP }).collect();
    let needed = least.iter().sum();
    if asked < needed {
        return Err(RetileError::TooFew { asked, least: needed, components, loops: loops.iter().sum() });
    }

    let on_line = features::lines(mesh, options.crease);
    let length = features::line_length(mesh, &on_line);
    let boundary: f64 = features::line_length(mesh, &mesh.opposite.iter().map(|&o| o == NONE).collect::<Vec<_>>());
    let edge = mean_edge(areas.iter().sum(), boundary, asked);
    let spacing = edge.max(length / (LINES_SHARE * asked as f64));
    let features = features::features(mesh, on_line, spacing);
    let mut lines = vec![0; components];
    let first = mesh.vertex_half_edges();
    for face in features.fixed.iter().map(|&v| first[v as usize] / 3).chain(features.cuts.iter().map(|c| c.0 / 3)) {
        lines[component[face as usize] as usize] += 1;
    }
    let on_lines: usize = lines.iter().sum();
    let inner: Vec<usize> = least.iter().zip(&lines).map(|(&least, &lines)| least.saturating_sub(lines)).collect();
    let mut shares = sites::shares(&areas, &inner, asked.saturating_sub(on_lines));
    let mut kept = features.fixed.clone();
    sites::keep_small(mesh, &component, &mut shares, &mut kept);
    let sites = sites::sites(mesh, &component, &shares, &areas, options.seed);
    let mutual = tessellate::tessellate(mesh, &features, &sites)?;

    let mut role = vec![Role::Old; mesh.vertex_count()];
    kept.iter().for_each(|&v| role[v as usize] = Role::Fixed);
    role.extend(std::iter::repeat_n(Role::Fixed, features.cuts.len()));
    role.extend(std::iter::repeat_n(Role::Free, sites.len()));
    let mut at: Vec<SurfacePoint> = first.iter().map(|&h| if h == NONE { at_origin(0) } else { at_origin(h) }).collect();
    at.extend(&mutual.at);
    let positions = at.iter().map(|&p| mesh.position(p)).collect();
    let surgery = Surgery::new(positions, mutual.faces, mutual.opposite, mutual.on_line);
    Ok(Tiling { original: mesh, surgery, at, role, count: asked, edge, kept_old: 0 })
}

/// Boundary loops of each component.
fn loops(mesh: &Mesh, component: &[u32], components: usize) -> Vec<usize> {
    let mut seen = vec![false; mesh.opposite.len()];
    let mut loops = vec![0; components];
    for start in 0..mesh.opposite.len() as u32 {
        if mesh.opposite[start as usize] != NONE || seen[start as usize] {
            continue;
        }
        loops[component[(start / 3) as usize] as usize] += 1;
        let mut h = start;
        while !seen[h as usize] {
            seen[h as usize] = true;
            h = super::next(h);
            while mesh.opposite[h as usize] != NONE {
                h = super::next(mesh.opposite[h as usize]);
            }
        }
    }
    loops
}

/// The edge length of equilateral faces that cover an area with so many vertices, some of them on a boundary.
fn mean_edge(area: f64, boundary: f64, vertices: usize) -> f64 {
    let of = |faces: f64| (4.0 * area / (3_f64.sqrt() * faces)).sqrt();
    let mut edge = of(2.0 * vertices as f64);
    for _ in 0..8 {
        let faces = (2.0 * vertices as f64 - boundary / edge).max(vertices as f64);
        edge = of(faces);
    }
    edge
}
