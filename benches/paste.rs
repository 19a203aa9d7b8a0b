//! Pasting over four sizes of mesh: seconds per stage, peak memory, pastes, draws per face, and how all of it grows.
//!
//! `cargo bench --bench paste` runs a bumpy torus of about 5k, 70k, 280k and 1M faces; with `LAPPED_CORPUS` set to a folder of
//! meshes also a small and a large bunny and a dragon. `-- iso` or `-- up` runs only one kind of guide.

#![expect(clippy::print_stdout, reason = "the table is what this program is for")]

use glam::{DVec3, Vec3};
use lapped::assets::exemplar;
use lapped::format::{Model, read_model};
use lapped::job::{ExemplarInput, PasteJob, Scale, Steer, paste_model};
use lapped::progress::Silent;
use std::f32::consts::TAU;
use std::io::Write;
use std::path::Path;
use std::time::Instant;

/// Surface area over exemplar area in all runs.
const RATIO: f64 = 40.0;

/// Sides of the tori: 2 n^2 faces each.
const SIDES: [usize; 4] = [50, 187, 374, 707];

/// A torus of 2 n^2 faces with bumps of three sizes.
fn bumpy_torus(n: usize) -> Model {
    let point = |i: usize, j: usize| {
        let (a, b) = (TAU * i as f32 / n as f32, TAU * j as f32 / n as f32);
        let large = 0.05 * (3.0 * a).sin() * (2.0 * b).cos();
        let middle = 0.02 * (9.0 * a + 5.0 * b).sin();
        let small = 0.005 * (31.0 * a).sin() * (23.0 * b).sin();
        let r = 0.4 + large + middle + small;
        Vec3::new((1.0 + r * b.cos()) * a.cos(), r * b.sin(), (1.0 + r * b.cos()) * a.sin())
    };
    let positions = (0..n).flat_map(|i| (0..n).map(move |j| point(i, j))).collect();
    let v = |i: usize, j: usize| ((i % n) * n + j % n) as u32;
    let faces = (0..n)
        .flat_map(|i| (0..n).map(move |j| (i, j)))
        .flat_map(|(i, j)| [[v(i, j), v(i, j + 1), v(i + 1, j)], [v(i + 1, j + 1), v(i + 1, j), v(i, j + 1)]])
        .collect();
    Model { name: format!("torus {n}"), positions, faces, ..Model::default() }
}

/// Sets the kernel's high-water mark of this process back, so that each run shows its own peak.
fn reset_peak() {
    if let Ok(mut file) = std::fs::OpenOptions::new().write(true).open("/proc/self/clear_refs") {
        let _ = file.write_all(b"5");
    }
}

/// Pastes, prints a row, and returns faces and seconds.
fn run(name: &str, model: &Model, up: bool) -> (usize, f64) {
    let input = ExemplarInput { exemplar: exemplar("moss").expect("a demo exemplar"), weight: 1.0, patches: Vec::new() };
    let job = PasteJob {
        scale: Scale::Ratio(RATIO),
        steer: if up { Steer::Up(DVec3::Y) } else { Steer::Isotropic(None) },
        ..PasteJob::default()
    };
    reset_peak();
    let begin = Instant::now();
    let done = paste_model(model, vec![input], &job, &Silent).expect("the bench meshes paste");
    let total = begin.elapsed().as_secs_f64();
    let peak = lapped::cli::report::peak_memory().unwrap_or(0) as f64;
    let (faces, p) = (done.report.clean.faces, &done.report.paste);
    let s = &p.seconds;
    println!(
        "{name:18} {faces:>8} {:>4} | {:>6.2} {:>6.2} {:>7.2} {:>6.2} {:>7.2} {:>6.2} {:>6.2} | {total:>7.2} {:>6.0} {:>6.0} | {:>6} {:>5.2} {:>6.2}",
        if up { "up" } else { "iso" },
        done.report.prepare_seconds,
        s.prepare,
        s.lay,
        s.cover,
        s.pasting,
        s.audit,
        s.order_and_cull,
        peak / 1e6,
        peak / faces as f64,
        p.pastes,
        p.draws_per_face,
        p.visible_hard_edges_per_exemplar,
    );
    (faces, total)
}

fn main() {
    let asked = |kind: &str| std::env::args().any(|a| a == kind);
    println!("{} threads, ratio {RATIO}; seconds; lay and cover are summed over threads", rayon::current_num_threads());
    println!(
        "mesh                  faces kind |  field  masks     lay  cover pasting  audit   cull |   total     MB B/face | pastes draws   hard"
    );
    for up in [false, true] {
        if asked(if up { "iso" } else { "up" }) {
            continue;
        }
        let rows: Vec<(usize, f64)> = SIDES.iter().map(|&n| run(&format!("torus {n}"), &bumpy_torus(n), up)).collect();
        for pair in rows.windows(2) {
            let exponent = (pair[1].1 / pair[0].1).ln() / (pair[1].0 as f64 / pair[0].0 as f64).ln();
            println!("    from {} to {} faces time grows as faces^{exponent:.2}", pair[0].0, pair[1].0);
        }
        let Some(corpus) = std::env::var_os("LAPPED_CORPUS") else { continue };
        for file in ["bunny-npm.obj", "stanford-bunny.obj", "dragon.ply"] {
            match read_model(&Path::new(&corpus).join("meshes").join(file)) {
                Ok(model) => drop(run(file, &model, up)),
                Err(error) => println!("{error}"),
            }
        }
    }
}
