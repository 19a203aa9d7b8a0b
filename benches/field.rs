//! n-way fields: seconds for the first field, for one with wishes, and (not relaxed, as while somebody steers) after one more;
//! singularities and error.
//!
//! `cargo bench --bench field` on bumpy tori; `-- MESH...` on meshes of yours. Where `MESH.directions.json` lies beside a mesh (as
//! `benches/peers/field.py` writes it), the directions in it are measured the same way, in the same run.

#![expect(clippy::print_stdout, reason = "the table is what this program is for")]

mod common;

use common::{SIDES, bumpy_torus, meshed, reset_peak};
use glam::{DVec2, DVec3, Vec3};
use lapped::field::nway::{Measure, NWayField, NWayOptions, NWaySolver, Over, Start, energy};
use lapped::format::read_model;
use lapped::mesh::Mesh;
use lapped::progress::Silent;
use serde::Deserialize;
use std::collections::HashMap;
use std::path::PathBuf;
use std::time::Instant;

const WAYS: [u32; 4] = [1, 2, 4, 6];

/// How strong a wish is.
const STRENGTH: f64 = 100.0;

/// Another program's directions: for each n one at each vertex.
#[derive(Deserialize)]
struct Peer {
    name: String,
    positions: Vec<Vec3>,
    /// Seconds and directions by n.
    fields: HashMap<u32, (f64, Vec<DVec3>)>,
}

fn main() {
    let files: Vec<PathBuf> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).map(PathBuf::from).collect();
    println!("{} threads; errors are sums of 2 (1 - cos n phi) / n^2 over vertices' neighbours", rayon::current_num_threads());
    println!(
        "mesh                     nodes  n | prepare   first wishes  again | iterations | singular   error |    MB | from noise     | elsewhere: singular error secs"
    );
    if files.is_empty() {
        for n in SIDES {
            rows("bumpy torus", &meshed(&bumpy_torus(n)), None);
        }
    }
    for file in files {
        let model = read_model(&file).expect("a mesh");
        let mesh = meshed(&model);
        let peer = std::fs::read(file.with_extension("directions.json")).ok();
        let peer = peer.map(|bytes| serde_json::from_slice::<Peer>(&bytes).expect("directions"));
        rows(&file.file_name().unwrap_or_default().to_string_lossy(), &mesh, peer.as_ref());
    }
}

fn rows(name: &str, mesh: &Mesh, peer: Option<&Peer>) {
    for n in WAYS {
        reset_peak();
        let begin = Instant::now();
        let solver = NWaySolver::new(mesh, Over::Vertices, n);
        let prepare = begin.elapsed().as_secs_f64();
        let nodes = solver.table.len();
        let begin = Instant::now();
        let (field, s) = solver.solve(&[], &NWayOptions::default(), &Silent);
        let first = begin.elapsed().as_secs_f64();
        let error = |field: &NWayField| energy(&solver.table, n, &field.powers, &[], Measure::Smooth);
        let told = (s.singularities, error(&field));
        // What directions are asked for at two places; then at a third.
        let mut wishes = vec![DVec2::ZERO; nodes];
        let ask = |v: usize, wishes: &mut [DVec2]| wishes[v] = -field.powers[v] * STRENGTH;
        ask(nodes / 3, &mut wishes);
        ask(2 * nodes / 3, &mut wishes);
        let begin = Instant::now();
        let (guided, _) = solver.solve(&wishes, &NWayOptions::default(), &Silent);
        let asked = begin.elapsed().as_secs_f64();
        ask(nodes / 2, &mut wishes);
        let begin = Instant::now();
        let (again, after) = solver.solve(&wishes, &NWayOptions { smooth: false, ..NWayOptions::default() }, &Silent);
        let adjusted = begin.elapsed().as_secs_f64();
        assert!(guided.powers != again.powers, "the third wish changes the field");
        print!(
            "{name:22} {nodes:>7} {n:>2} | {prepare:>7.3} {first:>7.3} {asked:>6.3} {adjusted:>6.3} | {:>4} {:>5} | {:>8} {:>7.1}",
            s.iterations, after.iterations, told.0, told.1
        );
        print!(" | {:>5.0}", lapped::cli::report::peak_memory().unwrap_or(0) as f64 / 1e6);
        let (noise, from_noise) = solver.solve(&[], &NWayOptions { start: Start::Random, ..NWayOptions::default() }, &Silent);
        print!(" | {:>8} {:>7.1}", from_noise.singularities, error(&noise));
        if let Some((peer, (seconds, directions))) = peer.and_then(|p| p.fields.get(&n).map(|f| (p, f))) {
            let of: HashMap<[u32; 3], DVec3> =
                peer.positions.iter().zip(directions).map(|(p, &d)| (p.to_array().map(f32::to_bits), d)).collect();
            let power = |v: usize| {
                let there = of.get(&mesh.positions[v].to_array().map(f32::to_bits)).copied().unwrap_or(DVec3::X);
                DVec2::from_angle(f64::from(n) * solver.table.angle_of(v as u32, there))
            };
            let theirs = NWayField { n, over: Over::Vertices, powers: (0..nodes).map(power).collect() };
            print!(" | {}: {} {:.1} {seconds:.2}", peer.name, solver.singularities(&theirs).len(), error(&theirs));
        }
        println!();
    }
}
