//! Pasting over four sizes of mesh: seconds per stage, peak memory, pastes, draws per face, and how all of it grows.
//!
//! `cargo bench --bench paste` runs a bumpy torus of about 5k, 70k, 280k and 1M faces; with `LAPPED_CORPUS` set to a folder of
//! meshes also a small and a large bunny and a dragon. `-- iso` or `-- up` runs only one kind of guide.

#![expect(clippy::print_stdout, reason = "the table is what this program is for")]

mod common;

use common::{SIDES, bumpy_torus, reset_peak};
use glam::DVec3;
use lapped::assets::exemplar;
use lapped::format::{Model, read_model};
use lapped::job::{ExemplarInput, PasteJob, Scale, Steer, paste_model};
use lapped::progress::Silent;
use std::path::Path;
use std::time::Instant;

/// Surface area over exemplar area in all runs.
const RATIO: f64 = 40.0;

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
