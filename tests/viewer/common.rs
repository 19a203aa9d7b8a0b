//! The viewer in a harness: what tests click and look at. Pictures are kept in `target/viewer/`.

#![allow(clippy::panic, clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

use egui_kittest::wgpu::{WgpuTestRenderer, create_render_state, default_wgpu_setup};
use egui_kittest::{Harness, kittest::Queryable};
use lapped::job::Link;
use lapped::render::gpu::Gpu;
use lapped::viewer::{App, Graphics};
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Software adapters are slow enough for one viewer at a time.
static ALONE: Mutex<()> = Mutex::new(());

/// Waits until no other viewer is open.
pub(crate) fn alone() -> MutexGuard<'static, ()> {
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Work that takes longer has hung.
const PATIENCE: Duration = Duration::from_secs(120);

/// A viewer without a window.
pub(crate) struct Bench {
    pub(crate) harness: Harness<'static, Option<App>>,
    pub(crate) home: tempfile::TempDir,
    _alone: MutexGuard<'static, ()>,
}

impl Bench {
    /// A window of so many points, and of that many pixels a point.
    pub(crate) fn new(size: [f32; 2], scale: f32) -> Self {
        Self::at_home(size, scale, tempfile::tempdir().unwrap())
    }

    /// The same with settings and unsaved work in a folder.
    pub(crate) fn at_home(size: [f32; 2], scale: f32, home: tempfile::TempDir) -> Self {
        let alone = alone();
        let state = create_render_state(default_wgpu_setup(), egui_wgpu::RendererOptions::PREDICTABLE);
        let gpu = Gpu::from_device(state.device.clone(), state.queue.clone());
        let graphics = Graphics::new(gpu, state.renderer.clone()).unwrap();
        let folder = home.path().to_owned();
        let mut graphics = Some(graphics);
        let harness = Harness::builder()
            .with_size(size)
            .with_pixels_per_point(scale)
            .with_render_cursor(false)
            .renderer(WgpuTestRenderer::from_render_state(state))
            .build_ui_state(
                move |ui, app: &mut Option<App>| {
                    let make = || App::new(ui.ctx(), graphics.take().unwrap(), Some(folder.clone()));
                    app.get_or_insert_with(make).timed_ui(ui);
                },
                None,
            );
        Self { harness, home, _alone: alone }
    }

    pub(crate) fn app(&self) -> &App {
        self.harness.state().as_ref().unwrap()
    }

    pub(crate) fn app_mut(&mut self) -> &mut App {
        self.harness.state_mut().as_mut().unwrap()
    }

    /// A built-in model with an exemplar on it, pasted.
    pub(crate) fn begin(&mut self, model: &str, exemplar: &str) {
        self.harness.step();
        self.app_mut().set_exemplars(vec![Link::BuiltIn(exemplar.to_owned())]);
        self.app_mut().set_model(Link::BuiltIn(model.to_owned()));
        self.settle();
    }

    /// Frames until no work goes on and everything asked for is shown.
    pub(crate) fn settle(&mut self) {
        let begin = Instant::now();
        let mut calm = 0;
        while calm < 4 {
            self.harness.step();
            calm = if self.app().is_idle() { calm + 1 } else { 0 };
            assert!(begin.elapsed() < PATIENCE, "work goes on for ever: {:?}", self.app().work());
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    /// A click on what is called so.
    pub(crate) fn click(&mut self, label: &str) {
        self.harness.get_by_label(label).click();
        self.harness.step();
        self.harness.step();
    }

    /// The window's picture, kept for who looks.
    pub(crate) fn picture(&mut self, name: &str) -> image::RgbaImage {
        let picture = self.harness.render().unwrap();
        let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("../viewer");
        std::fs::create_dir_all(&folder).unwrap();
        picture.save(folder.join(format!("{name}.png"))).unwrap();
        picture
    }

    /// What all errors and hints say.
    pub(crate) fn told(&self) -> String {
        self.app().notices.iter().map(|n| n.text.as_str()).collect::<Vec<_>>().join("\n")
    }
}

/// Pixels of two pictures that differ.
pub(crate) fn differ(a: &image::RgbaImage, b: &image::RgbaImage) -> usize {
    a.pixels().zip(b.pixels()).filter(|(a, b)| a.0.iter().zip(b.0).any(|(a, b)| a.abs_diff(b) > 12)).count()
}
