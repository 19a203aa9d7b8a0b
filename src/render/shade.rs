//! How light meets the surface: a studio of three soft lamps that stand around the camera, and a sky above a ground.
//!
//! Based on: B. Walter et al., "Microfacet models for refraction through rough surfaces", EGSR 2007 (the GGX
//! distribution); E. Heitz, "Understanding the masking-shadowing function in microfacet-based BRDFs", JCGT 2014
//! (height-correlated masking); C. Schlick, "An inexpensive BRDF model for physically-based rendering", 1994 (Fresnel).
//!
//! The studio serves textures: lamps and sky are balanced so that a grey surface that faces the camera shows just its own
//! grey, and the tone curve leaves everything up to [`SHOULDER`] as it is. Lamps are soft: they reach a little around the
//! edge of the light, and their highlights are no sharper than a lamp of that size would leave.

use glam::Vec3;

/// Linear light up to this is shown as it is; brighter light approaches 1 smoothly.
pub const SHOULDER: f32 = 0.72;

/// How far a lamp reaches around the terminator, as a share of its light.
const WRAP: f32 = 0.22;
/// What a lamp's size adds to the roughness parameter of its highlight.
const LAMP_SIZE: f32 = 0.08;
/// Reflectance of common non-metals at normal incidence.
pub const DIELECTRIC: f32 = 0.04;
/// The same for surfaces whose gloss nobody described: their colour counts most.
pub const PLAIN: f32 = 0.012;
/// Share of a lamp that still reaches a fully occluded crevice.
const LAMP_IN_CREVICE: f32 = 0.55;

/// A soft lamp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lamp {
    /// Unit vector towards it, in the camera's frame: x right, y up, z towards the viewer.
    pub towards: Vec3,
    /// Light it brings to a surface that faces it: 1 shows a white surface white.
    pub light: Vec3,
}

/// All the light there is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lighting {
    /// Lamps that move with the camera.
    pub lamps: [Lamp; 3],
    /// Light from straight above in the world.
    pub sky: Vec3,
    /// Light from straight below.
    pub ground: Vec3,
}

/// What is to be lit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surface {
    /// Base colour, linear.
    pub base_color: Vec3,
    /// Roughness, 0 to 1.
    pub roughness: f32,
    /// Metallic, 0 to 1.
    pub metallic: f32,
    /// Reflectance of the part that is no metal at normal incidence: [`DIELECTRIC`] or [`PLAIN`].
    pub reflectance: f32,
    /// How open the point is to light from all around, 0 to 1.
    pub occlusion: f32,
    /// Unit normal with the texture's relief, world space, on the viewer's side.
    pub normal: Vec3,
    /// Unit normal without relief: nothing is mirrored from below it.
    pub smooth: Vec3,
    /// Unit vector to the eye, world space.
    pub to_eye: Vec3,
}

/// The camera's axes and the world's up: where lamps and sky stand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stand {
    /// Towards the picture's right.
    pub right: Vec3,
    /// Towards its top.
    pub up: Vec3,
    /// Towards the viewer.
    pub back: Vec3,
    /// Up in the world.
    pub world_up: Vec3,
}

impl Default for Lighting {
    fn default() -> Self {
        Self::studio()
    }
}

impl Lighting {
    /// A warm key from the upper left, a cool fill from the right, a rim from behind, under an overcast sky.
    #[must_use]
    pub fn studio() -> Self {
        let lamp = |towards: Vec3, light: Vec3| Lamp { towards: towards.normalize(), light };
        Self {
            lamps: [
                lamp(Vec3::new(-0.55, 0.65, 0.75), Vec3::new(0.84, 0.82, 0.79)),
                lamp(Vec3::new(0.85, 0.05, 0.55), Vec3::new(0.15, 0.16, 0.175)),
                lamp(Vec3::new(0.45, 0.55, -0.75), Vec3::new(0.42, 0.43, 0.45)),
            ],
            sky: Vec3::new(0.44, 0.455, 0.48),
            ground: Vec3::new(0.20, 0.19, 0.18),
        }
        .balanced()
    }

    /// Even light with little modelling, for pictures whose colours carry figures.
    #[must_use]
    pub fn even() -> Self {
        let mut even = Self::studio();
        even.lamps[0].light *= 0.55;
        even.lamps[2].light *= 0.3;
        even.sky = Vec3::splat(0.62);
        even.ground = Vec3::splat(0.42);
        even.balanced()
    }

    /// The same light from every direction and no lamps: the white furnace.
    #[must_use]
    pub fn furnace() -> Self {
        let dark = Lamp { towards: Vec3::Z, light: Vec3::ZERO };
        Self { lamps: [dark; 3], sky: Vec3::ONE, ground: Vec3::ONE }
    }

    /// Unit vector to the main lamp, world space.
    #[must_use]
    pub fn key(&self, stand: &Stand) -> Vec3 {
        stand.turn(self.lamps[0].towards)
    }

    /// Scaled channel by channel so that a white surface that faces a level camera receives light 1.
    fn balanced(mut self) -> Self {
        let level = Stand { right: Vec3::X, up: Vec3::Y, back: Vec3::Z, world_up: Vec3::Y };
        let gain = self.diffuse(Vec3::Z, &level, 1.0).recip();
        for lamp in &mut self.lamps {
            lamp.light *= gain;
        }
        self.sky *= gain;
        self.ground *= gain;
        self
    }

    /// Light that arrives at a surface from all around.
    fn diffuse(&self, normal: Vec3, stand: &Stand, occlusion: f32) -> Vec3 {
        let from_lamps: Vec3 = self.lamps.iter().map(|lamp| lamp.light * wrapped(normal.dot(stand.turn(lamp.towards)))).sum();
        from_lamps * lamp_share(occlusion) + self.ambient(normal.dot(stand.world_up), 1.0) * occlusion
    }

    /// Light from around a direction that rises by `rise` (the sine of its height), spread by `roughness`.
    fn ambient(&self, rise: f32, roughness: f32) -> Vec3 {
        // A sharp reflection sees a horizon; a matt one the mean over half the sphere, which is linear in the rise.
        let width = 0.25 + 0.75 * roughness;
        let t = 0.5 + 0.5 * (rise / width).clamp(-1.0, 1.0);
        self.ground.lerp(self.sky, t)
    }

    /// Linear light towards the eye, emission apart, before the tone curve.
    #[must_use]
    pub fn shade(&self, surface: &Surface, stand: &Stand) -> Vec3 {
        let Surface { base_color, roughness, metallic, reflectance, occlusion, normal, smooth, to_eye } = *surface;
        let facing = normal.dot(to_eye).clamp(1e-3, 1.0);
        let grazing = (1.0 - facing).powi(5);
        let mirrored_by = |at_normal: Vec3| at_normal + (Vec3::splat(1.0 - roughness).max(at_normal) - at_normal) * grazing;
        let at_normal = Vec3::splat(reflectance).lerp(base_color, metallic);
        let glaze = mirrored_by(Vec3::splat(reflectance));
        let mirrored = glaze.lerp(mirrored_by(base_color), metallic);

        // What is mirrored is not scattered; metals scatter nothing.
        let mut light = base_color * (1.0 - metallic) * (Vec3::ONE - glaze) * self.diffuse(normal, stand, occlusion);

        let reflected = 2.0 * normal.dot(to_eye) * normal - to_eye;
        // Relief that leans away from the eye mirrors the surface itself.
        let above = (1.0 + reflected.dot(smooth)).clamp(0.0, 1.0);
        light += mirrored * self.ambient(reflected.dot(stand.world_up), roughness) * (occlusion * above * above);

        let alpha = (roughness * roughness + LAMP_SIZE).min(1.0);
        for lamp in &self.lamps {
            let towards = stand.turn(lamp.towards);
            let lit = normal.dot(towards);
            if lit > 0.0 && smooth.dot(towards) > 0.0 {
                let half = (towards + to_eye).normalize_or_zero();
                let fresnel = at_normal + (Vec3::ONE - at_normal) * (1.0 - half.dot(to_eye).clamp(0.0, 1.0)).powi(5);
                // A lamp's light is its irradiance over pi.
                let strength = std::f32::consts::PI * highlight(alpha, normal.dot(half), lit, facing) * lit;
                light += fresnel * lamp.light * strength * lamp_share(occlusion);
            }
        }
        light
    }
}

impl Stand {
    /// From the camera's frame to the world.
    fn turn(&self, v: Vec3) -> Vec3 {
        self.right * v.x + self.up * v.y + self.back * v.z
    }
}

fn wrapped(cosine: f32) -> f32 {
    ((cosine + WRAP) / (1.0 + WRAP)).max(0.0)
}

fn lamp_share(occlusion: f32) -> f32 {
    LAMP_IN_CREVICE + (1.0 - LAMP_IN_CREVICE) * occlusion
}

/// The GGX distribution times height-correlated masking over `4 (n.l) (n.v)`.
fn highlight(alpha: f32, half: f32, lit: f32, facing: f32) -> f32 {
    let a2 = alpha * alpha;
    let d = half * half * (a2 - 1.0) + 1.0;
    let distribution = a2 / (std::f32::consts::PI * d * d);
    let masking = lit * (facing * facing * (1.0 - a2) + a2).sqrt() + facing * (lit * lit * (1.0 - a2) + a2).sqrt();
    distribution * 0.5 / masking.max(1e-6)
}

/// The tone curve: the identity up to [`SHOULDER`], then towards 1. The hue stays, since all channels share one factor.
#[must_use]
pub fn tone(light: Vec3) -> Vec3 {
    let light = light.max(Vec3::ZERO);
    let most = light.max_element();
    if most <= SHOULDER {
        return light;
    }
    let room = 1.0 - SHOULDER;
    let shown = SHOULDER + room * (1.0 - (-(most - SHOULDER) / room).exp());
    light * (shown / most)
}

#[cfg(test)]
mod tests {
    use super::*;

    const LEVEL: Stand = Stand { right: Vec3::X, up: Vec3::Y, back: Vec3::Z, world_up: Vec3::Y };

    fn surface(base_color: Vec3, normal: Vec3) -> Surface {
        Surface {
            base_color,
            roughness: 0.7,
            metallic: 0.0,
            reflectance: PLAIN,
            occlusion: 1.0,
            normal,
            smooth: normal,
            to_eye: Vec3::Z,
        }
    }

    #[test]
    fn a_base_colour_that_faces_the_camera_survives() {
        for colour in [Vec3::splat(0.2158), Vec3::new(0.5, 0.1, 0.05), Vec3::new(0.02, 0.05, 0.3)] {
            let shown = tone(Lighting::studio().shade(&surface(colour, Vec3::Z), &LEVEL));
            let difference = (shown - colour).abs().max_element();
            assert!(difference < 0.012, "{colour} is shown as {shown}");
        }
    }

    #[test]
    fn in_a_white_furnace_white_stays_white_and_nothing_gains_light() {
        for roughness in [0.0, 0.3, 0.7, 1.0] {
            for metallic in [0.0, 0.5, 1.0] {
                for angle in [0.0_f32, 0.5, 1.0, 1.4, 1.55] {
                    let normal = Vec3::new(angle.sin(), 0.0, angle.cos());
                    let white = Surface { roughness, metallic, reflectance: DIELECTRIC, ..surface(Vec3::ONE, normal) };
                    let out = Lighting::furnace().shade(&white, &LEVEL);
                    assert!(out.max_element() < 1.0 + 1e-5, "no gain: {roughness} {metallic} {angle}: {out}");
                    assert!(out.min_element() > 0.97, "little loss: {roughness} {metallic} {angle}: {out}");
                }
            }
        }
    }

    #[test]
    fn the_highlight_reflects_what_it_must_over_the_hemisphere() {
        let reflected = |alpha: f32| -> f64 {
            let steps = 4000;
            let width = std::f64::consts::FRAC_PI_2 / f64::from(steps);
            let ring = |i: i32| {
                let (sin, lit) = ((f64::from(i) + 0.5) * width).sin_cos();
                let half = (0.5 * (1.0 + lit)).sqrt();
                f64::from(highlight(alpha, half as f32, lit as f32, 1.0)) * lit * sin * std::f64::consts::TAU * width
            };
            (0..steps).map(ring).sum()
        };
        // Seen from above: a mirror reflects all; of the roughest surface's light masking leaves 1 - ln 2.
        assert!((reflected(0.05) - 1.0).abs() < 0.02, "nearly a mirror: {}", reflected(0.05));
        let roughest = 1.0 - std::f64::consts::LN_2;
        assert!((reflected(1.0) - roughest).abs() < 1e-3, "the roughest: {}", reflected(1.0));
    }

    #[test]
    fn the_tone_curve_rises_keeps_hue_and_stays_below_one() {
        let mut last = -1.0;
        for i in 0..400 {
            let m = i as f32 * 0.01;
            let shown = tone(Vec3::new(m, 0.5 * m, 0.0));
            assert!(shown.x >= last - 1e-6 && shown.x <= 1.0, "monotone at {m}");
            assert!((shown.y - 0.5 * shown.x).abs() < 1e-6, "hue at {m}");
            last = shown.x;
        }
    }
}
