//! The border of a paste runs where it shows least, and never where nothing else covers the surface.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use crate::common::{Points, input, sheet};
use glam::Vec3;
use lapped::exemplar::{CoverageMask, Exemplar, Image, PatchSource};
use lapped::job::{ExemplarInput, PasteJob, Pasted, Scale, paste_model};
use lapped::paste::audit::LEAST_ALPHA;
use lapped::paste::order::cull;
use lapped::paste::seam::see_without_holes;
use lapped::paste::{Composite, Cut, FaceLists, LappedTexture, PasteOptions};
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
fn borders_run_where_both_sides_agree_around_them() {
    let plain = on_a_sheet(of(stones()), false, false);
    assert!(plain.lapped.pastes.iter().all(|p| p.cut.is_none()), "plain pastes end where their masks do");
    let made = on_a_sheet(of(stones()), false, true);
    let found = made.report.paste.cuts;
    assert!(found.cut > 10, "{found:?}: most pastes lie over others");
    assert!(found.border_after < 0.9 * found.border_before, "{found:?}: where stones are alike or joints meet they differ less");
    let both = on_a_sheet(of(stones()), true, true).report.paste.cuts;
    assert!(both.border_after < found.border_after, "{both:?}: less than {found:?} where windows agree already");
}

#[test]
fn nothing_is_cut_away_that_nobody_else_covers() {
    let made = on_a_sheet(of(stones()), true, true);
    let mesh = &made.mesh;
    let composite = Composite::new(mesh, &made.lapped);
    for at in Points::new(mesh).list(200_000) {
        let alpha = composite.alpha(at);
        assert!(alpha >= LEAST_ALPHA, "{at:?}: alpha {alpha}");
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

#[test]
fn cuts_that_leave_whole_faces_bare_are_taken_back_until_nothing_shows_through() {
    let plain = on_a_sheet(of(stones()), true, false);
    let (mesh, mut lapped) = (&plain.mesh, plain.lapped);
    // Nothing but a spot in the middle of each is left.
    lapped.pastes.iter_mut().for_each(|p| p.cut = Some(Box::new(Cut::new(|_| Some([0.05, 0.01])))));
    let masks: Vec<CoverageMask> = lapped.patches.iter().map(CoverageMask::new).collect();
    let lists = FaceLists::new(mesh.face_count(), &lapped.pastes);
    let least = |lapped: &LappedTexture| {
        let composite = Composite::new(mesh, lapped);
        Points::new(mesh).list(50_000).into_iter().map(|at| composite.alpha(at)).fold(1.0, f32::min)
    };
    assert_eq!(least(&lapped), 0.0, "before that most of the sheet is bare");
    let pitch = |_: u32| 0.5 / 64.0;
    let (seen, whole) = see_without_holes(mesh, &mut lapped, &lists, &masks, &pitch, true);
    assert!(seen.holes.is_empty(), "{} samples are still open", seen.holes.len());
    assert!(least(&lapped) >= LEAST_ALPHA, "least alpha {}", least(&lapped));
    assert!(whole > 0, "some pastes are needed whole");
    cull(&mut lapped, &seen);
    assert!(least(&lapped) >= LEAST_ALPHA, "least alpha {} of what is kept", least(&lapped));
}
