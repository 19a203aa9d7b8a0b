//! What is kept between sessions: settings, files opened lately, and work that no file holds yet.
//!
//! Unsaved work lies in a file of its own for each running program, so that one that crashed leaves it for the next.

use crate::format::write_file;
use crate::job::{Project, ProjectError};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Files that are remembered.
const RECENT: usize = 10;
/// How files with unsaved work begin, before the number of the program that writes them.
const RECOVERY: &str = "recovery-";

/// What is remembered.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct Settings {
    /// The dark theme.
    pub dark: bool,
    /// Files opened lately, latest first.
    pub recent: Vec<PathBuf>,
}

impl Default for Settings {
    fn default() -> Self {
        Self { dark: true, recent: Vec::new() }
    }
}

/// The folder.
#[derive(Debug, Clone)]
pub struct Home(PathBuf);

impl Home {
    /// A folder, or the system's own place for such things.
    #[must_use]
    pub fn new(folder: Option<PathBuf>) -> Self {
        Self(folder.unwrap_or_else(usual))
    }

    /// What is remembered; nothing if it cannot be read.
    #[must_use]
    pub fn settings(&self) -> Settings {
        let text = std::fs::read(self.0.join("settings.json")).unwrap_or_default();
        serde_json::from_slice(&text).unwrap_or_default()
    }

    /// Remembers.
    pub fn remember(&self, settings: &Settings) {
        if let Ok(text) = serde_json::to_vec_pretty(settings) {
            // What cannot be remembered is no reason to stop anybody.
            let _ = std::fs::create_dir_all(&self.0);
            let _ = write_file(&self.0.join("settings.json"), |file| file.write_all(&text));
        }
    }

    fn recovery(&self) -> PathBuf {
        self.0.join(format!("{RECOVERY}{}.lapped", std::process::id()))
    }

    /// Keeps unsaved work.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn keep(&self, project: &Project) -> Result<(), ProjectError> {
        // A folder that cannot be made shows when the file cannot be written.
        let _ = std::fs::create_dir_all(&self.0);
        project.write(&self.recovery())
    }

    /// There is no unsaved work any more.
    pub fn let_go(&self) {
        // It may never have been there.
        let _ = std::fs::remove_file(self.recovery());
    }

    /// Work that a program which runs no longer left behind, with its file.
    #[must_use]
    pub fn left_behind(&self) -> Option<(PathBuf, Project)> {
        let files = std::fs::read_dir(&self.0).ok()?;
        let mut found: Vec<PathBuf> = files.flatten().map(|f| f.path()).filter(|p| is_left_behind(p)).collect();
        found.sort();
        found.into_iter().find_map(|path| Project::read(&path).ok().map(|project| (path, project)))
    }
}

impl Settings {
    /// A file was opened.
    pub fn opened(&mut self, path: &Path) {
        self.recent.retain(|p| p != path);
        self.recent.insert(0, path.to_owned());
        self.recent.truncate(RECENT);
    }
}

/// True if a file holds unsaved work of a program that runs no longer.
fn is_left_behind(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let number = name.strip_prefix(RECOVERY).and_then(|n| n.strip_suffix(".lapped"));
    let Some(number) = number.and_then(|n| n.parse::<u32>().ok()) else { return false };
    // Where the system does not show its programs, only our own is known to run.
    let shown = Path::new("/proc/self").exists();
    number != std::process::id() && !(shown && Path::new(&format!("/proc/{number}")).exists())
}

/// Where the system wants settings.
fn usual() -> PathBuf {
    let folder = |name: &str| std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
    let base = if cfg!(windows) {
        folder("APPDATA")
    } else if cfg!(target_os = "macos") {
        folder("HOME").map(|home| home.join("Library/Application Support"))
    } else {
        folder("XDG_CONFIG_HOME").or_else(|| folder("HOME").map(|home| home.join(".config")))
    };
    base.unwrap_or_else(std::env::temp_dir).join("lapped")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unsaved_work_of_a_program_that_is_gone_is_found_and_ours_is_not() {
        let folder = tempfile::tempdir().expect("a folder");
        let home = Home::new(Some(folder.path().join("new")));
        let project = Project { seed: 7, ..Project::default() };
        home.keep(&project).expect("kept");
        assert!(home.left_behind().is_none(), "this program still runs");
        let gone = folder.path().join("new").join(format!("{RECOVERY}4294967294.lapped"));
        std::fs::rename(home.recovery(), &gone).expect("moved");
        assert_eq!(home.left_behind(), Some((gone, project)), "no system has a program of that number");
    }

    #[test]
    fn the_latest_files_come_first_and_once() {
        let mut settings = Settings::default();
        for name in ["a", "b", "a"] {
            settings.opened(Path::new(name));
        }
        assert_eq!(settings.recent, [Path::new("a"), Path::new("b")], "a was opened again");
    }
}
