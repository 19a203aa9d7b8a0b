//! Detail alone, over a smooth base: exemplars do not bring their slow changes with every paste.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use crate::common::{Points, opened, pasted, sheet};
use glam::{Vec3, Vec4};
use lapped::assets;
use lapped::exemplar::{Exemplar, Image};
use lapped::format::Model;
use lapped::job::{Area, Base, ExemplarInput, JobError, PasteJob, Region, Scale, Steer, paste_model, paste_regions};
use lapped::mesh::{Mesh, SurfacePoint};
use lapped::paste::Composite;
use lapped::progress::Silent;
use lapped::random::Random;
use lapped::surface::SurfaceTexture;

const SCALE: f64 = 0.5;

fn job(base: Option<Base>) -> PasteJob {
    PasteJob { base, scale: Scale::World(SCALE), ..PasteJob::default() }
}

/// Fine noise, dark red on its left, light green on its right.
fn two_sided() -> Exemplar {
    let mut random = Random::new(2, 0);
    let hue = |x: u32| Vec3::new(0.25, 0.04, 0.05).lerp(Vec3::new(0.3, 0.6, 0.2), x as f32 / 128.0);
    Exemplar::new("two-sided", Image::from_fn(128, 128, |x, _| hue(x) * random.range(0.7, 1.3) as f32))
}

fn input(exemplar: Exemplar) -> Vec<ExemplarInput> {
    vec![ExemplarInput { exemplar, weight: 1.0, patches: Vec::new() }]
}

fn colors(mesh: &Mesh, texture: &dyn SurfaceTexture, footprint: f64, count: usize) -> Vec<(SurfacePoint, Vec3)> {
    Points::new(mesh).list(count).into_iter().map(|p| (p, texture.texel(p, footprint as f32).base_color)).collect()
}

/// A model in colours from one end of y to the other, over a face corner's own position.
fn painted(mut model: Model) -> (Model, impl Fn(Vec3) -> Vec3) {
    let range = model.positions.iter().fold([f32::MAX, f32::MIN], |[lo, hi], p| [lo.min(p.y), hi.max(p.y)]);
    let at = move |p: Vec3| Vec3::new(0.7, 0.1, 0.05).lerp(Vec3::new(0.05, 0.2, 0.6), (p.y - range[0]) / (range[1] - range[0]));
    model.colors = Some(model.positions.iter().map(|&p| at(p).extend(1.0)).collect::<Vec<Vec4>>());
    (model, at)
}

#[test]
fn slow_changes_no_longer_step_where_pastes_end() {
    let model = sheet(48, 3.0);
    // Colours a sixteenth of an exemplar wide, pairs of them next to each other.
    let (wide, apart) = (SCALE / 16.0, 0.15 * SCALE as f32);
    let steps = |base| {
        let done = paste_model(&model, input(two_sided()), &job(base), &Silent).unwrap();
        let texture = Composite::new(&done.mesh, &done.lapped);
        let cell = 3.0 / 48.0;
        let point = |p: Vec3| {
            let [i, j] = [p.x, p.y].map(|c| ((c / cell) as u32).min(47));
            let [x, y] = [p.x / cell - i as f32, p.y / cell - j as f32];
            let lower = 2 * (j * 48 + i);
            if x >= y {
                SurfacePoint { face: lower, bary: Vec3::new(1.0 - x, x - y, y) }
            } else {
                SurfacePoint { face: lower + 1, bary: Vec3::new(1.0 - y, x, y - x) }
            }
        };
        let mut random = Random::new(4, 0);
        let mut place = || random.range(0.2, 2.6) as f32;
        let mut step = || {
            let at = Vec3::new(place(), place(), 0.0);
            let [a, b] = [at, at + Vec3::new(apart, 0.0, 0.0)].map(|p| texture.texel(point(p), wide as f32).base_color);
            a.distance(b)
        };
        let mut all: Vec<f32> = (0..4000).map(|_| step()).collect();
        all.sort_by(f32::total_cmp);
        // Where pastes of different sides meet.
        all[all.len() * 97 / 100]
    };
    let (own, detail) = (steps(None), steps(Some(Base::Own)));
    assert!(detail < 0.7 * own, "the largest steps were {own}, over a base {detail}");
}

#[test]
fn an_own_base_keeps_the_exemplars_colours() {
    let exemplar = two_sided();
    let mean = exemplar.channel(lapped::exemplar::Channel::BaseColor).unwrap().mean();
    let done = paste_model(
        &assets::mesh("dragonling").unwrap(),
        input(exemplar),
        &PasteJob { base: Some(Base::Own), ..PasteJob::default() },
        &Silent,
    )
    .unwrap();
    let found = colors(&done.mesh, &Composite::new(&done.mesh, &done.lapped), 0.0, 4000);
    let found = found.iter().map(|(_, c)| *c).sum::<Vec3>() / 4000.0;
    assert!(((found - mean) / mean).abs().max_element() < 0.15, "{found} on the surface, {mean} in the exemplar");
}

#[test]
fn vertex_colours_show_under_detail_whatever_the_exemplar_is_coloured() {
    let (model, colour) = painted(assets::mesh("dragonling").unwrap());
    let done =
        paste_model(&model, input(two_sided()), &PasteJob { base: Some(Base::Vertex), ..PasteJob::default() }, &Silent).unwrap();
    let texture = Composite::new(&done.mesh, &done.lapped);
    let ratios: Vec<Vec3> =
        colors(&done.mesh, &texture, 0.0, 6000).iter().map(|(p, c)| *c / colour(done.mesh.position(*p).as_vec3())).collect();
    let mean = ratios.iter().sum::<Vec3>() / ratios.len() as f32;
    assert!((mean - 1.0).abs().max_element() < 0.03, "detail lightens by {mean}");
    let varies = (ratios.iter().map(|r| (r.y - mean.y).powi(2)).sum::<f32>() / ratios.len() as f32).sqrt();
    // 0.3 / sqrt 3 at pixels, two thirds of it between them.
    assert!((0.1..0.13).contains(&varies), "noise of a third either way varies by {varies}");
}

#[test]
fn bases_go_through_the_file_on_faces_that_were_cut_as_well() {
    let (model, _) = painted(sheet(2, 3.0));
    let done = paste_model(&model, input(two_sided()), &job(Some(Base::Vertex)), &Silent).unwrap();
    assert!(done.record.source_face.is_some(), "faces were cut");
    let back = opened(&done.record);
    let [here, there] =
        [(&done.mesh, &done.lapped), (&back.mesh, &back.lapped)].map(|(m, l)| colors(m, &Composite::new(m, l), 0.0, 500));
    let most = here.iter().zip(&there).map(|((_, a), (_, b))| (*a - *b).abs().max_element()).fold(0.0, f32::max);
    assert!(most < 0.02, "colours differ by {most}");
}

#[test]
fn regions_have_bases_of_their_own() {
    let (model, _) = painted(assets::mesh("vase").unwrap());
    let region = |name: &str, area: Area, base| Region {
        name: name.to_owned(),
        area,
        inputs: input(two_sided()),
        job: PasteJob { base, steer: Steer::Isotropic(None), ..PasteJob::default() },
        ..Region::default()
    };
    let red = Vec3::new(0.6, 0.0, 0.0);
    let all = |base| region("all", Area::Everything, base);
    let blue = || region("blue", Area::Component(2), Some(Base::Color(red)));
    let done = paste_regions(&model, vec![all(None), blue()], &Silent).unwrap();
    let [below, above] = &done.lapped.layers[..] else { panic!("two layers") };
    assert!(below.base.is_empty() && above.base.len() == done.mesh.face_count());
    let alone = paste_regions(&model, vec![all(None), region("blue", Area::Component(2), None)], &Silent).unwrap();
    assert_eq!(alone.lapped.layers[1].pastes, above.pastes, "nothing else changes");
    let back = opened(&done.record);
    assert_eq!(back.lapped.layers, done.lapped.layers, "through the file");
}

#[test]
fn without_a_base_nothing_is_written_and_without_colours_vertex_is_refused() {
    let model = sheet(8, 3.0);
    let plain = pasted(&model, "moss", &job(None));
    assert!(plain.lapped.layers.is_empty());
    let refused = paste_model(&model, input(two_sided()), &job(Some(Base::Vertex)), &Silent);
    assert!(matches!(refused, Err(JobError::NoBase)), "{refused:?}");
}
