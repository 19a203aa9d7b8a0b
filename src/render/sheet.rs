//! Several views of one mesh side by side on one picture, with captions.

use super::RenderError;
use super::camera::{Camera, View};
use super::lens::Grid;
use super::picture::{Picture, to_byte};
use super::raster::Visibility;
use super::reference::{Background, DrawOptions, Stage};
use super::text;
use crate::mesh::Mesh;
use crate::surface::SurfaceTexture;
use glam::{Vec2, Vec3};

/// How a sheet of views is laid out.
#[derive(Debug, Clone, PartialEq)]
pub struct SheetOptions {
    /// Views with their captions; an empty caption is not drawn.
    pub views: Vec<(String, View)>,
    /// Width and height of one view, pixels.
    pub size: [u32; 2],
    /// Samples along each side of a pixel.
    pub samples: u32,
    /// Views in a row; 0 makes the sheet about square.
    pub columns: u32,
    /// How each view looks.
    pub draw: DrawOptions,
}

impl Default for SheetOptions {
    /// Front three-quarter, side, back and from above.
    fn default() -> Self {
        let views = [(30.0, 18.0), (95.0, 8.0), (205.0, 18.0), (-30.0, 62.0)].map(|(yaw, pitch)| View::degrees(yaw, pitch));
        Self {
            views: views.into_iter().map(|view| (view.describe(), view)).collect(),
            size: [512, 512],
            samples: 3,
            columns: 0,
            draw: DrawOptions::default(),
        }
    }
}

/// Width of the lines between views, pixels.
pub const SEPARATOR: u32 = 2;
/// Colour of those lines, sRGB.
const SEPARATOR_COLOUR: [u8; 4] = [255, 255, 255, 255];
/// Colour of captions, sRGB.
const INK: Vec3 = Vec3::new(0.25, 0.25, 0.27);

/// Draws all views onto one picture.
///
/// # Errors
/// If there are no views, or a view or the sheet would be too large.
pub fn sheet(mesh: &Mesh, texture: &dyn SurfaceTexture, options: &SheetOptions) -> Result<Picture, RenderError> {
    let stage = Stage::new(mesh, &options.draw);
    lay_out(mesh, options, |camera, grid| Ok(stage.draw(texture, &Visibility::new(mesh, camera, grid)?)))
}

/// Sets the pictures that `draw` makes of each view in a grid.
///
/// # Errors
/// If there are no views, a view or the sheet would be too large, or `draw` fails.
pub fn lay_out<E: From<RenderError>>(
    mesh: &Mesh,
    options: &SheetOptions,
    mut draw: impl FnMut(&Camera, Grid) -> Result<Picture, E>,
) -> Result<Picture, E> {
    let [width, height] = options.size;
    let count = options.views.len() as u32;
    let columns = if options.columns == 0 { f64::from(count).sqrt().ceil() as u32 } else { options.columns.min(count) };
    let rows = count.div_ceil(columns.max(1));
    let along = |cells: u32, size: u32| cells.saturating_mul(size.saturating_add(SEPARATOR)).saturating_sub(SEPARATOR);
    let grid = Grid { width, height, samples: options.samples };
    grid.check()?;
    // The sheet as a whole must be a picture, too.
    let whole = Grid { width: along(columns, width), height: along(rows, height), samples: 1 };
    whole.check()?;
    let separator = match options.draw.background {
        Background::Transparent => [0; 4],
        _ => SEPARATOR_COLOUR,
    };
    let mut out = Picture::filled(whole.width, whole.height, separator);
    for (i, (caption, view)) in options.views.iter().enumerate() {
        let camera = view.frame(mesh, grid.aspect());
        let mut picture = draw(&camera, grid)?;
        let letter = (0.02 * height as f32).clamp(7.0, 24.0);
        let at = Vec2::new(1.2 * letter, height as f32 - 2.4 * letter);
        text::write(&mut picture, caption, at, letter, INK, 0.85);
        let (column, row) = (i as u32 % columns, i as u32 / columns);
        out.paste(&picture, column * (width + SEPARATOR), row * (height + SEPARATOR));
    }
    // Cells left over in the last row continue the wall.
    if !count.is_multiple_of(columns) {
        let tone = out.pixel(0, whole.height - 1);
        let filler = Picture::filled(width, height, [tone[0], tone[1], tone[2], to_byte(f32::from(tone[3]) / 255.0)]);
        for cell in count..columns * rows {
            out.paste(&filler, (cell % columns) * (width + SEPARATOR), (cell / columns) * (height + SEPARATOR));
        }
    }
    Ok(out)
}
