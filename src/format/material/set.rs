//! Finding the files of a material set: beside a named image, in a folder, or by the beginning of their names.

use super::names::{Name, Role, parse};
use super::{ExemplarOptions, NormalConvention, warn};
use crate::exemplar::Channel;
use crate::format::error::{FormatError, Warning};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Endings of image files, the ones that keep most first: they are preferred where a set has a channel twice.
const ENDINGS: [&str; 11] = ["png", "tif", "tiff", "exr", "tga", "bmp", "webp", "hdr", "jpg", "jpeg", "jfif"];

const COLOR: Role = Role::Channel(Channel::BaseColor);

/// The files of an exemplar; the base colour's is always there.
#[derive(Debug, Default)]
pub(super) struct Found {
    pub(super) name: String,
    pub(super) files: BTreeMap<Role, PathBuf>,
    /// What the normal map's name says of its convention.
    pub(super) convention: Option<NormalConvention>,
}

/// A file of a folder, with its name taken apart.
#[derive(Debug, Clone)]
struct Candidate {
    path: PathBuf,
    name: Name,
}

/// Finds all files of the exemplar that `path` names.
pub(super) fn find(path: &Path, options: &ExemplarOptions, warnings: &mut Vec<Warning>) -> Result<Found, FormatError> {
    let explicit_base = options.channels.get(&Channel::BaseColor);
    let mut found = if path.is_dir() {
        in_folder(path, "", path, explicit_base.is_some())?
    } else if path.exists() {
        beside(path, options.alone, warnings)?
    } else {
        by_prefix(path, explicit_base.is_some())?
    };
    for (&channel, file) in &options.channels {
        found.files.insert(Role::Channel(channel), file.clone());
        if channel == Channel::Normal {
            found.convention = parse(&stem(file)).convention;
        }
    }
    // What the caller names goes before what was found in another form.
    if options.channels.contains_key(&Channel::Roughness) {
        found.files.remove(&Role::Gloss);
    }
    if found.name.is_empty() {
        found.name = found.files.get(&COLOR).map(|f| stem(f)).unwrap_or_default();
    }
    Ok(found)
}

/// The set around an image that the user named: the image is its base colour, whatever its name.
fn beside(path: &Path, alone: bool, warnings: &mut Vec<Warning>) -> Result<Found, FormatError> {
    let name = parse(&stem(path));
    let mut found = Found { name: stem(path), ..Found::default() };
    let is_color = matches!(name.role, None | Some(COLOR));
    if !is_color && !alone {
        warn(warnings, path, "its name is that of another channel; it is used as the base colour, alone");
    }
    if is_color && !alone {
        let folder = path.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
        // A folder that may not be listed is no reason to refuse the image.
        let candidates = list(folder).unwrap_or_default();
        let mine: Vec<_> = candidates.into_iter().filter(|c| c.name.set == name.set && c.name.role.is_some()).collect();
        collect(&mine, &name.variant, &mut found);
        if name.role.is_some() && !name.set.is_empty() {
            found.name = name.set;
        }
    }
    found.files.insert(COLOR, path.to_owned());
    Ok(found)
}

/// The one set of a folder whose name begins with `prefix`.
fn in_folder(folder: &Path, prefix: &str, asked: &Path, base_is_named: bool) -> Result<Found, FormatError> {
    let candidates = list(folder).map_err(|source| FormatError::Read { path: folder.to_owned(), source })?;
    let mut sets: BTreeMap<String, Vec<Candidate>> = BTreeMap::new();
    let wanted = parse(prefix);
    for candidate in candidates {
        if candidate.name.set.starts_with(&wanted.set) {
            sets.entry(candidate.name.set.clone()).or_default().push(candidate);
        }
    }
    if let Some(exact) = sets.remove(&wanted.set).filter(|_| !wanted.set.is_empty()) {
        sets = BTreeMap::from([(wanted.set.clone(), exact)]);
    }
    // An image whose name tells nothing is a colour if the rest of its set lacks one.
    let has_color = |set: &[Candidate]| base_is_named || set.iter().any(|c| matches!(c.name.role, None | Some(COLOR)));
    sets.retain(|_, set| has_color(set));
    let Some((key, set)) = sets.pop_first() else {
        return Err(FormatError::NoBaseColor {
            path: asked.to_owned(),
            looked_for: "_color, _basecolor, _albedo, _diffuse".into(),
        });
    };
    if !sets.is_empty() {
        let names: Vec<&str> = std::iter::once(&key).chain(sets.keys()).map(String::as_str).take(5).collect();
        return Err(FormatError::Unknown {
            path: asked.to_owned(),
            found: format!("there are {} material sets here ({}, ...)", sets.len() + 1, names.join(", ")),
            remedy: "name the colour image of one of them".into(),
        });
    }
    let mut found = Found { name: key, ..Found::default() };
    collect(&set, &wanted.variant, &mut found);
    if let (false, Some(plain)) = (found.files.contains_key(&COLOR), set.iter().find(|c| c.name.role.is_none())) {
        found.files.insert(COLOR, plain.path.clone());
    }
    if found.name.is_empty() {
        found.name = folder.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    }
    Ok(found)
}

fn by_prefix(path: &Path, base_is_named: bool) -> Result<Found, FormatError> {
    let folder = path.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let prefix = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    // A name with an image's ending is a file that is not there, not the beginning of others.
    let is_image = path.extension().is_some_and(|e| ENDINGS.contains(&e.to_string_lossy().to_lowercase().as_str()));
    if is_image || prefix.is_empty() || !folder.is_dir() {
        return Err(FormatError::Missing { path: path.to_owned() });
    }
    in_folder(folder, &prefix, path, base_is_named).map_err(|e| match e {
        FormatError::NoBaseColor { .. } => FormatError::Missing { path: path.to_owned() },
        other => other,
    })
}

/// Takes for each role the best of the candidates: of the wanted variant, OpenGL before DirectX, by [`ENDINGS`].
fn collect(candidates: &[Candidate], variant: &str, found: &mut Found) {
    let rank = |c: &Candidate| {
        let ending = c.path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        let place = ENDINGS.iter().position(|&e| e == ending);
        (c.name.variant != variant, c.name.convention == Some(NormalConvention::DirectX), place, c.path.clone())
    };
    let mut ordered: Vec<&Candidate> = candidates.iter().collect();
    ordered.sort_by_cached_key(|c| rank(c));
    for candidate in ordered {
        if let Some(role) = candidate.name.role.filter(|r| !found.files.contains_key(r)) {
            found.files.insert(role, candidate.path.clone());
            if role == Role::Channel(Channel::Normal) {
                found.convention = candidate.name.convention;
            }
        }
    }
}

/// The image files of a folder, sorted by name.
fn list(folder: &Path) -> std::io::Result<Vec<Candidate>> {
    let mut all = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        if ENDINGS.contains(&ending.as_str()) && path.is_file() {
            all.push(Candidate { name: parse(&stem(&path)), path });
        }
    }
    all.sort_by(|a, b| a.path.cmp(&b.path));
    Ok(all)
}

fn stem(path: &Path) -> String {
    path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default()
}
