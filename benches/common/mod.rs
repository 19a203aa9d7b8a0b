//! What the benches share: the meshes of four sizes, and the peak of memory.

#![allow(dead_code, reason = "no bench needs all of it")]

use glam::Vec3;
use lapped::format::Model;
use lapped::mesh::{CleanOptions, Mesh, clean};
use std::f32::consts::TAU;
use std::io::Write;
use std::time::Instant;

/// Sides of the tori: 2 n^2 faces each.
pub(crate) const SIDES: [usize; 4] = [50, 187, 374, 707];

/// A torus of 2 n^2 faces with bumps of three sizes.
pub(crate) fn bumpy_torus(n: usize) -> Model {
    let point = |i: usize, j: usize| {
        let (a, b) = (TAU * i as f32 / n as f32, TAU * j as f32 / n as f32);
        let large = 0.05 * (3.0 * a).sin() * (2.0 * b).cos();
        let middle = 0.02 * (9.0 * a + 5.0 * b).sin();
        let small = 0.005 * (31.0 * a).sin() * (23.0 * b).sin();
        let r = 0.4 + large + middle + small;
        Vec3::new((1.0 + r * b.cos()) * a.cos(), r * b.sin(), (1.0 + r * b.cos()) * a.sin())
    };
    let positions = (0..n).flat_map(|i| (0..n).map(move |j| point(i, j))).collect();
    let v = |i: usize, j: usize| ((i % n) * n + j % n) as u32;
    let faces = (0..n)
        .flat_map(|i| (0..n).map(move |j| (i, j)))
        .flat_map(|(i, j)| [[v(i, j), v(i, j + 1), v(i + 1, j)], [v(i + 1, j + 1), v(i + 1, j), v(i, j + 1)]])
        .collect();
    Model { name: format!("torus {n}"), positions, faces, ..Model::default() }
}

/// Sets the kernel's high-water mark of this process back, so that each run shows its own peak.
pub(crate) fn reset_peak() {
    if let Ok(mut file) = std::fs::OpenOptions::new().write(true).open("/proc/self/clear_refs") {
        let _ = file.write_all(b"5");
    }
}

/// The mesh that the program works on.
pub(crate) fn meshed(model: &Model) -> Mesh {
    clean(&model.positions, &model.faces, &CleanOptions::default()).expect("a mesh").mesh
}

/// A clock of the wall and of the processor.
pub(crate) struct Clock(Instant, f64);

impl Clock {
    pub(crate) fn start() -> Self {
        Self(Instant::now(), processor())
    }

    pub(crate) fn seconds(&self) -> f64 {
        self.0.elapsed().as_secs_f64()
    }

    pub(crate) fn told(&self) -> String {
        format!("{:6.2} ({:6.2})", self.0.elapsed().as_secs_f64(), processor() - self.1)
    }
}

/// Processor seconds of this process so far; 0 where the system does not say.
fn processor() -> f64 {
    let ticks = || -> Option<f64> {
        let text = std::fs::read_to_string("/proc/self/stat").ok()?;
        let fields: Vec<&str> = text.rsplit(')').next()?.split_whitespace().collect();
        Some(fields.get(11)?.parse::<f64>().ok()? + fields.get(12)?.parse::<f64>().ok()?)
    };
    ticks().unwrap_or(0.0) / 100.0
}

/// The unit sphere: an octahedron cut in four `rounds` times.
pub(crate) fn sphere(rounds: u32) -> Mesh {
    let mut positions = vec![Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z];
    let mut faces: Vec<[u32; 3]> = vec![[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]];
    for _ in 0..rounds {
        let mut middle = std::collections::BTreeMap::new();
        let mut of = |a: u32, b: u32, positions: &mut Vec<Vec3>| {
            *middle.entry((a.min(b), a.max(b))).or_insert_with(|| {
                positions.push(((positions[a as usize] + positions[b as usize]) / 2.0).normalize());
                positions.len() as u32 - 1
            })
        };
        faces = faces
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (of(a, b, &mut positions), of(b, c, &mut positions), of(c, a, &mut positions));
                [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
            })
            .collect();
    }
    Mesh::new(positions, faces).expect("an octahedron")
}
