//! Watching a paste being laid: the disc that grows face by face on the surface, and its flattening (LT 3.3, 3.4).
//!
//! Nothing is kept while pasting but where each paste began ([`super::Seeding`]). A paste that somebody wants to see is laid once
//! more with a [`Witness`]; laying is deterministic, so it is the same paste.

use super::grow::{PatchPlan, Site};
use super::lay::{Witness, lay_before};
use super::layout::Seeding;
use super::{LappedTexture, PasteOptions};
use crate::field::Guide;
use crate::mesh::Mesh;
use crate::mesh::disc::{Disc, Scratch};
use glam::{DVec2, Vec2};

/// Moments that a fit takes: the patch is seen to slide into its place.
const MOMENTS_OF_FIT: usize = 12;

/// How a paste came to lie where it does.
#[derive(Debug, Clone, PartialEq)]
pub struct Growth {
    /// Which texture patch it is of.
    pub patch: u16,
    /// Its faces in the order in which they joined, at the end.
    disc: Disc,
    plan: Plan,
    stages: Vec<Stage>,
}

/// Texture coordinates, in exemplar widths, to places over the patch's mask.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Plan {
    /// Where the centre lies over the mask, and what an exemplar width to the right and up is there.
    centre: DVec2,
    width: DVec2,
}

/// A part of the laying.
#[derive(Debug, Clone, PartialEq)]
struct Stage {
    what: Doing,
    /// Faces in the disc at its end.
    faces: usize,
    /// Where the disc's vertices lie at its end.
    uv: Vec<DVec2>,
}

/// What happens to the disc.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Doing {
    /// Faces join.
    Growing,
    /// It is fitted to the field.
    Fitting,
}

/// The disc at a moment.
#[derive(Debug, Clone, PartialEq)]
pub struct Moment {
    /// What was done last.
    pub doing: Doing,
    /// Times it was fitted so far, this one included.
    pub fits: usize,
    /// Faces of the mesh in it, in the order of joining.
    pub faces: Vec<u32>,
    /// Their corners over the patch's mask: [0, 1] inside, as in [`super::Paste::uv`].
    pub uv: Vec<[Vec2; 3]>,
}

impl Growth {
    /// Lays a paste of a lapped texture again and looks on. `options` must be those it was pasted with. `None` if the seeding is
    /// of another mesh or lapped texture.
    #[must_use]
    pub fn of(mesh: &Mesh, guide: &Guide, lapped: &LappedTexture, options: &PasteOptions, seeding: &Seeding) -> Option<Self> {
        let patch = lapped.patches.get(usize::from(seeding.patch))?;
        let exemplar = lapped.exemplars.get(usize::from(patch.exemplar))?;
        if seeding.at.face as usize >= mesh.face_count() {
            return None;
        }
        let plan = PatchPlan::new(patch, exemplar.size()[0]);
        let site = Site {
            mesh,
            guide,
            plan: &plan,
            seed: seeding.at,
            distortion: options.distortion_for(guide, seeding.free),
            predictor: options.predictor,
            free: seeding.free,
        };
        let mut stages = Stages::default();
        let laid = lay_before(site, seeding.angle, options.fit(), &mut Scratch::new(mesh), &mut stages)?;
        let centre = plan.mask_uv(DVec2::ZERO);
        let width = plan.mask_uv(DVec2::ONE) - centre;
        Some(Self { patch: seeding.patch, disc: laid.disc, plan: Plan { centre, width }, stages: stages.0 })
    }

    /// Moments from the seed face alone to the paste as it lies; at least 1.
    #[must_use]
    pub fn moments(&self) -> usize {
        let (mut before, mut moments) = (0, 0);
        for stage in &self.stages {
            moments += match stage.what {
                Doing::Growing => stage.faces - before,
                Doing::Fitting => MOMENTS_OF_FIT,
            };
            before = stage.faces;
        }
        moments
    }

    /// The disc at a moment, counted from 0; after the last one it stays as it is.
    #[must_use]
    pub fn at(&self, moment: usize) -> Moment {
        let (mut left, mut before, mut fits) = (moment, 0, 0);
        let mut uv: &[DVec2] = &[];
        for stage in &self.stages {
            fits += usize::from(stage.what == Doing::Fitting);
            let long = match stage.what {
                Doing::Growing => stage.faces - before,
                Doing::Fitting => MOMENTS_OF_FIT,
            };
            if left < long {
                return match stage.what {
                    Doing::Growing => self.moment(stage.what, fits, before + left + 1, &stage.uv),
                    Doing::Fitting => {
                        let t = smooth((left + 1) as f64 / MOMENTS_OF_FIT as f64);
                        let between: Vec<DVec2> = uv.iter().zip(&stage.uv).map(|(a, b)| a.lerp(*b, t)).collect();
                        self.moment(stage.what, fits, stage.faces, &between)
                    }
                };
            }
            (left, before, uv) = (left - long, stage.faces, &stage.uv);
        }
        self.moment(Doing::Fitting, fits, self.disc.faces.len(), &self.disc.uv)
    }

    fn moment(&self, doing: Doing, fits: usize, faces: usize, uv: &[DVec2]) -> Moment {
        let place = |v: u32| (self.plan.centre + uv[v as usize] * self.plan.width).as_vec2();
        Moment {
            doing,
            fits,
            faces: self.disc.faces[..faces].to_vec(),
            uv: self.disc.corners[..faces].iter().map(|corners| corners.map(place)).collect(),
        }
    }
}

/// Slow at both ends.
fn smooth(t: f64) -> f64 {
    t * t * (3.0 - 2.0 * t)
}

/// A witness that remembers.
#[derive(Default)]
struct Stages(Vec<Stage>);

impl Stages {
    fn add(&mut self, what: Doing, disc: &Disc) {
        self.0.push(Stage { what, faces: disc.faces.len(), uv: disc.uv.clone() });
    }
}

impl Witness for Stages {
    fn grown(&mut self, disc: &Disc) {
        self.add(Doing::Growing, disc);
    }

    fn fitted(&mut self, disc: &Disc) {
        self.add(Doing::Fitting, disc);
    }

    fn again(&mut self) {
        self.0.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exemplar::{Exemplar, Image, PatchOptions, PatchSource, PatchSpec, make_patches};
    use crate::field::{isotropic, up};
    use crate::mesh::disc::check_disc;
    use crate::mesh::shapes;
    use crate::paste::{Composite, Finish, cover};
    use crate::progress::Silent;
    use crate::surface::SurfaceTexture;
    use glam::{DVec3, Vec3};
    use std::collections::BTreeMap;

    fn pasted(mesh: &Mesh, guide: &Guide) -> (LappedTexture, Vec<Seeding>) {
        let exemplar = Exemplar::new("checks", Image::from_fn(48, 48, |x, y| Vec3::splat(((x / 6 + y / 6) % 2) as f32)));
        let spec = PatchSpec { source: PatchSource::Splotch, weight: 1.0 };
        let (patches, _) = make_patches(&exemplar, 0, &[spec], &PatchOptions::default()).expect("patches");
        let (lapped, seedings, _) = cover(mesh, guide, vec![exemplar], patches, &[], &PasteOptions::default(), &Silent)
            .expect("a paste")
            .finish(mesh, Finish { windows: true, cuts: true, contrast: false }, &Silent);
        (lapped, seedings)
    }

    #[test]
    fn a_paste_watched_is_the_paste_that_was_laid() {
        let mesh = shapes::torus(48, 24, 1.0, 0.4);
        let guides = [Guide::Directed(up(&mesh, DVec3::Z, 0.6).expect("a field").0), isotropic(&mesh, 0.6).expect("a scale")];
        for guide in guides {
            let (lapped, seedings) = pasted(&mesh, &guide);
            assert_eq!(seedings.len(), lapped.pastes.len(), "one for each paste that is left");
            let mut laid: Vec<u32> = seedings.iter().map(|s| s.laid).collect();
            laid.sort_unstable();
            assert!(laid.windows(2).all(|w| w[0] < w[1]), "each laid once");
            for (paste, seeding) in lapped.pastes.iter().zip(&seedings) {
                let growth = Growth::of(&mesh, &guide, &lapped, &PasteOptions::default(), seeding).expect("its own seeding");
                let last = growth.at(growth.moments() - 1);
                assert_eq!(last, growth.at(usize::MAX), "the last moment is the end");
                let corners: BTreeMap<u32, [Vec2; 3]> = last.faces.iter().copied().zip(last.uv).collect();
                for (face, uv) in paste.faces.iter().zip(&paste.uv) {
                    let off = corners[face].iter().zip(uv).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
                    assert!(off < 1e-5, "face {face} of paste {} lies {off} elsewhere", seeding.laid);
                }
            }
        }
    }

    #[test]
    fn every_moment_is_a_disc_and_faces_join_one_by_one() {
        let mesh = shapes::torus(48, 24, 1.0, 0.4);
        let guide = isotropic(&mesh, 0.9).expect("a scale");
        let (lapped, seedings) = pasted(&mesh, &guide);
        let growth = Growth::of(&mesh, &guide, &lapped, &PasteOptions::default(), &seedings[0]).expect("its own seeding");
        assert_eq!(growth.at(0).faces, [seedings[0].at.face], "from the seed face");
        let mut before = 0;
        for k in 0..growth.moments() {
            let moment = growth.at(k);
            assert_eq!(check_disc(&mesh, &moment.faces), Ok(()), "moment {k}");
            let joined = moment.faces.len() - before;
            assert_eq!(joined, usize::from(moment.doing == Doing::Growing), "moment {k}: one face, or a fit");
            before = moment.faces.len();
        }
        assert!(growth.at(usize::MAX).fits > 0, "it was fitted");
    }

    #[test]
    fn pastes_laid_one_by_one_end_at_the_whole() {
        let mesh = shapes::sphere(4);
        let guide = isotropic(&mesh, 0.7).expect("a scale");
        let (lapped, _) = pasted(&mesh, &guide);
        let whole = Composite::new(&mesh, &lapped);
        let places =
            (0..mesh.face_count() as u32).step_by(5).map(|face| crate::mesh::SurfacePoint { face, bary: Vec3::splat(1.0 / 3.0) });
        for at in places {
            let mut alpha = 0.0;
            for count in 0..=lapped.pastes.len() {
                let next = Composite::of_first(&mesh, &lapped, count).alpha(at);
                assert!(next >= alpha - 1e-6, "{count} pastes cover no less than one fewer: {alpha}, {next}");
                alpha = next;
            }
            assert_eq!(Composite::of_first(&mesh, &lapped, usize::MAX).texel(at, 0.01), whole.texel(at, 0.01), "all of them");
            assert!(alpha > 0.98, "everything is covered at the end: {alpha}");
        }
    }
}
