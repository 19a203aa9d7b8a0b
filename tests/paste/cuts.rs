//! The border of a paste runs where it shows least, and never where nothing else covers the surface.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use crate::common::{input, sheet};
use glam::Vec3;
use lapped::exemplar::{Exemplar, Image, PatchSource};
use lapped::job::{ExemplarInput, PasteJob, Pasted, Scale, paste_model};
use lapped::mesh::SurfacePoint;
use lapped::paste::audit::LEAST_ALPHA;
use lapped::paste::{Composite, PasteOptions};
use lapped::progress::Silent;
use lapped::random::Random;

/// Square stones of different greys with dark joints between them.
fn stones() -> Exemplar {
    const SIDE: u32 = 32;
    let mut random = Random::new(11, 0);
    let greys: Vec<f32> = (0..16).map(|_| random.range(0.2, 0.9) as f32).collect();
    let pixel = |x: u32, y: u32| {
        let joint = x % SIDE < 5 || y % SIDE < 5;
        Vec3::splat(if joint { 0.02 } else { greys[(y / SIDE * 4 + x / SIDE) as usize] })
    };
    Exemplar::new("stones", Image::from_fn(128, 128, pixel))
}

fn on_a_sheet(input: ExemplarInput, windows: bool, cuts: bool) -> Pasted {
    let paste = PasteOptions { windows, cuts, ..PasteOptions::default() };
    let job = PasteJob { scale: Scale::World(0.5), paste, ..PasteJob::default() };
    paste_model(&sheet(24, 2.0), vec![input], &job, &Silent).unwrap()
}

fn of(exemplar: Exemplar) -> ExemplarInput {
    ExemplarInput { exemplar, weight: 1.0, patches: Vec::new() }
}

#[test]
fn borders_run_through_joints() {
    let plain = on_a_sheet(of(stones()), false, false);
    assert!(plain.lapped.pastes.iter().all(|p| p.cut.is_none()), "plain pastes end where their masks do");
    let made = on_a_sheet(of(stones()), false, true);
    let found = made.report.paste.cuts;
    assert!(found.cut > 10, "{found:?}: most pastes lie over others");
    assert!(found.border_after < 0.6 * found.border_before, "{found:?}: through the joints they differ less");
    let both = on_a_sheet(of(stones()), true, true).report.paste.cuts;
    assert!(both.border_after < found.border_after, "{both:?}: less than {found:?} where windows agree already");
}

#[test]
fn nothing_is_cut_away_that_nobody_else_covers() {
    let made = on_a_sheet(of(stones()), true, true);
    let mesh = &made.mesh;
    let composite = Composite::new(mesh, &made.lapped);
    let mut random = Random::new(12, 0);
    for _ in 0..200_000 {
        let face = random.below(mesh.face_count() as u64) as u32;
        let (a, b) = (random.unit() as f32, random.unit() as f32);
        let (a, b) = if a + b > 1.0 { (1.0 - a, 1.0 - b) } else { (a, b) };
        let alpha = composite.alpha(SurfacePoint { face, bary: Vec3::new(1.0 - a - b, a, b) });
        assert!(alpha >= LEAST_ALPHA, "face {face}, {a} {b}: alpha {alpha}");
    }
    assert!(made.lapped.pastes.iter().any(|p| p.cut.is_some()), "some are cut");
}

#[test]
fn masks_that_follow_the_exemplar_are_left_whole() {
    let disc = Image::grey_from_fn(128, 128, |x, y| f32::from((x as f32 - 64.0).hypot(y as f32 - 64.0) < 55.0));
    let source = PatchSource::Mask { name: "disc".to_owned(), image: disc };
    let made = on_a_sheet(ExemplarInput { exemplar: stones(), ..input("bricks", &[source]) }, true, true);
    assert!(made.lapped.pastes.iter().all(|p| p.cut.is_none()), "they are the outline that was asked for");
}
