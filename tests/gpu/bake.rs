//! A bake whose pastes a graphics adapter composites is the processor's.

#![allow(
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "helpers of tests fail as tests do, and figures are shown when asked for"
)]

use crate::common::{pasted_with, renderer, renderers};
use glam::Vec3;
use lapped::atlas::{Atlas, AtlasError, BakeOptions, Baked, Frames, UnwrapOptions, bake, unwrap};
use lapped::exemplar::{Channel, Exemplar, Image, srgb};
use lapped::job::{BakeJob, Bound, Pasted, bake_record};
use lapped::paste::{CompositeBackend, Compositing, LappedTexture, Layer, base_color};
use lapped::progress::Silent;
use lapped::render::gpu::{Gpu, GpuComposite};
use lapped::render::normals::corner_normals;
use std::sync::Arc;

/// An exemplar with every channel.
fn everything() -> Exemplar {
    let mut exemplar = lapped::assets::exemplar("scales").unwrap();
    let [w, h] = exemplar.size();
    let wave = |k: f32| move |x: u32, y: u32| 0.5 + 0.5 * (k * x as f32).sin() * (k * y as f32).cos();
    for (channel, k) in [(Channel::Roughness, 0.1), (Channel::Metallic, 0.05), (Channel::Occlusion, 0.2), (Channel::Opacity, 0.04)]
    {
        exemplar.set(channel, Image::grey_from_fn(w, h, wave(k))).unwrap();
    }
    exemplar.set(Channel::Emissive, Image::from_fn(w, h, |x, y| Vec3::new(0.3, 0.1, 0.0) * wave(0.07)(x, y))).unwrap();
    exemplar
}

/// Everything, beside a normal map without heights and a plain colour, in two layers of which one is mixed by weights; some of
/// the mesh stays bare.
fn mixed() -> Pasted {
    let mut flatter = lapped::assets::exemplar("weave").unwrap();
    flatter.remove(Channel::Height);
    let mut done = pasted_with("knot", vec![everything(), flatter, lapped::assets::exemplar("rust").unwrap()], 40.0, true);
    let pastes = &mut done.lapped.pastes;
    pastes.truncate(pastes.len() * 4 / 5);
    let below = pastes.len() / 2;
    let (low, high) = done.mesh.bounds();
    let weight = |v: u32| (1.5 * (done.mesh.positions[v as usize].x - low.x) / (high.x - low.x)).clamp(0.2, 1.0);
    let weights = done.mesh.faces.iter().map(|f| f.map(weight)).collect();
    let layer = |pastes: usize, weights| Layer { pastes: pastes as u32, weights, ..Layer::default() };
    done.lapped.layers = vec![layer(below, Vec::new()), layer(done.lapped.pastes.len() - below, weights)];
    let hue = |k: usize| base_color(Vec3::new(0.1, 0.3, 0.6) * (0.4 + 0.2 * k as f32));
    done.lapped.layers[0].base = vec![[hue(0), hue(1), hue(2)]; done.mesh.face_count()];
    done
}

fn charts(pasted: &Pasted) -> (Atlas, Frames) {
    let options = UnwrapOptions { size: 256, mips: 0, ..UnwrapOptions::default() };
    let atlas = unwrap(&pasted.mesh, &options, &Silent).unwrap();
    let frames = Frames::with_tangents(&pasted.mesh, &atlas, corner_normals(&pasted.mesh, 1.0));
    (atlas, frames)
}

fn baked(pasted: &Pasted, (atlas, frames): &(Atlas, Frames), by: &Compositing, samples: u32) -> Baked {
    let texture = by.of(&pasted.mesh, &pasted.lapped).unwrap();
    let options = BakeOptions { samples, seams: false, ..BakeOptions::default() };
    bake(&pasted.mesh, atlas, frames, texture.as_ref(), &options, &Silent).unwrap()
}

fn on(gpu: &Gpu) -> Compositing {
    Compositing(Some(Arc::new(GpuComposite::new(gpu.clone()).unwrap())))
}

/// Differences of two images, of 255 (as displayed, if they are of light): the mean, and what 99.9 % of numbers stay below.
fn apart(channel: Channel, a: &Image, b: &Image) -> (f64, f64) {
    let light = matches!(channel, Channel::BaseColor | Channel::Emissive);
    let shown = |v: f32| match channel {
        Channel::Normal => 0.5 * v,
        _ if light => srgb::encode(v),
        _ => v,
    };
    let mut all: Vec<f64> = a.data().iter().zip(b.data()).map(|(&a, &b)| 255.0 * f64::from((shown(a) - shown(b)).abs())).collect();
    all.sort_by(f64::total_cmp);
    (all.iter().sum::<f64>() / all.len() as f64, all[all.len() * 999 / 1000])
}

#[test]
#[ignore = "needs graphics adapters, software will do: cargo test --test gpu -- --include-ignored"]
fn every_channel_of_every_texel_is_the_processors() {
    let pasted = mixed();
    let charts = charts(&pasted);
    for samples in [1, 2] {
        let expected = baked(&pasted, &charts, &Compositing::default(), samples);
        for renderer in renderers() {
            let adapter = renderer.gpu().adapter();
            let found = baked(&pasted, &charts, &on(renderer.gpu()), samples);
            assert_eq!(found.statistics.samples, expected.statistics.samples, "{adapter}: the same points");
            for (page, other) in found.pages.iter().zip(&expected.pages) {
                assert!(page.covered == other.covered, "{adapter}: the same texels");
                for ((channel, a), (_, b)) in page.images.iter().zip(&other.images) {
                    let (mean, most) = apart(*channel, a, b);
                    println!("{adapter}, {samples}: {channel:?} {mean:.3} {most:.2} of 255");
                    assert!(mean < 0.4 && most < 5.0, "{adapter}: {channel:?} differs by {mean}, {most} at the worst thousandth");
                }
            }
        }
    }
}

#[test]
#[ignore = "needs graphics adapters, software will do: cargo test --test gpu -- --include-ignored"]
fn lists_in_several_pages_bake_the_same() {
    let pasted = mixed();
    let charts = charts(&pasted);
    let whole = renderer("vulkan", None);
    let mut limits = whole.gpu().limits.clone();
    limits.max_storage_buffer_binding_size = 64 << 10;
    limits.max_buffer_size = 1 << 20;
    let split = renderer("vulkan", Some(limits));
    let [a, b] = [&whole, &split].map(|r| baked(&pasted, &charts, &on(r.gpu()), 1));
    assert!(a.pages == b.pages, "cutting the tables changes nothing");
}

#[test]
#[ignore = "needs graphics adapters, software will do: cargo test --test gpu -- --include-ignored"]
fn a_record_is_baked_on_an_adapter_and_a_lost_one_is_an_error() {
    let done = pasted_with("gear", vec![lapped::assets::exemplar("stone").unwrap()], 20.0, false);
    let bound = Bound::new(done.record.clone()).unwrap();
    let gpu = renderer("vulkan", None).gpu().clone();
    let job = BakeJob { compositing: on(&gpu), ..BakeJob::sized(256) };
    let (record, ..) = bake_record(done.record.clone(), &bound, &job, &Silent).unwrap();
    let (expected, ..) = bake_record(done.record.clone(), &bound, &BakeJob::sized(256), &Silent).unwrap();
    for ((channel, a), (_, b)) in record.look.unwrap().pages[0].iter().zip(&expected.look.unwrap().pages[0]) {
        let (mean, most) = apart(*channel, a, b);
        println!("{channel:?} {mean:.3} {most:.2} of 255, borders matched");
        assert!(mean < 0.5 && most < 8.0, "{channel:?}: with borders matched they differ by {mean}, {most}");
    }
    gpu.device.destroy();
    let error = bake_record(done.record, &bound, &job, &Silent).unwrap_err();
    assert!(matches!(error, AtlasError::Baker(_)), "{error}");
    assert!(error.to_string().contains("--baker cpu"), "{error}");
}

#[test]
#[ignore = "needs graphics adapters, software will do: cargo test --test gpu -- --include-ignored"]
fn exemplars_that_an_adapter_would_make_smaller_are_refused() {
    let done = pasted_with("vase", vec![lapped::assets::exemplar("stone").unwrap()], 20.0, false);
    let mut limits = renderer("vulkan", None).gpu().limits.clone();
    limits.max_texture_dimension_2d = 160;
    let backend = GpuComposite::new(renderer("vulkan", Some(limits)).gpu().clone()).unwrap();
    let error = backend.load(&done.mesh, &done.lapped).err().expect("the exemplar is larger than a texture may be");
    assert!(error.contains("stone"), "{error}");
    let bare = LappedTexture::default();
    assert!(backend.load(&done.mesh, &bare).is_ok(), "nothing to refuse without exemplars");
}
