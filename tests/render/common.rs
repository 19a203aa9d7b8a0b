//! Meshes and textures that the renderer's tests share.

#![allow(dead_code, reason = "each test file uses its part")]
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

use glam::{DVec3, Vec3};
use lapped::exemplar::{Channel, ChannelSet};
use lapped::mesh::{CleanOptions, Mesh, SurfacePoint, clean};
use lapped::surface::{SurfaceTexture, Texel};

#[path = "../common/grid.rs"]
mod grid;
pub(crate) use grid::flat;

/// A closed surface: a torus or, with `tube` 0, a sphere, from a grid of `n` by `n` quads.
#[must_use]
pub(crate) fn round(n: u32, tube: f64) -> Mesh {
    let mut positions = Vec::new();
    let mut faces = Vec::new();
    for i in 0..n {
        for j in 0..n {
            let (u, v) = (std::f64::consts::TAU * f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
            let p = if tube > 0.0 {
                let v = std::f64::consts::TAU * v;
                let r = 1.0 + tube * v.cos();
                DVec3::new(r * u.sin(), -tube * v.sin(), r * u.cos())
            } else {
                // Rows from pole to pole; the poles weld into one vertex each.
                let v = std::f64::consts::PI * f64::from(j) / f64::from(n - 1);
                let r = if j == 0 || j == n - 1 { 0.0 } else { v.sin() };
                DVec3::new(r * u.sin(), v.cos(), r * u.cos())
            };
            positions.push(p.as_vec3());
            let at = |i: u32, j: u32| (i % n) * n + j % n;
            if tube > 0.0 || j + 1 < n {
                let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
                faces.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    clean(&positions, &faces, &CleanOptions::default()).unwrap().mesh
}

/// The same faces with moved positions.
#[must_use]
pub(crate) fn moved(mesh: &Mesh, place: impl Fn(DVec3) -> DVec3) -> Mesh {
    let positions = mesh.positions.iter().map(|p| place(p.as_dvec3()).as_vec3()).collect();
    Mesh::new(positions, mesh.faces.clone()).unwrap()
}

/// A mesh of the corpus, or `None` if there is no corpus here.
#[must_use]
pub(crate) fn corpus(name: &str) -> Option<Mesh> {
    let path = crate::folder::corpus()?.join("meshes").join(name);
    let model = lapped::format::read_model(&path).unwrap();
    Some(clean(&model.positions, &model.faces, &CleanOptions::default()).unwrap().mesh)
}

/// A texture from a function of the surface point.
pub(crate) struct Painted<F> {
    pub(crate) channels: ChannelSet,
    pub(crate) paint: F,
}

impl<F: Fn(SurfacePoint, f32) -> Texel + Sync> SurfaceTexture for Painted<F> {
    fn channels(&self) -> ChannelSet {
        self.channels
    }
    fn texel(&self, at: SurfacePoint, footprint: f32) -> Texel {
        (self.paint)(at, footprint)
    }
}

/// One base colour everywhere.
pub(crate) fn plain(mesh: &Mesh, colour: Vec3) -> Painted<impl Fn(SurfacePoint, f32) -> Texel + Sync> {
    let normals: Vec<Vec3> = (0..mesh.face_count() as u32).map(|f| mesh.normal(f).as_vec3()).collect();
    let paint = move |at: SurfacePoint, _| Texel { base_color: colour, alpha: 1.0, ..Texel::empty(normals[at.face as usize]) };
    Painted { channels: ChannelSet::default().with(Channel::BaseColor), paint }
}

/// Checks in space, `count` along the diagonal of the bounds.
pub(crate) fn checks(mesh: &Mesh, count: f64) -> Painted<impl Fn(SurfacePoint, f32) -> Texel + Sync + '_> {
    let (low, high) = mesh.bounds();
    let size = (high - low).as_dvec3().length() / count;
    let paint = move |at: SurfacePoint, _| {
        let cell = ((mesh.position(at) - low.as_dvec3()) / size + 0.123).floor();
        let odd = (cell.element_sum() as i64).rem_euclid(2) as f32;
        Texel { base_color: Vec3::splat(0.1 + 0.5 * odd), alpha: 1.0, ..Texel::empty(mesh.normal(at.face).as_vec3()) }
    };
    Painted { channels: ChannelSet::default().with(Channel::BaseColor), paint }
}
