//! Pastes composited by something else than the processor's own loops, such as a graphics adapter.
//!
//! What it gives is a [`SurfaceTexture`] like [`Composite`], and is asked for many texels at a time.

use super::composite::Composite;
use super::lapped::LappedTexture;
use crate::mesh::Mesh;
use crate::surface::SurfaceTexture;
use std::fmt;
use std::sync::Arc;

/// Something that composites pastes.
pub trait CompositeBackend: fmt::Debug + Send + Sync {
    /// Brings a lapped texture and its mesh there.
    ///
    /// # Errors
    /// If it cannot hold them: a sentence.
    fn load<'a>(&self, mesh: &'a Mesh, lapped: &'a LappedTexture) -> Result<Box<dyn SurfaceTexture + 'a>, String>;
}

/// Where pastes are composited: on the processor, or by a back-end.
#[derive(Debug, Clone, Default)]
pub struct Compositing(pub Option<Arc<dyn CompositeBackend>>);

impl PartialEq for Compositing {
    fn eq(&self, other: &Self) -> bool {
        match (&self.0, &other.0) {
            (None, None) => true,
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            _ => false,
        }
    }
}

impl Compositing {
    /// A lapped texture on its mesh, ready to be asked.
    ///
    /// # Errors
    /// If the back-end cannot hold it: a sentence.
    pub fn of<'a>(&self, mesh: &'a Mesh, lapped: &'a LappedTexture) -> Result<Box<dyn SurfaceTexture + 'a>, String> {
        match &self.0 {
            None => Ok(Box::new(Composite::new(mesh, lapped))),
            Some(backend) => backend.load(mesh, lapped),
        }
    }
}
