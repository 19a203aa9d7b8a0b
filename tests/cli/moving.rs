//! Models that move, on the command line: pasted, drawn at a moment, played.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use crate::glb::bending;
use crate::program::{Place, text};

fn runs(place: &Place, args: &[&str]) {
    let out = place.run(args);
    assert_eq!(out.status.code(), Some(0), "{args:?}: {}", text(&out.stderr));
}

fn told(place: &Place, args: &[&str], code: i32) -> String {
    let out = place.run(args);
    assert_eq!(out.status.code(), Some(code), "{args:?}: {}", text(&out.stderr));
    text(&out.stderr)
}

/// A place with a tail that bends, and a record of it.
fn tail() -> Place {
    let place = Place::new();
    let (gltf, rest) = bending(10, 12);
    place.write("tail.glb", gltf.glb(rest));
    runs(&place, &["paste", "tail.glb", "wood.png", "-o", "a.glb", "--ratio", "10", "--quiet"]);
    place
}

#[test]
fn a_record_of_a_model_that_moves_is_drawn_at_a_moment_or_played() {
    let place = tail();
    let draw = |model: &str, out: &str, extra: &[&str]| {
        let args = ["render", model, "-o", out, "--size", "60x60", "--samples", "1", "--camera", "front", "--mode", "reference"];
        runs(&place, &[&args, extra].concat());
    };
    let picture = |file: &str| image::open(place.path(file)).unwrap().into_rgba8();
    draw("a.glb", "out/rest.png", &[]);
    for (time, extra) in [("0", &[][..]), ("1", &["--animation", "bend"]), ("1.5", &["--animation", "0"])] {
        draw("a.glb", &format!("out/{time}.png"), &[&["--time", time], extra].concat());
    }
    // In steps of 1/255 over the whole picture.
    let apart = |a: &str, b: &str| -> u64 {
        let (a, b) = (picture(a), picture(b));
        a.as_raw().iter().zip(b.as_raw()).map(|(a, b)| u64::from(a.abs_diff(*b))).sum()
    };
    assert!(apart("out/rest.png", "out/0.png") < 2000, "it begins at rest");
    assert!(apart("out/0.png", "out/1.png") > 20_000, "and bends");
    draw("tail.glb", "out/bare.png", &["--time", "1", "--transparent"]);
    let bare = picture("out/bare.png");
    assert!(bare.pixels().any(|p| p[3] == 255), "a bare mesh moves too");
    draw("a.glb", "out/play", &["--play"]);
    assert_eq!(place.files("out/play").len(), 48, "two seconds, 24 pictures each");
    let frame = |k: usize| format!("out/play/{k:04}.png");
    assert!(apart(&frame(12), &frame(36)) < 2000, "it goes back the way it came, before one camera");
    assert!(apart(&frame(0), &frame(24)) > 20_000, "and moves between");
    draw("a.glb", "out/play.apng", &["--play", "--transparent"]);
    let file = std::fs::read(place.path("out/play.apng")).unwrap();
    assert!(file.windows(4).any(|w| w == b"acTL"), "or an animated PNG");
}

#[test]
fn what_can_be_played_is_listed() {
    let place = tail();
    let out = place.run(&["inspect", "a.glb"]);
    assert!(text(&out.stdout).contains("0: \"bend\", 2.00 s"), "number, name and length: {}", text(&out.stdout));
    let out = place.run(&["inspect", "tail.glb", "--json"]);
    let found: serde_json::Value = serde_json::from_slice(&out.stdout).unwrap();
    assert_eq!(found["motion"]["animations"][0]["name"], "bend", "and for programs");
    let out = place.run(&["inspect", "mesh.obj", "--json"]);
    let found: serde_json::Value = serde_json::from_slice(&out.stdout).unwrap();
    assert!(found["motion"].is_null(), "a model that stands still");
}

#[test]
fn what_cannot_be_played_is_told() {
    let place = tail();
    let render = |model, extra: &[&'static str], code| told(&place, &[&["render", model, "-o", "out/a.png"], extra].concat(), code);
    assert!(render("mesh.obj", &["--time", "1"], 1).contains("has an animation"), "nothing moves");
    assert!(render("a.glb", &["--time", "1", "--animation", "walk"], 1).contains("\"bend\""), "the ones there are");
    assert!(render("a.glb", &["--animation", "bend"], 1).contains("--play"), "a name alone");
    assert!(render("a.glb", &["--time", "1", "--style", "stretch"], 1).contains("--time"), "a style of the rest pose");
    assert!(render("a.glb", &["--play", "--style", "pastes"], 1).contains("texture"), "a style that is not played");
    assert!(render("a.glb", &["--play", "--turntable", "9"], 2).contains("--turntable"), "one or the other");
    assert!(render("a.glb", &["--time", "-1"], 2).contains("0 or more"), "before the begin");
    assert!(place.files("out").is_empty(), "and nothing is left behind");
}

#[test]
fn an_exemplar_that_changes_is_pasted_drawn_at_a_moment_and_played() {
    let place = Place::new();
    // Two cells: dark red blobs, then blue ones.
    let sheet = image::RgbImage::from_fn(64, 32, |x, y| {
        let grey = ((x % 32 / 4 * 7 + y / 4 * 5) % 11) as u8 * 12 + 60;
        image::Rgb(if x < 32 { [grey, 0, 0] } else { [0, 0, grey] })
    });
    sheet.save(place.path("sheet.png")).unwrap();
    let paste = |out: &str, extra: &[&str]| {
        let args = ["paste", "mesh.obj", "sheet.png", "-o", out, "--ratio", "6", "--no-bake", "--sprites", "2x1"];
        place.run(&[&args, extra].concat())
    };
    let out = paste("out/b.glb", &["--fps", "6"]);
    let said = text(&out.stdout) + &text(&out.stderr);
    assert!(out.status.success() && said.contains("2 frames, shown over 0.33 s"), "{said}");
    let draw = |model: &str, out: &str, extra: &[&str]| {
        let args = ["render", model, "-o", out, "--size", "40x40", "--samples", "1", "--camera", "front", "--mode", "reference"];
        place.run(&[&args, extra].concat())
    };
    // Sums of red and blue over the model.
    let colours = |file: &str| {
        let picture = image::open(place.path(file)).unwrap().into_rgba8();
        let seen = picture.pixels().filter(|p| p[3] == 255);
        seen.fold([0_u64; 2], |[red, blue], p| [red + u64::from(p[0]), blue + u64::from(p[2])])
    };
    for (time, is_red) in [("0", true), ("0.1", true), ("0.2", false), ("0.4", true)] {
        let out = draw("out/b.glb", "out/b.png", &["--time", time, "--transparent"]);
        assert!(out.status.success(), "{}", text(&out.stderr));
        let [red, blue] = colours("out/b.png");
        assert_eq!(red > 2 * blue, is_red, "at {time} s: red {red}, blue {blue}");
        assert_eq!(blue > 2 * red, !is_red, "at {time} s: red {red}, blue {blue}");
    }
    assert!(draw("out/b.glb", "out/play", &["--play", "--transparent"]).status.success(), "it is played");
    let red: Vec<bool> = place.files("out/play").iter().map(|f| colours(&format!("out/play/{f}"))).map(|[r, b]| r > b).collect();
    assert_eq!(red, [true, true, true, true, false, false, false, false], "24 pictures a second, six frames a second");

    // A job file says the same, as numbers.
    let job = "[[region]]\nexemplar = \"sheet.png\"\nratio = 6\nsprites = \"2x1\"\nfps = 6\n";
    std::fs::write(place.path("job.toml"), job).unwrap();
    let by_job = place.run(&["paste", "mesh.obj", "--job", "job.toml", "-o", "out/j.glb", "--no-bake"]);
    assert!(by_job.status.success(), "{}", text(&by_job.stderr));
    let [flags, file] = ["out/b.glb", "out/j.glb"].map(|f| lapped::format::read_record(&place.path(f)).unwrap().lapped);
    assert_eq!(file.exemplars[0].frames(), flags.exemplars[0].frames(), "two frames, a sixth of a second each");

    // By view there is nothing to play.
    assert!(paste("out/v.glb", &["--frames", "view"]).status.success(), "the same cells by view");
    for (model, extra) in [("out/v.glb", &["--play"][..]), ("mesh.obj", &["--time", "1"])] {
        let out = draw(model, "out/none", extra);
        let said = text(&out.stderr);
        assert!(!out.status.success() && said.contains("neither the model nor its texture has an animation"), "{said}");
    }
    // What changes is told, and where it cannot.
    for (file, words) in [("out/b.glb", "2 frames over 0.33 s"), ("out/v.glb", "2 frames by the angle to the eye")] {
        let found = text(&place.run(&["inspect", file]).stdout);
        assert!(found.contains(words), "{found}");
    }
    let said = told(&place, &["bake", "out/b.glb", "-o", "out/baked.glb", "--size", "64"], 0);
    assert!(said.contains("one moment") && said.contains("--time"), "{said}");
    let said = told(&place, &["bake", "out/v.glb", "-o", "out/baked.glb", "--size", "64"], 0);
    assert!(said.contains("shows the first alone"), "{said}");
    for (time, is_red) in [("0", true), ("0.2", false)] {
        let args = ["bake", "out/b.glb", "-o", "out/still.obj", "--size", "64", "--time", time, "--quiet"];
        assert!(place.run(&args).status.success());
        let map = place.files("out").into_iter().find(|f| f.starts_with("still") && f.ends_with(".png")).unwrap();
        let [red, blue] = colours(&format!("out/{map}"));
        assert_eq!(red > blue, is_red, "baked at {time} s: red {red}, blue {blue}");
    }
    let said = text(&paste("out/f.glb", &["--frames", "first"]).stderr);
    assert!(said.contains("leave out one of them"), "{said}");
    let said = text(&paste("out/v.glb", &["--frames", "light", "--fps", "6"]).stderr);
    assert!(said.contains("change nothing: its frames do not go by time"), "{said}");
    let out = paste("out/f.glb", &["--sprites", "3x1"]);
    assert!(!out.status.success(), "one sheet has one number of cells");
}
