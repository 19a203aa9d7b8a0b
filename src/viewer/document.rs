//! What is open: a project, the way back from every change to it, and whether it is saved.

use crate::job::Project;
use crate::job::project::Link;
use std::path::{Path, PathBuf};

/// The most changes that can be undone.
const MOST_STEPS: usize = 200;

/// A project that is worked on.
#[derive(Debug, Default)]
pub struct Document {
    project: Project,
    past: Vec<Step>,
    future: Vec<Step>,
    /// The project as its file has it, and the file.
    saved: Project,
    path: Option<PathBuf>,
    /// The change that goes on, as a slider is dragged: it is undone as one.
    gesture: Option<&'static str>,
    revision: u64,
}

/// A change: its name, and the project on the other side of it.
#[derive(Debug)]
struct Step {
    name: &'static str,
    project: Project,
}

impl Document {
    /// The project.
    #[must_use]
    pub const fn project(&self) -> &Project {
        &self.project
    }

    /// Counts up with every change, undone ones too.
    #[must_use]
    pub const fn revision(&self) -> u64 {
        self.revision
    }

    /// Changes the project; `name` is what the change is called where it can be undone. Changes of one name are one until
    /// [`Document::end_gesture`]. True if anything is different now.
    pub fn edit(&mut self, name: &'static str, change: impl FnOnce(&mut Project)) -> bool {
        let mut project = self.project.clone();
        change(&mut project);
        if project == self.project {
            return false;
        }
        let before = std::mem::replace(&mut self.project, project);
        if self.gesture != Some(name) {
            self.past.push(Step { name, project: before });
            if self.past.len() > MOST_STEPS {
                self.past.remove(0);
            }
        }
        self.gesture = Some(name);
        self.future.clear();
        self.revision += 1;
        true
    }

    /// The next change is one of its own.
    pub const fn end_gesture(&mut self) {
        self.gesture = None;
    }

    /// Takes the last change back and says its name.
    pub fn undo(&mut self) -> Option<&'static str> {
        let step = self.past.pop()?;
        let project = std::mem::replace(&mut self.project, step.project);
        self.future.push(Step { name: step.name, project });
        self.moved();
        Some(step.name)
    }

    /// Makes the change that was taken back last again and says its name.
    pub fn redo(&mut self) -> Option<&'static str> {
        let step = self.future.pop()?;
        let project = std::mem::replace(&mut self.project, step.project);
        self.past.push(Step { name: step.name, project });
        self.moved();
        Some(step.name)
    }

    fn moved(&mut self) {
        self.gesture = None;
        self.revision += 1;
    }

    /// What undoing, and making again, would concern.
    #[must_use]
    pub fn steps(&self) -> [Option<&'static str>; 2] {
        [&self.past, &self.future].map(|steps| steps.last().map(|s| s.name))
    }

    /// Opens another project; `path` is its file, if it has one. Nothing can be undone then.
    pub fn open(&mut self, project: Project, path: Option<PathBuf>) {
        let revision = self.revision + 1;
        *self = Self { saved: project.clone(), project, path, revision, ..Self::default() };
    }

    /// The project was written to a file as it was then.
    pub fn saved(&mut self, project: Project, path: PathBuf) {
        self.saved = project;
        self.path = Some(path);
    }

    /// Its file.
    #[must_use]
    pub fn path(&self) -> Option<&Path> {
        self.path.as_deref()
    }

    /// True if there is work that no file holds. Where the camera stands is no work.
    #[must_use]
    pub fn unsaved(&self) -> bool {
        let work = |project: &Project| Project { view: None, ..project.clone() };
        work(&self.project) != work(&self.saved)
    }

    /// What to call it.
    #[must_use]
    pub fn title(&self) -> String {
        let file = self.path.as_ref().and_then(|p| p.file_stem()).map(|s| s.to_string_lossy().into_owned());
        file.or_else(|| self.project.model.as_ref().map(Link::name)).unwrap_or_else(|| "untitled".to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_go_back_and_forth_and_a_dragged_one_is_one() {
        let mut document = Document::default();
        let first = document.project().clone();
        for seed in 2..9 {
            assert!(document.edit("seed", |p| p.seed = seed), "another seed");
        }
        document.end_gesture();
        assert!(!document.edit("seed", |p| p.seed = 8), "nothing is different");
        document.edit("seed", |p| p.seed = 20);
        document.edit("splotches", |p| p.splotches = 5);
        assert!(document.unsaved(), "no file holds it");
        assert_eq!(document.undo(), Some("splotches"), "the last change");
        assert_eq!((document.undo(), document.project().seed), (Some("seed"), 8), "a change of its own");
        assert_eq!((document.undo(), document.project()), (Some("seed"), &first), "the dragged one as a whole");
        assert_eq!((document.undo(), document.unsaved()), (None, false), "where it began");
        while document.redo().is_some() {}
        assert_eq!((document.project().seed, document.project().splotches), (20, 5), "all again");
        document.undo();
        document.edit("seed", |p| p.seed = 1);
        assert_eq!(document.steps(), [Some("seed"), None], "what was undone is gone after a new change");
    }

    #[test]
    fn what_is_saved_is_what_was_written_not_what_came_after() {
        let mut document = Document::default();
        document.edit("seed", |p| p.seed = 2);
        let written = document.project().clone();
        document.edit("seed", |p| p.seed = 3);
        document.saved(written, "p.lapped".into());
        assert!(document.unsaved(), "the seed changed while it was written");
        document.undo();
        document.edit("seed", |p| p.seed = 2);
        assert!(!document.unsaved(), "back to what the file has");
        document.edit("view", |p| p.view = None);
        assert!(!document.unsaved(), "the camera is no work");
    }
}
