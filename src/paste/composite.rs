//! The pastes composited: what a lapped texture looks like at a surface point (LT 4).
//!
//! The pastes on the point's face are walked from the top down, each weighted by what the ones above let through, until
//! nothing more shows. Pastes of one layer are taken together and let through what the layer's weight leaves. All channels
//! travel together; normals are turned from each paste's own frame into the mesh's space.

use super::contrast::faded;
use super::lapped::{AGREES, FaceLists, LappedTexture, Layer, Paste};
use super::relief::{LEAST_COSINE, met};
use super::stencil::pixel_blur;
use super::turn::Turn;
use crate::exemplar::frames::duration;
use crate::exemplar::{Channel, ChannelSet, Exemplar, FramesBy, TexturePatch, Wrap};
use crate::mesh::{Mesh, SurfacePoint};
use crate::surface::{Sight, SurfaceTexture, Texel};
use glam::{DVec3, Vec2, Vec3};
use std::borrow::Cow;

/// What is left to see through below this cannot change an 8-bit picture.
const NOTHING_LEFT: f32 = 1.0 / 512.0;

/// A paste with a smaller share cannot be seen, even with a dozen like it.
const NOTHING_SHOWN: f32 = NOTHING_LEFT / 16.0;

/// A lapped texture bound to its mesh, ready to be asked.
#[derive(Debug)]
pub struct Composite<'a> {
    mesh: &'a Mesh,
    lapped: &'a LappedTexture,
    lists: FaceLists,
    channels: ChannelSet,
    /// One past the last paste of each layer.
    layer_ends: Vec<u32>,
    /// A paste keeps contrast, or lies over a base, so that sums may leave the range of a channel.
    clipped: bool,
    /// What patches refer to, as it is at the moment that is shown.
    exemplars: Cow<'a, [Exemplar]>,
    /// Depth of relief shown by parallax, in exemplar widths.
    parallax: f32,
}

/// What is left to see through, from the top down.
struct Clear<'a> {
    composite: &'a Composite<'a>,
    at: SurfacePoint,
    /// What the layers above let through.
    above: f32,
    /// What the pastes of this layer let through so far.
    inside: f32,
    /// This layer and its weight here.
    layer: usize,
    weight: f32,
    /// What base colours are multiplied by in this layer.
    gain: Vec3,
}

impl<'a> Clear<'a> {
    fn new(composite: &'a Composite<'a>, at: SurfacePoint) -> Self {
        Self { composite, at, above: 1.0, inside: 1.0, layer: usize::MAX, weight: 1.0, gain: Vec3::ONE }
    }

    /// The share of a point that a paste gets if it is opaque.
    fn share(&mut self, paste: u32) -> f32 {
        let ends = &self.composite.layer_ends;
        if !ends.is_empty() {
            let layer = ends.partition_point(|&end| end <= paste);
            if layer != self.layer {
                self.above = self.rest();
                self.inside = 1.0;
                self.layer = layer;
                let found = self.composite.lapped.layers.get(layer);
                self.weight = found.map_or(1.0, |l| l.weight(self.at));
                self.gain = found.map_or(Vec3::ONE, |l| l.gain(self.at));
            }
        }
        self.above * self.weight * self.inside
    }

    fn take(&mut self, alpha: f32) {
        self.inside *= 1.0 - alpha;
    }

    /// What all of them let through.
    fn rest(&self) -> f32 {
        if self.weight == 1.0 { self.above * self.inside } else { self.above * (1.0 - self.weight * (1.0 - self.inside)) }
    }
}

impl<'a> Composite<'a> {
    /// Sorts the pastes by face.
    #[must_use]
    pub fn new(mesh: &'a Mesh, lapped: &'a LappedTexture) -> Self {
        Self::of_first(mesh, lapped, lapped.pastes.len())
    }

    /// The lowest `count` pastes alone, as if the others had not been laid yet.
    #[must_use]
    pub fn of_first(mesh: &'a Mesh, lapped: &'a LappedTexture, count: usize) -> Self {
        let lists = FaceLists::new(mesh.face_count(), &lapped.pastes[..count.min(lapped.pastes.len())]);
        let channels = lapped.exemplars.iter().fold(ChannelSet::default(), |set, e| set.union(e.channels()));
        let ends = |end: &mut u32, layer: &Layer| {
            *end += layer.pastes;
            Some(*end)
        };
        let layer_ends = lapped.layers.iter().scan(0, ends).collect();
        let clipped =
            lapped.pastes.iter().any(|p| p.agreement != AGREES) || lapped.layers.iter().any(|layer| !layer.base.is_empty());
        Self { mesh, lapped, lists, channels, layer_ends, clipped, exemplars: Cow::Borrowed(&lapped.exemplars), parallax: 0.0 }
    }

    /// Shows the relief of exemplars with a height by parallax, so deep at most, in exemplar widths; 0 shows none.
    #[must_use]
    pub fn with_parallax(mut self, depth: f32) -> Self {
        self.parallax = depth.max(0.0);
        self
    }

    /// Shows exemplars that change with time as they are so many seconds after their first frame.
    #[must_use]
    pub fn with_time(mut self, seconds: f64) -> Self {
        if duration(&self.lapped.exemplars) > 0.0 {
            self.exemplars = self.lapped.exemplars.iter().map(|e| e.at(seconds)).collect();
        }
        self
    }

    /// Shows these exemplars in place of its own, one for each and as large.
    #[must_use]
    pub(super) fn showing(mut self, exemplars: Vec<Exemplar>) -> Self {
        self.exemplars = Cow::Owned(exemplars);
        self
    }

    /// The pastes on each face.
    #[must_use]
    pub const fn lists(&self) -> &FaceLists {
        &self.lists
    }

    /// Alpha of all pastes together at a point, at the finest level.
    #[must_use]
    pub fn alpha(&self, at: SurfacePoint) -> f32 {
        let mut clear = Clear::new(self, at);
        for &(paste, slot) in self.lists.of(at.face).iter().rev() {
            clear.share(paste);
            let paste = &self.lapped.pastes[paste as usize];
            clear.take(faded(paste_alpha(&self.lapped.patches, paste, slot, at.bary), paste.agreement)[0]);
        }
        1.0 - clear.rest()
    }

    /// Adds what one paste shows, its base colour times `gain`; returns its alpha.
    fn add(
        &self,
        texel: &mut Texel,
        (weight, gain): (f32, Vec3),
        (paste, slot): (u32, u32),
        ground: &Ground,
        at: SurfacePoint,
        footprint: f32,
    ) -> f32 {
        let paste = &self.lapped.pastes[paste as usize];
        let patch = &self.lapped.patches[paste.patch as usize];
        let exemplar = &self.exemplars[patch.exemplar as usize];
        let image = PixelMap::new(paste, patch, slot);
        let pixel = image.pixel(at.bary);
        let lod = (footprint * image.pixels_per_unit(ground.area)).max(1.0).log2();
        let [alpha, lift] = faded(patch.mask.sample(pixel, lod).x * cut_alpha(patch, paste, pixel, lod), paste.agreement);
        if alpha <= 0.0 {
            return 0.0;
        }
        let share = weight * alpha;
        let size = Vec2::from(exemplar.size().map(|s| s as f32));
        let wrapped = |place: Vec2| match exemplar.wrap {
            Wrap::Clamp => place,
            Wrap::Repeat => place.rem_euclid(size),
        };
        let mut place = exemplar_pixel(patch, paste, pixel);
        let image = image.turned(paste.turn);
        let relief = exemplar.channel(Channel::Height).filter(|_| self.parallax > 0.0);
        if let (Some(Sight { to_eye, .. }), Some(height)) = (ground.sight, relief) {
            let [right, down] = image.axes(ground);
            let cosine = to_eye.dot(ground.normal).abs().max(LEAST_COSINE);
            let slope = Vec2::new(to_eye.dot(right), to_eye.dot(down)) / cosine;
            place = met(height, place, slope, self.parallax * size.x, lod, wrapped);
        }
        let place = wrapped(place);
        let lifted = |v: Vec3, mean: Vec3| if lift == 1.0 { v } else { mean + lift * (v - mean) };
        let (low, high, part) = ground.frames(exemplar);
        let read_of = |frame: &Exemplar, channel| frame.channel(channel).map(|i| lifted(i.sample(place, lod), i.mean()));
        let read = |channel: Channel| {
            let shown = read_of(low, channel)?;
            Some(if part > 0.0 { shown.lerp(read_of(high, channel)?, part) } else { shown })
        };
        if let Some(v) = read(Channel::BaseColor) {
            texel.base_color += share * gain * v;
        }
        texel.normal += share * read(Channel::Normal).map_or(ground.normal, |n| image.to_mesh(ground, n));
        texel.height += share * read(Channel::Height).map_or(NEUTRAL.height, |v| v.x);
        texel.roughness += share * read(Channel::Roughness).map_or(NEUTRAL.roughness, |v| v.x);
        texel.metallic += share * read(Channel::Metallic).map_or(NEUTRAL.metallic, |v| v.x);
        texel.occlusion += share * read(Channel::Occlusion).map_or(NEUTRAL.occlusion, |v| v.x);
        texel.emissive += share * read(Channel::Emissive).unwrap_or(Vec3::ZERO);
        texel.opacity += share * read(Channel::Opacity).map_or(NEUTRAL.opacity, |v| v.x);
        alpha
    }
}

/// What a paste without a channel contributes to it.
const NEUTRAL: Texel = Texel::empty(Vec3::Z);

/// Pixel of the exemplar under a pixel of the mask, before it is wrapped.
#[inline]
#[must_use]
pub fn exemplar_pixel(patch: &TexturePatch, paste: &Paste, pixel: Vec2) -> Vec2 {
    let unmoved = Vec2::from(patch.origin.map(|o| o as f32)) + paste.offset;
    if paste.turn == Turn::NONE {
        return pixel + unmoved;
    }
    let middle = 0.5 * Vec2::from(patch.mask.size().map(|s| s as f32));
    paste.turn.apply(pixel - middle) + middle + unmoved
}

/// Alpha of one paste at a point of its face number `slot`, at the finest level.
#[inline]
#[must_use]
pub fn paste_alpha(patches: &[TexturePatch], paste: &Paste, slot: u32, bary: Vec3) -> f32 {
    let patch = &patches[paste.patch as usize];
    let [a, b, c] = paste.uv[slot as usize];
    let [w, h] = patch.mask.size();
    let pixel = (a * bary.x + b * bary.y + c * bary.z) * Vec2::new(w as f32, h as f32);
    patch.mask.finest().bilinear(pixel).x * cut_alpha(patch, paste, pixel, 0.0)
}

/// Alpha that a paste's own cut leaves at a pixel of its mask; at coarser levels cuts are softer.
#[inline]
fn cut_alpha(patch: &TexturePatch, paste: &Paste, pixel: Vec2, lod: f32) -> f32 {
    let Some(cut) = &paste.cut else { return 1.0 };
    let step = Vec2::ONE / Vec2::from(patch.mask.size().map(|s| s as f32));
    cut.alpha(pixel * step, pixel_blur(step) * lod.exp2())
}

/// A face in space.
struct Ground {
    /// Edges from the first corner to the second and third.
    edges: [DVec3; 2],
    /// Twice the area.
    area: f64,
    normal: Vec3,
    /// From where it is seen and lit, if that is known.
    sight: Option<Sight>,
}

impl Ground {
    fn new(mesh: &Mesh, face: u32, sight: Option<Sight>) -> Self {
        let [a, b, c] = mesh.corners(face);
        let area = (b - a).cross(c - a);
        Self { edges: [b - a, c - a], area: area.length(), normal: area.normalize_or_zero().as_vec3(), sight }
    }

    /// The two frames of an exemplar that are mixed here, and the share of the second.
    fn frames<'e>(&self, exemplar: &'e Exemplar) -> (&'e Exemplar, &'e Exemplar, f32) {
        let seen = exemplar.frames().zip(self.sight).filter(|(frames, _)| frames.by() != FramesBy::Time);
        let Some((frames, Sight { to_eye, to_light })) = seen else { return (exemplar, exemplar, 0.0) };
        let towards_eye = to_eye.dot(self.normal);
        let cosine = match frames.by() {
            FramesBy::Light => to_light.dot(self.normal) * towards_eye.signum(),
            FramesBy::View | FramesBy::Time => towards_eye.abs(),
        };
        let (low, part) = frames.between(cosine);
        let frame = |k: usize| k.checked_sub(1).map_or(exemplar, |k| &frames.others()[k]);
        (frame(low), frame(low + 1), part)
    }
}

/// How a paste's texture lies on one face: mask pixels of its corners.
struct PixelMap([Vec2; 3]);

impl PixelMap {
    fn new(paste: &Paste, patch: &TexturePatch, slot: u32) -> Self {
        let [w, h] = patch.mask.size();
        Self(paste.uv[slot as usize].map(|uv| uv * Vec2::new(w as f32, h as f32)))
    }

    fn pixel(&self, bary: Vec3) -> Vec2 {
        self.0[0] * bary.x + self.0[1] * bary.y + self.0[2] * bary.z
    }

    /// How the exemplar lies on the face, but for where.
    fn turned(self, turn: Turn) -> Self {
        Self(self.0.map(|corner| turn.apply(corner)))
    }

    /// Mask pixels per world unit, the mean over directions, on a face of twice the area `area`.
    fn pixels_per_unit(&self, area: f64) -> f32 {
        let pixels = (self.0[1] - self.0[0]).perp_dot(self.0[2] - self.0[0]).abs();
        if area > 0.0 { (f64::from(pixels) / area).sqrt() as f32 } else { 0.0 }
    }

    /// Unit vectors along which pixels go right and down on the face.
    fn axes(&self, ground: &Ground) -> [Vec3; 2] {
        let (d1, d2) = ((self.0[1] - self.0[0]).as_dvec2(), (self.0[2] - self.0[0]).as_dvec2());
        // World steps of one pixel right and down: the inverse of the map, up to the (irrelevant) size of its determinant.
        let sign = d1.perp_dot(d2).signum();
        let [e1, e2] = ground.edges;
        let right = (e1 * d2.y - e2 * d1.y) * sign;
        let down = (e2 * d1.x - e1 * d2.x) * sign;
        [right, down].map(|v| v.normalize_or_zero().as_vec3())
    }

    /// A tangent-space normal in the mesh's space.
    fn to_mesh(&self, ground: &Ground, n: Vec3) -> Vec3 {
        let [right, down] = self.axes(ground);
        (right * n.x - down * n.y + ground.normal * n.z).normalize_or(ground.normal)
    }
}

impl SurfaceTexture for Composite<'_> {
    fn channels(&self) -> ChannelSet {
        self.channels
    }

    fn texel(&self, at: SurfacePoint, footprint: f32) -> Texel {
        self.composited(&Ground::new(self.mesh, at.face, None), at, footprint)
    }

    fn texel_seen(&self, at: SurfacePoint, footprint: f32, sight: &Sight) -> Texel {
        self.composited(&Ground::new(self.mesh, at.face, Some(*sight)), at, footprint)
    }
}

impl Composite<'_> {
    fn composited(&self, ground: &Ground, at: SurfacePoint, footprint: f32) -> Texel {
        let normal = ground.normal;
        let mut sum = Texel {
            base_color: Vec3::ZERO,
            alpha: 0.0,
            normal: Vec3::ZERO,
            height: 0.0,
            roughness: 0.0,
            metallic: 0.0,
            occlusion: 0.0,
            emissive: Vec3::ZERO,
            opacity: 0.0,
        };
        let mut clear = Clear::new(self, at);
        for &entry in self.lists.of(at.face).iter().rev() {
            let share = clear.share(entry.0);
            if share >= NOTHING_SHOWN {
                clear.take(self.add(&mut sum, (share, clear.gain), entry, ground, at, footprint));
            }
            if clear.rest() < NOTHING_LEFT {
                break;
            }
        }
        let clear = clear.rest();
        let total = 1.0 - clear;
        if total <= 0.0 {
            return Texel::empty(normal);
        }
        let part = 1.0 / total;
        let one = |sum: f32| if self.clipped { (sum * part).clamp(0.0, 1.0) } else { sum * part };
        let three = |sum: Vec3| if self.clipped { (sum * part).clamp(Vec3::ZERO, Vec3::ONE) } else { sum * part };
        Texel {
            base_color: three(sum.base_color),
            alpha: if clear < NOTHING_LEFT { 1.0 } else { total },
            normal: sum.normal.normalize_or(normal),
            height: one(sum.height),
            roughness: one(sum.roughness),
            metallic: one(sum.metallic),
            occlusion: one(sum.occlusion),
            emissive: three(sum.emissive),
            opacity: one(sum.opacity),
        }
    }
}
