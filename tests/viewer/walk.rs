//! The walk through the window of docs/walk.md, step by step: its pictures are `target/viewer/walk-*.png`.

#![allow(clippy::unwrap_used, reason = "tests")]

use crate::common::Bench;
use egui::{Key, Modifiers, vec2};
use glam::Vec2;
use lapped::format::read_record;
use lapped::viewer::watch::Play;
use lapped::viewer::{Action, Mode};

#[test]
#[ignore = "needs a graphics adapter, software will do: cargo test --test viewer -- --include-ignored"]
fn from_an_empty_window_to_a_combed_textured_exported_model() {
    let mut bench = Bench::new([1280.0, 720.0], 1.0);
    bench.harness.run_steps(3);
    bench.settle();
    bench.picture("walk-1-empty");
    bench.click("vase with bricks");
    bench.settle();
    bench.harness.run_steps(3);
    bench.picture("walk-2-pasted");

    bench.comb();
    let middle = bench.app().viewport.rect().center() + vec2(0.0, 40.0);
    bench.drag(&[middle + vec2(-70.0, 50.0), middle + vec2(0.0, 10.0), middle + vec2(70.0, -50.0)], Modifiers::NONE);
    bench.settle();
    bench.drag(&[middle + vec2(-60.0, 90.0), middle + vec2(60.0, 80.0)], Modifiers::SHIFT);
    bench.settle();
    bench.harness.run_steps(3);
    bench.picture("walk-3-combed");
    assert!(bench.app().document.project().constraints.constraints.len() > 3, "two strokes left their constraints");
    let handle = bench.app().steer.combing.handles(&bench.app().shown().unwrap().open.cleaned.mesh)[1];
    let at = bench.app().viewport.place(&bench.app().viewport.orbit.camera(), handle.place).unwrap();
    bench.click_at(at);
    bench.harness.run_steps(3);
    bench.picture("walk-4-handle");
    bench.key(Key::Escape);
    bench.key(Key::C);

    bench.key(Key::X);
    while !bench.app().cut.as_ref().is_some_and(|cut| cut.cutter().has_edges()) {
        bench.harness.step();
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let [w, h] = bench.app().shown().unwrap().lapped().unwrap().exemplars[0].size().map(|n| n as f32);
    // Around some whole bricks: the wire runs along the mortar.
    let corners = [[0.12, 0.13], [0.5, 0.13], [0.87, 0.13], [0.87, 0.5], [0.87, 0.87], [0.5, 0.87], [0.12, 0.87], [0.12, 0.5]];
    for (k, [x, y]) in corners.into_iter().enumerate() {
        let at = bench.app().cut.as_ref().unwrap().place(Vec2::new(x * w, y * h)).unwrap();
        bench.click_at(at);
        if k == 5 {
            let next = bench.app().cut.as_ref().unwrap().place(Vec2::new(0.3 * w, 0.86 * h)).unwrap();
            bench.harness.hover_at(next);
            bench.harness.run_steps(3);
            bench.picture("walk-5-cutting");
        }
    }
    bench.key(Key::Enter);
    bench.settle();
    bench.harness.run_steps(6);
    bench.picture("walk-6-cut");
    assert_eq!(bench.app().shown().unwrap().lapped().unwrap().patches.len(), 1, "one patch, the one drawn");
    bench.key(Key::X);

    bench.key(Key::O);
    let all = bench.app().watch.as_ref().unwrap().watch().count();
    bench.app_mut().watch.as_mut().unwrap().watch_mut().show(all / 2);
    bench.settle();
    bench.harness.run_steps(3);
    bench.click_at(middle);
    bench.settle();
    if let Some(watch) = &mut bench.app_mut().watch {
        let moments = watch.watch().growth().map_or(0, lapped::paste::Growth::moments);
        watch.watch_mut().play = Play::Still;
        watch.watch_mut().go_to(moments / 3);
    }
    bench.harness.run_steps(3);
    bench.picture("walk-7-watching");
    bench.key(Key::O);

    bench.app_mut().viewport.split = Some(0.5);
    bench.app_mut().viewport.modes = [Mode::Single, Mode::Pastes];
    bench.settle();
    bench.harness.run_steps(4);
    bench.picture("walk-8-split");
    bench.app_mut().viewport.split = None;
    bench.app_mut().edit("synthesis", |p| p.synthesis.vertices = 120_000);
    bench.key(Key::Y);
    bench.settle();
    bench.harness.run_steps(4);
    bench.picture("walk-9-compare");
    assert!(bench.app().synthesized().is_some(), "pasted against synthesised: {}", bench.told());
    let record = bench.home.path().join("vase.glb");
    bench.app_mut().export_to(Action::ExportRecord, record.clone(), true);
    bench.settle();
    let written = read_record(&record).unwrap();
    assert_eq!(written.lapped.pastes.len(), bench.app().shown().unwrap().lapped().unwrap().pastes.len(), "all pastes are in it");
}
