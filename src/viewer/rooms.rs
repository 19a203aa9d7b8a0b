//! The view and the rooms around it: what combing, cutting and watching do with the pointer, and how they keep up with what is shown.

use super::app::App;
use super::build::Shown;
use super::cut::room::{CutRoom, Wanted};
use super::deeds::Still;
use super::mode::Mode;
use super::panels::shortened;
use super::steer::room::put;
use super::viewport::Given;
use super::watch::room::WatchRoom;
use crate::exemplar::Exemplar;
use crate::exemplar::frames::duration;
use crate::mesh::Mesh;
use egui::{Context, Ui};
use std::sync::Arc;
use std::time::Instant;

/// Seconds that exemplars go on by in one frame at most: who comes back to a window that rested sees no leap.
const LONGEST_STEP: f64 = 0.25;
/// The longest name of an exemplar that is shown whole, letters.
const NAME: usize = 20;

impl App {
    /// The three-dimensional view, in all the room there is.
    pub(super) fn view(&mut self, ui: &mut Ui) {
        let shown = self.shown.clone();
        self.viewport.set_room(ui.available_rect_before_wrap(), ui.pixels_per_point());
        let mesh = shown.as_deref().map(Shown::mesh);
        let bounds = mesh.map(Mesh::bounds).map(|(low, high)| [low.as_dvec3(), high.as_dvec3()]);
        if let Some(shown) = &shown
            && self.framed.as_ref() != Some(&shown.open.link)
        {
            self.framed = Some(shown.open.link.clone());
            let project = self.document.project();
            match project.view.as_ref().filter(|_| project.model == shown.project.model) {
                Some(view) => self.viewport.orbit = super::orbit::Orbit::restored(view),
                None => self.viewport.frame(shown.mesh()),
            }
        }
        if let Some(shown) = &shown {
            self.viewport.keep_framed(shown.mesh());
        }
        let pointed = shown.as_ref().map(|shown| self.steer.point(ui, &self.viewport, shown)).unwrap_or_default();
        if let Some(edit) = &pointed.edit {
            self.edit(edit.what, |project| put(project, edit));
        }
        let moment = shown.as_ref().map_or(0, |shown| self.play(ui, shown));
        let watched = self.watch.as_ref().and_then(WatchRoom::subject);
        let (side, synth, still, which) = (&self.side, &self.synth, &self.still, self.lines);
        let wanted = Still::wanted(&self.viewport, ui.visuals().dark_mode, shown.as_deref());
        let given = |mode: Mode| {
            let (own, number) = shown.as_ref().map_or((None, 0), |s| (Some(&s.subject), s.number()));
            let still = (mode == Mode::Reference).then(|| still.picture(wanted.as_ref())).flatten();
            // Numbers of partial subjects must not be those of revisions.
            if let Some((subject, number)) = watched.filter(|_| matches!(mode, Mode::Single | Mode::Layered)) {
                return Given { subject: Some(subject), lines: None, still: None, number: u64::MAX - number, moment };
            }
            let (subject, number) = match (mode.method(), &shown) {
                (Some(method), Some(shown)) => synth.subject(method, shown),
                _ if mode.is_made() => side.subject(mode),
                _ => (own, number),
            };
            let lines = shown.as_ref().and_then(|s| side.lines(s.number(), which));
            Given { subject, lines, still, number, moment }
        };
        let begin = Instant::now();
        let seen = self.viewport.show(ui, &self.graphics, bounds, pointed.held, given);
        self.trace.part("view", begin.elapsed());
        self.trace.part("device", seen.device);
        if let Some(error) = seen.error {
            self.tell(error.to_string(), true);
        }
        if let Some(shown) = &shown {
            self.steer.paint(ui, &self.viewport, shown);
            if let Some(turning) = self.side.turning(shown.number()).filter(|_| self.lines.singularities) {
                let camera = self.viewport.orbit.camera();
                super::labels::paint(ui, &self.viewport, turning, &|place| self.steer.in_sight(shown, &camera, place));
            }
            self.watch_view(ui, shown, &seen.response);
        }
    }

    /// True if exemplars are shown that go by time.
    #[must_use]
    pub fn changes(&self) -> bool {
        self.shown.as_ref().and_then(|shown| shown.lapped()).is_some_and(|lapped| duration(&lapped.exemplars) > 0.0)
    }

    /// Shows exemplars that go by time as they are now; a number that is another with every other frame.
    fn play(&mut self, ui: &Ui, shown: &Shown) -> u64 {
        let Some(lapped) = shown.lapped().filter(|_| self.changes()) else {
            self.viewport.playing = false;
            return 0;
        };
        if self.viewport.playing {
            self.viewport.clock += f64::from(ui.input(|i| i.unstable_dt)).min(LONGEST_STEP);
        }
        let clock = self.viewport.clock;
        let left = self.graphics.renderer.set_time(shown.subject.patches(), clock);
        if self.viewport.playing && left.is_finite() {
            ui.ctx().request_repaint_after_secs(left as f32);
        }
        let frames = lapped.exemplars.iter().filter_map(Exemplar::frames);
        frames.fold(0, |number, frames| number * frames.count() as u64 + frames.at(clock) as u64)
    }

    /// What watching does with the view.
    fn watch_view(&mut self, ui: &Ui, shown: &Shown, view: &egui::Response) {
        let Some(watch) = &mut self.watch else { return };
        if let Some(at) = view.interact_pointer_pos().filter(|_| view.clicked()) {
            watch.click(self.steer.pick(shown, &self.viewport, at));
        }
        watch.paint(ui, &self.viewport, &self.steer);
    }

    /// The panel of watching.
    pub(super) fn watching(&mut self, ui: &mut Ui) {
        if let Some(watch) = &mut self.watch {
            watch.show(ui);
        }
    }

    /// The comb's panel.
    pub(super) fn combing(&mut self, ui: &mut Ui) {
        let shown = self.shown.clone().filter(|shown| self.steer.ready(shown));
        let edit = match &shown {
            Some(shown) => self.steer.with(shown, |combing, ground| super::steer::panel::show(ui, combing, Some(ground))).flatten(),
            None => super::steer::panel::show(ui, &mut self.steer.combing, None),
        };
        if let Some(edit) = edit {
            self.edit(edit.what, |project| put(project, &edit));
        }
    }

    /// The editor of outlines, in all the room there is.
    pub(super) fn cutting(&mut self, ui: &mut Ui) {
        let Some(mut room) = self.cut.take() else { return };
        let project = self.document.project();
        let Some(exemplar) = project.exemplars.get(room.index).filter(|e| room.is_of(&e.link)) else { return };
        room.follow(&exemplar.shapes);
        let (index, feather) = (room.index, project.feather);
        let names: Vec<String> = project.exemplars.iter().map(|e| shortened(&e.link.name(), NAME)).collect();
        match room.show(ui, feather, &names) {
            Some(Wanted::Close) => return,
            Some(Wanted::Exemplar(index)) => return self.cut_exemplar(index, &ui.ctx().clone()),
            Some(Wanted::Shapes(shapes)) => {
                self.edit("outline", |p| p.exemplars[index].shapes = shapes);
                self.document.end_gesture();
            }
            None => {}
        }
        self.cut = Some(room);
    }

    pub(super) fn toggle_cutting(&mut self, context: &Context) {
        if self.cut.take().is_some() {
            return;
        }
        self.cut_exemplar(0, context);
    }

    /// Cuts patches from one of the exemplars.
    pub fn cut_exemplar(&mut self, index: usize, context: &Context) {
        let exemplar = self.document.project().exemplars.get(index).cloned();
        let read = exemplar.as_ref().and_then(|e| self.library.known(&e.link));
        match (exemplar, read) {
            (Some(exemplar), Some(read)) => self.cut = Some(CutRoom::new(index, &exemplar, read, waker(context))),
            _ => self.tell("there is no exemplar to cut patches from yet: choose one first", false),
        }
    }

    pub(super) fn toggle_watching(&mut self, context: &Context) {
        if self.watch.take().is_some() {
            return;
        }
        self.steer.on = false;
        self.watch = self.shown.clone().and_then(|shown| WatchRoom::new(shown, waker(context)));
        if self.watch.is_none() {
            self.tell("there are no pastes to watch yet: choose a model and an exemplar first", false);
        }
    }

    /// Keeps the rooms at what is shown.
    pub(super) fn follow(&mut self, ui: &Ui) {
        let Some(shown) = self.shown.clone() else {
            self.watch = None;
            return;
        };
        if let Err(trouble) = self.steer.follow(&shown, self.document.project()) {
            self.tell(trouble, true);
        }
        if self.watch.as_ref().is_some_and(|watch| !watch.is_of(&shown)) {
            self.watch = WatchRoom::new(Arc::clone(&shown), waker(ui.ctx()));
        }
        if let Some(watch) = &mut self.watch {
            watch.follow(ui, &self.graphics.renderer);
        }
    }
}

/// Asks for a frame.
fn waker(context: &Context) -> impl Fn() + Clone + Send + Sync + 'static {
    let context = context.clone();
    move || context.request_repaint()
}
