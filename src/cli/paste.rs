//! `lapped paste`: a mesh and exemplars in, a record with pastes out.

use super::bar::Bar;
use super::picture::{self, Size};
use super::channels::ChannelArgs;
use super::{Common, report};
use crate::exemplar::{Channel, Outline, PatchOptions, PatchShape, PatchSource, PatchSpec};
use crate::field::Constraints;
use crate::format::{check_output, read_exemplar, read_file, read_mask, read_model, write_record};
use crate::job::{ExemplarInput, JobReport, PasteJob, Pasted, Scale, Steer, paste_model};
use crate::mesh::CleanOptions;
use crate::paste::{Composite, IsotropicFit, PasteOptions, Predictor, Weights};
use crate::render::{PreviewStyle, Subject, View, preview};
use anyhow::{Context, anyhow, bail};
use clap::Args;
use glam::DVec3;
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
  What the method did:
      lapped paste bunny.obj scales.png -o bunny.glb --preview p.png --preview-style pastes --report r.json")]
pub struct PasteArgs {
    /// The mesh: OBJ, PLY, STL, glTF or GLB
    #[arg(value_name = "MESH")]
    pub mesh: PathBuf,
    /// Example images, or folders or file prefixes of material sets (color, normal, height, ...)
    #[arg(value_name = "EXEMPLAR", required = true)]
    pub exemplars: Vec<PathBuf>,
    /// Where to write the record (GLB)
    #[arg(short, long, value_name = "OUT.glb")]
    pub output: PathBuf,

    /// World length of one exemplar width
    #[arg(long, value_name = "LENGTH", conflicts_with = "ratio", help_heading = "Size and direction")]
    pub scale: Option<f64>,
    /// Surface area over exemplar area, if no --scale is given
    #[arg(long, value_name = "N", default_value_t = crate::field::DEFAULT_RATIO, help_heading = "Size and direction")]
    pub ratio: f64,
    /// Texture up: an axis (x, y, z, -x, ...) or X,Y,Z, projected onto the surface [default: y]
    #[arg(long, value_name = "AXIS", value_parser = super::axis, allow_hyphen_values = true, help_heading = "Size and direction")]
    pub up: Option<DVec3>,
    /// `none` for textures that look the same every way, or a JSON file: constraints, or a field with a vector per face
    #[arg(long, value_name = "none|FILE.json", help_heading = "Size and direction")]
    pub field: Option<String>,
    /// With --field none: constraints of which the scales count
    #[arg(long, value_name = "FILE.json", help_heading = "Size and direction")]
    pub scale_field: Option<PathBuf>,
    /// Leave large faces as they are: by default those larger than an exemplar, and around singularities of the field, are cut
    #[arg(long, help_heading = "Size and direction")]
    pub keep_faces: bool,

    /// Shape of the texture patches: whole, circle, splotch, a mask image, or a JSON file with outlines; may be repeated
    /// [default: the exemplar's own transparency if it has any, else splotch]
    #[arg(long, value_name = "SHAPE", help_heading = "Texture patches")]
    pub patch: Vec<String>,
    /// Pixels over which alpha falls off at a patch's edge [default: 3, or 1.5 % of a larger exemplar]
    #[arg(long, value_name = "PX", help_heading = "Texture patches")]
    pub feather: Option<f32>,
    /// Different splotches per exemplar
    #[arg(long, value_name = "N", default_value_t = 3, help_heading = "Texture patches")]
    pub splotches: u32,
    /// How often each exemplar is pasted relative to the others, in their order
    #[arg(long, value_name = "W,W,...", value_delimiter = ',', help_heading = "Texture patches")]
    pub weights: Vec<f32>,
    /// Read each exemplar's named image alone, without looking for normal, height and other maps beside it
    #[arg(long, help_heading = "Texture patches")]
    pub color_only: bool,

    /// See [`ChannelArgs`].
    #[command(flatten)]
    pub channels: ChannelArgs,

    /// Seed of all random choices
    #[arg(long, value_name = "N", default_value_t = 1, help_heading = "Method")]
    pub seed: u64,
    /// How far a face may be stretched against the field before a patch stops growing there [default: 1 with a direction,
    /// 1.4 without]
    #[arg(long, value_name = "BOUND", help_heading = "Method")]
    pub distortion: Option<f64>,
    /// How growth places new vertices
    #[arg(long, value_enum, default_value_t = PredictorArg::Field, help_heading = "Method")]
    pub predictor: PredictorArg,
    /// What a face counts in the fit
    #[arg(long, value_enum, default_value_t = WeightsArg::Area, help_heading = "Method")]
    pub fit_weights: WeightsArg,
    /// How patches without a direction are fitted
    #[arg(long, value_enum, default_value_t = IsotropicArg::Rotations, help_heading = "Method")]
    pub isotropic_fit: IsotropicArg,
    /// Keep pastes in the order laid, instead of sorting hard edges to the bottom
    #[arg(long, help_heading = "Method")]
    pub no_sort: bool,
    /// Keep faces that later pastes hide
    #[arg(long, help_heading = "Method")]
    pub no_cull: bool,
    /// Weld vertices closer than this, world units; 0 welds equal positions only
    #[arg(long, value_name = "TOL", default_value_t = 0.0, help_heading = "Method")]
    pub weld: f64,

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

/// Names of [`Predictor`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum PredictorArg {
    /// By the tangent field
    Field,
    /// By triangles similar to the faces around (Maillot 1993, the paper's)
    Maillot,
}

/// Names of [`Weights`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum WeightsArg {
    /// Its area
    Area,
    /// One (the paper's sum)
    Uniform,
}

/// Names of [`IsotropicFit`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum IsotropicArg {
    /// To the directions propagated in growth (the paper's)
    Propagated,
    /// Then to the rotation nearest to what each face got
    Rotations,
    /// By the linear conformal functional
    Conformal,
}

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
    seconds: RunSeconds,
    peak_memory_bytes: Option<u64>,
}

#[derive(Debug, Default, Serialize)]
struct RunSeconds {
    read: f64,
    job: f64,
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
    let job = job(args)?;
    let inputs = inputs(args)?;
    let model = read_model(&args.mesh)?;
    for note in &model.source.notes {
        args.common.warn(&format!("{}: {note}", args.mesh.display()));
    }
    seconds.read = begin.elapsed().as_secs_f64();

    let start = Instant::now();
    let mesh = args.mesh.display();
    let done = paste_model(&model, inputs, &job, &bar);
    bar.finish();
    let mut pasted = done.with_context(|| format!("{mesh}"))?;
    seconds.job = start.elapsed().as_secs_f64();
    pasted.report.warnings.iter().for_each(|w| args.common.warn(w));

    let start = Instant::now();
    pasted.record.job = describe(args, &pasted);
    write_record(&args.output, &pasted.record)?;
    seconds.write = start.elapsed().as_secs_f64();

    if let Some(path) = &args.preview {
        let start = Instant::now();
        draw(args, &pasted, path)?;
        seconds.preview = start.elapsed().as_secs_f64();
    }
    seconds.total = begin.elapsed().as_secs_f64();
    summary(args, &pasted, seconds.total);
    if let Some(path) = &args.common.report {
        let report = RunReport {
            command: "paste",
            version: env!("CARGO_PKG_VERSION"),
            mesh: args.mesh.display().to_string(),
            exemplars: args.exemplars.iter().map(|p| p.display().to_string()).collect(),
            output: args.output.display().to_string(),
            threads: rayon::current_num_threads(),
            job: &pasted.report,
            seconds,
            peak_memory_bytes: report::peak_memory(),
        };
        report::write(path, &report)?;
    }
    Ok(())
}

/// The validated job of the arguments.
fn job(args: &PasteArgs) -> anyhow::Result<PasteJob> {
    let scale = match args.scale {
        Some(length) if !(length > 0.0 && length.is_finite()) => {
            bail!("--scale is {length}: give the world length of one exemplar width, a number above zero")
        }
        Some(length) => Scale::World(length),
        None if !(args.ratio > 0.0 && args.ratio.is_finite()) => {
            bail!("--ratio is {}: give a number above zero (40 is the default)", args.ratio)
        }
        None => Scale::Ratio(args.ratio),
    };
    if !(args.weld >= 0.0 && args.weld.is_finite()) {
        bail!("--weld is {}: give a length in world units, 0 or more", args.weld);
    }
    Ok(PasteJob {
        clean: CleanOptions { weld: args.weld, ..CleanOptions::default() },
        scale,
        steer: steer(args)?,
        keep_faces: args.keep_faces,
        feather: args.feather,
        patches: PatchOptions { seed: args.seed, splotches: args.splotches, ..PatchOptions::default() },
        paste: PasteOptions {
            seed: args.seed,
            distortion: args.distortion,
            predictor: match args.predictor {
                PredictorArg::Field => Predictor::Field,
                PredictorArg::Maillot => Predictor::SimilarTriangles,
            },
            weights: match args.fit_weights {
                WeightsArg::Area => Weights::Area,
                WeightsArg::Uniform => Weights::Uniform,
            },
            isotropic_fit: match args.isotropic_fit {
                IsotropicArg::Propagated => IsotropicFit::Propagated,
                IsotropicArg::Rotations => IsotropicFit::default(),
                IsotropicArg::Conformal => IsotropicFit::Conformal,
            },
            hide_hard_edges: !args.no_sort,
            cull: !args.no_cull,
        },
    })
}

fn steer(args: &PasteArgs) -> anyhow::Result<Steer> {
    let axis = args.up.unwrap_or(DVec3::Y);
    let constraints = |path: &Path| -> anyhow::Result<Constraints> {
        Constraints::from_json(&read_text(path)?).with_context(|| path.display().to_string())
    };
    Ok(match args.field.as_deref() {
        None if args.scale_field.is_some() => {
            bail!("--scale-field goes with --field none; with a direction, put scales into its constraints")
        }
        None => Steer::Up(axis),
        Some("none") => Steer::Isotropic(args.scale_field.as_deref().map(constraints).transpose()?),
        Some(_) if args.scale_field.is_some() => bail!("--scale-field goes with --field none"),
        Some(file) => {
            let path = Path::new(file);
            let text = read_text(path)?;
            // A file of constraints has a key of that name; anything else is read as a field.
            let keys: Result<serde_json::Map<String, serde_json::Value>, _> = serde_json::from_str(&text);
            let keys =
                keys.with_context(|| format!("{file}: this is no JSON object; see docs/fields.md for the two kinds of file"))?;
            if keys.contains_key("constraints") {
                Steer::Constraints(Constraints::from_json(&text).with_context(|| file.to_owned())?, axis)
            } else {
                Steer::Field(text)
            }
        }
    })
}

fn read_text(path: &Path) -> anyhow::Result<String> {
    let bytes = read_file(path, "the JSON file")?;
    String::from_utf8(bytes).map_err(|_| anyhow!("{}: this is no text: name a JSON file", path.display()))
}

/// Exemplars with their patches.
fn inputs(args: &PasteArgs) -> anyhow::Result<Vec<ExemplarInput>> {
    if !args.weights.is_empty() && args.weights.len() != args.exemplars.len() {
        bail!("--weights has {} numbers for {} exemplars: give one each", args.weights.len(), args.exemplars.len());
    }
    if let (Some((channel, file)), true) = (args.channels.files().first_key_value(), args.exemplars.len() > 1) {
        bail!(
            "{}: this {} map cannot be shared by {} exemplars: give one exemplar, or name maps after their colour images",
            file.display(),
            channel.name(),
            args.exemplars.len()
        );
    }
    let patches: Vec<PatchSpec> = args.patch.iter().map(|text| patch(text)).collect::<anyhow::Result<_>>()?;
    let one = |(i, path): (usize, &PathBuf)| {
        let (exemplar, told) = read_exemplar(path, &args.channels.options(args.color_only))?;
        told.iter().for_each(|t| args.common.pass_on(t));
        let weight = args.weights.get(i).copied().unwrap_or(1.0);
        if !(weight > 0.0 && weight.is_finite()) {
            bail!("--weights has {weight}: give numbers above zero");
        }
        Ok(ExemplarInput { exemplar, weight, patches: patches.clone() })
    };
    args.exemplars.iter().enumerate().map(one).collect()
}

fn patch(text: &str) -> anyhow::Result<PatchSpec> {
    let source = match text.parse::<PatchShape>()? {
        PatchShape::Whole => PatchSource::Whole,
        PatchShape::Circle => PatchSource::Circle,
        PatchShape::Splotch => PatchSource::Splotch,
        PatchShape::Mask(path) => PatchSource::Mask { name: path.display().to_string(), image: read_mask(&path)? },
        PatchShape::Outline(path) => {
            let name = path.display().to_string();
            PatchSource::Outlines { outlines: Outline::from_json(&read_text(&path)?, &name)?, name }
        }
    };
    Ok(PatchSpec { source, weight: 1.0 })
}

/// What the record says of how it was made.
fn describe(args: &PasteArgs, pasted: &Pasted) -> serde_json::Value {
    serde_json::json!({
        "seed": args.seed,
        "scale": pasted.report.scale,
        "field": args.field.clone().unwrap_or_else(|| "up".to_owned()),
        "feather": args.feather,
        "pastes": pasted.report.paste.pastes,
        "drawsPerFace": pasted.report.paste.draws_per_face,
    })
}

fn draw(args: &PasteArgs, pasted: &Pasted, path: &Path) -> anyhow::Result<()> {
    let texture = Composite::new(&pasted.mesh, &pasted.lapped);
    let subject = Subject { mesh: &pasted.mesh, texture: &texture, lapped: Some(&pasted.lapped), guide: Some(&pasted.guide) };
    let options = picture::views(args.camera, args.preview_size.0, 2, false, picture::up_axis(args.up));
    picture::save(path, &preview(&subject, args.preview_style, &options)?)
}

/// The result in two lines on stdout.
fn summary(args: &PasteArgs, pasted: &Pasted, seconds: f64) {
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
    }
}
