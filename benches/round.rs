//! Round neighbourhoods: seconds, and fidelity against the method of levels of meshes.
//!
//! `cargo bench --bench round` shows how time grows with vertices, on spheres, and on a plane. With `LAPPED_CORPUS` set to a folder of
//! meshes and textures, `-- fidelity [MESH...]` measures both methods over meshes and exemplars, and `-- parts [MESH...]` what each part
//! of the adaptive metric and of refinement brings.
//!
//! Seconds are wall time, and in brackets processor time of all threads.

#![expect(clippy::print_stdout, reason = "the table is what this program is for")]

mod common;

use common::{Clock, sphere};
use glam::DVec3;
use lapped::compare::fidelity;
use lapped::exemplar::symmetry::symmetry;
use lapped::exemplar::{Channel, Exemplar};
use lapped::format::{ExemplarOptions, read_exemplar, read_model};
use lapped::job::synth::prepared;
use lapped::job::{
    Density, Direction, RoundJob, Steer, SynthJob, march, synthesize_marched, synthesize_on, synthesize_plane_image,
};
use lapped::mesh::{CleanOptions, Cleaned, Mesh, SurfacePoint, clean};
use lapped::progress::Silent;
use lapped::synth::VertexTexture;
use lapped::synth::round::{Metric, RoundOptions};
use std::path::PathBuf;

/// Exemplars are brought to this many pixels.
const SIDE: u32 = 64;

fn cleaned(mesh: &Mesh) -> Cleaned {
    clean(&mesh.positions, &mesh.faces, &CleanOptions::default()).expect("a mesh")
}

fn corpus() -> Option<PathBuf> {
    std::env::var_os("LAPPED_CORPUS").map(PathBuf::from)
}

fn exemplars() -> Vec<Exemplar> {
    let Some(folder) = corpus() else {
        return ["pebbles", "scales"].iter().filter_map(|n| lapped::assets::exemplar(n).ok()).collect();
    };
    let names = ["pebbles.jpg", "scales-128.png", "stripes-128.png", "herringbone-64.png", "boxtree.jpg", "caustics.jpg"];
    let options = ExemplarOptions { alone: true, ..ExemplarOptions::default() };
    names.iter().map(|n| read_exemplar(&folder.join("textures").join(n), &options).expect("an exemplar").0).collect()
}

fn meshes(wanted: &[String]) -> Vec<(String, Cleaned)> {
    let Some(folder) = corpus() else { return Vec::new() };
    let names = ["horse.ply", "armadillo.obj", "stanford-bunny.obj", "torus.obj"];
    let chosen = names.iter().filter(|n| wanted.is_empty() || wanted.iter().any(|w| n.contains(w.as_str())));
    let read = |name: &&str| {
        let model = read_model(&folder.join("meshes").join(name)).expect("a mesh");
        ((*name).to_owned(), clean(&model.positions, &model.faces, &CleanOptions::default()).expect("a surface"))
    };
    chosen.map(read).collect()
}

fn ways(exemplar: &Exemplar) -> u32 {
    let found = symmetry(exemplar.channel(Channel::BaseColor).expect("colour").finest());
    if found.isotropic { 1 } else { found.n }
}

/// How time grows with vertices, and what another direction costs.
fn growth() {
    let exemplar = exemplars().swap_remove(0);
    println!(" vertices | marching           us a vertex | synthesis          | another direction  | circles not whole");
    for rounds in [5, 6, 7, 8] {
        let mesh = cleaned(&sphere(rounds));
        let n = mesh.mesh.vertex_count();
        let job = RoundJob { density: Density::Vertices(n), side: Some(SIDE), ..RoundJob::default() };
        let clock = Clock::start();
        let (marched, _) = march(&mesh.mesh, &exemplar, &job, None, &Silent).expect("circles");
        let (marching, each) = (clock.told(), clock.seconds() * 1e6 / n as f64);
        let steered = |axis: DVec3| {
            let job = RoundJob { direction: Direction::Steered(Steer::Up(axis)), ..job.clone() };
            let clock = Clock::start();
            synthesize_marched(&mesh, &marched, &exemplar, &job, &Silent).expect("a texture");
            clock.told()
        };
        let (first, second) = (steered(DVec3::Y), steered(DVec3::X));
        let s = marched.marching.statistics();
        println!("{n:9} | {marching} {each:10.1} | {first} | {second} | {}", s.open + s.missing);
    }
    for side in [256, 512] {
        let job = RoundJob { side: Some(SIDE), tiles: Some(false), levels: 3, ..RoundJob::default() };
        let clock = Clock::start();
        synthesize_plane_image([side, side], &exemplar, &job, &Silent).expect("an image");
        println!("{side}x{side} on a plane: {}", clock.told());
    }
}

fn measured(texture: &VertexTexture, exemplar: &Exemplar) -> String {
    let right = |at: SurfacePoint| -> DVec3 {
        let corner = (0..3).max_by(|&a, &b| at.bary[a].total_cmp(&at.bary[b])).unwrap_or(0);
        texture.frames[texture.mesh.faces[at.face as usize][corner] as usize].right
    };
    let f = fidelity(&texture.mesh, texture, &right, texture.spacing, exemplar);
    let (r, o) = (f.result, f.floor);
    format!(
        "{:5.2} ({:4.2}) | {:.3} {:.3} {:.3} ({:.3}) | {:.3} ({:.3}) | {:4.2} | {:4.2}",
        r.swd,
        o.swd,
        r.coherence.mean,
        r.coherence.p95,
        r.coherence.p99,
        o.coherence.p99,
        r.completeness.mean,
        o.completeness.mean,
        r.energy,
        r.repetition
    )
}

const HEAD: &str = "swd (floor)  | coherence mean p95 p99 (floor) | complete (floor) | energy | repeats";

/// Both methods over meshes and exemplars, at one vertex a pixel.
fn fidelities(wanted: &[String]) {
    println!("mesh               exemplar         method    | seconds         | {HEAD}");
    for (name, mesh) in meshes(wanted) {
        let density = Density::Vertices(mesh.mesh.vertex_count().max(24_576));
        for exemplar in exemplars() {
            let direction = Direction::Steered(Steer::Relaxed(ways(&exemplar)));
            let prepared = prepared(&exemplar, Some(SIDE), None);
            let job = RoundJob { density, side: Some(SIDE), direction: direction.clone(), ..RoundJob::default() };
            let (marched, _) = march(&mesh.mesh, &exemplar, &job, None, &Silent).expect("circles");
            let clock = Clock::start();
            let made = synthesize_marched(&mesh, &marched, &exemplar, &job, &Silent).expect("a texture");
            println!("{name:18} {:16} chen-dong | {} | {}", exemplar.name, clock.told(), measured(&made.texture, &prepared));
            let job = SynthJob { density, side: Some(SIDE), direction, ..SynthJob::default() };
            let clock = Clock::start();
            let made = synthesize_on(&mesh, &exemplar, &job, &Silent, &mut |_, _, _| ()).expect("a texture");
            println!("{name:18} {:16} wei-levoy | {} | {}", exemplar.name, clock.told(), measured(&made.texture, &prepared));
        }
    }
}

/// What each part brings.
fn parts(wanted: &[String]) {
    let (usual, all) = (RoundOptions::default(), Metric::default());
    let variants = [
        ("all", usual, 2),
        ("no candidates", RoundOptions { metric: Metric { candidates: false, ..all }, ..usual }, 2),
        ("no sums", RoundOptions { metric: Metric { sums: false, ..all }, ..usual }, 2),
        ("no deviation", RoundOptions { metric: Metric { deviation: false, ..all }, ..usual }, 2),
        ("no region", RoundOptions { metric: Metric { region: false, ..all }, ..usual }, 2),
        ("no outliers", RoundOptions { metric: Metric { outliers: false, ..all }, ..usual }, 2),
        ("plain", RoundOptions { metric: Metric::plain(), ..usual }, 2),
        ("one level", usual, 1),
        ("three levels", usual, 3),
        ("two circles", RoundOptions { circles: 2, ..usual }, 2),
        ("four circles", RoundOptions { circles: 4, ..usual }, 2),
        ("range 0", RoundOptions { range: 0, ..usual }, 2),
        ("two passes", RoundOptions { passes: 2, ..usual }, 2),
    ];
    println!("mesh               exemplar         without       | seconds         | {HEAD}");
    for (name, mesh) in meshes(wanted) {
        for exemplar in exemplars() {
            let prepared = prepared(&exemplar, Some(SIDE), None);
            for (told, options, levels) in variants {
                let density = Density::Vertices(mesh.mesh.vertex_count().max(24_576));
                let direction = Direction::Steered(Steer::Relaxed(ways(&exemplar)));
                let job = RoundJob { density, side: Some(SIDE), direction, options, levels, ..RoundJob::default() };
                let (marched, _) = march(&mesh.mesh, &exemplar, &job, None, &Silent).expect("circles");
                let clock = Clock::start();
                let made = synthesize_marched(&mesh, &marched, &exemplar, &job, &Silent).expect("a texture");
                println!("{name:18} {:16} {told:13} | {} | {}", exemplar.name, clock.told(), measured(&made.texture, &prepared));
            }
        }
    }
}

fn main() {
    let args: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    match args.first().map(String::as_str) {
        Some("fidelity") => fidelities(&args[1..]),
        Some("parts") => parts(&args[1..]),
        _ => growth(),
    }
}
