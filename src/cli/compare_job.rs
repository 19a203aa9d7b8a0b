//! Job files of comparisons: meshes and exemplars, every one of these with every one of those. Keys are the flags of
//! `lapped compare`; those of an exemplar count before those of a mesh, and these before the defaults. See docs/comparison.md.

use super::compare::{CellArgs, Names};
use super::job_file::{first_line, flags, table, word};
use crate::compare::many::CellJob;
use anyhow::{Context, anyhow, bail};
use clap::Parser;
use std::path::{Path, PathBuf};
use toml::{Table, Value};

/// A cell's keys, read as the flags they are.
#[derive(Debug, Parser)]
#[command(no_binary_name = true, disable_help_flag = true)]
struct Keys {
    #[command(flatten)]
    args: CellArgs,
}

/// A mesh or an exemplar with keys of its own.
struct Named {
    file: PathBuf,
    name: Option<String>,
    keys: Table,
}

/// Reads the cells of a job file. Paths in it are relative to it.
///
/// # Errors
/// If it cannot be read, has no mesh or no exemplar, or a key is unknown or has an unusable value.
pub(super) fn read(path: &Path, output: &Path) -> anyhow::Result<Vec<CellJob>> {
    let name = || path.display().to_string();
    let mut table = table(path)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let defaults = match table.remove("defaults") {
        None => Table::new(),
        Some(Value::Table(defaults)) => defaults,
        Some(_) => bail!("{}: `defaults` is no table: write [defaults]", name()),
    };
    let meshes = named(&mut table, "mesh", folder).with_context(name)?;
    let exemplars = named(&mut table, "exemplar", folder).with_context(name)?;
    if let Some(key) = table.keys().next() {
        bail!("{}: unknown key `{key}`: use [defaults], [[mesh]] and [[exemplar]]", name());
    }
    let mut names = Names::default();
    let mut cells = Vec::new();
    for mesh in &meshes {
        for exemplar in &exemplars {
            let mut keys = defaults.clone();
            keys.extend(mesh.keys.clone());
            keys.extend(exemplar.keys.clone());
            let called = match (&mesh.name, &exemplar.name) {
                (None, None) => names.of(&mesh.file, &exemplar.file),
                (m, e) => {
                    let of = |name: &Option<String>, file: &Path| {
                        name.clone().or_else(|| file.file_stem().map(|s| s.to_string_lossy().into_owned())).unwrap_or_default()
                    };
                    names.once(&format!("{}-{}", of(m, &mesh.file), of(e, &exemplar.file)))
                }
            };
            let cell = cell(keys, folder).and_then(|args| args.cell(&mesh.file, &exemplar.file, &called, output));
            cells.push(cell.with_context(|| called.clone()).with_context(name)?);
        }
    }
    Ok(cells)
}

/// The meshes or exemplars of a file: names alone, or tables with a `file` and keys.
fn named(table: &mut Table, kind: &str, folder: &Path) -> anyhow::Result<Vec<Named>> {
    let Some(Value::Array(all)) = table.remove(kind) else {
        bail!(
            "there is no {kind}: write {kind} = [\"FILE\", ...], or [[{kind}]] and file = \"FILE\" below; see docs/comparison.md"
        );
    };
    if all.is_empty() {
        bail!("there is no {kind} in the list: name at least one");
    }
    let one = |value: Value| match value {
        Value::Table(mut keys) => {
            let file = keys.remove("file").with_context(|| format!("a {kind} has no file: give file = \"FILE\""))?;
            let name = keys.remove("name").map(|n| word("name", n)).transpose()?;
            Ok(Named { file: folder.join(word("file", file)?), name, keys })
        }
        value => Ok(Named { file: folder.join(word(kind, value)?), name: None, keys: Table::new() }),
    };
    all.into_iter().map(one).collect()
}

fn cell(keys: Table, folder: &Path) -> anyhow::Result<CellArgs> {
    let words = flags(keys, &["methods", "up"])?;
    let Keys { mut args } = Keys::try_parse_from(words).map_err(|e| anyhow!("{}", first_line(&e, "compare")))?;
    if let Some(field) = args.field.as_mut().filter(|f| f.to_ascii_lowercase().ends_with(".json")) {
        *field = folder.join(&*field).display().to_string();
    }
    Ok(args)
}
