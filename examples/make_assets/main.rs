//! Makes the demo meshes and exemplars of `assets/`, all of them our own work.
//!
//! `cargo run --release --example make_assets [DIR [NAME]]` writes into DIR (`assets` unless given) every asset whose
//! file name starts with NAME. The same bytes come out on each run.

mod generate;

use anyhow::{Context, Result};
use std::fs;
use std::io::{Write, stdout};
use std::path::PathBuf;

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let target = PathBuf::from(arguments.next().unwrap_or_else(|| "assets".into()));
    let wanted = arguments.next().unwrap_or_default();
    let write = |folder: &str, file: &str, bytes: &[u8]| -> Result<()> {
        let folder = target.join(folder);
        fs::create_dir_all(&folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
        let path = folder.join(file);
        fs::write(&path, bytes).with_context(|| format!("cannot write {}", path.display()))?;
        writeln!(stdout(), "{} {} KB", path.display(), bytes.len().div_ceil(1000))?;
        Ok(())
    };
    for mesh in generate::MESHES.iter().filter(|m| m.file.starts_with(&wanted)) {
        write("meshes", mesh.file, &mesh.bytes())?;
    }
    for exemplar in generate::EXEMPLARS.iter().filter(|e| e.name.starts_with(&wanted)) {
        for (file, bytes) in exemplar.files().with_context(|| format!("cannot encode {}", exemplar.name))? {
            write("exemplars", &file, &bytes)?;
        }
    }
    Ok(())
}
