//! Pictures for the editor: the exemplar, and the alpha that pasting will make of outlines, laid over it: what is cut off is dark.

use crate::exemplar::srgb::to_byte;
use crate::exemplar::{Channel, Exemplar, ExemplarError, Outline, PatchOptions, PatchSource, PatchSpec, make_patches};
use egui::{Color32, ColorImage};

/// How dark what is cut off becomes, of 255.
const DARK: f32 = 190.0;

/// Pictures have at most so many pixels along a side: what every adapter takes.
const MOST_SIDE: usize = 2048;

/// The exemplar's colours, of a large one every n-th pixel.
#[must_use]
pub fn picture(exemplar: &Exemplar) -> ColorImage {
    let size = exemplar.size().map(|n| n as usize);
    let Some(color) = exemplar.channel(Channel::BaseColor) else { return ColorImage::filled(size, Color32::GRAY) };
    thinned(size, |x, y| {
        let [r, g, b] = color.finest().pixel(x as i64, y as i64).to_array().map(to_byte);
        Color32::from_rgb(r, g, b)
    })
}

/// A picture of pixels, or of every n-th along both sides.
fn thinned(size: [usize; 2], pixel: impl Fn(usize, usize) -> Color32) -> ColorImage {
    let every = size[0].max(size[1]).div_ceil(MOST_SIDE).max(1);
    let thin = size.map(|n| n.div_ceil(every));
    let at = |i: usize| pixel(i % thin[0] * every, i / thin[0] * every);
    ColorImage::new(thin, (0..thin[0] * thin[1]).map(at).collect())
}

/// A picture to be laid over the exemplar: clear where alpha is 1, dark where it is 0. Of several patches the
/// greatest alpha shows.
///
/// # Errors
/// If an outline cannot be cut.
pub fn veil(exemplar: &Exemplar, outlines: &[Outline], feather: f32) -> Result<ColorImage, ExemplarError> {
    let [w, h] = exemplar.size().map(|n| n as usize);
    let mut alpha = vec![0.0_f32; w * h];
    if !outlines.is_empty() {
        let source = PatchSource::Outlines { name: "drawn here".to_owned(), outlines: outlines.to_vec() };
        let options = PatchOptions { feather, ..PatchOptions::default() };
        let (patches, _) = make_patches(exemplar, 0, &[PatchSpec { source, weight: 1.0 }], &options)?;
        for patch in &patches {
            let mask = patch.mask.finest();
            let [mw, mh] = mask.size();
            for y in 0..mh {
                for x in 0..mw {
                    let (px, py) = (i64::from(x) + i64::from(patch.origin[0]), i64::from(y) + i64::from(patch.origin[1]));
                    if let (Ok(px), Ok(py)) = (usize::try_from(px), usize::try_from(py))
                        && px < w
                        && py < h
                    {
                        let here = &mut alpha[py * w + px];
                        *here = here.max(mask.grey(i64::from(x), i64::from(y)));
                    }
                }
            }
        }
    }
    Ok(thinned([w, h], |x, y| Color32::from_black_alpha((DARK * (1.0 - alpha[y * w + x])) as u8)))
}
