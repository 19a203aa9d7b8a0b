//! From a change to its picture, and how long the interface stands still meanwhile: `cargo bench --bench view`; with `-- million`
//! only what a model of a million faces takes.
//!
//! The viewer is driven without a window; frames are drawn by whatever adapter there is, software ones too. Drawing itself is
//! not counted to the interface's time, waiting for the picture is.

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a bench fails and talks as tests do")]

use egui_kittest::Harness;
use egui_kittest::wgpu::{WgpuTestRenderer, create_render_state, default_wgpu_setup};
use lapped::field::Constraint;
use lapped::job::Link;
use lapped::job::project::{Direction, Size};
use lapped::render::gpu::Gpu;
use lapped::viewer::{App, Graphics};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::atomic::Ordering::Relaxed;
use std::time::{Duration, Instant};

/// While work goes on the window draws its status this often.
const STATUS: Duration = Duration::from_millis(100);

/// No screen shows more frames.
const FRAME: Duration = Duration::from_millis(16);

/// Changes of each kind.
const TIMES: usize = 12;

fn main() {
    let state = create_render_state(default_wgpu_setup(), egui_wgpu::RendererOptions::PREDICTABLE);
    let device = state.device.clone();
    // A software adapter draws on the processor: what still is drawn of one change must not slow the next.
    let drawn = move || drop(device.poll(wgpu::PollType::wait_indefinitely()));
    let gpu = Gpu::from_device(state.device.clone(), state.queue.clone());
    println!("{}", gpu.adapter());
    let mut graphics = Some(Graphics::new(gpu, state.renderer.clone()).unwrap());
    let home = tempfile::tempdir().unwrap();
    let folder = home.path().to_owned();
    let mut harness: Harness<'_, Option<App>> =
        Harness::builder().with_size([1280.0, 720.0]).renderer(WgpuTestRenderer::from_render_state(state)).build_ui_state(
            move |ui, app: &mut Option<App>| {
                let make = || App::new(ui.ctx(), graphics.take().unwrap(), Some(folder.clone()));
                app.get_or_insert_with(make).timed_ui(ui);
            },
            None,
        );
    harness.step();
    if !std::env::args().any(|argument| argument == "million") {
        changes(&mut harness, &drawn);
    }
    million(&mut harness, home.path());
}

/// Changes of each kind on models of several sizes.
fn changes(harness: &mut Harness<'_, Option<App>>, drawn: &dyn Fn()) {
    println!("model                faces  change       median ms   worst ms   longest stall ms");
    for (model, exemplar) in [("dragonling", "scales"), ("dragonling", "moss"), ("dragonling_25k", "scales")] {
        let app = harness.state_mut().as_mut().unwrap();
        app.set_exemplars(vec![Link::BuiltIn(exemplar.to_owned())]);
        app.set_model(Link::BuiltIn(model.to_owned()));
        settle(harness);
        harness.state_mut().as_mut().unwrap().edit("comb", |p| p.constraints.constraints.clear());
        settle(harness);
        for name in ["seed", "scale", "direction", "stroke"] {
            let mut times = Vec::new();
            *harness.state_mut().as_mut().unwrap().trace_mut() = lapped::viewer::trace::Trace::default();
            for k in 0..TIMES {
                let app = harness.state_mut().as_mut().unwrap();
                app.document.end_gesture();
                match name {
                    "seed" => app.edit("seed", |p| p.seed = 100 + k as u64),
                    "scale" => app.edit("scale", |p| p.size = Size::Ratio(36.0 + k as f64 * 0.5)),
                    "direction" => app.edit("direction", |p| {
                        let angle = 0.1 + 0.2 * k as f64;
                        p.direction = Direction::Up([angle.sin(), angle.cos(), 0.0]);
                    }),
                    // What the end of a stroke hands to the project.
                    _ => app.edit("comb", |p| {
                        let place =
                            Constraint { face: Some(500 * k as u32), direction: Some([1.0, 0.5, 0.2]), ..Constraint::default() };
                        p.constraints.constraints.push(place);
                    }),
                }
                settle(harness);
                drawn();
            }
            let app = harness.state().as_ref().unwrap();
            times.extend(app.trace().edits.iter().map(|e| 1e3 * e.seconds));
            times.sort_by(f64::total_cmp);
            let faces = app.shown().unwrap().mesh().face_count();
            println!(
                "{model:20} {faces:6} {name:10} {:10.0} {:10.0} {:14.1}",
                times[times.len() / 2],
                times.last().unwrap(),
                1e3 * app.trace().longest().as_secs_f64(),
            );
        }
    }
}

/// Opens a model of a million faces, tells how long that takes and what the interface does meanwhile.
fn million(harness: &mut Harness<'_, Option<App>>, folder: &Path) {
    let knot = lapped::assets::mesh("knot").unwrap();
    let (mut positions, mut faces) = (knot.positions, knot.faces);
    while faces.len() < 1_000_000 {
        let mut middles: BTreeMap<[u32; 2], u32> = BTreeMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                positions.push(0.5 * (positions[a as usize] + positions[b as usize]));
                positions.len() as u32 - 1
            })
        };
        let finer = faces.iter().flat_map(|&[a, b, c]| {
            let [x, y, z] = [middle(a, b), middle(b, c), middle(c, a)];
            [[a, x, z], [x, b, y], [z, y, c], [x, y, z]]
        });
        faces = finer.collect();
    }
    let path = folder.join("million.ply");
    let mut ply = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\nelement face {}\n\
         property list uchar uint vertex_indices\nend_header\n",
        positions.len(),
        faces.len()
    )
    .into_bytes();
    positions.iter().for_each(|p| ply.extend(p.to_array().map(f32::to_le_bytes).as_flattened()));
    for face in &faces {
        ply.push(3);
        ply.extend(face.map(u32::to_le_bytes).as_flattened());
    }
    std::fs::write(&path, ply).unwrap();
    *harness.state_mut().as_mut().unwrap().trace_mut() = lapped::viewer::trace::Trace::default();
    let begin = Instant::now();
    harness.state_mut().as_mut().unwrap().open_all(&[path]);
    settle(harness);
    let app = harness.state().as_ref().unwrap();
    let (seconds, trace) = (begin.elapsed().as_secs_f64(), app.trace());
    println!("{} faces opened and pasted in {seconds:.1} s", app.shown().unwrap().mesh().face_count());
    for stall in &trace.stalls {
        let working = stall.working.map_or(String::new(), |w| format!(", of which {:.1} ms working", 1e3 * w));
        println!("  at {:.1} s a frame of {:.1} ms{working}: {:?}", stall.at, 1e3 * stall.seconds, stall.parts);
    }
}

/// Frames until everything asked for is shown: as a window has them, when somebody asks for one at once, and now and then for the
/// status bar.
fn settle(harness: &mut Harness<'_, Option<App>>) {
    let asked = Arc::new(AtomicBool::new(false));
    let ask = Arc::clone(&asked);
    harness.ctx.set_request_repaint_callback(move |info| ask.store(ask.load(Relaxed) || info.delay.is_zero(), Relaxed));
    let begin = Instant::now();
    let mut last = begin;
    harness.step();
    while !harness.state().as_ref().unwrap().is_idle() {
        assert!(begin.elapsed() < Duration::from_secs(120), "work goes on for ever");
        if last.elapsed() > FRAME && (asked.swap(false, Relaxed) || last.elapsed() > STATUS) {
            last = Instant::now();
            harness.step();
        }
        std::thread::sleep(Duration::from_millis(1));
    }
}
