//! What the tests of pasting share: demo assets, jobs, the way through the file, random points, and a second opinion on
//! alpha.

#![allow(dead_code, reason = "each test file uses its part")]
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

use glam::{DVec2, DVec3, Vec2, Vec3};
use lapped::exemplar::{PatchOptions, PatchSource, PatchSpec, TexturePatch, Wrap, make_patches};
use lapped::field::{Guide, TangentField, default_scale};
use lapped::format::{Model, Record, read_record, write_record};
use lapped::job::{Bound, ExemplarInput, PasteJob, Pasted, paste_model};
use lapped::mesh::{CleanOptions, Mesh, SurfacePoint, clean};
use lapped::paste::{FaceLists, LappedTexture};
use lapped::progress::Silent;
use lapped::random::Random;
use rayon::prelude::*;

/// A demo mesh as a mesh.
pub(crate) fn asset(name: &str) -> Mesh {
    meshed(&lapped::assets::mesh(name).unwrap())
}

/// A model's mesh.
pub(crate) fn meshed(model: &Model) -> Mesh {
    clean(&model.positions, &model.faces, &CleanOptions::default()).unwrap().mesh
}

/// A model from positions and faces.
pub(crate) fn model_of(positions: Vec<Vec3>, faces: Vec<[u32; 3]>) -> Model {
    Model { positions, faces, ..Model::default() }
}

/// A flat sheet of `n` by `n` quads over [0, size]^2 in the plane z = 0, facing +z.
pub(crate) fn sheet(n: u32, size: f32) -> Model {
    let mut model = Model::default();
    for j in 0..=n {
        for i in 0..=n {
            model.positions.push(Vec3::new(i as f32, j as f32, 0.0) * (size / n as f32));
            if i < n && j < n {
                let a = j * (n + 1) + i;
                model.faces.extend([[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]);
            }
        }
    }
    model
}

/// A demo exemplar with patches from these sources; the default ones if there are none.
pub(crate) fn input(name: &str, sources: &[PatchSource]) -> ExemplarInput {
    let patches = sources.iter().map(|source| PatchSpec { source: source.clone(), weight: 1.0 }).collect();
    ExemplarInput { exemplar: lapped::assets::exemplar(name).unwrap(), weight: 1.0, patches }
}

/// The patches of one source, cut from a demo exemplar.
pub(crate) fn patches(exemplar: &str, source: PatchSource) -> Vec<TexturePatch> {
    let exemplar = lapped::assets::exemplar(exemplar).unwrap();
    make_patches(&exemplar, 0, &[PatchSpec { source, weight: 1.0 }], &PatchOptions::default()).unwrap().0
}

/// Does a job with one exemplar and default patches.
pub(crate) fn pasted(model: &Model, exemplar: &str, job: &PasteJob) -> Pasted {
    paste_model(model, vec![input(exemplar, &[])], job, &Silent).unwrap()
}

/// The record as written and read again.
pub(crate) fn through_file(record: &Record) -> Record {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("record.glb");
    write_record(&path, record).unwrap();
    read_record(&path).unwrap()
}

/// The record's lapped texture as whoever opens the written file sees it.
pub(crate) fn opened(record: &Record) -> Bound {
    Bound::new(through_file(record)).unwrap()
}

/// Points drawn by area. Points number `chunk * CHUNK ..` come from stream `chunk`, so that chunks can be drawn in
/// parallel.
pub(crate) struct Points<'a> {
    mesh: &'a Mesh,
    sums: Vec<f64>,
}

pub(crate) const CHUNK: usize = 10_000;

impl<'a> Points<'a> {
    pub(crate) fn new(mesh: &'a Mesh) -> Self {
        let mut sum = 0.0;
        let mut add = |f: u32| {
            sum += mesh.area(f);
            sum
        };
        Self { mesh, sums: (0..mesh.face_count() as u32).map(&mut add).collect() }
    }

    /// The `count` points of a chunk.
    pub(crate) fn chunk(&self, chunk: u64, count: usize) -> impl Iterator<Item = SurfacePoint> + '_ {
        let mut random = Random::new(0x0dd5, chunk);
        let whole = self.sums[self.sums.len() - 1];
        (0..count).map(move |_| {
            let at = random.range(0.0, whole);
            let face = self.sums.partition_point(|&s| s <= at).min(self.sums.len() - 1);
            let (root, v) = (random.unit().sqrt(), random.unit());
            let bary = [1.0 - root, root * (1.0 - v), root * v].map(|b| b as f32);
            SurfacePoint { face: face as u32, bary: Vec3::from(bary) }
        })
    }

    /// `count` points in one list.
    pub(crate) fn list(&self, count: usize) -> Vec<SurfacePoint> {
        (0..count.div_ceil(CHUNK) as u64).flat_map(|k| self.chunk(k, CHUNK.min(count - k as usize * CHUNK))).collect()
    }
}

/// Where a paste shows its exemplar under a pixel of its mask.
pub(crate) fn exemplar_place(lapped: &LappedTexture, paste: u32, pixel: DVec2) -> Vec2 {
    let paste = &lapped.pastes[paste as usize];
    let patch = &lapped.patches[paste.patch as usize];
    let exemplar = &lapped.exemplars[patch.exemplar as usize];
    let middle = glam::UVec2::from(patch.mask.size()).as_vec2() * 0.5;
    let turned = paste.turn.rotation().rotate(pixel.as_vec2() - middle) + middle;
    let place = turned + glam::IVec2::from(patch.origin).as_vec2() + paste.offset;
    match exemplar.wrap {
        Wrap::Repeat => place.rem_euclid(Vec2::from(exemplar.size().map(|s| s as f32))),
        Wrap::Clamp => place,
    }
}

/// Alpha of a mask image at continuous pixel coordinates: bilinear between pixel centres, 0 beyond them.
pub(crate) fn mask_alpha(patch: &TexturePatch, pixel: DVec2) -> f64 {
    let image = patch.mask.finest();
    let [w, h] = image.size();
    let p = pixel - 0.5;
    let low = p.floor();
    let at = |x: f64, y: f64| {
        let inside = x >= 0.0 && y >= 0.0 && x < f64::from(w) && y < f64::from(h);
        if inside { f64::from(image.data()[y as usize * w as usize + x as usize]) } else { 0.0 }
    };
    let t = p - low;
    let top = at(low.x, low.y) * (1.0 - t.x) + at(low.x + 1.0, low.y) * t.x;
    let bottom = at(low.x, low.y + 1.0) * (1.0 - t.x) + at(low.x + 1.0, low.y + 1.0) * t.x;
    top * (1.0 - t.y) + bottom * t.y
}

/// Alpha of a paste at a pixel of its mask: the mask's, and what its cut leaves, as docs/record.md says.
pub(crate) fn paste_alpha(lapped: &LappedTexture, paste: u32, pixel: DVec2) -> f64 {
    let paste = &lapped.pastes[paste as usize];
    let patch = &lapped.patches[paste.patch as usize];
    let alpha = mask_alpha(patch, pixel);
    let Some(cut) = &paste.cut else { return alpha };
    let size = patch.mask.size().map(f64::from);
    let d = pixel / DVec2::from(size) * 2.0 - 1.0;
    let r = d.x.abs().max(d.y.abs());
    let way = if d.x == r {
        16.0 * (1.0 + d.y / r)
    } else if d.y == r {
        32.0 + 16.0 * (1.0 - d.x / r)
    } else if d.x == -r {
        64.0 + 16.0 * (1.0 - d.y / r)
    } else {
        96.0 + 16.0 * (1.0 + d.x / r)
    };
    let step = |way: f64, byte: usize| f64::from(cut.steps()[way as usize % 128][byte]);
    let between = |byte: usize| step(way, byte) + way.fract() * (step(way + 1.0, byte) - step(way, byte));
    let (distance, width) = (between(0) / 204.0, (between(1) + 1.0) / 512.0);
    alpha * ((distance - r) / width.max(2.0 / size[0].min(size[1])) + 0.5).clamp(0.0, 1.0)
}

/// Mask pixel of a paste at a point of its face number `slot`.
pub(crate) fn mask_pixel(lapped: &LappedTexture, paste: u32, slot: u32, bary: Vec3) -> DVec2 {
    let paste = &lapped.pastes[paste as usize];
    let [w, h] = lapped.patches[paste.patch as usize].mask.size();
    let uv: [Vec2; 3] = paste.uv[slot as usize];
    let uv = (0..3).map(|k| uv[k].as_dvec2() * f64::from(bary[k])).sum::<DVec2>();
    uv * DVec2::new(f64::from(w), f64::from(h))
}

/// Alpha of all pastes together at a point, by the definition: 1 minus the product of what each lets through.
pub(crate) fn alpha_at(lapped: &LappedTexture, lists: &FaceLists, at: SurfacePoint) -> f64 {
    let through = |&(paste, slot): &(u32, u32)| 1.0 - paste_alpha(lapped, paste, mask_pixel(lapped, paste, slot, at.bary));
    1.0 - lists.of(at.face).iter().map(through).product::<f64>()
}

/// The least alpha of `count` random points, and where it is.
pub(crate) fn least_alpha(mesh: &Mesh, lapped: &LappedTexture, count: usize) -> (f64, DVec3) {
    let lists = FaceLists::new(mesh.face_count(), &lapped.pastes);
    let points = Points::new(mesh);
    let worst = |a: (f64, DVec3), b: (f64, DVec3)| if b.0 < a.0 { b } else { a };
    (0..count.div_ceil(CHUNK))
        .into_par_iter()
        .map(|k| {
            let chunk = points.chunk(k as u64, CHUNK.min(count - k * CHUNK));
            chunk.map(|at| (alpha_at(lapped, &lists, at), mesh.position(at))).fold((1.0, DVec3::ZERO), worst)
        })
        .reduce(|| (1.0, DVec3::ZERO), worst)
}

/// Faces drawn by all pastes together, per face of the mesh.
pub(crate) fn draws_per_face(mesh: &Mesh, lapped: &LappedTexture) -> f64 {
    lapped.pastes.iter().map(|p| p.faces.len()).sum::<usize>() as f64 / mesh.face_count() as f64
}

/// The value below which this share of weighted values lies.
pub(crate) fn quantile(values: &mut [(f64, f64)], share: f64) -> f64 {
    values.sort_by(|a, b| a.0.total_cmp(&b.0));
    let total: f64 = values.iter().map(|v| v.1).sum();
    let mut sum = 0.0;
    for &(value, weight) in values.iter() {
        sum += weight;
        if sum >= share * total {
            return value;
        }
    }
    f64::NAN
}

/// A directed guide along +Y, with poles wherever the surface faces up or down.
pub(crate) fn along_y(mesh: &Mesh) -> Guide {
    let scale = default_scale(mesh, 40.0, 1.0);
    let up = |f: u32| {
        let normal = mesh.normal(f);
        let up = DVec3::Y - normal * normal.y;
        (up.normalize_or(normal.any_orthonormal_vector()) * scale).as_vec3()
    };
    Guide::Directed(TangentField::along((0..mesh.face_count() as u32).map(up).collect()))
}

/// A torus about the z axis with a tube of 0.35.
pub(crate) fn torus() -> Model {
    let (n, m) = (48_u32, 24_u32);
    let mut model = Model::default();
    for i in 0..n {
        for j in 0..m {
            let (u, v) = (std::f32::consts::TAU * i as f32 / n as f32, std::f32::consts::TAU * j as f32 / m as f32);
            let r = 1.0 + 0.35 * v.cos();
            model.positions.push(Vec3::new(r * u.cos(), r * u.sin(), 0.35 * v.sin()));
            let at = |i: u32, j: u32| (i % n) * m + j % m;
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            model.faces.extend([[a, b, c], [a, c, d]]);
        }
    }
    model
}
