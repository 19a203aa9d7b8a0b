//! Synthesis: seconds and fidelity.
//!
//! `cargo bench --bench synth` on a sphere of 24,576 vertices with the demo exemplars at 64x64 pixels; with `LAPPED_CORPUS` set to a
//! folder of meshes and textures, with its exemplars instead. `-- NAME` runs only exemplars whose name contains it; `-- large` adds
//! the rows that show how time grows with vertices and pixels; `-- grid N FILE...` synthesises flat grids of N x N vertices,
//! which `benches/peers/synth.sh` holds against an image synthesiser.
//!
//! Seconds are wall time, and in brackets processor time of all threads.

#![expect(clippy::print_stdout, reason = "the table is what this program is for")]

mod common;

use common::{Clock, sphere};
use glam::{DVec3, Vec3};
use lapped::compare::fidelity;
use lapped::compare::measures::Reference;
use lapped::exemplar::Exemplar;
use lapped::exemplar::stack::Stack;
use lapped::exemplar::symmetry::symmetry;
use lapped::field::nway::{NWayOptions, on_pyramid};
use lapped::format::{ExemplarOptions, read_exemplar, save_image};
use lapped::job::synth::{levels_of, prepared};
use lapped::mesh::pyramid::{Pyramid, pyramid};
use lapped::mesh::retile::RetileOptions;
use lapped::mesh::{Mesh, SurfacePoint};
use lapped::progress::Silent;
use lapped::synth::{Levels, Place, SearchKind, Source, SynthOptions, VertexTexture, combed_right, random_right, synthesize};
use std::path::{Path, PathBuf};

fn tiled(mesh: &Mesh, vertices: usize, levels: usize) -> Pyramid {
    let options = RetileOptions { vertices, ..RetileOptions::default() };
    pyramid(mesh, &options, levels, &Silent).expect("enough vertices")
}

fn exemplars(wanted: &[String]) -> Vec<Exemplar> {
    let read = |path: PathBuf| {
        let options = ExemplarOptions { alone: true, ..ExemplarOptions::default() };
        read_exemplar(&path, &options).map(|(e, _)| e).expect("an exemplar")
    };
    let all: Vec<Exemplar> = match std::env::var_os("LAPPED_CORPUS") {
        Some(corpus) => {
            let folder = Path::new(&corpus).join("textures");
            let names = ["pebbles.jpg", "stripes-128.png", "tartan_color.jpg", "scales-128.png", "caustics.jpg", "boxtree.jpg"];
            names.iter().map(|n| read(folder.join(n))).collect()
        }
        None => ["pebbles", "stripes", "scales", "bricks"].iter().filter_map(|n| lapped::assets::exemplar(n).ok()).collect(),
    };
    all.into_iter().filter(|e| wanted.is_empty() || wanted.iter().any(|w| e.name.contains(w.as_str()))).collect()
}

const SEARCHES: [SearchKind; 3] = [SearchKind::Fast, SearchKind::Tsvq, SearchKind::Exhaustive];

fn measured(levels: &Levels, exemplar: &Exemplar, texture: &VertexTexture) -> String {
    let right = |at: SurfacePoint| -> DVec3 {
        let corner = (0..3).max_by(|&a, &b| at.bary[a].total_cmp(&at.bary[b])).unwrap_or(0);
        texture.frames[texture.mesh.faces[at.face as usize][corner] as usize].right
    };
    let f = fidelity(&texture.mesh, texture, &right, levels.finest().spacing, exemplar);
    let (r, o) = (f.result, f.floor);
    format!(
        "| {:5.2} ({:4.2}) | {:.3} {:.3} {:.3} ({:.3}) | {:.3} ({:.3}) | {:4.2} | {:4.2} ({:4.2})",
        r.swd,
        o.swd,
        r.coherence.mean,
        r.coherence.p95,
        r.coherence.p99,
        o.coherence.p99,
        r.completeness.mean,
        o.completeness.mean,
        r.energy,
        r.repetition,
        o.repetition
    )
}

fn figure_7(wanted: &[String]) {
    let mesh = tiled(&sphere(6), 24_576, 4);
    println!("sphere, 24,576 vertices, exemplars of 64x64, 4 levels, {} threads", rayon::current_num_threads());
    println!(
        "exemplar         search      ways |   relax          | synthesis       |  swd (floor) | coherence mean p95 p99 (floor) | complete (floor) | energy | repeats (floor)"
    );
    for exemplar in exemplars(wanted) {
        let exemplar = prepared(&exemplar, Some(64), None);
        let found = symmetry(exemplar.channel(lapped::exemplar::Channel::BaseColor).expect("colour").finest());
        let ways = if found.isotropic { 1 } else { found.n };
        let clock = Clock::start();
        let fields = on_pyramid(&mesh, ways, &NWayOptions::default(), &Silent);
        let relax = clock.told();
        let right = fields.tables.iter().zip(&fields.fields).map(|(t, f)| combed_right(t, f)).collect();
        let random = random_right(&mesh, 1);
        for (told, right, searches) in [(ways.to_string(), right, &SEARCHES[..]), ("none".to_owned(), random, &SEARCHES[..1])] {
            for &search in searches {
                for paper in [false, true] {
                    let usual = if paper { SynthOptions::paper() } else { SynthOptions::default() };
                    let options = SynthOptions { search, ..usual };
                    let clock = Clock::start();
                    let levels = Levels::of_pyramid(mesh.clone(), Vec::clone(&right));
                    let source = Source::image(&Stack::new(&exemplar, None), levels.len());
                    let made = synthesize(&levels, &source, &options, &Silent, &mut |_| ()).expect("it can be done");
                    let texture = VertexTexture::of_exemplar(levels.finest(), &exemplar, &made.places);
                    let seconds = clock.told();
                    let name = format!("{search:?}{}", if paper { " paper" } else { "" });
                    println!(
                        "{:16} {name:16} {told:>4} | {relax} | {seconds} {}",
                        exemplar.name,
                        measured(&levels, &exemplar, &texture)
                    );
                }
            }
        }
    }
}

/// How time grows with vertices, and with pixels.
fn growth(wanted: &[String]) {
    let Some(exemplar) = exemplars(wanted).into_iter().next() else { return };
    for (vertices, side) in [(16_000, 64), (64_000, 64), (256_000, 64), (24_576, 32), (24_576, 64), (24_576, 128), (24_576, 256)] {
        let exemplar = prepared(&exemplar, Some(side), None);
        let clock = Clock::start();
        let mesh = tiled(&sphere(7), vertices, levels_of(&exemplar, 4));
        let retile = clock.told();
        let clock = Clock::start();
        let fields = on_pyramid(&mesh, 1, &NWayOptions::default(), &Silent);
        let right = fields.tables.iter().zip(&fields.fields).map(|(t, f)| combed_right(t, f)).collect();
        let relax = clock.told();
        let clock = Clock::start();
        let levels = Levels::of_pyramid(mesh, right);
        let framed = clock.told();
        let source = Source::image(&Stack::new(&exemplar, None), levels.len());
        for search in &SEARCHES[..if vertices > 64_000 { 1 } else { 3 }] {
            let clock = Clock::start();
            let options = SynthOptions { search: *search, ..SynthOptions::default() };
            let made = synthesize(&levels, &source, &options, &Silent, &mut |_| ()).expect("it can be done");
            let s = made.statistics.levels;
            let sum = |of: fn(&lapped::synth::LevelStatistics) -> f64| s.iter().map(of).sum::<f64>();
            println!(
                "{vertices:>7} vertices, {side:>3} pixels, {:10} | retile {retile} | directions {relax} | fans {framed} | synthesis {} | flatten {:.2} build {:.2} match {:.2}",
                format!("{search:?}"),
                clock.told(),
                sum(|l| l.flatten_seconds),
                sum(|l| l.build_seconds),
                sum(|l| l.match_seconds),
            );
        }
    }
}

/// Image files brought to `side` pixels as comparisons bring their exemplars, written beside the working directory as PNG.
fn brought_to(side: u32, files: &[String]) {
    for file in files {
        let options = ExemplarOptions { alone: true, ..ExemplarOptions::default() };
        let (exemplar, _) = read_exemplar(Path::new(file), &options).expect("an exemplar");
        write_exemplar(file, &prepared(&exemplar, Some(side), None));
    }
}

/// Writes what an image file was brought to.
fn write_exemplar(file: &str, exemplar: &Exemplar) {
    let stem = Path::new(file).file_stem().unwrap_or_default().to_string_lossy();
    let image = exemplar.channel(lapped::exemplar::Channel::BaseColor).expect("colour").finest();
    save_image(Path::new(&format!("{stem}-exemplar.png")), image).expect("a picture");
}

/// Flat grids of `side` x `side` vertices from image files; the results are written beside the working directory as PNG.
fn grids(side: usize, files: &[String]) {
    for file in files {
        let options = ExemplarOptions { alone: true, ..ExemplarOptions::default() };
        let (exemplar, _) = read_exemplar(Path::new(file), &options).expect("an exemplar");
        let exemplar = prepared(&exemplar, Some(64), None);
        let count = levels_of(&exemplar, 4);
        let clock = Clock::start();
        let plane = |k: usize| {
            let (side, step) = (side >> k, (1 << k) as f32);
            let start = (step - 1.0) / 2.0;
            let point = |i: usize| Vec3::new(start + (i % side) as f32 * step, start + (i / side) as f32 * step, 0.0);
            let n = side as u32;
            let cells = (0..n - 1).flat_map(|j| (0..n - 1).map(move |i| j * n + i));
            let faces = cells.flat_map(|a| [[a, a + 1, a + n + 1], [a, a + n + 1, a + n]]).collect();
            let mesh = Mesh::new((0..side * side).map(point).collect(), faces).expect("a grid");
            let right = vec![DVec3::X; mesh.vertex_count()];
            (mesh, right)
        };
        let levels = Levels::new((0..count).map(plane).collect());
        let source = Source::image(&Stack::new(&exemplar, None), levels.len());
        let made = synthesize(&levels, &source, &SynthOptions::default(), &Silent, &mut |_| ()).expect("it can be done");
        let texture = VertexTexture::of_exemplar(levels.finest(), &exemplar, &made.places);
        println!("grid {file} {side}x{side} {}", clock.told());
        let colors = texture.channel(lapped::exemplar::Channel::BaseColor).expect("colour");
        let image = lapped::exemplar::Image::from_fn(side as u32, side as u32, |x, y| {
            // Rows of the grid run upward.
            let v = (side - 1 - y as usize) * side + x as usize;
            Vec3::from_slice(&colors[3 * v..3 * v + 3])
        });
        let stem = Path::new(file).file_stem().unwrap_or_default().to_string_lossy().into_owned();
        save_image(Path::new(&format!("{stem}-lapped.png")), &image).expect("a picture");
        write_exemplar(file, &exemplar);
        assert!(made.places.iter().all(|p| matches!(p, Place::Pixel(_))), "an image's places are pixels");
    }
}

/// The measures of an image against its exemplar, both files.
fn image_measures(image: &str, of: &str) {
    let read = |path: &str| {
        let options = ExemplarOptions { alone: true, ..ExemplarOptions::default() };
        read_exemplar(Path::new(path), &options).expect("an image").0
    };
    let (result, exemplar) = (read(image), prepared(&read(of), None, None));
    let m = Reference::new(&exemplar).measure_image(&result, 1);
    println!(
        "measures {image} swd {:.3} coherence {:.4} {:.4} {:.4} completeness {:.4} energy {:.3} repeats {:.2}",
        m.swd, m.coherence.mean, m.coherence.p95, m.coherence.p99, m.completeness.mean, m.energy, m.repetition
    );
}

fn main() {
    let args: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    match args.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["grid", side, ..] => grids(side.parse().expect("a number of vertices"), &args[2..]),
        ["exemplars", side, ..] => brought_to(side.parse().expect("a number of pixels"), &args[2..]),
        ["measure", image, of] => image_measures(image, of),
        ["large", ..] => growth(&args[1..]),
        _ => figure_7(&args),
    }
}
