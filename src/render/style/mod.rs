//! Pictures that show the method at work: which paste is where, the field, coverage, stretch, the mesh itself.
//!
//! Every style is a [`SurfaceTexture`] over the same rasterizer, some with lines drawn over the picture and a legend below.

mod charts;
mod coverage;
mod field;
mod layers;
mod legend;
mod palette;
mod pastes;
mod stretch;
mod wireframe;

pub use charts::ChartColors;
pub use palette::{distinct, sequential};

use super::RenderError;
use super::picture::Picture;
use super::raster::Visibility;
use super::reference::Stage;
use super::shade::Lighting;
use super::sheet::{SheetOptions, lay_out};
use crate::exemplar::{Channel, ChannelSet};
use crate::field::Guide;
use crate::mesh::{Mesh, SurfacePoint};
use crate::paste::LappedTexture;
use crate::surface::{SurfaceTexture, Texel};
use glam::Vec3;
pub use legend::Legend;
use rayon::prelude::*;
use std::fmt;
use std::str::FromStr;

/// What a preview shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PreviewStyle {
    /// The texture on the surface.
    #[default]
    Texture,
    /// Each paste in a colour of its own, with outlines where the topmost one changes.
    Pastes,
    /// The tangent field as arrows, and its singular points.
    Field,
    /// How many pastes each face draws, and where the surface shows through.
    Coverage,
    /// How far the topmost paste is from the scale that the field asks for.
    Stretch,
    /// The mesh's edges.
    Wireframe,
}

impl PreviewStyle {
    /// All styles, in the order in which help texts list them.
    pub const ALL: [Self; 6] = [Self::Texture, Self::Pastes, Self::Field, Self::Coverage, Self::Stretch, Self::Wireframe];

    /// The name on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Texture => "texture",
            Self::Pastes => "pastes",
            Self::Field => "field",
            Self::Coverage => "coverage",
            Self::Stretch => "stretch",
            Self::Wireframe => "wireframe",
        }
    }
}

impl fmt::Display for PreviewStyle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for PreviewStyle {
    type Err = RenderError;

    fn from_str(text: &str) -> Result<Self, RenderError> {
        Self::ALL.into_iter().find(|style| style.name() == text).ok_or_else(|| RenderError::Style { text: text.to_owned() })
    }
}

/// What there is to show.
#[derive(Clone, Copy)]
pub struct Subject<'a> {
    /// The mesh.
    pub mesh: &'a Mesh,
    /// What the texture style shows.
    pub texture: &'a dyn SurfaceTexture,
    /// The pastes, for the styles that show them.
    pub lapped: Option<&'a LappedTexture>,
    /// What steered them.
    pub guide: Option<&'a Guide>,
}

/// A style made ready for one subject.
trait Show: Sync {
    /// What covers the surface.
    fn texture(&self) -> &dyn SurfaceTexture;
    /// Draws over a finished picture.
    fn overlay(&self, _seen: &Visibility, _picture: &mut Picture) {}
    /// What explains the colours.
    fn legend(&self) -> Option<Legend> {
        None
    }
}

/// Draws the views of a sheet in a style.
///
/// # Errors
/// If the sheet cannot be drawn, or the subject lacks what the style shows.
pub fn preview(subject: &Subject, style: PreviewStyle, options: &SheetOptions) -> Result<Picture, RenderError> {
    let Some(show) = show(subject, style, options.samples)? else {
        return super::sheet::sheet(subject.mesh, subject.texture, options);
    };
    let mesh = subject.mesh;
    let mut options = options.clone();
    options.draw.lighting = Lighting::even();
    let stage = Stage::new(mesh, &options.draw);
    let mut sheet = lay_out(mesh, &options, |camera, grid| {
        let seen = Visibility::new(mesh, camera, grid)?;
        let mut picture = stage.draw(show.texture(), &seen);
        show.overlay(&seen, &mut picture);
        Ok::<_, RenderError>(picture)
    })?;
    if let Some(legend) = show.legend() {
        sheet = legend.below(&sheet);
    }
    Ok(sheet)
}

/// A style made ready; none for the texture itself.
fn show<'a>(subject: &Subject<'a>, style: PreviewStyle, samples: u32) -> Result<Option<Box<dyn Show + 'a>>, RenderError> {
    let Subject { mesh, lapped, guide, .. } = *subject;
    let missing = |what| RenderError::Missing { style: style.name(), what };
    let lapped = || lapped.ok_or(missing("a lapped texture"));
    Ok(Some(match style {
        PreviewStyle::Texture => return Ok(None),
        PreviewStyle::Pastes => Box::new(pastes::Pastes::new(mesh, lapped()?)),
        PreviewStyle::Field => {
            let field = guide.and_then(Guide::field).ok_or(missing("a directed field"))?;
            Box::new(field::Arrows::new(mesh, field))
        }
        PreviewStyle::Coverage => Box::new(coverage::Coverage::new(mesh, lapped()?)),
        PreviewStyle::Stretch => Box::new(stretch::Stretch::new(mesh, lapped()?, guide.ok_or(missing("the field"))?)),
        PreviewStyle::Wireframe => Box::new(wireframe::Wireframe::new(mesh, samples)),
    }))
}

/// How far from a corner towards the middle of its face a style is asked for that corner's colour: right at the corner
/// the pastes of its neighbours count too.
const INWARD: f32 = 0.2;

/// The colours of a style at the corners of every face, linear light, for who draws by a graphics device; and what they mean.
/// Lines that the style draws over a picture are not among them.
///
/// # Errors
/// If the subject lacks what the style shows.
#[allow(clippy::type_complexity, reason = "colours and their legend")]
pub fn corner_colours(subject: &Subject<'_>, style: PreviewStyle) -> Result<(Vec<[Vec3; 3]>, Option<Legend>), RenderError> {
    let show = show(subject, style, 1)?;
    let texture = show.as_ref().map_or(subject.texture, |show| show.texture());
    let colour = |face: u32, k: usize| {
        let mut bary = Vec3::splat(INWARD / 2.0);
        bary[k] = 1.0 - INWARD;
        texture.texel(SurfacePoint { face, bary }, 0.0).base_color
    };
    let colours = (0..subject.mesh.face_count() as u32).into_par_iter().map(|f| [0, 1, 2].map(|k| colour(f, k))).collect();
    Ok((colours, show.and_then(|show| show.legend())))
}

/// The channels of pictures that only have a colour.
fn colour_only() -> ChannelSet {
    ChannelSet::default().with(Channel::BaseColor)
}

/// A texel that only has a colour (linear light).
const fn coloured(colour: Vec3) -> Texel {
    Texel { base_color: colour, alpha: 1.0, ..Texel::empty(Vec3::ZERO) }
}
