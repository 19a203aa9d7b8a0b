//! Distributions gathered face by face, weighted by area, in fixed memory.

use super::fit::Deviation;
use super::grow::Stops;
use serde::Serialize;

/// Bins of ln(stretch), up to [`LOG_STRETCH_MAX`].
const STRETCH_BINS: usize = 2000;
/// Stretch beyond e^4 = 55 counts as that.
const LOG_STRETCH_MAX: f64 = 4.0;
/// Bins of the angle, a tenth of a degree each.
const ANGLE_BINS: usize = 1800;

/// How faces deviate from the field: histograms by area.
#[derive(Debug, Clone)]
pub struct Spread {
    stretch: Vec<f64>,
    angle: Vec<f64>,
    mirrored: f64,
    log_square: f64,
    angle_square: f64,
    area: f64,
    max_stretch: f64,
}

impl Default for Spread {
    fn default() -> Self {
        Self {
            stretch: vec![0.0; STRETCH_BINS],
            angle: vec![0.0; ANGLE_BINS],
            mirrored: 0.0,
            log_square: 0.0,
            angle_square: 0.0,
            area: 0.0,
            max_stretch: 1.0,
        }
    }
}

/// The figures of a [`Spread`].
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct SpreadSummary {
    /// Root mean square of ln(stretch), where stretch is the larger of largest and inverse smallest singular value.
    pub stretch_rms_log: f64,
    /// Median stretch.
    pub stretch_median: f64,
    /// 99th percentile of stretch.
    pub stretch_p99: f64,
    /// Largest stretch.
    pub stretch_max: f64,
    /// Share of the area that is mirrored.
    pub mirrored_share: f64,
    /// Angle between texture up and the field, degrees: root mean square.
    pub direction_rms: f64,
    /// Median.
    pub direction_median: f64,
    /// 95th percentile.
    pub direction_p95: f64,
}

impl Spread {
    /// Takes a face in.
    pub fn add(&mut self, face: Deviation) {
        self.area += face.area;
        if face.stretch.is_finite() {
            let log = face.stretch.ln().clamp(0.0, LOG_STRETCH_MAX);
            self.log_square += face.area * log * log;
            self.max_stretch = self.max_stretch.max(face.stretch);
            self.stretch[((log / LOG_STRETCH_MAX * STRETCH_BINS as f64) as usize).min(STRETCH_BINS - 1)] += face.area;
        } else {
            self.mirrored += face.area;
            self.stretch[STRETCH_BINS - 1] += face.area;
        }
        let degrees = face.angle.to_degrees();
        self.angle_square += face.area * degrees * degrees;
        self.angle[((degrees / 180.0 * ANGLE_BINS as f64) as usize).min(ANGLE_BINS - 1)] += face.area;
    }

    /// Takes another one's faces in.
    pub fn merge(&mut self, other: &Self) {
        self.stretch.iter_mut().zip(&other.stretch).for_each(|(a, b)| *a += b);
        self.angle.iter_mut().zip(&other.angle).for_each(|(a, b)| *a += b);
        self.mirrored += other.mirrored;
        self.log_square += other.log_square;
        self.angle_square += other.angle_square;
        self.area += other.area;
        self.max_stretch = self.max_stretch.max(other.max_stretch);
    }

    /// The figures.
    #[must_use]
    pub fn summary(&self) -> SpreadSummary {
        let area = if self.area > 0.0 { self.area } else { 1.0 };
        let stretch = |share| (quantile(&self.stretch, share) * LOG_STRETCH_MAX).exp();
        SpreadSummary {
            stretch_rms_log: (self.log_square / area).sqrt(),
            stretch_median: stretch(0.5),
            stretch_p99: stretch(0.99),
            stretch_max: self.max_stretch,
            mirrored_share: self.mirrored / area,
            direction_rms: (self.angle_square / area).sqrt(),
            direction_median: quantile(&self.angle, 0.5) * 180.0,
            direction_p95: quantile(&self.angle, 0.95) * 180.0,
        }
    }
}

/// Place of a quantile along the bins, 0 to 1 (the middle of its bin).
fn quantile(bins: &[f64], share: f64) -> f64 {
    let total: f64 = bins.iter().sum();
    let mut sum = 0.0;
    for (i, b) in bins.iter().enumerate() {
        sum += b;
        if sum >= share * total {
            return (i as f64 + 0.5) / bins.len() as f64;
        }
    }
    0.0
}

impl Stops {
    /// Adds another's counts.
    pub fn add(&mut self, other: Self) {
        self.disc += other.disc;
        self.flip += other.flip;
        self.stretch += other.stretch;
        self.reach += other.reach;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_weigh_by_area() {
        let mut spread = Spread::default();
        spread.add(Deviation { area: 98.0, stretch: 1.1, angle: 0.1 });
        let mut other = Spread::default();
        other.add(Deviation { area: 2.0, stretch: 3.0, angle: 1.0 });
        spread.merge(&other);
        let s = spread.summary();
        assert!((s.stretch_median - 1.1).abs() < 0.01 && (s.stretch_p99 - 3.0).abs() < 0.01, "{s:?}");
        assert!((s.direction_p95 - 0.1_f64.to_degrees()).abs() < 0.1, "{s:?}");
    }
}
