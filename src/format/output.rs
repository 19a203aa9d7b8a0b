//! Writing files so that there is never half of one: to a temporary file beside the target, then renamed onto it.

use super::error::FormatError;
use std::collections::BTreeSet;
use std::fs;
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Bytes gathered before they go to the operating system.
const BUFFER: usize = 1 << 20;

/// Writes a file through `content`. Whatever goes wrong, a file of that name stays as it was and nothing else is left.
///
/// # Errors
/// If the folder is missing or not writable, the disk is full, or the target is a folder or write-protected.
pub fn write_file(path: &Path, content: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), FormatError> {
    write(path, content).map_err(|e| explain(path, &e))
}

/// Says before the work whether [`write_file`] could write there, as far as that can be told without doing it.
///
/// # Errors
/// As [`write_file`].
pub fn check_output(path: &Path) -> Result<(), FormatError> {
    let probe = || match target_of(path)? {
        Target::Special(_) => Ok(()),
        Target::File(target) => with_temporary(&target, |_| Ok(())),
    };
    probe().map_err(|e: io::Error| explain(path, &e))
}

/// What a path leads to.
enum Target {
    /// A file, there already or not.
    File(PathBuf),
    /// A pipe or a device.
    Special(PathBuf),
}

fn target_of(path: &Path) -> io::Result<Target> {
    // A link stays a link: what it points to is replaced.
    let target = if path.is_symlink() { fs::canonicalize(path)? } else { path.to_owned() };
    match fs::metadata(&target) {
        Ok(there) if there.is_dir() => Err(ErrorKind::IsADirectory.into()),
        Ok(there) if there.is_file() && there.permissions().readonly() => Err(ErrorKind::ReadOnlyFilesystem.into()),
        Ok(there) if !there.is_file() => Ok(Target::Special(target)),
        _ => Ok(Target::File(target)),
    }
}

fn write(path: &Path, content: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let target = match target_of(path)? {
        // Pipes and devices cannot be replaced by renaming.
        Target::Special(target) => return fill(fs::File::create(&target)?, content).map(drop),
        Target::File(target) => target,
    };
    with_temporary(&target, |temporary| fill(temporary, content)?.persist(&target).map(drop).map_err(|e| e.error))
}

/// Temporary files that exist now.
static UNFINISHED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// For a process about to end in the middle of writing: removes its temporary files. While the guard that is returned
/// lives, no new one is made.
pub fn abandon_outputs() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    let mut unfinished = unfinished();
    while let Some(path) = unfinished.pop_first() {
        // What is gone already, or just got its final name, needs no removing.
        let _ = fs::remove_file(path);
    }
    unfinished
}

fn unfinished() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Works with a temporary file in the folder of a file; it is gone afterwards if it was not renamed.
fn with_temporary<T>(target: &Path, work: impl FnOnce(tempfile::NamedTempFile) -> io::Result<T>) -> io::Result<T> {
    let (file, path) = {
        let mut unfinished = unfinished();
        let file = temporary_for(target)?;
        let path = file.path().to_owned();
        unfinished.insert(path.clone());
        (file, path)
    };
    let done = work(file);
    unfinished().remove(&path);
    done
}

/// A temporary file in the folder of a file.
fn temporary_for(target: &Path) -> io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".lapped-").suffix(".tmp");
    #[cfg(unix)]
    {
        // The permissions of any new file, not the private ones of temporary files.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder_of(target))
}

fn fill<F: Write>(file: F, content: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<F> {
    let mut out = BufWriter::with_capacity(BUFFER, file);
    content(&mut out)?;
    out.into_inner().map_err(io::IntoInnerError::into_error)
}

fn folder_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_owned(),
        _ => PathBuf::from("."),
    }
}

fn explain(path: &Path, error: &io::Error) -> FormatError {
    let folder = folder_of(path);
    let folder = folder.display();
    let (what, remedy) = match error.kind() {
        ErrorKind::NotFound => (format!("the folder {folder} does not exist"), "create it first, or name another".to_owned()),
        ErrorKind::NotADirectory => (format!("{folder} is not a folder"), "name another place".into()),
        ErrorKind::IsADirectory => ("there is a folder of that name".into(), "name a file in it, or another file".into()),
        ErrorKind::PermissionDenied => (format!("the folder {folder} may not be written to"), "choose another folder".into()),
        ErrorKind::ReadOnlyFilesystem => ("it is write-protected".into(), "choose another place, or lift the protection".into()),
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => ("the disk is full".into(), "free some space and run again".into()),
        _ => (error.to_string(), "choose another place, or check the disk".into()),
    };
    FormatError::Write { path: path.to_owned(), what, remedy }
}

#[cfg(test)]
mod tests {
    use super::{abandon_outputs, write_file};

    #[test]
    fn a_process_that_ends_while_writing_takes_its_temporary_file_along() {
        let folder = tempfile::tempdir().expect("a folder");
        let target = folder.path().join("kept");
        std::fs::write(&target, "what was here").expect("written");
        let list = || std::fs::read_dir(folder.path()).expect("a folder").count();
        let failed = write_file(&target, |out| {
            out.write_all(&[7; 3 << 20])?;
            assert_eq!(list(), 2, "a temporary file is there");
            drop(abandon_outputs());
            assert_eq!(list(), 1, "and gone");
            Ok(())
        });
        assert!(failed.is_err(), "half a file never gets the final name");
        assert_eq!(std::fs::read(&target).expect("read"), b"what was here", "the old file is whole");
    }
}
