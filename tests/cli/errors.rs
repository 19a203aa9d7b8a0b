//! What cannot be done is told in one clear sentence, with exit code 1, and nothing is left behind.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]
#![allow(clippy::print_stderr, reason = "measured figures, for whoever runs with --nocapture")]

use crate::program::{OCTAHEDRON, Place, text};

/// Words with which a sentence says what to do.
const REMEDIES: [&str; 23] = [
    "give", "use ", "choose", "check", "name ", "export", "create", "copy", "free ", "rename", "resize", "see ", "try ", "read ",
    "write ", "convert", "save ", "set ", "remove", "is usual", "expected", "repair", "put ",
];

/// Runs a command that must fail on its input: exit code 1, one sentence on stderr that contains all of `names` and what to
/// do, nothing on stdout, nothing in the output folder.
fn refuses(place: &Place, args: &[&str], names: &[&str]) -> String {
    let out = place.run(args);
    let (stdout, stderr) = (text(&out.stdout), text(&out.stderr));
    assert_eq!(out.status.code(), Some(1), "{args:?}: {stdout}{stderr}");
    // Progress and warnings may come before; the error is the last line, and the only one of its kind.
    let errors: Vec<&str> = stderr.lines().filter(|l| l.contains("error")).collect();
    let last = stderr.lines().last().unwrap_or_default();
    assert!(errors.len() == 1 && last.starts_with("error: "), "{args:?}: one error, last: {stderr}");
    for name in names {
        assert!(last.contains(name), "{args:?}: names {name}: {last}");
    }
    assert!(REMEDIES.iter().any(|r| last.contains(r)), "{args:?}: says what to do: {last}");
    assert!(!stderr.contains("panicked") && !stderr.contains("RUST_BACKTRACE"), "{args:?}: {stderr}");
    assert!(last.len() < 400 && !last.contains("Error {") && !last.contains("Some("), "{args:?}: for people: {last}");
    assert!(stdout.is_empty(), "{args:?}: stdout {stdout}");
    let left = place.files("out");
    assert!(left.is_empty(), "{args:?}: left behind {left:?}");
    last.to_owned()
}

fn paste<'a>(mesh: &'a str, exemplar: &'a str, extra: &[&'a str]) -> Vec<&'a str> {
    [&["paste", mesh, exemplar, "-o", "out/a.glb", "--quiet"], extra].concat()
}

#[test]
fn a_mesh_that_cannot_be_read_is_told() {
    let place = Place::new();
    std::fs::create_dir(place.path("folder.obj")).unwrap();
    place.write("index.obj", OCTAHEDRON.replace("f 1 4 6", "f 1 4 99"));
    place.write("nan.obj", OCTAHEDRON.replace("v 0 0 -1", "v 0 nan -1"));
    place.write("infinite.obj", OCTAHEDRON.replace("v 0 0 -1", "v 0 inf -1"));
    place.write("empty.obj", "");
    place.write("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n");
    place.write("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    place.write("noise.glb", [7_u8; 300]);
    place.write("mesh.xyz", OCTAHEDRON);
    let ply = std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/assets/meshes/vase.ply")).unwrap();
    place.write("half.ply", &ply[..ply.len() / 2]);
    place.write("header.ply", &ply[..60]);
    place.write("index.ply", ply_with_index(1_000_000));
    place.write("nan.ply", ply_with_nan());
    place.write("none.ply", "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\nelement face 0\nproperty list uchar int vertex_indices\nend_header\n");
    let names = [
        "missing.obj",
        "folder.obj",
        "index.obj",
        "nan.obj",
        "infinite.obj",
        "empty.obj",
        "points.obj",
        "flat.obj",
        "noise.glb",
        "half.ply",
        "header.ply",
        "index.ply",
        "nan.ply",
        "none.ply",
    ];
    for mesh in names {
        let told = refuses(&place, &paste(mesh, "wood.png", &[]), &[mesh]);
        eprintln!("{told}");
        refuses(&place, &["render", mesh, "-o", "out/a.png", "--size", "32x32"], &[mesh]);
    }
    for mesh in ["missing.obj", "folder.obj", "half.ply", "empty.obj"] {
        refuses(&place, &["inspect", mesh], &[mesh]);
    }
    assert!(refuses(&place, &paste("index.obj", "wood.png", &[]), &[]).contains("99"), "the index is told");
    refuses(&place, &paste("mesh.xyz", "missing.png", &[]), &[]);
}

fn ply_header(faces: usize) -> String {
    format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
         element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    )
}

fn ply_of(corners: [f32; 9], indices: [u32; 3]) -> Vec<u8> {
    let mut bytes = ply_header(1).into_bytes();
    bytes.extend(corners.iter().flat_map(|v| v.to_le_bytes()));
    bytes.push(3);
    bytes.extend(indices.iter().flat_map(|v| v.to_le_bytes()));
    bytes
}

fn ply_with_index(index: u32) -> Vec<u8> {
    ply_of([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0], [0, 1, index])
}

fn ply_with_nan() -> Vec<u8> {
    ply_of([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, f32::NAN, 0.0], [0, 1, 2])
}

#[test]
fn an_exemplar_that_cannot_be_read_is_told() {
    let place = Place::new();
    let png = std::fs::read(place.path("wood.png")).unwrap();
    place.write("half.png", &png[..png.len() / 2]);
    place.write("empty.png", "");
    place.write("words.png", "this is not an image at all");
    std::fs::create_dir(place.path("folder")).unwrap();
    for exemplar in ["missing.png", "half.png", "empty.png", "words.png", "folder", "mesh.obj"] {
        eprintln!("{}", refuses(&place, &paste("mesh.obj", exemplar, &[]), &[exemplar]));
    }
    image::RgbImage::new(2, 2).save(place.path("tiny.png")).unwrap();
    eprintln!("{}", refuses(&place, &paste("mesh.obj", "tiny.png", &[]), &["error: tiny.png"]));
    // Of several the one at fault is named.
    refuses(&place, &["paste", "mesh.obj", "wood.png", "tiny.png", "-o", "out/a.glb", "-q"], &["error: tiny.png"]);
}

#[test]
fn absurd_numbers_are_told_with_the_flag_or_what_would_do() {
    let place = Place::new();
    let cases: [(&[&str], &[&str]); 15] = [
        (&["--scale", "0"], &["--scale"]),
        (&["--scale=-1"], &["--scale"]),
        (&["--scale", "nan"], &["--scale"]),
        (&["--scale", "inf"], &["--scale"]),
        (&["--scale", "1e-9"], &["scale", "1.000e-9"]),
        (&["--scale", "1e30"], &["scale", "1.000e30"]),
        (&["--scale", "1e-60"], &["a scale of 1e-60"]),
        (&["--ratio", "0"], &["--ratio"]),
        (&["--ratio", "1e30"], &["scale"]),
        (&["--ratio", "1e-30"], &["scale"]),
        (&["--weld=-1"], &["--weld"]),
        (&["--weights", "1,2"], &["--weights"]),
        (&["--weights", "0"], &["--weights"]),
        (&["--feather", "1e9"], &["--feather", "1e9 pixels", "256 x 256", "at most 102"]),
        (&["--distortion", "0"], &["distortion"]),
    ];
    for (extra, names) in cases {
        eprintln!("{}", refuses(&place, &paste("mesh.obj", "wood.png", extra), names));
    }
}

#[test]
fn files_of_options_that_are_wrong_are_told() {
    let place = Place::new();
    place.write("broken.json", "{\"version\": 1, ");
    place.write("version.json", r#"{"version": 9, "constraints": []}"#);
    place.write("key.json", r#"{"version": 1, "constraints": [{"postion": [0, 0, 0]}]}"#);
    place.write("field.json", r#"{"version": 1, "up": [[0, 1, 0]]}"#);
    place.write("line.json", "[[0, 0], [1, 1]]");
    place.write("cross.json", "[[0, 0], [1, 1], [1, 0], [0, 1]]");
    for file in ["missing.json", "broken.json", "version.json", "key.json"] {
        eprintln!("{}", refuses(&place, &paste("mesh.obj", "wood.png", &["--field", file]), &[file]));
    }
    for file in ["missing.json", "broken.json", "line.json", "cross.json", "missing.png"] {
        eprintln!("{}", refuses(&place, &paste("mesh.obj", "wood.png", &["--patch", file]), &[file]));
    }
    refuses(
        &place,
        &paste("mesh.obj", "wood.png", &["--field", "field.json"]),
        &["error: field.json: ", "the field has 1 vectors"],
    );
    refuses(&place, &paste("mesh.obj", "wood.png", &["--patch", "square"]), &["square"]);
    refuses(&place, &paste("mesh.obj", "wood.png", &["--scale-field", "key.json"]), &["--scale-field"]);
}

#[test]
fn output_that_cannot_be_written_is_told_and_nothing_is_left() {
    let place = Place::new();
    std::fs::create_dir(place.path("out2")).unwrap();
    std::fs::create_dir(place.path("out2/folder.glb")).unwrap();
    let run = |args: &[&str], names: &[&str]| eprintln!("{}", refuses(&place, args, names));
    run(&["paste", "mesh.obj", "wood.png", "-o", "nowhere/a.glb", "-q"], &["nowhere"]);
    run(&["paste", "mesh.obj", "wood.png", "-o", "out2/folder.glb", "-q"], &["folder.glb"]);
    run(&["paste", "mesh.obj", "wood.png", "-o", "mesh.obj/a.glb", "-q"], &["mesh.obj"]);
    run(&["render", "mesh.obj", "-o", "nowhere/a.png", "--size", "32x32"], &["nowhere"]);
    assert_eq!(place.files("out2"), ["folder.glb"], "only what was there");
    run(&["inspect", "mesh.obj", "--report", "nowhere/a.json"], &["nowhere"]);
    run(&["demo", "-o", "out", "--report", "nowhere/a.json"], &["nowhere"]);
    // A file in place of the folder.
    run(&["demo", "-o", "mesh.obj"], &["mesh.obj"]);
    assert_eq!(std::fs::read_to_string(place.path("mesh.obj")).unwrap(), OCTAHEDRON, "the file that stood in the way is untouched");
}

#[test]
fn a_picture_or_report_that_cannot_be_written_leaves_no_record_behind() {
    let place = Place::new();
    eprintln!(
        "{}",
        refuses(&place, &paste("mesh.obj", "wood.png", &["--preview", "nowhere/a.png", "--preview-size", "64x64"]), &["nowhere"])
    );
    eprintln!("{}", refuses(&place, &paste("mesh.obj", "wood.png", &["--report", "nowhere/a.json"]), &["nowhere"]));
}

#[cfg(unix)]
#[test]
fn a_folder_that_may_not_be_written_to_is_told() {
    use std::os::unix::fs::PermissionsExt;
    let place = Place::new();
    std::fs::create_dir(place.path("locked")).unwrap();
    std::fs::set_permissions(place.path("locked"), std::fs::Permissions::from_mode(0o555)).unwrap();
    // The superuser may write anyway: then there is nothing to refuse.
    if std::fs::write(place.path("locked/probe"), "").is_ok() {
        std::fs::remove_file(place.path("locked/probe")).unwrap();
        eprintln!("permissions do not hold for this user");
        // A device that cannot hold files stands in for it.
        refuses(&place, &["paste", "mesh.obj", "wood.png", "-o", "/dev/null/a.glb", "-q"], &["/dev/null"]);
        return;
    }
    refuses(&place, &["paste", "mesh.obj", "wood.png", "-o", "locked/a.glb", "-q"], &["locked"]);
    assert!(place.files("locked").is_empty(), "nothing was left");
}

#[test]
fn a_record_that_is_there_already_survives_a_failed_run() {
    let place = Place::new();
    let kept = place.write("kept.glb", "something dear");
    let out = place.run(&["paste", "mesh.obj", "wood.png", "-o", "kept.glb", "--scale", "1e-9"]);
    assert_eq!(out.status.code(), Some(1), "{}", text(&out.stderr));
    assert_eq!(std::fs::read_to_string(kept).unwrap(), "something dear", "the old file is untouched");
    let hidden: Vec<String> = place.files(".").into_iter().filter(|f| f.starts_with('.')).collect();
    assert!(hidden.is_empty(), "no temporary file: {hidden:?}");
}

#[cfg(unix)]
#[test]
fn an_interrupted_run_says_so_and_leaves_nothing_behind() {
    let place = Place::new();
    let mesh = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/meshes/dragonling_25k.ply");
    let child = place.start(&["paste", mesh, "wood.png", "-o", "out/a.glb", "--ratio", "4000"]);
    std::thread::sleep(std::time::Duration::from_millis(700));
    let sent = std::process::Command::new("sh").args(["-c", &format!("kill -INT {}", child.id())]).status().unwrap();
    assert!(sent.success(), "the signal was sent: a run of many seconds was not over yet");
    let out = child.wait_with_output().unwrap();
    let said = text(&out.stderr);
    assert_eq!(out.status.code(), Some(130), "what shells expect: {said}");
    assert!(said.contains("error: interrupted") && said.contains("run again"), "{said}");
    assert!(place.files("out").is_empty(), "left behind: {:?}", place.files("out"));
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_told_and_the_old_file_stays() {
    let place = Place::new();
    let told = refuses(&place, &["render", "mesh.obj", "-o", "/dev/full", "--size", "64x64"], &["/dev/full", "disk is full"]);
    eprintln!("{told}");
    refuses(
        &place,
        &paste("mesh.obj", "wood.png", &[]).iter().map(|a| if *a == "out/a.glb" { "/dev/full" } else { a }).collect::<Vec<_>>(),
        &["/dev/full", "disk is full"],
    );
}
