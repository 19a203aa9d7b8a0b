//! `inspect` tells what is in a file and what a job on it will take, and is right about it.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use crate::program::{Place, text};
use lapped::job::estimate::TRUST;
use serde_json::Value;
use std::path::Path;

fn run(place: &Place, args: &[&str]) -> String {
    let out = place.run(args);
    assert_eq!(out.status.code(), Some(0), "{args:?}: {}", text(&out.stderr));
    text(&out.stdout)
}

fn inspected(place: &Place, args: &[&str]) -> Value {
    serde_json::from_str(&run(place, &[&["inspect", "--json"], args].concat())).unwrap()
}

/// A box without lid, one of its faces turned, a stray triangle beside it with a doubled corner 1e-4 away, and a copy.
const FLAWED: &str = "# units: cm\no box\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
    f 1 4 3 2\nf 1 2 6 5\nf 2 3 7 6\nf 4 3 7 8\nf 4 1 5 8\no stray\nv 5 0 0\nv 6 0 0\nv 5 1 0\nv 6.0001 0 0\nv 6 1 0\n\
    f 9 10 11\nf 12 13 11\nf 10 11 9\nf 9 9 10\n";

#[test]
fn flaws_are_told_in_words_and_numbers() {
    let place = Place::new();
    place.write("flawed.obj", FLAWED);
    let plain = run(&place, &["inspect", "flawed.obj"]);
    for told in [
        "unit cm",
        "up not stated",
        "2 faces turned",
        "1 second copies",
        "1 faces without area",
        "3 component(s), 3 open",
        "open: 10 faces with 4 boundary edges (object \"box\", around face 0)",
        "object \"stray\": 4",
        "bounds        (0, 0, 0) to (6.0001, 1, 1)",
        "would choose --scale",
        "of memory",
    ] {
        assert!(plain.contains(told), "{told:?} is told:\n{plain}");
    }
    let clean = |args: &[&str]| inspected(&place, &[&["flawed.obj"], args].concat())["clean"].clone();
    let exact = clean(&[]);
    assert_eq!((&exact["components"], &exact["welded_vertices"]), (&3.into(), &0.into()), "a gap of 1e-4 stays open: {exact}");
    let welded = clean(&["--weld", "0.001"]);
    assert_eq!((&welded["components"], &welded["welded_vertices"]), (&2.into(), &1.into()), "--weld closes it: {welded}");
}

#[test]
fn what_goes_out_has_the_users_faces_in_the_users_order_and_winding() {
    let place = Place::new();
    place.write("flawed.obj", FLAWED);
    run(&place, &["paste", "--no-bake", "flawed.obj", "wood.png", "-o", "out/a.glb", "--keep-faces", "--quiet"]);
    let came = lapped::format::read_model(&place.path("flawed.obj")).unwrap();
    let went = lapped::format::read_record(&place.path("out/a.glb")).unwrap().model;
    assert_eq!((went.faces, went.positions, went.groups), (came.faces, came.positions, came.groups), "whatever cleaning turned");
}

#[test]
fn pastes_and_memory_of_the_demo_meshes_are_within_a_factor_of_two_of_the_estimate() {
    let place = Place::new();
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets");
    for (mesh, exemplar, flags) in [
        ("dragonling", "scales_color", &["--ratio", "60"][..]),
        ("knot", "pebbles_color", &["--field", "none", "--ratio", "30"]),
        ("gear", "rust_color", &["--field", "none"]),
        ("vase", "bricks_color", &["--ratio", "160"]),
        ("terrain", "leaves_color", &[]),
    ] {
        let mesh_file = assets.join(format!("meshes/{mesh}.ply"));
        let exemplar = assets.join(format!("exemplars/{exemplar}.png"));
        let files = [mesh_file.to_str().unwrap(), exemplar.to_str().unwrap()];
        run(&place, &[&["paste", files[0], files[1], "-o", "out/a.glb", "--report", "out/a.json", "--no-bake"], flags].concat());
        let report: Value = serde_json::from_slice(&std::fs::read(place.path("out/a.json")).unwrap()).unwrap();
        let check = |what: &str, real: f64, told: &Value| {
            let told = told.as_f64().unwrap();
            assert!(told <= TRUST * real && real <= TRUST * told, "{mesh}: {what} were thought to be {told:.0}, and are {real:.0}");
        };
        check("pastes", report["paste"]["pastes"].as_f64().unwrap(), &report["estimate"]["pastes"]);
        if let Some(peak) = report["peak_memory_bytes"].as_f64() {
            check("bytes of memory", peak, &report["estimate"]["memory_bytes"]);
        }
    }
}

#[test]
fn a_job_too_large_for_memory_is_refused_with_the_estimate() {
    let place = Place::new();
    let out = place.run(&["paste", "mesh.obj", "wood.png", "-o", "out/a.glb", "--memory", "3M"]);
    let said = text(&out.stderr);
    assert_eq!(out.status.code(), Some(1), "{said}");
    for word in ["MB of memory", "but 3 MB may be used", "use a larger scale", "--memory"] {
        assert!(said.contains(word), "{word:?}: {said}");
    }
    assert!(place.files("out").is_empty(), "nothing is written");
    run(&place, &["paste", "--no-bake", "mesh.obj", "wood.png", "-o", "out/a.glb", "--memory", "1G"]);
}

/// Rows of the table of the corpus's index that begins with these heads.
fn rows(index: &str, heads: &str) -> Vec<Vec<String>> {
    let table = index.lines().skip_while(|l| !l.starts_with(heads)).skip(2).take_while(|l| l.starts_with('|'));
    table.map(|line| line.trim_matches('|').split('|').map(|c| c.trim().to_owned()).collect()).collect()
}

/// The numbers in a text.
fn numbers(text: &str) -> Vec<f64> {
    text.split([' ', ',', '/']).filter_map(|w| w.parse().ok()).collect()
}

#[test]
fn every_mesh_of_the_corpus_has_the_counts_of_its_index() {
    let Some(corpus) = crate::folder::corpus() else { return };
    let index = std::fs::read_to_string(corpus.join("INDEX.md")).unwrap();
    let place = Place::new();
    let (meshes, welded) = (rows(&index, "| file | MB |"), rows(&index, "| file | result |"));
    let sizes = rows(&index, "| file | bbox min |");
    assert_eq!((meshes.len(), sizes.len(), welded.len()), (24, 24, 5), "the tables are found");
    for (row, size) in meshes.iter().zip(&sizes) {
        let name = &row[0];
        let told = inspected(&place, &[corpus.join("meshes").join(name).to_str().unwrap()]);
        let is = |what: &str, found: &Value, expected: f64| {
            assert_eq!(found.as_f64(), Some(expected), "{name}: {what}");
        };
        let clean = &told["clean"];
        is("vertices", &told["file_vertices"], numbers(&row[2])[0]);
        is("triangles", &clean["faces_in"], numbers(&row[3])[0]);
        is("vertices without a face", &clean["unreferenced_vertices"], numbers(&row[13])[0]);
        is("closed parts turned outward", &clean["turned_components"], f64::from(u8::from(row[14] == "INWARD")));
        for (corner, cell) in [("bounds_min", &size[1]), ("bounds_max", &size[2])] {
            for (k, expected) in numbers(cell).into_iter().enumerate() {
                let found = told[corner][k].as_f64().unwrap();
                if numbers(&row[13])[0] > 0.0 {
                    // The index counts vertices without a face in; ours are the bounds of the surface.
                    let within = if corner == "bounds_min" { found - expected } else { expected - found };
                    assert!(within > -0.006 * expected.abs(), "{name}: {corner} {k}: {found} lies beyond {expected}");
                    continue;
                }
                assert!((found - expected).abs() <= 0.006 * expected.abs() + 1e-5, "{name}: {corner} {k}: {found}, not {expected}");
            }
        }
        // Topology is told after welding; where that changes something, the second table has it.
        let after: Vec<f64> = match welded.iter().find(|w| w[0] == *name) {
            Some(row) => {
                let part = |key: &str| numbers(row[1].split_once(key).unwrap().1);
                let manifold = part("non-manifold ");
                [part("parts ")[0], part("Euler ")[0]]
                    .into_iter()
                    .chain(part("boundary ")[..2].to_vec())
                    .chain(manifold[..2].to_vec())
                    .collect()
            }
            None => {
                assert_eq!(row[12], "0", "{name}: nothing to weld");
                is("copies of faces", &clean["duplicate_faces"], numbers(&row[11])[0]);
                [numbers(&row[4])[0], numbers(&row[5])[0]].into_iter().chain(numbers(&row[7])).chain(numbers(&row[8])).collect()
            }
        };
        // Parting what is not manifold, and dropping copies, changes these.
        if after[4..6] == [0.0, 0.0] && numbers(&row[11])[0] == 0.0 {
            let keys = ["components", "euler_characteristic", "boundary_edges", "boundary_loops"];
            let by_index = numbers(&row[10])[0].max(if name == "dragon.ply" { 108.0 } else { 0.0 });
            let dropped = clean["degenerate_faces"].as_f64().unwrap() - by_index;
            if dropped == 0.0 {
                keys.iter().zip(&after).for_each(|(key, &expected)| is(key, &clean[*key], expected));
            } else {
                // Faces with three corners but no area leave holes where they lay.
                is("parts", &clean["components"], after[0]);
                is("Euler characteristic", &clean["euler_characteristic"], after[1] - dropped);
            }
        } else if numbers(&row[11])[0] == 0.0 {
            is("non-manifold edges", &clean["non_manifold_edges"], after[4]);
            is("non-manifold vertices", &clean["non_manifold_vertices"], after[5]);
        }
    }
}
