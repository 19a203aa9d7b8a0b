//! Re-tiling: seconds and evenness.
//!
//! `cargo bench --bench retile` on bumpy tori and a pyramid of one; with `LAPPED_CORPUS` set to a folder of meshes, each of them at 0.25, 1 and 4 times
//! its vertices. `-- NAME` runs only files whose name contains it.

#![expect(clippy::print_stdout, reason = "the table is what this program is for")]

mod common;

use common::{SIDES, bumpy_torus, meshed, reset_peak};
use lapped::format::read_model;
use lapped::mesh::Mesh;
use lapped::mesh::distance::farthest;
use lapped::mesh::pyramid::pyramid;
use lapped::mesh::retile::{RetileOptions, evenness, retile};
use lapped::progress::Silent;
use std::path::Path;
use std::time::Instant;

fn row(name: &str, mesh: &Mesh, vertices: usize) {
    reset_peak();
    let begin = Instant::now();
    let done = match retile(mesh, &RetileOptions { vertices, ..RetileOptions::default() }, &Silent) {
        Ok(done) => done,
        Err(error) => return println!("{name:20} {vertices:>8}: {error}"),
    };
    let seconds = begin.elapsed().as_secs_f64();
    let peak = lapped::cli::report::peak_memory().unwrap_or(0) as f64 / 1e6;
    let (s, e) = (done.statistics, done.statistics.evenness);
    let euler = done.mesh.euler_characteristic() - mesh.euler_characteristic();
    let spacing = 0.25 * e.mean_edge;
    let far = [farthest(mesh, &done.mesh, spacing), farthest(&done.mesh, mesh, spacing)].map(|d| d / e.mean_edge);
    println!(
        "{name:20} {:>8} {vertices:>8} {:>+6} | {seconds:>6.2} {peak:>5.0} | {:>5.3} | {:>5.1} {:>5.1} {:>5.1} | {:>5.2} {:>5.2} {:>5} {:>4} | {euler:>2} {:>3} {:>3} of {:>3} | {:?}",
        mesh.vertex_count(),
        s.vertices as i64 - vertices as i64,
        e.edge_variation,
        e.least_angle,
        e.low_angle,
        e.mean_least_angle,
        far[0],
        far[1],
        s.put_back,
        s.kept_old,
        e.degenerate_faces,
        e.folded_edges,
        evenness(mesh).folded_edges,
        e.valence,
    );
}

/// Four levels, the finest of 250,000 vertices.
fn pyramids() {
    let mesh = meshed(&bumpy_torus(500));
    let begin = Instant::now();
    let made =
        pyramid(&mesh, &RetileOptions { vertices: 250_000, ..RetileOptions::default() }, 4, &Silent).expect("enough vertices");
    let counts: Vec<usize> = made.levels.iter().map(|l| l.mesh.vertex_count()).collect();
    println!("a pyramid of {counts:?} vertices: {:.2} s", begin.elapsed().as_secs_f64());
}

fn main() {
    let wanted: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    println!("{} threads", rayon::current_num_threads());
    println!(
        "mesh                      from      to   diff |   secs    MB | stdv. | least   5 %  mean | out/e back/e  back kept | dEu deg fold | valence 4 5 6 7 8"
    );
    let Some(corpus) = std::env::var_os("LAPPED_CORPUS") else {
        for n in SIDES {
            let mesh = meshed(&bumpy_torus(n));
            row("bumpy torus", &mesh, mesh.vertex_count());
        }
        return pyramids();
    };
    let folder = Path::new(&corpus).join("meshes");
    let mut names: Vec<String> = std::fs::read_dir(&folder)
        .expect("a folder of meshes")
        .filter_map(|e| e.ok().and_then(|e| e.file_name().into_string().ok()))
        .collect();
    names.sort();
    for name in names.iter().filter(|n| wanted.is_empty() || wanted.iter().any(|w| n.contains(w))) {
        let Ok(model) = read_model(&folder.join(name)) else { continue };
        let mesh = meshed(&model);
        for times in [0.25, 1.0, 4.0] {
            row(name, &mesh, (mesh.vertex_count() as f64 * times) as usize);
        }
    }
}
