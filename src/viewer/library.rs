//! What has been read: models and exemplars by where they come from, shared by all threads.
//!
//! Undoing and reopening then read nothing again. Of models, which are large, only the last few are kept.

use crate::assets;
use crate::exemplar::Exemplar;
use crate::field::TangentField;
use crate::format::{
    ExemplarOptions, FormatError, Model, holds_record, read_exemplar, read_file, read_model_bytes, read_record_bytes,
};
use crate::job::{Bound, Link};
use crate::mesh::{CleanOptions, Cleaned, MeshError, clean};
use crate::paste::LappedTexture;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

/// Models that are kept.
const MODELS: usize = 3;

/// Why something cannot be opened.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OpenError {
    /// The file.
    #[error(transparent)]
    File(#[from] FormatError),
    /// The faces in it.
    #[error("{file}: {source}")]
    Mesh {
        /// The file.
        file: String,
        /// What is wrong with them.
        source: MeshError,
    },
}

/// A model made ready to be pasted on.
#[derive(Debug)]
pub struct OpenModel {
    /// Where it comes from.
    pub link: Link,
    /// As its file has it.
    pub model: Model,
    /// Its clean mesh.
    pub cleaned: Cleaned,
    /// The pastes that it came with, if it is a record, and their field.
    pub own: Option<(LappedTexture, Option<TangentField>)>,
}

/// An exemplar with what reading it told.
#[derive(Debug)]
pub struct OpenExemplar {
    /// Where it comes from.
    pub link: Link,
    /// The exemplar.
    pub exemplar: Exemplar,
    /// What the user should know, one sentence each.
    pub told: Vec<String>,
}

/// Everything that has been read.
#[derive(Debug, Default)]
pub struct Library {
    held: Mutex<Held>,
}

#[derive(Debug, Default)]
struct Held {
    /// Latest last.
    models: Vec<Arc<OpenModel>>,
    exemplars: BTreeMap<Link, Arc<OpenExemplar>>,
}

impl Library {
    fn held<T>(&self, with: impl FnOnce(&mut Held) -> T) -> T {
        with(&mut self.held.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// A model, read if it was not before.
    ///
    /// # Errors
    /// If it cannot be read, or is no mesh.
    pub fn model(&self, link: &Link) -> Result<Arc<OpenModel>, OpenError> {
        let there = self.held(|held| {
            let at = held.models.iter().position(|m| m.link == *link)?;
            let model = held.models.remove(at);
            held.models.push(Arc::clone(&model));
            Some(model)
        });
        if let Some(model) = there {
            return Ok(model);
        }
        let model = Arc::new(read(link)?);
        self.held(|held| {
            if held.models.len() >= MODELS {
                held.models.remove(0);
            }
            held.models.push(Arc::clone(&model));
        });
        Ok(model)
    }

    /// An exemplar, read if it was not before.
    ///
    /// # Errors
    /// If it cannot be read.
    pub fn exemplar(&self, link: &Link) -> Result<Arc<OpenExemplar>, OpenError> {
        if let Some(there) = self.known(link) {
            return Ok(there);
        }
        let (exemplar, told) = match link {
            Link::BuiltIn(name) => (assets::exemplar(name)?, Vec::new()),
            Link::File(path) => {
                let (exemplar, told) = read_exemplar(path, &ExemplarOptions::default())?;
                (exemplar, told.iter().map(ToString::to_string).collect())
            }
        };
        let read = Arc::new(OpenExemplar { link: link.clone(), exemplar, told });
        self.held(|held| held.exemplars.insert(link.clone(), Arc::clone(&read)));
        Ok(read)
    }

    /// An exemplar, if it was read before.
    #[must_use]
    pub fn known(&self, link: &Link) -> Option<Arc<OpenExemplar>> {
        self.held(|held| held.exemplars.get(link).map(Arc::clone))
    }

    /// Forgets what was read, so that changed files are read again.
    pub fn forget(&self) {
        self.held(|held| *held = Held::default());
    }
}

fn read(link: &Link) -> Result<OpenModel, OpenError> {
    let (model, own) = match link {
        Link::BuiltIn(name) => (assets::mesh(name)?, None),
        Link::File(path) => read_either(path)?,
    };
    let cleaned = clean(&model.positions, &model.faces, &CleanOptions::default())
        .map_err(|source| OpenError::Mesh { file: link.name(), source })?;
    Ok(OpenModel { link: link.clone(), model, cleaned, own })
}

/// A record with its pastes, or a plain model.
#[allow(clippy::type_complexity, reason = "the parts of an open model")]
fn read_either(path: &Path) -> Result<(Model, Option<(LappedTexture, Option<TangentField>)>), OpenError> {
    let file = read_file(path, "the model")?;
    if !holds_record(&file) {
        return Ok((read_model_bytes(path, &file)?, None));
    }
    let record = read_record_bytes(path, &file)?;
    let model = record.model.clone();
    let bound = Bound::new(record).map_err(|source| OpenError::Mesh { file: path.display().to_string(), source })?;
    Ok((model, Some((bound.lapped, bound.field))))
}
