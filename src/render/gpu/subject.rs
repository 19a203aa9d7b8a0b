//! A mesh with its pastes, on the device.

use super::error::GpuError;
use super::lists::Lists;
use super::patches::PatchTextures;
use super::renderer::Renderer;
use super::shape::Shape;
use crate::exemplar::{Exemplar, TexturePatch};
use crate::paste::LappedTexture;
use crate::render::reference::Stage;
use glam::Vec4;
use std::sync::Arc;

/// A mesh with its pastes, ready to be drawn.
///
/// Pastes are bound to faces and name texture patches by number: the vertices may move, and other exemplars and patches may
/// stand under the same pastes, without pasting again.
#[derive(Debug)]
pub struct Subject {
    pub(super) shape: Shape,
    pub(super) lists: Lists,
    pub(super) patches: Arc<PatchTextures>,
    /// Patches that the pastes name.
    named: usize,
}

impl Renderer {
    /// Brings a lapped texture and the mesh it lies on to the device. Without pastes the bare mesh is drawn.
    ///
    /// # Errors
    /// If it does not fit the device.
    pub fn load(&self, stage: &Stage<'_>, lapped: &LappedTexture) -> Result<Subject, GpuError> {
        self.load_tinted(stage, lapped, None)
    }

    /// The same with colours of the faces' own over all pastes: for each face its corners' base colour (linear light) and alpha,
    /// from 0 to 1, stored in 16 bits each. With an alpha of 1 and no pastes that is a mesh with vertex colours.
    ///
    /// # Errors
    /// If it does not fit the device, or the tints are not as many as the faces.
    pub fn load_tinted(&self, stage: &Stage<'_>, lapped: &LappedTexture, tints: Option<&[[Vec4; 3]]>) -> Result<Subject, GpuError> {
        self.load_with(stage, lapped, tints, Arc::new(self.load_patches(&lapped.exemplars, &lapped.patches)?))
    }

    /// The same with exemplars and patches that are on the device already; those of the lapped texture are not looked at.
    ///
    /// # Errors
    /// As [`Renderer::load_tinted`], or if there are fewer patches than the pastes name.
    pub fn load_with(
        &self,
        stage: &Stage<'_>,
        lapped: &LappedTexture,
        tints: Option<&[[Vec4; 3]]>,
        patches: Arc<PatchTextures>,
    ) -> Result<Subject, GpuError> {
        if let Some(tints) = tints.filter(|t| t.len() != stage.mesh.face_count()) {
            return Err(GpuError::Tints { found: tints.len(), expected: stage.mesh.face_count() });
        }
        let shape = Shape::new(&self.gpu, stage.mesh)?;
        let lists = Lists::new(&self.gpu, &self.layouts.page, stage.mesh, stage.normals(), lapped, tints)?;
        let named = lapped.pastes.iter().map(|p| usize::from(p.patch) + 1).max().unwrap_or(0);
        self.gpu.check()?;
        let mut subject = Subject { shape, lists, patches: Arc::clone(&patches), named };
        subject.set_patches(patches)?;
        // What was written goes to the device now, by this thread, not with the next frame of another one.
        self.gpu.queue.submit([]);
        Ok(subject)
    }

    /// Brings exemplars and texture patches to the device, to stand under pastes.
    ///
    /// # Errors
    /// If they do not fit the device.
    pub fn load_patches(&self, exemplars: &[Exemplar], patches: &[TexturePatch]) -> Result<PatchTextures, GpuError> {
        let named = patches.iter().map(|p| u64::from(p.exemplar) + 1).max().unwrap_or(0);
        if named > exemplars.len() as u64 {
            let what = "the patches name more exemplars than there are".to_owned();
            return Err(GpuError::Limit { what, needs: named, has: exemplars.len() as u64, remedy: "give them all" });
        }
        PatchTextures::new(&self.gpu, &self.layouts.patches, self.options.filter, exemplars, patches)
    }

    /// Shows exemplars that change with time as they are so many seconds after their first frame, wherever these patches are drawn from now
    /// on. How many seconds that goes on being right: without end if nothing changes.
    pub fn set_time(&self, patches: &PatchTextures, seconds: f64) -> f64 {
        patches.set_time(&self.gpu, seconds)
    }

    /// Moves a subject's vertices to where they are on another stage: the same faces, new positions.
    ///
    /// # Errors
    /// If the number of vertices or faces is another one.
    pub fn follow(&self, subject: &mut Subject, stage: &Stage<'_>) -> Result<(), GpuError> {
        let expected = subject.lists.pages.last().map_or(0, |page| page.faces.end as usize);
        if stage.mesh.face_count() != expected {
            return Err(GpuError::Faces { found: stage.mesh.face_count(), expected });
        }
        subject.shape.set(&self.gpu, &stage.mesh.positions)?;
        subject.lists.set_normals(&self.gpu, stage.normals());
        Ok(())
    }
}

impl Subject {
    /// Sets other exemplars and texture patches under the pastes; patch for patch, the old numbers name the new ones.
    ///
    /// # Errors
    /// If there are fewer patches than the pastes name.
    pub fn set_patches(&mut self, patches: Arc<PatchTextures>) -> Result<(), GpuError> {
        if patches.patch_count() < self.named {
            let what = "the pastes name more texture patches than there are".to_owned();
            let (needs, has) = (self.named as u64, patches.patch_count() as u64);
            return Err(GpuError::Limit { what, needs, has, remedy: "give at least as many" });
        }
        self.patches = patches;
        Ok(())
    }

    /// The exemplars and patches that it is drawn with.
    #[must_use]
    pub const fn patches(&self) -> &Arc<PatchTextures> {
        &self.patches
    }

    /// Bytes on the device: the mesh, the paste lists, and textures.
    #[must_use]
    pub fn bytes(&self) -> [u64; 3] {
        [self.shape.positions.size(), self.lists.bytes(), self.patches.bytes()]
    }

    /// Draws all faces with whatever pipeline is set.
    pub(super) fn draw_faces(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_bind_group(2, &self.patches.bindings, &[]);
        for page in &self.lists.pages {
            pass.set_bind_group(1, &page.tables, &[]);
            pass.draw(0..3 * page.faces.len() as u32, 0..1);
        }
    }

    /// Pages the paste lists are cut into.
    #[must_use]
    pub fn page_count(&self) -> usize {
        self.lists.pages.len()
    }
}
