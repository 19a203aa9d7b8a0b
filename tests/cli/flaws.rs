//! Whatever an artist has: every flaw of a mesh or an image ends in a result, told by `inspect`, or in one sentence.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use crate::program::{OCTAHEDRON, Place, text};
use serde_json::Value;
use std::f64::consts::{PI, TAU};
use std::fmt::Write;

/// An OBJ file.
fn obj(vertices: &[[f64; 3]], faces: &[[usize; 3]]) -> String {
    let mut text = String::new();
    vertices.iter().for_each(|[x, y, z]| writeln!(text, "v {x} {y} {z}").unwrap());
    faces.iter().for_each(|f| writeln!(text, "f {} {} {}", f[0] + 1, f[1] + 1, f[2] + 1).unwrap());
    text
}

/// A closed grid of `n` by `m` quads; `at` gives the place of (u, v) in [0, 1) and `twist` says that u = 1 joins u = 0 with
/// v turned round.
fn grid(n: usize, m: usize, twist: bool, close_v: bool, at: impl Fn(f64, f64) -> [f64; 3]) -> String {
    let rows = if close_v { m } else { m + 1 };
    let mut vertices = Vec::new();
    for i in 0..n {
        vertices.extend((0..rows).map(|j| at(i as f64 / n as f64, j as f64 / m as f64)));
    }
    let place = |i: usize, j: usize| {
        let j = if i == n && twist {
            if close_v { (2 * m - j) % m } else { m - j }
        } else if close_v {
            j % m
        } else {
            j
        };
        (i % n) * rows + j
    };
    let mut faces = Vec::new();
    for i in 0..n {
        for j in 0..m {
            let [a, b, c, d] = [place(i, j), place(i + 1, j), place(i + 1, j + 1), place(i, j + 1)];
            faces.extend([[a, b, c], [a, c, d]]);
        }
    }
    obj(&vertices, &faces)
}

fn moebius() -> String {
    grid(48, 6, true, false, |u, v| {
        let (a, w) = (u * TAU, v - 0.5);
        [(1.0 + w * (a / 2.0).cos()) * a.cos(), (1.0 + w * (a / 2.0).cos()) * a.sin(), w * (a / 2.0).sin()]
    })
}

/// The figure-eight immersion: it crosses itself in space, but nowhere in its edges.
fn klein() -> String {
    grid(48, 24, true, true, |u, v| {
        let (a, b) = (u * TAU, v * TAU);
        let r = 2.0 + (a / 2.0).cos() * b.sin() - (a / 2.0).sin() * (2.0 * b).sin();
        [r * a.cos(), r * a.sin(), (a / 2.0).sin() * b.sin() + (a / 2.0).cos() * (2.0 * b).sin()]
    })
}

/// Pastes on the mesh, and returns what `inspect` says of cleaning it. The cover is whole.
fn survives(place: &Place, name: &str, mesh: &str) -> Value {
    place.write(name, mesh);
    let out = place.run(&[
        "paste",
        "--size",
        "1024",
        "--mips",
        "0",
        name,
        "wood.png",
        "-o",
        "out/a.glb",
        "--report",
        "out/a.json",
        "--quiet",
        "--ratio",
        "8",
    ]);
    let said = text(&out.stderr);
    assert_eq!(out.status.code(), Some(0), "{name}: {said}");
    assert!(!said.contains("panicked"), "{name}: {said}");
    let report: Value = serde_json::from_slice(&std::fs::read(place.path("out/a.json")).unwrap()).unwrap();
    assert!(report["paste"]["least_alpha"].as_f64().unwrap() >= 0.98, "{name}: covered: {report}");
    let out = place.run(&["inspect", name, "--json"]);
    serde_json::from_slice::<Value>(&out.stdout).unwrap()["clean"].clone()
}

fn told(name: &str, report: &Value, expected: &[(&str, u64)]) {
    for &(key, count) in expected {
        assert_eq!(report[key].as_u64(), Some(count), "{name}: {key} in {report}");
    }
}

#[test]
fn surfaces_with_one_side_are_cut_open_and_covered() {
    let place = Place::new();
    let strip = survives(&place, "moebius.obj", &moebius());
    told("moebius", &strip, &[("one_sided_components", 1), ("components", 1), ("open_components", 1), ("turned_components", 0)]);
    let bottle = survives(&place, "klein.obj", &klein());
    told("klein", &bottle, &[("one_sided_components", 1), ("open_components", 1)]);
}

#[test]
fn edges_and_points_where_too_much_meets_are_parted() {
    let place = Place::new();
    // Five sheets on one edge, like the pages of a book.
    let mut vertices = vec![[0.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mut faces = Vec::new();
    for k in 0..5 {
        let a = PI * f64::from(k) / 4.0;
        vertices.extend([[a.cos(), 0.0, a.sin()], [a.cos(), 1.0, a.sin()]]);
        let n = vertices.len();
        faces.extend([[0, n - 2, n - 1], [0, n - 1, 1]]);
    }
    let book = survives(&place, "book.obj", &obj(&vertices, &faces));
    told("book", &book, &[("non_manifold_edges", 1), ("faces", 10)]);
    // Two cones, tip to tip.
    let (mut vertices, mut faces) = (vec![[0.0; 3]], Vec::new());
    for side in [-1.0, 1.0] {
        let first = vertices.len();
        vertices.extend((0..12).map(|k| {
            let a = TAU * f64::from(k) / 12.0;
            [0.5 * a.cos(), side, 0.5 * a.sin()]
        }));
        faces.extend((0..12).map(|k| [0, first + k, first + (k + 1) % 12]));
    }
    let cones = survives(&place, "cones.obj", &obj(&vertices, &faces));
    told("cones", &cones, &[("non_manifold_vertices", 1), ("components", 2), ("open_components", 2)]);
}

#[test]
fn windings_copies_and_crowds_are_mended_and_covered() {
    let place = Place::new();
    let turned = OCTAHEDRON.replace("f 3 2 5", "f 2 3 5").replace("f 1 4 6", "f 4 1 6");
    told("turned", &survives(&place, "turned.obj", &turned), &[("flipped_faces", 2), ("boundary_edges", 0)]);
    let inward: String = OCTAHEDRON
        .lines()
        .map(|l| match l.strip_prefix("f ").map(|f| f.split(' ').collect::<Vec<_>>()) {
            Some(f) => format!("f {} {} {}\n", f[0], f[2], f[1]),
            None => format!("{l}\n"),
        })
        .collect();
    told("inward", &survives(&place, "inward.obj", &inward), &[("turned_components", 1)]);
    let twice = format!("{OCTAHEDRON}f 1 3 5\nf 5 1 3\nf 3 1 5\n");
    told("twice", &survives(&place, "twice.obj", &twice), &[("duplicate_faces", 3), ("boundary_edges", 0), ("faces", 8)]);
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for k in 0..10_000 {
        let [x, y] = [k % 100, k / 100].map(f64::from);
        faces.push([0, 1, 2].map(|c| vertices.len() + c));
        vertices.extend([[x, y, 0.0], [x + 0.7, y, 0.1], [x, y + 0.7, 0.2]]);
    }
    let crowd = survives(&place, "crowd.obj", &obj(&vertices, &faces));
    told("crowd", &crowd, &[("components", 10_000), ("open_components", 10_000)]);
    assert_eq!(crowd["largest_open"].as_array().unwrap().len(), 12, "not ten thousand lines");
}

#[test]
fn size_and_place_do_not_matter() {
    let place = Place::new();
    for (scale, offset) in [(1e-6, 0.0), (1e6, 0.0), (1.0, 1e5)] {
        let moved: String = OCTAHEDRON
            .lines()
            .map(|l| match l.strip_prefix("v ") {
                Some(v) => {
                    let at: Vec<String> = v.split(' ').map(|c| format!("{}", c.parse::<f64>().unwrap() * scale + offset)).collect();
                    format!("v {}\n", at.join(" "))
                }
                None => format!("{l}\n"),
            })
            .collect();
        told(
            &format!("{scale} {offset}"),
            &survives(&place, "moved.obj", &moved),
            &[("faces", 8), ("boundary_edges", 0), ("degenerate_faces", 0)],
        );
    }
}

/// What the program says of an exemplar, and its exit code.
fn with_exemplar(place: &Place, file: &str) -> (Option<i32>, String) {
    let out = place.run(&["paste", "--no-bake", "mesh.obj", file, "-o", "out/x.glb"]);
    let said = text(&out.stderr);
    assert!(!said.contains("panicked"), "{file}: {said}");
    assert_eq!(place.path("out/x.glb").exists(), out.status.success(), "{file}: a record exactly if it worked");
    let _ = std::fs::remove_file(place.path("out/x.glb"));
    (out.status.code(), said)
}

/// A PNG header that promises an image, and next to nothing after it.
fn bomb(width: u32, height: u32) -> Vec<u8> {
    let crc = |bytes: &[u8]| {
        !bytes
            .iter()
            .fold(!0_u32, |crc, &b| (0..8).fold(crc ^ u32::from(b), |c, _| if c & 1 == 1 { c >> 1 ^ 0xEDB8_8320 } else { c >> 1 }))
    };
    let mut png = b"\x89PNG\r\n\x1a\n".to_vec();
    let mut chunk = |kind: &[u8; 4], data: &[u8]| {
        let body = [&kind[..], data].concat();
        png.extend((data.len() as u32).to_be_bytes());
        png.extend(&body);
        png.extend(crc(&body).to_be_bytes());
    };
    chunk(b"IHDR", &[&width.to_be_bytes()[..], &height.to_be_bytes(), &[8, 2, 0, 0, 0]].concat());
    chunk(b"IDAT", &[0x78, 0x9c, 0x63, 0, 0, 0, 1, 0, 1]);
    chunk(b"IEND", &[]);
    png
}

#[test]
fn images_that_are_none_are_told() {
    let place = Place::new();
    image::RgbaImage::new(64, 64).save(place.path("clear.png")).unwrap();
    image::RgbImage::new(1, 1).save(place.path("pixel.png")).unwrap();
    let photo = image::RgbImage::from_fn(256, 256, |x, y| image::Rgb([x as u8, y as u8, (x ^ y) as u8]));
    photo.save(place.path("whole.jpg")).unwrap();
    let jpeg = std::fs::read(place.path("whole.jpg")).unwrap();
    place.write("half.jpg", &jpeg[..jpeg.len() / 2]);
    place.write("bomb.png", bomb(30_000, 30_000));
    place.write("deep.png", bomb(16_384, 16_384));
    place.write("far.png", bomb(4_000_000_000, 1));
    for (file, words) in [
        ("clear.png", &["every pixel is transparent"][..]),
        ("pixel.png", &["pixel.png", "no opaque part", "use a larger"]),
        ("half.jpg", &["half.jpg", "cannot be decoded", "cut short"]),
        ("bomb.png", &["30000 x 30000", "scale it down"]),
        ("deep.png", &["16384 x 16384", "scale it down"]),
        ("far.png", &["scale it down"]),
    ] {
        let (code, said) = with_exemplar(&place, file);
        assert_eq!(code, Some(1), "{file}: {said}");
        words.iter().for_each(|w| assert!(said.contains(w), "{file} says {w:?}: {said}"));
    }
    // Long is not large.
    photo.save(place.path("a.png")).unwrap();
    image::RgbImage::from_pixel(16_384, 64, image::Rgb([90, 80, 70])).save(place.path("long.png")).unwrap();
    assert_eq!(with_exemplar(&place, "long.png").0, Some(0), "16,384 pixels across are read");
}

#[test]
fn meshes_cut_short_or_misnamed_are_told() {
    let place = Place::new();
    let out = place.run(&["paste", "--no-bake", "mesh.obj", "wood.png", "-o", "whole.glb", "--quiet"]);
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    let glb = std::fs::read(place.path("whole.glb")).unwrap();
    for share in [1, 10, 50, 99] {
        place.write("half.glb", &glb[..glb.len() * share / 100]);
        for command in [&["inspect", "half.glb"][..], &["render", "half.glb", "-o", "out/a.png"]] {
            let out = place.run(command);
            let said = text(&out.stderr);
            assert_eq!(out.status.code(), Some(1), "{share} %: {said}");
            assert!(said.starts_with("error: half.glb: ") && said.contains("export or copy it again"), "{share} %: {said}");
        }
    }
    place.write("mesh.glb", OCTAHEDRON);
    told("misnamed", &survives(&place, "mesh.ply", OCTAHEDRON), &[("faces", 8)]);
    place.write("photo.obj", std::fs::read(place.path("wood.png")).unwrap());
    let out = place.run(&["paste", "--no-bake", "photo.obj", "wood.png", "-o", "out/a.glb"]);
    assert!(text(&out.stderr).contains("a PNG image, which is not read as a mesh"), "{}", text(&out.stderr));
}
