//! The reference picture of a surface texture on a mesh: every sample shaded on its own, no graphics driver involved.
//!
//! 1. [`Visibility`] finds the face under each sample.
//! 2. At each sample the texture is asked for its texel over the sample's footprint; its normal is turned from the flat
//!    face to the smooth surface, and [`Lighting`] shades it.
//! 3. Where the material is not opaque, what lies behind follows, layer by layer, in exact order.
//! 4. Samples are averaged as displayed light (after the tone curve), so that bright edges are as smooth as dark ones.

use super::RenderError;
use super::camera::Camera;
use super::ground::GroundShadow;
use super::lens::{Grid, Hit, Lens};
use super::normals::{corner_normals, crease_angle};
use super::occlusion::openness;
use super::picture::{Picture, to_byte};
use super::raster::Visibility;
use super::shade::{DIELECTRIC, Lighting, PLAIN, Stand, Surface, tone};
use crate::exemplar::Channel;
use crate::exemplar::srgb;
use crate::mesh::{Mesh, NONE};
use crate::surface::{Sight, SurfaceTexture, Texel};
use glam::{DVec3, Quat, Vec3};
use rayon::prelude::*;
use std::borrow::Cow;
use std::sync::OnceLock;

/// The most layers of a translucent mesh that are looked through.
pub(super) const MAX_LAYERS: usize = 8;
/// Roughness of a texture that does not say: matt with a slight sheen.
const PLAIN_ROUGHNESS: f32 = 0.7;
/// How much of the background's light the ground's shadow takes where no sky is left.
const SHADOW: f32 = 0.75;

/// What is behind the mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Background {
    /// A light grey studio wall, a little darker towards the corners, with the mesh's shadow on the ground.
    Studio,
    /// One colour, linear light.
    Plain(Vec3),
    /// Nothing.
    Transparent,
}

/// How a picture is to look.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DrawOptions {
    /// The light.
    pub lighting: Lighting,
    /// What is behind.
    pub background: Background,
    /// Edges that turn by more than this, in radians, stay sharp; `None` chooses by the mesh ([`crease_angle`]).
    pub crease: Option<f64>,
    /// Colour of the mesh where no texture covers it, linear light.
    pub bare: Vec3,
    /// Whether hollows are darkened by ambient occlusion.
    pub occlusion: bool,
    /// Height of the ground, along the world's up; `None`: where the mesh's lowest point is. Pictures of a mesh that moves
    /// share one.
    pub floor: Option<f64>,
}

impl Default for DrawOptions {
    fn default() -> Self {
        Self {
            lighting: Lighting::studio(),
            background: Background::Studio,
            crease: None,
            bare: Vec3::new(0.42, 0.40, 0.38),
            occlusion: true,
            floor: None,
        }
    }
}

/// A mesh made ready to be drawn from many sides.
#[derive(Debug, Clone)]
pub struct Stage<'a> {
    /// The mesh.
    pub mesh: &'a Mesh,
    /// How pictures of it are to look.
    pub options: DrawOptions,
    normals: Vec<[Vec3; 3]>,
    shadow: OnceLock<GroundShadow>,
}

/// A picture of a texture on a mesh.
///
/// # Errors
/// If the grid has no samples or too many.
pub fn draw(
    mesh: &Mesh,
    texture: &dyn SurfaceTexture,
    camera: &Camera,
    grid: Grid,
    options: &DrawOptions,
) -> Result<Picture, RenderError> {
    let seen = Visibility::new(mesh, camera, grid)?;
    Ok(Stage::new(mesh, options).draw(texture, &seen))
}

impl<'a> Stage<'a> {
    /// Makes a mesh ready.
    #[must_use]
    pub fn new(mesh: &'a Mesh, options: &DrawOptions) -> Self {
        let crease = options.crease.unwrap_or_else(|| crease_angle(mesh));
        Self { mesh, options: *options, normals: corner_normals(mesh, crease), shadow: OnceLock::new() }
    }

    /// A picture of a texture on what is seen of the mesh.
    #[must_use]
    pub fn draw(&self, texture: &dyn SurfaceTexture, seen: &Visibility) -> Picture {
        let (grid, camera) = (seen.grid(), seen.camera());
        let mut behind = Vec::new();
        if texture.channels().has(Channel::Opacity) {
            while behind.len() + 1 < MAX_LAYERS {
                let next = behind.last().unwrap_or(seen).behind(self.mesh);
                if next.is_empty() {
                    break;
                }
                behind.push(next);
            }
        }
        let open = if self.options.occlusion { openness(self.mesh, &self.normals, seen) } else { Vec::new() };
        let frame = Frame {
            stage: self,
            texture,
            lens: Lens::new(camera, grid),
            grid,
            shadow: (self.options.background == Background::Studio).then(|| self.shadow(camera.world_up)),
            stand: Stand {
                right: camera.right.as_vec3(),
                up: camera.up.as_vec3(),
                back: -camera.forward.as_vec3(),
                world_up: camera.world_up.as_vec3(),
            },
            open,
        };
        let width = grid.width as usize;
        let mut picture = Picture::filled(grid.width, grid.height, [0; 4]);
        picture.rgba.par_chunks_mut(4 * width).enumerate().for_each(|(y, row)| {
            for (x, out) in row.as_chunks_mut::<4>().0.iter_mut().enumerate() {
                *out = frame.pixel(seen, &behind, x, y);
            }
        });
        picture
    }

    /// Smooth unit normals at the corners of each face.
    #[must_use]
    pub fn normals(&self) -> &[[Vec3; 3]] {
        &self.normals
    }

    /// The shadow on the ground; kept from picture to picture while up stays the same.
    pub(super) fn shadow(&self, up: DVec3) -> Cow<'_, GroundShadow> {
        let made = || GroundShadow::new(self.mesh, up, self.options.floor);
        let kept = match self.shadow.get() {
            Some(kept) => kept,
            // Made before the lock is taken: a thread that waits for its part of the work may be given another picture of this stage.
            None => {
                let made = made();
                self.shadow.get_or_init(|| made)
            }
        };
        if kept.up() == up { Cow::Borrowed(kept) } else { Cow::Owned(made()) }
    }
}

/// All that the pixels of one picture share.
struct Frame<'a> {
    stage: &'a Stage<'a>,
    texture: &'a dyn SurfaceTexture,
    lens: Lens<'a>,
    grid: Grid,
    stand: Stand,
    shadow: Option<Cow<'a, GroundShadow>>,
    open: Vec<f32>,
}

impl Frame<'_> {
    fn pixel(&self, seen: &Visibility, behind: &[Visibility], x: usize, y: usize) -> [u8; 4] {
        let n = self.grid.samples as usize;
        let open = self.open.get(y * self.grid.width as usize + x).copied().unwrap_or(1.0);
        // Colour times coverage, and what still comes through from the background.
        let (mut colour, mut through) = (Vec3::ZERO, 0.0);
        for v in y * n..(y + 1) * n {
            for u in x * n..(x + 1) * n {
                let mut left = 1.0;
                for (depth, layer) in std::iter::once(seen).chain(behind).enumerate() {
                    let face = layer.face(u, v);
                    if face == NONE || left < 1e-3 {
                        break;
                    }
                    let hit = self.lens.hit(self.stage.mesh, face, [u as f64 + 0.5, v as f64 + 0.5]);
                    let (light, opacity) = self.light(&hit, if depth == 0 { open } else { 1.0 });
                    colour += tone(light) * (left * opacity);
                    left *= 1.0 - opacity;
                }
                through += left;
            }
        }
        let count = (n * n) as f32;
        let (colour, through) = (colour / count, through / count);
        let (background, alpha) = if through > 0.0 { self.background(x, y) } else { (Vec3::ZERO, 0.0) };
        let total = 1.0 - through * (1.0 - alpha);
        if total <= 0.0 {
            return [0; 4];
        }
        let mixed = (colour + background * (through * alpha)) / total;
        // A step of eight bits is seen on the wall; half a step up or down, in a pattern, is not.
        let shift = through * alpha * dither(x, y) / 255.0;
        let [r, g, b] = mixed.to_array().map(|c| to_byte(srgb::encode(c) + shift));
        [r, g, b, to_byte(total)]
    }

    fn sight(&self, hit: &Hit) -> Sight {
        Sight { to_eye: hit.to_eye.as_vec3(), to_light: self.stage.options.lighting.key(&self.stand) }
    }

    /// Light from a hit towards the eye, and how opaque it is there.
    fn light(&self, hit: &Hit, open: f32) -> (Vec3, f32) {
        let options = &self.stage.options;
        let texel = self.texture.texel_seen(hit.at, hit.footprint as f32, &self.sight(hit));
        let channels = self.texture.channels();
        let cover = texel.alpha.clamp(0.0, 1.0);
        let opacity = if channels.has(Channel::Opacity) { 1.0 - cover * (1.0 - texel.opacity.clamp(0.0, 1.0)) } else { 1.0 };
        let mix = |bare: f32, own: f32| bare + (own - bare) * cover;
        let known = |channel, value, otherwise| if channels.has(channel) { value } else { otherwise };
        let roughness = known(Channel::Roughness, texel.roughness, PLAIN_ROUGHNESS);
        let occlusion = known(Channel::Occlusion, texel.occlusion, 1.0);
        let (smooth, normal) = self.normals(hit, &texel, channels.has(Channel::Normal), cover);
        let described = channels.has(Channel::Roughness) || channels.has(Channel::Metallic);
        let surface = Surface {
            base_color: options.bare.lerp(texel.base_color, cover),
            roughness: mix(PLAIN_ROUGHNESS, roughness).clamp(0.0, 1.0),
            metallic: mix(0.0, known(Channel::Metallic, texel.metallic, 0.0)).clamp(0.0, 1.0),
            reflectance: if described { DIELECTRIC } else { PLAIN },
            occlusion: open * mix(1.0, occlusion).clamp(0.0, 1.0),
            normal,
            smooth,
            to_eye: hit.to_eye.as_vec3(),
        };
        let light = options.lighting.shade(&surface, &self.stand);
        let emitted = if channels.has(Channel::Emissive) { texel.emissive * cover } else { Vec3::ZERO };
        (light + emitted, opacity)
    }

    /// The smooth normal on the viewer's side, and the same with the texture's own relief.
    fn normals(&self, hit: &Hit, texel: &Texel, relief: bool, cover: f32) -> (Vec3, Vec3) {
        let flat = self.stage.mesh.normal(hit.at.face).as_vec3();
        let corner = self.stage.normals[hit.at.face as usize];
        let bary = hit.at.bary;
        let smooth = (corner[0] * bary.x + corner[1] * bary.y + corner[2] * bary.z).normalize_or(flat);
        let own = if relief && cover > 0.0 && flat != Vec3::ZERO {
            let turned = Quat::from_rotation_arc(flat, smooth) * texel.normal;
            smooth.lerp(turned, cover).normalize_or(smooth)
        } else {
            smooth
        };
        if hit.front { (smooth, own) } else { (-smooth, -own) }
    }

    /// Displayed light and opacity of what is behind the mesh at a pixel.
    fn background(&self, x: usize, y: usize) -> (Vec3, f32) {
        match self.stage.options.background {
            Background::Transparent => (Vec3::ZERO, 0.0),
            Background::Plain(colour) => (colour, 1.0),
            Background::Studio => {
                let middle = |v: usize| (v as f64 + 0.5) * f64::from(self.grid.samples);
                let (start, direction) = self.lens.ray([middle(x), middle(y)]);
                let hidden = self.shadow.as_ref().map_or(0.0, |shadow| shadow.along(start, direction));
                (wall(x, y, self.grid) * (1.0 - SHADOW * hidden), 1.0)
            }
        }
    }
}

/// The 8x8 pattern of ordered dithering, -1/2 to 1/2: its 64 values are each taken once, neighbours far apart.
fn dither(x: usize, y: usize) -> f32 {
    let bit = |i: usize| (((x ^ y) >> i & 1) << (5 - 2 * i)) | ((y >> i & 1) << (4 - 2 * i));
    ((bit(0) | bit(1) | bit(2)) as f32 + 0.5) / 64.0 - 0.5
}

/// The studio's wall: brightest a little above the middle.
fn wall(x: usize, y: usize, grid: Grid) -> Vec3 {
    /// Linear light in the middle and in the corners.
    const MIDDLE: Vec3 = Vec3::new(0.80, 0.80, 0.81);
    const CORNER: Vec3 = Vec3::new(0.50, 0.505, 0.52);
    let place = DVec3::new((x as f64 + 0.5) / f64::from(grid.width) - 0.5, (y as f64 + 0.5) / f64::from(grid.height) - 0.42, 0.0);
    let t = (place.length_squared() / 0.55).min(1.0) as f32;
    MIDDLE.lerp(CORNER, t)
}
