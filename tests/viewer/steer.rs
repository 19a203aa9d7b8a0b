//! Combing, cutting and watching, by the mouse on the view.

#![allow(clippy::unwrap_used, reason = "tests")]

use crate::common::Bench;
use egui::{Event, Key, Modifiers, PointerButton, Pos2, vec2};
use glam::{DVec3, Vec2};
use lapped::job::Link;
use lapped::job::project::Shape;
use lapped::paste::watch::Doing;

const SMALL: [f32; 2] = [1280.0, 720.0];

impl Bench {
    fn button(&mut self, at: Pos2, pressed: bool, modifiers: Modifiers) {
        self.harness.event(Event::PointerButton { pos: at, button: PointerButton::Primary, pressed, modifiers });
        self.harness.step();
    }

    /// Drags from one place of the window to others, with keys held.
    pub(crate) fn drag(&mut self, way: &[Pos2], modifiers: Modifiers) {
        self.harness.event(Event::ModifiersChanged(modifiers));
        self.harness.hover_at(way[0]);
        self.harness.step();
        self.button(way[0], true, modifiers);
        for pair in way.windows(2) {
            for i in 1..=6 {
                self.harness.hover_at(pair[0].lerp(pair[1], i as f32 / 6.0));
                self.harness.step();
            }
        }
        self.button(way[way.len() - 1], false, modifiers);
        self.harness.event(Event::ModifiersChanged(Modifiers::NONE));
        self.harness.step();
    }

    pub(crate) fn click_at(&mut self, at: Pos2) {
        self.harness.hover_at(at);
        self.harness.step();
        self.button(at, true, Modifiers::NONE);
        self.button(at, false, Modifiers::NONE);
        self.harness.step();
    }

    pub(crate) fn key(&mut self, key: Key) {
        self.harness.key_press(key);
        self.harness.run_steps(2);
    }

    /// Frames until combing is ready.
    pub(crate) fn comb(&mut self) {
        self.key(Key::C);
        while !self.app().shown().is_some_and(|shown| self.app().steer.ready(shown)) {
            self.harness.step();
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
    }

    /// The direction of texture up in the window at a place of it, and the scale there.
    fn up_at(&self, at: Pos2) -> ([f32; 2], f64) {
        let shown = self.app().shown().unwrap();
        let place = self.app().steer.pick(shown, &self.app().viewport, at).unwrap();
        let laid = shown.laid.as_ref().unwrap();
        let fine = laid.fine.as_ref().map_or(place, |fine| fine.locate(place));
        let field = shown.field().unwrap();
        let (viewport, mesh) = (&self.app().viewport, shown.mesh());
        let (from, up): (DVec3, DVec3) = (mesh.position(fine), field.up[fine.face as usize].as_dvec3());
        let camera = viewport.orbit.camera();
        let step = viewport.place(&camera, from + up * 0.05).unwrap() - viewport.place(&camera, from).unwrap();
        let step = step.normalized();
        ([step.x, step.y], up.length())
    }
}

#[test]
#[ignore = "needs a graphics adapter, software will do: cargo test --test viewer -- --include-ignored"]
fn a_stroke_combs_the_texture_along_it_and_is_undone() {
    let mut bench = Bench::new(SMALL, 1.0);
    bench.begin("vase", "weave");
    let before = bench.app().shown().unwrap().lapped().unwrap().clone();
    bench.comb();
    let middle = bench.app().viewport.rect().center() + vec2(0.0, 60.0);
    let (from, to) = (middle - vec2(60.0, 30.0), middle + vec2(60.0, 30.0));
    let camera = bench.app().viewport.orbit.camera();
    bench.drag(&[from, to], Modifiers::NONE);
    bench.settle();
    assert_eq!(bench.app().viewport.orbit.camera(), camera, "the camera stays where it is");
    let constraints = bench.app().document.project().constraints.constraints.len();
    assert!(constraints >= 2, "{constraints} constraints");
    let (up, _) = bench.up_at(middle);
    let wanted = (to - from).normalized();
    let cosine = up[0] * wanted.x + up[1] * wanted.y;
    assert!(cosine > 0.95, "texture up {up:?} runs along the stroke {wanted:?}");
    bench.picture("combed");
    let slow = bench.app().document.project().constraints.clone();
    bench.harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    bench.settle();
    assert!(bench.app().document.project().constraints.constraints.is_empty(), "undone");
    // The same stroke between two frames.
    let button = |pos: Pos2, pressed: bool| {
        let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
        Event::PointerButton { pos, button, pressed, modifiers }
    };
    let way = (0..=6).map(|i| Event::PointerMoved(from.lerp(to, i as f32 / 6.0)));
    let events = [Event::PointerMoved(from), button(from, true)].into_iter().chain(way).chain([button(to, false)]);
    bench.harness.input_mut().events.extend(events);
    bench.harness.step();
    bench.settle();
    assert_eq!(bench.app().document.project().constraints, slow, "quick or slow, the same constraints");
    bench.harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    bench.settle();
    assert_eq!(bench.app().shown().unwrap().lapped().unwrap(), &before, "paste for paste");
    bench.harness.run_steps(2);
    assert!(bench.app().steer.combing.constraints().constraints.is_empty(), "no handle is left");
}

#[test]
#[ignore = "needs a graphics adapter, software will do: cargo test --test viewer -- --include-ignored"]
fn shift_combs_the_scale_and_a_handle_is_clicked_moved_and_deleted() {
    let mut bench = Bench::new(SMALL, 1.0);
    bench.begin("vase", "weave");
    bench.comb();
    let middle = bench.app().viewport.rect().center() + vec2(0.0, 60.0);
    let (_, plain) = bench.up_at(middle);
    bench.app_mut().steer.combing.settings.scale = 2.5;
    bench.drag(&[middle - vec2(40.0, 0.0), middle + vec2(40.0, 0.0)], Modifiers::SHIFT);
    bench.settle();
    let (_, scaled) = bench.up_at(middle);
    assert!((scaled / plain - 2.5).abs() < 0.3, "scale {plain} became {scaled}");
    bench.picture("scaled");
    let count = bench.app().document.project().constraints.constraints.len();
    let handle = bench.app().steer.combing.handles(&bench.app().shown().unwrap().open.cleaned.mesh)[0];
    let place = |bench: &Bench, p: DVec3| bench.app().viewport.place(&bench.app().viewport.orbit.camera(), p).unwrap();
    let at = place(&bench, handle.place);
    bench.click_at(at);
    assert_eq!(bench.app().steer.combing.selected(), Some(0), "a click selects it");
    bench.picture("handle");
    bench.drag(&[at, at + vec2(0.0, -40.0)], Modifiers::NONE);
    bench.settle();
    let moved = bench.app().steer.combing.handles(&bench.app().shown().unwrap().open.cleaned.mesh)[0];
    let now = place(&bench, moved.place);
    assert!(now.distance(at + vec2(0.0, -40.0)) < 4.0, "dragged from {at} to {now}");
    bench.key(Key::Delete);
    bench.settle();
    assert_eq!(bench.app().document.project().constraints.constraints.len(), count - 1, "deleted");
}

#[test]
#[ignore = "needs a graphics adapter, software will do: cargo test --test viewer -- --include-ignored"]
fn an_outline_drawn_on_the_exemplar_becomes_the_shape_of_its_patches() {
    let mut bench = Bench::new(SMALL, 1.0);
    bench.begin("vase", "weave");
    bench.key(Key::X);
    let ready = |bench: &Bench| bench.app().cut.as_ref().is_some_and(|cut| cut.cutter().has_edges());
    while !ready(&bench) {
        bench.harness.step();
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let exemplar = bench.app().shown().unwrap().lapped().unwrap().exemplars[0].size();
    let size = Vec2::new(exemplar[0] as f32, exemplar[1] as f32);
    let corner = |k: u32| {
        let angle = k as f32 / 7.0 * std::f32::consts::TAU;
        size * 0.5 + Vec2::from_angle(angle) * 0.3 * size.min_element()
    };
    for k in 0..7 {
        let at = bench.app().cut.as_ref().unwrap().place(corner(k)).unwrap();
        bench.click_at(at);
    }
    bench.picture("cutting");
    let first = bench.app().cut.as_ref().unwrap().cutter().drawing().unwrap().0.anchors[0];
    let at = bench.app().cut.as_ref().unwrap().place(first).unwrap();
    bench.click_at(at);
    bench.settle();
    let shapes = bench.app().document.project().exemplars[0].shapes.clone();
    assert!(matches!(&shapes[..], [Shape::Outline(points)] if points.len() > 6), "{shapes:?}");
    assert_eq!(bench.app().shown().unwrap().lapped().unwrap().patches.len(), 1, "pasted with one patch");
    bench.harness.run_steps(8);
    bench.picture("cut");
    bench.harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    bench.settle();
    assert!(bench.app().document.project().exemplars[0].shapes.is_empty(), "undone");
    bench.harness.run_steps(2);
    assert!(bench.app().cut.as_ref().unwrap().cutter().outlines().is_empty(), "in the editor too");
}

#[test]
#[ignore = "needs a graphics adapter, software will do: cargo test --test viewer -- --include-ignored"]
fn outlines_of_a_second_exemplar_are_its_own() {
    let mut bench = Bench::new(SMALL, 1.0);
    bench.begin("vase", "weave");
    let links = ["weave", "pebbles"].map(|name| Link::BuiltIn(name.to_owned()));
    bench.app_mut().set_exemplars(links.to_vec());
    bench.settle();
    let context = bench.harness.ctx.clone();
    bench.app_mut().cut_exemplar(1, &context);
    bench.harness.run_steps(3);
    let size = bench.app().shown().unwrap().lapped().unwrap().exemplars[1].size().map(|n| n as f32);
    for [x, y] in [[0.2, 0.2], [0.8, 0.25], [0.75, 0.8], [0.25, 0.75]] {
        let at = bench.app().cut.as_ref().unwrap().place(Vec2::new(x * size[0], y * size[1])).unwrap();
        bench.click_at(at);
    }
    bench.key(Key::Enter);
    bench.settle();
    bench.harness.run_steps(6);
    bench.picture("cut-second");
    let shapes = |bench: &Bench| bench.app().document.project().exemplars.iter().map(|e| e.shapes.clone()).collect::<Vec<_>>();
    let cut = shapes(&bench);
    assert!(cut[0].is_empty() && matches!(&cut[1][..], [Shape::Outline(_)]), "{cut:?}");
    bench.app_mut().cut_exemplar(0, &context);
    bench.harness.run_steps(3);
    assert!(bench.app().cut.as_ref().unwrap().cutter().outlines().is_empty(), "the first has none");
    assert_eq!(shapes(&bench), cut, "looking at it changes nothing");
    bench.app_mut().cut_exemplar(1, &context);
    bench.harness.run_steps(3);
    assert_eq!(bench.app().cut.as_ref().unwrap().cutter().outlines().len(), 1, "the second has kept its own");
}

#[test]
#[ignore = "needs a graphics adapter, software will do: cargo test --test viewer -- --include-ignored"]
fn a_disc_behind_nearer_parts_is_hidden_by_them() {
    let mut bench = Bench::new(SMALL, 1.0);
    bench.begin("knot", "weave");
    bench.comb();
    bench.key(Key::O);
    bench.settle();
    bench.harness.run_steps(4);
    let before = bench.picture("watch-hidden-before");
    // A paste on the far side of a strand that looks at the eye through a nearer one.
    let (app, shown) = (bench.app(), bench.app().shown().unwrap());
    let (mesh, camera) = (shown.mesh(), app.viewport.orbit.camera());
    let faces_eye = |f: u32| mesh.normal(f).dot(mesh.centroid(f) - camera.eye) < 0.0;
    let hidden = |f: &u32| faces_eye(*f) && !app.steer.in_sight(shown, &camera, mesh.centroid(*f));
    let count = |faces: &[u32]| faces.iter().filter(|f| hidden(f)).count();
    let pastes = &shown.lapped().unwrap().pastes;
    let chosen = (0..pastes.len()).max_by_key(|&p| count(&pastes[p].faces)).unwrap();
    let places: Vec<Pos2> = {
        let faces = pastes[chosen].faces.iter().filter(|f| hidden(f));
        faces.filter_map(|&f| app.viewport.place(&camera, mesh.centroid(f))).collect()
    };
    assert!(places.len() > 10, "{} faces are hidden", places.len());
    bench.app_mut().watch.as_mut().unwrap().watch_mut().choose(Some(chosen));
    bench.settle();
    let moments = bench.app().watch.as_ref().unwrap().watch().growth().map_or(0, lapped::paste::Growth::moments);
    bench.app_mut().watch.as_mut().unwrap().watch_mut().play = lapped::viewer::watch::Play::Still;
    bench.app_mut().watch.as_mut().unwrap().watch_mut().go_to(moments);
    bench.harness.run_steps(3);
    let after = bench.picture("watch-hidden");
    let changed = places.iter().filter(|at| {
        let (x, y) = (at.x as u32, at.y as u32);
        before.get_pixel(x, y) != after.get_pixel(x, y)
    });
    // Beside its outline a seen part of the disc may lie over the middle of a hidden face.
    let changed = changed.count();
    assert!(10 * changed <= places.len(), "{changed} of {} hidden faces were painted", places.len());
}

#[test]
#[ignore = "needs a graphics adapter, software will do: cargo test --test viewer -- --include-ignored"]
fn pastes_are_watched_one_by_one_and_one_of_them_grows() {
    let mut bench = Bench::new(SMALL, 1.0);
    bench.begin("vase", "weave");
    bench.comb();
    bench.key(Key::O);
    let all = bench.app().watch.as_ref().unwrap().watch().count();
    let rect = bench.app().viewport.rect();
    let whole = bench.picture("watch-all");
    bench.app_mut().watch.as_mut().unwrap().watch_mut().show(all / 6);
    bench.settle();
    bench.harness.run_steps(4);
    let some = bench.picture("watch-some");
    let differ = |a: &image::RgbaImage, b: &image::RgbaImage| {
        let inside = |x: u32, y: u32| rect.contains(egui::pos2(x as f32, y as f32));
        a.enumerate_pixels().filter(|(x, y, p)| inside(*x, *y) && *p != b.get_pixel(*x, *y)).count()
    };
    assert!(differ(&whole, &some) > 5000, "most of it is bare: {} pixels differ", differ(&whole, &some));
    bench.app_mut().watch.as_mut().unwrap().watch_mut().show(all);
    bench.settle();
    bench.harness.run_steps(4);
    let again = bench.picture("watch-again");
    assert!(differ(&whole, &again) < 50, "all of them are the whole: {} pixels differ", differ(&whole, &again));
    let middle = bench.app().viewport.rect().center() + vec2(0.0, 60.0);
    bench.click_at(middle);
    bench.settle();
    let growth = |bench: &Bench| bench.app().watch.as_ref().unwrap().watch().growth().map(lapped::paste::Growth::moments);
    let moments = growth(&bench).unwrap();
    bench.app_mut().watch.as_mut().unwrap().watch_mut().play = lapped::viewer::watch::Play::Still;
    bench.app_mut().watch.as_mut().unwrap().watch_mut().go_to(moments / 3);
    bench.harness.run_steps(3);
    bench.picture("watch-growing");
    bench.app_mut().watch.as_mut().unwrap().watch_mut().go_to(moments);
    bench.harness.run_steps(3);
    let moment = bench.app().watch.as_ref().unwrap().watch().moment().unwrap();
    assert!(moment.doing == Doing::Fitting && moment.fits > 0, "it ends with a fit");
    bench.picture("watch-grown");
}
