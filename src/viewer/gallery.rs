//! Built-in models and exemplars with small pictures of them, drawn off the interface's thread.

use super::worker::Lane;
use crate::assets;
use crate::exemplar::{Channel, Exemplar, srgb};
use crate::job::Link;
use crate::mesh::{CleanOptions, clean};
use crate::paste::{Composite, LappedTexture};
use crate::render::picture::to_byte;
use crate::render::{Background, DrawOptions, Grid, Picture, View, draw};
use egui::{ColorImage, Context, TextureHandle, TextureOptions};
use std::collections::BTreeMap;

/// Side of a small picture, pixels.
pub const SIDE: u32 = 96;
/// Faces beyond which a model's small picture is not drawn.
const MOST_FACES: usize = 60_000;

/// The small pictures that are there.
pub struct Thumbnails {
    lane: Lane<(Link, ColorImage)>,
    there: BTreeMap<Link, TextureHandle>,
    begun: bool,
}

impl std::fmt::Debug for Thumbnails {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_set().entries(self.there.keys()).finish()
    }
}

impl Thumbnails {
    /// None yet; `wake` is called when one is there.
    pub fn new(wake: impl Fn() + Send + Sync + 'static) -> Self {
        Self { lane: Lane::new("lapped thumbnails", wake), there: BTreeMap::new(), begun: false }
    }

    /// True if none is being drawn.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        self.begun && self.lane.is_idle()
    }

    /// Takes in what was drawn; begins with the built-in ones the first time.
    pub fn take(&mut self, context: &Context) {
        if !std::mem::replace(&mut self.begun, true) {
            self.lane.submit(|_, deliver| {
                let exemplars =
                    assets::exemplar_names().filter_map(|name| Some((name, of_exemplar(&assets::exemplar(name).ok()?))));
                exemplars.for_each(|(name, picture)| deliver((Link::BuiltIn(name.to_owned()), picture)));
                let models = assets::mesh_names().filter_map(|name| Some((name, of_model(name)?)));
                models.for_each(|(name, picture)| deliver((Link::BuiltIn(name.to_owned()), picture)));
            });
        }
        for (link, picture) in self.lane.take() {
            self.add(context, link, picture);
        }
    }

    /// Adds one.
    pub fn add(&mut self, context: &Context, link: Link, picture: ColorImage) {
        let texture = context.load_texture(link.name(), picture, TextureOptions::LINEAR);
        self.there.insert(link, texture);
    }

    /// The small picture of something, if it is there.
    #[must_use]
    pub fn of(&self, link: &Link) -> Option<&TextureHandle> {
        self.there.get(link)
    }
}

/// A picture for the interface.
#[must_use]
pub fn color_image(picture: &Picture) -> ColorImage {
    ColorImage::from_rgba_unmultiplied([picture.width as usize, picture.height as usize], &picture.rgba)
}

/// An exemplar's base colour, the middle of it where it is not square.
#[must_use]
pub fn of_exemplar(exemplar: &Exemplar) -> ColorImage {
    let side = SIDE as usize;
    let Some(chain) = exemplar.channel(Channel::BaseColor) else { return ColorImage::filled([side; 2], egui::Color32::GRAY) };
    let [width, height] = chain.size().map(|s| s as f32);
    let step = width.min(height) / SIDE as f32;
    let first = glam::Vec2::new(0.5 * (width - step * SIDE as f32), 0.5 * (height - step * SIDE as f32));
    let lod = step.max(1.0).log2();
    let pixel = |i: usize| {
        let place = first + glam::Vec2::new((i % side) as f32 + 0.5, (i / side) as f32 + 0.5) * step;
        let [r, g, b] = chain.sample(place, lod).to_array().map(|c| to_byte(srgb::encode(c)));
        egui::Color32::from_rgb(r, g, b)
    };
    ColorImage::new([side; 2], (0..side * side).map(pixel).collect())
}

/// A built-in model from the front right; none if it would take long.
fn of_model(name: &str) -> Option<ColorImage> {
    let model = assets::mesh(name).ok().filter(|m| m.faces.len() <= MOST_FACES)?;
    let mesh = clean(&model.positions, &model.faces, &CleanOptions::default()).ok()?.mesh;
    let options = DrawOptions { background: Background::Transparent, occlusion: false, ..DrawOptions::default() };
    let grid = Grid { width: SIDE, height: SIDE, samples: 2 };
    let nothing = LappedTexture::default();
    let picture = draw(&mesh, &Composite::new(&mesh, &nothing), &View::default().frame(&mesh, 1.0), grid, &options).ok()?;
    Some(color_image(&picture))
}
