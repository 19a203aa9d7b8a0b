//! Baking: what was baked is what the texture says, to the last texel of the gutters.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]
#![allow(clippy::print_stderr, reason = "measured figures, for whoever runs with --nocapture")]

use crate::charts::asset;
use glam::{Vec2, Vec3};
use lapped::atlas::{Atlas, AtlasTexture, BakeOptions, Baked, Frames, UnwrapOptions, bake, unwrap};
use lapped::exemplar::{Channel, ChannelSet};
use lapped::format::Record;
use lapped::job::bake::{LookOnMesh, bake_model};
use lapped::job::{BakeJob, Bound, ExemplarInput, PasteJob, Scale, Steer, paste_model};
use lapped::mesh::{Mesh, SurfacePoint};
use lapped::paste::Composite;
use lapped::progress::Silent;
use lapped::random::Random;
use lapped::render::normals::corner_normals;
use lapped::render::{DrawOptions, Grid, Stage, View, Visibility};
use lapped::surface::{SurfaceTexture, Texel};

/// A smooth function of the place in space, in every channel.
pub(crate) struct Smooth<'a> {
    pub(crate) mesh: &'a Mesh,
    pub(crate) channels: ChannelSet,
}

impl<'a> Smooth<'a> {
    pub(crate) fn new(mesh: &'a Mesh, channels: &[Channel]) -> Self {
        Self { mesh, channels: channels.iter().fold(ChannelSet::default(), |set, &c| set.with(c)) }
    }

    /// Place within the bounds, 0 to 1.
    fn place(&self, at: SurfacePoint) -> Vec3 {
        let (low, high) = self.mesh.bounds();
        ((self.mesh.position(at).as_vec3() - low) / (high - low).max_element()).clamp(Vec3::ZERO, Vec3::ONE)
    }
}

impl SurfaceTexture for Smooth<'_> {
    fn channels(&self) -> ChannelSet {
        self.channels
    }

    fn texel(&self, at: SurfacePoint, _footprint: f32) -> Texel {
        let p = self.place(at);
        let normal = self.mesh.normal(at.face).as_vec3();
        let tilt = Vec3::new((9.0 * p.y).sin(), (9.0 * p.z).cos(), (9.0 * p.x).sin()) * 0.4;
        Texel {
            base_color: 0.2 + 0.6 * p,
            alpha: 1.0,
            normal: (normal + tilt).normalize_or(normal),
            height: p.x,
            roughness: p.y,
            metallic: p.z,
            occlusion: 1.0 - p.x,
            emissive: 0.5 * p,
            opacity: 1.0 - 0.5 * p.y,
        }
    }
}

fn baked(mesh: &Mesh, size: u32, texture: &dyn SurfaceTexture, options: &BakeOptions) -> (Atlas, Frames, Baked) {
    let atlas = unwrap(mesh, &UnwrapOptions { size, ..UnwrapOptions::default() }, &Silent).unwrap();
    let normals = corner_normals(mesh, 1.0);
    let frames = if texture.channels().has(Channel::Normal) {
        Frames::with_tangents(mesh, &atlas, normals)
    } else {
        Frames::smooth(normals)
    };
    let made = bake(mesh, &atlas, &frames, texture, options, &Silent).unwrap();
    (atlas, frames, made)
}

/// The bake as a texture again.
fn again<'a>(mesh: &'a Mesh, atlas: &Atlas, frames: Frames, made: Baked) -> AtlasTexture<'a> {
    let faces = 0..mesh.face_count() as u32;
    let uv = faces.clone().map(|f| atlas.face_uv(f)).collect();
    let page = faces.map(|f| atlas.page_of(f)).collect();
    AtlasTexture::new(mesh, uv, page, made.pages.into_iter().map(|p| p.images).collect(), frames)
}

/// Points spread over the faces, some of them on corners and edges.
pub(crate) fn points(mesh: &Mesh, count: usize) -> Vec<SurfacePoint> {
    let mut random = Random::new(5, 0);
    (0..count)
        .map(|k| {
            let face = random.below(mesh.face_count() as u64) as u32;
            let (a, b) = (random.unit() as f32, random.unit() as f32);
            let bary = match k % 4 {
                0 => Vec3::X,
                1 => Vec3::new(a, 1.0 - a, 0.0),
                _ if a + b > 1.0 => Vec3::new(1.0 - a, 1.0 - b, a + b - 1.0),
                _ => Vec3::new(a, b, 1.0 - a - b),
            };
            SurfacePoint { face, bary }
        })
        .collect()
}

#[test]
fn every_channel_comes_back_at_every_point() {
    for name in ["knot", "gear"] {
        let mesh = asset(name);
        let texture = Smooth::new(&mesh, &Channel::ALL);
        let (atlas, frames, made) = baked(&mesh, 512, &texture, &BakeOptions::default());
        let found = again(&mesh, &atlas, frames, made);
        let texel = 1.0 / atlas.density(&mesh);
        let (low, high) = mesh.bounds();
        // A value changes by no more than its slope over two and a half texels, where charts are stretched most; normals by nine times that.
        let slack = (2.5 * texel) as f32 / (high - low).max_element();
        let mut angles = Vec::new();
        for at in points(&mesh, 20_000) {
            let (a, b) = (texture.texel(at, 0.0), found.texel(at, 0.0));
            for (channel, apart) in [
                (Channel::BaseColor, (a.base_color - b.base_color).abs().max_element()),
                (Channel::Height, (a.height - b.height).abs()),
                (Channel::Roughness, (a.roughness - b.roughness).abs()),
                (Channel::Metallic, (a.metallic - b.metallic).abs()),
                (Channel::Occlusion, (a.occlusion - b.occlusion).abs()),
                (Channel::Emissive, (a.emissive - b.emissive).abs().max_element()),
                (Channel::Opacity, (a.opacity - b.opacity).abs()),
            ] {
                assert!(apart < slack, "{name}: {channel:?} off by {apart} at {at:?}, two and a half texels make {slack}");
            }
            assert_eq!(b.alpha, 1.0, "{name}: nothing shows through");
            angles.push(a.normal.angle_between(b.normal));
        }
        angles.sort_by(f32::total_cmp);
        let most = angles[angles.len() * 99 / 100];
        // The normals given turn by nine radians over the model, and jump a little from face to face; where charts meet the two
        // sides are made one.
        assert!(most < 0.2, "{name}: 99 % of normals within {most} radians");
    }
}

#[test]
fn a_plain_colour_fills_the_whole_page() {
    struct Plain;
    impl SurfaceTexture for Plain {
        fn channels(&self) -> ChannelSet {
            ChannelSet::default().with(Channel::BaseColor)
        }
        fn texel(&self, _at: SurfacePoint, _footprint: f32) -> Texel {
            Texel { base_color: Vec3::new(1.0, 0.5, 0.25), alpha: 1.0, ..Texel::empty(Vec3::Z) }
        }
    }
    let mesh = asset("dragonling");
    let (_, _, made) = baked(&mesh, 512, &Plain, &BakeOptions::default());
    let image = made.pages[0].image(Channel::BaseColor).unwrap();
    for (i, texel) in image.data().as_chunks::<3>().0.iter().enumerate() {
        let apart = (Vec3::from_array(*texel) - Vec3::new(1.0, 0.5, 0.25)).abs().max_element();
        assert!(apart < 1e-4, "texel {i} is {texel:?}: background is seen");
    }
}

#[test]
fn what_no_texture_covers_is_bare() {
    struct Half<'a>(&'a Mesh);
    impl SurfaceTexture for Half<'_> {
        fn channels(&self) -> ChannelSet {
            ChannelSet::default().with(Channel::BaseColor)
        }
        fn texel(&self, at: SurfacePoint, _footprint: f32) -> Texel {
            let alpha = if self.0.position(at).x > 0.0 { 1.0 } else { 0.0 };
            Texel { base_color: Vec3::X, alpha, ..Texel::empty(Vec3::Z) }
        }
    }
    let mesh = asset("knot");
    let options = BakeOptions { bare: Vec3::Y, ..BakeOptions::default() };
    let (atlas, frames, made) = baked(&mesh, 512, &Half(&mesh), &options);
    let texel = 1.0 / atlas.density(&mesh);
    let found = again(&mesh, &atlas, frames, made);
    for at in points(&mesh, 5000) {
        let x = mesh.position(at).x;
        if x.abs() > 3.0 * texel {
            let expected = if x > 0.0 { Vec3::X } else { Vec3::Y };
            let apart = (found.texel(at, 0.0).base_color - expected).abs().max_element();
            assert!(apart < 0.02, "bare where nothing lies, at {x}: off by {apart}");
        }
    }
}

#[test]
fn chart_borders_agree_better_when_asked_to_and_texels_hardly_move() {
    let (record, bound) = pasted("dragonling", "moss", 30.0);
    drop(record);
    let texture = Composite::new(&bound.mesh, &bound.lapped);
    let run = |seams| baked(&bound.mesh, 512, &texture, &BakeOptions { seams, ..BakeOptions::default() });
    let ((.., before), (.., after)) = (run(false), run(true));
    let (b, a) = (before.statistics.seams, after.statistics.seams);
    eprintln!("borders: {b:?} then {a:?}");
    assert!(a.mean < 1.0, "the mean difference is {} of 255", a.mean);
    assert!(a.mean * 3.0 < b.mean, "{} before, {} after", b.mean, a.mean);
    let moved = |page: usize| {
        let (x, y) = (before.pages[page].image(Channel::BaseColor).unwrap(), after.pages[page].image(Channel::BaseColor).unwrap());
        let covered = x.data().as_chunks::<3>().0.iter().zip(y.data().as_chunks::<3>().0).zip(&before.pages[page].covered);
        let changes: Vec<f32> = covered
            .filter(|(_, c)| **c)
            .map(|((x, y), _)| (Vec3::from_array(*x) - Vec3::from_array(*y)).abs().max_element())
            .collect();
        changes.iter().sum::<f32>() / changes.len() as f32
    };
    assert!(moved(0) < 0.01, "texels under charts move by {} on the mean", moved(0));
}

#[test]
fn any_number_of_threads_bakes_the_same() {
    let mesh = asset("gear");
    let texture = Smooth::new(&mesh, &[Channel::BaseColor, Channel::Normal]);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| baked(&mesh, 256, &texture, &BakeOptions::default()).2)
    };
    assert!(on(1) == on(3), "the same texels");
}

/// A demo mesh with a demo exemplar pasted on it.
pub(crate) fn pasted(mesh: &str, exemplar: &str, ratio: f64) -> (Record, Bound) {
    let model = lapped::assets::mesh(mesh).unwrap();
    let input = ExemplarInput { exemplar: lapped::assets::exemplar(exemplar).unwrap(), weight: 1.0, patches: Vec::new() };
    let job = PasteJob { scale: Scale::Ratio(ratio), steer: Steer::Isotropic(None), ..PasteJob::default() };
    let record = paste_model(&model, vec![input], &job, &Silent).unwrap().record;
    let bound = Bound::new(record.clone()).unwrap();
    (record, bound)
}

#[test]
fn a_bake_looks_like_what_is_composited_at_run_time_from_eight_sides() {
    let (record, bound) = pasted("knot", "rust", 30.0);
    let texture = Composite::new(&bound.mesh, &bound.lapped);
    let size = lapped::job::bake::default_size(&bound.mesh, &bound.lapped);
    let job = BakeJob { unwrap: UnwrapOptions { size, ..UnwrapOptions::default() }, ..BakeJob::default() };
    let made = bake_model(&record.model, &bound.mesh, &bound.user_faces, &texture, &job, &Silent).unwrap();
    let clean = lapped::mesh::clean(&made.model.positions, &made.model.faces, &lapped::mesh::CleanOptions::default()).unwrap();
    let on_mesh = LookOnMesh::new(&made.model, &made.look, &clean.mesh, &clean.user_faces);
    let baked = AtlasTexture::new(&clean.mesh, on_mesh.uv, on_mesh.page, made.look.pages, on_mesh.frames);
    let stage = Stage::new(&bound.mesh, &DrawOptions::default());
    let grid = Grid { width: 320, height: 320, samples: 2 };
    for k in 0..8 {
        let view = View::degrees(45.0 * f64::from(k), if k % 2 == 0 { 20.0 } else { -20.0 });
        let seen = Visibility::new(&bound.mesh, &view.frame(&bound.mesh, 1.0), grid).unwrap();
        let (a, b) = (stage.draw(&texture, &seen), stage.draw(&baked, &seen));
        let (mut sum, mut count) = (0.0, 0);
        for (p, q) in a.rgba.as_chunks::<4>().0.iter().zip(b.rgba.as_chunks::<4>().0) {
            if p[3] > 0 {
                (0..3).for_each(|c| sum += f64::from(p[c].abs_diff(q[c])));
                count += 3;
            }
        }
        let mean = sum / f64::from(count);
        eprintln!("view {k}: {mean:.3} of 255");
        assert!(mean < 2.0, "view {k}: the mean difference is {mean} of 255");
    }
}

#[test]
fn own_coordinates_stay_beside_the_atlas() {
    let mut model = lapped::assets::mesh("gear").unwrap();
    model.uvs = Some((0..model.positions.len()).map(|v| Vec2::new(v as f32, 0.5)).collect());
    let cleaned = lapped::mesh::clean(&model.positions, &model.faces, &lapped::mesh::CleanOptions::default()).unwrap();
    let texture = Smooth::new(&cleaned.mesh, &[Channel::BaseColor]);
    let job = BakeJob { unwrap: UnwrapOptions { size: 256, mips: 0, ..UnwrapOptions::default() }, ..BakeJob::default() };
    let made = bake_model(&model, &cleaned.mesh, &cleaned.user_faces, &texture, &job, &Silent).unwrap();
    let own = made.model.uvs.unwrap();
    for (mine, theirs) in made.model.faces.iter().zip(&model.faces) {
        for k in 0..3 {
            assert_eq!(own[mine[k] as usize], Vec2::new(theirs[k] as f32, 0.5), "each corner keeps the user's coordinates");
        }
    }
}
