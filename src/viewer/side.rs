//! Subjects beside the texture itself: the same pastes in colours of their own, figures in colours, the baked atlas, and lines on the
//! surface. Each is made when a pane shows it.

use super::build::Shown;
use super::graphics::Graphics;
use super::lines::{Detail, Lines, lines};
use super::mode::Mode;
use super::worker::{Deliver, Lane, Meter};
use crate::atlas::{AtlasError, BakeOptions, Frames, UnwrapOptions, bake, unwrap};
use crate::exemplar::{Channel, Exemplar, Hull, Image, MipChain, TexturePatch};
use crate::field::turning_points;
use crate::job::bake::default_size;
use crate::mesh::{Mesh, MeshError};
use crate::paste::{AGREES, Composite, LappedTexture, Layer, Paste, Turn};
use crate::progress::Progress;
use crate::render::gpu::{GpuError, Renderer, Subject};
use crate::render::style::{Legend, corner_colours, distinct};
use crate::render::{DrawOptions, PreviewStyle, RenderError, Stage, Subject as Styled};
use crate::surface::SurfaceTexture;
use glam::{DVec3, Vec2, Vec3, Vec4};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Colours that pastes take turns in: enough that neighbours differ.
const COLOURS: u16 = 24;
/// The most patches that are repeated in every colour; with more of them fewer colours are taken.
const MOST_PATCHES: usize = 240;
/// Longest side of the atlas that is looked at, texels.
const LARGEST_ATLAS: u32 = 2048;

/// Why a subject was not made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SideError {
    /// The device.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// There is nothing to show.
    #[error(transparent)]
    Style(#[from] RenderError),
    /// The atlas.
    #[error(transparent)]
    Atlas(#[from] AtlasError),
    /// A mesh of lines.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}

impl SideError {
    /// True if it was stopped because something newer was wanted.
    #[must_use]
    pub const fn is_cancelled(&self) -> bool {
        matches!(self, Self::Atlas(AtlasError::Cancelled))
    }
}

/// A subject that was made.
#[derive(Debug)]
struct Made {
    revision: u64,
    subject: Option<Subject>,
    legend: Option<Legend>,
}

/// The field's turning points.
#[derive(Debug, Clone, PartialEq)]
pub struct Turning {
    /// Where each is, and its index in n-th parts of a full turn.
    pub points: Vec<(DVec3, i32)>,
    /// Ways of the field: n.
    pub ways: u32,
}

impl Turning {
    /// The sum of their indices, in n-th parts of a full turn.
    #[must_use]
    pub fn sum(&self) -> i64 {
        self.points.iter().map(|(_, parts)| i64::from(*parts)).sum()
    }
}

/// What lines are of.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Drawn {
    revision: u64,
    which: Lines,
    detail: Detail,
    near: DVec3,
}

type Ruled = (Drawn, Result<Option<Subject>, SideError>, Option<Turning>);

/// The subjects that are there.
#[derive(Debug)]
pub struct Side {
    lane: Lane<(Mode, Result<Made, SideError>)>,
    made: BTreeMap<Mode, (u64, Made)>,
    asked: Option<(Mode, u64)>,
    ruler: Lane<Ruled>,
    ruled: Option<(Drawn, Option<Subject>)>,
    ruling: Option<Drawn>,
    turning: Option<(u64, Turning)>,
    /// Counts what was made.
    count: u64,
}

impl Side {
    /// None yet; `wake` is called when one is there.
    pub fn new(wake: impl Fn() + Send + Sync + Clone + 'static) -> Self {
        Self {
            lane: Lane::new("lapped figures", wake.clone()),
            made: BTreeMap::new(),
            asked: None,
            ruler: Lane::new("lapped lines", wake),
            ruled: None,
            ruling: None,
            turning: None,
            count: 0,
        }
    }

    /// True if nothing is being made.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        self.lane.is_idle() && self.ruler.is_idle()
    }

    /// The work on a mode's subject, if it goes on.
    #[must_use]
    pub fn meter(&self) -> Option<Arc<Meter>> {
        self.lane.meter()
    }

    /// Stops what is being made.
    pub fn cancel(&self) {
        self.lane.cancel();
    }

    /// The subject for a mode, if it is there, and a number that is another with every other; it may be of an earlier revision.
    #[must_use]
    pub fn subject(&self, mode: Mode) -> (Option<&Subject>, u64) {
        self.made.get(&mode).map_or((None, 0), |(number, made)| (made.subject.as_ref(), *number))
    }

    /// What a mode's colours mean.
    #[must_use]
    pub fn legend(&self, mode: Mode) -> Option<&Legend> {
        self.made.get(&mode).and_then(|(_, made)| made.legend.as_ref())
    }

    /// The lines on the surface of a revision, and a number that is another with every other.
    #[must_use]
    pub fn lines(&self, revision: u64, which: Lines) -> Option<(&Subject, u64)> {
        // Others than those asked for last stay until these are there.
        let (drawn, subject) = self.ruled.as_ref().filter(|(d, _)| d.revision == revision && which.any())?;
        let number = drawn.near.to_array().iter().fold(self.count, |n, c| n.rotate_left(7) ^ c.to_bits());
        Some((subject.as_ref()?, number))
    }

    /// The turning points of the field of a revision, if they were looked for.
    #[must_use]
    pub fn turning(&self, revision: u64) -> Option<&Turning> {
        self.turning.as_ref().filter(|(of, _)| *of == revision).map(|(_, turning)| turning)
    }

    /// Takes in what was made; what went wrong is returned.
    pub fn take(&mut self) -> Vec<SideError> {
        let mut errors = Vec::new();
        for (mode, made) in self.lane.take() {
            self.count += 1;
            match made {
                Ok(made) => drop(self.made.insert(mode, (self.count, made))),
                Err(error) if error.is_cancelled() => {}
                Err(error) => errors.push(error),
            }
        }
        for (drawn, subject, turning) in self.ruler.take() {
            self.count += 1;
            self.turning = turning.map(|t| (drawn.revision, t)).or(self.turning.take());
            match subject {
                Ok(subject) => self.ruled = Some((drawn, subject)),
                Err(error) => errors.push(error),
            }
        }
        errors
    }

    /// Asks for one of the modes' subjects that is out of date.
    pub fn ask(&mut self, modes: &[Mode], shown: &Arc<Shown>, graphics: &Graphics) {
        let old = |mode: &&Mode| self.made.get(mode).is_none_or(|(_, made)| made.revision != shown.number());
        let Some(&mode) = modes.iter().filter(|m| m.is_made()).find(old) else { return };
        if self.asked == Some((mode, shown.number())) {
            return;
        }
        self.asked = Some((mode, shown.number()));
        let (shown, renderer) = (Arc::clone(shown), Arc::clone(&graphics.renderer));
        self.lane.submit(move |meter, deliver| {
            if let Err(error) = make(mode, &shown, &renderer, &**meter, deliver) {
                deliver((mode, Err(error)));
            }
        });
    }

    /// Asks for lines as they are to be seen from a point of view: so much of the world from top to bottom, around `at`.
    pub fn ask_lines(&mut self, which: Lines, height: f64, at: DVec3, shown: &Arc<Shown>, graphics: &Graphics) {
        if !which.any() {
            return;
        }
        let detail = Detail::of(height);
        // A new place only when the old one is left.
        let near = self.ruling.map(|d| d.near).filter(|near| near.distance(at) < 0.5 * height).unwrap_or(at);
        let wanted = Drawn { revision: shown.number(), which, detail, near };
        if self.ruling == Some(wanted) {
            return;
        }
        self.ruling = Some(wanted);
        let (shown, renderer) = (Arc::clone(shown), Arc::clone(&graphics.renderer));
        self.ruler.submit(move |_, deliver| {
            let strips = lines(shown.mesh(), shown.field(), which, detail, near);
            let turning = shown.field().filter(|_| which.singularities).map(|field| {
                let points = turning_points(shown.mesh(), field);
                let points = points.iter().map(|p| (shown.mesh().point(p.place), p.parts)).collect();
                Turning { points, ways: field.ways }
            });
            let tints = strips.tints();
            let subject = (!strips.faces.is_empty())
                .then(|| -> Result<Subject, SideError> {
                    let mesh = Mesh::new(strips.positions, strips.faces)?;
                    let stage = Stage::new(&mesh, &DrawOptions::default());
                    Ok(renderer.load_tinted(&stage, &LappedTexture::default(), Some(&tints))?)
                })
                .transpose();
            deliver((wanted, subject, turning));
        });
    }
}

fn make(
    mode: Mode,
    shown: &Shown,
    renderer: &Renderer,
    progress: &dyn Progress,
    deliver: Deliver<'_, (Mode, Result<Made, SideError>)>,
) -> Result<(), SideError> {
    let nothing = LappedTexture::default();
    let mesh = shown.mesh();
    let stage = Stage::new(mesh, &DrawOptions::default());
    let done = |subject, legend| deliver((mode, Ok(Made { revision: shown.number(), subject: Some(subject), legend })));
    let lapped = shown.lapped();
    match (mode, lapped) {
        (Mode::Pastes, Some(lapped)) => done(renderer.load(&stage, &in_colours(lapped))?, None),
        (Mode::Draws | Mode::Stretch, _) => {
            let style = if mode == Mode::Draws { PreviewStyle::Coverage } else { PreviewStyle::Stretch };
            let guide = shown.guide();
            let composite = Composite::new(mesh, lapped.unwrap_or(&nothing));
            let (colours, legend) = corner_colours(&Styled { mesh, texture: &composite, lapped, guide: guide.as_ref() }, style)?;
            let tints: Vec<[Vec4; 3]> = colours.iter().map(|face| face.map(|c| c.extend(1.0))).collect();
            done(renderer.load_tinted(&stage, &nothing, Some(&tints))?, legend);
        }
        (Mode::Atlas, Some(lapped)) => done(renderer.load(&stage, &baked(mesh, &stage, lapped, progress)?)?, None),
        _ => done(renderer.load(&stage, &nothing)?, None),
    }
    Ok(())
}

/// The same pastes with a colour each: every texture patch is repeated over exemplars of one colour.
fn in_colours(lapped: &LappedTexture) -> LappedTexture {
    let patches = lapped.patches.len().max(1);
    let colours = (MOST_PATCHES / patches).clamp(1, usize::from(COLOURS)) as u16;
    let exemplar = |k: u16| Exemplar::new(format!("colour {k}"), Image::from_fn(1, 1, |_, _| distinct(u32::from(k))));
    let recoloured = |k: u16| lapped.patches.iter().map(move |patch| TexturePatch { exemplar: k, ..patch.clone() });
    let paste = |(i, paste): (usize, &Paste)| {
        let patch = (i % usize::from(colours) * patches + usize::from(paste.patch)).min(usize::from(u16::MAX)) as u16;
        Paste { patch, ..paste.clone() }
    };
    LappedTexture {
        exemplars: (0..colours).map(exemplar).collect(),
        patches: (0..colours).flat_map(recoloured).collect(),
        pastes: lapped.pastes.iter().enumerate().map(paste).collect(),
        layers: lapped.layers.iter().map(|layer| Layer { base: Vec::new(), ..layer.clone() }).collect(),
    }
}

/// The texture baked into an atlas, as a lapped texture of its own: a page is an exemplar without mask that lies over all
/// faces of the page's charts.
fn baked(mesh: &Mesh, stage: &Stage<'_>, lapped: &LappedTexture, progress: &dyn Progress) -> Result<LappedTexture, SideError> {
    let texture = Composite::new(mesh, lapped);
    let size = default_size(mesh, lapped).min(LARGEST_ATLAS);
    let atlas = unwrap(mesh, &UnwrapOptions { size, ..UnwrapOptions::default() }, progress)?;
    let frames = if texture.channels().has(Channel::Normal) {
        Frames::with_tangents(mesh, &atlas, stage.normals().to_vec())
    } else {
        Frames::smooth(stage.normals().to_vec())
    };
    let pages = bake(mesh, &atlas, &frames, &texture, &BakeOptions::default(), progress)?.pages;
    let mask = MipChain::new(Image::grey_from_fn(atlas.size, atlas.size, |_, _| 1.0));
    let side = atlas.size as f32;
    let hull = Hull::new([[0.0, 0.0], [side, 0.0], [side, side], [0.0, side]].map(Vec2::from_array).to_vec());
    let mut out = LappedTexture::default();
    for (number, page) in pages.into_iter().enumerate() {
        let base = page.image(Channel::BaseColor).cloned().unwrap_or_else(|| Image::from_fn(1, 1, |_, _| Vec3::splat(0.5)));
        let mut exemplar = Exemplar::new(format!("page {number}"), base);
        for (channel, image) in page.images {
            if channel != Channel::BaseColor && channel != Channel::Height {
                // All images of a page have its size.
                let _same_size = exemplar.set(channel, image);
            }
        }
        out.exemplars.push(exemplar);
        let (exemplar, centre) = (number as u16, Vec2::splat(0.5 * side));
        out.patches.push(TexturePatch {
            exemplar,
            origin: [0, 0],
            mask: mask.clone(),
            hull: hull.clone(),
            centre,
            weight: 1.0,
            slides: false,
        });
        let on_page = |face: &u32| atlas.page[atlas.chart[*face as usize] as usize] == number as u32;
        let faces: Vec<u32> = (0..mesh.face_count() as u32).filter(on_page).collect();
        let uv = faces.iter().map(|&face| atlas.face_uv(face)).collect();
        out.pastes.push(Paste {
            patch: number as u16,
            faces,
            uv,
            offset: Vec2::ZERO,
            turn: Turn::NONE,
            cut: None,
            agreement: AGREES,
        });
    }
    Ok(out)
}
