//! Exemplars from files: one image, or a material set with an image for each channel.
//!
//! 1. The files of the set are found by their names, or named by the caller.
//! 2. Each is decoded by what it holds: colours from sRGB, data as it is.
//! 3. Sizes are brought to that of the base colour, normals to y up, heights to bright-is-outward.
//! 4. Transparency of the base colour's own file becomes the opacity channel. Colours under transparent pixels stay as the
//!    file has them; extending the opaque ones into them is the caller's next step.

mod frames;
mod names;
mod relief;
mod set;

use super::error::{FormatError, Problem, Warning};
use super::picture::{Picture, Transfer, decode};
use super::read_file;
use crate::exemplar::{Channel, Exemplar, Image, MipChain, Wrap, equalize};
pub use frames::{FRAMES_PER_SECOND, FrameOptions, FrameSource};
use glam::{Vec2, Vec3};
use image::ImageFormat;
use names::Role;
use set::{Found, find};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Which way the second component of a normal map points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum NormalConvention {
    /// Up along the image.
    #[default]
    OpenGl,
    /// Down along the image.
    DirectX,
}

impl std::fmt::Display for NormalConvention {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::OpenGl => "OpenGL (green is up)",
            Self::DirectX => "DirectX (green is down)",
        })
    }
}

/// How to read an exemplar.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ExemplarOptions {
    /// Files of single channels; they go before any that are found by name.
    pub channels: BTreeMap<Channel, PathBuf>,
    /// Read the named image alone, without looking for others of its set.
    pub alone: bool,
    /// Convention of the normal map. `None` goes by its name, then by the map itself.
    pub normal: Option<NormalConvention>,
    /// Whether bright means outward in the height map. `None` goes by the normal map, if there is one.
    pub bright_is_high: Option<bool>,
    /// What lies beyond the edges.
    pub wrap: Wrap,
    /// Take slow changes of light out of the base colour ([`equalize`]), of each frame by itself.
    pub equalize: bool,
    /// How it changes.
    pub frames: FrameOptions,
}

/// Reads an exemplar. `path` is an image, a folder with one material set, or the beginning of a set's file names.
///
/// # Errors
/// If a file cannot be read or decoded, there is no base colour or a choice of several, or every pixel is transparent.
pub fn read_exemplar(path: &Path, options: &ExemplarOptions) -> Result<(Exemplar, Vec<Warning>), FormatError> {
    let mut warnings = Vec::new();
    let found = find(path, options, &mut warnings)?;
    let base = &found.files[&Role::Channel(Channel::BaseColor)];
    let pictures = frames::animated(base, options)?;
    let picture = pictures.first().map_or_else(|| read_picture(base, Transfer::Srgb), |(picture, _)| Ok(picture.clone()))?;
    warn_if_clipped(&picture.image, base, &mut warnings);
    let fail = |source| FormatError::Exemplar { path: base.clone(), source };
    let mut exemplar = Exemplar::new(found.name.clone(), in_color(picture.image));
    exemplar.wrap = options.wrap;
    if let Some(alpha) = picture.alpha {
        if alpha.data().iter().all(|&a| a == 0.0) {
            let problem = Problem::new("", "every pixel is transparent", "use an image with something in it");
            return Err(FormatError::malformed(base, problem));
        }
        exemplar.set(Channel::Opacity, alpha).map_err(fail)?;
    }
    for (channel, image) in read_channels(&found, options, exemplar.size(), &mut warnings)? {
        exemplar.set(channel, image).map_err(fail)?;
    }
    let keeps_opacity = found.files.contains_key(&Role::Channel(Channel::Opacity));
    let mut exemplar = frames::add(exemplar, pictures, base, options, keeps_opacity, &mut warnings)?;
    if options.equalize {
        let (done, cost) = equalize(&mut exemplar).told();
        note(&mut warnings, base, &done);
        if let Some(cost) = cost {
            warn(&mut warnings, base, &cost);
        }
    }
    Ok((exemplar, warnings))
}

/// An exemplar from files already in memory, the base colour first; normals point y up, heights are bright outward. The
/// paths are for messages.
///
/// # Errors
/// If a file cannot be decoded, or does not fit the first.
pub fn read_exemplar_bytes<'a>(
    name: &str,
    files: impl Iterator<Item = (Channel, &'a Path, &'a [u8])>,
) -> Result<Exemplar, FormatError> {
    let mut exemplar: Option<Exemplar> = None;
    for (channel, path, file) in files {
        if file.is_empty() {
            return Err(FormatError::Empty { path: path.to_owned() });
        }
        let picture = decode(file, image::guess_format(file).ok(), Transfer::of(channel));
        let image = picture.map_err(|problem| FormatError::malformed(path, problem))?.image;
        let image = if channel.components() == 3 { in_color(image) } else { in_grey(&image) };
        match &mut exemplar {
            None => exemplar = Some(Exemplar::new(name, image)),
            Some(e) => e.set(channel, image).map_err(|source| FormatError::Exemplar { path: path.to_owned(), source })?,
        }
    }
    exemplar.ok_or_else(|| FormatError::Empty { path: name.into() })
}

/// Reads a mask: an image's transparency if it has any, else its brightness as it is stored; one component, 0 to 1.
///
/// # Errors
/// If the file cannot be read or decoded.
pub fn read_mask(path: &Path) -> Result<Image, FormatError> {
    let picture = read_picture(path, Transfer::Linear)?;
    Ok(picture.alpha.unwrap_or_else(|| in_grey(&picture.image)))
}

/// Every channel but the base colour, at the base colour's size.
fn read_channels(
    found: &Found,
    options: &ExemplarOptions,
    size: [u32; 2],
    warnings: &mut Vec<Warning>,
) -> Result<BTreeMap<Channel, Image>, FormatError> {
    let mut images = BTreeMap::new();
    for (&role, path) in &found.files {
        match role {
            Role::Channel(Channel::BaseColor) => {}
            Role::Channel(channel) => {
                let picture = read_picture(path, Transfer::of(channel))?;
                let image = match channel {
                    Channel::Opacity => picture.alpha.unwrap_or_else(|| in_grey(&picture.image)),
                    Channel::Normal if picture.image.components() == 1 => {
                        warn(warnings, path, "a normal map needs three components, this image is grey: it was left out");
                        continue;
                    }
                    _ if channel.components() == 3 => in_color(picture.image),
                    _ => in_grey(&picture.image),
                };
                if channel == Channel::Emissive {
                    warn_if_clipped(&image, path, warnings);
                }
                images.insert(channel, fit(image, size, path, warnings));
            }
            Role::Gloss => {
                let mut image = in_grey(&read_picture(path, Transfer::Linear)?.image);
                image.data_mut().iter_mut().for_each(|v| *v = 1.0 - *v);
                images.entry(Channel::Roughness).or_insert(fit(image, size, path, warnings));
            }
            Role::Packed => {
                let image = fit(in_color(read_picture(path, Transfer::Linear)?.image), size, path, warnings);
                for (k, channel) in [Channel::Occlusion, Channel::Roughness, Channel::Metallic].into_iter().enumerate() {
                    let [w, h] = size;
                    let plane = || Image::grey_from_fn(w, h, |x, y| image.pixel(i64::from(x), i64::from(y))[k]);
                    images.entry(channel).or_insert_with(plane);
                }
            }
        }
    }
    settle_relief(found, options, &mut images, warnings);
    Ok(images)
}

/// Turns the normal map to y up and the height map to bright-is-outward.
fn settle_relief(found: &Found, options: &ExemplarOptions, images: &mut BTreeMap<Channel, Image>, warnings: &mut Vec<Warning>) {
    let file = |channel| found.files.get(&Role::Channel(channel));
    let (Some(mut normal), Some(path)) = (images.remove(&Channel::Normal), file(Channel::Normal)) else {
        if options.bright_is_high == Some(false) {
            images.get_mut(&Channel::Height).map(turn_over);
        }
        return;
    };
    let seen = relief::y_up(&normal);
    let looks = if seen < 0.0 { NormalConvention::DirectX } else { NormalConvention::OpenGl };
    let telling = seen.abs() >= relief::TELLING;
    let convention = match (options.normal, found.convention) {
        (Some(stated), _) => stated,
        (None, Some(named)) => {
            if telling && looks != named {
                let text = format!("its name says {named}, but its slopes look like {looks}; the name was believed");
                warn(warnings, path, &text);
            } else {
                note(warnings, path, &format!("the convention of this normal map is {named}, by its name"));
            }
            named
        }
        (None, None) if telling => {
            note(warnings, path, &format!("the convention of this normal map is {looks}, by its slopes"));
            looks
        }
        (None, None) => {
            warn(warnings, path, "nothing tells the convention of this normal map; OpenGL (green is up) was taken");
            NormalConvention::OpenGl
        }
    };
    if convention == NormalConvention::DirectX {
        normal.data_mut().as_chunks_mut::<3>().0.iter_mut().for_each(|n| n[1] = -n[1]);
    }
    if let (Some(height), Some(path)) = (images.get_mut(&Channel::Height), file(Channel::Height)) {
        let deep = relief::bright_is_high(&normal, height) <= -relief::TELLING;
        let bright_is_high = options.bright_is_high.unwrap_or(!deep);
        if !bright_is_high {
            turn_over(height);
        }
        if options.bright_is_high.is_none() && deep {
            warn(warnings, path, "against the normal map, bright is deep in this height map; it was turned over");
        }
    }
    images.insert(Channel::Normal, normal);
}

fn turn_over(height: &mut Image) {
    height.data_mut().iter_mut().for_each(|h| *h = 1.0 - *h);
}

fn warn(warnings: &mut Vec<Warning>, path: &Path, text: &str) {
    warnings.push(Warning { path: path.to_owned(), text: text.to_owned(), note: false });
}

fn note(warnings: &mut Vec<Warning>, path: &Path, text: &str) {
    warnings.push(Warning { path: path.to_owned(), text: text.to_owned(), note: true });
}

/// Records hold colours of 0 to 1; brighter ones, which float files may have, are told.
fn warn_if_clipped(image: &Image, path: &Path, warnings: &mut Vec<Warning>) {
    let brightest = image.data().iter().copied().fold(0.0, f32::max);
    if brightest > 1.0 {
        let over = image.data().iter().filter(|&&v| v > 1.0).count() as f64 / image.data().len() as f64;
        let text = format!(
            "it is up to {brightest:.3} bright, and {:.1} % of it is above 1: that will be cut off at 1 where the record is written; \
             expose it darker to keep it",
            100.0 * over
        );
        warn(warnings, path, &text);
    }
}

fn read_picture(path: &Path, transfer: Transfer) -> Result<Picture, FormatError> {
    let file = read_file(path, "an image")?;
    if file.is_empty() {
        return Err(FormatError::Empty { path: path.to_owned() });
    }
    let format = image::guess_format(&file).ok().or_else(|| {
        // TGA files do not say what they are.
        ImageFormat::from_path(path).ok().filter(|&f| f == ImageFormat::Tga)
    });
    if format.is_none() {
        return Err(FormatError::Unknown {
            path: path.to_owned(),
            found: "this is no image known here".into(),
            remedy: "name a PNG, JPEG, EXR, HDR, WebP, TGA, BMP or TIFF file".into(),
        });
    }
    decode(&file, format, transfer).map_err(|problem| FormatError::malformed(path, problem))
}

/// Three components, whatever came in.
fn in_color(image: Image) -> Image {
    if image.components() == 3 {
        return image;
    }
    let [w, h] = image.size();
    Image::from_fn(w, h, |x, y| image.pixel(i64::from(x), i64::from(y)))
}

/// One component: the mean of those there are.
fn in_grey(image: &Image) -> Image {
    let [w, h] = image.size();
    Image::grey_from_fn(w, h, |x, y| {
        let p = image.pixel(i64::from(x), i64::from(y));
        // Three equal components must come out as they are, without rounding.
        if p == Vec3::splat(p.x) { p.x } else { p.element_sum() / 3.0 }
    })
}

/// The image at another size, by trilinear sampling of its mip levels.
fn fit(image: Image, size: [u32; 2], path: &Path, warnings: &mut Vec<Warning>) -> Image {
    let from = image.size();
    if from == size {
        return image;
    }
    let text = format!("{} x {} pixels were resampled to the base colour's {} x {}", from[0], from[1], size[0], size[1]);
    warn(warnings, path, &text);
    let ratio = Vec2::new(from[0] as f32 / size[0] as f32, from[1] as f32 / size[1] as f32);
    let components = image.components();
    let chain = MipChain::new(image);
    let lod = ratio.max_element().log2().max(0.0);
    let sample = |x: u32, y: u32| chain.sample((Vec2::new(x as f32, y as f32) + 0.5) * ratio, lod);
    if components == 3 {
        Image::from_fn(size[0], size[1], sample)
    } else {
        Image::grey_from_fn(size[0], size[1], |x, y| sample(x, y).x)
    }
}
