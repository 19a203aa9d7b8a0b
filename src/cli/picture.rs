//! Pictures on the command line: sizes, cameras, styles, and writing them.

use crate::format::write_file;
use crate::render::{Background, Picture, SEPARATOR, SheetOptions, UpAxis, View};
use anyhow::Context;
use glam::DVec3;
use std::path::Path;

/// A size like 1024x768.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Size(pub [u32; 2]);

impl std::str::FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || "give width and height in pixels, like 1024x768".to_owned();
        let (w, h) = text.split_once(['x', 'X']).ok_or_else(wrong)?;
        let number = |s: &str| s.trim().parse::<u32>().ok().filter(|n| (1..=16384).contains(n)).ok_or_else(wrong);
        Ok(Self([number(w)?, number(h)?]))
    }
}

impl std::fmt::Display for Size {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}x{}", self.0[0], self.0[1])
    }
}

/// The up axis of a picture of a model whose texture goes up along `axis`.
#[must_use]
pub fn up_axis(axis: Option<DVec3>) -> UpAxis {
    match axis {
        Some(a) if a.z.abs() > a.x.abs().max(a.y.abs()) => UpAxis::Z,
        _ => UpAxis::Y,
    }
}

/// A single view, or the four standard ones on a sheet of `size` with `up` upward.
#[must_use]
pub fn views(camera: Option<View>, size: [u32; 2], samples: u32, transparent: bool, up: UpAxis) -> SheetOptions {
    let mut options = SheetOptions { samples, ..SheetOptions::default() };
    match camera {
        Some(view) => {
            options.views = vec![(String::new(), view)];
            options.size = size;
        }
        None => {
            options.views.iter_mut().for_each(|(_, view)| view.up = up);
            options.size = size.map(|s| (s.saturating_sub(SEPARATOR) / 2).max(1));
        }
    }
    if transparent {
        options.draw.background = Background::Transparent;
    }
    options
}

/// Writes a picture as PNG.
///
/// # Errors
/// If the file cannot be written.
pub fn save(path: &Path, picture: &Picture) -> anyhow::Result<()> {
    let png = picture.png().context("the picture cannot be encoded")?;
    write_file(path, |out| out.write_all(&png))?;
    Ok(())
}
