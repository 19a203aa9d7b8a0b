//! `lapped` puts any example texture on any triangle mesh: no UVs, no cuts, no painting.
//!
//! # The pipeline in a page
//!
//! 1. [`format`](mod@format) reads a mesh into a [`format::Model`] and images into [`exemplar::Exemplar`]s.
//! 2. [`mesh`] cleans the model into an oriented manifold, [`mesh::Mesh`].
//! 3. [`exemplar`] cuts [`exemplar::TexturePatch`]es: masks with soft edges over the exemplar.
//! 4. [`field`] says which way and how large the texture lies at each face: a [`field::Guide`].
//! 5. [`mod@paste`] covers the mesh with overlapping pastes: a [`paste::LappedTexture`].
//! 6. [`surface::SurfaceTexture`] is what the result looks like at a point; [`render`] draws it.
//!
//! [`job`] does all of it at once and brings the result back onto the model's own faces:
//!
//! ```
//! use lapped::job::{ExemplarInput, PasteJob, Steer, paste_model};
//! use lapped::mesh::SurfacePoint;
//! use lapped::paste::Composite;
//! use lapped::progress::Silent;
//! use lapped::surface::SurfaceTexture;
//!
//! let model = lapped::assets::mesh("knot")?;
//! let exemplar = lapped::assets::exemplar("rust")?;
//! let input = ExemplarInput { exemplar, weight: 1.0, patches: Vec::new() };
//! let job = PasteJob { steer: Steer::Isotropic(None), ..PasteJob::default() };
//! let pasted = paste_model(&model, vec![input], &job, &Silent)?;
//!
//! let texture = Composite::new(&pasted.mesh, &pasted.lapped);
//! let middle = SurfacePoint { face: 0, bary: glam::Vec3::splat(1.0 / 3.0) };
//! assert!(texture.texel(middle, 0.0).alpha > 0.98);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod assets;
pub mod atlas;
pub mod cli;
pub mod compare;
pub mod exemplar;
pub mod field;
pub mod format;
pub mod job;
pub mod mesh;
pub mod numeric;
pub mod paste;
pub mod progress;
pub mod random;
pub mod render;
pub mod surface;
pub mod synth;
#[cfg(feature = "viewer")]
pub mod viewer;
