//! Baking over four sizes of mesh: seconds of unwrapping, baking and the rest, memory a face, and how all of it grows.
//!
//! `cargo bench --bench bake` runs a bumpy torus of about 5k, 70k, 280k and 1M faces into a page of 4096 texels, a lapped texture
//! of 40 exemplar areas on it. With `LAPPED_CORPUS` set to a folder of meshes, the charts of those instead, by both methods
//! (`-- NAME` runs only files whose name contains it).

#![expect(clippy::print_stdout, reason = "the table is what this program is for")]

mod common;

use common::{SIDES, bumpy_torus, reset_peak};
use lapped::assets::exemplar;
use lapped::atlas::{ChartMethod, UnwrapOptions, stretch, unwrap};
use lapped::format::{Model, read_model};
use lapped::job::{BakeJob, Bound, ExemplarInput, PasteJob, Scale, Steer, bake_model, paste_model};
use lapped::mesh::{CleanOptions, clean};
use lapped::paste::Composite;
use lapped::progress::{Progress, Silent};
use std::path::Path;
use std::sync::Mutex;
use std::time::Instant;

/// Texels along each side of a page.
const SIZE: u32 = 4096;

/// Surface area over exemplar area.
const RATIO: f64 = 40.0;

/// Processor seconds of this process so far, all threads.
fn processor_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let after = stat.rsplit(')').next().unwrap_or_default();
    let ticks: f64 = after.split_whitespace().skip(11).take(2).filter_map(|t| t.parse::<f64>().ok()).sum();
    ticks / 100.0
}

/// Notes when each stage begins.
#[derive(Default)]
struct Stages(Mutex<Vec<(String, Instant)>>);

impl Progress for Stages {
    fn stage(&self, name: &str, _total: u64) {
        let mut stages = self.0.lock().expect("no stage panics");
        if stages.last().is_none_or(|(last, _)| last != name) {
            stages.push((name.to_owned(), Instant::now()));
        }
    }
    fn done(&self, _done: u64) {}
}

impl Stages {
    /// Each stage with its seconds.
    fn told(&self) -> String {
        let mut stages = self.0.lock().expect("no stage panics");
        stages.push((String::new(), Instant::now()));
        let one = |w: &[(String, Instant)]| format!("{} {:.2}", w[0].0, (w[1].1 - w[0].1).as_secs_f64());
        stages.windows(2).map(one).collect::<Vec<_>>().join(", ")
    }
}

/// Bakes, prints a row, and returns faces and seconds.
fn run(model: &Model) -> (usize, f64) {
    let input = ExemplarInput { exemplar: exemplar("moss").expect("a demo exemplar"), weight: 1.0, patches: Vec::new() };
    let paste = PasteJob { scale: Scale::Ratio(RATIO), steer: Steer::Isotropic(None), ..PasteJob::default() };
    let record = paste_model(model, vec![input], &paste, &Silent).expect("the bench meshes paste").record;
    let bound = Bound::new(record.clone()).expect("the record's model is a mesh");
    let texture = Composite::new(&bound.mesh, &bound.lapped);
    let job = BakeJob { unwrap: UnwrapOptions { size: SIZE, ..UnwrapOptions::default() }, ..BakeJob::default() };
    let stages = Stages::default();
    reset_peak();
    let before = lapped::cli::report::peak_memory().unwrap_or(0) as f64;
    let (begin, cpu) = (Instant::now(), processor_seconds());
    let done = bake_model(&record.model, &bound.mesh, &bound.user_faces, &texture, &job, &stages).expect("the bench meshes bake");
    let (total, cpu) = (begin.elapsed().as_secs_f64(), processor_seconds() - cpu);
    let peak = lapped::cli::report::peak_memory().unwrap_or(0) as f64;
    let (faces, r) = (bound.mesh.face_count(), done.report);
    println!(
        "{faces:>8} {:>6} {:>5.1} {:>6.4} {:>6.2} | {:>7.2} {:>7.2} | {total:>7.2} {cpu:>7.2} | {:>6.0} {:>6.0} | {:>5.2} {:>5.1} {:>6.1}",
        r.charts,
        100.0 * r.efficiency,
        r.stretch.l2,
        r.stretch.linf,
        r.unwrap_seconds,
        r.bake_seconds,
        peak / 1e6,
        (peak - before) / faces as f64,
        r.bake.seams.mean,
        r.bake.seams.most,
        r.bake.seams.greatest,
    );
    println!("         {}", stages.told());
    (faces, total)
}

/// Charts of one mesh by one method, on 1024 texels with gutters of 2: as `benches/peers/unwrap.py` asks of others.
fn charts(name: &str, path: &Path, method: ChartMethod) {
    let model = match read_model(path) {
        Ok(model) => model,
        Err(error) => return println!("{error}"),
    };
    let mesh = clean(&model.positions, &model.faces, &CleanOptions::default()).expect("a mesh").mesh;
    let (begin, cpu) = (Instant::now(), processor_seconds());
    let options = UnwrapOptions { size: 1024, mips: 0, method, ..UnwrapOptions::default() };
    match unwrap(&mesh, &options, &Silent) {
        Ok(atlas) => {
            let s = stretch(&mesh, &atlas);
            println!(
                "{name:20} {:>7} {:5} | {:>7.2} {:>7.2} | {:>6} {:>5.1} {:>7.4} {:>7.2} {:>5}",
                mesh.face_count(),
                format!("{method:?}").to_lowercase(),
                begin.elapsed().as_secs_f64(),
                processor_seconds() - cpu,
                atlas.chart_count(),
                100.0 * atlas.efficiency(),
                s.l2,
                s.linf,
                s.collapsed_faces
            );
        }
        Err(error) => println!("{name:20} {method:?}: {error}"),
    }
}

fn main() {
    println!("{} threads", rayon::current_num_threads());
    let wanted: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    if let Some(corpus) = std::env::var_os("LAPPED_CORPUS") {
        println!("mesh                   faces how   |    secs processor | charts fill%      L2    Linf needles");
        let folder = Path::new(&corpus).join("meshes");
        let entries = std::fs::read_dir(&folder).expect("a folder of meshes");
        let mut names: Vec<String> = entries.filter_map(|e| e.ok().and_then(|e| e.file_name().into_string().ok())).collect();
        names.sort();
        for name in names.iter().filter(|n| wanted.is_empty() || wanted.iter().any(|w| n.contains(w))) {
            for method in [ChartMethod::Auto, ChartMethod::Grow] {
                charts(name, &folder.join(name), method);
            }
        }
        return;
    }
    println!(
        "   faces charts fill%     L2   Linf |  unwrap    bake |   total     cpu |     MB B/face | borders: mean, 99 %, most (of 255)"
    );
    let rows: Vec<(usize, f64)> = SIDES.iter().map(|&n| run(&bumpy_torus(n))).collect();
    for pair in rows.windows(2) {
        let exponent = (pair[1].1 / pair[0].1).ln() / (pair[1].0 as f64 / pair[0].0 as f64).ln();
        println!("    from {} to {} faces time grows as faces^{exponent:.2}", pair[0].0, pair[1].0);
    }
}
