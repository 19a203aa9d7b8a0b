//! `lapped compare`: a mesh and exemplars in, a page out that puts every method side by side.

use super::bar::Bar;
use super::compare_job;
use super::picture::Size;
use super::region::steer_of;
use super::{Common, report};
use crate::compare::many::{CellDone, CellJob, SUMMARY_PAGE, run_all, run_cell};
use crate::compare::report::PAGE;
use crate::compare::setting::{RATIO, SIDE};
use crate::compare::{CompareJob, Method, SettingOptions};
use crate::format::check_output;
use crate::job::estimate::peak_memory;
use crate::job::{Scale, Steer};
use crate::mesh::CleanOptions;
use crate::render::View;
use anyhow::{anyhow, bail};
use clap::Args;
use glam::DVec3;
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeSet;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Arguments of `lapped compare`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  All methods on one mesh with one exemplar; open compared/report.html:
      lapped compare bunny.obj pebbles.jpg -o compared
  Only two of them, larger, with a texture that has no direction:
      lapped compare rock.ply moss.jpg -o compared --methods pasted,wei-levoy --ratio 10 --field none
  Several exemplars, a page each and one over all of them; open compared/index.html:
      lapped compare bunny.obj bricks.png scales.png wood.png -o compared --up y
  Many meshes and exemplars from a file; what is finished is kept when it is run again (docs/comparison.md):
      lapped compare --job assets.toml -o compared

Methods: pasted (at run time), plain (as the paper has it), baked (pasted, in an atlas), wei-levoy, chen-dong, triplanar, hex
(hexagons on triplanar planes), tiling (over automatic charts). All get the same mesh, the same pixels, the same size and the same
direction, and are measured on the surface in the same way. docs/comparison.md says what each number means.

Synthesis takes a vertex for each pixel on the surface: --ratio times the pixels of the exemplar. With the defaults that is about 330
thousand; --exemplar-size 64 makes it a quarter.")]
pub struct CompareArgs {
    /// The mesh: OBJ, PLY, STL, glTF or GLB
    #[arg(value_name = "MESH", required_unless_present = "job")]
    pub mesh: Option<PathBuf>,
    /// Example images; each is compared on its own
    #[arg(value_name = "EXEMPLAR", required_unless_present = "job")]
    pub exemplars: Vec<PathBuf>,
    /// Meshes, exemplars and options from this file instead (see docs/comparison.md)
    #[arg(long, value_name = "FILE.toml", conflicts_with_all = OF_A_CELL)]
    pub job: Option<PathBuf>,
    /// Folder to write to
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// See [`CellArgs`].
    #[command(flatten)]
    pub cell: CellArgs,
    /// See [`Common`].
    #[command(flatten)]
    pub common: Common,
}

/// Flags that belong into a job file where there is one.
const OF_A_CELL: [&str; 15] = [
    "mesh",
    "exemplars",
    "methods",
    "scale",
    "ratio",
    "up",
    "field",
    "patch",
    "small",
    "exemplar_size",
    "weld",
    "seed",
    "cameras",
    "size",
    "blind",
];

/// What one comparison is told.
#[derive(Debug, Clone, Args)]
pub struct CellArgs {
    /// Methods to compare, of: pasted, plain, baked, wei-levoy, chen-dong, triplanar, hex, tiling [default: all but plain]
    #[arg(long, value_name = "M,M,...", value_delimiter = ',', help_heading = "Method")]
    pub methods: Vec<Method>,
    /// World length of one exemplar width
    #[arg(long, value_name = "LENGTH", conflicts_with = "ratio", help_heading = "Size and direction")]
    pub scale: Option<f64>,
    /// Surface area over exemplar area, if no --scale is given
    #[arg(long, value_name = "N", default_value_t = RATIO, help_heading = "Size and direction")]
    pub ratio: f64,
    /// Texture up: an axis (x, y, z, -x, ...) or X,Y,Z, projected onto the surface [default: y]
    #[arg(long, value_name = "AXIS", value_parser = super::axis, allow_hyphen_values = true, help_heading = "Size and direction")]
    pub up: Option<DVec3>,
    /// `none` for textures that look the same every way; `curvature` to follow the surface; `relax:N` for the smoothest field of N
    /// ways; `auto` to let the exemplar decide; or a JSON file: constraints, or a field with a vector per face
    #[arg(long, value_name = "none|curvature|relax:N|auto|FILE.json", help_heading = "Size and direction")]
    pub field: Option<String>,
    /// Texture patches of the pasted methods: `auto` lets the exemplar choose, as in `lapped paste`
    #[arg(long, value_enum, value_name = "SHAPE", default_value_t = PatchArg::Splotch, help_heading = "Method")]
    pub patch: PatchArg,
    /// Lay smaller pastes over hard edges that still show, as in `lapped paste`; plain pastes have none
    #[arg(long, help_heading = "Method")]
    pub small: bool,
    /// Longer side of the exemplar in pixels, to which a larger one is brought for all methods
    #[arg(long, value_name = "PX", default_value_t = SIDE, value_parser = clap::value_parser!(u32).range(16..=1024), help_heading = "Size and direction")]
    pub exemplar_size: u32,
    /// Weld vertices closer than this, world units; 0 welds equal positions only
    #[arg(long, value_name = "TOL", default_value_t = 0.0, help_heading = "Method")]
    pub weld: f64,
    /// Seed of all random choices
    #[arg(long, value_name = "N", default_value_t = 1, help_heading = "Method")]
    pub seed: u64,
    /// Where pictures are taken from, like front, or yaw=30,pitch=15; may be repeated [default: from the front and from behind]
    #[arg(long = "camera", value_name = "VIEW", help_heading = "Pictures")]
    pub cameras: Vec<View>,
    /// Size of each picture in pixels
    #[arg(long, value_name = "WxH", default_value_t = Size([512, 512]), help_heading = "Pictures")]
    pub size: Size,
    /// Also make a sheet of N crops around borders of each method, mixed with N of the exemplar: tell them apart, then look into
    /// report.json
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(..=1000), help_heading = "Pictures")]
    pub blind: u32,
}

/// Texture patches of the pasted methods.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum PatchArg {
    /// The usual ones
    Splotch,
    /// Outlines along the exemplar's own lines, if it has any that close
    Auto,
}

impl CellArgs {
    /// The cell of a mesh and an exemplar, in a folder of that name within `output`.
    ///
    /// # Errors
    /// If a value is out of range, or a field cannot be read.
    pub(super) fn cell(&self, mesh: &Path, exemplar: &Path, name: &str, output: &Path) -> anyhow::Result<CellJob> {
        let scale = match self.scale {
            Some(length) if !(length > 0.0 && length.is_finite()) => {
                bail!("--scale is {length:?}: give the world length of one exemplar width, a number above zero")
            }
            Some(length) => Scale::World(length),
            None if !(self.ratio > 0.0 && self.ratio.is_finite()) => {
                bail!("--ratio is {:?}: give a number above zero ({RATIO} is the default)", self.ratio)
            }
            None => Scale::Ratio(self.ratio),
        };
        if !(self.weld >= 0.0 && self.weld.is_finite()) {
            bail!("--weld is {}: give a length in world units, 0 or more", self.weld);
        }
        let axis = self.up.unwrap_or(DVec3::Y);
        let steer = match self.field.as_deref() {
            None | Some("auto") => Steer::Up(axis),
            Some("none") => Steer::Isotropic(None),
            Some(named) => steer_of(named, axis)?,
        };
        let defaults = CompareJob::default();
        let up = super::picture::up_axis(self.up);
        let mut views = if self.cameras.is_empty() { defaults.views } else { self.cameras.clone() };
        if self.cameras.is_empty() {
            views.iter_mut().for_each(|view| view.up = up);
        }
        let job = CompareJob {
            methods: if self.methods.is_empty() { defaults.methods } else { self.methods.clone() },
            setting: SettingOptions {
                scale,
                steer,
                side: self.exemplar_size,
                clean: CleanOptions { weld: self.weld, ..CleanOptions::default() },
                seed: self.seed,
                choose: self.patch == PatchArg::Auto,
                small: self.small,
            },
            views,
            size: self.size.0,
            blind: self.blind,
        };
        Ok(CellJob {
            name: name.to_owned(),
            mesh: mesh.to_owned(),
            exemplar: exemplar.to_owned(),
            job,
            steer_by_exemplar: self.field.as_deref() == Some("auto"),
            command: self.command(mesh, exemplar, output, name),
        })
    }

    /// The command that does a cell alone.
    fn command(&self, mesh: &Path, exemplar: &Path, output: &Path, name: &str) -> String {
        let mut words = vec!["lapped".to_owned(), "compare".to_owned()];
        words.extend([mesh, exemplar].map(|p| p.display().to_string()));
        words.extend(["-o".to_owned(), output.join(name).display().to_string()]);
        let mut flag = |name: &str, value: String| words.extend([format!("--{name}"), value]);
        if !self.methods.is_empty() {
            flag("methods", self.methods.iter().map(|m| m.key()).collect::<Vec<_>>().join(","));
        }
        match self.scale {
            Some(scale) => flag("scale", scale.to_string()),
            None => flag("ratio", self.ratio.to_string()),
        }
        if let Some(up) = self.up {
            flag("up", format!("{},{},{}", up.x, up.y, up.z));
        }
        if let Some(field) = &self.field {
            flag("field", field.clone());
        }
        if self.patch == PatchArg::Auto {
            flag("patch", "auto".to_owned());
        }
        flag("exemplar-size", self.exemplar_size.to_string());
        if self.weld > 0.0 {
            flag("weld", self.weld.to_string());
        }
        flag("seed", self.seed.to_string());
        for camera in &self.cameras {
            let [yaw, pitch] = [camera.yaw, camera.pitch].map(f64::to_degrees);
            flag("camera", format!("yaw={yaw},pitch={pitch},zoom={}", camera.zoom));
        }
        flag("size", self.size.to_string());
        if self.blind > 0 {
            flag("blind", self.blind.to_string());
        }
        if self.small {
            words.push("--small".to_owned());
        }
        words.iter().map(|w| quoted(w)).collect::<Vec<_>>().join(" ")
    }
}

/// A word as shells read it.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:+@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) { word.to_owned() } else { format!("'{}'", word.replace('\'', "'\\''")) }
}

/// The report of a run.
#[derive(Debug, Serialize)]
struct RunReport<'a> {
    command: &'static str,
    version: &'static str,
    output: String,
    cells: Vec<CellReport<'a>>,
    seconds: f64,
    peak_memory_bytes: Option<u64>,
}

#[derive(Debug, Serialize)]
struct CellReport<'a> {
    name: &'a str,
    mesh: &'a str,
    exemplar: &'a str,
    kept: bool,
    seconds: f64,
    failed: Option<&'a str>,
}

/// Runs the command.
///
/// # Errors
/// If a file cannot be read or written, or nothing could be compared.
pub fn run(args: &CompareArgs) -> anyhow::Result<()> {
    let begin = Instant::now();
    args.common.report.iter().try_for_each(|p| check_output(p))?;
    if args.output.is_file() {
        bail!("{}: this is a file: name a folder with -o", args.output.display());
    }
    let bar = Bar::new(args.common.quiet);
    let cells = cells(args)?;
    let alone = args.job.is_none() && cells.len() == 1;
    let all = if let ([cell], true) = (&cells[..], alone) {
        let begin = Instant::now();
        let done = run_cell(cell, &args.output, &bar);
        bar.finish();
        let (report, kept) = done?;
        if kept {
            args.common.say("note: this was done before with the same files, options and version, and is kept");
        }
        if !args.common.quiet {
            writeln!(std::io::stdout(), "{}", summary(&args.output.join(PAGE), &report))?;
        }
        let [mesh, exemplar] = [&cell.mesh, &cell.exemplar].map(|p| p.display().to_string());
        vec![CellDone { name: cell.name.clone(), mesh, exemplar, report: Ok(report), kept, seconds: begin.elapsed().as_secs_f64() }]
    } else {
        let mut count = 0;
        let all = run_all(&cells, &args.output, &bar, &mut |done: &CellDone| {
            count += 1;
            bar.finish();
            let what = match &done.report {
                Ok(_) if done.kept => "kept".to_owned(),
                Ok(_) => format!("{:.1} s", done.seconds),
                Err(why) => format!("failed: {why}"),
            };
            args.common.say(&format!("{count} of {}: {}: {what}", cells.len(), done.name));
        })?;
        if !args.common.quiet {
            let good = all.iter().filter(|d| d.report.is_ok()).count();
            let page = args.output.join(SUMMARY_PAGE);
            writeln!(std::io::stdout(), "{}: {good} of {} pairs compared", page.display(), all.len())?;
        }
        all
    };
    if let Some(path) = &args.common.report {
        let cells = all.iter().map(|d| CellReport {
            name: &d.name,
            mesh: &d.mesh,
            exemplar: &d.exemplar,
            kept: d.kept,
            seconds: d.seconds,
            failed: d.report.as_ref().err().map(String::as_str),
        });
        let run = RunReport {
            command: "compare",
            version: env!("CARGO_PKG_VERSION"),
            output: args.output.display().to_string(),
            cells: cells.collect(),
            seconds: begin.elapsed().as_secs_f64(),
            peak_memory_bytes: peak_memory(),
        };
        report::write(path, &run)?;
    }
    if all.iter().all(|d| d.report.is_err()) {
        let why = all.iter().find_map(|d| d.report.as_ref().err().map(String::as_str));
        return Err(anyhow!("nothing could be compared: {}", why.unwrap_or("there is no pair")));
    }
    Ok(())
}

/// The cells that were asked for.
fn cells(args: &CompareArgs) -> anyhow::Result<Vec<CellJob>> {
    let Some(mesh) = &args.mesh else {
        return match &args.job {
            Some(file) => compare_job::read(file, &args.output),
            None => bail!("there is no mesh: name one, or a job file with --job"),
        };
    };
    let mut names = Names::default();
    let one = |exemplar: &PathBuf| {
        let name = if args.exemplars.len() == 1 { String::new() } else { names.of(mesh, exemplar) };
        args.cell.cell(mesh, exemplar, &name, &args.output)
    };
    args.exemplars.iter().map(one).collect()
}

/// Names of cells, each once.
#[derive(Debug, Default)]
pub(super) struct Names(BTreeSet<String>);

impl Names {
    /// A name for a mesh and an exemplar.
    pub(super) fn of(&mut self, mesh: &Path, exemplar: &Path) -> String {
        let stem = |p: &Path| p.file_stem().map_or_else(|| "unnamed".to_owned(), |s| s.to_string_lossy().into_owned());
        self.once(&format!("{}-{}", stem(mesh), stem(exemplar)))
    }

    /// This name, or with a number behind it if it was given before.
    pub(super) fn once(&mut self, base: &str) -> String {
        let plain: String = base.chars().map(|c| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '_' }).collect();
        let plain = plain.trim_start_matches('.');
        let mut name = plain.to_owned();
        let mut count = 1;
        while !self.0.insert(name.clone()) {
            count += 1;
            name = format!("{plain}-{count}");
        }
        name
    }
}

/// The result in a few lines.
fn summary(page: &Path, report: &Value) -> String {
    let mut text = format!("{}:", page.display());
    let methods = report["methods"].as_array().map_or(&[][..], Vec::as_slice);
    for method in methods.iter().filter(|m| !m["failed"].is_null()) {
        let [label, why] = ["label", "failed"].map(|key| method[key].as_str().unwrap_or_default());
        text.push_str(&format!("\n  {label} failed: {why}"));
    }
    for row in report["rows"].as_array().into_iter().flatten() {
        let told = ["swd", "coherence99", "seams", "direction", "allBytes", "seconds"];
        if row["key"].as_str().is_some_and(|key| told.contains(&key)) {
            let [label, why] = ["label", "why"].map(|key| row[key].as_str().unwrap_or_default());
            text.push_str(&format!("\n  {label}: {why}"));
        }
    }
    text
}
