//! What draws: the processor, or a graphics adapter.

#![cfg_attr(not(feature = "gpu"), allow(unused_variables, reason = "only adapters draw from the pastes and warn"))]

use super::Common;
use super::bar::Bar;
use super::render::{Mode, RenderArgs, texture_of};
#[cfg(feature = "gpu")]
use crate::exemplar::{Exemplar, frames::duration};
use crate::mesh::Mesh;
use crate::paste::LappedTexture;
use crate::progress::Progress;
use crate::render::{Camera, Grid, Picture, PreviewStyle, SheetOptions, Stage, Subject, Visibility, preview};

/// Takes pictures that follow one another.
pub(super) type Each<'a> = &'a mut dyn FnMut(Picture) -> anyhow::Result<()>;

/// Colours of the faces' own, for adapters: at the three corners of each.
pub(super) type Tints<'a> = Option<&'a [[glam::Vec4; 3]]>;

/// A renderer, chosen.
pub(super) enum Brush {
    /// The reference renderer, which shows relief so deep.
    Reference(f32),
    #[cfg(feature = "gpu")]
    Gpu(Box<crate::render::gpu::Renderer>, crate::render::gpu::Path),
}

impl Brush {
    /// The renderer that the arguments ask for.
    pub(super) fn new(args: &RenderArgs) -> anyhow::Result<Self> {
        let texture = args.style == PreviewStyle::Texture;
        if (args.turntable.is_some() || args.play) && !texture {
            let what = if args.play { "an animation" } else { "a turntable" };
            anyhow::bail!("{what} shows the texture: leave out --style {}, or draw single views", args.style);
        }
        if args.time.is_some() && matches!(args.style, PreviewStyle::Field | PreviewStyle::Stretch) {
            anyhow::bail!("the style {} shows the mesh as it was pasted: leave out --time", args.style);
        }
        if !texture && matches!(args.mode, Mode::Single | Mode::Layered) {
            anyhow::bail!("the style {} is drawn on the processor: leave out --mode, or ask for reference", args.style);
        }
        if matches!(args.mode, Mode::Reference | Mode::Atlas) && args.adapter.is_some() {
            anyhow::bail!("the modes reference and atlas use no graphics adapter: leave out --adapter, or ask for another mode");
        }
        match args.mode {
            Mode::Reference | Mode::Atlas => Ok(Self::Reference(args.parallax)),
            Mode::Auto if !texture => Ok(Self::Reference(args.parallax)),
            mode => Self::graphics(mode, args),
        }
    }

    #[cfg(feature = "gpu")]
    fn graphics(mode: Mode, args: &RenderArgs) -> anyhow::Result<Self> {
        use crate::render::gpu::{Gpu, GpuOptions, Path, Renderer, RendererOptions, has_hardware};
        let options = RendererOptions { parallax: args.parallax, ..RendererOptions::default() };
        let open = |adapter| Renderer::new(Gpu::new(&GpuOptions { adapter, limits: None })?, options);
        let path = if mode == Mode::Layered { Path::Layered } else { Path::Single };
        if mode != Mode::Auto || args.adapter.is_some() {
            return Ok(Self::Gpu(Box::new(open(args.adapter.clone())?), path));
        }
        // A software adapter has nothing over the reference renderer.
        if !has_hardware() {
            return Ok(Self::Reference(args.parallax));
        }
        match open(None) {
            Ok(renderer) => Ok(Self::Gpu(Box::new(renderer), path)),
            Err(error) => {
                args.common.warn(&format!("{error}: it was drawn so"));
                Ok(Self::Reference(args.parallax))
            }
        }
    }

    #[cfg(not(feature = "gpu"))]
    fn graphics(mode: Mode, args: &RenderArgs) -> anyhow::Result<Self> {
        if mode == Mode::Auto {
            return Ok(Self::Reference(args.parallax));
        }
        anyhow::bail!("this program was built without graphics adapters (the cargo feature gpu): draw with --mode reference")
    }

    /// Its name on the command line.
    pub(super) fn mode(&self) -> &'static str {
        match self {
            Self::Reference(_) => "reference",
            #[cfg(feature = "gpu")]
            Self::Gpu(_, crate::render::gpu::Path::Single) => "single",
            #[cfg(feature = "gpu")]
            Self::Gpu(_, crate::render::gpu::Path::Layered) => "layered",
        }
    }

    /// Depth of relief that the reference renderer shows.
    fn parallax(&self) -> f32 {
        match self {
            Self::Reference(depth) => *depth,
            #[cfg(feature = "gpu")]
            Self::Gpu(..) => 0.0,
        }
    }

    /// The adapter it draws with.
    pub(super) fn adapter(&self) -> Option<String> {
        match self {
            Self::Reference(_) => None,
            #[cfg(feature = "gpu")]
            Self::Gpu(renderer, _) => Some(renderer.gpu().adapter()),
        }
    }

    /// A sheet of views.
    pub(super) fn sheet(
        &self,
        subject: &Subject<'_>,
        tints: Tints<'_>,
        style: PreviewStyle,
        options: &SheetOptions,
        common: &Common,
    ) -> anyhow::Result<Picture> {
        match self {
            Self::Reference(_) => Ok(preview(subject, style, options)?),
            #[cfg(feature = "gpu")]
            Self::Gpu(renderer, path) => {
                let stage = Stage::new(subject.mesh, &options.draw);
                let loaded = load(renderer, &stage, subject.lapped, tints, common)?;
                let draw = |camera: &Camera, grid| renderer.draw(&loaded, &stage, camera, grid, *path);
                Ok(crate::render::lay_out(subject.mesh, options, draw)?)
            }
        }
    }

    /// One picture from each camera, handed over as soon as it is drawn.
    #[allow(clippy::too_many_arguments, reason = "what is drawn, by what light, and where it goes")]
    pub(super) fn views(
        &self,
        subject: &Subject<'_>,
        tints: Tints<'_>,
        options: &SheetOptions,
        cameras: &[Camera],
        grid: Grid,
        common: &Common,
        each: Each<'_>,
    ) -> anyhow::Result<()> {
        let stage = Stage::new(subject.mesh, &options.draw);
        #[cfg(feature = "gpu")]
        let loaded = match self {
            Self::Reference(_) => None,
            Self::Gpu(renderer, path) => {
                let loaded = load(renderer, &stage, subject.lapped, tints, common)?;
                Some((renderer, loaded, *path))
            }
        };
        let bar = Bar::new(common.quiet);
        bar.stage("drawing", cameras.len() as u64);
        for (done, camera) in cameras.iter().enumerate() {
            bar.done(done as u64);
            #[cfg(feature = "gpu")]
            if let Some((renderer, loaded, path)) = &loaded {
                each(renderer.draw(loaded, &stage, camera, grid, *path)?)?;
                continue;
            }
            each(stage.draw(subject.texture, &Visibility::new(subject.mesh, camera, grid)?))?;
        }
        bar.finish();
        Ok(())
    }

    /// One picture of each moment: of what a moving mesh becomes, and with exemplars as they are so many seconds on. Each is handed over as
    /// soon as it is drawn.
    #[allow(clippy::too_many_arguments, reason = "what is drawn, by what light, and where it goes")]
    pub(super) fn play(
        &self,
        moments: impl ExactSizeIterator<Item = anyhow::Result<(Mesh, f64)>>,
        lapped: Option<&LappedTexture>,
        options: &SheetOptions,
        camera: &Camera,
        grid: Grid,
        common: &Common,
        each: Each<'_>,
    ) -> anyhow::Result<()> {
        #[cfg(feature = "gpu")]
        let mut loaded = None;
        let bar = Bar::new(common.quiet);
        bar.stage("drawing", moments.len() as u64);
        for (done, moment) in moments.enumerate() {
            let (mesh, seconds) = moment?;
            bar.done(done as u64);
            let stage = Stage::new(&mesh, &options.draw);
            #[cfg(feature = "gpu")]
            if let Self::Gpu(renderer, path) = self {
                let subject = match &mut loaded {
                    Some(subject) => {
                        renderer.follow(subject, &stage)?;
                        subject
                    }
                    None => loaded.insert(load(renderer, &stage, lapped, None, common)?),
                };
                if let Some(lapped) = lapped.filter(|l| duration(&l.exemplars) > 0.0) {
                    let now: Vec<Exemplar> = lapped.exemplars.iter().map(|e| e.at(seconds)).collect();
                    subject.set_patches(renderer.load_patches(&now, &lapped.patches)?.into())?;
                }
                each(renderer.draw(subject, &stage, camera, grid, *path)?)?;
                continue;
            }
            let parallax = self.parallax();
            each(stage.draw(texture_of(&mesh, lapped, parallax, seconds).as_ref(), &Visibility::new(&mesh, camera, grid)?))?;
        }
        bar.finish();
        Ok(())
    }
}

/// A lapped texture, or a bare mesh, on the device. What the device makes of it that the user should know is told.
#[cfg(feature = "gpu")]
fn load(
    renderer: &crate::render::gpu::Renderer,
    stage: &Stage<'_>,
    lapped: Option<&LappedTexture>,
    tints: Tints<'_>,
    common: &Common,
) -> anyhow::Result<crate::render::gpu::Subject> {
    let nothing = LappedTexture::default();
    let loaded = renderer.load_tinted(stage, lapped.unwrap_or(&nothing), tints)?;
    loaded.patches().warnings().iter().for_each(|w| common.warn(w));
    Ok(loaded)
}
