//! Growing the surface patch of a paste (LT 3.3).
//!
//! Based on: Praun, Finkelstein, Hoppe 2000, sections 3.2 (propagated directions) and 3.3; the similar-triangle
//! prediction of new vertices from Maillot, Yahia, Verroust 1993.
//!
//! 1. The seed point goes to the texture patch's centre, the seed face's (S, T) to the texture's axes.
//! 2. Faces join in the order of their distance from the centre in texture space, as long as the patch stays a disc
//!    ([`crate::mesh::disc`]), the edge they join over crosses the interior of the hull, and they are neither flipped
//!    nor stretched beyond a bound against the field. An edge where growth stops for one of the last reasons is a *hard
//!    edge*: the texture ends there without falling off.
//! 3. For isotropic textures the direction of a face is the mean of its neighbours' in the patch, projected; where a field has n
//!    ways it is that of them which is nearest to this mean, so that no line is left over which the choice jumps.
//!
//! Where we differ: a new vertex is placed by the field, not by a triangle similar to its face. Similar triangles
//! extrapolate what the last face did; on fine meshes the errors compound, fingers run far out and a patch takes several
//! times the faces it needs. [`Predictor::SimilarTriangles`] keeps the paper's way. And no new vertex may lie
//! further from the centre in space than the hull could reach (`REACH`).

use super::frame::Frame;
use crate::exemplar::{Hull, TexturePatch};
use crate::field::Guide;
use crate::mesh::disc::{Disc, Grower, Joining, Rule};
use crate::mesh::{Mesh, NONE, SurfacePoint, next, prev};
use glam::{DMat2, DVec2, DVec3};
use std::f64::consts::TAU;

/// A new vertex may be this many hull radii (in world units, by the local scale) from the seed point, plus the length of
/// the edge it joins over. A straight line is never longer than the way over the surface, so honest patches are not cut;
/// 1.2 leaves room for the stretch that the distortion bound allows.
const REACH: f64 = 1.2;

/// How a new vertex is placed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Predictor {
    /// By the tangent field, from the ends of the edge joined over.
    #[default]
    Field,
    /// By triangles similar to the faces around it (the paper's, after Maillot et al.).
    SimilarTriangles,
}

/// Why growth stopped at open edges inside the hull.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize)]
pub struct Stops {
    /// The patch would have ended to be a disc.
    pub disc: usize,
    /// The face would have been mirrored.
    pub flip: usize,
    /// The face would have been stretched beyond the bound.
    pub stretch: usize,
    /// The face would have reached beyond what the hull can cover.
    pub reach: usize,
}

/// What stays the same over all growth of a paste.
#[derive(Debug, Clone, Copy)]
pub struct Site<'a> {
    /// The surface.
    pub mesh: &'a Mesh,
    /// Field or scale.
    pub guide: &'a Guide,
    /// The texture patch to cover.
    pub plan: &'a PatchPlan,
    /// Where its centre goes.
    pub seed: SurfacePoint,
    /// Largest allowed Frobenius norm of (image of (S, T) - identity).
    pub distortion: f64,
    /// How new vertices are placed.
    pub predictor: Predictor,
    /// The guide's direction holds at the seed alone, and is propagated from there as where the guide has none.
    pub free: bool,
}

impl Site<'_> {
    /// True if directions are propagated from the seed.
    #[must_use]
    pub const fn propagates(&self) -> bool {
        self.free || matches!(self.guide, Guide::Isotropic { .. })
    }
}

/// A texture patch's hull in texture space: exemplar widths, t up, the centre at the origin.
#[derive(Debug, Clone)]
pub struct PatchPlan {
    /// The hull.
    pub hull: Hull,
    /// Largest distance of the hull from the centre.
    pub radius: f64,
    centre: DVec2,
    width: f64,
    origin: DVec2,
    size: DVec2,
}

impl PatchPlan {
    /// The plan of a texture patch of an exemplar `width` pixels wide.
    #[must_use]
    pub fn new(patch: &TexturePatch, width: u32) -> Self {
        let [w, h] = patch.mask.size();
        let (centre, width) = (patch.centre.as_dvec2(), f64::from(width));
        let radius = patch.hull.points().iter().map(|p| p.as_dvec2().distance(centre) / width).fold(0.0, f64::max);
        Self {
            hull: patch.hull.clone(),
            radius,
            centre,
            width,
            origin: DVec2::new(f64::from(patch.origin[0]), f64::from(patch.origin[1])),
            size: DVec2::new(f64::from(w), f64::from(h)),
        }
    }

    /// Pixels of the exemplar in one exemplar width.
    #[must_use]
    pub const fn pixels_per_width(&self) -> f64 {
        self.width
    }

    /// Pixel of the exemplar at a texture point.
    #[inline]
    #[must_use]
    pub fn pixel(&self, q: DVec2) -> DVec2 {
        self.centre + self.width * DVec2::new(q.x, -q.y)
    }

    /// Pixel of the patch's mask at a texture point.
    #[inline]
    #[must_use]
    pub fn mask_pixel(&self, q: DVec2) -> DVec2 {
        self.pixel(q) - self.origin
    }

    /// Coordinates over the patch's mask at a texture point, [0, 1] inside.
    #[inline]
    #[must_use]
    pub fn mask_uv(&self, q: DVec2) -> DVec2 {
        self.mask_pixel(q) / self.size
    }
}

/// The rule of growth for one paste; also keeps the frames of the disc's faces, in their order.
#[derive(Debug)]
pub struct PasteRule<'a> {
    site: Site<'a>,
    /// Faces smaller than this share of the hull's radius are judged together with their neighbours.
    even_out: f64,
    centre: DVec3,
    frames: Vec<Frame>,
    /// Images of the frames, each evened out with those of the faces it joined.
    images: Vec<DMat2>,
    /// The faces of the disc that each face joined.
    beside: Vec<[u32; 3]>,
    pending: Option<(Frame, DMat2)>,
    evened: bool,
}

impl<'a> PasteRule<'a> {
    /// Begins a patch: the rule and the seed face's corners in texture space. `angle` turns the texture where the guide
    /// leaves that open; faces smaller than `even_out` hull radii are judged together with their neighbours. `None` if the seed face has no usable basis.
    #[must_use]
    pub fn new(site: Site<'a>, even_out: f64, angle: f64) -> Option<(Self, [DVec2; 3])> {
        let face = site.seed.face;
        let frame = match site.guide {
            Guide::Directed(field) => Frame::of(site.mesh, field, face)?,
            Guide::Isotropic { scale } => {
                let normal = site.mesh.normal(face);
                let [a, b, _] = site.mesh.corners(face);
                let along = (b - a).normalize_or_zero();
                let up = along * angle.cos() + normal.cross(along) * angle.sin();
                Frame::from_up(up * f64::from(scale[face as usize]), normal)?
            }
        };
        let centre = site.mesh.position(site.seed);
        let uv = site.mesh.corners(face).map(|p| frame.texture_step(p - centre));
        let new = Self {
            site,
            even_out,
            centre,
            frames: vec![frame],
            images: vec![DMat2::IDENTITY],
            beside: vec![[NONE; 3]],
            pending: None,
            evened: false,
        };
        Some((new, uv))
    }

    /// The frames of the disc's faces, in their order.
    #[must_use]
    pub fn frames(&self) -> &[Frame] {
        &self.frames
    }

    /// Hands the frames out.
    #[must_use]
    pub fn into_frames(self) -> Vec<Frame> {
        self.frames
    }

    /// True if a face was judged together with its neighbours.
    #[must_use]
    pub const fn evened(&self) -> bool {
        self.evened
    }

    /// The frame of a face beside the disc.
    fn frame(&self, joining: &Joining) -> Option<Frame> {
        match self.site.guide {
            guide if self.site.propagates() => {
                let normal = self.site.mesh.normal(joining.face);
                let up = self.continued(joining, normal).normalize_or_zero();
                Frame::from_up(up * f64::from(guide.scale(joining.face)), normal)
            }
            Guide::Directed(field) if field.ways > 1 => {
                let normal = self.site.mesh.normal(joining.face);
                let (right, up) = field.basis(self.site.mesh, joining.face);
                let part = TAU / f64::from(field.ways);
                let wanted = self.continued(joining, normal);
                let turn = part * (normal.dot(up.cross(wanted)).atan2(up.dot(wanted)) / part).round();
                let turned = |v: DVec3| v * turn.cos() + normal.cross(v) * turn.sin();
                Frame::new(turned(right), turned(up), normal)
            }
            Guide::Directed(field) => Frame::of(self.site.mesh, field, joining.face),
            Guide::Isotropic { .. } => None,
        }
    }

    /// The mean of the neighbours' directions in the plane of a face.
    fn continued(&self, joining: &Joining, normal: DVec3) -> DVec3 {
        let beside = joining.across.iter().filter(|&&i| i != NONE).map(|&i| self.frames[i as usize].up);
        let mean = beside.map(DVec3::normalize_or_zero).sum::<DVec3>();
        mean - normal * mean.dot(normal)
    }

    fn predict(&self, grower: &Grower, joining: &Joining, corner: usize, frame: &Frame) -> DVec2 {
        let mesh = self.site.mesh;
        match self.site.predictor {
            Predictor::Field => {
                let p = mesh.corners(joining.face);
                let from = |k: usize| grower.disc().uv[joining.corners[k] as usize] + frame.texture_step(p[corner] - p[k]);
                0.5 * (from((corner + 1) % 3) + from((corner + 2) % 3))
            }
            Predictor::SimilarTriangles => similar_triangles(mesh, grower, 3 * joining.face + corner as u32),
        }
    }

    /// How much a face's own image counts against its neighbours'.
    fn own_share(&self, frame: &Frame, p: &[DVec3; 3]) -> f64 {
        let over = self.even_out * self.site.plan.radius;
        let size = frame.texture_step(p[1] - p[0]).perp_dot(frame.texture_step(p[2] - p[0])).abs().sqrt();
        if size < over { size / over } else { 1.0 }
    }

    /// The image of a face's frame, evened out with those of the disc faces beside it over `even_out`.
    fn even_image(&self, frame: &Frame, p: &[DVec3; 3], uv: &[DVec2; 3], beside: &[u32; 3]) -> Option<DMat2> {
        let image = frame.image(p, uv)?;
        let (mut sum, mut count) = (DMat2::ZERO, 0.0);
        for &i in beside.iter().filter(|&&i| i != NONE) {
            sum += self.images[i as usize];
            count += 1.0;
        }
        if count == 0.0 {
            return Some(image);
        }
        let own = self.own_share(frame, p);
        Some(sum * ((1.0 - own) / count) + image * own)
    }

    /// The disc's coordinates have changed: looks at its faces again.
    pub fn moved(&mut self, disc: &Disc) {
        for i in 0..disc.faces.len() {
            let p = self.site.mesh.corners(disc.faces[i]);
            if let Some(image) = self.even_image(&self.frames[i], &p, &disc.face_uv(i), &self.beside[i]) {
                self.images[i] = image;
            }
        }
    }

    /// Places a face and tests it: its frame, that frame's image and its new vertex's position, or the reason to keep it
    /// out.
    fn weigh(&self, grower: &Grower, joining: &Joining) -> Result<(Frame, DMat2, DVec2), Refusal> {
        let mesh = self.site.mesh;
        let frame = self.frame(joining).ok_or(Refusal::Stretch)?;
        let p = mesh.corners(joining.face);
        let mut new_uv = DVec2::ZERO;
        if let Some(k) = joining.new_corner {
            let scale = frame.up.length().max(self.frames[0].up.length());
            let edge = p[(k + 1) % 3].distance(p[(k + 2) % 3]);
            if p[k].distance(self.centre) > REACH * self.site.plan.radius * scale + edge {
                return Err(Refusal::Reach);
            }
            new_uv = self.predict(grower, joining, k, &frame);
        }
        let uv =
            [0, 1, 2].map(|k| if joining.new_corner == Some(k) { new_uv } else { grower.disc().uv[joining.corners[k] as usize] });
        let image = self.even_image(&frame, &p, &uv, &joining.across).ok_or(Refusal::Stretch)?;
        if image.determinant() <= 0.0 {
            return Err(Refusal::Flip);
        }
        let off = image - DMat2::IDENTITY;
        let norm = (off.x_axis.length_squared() + off.y_axis.length_squared()).sqrt();
        if norm > self.site.distortion { Err(Refusal::Stretch) } else { Ok((frame, image, new_uv)) }
    }

    /// Counts, for the edges where growth ended inside the hull, why it did.
    #[must_use]
    pub fn stops(&mut self, grower: &Grower) -> Stops {
        let mut stops = Stops::default();
        let border: Vec<(usize, usize)> = grower.open_border().collect();
        for (index, edge) in border {
            let corners = grower.disc().corners[index];
            if self.distance(grower.disc(), corners[edge], corners[(edge + 1) % 3]).is_none() {
                continue;
            }
            let reason = match grower.joining_over(index, edge) {
                None => &mut stops.disc,
                Some(joining) => match self.weigh(grower, &joining) {
                    Err(Refusal::Flip) => &mut stops.flip,
                    Err(Refusal::Reach) => &mut stops.reach,
                    Err(Refusal::Stretch) | Ok(_) => &mut stops.stretch,
                },
            };
            *reason += 1;
        }
        stops
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Refusal {
    Flip,
    Stretch,
    Reach,
}

impl Rule for PasteRule<'_> {
    fn distance(&mut self, disc: &Disc, a: u32, b: u32) -> Option<f64> {
        let (a, b) = (disc.uv[a as usize], disc.uv[b as usize]);
        let crosses = self.site.plan.hull.crosses_interior(self.site.plan.pixel(a).as_vec2(), self.site.plan.pixel(b).as_vec2());
        crosses.then(|| (0.5 * (a + b)).length())
    }

    fn admit(&mut self, grower: &Grower, joining: &Joining) -> Option<DVec2> {
        let (frame, image, uv) = self.weigh(grower, joining).ok()?;
        self.pending = Some((frame, image));
        Some(uv)
    }

    fn joined(&mut self, _disc: &Disc, joining: &Joining) {
        if let Some((frame, image)) = self.pending.take() {
            let p = self.site.mesh.corners(joining.face);
            self.evened |= self.own_share(&frame, &p) < 1.0;
            self.frames.push(frame);
            self.images.push(image);
            self.beside.push(joining.across);
        }
    }
}

/// The mean, over all faces around the vertex at corner half-edge `h` whose other two corners are placed, of where a
/// triangle similar to the face would put it.
fn similar_triangles(mesh: &Mesh, grower: &Grower, h: u32) -> DVec2 {
    let (mut sum, mut count) = (DVec2::ZERO, 0);
    let mut add = |h: u32| {
        let (a, b) = (mesh.origin(next(h)), mesh.origin(prev(h)));
        let (ia, ib) = (grower.vertex_index(a), grower.vertex_index(b));
        if ia == NONE || ib == NONE {
            return;
        }
        let (pa, pb, p) = (mesh.point(a), mesh.point(b), mesh.point(mesh.origin(h)));
        let edge = pb - pa;
        let along = edge.dot(p - pa) / edge.length_squared();
        let across = edge.cross(p - pa).length() / edge.length_squared();
        let (qa, qb) = (grower.disc().uv[ia as usize], grower.disc().uv[ib as usize]);
        sum += qa + along * (qb - qa) + across * (qb - qa).perp();
        count += 1;
    };
    // Counter-clockwise to home or to a boundary, then clockwise from the start.
    let mut at = h;
    loop {
        add(at);
        at = mesh.opposite[prev(at) as usize];
        if at == h || at == NONE {
            break;
        }
    }
    if at == NONE {
        let mut back = mesh.opposite[h as usize];
        while back != NONE {
            add(next(back));
            back = mesh.opposite[next(back) as usize];
        }
    }
    sum / f64::from(count.max(1))
}
