//! What can go wrong with a file: every message says which file, what is wrong, where, and what to do.

use crate::exemplar::ExemplarError;
use std::path::{Path, PathBuf};

/// Why a file cannot be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FormatError {
    /// There is no such file.
    #[error("{}: there is no such file: check the path", path.display())]
    Missing {
        /// The path given.
        path: PathBuf,
    },
    /// A folder where a file is needed.
    #[error("{}: this is a folder, not a file: name {wanted} in it", path.display())]
    Folder {
        /// The path given.
        path: PathBuf,
        /// What is looked for.
        wanted: &'static str,
    },
    /// The operating system refuses to read it.
    #[error("{}: cannot be read: {source}: check that it may be read", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        source: std::io::Error,
    },
    /// A file of zero bytes.
    #[error("{}: the file is empty: export or copy it again", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// A file of another kind than those that are read here.
    #[error("{}: {found}: {remedy}", path.display())]
    Unknown {
        /// The file.
        path: PathBuf,
        /// What it seems to be.
        found: String,
        /// What to do.
        remedy: String,
    },
    /// The file breaks the rules of its format, or uses a part of it that is not supported.
    #[error("{}: {}{what}: {remedy}", path.display(), place_prefix(place))]
    Malformed {
        /// The file.
        path: PathBuf,
        /// Where in the file; empty if it concerns the whole.
        place: String,
        /// What is wrong there.
        what: String,
        /// What to do.
        remedy: String,
    },
    /// No file of a material set carries the base colour.
    #[error(
        "{}: no base colour image was found ({looked_for}): name the colour image itself, or rename it to end in _color", path.display()
    )]
    NoBaseColor {
        /// The folder or prefix given.
        path: PathBuf,
        /// The endings that were looked for.
        looked_for: String,
    },
    /// The channels do not make an exemplar.
    #[error("{}: {source}", path.display())]
    Exemplar {
        /// The base colour's file.
        path: PathBuf,
        /// What is wrong.
        source: ExemplarError,
    },
    /// The output cannot be written. Nothing was left behind.
    #[error("{}: cannot be written: {what}: {remedy}", path.display())]
    Write {
        /// The file that was to be written.
        path: PathBuf,
        /// What is wrong.
        what: String,
        /// What to do.
        remedy: String,
    },
}

fn place_prefix(place: &str) -> String {
    if place.is_empty() { String::new() } else { format!("{place}: ") }
}

impl FormatError {
    /// A [`Problem`] with the name of its file.
    pub(crate) fn malformed(path: &Path, problem: Problem) -> Self {
        let Problem { place, what, remedy } = problem;
        Self::Malformed { path: path.to_owned(), place, what, remedy: remedy.into() }
    }
}

/// The usual remedy for files that end early or contradict themselves.
pub(crate) const DAMAGED: &str = "the file is damaged or cut short; export or copy it again";

/// What is wrong inside a file, found by a parser that does not know the file's name.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Problem {
    /// Where; empty for the whole file.
    pub(crate) place: String,
    /// What is wrong.
    pub(crate) what: String,
    /// What to do.
    pub(crate) remedy: &'static str,
}

impl Problem {
    pub(crate) fn new(place: impl Into<String>, what: impl Into<String>, remedy: &'static str) -> Self {
        Self { place: place.into(), what: what.into(), remedy }
    }

    /// The file ends early or contradicts itself.
    pub(crate) fn damaged(place: impl Into<String>, what: impl Into<String>) -> Self {
        Self::new(place, what, DAMAGED)
    }
}

/// Something the user should know about a file that was read all the same.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Warning {
    /// The file.
    pub path: PathBuf,
    /// One sentence: what was found and what was done about it.
    pub text: String,
    /// True if nothing is wrong: it only tells what was decided.
    pub note: bool,
}

impl std::fmt::Display for Warning {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}", self.path.display(), self.text)
    }
}
