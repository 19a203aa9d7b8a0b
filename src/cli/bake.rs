//! `lapped bake`: a record in, a model with a texture atlas out that any tool opens.

use super::bar::Bar;
use super::{Common, picture, report};
use crate::atlas::{Atlas, AtlasError, BakeOptions, ChartMethod, UnwrapOptions};
use crate::exemplar::{Exemplar, Frames, FramesBy};
use crate::format::export::{Export, Kind, write_layers, write_look, write_mips};
use crate::format::{Model, Record, check_output, read_record, save_image, write_record};
use crate::job::bake::{chart_colors, default_samples, default_size, page_view, with_normals};
use crate::job::{BakeJob, BakeReport, BakedModel, Bound, Coordinates, Displace, bake_record, bake_record_sized, displace_mesh};
use crate::mesh::Mesh;
use crate::paste::Compositing;
use crate::render::{PreviewStyle, Subject, UpAxis, preview};
use anyhow::{Context, bail};
use clap::Args;
use serde::Serialize;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Arguments of `lapped bake`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  lapped bake bunny.glb -o bunny-baked.glb                      opens textured anywhere; our tools still find the pastes
  lapped bake bunny.glb -o bunny.glb --size 4096 --mips 4       larger, with wider gutters
  lapped bake bunny.glb -o bunny.obj                            bunny.obj, bunny.mtl and an image for each map
  lapped bake bunny.glb -o bunny.gltf                           bunny.gltf, bunny.bin and its images
  lapped bake wall.glb -o relief.glb --displace 0.05            the relief as geometry
  lapped bake bunny.glb -o b.glb --show-charts c.png --show-uv uv.png
  lapped bake bunny.glb -o layers.glb --layers                  the pastes themselves, for any engine
  lapped bake spot.glb -o spot-baked.glb --uv keep              into the model's own coordinates
  lapped bake lava.glb -o lava-1.obj --time 1                   a moment of an exemplar that changes")]
pub struct BakeArgs {
    /// A record (GLB written by `lapped paste`)
    #[arg(value_name = "MODEL.glb")]
    pub model: PathBuf,
    /// Where to write: .glb, .gltf, .obj or .ply
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
    /// See [`AtlasArgs`].
    #[command(flatten)]
    pub atlas: AtlasArgs,
    /// Cut the mesh fine and move it by the texture's height: world units from the darkest to the brightest
    #[arg(long, value_name = "LENGTH", value_parser = length)]
    pub displace: Option<f64>,
    /// Faces to cut a displaced mesh into, about
    #[arg(long, value_name = "N", default_value_t = Displace::FACES, requires = "displace")]
    pub displace_faces: usize,
    /// Write the pastes themselves as overlapping primitives, blended by alpha: no atlas; heights and opacity are lost
    #[arg(long, conflicts_with_all = ["displace", "size", "pages", "mips", "mip_chain", "bake_samples", "charts", "uv", "baker", "bake_adapter", "no_record"])]
    pub layers: bool,
    /// Also draw the charts on the model: four views on one sheet
    #[arg(long, value_name = "FILE.png", help_heading = "Pictures", conflicts_with = "layers")]
    pub show_charts: Option<PathBuf>,
    /// Also draw the charts as they lie in the image
    #[arg(long, value_name = "FILE.png", help_heading = "Pictures", conflicts_with = "layers")]
    pub show_uv: Option<PathBuf>,
    /// Leave the pastes out of the GLB: smaller, but our own tools see a plain textured model
    #[arg(long)]
    pub no_record: bool,
    /// Bake exemplars that change with time as they are so many seconds after their first frame
    #[arg(long, value_name = "SECONDS", value_parser = super::render::seconds, allow_hyphen_values = true, default_value_t = 0.0)]
    pub time: f64,
    /// See [`Common`].
    #[command(flatten)]
    pub common: Common,
}

/// How to make an atlas, for every command that bakes.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Baking")]
pub struct AtlasArgs {
    /// Texels along each side of the atlas [default: what the exemplar's detail needs, a power of two up to 2048]
    #[arg(long, value_name = "TEXELS", value_parser = clap::value_parser!(u32).range(16..=16384))]
    pub size: Option<u32>,
    /// Images to spread the charts over
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=64))]
    pub pages: u32,
    /// Mip levels below the finest that show no other chart's colour; each doubles the gutters
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(0..=8))]
    pub mips: u32,
    /// Also write all mip levels of each map, beside the file, as KTX 2.0 (.ktx2)
    #[arg(long)]
    pub mip_chain: bool,
    /// Samples along each side of a texel: 1, 2, 4 or 8 [default: as many as it holds pixels of the exemplar, about]
    #[arg(long, value_name = "N", value_parser = samples)]
    pub bake_samples: Option<u32>,
    /// How charts are made
    #[arg(long, value_enum, value_name = "HOW", default_value_t = ChartArg::Auto)]
    pub charts: ChartArg,
    /// Where texels lie: in charts that are made, or in the model's own coordinates
    #[arg(long, value_enum, value_name = "WHERE", default_value_t = UvArg::Charts)]
    pub uv: UvArg,
    /// What composites the pastes at each texel
    #[arg(long, value_enum, value_name = "BY", default_value_t = BakerArg::Auto)]
    pub baker: BakerArg,
    /// Graphics adapter to bake on: a number or a part of a name as `lapped inspect --gpu` lists them
    #[arg(long, value_name = "NAME")]
    pub bake_adapter: Option<String>,
}

fn length(text: &str) -> Result<f64, String> {
    let wrong = || "give a length in world units that is not 0, like 0.02; below 0 bright is inward".to_owned();
    text.parse().ok().filter(|l: &f64| l.is_finite() && *l != 0.0).ok_or_else(wrong)
}

fn samples(text: &str) -> Result<u32, String> {
    text.parse().ok().filter(|n| [1, 2, 4, 8].contains(n)).ok_or_else(|| "give 1, 2, 4 or 8".to_owned())
}

/// Names of [`ChartMethod`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
pub enum ChartArg {
    /// Few charts of little stretch
    #[default]
    Auto,
    /// Discs grown face by face, the paper's way
    Grow,
}

/// Names of [`Coordinates`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
pub enum UvArg {
    /// Charts that are made
    #[default]
    Charts,
    /// The model's own coordinates, if no two faces share a texel
    Keep,
}

/// What composites pastes for a bake.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
pub enum BakerArg {
    /// A graphics adapter if there is one in hardware, else the processor
    #[default]
    Auto,
    /// The processor
    Cpu,
    /// A graphics adapter
    Gpu,
}

impl AtlasArgs {
    /// What composites the pastes: an adapter only if it can be used, unless it was asked for.
    fn compositing(&self, common: &Common) -> anyhow::Result<Compositing> {
        let named = self.bake_adapter.as_deref();
        match self.baker {
            BakerArg::Cpu if named.is_some() => bail!("--bake-adapter is for baking on an adapter: leave out --baker cpu"),
            BakerArg::Cpu => Ok(Compositing::default()),
            BakerArg::Auto if named.is_none() => Ok(if_hardware().unwrap_or_else(|e| {
                common.warn(&format!("the processor bakes: {e:#}"));
                Compositing::default()
            })),
            BakerArg::Auto | BakerArg::Gpu => on_adapter(named),
        }
    }

    /// The job for a record, at a size that suits it unless one was given.
    #[must_use]
    pub fn job(&self, bound: &Bound) -> BakeJob {
        let (mesh, lapped) = (&bound.mesh, &bound.lapped);
        let size = self.size.unwrap_or_else(|| default_size(mesh, lapped));
        let samples = self.bake_samples.unwrap_or_else(|| default_samples(mesh, lapped, size));
        BakeJob {
            coordinates: match self.uv {
                UvArg::Charts => Coordinates::Charts,
                UvArg::Keep => Coordinates::Own,
            },
            unwrap: UnwrapOptions {
                size,
                pages: self.pages,
                mips: self.mips,
                method: match self.charts {
                    ChartArg::Auto => ChartMethod::Auto,
                    ChartArg::Grow => ChartMethod::Grow,
                },
                ..UnwrapOptions::default()
            },
            bake: BakeOptions { samples, mips: self.mip_chain, ..BakeOptions::default() },
            crease: None,
            compositing: Compositing::default(),
        }
    }
}

#[cfg(feature = "gpu")]
fn on_adapter(name: Option<&str>) -> anyhow::Result<Compositing> {
    use crate::render::gpu::{Gpu, GpuComposite, GpuOptions};
    let gpu = Gpu::new(&GpuOptions { adapter: name.map(str::to_owned), limits: None })?;
    Ok(Compositing(Some(std::sync::Arc::new(GpuComposite::new(gpu)?))))
}

#[cfg(not(feature = "gpu"))]
fn on_adapter(_name: Option<&str>) -> anyhow::Result<Compositing> {
    bail!("this program was built without graphics adapters (the cargo feature gpu): bake with --baker cpu")
}

/// An adapter of hardware if there is one; one in software has nothing over the processor.
#[cfg(feature = "gpu")]
fn if_hardware() -> anyhow::Result<Compositing> {
    if crate::render::gpu::has_hardware() { on_adapter(None) } else { Ok(Compositing::default()) }
}

#[cfg(not(feature = "gpu"))]
fn if_hardware() -> anyhow::Result<Compositing> {
    Ok(Compositing::default())
}

#[derive(Debug, Serialize)]
struct RunReport<'a> {
    command: &'static str,
    version: &'static str,
    model: String,
    output: String,
    threads: usize,
    #[serde(flatten)]
    bake: &'a BakeReport,
    total_seconds: f64,
    peak_memory_bytes: Option<u64>,
}

/// Runs the command.
///
/// # Errors
/// If a file cannot be read or written, or the charts do not fit.
pub fn run(args: &BakeArgs) -> anyhow::Result<()> {
    let begin = Instant::now();
    let kind = Kind::of(&args.output)?;
    [Some(&args.output), args.common.report.as_ref(), args.show_charts.as_ref(), args.show_uv.as_ref()]
        .into_iter()
        .flatten()
        .try_for_each(|p| check_output(p))?;
    let bar = Bar::new(args.common.quiet);
    let record = read_record(&args.model)?;
    tell_stills(&record, &args.common);
    if args.layers {
        return layers(args, kind, record, begin);
    }
    let name = || args.model.display().to_string();
    let mut bound = Bound::new(record.clone()).with_context(name)?;
    at_time(&mut bound.lapped.exemplars, args.time);
    let (record, atlas, report) = match args.displace {
        Some(height) => displaced(args, &record, &bound, height, &bar).with_context(name)?,
        None => baked(&record, &bound, &args.atlas, &args.common, &bar).with_context(name)?,
    };
    pictures(args, &bound.mesh, &atlas, &bar)?;
    bar.finish();
    write(&args.output, kind, &record, args.no_record || args.displace.is_some())?;
    let seconds = begin.elapsed().as_secs_f64();
    if !args.common.quiet {
        writeln!(std::io::stdout(), "{}: {}, in {seconds:.2} s", args.output.display(), in_words(&report))?;
    }
    if let Some(path) = &args.common.report {
        let found = RunReport {
            command: "bake",
            version: env!("CARGO_PKG_VERSION"),
            model: args.model.display().to_string(),
            output: args.output.display().to_string(),
            threads: rayon::current_num_threads(),
            bake: &report,
            total_seconds: seconds,
            peak_memory_bytes: report::peak_memory(),
        };
        report::write(path, &found)?;
    }
    Ok(())
}

/// A record with its bake.
///
/// # Errors
/// If the charts do not fit, or the adapter that was asked for cannot bake.
pub(super) fn baked(
    record: &Record,
    bound: &Bound,
    args: &AtlasArgs,
    common: &Common,
    bar: &Bar,
) -> anyhow::Result<(Record, Atlas, BakeReport)> {
    by_any(args, bound, common, |job| match args.size {
        Some(_) => bake_record(record.clone(), bound, job, bar),
        None => bake_record_sized(record, bound, job, bar),
    })
}

/// Does a bake by what was asked for; by the processor where an adapter that nobody asked for fails.
fn by_any<T>(
    args: &AtlasArgs,
    bound: &Bound,
    common: &Common,
    bake: impl Fn(&BakeJob) -> Result<T, AtlasError>,
) -> anyhow::Result<T> {
    let job = BakeJob { compositing: args.compositing(common)?, ..args.job(bound) };
    match bake(&job) {
        Err(AtlasError::Baker(what)) if args.baker == BakerArg::Auto && args.bake_adapter.is_none() => {
            common.warn(&format!("the processor bakes: {what}"));
            Ok(bake(&BakeJob { compositing: Compositing::default(), ..job })?)
        }
        done => Ok(done?),
    }
}

/// The pictures of charts that were asked for.
fn pictures(args: &BakeArgs, mesh: &Mesh, atlas: &Atlas, bar: &Bar) -> anyhow::Result<()> {
    if let Some(path) = &args.show_charts {
        let colors = chart_colors(mesh, atlas);
        let subject = Subject { mesh, texture: &colors, lapped: None, guide: None };
        let sheet = picture::views(None, [1024; 2], 2, false, UpAxis::Y);
        picture::save(path, &preview(&subject, PreviewStyle::Texture, &sheet)?)?;
    }
    if let Some(path) = &args.show_uv {
        save_image(path, &page_view(mesh, atlas, bar)?)?;
    }
    Ok(())
}

/// A record's model, displaced, with its bake; nothing else of the record fits it any more.
fn displaced(
    args: &BakeArgs,
    record: &Record,
    bound: &Bound,
    height: f64,
    bar: &Bar,
) -> anyhow::Result<(Record, Atlas, BakeReport)> {
    let displace = Displace { height, faces: args.displace_faces };
    let BakedModel { model, look, atlas, report } = by_any(&args.atlas, bound, &args.common, |job| {
        let texture = job.compositing.of(&bound.mesh, &bound.lapped).map_err(AtlasError::Baker)?;
        displace_mesh(&bound.mesh, texture.as_ref(), job, &displace, bar)
    })?;
    let model = Model { name: record.model.name.clone(), ..model };
    Ok((Record { model, look: Some(look), generator: record.generator.clone(), ..Record::default() }, atlas, report))
}

/// Exemplars that change with time, as they are at one.
fn at_time(exemplars: &mut [Exemplar], seconds: f64) {
    let moving = |e: &&mut Exemplar| e.frames().is_some_and(|frames| frames.by() == FramesBy::Time);
    exemplars.iter_mut().filter(moving).for_each(|e| *e = e.at(seconds));
}

/// Tells that what is baked stands still.
pub(super) fn tell_stills(record: &Record, common: &Common) {
    for exemplar in &record.lapped.exemplars {
        let shown = match exemplar.frames().map(Frames::by) {
            None => continue,
            Some(FramesBy::Time) => "one moment: choose it with `lapped bake --time SECONDS`",
            Some(FramesBy::View | FramesBy::Light) => "the first alone",
        };
        common.warn(&format!("exemplar {}: its frames cannot be baked, so the baked texture shows {shown}", exemplar.name));
    }
}

/// Writes the pastes as ordinary primitives.
fn layers(args: &BakeArgs, kind: Kind, mut record: Record, begin: Instant) -> anyhow::Result<()> {
    if kind != Kind::Glb {
        bail!("{}: layers are written as .glb: give the name this ending", args.output.display());
    }
    record.model = with_normals(&record.model)?;
    at_time(&mut record.lapped.exemplars, args.time);
    let report = write_layers(&args.output, &record)?;
    if record.lapped.exemplars.len() > 1 {
        args.common.warn(
            "with several exemplars the layers have several materials: renderers that sort translucent parts by distance may draw \
             them in another order",
        );
    }
    if !args.common.quiet {
        let seconds = begin.elapsed().as_secs_f64();
        writeln!(
            std::io::stdout(),
            "{}: {} pastes as {} primitives of {} triangles, {} materials, in {seconds:.2} s",
            args.output.display(),
            record.lapped.pastes.len(),
            report.primitives,
            report.triangles,
            report.materials
        )?;
    }
    if let Some(path) = &args.common.report {
        report::write(path, &report)?;
    }
    Ok(())
}

fn write(path: &Path, kind: Kind, record: &Record, plain: bool) -> anyhow::Result<()> {
    let Some(look) = &record.look else { bail!("{}: nothing was baked", path.display()) };
    if kind == Kind::Glb && !plain {
        write_record(path, record)?;
    } else {
        write_look(path, kind, &Export { model: &record.model, look, generator: &record.generator })?;
    }
    write_mips(path, look)?;
    Ok(())
}

/// A bake in a line.
pub(super) fn in_words(report: &BakeReport) -> String {
    let pages = if report.pages > 1 { format!(" on {} pages", report.pages) } else { String::new() };
    format!(
        "baked {} charts into {size} x {size} texels{pages}, {:.0} % filled, stretch {:.3}, borders differ by {:.2} of 255",
        report.charts,
        100.0 * report.efficiency,
        report.stretch.l2,
        report.bake.seams.mean,
        size = report.size,
    )
}
