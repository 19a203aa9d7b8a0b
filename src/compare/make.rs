//! Making each method's texture, and what it takes.

use super::CompareError;
use super::baselines::{HexOptions, Sheet, Tiling, Triplanar, TriplanarOptions};
use super::method::Method;
use super::setting::Setting;
use super::source::{BakedSource, PastedSource, SeenSource, Sourced, VertexSource};
use crate::atlas::{Atlas, AtlasError, BakeOptions, Frames, MAX_SIZE, Page, Stretch, UnwrapOptions, bake, stretch, unwrap};
use crate::exemplar::{Exemplar, MipChain, Wrap};
use crate::job::bake::{default_samples, default_size};
use crate::job::estimate::{forget_peak, held_memory, peak_memory};
use crate::job::guide::difficulty;
use crate::job::{
    Density, Direction, ExemplarInput, PasteJob, RoundJob, SynthJob, cut_patches, march, synthesize_marched, synthesize_on,
};
use crate::mesh::Mesh;
use crate::paste::{Composite, LappedTexture, PasteOptions, paste};
use crate::progress::Progress;
use crate::render::normals::{corner_normals, crease_angle};
use crate::synth::round::RoundOptions;
use crate::synth::{SynthOptions, VertexTexture};
use serde::Serialize;
use std::sync::Arc;
use std::time::Instant;

/// What a method made.
#[derive(Debug)]
pub enum Product {
    /// Pastes.
    Pasted(Arc<LappedTexture>),
    /// Pastes, charts and pages.
    Baked(Arc<LappedTexture>, Box<Atlas>, Vec<Page>),
    /// Values at vertices.
    Vertex(Box<VertexTexture>),
    /// Planes.
    Planes(Sheet),
    /// Charts.
    Charts(Box<Atlas>),
}

/// What a method takes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Costs {
    /// Seconds to make it, mesh and field given.
    pub seconds: f64,
    /// Memory held at most while it was made, beyond what was held before, bytes; `None` where the system does not say.
    pub peak_bytes: Option<u64>,
    /// How often a face is drawn, on the mean.
    pub draws_per_face: f64,
    /// Bytes of images to show it with, 8 bits a channel, with mip levels.
    pub texture_bytes: u64,
    /// Bytes of all else that it needs beside the mesh: pastes, coordinates, a mesh of its own.
    pub record_bytes: u64,
    /// `texture_bytes` for each square of the exemplar's width on the surface.
    pub texture_bytes_per_square: f64,
    /// `record_bytes` for the same.
    pub record_bytes_per_square: f64,
    /// Stretch of the charts, if there are any.
    pub chart_stretch: Option<Stretch>,
}

/// A method's product and what it took.
#[derive(Debug)]
pub struct Made {
    /// The method.
    pub method: Method,
    /// What it made.
    pub product: Product,
    /// What it took.
    pub costs: Costs,
}

/// Makes methods one after the other; what two of them share is made once.
#[derive(Debug)]
pub struct Maker<'a> {
    setting: &'a Setting,
    /// The pastes, with the seconds they took.
    pasted: Option<(Arc<LappedTexture>, f64)>,
}

/// Bytes of a face in a paste: its number, and coordinates at three corners; see `docs/record.md`.
const PASTE_FACE: usize = 4 + 3 * 8;
/// Bytes of a paste: its patch, where its faces begin, its shift.
const PASTE: usize = 2 + 4 + 8;
/// Bytes of texture coordinates.
const COORDINATES: usize = 8;
/// Bytes of a vertex that has a colour: position, normal, colour.
const VERTEX: usize = 12 + 12 + 4;
/// Bytes of a triangle.
const FACE: usize = 12;
/// Texels of all mip levels over those of the finest.
const MIPS: f64 = 4.0 / 3.0;

impl<'a> Maker<'a> {
    /// A maker for a setting.
    #[must_use]
    pub const fn new(setting: &'a Setting) -> Self {
        Self { setting, pasted: None }
    }

    /// Makes one.
    ///
    /// # Errors
    /// If the method cannot be used on this mesh or exemplar, or `progress` cancels.
    pub fn make(&mut self, method: Method, progress: &dyn Progress) -> Result<Made, CompareError> {
        let forgot = forget_peak();
        let before = held_memory();
        let begin = Instant::now();
        let shared = self.pasted.as_ref().map_or(0.0, |p| p.1);
        let product = match method {
            Method::Pasted => Product::Pasted(self.pasted(progress)?),
            Method::Plain => Product::Pasted(Arc::new(self.lap(self.setting.job.paste.clone().plain(), progress)?)),
            Method::Baked => {
                let lapped = self.pasted(progress)?;
                let (atlas, pages) = self.baked(&lapped, progress)?;
                Product::Baked(lapped, Box::new(atlas), pages)
            }
            Method::WeiLevoy => Product::Vertex(Box::new(self.wei_levoy(progress)?)),
            Method::ChenDong => Product::Vertex(Box::new(self.chen_dong(progress)?)),
            Method::Triplanar => Product::Planes(Sheet::Plain),
            Method::Hex => Product::Planes(Sheet::Hex(HexOptions { seed: self.setting.seed, ..HexOptions::default() })),
            Method::Tiling => Product::Charts(Box::new(self.charts(default_charts(), progress)?)),
        };
        let shared = if matches!(method, Method::Pasted | Method::Baked) { shared } else { 0.0 };
        let mut costs = self.costs(&product);
        costs.seconds = begin.elapsed().as_secs_f64() + shared;
        costs.peak_bytes = if forgot { peak_memory().zip(before).map(|(peak, held)| peak.saturating_sub(held)) } else { None };
        Ok(Made { method, product, costs })
    }

    fn pasted(&mut self, progress: &dyn Progress) -> Result<Arc<LappedTexture>, CompareError> {
        if let Some((lapped, _)) = &self.pasted {
            return Ok(Arc::clone(lapped));
        }
        let begin = Instant::now();
        let lapped = Arc::new(self.lap(self.setting.job.paste.clone(), progress)?);
        self.pasted = Some((Arc::clone(&lapped), begin.elapsed().as_secs_f64()));
        Ok(lapped)
    }

    fn lap(&self, options: PasteOptions, progress: &dyn Progress) -> Result<LappedTexture, CompareError> {
        let Setting { job, guide, exemplar, .. } = self.setting;
        let job = PasteJob { paste: options, ..job.clone() };
        let mesh = self.setting.mesh();
        let mut input = ExemplarInput { exemplar: exemplar.clone(), weight: 1.0, patches: Vec::new() };
        if let Some(choice) = &self.setting.choice {
            input.patches = choice.specs();
            choice.prepare(&mut input.exemplar);
        }
        let (exemplars, patches) = cut_patches(vec![input], &job, &mut Vec::new())?;
        let (lapped, _) = paste(mesh, guide, exemplars, patches, &difficulty(mesh, guide), &job.paste, progress)?;
        Ok(lapped)
    }

    /// Charts on a page of so many texels, or the next larger one that has room for them.
    fn charts(&self, mut size: u32, progress: &dyn Progress) -> Result<Atlas, AtlasError> {
        loop {
            match unwrap(self.setting.mesh(), &UnwrapOptions { size, ..UnwrapOptions::default() }, progress) {
                Err(AtlasError::NoRoom { .. }) if size < MAX_SIZE => size *= 2,
                done => return done,
            }
        }
    }

    fn baked(&self, lapped: &LappedTexture, progress: &dyn Progress) -> Result<(Atlas, Vec<Page>), CompareError> {
        let mesh = self.setting.mesh();
        let atlas = self.charts(default_size(mesh, lapped), progress)?;
        let options = BakeOptions { samples: default_samples(mesh, lapped, atlas.size), ..BakeOptions::default() };
        let frames = Frames::smooth(corner_normals(mesh, crease_angle(mesh)));
        let baked = bake(mesh, &atlas, &frames, &Composite::new(mesh, lapped), &options, progress)?;
        Ok((atlas, baked.pages))
    }

    fn wei_levoy(&self, progress: &dyn Progress) -> Result<VertexTexture, CompareError> {
        let Setting { cleaned, steer, exemplar, scale, seed, .. } = self.setting;
        let job = SynthJob {
            density: Density::Scale(*scale),
            side: Some(longer(exemplar)),
            tiles: Some(exemplar.wrap == Wrap::Repeat),
            direction: Direction::Steered(steer.clone()),
            options: SynthOptions { seed: *seed, ..SynthOptions::default() },
            ..SynthJob::default()
        };
        Ok(synthesize_on(cleaned, exemplar, &job, progress, &mut |_, _, _| ())?.texture)
    }

    fn chen_dong(&self, progress: &dyn Progress) -> Result<VertexTexture, CompareError> {
        let Setting { cleaned, steer, exemplar, scale, seed, .. } = self.setting;
        let job = RoundJob {
            density: Density::Scale(*scale),
            side: Some(longer(exemplar)),
            tiles: Some(exemplar.wrap == Wrap::Repeat),
            direction: Direction::Steered(steer.clone()),
            options: RoundOptions { seed: *seed, ..RoundOptions::default() },
            ..RoundJob::default()
        };
        let (marched, _) = march(&cleaned.mesh, exemplar, &job, None, progress)?;
        Ok(synthesize_marched(cleaned, &marched, exemplar, &job, progress)?.texture)
    }

    fn costs(&self, product: &Product) -> Costs {
        let mesh = self.setting.mesh();
        let image = |chain: &MipChain, bytes: f64| -> f64 {
            let [w, h] = chain.size().map(f64::from);
            w * h * bytes * MIPS
        };
        // Colour is kept in four bytes, as graphics adapters want it.
        let exemplar = |e: &Exemplar| e.channel(crate::exemplar::Channel::BaseColor).map_or(0.0, |c| image(c, 4.0));
        let coordinates = |atlas: &Atlas| atlas.vertices.len() * COORDINATES;
        let mut costs = Costs { draws_per_face: 1.0, ..Costs::default() };
        let (texture, record) = match product {
            Product::Pasted(lapped) => {
                let draws: usize = lapped.pastes.iter().map(|p| p.faces.len()).sum();
                costs.draws_per_face = draws as f64 / mesh.face_count() as f64;
                let masks: f64 = lapped.patches.iter().map(|p| image(&p.mask, 1.0)).sum();
                let images: f64 = lapped.exemplars.iter().map(exemplar).sum();
                (images + masks, draws * PASTE_FACE + lapped.pastes.len() * PASTE)
            }
            Product::Baked(_, atlas, _) => {
                costs.chart_stretch = Some(stretch(mesh, atlas));
                let texels = f64::from(atlas.size).powi(2) * f64::from(atlas.pages);
                (texels * 4.0 * MIPS, coordinates(atlas))
            }
            Product::Vertex(texture) => (0.0, texture.mesh.vertex_count() * VERTEX + texture.mesh.face_count() * FACE),
            Product::Planes(_) => (exemplar(&self.setting.exemplar), 0),
            Product::Charts(atlas) => {
                costs.chart_stretch = Some(stretch(mesh, atlas));
                (exemplar(&self.setting.exemplar), coordinates(atlas))
            }
        };
        (costs.texture_bytes, costs.record_bytes) = (texture.round() as u64, record as u64);
        // A square of the exemplar's width is not the exemplar's area unless that is a square.
        let squares = (mesh.total_area() / self.setting.scale.powi(2)).max(f64::MIN_POSITIVE);
        costs.texture_bytes_per_square = texture / squares;
        costs.record_bytes_per_square = record as f64 / squares;
        costs
    }
}

/// Texels along a side of a page for charts that nothing is baked into: enough for gutters to be small.
const fn default_charts() -> u32 {
    1024
}

fn longer(exemplar: &Exemplar) -> u32 {
    exemplar.size()[0].max(exemplar.size()[1])
}

impl Product {
    /// The texture on the mesh that it is at home on, where it is measured: a synthesised one has a mesh of its own.
    #[must_use]
    pub fn at_home<'a>(&'a self, setting: &'a Setting) -> (&'a Mesh, Box<dyn Sourced + 'a>) {
        match self {
            Self::Vertex(texture) => (&texture.mesh, Box::new(VertexSource::new(texture, setting.plane))),
            _ => (setting.mesh(), self.source(setting)),
        }
    }

    /// The texture on the mesh of the setting, where it is seen.
    #[must_use]
    pub fn source<'a>(&'a self, setting: &'a Setting) -> Box<dyn Sourced + 'a> {
        let mesh = setting.mesh();
        match self {
            Self::Pasted(lapped) => Box::new(PastedSource::new(mesh, lapped)),
            Self::Baked(lapped, atlas, pages) => Box::new(BakedSource::new(mesh, atlas, pages, PastedSource::new(mesh, lapped))),
            Self::Vertex(texture) => Box::new(SeenSource::new(mesh, texture, setting.plane)),
            Self::Planes(sheet) => {
                let options = TriplanarOptions { sheet: *sheet, ..TriplanarOptions::default() };
                Box::new(Triplanar::new(mesh, &setting.exemplar, setting.scale, options))
            }
            Self::Charts(atlas) => Box::new(Tiling::new(mesh, atlas, &setting.exemplar, setting.scale)),
        }
    }

    /// Its charts, if it has any.
    #[must_use]
    pub fn charts(&self) -> Option<&Atlas> {
        match self {
            Self::Baked(_, atlas, _) | Self::Charts(atlas) => Some(atlas),
            _ => None,
        }
    }
}
