//! The demo assets: they are whole, clean, small, and what the generator makes.

#[path = "../examples/make_assets/generate/mod.rs"]
mod generate;

use generate::{EXEMPLARS, MESHES, MeshAsset, Triangles};
use glam::{DVec3, Vec3};
use lapped::mesh::{CleanOptions, CleanReport, Mesh, clean};
use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;

fn folder(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("assets").join(name)
}

fn files(name: &str) -> Vec<(String, u64)> {
    let entries = fs::read_dir(folder(name)).expect("the folder of assets");
    let mut found: Vec<_> = entries
        .map(|entry| {
            let entry = entry.expect("a folder entry");
            (entry.file_name().into_string().expect("a plain name"), entry.metadata().expect("file data").len())
        })
        .collect();
    found.sort();
    found
}

/// The committed mesh, read here by hand: a second opinion on the layout of the files.
fn stored(file: &str) -> Triangles {
    let bytes = fs::read(folder("meshes").join(file)).expect("a mesh file of the catalogue");
    let mut mesh = Triangles::default();
    if file.ends_with(".obj") {
        for line in String::from_utf8(bytes).expect("OBJ is text").lines() {
            let words: Vec<&str> = line.split(' ').collect();
            match words[0] {
                "v" => mesh.positions.push(DVec3::from_array([1, 2, 3].map(|k| words[k].parse().expect("a coordinate")))),
                _ => mesh.faces.push([1, 2, 3].map(|k| words[k].parse::<u32>().expect("a vertex number") - 1)),
            }
        }
        return mesh;
    }
    let end = bytes.windows(11).position(|w| w == b"end_header\n").expect("a PLY header") + 11;
    let header = std::str::from_utf8(&bytes[..end]).expect("an ASCII header");
    let count = |element: &str| -> usize {
        let line = header.lines().find_map(|l| l.strip_prefix(element)).expect("the element");
        line.trim().parse().expect("a count")
    };
    let (vertices, faces) = (count("element vertex"), count("element face"));
    let word = |at: usize| -> [u8; 4] { bytes[at..at + 4].try_into().expect("4 bytes") };
    let float = |at: usize| f64::from(f32::from_le_bytes(word(at)));
    mesh.positions = (0..vertices).map(|i| DVec3::from_array([0, 4, 8].map(|k| float(end + 12 * i + k)))).collect();
    let start = end + 12 * vertices;
    assert_eq!(bytes.len(), start + 13 * faces, "{file} holds just its vertices and faces");
    mesh.faces = (0..faces).map(|i| [1, 5, 9].map(|k| i32::from_le_bytes(word(start + 13 * i + k)) as u32)).collect();
    mesh
}

fn cleaned(asset: &MeshAsset) -> (Mesh, CleanReport) {
    let mesh = stored(asset.file);
    let positions: Vec<Vec3> = mesh.positions.iter().map(|p| p.as_vec3()).collect();
    let cleaned = clean(&positions, &mesh.faces, &CleanOptions::default()).expect("a mesh");
    (cleaned.mesh, cleaned.report)
}

#[test]
fn the_folders_hold_what_the_catalogue_lists_and_stay_small() {
    let meshes: BTreeSet<String> = files("meshes").into_iter().map(|f| f.0).collect();
    let listed: BTreeSet<String> = MESHES.iter().map(|m| m.file.to_string()).collect();
    assert_eq!(meshes, listed, "meshes: run `cargo run --release --example make_assets`");
    let exemplars: BTreeSet<String> = files("exemplars").into_iter().map(|f| f.0).collect();
    let parts = |relief: bool| if relief { &["color", "normal", "height"][..] } else { &["color"][..] };
    let listed: BTreeSet<String> =
        EXEMPLARS.iter().flat_map(|e| parts(e.relief).iter().map(|p| format!("{}_{p}.png", e.name))).collect();
    assert_eq!(exemplars, listed, "exemplars: run `cargo run --release --example make_assets`");
    assert_eq!((meshes.len(), EXEMPLARS.len(), exemplars.len()), (7, 12, 22), "meshes, exemplars, pictures");
    let bytes: u64 = [files("meshes"), files("exemplars")].iter().flatten().map(|f| f.1).sum();
    assert!(bytes < 7_000_000, "{bytes} bytes of assets weigh on every clone");
}

#[test]
fn meshes_need_no_cleaning() {
    for asset in MESHES {
        let (mesh, report) = cleaned(asset);
        let mended = [
            report.unreferenced_vertices,
            report.welded_vertices,
            report.degenerate_faces,
            report.duplicate_faces,
            report.flipped_faces,
            report.turned_components,
            report.non_manifold_edges,
            report.non_manifold_vertices,
        ];
        assert_eq!(mended, [0; 8], "{}: {report:?}", asset.file);
        assert_eq!(report.components, 1, "{} is one piece", asset.file);
        let (loops, euler) = match asset.file.split(['.', '_']).next().unwrap() {
            "dragonling" => (0, 2),
            "knot" => (0, 0),
            // Bore and five holes: genus 6.
            "gear" => (0, 2 - 2 * 6),
            "vase" | "terrain" => (1, 1),
            other => panic!("{other}: say here what its topology is"),
        };
        assert_eq!((report.boundary_loops, report.euler_characteristic), (loops, euler), "{}: topology", asset.file);
        if loops == 0 {
            let volume: f64 = (0..mesh.face_count() as u32)
                .map(|f| {
                    let [a, b, c] = mesh.corners(f);
                    a.dot(b.cross(c)) / 6.0
                })
                .sum();
            assert!(volume > 0.0, "{} is inside out: volume {volume}", asset.file);
        }
        let (low, high) = mesh.bounds();
        let size = high - low;
        assert!(low.y.abs() < 0.02, "{} stands at y = {}", asset.file, low.y);
        assert!((1.7..2.6).contains(&size.max_element()), "{} is about 2 units in size: {size}", asset.file);
    }
}

#[test]
fn triangles_are_well_shaped() {
    for asset in MESHES {
        let (mesh, _) = cleaned(asset);
        let mut angles: Vec<f64> = (0..mesh.face_count() as u32)
            .map(|f| {
                let p = mesh.corners(f);
                let angle = |k: usize| (p[(k + 1) % 3] - p[k]).angle_between(p[(k + 2) % 3] - p[k]).to_degrees();
                angle(0).min(angle(1)).min(angle(2))
            })
            .collect();
        angles.sort_by(f64::total_cmp);
        let (worst, median) = (angles[0], angles[angles.len() / 2]);
        assert!(worst > 10.0 && median > 38.0, "{}: smallest angles: worst {worst:.1}, median {median:.1}", asset.file);
    }
}

#[test]
fn meshes_come_out_the_same_again() {
    // The dragonlings take seconds in an unoptimised build; the smaller of them stands for both.
    for asset in MESHES.iter().filter(|m| m.file != "dragonling_25k.ply") {
        let made = fs::read(folder("meshes").join(asset.file)).unwrap();
        assert!(made == asset.bytes(), "{} differs: run `cargo run --release --example make_assets`", asset.file);
    }
}

#[test]
fn exemplars_come_out_the_same_again() {
    // Pixels are compared, so that another version of the PNG encoder may pack them otherwise.
    for name in ["weave", "stripes"] {
        let asset = EXEMPLARS.iter().find(|e| e.name == name).unwrap();
        for (file, bytes) in asset.files().unwrap() {
            let stored = image::open(folder("exemplars").join(&file)).unwrap();
            let made = image::load_from_memory(&bytes).unwrap();
            assert!(stored == made, "{file} differs: run `cargo run --release --example make_assets`");
        }
    }
}

#[test]
fn pictures_of_an_exemplar_are_aligned_and_normals_are_unit_vectors() {
    for asset in EXEMPLARS {
        let open = |part: &str| image::open(folder("exemplars").join(format!("{}_{part}.png", asset.name))).unwrap();
        let color = open("color").into_rgb8();
        assert_eq!(color.width(), color.height(), "{} is square", asset.name);
        if !asset.relief {
            continue;
        }
        let (normal, height) = (open("normal").into_rgb8(), open("height").into_luma8());
        assert_eq!(normal.dimensions(), color.dimensions(), "{}: normals", asset.name);
        assert_eq!(height.dimensions(), color.dimensions(), "{}: heights", asset.name);
        // Where the height rises upwards in the picture the normal leans down, and the other way round.
        let (mut agree, mut both) = (0, 0);
        for y in 1..height.height() - 1 {
            for x in 0..height.width() {
                let n = normal.get_pixel(x, y).0.map(|c| f64::from(c) / 127.5 - 1.0);
                let length = n.iter().map(|c| c * c).sum::<f64>().sqrt();
                assert!((length - 1.0).abs() < 0.02, "{} ({x}, {y}): normal of length {length}", asset.name);
                let rise = i32::from(height.get_pixel(x, y - 1).0[0]) - i32::from(height.get_pixel(x, y + 1).0[0]);
                if rise.abs() > 8 {
                    both += 1;
                    agree += i32::from((rise > 0) == (n[1] < 0.0));
                }
            }
        }
        assert!(both > 1000 && agree * 100 > both * 95, "{}: {agree} of {both} normals fit the height", asset.name);
    }
}

#[test]
fn exemplars_tile() {
    for asset in EXEMPLARS {
        let picture = image::open(folder("exemplars").join(format!("{}_color.png", asset.name))).unwrap().into_rgb8();
        let size = picture.width();
        for upright in [false, true] {
            // Mean difference between line `i` and the next; after the last comes the first.
            let change = |i: u32| -> f64 {
                let pixel =
                    |line: u32, k: u32| if upright { picture.get_pixel(line % size, k) } else { picture.get_pixel(k, line % size) };
                let sum: u32 = (0..size)
                    .flat_map(|k| (0..3).map(move |c| (k, c)))
                    .map(|(k, c)| u32::from(pixel(i, k).0[c].abs_diff(pixel(i + 1, k).0[c])))
                    .sum();
                f64::from(sum) / f64::from(3 * size)
            };
            let within = (0..size - 1).map(change).fold(0.0, f64::max);
            let seam = change(size - 1);
            assert!(seam <= within, "{}: {seam:.1} across the edge, at most {within:.1} within", asset.name);
        }
    }
}
