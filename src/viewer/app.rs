//! All of the viewer but its window.

use super::action::Action;
use super::build::{BuildError, Kitchen, Shown, build};
use super::cut::room::{CutRoom, Wanted};
use super::deeds::{Done, Still};
use super::document::Document;
use super::gallery::Thumbnails;
use super::graphics::Graphics;
use super::home::{Home, Settings};
use super::library::Library;
use super::lines::Lines;
use super::mode::Mode;
use super::panels;
use super::side::Side;
use super::steer::room::{SteerRoom, put};
use super::trace::Trace;
use super::viewport::{Given, Viewport};
use super::watch::room::WatchRoom;
use super::worker::Lane;
use crate::job::Project;
use crate::mesh::Mesh;
use egui::{Context, Ui};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

/// Seconds that unsaved work may be old before it is kept.
const KEEP_AFTER: f64 = 2.0;
/// Seconds at rest after which the reference renderer is asked.
const REST: f64 = 0.15;

/// Something the user is told.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Notice {
    /// A sentence: what is wrong, where, what to do.
    pub text: String,
    /// It is an error, not a hint.
    pub error: bool,
    /// It is about what is shown, and goes with the next picture.
    pub passing: bool,
}

/// What a question is about that stands between the user and a deed.
#[derive(Debug, Clone, PartialEq)]
pub enum Question {
    /// There is unsaved work, and this would lose it.
    Unsaved(Loss),
    /// The name of a file is wanted; what is typed so far.
    Name(super::deeds::Purpose, String),
    /// Work was left behind by a crash, in this file.
    Recover(PathBuf, Box<Project>),
}

/// What would lose unsaved work.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Loss {
    /// Closing the window.
    Quit,
    /// Beginning anew.
    New,
    /// Opening a project.
    Open(PathBuf),
}

/// The viewer.
#[derive(Debug)]
pub struct App {
    /// What is open.
    pub document: Document,
    /// The three-dimensional view.
    pub viewport: Viewport,
    /// Lines on the surface.
    pub lines: Lines,
    /// What the user is told.
    pub notices: Vec<Notice>,
    /// What the user is asked.
    pub question: Option<Question>,
    /// Panels that can be closed.
    pub open_panels: OpenPanels,
    /// Combing.
    pub steer: SteerRoom,
    /// Outlines being cut.
    pub cut: Option<CutRoom>,
    /// Pastes being watched.
    pub watch: Option<WatchRoom>,
    /// Ask for files by their names in the window, not in the system's dialogs.
    pub own_dialogs: bool,
    pub(super) graphics: Graphics,
    pub(super) library: Arc<Library>,
    pub(super) settings: Settings,
    pub(super) home: Home,
    pub(super) shown: Option<Arc<Shown>>,
    pub(super) thumbnails: Thumbnails,
    pub(super) side: Side,
    pub(super) still: Still,
    pub(super) opens: Lane<Done>,
    pub(super) saves: Lane<Done>,
    pub(super) exports: Lane<Done>,
    pub(super) dialogs: Lane<Done>,
    builds: Lane<Result<Option<Box<Shown>>, BuildError>>,
    kitchen: Arc<Kitchen>,
    /// The revision that was asked for last.
    asked: u64,
    /// The model whose frame was taken last, so that another one is framed anew.
    framed: Option<crate::job::Link>,
    /// The revision that is kept against crashes, and when that was.
    kept: (u64, f64),
    /// Seconds that the work before this took.
    pub(super) last_job: Option<(&'static str, f64)>,
    trace: Trace,
    over: bool,
    /// What is done once the project is saved.
    pub(super) after_save: Option<Loss>,
}

/// Panels that can be closed.
#[derive(Debug, Clone, Copy)]
pub struct OpenPanels {
    /// Built-in models and exemplars.
    pub gallery: bool,
    /// Figures.
    pub figures: bool,
    /// Keys and the mouse.
    pub help: bool,
}

impl App {
    /// The viewer, drawn by a context's user interface; settings are kept in `home`, or the system's own place.
    #[must_use]
    pub fn new(context: &Context, graphics: Graphics, home: Option<PathBuf>) -> Self {
        let home = Home::new(home);
        let settings = home.settings();
        let wake = || {
            let context = context.clone();
            move || context.request_repaint()
        };
        let mut viewport = Viewport::default();
        viewport.prepare(&graphics);
        super::theme::apply(context, settings.dark);
        let question = home.left_behind().map(|(path, project)| Question::Recover(path, Box::new(project)));
        Self {
            document: Document::default(),
            viewport,
            lines: Lines::default(),
            notices: Vec::new(),
            question,
            steer: SteerRoom::new(wake()),
            cut: None,
            watch: None,
            own_dialogs: false,
            open_panels: OpenPanels { gallery: true, figures: true, help: false },
            library: Arc::default(),
            settings,
            home,
            shown: None,
            thumbnails: Thumbnails::new(wake()),
            side: Side::new(wake()),
            still: Still::new(wake()),
            opens: Lane::new("lapped opening", wake()),
            saves: Lane::new("lapped saving", wake()),
            exports: Lane::new("lapped exporting", wake()),
            dialogs: Lane::new("lapped dialogs", wake()),
            builds: Lane::new("lapped pasting", wake()),
            kitchen: Arc::default(),
            asked: 0,
            framed: None,
            kept: (0, 0.0),
            last_job: None,
            trace: Trace::default(),
            over: false,
            after_save: None,
            graphics,
        }
    }

    /// What the window is called.
    #[must_use]
    pub fn title(&self) -> String {
        let unsaved = if self.document.unsaved() { "*" } else { "" };
        format!("{unsaved}{} - lapped", self.document.title())
    }

    /// What is shown.
    #[must_use]
    pub fn shown(&self) -> Option<&Shown> {
        self.shown.as_deref()
    }

    /// True once all that was asked for is shown, and no work goes on.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        let built = self.asked == self.document.revision() && self.builds.meter().is_none();
        let files = [&self.opens, &self.saves, &self.exports].into_iter().all(|lane| lane.meter().is_none());
        let watched = self.watch.as_ref().is_none_or(WatchRoom::is_idle);
        built && files && watched && self.side.is_idle() && self.thumbnails.is_idle()
    }

    /// True once the window is to be closed.
    #[must_use]
    pub const fn is_over(&self) -> bool {
        self.over
    }

    /// Times of the session.
    #[must_use]
    pub const fn trace(&self) -> &Trace {
        &self.trace
    }

    /// The same, to be told of frames.
    pub const fn trace_mut(&mut self) -> &mut Trace {
        &mut self.trace
    }

    /// Tells the user something once.
    pub fn tell(&mut self, text: impl Into<String>, error: bool) {
        self.add(Notice { text: text.into(), error, passing: false });
    }

    fn add(&mut self, notice: Notice) {
        if !self.notices.contains(&notice) {
            self.notices.push(notice);
        }
    }

    /// Changes the project; see [`Document::edit`].
    pub fn edit(&mut self, name: &'static str, change: impl FnOnce(&mut Project)) {
        if self.document.edit(name, change) {
            self.trace.edited(name, self.document.revision());
        }
    }

    /// Closes the window, or asks first if there is unsaved work.
    pub fn ask_to_quit(&mut self) {
        self.lose(Loss::Quit);
    }

    /// Does what loses unsaved work, or asks first.
    pub fn lose(&mut self, loss: Loss) {
        if self.document.unsaved() {
            self.question = Some(Question::Unsaved(loss));
        } else {
            self.lose_now(loss);
        }
    }

    /// Does what loses unsaved work.
    pub fn lose_now(&mut self, loss: Loss) {
        self.question = None;
        match loss {
            Loss::Quit => self.over = true,
            Loss::New => self.begin(Project::default(), None),
            Loss::Open(path) => self.open(vec![path]),
        }
    }

    /// Begins with a project; `path` is its file.
    pub(super) fn begin(&mut self, project: Project, path: Option<PathBuf>) {
        self.document.open(project, path);
        self.framed = None;
        self.notices.clear();
        self.trace.edited("open", self.document.revision());
    }

    /// Goes on with work that was left behind; no file holds it yet.
    pub(super) fn recover(&mut self, project: Project) {
        self.begin(Project::default(), None);
        self.edit("recovery", |p| *p = project);
        self.document.end_gesture();
    }

    /// The window is closed: nothing is left to be recovered.
    pub fn close(&mut self) {
        self.builds.cancel();
        self.exports.cancel();
        self.home.let_go();
        self.home.remember(&self.settings);
    }

    /// Does a deed.
    pub fn act(&mut self, action: Action, context: &Context) {
        match action {
            Action::New => self.lose(Loss::New),
            Action::Open => self.ask_what_to_open(),
            Action::Save => self.save(),
            Action::SaveAs => self.ask_where_to_save(),
            Action::ExportPicture | Action::ExportRecord | Action::ExportBaked => self.ask_where_to_export(action),
            Action::Quit => self.ask_to_quit(),
            Action::Undo if self.cut.as_mut().is_some_and(CutRoom::back) => {}
            Action::Undo => self.step(Document::undo),
            Action::Redo => self.step(Document::redo),
            Action::Frame => {
                if let Some(shown) = self.shown.clone() {
                    self.viewport.frame(shown.mesh());
                }
            }
            Action::Turntable => self.viewport.turntable = !self.viewport.turntable,
            Action::Split => self.viewport.split = if self.viewport.split.is_some() { None } else { Some(0.5) },
            Action::NextMode => {
                let place = Mode::ALL.iter().position(|m| *m == self.viewport.modes[0]).unwrap_or(0);
                self.viewport.modes[0] = Mode::ALL[(place + 1) % Mode::ALL.len()];
            }
            Action::Comb => {
                self.steer.on = !self.steer.on;
                self.watch = None;
            }
            Action::Cut => self.toggle_cutting(context),
            Action::Watch => self.toggle_watching(context),
            Action::Arrows => self.lines.arrows = !self.lines.arrows,
            Action::Streamlines => self.lines.streamlines = !self.lines.streamlines,
            Action::Singularities => self.lines.singularities = !self.lines.singularities,
            Action::Edges => self.lines.edges = !self.lines.edges,
            Action::Reload => {
                self.library.forget();
                self.kitchen = Arc::default();
                self.asked = 0;
            }
            Action::Stop => self.stop(),
            Action::Theme => {
                self.settings.dark = !self.settings.dark;
                super::theme::apply(context, self.settings.dark);
                self.home.remember(&self.settings);
            }
            Action::Gallery => self.open_panels.gallery = !self.open_panels.gallery,
            Action::Figures => self.open_panels.figures = !self.open_panels.figures,
            Action::Help => self.open_panels.help = !self.open_panels.help,
        }
    }

    fn step(&mut self, step: impl FnOnce(&mut Document) -> Option<&'static str>) {
        if let Some(name) = step(&mut self.document) {
            self.trace.edited(name, self.document.revision());
        }
    }

    /// Closes what lies over the view, or else stops the work that goes on.
    fn stop(&mut self) {
        if self.open_panels.help {
            self.open_panels.help = false;
            return;
        }
        let cutting = self.cut.as_mut().is_some_and(CutRoom::escape);
        let combing = self.shown.clone().is_some_and(|shown| self.steer.escape(&shown));
        if !cutting && !combing {
            self.builds.cancel();
            self.opens.cancel();
            self.exports.cancel();
            self.side.cancel();
        }
    }

    /// What goes on, if anything does: what it is, its stage, and the share that is done if that is known.
    #[must_use]
    pub fn work(&self) -> Option<(&'static str, String, Option<f32>)> {
        let meters = [
            ("Opening", self.opens.meter()),
            ("Pasting", self.builds.meter()),
            ("Exporting", self.exports.meter()),
            ("Preparing", self.side.meter()),
        ];
        let (name, meter) = meters.into_iter().find_map(|(name, meter)| meter.map(|m| (name, m)))?;
        let (stage, share) = meter.state();
        Some((name, stage, share))
    }

    /// One frame of the interface.
    pub fn ui(&mut self, ui: &mut Ui) {
        self.take_results(ui.ctx());
        let typing = ui.ctx().text_edit_focused();
        if self.question.is_none() {
            while let Some(action) = ui.input_mut(|input| Action::pressed(input, typing)) {
                self.act(action, &ui.ctx().clone());
            }
        }
        self.take_drops(ui.ctx());
        self.follow(ui);
        panels::show(self, ui);
        if !ui.input(|i| i.pointer.any_down()) && !typing {
            self.document.end_gesture();
        }
        self.ask_for_work(ui);
    }

    /// The three-dimensional view, in all the room there is.
    pub(super) fn view(&mut self, ui: &mut Ui) {
        let shown = self.shown.clone();
        self.viewport.set_room(ui.max_rect(), ui.pixels_per_point());
        let mesh = shown.as_deref().map(Shown::mesh);
        let bounds = mesh.map(Mesh::bounds).map(|(low, high)| [low.as_dvec3(), high.as_dvec3()]);
        if let Some(shown) = &shown
            && self.framed.as_ref() != Some(&shown.open.link)
        {
            self.framed = Some(shown.open.link.clone());
            match &shown.project.view {
                Some(view) => self.viewport.orbit = super::orbit::Orbit::restored(view),
                None => self.viewport.frame(shown.mesh()),
            }
        }
        let pointed = shown.as_ref().map(|shown| self.steer.point(ui, &self.viewport, shown)).unwrap_or_default();
        if let Some(edit) = &pointed.edit {
            self.edit(edit.what, |project| put(project, edit));
        }
        let watched = self.watch.as_ref().and_then(WatchRoom::subject);
        let (side, still, which) = (&self.side, &self.still, self.lines);
        let wanted = Still::wanted(&self.viewport, ui.visuals().dark_mode, shown.as_deref());
        let given = |mode: Mode| {
            let (own, number) = shown.as_ref().map_or((None, 0), |s| (Some(&s.subject), s.number()));
            let still = (mode == Mode::Reference).then(|| still.picture(wanted.as_ref())).flatten();
            // Numbers of partial subjects must not be those of revisions.
            if let Some((subject, number)) = watched.filter(|_| matches!(mode, Mode::Single | Mode::Layered)) {
                return Given { subject: Some(subject), lines: None, still: None, number: u64::MAX - number };
            }
            let (subject, number) = if mode.is_made() { side.subject(mode) } else { (own, number) };
            let lines = shown.as_ref().and_then(|s| side.lines(s.number(), which));
            Given { subject, lines, still, number }
        };
        let seen = self.viewport.show(ui, &self.graphics, bounds, pointed.held, given);
        if let Some(error) = seen.error {
            self.tell(error.to_string(), true);
        }
        if let Some(shown) = &shown {
            self.steer.paint(ui, &self.viewport, shown);
            self.watch_view(ui, shown, &seen.response);
        }
    }

    /// What watching does with the view.
    fn watch_view(&mut self, ui: &Ui, shown: &Shown, view: &egui::Response) {
        let Some(watch) = &mut self.watch else { return };
        if let Some(at) = view.interact_pointer_pos().filter(|_| view.clicked()) {
            watch.click(self.steer.pick(shown, &self.viewport, at));
        }
        watch.paint(ui, &self.viewport);
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
        match room.show(ui, feather) {
            Some(Wanted::Close) => return,
            Some(Wanted::Shapes(shapes)) => {
                self.edit("outline", |p| p.exemplars[index].shapes = shapes);
                self.document.end_gesture();
            }
            None => {}
        }
        self.cut = Some(room);
    }

    fn toggle_cutting(&mut self, context: &Context) {
        if self.cut.take().is_some() {
            return;
        }
        let first = self.document.project().exemplars.first().cloned();
        let read = first.as_ref().and_then(|e| self.library.known(&e.link));
        match (first, read) {
            (Some(exemplar), Some(read)) => {
                self.cut = Some(CutRoom::new(0, &exemplar, read, waker(context)));
            }
            _ => self.tell("there is no exemplar to cut patches from yet: choose one first", false),
        }
    }

    fn toggle_watching(&mut self, context: &Context) {
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
    fn follow(&mut self, ui: &Ui) {
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

    /// Takes in what jobs have brought forth.
    fn take_results(&mut self, context: &Context) {
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
                Err(error) if error.is_cancelled() => {}
                Err(error) => self.add(Notice { text: error.to_string(), error: true, passing: true }),
            }
        }
        let lanes = [&self.opens, &self.saves, &self.exports, &self.dialogs];
        let done: Vec<Done> = lanes.into_iter().flat_map(Lane::take).collect();
        done.into_iter().for_each(|done| self.take_done(done));
        self.thumbnails.take(context);
        for error in self.side.take() {
            self.tell(error.to_string(), true);
        }
        self.still.take(context);
    }

    /// Asks for whatever is out of date.
    fn ask_for_work(&mut self, ui: &Ui) {
        let revision = self.document.revision();
        if revision != self.asked {
            self.asked = revision;
            let project = self.document.project().clone();
            let (kitchen, library) = (Arc::clone(&self.kitchen), Arc::clone(&self.library));
            let renderer = Arc::clone(&self.graphics.renderer);
            self.builds.submit(move |meter, deliver| {
                let make =
                    |draft| build(&project, revision, draft, &kitchen, &library, &renderer, &**meter).map(|s| s.map(Box::new));
                if project.windows && !project.exemplars.is_empty() {
                    let draft = make(true);
                    let failed = draft.is_err();
                    deliver(draft);
                    if failed {
                        return;
                    }
                }
                deliver(make(false));
            });
        }
        let now = ui.input(|i| i.time);
        if let Some(shown) = &self.shown {
            let modes: Vec<Mode> = self.viewport.seen_modes().collect();
            self.side.ask(&modes, shown, &self.graphics);
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

    /// How long the interface works is told to the trace by whoever drives it; tests do so by this.
    pub fn timed_ui(&mut self, ui: &mut Ui) {
        let begin = Instant::now();
        self.ui(ui);
        self.trace.frame(begin.elapsed());
    }
}

/// Asks for a frame.
fn waker(context: &Context) -> impl Fn() + Clone + Send + Sync + 'static {
    let context = context.clone();
    move || context.request_repaint()
}
