//! What the window looks like: pictures that are kept for who looks, and what must be seen in them.

#![allow(clippy::unwrap_used, reason = "tests")]

use crate::common::{Bench, differ};
use egui_kittest::kittest::NodeT;
use lapped::job::Link;
use lapped::job::project::Direction;
use lapped::render::Picture;
use lapped::render::animation::Film;
use lapped::viewer::Mode;
use lapped::viewer::lines::Lines;

#[test]
#[ignore = "needs a graphics adapter, software will do: cargo test --test viewer -- --include-ignored"]
fn lines_lie_over_the_surface_and_singularities_are_counted() {
    let mut bench = Bench::new([1280.0, 720.0], 1.0);
    bench.begin("dragonling", "scales");
    let plain = bench.picture("textured");
    let all = [
        ("arrows", Lines { arrows: true, singularities: true, ..Lines::default() }),
        ("streamlines", Lines { streamlines: true, ..Lines::default() }),
        ("edges", Lines { edges: true, ..Lines::default() }),
    ];
    for (name, lines) in all {
        bench.app_mut().lines = lines;
        bench.settle();
        let drawn = bench.picture(name);
        let changed = differ(&plain, &drawn);
        assert!(changed > 3000, "{name}: {changed} pixels differ");
    }
    bench.app_mut().edit("direction", |p| p.direction = Direction::Relaxed(4));
    bench.app_mut().lines = Lines { arrows: true, singularities: true, ..Lines::default() };
    bench.settle();
    let sum = lapped::field::turning_points(bench.app().shown().unwrap().mesh(), bench.app().shown().unwrap().field().unwrap());
    let mesh = bench.app().shown().unwrap().mesh();
    let parts: i64 = sum.iter().map(|s| i64::from(s.parts)).sum();
    assert_eq!(parts, 4 * mesh.euler_characteristic(), "Poincare and Hopf");
    bench.picture("four-ways");
}

#[test]
#[ignore = "needs a graphics adapter, software will do: cargo test --test viewer -- --include-ignored"]
fn the_window_is_readable_at_every_size_and_scale() {
    for (name, size, scale) in [("narrow", [620.0, 480.0], 1.0), ("tiny", [480.0, 320.0], 1.0), ("dense", [960.0, 540.0], 2.0)] {
        let mut bench = Bench::new(size, scale);
        bench.settle();
        bench.picture(&format!("welcome-{name}"));
        bench.begin("vase", "bricks");
        bench.picture(&format!("vase-{name}"));
        let rect = bench.app().viewport.rect();
        assert!(rect.width() > 0.35 * size[0] && rect.height() > 0.6 * size[1], "{name}: the view has {rect:?}");
    }
}

#[test]
#[ignore = "needs a graphics adapter, software will do: cargo test --test viewer -- --include-ignored"]
fn a_window_moved_to_a_denser_screen_draws_more_pixels_and_one_without_size_draws_none() {
    let mut bench = Bench::new([800.0, 500.0], 1.0);
    bench.begin("knot", "weave");
    let (rect, pixels) = (bench.app().viewport.rect(), bench.app().viewport.pixels());
    // As the system tells of a screen with points of two pixels.
    let viewport = bench.harness.input_mut().viewports.entry(egui::ViewportId::ROOT).or_default();
    viewport.native_pixels_per_point = Some(2.0);
    bench.settle();
    let denser = bench.app().viewport.pixels();
    assert!((0..2).all(|k| denser[k].abs_diff(2 * pixels[k]) <= 2), "{pixels:?} became {denser:?}");
    assert!((bench.app().viewport.rect().size() - rect.size()).length() < 2.0, "as large on the desk: {rect:?}");
    let picture = bench.picture("denser-screen");
    assert_eq!(picture.dimensions(), (1600, 1000), "all of the window");
    for size in [[1.0, 1.0], [300.0, 0.0], [800.0, 500.0]] {
        bench.harness.set_size(size.into());
        bench.harness.run_steps(3);
        assert!(bench.told().is_empty(), "{size:?}: {}", bench.told());
    }
    bench.settle();
    assert_eq!(bench.app().viewport.pixels(), denser, "as before");
}

#[test]
#[ignore = "needs a graphics adapter, software will do: cargo test --test viewer -- --include-ignored"]
fn split_light_help_and_long_names() {
    let mut bench = Bench::new([1280.0, 720.0], 1.0);
    bench.begin("vase", "bricks");
    bench.app_mut().viewport.split = Some(0.5);
    bench.settle();
    let split = bench.picture("split");
    bench.app_mut().viewport.modes = [Mode::Draws, Mode::Stretch];
    bench.settle();
    assert!(differ(&split, &bench.picture("figures-in-colours")) > 20_000, "other modes, other colours");
    bench.harness.key_press(egui::Key::F1);
    bench.harness.run_steps(3);
    bench.picture("help");
    bench.harness.key_press(egui::Key::Escape);
    bench.harness.key_press(egui::Key::L);
    bench.app_mut().viewport.modes = [Mode::Single, Mode::Pastes];
    bench.settle();
    bench.picture("light");
    // A model and an exemplar with names of their own.
    let name = "a-scan-of-the-north-portal-of-the-cathedral-after-cleaning-2024-03-17-final.ply";
    let [model, image] = [name, "weathered-limestone-with-lichen-and-traces-of-paint.png"].map(|n| bench.home.path().join(n));
    let mesh = b"ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
        element face 4\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
    std::fs::write(&model, mesh).unwrap();
    image::RgbImage::from_fn(64, 64, |x, y| image::Rgb([(4 * x) as u8, 128, (4 * y) as u8])).save(&image).unwrap();
    bench.app_mut().open_all(&[model, image]);
    bench.settle();
    assert_eq!(bench.app().shown().unwrap().open.cleaned.mesh.face_count(), 4, "{}", bench.told());
    bench.picture("long-names");
    let labels: Vec<String> = bench.harness.root().children_recursive().filter_map(|n| n.accesskit_node().value()).collect();
    assert!(!labels.iter().any(|l| l.contains(name)), "the long name is shortened");
}

#[test]
#[ignore = "needs a graphics adapter, software will do: cargo test --test viewer -- --include-ignored"]
fn an_atlas_is_baked_and_looks_like_what_was_baked() {
    let mut bench = Bench::new([1000.0, 640.0], 1.0);
    bench.begin("knot", "pebbles");
    bench.app_mut().edit("direction", |p| p.direction = Direction::Relaxed(1));
    bench.settle();
    let single = bench.picture("before-atlas");
    bench.app_mut().viewport.modes[0] = Mode::Atlas;
    bench.harness.run_steps(3);
    bench.settle();
    let atlas = bench.picture("atlas");
    let apart = differ(&single, &atlas);
    assert!(apart < 120_000, "the bake looks like what was baked: {apart} pixels differ");
    bench.app_mut().set_model(Link::BuiltIn("vase".into()));
    bench.settle();
    assert!(bench.told().is_empty(), "{}", bench.told());
}

#[test]
#[ignore = "needs a graphics adapter, software will do: cargo test --test viewer -- --include-ignored"]
fn exemplars_that_go_by_time_change_while_they_are_played() {
    let mut bench = Bench::new([900.0, 600.0], 1.0);
    // Red and blue blobs in turn, half a second each.
    let path = bench.home.path().join("blinking.png");
    let mut file = Vec::new();
    let mut film = Film::apng(&mut file, [64, 64], 2, 2).unwrap();
    for (red, blue) in [(255, 0), (0, 255)] {
        let mut frame = Picture::filled(64, 64, [0, 0, 0, 255]);
        for (i, pixel) in frame.rgba.as_chunks_mut::<4>().0.iter_mut().enumerate() {
            let grey = 40 + 25 * ((i % 64 / 8 * 5 + i / 64 / 8 * 3) % 9) as u32;
            (pixel[0], pixel[2]) = ((red * grey / 255) as u8, (blue * grey / 255) as u8);
        }
        film.push(&frame).unwrap();
    }
    film.finish().unwrap();
    std::fs::write(&path, file).unwrap();
    bench.begin("vase", "bricks");
    assert!(!bench.app().changes(), "bricks stay");
    bench.app_mut().set_exemplars(vec![Link::File(path)]);
    bench.settle();
    assert!(bench.app().changes() && !bench.app().viewport.playing, "it could change, and waits for somebody to ask for it");
    // More red than blue, or the other way, over the whole window.
    let is_red = |bench: &mut Bench| {
        let picture = bench.picture("played");
        let sum = |c: usize| picture.pixels().map(|p| u64::from(p.0[c])).sum::<u64>();
        sum(0) > sum(2)
    };
    bench.harness.key_press(egui::Key::K);
    let mut seen = Vec::new();
    for _ in 0..12 {
        bench.harness.step();
        seen.push(is_red(&mut bench));
    }
    assert!(seen.contains(&true) && seen.contains(&false), "it changes: {seen:?}");
    assert!(seen.windows(2).filter(|w| w[0] != w[1]).count() >= 2, "again and again: {seen:?}");
    bench.harness.key_press(egui::Key::K);
    bench.harness.run_steps(2);
    let clock = bench.app().viewport.clock;
    bench.harness.run_steps(6);
    assert_eq!((bench.app().viewport.playing, bench.app().viewport.clock), (false, clock), "and stops");
}
