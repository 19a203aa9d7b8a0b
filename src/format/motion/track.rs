//! Numbers over time: keys and what lies between them.

/// How a track goes from key to key.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Interpolation {
    /// Straight; rotations turn evenly.
    #[default]
    Linear,
    /// Not at all, until the next key.
    Step,
    /// Along a cubic whose slopes are given with each key.
    CubicSpline,
}

/// Some numbers over time.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Track {
    /// How it goes from key to key.
    pub interpolation: Interpolation,
    /// When the keys are, seconds, rising. Before the first and after the last the track stands still.
    pub times: Vec<f32>,
    /// The numbers of each key in turn; with [`Interpolation::CubicSpline`] the slopes into the key, the numbers, and the
    /// slopes out of it.
    pub values: Vec<f32>,
}

impl Track {
    /// What is wrong with a track of `width` numbers a key, if anything.
    #[must_use]
    pub fn flaw(&self, width: usize) -> Option<String> {
        let parts = if self.interpolation == Interpolation::CubicSpline { 3 } else { 1 };
        let needed = self.times.len().saturating_mul(parts).saturating_mul(width);
        if self.times.is_empty() {
            return Some("it has no keys".to_owned());
        }
        if !self.times.iter().all(|t| *t >= 0.0 && t.is_finite()) || !self.times.is_sorted_by(|a, b| a < b) {
            return Some("its times do not rise from 0 on".to_owned());
        }
        if self.values.len() != needed {
            let (keys, has) = (self.times.len(), self.values.len());
            return Some(format!("its {keys} keys need {needed} numbers, but there are {has}"));
        }
        self.values.iter().any(|v| !v.is_finite()).then(|| "it holds something that is not a number".to_owned())
    }

    /// The numbers at a time. `turns`: they are a quaternion, which turns evenly and stays one. The track must have no flaw.
    #[must_use]
    pub fn at(&self, time: f64, turns: bool) -> Vec<f64> {
        let cubic = self.interpolation == Interpolation::CubicSpline;
        let width = self.values.len() / self.times.len() / if cubic { 3 } else { 1 };
        let row = |k: usize, part: usize| {
            let row = if cubic { 3 * k + part } else { k };
            self.values[row * width..(row + 1) * width].iter().map(|&v| f64::from(v))
        };
        let after = self.times.partition_point(|&t| f64::from(t) <= time);
        if after == 0 || after == self.times.len() || self.interpolation == Interpolation::Step {
            return row(after.saturating_sub(1), 1).collect();
        }
        let k = after - 1;
        let (start, end) = (f64::from(self.times[k]), f64::from(self.times[after]));
        let (span, s) = (end - start, (time - start) / (end - start));
        if cubic {
            let (s2, s3) = (s * s, s * s * s);
            let basis = [2.0 * s3 - 3.0 * s2 + 1.0, (s3 - 2.0 * s2 + s) * span, 3.0 * s2 - 2.0 * s3, (s3 - s2) * span];
            let keys = row(k, 1).zip(row(k, 2)).zip(row(after, 1).zip(row(after, 0)));
            return keys.map(|((v0, b0), (v1, a1))| basis[0] * v0 + basis[1] * b0 + basis[2] * v1 + basis[3] * a1).collect();
        }
        if turns {
            let quaternion = |k: usize| {
                let v: Vec<f64> = row(k, 0).collect();
                glam::DQuat::from_slice(&v).normalize()
            };
            let between = quaternion(k).slerp(quaternion(after), s);
            return between.to_array().to_vec();
        }
        row(k, 0).zip(row(after, 0)).map(|(a, b)| a + (b - a) * s).collect()
    }

    /// A track with the same keys on which nothing changes.
    #[must_use]
    pub fn still(&self, values: &[f32]) -> Self {
        let slopes = if self.interpolation == Interpolation::CubicSpline { values.len() } else { 0 };
        let none = std::iter::repeat_n(0.0, slopes);
        let key = || none.clone().chain(values.iter().copied()).chain(none.clone());
        Self { values: self.times.iter().flat_map(|_| key()).collect(), ..self.clone() }
    }

    /// Several tracks as one whose keys hold the numbers of all in turn, and whether that is exact: it is where all have the
    /// same keys, or none goes along cubics and all go the same way. Else keys are added, `per_second`.
    #[must_use]
    pub fn beside(tracks: &[&Self], per_second: f64) -> (Self, bool) {
        let Some(first) = tracks.first() else { return (Self::default(), true) };
        let alike = |t: &&Self| t.interpolation == first.interpolation;
        let parts = |t: &Self| if t.interpolation == Interpolation::CubicSpline { 3 } else { 1 };
        if tracks.iter().all(|t| alike(t) && t.times == first.times) {
            let mut values = Vec::new();
            for row in 0..first.times.len() * parts(first) {
                for track in tracks {
                    let width = track.values.len() / (first.times.len() * parts(first));
                    values.extend_from_slice(&track.values[row * width..(row + 1) * width]);
                }
            }
            return (Self { values, ..(*first).clone() }, true);
        }
        let exact = first.interpolation != Interpolation::CubicSpline && tracks.iter().all(alike);
        let mut times: Vec<f32> = tracks.iter().flat_map(|t| &t.times).copied().collect();
        let end = times.iter().copied().fold(0.0, f32::max);
        if !exact {
            times.extend((0..(f64::from(end) * per_second) as usize).map(|k| (k as f64 / per_second) as f32));
        }
        times.sort_by(f32::total_cmp);
        times.dedup();
        let at = |&time: &f32| tracks.iter().flat_map(move |t| t.at(f64::from(time), false)).map(|v| v as f32);
        let values = times.iter().flat_map(at).collect();
        (Self { interpolation: if exact { first.interpolation } else { Interpolation::Linear }, times, values }, exact)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn track(interpolation: Interpolation, values: &[f32]) -> Track {
        Track { interpolation, times: vec![1.0, 3.0], values: values.to_vec() }
    }

    #[test]
    fn keys_are_met_and_the_way_between_them_is_as_the_specification_has_it() {
        let linear = track(Interpolation::Linear, &[2.0, 6.0]);
        let step = track(Interpolation::Step, &[2.0, 6.0]);
        // Value 0 with slope 1 out of it, to value 0 with slope -1 into it: s(1 - s) times the span.
        let cubic = track(Interpolation::CubicSpline, &[9.0, 0.0, 1.0, -1.0, 0.0, 9.0]);
        for (track, times) in [
            (&linear, [(0.0, 2.0), (1.0, 2.0), (1.5, 3.0), (3.0, 6.0), (9.0, 6.0)]),
            (&step, [(0.0, 2.0), (1.0, 2.0), (2.9, 2.0), (3.0, 6.0), (9.0, 6.0)]),
            (&cubic, [(0.0, 0.0), (1.0, 0.0), (2.0, 0.5), (1.5, 0.375), (3.0, 0.0)]),
        ] {
            assert_eq!(track.flaw(1), None, "{track:?} is sound");
            for (time, value) in times {
                let found = track.at(time, false)[0];
                assert!((found - value).abs() < 1e-9, "{:?} at {time}: {found}, not {value}", track.interpolation);
            }
        }
        let half = std::f32::consts::FRAC_1_SQRT_2;
        let turn = track(Interpolation::Linear, &[0.0, 0.0, 0.0, 1.0, 0.0, half, 0.0, half]);
        let third = turn.at(1.0 + 2.0 / 3.0, true);
        let angle = 2.0 * third[1].atan2(third[3]);
        assert!((angle.to_degrees() - 30.0).abs() < 1e-4, "a third of a quarter turn: {}", angle.to_degrees());
    }

    #[test]
    fn tracks_beside_each_other_say_what_each_says() {
        let a = track(Interpolation::Linear, &[2.0, 6.0]);
        let b = Track { times: vec![0.0, 1.0, 2.5], values: vec![1.0, 0.0, 9.0], ..Track::default() };
        let cubic = track(Interpolation::CubicSpline, &[9.0, 0.0, 1.0, -1.0, 0.0, 9.0]);
        let still = cubic.still(&[7.0]);
        for (tracks, bound) in
            [([&a, &a], 1e-6), ([&a, &b], 1e-6), ([&cubic, &cubic], 1e-6), ([&cubic, &still], 1e-6), ([&a, &cubic], 1e-3)]
        {
            let (both, exact) = Track::beside(&tracks, 60.0);
            assert_eq!(exact, bound < 1e-4, "exact where it says so");
            assert_eq!(both.flaw(2), None, "sound");
            for k in 0..40 {
                let time = f64::from(k) * 0.1;
                let found = both.at(time, false);
                let apart = [tracks[0].at(time, false)[0], tracks[1].at(time, false)[0]];
                assert!((found[0] - apart[0]).abs().max((found[1] - apart[1]).abs()) < bound, "{time}: {found:?} {apart:?}");
            }
        }
    }

    #[test]
    fn flaws_are_told() {
        assert!(track(Interpolation::Linear, &[1.0]).flaw(1).is_some(), "too few numbers");
        assert!(track(Interpolation::Linear, &[1.0, f32::NAN]).flaw(1).is_some(), "not a number");
        assert!(Track::default().flaw(1).is_some(), "no keys");
        let falling = Track { times: vec![1.0, 0.5], values: vec![0.0; 2], ..Track::default() };
        assert!(falling.flaw(1).is_some(), "time runs backwards");
    }
}
