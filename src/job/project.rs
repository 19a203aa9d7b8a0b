//! Projects: all that somebody chose for one model, in one file that opens again as it was saved.
//!
//! The file is JSON. It names the model and the exemplars, and holds everything else: size, direction with its constraints, texture
//! patches with their outlines, seed, camera. Pasting is deterministic, so the same choices give the same pastes; a
//! fingerprint tells when a named file has changed since. Files in the project's own folder and below are named from there,
//! so that a folder may be moved as a whole. `docs/formats.md` describes the keys.

use super::base::Base;
use super::beside::Synthesis;
use super::input::{ExemplarInput, PasteJob, Scale, Steer};
use crate::exemplar::symmetry::exemplar_symmetry;
use crate::exemplar::{Exemplar, Outline, PatchOptions, PatchSource, PatchSpec};
use crate::field::Constraints;
use crate::format::{FormatError, read_file, read_mask, write_file};
use crate::paste::PasteOptions;
use glam::{DVec3, Vec2};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// The version of the project file.
pub const PROJECT_VERSION: u32 = 1;

/// The ending of project files.
pub const PROJECT_EXTENSION: &str = "lapped";

/// Something that is opened: built into the program, or a file.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum Link {
    /// A demo asset, by its name.
    BuiltIn(String),
    /// A file; of a material set its folder or prefix.
    File(PathBuf),
}

impl Link {
    /// What to call it: the asset's name, or the file's.
    #[must_use]
    pub fn name(&self) -> String {
        match self {
            Self::BuiltIn(name) => name.clone(),
            Self::File(path) => path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned(),
        }
    }
}

/// A shape of texture patches.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum Shape {
    /// The whole exemplar.
    Whole,
    /// The largest disc.
    Circle,
    /// Random smooth blobs.
    Splotch,
    /// An image as mask.
    Mask(PathBuf),
    /// A polygon drawn by the user, fractions of the exemplar's size.
    Outline(Vec<[f32; 2]>),
}

/// An exemplar of a project.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct ProjectExemplar {
    /// Where it comes from.
    pub link: Link,
    /// How often it is pasted, relative to the others.
    #[serde(default = "one")]
    pub weight: f32,
    /// Shapes of its texture patches. Empty: its own transparency if it has any, else splotches.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub shapes: Vec<Shape>,
    /// What its file held when the project was saved.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fingerprint: Option<String>,
}

const fn one() -> f32 {
    1.0
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "as serde calls it")]
const fn is_off(switch: &bool) -> bool {
    !*switch
}

fn is_usual(synthesis: &Synthesis) -> bool {
    *synthesis == Synthesis::default()
}

impl ProjectExemplar {
    /// An exemplar with nothing chosen for it yet.
    #[must_use]
    pub const fn new(link: Link) -> Self {
        Self { link, weight: 1.0, shapes: Vec::new(), fingerprint: None }
    }
}

/// How large the texture is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum Size {
    /// The surface has so many times the first exemplar's area.
    Ratio(f64),
    /// World length of one exemplar width.
    World(f64),
}

/// Which way the texture lies.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum Direction {
    /// Along an axis projected onto the surface; constraints, where there are any, decide around them.
    Up([f64; 3]),
    /// Along the direction in which the surface bends least.
    Curvature,
    /// The smoothest field of so many ways.
    Relaxed(u32),
    /// As the first exemplar's own symmetry asks for.
    Auto,
    /// None: every paste lies its own way.
    None,
}

/// A camera around a model.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct ProjectView {
    /// Turn about the up axis and height above the horizon, radians.
    pub turn: [f64; 2],
    /// The point looked at.
    pub at: [f64; 3],
    /// Distance of the eye from there.
    pub distance: f64,
    /// Z is up, not Y.
    #[serde(default)]
    pub z_up: bool,
}

/// A project.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields, default)]
pub struct Project {
    /// [`PROJECT_VERSION`].
    pub version: u32,
    /// The model.
    pub model: Option<Link>,
    /// What its file held when the project was saved.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fingerprint: Option<String>,
    /// The exemplars.
    pub exemplars: Vec<ProjectExemplar>,
    /// How large the texture is.
    pub size: Size,
    /// Which way it lies.
    pub direction: Direction,
    /// What is asked for at some places.
    pub constraints: Constraints,
    /// Pixels over which alpha falls off at a patch's edge; absent: by each exemplar's size.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub feather: Option<f32>,
    /// Different splotches per exemplar.
    pub splotches: u32,
    /// Growth stops where the stretch is more than this; absent: by the direction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distortion: Option<f64>,
    /// Leave large faces as they are.
    pub keep_faces: bool,
    /// Each paste shows the part of its exemplar that agrees best with what lies around it, and ends where that shows least; others
    /// are laid over hard edges.
    pub windows: bool,
    /// With `windows`, smaller pastes are laid over hard edges that still show.
    #[serde(skip_serializing_if = "is_off")]
    pub small: bool,
    /// With `windows`, contrast is kept where pastes fade.
    #[serde(skip_serializing_if = "is_off")]
    pub contrast: bool,
    /// Slow changes of light are taken out of the exemplars.
    #[serde(skip_serializing_if = "is_off")]
    pub equalize: bool,
    /// What the exemplars' detail alone lies over; absent: they are pasted as they are.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub base: Option<Base>,
    /// Seed of all random choices.
    pub seed: u64,
    /// The synthesis that the pastes are compared with.
    #[serde(skip_serializing_if = "is_usual")]
    pub synthesis: Synthesis,
    /// The camera; absent: one that shows all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view: Option<ProjectView>,
}

impl Default for Project {
    fn default() -> Self {
        Self {
            version: PROJECT_VERSION,
            model: None,
            fingerprint: None,
            exemplars: Vec::new(),
            size: Size::Ratio(crate::field::DEFAULT_RATIO),
            direction: Direction::Up([0.0, 1.0, 0.0]),
            constraints: Constraints::default(),
            feather: None,
            splotches: 3,
            distortion: None,
            keep_faces: false,
            windows: true,
            small: false,
            contrast: false,
            equalize: false,
            base: None,
            seed: 1,
            synthesis: Synthesis::default(),
            view: None,
        }
    }
}

/// Why a project cannot be opened or saved.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ProjectError {
    /// The file.
    #[error(transparent)]
    File(#[from] FormatError),
    /// It is no project.
    #[error("{file}: this is no project of lapped: {reason}; open a .{PROJECT_EXTENSION} file, or a mesh or an image")]
    Syntax {
        /// The file.
        file: String,
        /// What is wrong, with line and column.
        reason: String,
    },
    /// A project of another version.
    #[error("{file}: this project has version {found}; this program reads version {PROJECT_VERSION}: open it with a newer one")]
    Version {
        /// The file.
        file: String,
        /// Its version.
        found: u32,
    },
}

impl Project {
    /// Reads a project; the files it names are looked for from its folder.
    ///
    /// # Errors
    /// If the file cannot be read or is no project.
    pub fn read(path: &Path) -> Result<Self, ProjectError> {
        let bytes = read_file(path, "the project")?;
        let file = || path.display().to_string();
        let read: Result<Self, _> = serde_json::from_slice(&bytes);
        let mut project = read.map_err(|e| ProjectError::Syntax { file: file(), reason: e.to_string() })?;
        if project.version != PROJECT_VERSION {
            return Err(ProjectError::Version { file: file(), found: project.version });
        }
        let folder = absolute(path).parent().map(Path::to_owned).unwrap_or_default();
        project.each_path(|p| *p = folder.join(&*p));
        Ok(project)
    }

    /// Writes a project, whole or not at all, with fingerprints of the files it names.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), ProjectError> {
        let folder = absolute(path).parent().map(Path::to_owned).unwrap_or_default();
        let mut out = self.clone();
        out.fingerprint = out.model.as_ref().and_then(fingerprint);
        for exemplar in &mut out.exemplars {
            exemplar.fingerprint = fingerprint(&exemplar.link);
        }
        out.each_path(|p| {
            if let Ok(inside) = absolute(p).strip_prefix(&folder) {
                *p = inside.to_owned();
            }
        });
        let text = serde_json::to_vec_pretty(&out)
            .map_err(|e| ProjectError::Syntax { file: path.display().to_string(), reason: e.to_string() })?;
        Ok(write_file(path, |file| file.write_all(&text))?)
    }

    /// Names of files that hold something else than when the project was saved, or are gone.
    #[must_use]
    pub fn changed_files(&self) -> Vec<String> {
        let model = self.model.iter().map(|link| (link, &self.fingerprint));
        let exemplars = self.exemplars.iter().map(|e| (&e.link, &e.fingerprint));
        let changed = |(link, then): (&Link, &Option<String>)| (then.is_some() && fingerprint(link) != *then).then(|| link.name());
        model.chain(exemplars).filter_map(changed).collect()
    }

    /// Calls for every path in the project.
    fn each_path(&mut self, mut change: impl FnMut(&mut PathBuf)) {
        let exemplars = self.exemplars.iter_mut();
        let (links, shapes): (Vec<_>, Vec<_>) = exemplars.map(|e| (&mut e.link, &mut e.shapes)).unzip();
        for link in self.model.iter_mut().chain(links) {
            if let Link::File(path) = link {
                change(path);
            }
        }
        for shape in shapes.into_iter().flatten() {
            if let Shape::Mask(path) = shape {
                change(path);
            }
        }
    }

    /// True if another project asks for the same pastes on the same model.
    #[must_use]
    pub fn pastes_as(&self, other: &Self) -> bool {
        let pasting = |p: &Self| Self { view: None, synthesis: Synthesis::default(), ..p.clone() };
        pasting(self) == pasting(other)
    }

    /// The job that the project asks for; `first` is its first exemplar, which decides where the direction is left to it.
    #[must_use]
    pub fn job(&self, first: Option<&Exemplar>) -> PasteJob {
        let (small, contrast) = (self.small, self.contrast);
        let paste = PasteOptions { seed: self.seed, distortion: self.distortion, small, contrast, ..PasteOptions::default() };
        PasteJob {
            scale: match self.size {
                Size::Ratio(ratio) => Scale::Ratio(ratio),
                Size::World(length) => Scale::World(length),
            },
            steer: self.steer(first),
            keep_faces: self.keep_faces,
            feather: self.feather,
            base: self.base,
            patches: PatchOptions { seed: self.seed, splotches: self.splotches, ..PatchOptions::default() },
            paste: if self.windows { paste } else { paste.plain() },
            ..PasteJob::default()
        }
    }

    fn steer(&self, first: Option<&Exemplar>) -> Steer {
        let held = !self.constraints.constraints.is_empty();
        match self.direction {
            Direction::Up(axis) if held => Steer::Constraints(self.constraints.clone(), DVec3::from(axis)),
            Direction::Up(axis) => Steer::Up(DVec3::from(axis)),
            Direction::Curvature => Steer::Curvature,
            Direction::Relaxed(ways) => Steer::Relaxed(ways),
            Direction::None => Steer::Isotropic(held.then(|| self.constraints.clone())),
            Direction::Auto => match first.and_then(exemplar_symmetry) {
                Some(found) if found.isotropic => Steer::Isotropic(None),
                Some(found) => Steer::Relaxed(found.n),
                None => Steer::Relaxed(1),
            },
        }
    }
}

impl ProjectExemplar {
    /// The exemplar with the patches chosen for it.
    ///
    /// # Errors
    /// If a mask cannot be read.
    pub fn input(&self, exemplar: Exemplar) -> Result<ExemplarInput, FormatError> {
        let source = |shape: &Shape| {
            Ok(match shape {
                Shape::Whole => PatchSource::Whole,
                Shape::Circle => PatchSource::Circle,
                Shape::Splotch => PatchSource::Splotch,
                Shape::Mask(path) => PatchSource::Mask { name: path.display().to_string(), image: read_mask(path)? },
                Shape::Outline(points) => PatchSource::Outlines {
                    name: "the drawn outline".to_owned(),
                    outlines: vec![Outline { points: points.iter().copied().map(Vec2::from_array).collect() }],
                },
            })
        };
        let spec = |shape| source(shape).map(|source| PatchSpec { source, weight: 1.0 });
        let patches = self.shapes.iter().map(spec).collect::<Result<_, FormatError>>()?;
        Ok(ExemplarInput { exemplar, weight: self.weight, patches })
    }
}

fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned())
}

/// A hash of a file's bytes (FNV-1a, 64 bits); none of what is built in, is a folder, or cannot be read.
fn fingerprint(link: &Link) -> Option<String> {
    let Link::File(path) = link else { return None };
    let bytes = std::fs::read(path).ok()?;
    let step = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
    Some(format!("{:016x}", bytes.iter().fold(0xcbf2_9ce4_8422_2325, step)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Constraint;

    fn project(folder: &Path) -> Project {
        let file = |name: &str| Link::File(folder.join(name));
        let shapes = vec![Shape::Circle, Shape::Outline(vec![[0.1, 0.2], [0.9, 0.1], [0.5, 0.8]])];
        let stone = Link::BuiltIn("stone".into());
        Project {
            model: Some(file("a.ply")),
            exemplars: vec![
                ProjectExemplar { shapes, weight: 0.25, ..ProjectExemplar::new(file("maps/b.png")) },
                ProjectExemplar::new(stone),
            ],
            size: Size::World(0.1),
            direction: Direction::Up([0.0, 0.6, 0.8]),
            constraints: Constraints {
                constraints: vec![Constraint { face: Some(3), scale: Some(1.0 / 3.0), ..Constraint::default() }],
                ..Constraints::default()
            },
            feather: Some(2.5),
            small: true,
            equalize: true,
            base: Some("#8a5a3c".parse().expect("a colour")),
            synthesis: Synthesis { exemplar: 1, vertices: 20_000, seed: 9 },
            view: Some(ProjectView { turn: [0.1, -0.3], at: [1.0, 2.0, 1.0 / 3.0], distance: 4.0, z_up: true }),
            ..Project::default()
        }
    }

    #[test]
    fn switches_of_borders_count_where_borders_are_matched_and_are_written_where_they_are_on() {
        let on = Project { small: true, contrast: true, ..Project::default() };
        let switches = |p: &Project| (p.job(None).paste.small, p.job(None).paste.contrast);
        assert_eq!(switches(&on), (true, true), "they reach the job");
        assert_eq!(switches(&Project { windows: false, ..on.clone() }), (false, false), "plain pastes have neither");
        assert_eq!(switches(&Project::default()), (false, false), "nobody asked");
        let written = |p: &Project| serde_json::to_value(p).expect("JSON").as_object().map(|o| o.contains_key("small"));
        assert_eq!([&on, &Project::default()].map(written), [Some(true), Some(false)], "older versions read projects without them");
    }

    #[test]
    fn a_base_reaches_the_job_and_is_written_as_the_command_line_has_it() {
        for text in ["own", "vertex", "#8a5a3c"] {
            let over = Project { base: Some(text.parse().expect("a base")), ..Project::default() };
            assert_eq!(over.job(None).base, over.base, "{text}");
            assert_eq!(serde_json::to_value(&over).expect("JSON")["base"], text);
        }
        assert!(serde_json::from_str::<Project>("{\"base\": \"mud\"}").is_err(), "no base");
    }

    #[test]
    fn a_project_comes_back_as_it_was_saved_from_a_moved_folder_too() {
        let folder = tempfile::tempdir().expect("a folder");
        let before = folder.path().join("before");
        std::fs::create_dir_all(before.join("maps")).expect("made");
        std::fs::write(before.join("a.ply"), b"ply").expect("written");
        let saved = project(&before);
        saved.write(&before.join("p.lapped")).expect("saved");
        let after = folder.path().join("after");
        std::fs::rename(&before, &after).expect("moved");
        let read = Project::read(&after.join("p.lapped")).expect("read");
        assert!(read.fingerprint.is_some(), "of the model's file");
        assert_eq!(Project { fingerprint: None, ..read.clone() }, project(&after), "everything, to the last bit");
        assert!(read.changed_files().is_empty(), "nothing changed");
        std::fs::write(after.join("a.ply"), b"plx").expect("written");
        assert_eq!(read.changed_files(), ["a.ply"], "another content is told");
    }

    #[test]
    fn what_is_no_project_is_told_with_its_place() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("p.lapped");
        for (text, word) in [("{", "line 1"), (r#"{"sed":1}"#, "sed"), (r#"{"version":9}"#, "version 9")] {
            std::fs::write(&path, text).expect("written");
            let told = Project::read(&path).expect_err("no project").to_string();
            assert!(told.contains(word) && told.contains("p.lapped"), "{told}");
        }
    }
}
