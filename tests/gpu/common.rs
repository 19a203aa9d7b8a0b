//! Adapters, subjects and comparisons that the tests of the GPU renderer share. Without an adapter they fail.

#![allow(dead_code, reason = "each test file uses its part")]
#![allow(clippy::panic, clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

use glam::{DVec3, Vec2, Vec3};
use lapped::exemplar::{Exemplar, Hull, Image, MipChain, TexturePatch};
use lapped::format::Model;
use lapped::job::{ExemplarInput, PasteJob, Pasted, Scale, Steer, paste_model};
use lapped::mesh::Mesh;
use lapped::paste::{AGREES, LappedTexture, Paste, Turn};
use lapped::progress::Silent;
use lapped::render::gpu::{Gpu, GpuOptions, Renderer, RendererOptions};
use lapped::render::{Camera, Grid, Picture, Visibility};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

#[path = "../common/grid.rs"]
mod grid;
pub(crate) use grid::flat;

/// One renderer on each interface, for one test at a time: on OpenGL threads that draw at once wait for each other, and wgpu
/// takes a long wait for a deadlock.
pub(crate) struct Renderers {
    both: &'static [Renderer; 2],
    _alone: MutexGuard<'static, ()>,
}

impl std::ops::Deref for Renderers {
    type Target = [Renderer; 2];

    fn deref(&self) -> &[Renderer; 2] {
        self.both
    }
}

impl IntoIterator for Renderers {
    type Item = &'static Renderer;
    type IntoIter = Each;

    fn into_iter(self) -> Each {
        Each { left: self.both.iter(), _all: self }
    }
}

/// The renderers one by one; nobody else has them meanwhile.
pub(crate) struct Each {
    left: std::slice::Iter<'static, Renderer>,
    _all: Renderers,
}

impl Iterator for Each {
    type Item = &'static Renderer;

    fn next(&mut self) -> Option<&'static Renderer> {
        self.left.next()
    }
}

/// One renderer on each interface. Both must be there.
pub(crate) fn renderers() -> Renderers {
    static BOTH: OnceLock<[Renderer; 2]> = OnceLock::new();
    static ALONE: Mutex<()> = Mutex::new(());
    let alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    Renderers { both: BOTH.get_or_init(|| ["vulkan", "gl"].map(|name| renderer(name, None))), _alone: alone }
}

/// A renderer on an interface, kept to limits.
pub(crate) fn renderer(name: &str, limits: Option<wgpu::Limits>) -> Renderer {
    let gpu = Gpu::new(&GpuOptions { adapter: Some(name.to_owned()), limits });
    let gpu = gpu.unwrap_or_else(|e| panic!("these tests need a {name} adapter, software will do: {e}"));
    Renderer::new(gpu, RendererOptions::default()).unwrap()
}

/// A mesh of the assets covered with exemplars of the assets.
pub(crate) fn pasted(mesh: &str, exemplars: &[&str], ratio: f64, up: bool) -> Pasted {
    pasted_with(mesh, exemplars.iter().map(|name| lapped::assets::exemplar(name).unwrap()).collect(), ratio, up)
}

/// A mesh of the assets covered with exemplars.
pub(crate) fn pasted_with(mesh: &str, exemplars: Vec<Exemplar>, ratio: f64, up: bool) -> Pasted {
    pasted_model(&lapped::assets::mesh(mesh).unwrap(), exemplars, ratio, up)
}

/// A model covered with exemplars.
pub(crate) fn pasted_model(model: &Model, exemplars: Vec<Exemplar>, ratio: f64, up: bool) -> Pasted {
    let inputs = exemplars.into_iter().map(|exemplar| ExemplarInput { exemplar, weight: 1.0, patches: Vec::new() }).collect();
    let steer = if up { Steer::Up(DVec3::Y) } else { Steer::Isotropic(None) };
    let job = PasteJob { scale: Scale::Ratio(ratio), steer, ..PasteJob::default() };
    paste_model(model, inputs, &job, &Silent).unwrap()
}

/// How two pictures differ, in steps of 1/255: the mean of red, green and blue, and a difference in alpha as one of them.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Difference {
    /// Mean over pixels of the surface away from its outlines.
    pub(crate) inside: f64,
    /// Mean over the pixels within one of an outline.
    pub(crate) outline: f64,
    /// Mean over the rest.
    pub(crate) outside: f64,
    /// The largest of all.
    pub(crate) most: u8,
}

/// Compares pictures of what a camera sees. Outlines are where the mesh ends or one part of it hides another.
pub(crate) fn compare(mesh: &Mesh, camera: &Camera, grid: Grid, a: &Picture, b: &Picture) -> Difference {
    assert_eq!((a.width, a.height), (b.width, b.height), "pictures of one size");
    let seen = Visibility::new(mesh, camera, grid).unwrap();
    let [across, down] = grid.size();
    let depth: Vec<f64> =
        (0..across * down).map(|i| seen.hit(mesh, i % across, i / across).map_or(f64::INFINITY, |hit| hit.depth)).collect();
    let n = grid.samples as usize;
    let (mut sums, mut counts, mut most) = ([0.0; 3], [0.0_f64; 3], 0);
    for y in 0..grid.height as usize {
        for x in 0..grid.width as usize {
            let rows = (y * n).saturating_sub(n)..((y + 2) * n).min(down);
            let columns = (x * n).saturating_sub(n)..((x + 2) * n).min(across);
            let around = rows.flat_map(|v| columns.clone().map(move |u| (u, v))).map(|(u, v)| depth[v * across + u]);
            let (near, far) = around.fold((f64::INFINITY, 0.0_f64), |(near, far), d| (near.min(d), far.max(d)));
            let kind = match () {
                () if near == f64::INFINITY => 2,
                () if far > 1.02 * near => 1,
                () => 0,
            };
            let (p, q) = (a.pixel(x as u32, y as u32), b.pixel(x as u32, y as u32));
            for k in 0..4 {
                sums[kind] += f64::from(p[k].abs_diff(q[k])) / 3.0;
                most = most.max(p[k].abs_diff(q[k]));
            }
            counts[kind] += 1.0;
        }
    }
    let mean = |kind: usize| sums[kind] / counts[kind].max(1.0);
    Difference { inside: mean(0), outline: mean(1), outside: mean(2), most }
}

/// An exemplar of coloured checks.
pub(crate) fn checks(size: u32) -> Exemplar {
    let pixel =
        |x: u32, y: u32| Vec3::new(0.1 + 0.8 * ((x / 4 + y / 4) % 2) as f32, x as f32 / size as f32, y as f32 / size as f32);
    Exemplar::new("checks", Image::from_fn(size, size, pixel))
}

/// A round texture patch of `side` pixels, its corner at `origin`.
pub(crate) fn round_patch(side: u32, origin: [i32; 2]) -> TexturePatch {
    let middle = 0.5 * side as f32;
    let alpha = |x: u32, y: u32| {
        let d = Vec2::new(x as f32 + 0.5 - middle, y as f32 + 0.5 - middle).length();
        ((middle - 1.0 - d) / 2.0).clamp(0.0, 1.0)
    };
    TexturePatch {
        exemplar: 0,
        origin,
        mask: MipChain::mask(Image::grey_from_fn(side, side, alpha)),
        hull: Hull::new(vec![Vec2::ZERO, Vec2::new(side as f32, 0.0), Vec2::splat(side as f32), Vec2::new(0.0, side as f32)]),
        centre: Vec2::splat(middle),
        weight: 1.0,
        slides: false,
    }
}

/// `count` pastes on the flat grid, each on a few faces around a place of its own.
pub(crate) fn scattered(mesh: &Mesh, patches: Vec<TexturePatch>, exemplar: Exemplar, count: usize) -> LappedTexture {
    let faces = mesh.face_count();
    let paste = |k: usize| {
        let first = (k * 7919) % faces;
        let chosen: Vec<u32> = [first, first ^ 1].into_iter().filter(|&f| f < faces).map(|f| f as u32).collect();
        let centre = mesh.centroid(first as u32);
        let size = 2.5 * mesh.area(first as u32).sqrt();
        let uv = |f: u32| {
            mesh.corners(f).map(|p| {
                let d = (p - centre) / size;
                Vec2::new(0.5 + d.x as f32, 0.5 - d.y as f32)
            })
        };
        Paste {
            patch: (k % patches.len()) as u16,
            uv: chosen.iter().map(|&f| uv(f)).collect(),
            faces: chosen,
            offset: Vec2::ZERO,
            turn: Turn::NONE,
            cut: None,
            agreement: AGREES,
        }
    };
    let pastes = (0..count).map(paste).collect();
    LappedTexture { exemplars: vec![exemplar], patches, pastes, layers: Vec::new() }
}
