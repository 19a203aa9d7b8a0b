//! What draws: the processor, or a graphics adapter.

#![cfg_attr(not(feature = "gpu"), allow(unused_variables, reason = "only adapters draw from the pastes and warn"))]

use super::Common;
use super::bar::Bar;
use super::render::{Mode, RenderArgs};
use crate::paste::LappedTexture;
use crate::progress::Progress;
use crate::render::{Camera, Grid, Picture, PreviewStyle, SheetOptions, Stage, Subject, Visibility, preview};

/// A renderer, chosen.
pub(super) enum Brush {
    Reference,
    #[cfg(feature = "gpu")]
    Gpu(Box<crate::render::gpu::Renderer>, crate::render::gpu::Path),
}

impl Brush {
    /// The renderer that the arguments ask for.
    pub(super) fn new(args: &RenderArgs) -> anyhow::Result<Self> {
        let texture = args.style == PreviewStyle::Texture;
        if args.turntable.is_some() && !texture {
            anyhow::bail!("a turntable shows the texture: leave out --style {}, or draw single views", args.style);
        }
        if !texture && matches!(args.mode, Mode::Single | Mode::Layered) {
            anyhow::bail!("the style {} is drawn on the processor: leave out --mode, or ask for reference", args.style);
        }
        if args.mode == Mode::Reference && args.adapter.is_some() {
            anyhow::bail!("the mode reference uses no graphics adapter: leave out --adapter, or ask for another mode");
        }
        match args.mode {
            Mode::Reference => Ok(Self::Reference),
            Mode::Auto if !texture => Ok(Self::Reference),
            mode => Self::graphics(mode, args),
        }
    }

    #[cfg(feature = "gpu")]
    fn graphics(mode: Mode, args: &RenderArgs) -> anyhow::Result<Self> {
        use crate::render::gpu::{Gpu, GpuOptions, Path, Renderer, RendererOptions, has_hardware};
        let open = |adapter| Renderer::new(Gpu::new(&GpuOptions { adapter, limits: None })?, RendererOptions::default());
        let path = if mode == Mode::Layered { Path::Layered } else { Path::Single };
        if mode != Mode::Auto || args.adapter.is_some() {
            return Ok(Self::Gpu(Box::new(open(args.adapter.clone())?), path));
        }
        // A software adapter has nothing over the reference renderer.
        if !has_hardware() {
            return Ok(Self::Reference);
        }
        match open(None) {
            Ok(renderer) => Ok(Self::Gpu(Box::new(renderer), path)),
            Err(error) => {
                args.common.warn(&format!("{error}: it was drawn so"));
                Ok(Self::Reference)
            }
        }
    }

    #[cfg(not(feature = "gpu"))]
    fn graphics(mode: Mode, _args: &RenderArgs) -> anyhow::Result<Self> {
        if mode == Mode::Auto {
            return Ok(Self::Reference);
        }
        anyhow::bail!("this program was built without graphics adapters (the cargo feature gpu): draw with --mode reference")
    }

    /// Its name on the command line.
    pub(super) fn mode(&self) -> &'static str {
        match self {
            Self::Reference => "reference",
            #[cfg(feature = "gpu")]
            Self::Gpu(_, crate::render::gpu::Path::Single) => "single",
            #[cfg(feature = "gpu")]
            Self::Gpu(_, crate::render::gpu::Path::Layered) => "layered",
        }
    }

    /// The adapter it draws with.
    pub(super) fn adapter(&self) -> Option<String> {
        match self {
            Self::Reference => None,
            #[cfg(feature = "gpu")]
            Self::Gpu(renderer, _) => Some(renderer.gpu().adapter()),
        }
    }

    /// A sheet of views.
    pub(super) fn sheet(
        &self,
        subject: &Subject<'_>,
        lapped: &LappedTexture,
        style: PreviewStyle,
        options: &SheetOptions,
        common: &Common,
    ) -> anyhow::Result<Picture> {
        match self {
            Self::Reference => Ok(preview(subject, style, options)?),
            #[cfg(feature = "gpu")]
            Self::Gpu(renderer, path) => {
                let stage = Stage::new(subject.mesh, &options.draw);
                let loaded = renderer.load(&stage, lapped)?;
                loaded.patches().warnings().iter().for_each(|w| common.warn(w));
                let draw = |camera: &Camera, grid| renderer.draw(&loaded, &stage, camera, grid, *path);
                Ok(crate::render::lay_out(subject.mesh, options, draw)?)
            }
        }
    }

    /// One picture from each camera.
    pub(super) fn views(
        &self,
        subject: &Subject<'_>,
        lapped: &LappedTexture,
        options: &SheetOptions,
        cameras: &[Camera],
        grid: Grid,
        common: &Common,
    ) -> anyhow::Result<Vec<Picture>> {
        let stage = Stage::new(subject.mesh, &options.draw);
        #[cfg(feature = "gpu")]
        let loaded = match self {
            Self::Reference => None,
            Self::Gpu(renderer, path) => {
                let loaded = renderer.load(&stage, lapped)?;
                loaded.patches().warnings().iter().for_each(|w| common.warn(w));
                Some((renderer, loaded, *path))
            }
        };
        let mut pictures = Vec::new();
        let bar = Bar::new(common.quiet);
        bar.stage("drawing", cameras.len() as u64);
        for camera in cameras {
            bar.done(pictures.len() as u64);
            #[cfg(feature = "gpu")]
            if let Some((renderer, loaded, path)) = &loaded {
                pictures.push(renderer.draw(loaded, &stage, camera, grid, *path)?);
                continue;
            }
            pictures.push(stage.draw(subject.texture, &Visibility::new(subject.mesh, camera, grid)?));
        }
        bar.finish();
        Ok(pictures)
    }
}
