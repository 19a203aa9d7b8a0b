//! Syntheses beside the pastes: shown, changed by combing, kept circles, exported.

#![allow(clippy::unwrap_used, reason = "tests")]

use crate::common::{Bench, differ};
use egui::{Key, Modifiers, vec2};
use lapped::exemplar::Channel;
use lapped::format::read_model;
use lapped::job::Link;
use lapped::viewer::synth::{Figures, Method};
use lapped::viewer::{Action, Mode};

const SMALL: [f32; 2] = [1280.0, 720.0];

fn figures(bench: &Bench, method: Method) -> Figures {
    bench.app().synth.figures(method, bench.app().shown().unwrap()).unwrap().clone()
}

/// The colours that Chen's and Dong's method has chosen.
fn colours(bench: &Bench) -> Vec<f32> {
    let texture = bench.app().synth.texture(Method::ChenDong, bench.app().shown().unwrap()).unwrap();
    texture.channel(Channel::BaseColor).unwrap().to_vec()
}

#[test]
#[ignore = "needs a graphics adapter, software will do: cargo test --test viewer -- --include-ignored"]
fn pasted_and_synthesized_stand_side_by_side_and_levels_appear() {
    let mut bench = Bench::new(SMALL, 1.0);
    bench.begin("knot", "pebbles");
    bench.app_mut().edit("synthesis", |p| p.synthesis.vertices = 20_000);
    bench.key(Key::Y);
    bench.settle();
    assert_eq!(bench.app().viewport.modes, [Mode::Single, Mode::WeiLevoy], "pasted on the left");
    let made = figures(&bench, Method::WeiLevoy);
    assert!(bench.told().is_empty(), "{}", bench.told());
    assert!((15_000..25_000).contains(&made.vertices), "about as many as asked for: {made:?}");
    assert!(made.levels[1] > 1 && made.whole(), "{made:?}");
    assert_eq!(bench.app().synth.count(), made.levels[1] as u64, "a picture for each level, the last one the whole");
    bench.harness.run_steps(3);
    let levels = bench.picture("compare-wei-levoy");
    bench.click("Chen-Dong");
    bench.settle();
    bench.harness.run_steps(3);
    assert_eq!(bench.app().viewport.modes[1], Mode::ChenDong, "in the pane that showed the other");
    let round = bench.picture("compare-chen-dong");
    assert!(differ(&levels, &round) > 5_000, "another method, another texture");
    bench.app_mut().viewport.modes = [Mode::WeiLevoy, Mode::ChenDong];
    bench.settle();
    bench.picture("compare-methods");
    bench.app_mut().set_model(Link::BuiltIn("vase".into()));
    bench.settle();
    let vase = figures(&bench, Method::ChenDong);
    assert!(vase.whole() && vase.seconds[0] > 0.0, "another model is marched: {vase:?}");
    assert!(bench.told().is_empty(), "{}", bench.told());
    bench.key(Key::Y);
    assert_eq!(bench.app().viewport.split, None, "the comparison is over");
}

#[test]
#[ignore = "needs a graphics adapter, software will do: cargo test --test viewer -- --include-ignored"]
fn combing_synthesizes_anew_without_marching_and_pastes_are_left_alone_by_seeds_of_synthesis() {
    let mut bench = Bench::new(SMALL, 1.0);
    bench.begin("vase", "weave");
    bench.app_mut().edit("synthesis", |p| p.synthesis.vertices = 20_000);
    bench.app_mut().viewport.split = Some(0.5);
    bench.app_mut().viewport.modes = [Mode::ChenDong, Mode::Single];
    bench.settle();
    let first = colours(&bench);
    let marched = figures(&bench, Method::ChenDong).seconds[0];
    assert!(marched > 0.0, "marched the first time");
    let pasted = bench.app().shown().unwrap().revision;
    bench.app_mut().edit("synthesis", |p| p.synthesis.seed = 5);
    bench.settle();
    assert_ne!(colours(&bench), first, "another seed, another arrangement");
    assert_eq!(bench.app().shown().unwrap().revision, pasted, "nothing was pasted for that");
    bench.harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    bench.settle();
    assert_eq!(colours(&bench), first, "undone");

    bench.comb();
    let rect = bench.app().viewport.rect();
    let on = |at| bench.app().steer.pick(bench.app().shown().unwrap(), &bench.app().viewport, at).is_some();
    let ends = |at| [at - vec2(10.0, 20.0), at + vec2(10.0, 20.0)];
    let places = (0..60).map(|k| rect.center() + vec2(-24.0 - 8.0 * (k % 10) as f32, 100.0 - 40.0 * (k / 10) as f32));
    let stroke = places.map(ends).find(|ends| ends.iter().all(|&at| on(at))).expect("a place on the model left of the divider");
    bench.drag(&stroke, Modifiers::NONE);
    bench.settle();
    assert!(!bench.app().document.project().constraints.constraints.is_empty(), "combed");
    assert_ne!(colours(&bench), first, "the texture turned");
    assert_eq!(figures(&bench, Method::ChenDong).seconds[0], 0.0, "nothing was marched for that");
    bench.picture("combed-chen-dong");
}

#[test]
#[ignore = "needs a graphics adapter, software will do: cargo test --test viewer -- --include-ignored"]
fn a_synthesis_is_exported_with_its_colours_and_one_that_is_not_there_is_told() {
    let mut bench = Bench::new(SMALL, 1.0);
    bench.begin("knot", "moss");
    let path = |bench: &Bench, name: &str| bench.home.path().join(name);
    let early = path(&bench, "early.glb");
    bench.app_mut().export_to(Action::ExportSynthesis, early.clone(), true);
    bench.settle();
    assert!(!early.exists() && bench.told().contains("no synthesis to export"), "{}", bench.told());
    bench.app_mut().notices.clear();
    bench.app_mut().edit("synthesis", |p| p.synthesis.vertices = 8_000);
    bench.app_mut().viewport.modes[0] = Mode::WeiLevoy;
    bench.settle();
    let texture = bench.app().synthesized().unwrap();
    for name in ["knot.glb", "knot.ply"] {
        let file = path(&bench, name);
        bench.app_mut().export_to(Action::ExportSynthesis, file.clone(), true);
        bench.settle();
        let model = read_model(&file).unwrap();
        assert_eq!(model.positions, texture.mesh.positions, "{name}: vertex for vertex");
        let colours = model.colors.unwrap();
        let wanted = texture.channel(Channel::BaseColor).unwrap();
        let apart = colours.iter().zip(wanted.chunks_exact(3)).map(|(c, w)| (c.x - w[0]).abs().max((c.y - w[1]).abs()));
        let worst = apart.fold(0.0_f32, f32::max);
        assert!(worst < 0.01, "{name}: colours differ by {worst}");
    }
    let other = path(&bench, "knot.obj");
    bench.app_mut().export_to(Action::ExportSynthesis, other.clone(), true);
    bench.settle();
    assert!(!other.exists() && bench.told().contains(".glb or .ply"), "{}", bench.told());
}

#[test]
#[ignore = "needs a graphics adapter, software will do: cargo test --test viewer -- --include-ignored"]
fn a_synthesis_is_stopped_and_begins_again_with_the_next_change() {
    let mut bench = Bench::new(SMALL, 1.0);
    bench.begin("dragonling_25k", "scales");
    bench.app_mut().edit("synthesis", |p| p.synthesis.vertices = 400_000);
    bench.app_mut().viewport.modes[0] = Mode::WeiLevoy;
    bench.harness.run_steps(4);
    assert!(bench.app().work().is_some_and(|(what, ..)| what == "Synthesising"), "{:?}", bench.app().work());
    bench.key(Key::Escape);
    bench.settle();
    assert!(bench.app().synthesized().is_none() && bench.told().is_empty(), "stopped without a word: {}", bench.told());
    bench.app_mut().edit("synthesis", |p| p.synthesis.vertices = 8_000);
    bench.settle();
    assert!(bench.app().synthesized().is_some(), "begun again: {}", bench.told());
}
