//! What shows under each paste's mask is the part of the exemplar that goes on what lies around it.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use crate::common::{input, sheet};
use glam::{Vec2, Vec3};
use lapped::exemplar::outline::Outline;
use lapped::exemplar::{Channel, Exemplar, Image, PatchSource, Wrap};
use lapped::job::{ExemplarInput, PasteJob, Pasted, Scale, paste_model};
use lapped::paste::{LappedTexture, PasteOptions, Turn};
use lapped::progress::Silent;

fn job(windows: bool) -> PasteJob {
    PasteJob {
        scale: Scale::World(0.5),
        paste: PasteOptions { windows, cuts: false, ..PasteOptions::default() },
        ..PasteJob::default()
    }
}

fn on_a_sheet(exemplar: &Exemplar, windows: bool) -> Pasted {
    let input = ExemplarInput { exemplar: exemplar.clone(), weight: 1.0, patches: Vec::new() };
    paste_model(&sheet(24, 2.0), vec![input], &job(windows), &Silent).unwrap()
}

/// Soft checks, `count` of them a side; they tile if the count is whole.
fn checks(count: f32) -> Exemplar {
    let wave = |v: u32| ((v as f32 + 0.5) / 128.0 * count * std::f32::consts::TAU).sin();
    Exemplar::new("checks", Image::from_fn(128, 128, |x, y| Vec3::new(0.5, 0.4, 0.3) * (1.0 + 0.9 * wave(x) * wave(y))))
}

/// Pixels of the exemplar that a paste shows: the corners of its mask.
fn window(lapped: &LappedTexture, paste: usize) -> [Vec2; 2] {
    let paste = &lapped.pastes[paste];
    let patch = &lapped.patches[paste.patch as usize];
    let low = Vec2::new(patch.origin[0] as f32, patch.origin[1] as f32) + paste.offset;
    [low, low + Vec2::from(patch.mask.size().map(|s| s as f32))]
}

#[test]
fn on_a_sheet_an_exemplar_that_tiles_goes_on_without_a_seam() {
    let exemplar = checks(4.0);
    let [plain, chosen] = [false, true].map(|windows| on_a_sheet(&exemplar, windows));
    assert_eq!(chosen.lapped.exemplars[0].wrap, Wrap::Repeat, "it tiles");
    let found = chosen.report.paste.windows;
    assert!(found.matched > 10, "{found:?}: most pastes lie over others");
    assert!(found.border_after < 0.15 * found.border_before, "{found:?}: checks meet checks");
    let faces = |p: &Pasted| p.lapped.pastes.iter().map(|p| (p.faces.clone(), p.uv.clone())).collect::<Vec<_>>();
    assert_eq!(faces(&plain), faces(&chosen), "pastes lie where they lay");
    assert!(plain.lapped.pastes.iter().all(|p| p.offset == Vec2::ZERO), "and plain ones show what they showed");
}

#[test]
fn of_an_exemplar_that_does_not_tile_windows_stay_inside() {
    let exemplar = checks(4.4);
    let chosen = on_a_sheet(&exemplar, true);
    assert_eq!(chosen.lapped.exemplars[0].wrap, Wrap::Clamp, "it does not tile");
    let found = chosen.report.paste.windows;
    assert!(found.border_after < 0.8 * found.border_before, "{found:?}: borders agree better all the same");
    for k in (0..chosen.lapped.pastes.len()).filter(|&k| chosen.lapped.pastes[k].turn == Turn::NONE) {
        let [low, high] = window(&chosen.lapped, k);
        assert!(low.min_element() >= 0.0 && high.max_element() <= 128.0, "paste {k} shows {low} to {high}");
    }
}

#[test]
fn outlines_that_follow_the_exemplar_keep_it_under_them() {
    let corners = [[0.1, 0.1], [0.6, 0.15], [0.7, 0.6], [0.2, 0.7]].map(Vec2::from);
    let outline = Outline { points: corners.to_vec() };
    let source = PatchSource::Outlines { name: "test".to_owned(), outlines: vec![outline] };
    let cut = ExemplarInput { exemplar: checks(4.0), ..input("bricks", &[source]) };
    let made = paste_model(&sheet(24, 2.0), vec![cut], &job(true), &Silent).unwrap();
    assert!(made.lapped.pastes.iter().all(|p| p.offset == Vec2::ZERO), "what was outlined is what shows");
    let mut leaf = checks(4.0);
    let disc = |x: u32, y: u32| f32::from((x as f32 - 64.0).hypot(y as f32 - 64.0) < 50.0);
    leaf.set(Channel::Opacity, Image::grey_from_fn(128, 128, disc)).unwrap();
    let leaves = on_a_sheet(&leaf, true);
    assert!(leaves.lapped.pastes.iter().all(|p| p.offset == Vec2::ZERO), "and so with transparent parts as outline");
}
