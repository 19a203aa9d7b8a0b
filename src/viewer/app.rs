//! All of the viewer but its window.

use super::action::Action;
use super::build::{BuildError, Kitchen, Shown};
use super::cut::room::CutRoom;
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
use super::steer::room::SteerRoom;
use super::synth::SynthRoom;
use super::trace::Trace;
use super::viewport::Viewport;
use super::watch::room::WatchRoom;
use super::worker::Lane;
use crate::job::Project;
use egui::{Context, Ui};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

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
    /// Syntheses beside the pastes.
    pub synth: SynthRoom,
    pub(super) builds: Lane<Result<Option<Box<Shown>>, BuildError>>,
    pub(super) kitchen: Arc<Kitchen>,
    /// The revision that was asked for last, and what was built for it.
    pub(super) asked: u64,
    pub(super) building: Option<Project>,
    /// The model whose frame was taken last, so that another one is framed anew.
    pub(super) framed: Option<crate::job::Link>,
    /// The revision that is kept against crashes, and when that was.
    pub(super) kept: (u64, f64),
    /// Seconds that the work before this took.
    pub(super) last_job: Option<(&'static str, f64)>,
    pub(super) trace: Trace,
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
            synth: SynthRoom::new(wake()),
            still: Still::new(wake()),
            opens: Lane::new("lapped opening", wake()),
            saves: Lane::new("lapped saving", wake()),
            exports: Lane::new("lapped exporting", wake()),
            dialogs: Lane::new("lapped dialogs", wake()),
            builds: Lane::new("lapped pasting", wake()),
            kitchen: Arc::default(),
            asked: 0,
            building: None,
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

    pub(super) fn add(&mut self, notice: Notice) {
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
        self.synth.cancel();
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
            Action::ExportPicture | Action::ExportRecord | Action::ExportBaked | Action::ExportSynthesis => {
                self.ask_where_to_export(action);
            }
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
            Action::Play => self.viewport.playing = !self.viewport.playing && self.changes(),
            Action::Split => self.viewport.split = if self.viewport.split.is_some() { None } else { Some(0.5) },
            Action::NextMode => {
                let place = Mode::ALL.iter().position(|m| *m == self.viewport.modes[0]).unwrap_or(0);
                self.viewport.modes[0] = Mode::ALL[(place + 1) % Mode::ALL.len()];
            }
            Action::Compare => self.viewport.compare(),
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
                (self.asked, self.building) = (0, None);
                self.synth.forget();
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
            self.building = None;
            self.opens.cancel();
            self.exports.cancel();
            self.side.cancel();
            self.synth.cancel();
        }
    }

    /// One frame of the interface.
    pub fn ui(&mut self, ui: &mut Ui) {
        self.timed("results", |app| app.take_results(ui.ctx()));
        let typing = ui.ctx().text_edit_focused();
        let mut pressed = Vec::new();
        if self.question.is_none() {
            pressed.extend(std::iter::from_fn(|| ui.input_mut(|input| Action::pressed(input, typing))));
        }
        self.take_drops(ui.ctx());
        self.timed("rooms", |app| app.follow(ui));
        self.timed("panels", |app| panels::show(app, ui));
        if !ui.input(|i| i.pointer.any_down()) && !typing {
            self.document.end_gesture();
        }
        // After what the mouse did: in a slow frame a slider is let go and undone at once.
        for action in pressed {
            self.act(action, &ui.ctx().clone());
            ui.ctx().request_repaint();
        }
        self.timed("asking", |app| app.ask_for_work(ui));
    }

    /// Does a part of a frame and tells the trace how long it took.
    pub(super) fn timed<T>(&mut self, part: &'static str, deed: impl FnOnce(&mut Self) -> T) -> T {
        let begin = Instant::now();
        let done = deed(self);
        self.trace.part(part, begin.elapsed());
        done
    }

    /// How long the interface works is told to the trace by whoever drives it; tests do so by this.
    pub fn timed_ui(&mut self, ui: &mut Ui) {
        let begin = Instant::now();
        self.trace.begin_frame();
        self.ui(ui);
        self.trace.frame(begin.elapsed());
    }
}
