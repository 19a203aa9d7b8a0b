//! `lapped synth`: a mesh and an exemplar in, a re-tiled mesh whose vertices hold a texture that looks like the exemplar out.

use super::bake::in_words;
use super::bar::Bar;
use super::channels::ChannelArgs;
use super::picture::{self, Size};
use super::region::{found_steer, steer_of};
use super::synth_round::{self, RoundArgs};
use super::{Common, report};
use crate::exemplar::{Channel, Exemplar, MipChain};
use crate::format::{Model, check_output, export, read_exemplar, read_model, vertices, write_vertices};
use crate::job::synth::VERTICES;
use crate::job::{
    BakeJob, Density, Direction, Painted, Steer, SynthJob, SynthJobError, SynthReport, Synthesized, bake_model, synthesize_on,
    transfer,
};
use crate::mesh::{CleanOptions, CleanReport, Cleaned, Mesh, clean};
use crate::render::{View, sheet};
use crate::synth::{OnMesh, SearchKind, SynthOptions, VertexTexture, Window};
use anyhow::{Context, bail};
use clap::Args;
use glam::DVec3;
use serde::Serialize;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Arguments of `lapped synth`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  Pebbles all over a bunny, a vertex a pixel, and a picture of the result:
      lapped synth bunny.obj pebbles.jpg -o bunny.glb --preview bunny.png
  Stripes that follow the smoothest field of two ways:
      lapped synth torus.obj stripes.png -o torus.glb --field relax:2 --vertices 50000
  One exemplar width a tenth of a unit long, as PLY:
      lapped synth cat.obj fur.png -o cat.ply --scale 0.1 --field cat-field.json
  Height too, and the surface moved by it:
      lapped synth head.obj weave.png --height weave-height.png -o head.glb --displace 0.05
  Baked onto the mesh as it came, its own faces with charts and an image:
      lapped synth bunny.obj moss.jpg -o vertices.glb --bake bunny-moss.glb --bake-size 2048
  What another model is painted with, moved here:
      lapped synth bunny.obj cow.glb -o bunny.glb
      lapped synth bunny.obj spot.obj --exemplar-texture spot.png -o bunny.glb
  On the mesh's own vertices, with circles about them that are kept for the next texture or direction; and an image:
      lapped synth horse.ply scales.png -o horse.glb --method chen-dong --marching horse.circles
      lapped synth --plane 512x512 pebbles.jpg -o pebbles.png --method chen-dong
  Better and slower, worse and as in the paper:
      lapped synth bunny.obj bricks.png -o bunny.glb --passes 6,6,4,3
      lapped synth bunny.obj bricks.png -o bunny.glb --paper --search tsvq

The mesh that comes out is another one: the surface with evenly spread vertices, each of which stands for a pixel; with --method
chen-dong it is the mesh itself, with long edges cut. More vertices make a finer texture, not a sharper one (--vertices), unless
the exemplar has more pixels (--exemplar-size).")]
pub struct SynthArgs {
    /// The mesh: OBJ, PLY, STL, glTF or GLB; with --plane there is none, and the exemplar is all there is to name
    #[arg(value_name = "MESH")]
    pub mesh: PathBuf,
    /// The example image, or a folder or file prefix of a material set; or a mesh with colours at its vertices
    #[arg(value_name = "EXEMPLAR", required_unless_present = "plane", conflicts_with = "plane")]
    pub exemplar: Option<PathBuf>,
    /// Where to write the result: .glb (colours in COLOR_0) or .ply; with --plane .png
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
    /// The image over the texture coordinates of an exemplar that is a mesh
    #[arg(long, value_name = "IMAGE")]
    pub exemplar_texture: Option<PathBuf>,
    /// How
    #[arg(long, value_enum, default_value_t = Method::WeiLevoy)]
    pub method: Method,
    /// Synthesise an image of this size instead of a surface, by `--method chen-dong`; other channels than colour are written beside
    /// it, each under its name
    #[arg(long, value_name = "WxH", conflicts_with_all = ["vertices", "scale", "bake", "displace", "preview"])]
    pub plane: Option<Size>,

    /// Vertices: each stands for a pixel of the exemplar, so more of them make the texture smaller on the surface [default: 24576]
    #[arg(long, value_name = "N", conflicts_with = "scale", help_heading = "Size and direction")]
    pub vertices: Option<usize>,
    /// World length of one exemplar width, instead of a number of vertices
    #[arg(long, value_name = "LENGTH", help_heading = "Size and direction")]
    pub scale: Option<f64>,
    /// Longer side of the exemplar in pixels, to which it is brought first; a mesh is re-tiled into as many vertices as a square
    /// of that side has pixels [default: its own, at most 128]
    #[arg(long, value_name = "PX", value_parser = clap::value_parser!(u32).range(1..=1024), help_heading = "Size and direction")]
    pub exemplar_size: Option<u32>,
    /// `random` for a direction of its own at every vertex; `none` for the smoothest direction; `relax:N` for the smoothest field of N ways; `curvature` to follow the
    /// surface; `up` for --up; `auto` to let the exemplar decide; or a JSON file: constraints, or a field with a vector per face
    #[arg(
        long,
        value_name = "auto|random|none|relax:N|curvature|up|FILE.json",
        default_value = "auto",
        help_heading = "Size and direction"
    )]
    pub field: String,
    /// Texture up for `--field up`: an axis (x, y, z, -x, ...) or X,Y,Z
    #[arg(long, value_name = "AXIS", value_parser = super::axis, allow_hyphen_values = true, help_heading = "Size and direction")]
    pub up: Option<DVec3>,
    /// Keep edges over which the surface bends by more than this when vertices are spread
    #[arg(long, value_name = "DEGREES", help_heading = "Size and direction")]
    pub crease: Option<f64>,

    /// Read the exemplar's named image alone, without looking for normal, height and other maps beside it
    #[arg(long, help_heading = "Channels")]
    pub color_only: bool,
    /// See [`ChannelArgs`].
    #[command(flatten)]
    pub channels: ChannelArgs,
    /// Move the vertices along their normals by the height channel, this far from lowest to highest, world units
    #[arg(long, value_name = "DEPTH", help_heading = "Channels")]
    pub displace: Option<f64>,

    /// How to search: `fast` continues what neighbours show where that fits, `tsvq` and `exhaustive` are Wei's and Levoy's
    /// [default: fast]
    #[arg(long, value_enum, help_heading = "Method")]
    pub search: Option<SearchArg>,
    /// What the paper does: its neighbourhoods, one pass a level, the vertex in its own neighbourhood
    #[arg(long, help_heading = "Method")]
    pub paper: bool,
    /// Levels at most [default: 4; with chen-dong 2]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=8), help_heading = "Method")]
    pub levels: Option<u64>,
    /// Neighbourhoods from the coarsest level to the finest: sides and levels each reaches over [default: 3x3,1 5x5,2 7x7,2 7x7,2;
    /// with --paper 1x1,1 3x3,2 5x5,2 7x7,2]
    #[arg(long, value_name = "WINDOWS", value_parser = windows, help_heading = "Method")]
    pub windows: Option<Windows>,
    /// Passes over each level from the coarsest to the finest; more take longer and mend more [default: 4,4,2,1; with --paper 1;
    /// with chen-dong a number for all levels but the coarsest, 1]
    #[arg(long, value_name = "N,N,...", value_delimiter = ',', value_parser = clap::value_parser!(u16).range(0..=100), help_heading = "Method")]
    pub passes: Option<Vec<u16>>,
    /// Whether the exemplar goes on over its edges; `auto` compares opposite edges
    #[arg(long, value_enum, default_value_t = EdgesArg::Auto, help_heading = "Method")]
    pub edges: EdgesArg,
    /// See [`RoundArgs`].
    #[command(flatten)]
    pub round: RoundArgs,
    /// Seed of all random choices
    #[arg(long, value_name = "N", default_value_t = 1, help_heading = "Method")]
    pub seed: u64,
    /// Weld vertices closer than this, world units; 0 welds equal positions only
    #[arg(long, value_name = "TOL", default_value_t = 0.0, help_heading = "Method")]
    pub weld: f64,

    /// Also bake the result onto the mesh as it came: its own faces, with charts and images (.glb, .gltf, .obj)
    #[arg(long, value_name = "OUT", help_heading = "Bake")]
    pub bake: Option<PathBuf>,
    /// Texels along each side of the baked images
    #[arg(long, value_name = "N", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(16..=16384), help_heading = "Bake")]
    pub bake_size: u32,

    /// Also draw the result: four views on one sheet
    #[arg(long, value_name = "FILE.png", help_heading = "Pictures")]
    pub preview: Option<PathBuf>,
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

/// Methods.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Method {
    /// Wei and Levoy 2001: neighbourhoods on re-tiled meshes, matched level by level
    WeiLevoy,
    /// Chen and Dong 2008: circles around the mesh's own vertices, marched once for all textures and directions
    ChenDong,
}

/// Names of [`SearchKind`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum SearchArg {
    /// Continuations and a tree over principal components
    Fast,
    /// Tree-structured vector quantization
    Tsvq,
    /// Every candidate
    Exhaustive,
}

/// What lies beyond an exemplar's edges.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum EdgesArg {
    /// What its edges suggest
    Auto,
    /// The exemplar again
    Tile,
    /// Nothing: neighbourhoods stay inside
    Inside,
}

/// A list of neighbourhoods.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Windows(Vec<Window>);

fn windows(text: &str) -> Result<Windows, String> {
    let all: Result<Vec<Window>, String> = text.split_whitespace().map(str::parse).collect();
    all.and_then(|w| if w.is_empty() { Err("give at least one, like 7x7,2".to_owned()) } else { Ok(Windows(w)) })
}

#[derive(Debug, Serialize)]
struct RunReport {
    command: &'static str,
    mesh: String,
    exemplar: String,
    output: String,
    threads: usize,
    vertices: usize,
    options: SynthOptions,
    clean: CleanReport,
    synth: SynthReport,
    seconds: f64,
    peak_memory_bytes: Option<u64>,
}

/// Runs the command.
///
/// # Errors
/// If a file cannot be read or written, or the job cannot be done.
pub fn run(args: &SynthArgs) -> anyhow::Result<()> {
    match args.method {
        Method::WeiLevoy => run_levels(args),
        Method::ChenDong => synth_round::run(args),
    }
}

fn run_levels(args: &SynthArgs) -> anyhow::Result<()> {
    args.round.refuse()?;
    if args.plane.is_some() {
        bail!("--plane goes with --method chen-dong");
    }
    let begin = Instant::now();
    let kind = vertices::Kind::of(&args.output)?;
    args.bake.as_deref().map(export::Kind::of).transpose()?;
    [Some(&args.output), args.preview.as_ref(), args.bake.as_ref(), args.common.report.as_ref()]
        .into_iter()
        .flatten()
        .try_for_each(|p| check_output(p))?;
    check(args)?;
    let name = || args.mesh.display().to_string();
    let exemplar = exemplar(args)?;
    let model = read_model(&args.mesh)?;
    model.source.notes.iter().for_each(|note| args.common.warn(&format!("{}: {note}", name())));
    let cleaned =
        clean(&model.positions, &model.faces, &CleanOptions { weld: args.weld, ..CleanOptions::default() }).with_context(name)?;
    let axis = args.up.unwrap_or(DVec3::Y);
    let steer = || match &exemplar {
        Given::Image(image) => found_steer(image, &args.common),
        Given::Mesh(..) => Steer::Relaxed(1),
    };
    let direction = direction(args, axis, steer)?;
    let options = options(args);
    let job = SynthJob {
        density: density(args),
        levels: args.levels.unwrap_or(4) as usize,
        side: args.exemplar_size,
        tiles: tiles(args),
        direction,
        crease: args.crease.map(f64::to_radians),
        nearest: args.paper,
        options,
    };
    let bar = Bar::new(args.common.quiet);
    let done = match &exemplar {
        Given::Image(image) => synthesize_on(&cleaned, image, &job, &bar, &mut |_, _, _| ()),
        Given::Mesh(model, from, image) => {
            let base = image.as_ref().and_then(|e| e.channel(Channel::BaseColor)).map(MipChain::finest);
            let missing = if base.is_some() { "texture coordinates" } else { "colours at its vertices" };
            let texture = Painted::new(model, &from.mesh, &from.user_faces, base).with_context(|| {
                format!(
                    "{}: it has no {missing}: give one that has, or an image with --exemplar-texture",
                    exemplar_path(args).display()
                )
            })?;
            transfer(&cleaned, from, &texture, &job, &bar)
        }
    };
    bar.finish();
    let made = done.map_err(|e| match e {
        SynthJobError::Field(_) => anyhow::Error::new(e).context(args.field.clone()),
        SynthJobError::Scale(_) => anyhow::Error::new(e).context("--scale"),
        e => anyhow::Error::new(e).context(name()),
    })?;
    if args.displace.is_some() && made.texture.channel(Channel::Height).is_none() {
        bail!("{}: --displace needs a height channel: name one with --height", exemplar_path(args).display());
    }
    let moved = args.displace.map(|depth| made.texture.displaced(depth));
    let mesh = moved.as_ref().unwrap_or(&made.texture.mesh);
    write_vertices(&args.output, kind, &model.name, mesh, &made.texture)?;
    write_more(args, &model, &cleaned, &made.texture, mesh)?;
    summary(args, &made, begin.elapsed().as_secs_f64());
    if let Some(path) = &args.common.report {
        let report = RunReport {
            command: "synth",
            mesh: name(),
            exemplar: exemplar_path(args).display().to_string(),
            output: args.output.display().to_string(),
            threads: rayon::current_num_threads(),
            vertices: mesh.vertex_count(),
            options: job.options,
            clean: cleaned.report,
            synth: made.report,
            seconds: begin.elapsed().as_secs_f64(),
            peak_memory_bytes: report::peak_memory(),
        };
        report::write(path, &report)?;
    }
    Ok(())
}

/// The exemplar's path: with --plane it is the only one.
pub(super) fn exemplar_path(args: &SynthArgs) -> &Path {
    args.exemplar.as_deref().unwrap_or(&args.mesh)
}

/// Checks what both methods take.
pub(super) fn check(args: &SynthArgs) -> anyhow::Result<()> {
    if args.crease.is_some_and(|c| !(c > 0.0 && c < 180.0)) {
        bail!("--crease is {}: give an angle between 0 and 180 degrees", args.crease.unwrap_or_default());
    }
    if !(args.weld >= 0.0 && args.weld.is_finite()) {
        bail!("--weld is {}: give a length in world units, 0 or more", args.weld);
    }
    if args.displace.is_some_and(|d| !d.is_finite()) {
        bail!("--displace is {}: give a length in world units", args.displace.unwrap_or_default());
    }
    Ok(())
}

/// Writes the bake and the preview that are asked for; `mesh` is the texture's own or that one displaced.
pub(super) fn write_more(
    args: &SynthArgs,
    model: &Model,
    cleaned: &Cleaned,
    texture: &VertexTexture,
    mesh: &Mesh,
) -> anyhow::Result<()> {
    if let Some(path) = &args.bake {
        let kind = export::Kind::of(path)?;
        // What was made lies on another mesh; each point of the model's own looks at the nearest one there.
        let shown = OnMesh::new(&cleaned.mesh, texture);
        let bar = Bar::new(args.common.quiet);
        let baked = bake_model(model, &cleaned.mesh, &cleaned.user_faces, &shown, &BakeJob::sized(args.bake_size), &bar);
        bar.finish();
        let baked = baked.with_context(|| args.mesh.display().to_string())?;
        let generator = concat!("lapped ", env!("CARGO_PKG_VERSION"));
        export::write_look(path, kind, &export::Export { model: &baked.model, look: &baked.look, generator })?;
        if !args.common.quiet {
            let _ = writeln!(std::io::stdout(), "{}: {}", path.display(), in_words(&baked.report));
        }
    }
    if let Some(path) = &args.preview {
        let options = picture::views(args.camera, args.preview_size.0, 2, false, picture::up_axis(args.up));
        picture::save(path, &sheet(mesh, texture, &options)?)?;
    }
    Ok(())
}

/// Which way the texture lies; `steer` is asked for `auto`.
pub(super) fn direction(args: &SynthArgs, axis: DVec3, steer: impl Fn() -> Steer) -> anyhow::Result<Direction> {
    Ok(match args.field.as_str() {
        "random" => Direction::Random,
        "none" => Direction::Steered(Steer::Isotropic(None)),
        "up" => Direction::Steered(Steer::Up(axis)),
        _ if args.up.is_some() => bail!("--up goes with --field up"),
        "auto" => Direction::Steered(steer()),
        named => Direction::Steered(steer_of(named, axis)?),
    })
}

/// How many vertices.
pub(super) fn density(args: &SynthArgs) -> Density {
    match (args.vertices, args.scale) {
        (_, Some(scale)) => Density::Scale(scale),
        (vertices, None) => Density::Vertices(vertices.unwrap_or(VERTICES)),
    }
}

/// Whether the exemplar tiles, if that is said.
pub(super) const fn tiles(args: &SynthArgs) -> Option<bool> {
    match args.edges {
        EdgesArg::Auto => None,
        EdgesArg::Tile => Some(true),
        EdgesArg::Inside => Some(false),
    }
}

/// What is synthesised from.
enum Given {
    Image(Box<Exemplar>),
    Mesh(Box<Model>, Box<Cleaned>, Option<Box<Exemplar>>),
}

/// Reads the exemplar: a mesh by its file's ending, an image otherwise.
fn exemplar(args: &SynthArgs) -> anyhow::Result<Given> {
    let read = |path: &Path| -> anyhow::Result<Box<Exemplar>> {
        let (exemplar, told) = read_exemplar(path, &args.channels.options(args.color_only)?)?;
        told.iter().for_each(|w| args.common.pass_on(w));
        if exemplar.frames().is_some() {
            args.common.warn(&format!("{}: what is synthesised does not change: it follows the first frame alone", path.display()));
        }
        Ok(Box::new(exemplar))
    };
    let ending = exemplar_path(args).extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    if !matches!(ending.as_deref(), Some("obj" | "ply" | "stl" | "gltf" | "glb")) {
        if let Some(image) = &args.exemplar_texture {
            bail!("{}: --exemplar-texture goes with an exemplar that is a mesh", image.display());
        }
        return Ok(Given::Image(read(exemplar_path(args))?));
    }
    let name = || exemplar_path(args).display().to_string();
    let model = read_model(exemplar_path(args))?;
    let cleaned = clean(&model.positions, &model.faces, &CleanOptions::default()).with_context(name)?;
    let image = args.exemplar_texture.as_deref().map(read).transpose()?;
    Ok(Given::Mesh(Box::new(model), Box::new(cleaned), image))
}

fn options(args: &SynthArgs) -> SynthOptions {
    let usual = if args.paper { SynthOptions::paper() } else { SynthOptions::default() };
    SynthOptions {
        windows: args.windows.as_ref().map_or(usual.windows, |w| w.0.clone()),
        passes: args.passes.as_ref().map_or(usual.passes, |p| p.iter().map(|&n| usize::from(n)).collect()),
        search: match args.search {
            None | Some(SearchArg::Fast) => SearchKind::Fast,
            Some(SearchArg::Tsvq) => SearchKind::Tsvq,
            Some(SearchArg::Exhaustive) => SearchKind::Exhaustive,
        },
        seed: args.seed,
        ..usual
    }
}

/// The result in a line on stdout.
fn summary(args: &SynthArgs, made: &Synthesized, seconds: f64) {
    let r = &made.report;
    let text = format!(
        "{}: {} vertices from {}x{} pixels{}, {} levels, one width is {:.4} long, {} of {} samples uncovered, in {seconds:.2} s",
        args.output.display(),
        made.texture.mesh.vertex_count(),
        r.exemplar[0],
        r.exemplar[1],
        if r.tiles { " that tile" } else { "" },
        r.synth.levels.len(),
        r.scale,
        r.synth.levels.iter().map(|l| l.uncovered_samples).sum::<u64>(),
        r.synth.levels.iter().map(|l| l.vertices as u64 * u64::from(l.window.side).pow(2)).sum::<u64>(),
    );
    if !args.common.quiet {
        let _ = writeln!(std::io::stdout(), "{text}");
    }
}
