//! An exemplar made ready to be compared with: what is the same for every result.

use super::histogram::Histogram;
use super::patches::{Known, coherence_to};
use super::pieces::{Pieces, Placed, of_image, of_surface};
use super::sliced::Sliced;
use super::spectrum::{laplacian_energy, repetition};
use super::{Measured, OwnSteps, Spread};
use crate::exemplar::{Exemplar, Wrap};

/// Pieces that are compared.
const PIECES: usize = 1500;
/// Their side, pixels: 7 on the coarsest of three levels.
const SIDE: usize = 28;
/// Larger pieces that repetition is looked for in, and their side.
const LARGE: usize = 12;
const LARGE_SIDE: usize = 120;

/// Pieces with what is found out once about them, however many others are compared with them.
#[derive(Debug)]
struct Prepared {
    pieces: Pieces,
    known: Known,
    sliced: Sliced,
    histogram: Histogram,
    energy: f64,
}

impl Prepared {
    fn new(pieces: Pieces, known: Known) -> Self {
        let (sliced, histogram, energy) = (Sliced::new(&pieces), Histogram::new(&pieces), laplacian_energy(&pieces));
        Self { pieces, known, sliced, histogram, energy }
    }
}

/// An exemplar's pieces and patches, its own steps, and the floor.
#[derive(Debug)]
pub struct Reference {
    /// `None` if the exemplar is too small for a piece.
    whole: Option<Prepared>,
    /// Its steps from pixel to pixel; `None` as for [`Self::known`].
    pub own: Option<OwnSteps>,
    /// One half of the exemplar against the other.
    pub floor: Measured,
}

impl Reference {
    /// Cuts an exemplar into pieces.
    #[must_use]
    pub fn new(exemplar: &Exemplar) -> Self {
        let whole = of_image(exemplar, SIDE, PIECES, 3, [0.0, 1.0]);
        let [half, other] = [(4, [0.0, 0.5]), (5, [0.5, 1.0])].map(|(seed, part)| of_image(exemplar, SIDE, PIECES, seed, part));
        // Over its edges an exemplar repeats itself; that is no measure of what it holds.
        let mut alone = exemplar.clone();
        alone.wrap = Wrap::Clamp;
        let large = of_image(&alone, LARGE_SIDE, LARGE, 6, [0.0, 1.0]);
        let own = OwnSteps::new(&whole);
        let known = |part, pieces: &Pieces| Known::of_image(exemplar, part).filter(|_| !pieces.data.is_empty());
        let other = known([0.5, 1.0], &other).map(|known| Prepared::new(other, known));
        let known = known([0.0, 1.0], &whole);
        let floor = measured(&half, &large, other.as_ref());
        Self { whole: known.map(|known| Prepared::new(whole, known)), own, floor }
    }

    /// The exemplar's patches; `None` if it is too small for a piece.
    #[must_use]
    pub fn known(&self) -> Option<&Known> {
        self.whole.as_ref().map(|w| &w.known)
    }

    /// Measures a texture on a surface at points drawn by a seed and the next; nothing is a number if the exemplar is too small.
    #[must_use]
    pub fn measure(&self, at: &Placed, seed: u64) -> Measured {
        // Nothing to compare with; and pieces of pixels as large as the exemplar would be walked all over the surface.
        if self.whole.is_none() {
            return nothing();
        }
        let result = of_surface(at, SIDE, PIECES, seed);
        let large = of_surface(at, LARGE_SIDE, LARGE, seed + 1);
        measured(&result, &large, self.whole.as_ref())
    }

    /// Measures an image, as [`Self::measure`] does a surface.
    #[must_use]
    pub fn measure_image(&self, image: &Exemplar, seed: u64) -> Measured {
        let result = of_image(image, SIDE, PIECES, seed, [0.0, 1.0]);
        let large = of_image(image, LARGE_SIDE, LARGE, seed + 1, [0.0, 1.0]);
        measured(&result, &large, self.whole.as_ref())
    }
}

/// What an exemplar without a piece of its own tells.
const fn nothing() -> Measured {
    let spread = Spread { mean: f64::NAN, p95: f64::NAN, p99: f64::NAN };
    Measured { swd: f64::NAN, coherence: spread, completeness: spread, energy: f64::NAN, repetition: f64::NAN, histogram: f64::NAN }
}

/// Measures pieces against an exemplar's.
fn measured(result: &Pieces, large: &Pieces, exemplar: Option<&Prepared>) -> Measured {
    let Some(exemplar) = exemplar else { return nothing() };
    let (coherence, completeness) = coherence_to(result, &exemplar.pieces, &exemplar.known);
    Measured {
        swd: Sliced::new(result).distance(&exemplar.sliced),
        coherence,
        completeness,
        energy: laplacian_energy(result) / exemplar.energy.max(f64::MIN_POSITIVE),
        repetition: repetition(large),
        histogram: Histogram::new(result).distance(&exemplar.histogram),
    }
}
