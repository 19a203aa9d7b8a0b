//! Work that goes on: asked for when what is shown is out of date, taken in when it is there.

use super::app::{App, Notice};
use super::build::{FirstAnswers, build};
use super::deeds::{Done, Still};
use super::mode::Mode;
use super::watch::room::WatchRoom;
use super::worker::Lane;
use egui::{Context, Ui};
use std::sync::Arc;

/// Seconds that unsaved work may be old before it is kept.
const KEEP_AFTER: f64 = 2.0;
/// Seconds at rest after which the reference renderer is asked.
const REST: f64 = 0.15;

impl App {
    /// True once all that was asked for is shown, and no work goes on.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        let built = self.asked == self.document.revision() && self.builds.is_idle();
        let files = [&self.opens, &self.saves, &self.exports].into_iter().all(Lane::is_idle);
        let watched = self.watch.as_ref().is_none_or(WatchRoom::is_idle);
        built && files && watched && self.side.is_idle() && self.synth.is_idle() && self.thumbnails.is_idle()
    }

    /// What goes on, if anything does: what it is, its stage, and the share that is done if that is known.
    #[must_use]
    pub fn work(&self) -> Option<(&'static str, String, Option<f32>)> {
        let meters = [
            ("Opening", self.opens.meter()),
            ("Pasting", self.builds.meter()),
            ("Exporting", self.exports.meter()),
            ("Preparing", self.side.meter()),
            ("Synthesising", self.synth.meter()),
        ];
        let (name, meter) = meters.into_iter().find_map(|(name, meter)| meter.map(|m| (name, m)))?;
        let (stage, share) = meter.state();
        Some((name, stage, share))
    }

    /// Takes in what jobs have brought forth.
    pub(super) fn take_results(&mut self, context: &Context) {
        for result in self.builds.take() {
            match result {
                Ok(Some(shown)) => {
                    self.trace.shown(shown.revision, shown.mesh().face_count());
                    self.notices.retain(|notice| !notice.passing);
                    for text in shown.told.clone() {
                        self.add(Notice { text, error: false, passing: true });
                    }
                    self.last_job = Some(("Pasted", shown.seconds));
                    let before = self.shown.replace(Arc::from(shown));
                    // Letting go of a large mesh takes longer than a frame.
                    rayon::spawn(move || drop(before));
                }
                Ok(None) => self.shown = None,
                Err(error) => {
                    self.building = None;
                    if !error.is_cancelled() {
                        self.add(Notice { text: error.to_string(), error: true, passing: true });
                    }
                }
            }
        }
        let lanes = [&self.opens, &self.saves, &self.exports, &self.dialogs];
        let done: Vec<Done> = lanes.into_iter().flat_map(Lane::take).collect();
        done.into_iter().for_each(|done| self.take_done(done));
        self.thumbnails.take(context);
        for error in self.side.take() {
            self.tell(error.to_string(), true);
        }
        let (seen, errors) = self.synth.take();
        if let Some((revision, vertices)) = seen {
            self.trace.shown(revision, vertices);
        }
        for error in errors {
            self.tell(error.to_string(), true);
        }
        self.still.take(context);
    }

    /// Asks for whatever is out of date.
    pub(super) fn ask_for_work(&mut self, ui: &Ui) {
        let revision = self.document.revision();
        if revision != self.asked {
            self.asked = revision;
            self.build();
        }
        let now = ui.input(|i| i.time);
        if let Some(shown) = &self.shown {
            let modes: Vec<Mode> = self.viewport.seen_modes().collect();
            self.side.ask(&modes, shown, &self.graphics);
            let (methods, chosen) = (modes.iter().filter_map(|mode| mode.method()), self.document.project().synthesis);
            self.synth.ask(methods, shown, chosen, revision, &self.graphics);
            self.side.ask_lines(self.lines, self.viewport.height(), self.viewport.orbit.at, shown, &self.graphics);
            if modes.contains(&Mode::Reference) {
                if self.viewport.at_rest(now) < REST {
                    ui.ctx().request_repaint_after_secs(REST as f32);
                } else if let Some(wanted) = Still::wanted(&self.viewport, ui.visuals().dark_mode, Some(shown)) {
                    self.still.ask(wanted, shown);
                }
            }
        }
        if self.work().is_some() {
            // The status bar follows the work.
            ui.ctx().request_repaint_after_secs(0.1);
        }
        self.keep_unsaved(ui, now);
    }

    /// Builds what the document asks for, unless that is what was built last, or is being built.
    fn build(&mut self) {
        let (project, revision) = (self.document.project().clone(), self.document.revision());
        if self.building.as_ref().is_some_and(|before| before.pastes_as(&project)) {
            return;
        }
        self.building = Some(project.clone());
        let (kitchen, library) = (Arc::clone(&self.kitchen), Arc::clone(&self.library));
        let (renderer, before) = (Arc::clone(&self.graphics.renderer), self.shown.clone());
        self.builds.submit(move |meter, deliver| {
            let draft = |shown| deliver(Ok(Some(Box::new(shown))));
            let first = FirstAnswers { before: before.as_deref(), take: &draft };
            let made = build(&project, revision, &kitchen, &library, &renderer, &**meter, first);
            deliver(made.map(|shown| shown.map(Box::new)));
        });
    }

    /// Keeps unsaved work against crashes, now and then.
    fn keep_unsaved(&mut self, ui: &Ui, now: f64) {
        let revision = self.document.revision();
        if revision == self.kept.0 {
            return;
        }
        if !self.document.unsaved() {
            self.kept = (revision, now);
            self.home.let_go();
        } else if now - self.kept.1 >= KEEP_AFTER {
            self.kept = (revision, now);
            self.keep_now();
        } else {
            ui.ctx().request_repaint_after_secs(KEEP_AFTER as f32);
        }
    }
}
