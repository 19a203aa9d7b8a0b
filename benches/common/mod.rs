//! What the benches share: the meshes of four sizes, and the peak of memory.

#![allow(dead_code, reason = "no bench needs all of it")]

use glam::Vec3;
use lapped::format::Model;
use lapped::mesh::{CleanOptions, Mesh, clean};
use std::f32::consts::TAU;
use std::io::Write;

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
