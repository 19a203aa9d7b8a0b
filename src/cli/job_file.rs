//! Job files: several regions of one model in a TOML file. Every key of a region is a flag of `lapped paste`, so that there
//! is one list of options; see docs/job.md.

use super::region::RegionArgs;
use crate::format::read_file;
use anyhow::{Context, anyhow, bail};
use clap::Parser;
use std::path::{Path, PathBuf};
use toml::{Table, Value};

/// One region of a job file.
#[derive(Debug, Clone)]
pub struct JobRegion {
    /// What it is called.
    pub name: String,
    /// Its exemplars.
    pub exemplars: Vec<PathBuf>,
    /// The rest.
    pub args: RegionArgs,
}

/// A region's keys, read as the flags they are.
#[derive(Debug, Parser)]
#[command(no_binary_name = true, disable_help_flag = true)]
struct Keys {
    #[arg(required = true)]
    exemplars: Vec<PathBuf>,
    #[command(flatten)]
    args: RegionArgs,
}

/// Reads the regions of a job file. Paths in it are relative to it.
///
/// # Errors
/// If it cannot be read, is no TOML, has no region, or a key is unknown or has an unusable value.
pub fn read(path: &Path) -> anyhow::Result<Vec<JobRegion>> {
    let name = || path.display().to_string();
    let mut table = table(path)?;
    let defaults = match table.remove("defaults") {
        None => Table::new(),
        Some(Value::Table(defaults)) => defaults,
        Some(_) => bail!("{}: `defaults` is no table: write [defaults]", name()),
    };
    let Some(Value::Array(regions)) = table.remove("region") else {
        bail!("{}: there is no region: write [[region]] and its keys below; see docs/job.md", name());
    };
    if regions.is_empty() {
        bail!("{}: there is no region in it: write [[region]] and its keys below; see docs/job.md", name());
    }
    if let Some(key) = table.keys().next() {
        bail!("{}: unknown key `{key}`: use [defaults] and [[region]]", name());
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    let one = |(index, region): (usize, Value)| {
        let Value::Table(own) = region else { bail!("region {}: it is no table: write [[region]]", index + 1) };
        let mut keys = defaults.clone();
        keys.extend(own);
        let called = match keys.remove("name") {
            Some(Value::String(called)) => called,
            None => format!("{}", index + 1),
            Some(_) => bail!("region {}: its name is no text: put it in quotes", index + 1),
        };
        region_of(keys, &called, folder).with_context(|| format!("region {} ({called:?})", index + 1))
    };
    regions.into_iter().enumerate().map(one).collect::<anyhow::Result<_>>().with_context(name)
}

/// A TOML file.
///
/// # Errors
/// If it cannot be read, or is no TOML.
pub(super) fn table(path: &Path) -> anyhow::Result<Table> {
    let name = || path.display().to_string();
    let text = String::from_utf8(read_file(path, "the job file")?);
    let text = text.map_err(|_| anyhow!("{}: this is no text: name a TOML file", name()))?;
    text.parse().map_err(|e: toml::de::Error| {
        let line = e.span().map_or(1, |s| text[..s.start.min(text.len())].matches('\n').count() + 1);
        anyhow!("{}: line {line}: {}: check the TOML there", name(), e.message().replace('\n', " "))
    })
}

/// Keys as the flags they are; those of `lists` take all values of a list at once, separated by commas.
///
/// # Errors
/// If a value is neither text nor a number.
pub(super) fn flags(keys: Table, lists: &[&str]) -> anyhow::Result<Vec<String>> {
    let mut words = Vec::new();
    for (key, value) in keys {
        let flag = format!("--{key}");
        match value {
            Value::Boolean(false) => {}
            Value::Boolean(true) => words.push(flag),
            Value::Array(list) if lists.contains(&key.as_str()) => {
                let list: Vec<String> = list.into_iter().map(|v| word(&key, v)).collect::<anyhow::Result<_>>()?;
                words.push(format!("{flag}={}", list.join(",")));
            }
            // The flag again and again.
            Value::Array(list) => {
                for value in list {
                    words.push(format!("{flag}={}", word(&key, value)?));
                }
            }
            value => words.push(format!("{flag}={}", word(&key, value)?)),
        }
    }
    Ok(words)
}

fn region_of(mut keys: Table, name: &str, folder: &Path) -> anyhow::Result<JobRegion> {
    let exemplars = keys.remove("exemplar").context("it has no exemplar: give exemplar = \"FILE\" or a list")?;
    let mut words = flags(keys, &["weights", "up"])?;
    words.push("--".to_owned());
    match exemplars {
        Value::Array(list) => {
            for value in list {
                words.push(word("exemplar", value)?);
            }
        }
        value => words.push(word("exemplar", value)?),
    }
    let Keys { mut exemplars, mut args } = Keys::try_parse_from(words).map_err(|e| anyhow!("{}", first_line(&e, "paste")))?;
    args.resolve(folder);
    exemplars.iter_mut().for_each(|e| *e = folder.join(&*e));
    Ok(JobRegion { name: name.to_owned(), exemplars, args })
}

pub(super) fn word(key: &str, value: Value) -> anyhow::Result<String> {
    Ok(match value {
        Value::String(text) => text,
        Value::Integer(number) => number.to_string(),
        Value::Float(number) => number.to_string(),
        _ => bail!("`{key}` is neither text nor a number: see docs/job.md"),
    })
}

/// What clap says of a flag of a command, as it reads in a file.
pub(super) fn first_line(error: &clap::Error, command: &str) -> String {
    let text = error.to_string();
    let line = text.lines().next().unwrap_or_default().trim_start_matches("error: ").replace("--", "");
    format!("{line}: use the flags of `lapped {command}` as keys, without dashes")
}
