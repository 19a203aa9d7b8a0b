//! `lapped render`: a picture of a record, or of a plain mesh.

use super::brush::Brush;
use super::picture::{self, Size};
use super::{Common, report};
use crate::exemplar::ChannelSet;
use crate::field::Guide;
use crate::format::{check_output, holds_record, read_file, read_model_bytes, read_record_bytes, write_file};
use crate::job::Bound;
use crate::mesh::{CleanOptions, Mesh, SurfacePoint, clean};
use crate::paste::{Composite, LappedTexture};
use crate::render::{Grid, Picture, PreviewStyle, Subject, View, animation};
use crate::surface::{SurfaceTexture, Texel};
use anyhow::Context;
use clap::Args;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Arguments of `lapped render`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  lapped render bunny.glb -o bunny.png                                 four views on one sheet
  lapped render bunny.glb -o front.png --camera front --size 1600x1200
  lapped render bunny.glb -o hero.png --camera yaw=30,pitch=12,zoom=1.3 --samples 4 --transparent
  lapped render bunny.glb -o ear.png --camera three-quarter,zoom=4,at=0.1,1.6,0
  lapped render bunny.glb -o turn.gif --turntable 36 --size 400x400    also .apng, or a folder of PNG files
  lapped render bunny.glb -o bunny.png --mode single --adapter vulkan
  lapped render bunny.glb -o pastes.png --style pastes")]
pub struct RenderArgs {
    /// A record (GLB written by `lapped paste`), or any mesh
    #[arg(value_name = "MODEL")]
    pub model: PathBuf,
    /// Where to write the picture (PNG); of a turntable an animation (.apng, .gif) or a folder
    #[arg(short, long, value_name = "OUT.png")]
    pub output: PathBuf,
    /// How to draw. `auto` takes graphics hardware if there is any and the style can be drawn by it
    #[arg(long, value_enum, default_value_t = Mode::Auto)]
    pub mode: Mode,
    /// Graphics adapter: a number or a part of a name as `lapped inspect --gpu` lists them
    #[arg(long, value_name = "NAME")]
    pub adapter: Option<String>,
    /// Size in pixels
    #[arg(long, value_name = "WxH", default_value_t = Size([1024, 1024]))]
    pub size: Size,
    /// One view instead of four: front, back, left, right, top, bottom, three-quarter, or settings like
    /// yaw=30,pitch=15,zoom=1.2,at=X,Y,Z (the point in the middle)
    #[arg(long, value_name = "VIEW")]
    pub camera: Option<View>,
    /// A full turn in so many pictures
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=3600))]
    pub turntable: Option<u32>,
    /// Which way is up on the sheet of four views and the turntable: y or z
    #[arg(long, value_name = "AXIS", value_parser = super::axis, allow_hyphen_values = true)]
    pub up: Option<glam::DVec3>,
    /// What to show: texture, pastes, field, coverage, stretch, wireframe
    #[arg(long, value_name = "STYLE", default_value_t = PreviewStyle::Texture)]
    pub style: PreviewStyle,
    /// Samples along each side of a pixel
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=8))]
    pub samples: u32,
    /// Nothing behind the model
    #[arg(long)]
    pub transparent: bool,
    /// See [`Common`].
    #[command(flatten)]
    pub common: Common,
}

/// Ways to draw.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Mode {
    /// `single` on graphics hardware, `reference` without
    Auto,
    /// On a graphics adapter: each face once, its pastes from the top down
    Single,
    /// On a graphics adapter: the pastes one over another, as the paper has it
    Layered,
    /// On the processor, no graphics driver needed
    Reference,
}

#[derive(Debug, Serialize)]
struct RunReport {
    command: &'static str,
    model: String,
    output: String,
    faces: usize,
    pastes: usize,
    /// How it was drawn, and by which adapter.
    mode: &'static str,
    adapter: Option<String>,
    pictures: usize,
    read_seconds: f64,
    draw_seconds: f64,
    peak_memory_bytes: Option<u64>,
}

/// What a file holds to be drawn.
enum Shown {
    Record(Box<Bound>),
    Mesh(Mesh),
}

impl Shown {
    fn read(path: &Path) -> anyhow::Result<Self> {
        let name = || path.display().to_string();
        let file = read_file(path, "the record or mesh")?;
        if holds_record(&file) {
            return Ok(Self::Record(Box::new(Bound::new(read_record_bytes(path, &file)?).with_context(name)?)));
        }
        let model = read_model_bytes(path, &file)?;
        Ok(Self::Mesh(clean(&model.positions, &model.faces, &CleanOptions::default()).with_context(name)?.mesh))
    }
}

/// A mesh without any texture.
struct Bare<'a>(&'a Mesh);

impl SurfaceTexture for Bare<'_> {
    fn channels(&self) -> ChannelSet {
        ChannelSet::default()
    }

    fn texel(&self, at: SurfacePoint, _footprint: f32) -> Texel {
        Texel::empty(self.0.normal(at.face).as_vec3())
    }
}

/// Runs the command.
///
/// # Errors
/// If the model cannot be read, lacks what the style shows, the adapter asked for cannot draw it, or the picture cannot be
/// written.
pub fn run(args: &RenderArgs) -> anyhow::Result<()> {
    let begin = Instant::now();
    let folder = args.turntable.is_some() && Animation::of(&args.output)? == Animation::Folder;
    let output = (!folder).then_some(&args.output);
    [output, args.common.report.as_ref()].into_iter().flatten().try_for_each(|p| check_output(p))?;
    let name = || args.model.display().to_string();
    let brush = Brush::new(args)?;
    let shown = Shown::read(&args.model)?;
    let read_seconds = begin.elapsed().as_secs_f64();
    let up = picture::up_axis(args.up);
    let options = picture::views(args.camera, args.size.0, args.samples, args.transparent, up);
    let start = Instant::now();
    let nothing = LappedTexture::default();
    let (mesh, lapped, field) = match shown {
        Shown::Record(bound) => (bound.mesh, Some(bound.lapped), bound.field),
        Shown::Mesh(mesh) => (mesh, None, None),
    };
    let mixed = lapped.as_ref().is_some_and(|l| l.layers.iter().any(|layer| !layer.weights.is_empty()));
    let brush = if mixed && args.mode == Mode::Auto { Brush::Reference } else { brush };
    let guide = field.map(Guide::Directed);
    let texture: Box<dyn SurfaceTexture + '_> = match &lapped {
        Some(lapped) => Box::new(Composite::new(&mesh, lapped)),
        None => Box::new(Bare(&mesh)),
    };
    let subject = Subject { mesh: &mesh, texture: texture.as_ref(), lapped: lapped.as_ref(), guide: guide.as_ref() };
    let pasted = lapped.as_ref().unwrap_or(&nothing);
    let pictures = match args.turntable {
        None => vec![brush.sheet(&subject, pasted, args.style, &options, &args.common).with_context(name)?],
        Some(count) => {
            let view = args.camera.unwrap_or(View { up, ..View::degrees(30.0, 18.0) });
            let grid = Grid { width: args.size.0[0], height: args.size.0[1], samples: args.samples };
            let cameras = view.turntable(&mesh, grid.aspect(), count);
            brush.views(&subject, pasted, &options, &cameras, grid, &args.common).with_context(name)?
        }
    };
    let draw_seconds = start.elapsed().as_secs_f64();
    match args.turntable {
        None => picture::save(&args.output, &pictures[0])?,
        Some(_) => save_turn(&args.output, &pictures)?,
    }
    if let Some(path) = &args.common.report {
        let report = RunReport {
            command: "render",
            model: name(),
            output: args.output.display().to_string(),
            faces: mesh.face_count(),
            pastes: pasted.pastes.len(),
            mode: brush.mode(),
            adapter: brush.adapter(),
            pictures: pictures.len(),
            read_seconds,
            draw_seconds,
            peak_memory_bytes: report::peak_memory(),
        };
        report::write(path, &report)?;
    }
    Ok(())
}

/// What a turntable is written as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Animation {
    Apng,
    Gif,
    Folder,
}

impl Animation {
    fn of(path: &Path) -> anyhow::Result<Self> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        match extension.as_deref() {
            Some("apng" | "png") => Ok(Self::Apng),
            Some("gif") => Ok(Self::Gif),
            None => Ok(Self::Folder),
            Some(other) => {
                let path = path.display();
                anyhow::bail!("{path}: a turntable is no .{other}: name a .apng, a .gif, or a folder for PNG files")
            }
        }
    }
}

/// Pictures a second of an animated turntable.
const PER_SECOND: u16 = 24;

fn save_turn(path: &Path, pictures: &[Picture]) -> anyhow::Result<()> {
    let bytes = match Animation::of(path)? {
        Animation::Apng => animation::apng(pictures, PER_SECOND)?,
        Animation::Gif => animation::gif(pictures, PER_SECOND)?,
        Animation::Folder => {
            std::fs::create_dir_all(path).with_context(|| format!("{}: the folder cannot be made", path.display()))?;
            let save = |(k, drawn): (usize, &Picture)| picture::save(&path.join(format!("{k:04}.png")), drawn);
            return pictures.iter().enumerate().try_for_each(save);
        }
    };
    Ok(write_file(path, |out| out.write_all(&bytes))?)
}
