//! Panels and deeds, without a window.

#![allow(clippy::unwrap_used, reason = "tests")]

use crate::common::Bench;
use egui::{Event, Key, Modifiers, PointerButton, vec2};
use egui_kittest::kittest::{NodeT, Queryable};
use lapped::job::Project;
use lapped::viewer::Mode;

/// A window as small as it must still be readable in.
const SMALL: [f32; 2] = [1280.0, 720.0];

#[test]
#[ignore = "needs a graphics adapter, software will do: cargo test --test viewer -- --include-ignored"]
fn a_demo_is_picked_pasted_turned_and_seen() {
    let mut bench = Bench::new(SMALL, 1.0);
    bench.settle();
    bench.picture("welcome");
    bench.click("knot with weave");
    bench.settle();
    let shown = bench.app().shown().unwrap();
    let report = shown.report().unwrap();
    assert!(report.paste.least_alpha > 0.98 && report.paste.pastes > 20, "the knot is covered: {:?}", report.paste);
    let before = bench.picture("knot");
    let middle = bench.app().viewport.rect().center();
    bench.harness.drag_at(middle);
    bench.harness.step();
    bench.harness.hover_at(middle + vec2(120.0, 20.0));
    bench.harness.step();
    bench.harness.drop_at(middle + vec2(120.0, 20.0));
    bench.settle();
    let after = bench.picture("knot-turned");
    let differ = before.pixels().zip(after.pixels()).filter(|(a, b)| a != b).count();
    assert!(differ > 20_000, "the model was turned: {differ} pixels differ");
}

#[test]
#[ignore = "needs a graphics adapter, software will do: cargo test --test viewer -- --include-ignored"]
fn every_change_can_be_undone_and_undone_ones_show_the_same_pastes() {
    let mut bench = Bench::new(SMALL, 1.0);
    bench.begin("knot", "weave");
    let first = bench.app().shown().unwrap().lapped().unwrap().clone();
    bench.app_mut().edit("seed", |p| p.seed = 9);
    bench.settle();
    assert_ne!(bench.app().shown().unwrap().lapped().unwrap(), &first, "another seed, other pastes");
    bench.harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    bench.settle();
    assert_eq!(bench.app().shown().unwrap().lapped().unwrap(), &first, "back to the first");
    bench.harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    bench.settle();
    assert_eq!(bench.app().document.project().seed, 9, "and again");
}

#[test]
#[ignore = "needs a graphics adapter, software will do: cargo test --test viewer -- --include-ignored"]
fn a_slider_moved_let_go_and_undone_within_one_frame_is_undone() {
    let mut bench = Bench::new(SMALL, 1.0);
    bench.begin("knot", "weave");
    let first = bench.app().document.project().clone();
    let scale = bench.harness.get_by_role_and_label(egui::accesskit::Role::Slider, "scale").rect();
    let at = scale.left_center() + vec2(20.0, 0.0);
    let button = |pressed| Event::PointerButton { pos: at, button: PointerButton::Primary, pressed, modifiers: Modifiers::NONE };
    bench.harness.hover_at(at);
    bench.harness.step();
    bench.harness.event(button(true));
    bench.harness.step();
    bench.harness.hover_at(at + vec2(10.0, 0.0));
    bench.harness.step();
    assert_ne!(bench.app().document.project().size, first.size, "the slider moves");
    // The next frame comes late: all this has happened meanwhile.
    let undo = |pressed| {
        let modifiers = Modifiers::COMMAND;
        Event::Key { key: Key::Z, physical_key: None, pressed, repeat: false, modifiers }
    };
    let late = [Event::PointerMoved(at + vec2(16.0, 0.0)), button(false), undo(true), undo(false)];
    bench.harness.input_mut().events.extend(late);
    bench.harness.step();
    bench.harness.step();
    assert_eq!(bench.app().document.project(), &first, "as it was before the slider moved");
    assert_eq!(bench.app().document.steps()[1], Some("scale"), "one change, taken back");
}

#[test]
#[ignore = "needs a graphics adapter, software will do: cargo test --test viewer -- --include-ignored"]
fn smaller_patches_are_laid_and_taken_back_by_a_switch_that_plain_pastes_lack() {
    let mut bench = Bench::new(SMALL, 1.0);
    bench.begin("knot", "bricks");
    let patches = |bench: &Bench| bench.app().shown().unwrap().lapped().unwrap().patches.len();
    let first = patches(&bench);
    let click = |bench: &mut Bench, label: &str| {
        bench.harness.get_by_role_and_label(egui::accesskit::Role::CheckBox, label).click();
        bench.settle();
    };
    click(&mut bench, "smaller patches");
    assert!(bench.app().document.project().small && patches(&bench) > first, "{} patches", patches(&bench));
    click(&mut bench, "keep contrast");
    assert!(bench.app().document.project().contrast, "the other switch");
    click(&mut bench, "match borders");
    assert_eq!(patches(&bench), first, "plain pastes have no smaller ones");
    let small = bench.harness.get_by_role_and_label(egui::accesskit::Role::CheckBox, "smaller patches");
    assert!(small.accesskit_node().is_disabled(), "and no switch for them");
}

#[test]
#[ignore = "needs a graphics adapter, software will do: cargo test --test viewer -- --include-ignored"]
fn light_is_evened_out_and_detail_laid_over_a_base_by_what_is_chosen() {
    let mut bench = Bench::new(SMALL, 1.0);
    bench.begin("knot", "bricks");
    let lapped = |bench: &Bench| bench.app().shown().unwrap().lapped().unwrap().clone();
    let first = lapped(&bench);
    let light = |bench: &mut Bench| {
        bench.harness.get_by_role_and_label(egui::accesskit::Role::CheckBox, "even out light").click();
        bench.settle();
    };
    light(&mut bench);
    assert_ne!(lapped(&bench).exemplars, first.exemplars, "other pixels");
    assert!(bench.app().shown().unwrap().told.iter().any(|t| t.contains("its light varied by")), "and it is told");
    light(&mut bench);
    assert_eq!(lapped(&bench), first, "as it was");
    let choose = |bench: &mut Bench, base: &str| {
        bench.harness.get_by_role_and_label(egui::accesskit::Role::ComboBox, "exemplars").click();
        bench.harness.run_steps(3);
        bench.harness.get_by_role_and_label(egui::accesskit::Role::Button, base).click();
        bench.settle();
    };
    choose(&mut bench, "over their own colours");
    let own = lapped(&bench);
    assert_ne!(own.exemplars, first.exemplars, "detail alone");
    assert_eq!(own.layers[0].base.len(), bench.app().shown().unwrap().mesh().face_count(), "on every face");
    bench.picture("base-own");
    choose(&mut bench, "over one colour");
    bench.picture("base-colour");
    let plain = lapped(&bench);
    assert!(plain.layers[0].base.iter().flatten().all(|c| *c == plain.layers[0].base[0][0]), "one colour");
    assert_eq!(plain.exemplars, own.exemplars, "the same detail");
    choose(&mut bench, "pasted as they are");
    assert_eq!(lapped(&bench), first, "and nothing is left of it");
}

#[test]
#[ignore = "needs a graphics adapter, software will do: cargo test --test viewer -- --include-ignored"]
fn a_saved_project_opens_as_it_was_to_the_last_paste() {
    let mut bench = Bench::new(SMALL, 1.0);
    bench.begin("vase", "bricks");
    bench.app_mut().edit("base", |p| p.base = Some("#8a5a3c".parse().unwrap()));
    bench.app_mut().edit("seed", |p| p.seed = 4);
    bench.app_mut().edit("feather", |p| p.feather = Some(7.3));
    bench.app_mut().viewport.orbit.turn(80.0, 30.0);
    bench.settle();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("vase.lapped");
    bench.app_mut().save_to(path.clone());
    bench.settle();
    assert!(!bench.app().document.unsaved(), "saved: {}", bench.told());
    let (lapped, orbit) = (bench.app().shown().unwrap().lapped().unwrap().clone(), bench.app().viewport.orbit);
    drop(bench);
    let mut again = Bench::new(SMALL, 1.0);
    again.harness.step();
    again.app_mut().open_all(std::slice::from_ref(&path));
    again.settle();
    assert_eq!(again.app().shown().unwrap().lapped().unwrap(), &lapped, "paste for paste");
    assert_eq!(again.app().viewport.orbit.camera(), orbit.camera(), "seen from there");
    let saved = Project { view: None, ..Project::read(&path).unwrap_or_default() };
    assert_eq!(Project { view: None, ..again.app().document.project().clone() }, saved, "the same project");
}

#[test]
#[ignore = "needs a graphics adapter, software will do: cargo test --test viewer -- --include-ignored"]
fn a_broken_file_is_told_in_the_window_and_changes_nothing() {
    let mut bench = Bench::new(SMALL, 1.0);
    bench.begin("knot", "weave");
    let before = bench.app().document.project().clone();
    let path = bench.home.path().join("broken.ply");
    std::fs::write(&path, b"ply\nformat ascii 1.0\nelement vertex banana\n").unwrap();
    bench.app_mut().open_all(&[path]);
    bench.settle();
    assert!(bench.app().notices.iter().any(|n| n.error && n.text.contains("broken.ply")), "told: {}", bench.told());
    assert_eq!(bench.app().document.project(), &before, "the project is as it was");
    assert!(bench.app().shown().is_some(), "the knot is still there");
    bench.picture("broken-file");
}

#[test]
#[ignore = "needs a graphics adapter, software will do: cargo test --test viewer -- --include-ignored"]
fn both_ways_of_drawing_agree_and_every_mode_shows_something() {
    let mut bench = Bench::new([900.0, 640.0], 1.0);
    bench.begin("knot", "weave");
    let mut seen = Vec::new();
    for mode in Mode::ALL {
        bench.app_mut().viewport.modes[0] = mode;
        bench.settle();
        for _ in 0..40 {
            bench.harness.step();
            std::thread::sleep(std::time::Duration::from_millis(10));
        }
        bench.settle();
        seen.push((mode, bench.picture(&format!("mode-{mode:?}"))));
    }
    let of = |mode: Mode| &seen.iter().find(|(m, _)| *m == mode).unwrap().1;
    let rect = bench.app().viewport.rect().shrink(8.0);
    let (single, layered) = (of(Mode::Single), of(Mode::Layered));
    let mut far = 0_usize;
    for (x, y, pixel) in single.enumerate_pixels() {
        let inside = rect.contains(egui::pos2(x as f32, y as f32));
        let apart = pixel.0.iter().zip(layered.get_pixel(x, y).0).map(|(a, b)| a.abs_diff(b)).max();
        far += usize::from(inside && apart > Some(40));
    }
    // Edges are smooth in one and not in the other.
    let all = (rect.width() * rect.height()) as usize;
    assert!(far * 25 < all, "{far} of {all} pixels differ");
    for (mode, picture) in &seen {
        let grey = |p: &image::Rgba<u8>| p.0[0].abs_diff(p.0[1]) < 6 && p.0[1].abs_diff(p.0[2]) < 6;
        let coloured = picture.pixels().filter(|p| !grey(p)).count();
        assert!(*mode == Mode::Bare || coloured > 15_000, "{mode:?} shows {coloured} coloured pixels");
    }
}

#[test]
#[ignore = "needs a graphics adapter, software will do: cargo test --test viewer -- --include-ignored"]
fn unsaved_work_is_asked_about_and_survives_a_crash() {
    let mut bench = Bench::new(SMALL, 1.0);
    bench.begin("knot", "rust");
    bench.app_mut().edit("seed", |p| p.seed = 77);
    bench.app_mut().ask_to_quit();
    bench.harness.run_steps(2);
    assert!(!bench.app().is_over(), "asked first");
    bench.picture("unsaved");
    bench.click("Cancel");
    assert!(!bench.app().is_over() && bench.app().question.is_none(), "went on");
    // Frames of a quarter of a second each: after a few unsaved work is kept.
    bench.harness.run_steps(12);
    bench.settle();
    let kept = bench.home.path().join(format!("recovery-{}.lapped", std::process::id()));
    assert_eq!(Project::read(&kept).map(|p| p.seed).ok(), Some(77), "kept against a crash");
    let home = tempfile::tempdir().unwrap();
    std::fs::copy(&kept, home.path().join("recovery-4294967294.lapped")).unwrap();
    drop(bench);
    let mut again = Bench::at_home(SMALL, 1.0, home);
    again.harness.run_steps(2);
    again.picture("recover");
    again.click("Restore");
    again.settle();
    assert_eq!(again.app().document.project().seed, 77, "as it was");
    assert!(again.app().document.unsaved(), "no file holds it yet");
    again.app_mut().ask_to_quit();
    again.harness.run_steps(2);
    again.click("Discard");
    assert!(again.app().is_over(), "closed");
}
