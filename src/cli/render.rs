//! `lapped render`: a picture of a record, or of a plain mesh.

use super::picture::{self, Size};
use super::{Common, report};
use crate::exemplar::ChannelSet;
use crate::field::Guide;
use crate::format::{check_output, holds_record, read_file, read_model_bytes, read_record_bytes};
use crate::job::Bound;
use crate::mesh::{CleanOptions, Mesh, SurfacePoint, clean};
use crate::paste::Composite;
use crate::render::{PreviewStyle, Subject, View, preview};
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
  lapped render bunny.glb -o pastes.png --style pastes")]
pub struct RenderArgs {
    /// A record (GLB written by `lapped paste`), or any mesh
    #[arg(value_name = "MODEL")]
    pub model: PathBuf,
    /// Where to write the picture (PNG)
    #[arg(short, long, value_name = "OUT.png")]
    pub output: PathBuf,
    /// How to draw: `reference` evaluates every pixel on the processor, no graphics driver needed
    #[arg(long, value_enum, default_value_t = Mode::Reference)]
    pub mode: Mode,
    /// Size in pixels
    #[arg(long, value_name = "WxH", default_value_t = Size([1024, 1024]))]
    pub size: Size,
    /// One view instead of four: front, back, left, right, top, bottom, or yaw=30,pitch=15,zoom=1.2
    #[arg(long, value_name = "VIEW")]
    pub camera: Option<View>,
    /// Which way is up on the sheet of four views: y or z
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
    /// On the processor
    Reference,
}

#[derive(Debug, Serialize)]
struct RunReport {
    command: &'static str,
    model: String,
    output: String,
    faces: usize,
    pastes: usize,
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
/// If the model cannot be read, lacks what the style shows, or the picture cannot be written.
pub fn run(args: &RenderArgs) -> anyhow::Result<()> {
    let begin = Instant::now();
    [Some(&args.output), args.common.report.as_ref()].into_iter().flatten().try_for_each(|p| check_output(p))?;
    let name = || args.model.display().to_string();
    let shown = Shown::read(&args.model)?;
    let read_seconds = begin.elapsed().as_secs_f64();
    let options = picture::views(args.camera, args.size.0, args.samples, args.transparent, picture::up_axis(args.up));
    let start = Instant::now();
    let (picture, faces, pastes) = match shown {
        Shown::Record(bound) => {
            let Bound { mesh, lapped, field, .. } = *bound;
            let texture = Composite::new(&mesh, &lapped);
            let guide = field.map(Guide::Directed);
            let subject = Subject { mesh: &mesh, texture: &texture, lapped: Some(&lapped), guide: guide.as_ref() };
            (preview(&subject, args.style, &options).with_context(name)?, mesh.face_count(), lapped.pastes.len())
        }
        Shown::Mesh(mesh) => {
            let subject = Subject { mesh: &mesh, texture: &Bare(&mesh), lapped: None, guide: None };
            (preview(&subject, args.style, &options).with_context(name)?, mesh.face_count(), 0)
        }
    };
    let draw_seconds = start.elapsed().as_secs_f64();
    picture::save(&args.output, &picture)?;
    if let Some(path) = &args.common.report {
        let report = RunReport {
            command: "render",
            model: name(),
            output: args.output.display().to_string(),
            faces,
            pastes,
            read_seconds,
            draw_seconds,
            peak_memory_bytes: report::peak_memory(),
        };
        report::write(path, &report)?;
    }
    Ok(())
}
