//! Error against run time, interpolated between measurements.

/// Measured pairs of run time in seconds and error.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// By rising time; both above 0.
    points: Vec<(f64, f64)>,
}

/// Where a measured curve reaches a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Crossing {
    /// There, between two measurements or on one.
    At(f64),
    /// At or before the quickest measurement.
    Below,
    /// Nowhere in the measurements.
    Never,
}

impl Curve {
    /// A curve through `points` of time and error; those that are not above 0 are left out.
    pub fn new(points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let sound = |v: f64| v.is_finite() && v > 0.0;
        let mut points: Vec<_> =
            points.into_iter().filter(|(time, error)| sound(*time) && sound(*error)).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self { points }
    }

    /// The error at `time`, interpolated between the logarithms of both.
    pub fn error_at(&self, time: f64) -> Crossing {
        match (self.points.first(), self.points.last()) {
            (Some(first), Some(last)) if time >= first.0 && time <= last.0 => {}
            (Some(first), _) if time < first.0 => return Crossing::Below,
            _ => return Crossing::Never,
        }
        let after = self.points.partition_point(|(t, _)| *t < time);
        let b = self.points[after];
        let a = self.points[after.saturating_sub(1)];
        Crossing::At(between(a, b, time))
    }

    /// The error at `time`, as [`error_at`](Self::error_at); beyond the measurements in favour of the
    /// curve: as 1/time after the last one, as independent samples fall at best, and that of the
    /// first one before it. `None` without measurements.
    pub fn favoured_error_at(&self, time: f64) -> Option<f64> {
        let (first, last) = (self.points.first()?, self.points.last()?);
        match self.error_at(time) {
            Crossing::At(error) => Some(error),
            Crossing::Below => Some(first.1),
            Crossing::Never => Some(last.1 * last.0 / time),
        }
    }

    /// The shortest time from which the curve is at or under `error`, interpolated likewise.
    pub fn time_to(&self, error: f64) -> Crossing {
        match self.points.first() {
            Some(first) if first.1 == error => return Crossing::At(first.0),
            Some(first) if first.1 < error => return Crossing::Below,
            _ => {}
        }
        let steps = self.points.windows(2).map(|pair| (pair[0], pair[1]));
        let crossing = steps.into_iter().find(|(_, b)| b.1 <= error);
        let swap = |(time, error): (f64, f64)| (error, time);
        crossing.map_or(Crossing::Never, |(a, b)| Crossing::At(between(swap(a), swap(b), error)))
    }
}

/// y at x on the line through a and b between logarithms.
fn between(a: (f64, f64), b: (f64, f64), x: f64) -> f64 {
    if a.0 == b.0 {
        return b.1;
    }
    let share = (x / a.0).ln() / (b.0 / a.0).ln();
    a.1 * (b.1 / a.1).powf(share)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn inverse() -> Curve {
        Curve::new([(16.0, 1.0 / 16.0), (1.0, 1.0), (4.0, 0.25)])
    }

    fn is_at(reach: Crossing, value: f64) -> bool {
        matches!(reach, Crossing::At(v) if (v - value).abs() < 1e-9 * value)
    }

    #[test]
    fn a_power_law_is_met_between_measurements() {
        assert!(is_at(inverse().error_at(2.0), 0.5) && is_at(inverse().time_to(0.125), 8.0));
        assert!(is_at(inverse().error_at(16.0), 1.0 / 16.0) && is_at(inverse().time_to(1.0), 1.0));
    }

    #[test]
    fn nothing_is_extrapolated() {
        assert_eq!(inverse().error_at(0.9), Crossing::Below);
        assert_eq!(inverse().error_at(16.1), Crossing::Never);
        assert_eq!(inverse().time_to(1.1), Crossing::Below);
        assert_eq!(inverse().time_to(0.06), Crossing::Never);
        assert_eq!(Curve::new([]).error_at(1.0), Crossing::Never);
        assert_eq!(Curve::new([(1.0, 0.0), (f64::NAN, 1.0)]).time_to(1.0), Crossing::Never);
    }

    #[test]
    fn beyond_the_measurements_the_curve_is_favoured() {
        assert_eq!(inverse().favoured_error_at(32.0), Some(1.0 / 32.0));
        assert_eq!(inverse().favoured_error_at(0.5), Some(1.0));
        assert_eq!(Curve::new([]).favoured_error_at(1.0), None);
    }

    #[test]
    fn a_curve_that_rises_again_is_left_at_its_first_crossing() {
        let curve = Curve::new([(1.0, 1.0), (2.0, 0.5), (3.0, 0.7), (4.0, 0.1)]);
        assert!(is_at(curve.time_to(0.5), 2.0));
    }

    proptest! {
        #[test]
        fn answers_stay_within_the_measurements(
            points in prop::collection::vec((1e-3..1e3_f64, 1e-9..1e3_f64), 1..8),
            at in 1e-4..1e4_f64,
        ) {
            let curve = Curve::new(points.clone());
            let slack = 1.0 + 1e-9;
            if let Crossing::At(time) = curve.time_to(at) {
                let times = points.iter().map(|p| p.0);
                prop_assert!(time >= times.clone().fold(f64::INFINITY, f64::min) / slack);
                prop_assert!(time <= times.fold(0.0, f64::max) * slack);
            }
            if let Crossing::At(error) = curve.error_at(at) {
                let errors = points.iter().map(|p| p.1);
                prop_assert!(error >= errors.clone().fold(f64::INFINITY, f64::min) / slack);
                prop_assert!(error <= errors.fold(0.0, f64::max) * slack);
            }
        }
    }
}
