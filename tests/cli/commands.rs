//! The commands at work: what they write, what they say, and that it can be read again.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use crate::program::{Place, text};
use serde_json::Value;

fn succeeds(place: &Place, args: &[&str]) -> (String, String) {
    let out = place.run(args);
    let (stdout, stderr) = (text(&out.stdout), text(&out.stderr));
    assert_eq!(out.status.code(), Some(0), "{args:?}: {stderr}");
    (stdout, stderr)
}

fn json(place: &Place, name: &str) -> Value {
    serde_json::from_slice(&std::fs::read(place.path(name)).unwrap()).unwrap()
}

#[test]
fn paste_writes_a_record_a_picture_and_a_report_and_nothing_else() {
    let place = Place::new();
    let args = ["paste", "mesh.obj", "wood.png", "-o", "out/a.glb", "--preview", "out/a.png", "--preview-size", "200x160"];
    let (stdout, stderr) = succeeds(&place, &[&args[..], &["--report", "out/a.json"]].concat());
    assert_eq!(place.files("out"), ["a.glb", "a.json", "a.png"], "files written");
    assert!(stdout.contains("out/a.glb") && stdout.contains("draws per face"), "the result is summed up: {stdout}");
    assert!(!stderr.contains("error") && !stderr.contains("panicked"), "{stderr}");
    let picture = image::open(place.path("out/a.png")).unwrap();
    assert_eq!((picture.width(), picture.height()), (200, 160), "size of the picture");
    let report = json(&place, "out/a.json");
    assert_eq!(report["command"], "paste", "the report names the command");
    assert!(report["paste"]["least_alpha"].as_f64().unwrap() >= 0.98, "{report}");
    assert!(report["paste"]["draws_per_face"].as_f64().unwrap() >= 1.0, "{report}");
    // Another reader of glTF opens it as the plain mesh.
    let (document, buffers, _) = gltf::import(place.path("out/a.glb")).unwrap();
    let primitive = document.meshes().next().unwrap().primitives().next().unwrap();
    let indices = primitive.reader(|b| Some(&buffers[b.index()])).read_indices().unwrap().into_u32().count();
    let record = lapped::format::read_record(&place.path("out/a.glb")).unwrap();
    assert_eq!(indices, 3 * record.model.faces.len(), "faces of the plain mesh");
    assert!(!record.lapped.pastes.is_empty(), "pastes");
}

#[test]
fn an_exemplar_that_chooses_its_patches_says_why() {
    let place = Place::new();
    // Stones in mortar: squares of several greys, every other row half a stone further.
    let stone = |x: u32, y: u32| {
        let row = y / 16;
        let x = (x + row % 2 * 10) % 120;
        if y % 16 < 2 || x % 20 < 2 { 20 } else { 110 + (x / 20 * 37 + row * 53) % 90 }
    };
    image::GrayImage::from_fn(120, 128, |x, y| image::Luma([stone(x, y) as u8])).save(place.path("stones.png")).unwrap();
    let args = ["paste", "--no-bake", "mesh.obj", "-o", "out/a.glb", "--report", "out/a.json", "--patch", "auto"];
    let (_, told) = succeeds(&place, &[&args[..], &["stones.png"]].concat());
    assert!(told.contains("along dark lines") && told.contains("--field"), "says what and which way: {told}");
    let report = json(&place, "out/a.json");
    let choice = &report["choices"][0];
    assert_eq!(choice["exemplar"], "stones", "{choice}");
    assert!(choice["outlines"].as_u64().unwrap() >= 1 && choice["outlines"] == report["patches"], "{choice}");
    assert!(told.contains(choice["reasons"][0].as_str().unwrap()), "the report says the same: {choice}");
    assert!(report["paste"]["least_alpha"].as_f64().unwrap() >= 0.98, "covered");
    // Wood has no lines that close; what it gets is what it gets without being asked.
    let (_, told) = succeeds(&place, &[&args[..], &["wood.png", "--up", "y"]].concat());
    assert!(told.contains("splotches") && !told.contains("--field"), "a direction given counts: {told}");
    let chosen = std::fs::read(place.path("out/a.glb")).unwrap();
    succeeds(&place, &["paste", "--no-bake", "mesh.obj", "wood.png", "-o", "out/a.glb"]);
    assert!(std::fs::read(place.path("out/a.glb")).unwrap() == chosen, "the same pastes");
}

#[test]
fn options_of_paste_take_effect() {
    let place = Place::new();
    place.write("field.json", r#"{"version": 1, "constraints": [{"position": [1, 0, 0], "direction": [0, 0, 1], "scale": 0.5}]}"#);
    place.write("outline.json", "[[0.1, 0.1], [0.9, 0.1], [0.5, 0.9]]");
    place.write("scales.json", r#"{"version": 1, "constraints": [{"face": 0, "scale": 2}]}"#);
    let bright = |x: f32, y: f32| (x - 32.0).powi(2) + 2.0 * (y - 32.0).powi(2) < 900.0;
    let ellipse = image::GrayImage::from_fn(64, 64, |x, y| image::Luma([if bright(x as f32, y as f32) { 255 } else { 0 }]));
    ellipse.save(place.path("ellipse.png")).unwrap();
    let lines: [&[&str]; 21] = [
        &["--scale", "0.5"],
        &["--ratio", "12", "--up", "-x"],
        &["--up", "1,2,3", "--patch", "whole"],
        &["--field", "none", "--patch", "circle", "--isotropic-fit", "conformal"],
        &["--field", "none", "--scale-field", "scales.json", "--isotropic-fit", "propagated"],
        &["--field", "field.json", "--keep-faces"],
        &["--patch", "outline.json", "--feather", "1"],
        &["--patch", "ellipse.png", "--patch", "circle"],
        &["--patch", "auto"],
        &["--patch", "auto", "--patch", "circle", "--up", "z"],
        &["--predictor", "maillot", "--fit-weights", "uniform", "--distortion", "0.6"],
        &["--no-sort", "--no-cull", "--weld", "0.001", "--threads", "1"],
        &["--splotches", "1", "--seed", "18446744073709551615", "--color-only"],
        &["--plain"],
        &["--no-prune"],
        &["--no-windows", "--no-cuts", "--no-overlays"],
        &["--small"],
        &["--base", "#8a5a3c"],
        &["--keep-contrast", "--feather=12"],
        &["--equalize"],
        &["--quiet", "rust.png", "--weights", "1,3"],
    ];
    let mut seen = Vec::new();
    for extra in lines {
        let args = [&["paste", "--no-bake", "mesh.obj", "wood.png", "-o", "out/a.glb", "--report", "out/a.json"], extra].concat();
        let (stdout, _) = succeeds(&place, &args);
        assert_eq!(stdout.is_empty(), extra.contains(&"--quiet"), "{extra:?} says {stdout:?}");
        assert!(json(&place, "out/a.json")["paste"]["least_alpha"].as_f64().unwrap() >= 0.98, "{extra:?}: covered");
        let bytes = std::fs::read(place.path("out/a.glb")).unwrap();
        assert!(!seen.contains(&bytes), "{extra:?} changed nothing");
        seen.push(bytes);
    }
    let wide = lapped::format::read_record(&place.path("out/a.glb")).unwrap();
    assert_eq!(wide.lapped.exemplars.len(), 2, "two exemplars in the last one");
}

#[test]
fn render_draws_records_and_bare_meshes() {
    let place = Place::new();
    succeeds(&place, &["paste", "--no-bake", "mesh.obj", "wood.png", "-o", "out/a.glb", "--quiet"]);
    let mut pictures = Vec::new();
    let styles: [&[&str]; 5] = [
        &[],
        &["--style", "pastes"],
        &["--style", "field"],
        &["--camera", "front", "--samples", "1"],
        &["--camera", "yaw=30,pitch=15,zoom=1.2", "--transparent"],
    ];
    for (i, extra) in styles.into_iter().enumerate() {
        let out = format!("out/{i}.png");
        succeeds(&place, &[&["render", "out/a.glb", "-o", &out, "--size", "160x120"], extra].concat());
        let picture = image::open(place.path(&out)).unwrap().into_rgba8();
        assert_eq!(picture.dimensions(), (160, 120), "size with {extra:?}");
        assert!(!pictures.contains(&picture), "{extra:?} drew what another one drew");
        pictures.push(picture);
    }
    assert!(pictures[4].pixels().any(|p| p[3] == 0) && pictures[3].pixels().all(|p| p[3] == 255), "--transparent");
    succeeds(&place, &["render", "mesh.obj", "-o", "out/plain.png", "--size", "100x100", "--mode", "reference"]);
    assert!(place.files("out").contains(&"plain.png".to_owned()), "a mesh without texture is drawn too");
}

#[cfg(feature = "gpu")]
#[test]
#[ignore = "needs graphics adapters, software will do: cargo test --test cli graphics_adapters -- --include-ignored"]
fn render_draws_on_graphics_adapters() {
    let place = Place::new();
    succeeds(&place, &["paste", "--no-bake", "mesh.obj", "wood.png", "-o", "out/a.glb", "--quiet"]);
    let (listed, _) = succeeds(&place, &["inspect", "--gpu"]);
    assert!(listed.contains("vulkan") && listed.contains("gl"), "adapters are listed: {listed}");
    let draw = |mode: &str, adapter: &str| {
        let out = format!("out/{mode}-{adapter}.png");
        let args = ["render", "out/a.glb", "-o", &out, "--size", "90x70", "--camera", "front", "--mode", mode];
        let chosen: &[&str] = if adapter.is_empty() { &[] } else { &["--adapter", adapter] };
        succeeds(&place, &[args.as_slice(), chosen].concat());
        image::open(place.path(&out)).unwrap().into_rgb8()
    };
    let expected = draw("reference", "");
    for (mode, adapter) in [("single", "vulkan"), ("layered", "vulkan"), ("single", "gl"), ("layered", "gl"), ("auto", "gl")] {
        let drawn = draw(mode, adapter);
        let sum: u64 = expected.as_raw().iter().zip(drawn.as_raw()).map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
        assert!(sum < expected.as_raw().len() as u64 / 2, "{mode} on {adapter}: {sum} steps in all");
    }
    for adapter in ["vulkan", "gl"] {
        let args = ["paste", "mesh.obj", "wood.png", "-o", "out/gpu.glb", "--coverage", "gpu", "--adapter", adapter];
        let (said, _) = succeeds(&place, &args);
        assert!(said.contains("least alpha 0.99") || said.contains("least alpha 1.0"), "nothing is left bare: {said}");
    }
}

#[test]
fn a_turntable_is_an_animation_or_a_folder() {
    let place = Place::new();
    let turn = |out: &str| {
        succeeds(&place, &["render", "mesh.obj", "-o", out, "--turntable", "3", "--size", "40x30", "--mode", "reference"]);
    };
    turn("out/turn.gif");
    turn("out/turn.apng");
    turn("out/turn");
    let start = |file: &str| std::fs::read(place.path(file)).unwrap();
    assert!(start("out/turn.gif").starts_with(b"GIF89a"), "a GIF");
    assert!(start("out/turn.apng").windows(4).any(|w| w == b"acTL"), "an animated PNG");
    assert_eq!(place.files("out/turn").len(), 3, "three files");
}

#[test]
fn inspect_tells_meshes_records_and_images_apart() {
    let place = Place::new();
    succeeds(&place, &["paste", "--no-bake", "mesh.obj", "wood.png", "-o", "out/a.glb", "--quiet"]);
    for file in ["mesh.obj", "out/a.glb", "wood.png"] {
        let (plain, _) = succeeds(&place, &["inspect", file]);
        assert!(!plain.trim().is_empty(), "{file}: something is told");
        let (told, _) = succeeds(&place, &["inspect", file, "--json"]);
        let value: Value = serde_json::from_str(&told).unwrap();
        let kind = value["kind"].as_str().unwrap().to_owned();
        let expected = if file == "mesh.obj" {
            "mesh"
        } else if file == "wood.png" {
            "exemplar"
        } else {
            "record"
        };
        assert_eq!(kind, expected, "{file}");
    }
    let (told, _) = succeeds(&place, &["inspect", "mesh.obj"]);
    assert!(told.contains('8'), "eight faces are told: {told}");
}

#[test]
fn help_and_version_go_to_stdout_and_every_command_shows_examples() {
    let place = Place::new();
    let (help, _) = succeeds(&place, &["--help"]);
    assert!(help.contains("Examples:") && help.contains("lapped paste"), "{help}");
    for command in ["paste", "render", "inspect", "demo"] {
        let (help, _) = succeeds(&place, &[command, "--help"]);
        assert!(help.contains("Examples:") || command == "demo", "{command}: {help}");
        assert!(help.contains("--threads") && help.contains("--report"), "{command}: {help}");
    }
    let (version, _) = succeeds(&place, &["--version"]);
    assert!(version.contains(env!("CARGO_PKG_VERSION")), "{version}");
}

#[test]
fn completions_and_manual_pages_know_every_command_and_flag() {
    let place = Place::new();
    let (help, _) = succeeds(&place, &["paste", "--help"]);
    let flags: Vec<&str> = help
        .split_whitespace()
        .filter(|w| w.starts_with("--") && w[2..].chars().all(|c| c.is_ascii_lowercase() || c == '-'))
        .collect();
    assert!(flags.len() > 30, "flags of the help: {flags:?}");
    std::fs::create_dir(place.path("out/man")).unwrap();
    succeeds(&place, &["man", "-o", "out/man"]);
    let page = std::fs::read_to_string(place.path("out/man/lapped-paste.1")).unwrap().replace("\\-", "-");
    let mut texts = vec![("lapped-paste.1", page)];
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        texts.push((shell, succeeds(&place, &["completions", shell]).0));
    }
    for (what, text) in &texts {
        let missing: Vec<_> = flags.iter().filter(|f| !text.contains(if *what == "fish" { &f[2..] } else { f })).collect();
        assert!(missing.is_empty(), "{what} lacks {missing:?}");
    }
    let pages = place.files("out/man");
    assert!(
        ["lapped.1", "lapped-demo.1", "lapped-inspect.1", "lapped-render.1"].iter().all(|p| pages.contains(&(*p).to_owned())),
        "{pages:?}"
    );
    let (whole, _) = succeeds(&place, &["man"]);
    assert!(whole.contains(".TH lapped 1"), "{whole}");
}

#[test]
fn wrong_usage_exits_with_2_and_shows_usage() {
    let place = Place::new();
    let lines: [&[&str]; 10] = [
        &[],
        &["past"],
        &["paste", "mesh.obj", "-o", "out/a.glb"],
        &["paste", "mesh.obj", "wood.png"],
        &["paste", "mesh.obj", "wood.png", "-o", "out/a.glb", "--scale", "large"],
        &["paste", "mesh.obj", "wood.png", "-o", "out/a.glb", "--up", "0,0,0"],
        &["paste", "mesh.obj", "wood.png", "-o", "out/a.glb", "--scale", "1", "--ratio", "3"],
        &["paste", "mesh.obj", "wood.png", "-o", "out/a.glb", "--preview-size", "10by10"],
        &["render", "mesh.obj", "-o", "out/a.png", "--camera", "yaw=up"],
        &["render", "mesh.obj", "-o", "out/a.png", "--samples", "0"],
    ];
    for args in lines {
        let out = place.run(args);
        let stderr = text(&out.stderr);
        assert_eq!(out.status.code(), Some(2), "{args:?}: {stderr}");
        assert!(stderr.contains("Usage:") || stderr.contains("--help"), "{args:?}: {stderr}");
        assert!(out.stdout.is_empty() && !stderr.contains("panicked"), "{args:?}: {stderr}");
    }
    assert!(place.files("out").is_empty(), "nothing was written: {:?}", place.files("out"));
}

#[test]
fn threads_change_no_byte_of_what_is_written() {
    let place = Place::new();
    for threads in ["1", "2", "3"] {
        let out = format!("out/{threads}.glb");
        succeeds(
            &place,
            &["paste", "--size", "256", "mesh.obj", "wood.png", "-o", &out, "--ratio", "60", "--threads", threads, "--quiet"],
        );
    }
    let bytes = ["1", "2", "3"].map(|t| std::fs::read(place.path(&format!("out/{t}.glb"))).unwrap());
    assert!(bytes[0] == bytes[1] && bytes[1] == bytes[2], "1, 2 and 3 threads write the same bytes");
}

#[test]
fn demo_shows_every_model_and_the_method() {
    let place = Place::new();
    let (stdout, _) = succeeds(&place, &["demo", "-o", "out/demo", "--report", "out/demo.json"]);
    let files = place.files("out/demo");
    let records: Vec<_> = files.iter().filter(|f| f.ends_with(".glb")).collect();
    assert!(records.len() >= 4 && files.contains(&"gallery.png".to_owned()), "{files:?}");
    for style in ["pastes", "field", "coverage", "stretch", "wireframe"] {
        assert!(files.iter().any(|f| f.ends_with(&format!("-{style}.png"))), "a picture of {style}: {files:?}");
    }
    assert!(files.iter().all(|f| !f.starts_with('.')), "no temporary file is left: {files:?}");
    assert!(stdout.contains("gallery.png"), "it says where to look: {stdout}");
    let report = json(&place, "out/demo.json");
    for model in report["models"].as_array().unwrap() {
        let name = model["name"].as_str().unwrap();
        assert!(model["paste"]["least_alpha"].as_f64().unwrap() >= 0.98, "{name} is covered");
        let record = lapped::format::read_record(&place.path(&format!("out/demo/{name}.glb"))).unwrap();
        assert!(!record.lapped.pastes.is_empty(), "{name} has pastes");
        let picture = image::open(place.path(&format!("out/demo/{name}.png"))).unwrap().into_rgb8();
        let first = *picture.get_pixel(0, 0);
        assert!(picture.pixels().any(|p| *p != first), "{name} was drawn");
    }
}
