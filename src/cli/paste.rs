//! `lapped paste`: a mesh and exemplars in, a record with pastes out.

use super::bake::{AtlasArgs, baked, in_words, tell_stills};
use super::bar::Bar;
use super::job_file::{self, JobRegion};
use super::picture::{self, Size};
use super::region::RegionArgs;
use super::{Common, report};
use crate::exemplar::Channel;
use crate::exemplar::auto::Choice;
use crate::format::{check_output, read_model, write_record};
use crate::job::auto::largest_feature;
use crate::job::{BakeReport, Bound, JobError, JobReport, PasteJob, Pasted, Region, available_memory, paste_regions};
use crate::mesh::CleanOptions;
use crate::paste::{Composite, Coverage, PasteError};
use crate::render::{PreviewStyle, Subject, View, preview};
use anyhow::{Context, anyhow, bail};
use clap::Args;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Arguments of `lapped paste`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  Bricks upright, a row of bricks every tenth of a unit or so:
      lapped paste tower.obj bricks.png -o tower.glb --scale 0.8
  Fur that follows a field drawn by a few constraints (see docs/fields.md):
      lapped paste cat.obj fur.png -o cat.glb --field cat-field.json
  Moss, which looks the same every way, and a picture of the result:
      lapped paste rock.ply moss.jpg -o rock.glb --field none --preview rock.png
  Two exemplars, the first three times as often, pasted along outlines drawn by hand:
      lapped paste wall.glb a.png b.png --weights 3,1 --patch a-outlines.json -o wall-lapped.glb
  A material whose maps are named by nobody's habit:
      lapped paste wall.obj w1.png -o wall.glb --normal w2.png --height w3.png --normal-convention directx
  Bricks on the faces of one material only, and a whole model in one run from a job file:
      lapped paste house.glb bricks.png -o house-lapped.glb --where material=wall --border 0.1
      lapped paste house.glb --job house.toml -o house-lapped.glb
  Fine bark over the colours that the mesh is painted in:
      lapped paste tree.ply bark.jpg -o tree.glb --base vertex
  Lava that flows, sixteen frames of it in one image; velvet that changes with the view, from facing to grazing in three images:
      lapped paste rock.ply lava.png -o lava.glb --sprites 4x4 --fps 8
      lapped paste chair.obj velvet_1.png -o chair.glb --sequence --frames view
  A larger bake with wider gutters, or none at all:
      lapped paste rock.ply moss.jpg -o rock.glb --size 4096 --mips 4
      lapped paste rock.ply moss.jpg -o rock.glb --no-bake
  What the method did:
      lapped paste bunny.obj scales.png -o bunny.glb --preview p.png --preview-style pastes --report r.json")]
pub struct PasteArgs {
    /// The mesh: OBJ, PLY, STL, glTF or GLB
    #[arg(value_name = "MESH")]
    pub mesh: PathBuf,
    /// Example images, or folders or file prefixes of material sets (color, normal, height, ...)
    #[arg(value_name = "EXEMPLAR", required_unless_present = "job")]
    pub exemplars: Vec<PathBuf>,
    /// Several textures on one model: regions from this file instead of the flags below (see docs/job.md)
    #[arg(long, value_name = "FILE.toml", conflicts_with_all = OF_A_REGION)]
    pub job: Option<PathBuf>,
    /// Where to write the record (GLB)
    #[arg(short, long, value_name = "OUT.glb")]
    pub output: PathBuf,

    /// See [`RegionArgs`].
    #[command(flatten)]
    pub region: RegionArgs,
    /// Weld vertices closer than this, world units; 0 welds equal positions only
    #[arg(long, value_name = "TOL", default_value_t = 0.0, help_heading = "Method")]
    pub weld: f64,

    /// What draws the coverage buffer: `gpu` is a graphics adapter
    #[arg(long, value_enum, value_name = "BY", default_value_t = CoverageBy::Cpu, help_heading = "Method")]
    pub coverage: CoverageBy,
    /// Graphics adapter for --coverage gpu: a number or a part of a name as `lapped inspect --gpu` lists them
    #[arg(long, value_name = "NAME", help_heading = "Method")]
    pub adapter: Option<String>,

    /// Refuse jobs that would take more memory than this, like 500M or 8G [default: what is free]
    #[arg(long, value_name = "BYTES", value_parser = bytes, help_heading = "Method")]
    pub memory: Option<f64>,

    /// Write the pastes alone: other tools then show a grey model
    #[arg(long, help_heading = "Baking")]
    pub no_bake: bool,
    /// See [`AtlasArgs`].
    #[command(flatten)]
    pub atlas: AtlasArgs,

    /// Also draw the result: four views on one sheet
    #[arg(long, value_name = "FILE.png", help_heading = "Pictures")]
    pub preview: Option<PathBuf>,
    /// What the preview shows: texture, pastes, field, coverage, stretch, wireframe
    #[arg(long, value_name = "STYLE", default_value_t = PreviewStyle::Texture, help_heading = "Pictures")]
    pub preview_style: PreviewStyle,
    /// Size of the preview in pixels
    #[arg(long, value_name = "WxH", default_value_t = Size([1024, 1024]), help_heading = "Pictures")]
    pub preview_size: Size,
    /// One view instead of four, like front, or yaw=30,pitch=15,zoom=1.2
    #[arg(long, value_name = "VIEW", help_heading = "Pictures")]
    pub camera: Option<View>,

    /// See [`Common`].
    #[command(flatten)]
    pub common: Common,
}

/// What draws the coverage buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum CoverageBy {
    /// The processor
    Cpu,
    /// A graphics adapter
    Gpu,
}

/// A number of bytes, as K, M or G if it ends so.
fn bytes(text: &str) -> Result<f64, String> {
    let (number, unit) = match text.char_indices().last() {
        Some((at, 'k' | 'K')) => (&text[..at], 1e3),
        Some((at, 'm' | 'M')) => (&text[..at], 1e6),
        Some((at, 'g' | 'G')) => (&text[..at], 1e9),
        _ => (text, 1.0),
    };
    let bytes = number.parse::<f64>().ok().map(|n| n * unit).filter(|b| *b > 0.0);
    bytes.ok_or_else(|| "give a number of bytes, like 500M or 8G".to_owned())
}

/// Flags that belong into a job file where there is one.
const OF_A_REGION: [&str; 42] = [
    "exemplars",
    "scale",
    "ratio",
    "up",
    "field",
    "scale_field",
    "keep_faces",
    "patch",
    "feather",
    "plain",
    "no_windows",
    "no_cuts",
    "keep_contrast",
    "base",
    "no_overlays",
    "small",
    "no_prune",
    "splotches",
    "weights",
    "color_only",
    "normal",
    "height",
    "roughness",
    "metallic",
    "occlusion",
    "emissive",
    "opacity",
    "normal_convention",
    "equalize",
    "frames",
    "sequence",
    "sprites",
    "fps",
    "seed",
    "distortion",
    "predictor",
    "fit_weights",
    "isotropic_fit",
    "no_sort",
    "no_cull",
    "area",
    "border",
];

/// The report of a run.
#[derive(Debug, Serialize)]
struct RunReport<'a> {
    command: &'static str,
    version: &'static str,
    mesh: String,
    exemplars: Vec<String>,
    output: String,
    threads: usize,
    #[serde(flatten)]
    job: &'a JobReport,
    /// What exemplars were found to ask for (`--patch auto`).
    #[serde(skip_serializing_if = "Vec::is_empty")]
    choices: Vec<Choice>,
    bake: Option<BakeReport>,
    seconds: RunSeconds,
    peak_memory_bytes: Option<u64>,
}

#[derive(Debug, Default, Serialize)]
struct RunSeconds {
    read: f64,
    job: f64,
    bake: f64,
    write: f64,
    preview: f64,
    total: f64,
}

/// Runs the command.
///
/// # Errors
/// If a file cannot be read or written, or the job cannot be done.
pub fn run(args: &PasteArgs) -> anyhow::Result<()> {
    let begin = Instant::now();
    let bar = Bar::new(args.common.quiet);
    let mut seconds = RunSeconds::default();
    // What cannot be written is told before the work, not after it, and leaves nothing half done.
    [Some(&args.output), args.preview.as_ref(), args.common.report.as_ref()]
        .into_iter()
        .flatten()
        .try_for_each(|p| check_output(p))?;
    let named = match &args.job {
        Some(file) => job_file::read(file)?,
        None => vec![JobRegion { name: String::new(), exemplars: args.exemplars.clone(), args: args.region.clone() }],
    };
    let (regions, mut choices) = regions(args, &named)?;
    let model = read_model(&args.mesh)?;
    for note in &model.source.notes {
        args.common.warn(&format!("{}: {note}", args.mesh.display()));
    }
    seconds.read = begin.elapsed().as_secs_f64();

    let start = Instant::now();
    let done = paste_regions(&model, regions, &bar);
    bar.finish();
    let mut pasted = done.map_err(|e| anyhow!("{}: {e}", culprit(args, &named, &e)))?;
    if let Some(choice) = choices.first_mut() {
        choice.reasons.extend(too_large(args, &pasted, choice));
    }
    seconds.job = start.elapsed().as_secs_f64();
    pasted.report.warnings.iter().for_each(|w| args.common.warn(w));

    let start = Instant::now();
    pasted.record.job = describe(args, &pasted);
    let mut bake = None;
    if !args.no_bake {
        let name = || args.mesh.display().to_string();
        let record = std::mem::take(&mut pasted.record);
        tell_stills(&record, &args.common);
        let bound = Bound::new(record.clone()).with_context(name)?;
        let (record, _, report) = baked(&record, &bound, &args.atlas, &args.common, &bar).with_context(name)?;
        bar.finish();
        pasted.record = record;
        bake = Some(report);
    }
    seconds.bake = start.elapsed().as_secs_f64();
    let start = Instant::now();
    write_record(&args.output, &pasted.record)?;
    seconds.write = start.elapsed().as_secs_f64();

    if let Some(path) = &args.preview {
        let start = Instant::now();
        draw(args, &pasted, path)?;
        seconds.preview = start.elapsed().as_secs_f64();
    }
    seconds.total = begin.elapsed().as_secs_f64();
    summary(args, &pasted, bake.as_ref(), seconds.total);
    if let Some(path) = &args.common.report {
        let report = RunReport {
            command: "paste",
            version: env!("CARGO_PKG_VERSION"),
            mesh: args.mesh.display().to_string(),
            exemplars: named.iter().flat_map(|r| &r.exemplars).map(|p| p.display().to_string()).collect(),
            output: args.output.display().to_string(),
            threads: rayon::current_num_threads(),
            job: &pasted.report,
            choices,
            bake,
            seconds,
            peak_memory_bytes: report::peak_memory(),
        };
        report::write(path, &report)?;
    }
    Ok(())
}

/// The regions, with everything they name read, and what exemplars were found to ask for.
fn regions(args: &PasteArgs, named: &[JobRegion]) -> anyhow::Result<(Vec<Region>, Vec<Choice>)> {
    if !(args.weld >= 0.0 && args.weld.is_finite()) {
        bail!("--weld is {}: give a length in world units, 0 or more", args.weld);
    }
    let clean = CleanOptions { weld: args.weld, ..CleanOptions::default() };
    let memory = args.memory.or_else(available_memory);
    let coverage = coverage(args)?;
    let mut choices = Vec::new();
    let mut regions = Vec::new();
    for (index, region) in named.iter().enumerate() {
        let read = region.args.region(&region.name, &region.exemplars, &args.common);
        let (mut read, found) = match &args.job {
            Some(file) => read.with_context(|| format!("{}: region {} ({:?})", file.display(), index + 1, region.name))?,
            None => read?,
        };
        read.job = PasteJob { clean: clean.clone(), memory, ..read.job };
        read.job.paste.coverage = coverage.clone();
        regions.push(read);
        choices.extend(found);
    }
    Ok((regions, choices))
}

/// Tells if the features of an exemplar that chose its patches are too large for the mesh.
fn too_large(args: &PasteArgs, pasted: &Pasted, choice: &Choice) -> Option<String> {
    let (scale, feature) = (pasted.report.scale, f64::from(choice.feature));
    let most = largest_feature(&pasted.mesh);
    let reason = (!choice.outlines.is_empty() && feature * scale > most).then(|| {
        format!(
            "its features are {:.3} long here, and thin parts of the mesh bend those above {most:.3} around: --scale {:.3} would fit them",
            feature * scale,
            most / feature
        )
    })?;
    args.common.say(&format!("patches of {}: {reason}", choice.exemplar));
    Some(reason)
}

/// What draws coverage.
fn coverage(args: &PasteArgs) -> anyhow::Result<Coverage> {
    match args.coverage {
        CoverageBy::Cpu if args.adapter.is_some() => bail!("--adapter is for --coverage gpu: leave it out, or add that"),
        CoverageBy::Cpu => Ok(Coverage::default()),
        CoverageBy::Gpu => on_adapter(args),
    }
}

#[cfg(feature = "gpu")]
fn on_adapter(args: &PasteArgs) -> anyhow::Result<Coverage> {
    use crate::render::gpu::{Gpu, GpuCoverage, GpuOptions};
    let gpu = Gpu::new(&GpuOptions { adapter: args.adapter.clone(), limits: None })?;
    Ok(Coverage(Some(std::sync::Arc::new(GpuCoverage::new(gpu)?))))
}

#[cfg(not(feature = "gpu"))]
fn on_adapter(_args: &PasteArgs) -> anyhow::Result<Coverage> {
    bail!("this program was built without graphics adapters (the cargo feature gpu): leave out --coverage gpu")
}

/// The file that an error concerns, or the flag.
fn culprit(args: &PasteArgs, named: &[JobRegion], error: &JobError) -> String {
    let (index, inner) = match error {
        JobError::Region { index, source, .. } => (*index, &**source),
        other => (0, other),
    };
    let region = named.get(index);
    let of_region = args.job.as_ref().unwrap_or(&args.mesh);
    let file = match inner {
        JobError::Exemplar { index, .. } => region.and_then(|r| r.exemplars.get(*index)).unwrap_or(&args.mesh),
        JobError::Field(_) | JobError::Paste(PasteError::NoBasis { .. } | PasteError::GuideSize { .. }) => {
            region.and_then(|r| r.args.field_file()).unwrap_or(&args.mesh)
        }
        JobError::Feather { .. } if args.job.is_none() => return "--feather".to_owned(),
        JobError::Paste(PasteError::Coverage(_)) => return "--coverage".to_owned(),
        JobError::Area(_) | JobError::Feather { .. } | JobError::Scale(_) => of_region,
        _ => &args.mesh,
    };
    file.display().to_string()
}

/// What the record says of how it was made.
fn describe(args: &PasteArgs, pasted: &Pasted) -> serde_json::Value {
    serde_json::json!({
        "seed": args.region.seed,
        "scale": pasted.report.scale,
        "field": args.region.field.clone().unwrap_or_else(|| "up".to_owned()),
        "feather": args.region.feather,
        "plain": args.region.plain,
        "windows": !args.region.plain && !args.region.no_windows,
        "cuts": !args.region.plain && !args.region.no_cuts,
        "contrast": args.region.keep_contrast,
        "base": args.region.base.map(|base| base.to_string()),
        "overlays": !args.region.plain && !args.region.no_overlays,
        "small": args.region.small,
        "prune": !args.region.plain && !args.region.no_prune,
        "regions": pasted.report.regions.iter().map(|r| &r.name).collect::<Vec<_>>(),
        "pastes": pasted.report.paste.pastes,
        "drawsPerFace": pasted.report.paste.draws_per_face,
    })
}

fn draw(args: &PasteArgs, pasted: &Pasted, path: &Path) -> anyhow::Result<()> {
    let texture = Composite::new(&pasted.mesh, &pasted.lapped);
    let subject = Subject { mesh: &pasted.mesh, texture: &texture, lapped: Some(&pasted.lapped), guide: Some(&pasted.guide) };
    let options = picture::views(args.camera, args.preview_size.0, 2, false, picture::up_axis(args.region.up));
    picture::save(path, &preview(&subject, args.preview_style, &options)?)
}

/// The result in two lines on stdout, or three.
fn summary(args: &PasteArgs, pasted: &Pasted, bake: Option<&BakeReport>, seconds: f64) {
    use std::io::Write;
    let Pasted { report, lapped, .. } = pasted;
    let p = &report.paste;
    let channels: Vec<&str> =
        lapped.exemplars.first().map(|e| e.channels().iter().map(Channel::name).collect()).unwrap_or_default();
    let text = format!(
        "{}: {} pastes of {} texture patches ({}) on {} faces, {:.2} draws per face, least alpha {:.3}, in {seconds:.2} s",
        args.output.display(),
        p.pastes,
        report.patches,
        channels.join(", "),
        report.clean.faces,
        p.draws_per_face,
        p.least_alpha,
    );
    if !args.common.quiet {
        let _ = writeln!(std::io::stdout(), "{text}");
        if let Some(bake) = bake {
            let _ = writeln!(std::io::stdout(), "{}", in_words(bake));
        }
    }
}
