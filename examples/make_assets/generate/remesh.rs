//! From a signed distance field to well-shaped triangles.
//!
//! 1. Marching tetrahedra on a grid, six to the cell: no ambiguous cases, so a manifold.
//! 2. Isotropic remeshing: split long edges, collapse short ones, flip towards six neighbours, relax in the tangent plane,
//!    project back onto the field. The wished length is shorter where the surface bends.
//!
//! Based on: Botsch and Kobbelt, "A Remeshing Approach to Multiresolution Modeling", SGP 2004, section 4. We differ in
//! the wished length, which follows the curvature, and in projecting onto the distance field, which is exact.

use super::Triangles;
use super::sdf::Body;
use glam::DVec3;
use rayon::prelude::*;

/// How finely to sample a body.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fineness {
    /// Side of a grid cell of the first mesh.
    pub(crate) cell: f64,
    /// Edge length where the surface is flat.
    pub(crate) longest: f64,
    /// Edge length where it is sharply bent.
    pub(crate) shortest: f64,
    /// Angle, in radians, that neighbouring normals may differ by before edges are made shorter.
    pub(crate) bend: f64,
}

/// Meshes the body within the box from `low` to `high`, which must hold all of it.
pub(crate) fn mesh_body(body: &Body, low: DVec3, high: DVec3, fineness: Fineness) -> Triangles {
    /// Rounds of remeshing; edge lengths and valences settle well before.
    const ROUNDS: usize = 9;
    let first = march(body, low, high, fineness.cell);
    let mut work = Work::new(first);
    for _ in 0..ROUNDS {
        work.measure(body, fineness);
        work.split();
        work.collapse(body);
        work.flip();
        work.relax(body);
    }
    work.flip();
    work.relax(body);
    work.flip_thin();
    work.finish()
}

fn march(body: &Body, low: DVec3, high: DVec3, cell: f64) -> Triangles {
    /// Cells along a block that is skipped as a whole when the surface is far.
    const BLOCK: usize = 4;
    let count = ((high - low) / cell).ceil().to_array().map(|n| (n as usize).div_ceil(BLOCK) * BLOCK + 1);
    let place = |x: usize, y: usize, z: usize| low + DVec3::new(x as f64, y as f64, z as f64) * cell;
    let blocks = count.map(|n| (n - 1) / BLOCK);
    // Value at the middle of a block where the surface is too far to pass through it.
    let far: Vec<Option<f64>> = (0..blocks[0] * blocks[1] * blocks[2])
        .into_par_iter()
        .map(|b| {
            let (x, y, z) = (b % blocks[0], b / blocks[0] % blocks[1], b / (blocks[0] * blocks[1]));
            let half = (BLOCK / 2) as f64 * cell;
            let middle = body.distance(place(x * BLOCK, y * BLOCK, z * BLOCK) + DVec3::splat(half));
            // More than the half diagonal: the field may grow faster than 1 where ellipsoids are slim.
            (middle.abs() > 1.6 * half * 3_f64.sqrt()).then_some(middle)
        })
        .collect();
    let values: Vec<f64> = (0..count[0] * count[1] * count[2])
        .into_par_iter()
        .map(|i| {
            let at = [i % count[0], i / count[0] % count[1], i / (count[0] * count[1])];
            let b: [usize; 3] = std::array::from_fn(|k| (at[k] / BLOCK).min(blocks[k] - 1));
            far[(b[2] * blocks[1] + b[1]) * blocks[0] + b[0]].unwrap_or_else(|| body.distance(place(at[0], at[1], at[2])))
        })
        .collect();
    // The six tetrahedra of a cell: along its diagonal, by the orders in which the axes are walked. Odd orders are mirrored.
    const WALKS: [([usize; 2], bool); 6] =
        [([1, 3], true), ([2, 6], true), ([4, 5], true), ([1, 5], false), ([2, 3], false), ([4, 6], false)];
    let mut cut = Cut { values: &values, count, low, cell, vertex: vec![u32::MAX; 8 * values.len()], mesh: Triangles::default() };
    for i in 0..values.len() {
        let at = [i % count[0], i / count[0] % count[1], i / (count[0] * count[1])];
        if (0..3).any(|k| at[k] + 1 == count[k]) {
            continue;
        }
        let corner = |k: usize| i + (k & 1) + (k >> 1 & 1) * count[0] + (k >> 2) * count[0] * count[1];
        let first = values[i] < 0.0;
        if (1..8).all(|k| (values[corner(k)] < 0.0) == first) {
            continue;
        }
        for ([b, c], even) in WALKS {
            cut.tetrahedron([(i, 0), (corner(b), b), (corner(c), c), (corner(7), 7)], even);
        }
    }
    cut.mesh
}

/// Marching tetrahedra at work.
struct Cut<'a> {
    values: &'a [f64],
    count: [usize; 3],
    low: DVec3,
    cell: f64,
    /// Vertex on the edge from a grid point along the direction with the bits of its place in the list of eight.
    vertex: Vec<u32>,
    mesh: Triangles,
}

impl Cut<'_> {
    /// Adds the surface within a tetrahedron. Each corner is a grid point and its place in the cell; places grow.
    fn tetrahedron(&mut self, corners: [(usize, usize); 4], even: bool) {
        /// Even orders of the corners that put any one, or any two, of them first.
        const ONE: [[usize; 4]; 4] = [[0, 1, 2, 3], [1, 0, 3, 2], [2, 3, 0, 1], [3, 2, 1, 0]];
        const TWO: [[usize; 4]; 6] = [[0, 1, 2, 3], [0, 2, 3, 1], [0, 3, 1, 2], [1, 2, 0, 3], [1, 3, 2, 0], [2, 3, 0, 1]];
        let inside = corners.map(|(point, _)| self.values[point] < 0.0);
        let number = inside.iter().filter(|&&i| i).count();
        let add = |cut: &mut Self, face: [u32; 3], flip: bool| {
            cut.mesh.faces.push(if flip { [face[0], face[2], face[1]] } else { face });
        };
        if number == 2 {
            for [i, j, k, l] in TWO {
                if inside[i] && inside[j] {
                    let [a, b, c, d] = [[i, k], [i, l], [j, l], [j, k]].map(|[p, q]| self.vertex(corners[p], corners[q]));
                    add(self, [a, b, c], !even);
                    add(self, [a, c, d], !even);
                }
            }
        } else if number == 1 || number == 3 {
            for [i, j, k, l] in ONE {
                if inside[i] == (number == 1) {
                    let face = [j, k, l].map(|q| self.vertex(corners[i], corners[q]));
                    add(self, face, even == (number == 3));
                }
            }
        }
    }

    fn vertex(&mut self, p: (usize, usize), q: (usize, usize)) -> u32 {
        let (p, q) = if p.1 < q.1 { (p, q) } else { (q, p) };
        let key = 8 * p.0 + (q.1 ^ p.1);
        if self.vertex[key] == u32::MAX {
            let place = |i: usize| {
                let [nx, ny, _] = self.count;
                self.low + DVec3::new((i % nx) as f64, (i / nx % ny) as f64, (i / (nx * ny)) as f64) * self.cell
            };
            let (u, v) = (self.values[p.0], self.values[q.0]);
            self.vertex[key] = self.mesh.positions.len() as u32;
            self.mesh.positions.push(place(p.0).lerp(place(q.0), u / (u - v)));
        }
        self.vertex[key]
    }
}

/// A face that is gone.
const DEAD: [u32; 3] = [u32::MAX; 3];

struct Work {
    positions: Vec<DVec3>,
    faces: Vec<[u32; 3]>,
    /// Faces around each vertex, unordered.
    around: Vec<Vec<u32>>,
    /// Wished edge length at each vertex.
    wish: Vec<f64>,
}

impl Work {
    fn new(mesh: Triangles) -> Self {
        let mut around = vec![Vec::new(); mesh.positions.len()];
        for (f, face) in mesh.faces.iter().enumerate() {
            for &v in face {
                around[v as usize].push(f as u32);
            }
        }
        let wish = vec![0.0; mesh.positions.len()];
        Self { positions: mesh.positions, faces: mesh.faces, around, wish }
    }

    fn point(&self, v: u32) -> DVec3 {
        self.positions[v as usize]
    }

    fn length(&self, a: u32, b: u32) -> f64 {
        self.point(a).distance(self.point(b))
    }

    /// Length over wished length.
    fn excess(&self, a: u32, b: u32) -> f64 {
        self.length(a, b) / (0.5 * (self.wish[a as usize] + self.wish[b as usize]))
    }

    fn area_vector(&self, [a, b, c]: [u32; 3]) -> DVec3 {
        (self.point(b) - self.point(a)).cross(self.point(c) - self.point(a))
    }

    /// All edges whose excess is in a range, the most extreme first.
    fn edges(&self, wanted: impl Fn(f64) -> bool) -> Vec<(f64, u32, u32)> {
        let mut edges = Vec::new();
        for face in self.faces.iter().filter(|f| **f != DEAD) {
            for k in 0..3 {
                let (a, b) = (face[k], face[(k + 1) % 3]);
                if a < b && wanted(self.excess(a, b)) {
                    edges.push((self.excess(a, b), a, b));
                }
            }
        }
        edges.sort_by(|x, y| x.0.total_cmp(&y.0).then((x.1, x.2).cmp(&(y.1, y.2))));
        edges
    }

    /// The two faces along an edge, the one that has it as a to b first, and the corners opposite.
    fn wings(&self, a: u32, b: u32) -> Option<[(u32, u32); 2]> {
        let mut found = [None, None];
        for &f in &self.around[a as usize] {
            let face = self.faces[f as usize];
            let k = face.iter().position(|&v| v == a)?;
            if face[(k + 1) % 3] == b {
                found[0] = Some((f, face[(k + 2) % 3]));
            } else if face[(k + 2) % 3] == b {
                found[1] = Some((f, face[(k + 1) % 3]));
            }
        }
        Some([found[0]?, found[1]?])
    }

    fn neighbours(&self, v: u32) -> Vec<u32> {
        let faces = self.around[v as usize].iter().flat_map(|&f| self.faces[f as usize]);
        let mut ring: Vec<u32> = faces.filter(|&w| w != v).collect();
        ring.sort_unstable();
        ring.dedup();
        ring
    }

    fn replace(&mut self, f: u32, face: [u32; 3]) {
        for v in self.faces[f as usize] {
            if v != u32::MAX {
                self.around[v as usize].retain(|&g| g != f);
            }
        }
        self.faces[f as usize] = face;
        for v in face {
            if v != u32::MAX {
                self.around[v as usize].push(f);
            }
        }
    }

    /// Wished lengths from how much the surface's normal turns along the edges, smoothed so that sizes grow gradually.
    fn measure(&mut self, body: &Body, fineness: Fineness) {
        /// Passes of smoothing.
        const PASSES: usize = 3;
        let live: Vec<bool> = self.around.iter().map(|a| !a.is_empty()).collect();
        let normals: Vec<DVec3> =
            self.positions.par_iter().zip(&live).map(|(&p, &l)| if l { body.normal(p) } else { DVec3::ZERO }).collect();
        let rings: Vec<Vec<u32>> = (0..self.positions.len() as u32).into_par_iter().map(|v| self.neighbours(v)).collect();
        for v in 0..self.positions.len() {
            let turn = |&w: &u32| normals[v].distance(normals[w as usize]) / self.length(v as u32, w).max(1e-9);
            let bent = rings[v].iter().map(turn).fold(0.0, f64::max);
            self.wish[v] = (fineness.bend / bent.max(1e-9)).clamp(fineness.shortest, fineness.longest);
        }
        for _ in 0..PASSES {
            let old = self.wish.clone();
            for v in 0..old.len() {
                let mean = rings[v].iter().map(|&w| old[w as usize]).sum::<f64>() / rings[v].len().max(1) as f64;
                self.wish[v] = 0.5 * (old[v] + mean.min(old[v] * 1.5));
            }
        }
    }

    fn split(&mut self) {
        for (_, a, b) in self.edges(|e| e > 4.0 / 3.0).into_iter().rev() {
            if self.excess(a, b) <= 4.0 / 3.0 {
                continue;
            }
            let Some([(f, c), (g, d)]) = self.wings(a, b) else { continue };
            let m = self.positions.len() as u32;
            self.positions.push(0.5 * (self.point(a) + self.point(b)));
            self.wish.push(0.5 * (self.wish[a as usize] + self.wish[b as usize]));
            self.around.push(Vec::new());
            self.replace(f, [a, m, c]);
            self.replace(g, [b, m, d]);
            for face in [[m, b, c], [m, a, d]] {
                self.faces.push(DEAD);
                self.replace(self.faces.len() as u32 - 1, face);
            }
        }
    }

    /// True if moving a vertex turns none of the faces around it over, `without` left out: each keeps its side, or faces
    /// the body's outward `normal` there, or does so better than before.
    fn keeps_sides(&self, v: u32, to: DVec3, normal: DVec3, without: &[u32]) -> bool {
        /// Least cosine between a face's normal before and after.
        const TURN: f64 = 0.5;
        /// Least cosine between a face's normal and the body's.
        const FACING: f64 = 0.35;
        self.around[v as usize].iter().filter(|f| !without.contains(f)).all(|&f| {
            let face = self.faces[f as usize];
            let [p, q, r] = face.map(|w| if w == v { to } else { self.point(w) });
            let (old, new) = (self.area_vector(face).normalize_or_zero(), (q - p).cross(r - p).normalize_or_zero());
            let facing = new.dot(normal);
            facing > FACING || (facing > 0.0 && old.dot(new) > TURN) || facing > old.dot(normal)
        })
    }

    fn collapse(&mut self, body: &Body) {
        for (_, a, b) in self.edges(|e| e < 0.8) {
            let Some([(f, c), (g, d)]) = self.wings(a, b) else { continue };
            if self.excess(a, b) >= 0.8 {
                continue;
            }
            // The neighbours in common must be the two wing corners, or the surface would pinch.
            let (ring_a, ring_b) = (self.neighbours(a), self.neighbours(b));
            let common = ring_a.iter().filter(|v| ring_b.binary_search(v).is_ok()).count();
            let thin = [c, d].iter().any(|&v| self.around[v as usize].len() <= 3);
            if common != 2 || thin || c == d {
                continue;
            }
            let middle = body.project(0.5 * (self.point(a) + self.point(b)));
            let stays_short = |v: u32, ring: &[u32]| {
                ring.iter().all(|&w| {
                    w == a || w == b || self.point(w).distance(middle) < 1.4 * 0.5 * (self.wish[v as usize] + self.wish[w as usize])
                })
            };
            if !stays_short(a, &ring_a) || !stays_short(b, &ring_b) {
                continue;
            }
            let normal = body.normal(middle);
            if !self.keeps_sides(a, middle, normal, &[f, g]) || !self.keeps_sides(b, middle, normal, &[f, g]) {
                continue;
            }
            self.replace(f, DEAD);
            self.replace(g, DEAD);
            for h in self.around[b as usize].clone() {
                let face = self.faces[h as usize].map(|v| if v == b { a } else { v });
                self.replace(h, face);
            }
            self.positions[a as usize] = middle;
        }
    }

    /// Flips edges that bring the valences nearer to 6.
    fn flip(&mut self) {
        self.flip_where(|work, [a, b, c, d]| {
            let off = |v: u32, change: i64| {
                let n = work.around[v as usize].len() as i64 + change - 6;
                n * n
            };
            off(a, -1) + off(b, -1) + off(c, 1) + off(d, 1) < off(a, 0) + off(b, 0) + off(c, 0) + off(d, 0)
        });
    }

    /// Flips edges that make the thinner of their two faces rounder.
    fn flip_thin(&mut self) {
        self.flip_where(|work, [a, b, c, d]| {
            let round = |face: [u32; 3]| {
                let longest = (0..3).map(|k| work.length(face[k], face[(k + 1) % 3])).fold(0.0, f64::max);
                work.area_vector(face).length() / (longest * longest)
            };
            round([a, d, c]).min(round([d, b, c])) > 1.05 * round([a, b, c]).min(round([b, a, d]))
        });
    }

    /// Flips each edge a-b with the corners c and d opposite for which `better` says so, unless that folds the surface.
    fn flip_where(&mut self, better: impl Fn(&Self, [u32; 4]) -> bool) {
        for (_, a, b) in self.edges(|_| true) {
            let Some([(f, c), (g, d)]) = self.wings(a, b) else { continue };
            let too_few = self.around[a as usize].len() <= 3 || self.around[b as usize].len() <= 3;
            if too_few || c == d || !better(self, [a, b, c, d]) || self.neighbours(c).binary_search(&d).is_ok() {
                continue;
            }
            let (new_f, new_g) = ([a, d, c], [d, b, c]);
            let mean = self.area_vector(self.faces[f as usize]).normalize_or_zero()
                + self.area_vector(self.faces[g as usize]).normalize_or_zero();
            let flat = |face| self.area_vector(face).normalize_or_zero().dot(mean.normalize_or_zero()) > 0.7;
            if flat(new_f) && flat(new_g) {
                self.replace(f, new_f);
                self.replace(g, new_g);
            }
        }
    }

    /// Moves each vertex in its tangent plane to the mean of the faces around, finer regions weighing more, and back onto
    /// the body.
    fn relax(&mut self, body: &Body) {
        /// Share of the way that is gone.
        const DAMPING: f64 = 0.7;
        let target = |v: usize| {
            let p = self.positions[v];
            if self.around[v].is_empty() {
                return p;
            }
            let (mut sum, mut weights) = (DVec3::ZERO, 0.0);
            for &f in &self.around[v] {
                let face = self.faces[f as usize];
                let wish = face.iter().map(|&w| self.wish[w as usize]).sum::<f64>();
                let weight = self.area_vector(face).length() / (wish * wish);
                sum += face.iter().map(|&w| self.point(w)).sum::<DVec3>() / 3.0 * weight;
                weights += weight;
            }
            let normal = body.normal(p);
            let step = sum / weights.max(1e-300) - p;
            body.project(p + DAMPING * (step - normal * normal.dot(step)))
        };
        let targets: Vec<DVec3> = (0..self.positions.len()).into_par_iter().map(target).collect();
        for (v, to) in targets.into_iter().enumerate() {
            // Nor may vertices run together, which they would where the field's gradient jumps.
            let apart = self.neighbours(v as u32).iter().map(|&w| self.point(w).distance(to)).fold(f64::INFINITY, f64::min);
            if apart > 0.4 * self.wish[v] && self.keeps_sides(v as u32, to, body.normal(to), &[]) {
                self.positions[v] = to;
            }
        }
    }

    /// The live part, renumbered.
    fn finish(self) -> Triangles {
        let mut number = vec![u32::MAX; self.positions.len()];
        let mut out = Triangles::default();
        for face in self.faces.iter().filter(|f| **f != DEAD) {
            out.faces.push(face.map(|v| {
                if number[v as usize] == u32::MAX {
                    number[v as usize] = out.positions.len() as u32;
                    out.positions.push(self.positions[v as usize]);
                }
                number[v as usize]
            }));
        }
        out
    }
}
