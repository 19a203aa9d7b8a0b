//! `lapped render`: a picture of a record, or of a plain mesh.

use super::brush::{Brush, Each};
use super::picture::{self, Size};
use super::{Common, report};
use crate::atlas::AtlasTexture;
use crate::exemplar::ChannelSet;
use crate::exemplar::frames::duration;
use crate::field::{Guide, TangentField};
use crate::format::{
    Look, Model, check_output, holds_record, read_file, read_look_bytes, read_model_bytes, read_record_bytes, write_file,
};
use crate::job::bake::LookOnMesh;
use crate::job::{Bound, Moving, Painted};
use crate::mesh::clean::UserFace;
use crate::mesh::{CleanOptions, Cleaned, Mesh, SurfacePoint, clean};
use crate::paste::{Composite, LappedTexture};
use crate::render::animation::Film;
use crate::render::normals::crease_angle;
use crate::render::{Grid, PreviewStyle, SheetOptions, Subject, View};
use crate::surface::{SurfaceTexture, Texel};
use anyhow::{Context, bail};
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
  lapped render fox.glb -o run.apng --play --animation Run             a model's own animation
  lapped render fox.glb -o fox.png --time 0.4 --camera left
  lapped render lava.glb -o lava.gif --play                            exemplars that change with time
  lapped render bunny.glb -o bunny.png --mode single --adapter vulkan
  lapped render bunny.glb -o baked.png --mode atlas                    the bake, as other tools show it
  lapped render bunny.glb -o pastes.png --style pastes")]
pub struct RenderArgs {
    /// A record (GLB written by `lapped paste` or `lapped synth`), or any mesh; colours at its vertices are shown
    #[arg(value_name = "MODEL")]
    pub model: PathBuf,
    /// Where to write the picture (PNG); of --turntable and --play an animation (.apng, .gif) or a folder
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
    /// Draw the model so many seconds into its animation, and into that of exemplars that change with time
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_hyphen_values = true)]
    pub time: Option<f64>,
    /// Play the model's animation, and that of its exemplars, 24 pictures a second
    #[arg(long, conflicts_with_all = ["time", "turntable"])]
    pub play: bool,
    /// Which animation --time and --play mean: its name, or its number from 0 [default: 0]
    #[arg(long, value_name = "NAME")]
    pub animation: Option<String>,
    /// Which way is up on the sheet of four views and the turntable: y or z
    #[arg(long, value_name = "AXIS", value_parser = super::axis, allow_hyphen_values = true)]
    pub up: Option<glam::DVec3>,
    /// What to show: texture, pastes, field, coverage, stretch, wireframe
    #[arg(long, value_name = "STYLE", default_value_t = PreviewStyle::Texture)]
    pub style: PreviewStyle,
    /// Show the relief of exemplars with a height by parallax, so many exemplar widths deep; 0.01 to 0.03 is usual
    #[arg(long, value_name = "DEPTH", default_value_t = 0.0, value_parser = depth)]
    pub parallax: f32,
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
    /// The baked atlas, as any other tool shows it; on the processor
    Atlas,
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
struct Shown {
    mesh: Mesh,
    lapped: Option<LappedTexture>,
    field: Option<TangentField>,
    moving: Option<Moving>,
    look: Option<(LookOnMesh, Box<Look>)>,
    /// The model itself and where its faces went, if it has colours at its vertices and no pastes.
    painted: Option<(Box<Model>, Vec<UserFace>)>,
}

impl Shown {
    /// What a file holds; a look only for a model that stands still.
    fn read(path: &Path, mode: Mode, moves: bool) -> anyhow::Result<Self> {
        let name = || path.display().to_string();
        let file = read_file(path, "the record or mesh")?;
        let record = holds_record(&file);
        if mode == Mode::Atlas && moves {
            bail!("the mode atlas draws models at rest: leave out --time and --play, or choose another --mode");
        }
        if mode == Mode::Atlas || (mode == Mode::Auto && !record && !moves) {
            if let Some((model, look)) = read_look_bytes(path, &file)? {
                let Cleaned { mesh, user_faces, .. } =
                    clean(&model.positions, &model.faces, &CleanOptions::default()).with_context(name)?;
                let on_mesh = LookOnMesh::new(&model, &look, &mesh, &user_faces);
                let look = Some((on_mesh, Box::new(look)));
                return Ok(Self { mesh, lapped: None, field: None, moving: None, look, painted: None });
            }
            if mode == Mode::Atlas {
                bail!("{}: it has no baked atlas: make one with `lapped bake`, or choose another --mode", path.display());
            }
        }
        let model = if record {
            let record = read_record_bytes(path, &file)?;
            if !(record.lapped.pastes.is_empty() && record.model.colors.is_some()) {
                let Bound { mesh, lapped, field, moving, .. } = Bound::new(record).with_context(name)?;
                return Ok(Self { mesh, lapped: Some(lapped), field, moving, look: None, painted: None });
            }
            record.model
        } else {
            read_model_bytes(path, &file)?
        };
        let cleaned = clean(&model.positions, &model.faces, &CleanOptions::default()).with_context(name)?;
        let moving = Moving::new(&model, &cleaned).with_context(name)?;
        let painted = model.colors.is_some().then(|| (Box::new(model), cleaned.user_faces));
        Ok(Self { mesh: cleaned.mesh, lapped: None, field: None, moving, look: None, painted })
    }
}

/// The animation of the model that is asked for, if one is. A model that stands still may have a texture that `changes`.
fn animation_of<'a>(moving: Option<&'a Moving>, changes: bool, args: &RenderArgs) -> anyhow::Result<Option<(&'a Moving, usize)>> {
    if args.time.is_none() && !args.play {
        anyhow::ensure!(args.animation.is_none(), "--animation says which one is drawn: add --time SECONDS or --play");
        return Ok(None);
    }
    let moving = moving.filter(|m| !m.motion.animations.is_empty());
    if moving.is_none() && changes && args.animation.is_none() {
        return Ok(None);
    }
    let moving = moving.context(
        "neither the model nor its texture has an animation: export it with one, paste an animated exemplar, or leave out --time and \
         --play",
    )?;
    let number = args.animation.as_ref().map_or(Ok(0), |name| moving.motion.find(name))?;
    Ok(Some((moving, number)))
}

/// What lies on a mesh.
pub(super) fn texture_of<'a>(
    mesh: &'a Mesh,
    lapped: Option<&'a LappedTexture>,
    parallax: f32,
    seconds: f64,
) -> Box<dyn SurfaceTexture + 'a> {
    match lapped {
        Some(lapped) => Box::new(Composite::new(mesh, lapped).with_parallax(parallax).with_time(seconds)),
        None => Box::new(Bare(mesh)),
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
    let many = args.turntable.is_some() || args.play;
    let folder = many && Animation::of(&args.output)? == Animation::Folder;
    let output = (!folder).then_some(&args.output);
    [output, args.common.report.as_ref()].into_iter().flatten().try_for_each(|p| check_output(p))?;
    let name = || args.model.display().to_string();
    let brush = Brush::new(args)?;
    let moves = args.time.is_some() || args.play;
    let Shown { mut mesh, mut lapped, field, moving, look, painted } = Shown::read(&args.model, args.mode, moves)?;
    let plain = painted.is_some() && args.mode == Mode::Auto;
    let brush = if look.is_some() || plain { Brush::Reference(0.0) } else { brush };
    let read_seconds = begin.elapsed().as_secs_f64();
    let up = picture::up_axis(args.up);
    let mut options = picture::views(args.camera, args.size.0, args.samples, args.transparent, up);
    let start = Instant::now();
    let changing = lapped.as_ref().map_or(0.0, |l| duration(&l.exemplars));
    let played = animation_of(moving.as_ref(), changing > 0.0, args).with_context(name)?;
    if let (Some(time), Some(lapped)) = (args.time, &mut lapped) {
        lapped.exemplars.iter_mut().for_each(|e| *e = e.at(time));
    }
    if played.is_some() {
        // The same creases in all pictures.
        options.draw.crease = Some(crease_angle(&mesh));
    }
    let view = args.camera.unwrap_or(View { up, ..View::degrees(30.0, 18.0) });
    let grid = Grid { width: args.size.0[0], height: args.size.0[1], samples: args.samples };
    let lapped = lapped.as_ref();
    let pictures = match played {
        _ if args.play => {
            let duration = played.map_or(0.0, |(moving, animation)| moving.motion.animations[animation].duration());
            let film = Played { mesh: &mesh, moving: played, lapped, duration: duration.max(changing) };
            play(&brush, &film, &view, grid, &mut options, args).with_context(name)?
        }
        _ => {
            if let (Some((moving, animation)), Some(time)) = (played, args.time) {
                mesh = moving.at(Some(animation), time).with_context(name)?;
            }
            let guide = field.map(Guide::Directed);
            let painted = painted.as_ref().and_then(|(model, faces)| Painted::new(model, &mesh, faces, None));
            let tints = painted.as_ref().and_then(Painted::corners);
            let tints = tints.as_deref();
            let texture: Box<dyn SurfaceTexture + '_> = match look {
                Some((at, look)) => Box::new(AtlasTexture::new(&mesh, at.uv, at.page, look.pages, at.frames)),
                None => painted.map_or_else(
                    || texture_of(&mesh, lapped, args.parallax, 0.0),
                    |painted| Box::new(painted) as Box<dyn SurfaceTexture>,
                ),
            };
            let subject = Subject { mesh: &mesh, texture: texture.as_ref(), lapped, guide: guide.as_ref() };
            match args.turntable {
                None => {
                    let drawn = brush.sheet(&subject, tints, args.style, &options, &args.common).with_context(name)?;
                    picture::save(&args.output, &drawn)?;
                    1
                }
                Some(count) => {
                    let cameras = view.turntable(&mesh, grid.aspect(), count);
                    save_film(&args.output, args.size.0, count, |each| {
                        brush.views(&subject, tints, &options, &cameras, grid, &args.common, each).with_context(name)
                    })?;
                    count
                }
            }
        }
    };
    let draw_seconds = start.elapsed().as_secs_f64();
    if let Some(path) = &args.common.report {
        let report = RunReport {
            command: "render",
            model: name(),
            output: args.output.display().to_string(),
            faces: mesh.face_count(),
            pastes: lapped.map_or(0, |l| l.pastes.len()),
            mode: brush.mode(),
            adapter: brush.adapter(),
            pictures: pictures as usize,
            read_seconds,
            draw_seconds,
            peak_memory_bytes: report::peak_memory(),
        };
        report::write(path, &report)?;
    }
    Ok(())
}

/// A depth in exemplar widths.
fn depth(text: &str) -> Result<f32, String> {
    let depth = text.parse::<f32>().ok().filter(|d| (0.0..=1.0).contains(d));
    depth.ok_or_else(|| "give a depth from 0 to 1 exemplar widths".to_owned())
}

/// Seconds into an animation.
pub(super) fn seconds(text: &str) -> Result<f64, String> {
    let time = text.parse::<f64>().ok().filter(|t| *t >= 0.0 && t.is_finite());
    time.ok_or_else(|| "give seconds from the animation's begin, 0 or more".to_owned())
}

/// The most pictures of an animation that are played.
const MOST_PICTURES: f64 = 3600.0;
/// The most vertices of all its pictures together that the camera looks at to keep them in sight.
const FRAMED: usize = 1 << 21;

/// What is played.
struct Played<'a> {
    mesh: &'a Mesh,
    /// How the model moves, if it does.
    moving: Option<(&'a Moving, usize)>,
    lapped: Option<&'a LappedTexture>,
    duration: f64,
}

impl Played<'_> {
    fn mesh(&self, seconds: f64) -> anyhow::Result<Mesh> {
        Ok(match self.moving {
            Some((moving, animation)) => moving.at(Some(animation), seconds)?,
            None => self.mesh.clone(),
        })
    }
}

/// Draws and saves the pictures of an animation, all seen by one camera and over one ground; how many there are.
fn play(
    brush: &Brush,
    film: &Played<'_>,
    view: &View,
    grid: Grid,
    options: &mut SheetOptions,
    args: &RenderArgs,
) -> anyhow::Result<u32> {
    let duration = film.duration;
    let count = (duration * f64::from(PER_SECOND)).ceil().max(1.0);
    if count > MOST_PICTURES {
        anyhow::bail!("the animation lasts {duration:.0} s, which is {count:.0} pictures: draw single ones with --time");
    }
    let seconds = |k: u32| f64::from(k) / f64::from(PER_SECOND);
    let mut seen = Vec::new();
    let poses = if film.moving.is_some() { count as u32 } else { 1 };
    for k in 0..poses {
        let mesh = film.mesh(seconds(k))?;
        let step = (mesh.vertex_count() * poses as usize).div_ceil(FRAMED).max(1);
        seen.extend(mesh.positions.iter().step_by(step).map(|p| p.as_dvec3()));
    }
    let camera = view.frame_points(seen.iter().copied(), grid.aspect());
    options.draw.floor = seen.iter().map(|p| p.dot(camera.world_up)).reduce(f64::min);
    let moments = (0..count as u32).map(|k| Ok((film.mesh(seconds(k))?, seconds(k))));
    save_film(&args.output, args.size.0, count as u32, |each| {
        brush.play(moments, film.lapped, options, &camera, grid, &args.common, each)
    })?;
    Ok(count as u32)
}

/// What pictures that follow one another are written as.
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
                anyhow::bail!(
                    "{path}: pictures that follow one another are no .{other}: name a .apng, a .gif, or a folder for PNG files"
                )
            }
        }
    }
}

/// Pictures a second of an animation.
const PER_SECOND: u16 = 24;

/// Saves `count` pictures as they are drawn.
fn save_film(path: &Path, size: [u32; 2], count: u32, draw: impl FnOnce(Each<'_>) -> anyhow::Result<()>) -> anyhow::Result<()> {
    let mut bytes = Vec::new();
    let mut film = match Animation::of(path)? {
        Animation::Apng => Film::apng(&mut bytes, size, count, PER_SECOND)?,
        Animation::Gif => Film::gif(&mut bytes, size, PER_SECOND)?,
        Animation::Folder => {
            let mut number = 0;
            return draw(&mut |drawn| {
                std::fs::create_dir_all(path).with_context(|| format!("{}: the folder cannot be made", path.display()))?;
                picture::save(&path.join(format!("{number:04}.png")), &drawn)?;
                number += 1;
                Ok(())
            });
        }
    };
    draw(&mut |drawn| Ok(film.push(&drawn)?))?;
    film.finish()?;
    Ok(write_file(path, |out| out.write_all(&bytes))?)
}
