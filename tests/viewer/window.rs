//! The real window on a virtual screen, driven by mouse and keyboard: what an artist does in the first two minutes.
//!
//! Needs `Xvfb`, `xdotool` and ImageMagick's `import`; without them it fails.

#![allow(clippy::unwrap_used, reason = "tests")]

use lapped::job::Project;
use lapped::job::project::Size;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// What is waited for comes within this, or never.
const PATIENCE: Duration = Duration::from_secs(90);

/// A virtual screen with the viewer on it. Both are ended when it goes.
struct Desktop {
    screen: Child,
    display: String,
    viewer: Option<Child>,
    folder: tempfile::TempDir,
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
        let mut screen = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", &format!("{size}x24"), "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("Xvfb starts: install xvfb");
        let mut number = String::new();
        BufReader::new(screen.stdout.take().unwrap()).read_line(&mut number).unwrap();
        let display = format!(":{}", number.trim());
        Self { screen, display, viewer: None, folder: tempfile::tempdir().unwrap() }
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
        let path = folder.join(format!("window-{name}.png"));
        self.run("import", &["-window", "root", path.to_str().unwrap()]);
        image::open(&path).expect("a picture of the screen").to_rgba8()
    }

    /// Waits until nothing changes any more: what works is seen to work in the status bar.
    fn wait_for_rest(&self) {
        self.wait("rest", |desktop| {
            let before = desktop.picture("now");
            std::thread::sleep(Duration::from_millis(800));
            before == desktop.picture("now")
        });
    }

    /// Waits until the view shows many colours: a texture.
    fn wait_for_texture(&self) {
        self.wait("the texture", |desktop| coloured(&desktop.picture("now")) > 12_000);
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
    let text = r#"{"version":1,"model":{"builtIn":"vase"},"exemplars":[{"link":{"builtIn":"bricks"}}]}"#;
    std::fs::write(&project, text).unwrap();
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
    desktop.wait_for_rest();
    // Behind the question everything is dimmed, an empty place of the left panel too.
    let panel = |picture: &image::RgbaImage| *picture.get_pixel(200, 650);
    let before = panel(&desktop.picture("now"));
    desktop.keys("ctrl+e");
    desktop.wait("the question for a name", |d| panel(&d.picture("now")) != before);
    std::thread::sleep(Duration::from_millis(700));
    desktop.keys("ctrl+a");
    desktop.tool(&["type", record.to_str().unwrap()]);
    desktop.picture("path");
    desktop.keys("Return");
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

    desktop.tool(&["windowfocus", &window]);
    desktop.keys("ctrl+q");
    let mut viewer = desktop.viewer.take().unwrap();
    let begin = Instant::now();
    let status = loop {
        if let Some(status) = viewer.try_wait().unwrap() {
            break status;
        }
        if begin.elapsed() > PATIENCE {
            let _ended = viewer.kill();
        }
        std::thread::sleep(Duration::from_millis(100));
    };
    assert!(status.success(), "closed: {status}");
    let trace: serde_json::Value = serde_json::from_slice(&std::fs::read(desktop.path("trace.json")).unwrap()).unwrap();
    assert!(trace["edits"].as_array().is_some_and(|e| e.len() >= 2), "edits were seen: {trace}");
    // The project opens again as it was left.
    desktop.open(&["--size", "1280x800", project.to_str().unwrap()]);
    desktop.wait_for_texture();
    desktop.picture("reopened");
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
