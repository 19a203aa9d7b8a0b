//! The flags that describe one region: which exemplars, where, how large, which way. They are those of `lapped paste`, and
//! the keys of a job file.

use super::Common;
use super::channels::ChannelArgs;
use crate::exemplar::auto::Choice;
use crate::exemplar::symmetry::Symmetry;
use crate::exemplar::{Exemplar, Outline, PatchOptions, PatchShape, PatchSource, PatchSpec};
use crate::field::Constraints;
use crate::field::nway::MOST_WAYS;
use crate::format::{read_exemplar, read_file, read_mask};
use crate::job::patches::default_feather;
use crate::job::{Area, Base, ExemplarInput, PasteJob, Region, Scale, Steer, Where};
use crate::paste::{IsotropicFit, PasteOptions, Predictor, Weights};
use anyhow::{Context, anyhow, bail};
use clap::Args;
use glam::DVec3;
use std::path::{Path, PathBuf};

/// Arguments of one region.
#[derive(Debug, Clone, Args)]
pub struct RegionArgs {
    /// World length of one exemplar width
    #[arg(long, value_name = "LENGTH", conflicts_with = "ratio", help_heading = "Size and direction")]
    pub scale: Option<f64>,
    /// Surface area over exemplar area, if no --scale is given
    #[arg(long, value_name = "N", default_value_t = crate::field::DEFAULT_RATIO, help_heading = "Size and direction")]
    pub ratio: f64,
    /// Texture up: an axis (x, y, z, -x, ...) or X,Y,Z, projected onto the surface [default: y]
    #[arg(long, value_name = "AXIS", value_parser = super::axis, allow_hyphen_values = true, help_heading = "Size and direction")]
    pub up: Option<DVec3>,
    /// `none` for textures that look the same every way; `curvature` to follow the surface; `relax:N` for the smoothest field of N
    /// ways; `auto` to let the first exemplar decide; or a JSON file: constraints, or a field with a vector per face
    #[arg(long, value_name = "none|curvature|relax:N|auto|FILE.json", help_heading = "Size and direction")]
    pub field: Option<String>,
    /// With --field none: constraints of which the scales count
    #[arg(long, value_name = "FILE.json", help_heading = "Size and direction")]
    pub scale_field: Option<PathBuf>,
    /// Leave large faces as they are: by default those larger than a quarter of an exemplar, and those around singularities of the
    /// field, are cut
    #[arg(long, help_heading = "Size and direction")]
    pub keep_faces: bool,

    /// Shape of the texture patches: whole, circle, splotch, a mask image, a JSON file with outlines, or auto: outlines along the
    /// exemplar's own grout, gaps and borders if it has any that close, and --field auto unless a direction is given; may be repeated
    /// [default: the exemplar's own transparency if it has any, else splotch]
    #[arg(long, value_name = "SHAPE", help_heading = "Texture patches")]
    pub patch: Vec<String>,
    /// Pixels over which alpha falls off at a patch's edge [default: 3, or 1.5 % of a larger exemplar]
    #[arg(long, value_name = "PX", help_heading = "Texture patches")]
    pub feather: Option<f32>,
    /// The paper's own pastes: each shows the same part of its exemplar and ends where its mask does, whatever lies around it
    #[arg(long, help_heading = "Texture patches")]
    pub plain: bool,
    /// Let each paste show the same part of its exemplar
    #[arg(long, help_heading = "Texture patches")]
    pub no_windows: bool,
    /// Let each paste end where its mask does
    #[arg(long, help_heading = "Texture patches")]
    pub no_cuts: bool,
    /// Give back the contrast that two textures lose where one fades into the other: for wide --feather, or soft exemplars
    #[arg(long, help_heading = "Texture patches", conflicts_with = "plain")]
    pub keep_contrast: bool,
    /// Paste the detail of exemplars alone, over a smooth base: their own slow changes of colour (own), the mesh's vertex colours
    /// (vertex), or one colour (#RRGGBB)
    #[arg(long, value_name = "own|vertex|#RRGGBB", help_heading = "Texture patches")]
    pub base: Option<Base>,
    /// Lay no pastes over hard edges that show. Only those of exemplars that look the same every way lie across the field
    #[arg(long, help_heading = "Texture patches")]
    pub no_overlays: bool,
    /// Lay smaller pastes over hard edges that still show: fewer shards on thin limbs and in folds, for more pastes and masks
    #[arg(long, help_heading = "Texture patches", conflicts_with_all = ["plain", "no_overlays"])]
    pub small: bool,
    /// Keep pastes that the others make needless
    #[arg(long, help_heading = "Texture patches")]
    pub no_prune: bool,
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

    /// Paste there only: object=, group= or material=NAME (* for any letters), color=#RRGGBB, paint=red, mask=FILE.png
    #[arg(long = "where", value_name = "AREA", help_heading = "Region")]
    pub area: Option<Where>,
    /// Width of the soft border around objects, groups and materials, world units
    #[arg(long, value_name = "LENGTH", default_value_t = 0.0, help_heading = "Region")]
    pub border: f64,
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

impl RegionArgs {
    /// Reads everything that the region names; with it what its exemplars were found to ask for.
    ///
    /// # Errors
    /// If a value is out of range, or a file cannot be read.
    pub fn region(&self, name: &str, exemplars: &[PathBuf], common: &Common) -> anyhow::Result<(Region, Vec<Choice>)> {
        let area = match &self.area {
            None => Area::Everything,
            Some(Where::Area(area)) => area.clone(),
            Some(Where::Mask(path)) => Area::Mask(read_mask(path)?),
        };
        if self.border != 0.0 && area == Area::Everything {
            bail!("--border is {}: it goes with --where", self.border);
        }
        let (inputs, choices) = inputs(self, exemplars, common)?;
        let job = PasteJob { steer: steer(self, &inputs, &choices, common)?, ..job(self)? };
        Ok((Region { name: name.to_owned(), area, border: self.border, inputs, job }, choices))
    }

    /// True if exemplars choose their own patches.
    fn asks_exemplars(&self) -> bool {
        self.patch.iter().any(|p| matches!(p.parse(), Ok(PatchShape::Auto)))
    }

    /// The file with the field, if one is named.
    #[must_use]
    pub fn field_file(&self) -> Option<&Path> {
        self.field.as_deref().filter(|f| is_field_file(f)).map(Path::new).or(self.scale_field.as_deref())
    }

    /// Takes relative paths as lying in a folder.
    pub fn resolve(&mut self, folder: &Path) {
        let join = |path: &mut PathBuf| *path = folder.join(&*path);
        let text = |path: &mut String| *path = folder.join(&*path).display().to_string();
        let channels = &mut self.channels;
        let maps = [
            &mut channels.normal,
            &mut channels.height,
            &mut channels.roughness,
            &mut channels.metallic,
            &mut channels.occlusion,
            &mut channels.emissive,
            &mut channels.opacity,
            &mut self.scale_field,
        ];
        maps.into_iter().flatten().for_each(join);
        self.field.iter_mut().filter(|f| is_field_file(f)).for_each(text);
        let is_file = |p: &&mut String| matches!(p.parse(), Ok(PatchShape::Mask(_) | PatchShape::Outline(_)));
        self.patch.iter_mut().filter(is_file).for_each(text);
        if let Some(Where::Mask(path)) = &mut self.area {
            *path = folder.join(&*path);
        }
    }
}

/// The validated job of the arguments.
fn job(args: &RegionArgs) -> anyhow::Result<PasteJob> {
    let scale = match args.scale {
        Some(length) if !(length > 0.0 && length.is_finite()) => {
            bail!("--scale is {length:?}: give the world length of one exemplar width, a number above zero")
        }
        Some(length) => Scale::World(length),
        None if !(args.ratio > 0.0 && args.ratio.is_finite()) => {
            bail!("--ratio is {:?}: give a number above zero (40 is the default)", args.ratio)
        }
        None => Scale::Ratio(args.ratio),
    };
    let paste = PasteOptions {
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
        overlays: !args.no_overlays,
        small: args.small,
        prune: !args.no_prune,
        cull: !args.no_cull,
        windows: !args.no_windows,
        cuts: !args.no_cuts,
        contrast: args.keep_contrast,
        ..PasteOptions::default()
    };
    Ok(PasteJob {
        scale,
        keep_faces: args.keep_faces,
        feather: args.feather,
        base: args.base,
        patches: PatchOptions { seed: args.seed, splotches: args.splotches, ..PatchOptions::default() },
        paste: if args.plain { paste.plain() } else { paste },
        ..PasteJob::default()
    })
}

/// True if `--field` names a file rather than a kind of field.
fn is_field_file(text: &str) -> bool {
    !matches!(text, "none" | "curvature" | "auto") && !text.starts_with(RELAX)
}

/// Begins the name of a relaxed field; its number of ways follows.
const RELAX: &str = "relax:";

fn steer(args: &RegionArgs, inputs: &[ExemplarInput], choices: &[Choice], common: &Common) -> anyhow::Result<Steer> {
    let axis = args.up.unwrap_or(DVec3::Y);
    let constraints = |path: &Path| -> anyhow::Result<Constraints> {
        Constraints::from_json(&read_text(path)?).with_context(|| path.display().to_string())
    };
    Ok(match args.field.as_deref() {
        None if args.scale_field.is_some() => {
            bail!("--scale-field goes with --field none; with a direction, put scales into its constraints")
        }
        None if args.up.is_none() && args.asks_exemplars() => steer_by(inputs, choices, common),
        None => Steer::Up(axis),
        Some("none") => Steer::Isotropic(args.scale_field.as_deref().map(constraints).transpose()?),
        Some(_) if args.scale_field.is_some() => bail!("--scale-field goes with --field none"),
        Some("auto") => steer_by(inputs, choices, common),
        Some(named) => steer_of(named, axis)?,
    })
}

fn steer_by(inputs: &[ExemplarInput], choices: &[Choice], common: &Common) -> Steer {
    match (choices.first(), inputs.first()) {
        (Some(choice), _) => told_steer(Steer::by_symmetry(choice.symmetry.as_ref()), choice.symmetry.as_ref(), common),
        (None, Some(input)) => found_steer(&input.exemplar, common),
        (None, None) => Steer::Relaxed(1),
    }
}

/// What a `--field` other than `none` and `auto` asks for.
///
/// # Errors
/// If it names a file that cannot be read, or too many ways.
pub(super) fn steer_of(named: &str, axis: DVec3) -> anyhow::Result<Steer> {
    Ok(match named {
        "curvature" => Steer::Curvature,
        text if text.starts_with(RELAX) => match text[RELAX.len()..].parse() {
            Ok(n @ 1..=MOST_WAYS) => Steer::Relaxed(n),
            _ => bail!("--field {text}: give {RELAX} and a number of ways from 1 to {MOST_WAYS}, like relax:4"),
        },
        file => {
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

/// What an exemplar's own symmetry asks for; says what it found.
pub(super) fn found_steer(exemplar: &Exemplar, common: &Common) -> Steer {
    let (steer, found) = Steer::by_exemplar(exemplar);
    told_steer(steer, found.as_ref(), common)
}

fn told_steer(steer: Steer, found: Option<&Symmetry>, common: &Common) -> Steer {
    if let Some(found) = found {
        let flag = if found.isotropic { "none".to_owned() } else { format!("relax:{}", found.n) };
        common.say(&format!("field: turned, {found}: --field {flag}"));
    }
    steer
}

fn read_text(path: &Path) -> anyhow::Result<String> {
    let bytes = read_file(path, "the JSON file")?;
    String::from_utf8(bytes).map_err(|_| anyhow!("{}: this is no text: name a JSON file", path.display()))
}

/// Exemplars with their patches, and what was found of those that choose their own.
fn inputs(args: &RegionArgs, exemplars: &[PathBuf], common: &Common) -> anyhow::Result<(Vec<ExemplarInput>, Vec<Choice>)> {
    if !args.weights.is_empty() && args.weights.len() != exemplars.len() {
        bail!("--weights has {} numbers for {} exemplars: give one each", args.weights.len(), exemplars.len());
    }
    if let (Some((channel, file)), true) = (args.channels.files().first_key_value(), exemplars.len() > 1) {
        bail!(
            "{}: this {} map cannot be shared by {} exemplars: give one exemplar, or name maps after their colour images",
            file.display(),
            channel.name(),
            exemplars.len()
        );
    }
    let patches: Vec<Option<PatchSpec>> = args.patch.iter().map(|text| patch(text)).collect::<anyhow::Result<_>>()?;
    let mut choices = Vec::new();
    let mut inputs = Vec::new();
    for (i, path) in exemplars.iter().enumerate() {
        let (mut exemplar, told) = read_exemplar(path, &args.channels.options(args.color_only)?)?;
        told.iter().for_each(|t| common.pass_on(t));
        let weight = args.weights.get(i).copied().unwrap_or(1.0);
        if !(weight > 0.0 && weight.is_finite()) {
            bail!("--weights has {weight}: give numbers above zero");
        }
        if args.asks_exemplars() {
            let choice = Choice::of(&exemplar, args.feather.unwrap_or_else(|| default_feather(exemplar.size())));
            choice.reasons.iter().for_each(|reason| common.say(&format!("patches of {}: {reason}", path.display())));
            choice.prepare(&mut exemplar);
            choices.push(choice);
        }
        let specs = |given: &Option<PatchSpec>| match (given, choices.last()) {
            (Some(given), _) => vec![given.clone()],
            // Beside other shapes the usual ones must be named.
            (None, Some(choice)) if patches.len() > 1 && choice.outlines.is_empty() => {
                vec![PatchSpec { source: if choice.opacity { PatchSource::Whole } else { PatchSource::Splotch }, weight: 1.0 }]
            }
            (None, choice) => choice.map(Choice::specs).unwrap_or_default(),
        };
        inputs.push(ExemplarInput { weight, patches: patches.iter().flat_map(specs).collect(), exemplar });
    }
    Ok((inputs, choices))
}

/// The patches a text means; `None` if the exemplar chooses them.
fn patch(text: &str) -> anyhow::Result<Option<PatchSpec>> {
    let source = match text.parse::<PatchShape>()? {
        PatchShape::Auto => return Ok(None),
        PatchShape::Whole => PatchSource::Whole,
        PatchShape::Circle => PatchSource::Circle,
        PatchShape::Splotch => PatchSource::Splotch,
        PatchShape::Mask(path) => PatchSource::Mask { name: path.display().to_string(), image: read_mask(&path)? },
        PatchShape::Outline(path) => {
            let name = path.display().to_string();
            PatchSource::Outlines { outlines: Outline::from_json(&read_text(&path)?, &name)?, name }
        }
    };
    Ok(Some(PatchSpec { source, weight: 1.0 }))
}
