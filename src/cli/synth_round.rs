//! `lapped synth --method chen-dong`: on the mesh's own vertices, or on a plane.

use super::bar::Bar;
use super::region::found_steer;
use super::report;
use super::synth::{SynthArgs, check, density, direction, exemplar_path, tiles, write_more};
use crate::exemplar::{Channel, Exemplar};
use crate::format::{
    check_output, export, read_exemplar, read_file, read_model, save_channel, vertices, write_file, write_vertices,
};
use crate::job::round::LEVELS;
use crate::job::{Refined, RoundJob, RoundJobError, RoundReport, march, synthesize_marched, synthesize_plane_image};
use crate::mesh::{CleanOptions, CleanReport, clean};
use crate::progress::Progress;
use crate::synth::round::{CacheError, MOST_CIRCLES, MOST_LEVELS, Metric, RoundOptions};
use anyhow::{Context, bail};
use clap::Args;
use glam::DVec3;
use serde::Serialize;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Options of `--method chen-dong`.
#[derive(Debug, Clone, Args)]
pub struct RoundArgs {
    /// Keep what was marched in this file, and read it from there the next time: it serves any exemplar and direction on the same mesh
    /// at the same scale
    #[arg(long, value_name = "FILE", help_heading = "Round neighbourhoods (--method chen-dong)")]
    pub marching: Option<PathBuf>,
    /// Circles of a neighbourhood; 3 stand for 7x7 [default: 3]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=MOST_CIRCLES as u64), help_heading = "Round neighbourhoods (--method chen-dong)")]
    pub circles: Option<u64>,
    /// Pixels around the place above that are tried on finer levels [default: 2]
    #[arg(long, value_name = "PX", value_parser = clap::value_parser!(u32).range(0..=16), help_heading = "Round neighbourhoods (--method chen-dong)")]
    pub range: Option<u32>,
    /// Leave out parts of the adaptive metric, to see what they bring
    #[arg(
        long,
        value_enum,
        value_name = "PART,...",
        value_delimiter = ',',
        help_heading = "Round neighbourhoods (--method chen-dong)"
    )]
    pub without: Vec<PartArg>,
}

/// Parts of [`Metric`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum PartArg {
    /// Candidates from neighbours: every pixel is one instead, which is slow
    Candidates,
    /// Sums over all sizes: the largest counts alone
    Sums,
    /// Dropping of candidates outside the low end of the deviation
    Deviation,
    /// A size of neighbourhood that goes by the region
    Region,
    /// Leaving out of outliers
    Outliers,
}

impl RoundArgs {
    /// Refuses these options where they mean nothing.
    ///
    /// # Errors
    /// If one is given.
    pub fn refuse(&self) -> anyhow::Result<()> {
        let given = [
            ("--marching", self.marching.is_some()),
            ("--circles", self.circles.is_some()),
            ("--range", self.range.is_some()),
            ("--without", !self.without.is_empty()),
        ];
        match given.iter().find(|g| g.1) {
            Some((flag, _)) => bail!("{flag} goes with --method chen-dong"),
            None => Ok(()),
        }
    }
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
struct RunReport {
    command: &'static str,
    method: &'static str,
    mesh: Option<String>,
    exemplar: String,
    output: String,
    threads: usize,
    vertices: usize,
    options: RoundOptions,
    clean: Option<CleanReport>,
    round: RoundReport,
    seconds: f64,
    peak_memory_bytes: Option<u64>,
}

/// Runs the command.
///
/// # Errors
/// If a file cannot be read or written, or the job cannot be done.
pub(super) fn run(args: &SynthArgs) -> anyhow::Result<()> {
    let others = [
        ("--search", args.search.is_some()),
        ("--windows", args.windows.is_some()),
        ("--paper", args.paper),
        ("--crease", args.crease.is_some()),
        ("--exemplar-texture", args.exemplar_texture.is_some()),
    ];
    if let Some((flag, _)) = others.iter().find(|o| o.1) {
        bail!("{flag} goes with --method wei-levoy");
    }
    if args.levels.is_some_and(|l| l > MOST_LEVELS as u64) {
        bail!("--levels is {}: --method chen-dong takes 1 to {MOST_LEVELS}", args.levels.unwrap_or_default());
    }
    let passes = match args.passes.as_deref() {
        None => RoundOptions::default().passes,
        Some([passes]) => usize::from(*passes),
        Some(_) => bail!("--passes takes one number with --method chen-dong"),
    };
    let part = |part: PartArg| !args.round.without.contains(&part);
    let usual = RoundOptions::default();
    let options = RoundOptions {
        circles: args.round.circles.map_or(usual.circles, |c| c as usize),
        range: args.round.range.unwrap_or(usual.range),
        metric: Metric {
            candidates: part(PartArg::Candidates),
            sums: part(PartArg::Sums),
            deviation: part(PartArg::Deviation),
            region: part(PartArg::Region),
            outliers: part(PartArg::Outliers),
        },
        passes,
        seed: args.seed,
        ..usual
    };
    let job = RoundJob {
        density: density(args),
        levels: args.levels.map_or(LEVELS, |l| l as usize),
        side: args.exemplar_size,
        tiles: tiles(args),
        options,
        ..RoundJob::default()
    };
    let path = exemplar_path(args);
    let ending = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    if matches!(ending.as_deref(), Some("obj" | "ply" | "stl" | "gltf" | "glb")) {
        bail!("{}: with --method chen-dong the exemplar is an image; --method wei-levoy takes a painted mesh", path.display());
    }
    check(args)?;
    let (exemplar, told) = read_exemplar(path, &args.channels.options(args.color_only)?)?;
    told.iter().for_each(|w| args.common.pass_on(w));
    if exemplar.frames().is_some() {
        args.common.warn(&format!("{}: what is synthesised does not change: it follows the first frame alone", path.display()));
    }
    match args.plane {
        Some(size) => plane(args, size.0, &exemplar, &job),
        None => surface(args, &exemplar, job),
    }
}

fn surface(args: &SynthArgs, exemplar: &Exemplar, job: RoundJob) -> anyhow::Result<()> {
    let begin = Instant::now();
    let kind = vertices::Kind::of(&args.output)?;
    args.bake.as_deref().map(export::Kind::of).transpose()?;
    let outputs = [Some(&args.output), args.preview.as_ref(), args.bake.as_ref(), args.common.report.as_ref()];
    outputs.into_iter().flatten().chain(&args.round.marching).try_for_each(|p| check_output(p))?;
    let name = || args.mesh.display().to_string();
    let model = read_model(&args.mesh)?;
    model.source.notes.iter().for_each(|note| args.common.warn(&format!("{}: {note}", name())));
    let cleaned =
        clean(&model.positions, &model.faces, &CleanOptions { weld: args.weld, ..CleanOptions::default() }).with_context(name)?;
    let axis = args.up.unwrap_or(DVec3::Y);
    let job = RoundJob { direction: direction(args, axis, || found_steer(exemplar, &args.common))?, ..job };
    let explained = |e: RoundJobError| match e {
        RoundJobError::Field(_) => anyhow::Error::new(e).context(args.field.clone()),
        RoundJobError::Scale(_) => anyhow::Error::new(e).context("--scale"),
        e => anyhow::Error::new(e).context(name()),
    };
    let bar = Bar::new(args.common.quiet);
    let kept = match &args.round.marching {
        Some(path) if path.exists() => Some(read_file(path, "the file of circles")?),
        _ => None,
    };
    let done = march(&cleaned.mesh, exemplar, &job, kept.as_deref(), &bar as &dyn Progress);
    bar.finish();
    let (marched, told) = done.map_err(explained)?;
    if let Some(path) = &args.round.marching {
        match told {
            // Nobody's other file is written over.
            Some(CacheError::Other) => return Err(anyhow::Error::new(CacheError::Other).context(path.display().to_string())),
            Some(error) => args.common.warn(&format!("{}: {error}; that is done now", path.display())),
            None => {}
        }
        if marched.fresh {
            write_file(path, |out| out.write_all(&marched.marching.to_bytes()))?;
        }
    }
    let done = synthesize_marched(&cleaned, &marched, exemplar, &job, &bar as &dyn Progress);
    bar.finish();
    let made = done.map_err(explained)?;
    if args.displace.is_some() && made.texture.channel(Channel::Height).is_none() {
        bail!("{}: --displace needs a height channel: name one with --height", exemplar_path(args).display());
    }
    let moved = args.displace.map(|depth| made.texture.displaced(depth));
    let mesh = moved.as_ref().unwrap_or(&made.texture.mesh);
    write_vertices(&args.output, kind, &model.name, mesh, &made.texture)?;
    write_more(args, &model, &cleaned, &made.texture, mesh)?;
    summary(args, mesh.vertex_count(), &made.report, begin.elapsed().as_secs_f64());
    told_in_full(args, mesh.vertex_count(), Some(cleaned.report), &job, made.report, begin)
}

fn plane(args: &SynthArgs, size: [u32; 2], exemplar: &Exemplar, job: &RoundJob) -> anyhow::Result<()> {
    let begin = Instant::now();
    if args.output.extension().is_none_or(|e| !e.eq_ignore_ascii_case("png")) {
        bail!("{}: --plane makes images: give the name the ending .png", args.output.display());
    }
    if args.round.marching.is_some() {
        bail!("--marching goes with a mesh: on a plane nothing is marched");
    }
    [Some(&args.output), args.common.report.as_ref()].into_iter().flatten().try_for_each(|p| check_output(p))?;
    let bar = Bar::new(args.common.quiet);
    let done = synthesize_plane_image(size, exemplar, job, &bar as &dyn Progress);
    bar.finish();
    let (image, report) = done.map_err(|e| anyhow::Error::new(e).context(args.output.display().to_string()))?;
    for channel in image.channels().iter() {
        let Some(chain) = image.channel(channel) else { continue };
        let path = if channel == Channel::BaseColor { args.output.clone() } else { beside(&args.output, channel) };
        save_channel(&path, chain.finest(), channel)?;
    }
    summary(args, (size[0] * size[1]) as usize, &report, begin.elapsed().as_secs_f64());
    told_in_full(args, (size[0] * size[1]) as usize, None, job, report, begin)
}

/// A channel's image beside the one of colours.
fn beside(path: &Path, channel: Channel) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}_{}.png", channel.name()))
}

/// The result in a line on stdout.
fn summary(args: &SynthArgs, vertices: usize, r: &RoundReport, seconds: f64) {
    if args.common.quiet {
        return;
    }
    let refined = match r.refined {
        Refined::No => "",
        Refined::Cut => " (refined)",
        Refined::Retiled => " (re-tiled)",
    };
    let what = match r.marching {
        Some(m) => format!(
            "{vertices} vertices{refined}, one width is {:.4} long, {} circles{}, {} vertices without a full set",
            r.scale,
            m.closed + m.open,
            if r.marched { "" } else { " as marched before" },
            m.incomplete
        ),
        None => format!("{vertices} pixels"),
    };
    let text = format!(
        "{}: {what}, from {}x{} pixels{}, {} levels, in {seconds:.2} s",
        args.output.display(),
        r.exemplar[0],
        r.exemplar[1],
        if r.tiles { " that tile" } else { "" },
        r.levels.len(),
    );
    let _ = writeln!(std::io::stdout(), "{text}");
}

fn told_in_full(
    args: &SynthArgs,
    vertices: usize,
    clean: Option<CleanReport>,
    job: &RoundJob,
    round: RoundReport,
    begin: Instant,
) -> anyhow::Result<()> {
    let Some(path) = &args.common.report else { return Ok(()) };
    let report = RunReport {
        command: "synth",
        method: "chen-dong",
        mesh: args.plane.is_none().then(|| args.mesh.display().to_string()),
        exemplar: exemplar_path(args).display().to_string(),
        output: args.output.display().to_string(),
        threads: rayon::current_num_threads(),
        vertices,
        options: job.options,
        clean,
        round,
        seconds: begin.elapsed().as_secs_f64(),
        peak_memory_bytes: report::peak_memory(),
    };
    report::write(path, &report)
}
