//! What is done with files, and pictures at rest: asked for here, done on other threads, taken in here.

use super::action::Action;
use super::app::{App, Question};
use super::build::Shown;
use super::gallery::{color_image, of_exemplar};
use super::library::{OpenExemplar, OpenModel};
use super::viewport::Viewport;
use super::worker::Lane;
use crate::atlas::AtlasError;
use crate::format::{FormatError, vertices, write_file, write_record, write_vertices};
use crate::job::bake::default_size;
use crate::job::project::{PROJECT_EXTENSION, ProjectExemplar};
use crate::job::{BakeJob, Bound, Link, Project, ProjectError, bake_record};
use crate::paste::{Composite, LappedTexture};
use crate::progress::Progress;
use crate::render::{Background, Camera, DrawOptions, Grid, Picture, RenderError, Stage, Visibility};
use crate::synth::VertexTexture;
use egui::{Context, TextureHandle, TextureId, TextureOptions};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Endings of images, which are exemplars; whatever else is no project is a model.
const IMAGES: [&str; 11] = ["png", "jpg", "jpeg", "webp", "tga", "bmp", "tif", "tiff", "exr", "hdr", "gif"];
/// Endings of models, for the dialog.
const MODELS: [&str; 5] = ["obj", "ply", "stl", "glb", "gltf"];
/// Samples along each side of a pixel of pictures that are written.
const SAMPLES: u32 = 3;
/// The longer side of pictures that are written, pixels at least.
const LEAST_SIDE: u32 = 1600;

/// Why a deed was not done.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DeedError {
    /// A file.
    #[error(transparent)]
    File(#[from] FormatError),
    /// Something that was to be opened.
    #[error(transparent)]
    Open(#[from] super::library::OpenError),
    /// A project.
    #[error(transparent)]
    Project(#[from] ProjectError),
    /// A bake.
    #[error(transparent)]
    Bake(#[from] AtlasError),
    /// A picture.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// There is nothing to write.
    #[error("there is no {0} to export yet: open a model and choose an exemplar first")]
    Nothing(&'static str),
    /// No synthesis is shown, or it is not whole.
    #[error("there is no synthesis to export yet: show Wei-Levoy or Chen-Dong and let it come to its end")]
    NoSynthesis,
}

/// A deed that is done.
#[derive(Debug)]
pub enum Done {
    /// Files were opened: models, exemplars, and what could not be.
    Opened(Vec<Arc<OpenModel>>, Vec<Arc<OpenExemplar>>, Vec<DeedError>),
    /// A project was opened, and these files have changed since it was saved.
    Project(PathBuf, Box<Project>, Vec<String>),
    /// A project was written.
    Saved(PathBuf, Box<Project>),
    /// A file was written.
    Written(PathBuf),
    /// Files were chosen in a dialog.
    Chosen(Purpose, Vec<PathBuf>),
    /// Unsaved work was kept, or could not be.
    Kept(Option<String>),
    /// It was not done.
    Failed(DeedError),
}

/// What files are chosen for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// To be opened.
    Open,
    /// To hold the project.
    Save,
    /// To hold a picture, a record or a baked model.
    Export(Action),
}

/// True if a path names an exemplar: an image, or a folder of maps.
fn is_exemplar(path: &Path) -> bool {
    let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    path.is_dir() || extension.is_some_and(|e| IMAGES.contains(&e.as_str()))
}

fn is_project(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case(PROJECT_EXTENSION))
}

impl App {
    /// Opens files, whatever they are; a project loses what is open, so unsaved work is asked about.
    pub fn open_all(&mut self, files: &[PathBuf]) {
        match files.iter().find(|path| is_project(path)) {
            Some(project) => self.lose(super::app::Loss::Open(project.clone())),
            None if !files.is_empty() => self.open(files.to_vec()),
            None => {}
        }
    }

    /// Opens files.
    pub(super) fn open(&mut self, files: Vec<PathBuf>) {
        let library = Arc::clone(&self.library);
        self.opens.submit(move |meter, deliver| {
            if let Some(path) = files.iter().find(|path| is_project(path)) {
                meter.stage("reading the project", 0);
                let read = Project::read(path).map(|project| {
                    let changed = project.changed_files();
                    Done::Project(path.clone(), Box::new(project), changed)
                });
                return deliver(read.unwrap_or_else(|e| Done::Failed(e.into())));
            }
            let (mut models, mut exemplars, mut errors) = (Vec::new(), Vec::new(), Vec::new());
            for path in files {
                meter.stage(&format!("reading {}", path.display()), 0);
                let link = Link::File(std::path::absolute(&path).unwrap_or(path.clone()));
                if is_exemplar(&path) {
                    library.exemplar(&link).map_or_else(|e| errors.push(e.into()), |read| exemplars.push(read));
                } else {
                    library.model(&link).map_or_else(|e| errors.push(e.into()), |read| models.push(read));
                }
            }
            deliver(Done::Opened(models, exemplars, errors));
        });
    }

    /// Files dropped onto the window.
    pub(super) fn take_drops(&mut self, context: &Context) {
        let dropped: Vec<PathBuf> = context.input(|i| i.raw.dropped_files.iter().map(|f| f.path().to_owned()).collect());
        self.open_all(&dropped);
    }

    /// Takes a model.
    pub fn set_model(&mut self, link: Link) {
        self.edit("model", |p| (p.model, p.view) = (Some(link), None));
        self.document.end_gesture();
    }

    /// Takes exemplars in place of those there are.
    pub fn set_exemplars(&mut self, links: Vec<Link>) {
        self.edit("exemplar", |p| p.exemplars = links.into_iter().map(ProjectExemplar::new).collect());
        self.document.end_gesture();
    }

    /// Saves the project, asking where if it has no file.
    pub fn save(&mut self) {
        match self.document.path().map(Path::to_owned) {
            Some(path) => self.save_to(path),
            None => self.ask_where_to_save(),
        }
    }

    /// Saves the project in a file.
    pub fn save_to(&mut self, path: PathBuf) {
        let path = if path.extension().is_some() { path } else { path.with_extension(PROJECT_EXTENSION) };
        let view = self.shown.is_some().then(|| self.viewport.orbit.saved());
        let project = Project { view, ..self.document.project().clone() };
        self.saves.submit(move |meter, deliver| {
            meter.stage("saving", 0);
            deliver(match project.write(&path) {
                Ok(()) => Done::Saved(path, Box::new(project)),
                Err(error) => Done::Failed(error.into()),
            });
        });
    }

    /// Keeps unsaved work against crashes.
    pub(super) fn keep_now(&mut self) {
        let (home, project) = (self.home.clone(), self.document.project().clone());
        if self.saves.meter().is_none() {
            self.saves.submit(move |_, deliver| deliver(Done::Kept(home.keep(&project).err().map(|e| e.to_string()))));
        }
    }

    /// Writes a picture, a record or a baked model of what is shown.
    pub fn export_to(&mut self, what: Action, path: PathBuf, dark: bool) {
        let Some(shown) = self.shown.clone() else {
            return self.tell(DeedError::Nothing("model").to_string(), true);
        };
        if shown.draft.is_some() && what != Action::ExportSynthesis {
            return self.tell("what is shown is a draft, its borders are being matched: export once that is done".to_owned(), true);
        }
        let camera = self.viewport.orbit.camera();
        let options = DrawOptions { occlusion: true, ..self.viewport.options(dark) };
        let pixels = self.viewport.pixels();
        let synthesis = self.synthesized();
        self.exports.submit(move |meter, deliver| {
            let written = match what {
                Action::ExportSynthesis => write_synthesis(&shown, synthesis.as_deref(), &path, &**meter),
                Action::ExportPicture => write_picture(&shown, &camera, pixels, &options, &path, &**meter),
                Action::ExportRecord => write_pastes(&shown, &path, None, &**meter),
                _ => write_pastes(&shown, &path, Some(()), &**meter),
            };
            deliver(written.map_or_else(Done::Failed, |()| Done::Written(path)));
        });
    }

    pub(super) fn ask_what_to_open(&mut self) {
        let all: Vec<&str> = MODELS.iter().chain(&IMAGES).copied().chain([PROJECT_EXTENSION]).collect();
        let dialog = rfd::FileDialog::new().set_title("Open").add_filter("Everything lapped opens", &all);
        self.ask(Purpose::Open, String::new(), move || dialog.pick_files());
    }

    pub(super) fn ask_where_to_save(&mut self) {
        let dialog = rfd::FileDialog::new().set_title("Save project").add_filter("Project", &[PROJECT_EXTENSION]);
        let name = format!("{}.{PROJECT_EXTENSION}", self.document.title());
        let dialog = dialog.set_file_name(&name);
        self.ask(Purpose::Save, name, move || dialog.save_file().map(|path| vec![path]));
    }

    pub(super) fn ask_where_to_export(&mut self, what: Action) {
        if self.shown.is_none() {
            return self.tell(DeedError::Nothing("model").to_string(), true);
        }
        if what == Action::ExportSynthesis && self.synthesized().is_none() {
            return self.tell(DeedError::NoSynthesis.to_string(), true);
        }
        let endings: &[&str] = match what {
            Action::ExportPicture => &["png"],
            Action::ExportSynthesis => &["glb", "ply"],
            _ => &["glb"],
        };
        let (ending, dialog) = (endings[0], rfd::FileDialog::new().set_title(what.name()));
        let dialog = endings.iter().fold(dialog, |dialog, ending| dialog.add_filter(*ending, &[ending]));
        let name = format!("{}.{ending}", self.document.title());
        let dialog = dialog.set_file_name(&name);
        self.ask(Purpose::Export(what), name, move || dialog.save_file().map(|path| vec![path]));
    }

    /// Asks for files on a thread of its own: dialogs of the system wait for an answer.
    fn ask(&mut self, purpose: Purpose, name: String, dialog: impl FnOnce() -> Option<Vec<PathBuf>> + Send + 'static) {
        if self.own_dialogs {
            self.question = Some(Question::Name(purpose, name));
        } else if self.dialogs.meter().is_none() {
            self.dialogs.submit(move |_, deliver| deliver(Done::Chosen(purpose, dialog().unwrap_or_default())));
        }
    }

    /// Takes in a deed that is done.
    pub(super) fn take_done(&mut self, done: Done) {
        match done {
            Done::Opened(models, exemplars, errors) => {
                let paths = models.iter().map(|m| &m.link).chain(exemplars.iter().map(|e| &e.link));
                for link in paths {
                    if let Link::File(path) = link {
                        self.settings.opened(path);
                    }
                }
                self.home.remember(&self.settings);
                if let Some(model) = models.last() {
                    self.set_model(model.link.clone());
                }
                if !exemplars.is_empty() {
                    self.set_exemplars(exemplars.iter().map(|e| e.link.clone()).collect());
                }
                for error in errors {
                    self.tell(error.to_string(), true);
                }
            }
            Done::Project(path, project, changed) => {
                self.settings.opened(&path);
                self.begin(*project, Some(path));
                for name in changed {
                    self.tell(
                        format!("{name} has changed since the project was saved, or is gone: what is shown may differ"),
                        false,
                    );
                }
            }
            Done::Saved(path, project) => {
                self.settings.opened(&path);
                self.home.remember(&self.settings);
                self.document.saved(*project, path);
                self.home.let_go();
                if let Some(loss) = self.after_save.take() {
                    self.lose(loss);
                }
            }
            Done::Written(path) => self.tell(format!("{} was written", path.display()), false),
            Done::Chosen(purpose, paths) => self.take_files(purpose, &paths),
            Done::Kept(None) => {}
            Done::Kept(Some(error)) => self.tell(format!("unsaved work cannot be kept against a crash: {error}"), false),
            Done::Failed(DeedError::Bake(AtlasError::Cancelled)) => {}
            Done::Failed(error) => {
                self.after_save = None;
                self.tell(error.to_string(), true);
            }
        }
    }

    /// Takes files that were chosen.
    pub(super) fn take_files(&mut self, purpose: Purpose, paths: &[PathBuf]) {
        match (purpose, paths.first()) {
            (_, None) => self.after_save = None,
            (Purpose::Open, _) => self.open_all(paths),
            (Purpose::Save, Some(path)) => self.save_to(path.clone()),
            (Purpose::Export(what), Some(path)) => self.export_to(what, path.clone(), self.settings.dark),
        }
    }

    /// The synthesis that is shown, if one is and it is whole; of two the right one.
    #[must_use]
    pub fn synthesized(&self) -> Option<Arc<VertexTexture>> {
        self.viewport
            .seen_modes()
            .filter_map(super::Mode::method)
            .filter_map(|method| self.synth.texture(method, self.shown()?))
            .last()
    }

    /// The small picture of an exemplar that was read.
    pub(super) fn picture_of(&mut self, context: &Context, link: &Link) -> Option<TextureId> {
        if self.thumbnails.of(link).is_none()
            && let Some(read) = self.library.known(link)
        {
            self.thumbnails.add(context, link.clone(), of_exemplar(&read.exemplar));
        }
        self.thumbnails.of(link).map(TextureHandle::id)
    }
}

fn write_picture(
    shown: &Shown,
    camera: &Camera,
    pixels: [u32; 2],
    options: &DrawOptions,
    path: &Path,
    progress: &dyn Progress,
) -> Result<(), DeedError> {
    progress.stage("drawing the picture", 0);
    let larger = (f64::from(LEAST_SIDE) / f64::from(pixels[0].max(pixels[1]).max(1))).max(1.0);
    let [width, height] = pixels.map(|s| ((f64::from(s) * larger).round() as u32).max(1));
    let picture = reference(shown, camera, Grid { width, height, samples: SAMPLES }, options)?;
    let png = picture.png()?;
    Ok(write_file(path, |file| file.write_all(&png))?)
}

/// A picture by the reference renderer.
fn reference(shown: &Shown, camera: &Camera, grid: Grid, options: &DrawOptions) -> Result<Picture, RenderError> {
    let nothing = LappedTexture::default();
    let mesh = shown.mesh();
    let texture = Composite::new(mesh, shown.lapped().unwrap_or(&nothing));
    let seen = Visibility::new(mesh, camera, grid)?;
    Ok(Stage::new(mesh, options).draw(&texture, &seen))
}

fn write_pastes(shown: &Shown, path: &Path, bake: Option<()>, progress: &dyn Progress) -> Result<(), DeedError> {
    progress.stage("gathering the pastes", 0);
    let mut record = shown.record().ok_or(DeedError::Nothing("texture"))?;
    if bake.is_some() {
        let failed = |source| super::library::OpenError::Mesh { file: shown.open.link.name(), source };
        let bound = Bound::new(record.clone()).map_err(failed)?;
        let job = BakeJob::sized(default_size(&bound.mesh, &bound.lapped));
        record = bake_record(record, &bound, &job, progress)?.0;
    }
    progress.stage("writing", 0);
    Ok(write_record(path, &record)?)
}

fn write_synthesis(shown: &Shown, texture: Option<&VertexTexture>, path: &Path, progress: &dyn Progress) -> Result<(), DeedError> {
    let texture = texture.ok_or(DeedError::NoSynthesis)?;
    let kind = vertices::Kind::of(path)?;
    progress.stage("writing", 0);
    Ok(write_vertices(path, kind, &shown.open.model.name, &texture.mesh, texture)?)
}

/// What a picture at rest is of.
#[derive(Debug, Clone, PartialEq)]
pub struct Wanted {
    revision: u64,
    camera: Camera,
    grid: Grid,
    options: DrawOptions,
}

/// A picture at rest, drawn by the reference renderer.
pub struct Still {
    lane: Lane<(Wanted, Result<Picture, RenderError>)>,
    asked: Option<Wanted>,
    there: Option<(Wanted, TextureHandle)>,
}

impl std::fmt::Debug for Still {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Still").field("asked", &self.asked).finish_non_exhaustive()
    }
}

impl Still {
    /// None yet; `wake` is called when one is there.
    pub fn new(wake: impl Fn() + Send + Sync + 'static) -> Self {
        Self { lane: Lane::new("lapped reference", wake), asked: None, there: None }
    }

    /// What a picture of the view would be of.
    #[must_use]
    pub fn wanted(viewport: &Viewport, dark: bool, shown: Option<&Shown>) -> Option<Wanted> {
        let [width, height] = viewport.pixels();
        let grid = Grid { width, height, samples: 2 };
        let background = match viewport.options(dark).background {
            Background::Plain(_) if viewport.backdrop == super::mode::Backdrop::Theme => Background::Studio,
            other => other,
        };
        let options = DrawOptions { occlusion: true, background, ..viewport.options(dark) };
        let camera = viewport.orbit.camera();
        shown.filter(|_| width.min(height) > 0).map(|shown| Wanted { revision: shown.number(), camera, grid, options })
    }

    /// The picture, if it is of what is wanted.
    #[must_use]
    pub fn picture(&self, wanted: Option<&Wanted>) -> Option<TextureId> {
        self.there.as_ref().filter(|(of, _)| Some(of) == wanted).map(|(_, texture)| texture.id())
    }

    /// Asks for a picture.
    pub fn ask(&mut self, wanted: Wanted, shown: &Arc<Shown>) {
        let there = self.there.as_ref().is_some_and(|(of, _)| *of == wanted);
        if there || self.asked.as_ref() == Some(&wanted) {
            return;
        }
        self.asked = Some(wanted.clone());
        let shown = Arc::clone(shown);
        self.lane.submit(move |_, deliver| {
            let drawn = reference(&shown, &wanted.camera, wanted.grid, &wanted.options);
            deliver((wanted, drawn));
        });
    }

    /// Takes in a picture that was drawn.
    pub fn take(&mut self, context: &Context) {
        for (wanted, drawn) in self.lane.take() {
            if let Ok(picture) = drawn {
                let texture = context.load_texture("reference", color_image(&picture), TextureOptions::LINEAR);
                self.there = Some((wanted, texture));
            }
        }
    }
}
