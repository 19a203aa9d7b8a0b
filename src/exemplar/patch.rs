//! Making texture patches: from shapes asked for to masks, hulls and centres.
//!
//! Based on: Praun, Finkelstein, Hoppe, "Lapped Textures" (2000), sections 3.1 (patches) and 4 (transparent borders).
//!
//! 1. Each shape gives an outline; where the exemplar has transparent parts, the outline of its opaque parts bounds it too,
//!    and so do the centres of the exemplar's border pixels.
//! 2. The depth below the nearest of these outlines gives alpha ([`super::mask`]); soft masks and soft opacity multiply it.
//! 3. The largest piece is cut out, its hull and its deepest opaque point are found.
//!
//! The paper's patches are drawn by hand or are a splotch; whole exemplars, discs and images as masks are ours.

use super::mask::{self, CutOut, OPAQUE};
use super::outline::{self, Outline};
use super::splotch::{Fill, splotch};
use super::{Channel, Exemplar, ExemplarError, Hull, Image, MipChain, TexturePatch, Wrap};
use crate::random::Random;
use glam::{IVec2, Vec2};
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Depth in pixels below the nearest pixel that is not opaque that a patch needs somewhere: there its centre lies, and
/// alpha must be 1 around it for every paste to cover its own seed.
const LEAST_DEPTH: f32 = 2.0;
/// Mask values up to this are background: noise of a lossy file must not become outline.
const BACKGROUND: f32 = 4.0 / 255.0;
/// Mask values from this on are fully opaque, for the same reason.
const FOREGROUND: f32 = 250.0 / 255.0;
/// Where the outline of a mask runs once its background is 0: less than half a step of 8 bits.
const OUTLINE_LEVEL: f32 = 1.0 / 512.0;
/// An exemplar has transparent parts if its opacity falls below this anywhere; above, it is a clear material.
const TRANSPARENT: f32 = 0.5;
/// Shapes without softness of their own are blurred over this many pixels at least, against stairs.
const LEAST_FEATHER: f32 = 1.0;
/// How far the proportions of a mask image may differ from the exemplar's before it is told.
const ASPECT_TOLERANCE: f32 = 0.01;
/// Share of a mask's alpha in dropped pieces from which that is told; less is dust.
const TOLD_SHARE: f32 = 0.001;
/// First of the random streams of splotches.
const SPLOTCH_STREAM: u64 = 0x5350_4C4F_0000_0000;

/// How a shape is named at the command line. Files are not read here.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum PatchShape {
    /// `whole`
    Whole,
    /// `circle`
    Circle,
    /// `splotch`
    Splotch,
    /// `auto`: what [`Choice`](super::auto::Choice) finds.
    Auto,
    /// `FILE.png` or another image.
    Mask(PathBuf),
    /// `FILE.json`
    Outline(PathBuf),
}

impl FromStr for PatchShape {
    type Err = ExemplarError;

    fn from_str(text: &str) -> Result<Self, ExemplarError> {
        const IMAGES: [&str; 9] = ["png", "jpg", "jpeg", "webp", "tga", "bmp", "tif", "tiff", "exr"];
        let extension = Path::new(text).extension().map(|e| e.to_string_lossy().to_lowercase());
        match (text, extension.as_deref()) {
            ("whole", _) => Ok(Self::Whole),
            ("circle", _) => Ok(Self::Circle),
            ("splotch", _) => Ok(Self::Splotch),
            ("auto", _) => Ok(Self::Auto),
            (_, Some("json")) => Ok(Self::Outline(text.into())),
            (_, Some(e)) if IMAGES.contains(&e) => Ok(Self::Mask(text.into())),
            _ => Err(ExemplarError::BadPatch {
                what: "the patch shape".to_owned(),
                found: format!("'{text}'"),
                remedy: "give whole, circle, splotch, auto, an image file as mask or a .json file with outlines".to_owned(),
            }),
        }
    }
}

/// Where texture patches come from.
#[derive(Debug, Clone, PartialEq)]
pub enum PatchSource {
    /// The whole exemplar.
    Whole,
    /// The largest disc.
    Circle,
    /// Smooth random blobs, [`PatchOptions::splotches`] of them.
    Splotch,
    /// An image as mask, stretched over the exemplar: its first component (alpha, or grey) is alpha.
    Mask {
        /// What to call it in messages, usually the file.
        name: String,
        /// The image.
        image: Image,
    },
    /// Polygons, one patch each.
    Outlines {
        /// What to call them in messages, usually the file.
        name: String,
        /// The polygons.
        outlines: Vec<Outline>,
    },
}

/// Texture patches to make.
#[derive(Debug, Clone, PartialEq)]
pub struct PatchSpec {
    /// Their shape.
    pub source: PatchSource,
    /// How often one of them is chosen relative to other specs; shared by all patches made from this one.
    pub weight: f32,
}

/// How texture patches are made.
#[derive(Debug, Clone, PartialEq)]
pub struct PatchOptions {
    /// Pixels below the outline over which alpha rises from 0 to 1. 0 leaves mask images as they are and gives other
    /// shapes an edge of one pixel.
    pub feather: f32,
    /// Seed of the splotches.
    pub seed: u64,
    /// Splotches per [`PatchSource::Splotch`].
    pub splotches: u32,
    /// Share of the exemplar's sides that splotches leave free, so that other parts of it can show under them.
    pub room: f32,
    /// Splotches fill more of the exemplar, and are less irregular: for pastes whose borders are moved away from their outlines.
    pub full: bool,
}

impl Default for PatchOptions {
    fn default() -> Self {
        Self { feather: 3.0, seed: 0, splotches: 3, room: 0.0, full: false }
    }
}

/// Cuts texture patches from exemplar number `index`. Also returns warnings, each a sentence.
///
/// # Errors
/// If a setting is out of range, an outline is no simple polygon, or a patch would have no opaque part.
pub fn make_patches(
    exemplar: &Exemplar,
    index: u16,
    specs: &[PatchSpec],
    options: &PatchOptions,
) -> Result<(Vec<TexturePatch>, Vec<String>), ExemplarError> {
    check(specs, options)?;
    let mut warnings = Vec::new();
    let ground = Ground::new(exemplar, options.feather, &mut warnings);
    let mut patches = Vec::new();
    for (number, spec) in specs.iter().enumerate() {
        let cuts = cuts(&ground, spec, options, u64::from(index) << 16 | number as u64, &mut warnings)?;
        let weight = spec.weight / cuts.len() as f32;
        let slides = matches!(spec.source, PatchSource::Whole | PatchSource::Circle | PatchSource::Splotch);
        for Cut { name, depth, soft, moved } in cuts {
            let name = format!("{name} of exemplar '{}'", exemplar.name);
            let patch = ground.patch(&name, depth, soft.as_deref(), &mut warnings)?.moved(moved);
            patches.push(TexturePatch { exemplar: index, weight, slides: slides && ground.soft.is_none(), ..patch });
        }
    }
    Ok((patches, warnings))
}

/// True if the exemplar has transparent parts and enough opaque ones that its opacity serves as an outline of its patches.
/// Otherwise opacity is a property of the material like any other channel.
#[must_use]
pub fn opacity_is_outline(exemplar: &Exemplar, feather: f32) -> bool {
    Ground::new(exemplar, feather, &mut Vec::new()).soft.is_some()
}

fn check(specs: &[PatchSpec], options: &PatchOptions) -> Result<(), ExemplarError> {
    let bad = |what: &str, found: String, remedy: &str| {
        Err(ExemplarError::BadPatch { what: what.to_owned(), found, remedy: remedy.to_owned() })
    };
    if !(options.feather.is_finite() && options.feather >= 0.0) {
        return bad("the feather", options.feather.to_string(), "give a number of pixels, 0 or more");
    }
    if options.splotches == 0 {
        return bad("the number of splotches", "0".to_owned(), "give 1 or more");
    }
    if !(0.0..=0.5).contains(&options.room) {
        return bad("the room of splotches", options.room.to_string(), "give a share of the exemplar from 0 to 0.5");
    }
    for spec in specs {
        if !(spec.weight.is_finite() && spec.weight > 0.0) {
            return bad("the weight of a patch", spec.weight.to_string(), "give a number above 0");
        }
        if matches!(&spec.source, PatchSource::Outlines { outlines, .. } if outlines.is_empty()) {
            return bad("the number of outlines", "0".to_owned(), "give 1 or more");
        }
    }
    Ok(())
}

/// One patch to cut: the depth of each pixel below its outline, and alpha of its own that multiplies the feather's.
struct Cut {
    name: String,
    depth: Vec<f32>,
    soft: Option<Vec<f32>>,
    /// Where the patch lies, from where it was cut.
    moved: IVec2,
}

impl TexturePatch {
    /// The patch so many pixels further in an exemplar that repeats.
    fn moved(self, by: IVec2) -> Self {
        let origin = (IVec2::from_array(self.origin) + by).to_array();
        Self { origin, hull: self.hull.moved(by.as_vec2()), centre: self.centre + by.as_vec2(), ..self }
    }
}

fn cuts(
    ground: &Ground,
    spec: &PatchSpec,
    options: &PatchOptions,
    stream: u64,
    warnings: &mut Vec<String>,
) -> Result<Vec<Cut>, ExemplarError> {
    let hard = |name: String, depth| Cut { name, depth, soft: None, moved: IVec2::ZERO };
    Ok(match &spec.source {
        PatchSource::Whole => vec![hard("the whole".to_owned(), vec![ground.reach; ground.depth.len()])],
        PatchSource::Circle => vec![hard("the circle".to_owned(), ground.circle())],
        PatchSource::Splotch => (0..options.splotches)
            .map(|k| {
                let mut random = Random::new(options.seed, SPLOTCH_STREAM + (stream << 16) + u64::from(k));
                let free = (ground.size() * options.room * 0.5).floor() + 0.5;
                let fill = if options.full { Fill::FULL } else { Fill::ROUGH };
                let points = splotch(free, ground.size() - free, options.feather, fill, &mut random);
                hard(format!("splotch {}", k + 1), ground.polygon(&points))
            })
            .collect(),
        PatchSource::Outlines { name, outlines } => {
            let cut = |(i, outline): (usize, &Outline)| {
                let name = format!("outline {} of '{name}'", i + 1);
                let points = outline.in_pixels(ground.size(), &name)?;
                let moved = ground.beyond(&points);
                let points: Vec<Vec2> = points.iter().map(|&p| p - moved.as_vec2()).collect();
                Ok(Cut { moved, ..hard(name, ground.polygon(&points)) })
            };
            outlines.iter().enumerate().map(cut).collect::<Result<_, _>>()?
        }
        PatchSource::Mask { name, image } => {
            let name = format!("mask '{name}'");
            let image = ground.fitted(image, &name, warnings);
            let feathered = options.feather > 0.0;
            let depth = if feathered { ground.depth_in(&image) } else { vec![ground.reach; ground.depth.len()] };
            vec![Cut { name, depth, soft: Some(image.data().to_vec()), moved: IVec2::ZERO }]
        }
    })
}

/// What bounds all patches of one exemplar: its border and its own opacity.
struct Ground {
    width: usize,
    height: usize,
    /// Width of the transition from outline to opaque.
    reach: f32,
    /// Depth of each pixel, at most `reach`.
    depth: Vec<f32>,
    /// Opacity, where it is an outline.
    soft: Option<Vec<f32>>,
    /// The exemplar goes on over its edges.
    repeats: bool,
}

impl Ground {
    fn new(exemplar: &Exemplar, feather: f32, warnings: &mut Vec<String>) -> Self {
        let [width, height] = exemplar.size().map(|n| n as usize);
        let reach = feather.max(LEAST_FEATHER);
        // The centres of border pixels are the outline, so that these are transparent.
        let mut depth = vec![reach; width * height];
        for (y, row) in depth.chunks_exact_mut(width).enumerate() {
            for (x, depth) in row.iter_mut().enumerate() {
                *depth = (x.min(width - 1 - x).min(y).min(height - 1 - y) as f32).min(reach);
            }
        }
        let bare = Self { width, height, reach, depth, soft: None, repeats: exemplar.wrap == Wrap::Repeat };
        let Some(opacity) = exemplar.channel(Channel::Opacity).map(MipChain::finest) else { return bare };
        if opacity.data().iter().all(|&o| o >= TRANSPARENT) {
            return bare;
        }
        let opacity = levels(opacity);
        let mut bounded = Self { soft: Some(opacity.data().to_vec()), ..bare };
        let own = bounded.depth_in(&opacity);
        let both = bounded.depth.iter().zip(own).map(|(rectangle, own)| rectangle.min(own)).collect();
        let rectangle = std::mem::replace(&mut bounded.depth, both);
        let opaque: Vec<bool> = bounded.alpha(&bounded.depth, None).iter().map(|&a| a >= OPAQUE).collect();
        if mask::deepest(&opaque, width).is_some_and(|(_, depth)| depth >= LEAST_DEPTH) {
            return bounded;
        }
        warnings.push(format!(
            "the opaque parts of exemplar '{}' are too thin for a feather of {feather} pixels: patches ignore its opacity, \
             which stays a channel of the material",
            exemplar.name
        ));
        Self { depth: rectangle, soft: None, ..bounded }
    }

    fn size(&self) -> Vec2 {
        Vec2::new(self.width as f32, self.height as f32)
    }

    /// Depth below the largest disc inside the border and the opaque parts.
    fn circle(&self) -> Vec<f32> {
        let whole = (self.size() * 0.5, self.size().min_element() * 0.5 - 0.5);
        let (centre, radius) = match &self.soft {
            None => whole,
            Some(_) => {
                let inside: Vec<bool> = self.depth.iter().map(|&d| d > 0.0).collect();
                mask::deepest(&inside, self.width).map_or(whole, |(centre, depth)| (centre, depth - 0.5))
            }
        };
        let depth = |i: usize| radius - centre.distance(Vec2::new((i % self.width) as f32, (i / self.width) as f32) + 0.5);
        (0..self.depth.len()).map(|i| depth(i).clamp(0.0, self.reach)).collect()
    }

    /// How far a polygon must be moved back to lie in the exemplar's middle, if it reaches over edges that repeat.
    fn beyond(&self, points: &[Vec2]) -> IVec2 {
        let low = points.iter().fold(Vec2::INFINITY, |m, &p| m.min(p));
        let high = points.iter().fold(Vec2::NEG_INFINITY, |m, &p| m.max(p));
        let over = low.cmplt(Vec2::ZERO).any() || high.cmpgt(self.size()).any();
        if over && self.repeats && self.soft.is_none() {
            (0.5 * (low + high - self.size())).round().as_ivec2()
        } else {
            IVec2::ZERO
        }
    }

    fn polygon(&self, points: &[Vec2]) -> Vec<f32> {
        let inside = outline::fill(points, self.width, self.height);
        outline::depth_below(&inside, self.width, &outline::sides(points), self.reach)
    }

    /// Depth below the line where a mask of the exemplar's size begins to be more than background.
    fn depth_in(&self, mask: &Image) -> Vec<f32> {
        let inside: Vec<bool> = mask.data().iter().map(|&v| v >= OUTLINE_LEVEL).collect();
        outline::depth_below(&inside, self.width, &outline::level_line(mask, OUTLINE_LEVEL), self.reach)
    }

    /// A mask image brought to the exemplar's size, one component, background 0 and foreground 1.
    fn fitted(&self, image: &Image, name: &str, warnings: &mut Vec<String>) -> Image {
        let [w, h] = image.size();
        let scale = Vec2::new(w as f32, h as f32) / self.size();
        if (scale.x / scale.y - 1.0).abs() > ASPECT_TOLERANCE {
            warnings.push(format!(
                "{name} has {w} x {h} pixels, the exemplar {} x {}: it is stretched out of proportion",
                self.width, self.height
            ));
        }
        if scale == Vec2::ONE {
            return levels(image);
        }
        let chain = MipChain::new(image.clone());
        let lod = scale.max_element().log2().max(0.0);
        levels(&Image::grey_from_fn(self.width as u32, self.height as u32, |x, y| {
            chain.sample((Vec2::new(x as f32, y as f32) + 0.5) * scale, lod).x
        }))
    }

    fn alpha(&self, depth: &[f32], soft: Option<&[f32]>) -> Vec<f32> {
        let feathered = |(i, depth): (usize, &f32)| mask::feather_alpha(depth.min(self.depth[i]), self.reach);
        let mut alpha: Vec<f32> = depth.par_iter().enumerate().map(feathered).collect();
        for factor in [soft, self.soft.as_deref()].into_iter().flatten() {
            alpha.par_iter_mut().zip(factor).for_each(|(alpha, factor)| *alpha *= factor);
        }
        alpha
    }

    /// The patch below an outline: its mask, hull and centre. Weight and exemplar are the caller's.
    fn patch(
        &self,
        name: &str,
        depth: Vec<f32>,
        soft: Option<&[f32]>,
        warnings: &mut Vec<String>,
    ) -> Result<TexturePatch, ExemplarError> {
        let nothing = || ExemplarError::NothingOpaque {
            what: name.to_owned(),
            need: 2.0 * LEAST_DEPTH - 1.0,
            remedy: format!("use a larger shape or image, or a feather below {} pixels", self.reach),
        };
        let alpha = self.alpha(&depth, soft);
        drop(depth);
        let CutOut { mask, origin, dropped } = mask::cut_out(&alpha, self.width).ok_or_else(nothing)?;
        if dropped.1 >= TOLD_SHARE {
            warnings.push(format!(
                "{name} falls into {} pieces: only the largest is used, {:.1} % of it is left out",
                dropped.0 + 1,
                100.0 * dropped.1
            ));
        }
        let opaque: Vec<bool> = mask.data().iter().map(|&a| a >= OPAQUE).collect();
        let deepest = mask::deepest(&opaque, mask.size()[0] as usize);
        let (centre, _) = deepest.filter(|&(_, depth)| depth >= LEAST_DEPTH).ok_or_else(nothing)?;
        let hull = Hull::of_mask(&mask, origin).ok_or_else(nothing)?;
        Ok(TexturePatch {
            exemplar: 0,
            origin: origin.to_array(),
            mask: MipChain::mask(mask),
            hull,
            centre: centre + origin.as_vec2(),
            weight: 1.0,
            slides: false,
        })
    }
}

/// The first component of a mask, stretched so that background becomes 0 and foreground 1.
fn levels(mask: &Image) -> Image {
    let [w, h] = mask.size();
    Image::grey_from_fn(w, h, |x, y| {
        let v = mask.grey(i64::from(x), i64::from(y));
        ((v - BACKGROUND) / (FOREGROUND - BACKGROUND)).clamp(0.0, 1.0)
    })
}
