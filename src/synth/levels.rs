//! The levels that are synthesised on: meshes, texture frames at their vertices, and the way from each to the coarser ones.

use super::fan::{Fans, Frame};
use super::neighbourhood::{Ground, Neighbourhoods};
use super::window::Window;
use crate::field::NWayField;
use crate::field::nway::Connection;
use crate::mesh::pyramid::{Parent, Pyramid, parents};
use crate::mesh::{Mesh, SurfacePoint};
use crate::random::Random;
use glam::DVec3;
use rayon::prelude::*;
use std::collections::VecDeque;
use std::f64::consts::TAU;

/// One level.
#[derive(Debug, Clone)]
pub struct Level {
    /// Its mesh.
    pub mesh: Mesh,
    /// The texture frame at each vertex.
    pub frames: Vec<Frame>,
    /// Distance of template samples, world units: one pixel of the exemplar's level of the same number.
    pub spacing: f64,
    pub(super) fans: Fans,
}

/// Levels of a surface, the finest first.
#[derive(Debug, Clone)]
pub struct Levels {
    levels: Vec<Level>,
    /// For each level but the last the parents of its vertices on the next.
    parents: Vec<Vec<SurfacePoint>>,
}

/// The distance of template samples on a mesh: sqrt(2 A) for a mean face area A (WL 3.3), the edge of a regular grid.
#[must_use]
pub fn spacing(mesh: &Mesh) -> f64 {
    (2.0 * mesh.total_area() / mesh.face_count().max(1) as f64).sqrt().max(f64::MIN_POSITIVE)
}

impl Level {
    /// A mesh with a direction of texture right at each vertex, and the distance of template samples.
    #[must_use]
    pub fn new(mesh: Mesh, right: &[DVec3], spacing: f64) -> Self {
        let normals = mesh.vertex_normals();
        let any = |v: usize| right.get(v).copied().unwrap_or(DVec3::X);
        let frame = |(v, n): (usize, &glam::Vec3)| Frame::new(n.as_dvec3(), any(v));
        let frames: Vec<Frame> = normals.par_iter().enumerate().with_min_len(1024).map(frame).collect();
        let fans = Fans::new(&mesh, &frames, spacing);
        Self { mesh, frames, spacing, fans }
    }
}

impl Levels {
    /// Levels from meshes, the finest first, with a direction of texture right at each vertex.
    #[must_use]
    pub fn new(meshes: Vec<(Mesh, Vec<DVec3>)>) -> Self {
        let parents = meshes.windows(2).map(|w| points(parents(&w[0].0, &w[1].0))).collect();
        Self::with_parents(meshes, parents)
    }

    /// Levels of a mesh pyramid with a direction of texture right at each vertex of each level.
    #[must_use]
    pub fn of_pyramid(pyramid: Pyramid, right: Vec<Vec<DVec3>>) -> Self {
        let meshes = pyramid.levels.into_iter().map(|l| l.mesh).zip(right).collect();
        Self::with_parents(meshes, pyramid.parents.into_iter().map(points).collect())
    }

    fn with_parents(meshes: Vec<(Mesh, Vec<DVec3>)>, parents: Vec<Vec<SurfacePoint>>) -> Self {
        let level = |(mesh, right): (Mesh, Vec<DVec3>)| {
            let spacing = spacing(&mesh);
            Level::new(mesh, &right, spacing)
        };
        Self { levels: meshes.into_iter().map(level).collect(), parents }
    }

    /// The levels, the finest first.
    #[must_use]
    pub fn levels(&self) -> &[Level] {
        &self.levels
    }

    /// The finest level.
    #[must_use]
    pub fn finest(&self) -> &Level {
        &self.levels[0]
    }

    /// How many levels.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.levels.len()
    }

    /// True if there are none.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.levels.is_empty()
    }

    /// The parent of each vertex of a level on the next coarser one; empty for the coarsest.
    pub(super) fn parents(&self, level: usize) -> &[SurfacePoint] {
        self.parents.get(level).map_or(&[], Vec::as_slice)
    }

    pub(super) fn ground(&self, level: usize) -> Ground<'_> {
        let Level { mesh, frames, spacing, fans } = &self.levels[level];
        Ground { mesh, frames, fans, spacing: *spacing }
    }

    /// The neighbourhoods of a level.
    pub(super) fn neighbourhoods(&self, level: usize, window: Window, middle: bool) -> Neighbourhoods {
        let reach = (window.levels as usize).min(self.len() - level);
        // Beyond the next level, parents are found as those were: where a vertex's own normal meets the mesh.
        let farther: Vec<Vec<SurfacePoint>> =
            (2..reach).map(|k| points(parents(&self.levels[level].mesh, &self.levels[level + k].mesh))).collect();
        let coarser: Vec<(Ground, &[SurfacePoint])> = (1..reach)
            .map(|k| (self.ground(level + k), if k == 1 { self.parents(level) } else { farther[k - 2].as_slice() }))
            .collect();
        Neighbourhoods::new(self.ground(level), &coarser, window, middle)
    }
}

fn points(parents: Vec<Parent>) -> Vec<SurfacePoint> {
    parents.into_iter().map(|p| p.at).collect()
}

/// Directions of texture right from an n-way field over a mesh's vertices, measured against `table`: one of the n at each vertex, the one that goes on
/// from its neighbours'. From vertex to vertex, ring by ring; where two ways around a singularity meet, the choice jumps by
/// an n-th turn, over which an n-way exemplar goes on.
#[must_use]
pub fn combed_right(table: &Connection, field: &NWayField) -> Vec<DVec3> {
    let part = TAU / f64::from(field.n);
    let mut angles: Vec<f64> = field.powers.par_iter().map(|p| p.to_angle() / f64::from(field.n)).collect();
    let mut done = vec![false; angles.len()];
    let mut queue = VecDeque::new();
    for seed in 0..angles.len() as u32 {
        if std::mem::replace(&mut done[seed as usize], true) {
            continue;
        }
        queue.push_back(seed);
        while let Some(v) = queue.pop_front() {
            for there in table.neighbours(v) {
                if !std::mem::replace(&mut done[there.node as usize], true) {
                    // Its direction carried here, and how many parts of a turn it is off.
                    let carried = angles[there.node as usize] + there.turn;
                    angles[there.node as usize] += ((angles[v as usize] - carried) / part).round() * part;
                    queue.push_back(there.node);
                }
            }
        }
    }
    angles.par_iter().enumerate().map(|(v, &angle)| table.direction(v as u32, angle)).collect()
}

/// A random direction at each vertex of each level (WL 3.1).
#[must_use]
pub fn random_right(pyramid: &Pyramid, seed: u64) -> Vec<Vec<DVec3>> {
    let level = |(k, made): (usize, &crate::mesh::retile::Retiled)| {
        let mut random = Random::new(seed, 0xD1 + k as u64);
        let normals = made.mesh.vertex_normals();
        let one = |n: &glam::Vec3| {
            let frame = Frame::new(n.as_dvec3(), DVec3::X);
            let (sine, cosine) = random.range(0.0, TAU).sin_cos();
            frame.right * cosine + frame.up * sine
        };
        normals.iter().map(one).collect()
    };
    pyramid.levels.iter().enumerate().map(level).collect()
}
