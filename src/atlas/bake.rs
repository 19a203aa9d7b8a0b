//! Baking: what a surface texture looks like at each texel of an atlas.
//!
//! 1. Each face is rasterized exactly over a grid of samples, several to a texel; every sample asks the texture over its own
//!    footprint. A texel is the mean of its samples, colour in linear light.
//! 2. A texel that a chart touches without any sample in it asks at the nearest point of the chart.
//! 3. Normals are turned to the smooth surface and into the tangent frame that glTF renderers will use ([`Frames`]).
//! 4. Where the texture does not cover the surface, the bare surface shows.
//! 5. Gutters are filled ([`mod@super::dilate`]), and both sides of each chart border brought to agree ([`super::seams`]).
//!
//! Rows are worked on in bands, each on its own, so that the result does not depend on the number of threads.

use super::dilate::dilate;
use super::mips::mip_levels;
use super::raster::{BAND, Bands, Triangle};
use super::seams::{SeamStatistics, Seams};
use super::{Atlas, AtlasError, Frames};
use crate::exemplar::{Channel, ChannelSet, Image};
use crate::mesh::{Mesh, SurfacePoint};
use crate::progress::Progress;
use crate::surface::{SurfaceTexture, Texel};
use glam::Vec3;
use rayon::prelude::*;
use serde::Serialize;
use std::sync::atomic::{AtomicU64, Ordering};

/// How to bake.
#[derive(Debug, Clone, PartialEq)]
pub struct BakeOptions {
    /// Samples along each side of a texel: 1, 2, 4 or 8. The texture is asked over the footprint of a sample, so one is enough
    /// where texels are no larger than what the texture is made of.
    pub samples: u32,
    /// Colour of the surface where no texture covers it, linear light.
    pub bare: Vec3,
    /// Whether both sides of each chart border are brought to agree.
    pub seams: bool,
    /// Whether the mip levels of each page are made as well ([`mod@super::mips`]).
    pub mips: bool,
}

impl Default for BakeOptions {
    fn default() -> Self {
        Self { samples: 1, bare: Vec3::new(0.42, 0.40, 0.38), seams: true, mips: false }
    }
}

/// Roughness of the bare surface.
const BARE_ROUGHNESS: f32 = 0.7;

/// One page of a baked atlas.
#[derive(Debug, Clone, PartialEq)]
pub struct Page {
    /// An image for each channel, in the order of channels. Normals are in the charts' tangent frames.
    pub images: Vec<(Channel, Image)>,
    /// Which texels a chart touches; rows from the top.
    pub covered: Vec<bool>,
    /// The same images at the mip levels below, the largest first; empty unless they were asked for.
    pub mips: Vec<Vec<(Channel, Image)>>,
}

impl Page {
    /// The image of a channel.
    #[must_use]
    pub fn image(&self, channel: Channel) -> Option<&Image> {
        self.images.iter().find(|(c, _)| *c == channel).map(|(_, image)| image)
    }
}

/// Figures of a bake.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct BakeStatistics {
    /// Texels that charts touch.
    pub covered_texels: u64,
    /// Samples asked for.
    pub samples: u64,
    /// How charts agree at their borders.
    pub seams: SeamStatistics,
}

/// A baked atlas.
#[derive(Debug, Clone, PartialEq)]
pub struct Baked {
    /// The pages.
    pub pages: Vec<Page>,
    /// Figures.
    pub statistics: BakeStatistics,
}

/// Bakes a texture. `frames` needs tangents if the texture has normals.
///
/// # Errors
/// If the texture cannot answer, or `progress` cancels.
pub fn bake(
    mesh: &Mesh,
    atlas: &Atlas,
    frames: &Frames,
    texture: &dyn SurfaceTexture,
    options: &BakeOptions,
    progress: &dyn Progress,
) -> Result<Baked, AtlasError> {
    let bands = u64::from(atlas.pages) * (atlas.size as usize).div_ceil(BAND) as u64;
    progress.stage("baking", bands);
    let baker = Baker { mesh, atlas, frames, texture, options, layout: Layout::new(texture.channels()), done: AtomicU64::new(0) };
    let mut statistics = BakeStatistics::default();
    let mut pages = Vec::with_capacity(atlas.pages as usize);
    for page in 0..atlas.pages {
        pages.push(baker.page(page, &mut statistics, progress)?);
    }
    progress.stage("filling gutters", 0);
    for page in &mut pages {
        dilate(&page.covered, atlas.size as usize, &mut page.images);
    }
    progress.stage("matching chart borders", 0);
    let seams = Seams::new(mesh, atlas, frames);
    if options.seams {
        seams.solve(&mut pages);
    }
    statistics.seams = seams.measure(&pages);
    if options.mips {
        progress.stage("making mip levels", 0);
        for page in &mut pages {
            page.mips = mip_levels(&page.covered, &page.images);
        }
    }
    if progress.cancelled() {
        return Err(AtlasError::Cancelled);
    }
    Ok(Baked { pages, statistics })
}

/// Where each channel's components stand in a texel's row of numbers.
struct Layout {
    /// Channel and its first component.
    channels: Vec<(Channel, usize)>,
    width: usize,
}

impl Layout {
    fn new(channels: ChannelSet) -> Self {
        let mut width = 0;
        let place = |c: Channel| {
            let at = width;
            width += c.components();
            (c, at)
        };
        let channels = channels.with(Channel::BaseColor).iter().map(place).collect();
        Self { channels, width }
    }
}

struct Baker<'a> {
    mesh: &'a Mesh,
    atlas: &'a Atlas,
    frames: &'a Frames,
    texture: &'a dyn SurfaceTexture,
    options: &'a BakeOptions,
    layout: Layout,
    done: AtomicU64,
}

impl Baker<'_> {
    fn page(&self, page: u32, statistics: &mut BakeStatistics, progress: &dyn Progress) -> Result<Page, AtlasError> {
        let size = self.atlas.size as usize;
        let bands = Bands::new(self.mesh, self.atlas, page);
        let mut images: Vec<Vec<f32>> = self.layout.channels.iter().map(|(c, _)| vec![0.0; size * size * c.components()]).collect();
        let mut covered = vec![false; size * size];
        // Each band's part of every image.
        let mut parts: Vec<Vec<&mut [f32]>> = (0..bands.count()).map(|_| Vec::new()).collect();
        for (image, (channel, _)) in images.iter_mut().zip(&self.layout.channels) {
            let chunks = image.chunks_mut(BAND * size * channel.components());
            parts.iter_mut().zip(chunks).for_each(|(part, chunk)| part.push(chunk));
        }
        let counts: Result<Vec<[u64; 2]>, AtlasError> = parts
            .into_par_iter()
            .zip(covered.par_chunks_mut(BAND * size))
            .enumerate()
            .map(|(band, (mut part, covered))| {
                if progress.cancelled() {
                    return Err(AtlasError::Cancelled);
                }
                let samples = self.band(band, bands.faces(band), &mut part, covered).map_err(AtlasError::Baker)?;
                progress.done(self.done.fetch_add(1, Ordering::Relaxed) + 1);
                Ok([samples, covered.iter().filter(|&&c| c).count() as u64])
            })
            .collect();
        for [samples, texels] in counts? {
            statistics.samples += samples;
            statistics.covered_texels += texels;
        }
        let image = |((channel, _), data): (&(Channel, usize), Vec<f32>)| {
            Image::new(size as u32, size as u32, channel.components(), data).map(|image| (*channel, image))
        };
        Ok(Page { images: self.layout.channels.iter().zip(images).filter_map(image).collect(), covered, mips: Vec::new() })
    }

    /// Bakes a band of rows; returns the samples asked for.
    fn band(&self, band: usize, faces: &[u32], images: &mut [&mut [f32]], covered: &mut [bool]) -> Result<u64, String> {
        let size = self.atlas.size as usize;
        let top = (band * BAND) as i64;
        let rows = top..top + (covered.len() / size) as i64;
        let mut count = vec![0_u16; covered.len()];
        let mut questions = Questions::new(self);
        let mut failed = None;
        for &face in faces {
            let Some(triangle) = Triangle::new(self.atlas.face_texels(face)) else { continue };
            let face = Face::new(self, face);
            triangle.samples(rows.clone(), self.options.samples, |x, y, bary| {
                if x < 0 || x as usize >= size || failed.is_some() {
                    return;
                }
                let i = (y - top) as usize * size + x as usize;
                count[i] += 1;
                failed = questions.ask(i, &face, bary, images).err();
            });
        }
        // The nearest chart point to texels without samples: face, barycentric coordinates, distance.
        let mut nearest: Vec<(u32, f32, u32, Vec3)> = Vec::new();
        for &face in faces {
            let Some(triangle) = Triangle::new(self.atlas.face_texels(face)) else { continue };
            triangle.touched(rows.clone(), |x, y| {
                let i = (y - top) as usize * size + x as usize;
                if x >= 0 && (x as usize) < size && count[i] == 0 {
                    let (distance, bary) = triangle.nearest(x, y);
                    nearest.push((i as u32, distance as f32, face, bary));
                }
            });
        }
        nearest.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
        nearest.dedup_by_key(|n| n.0);
        for &(i, _, face, bary) in &nearest {
            count[i as usize] = 1;
            questions.ask(i as usize, &Face::new(self, face), bary, images)?;
        }
        questions.answer(images)?;
        if let Some(failed) = failed {
            return Err(failed);
        }
        for (i, &count) in count.iter().enumerate().filter(|(_, count)| **count > 1) {
            let part = 1.0 / f32::from(count);
            for (image, (channel, _)) in images.iter_mut().zip(&self.layout.channels) {
                let n = channel.components();
                image[i * n..(i + 1) * n].iter_mut().for_each(|v| *v *= part);
            }
        }
        covered.iter_mut().zip(&count).for_each(|(covered, &count)| *covered = count > 0);
        self.unit_normals(images, covered);
        Ok(questions.asked)
    }

    /// Means of unit vectors are brought back to unit length.
    fn unit_normals(&self, images: &mut [&mut [f32]], covered: &[bool]) {
        let place = self.layout.channels.iter().position(|(c, _)| *c == Channel::Normal);
        let Some(image) = place.and_then(|k| images.get_mut(k)) else { return };
        for (normal, _) in image.chunks_exact_mut(3).zip(covered).filter(|(_, c)| **c) {
            let unit = Vec3::from_slice(normal).normalize_or(Vec3::Z);
            normal.copy_from_slice(&unit.to_array());
        }
    }

    /// The numbers of a texel that a point shows, all channels.
    fn numbers(&self, face: &Face, bary: Vec3, texel: &Texel, out: &mut [f32]) {
        for &(channel, at) in &self.layout.channels {
            match channel {
                Channel::Normal => {
                    let smooth = self.frames.normal(face.index, bary, face.normal);
                    let turned = Frames::turn(face.normal, smooth, texel.normal);
                    let own = smooth.lerp(turned, texel.alpha.clamp(0.0, 1.0)).normalize_or(smooth);
                    let local = self.frames.frame(face.index, bary, smooth).transpose() * own;
                    local.write_to_slice(&mut out[at..]);
                }
                _ => shown(channel, texel, self.options.bare, &mut out[at..]),
            }
        }
    }
}

/// Points asked about at once: few enough to stay small in memory, enough to keep an adapter busy.
const QUESTIONS: usize = 1 << 15;

/// Points that wait for an answer, and the texels they add to.
struct Questions<'a> {
    baker: &'a Baker<'a>,
    points: Vec<(SurfacePoint, f32)>,
    /// For each point its texel and its place in `faces`.
    to: Vec<(u32, u32)>,
    faces: Vec<Face>,
    shown: Vec<Texel>,
    values: Vec<f32>,
    asked: u64,
}

impl<'a> Questions<'a> {
    fn new(baker: &'a Baker<'a>) -> Self {
        let values = vec![0.0; baker.layout.width];
        Self { baker, points: Vec::new(), to: Vec::new(), faces: Vec::new(), shown: Vec::new(), values, asked: 0 }
    }

    /// Asks about a point of a face, for a texel.
    fn ask(&mut self, texel: usize, face: &Face, bary: Vec3, images: &mut [&mut [f32]]) -> Result<(), String> {
        if self.faces.last().is_none_or(|last| last.index != face.index) {
            self.faces.push(*face);
        }
        self.points.push((SurfacePoint { face: face.index, bary }, face.footprint));
        self.to.push((texel as u32, self.faces.len() as u32 - 1));
        if self.points.len() < QUESTIONS { Ok(()) } else { self.answer(images) }
    }

    /// Adds the answers to the texels.
    fn answer(&mut self, images: &mut [&mut [f32]]) -> Result<(), String> {
        self.asked += self.points.len() as u64;
        self.shown.resize(self.points.len(), Texel::empty(Vec3::Z));
        self.baker.texture.texels(&self.points, &mut self.shown)?;
        for ((&(at, _), &(texel, face)), shown) in self.points.iter().zip(&self.to).zip(&self.shown) {
            self.baker.numbers(&self.faces[face as usize], at.bary, shown, &mut self.values);
            for (image, &(channel, first)) in images.iter_mut().zip(&self.baker.layout.channels) {
                let n = channel.components();
                let texel = &mut image[texel as usize * n..][..n];
                texel.iter_mut().zip(&self.values[first..]).for_each(|(sum, value)| *sum += value);
            }
        }
        self.points.clear();
        self.to.clear();
        self.faces.clear();
        Ok(())
    }
}

/// What a texel shows of a channel other than normals, over the bare surface.
fn shown(channel: Channel, texel: &Texel, bare: Vec3, out: &mut [f32]) {
    let cover = texel.alpha.clamp(0.0, 1.0);
    let over = |bare: f32, own: f32| bare + (own - bare) * cover;
    match channel {
        Channel::BaseColor => bare.lerp(texel.base_color, cover).write_to_slice(out),
        Channel::Emissive => (texel.emissive * cover).write_to_slice(out),
        Channel::Normal => texel.normal.write_to_slice(out),
        Channel::Height => out[0] = over(0.5, texel.height),
        Channel::Roughness => out[0] = over(BARE_ROUGHNESS, texel.roughness),
        Channel::Metallic => out[0] = over(0.0, texel.metallic),
        Channel::Occlusion => out[0] = over(1.0, texel.occlusion),
        Channel::Opacity => out[0] = over(1.0, texel.opacity),
    }
}

/// What the samples of a face share.
#[derive(Debug, Clone, Copy)]
struct Face {
    index: u32,
    normal: Vec3,
    /// World width of a sample.
    footprint: f32,
}

impl Face {
    fn new(baker: &Baker<'_>, index: u32) -> Self {
        let world = baker.mesh.area_vector(index);
        let [a, b, c] = baker.atlas.face_texels(index);
        let texels = (b - a).perp_dot(c - a).abs();
        let texel = if texels > 0.0 { (world.length() / texels).sqrt() } else { 0.0 };
        let footprint = (texel / f64::from(baker.options.samples)) as f32;
        Self { index, normal: world.normalize_or_zero().as_vec3(), footprint }
    }
}
