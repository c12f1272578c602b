//! A stretch of a ray through a medium.

use crate::math::{Rgb, Span, Spectrum};

/// A value along a stretch of a ray as a straight line: nowhere below 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Ramp<S = f64> {
    /// Mean value.
    pub mean: S,
    /// By how much the value at the end is above the mean, and the one at the start below it.
    pub rise: S,
}

impl Ramp {
    /// The line of this mean that rises by `rise`, or by as much of it as leaves no value below 0.
    pub fn new(mean: f64, rise: f64) -> Self {
        let rise = if rise > mean { mean } else { rise };
        Self { mean, rise: if rise < -mean { -mean } else { rise } }
    }

    /// The same value everywhere.
    pub const fn flat(mean: f64) -> Self {
        Self { mean, rise: 0.0 }
    }

    /// What it comes to where 1 means `unit`.
    pub fn times<S: Spectrum>(self, unit: S) -> Ramp<S> {
        Ramp { mean: unit * self.mean, rise: unit * self.rise }
    }

    /// The same line over `part` of `whole`.
    pub fn part(self, whole: Span, part: Span) -> Self {
        if self.rise == 0.0 {
            return self;
        }
        let fraction = |t: f64| ((t - whole.start) / whole.length()).clamp(0.0, 1.0);
        let (start, end) = (fraction(part.start), fraction(part.end));
        Self::new(self.mean + self.rise * (start + end - 1.0), self.rise * (end - start))
    }
}

/// A stretch of a ray with its coefficients.
#[derive(Debug, Clone, Copy)]
pub struct Piece<S = Rgb> {
    /// Where it is, in metres along the ray.
    pub span: Span,
    /// Mean extinction coefficient, 1/m.
    pub sigma_t: S,
    /// By how much the extinction coefficient rises from its mean to the end of the piece, as it
    /// does from the start to the mean, 1/m: at most the mean in size. Within a voxel that is
    /// optically thick it decides where light scatters.
    pub rise: S,
    /// Mean emission coefficient, W/(m³ sr).
    pub emission: S,
    /// Optical thickness from the start of the ray to the start of the piece.
    pub before: S,
}

impl<S: Spectrum> Piece<S> {
    /// The extinction coefficient `along` metres from the start of the piece, 1/m.
    pub fn sigma_t_at(&self, along: f64) -> S {
        self.sigma_t + self.rise * (2.0 * along / self.span.length() - 1.0)
    }

    /// Optical thickness from the start of the ray to `along` metres from the start of the piece.
    pub fn thickness_to(&self, along: f64) -> S {
        let mean = self.sigma_t - self.rise * (1.0 - along / self.span.length());
        self.before + thickness_of(mean, along)
    }

    /// How many metres from the start of the piece the optical thickness from the start of the ray
    /// is `target` in a channel; nothing where nothing is met.
    pub(super) fn reach(&self, target: f64, channel: usize) -> Option<f64> {
        let (mean, rise) = (self.sigma_t.channel(channel), self.rise.channel(channel));
        let length = self.span.length();
        let left = target - self.before.channel(channel);
        // The smaller root of the quadratic that the thickness is, in the form without cancellation.
        let first = mean - rise;
        let root = (first * first + 4.0 * rise * (left / length)).max(0.0).sqrt();
        (mean > 0.0)
            .then(|| if left > 0.0 { (2.0 * left / (first + root)).min(length) } else { 0.0 })
    }
}

/// `sigma_t` times `length`, where nothing over an endless way is nothing.
pub(super) fn thickness_of<S: Spectrum>(sigma_t: S, length: f64) -> S {
    (sigma_t * length).map(|tau| if tau.is_nan() { 0.0 } else { tau })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn piece(mean: f64, share: f64, length: f64) -> Piece<f64> {
        let Ramp { mean, rise } = Ramp::new(mean, share * mean);
        let span = Span::new(3.0, 3.0 + length);
        Piece { span, sigma_t: mean, rise, emission: 0.0, before: 0.5 }
    }

    #[test]
    fn a_line_stays_at_or_above_0() {
        assert_eq!(Ramp::new(2.0, 5.0), Ramp { mean: 2.0, rise: 2.0 });
        assert_eq!(Ramp::new(2.0, -5.0), Ramp { mean: 2.0, rise: -2.0 });
        assert_eq!(Ramp::new(2.0, -1.0), Ramp { mean: 2.0, rise: -1.0 });
        assert_eq!(Ramp::new(0.0, 1.0), Ramp::flat(0.0));
    }

    proptest! {
        #[test]
        fn parts_make_up_the_whole(share in -1.0..=1.0f64, cut in 0.0..=1.0f64) {
            let whole = Span::new(1.0, 3.0);
            let ramp = Ramp::new(4.0, 4.0 * share);
            let cut = 1.0 + 2.0 * cut;
            let [a, b] = [Span::new(1.0, cut), Span::new(cut, 3.0)].map(|s| (ramp.part(whole, s), s));
            let sum = a.0.mean * a.1.length() + b.0.mean * b.1.length();
            prop_assert!((sum - 8.0).abs() < 1e-12);
            let (end, start) = (a.0.mean + a.0.rise, b.0.mean - b.0.rise);
            prop_assert!((end - start).abs() < 1e-12, "{end} then {start}");
        }

        #[test]
        fn reach_inverts_thickness(
            mean in -8.0..8.0f64,
            share in -1.0..=1.0f64,
            length in -6.0..6.0f64,
            fraction in 0.0..=1.0f64,
        ) {
            let piece = piece(10f64.powf(mean), share, 10f64.powf(length));
            let tau = piece.sigma_t * piece.span.length() * fraction;
            let along = piece.reach(0.5 + tau, 0).unwrap();
            prop_assert!((0.0..=piece.span.length()).contains(&along));
            let left = 0.5 + tau - 0.5; // as it is rounded beside what lies before
            let found = piece.thickness_to(along) - 0.5;
            prop_assert!((found - left).abs() <= 1e-9 * tau + 1e-12, "{found} for {tau}");
        }

        #[test]
        fn extinction_is_the_slope_of_thickness(share in -1.0..=1.0f64, along in 0.1..1.9f64) {
            let piece = piece(5.0, share, 2.0);
            let slope = (piece.thickness_to(along + 1e-4) - piece.thickness_to(along - 1e-4)) / 2e-4;
            prop_assert!((slope - piece.sigma_t_at(along)).abs() < 1e-8);
        }
    }
}
