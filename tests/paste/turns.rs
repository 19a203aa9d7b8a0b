//! What a paste shows may be turned about its mask's middle, where the exemplar looks the same so.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use crate::common::{meshed, sheet};
use crate::turned::{one_paste, waves};
use glam::{Vec2, Vec3};
use lapped::exemplar::{Exemplar, Image, Wrap};
use lapped::job::{ExemplarInput, PasteJob, Pasted, Scale, Steer, paste_model};
use lapped::mesh::SurfacePoint;
use lapped::paste::{Composite, LappedTexture, PasteOptions, TURNS, Turn};
use lapped::progress::Silent;
use lapped::random::Random;
use lapped::surface::{Sight, SurfaceTexture};

#[test]
fn a_turned_paste_shows_what_a_plain_one_shows_of_the_turned_exemplar() {
    let mesh = meshed(&sheet(1, 1.0));
    let (one, other) = (one_paste(waves(false), Turn::new(TURNS / 4)), one_paste(waves(true), Turn::NONE));
    let still = one_paste(waves(false), Turn::NONE);
    let [one, other, still] = [&one, &other, &still].map(|l| Composite::new(&mesh, l).with_parallax(0.1));
    let sight = Sight { to_eye: Vec3::new(0.5, -0.3, 1.0).normalize(), to_light: Vec3::Z };
    let mut random = Random::new(5, 0);
    let mut changed = 0.0;
    for k in 0..400 {
        let (a, b) = (random.unit().sqrt(), random.unit());
        let bary = Vec3::new((1.0 - a) as f32, (a * (1.0 - b)) as f32, (a * b) as f32);
        let at = SurfacePoint { face: k % 2, bary };
        // Fine and coarse levels.
        let footprint = if k % 4 < 2 { 0.0 } else { 0.1 };
        let [found, expected, before] = [&one, &other, &still].map(|c| c.texel_seen(at, footprint, &sight));
        let near = |a: Vec3, b: Vec3| a.distance(b) < 2e-4;
        assert!(near(found.base_color, expected.base_color), "colour at {at:?}: {found:?}, not {expected:?}");
        assert!(near(found.normal, expected.normal), "normal at {at:?}: {} and not {}", found.normal, expected.normal);
        assert!((found.height - expected.height).abs() < 2e-4, "height at {at:?}");
        changed += before.base_color.distance(found.base_color) / 400.0;
    }
    assert!(changed > 0.1, "turning shows something else: {changed}");
}

fn on_a_sheet(exemplar: Exemplar, windows: bool, steer: Steer) -> Pasted {
    let job = PasteJob {
        scale: Scale::World(0.5),
        steer,
        paste: PasteOptions { windows, cuts: false, ..PasteOptions::default() },
        ..PasteJob::default()
    };
    let input = ExemplarInput { exemplar, weight: 1.0, patches: Vec::new() };
    paste_model(&sheet(24, 2.0), vec![input], &job, &Silent).unwrap()
}

/// Dots at random, which look the same every way; along x and y they go on at the other side if they are to tile.
fn dots(tile: bool) -> Exemplar {
    let mut random = Random::new(8, 0);
    let side = 128.0_f32;
    let dots: Vec<Vec2> = (0..420).map(|_| Vec2::new(random.unit() as f32, random.unit() as f32) * side).collect();
    let image = Image::from_fn(128, 128, |x, y| {
        let at = Vec2::new(x as f32, y as f32);
        let near = |dot: &Vec2| {
            let d = at - *dot;
            let d = if tile { d - side * (d / side).round() } else { d };
            (-d.length_squared() / 5.0).exp()
        };
        Vec3::splat(dots.iter().map(near).sum::<f32>().min(1.0))
    });
    Exemplar::new("dots", image)
}

#[test]
fn an_exemplar_that_looks_the_same_every_way_is_turned_and_borders_agree_better_for_it() {
    for tile in [true, false] {
        let made = on_a_sheet(dots(tile), true, Steer::Isotropic(None));
        assert_eq!(made.lapped.exemplars[0].wrap == Wrap::Repeat, tile);
        let found = made.report.paste.windows;
        let turned = made.lapped.pastes.iter().filter(|p| p.turn != Turn::NONE).count();
        assert!(turned > 0 && found.turned >= turned, "{found:?}: {turned} turned");
        assert!(found.border_after < 0.95 * found.border_before, "{found:?}");
        let plain = on_a_sheet(dots(tile), false, Steer::Isotropic(None));
        assert!(plain.lapped.pastes.iter().all(|p| p.turn == Turn::NONE), "nobody asked");
        let directed = on_a_sheet(dots(tile), true, Steer::default());
        assert!(directed.report.paste.windows.matched > 0);
        assert!(directed.lapped.pastes.iter().all(|p| p.turn == Turn::NONE), "a direction is kept");
        if !tile {
            stays_inside(&made.lapped);
        }
    }
}

/// Everything that pastes show lies on their exemplar.
fn stays_inside(lapped: &LappedTexture) {
    for (k, paste) in lapped.pastes.iter().enumerate() {
        let patch = &lapped.patches[paste.patch as usize];
        let mask = patch.mask.finest();
        let size = Vec2::from(lapped.exemplars[patch.exemplar as usize].size().map(|s| s as f32));
        let middle = 0.5 * Vec2::from(mask.size().map(|s| s as f32));
        for y in 0..mask.size()[1] {
            for x in (0..mask.size()[0]).filter(|&x| mask.grey(x.into(), y.into()) > 0.0) {
                let pixel = Vec2::new(x as f32, y as f32) + 0.5;
                let place = paste.turn.rotation().rotate(pixel - middle) + middle + Vec2::from(patch.origin.map(|o| o as f32));
                let place = place + paste.offset;
                let inside = place.cmpge(Vec2::ZERO).all() && place.cmple(size).all();
                assert!(inside, "paste {k}, {:?}, shows {place}", paste.turn);
            }
        }
    }
}

#[test]
fn checks_are_turned_by_quarters_alone_and_nothing_is_under_a_direction() {
    let wave = |v: u32| ((v as f32 + 0.5) / 128.0 * 4.4 * std::f32::consts::TAU).sin();
    let checks =
        Exemplar::new("checks", Image::from_fn(128, 128, |x, y| Vec3::new(0.5, 0.4, 0.3) * (1.0 + 0.9 * wave(x) * wave(y))));
    let made = on_a_sheet(checks.clone(), true, Steer::Isotropic(None));
    assert!(made.lapped.pastes.iter().all(|p| p.turn.parts().is_multiple_of(TURNS / 4)));
    assert!(made.report.paste.windows.turned > 0, "checks may be turned where nothing gives a direction");
    stays_inside(&made.lapped);
    let scales = lapped::assets::exemplar("scales").unwrap();
    let made = on_a_sheet(scales.clone(), true, Steer::Isotropic(None));
    assert!(made.report.paste.windows.matched > 0);
    assert!(made.lapped.pastes.iter().all(|p| p.turn == Turn::NONE), "scales have one way up");
    for exemplar in [checks, scales] {
        let made = on_a_sheet(exemplar, true, Steer::default());
        assert!(made.report.paste.windows.matched > 0);
        assert!(made.lapped.pastes.iter().all(|p| p.turn == Turn::NONE), "a direction is kept");
    }
}
