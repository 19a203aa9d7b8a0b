//! Regions: textures where names, colours or masks say, several on one model, mixed where their borders are soft.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use crate::common::{Points, least_alpha, opened};
use crate::program::{Place, text};
use lapped::format::{Record, read_record};
use lapped::job::Bound;
use lapped::paste::{Composite, FaceLists, LappedTexture};
use lapped::surface::SurfaceTexture;
use std::fmt::Write;

const N: usize = 24;

/// A flat sheet over [0, 1]^2 with texture coordinates; material `left` up to x = 1/2, `right` beyond; vertex colours red to
/// the left and blue to the right of it, and red growing with y at the very right.
fn sheet() -> String {
    let mut obj = String::new();
    for j in 0..=N {
        for i in 0..=N {
            let [x, y] = [i, j].map(|k| k as f64 / N as f64);
            let [r, b] = if x <= 0.5 { [1.0, 0.0] } else { [0.0, 1.0] };
            writeln!(obj, "v {x} {y} 0 {r} 0 {b}\nvt {x} {y}").unwrap();
        }
    }
    for side in ["left", "right"] {
        writeln!(obj, "usemtl {side}").unwrap();
        for j in 0..N {
            for i in (0..N).filter(|i| (*i < N / 2) == (side == "left")) {
                let [a, b] = [j * (N + 1) + i + 1, j * (N + 1) + i + 2];
                let [c, d] = [b + N + 1, a + N + 1];
                writeln!(obj, "f {a}/{a} {b}/{b} {c}/{c}\nf {a}/{a} {c}/{c} {d}/{d}").unwrap();
            }
        }
    }
    obj
}

fn place() -> Place {
    let place = Place::new();
    place.write("sheet.obj", sheet());
    let ramp = image::GrayImage::from_fn(64, 64, |x, _| image::Luma([(x * 255 / 63) as u8]));
    ramp.save(place.path("ramp.png")).unwrap();
    place
}

fn paste(place: &Place, flags: &[&str]) -> Record {
    let out = place.run(&[&["paste", "--no-bake", "sheet.obj", "-o", "out/a.glb", "--quiet"], flags].concat());
    assert_eq!(out.status.code(), Some(0), "{flags:?}: {}", text(&out.stderr));
    read_record(&place.path("out/a.glb")).unwrap()
}

fn refused(place: &Place, flags: &[&str], words: &[&str]) {
    let out = place.run(&[&["paste", "--no-bake", "sheet.obj", "-o", "out/b.glb", "--quiet"], flags].concat());
    let said = text(&out.stderr);
    assert_eq!(out.status.code(), Some(1), "{flags:?}: {said}");
    assert_eq!(said.lines().count(), 1, "one sentence: {said}");
    words.iter().for_each(|w| assert!(said.contains(w), "{flags:?}: says {w:?}: {said}"));
    assert!(!place.path("out/b.glb").exists(), "nothing is written");
}

const TWO: &str = r#"
[defaults]
ratio = 6
seed = 3

[[region]]
name = "ground"
exemplar = "wood.png"
up = [0, 1, 0]

[[region]]
name = "half"
exemplar = ["rust.png"]
where = "material=ri*"
border = 0.25
field = "none"
patch = ["circle", "splotch"]
"#;

#[test]
fn regions_mix_by_their_weights_and_nothing_else() {
    let place = place();
    place.write("two.toml", TWO);
    let record = paste(&place, &["--job", "two.toml"]);
    let names: Vec<&str> = record.lapped.layers.iter().map(|l| l.name.as_str()).collect();
    assert_eq!(names, ["ground", "half"], "layers from the bottom up");
    let Bound { mesh, lapped, .. } = opened(&record);
    let ground = lapped.layers[0].pastes as usize;
    let alone = |range: std::ops::Range<usize>| LappedTexture {
        pastes: lapped.pastes[range].to_vec(),
        layers: Vec::new(),
        ..lapped.clone()
    };
    let (lower, upper) = (alone(0..ground), alone(ground..lapped.pastes.len()));
    let [both, lower, upper] = [&lapped, &lower, &upper].map(|l| Composite::new(&mesh, l));
    let (mut soft, mut bare) = (0, 0);
    for at in Points::new(&mesh).list(4000) {
        let x = f64::from(mesh.position(at).x as f32);
        let weight = lapped.layers[1].weight(at);
        // The border begins at x = 1/2 and is over at 1/4; linear within faces of 1/24.
        let t = ((0.5 - x) / 0.25).clamp(0.0, 1.0);
        let expected = 1.0 - t * t * (3.0 - 2.0 * t);
        assert!((f64::from(weight) - expected).abs() < 0.05, "weight {weight} at x = {x}, not {expected}");
        let (found, below, above) = (both.texel(at, 0.0), lower.texel(at, 0.0), upper.texel(at, 0.0));
        assert!(found.alpha > 0.98, "the ground is whole: {} at {x}", found.alpha);
        let mixed = below.base_color * (1.0 - weight) + above.base_color * weight;
        if weight == 0.0 || above.alpha > 0.98 {
            assert!((found.base_color - mixed).length() < 0.02, "{} at x = {x}, not {mixed}", found.base_color);
        }
        soft += usize::from(weight > 0.01 && weight < 0.99);
        bare += usize::from(weight == 0.0);
    }
    assert!(soft > 300 && bare > 300, "{soft} points in the border, {bare} beyond it");
}

#[test]
fn a_texture_stays_where_it_is_asked_to() {
    let place = place();
    for flags in [["--where", "material=left"], ["--where", "color=#ff0000"]] {
        let record = paste(&place, &[&["wood.png", "--ratio", "5"], &flags[..]].concat());
        let Bound { mesh, lapped, .. } = opened(&record);
        let lists = FaceLists::new(mesh.face_count(), &lapped.pastes);
        let texture = Composite::new(&mesh, &lapped);
        for at in Points::new(&mesh).list(2000) {
            let (x, alpha) = (mesh.position(at).x, texture.alpha(at));
            // A colour changes between vertices: over the one row of faces where it does.
            let edge = if flags[1].starts_with("color") { 0.5 + 1.0 / N as f64 } else { 0.5 };
            assert!(x > 0.5 || alpha > 0.98, "{flags:?}: covered at {x}: {alpha}");
            assert!(x <= edge + 1e-6 || alpha == 0.0 && lists.of(at.face).is_empty(), "{flags:?}: bare at {x}: {alpha}");
        }
    }
}

#[test]
fn masks_and_painted_channels_are_weights_as_they_are() {
    let place = place();
    let record = paste(&place, &["wood.png", "--ratio", "5", "--where", "mask=ramp.png"]);
    let layer = &record.lapped.layers[0];
    for (face, weights) in record.model.faces.iter().zip(&layer.weights) {
        for k in 0..3 {
            let x = record.model.positions[face[k] as usize].x;
            let expected = ((x * 64.0 - 0.5) / 63.0).clamp(0.0, 1.0);
            assert!((weights[k] - expected).abs() < 0.01, "mask at x = {x}: {} not {expected}", weights[k]);
        }
    }
    let record = paste(&place, &["wood.png", "--ratio", "5", "--where", "paint=blue"]);
    for (face, weights) in record.model.faces.iter().zip(&record.lapped.layers[0].weights) {
        let expected = face.map(|v| if record.model.positions[v as usize].x > 0.5 { 1.0 } else { 0.0 });
        assert_eq!(*weights, expected, "blue at the corners");
    }
}

#[test]
fn a_single_region_of_everything_is_an_ordinary_paste() {
    let place = place();
    place.write("one.toml", "[[region]]\nexemplar = \"wood.png\"\nratio = 7\n");
    let by_job = paste(&place, &["--job", "one.toml"]);
    let plain = paste(&place, &["wood.png", "--ratio", "7"]);
    assert_eq!((by_job.lapped, by_job.model), (plain.lapped, plain.model), "the same record");
    let (least, at) = least_alpha(
        &crate::common::meshed(&lapped::format::read_model(&place.path("sheet.obj")).unwrap()),
        &opened(&read_record(&place.path("out/a.glb")).unwrap()).lapped,
        5000,
    );
    assert!(least > 0.98, "covered: {least} at {at}");
}

#[test]
fn what_is_wrong_with_a_region_is_told_with_its_name() {
    let place = place();
    refused(&place, &["wood.png", "--where", "material=middle"], &["sheet.obj", "\"middle\"", "\"left\", \"right\""]);
    refused(&place, &["wood.png", "--where", "group=a"], &["names no groups"]);
    refused(&place, &["wood.png", "--where", "paint=green"], &["empty", "check the vertex colours"]);
    refused(&place, &["wood.png", "--where", "mask=nowhere.png"], &["nowhere.png", "no such file"]);
    refused(&place, &["wood.png", "--where", "mask=ramp.png", "--border", "0.1"], &["border", "paint soft edges"]);
    refused(&place, &["wood.png", "--border", "0.1"], &["--border", "--where"]);
    let job = |text: &str, words: &[&str]| {
        place.write("bad.toml", text);
        refused(&place, &["--job", "bad.toml"], &[&["bad.toml"], words].concat());
    };
    job("[[region]]\nexemplar = \"wood.png\"\nscael = 2\n", &["region 1", "scael", "keys"]);
    job("[[region]]\nexemplar = \"wood.png\"\nscale = \"big\"\n", &["region 1", "scale", "big"]);
    job("[[region]]\nexemplar = \"wood.png\"\n\n[[region\n", &["line 4"]);
    job("[[region]]\nname = \"walls\"\n", &["region 1 (\"walls\")", "no exemplar"]);
    job("", &["[[region]]"]);
    job("[[region]]\nname = \"walls\"\nexemplar = \"gone.png\"\n", &["\"walls\"", "gone.png", "no such file"]);
    let two = TWO.replace("ri*", "roof");
    job(&two, &["region 2 (\"half\")", "\"roof\"", "use one of"]);
    refused(&place, &["--job", "missing.toml"], &["missing.toml", "no such file"]);
    let both = place.run(&["paste", "sheet.obj", "wood.png", "--job", "two.toml", "-o", "out/b.glb"]);
    assert_eq!(both.status.code(), Some(2), "a job and flags of a region exclude each other: {}", text(&both.stderr));
}
