//! What a job will take, told before it begins: pastes, time and memory.
//!
//! Pastes follow from areas: random seeding lays [`PASTES_PER_COVER`] opaque areas per area of surface, more where a
//! direction makes patches stop early. Memory and time are sums of what was measured for a face, a pixel and a coverage
//! cell, on the demo meshes, scans and exemplars of 256 to 4096 pixels; see `docs/performance.md`. Tests hold pastes and
//! memory of the demo meshes to within [`TRUST`] of these figures. Needles and rough scans take longer than told here.

use crate::exemplar::{Channel, Exemplar, Frames};
use crate::mesh::CleanReport;
use crate::paste::{FINEST_WINDOW, PASTES_PER_COVER};
use serde::Serialize;

/// Pastes and memory of usual jobs lie within this factor of the estimate.
pub const TRUST: f64 = 2.0;

/// Opaque share of the exemplar under a splotch, and under one for pastes whose windows and borders are chosen: more where the exemplar
/// tiles, less where it does not.
const SPLOTCH_SHARE: f64 = 0.6;
const FULL_SHARE: f64 = 0.68;

/// Patches that follow a direction stop where it turns, and more of them are needed,
const DIRECTED: f64 = 1.25;

/// and around the ends and poles of a shape, however large the texture is.
const POLES: f64 = 15.0;

/// Bytes: the program itself,
const BASE: f64 = 16e6;
/// a face with its share of pastes, without a direction and with one,
const FACE: [f64; 2] = [400.0, 550.0];
/// a pixel of an exemplar with the masks of its patches,
const PIXEL: f64 = 32.5;
/// each component of that pixel (two copies with their mip levels),
const COMPONENT: f64 = 2.0 * 16.0 / 3.0;
/// the same where windows are chosen, for each pixel of the finest level that they look at,
const WINDOW_COMPONENT: f64 = 21.0;
/// and a coverage cell.
const CELL: f64 = 0.75;

/// Seconds of one core of a 2.5 GHz server processor: starting, a face (without and with a direction), a paste, a pixel, a
/// coverage cell.
const SECONDS: [f64; 6] = [0.05, 2.2e-5, 5.5e-5, 6.5e-4, 2.5e-6, 1.2e-7];

/// Seconds of one core that choosing the window of a paste adds, and its cut.
const WINDOW_PASTE: f64 = 3e-3;

/// What an estimate goes by.
#[derive(Debug, Clone, PartialEq)]
pub struct Work {
    /// Faces of the clean mesh.
    pub faces: usize,
    /// Its components: each takes a paste at least.
    pub components: usize,
    /// Surface area over exemplar area.
    pub ratio: f64,
    /// Whether the texture follows a direction.
    pub directed: bool,
    /// Pixels and components of each exemplar.
    pub exemplars: Vec<(f64, usize)>,
    /// Numbers in the frames of exemplars after the first, but for those that they share with it.
    pub frames: f64,
    /// Whether each paste's window of its exemplar is chosen.
    pub windows: bool,
    /// Threads at work.
    pub threads: usize,
}

impl Work {
    /// Work on a clean mesh with these exemplars.
    #[must_use]
    pub fn new(report: &CleanReport, ratio: f64, directed: bool, windows: bool, exemplars: &[Exemplar]) -> Self {
        let size = |e: &Exemplar| {
            let [w, h] = e.size().map(f64::from);
            (w * h, e.channels().iter().map(Channel::components).sum())
        };
        let frames = |e: &Exemplar| {
            let own = |other: &Exemplar, c: Channel| !e.channel(c).zip(other.channel(c)).is_some_and(|(a, b)| a.shares_pixels(b));
            let others = e.frames().map_or(&[][..], Frames::others).iter();
            let components: usize = others.flat_map(|o| o.channels().iter().filter(|&c| own(o, c))).map(Channel::components).sum();
            e.size().map(f64::from).iter().product::<f64>() * components as f64
        };
        Self {
            faces: report.faces,
            components: report.components,
            ratio,
            directed,
            exemplars: exemplars.iter().map(size).collect(),
            frames: exemplars.iter().map(frames).sum(),
            windows,
            threads: rayon::current_num_threads(),
        }
    }
}

/// What a job will take, roughly.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Estimate {
    /// Pastes in the record.
    pub pastes: f64,
    /// Seconds on this many threads of a processor of today.
    pub seconds: f64,
    /// Most memory held at a time, bytes.
    pub memory_bytes: f64,
}

impl Estimate {
    /// Takes in what another stage of the same run will take: its memory is on top, but for the program itself.
    pub fn add(&mut self, other: &Self) {
        self.pastes += other.pastes;
        self.seconds += other.seconds;
        self.memory_bytes = if self.memory_bytes > 0.0 { self.memory_bytes - BASE } else { 0.0 } + other.memory_bytes;
    }

    /// The estimate for some work.
    #[must_use]
    pub fn new(work: &Work) -> Self {
        let directed = usize::from(work.directed);
        let covering = PASTES_PER_COVER * work.ratio / if work.windows { FULL_SHARE } else { SPLOTCH_SHARE };
        let pastes = if work.directed { DIRECTED * covering + POLES } else { covering };
        let pastes = pastes.max(1.0).max(work.components as f64);
        let faces = work.faces as f64;
        let pixels: f64 = work.exemplars.iter().map(|e| e.0).sum();
        let numbers: f64 = work.exemplars.iter().map(|e| e.0 * e.1 as f64).sum();
        let looked_at = |e: &(f64, usize)| e.0.min(f64::from(FINEST_WINDOW * FINEST_WINDOW)) * e.1 as f64;
        let windows = if work.windows { work.exemplars.iter().map(looked_at).sum() } else { 0.0 };
        // A surface of `ratio` exemplars has a cell for every four of their pixels.
        let cells = work.ratio * work.exemplars.iter().map(|e| e.0).fold(0.0, f64::max) / 4.0;
        let [start, isotropic, along, paste, pixel, cell] = SECONDS;
        let paste = if work.windows { paste + WINDOW_PASTE } else { paste };
        let one_core = [isotropic, along][directed] * faces + paste * pastes + pixel * pixels + cell * cells;
        Self {
            pastes,
            seconds: start + one_core / work.threads.max(1) as f64,
            memory_bytes: BASE
                + FACE[directed] * faces
                + PIXEL * pixels
                + COMPONENT * (numbers + work.frames)
                + WINDOW_COMPONENT * windows
                + CELL * cells,
        }
    }
}

/// Bytes in words: 12 MB, 3.4 GB.
#[must_use]
pub fn in_words(bytes: f64) -> String {
    match bytes {
        b if b >= 1e9 => format!("{:.1} GB", b / 1e9),
        b => format!("{:.0} MB", (b / 1e6).max(1.0)),
    }
}

/// The most memory the process has held since it began, or since [`forget_peak`], bytes; `None` where the system does not say.
#[must_use]
pub fn peak_memory() -> Option<u64> {
    status("VmHWM:")
}

/// Memory the process holds now, bytes; `None` where the system does not say.
#[must_use]
pub fn held_memory() -> Option<u64> {
    status("VmRSS:")
}

/// Lets [`peak_memory`] begin anew; true where the system can.
#[must_use]
pub fn forget_peak() -> bool {
    std::fs::write("/proc/self/clear_refs", "5").is_ok()
}

/// A number of bytes that the system tells of this process.
fn status(name: &str) -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|l| l.starts_with(name))?;
    let kilobytes: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kilobytes * 1024)
}

/// Memory that can be had now without harm to others, bytes; `None` where the system does not say.
#[must_use]
pub fn available_memory() -> Option<f64> {
    let number = |path: &str| -> Option<f64> { std::fs::read_to_string(path).ok()?.trim().parse().ok() };
    let info = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = info.lines().find(|l| l.starts_with("MemAvailable:"))?;
    let machine = line.split_whitespace().nth(1)?.parse::<f64>().ok()? * 1024.0;
    // A container may be allowed less than the machine has.
    let allowed = number("/sys/fs/cgroup/memory.max").zip(number("/sys/fs/cgroup/memory.current")).map(|(most, held)| most - held);
    Some(allowed.map_or(machine, |a| machine.min(a.max(0.0))))
}
