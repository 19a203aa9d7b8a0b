//! The shared mesh core: an indexed triangle mesh with opposite half-edges. Knows nothing of textures.
//!
//! A half-edge is named by its corner: half-edge `h = 3 f + k` runs from corner `k` of face `f` to the next corner.
//! [`Mesh::opposite`] pairs each with the half-edge that runs the other way, or [`NONE`] on a boundary. That table is
//! the whole topology: rings, boundaries and components are walks over it.
//!
//! Every `Mesh` is an oriented manifold, possibly with boundary, of any genus and any number of components; each vertex
//! has one fan of faces. [`clean()`] makes one from whatever a file holds.

pub mod clean;
pub mod curvature;
pub mod disc;
pub mod distance;
pub mod geodesic;
pub mod nearest;
pub mod part;
pub mod pyramid;
pub mod retile;
pub mod subdivide;
pub mod transport;
pub mod walk;
mod weld;

#[cfg(test)]
pub(crate) mod shapes;

pub use clean::{CleanOptions, CleanReport, Cleaned, clean};

use glam::{DVec3, Vec3};

/// "No half-edge", "no face", "no vertex" in every index table of the crate.
pub const NONE: u32 = u32::MAX;

/// Why positions and faces are no mesh.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// There is nothing to work on.
    #[error("the mesh has no faces: export it with its triangles or polygons")]
    Empty,
    /// A face names a vertex that is not there.
    #[error(
        "face {face} uses vertex {vertex}, but there are only {count} vertices (counting from 0): the file is damaged or cut short"
    )]
    IndexOutOfRange {
        /// Face, in the caller's order, from 0.
        face: usize,
        /// The vertex it names.
        vertex: u32,
        /// How many vertices there are.
        count: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("vertex {vertex} has a coordinate that is not a number (NaN or infinite): repair the mesh where it was made")]
    NotFinite {
        /// Vertex, in the caller's order, from 0.
        vertex: usize,
    },
    /// All faces were degenerate.
    #[error(
        "none of the {count} faces has any area, so nothing can be pasted on this mesh: check its coordinates, or export it again"
    )]
    NoArea {
        /// How many faces were looked at.
        count: usize,
    },
    /// More elements than 32-bit half-edge indices can name.
    #[error("the mesh has {count} faces; at most {max} are supported: split it")]
    TooLarge {
        /// Faces given.
        count: usize,
        /// Faces supported.
        max: usize,
    },
    /// The faces are not an oriented manifold; only [`Mesh::new`] on uncleaned faces says so.
    #[error("half-edge {from}-{to} is used by more than one face: run `clean` on the mesh first")]
    NotManifold {
        /// Start vertex.
        from: u32,
        /// End vertex.
        to: u32,
    },
}

/// The largest number of faces whose half-edges fit 32-bit indices, [`NONE`] apart.
pub const MAX_FACES: usize = (u32::MAX / 3 - 1) as usize;

/// A point on the surface: a face and barycentric coordinates that sum to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// Face index.
    pub face: u32,
    /// Weights of the face's three corners.
    pub bary: Vec3,
}

/// An oriented triangle manifold. See the module text for its invariants.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    /// Vertex positions, world units.
    pub positions: Vec<Vec3>,
    /// Corners of each face, counter-clockwise seen from outside.
    pub faces: Vec<[u32; 3]>,
    /// For each half-edge `3 f + k` the one that runs back along the same edge, or [`NONE`] on a boundary.
    pub opposite: Vec<u32>,
}

/// The half-edge after `h` in its face.
#[inline]
#[must_use]
pub const fn next(h: u32) -> u32 {
    if h % 3 == 2 { h - 2 } else { h + 1 }
}

/// The half-edge before `h` in its face.
#[inline]
#[must_use]
pub const fn prev(h: u32) -> u32 {
    if h.is_multiple_of(3) { h + 2 } else { h - 1 }
}

impl Mesh {
    /// Builds the half-edge table over faces that already are an oriented manifold.
    ///
    /// # Errors
    /// If an index is out of range, a coordinate not finite, there are no faces, or a half-edge occurs twice.
    pub fn new(positions: Vec<Vec3>, faces: Vec<[u32; 3]>) -> Result<Self, MeshError> {
        check_input(&positions, &faces)?;
        let opposite = match_half_edges(&faces)?;
        Ok(Self { positions, faces, opposite })
    }

    /// Number of faces.
    #[must_use]
    pub const fn face_count(&self) -> usize {
        self.faces.len()
    }

    /// Number of vertices.
    #[must_use]
    pub const fn vertex_count(&self) -> usize {
        self.positions.len()
    }

    /// Position of a vertex in double precision.
    #[inline]
    #[must_use]
    pub fn point(&self, vertex: u32) -> DVec3 {
        self.positions[vertex as usize].as_dvec3()
    }

    /// Corner positions of a face in double precision.
    #[inline]
    #[must_use]
    pub fn corners(&self, face: u32) -> [DVec3; 3] {
        self.faces[face as usize].map(|v| self.point(v))
    }

    /// Vertex where half-edge `h` starts.
    #[inline]
    #[must_use]
    pub fn origin(&self, h: u32) -> u32 {
        self.faces[(h / 3) as usize][(h % 3) as usize]
    }

    /// Twice the area times the unit normal.
    #[inline]
    #[must_use]
    pub fn area_vector(&self, face: u32) -> DVec3 {
        let [a, b, c] = self.corners(face);
        (b - a).cross(c - a)
    }

    /// Unit normal of a face; zero for a face without area.
    #[inline]
    #[must_use]
    pub fn normal(&self, face: u32) -> DVec3 {
        self.area_vector(face).normalize_or_zero()
    }

    /// Area of a face, world units squared.
    #[inline]
    #[must_use]
    pub fn area(&self, face: u32) -> f64 {
        0.5 * self.area_vector(face).length()
    }

    /// Area of the whole surface.
    #[must_use]
    pub fn total_area(&self) -> f64 {
        (0..self.face_count() as u32).map(|f| self.area(f)).sum()
    }

    /// Centroid of a face.
    #[inline]
    #[must_use]
    pub fn centroid(&self, face: u32) -> DVec3 {
        let [a, b, c] = self.corners(face);
        (a + b + c) / 3.0
    }

    /// Position of a surface point.
    #[inline]
    #[must_use]
    pub fn position(&self, at: SurfacePoint) -> DVec3 {
        let [a, b, c] = self.corners(at.face);
        let w = at.bary.as_dvec3();
        a * w.x + b * w.y + c * w.z
    }

    /// The face across edge `k` (from corner `k` to the next) of a face, or [`NONE`].
    #[inline]
    #[must_use]
    pub fn neighbour(&self, face: u32, k: u32) -> u32 {
        match self.opposite[(3 * face + k) as usize] {
            NONE => NONE,
            h => h / 3,
        }
    }

    /// Smallest and largest corner of the axis-aligned bounding box.
    #[must_use]
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let start = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        self.positions.iter().fold(start, |(lo, hi), &p| (lo.min(p), hi.max(p)))
    }

    /// Unit normals at the vertices: the mean of the faces around, weighted by their angle there.
    #[must_use]
    pub fn vertex_normals(&self) -> Vec<Vec3> {
        let mut sums = vec![DVec3::ZERO; self.vertex_count()];
        for (f, corners) in self.faces.iter().enumerate() {
            let normal = self.normal(f as u32);
            let p = self.corners(f as u32);
            for k in 0..3 {
                let (a, b) = (p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]);
                let angle = a.cross(b).length().atan2(a.dot(b));
                sums[corners[k] as usize] += normal * angle;
            }
        }
        sums.into_iter().map(|n| n.normalize_or_zero().as_vec3()).collect()
    }

    /// One half-edge that starts at each vertex ([`NONE`] if no face uses it): on a boundary the one from which
    /// [`Mesh::ring`] sees the whole fan.
    #[must_use]
    pub fn vertex_half_edges(&self) -> Vec<u32> {
        let mut first = vec![NONE; self.vertex_count()];
        for h in 0..self.opposite.len() as u32 {
            let v = self.origin(h) as usize;
            // Turning counter-clockwise ends at a boundary on the far side; start where nothing lies clockwise.
            if first[v] == NONE || self.opposite[h as usize] == NONE {
                first[v] = h;
            }
        }
        first
    }

    /// The half-edges that start at one vertex, counter-clockwise, from one that [`Mesh::vertex_half_edges`] gave.
    pub fn ring(&self, start: u32) -> impl Iterator<Item = u32> + '_ {
        let mut at = start;
        std::iter::from_fn(move || {
            if at == NONE {
                return None;
            }
            let here = at;
            at = self.opposite[prev(here) as usize];
            if at == start {
                at = NONE;
            }
            Some(here)
        })
    }

    /// Component number of each face, and how many there are. Components are numbered by their first face.
    #[must_use]
    pub fn components(&self) -> (Vec<u32>, usize) {
        let mut of = vec![NONE; self.face_count()];
        let mut count = 0;
        let mut stack = Vec::new();
        for seed in 0..self.face_count() as u32 {
            if of[seed as usize] != NONE {
                continue;
            }
            of[seed as usize] = count;
            stack.push(seed);
            while let Some(f) = stack.pop() {
                for k in 0..3 {
                    let g = self.neighbour(f, k);
                    if g != NONE && of[g as usize] == NONE {
                        of[g as usize] = count;
                        stack.push(g);
                    }
                }
            }
            count += 1;
        }
        (of, count as usize)
    }

    /// Number of edges: pairs of half-edges, and single ones on boundaries.
    #[must_use]
    pub fn edge_count(&self) -> usize {
        let single = self.boundary_edge_count();
        (self.opposite.len() - single) / 2 + single
    }

    /// Number of edges with a face on one side only.
    #[must_use]
    pub fn boundary_edge_count(&self) -> usize {
        self.opposite.iter().filter(|&&o| o == NONE).count()
    }

    /// Number of boundary loops.
    #[must_use]
    pub fn boundary_loop_count(&self) -> usize {
        let mut seen = vec![false; self.opposite.len()];
        let mut loops = 0;
        for start in 0..self.opposite.len() as u32 {
            if self.opposite[start as usize] != NONE || seen[start as usize] {
                continue;
            }
            loops += 1;
            let mut h = start;
            while !seen[h as usize] {
                seen[h as usize] = true;
                h = next(h);
                while self.opposite[h as usize] != NONE {
                    h = next(self.opposite[h as usize]);
                }
            }
        }
        loops
    }

    /// Euler characteristic V - E + F over the vertices that faces use.
    #[must_use]
    pub fn euler_characteristic(&self) -> i64 {
        let mut used = vec![false; self.vertex_count()];
        for &v in self.faces.as_flattened() {
            used[v as usize] = true;
        }
        let vertices = used.iter().filter(|&&u| u).count();
        vertices as i64 - self.edge_count() as i64 + self.face_count() as i64
    }

    /// Signed volume of the solid that the faces enclose (about their mean, so that open parts give a small number).
    #[must_use]
    pub fn signed_volume(&self) -> f64 {
        let faces: Vec<u32> = (0..self.face_count() as u32).collect();
        signed_volume(&self.positions, &self.faces, &faces)
    }

    /// Tests every invariant of the module text; for tests, property tests and fuzz targets.
    ///
    /// # Errors
    /// A sentence naming the first element that breaks one.
    pub fn check(&self) -> Result<(), String> {
        check_input(&self.positions, &self.faces).map_err(|e| e.to_string())?;
        if self.opposite.len() != 3 * self.face_count() {
            return Err(format!("{} opposites for {} faces", self.opposite.len(), self.face_count()));
        }
        for h in 0..self.opposite.len() as u32 {
            let o = self.opposite[h as usize];
            if o == NONE {
                continue;
            }
            if o as usize >= self.opposite.len() || self.opposite[o as usize] != h {
                return Err(format!("half-edge {h} and its opposite {o} do not name each other"));
            }
            if self.origin(h) != self.origin(next(o)) || self.origin(next(h)) != self.origin(o) {
                return Err(format!("half-edges {h} and {o} run along different edges"));
            }
        }
        for (f, c) in self.faces.iter().enumerate() {
            if c[0] == c[1] || c[1] == c[2] || c[2] == c[0] {
                return Err(format!("face {f} repeats a vertex: {c:?}"));
            }
        }
        let first = self.vertex_half_edges();
        let mut reached = 0;
        for &h in &first {
            if h != NONE {
                reached += self.ring(h).count();
            }
        }
        if reached != self.opposite.len() {
            return Err(format!(
                "one fan a vertex reaches {reached} of {} corners: a vertex has several fans",
                self.opposite.len()
            ));
        }
        Ok(())
    }
}

/// Signed volume under some faces, taken about their own mean corner so that distance from the origin costs no accuracy.
pub(crate) fn signed_volume(positions: &[Vec3], faces: &[[u32; 3]], subset: &[u32]) -> f64 {
    let corner = |f: u32, k: usize| positions[faces[f as usize][k] as usize].as_dvec3();
    let mean = subset.iter().map(|&f| corner(f, 0)).sum::<DVec3>() / subset.len().max(1) as f64;
    let six: f64 = subset
        .iter()
        .map(|&f| {
            let [a, b, c] = [0, 1, 2].map(|k| corner(f, k) - mean);
            a.dot(b.cross(c))
        })
        .sum();
    six / 6.0
}

pub(crate) fn check_input(positions: &[Vec3], faces: &[[u32; 3]]) -> Result<(), MeshError> {
    if faces.is_empty() {
        return Err(MeshError::Empty);
    }
    if faces.len() > MAX_FACES || positions.len() > MAX_FACES {
        return Err(MeshError::TooLarge { count: faces.len().max(positions.len()), max: MAX_FACES });
    }
    if let Some(vertex) = positions.iter().position(|p| !p.is_finite()) {
        return Err(MeshError::NotFinite { vertex });
    }
    let count = positions.len();
    for (face, corners) in faces.iter().enumerate() {
        if let Some(&vertex) = corners.iter().find(|&&v| v as usize >= count) {
            return Err(MeshError::IndexOutOfRange { face, vertex, count });
        }
    }
    Ok(())
}

/// Pairs half-edges; every edge must have one face on each side, or one face at all.
fn match_half_edges(faces: &[[u32; 3]]) -> Result<Vec<u32>, MeshError> {
    let mut opposite = vec![NONE; faces.len() * 3];
    let mut bad = None;
    for_each_edge(faces, |uses| match *uses {
        [_] => {}
        [h, o] if ends(faces, h).0 != ends(faces, o).0 => {
            opposite[h as usize] = o;
            opposite[o as usize] = h;
        }
        _ => bad = bad.or(Some(ends(faces, uses[0]))),
    });
    match bad {
        Some((from, to)) => Err(MeshError::NotManifold { from, to }),
        None => Ok(opposite),
    }
}

/// Start and end vertex of a half-edge.
#[inline]
pub(crate) fn ends(faces: &[[u32; 3]], h: u32) -> (u32, u32) {
    let (c, k) = (faces[(h / 3) as usize], (h % 3) as usize);
    (c[k], c[(k + 1) % 3])
}

/// Calls `visit` with the half-edges of each undirected edge, ascending. By bucket and sort rather than by hash map, so
/// that memory stays small and no result ever depends on a hash.
pub(crate) fn for_each_edge(faces: &[[u32; 3]], mut visit: impl FnMut(&[u32])) {
    let vertices = faces.as_flattened().iter().max().map_or(0, |&v| v as usize + 1);
    let low_end = |h: u32| {
        let (a, b) = ends(faces, h);
        a.min(b) as usize
    };
    let half_edges = 0..3 * faces.len() as u32;
    let mut start = vec![0_u32; vertices + 1];
    for h in half_edges.clone() {
        start[low_end(h) + 1] += 1;
    }
    for v in 0..vertices {
        start[v + 1] += start[v];
    }
    let mut fill = start.clone();
    let mut bucket = vec![0_u32; half_edges.len()];
    for h in half_edges {
        let place = &mut fill[low_end(h)];
        bucket[*place as usize] = h;
        *place += 1;
    }
    for v in 0..vertices {
        let slice = &mut bucket[start[v] as usize..start[v + 1] as usize];
        let high_end = |h: u32| {
            let (a, b) = ends(faces, h);
            a.max(b)
        };
        slice.sort_unstable_by_key(|&h| (high_end(h), h));
        for edge in slice.chunk_by(|&g, &h| high_end(g) == high_end(h)) {
            visit(edge);
        }
    }
}
