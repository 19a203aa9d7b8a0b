//! Channels named by flags travel through the program into the record, whatever their files are called.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use crate::program::{Place, text};
use lapped::exemplar::Channel;

/// A place with the woven demo exemplar under names that say nothing, its normal map in both conventions.
fn place() -> Place {
    let place = Place::new();
    let asset = |name: &str| image::open(format!("{}/assets/exemplars/weave_{name}.png", env!("CARGO_MANIFEST_DIR"))).unwrap();
    asset("color").save(place.path("one.png")).unwrap();
    asset("height").save(place.path("two.png")).unwrap();
    let up = asset("normal").into_rgb8();
    up.save(place.path("up.png")).unwrap();
    let mut down = up;
    down.pixels_mut().for_each(|p| p[1] = 255 - p[1]);
    down.save(place.path("down.png")).unwrap();
    place
}

/// Pastes with these flags; the normals of the record's exemplar and what was said.
fn paste(place: &Place, flags: &[&str]) -> (Vec<f32>, String) {
    let out = place.run(&[&["paste", "--no-bake", "mesh.obj", "one.png", "-o", "out/a.glb"], flags].concat());
    assert_eq!(out.status.code(), Some(0), "{flags:?}: {}", text(&out.stderr));
    let record = lapped::format::read_record(&place.path("out/a.glb")).unwrap();
    (record.lapped.exemplars[0].channel(Channel::Normal).unwrap().finest().data().to_vec(), text(&out.stderr))
}

/// Equal but for the rounding of 16 bits.
fn same(a: &[f32], b: &[f32]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-4)
}

#[test]
fn a_normal_map_of_either_convention_gives_the_same_record() {
    let place = place();
    let (up, _) = paste(&place, &["--normal", "up.png", "--normal-convention", "opengl"]);
    let (down, _) = paste(&place, &["--normal", "down.png", "--normal-convention", "directx"]);
    let (wrong, _) = paste(&place, &["--normal", "down.png", "--normal-convention", "opengl"]);
    assert!(same(&up, &down), "the convention stated is undone");
    assert!(!same(&up, &wrong), "a wrong one shows");
    for (file, convention) in [("up.png", "OpenGL"), ("down.png", "DirectX")] {
        let (auto, said) = paste(&place, &["--normal", file]);
        assert!(same(&auto, &up), "{file}: the convention shows in the slopes");
        assert!(said.contains("note:") && said.contains(file) && said.contains(convention), "and is told: {said}");
    }
}

#[test]
fn every_channel_may_be_named_and_sizes_are_brought_together() {
    let place = place();
    let grey = |name: &str, value: u8, size| {
        image::GrayImage::from_pixel(size, size, image::Luma([value])).save(place.path(name)).unwrap();
    };
    grey("a.png", 51, 16);
    grey("b.png", 102, 256);
    grey("c.png", 204, 256);
    let size = image::open(place.path("one.png")).unwrap().width();
    image::RgbImage::from_pixel(size, size, image::Rgb([9, 0, 200])).save(place.path("glow.png")).unwrap();
    let flags = ["--normal", "up.png", "--height", "two.png", "--roughness", "a.png", "--metallic", "b.png"];
    let (_, said) =
        paste(&place, &[&flags[..], &["--occlusion", "c.png", "--emissive", "glow.png", "--opacity", "c.png"]].concat());
    assert!(said.contains("a.png: 16 x 16 pixels were resampled"), "{said}");
    let record = lapped::format::read_record(&place.path("out/a.glb")).unwrap();
    let exemplar = &record.lapped.exemplars[0];
    assert_eq!(exemplar.channels().iter().count(), Channel::ALL.len(), "all channels arrive");
    let value = |c: Channel| exemplar.channel(c).unwrap().finest().pixel(7, 7).x;
    let found = [Channel::Roughness, Channel::Metallic, Channel::Occlusion, Channel::Opacity].map(value);
    assert_eq!(found, [0.2, 0.4, 0.8, 0.8], "each in its place");
}

#[test]
fn one_map_for_two_exemplars_is_refused() {
    let place = place();
    let out = place.run(&["paste", "--no-bake", "mesh.obj", "one.png", "wood.png", "-o", "out/a.glb", "--normal", "up.png"]);
    let said = text(&out.stderr);
    assert_eq!(out.status.code(), Some(1), "{said}");
    assert!(said.contains("up.png") && said.contains("2 exemplars") && said.contains("give one"), "{said}");
    assert!(place.files("out").is_empty(), "nothing is written");
}

#[test]
fn light_above_one_is_told_before_it_is_cut_off() {
    let place = place();
    let bright = image::Rgb32FImage::from_fn(32, 32, |x, _| image::Rgb([if x < 8 { 4.0 } else { 0.5 }; 3]));
    bright.save(place.path("bright.exr")).unwrap();
    let out = place.run(&["paste", "--no-bake", "mesh.obj", "bright.exr", "-o", "out/a.glb"]);
    let said = text(&out.stderr);
    assert_eq!(out.status.code(), Some(0), "{said}");
    assert!(said.contains("warning: bright.exr") && said.contains("25.0 %") && said.contains("above 1"), "{said}");
}
