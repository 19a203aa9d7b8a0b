//! Subjects beside the texture itself: the same pastes in colours of their own, the bare mesh. Made when a pane shows them.

use super::build::Shown;
use super::graphics::Graphics;
use super::mode::Mode;
use super::worker::Lane;
use crate::exemplar::{Exemplar, Image};
use crate::paste::LappedTexture;
use crate::render::gpu::{GpuError, Renderer, Subject};
use crate::render::style::distinct;
use crate::render::{DrawOptions, Stage};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Colours that pastes take turns in: enough that neighbours differ.
const COLOURS: u16 = 24;
/// The most patches that are repeated in every colour; with more of them fewer colours are taken.
const MOST_PATCHES: usize = 240;

/// What a job brings forth.
type Made = (Mode, u64, Result<Subject, GpuError>);

/// The subjects that are there.
#[derive(Debug)]
pub struct Side {
    lane: Lane<Made>,
    made: BTreeMap<Mode, (u64, Result<Subject, GpuError>)>,
    /// The mode and revision asked for last.
    asked: Option<(Mode, u64)>,
}

impl Side {
    /// None yet; `wake` is called when one is there.
    pub fn new(wake: impl Fn() + Send + Sync + 'static) -> Self {
        Self { lane: Lane::new("lapped figures", wake), made: BTreeMap::new(), asked: None }
    }

    /// True if nothing is being made.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        self.lane.meter().is_none()
    }

    /// The subject for a mode, if it is there; it may be of an earlier revision.
    #[must_use]
    pub fn subject(&self, mode: Mode) -> Option<&Subject> {
        self.made.get(&mode).and_then(|(_, made)| made.as_ref().ok())
    }

    /// Another number with every other subject.
    #[must_use]
    pub fn number(&self, mode: Mode) -> u64 {
        self.made.get(&mode).map_or(0, |(revision, _)| *revision)
    }

    /// Takes in what was made.
    pub fn take(&mut self) {
        for (mode, revision, made) in self.lane.take() {
            self.made.insert(mode, (revision, made));
            self.asked = None;
        }
    }

    /// Asks for one of the modes' subjects that is out of date.
    pub fn ask(&mut self, modes: &[Mode], shown: &Arc<Shown>, graphics: &Graphics) {
        let old = |mode: &&Mode| self.made.get(mode).is_none_or(|(revision, _)| *revision != shown.revision);
        let of_ours = |mode: &&Mode| matches!(mode, Mode::Pastes | Mode::Bare);
        let Some(&mode) = modes.iter().filter(of_ours).find(old) else { return };
        if self.asked == Some((mode, shown.revision)) {
            return;
        }
        self.asked = Some((mode, shown.revision));
        let (shown, renderer) = (Arc::clone(shown), Arc::clone(&graphics.renderer));
        self.lane.submit(move |_, deliver| deliver((mode, shown.revision, make(mode, &shown, &renderer))));
    }
}

fn make(mode: Mode, shown: &Shown, renderer: &Renderer) -> Result<Subject, GpuError> {
    let nothing = LappedTexture::default();
    let stage = Stage::new(shown.mesh(), &DrawOptions::default());
    match (mode, shown.lapped()) {
        (Mode::Pastes, Some(lapped)) => renderer.load(&stage, &in_colours(lapped)),
        _ => renderer.load(&stage, &nothing),
    }
}

/// The same pastes with a colour each: every texture patch is repeated over exemplars of one colour.
fn in_colours(lapped: &LappedTexture) -> LappedTexture {
    let patches = lapped.patches.len().max(1);
    let colours = (MOST_PATCHES / patches).clamp(1, usize::from(COLOURS)) as u16;
    let exemplar = |k: u16| Exemplar::new(format!("colour {k}"), Image::from_fn(1, 1, |_, _| distinct(u32::from(k))));
    let recoloured =
        |k: u16| lapped.patches.iter().map(move |patch| crate::exemplar::TexturePatch { exemplar: k, ..patch.clone() });
    let paste = |(i, paste): (usize, &crate::paste::Paste)| {
        let patch = (i % usize::from(colours) * patches + usize::from(paste.patch)).min(usize::from(u16::MAX)) as u16;
        crate::paste::Paste { patch, ..paste.clone() }
    };
    LappedTexture {
        exemplars: (0..colours).map(exemplar).collect(),
        patches: (0..colours).flat_map(recoloured).collect(),
        pastes: lapped.pastes.iter().enumerate().map(paste).collect(),
        layers: lapped.layers.clone(),
    }
}
