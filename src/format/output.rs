//! Writing files so that there is never half of one: to a temporary file beside the target, then renamed onto it.

use super::error::FormatError;
use std::fs;
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};

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
        Target::File(target) => temporary_for(&target).map(drop),
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
    let temporary = fill(temporary_for(&target)?, content)?;
    temporary.persist(&target).map(drop).map_err(|e| e.error)
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
