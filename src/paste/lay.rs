//! Laying one paste: grow, fit, and grow again where the fit drew the surface patch back (LT 3.3, 3.4).

use super::fit::{Deviation, FitProblem, Fitter, IsotropicFit, Weights, deviations};
use super::frame::Frame;
use super::grow::{PasteRule, Site, Stops};
use crate::mesh::disc::{Disc, Grower, Scratch};
use crate::mesh::{Mesh, SurfacePoint};
use glam::DVec2;

/// The fit may uncover parts of the texture patch, which then grows and is fitted again, at most this often: the second
/// round adds few faces and the third next to none.
const REGROWTHS: usize = 3;

/// When no more than this share of a patch's faces has joined after a fit, they lie along its rim where the field has placed
/// them, and the fit that follows moves nothing far enough to uncover the patch again.
const FEW: f64 = 0.03;

/// Faces smaller than this share of the hull's radius are judged together with their neighbours. On a fine or noisy mesh
/// single faces tilt and flip without being seen; refusing them leaves slits in the patch, because the faces around a
/// hole may not close the ring.
const EVEN_OUT: f64 = 0.3;

/// A patch grown that tolerantly is laid again, each face judged alone, if more than this share of its area ...
const MAX_BAD_AREA: f64 = 0.01;

/// ... is stretched by more than this after the fit.
const BAD_STRETCH: f64 = 2.0;

/// How to fit.
#[derive(Debug, Clone, Copy, Default)]
pub struct FitChoice {
    /// Weights of the faces.
    pub weights: Weights,
    /// What to do for isotropic guides.
    pub isotropic: IsotropicFit,
    /// Grow and fit only once: the patch may end short of its outline, and lies nearly where it belongs.
    pub once: bool,
}

/// A surface patch laid flat over its texture patch.
#[derive(Debug, Clone)]
pub struct Laid {
    /// The patch; its plane coordinates are texture coordinates in exemplar widths, t up, the centre at the origin.
    pub disc: Disc,
    /// Frames of its faces.
    pub frames: Vec<Frame>,
    /// Faces' edges where the texture ends without falling off, as (index of the disc's face, edge).
    pub open: Vec<(usize, usize)>,
    /// Why it ends there.
    pub stops: Stops,
    /// Conjugate gradient iterations.
    pub iterations: usize,
    /// How often it was grown again after a fit.
    pub regrowths: usize,
}

impl Laid {
    /// How its faces deviate from the field.
    pub fn deviations<'a>(&'a self, mesh: &'a Mesh) -> impl Iterator<Item = Deviation> + 'a {
        deviations(mesh, &self.disc, &self.frames)
    }
}

/// Looks on while a patch is laid.
pub trait Witness {
    /// Faces have joined, one after the other at the end of the disc; where they lie they stayed while others joined.
    fn grown(&mut self, _disc: &Disc) {}
    /// A fit has moved the disc.
    fn fitted(&mut self, _disc: &Disc) {}
    /// What was laid so far is stretched too much: it begins again from the seed.
    fn again(&mut self) {}
}

/// Nobody.
impl Witness for () {}

/// Lays a texture patch at a site, turned by `angle` where the guide is isotropic. `None` if the field has no usable
/// basis at the seed.
#[must_use]
pub fn lay(site: Site, angle: f64, choice: FitChoice, scratch: &mut Scratch) -> Option<Laid> {
    lay_before(site, angle, choice, scratch, &mut ())
}

/// [`lay`] with a witness.
#[must_use]
pub fn lay_before(site: Site, angle: f64, choice: FitChoice, scratch: &mut Scratch, witness: &mut impl Witness) -> Option<Laid> {
    match lay_evenly(site, EVEN_OUT, angle, choice, scratch, witness)? {
        Outcome::Laid(laid) => Some(*laid),
        Outcome::Stretched { iterations: spent } => {
            witness.again();
            match lay_evenly(site, 0.0, angle, choice, scratch, witness)? {
                Outcome::Laid(laid) => Some(Laid { iterations: laid.iterations + spent, ..*laid }),
                Outcome::Stretched { .. } => None,
            }
        }
    }
}

/// How laying ended.
enum Outcome {
    Laid(Box<Laid>),
    /// Faces judged together with their neighbours turned out stretched too much.
    Stretched {
        iterations: usize,
    },
}

/// Share of a patch's area that is stretched too much.
fn bad_share(mesh: &Mesh, disc: &Disc, frames: &[Frame]) -> f64 {
    let (bad, all) = deviations(mesh, disc, frames).fold((0.0, 0.0), |(bad, all), d| {
        let is_bad = d.stretch > BAD_STRETCH;
        (bad + if is_bad { d.area } else { 0.0 }, all + d.area)
    });
    bad / all
}

fn lay_evenly(
    site: Site,
    even_out: f64,
    angle: f64,
    choice: FitChoice,
    scratch: &mut Scratch,
    witness: &mut impl Witness,
) -> Option<Outcome> {
    let (mut rule, uv) = PasteRule::new(site, even_out, angle)?;
    let mut grower = Grower::new(site.mesh, scratch, site.seed.face, uv);
    grower.grow(&mut rule);
    witness.grown(grower.disc());
    let isotropic = site.propagates().then_some(choice.isotropic);
    let fitter = |grower: &Grower, rule: &PasteRule| {
        let (disc, frames) = (grower.disc(), rule.frames());
        Fitter::new(&FitProblem { mesh: site.mesh, disc, frames, weights: choice.weights, isotropic })
    };
    let (mut iterations, mut regrowths) = (0, 0);
    loop {
        let mut fit = fitter(&grower, &rule);
        let draft = fit.draft(grower.disc());
        place(&mut grower, draft, site.seed);
        witness.fitted(grower.disc());
        // Seen as soon as the first draft: what it stretches the last fit stretches too.
        if rule.evened() && bad_share(site.mesh, grower.disc(), rule.frames()) > MAX_BAD_AREA {
            return Some(Outcome::Stretched { iterations: iterations + fit.iterations() });
        }
        if choice.once {
            iterations += fit.iterations();
            break;
        }
        rule.moved(grower.disc());
        let joined = if regrowths < REGROWTHS { grower.grow(&mut rule) } else { 0 };
        let few = joined as f64 <= FEW * grower.disc().faces.len() as f64;
        if joined > 0 {
            witness.grown(grower.disc());
            iterations += fit.iterations();
            regrowths += 1;
            if !few {
                continue;
            }
            fit = fitter(&grower, &rule);
        }
        let fitted = fit.finish(grower.disc());
        place(&mut grower, fitted, site.seed);
        witness.fitted(grower.disc());
        iterations += fit.iterations();
        break;
    }
    let stops = rule.stops(&grower);
    let open = grower.open_border().collect();
    Some(Outcome::Laid(Box::new(Laid { frames: rule.into_frames(), disc: grower.into_disc(), open, stops, iterations, regrowths })))
}

/// Moves the disc to these coordinates, translated so that the seed point lies on the texture patch's centre. The seed
/// face's corners are the disc's first three vertices.
fn place(grower: &mut Grower, uv: Vec<DVec2>, seed: SurfacePoint) {
    let w = seed.bary.as_dvec3();
    let shift = uv[0] * w.x + uv[1] * w.y + uv[2] * w.z;
    grower.uv_mut().iter_mut().zip(uv).for_each(|(to, q)| *to = q - shift);
}
