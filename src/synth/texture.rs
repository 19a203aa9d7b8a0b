//! The result: values at the vertices of the re-tiled mesh, as a texture of that surface and of the user's own.

use super::fan::Frame;
use super::levels::Level;
use super::source::Place;
use crate::exemplar::{Channel, ChannelSet, Exemplar, Image, Wrap};
use crate::mesh::nearest::Nearest;
use crate::mesh::transport::turned;
use crate::mesh::{Mesh, SurfacePoint};
use crate::surface::{SurfaceTexture, Texel};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::sync::OnceLock;

/// Softer copies for distant views; each is twice as soft as the one before.
const SOFTER: usize = 3;

/// A re-tiled mesh with the values of every channel at its vertices.
#[derive(Debug)]
pub struct VertexTexture {
    /// The mesh.
    pub mesh: Mesh,
    /// The texture frame at each vertex.
    pub frames: Vec<Frame>,
    /// Distance of two samples, world units.
    pub spacing: f64,
    /// The place of the exemplar that each vertex shows; empty where values have no such place.
    pub places: Vec<Place>,
    channels: Vec<(Channel, Vec<f32>)>,
    softer: OnceLock<Vec<Vec<Vec<f32>>>>,
}

/// A sample by Catmull's and Rom's cubic, within what the pixels around hold. Between vertices values are interpolated once more,
/// and bilinear samples would be blurred twice.
fn sample(image: &Image, wrap: Wrap, at: [f32; 2]) -> Vec3 {
    let [w, h] = image.size().map(i64::from);
    let low = at.map(|a| (a - 0.5).floor());
    let [x, y] = low.map(|l| l as i64);
    let weights = |t: f32| {
        let (t2, t3) = (t * t, t * t * t);
        [-t3 + 2.0 * t2 - t, 3.0 * t3 - 5.0 * t2 + 2.0, -3.0 * t3 + 4.0 * t2 + t, t3 - t2].map(|w| w / 2.0)
    };
    let (across, down) = (weights(at[0] - 0.5 - low[0]), weights(at[1] - 0.5 - low[1]));
    let (mut sum, mut least, mut most) = (Vec3::ZERO, Vec3::INFINITY, Vec3::NEG_INFINITY);
    for (j, v) in (-1..3).zip(down) {
        for (i, u) in (-1..3).zip(across) {
            let pixel = match wrap {
                Wrap::Clamp => image.pixel(x + i, y + j),
                Wrap::Repeat => image.pixel((x + i).rem_euclid(w), (y + j).rem_euclid(h)),
            };
            sum += pixel * (u * v);
            (least, most) = (least.min(pixel), most.max(pixel));
        }
    }
    sum.clamp(least, most)
}

/// All channels of an exemplar at the places that were chosen for the pixels of an image, rows from the top; pixels without a place
/// take the exemplar's first.
#[must_use]
pub fn image_of(size: [u32; 2], exemplar: &Exemplar, places: &[Place]) -> Exemplar {
    let of = |channel: Channel| {
        let image = exemplar.channel(channel)?.finest();
        let value = |x: u32, y: u32| match places.get((y * size[0] + x) as usize) {
            Some(Place::Pixel(at)) => sample(image, exemplar.wrap, *at),
            _ => image.pixel(0, 0),
        };
        Some(match channel.components() {
            1 => Image::grey_from_fn(size[0], size[1], |x, y| value(x, y).x),
            _ => Image::from_fn(size[0], size[1], value),
        })
    };
    let base = of(Channel::BaseColor).unwrap_or_else(|| Image::from_fn(size[0], size[1], |_, _| Vec3::ZERO));
    let mut out = Exemplar::new(exemplar.name.clone(), base);
    for channel in exemplar.channels().iter().filter(|&c| c != Channel::BaseColor) {
        // Size and components are those of the channel itself.
        let _fits = of(channel).map(|image| out.set(channel, image));
    }
    out
}

impl VertexTexture {
    /// All channels of an exemplar at the places that were chosen for the vertices of a level.
    #[must_use]
    pub fn of_exemplar(level: &Level, exemplar: &Exemplar, places: &[Place]) -> Self {
        let of = |channel: Channel| {
            let image = exemplar.channel(channel)?.finest();
            let count = channel.components();
            let mut values = vec![0.0; places.len() * count];
            values.par_chunks_exact_mut(count).zip(places).with_min_len(1024).for_each(|(out, place)| {
                if let Place::Pixel(at) = *place {
                    out.copy_from_slice(&sample(image, exemplar.wrap, at).to_array()[..count]);
                }
            });
            Some((channel, values))
        };
        Self { places: places.to_vec(), ..Self::new(level, exemplar.channels().iter().filter_map(of).collect()) }
    }

    /// The channels of another vertex texture at the places that were chosen.
    #[must_use]
    pub fn of_texture(level: &Level, from: &Self, places: &[Place]) -> Self {
        let of = |(channel, values): &(Channel, Vec<f32>)| {
            let count = channel.components();
            let value = |p: &Place| match *p {
                Place::Vertex(v) => values[v as usize * count..][..count].to_vec(),
                Place::Pixel(_) => vec![0.0; count],
            };
            (*channel, places.iter().flat_map(value).collect())
        };
        Self { places: places.to_vec(), ..Self::new(level, from.channels.iter().map(of).collect()) }
    }

    /// Values at the vertices of a level; channels whose number of values does not fit are left out.
    #[must_use]
    pub fn new(level: &Level, channels: Vec<(Channel, Vec<f32>)>) -> Self {
        let vertices = level.mesh.vertex_count();
        let mut channels = channels;
        channels.retain(|(c, values)| values.len() == vertices * c.components());
        channels.sort_by_key(|(c, _)| *c);
        let (mesh, frames) = (level.mesh.clone(), level.frames.clone());
        Self { mesh, frames, spacing: level.spacing, places: Vec::new(), channels, softer: OnceLock::new() }
    }

    /// The values of a channel, vertex by vertex.
    #[must_use]
    pub fn channel(&self, channel: Channel) -> Option<&[f32]> {
        self.channels.iter().find(|(c, _)| *c == channel).map(|(_, v)| v.as_slice())
    }

    /// All channels and their values.
    #[must_use]
    pub fn all(&self) -> &[(Channel, Vec<f32>)] {
        &self.channels
    }

    /// The mesh with its vertices moved along their normals: height 0 inward, 1 outward by half of `depth` (world units).
    #[must_use]
    pub fn displaced(&self, depth: f64) -> Mesh {
        let mut mesh = self.mesh.clone();
        if let Some(heights) = self.channel(Channel::Height) {
            for ((p, frame), &h) in mesh.positions.iter_mut().zip(&self.frames).zip(heights) {
                *p = (p.as_dvec3() + frame.normal * (f64::from(h) - 0.5) * depth).as_vec3();
            }
        }
        mesh
    }

    /// The softer copies: each vertex and its neighbours averaged, often enough to be as soft as the footprint is wide. By one thread
    /// alone: whoever waits here for others might be given a pixel to draw, and come here again.
    fn softer(&self) -> &[Vec<Vec<f32>>] {
        self.softer.get_or_init(|| {
            let first = self.mesh.vertex_half_edges();
            let around: Vec<Vec<u32>> = first
                .iter()
                .map(|&h| {
                    let ring = if h == crate::mesh::NONE { Vec::new() } else { self.mesh.ring(h).collect() };
                    ring.into_iter().map(|h| self.mesh.origin(crate::mesh::next(h))).collect()
                })
                .collect();
            let soften = |values: &[f32], count: usize| -> Vec<f32> {
                let one = |v: usize| {
                    let mut sum = Vec3::ZERO;
                    let at = |v: usize| Vec3::from_array(std::array::from_fn(|k| values[v * count + k.min(count - 1)]));
                    around[v].iter().for_each(|&w| sum += at(w as usize));
                    (at(v) + sum) / (1 + around[v].len()) as f32
                };
                (0..around.len()).flat_map(|v| one(v).to_array().into_iter().take(count)).collect()
            };
            let mut out: Vec<Vec<Vec<f32>>> = Vec::new();
            for level in 0..SOFTER {
                let rounds = if level == 0 { 1 } else { 3 << (2 * (level - 1)) };
                let next = self.channels.iter().enumerate().map(|(k, (c, finest))| {
                    let mut values = out.last().map_or_else(|| finest.clone(), |l| l[k].clone());
                    (0..rounds).for_each(|_| values = soften(&values, c.components()));
                    values
                });
                let next = next.collect();
                out.push(next);
            }
            out
        })
    }

    /// A channel's value in a face; `lod` 0 is the finest, each whole step twice as soft.
    fn value(&self, index: usize, at: SurfacePoint, lod: f32, corner: impl Fn(u32, Vec3) -> Vec3) -> Vec3 {
        let (channel, finest) = &self.channels[index];
        let count = channel.components();
        let read = |values: &[f32]| {
            let mut sum = Vec3::ZERO;
            for (k, v) in self.mesh.faces[at.face as usize].into_iter().enumerate() {
                let value = Vec3::from_array(std::array::from_fn(|c| values[v as usize * count + c.min(count - 1)]));
                sum += at.bary[k] * corner(v, value);
            }
            sum
        };
        let lod = lod.clamp(0.0, SOFTER as f32);
        let level = |k: usize| if k == 0 { read(finest) } else { read(&self.softer()[k - 1][index]) };
        let (low, part) = (lod.floor() as usize, lod.fract());
        if part == 0.0 { level(low) } else { level(low).lerp(level(low + 1), part) }
    }

    /// The texel at a point, for a surface whose face there has unit normal `face_normal`.
    fn texel_on(&self, at: SurfacePoint, footprint: f32, face_normal: DVec3) -> Texel {
        let lod = (footprint / self.spacing as f32).max(1.0).log2();
        let mut out = Texel { alpha: 1.0, ..Texel::empty(face_normal.as_vec3()) };
        for (index, (channel, _)) in self.channels.iter().enumerate() {
            let plain = |_: u32, v: Vec3| v;
            let value = match channel {
                Channel::Normal => self.value(index, at, lod, |v, n| {
                    let f = &self.frames[v as usize];
                    let n = n.as_dvec3();
                    turned(f.right * n.x + f.up * n.y + f.normal * n.z, f.normal, face_normal).as_vec3()
                }),
                _ => self.value(index, at, lod, plain),
            };
            out.set(*channel, if *channel == Channel::Normal { value.normalize_or(out.normal) } else { value });
        }
        out
    }
}

impl SurfaceTexture for VertexTexture {
    fn channels(&self) -> ChannelSet {
        self.channels.iter().fold(ChannelSet::default(), |set, (c, _)| set.with(*c))
    }

    fn texel(&self, at: SurfacePoint, footprint: f32) -> Texel {
        self.texel_on(at, footprint, self.mesh.normal(at.face))
    }
}

/// A vertex texture seen from the mesh that was re-tiled: each of its points looks at the nearest one of the new mesh.
#[derive(Debug)]
pub struct OnMesh<'a> {
    mesh: &'a Mesh,
    texture: &'a VertexTexture,
    nearest: Nearest<'a>,
}

impl<'a> OnMesh<'a> {
    /// Binds a vertex texture to the mesh it was made for.
    #[must_use]
    pub fn new(mesh: &'a Mesh, texture: &'a VertexTexture) -> Self {
        Self { mesh, texture, nearest: Nearest::new(&texture.mesh) }
    }
}

impl OnMesh<'_> {
    /// The point of the re-tiled mesh that a point of this one looks at.
    #[must_use]
    pub fn there(&self, at: SurfacePoint) -> Option<SurfacePoint> {
        self.nearest.nearest(self.mesh.position(at)).map(|hit| hit.at)
    }
}

impl SurfaceTexture for OnMesh<'_> {
    fn channels(&self) -> ChannelSet {
        self.texture.channels()
    }

    fn texel(&self, at: SurfacePoint, footprint: f32) -> Texel {
        let normal = self.mesh.normal(at.face);
        match self.there(at) {
            Some(there) => self.texture.texel_on(there, footprint, normal),
            None => Texel::empty(normal.as_vec3()),
        }
    }
}
