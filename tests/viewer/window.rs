//! The real window on a virtual screen, driven by mouse and keyboard: what an artist does in the first two minutes.
//!
//! Needs `Xvfb`, `xdotool` and ImageMagick's `import`; without them it fails.

#![allow(clippy::unwrap_used, reason = "tests")]

use crate::common::alone;
use lapped::format::{read_model, read_record};
use lapped::job::Project;
use lapped::job::project::{Shape, Size};
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::MutexGuard;
use std::time::{Duration, Instant};

/// What is waited for comes within this, or never.
const PATIENCE: Duration = Duration::from_secs(90);

/// A virtual screen with the viewer on it. Both are ended when it goes.
struct Desktop {
    screen: Child,
    display: String,
    viewer: Option<Child>,
    folder: tempfile::TempDir,
    /// A point is two pixels.
    dense: bool,
    _alone: MutexGuard<'static, ()>,
}

impl Drop for Desktop {
    fn drop(&mut self) {
        for child in self.viewer.iter_mut().chain([&mut self.screen]) {
            let _ended = (child.kill(), child.wait());
        }
    }
}

impl Desktop {
    fn new(size: &str) -> Self {
        let alone = alone();
        let mut screen = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", &format!("{size}x24"), "-nolisten", "tcp", "-noreset"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("Xvfb starts: install xvfb");
        let mut number = String::new();
        BufReader::new(screen.stdout.take().unwrap()).read_line(&mut number).unwrap();
        let display = format!(":{}", number.trim());
        Self { screen, display, viewer: None, folder: tempfile::tempdir().unwrap(), dense: false, _alone: alone }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn open(&mut self, arguments: &[&str]) {
        let viewer = Command::new(env!("CARGO_BIN_EXE_lapped"))
            .args(["view", "--own-dialogs", "--home"])
            .arg(self.path("home"))
            .arg("--trace")
            .arg(self.path("trace.json"))
            .args(arguments)
            .env("DISPLAY", &self.display)
            .env_remove("WAYLAND_DISPLAY")
            .env("WINIT_X11_SCALE_FACTOR", if self.dense { "2" } else { "1" })
            .spawn()
            .unwrap();
        self.viewer = Some(viewer);
        self.wait("the window", |desktop| !desktop.tool(&["search", "--onlyvisible", "--name", "lapped"]).is_empty());
        // Without a window manager nobody else gives it the keyboard.
        self.tool(&["mousemove", "640", "400", "windowfocus", &self.window()]);
    }

    fn run(&self, program: &str, arguments: &[&str]) -> String {
        let out = Command::new(program).args(arguments).env("DISPLAY", &self.display).output();
        let out = out.expect("xdotool and import are there: install xdotool and imagemagick");
        String::from_utf8_lossy(&out.stdout).into_owned()
    }

    fn tool(&self, arguments: &[&str]) -> String {
        self.run("xdotool", arguments)
    }

    fn window(&self) -> String {
        self.tool(&["search", "--onlyvisible", "--name", "lapped"]).lines().next().unwrap_or_default().to_owned()
    }

    fn title(&self) -> String {
        self.tool(&["getwindowname", &self.window()]).trim().to_owned()
    }

    fn keys(&self, keys: &str) {
        self.tool(&["key", keys]);
    }

    fn wait(&self, what: &str, mut done: impl FnMut(&Self) -> bool) {
        let begin = Instant::now();
        while !done(self) {
            if begin.elapsed() > PATIENCE {
                self.picture("gave-up");
            }
            assert!(begin.elapsed() < PATIENCE, "{what} did not come");
            std::thread::sleep(Duration::from_millis(150));
        }
    }

    /// The screen, kept for who looks.
    fn picture(&self, name: &str) -> image::RgbaImage {
        let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("../viewer");
        std::fs::create_dir_all(&folder).unwrap();
        self.shot(&folder.join(format!("window-{name}.png")))
    }

    /// The screen as it is now.
    fn look(&self) -> image::RgbaImage {
        self.shot(&self.path("now.png"))
    }

    fn shot(&self, path: &Path) -> image::RgbaImage {
        self.run("import", &["-window", "root", path.to_str().unwrap()]);
        image::open(path).expect("a picture of the screen").to_rgba8()
    }

    /// Waits until nothing changes any more: what works is seen to work in the status bar.
    fn wait_for_rest(&self) {
        self.wait("rest", |desktop| {
            let before = desktop.look();
            std::thread::sleep(Duration::from_millis(800));
            before == desktop.look()
        });
    }

    /// Waits until the view shows many colours: a texture.
    fn wait_for_texture(&self) {
        self.wait("the texture", |desktop| coloured(&desktop.look()) > 12_000);
    }
}

/// Pixels in the middle of the screen that are no grey.
fn coloured(picture: &image::RgbaImage) -> usize {
    let (w, h) = picture.dimensions();
    let middle = |x: u32, y: u32| (w / 4..3 * w / 4).contains(&x) && (h / 4..3 * h / 4).contains(&y);
    let bright = |p: &image::Rgba<u8>| p.0[..3].iter().max().unwrap() - p.0[..3].iter().min().unwrap() > 14;
    picture.enumerate_pixels().filter(|(x, y, p)| middle(*x, *y) && bright(p)).count()
}

fn written(path: &Path) -> bool {
    path.metadata().is_ok_and(|m| m.len() > 0)
}

#[test]
#[ignore = "needs a graphics adapter and a virtual screen: cargo test --test viewer -- --include-ignored"]
fn the_window_opens_turns_changes_saves_exports_and_closes() {
    let mut desktop = Desktop::new("1280x800");
    let project = desktop.path("vase.lapped");
    std::fs::write(&project, VASE).unwrap();
    desktop.open(&["--size", "1280x800", project.to_str().unwrap()]);
    desktop.wait_for_texture();
    desktop.wait_for_rest();
    let first = desktop.picture("opened");

    // Turned by the mouse, brought nearer by the wheel.
    for step in ["mousedown 1", "mousemove 760 430", "mousemove 860 440", "mouseup 1", "click 4", "click 4"] {
        desktop.tool(&step.split(' ').collect::<Vec<_>>());
        std::thread::sleep(Duration::from_millis(200));
    }
    let differ = |picture: &image::RgbaImage| first.pixels().zip(picture.pixels()).filter(|(a, b)| a != b).count();
    desktop.wait("the vase turned", |d| differ(&d.picture("turned")) > 10_000);

    // Compared, and made smaller again.
    desktop.keys("v");
    std::thread::sleep(Duration::from_secs(1));
    desktop.wait_for_rest();
    desktop.picture("split");
    desktop.keys("v");
    desktop.wait_for_rest();

    // The slider of the scale, drawn to the right.
    for step in ["mousemove 102 265", "mousedown 1", "mousemove 120 265", "mousemove 130 265", "mouseup 1"] {
        desktop.tool(&step.split(' ').collect::<Vec<_>>());
        std::thread::sleep(Duration::from_millis(200));
    }
    desktop.wait("an unsaved change", |d| d.title().starts_with('*'));
    desktop.wait_for_rest();
    desktop.keys("ctrl+z");
    desktop.wait("the change undone", |d| !d.title().starts_with('*'));
    desktop.keys("ctrl+shift+z");
    desktop.wait("the change made again", |d| d.title().starts_with('*'));
    desktop.keys("ctrl+s");
    desktop.wait("the project saved", |d| !d.title().starts_with('*'));
    let saved = Project::read(&project).unwrap();
    assert!(saved.view.is_some() && saved != Project { view: saved.view, ..Project::default() }, "{saved:?}");
    assert!(matches!(saved.size, Size::Ratio(_)), "by the slider: {:?}", saved.size);

    // A record, by its name typed into the window.
    let record = desktop.path("vase.glb");
    desktop.name_file("ctrl+e", &record);
    desktop.wait("the record", |_| written(&record));
    desktop.picture("exported");

    // Minimised and shown again, and resized to almost nothing and back.
    let window = desktop.window();
    desktop.tool(&["windowminimize", &window]);
    desktop.tool(&["windowmap", &window]);
    desktop.tool(&["windowsize", &window, "480", "320"]);
    std::thread::sleep(Duration::from_millis(700));
    desktop.picture("smallest");
    desktop.tool(&["windowsize", &window, "1280", "800"]);
    desktop.wait_for_texture();

    let status = desktop.quit();
    assert!(status.success(), "closed: {status}");
    let trace: serde_json::Value = serde_json::from_slice(&std::fs::read(desktop.path("trace.json")).unwrap()).unwrap();
    assert!(trace["edits"].as_array().is_some_and(|e| e.len() >= 2), "edits were seen: {trace}");
    // The project opens again as it was left.
    desktop.open(&["--size", "1280x800", project.to_str().unwrap()]);
    desktop.wait_for_texture();
    desktop.picture("reopened");
}

/// The project that the tests begin with.
const VASE: &str =
    r#"{"version":1,"model":{"builtIn":"vase"},"exemplars":[{"link":{"builtIn":"bricks"}}],"synthesis":{"vertices":8000}}"#;

impl Desktop {
    /// Mouse steps, each seen by the window before the next.
    fn mouse(&self, steps: &[&str]) {
        for step in steps {
            self.tool(&step.split(' ').collect::<Vec<_>>());
            std::thread::sleep(Duration::from_millis(300));
        }
    }

    fn click(&self, at: [i32; 2]) {
        self.mouse(&[&format!("mousemove {} {}", at[0], at[1]), "mousedown 1", "mouseup 1"]);
    }

    /// Saves, and reads what was saved once it is what is waited for.
    fn saved(&self, path: &Path, what: &str, done: impl Fn(&Project) -> bool) -> Project {
        let mut last = Project::default();
        self.wait(what, |desktop| {
            desktop.keys("ctrl+s");
            std::thread::sleep(Duration::from_millis(400));
            last = Project::read(path).unwrap();
            done(&last)
        });
        self.wait("the project saved", |d| !d.title().starts_with('*'));
        last
    }

    /// Types a file's name into the question that a key asks.
    fn name_file(&self, keys: &str, path: &Path) {
        self.wait_for_rest();
        // Behind the question everything is dimmed, an empty place of the left panel too.
        let panel = |picture: &image::RgbaImage| *picture.get_pixel(200, 650);
        let before = panel(&self.look());
        self.keys(keys);
        self.wait("the question for a name", |d| panel(&d.look()) != before);
        // Keys count from the frame on in which the question has the focus, and frames take long where much else goes on.
        std::thread::sleep(Duration::from_secs(2));
        self.keys("ctrl+a");
        self.tool(&["type", path.to_str().unwrap()]);
        std::thread::sleep(Duration::from_secs(1));
        self.keys("Return");
    }

    /// Closes the window by its key.
    fn quit(&mut self) -> std::process::ExitStatus {
        self.tool(&["windowfocus", &self.window()]);
        self.keys("ctrl+q");
        let mut viewer = self.viewer.take().unwrap();
        let begin = Instant::now();
        loop {
            if let Some(status) = viewer.try_wait().unwrap() {
                return status;
            }
            if begin.elapsed() > PATIENCE {
                let _ended = viewer.kill();
            }
            std::thread::sleep(Duration::from_millis(100));
        }
    }
}

#[test]
#[ignore = "needs a graphics adapter and a virtual screen: cargo test --test viewer -- --include-ignored"]
fn an_artist_combs_cuts_changes_the_exemplar_compares_saves_and_reopens() {
    let mut desktop = Desktop::new("1280x800");
    let project = desktop.path("vase.lapped");
    std::fs::write(&project, VASE).unwrap();
    desktop.open(&["--size", "1280x800", project.to_str().unwrap()]);
    desktop.wait_for_texture();
    desktop.wait_for_rest();

    // Combed by a stroke over the vase.
    desktop.keys("c");
    std::thread::sleep(Duration::from_secs(1));
    desktop.mouse(&[
        "mousemove 600 470",
        "mousedown 1",
        "mousemove 620 450",
        "mousemove 650 425",
        "mousemove 690 390",
        "mouseup 1",
    ]);
    desktop.wait("the stroke", |d| d.title().starts_with('*'));
    desktop.wait_for_rest();
    desktop.picture("combed");
    let combed = desktop.saved(&project, "the stroke in the project", |p| !p.constraints.constraints.is_empty());
    desktop.keys("c");

    // Another exemplar: the first of the built-in ones.
    desktop.click([36, 188]);
    desktop.wait_for_rest();
    desktop.picture("built-in");
    desktop.click([58, 244]);
    let switched = desktop.saved(&project, "another exemplar", |p| p.exemplars != combed.exemplars);
    desktop.wait_for_rest();
    desktop.picture("switched");
    desktop.keys("ctrl+z");
    desktop.saved(&project, "the first exemplar again", |p| p.exemplars == combed.exemplars);
    desktop.keys("ctrl+shift+z");
    desktop.saved(&project, "the other one again", |p| p.exemplars == switched.exemplars);

    // A patch cut by clicks on the exemplar.
    desktop.keys("x");
    desktop.wait_for_rest();
    [[410, 330], [560, 330], [580, 420], [560, 520], [410, 520]].into_iter().for_each(|at| desktop.click(at));
    desktop.picture("cutting");
    desktop.keys("Return");
    let outlined = |p: &Project| matches!(&p.exemplars[0].shapes[..], [Shape::Outline(points)] if points.len() > 3);
    desktop.saved(&project, "the outline", outlined);
    desktop.wait_for_rest();
    desktop.picture("cut");
    desktop.keys("ctrl+z");
    desktop.saved(&project, "no outline", |p| p.exemplars[0].shapes.is_empty());
    desktop.keys("ctrl+shift+z");
    let cut = desktop.saved(&project, "the outline again", outlined);
    desktop.keys("x");

    // Compared with its synthesis, which is written.
    desktop.keys("y");
    let right = |picture: &image::RgbaImage| image::imageops::crop_imm(picture, 670, 30, 380, 740).to_image();
    let bright = |p: &image::Rgba<u8>| p.0[..3].iter().max().unwrap() - p.0[..3].iter().min().unwrap() > 14;
    desktop.wait("the synthesis", |d| right(&d.look()).pixels().filter(|p| bright(p)).count() > 20_000);
    desktop.picture("compared");
    desktop.keys("y");
    let [record, baked] = ["vase.glb", "baked.glb"].map(|name| desktop.path(name));
    desktop.name_file("ctrl+e", &record);
    desktop.wait("the record", |_| written(&record));
    desktop.name_file("ctrl+shift+e", &baked);
    desktop.wait("the baked model", |_| written(&baked));
    assert!(read_record(&record).unwrap().lapped.pastes.len() > 10, "pastes are in the record");
    assert!(read_model(&baked).unwrap().uvs.is_some(), "charts are in the baked model");
    assert!(desktop.quit().success(), "closed");

    desktop.open(&["--size", "1280x800", project.to_str().unwrap()]);
    desktop.wait_for_texture();
    desktop.wait_for_rest();
    desktop.picture("opened-again");
    assert_eq!(Project { view: None, ..Project::read(&project).unwrap() }, Project { view: None, ..cut }, "the same project");
    assert!(desktop.quit().success(), "closed");
}

#[test]
#[ignore = "needs a graphics adapter and a virtual screen: cargo test --test viewer -- --include-ignored"]
fn on_a_dense_screen_everything_is_twice_as_large() {
    let mut desktop = Desktop::new("1280x800");
    let project = desktop.path("vase.lapped");
    std::fs::write(&project, VASE).unwrap();
    desktop.dense = true;
    desktop.open(&["--size", "640x400", project.to_str().unwrap()]);
    desktop.wait_for_texture();
    desktop.wait_for_rest();
    desktop.picture("dense");
    let window = desktop.window();
    let geometry = desktop.tool(&["getwindowgeometry", &window]);
    assert!(geometry.contains("1280x800"), "points of two pixels each: {geometry}");
    for size in [["1", "1"], ["300", "2"], ["1280", "800"]] {
        desktop.tool(&["windowsize", &window, size[0], size[1]]);
        std::thread::sleep(Duration::from_millis(500));
    }
    desktop.wait_for_texture();
    assert!(desktop.quit().success(), "it lived through windows of next to no size");
}

#[test]
#[ignore = "needs a graphics adapter and a virtual screen: cargo test --test viewer -- --include-ignored"]
fn without_a_screen_it_says_so() {
    let out = Command::new(env!("CARGO_BIN_EXE_lapped"))
        .arg("view")
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .output()
        .unwrap();
    let told = String::from_utf8_lossy(&out.stderr);
    assert_eq!(out.status.code(), Some(1), "an error: {told}");
    assert!(told.contains("no display") && told.contains("lapped render"), "what to do: {told}");
}
