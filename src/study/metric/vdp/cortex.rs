//! The cortex transform (Daly 1993, "Cortex transform", after Watson 1987, "The Cortex Transform:
//! Rapid Computation of Simulated Neural Images").
//!
//! Frequencies are in cycles a pixel. Half amplitudes of the radial filters lie at 1/2, 1/4 ... 1/32;
//! the fans are 30 degrees apart. All bands add up to 1 everywhere, the corners of the spectrum
//! included.

use std::f64::consts::PI;

/// Rings between the base band and the highest frequencies, K - 1.
const LEVELS: i32 = 5;
/// Orientations, L.
const FANS: i32 = 6;
/// Angle between two fans.
const FAN_WIDTH: f64 = PI / FANS as f64;

/// One band of the transform.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Band {
    /// The lowest frequencies, of any orientation.
    Base,
    /// A ring of frequencies, 1 the highest, seen through a fan.
    Oriented {
        /// From 1 to [`LEVELS`].
        level: i32,
        /// From 0 to [`FANS`] - 1.
        fan: i32,
    },
}

impl Band {
    /// Every band, the base first.
    pub(super) fn all() -> impl Iterator<Item = Self> {
        let rings = (1..=LEVELS).rev();
        let oriented =
            rings.flat_map(|level| (0..FANS).map(move |fan| Self::Oriented { level, fan }));
        std::iter::once(Self::Base).chain(oriented)
    }

    /// What the band lets through of a frequency, 0 to 1.
    pub(super) fn gain(self, fx: f64, fy: f64) -> f64 {
        let rho = (fx * fx + fy * fy).sqrt();
        match self {
            Self::Base => base(rho),
            Self::Oriented { level, fan: index } => match dom(rho, level) {
                0.0 => 0.0,
                ring => ring * fan(fy.atan2(fx), index),
            },
        }
    }

    /// The slope s by which masking grows with the mask's contrast: coarse patterns are better
    /// learnt than fine ones. Values of Daly 1995, US patent 5394483; the chapter gives their range.
    pub(super) fn masking_slope(self) -> f64 {
        match self {
            Self::Base => 0.7,
            Self::Oriented { level: 4.., .. } => 0.8,
            Self::Oriented { .. } => 1.0,
        }
    }
}

/// The difference-of-mesas filter of a ring. Nothing stands above the first, so that it takes in
/// the corners of the spectrum.
fn dom(rho: f64, level: i32) -> f64 {
    let outer = if level == 1 { 1.0 } else { mesa(rho, level - 1) };
    let inner = if level == LEVELS { base(rho) } else { mesa(rho, level) };
    outer - inner
}

/// A flat top that falls to 0 over 2/3 of its half-amplitude frequency, 2^-level.
fn mesa(rho: f64, level: i32) -> f64 {
    let half = 0.5_f64.powi(level);
    let width = 2.0 / 3.0 * half;
    match (rho - half) / width + 0.5 {
        ..=0.0 => 1.0, // most frequencies are spared the cosine
        1.0.. => 0.0,
        fall => 0.5 * (1.0 + (PI * fall).cos()),
    }
}

/// The base band: a Gaussian cut at three standard deviations.
fn base(rho: f64) -> f64 {
    let end = 4.0 / 3.0 * 0.5_f64.powi(LEVELS);
    if rho < end { (-4.5 * (rho / end).powi(2)).exp() } else { 0.0 }
}

/// The fan around `index` steps of orientation; `theta` is the direction of the frequency.
fn fan(theta: f64, index: i32) -> f64 {
    let turn = (theta - f64::from(index) * FAN_WIDTH).rem_euclid(PI);
    let off = turn.min(PI - turn);
    if off < FAN_WIDTH { 0.5 * (1.0 + (PI * off / FAN_WIDTH).cos()) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_are_31_bands() {
        assert_eq!(Band::all().count(), 31);
    }

    #[test]
    fn bands_add_up_to_one_everywhere() {
        for i in 0..=50 {
            for j in -50..=50 {
                let [fx, fy] = [i, j].map(|k| f64::from(k) * 0.01);
                let sum: f64 = Band::all().map(|band| band.gain(fx, fy)).sum();
                assert!((sum - 1.0).abs() < 1e-12, "{sum} at {fx}, {fy}");
                assert!(Band::all().all(|band| band.gain(fx, fy) >= 0.0));
            }
        }
    }

    #[test]
    fn filters_are_even_and_pass_their_centres_whole() {
        for (level, rho) in [(1, 0.7), (2, 1.0 / 3.0), (3, 1.0 / 6.0), (4, 1.0 / 12.0)] {
            for index in 0..FANS {
                let (fy, fx) = (f64::from(index) * FAN_WIDTH).sin_cos();
                let band = Band::Oriented { level, fan: index };
                assert!((band.gain(rho * fx, rho * fy) - 1.0).abs() < 1e-9);
                assert!((band.gain(-rho * fx, -rho * fy) - 1.0).abs() < 1e-9);
            }
        }
    }
}
