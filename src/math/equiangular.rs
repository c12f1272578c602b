//! Distances along a ray, dense where it passes a place.

use std::f64::consts::FRAC_PI_2;

use super::{Ray, Span, World, WorldPoint};

/// Distances along a ray in proportion to one over the squared distance from a place beside it, so
/// that light from a lamp there loses its peak (Kulla and Fajardo 2012, "Importance Sampling
/// Techniques for Path Tracing in Participating Media", section 3).
#[derive(Debug, Clone, Copy)]
pub struct Equiangular {
    span: Span,
    /// Where the ray passes the place closest, in metres along it.
    foot: f64,
    /// Distance of the place from there, in metres, with the spread of what is around the place.
    distance: f64,
    /// Angle at the place, in radians, from the foot to the start of the span.
    start: f64,
    /// Angle at the place that the span fills, in radians.
    opening: f64,
}

impl Equiangular {
    /// Over `span` of `ray` (unit direction) round `place`; nothing where the span has no length
    /// or the ray leads through the place, so that no density exists.
    pub fn new(ray: &Ray<World>, span: Span, place: WorldPoint) -> Option<Self> {
        Self::around(ray, span, place, 0.0)
    }

    /// As [`new`](Self::new), for places around `place` whose distances from it have a root mean square of `spread`
    /// metres: in proportion to one over their mean squared distance.
    pub fn around(ray: &Ray<World>, span: Span, place: WorldPoint, spread: f64) -> Option<Self> {
        let to = place - ray.origin;
        let foot = to.dot(ray.direction);
        let distance = (to - ray.direction * foot).length().hypot(spread);
        Self::over(span, foot, distance)
    }

    /// Over the part of its span that is within `other`; nothing where that has no length.
    pub fn within(&self, other: Span) -> Option<Self> {
        Self::over(self.span.intersect(other), self.foot, self.distance)
    }

    fn over(span: Span, foot: f64, distance: f64) -> Option<Self> {
        let angle = |t: f64| if t.is_infinite() { FRAC_PI_2 } else { (t - foot).atan2(distance) };
        let start = angle(span.start);
        let opening = angle(span.end) - start;
        let sound = distance > 0.0 && opening > 0.0 && foot.is_finite();
        sound.then_some(Self { span, foot, distance, start, opening })
    }

    /// Integral of one over the squared distance along the span, 1/m.
    pub fn total(&self) -> f64 {
        self.opening / self.distance
    }

    /// A distance along the ray.
    pub fn sample(&self, u: f64) -> f64 {
        let t = self.foot + self.distance * (self.start + u * self.opening).tan();
        t.clamp(self.span.start, self.span.end.min(f64::MAX))
    }

    /// Density of [`sample`](Self::sample) at a distance, 1/m; 0 outside the span.
    pub fn pdf(&self, t: f64) -> f64 {
        if t < self.span.start || t > self.span.end {
            return 0.0;
        }
        self.distance / (self.opening * (self.distance.powi(2) + (t - self.foot).powi(2)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use proptest::prelude::*;

    proptest! {
        /// The density integrates, from one sample to another, to the difference of their numbers.
        #[test]
        fn density_belongs_to_samples(
            start in -5.0..5.0f64, length in 1e-3..20.0f64,
            place in prop::array::uniform3(-10.0..10.0f64),
            low in 0.0..1.0f64, high in 0.0..1.0f64,
        ) {
            let ray = Ray::new(WorldPoint::new(0.1, 0.2, 0.3), DVec3::Z);
            let span = Span::new(start, start + length);
            let place = WorldPoint::from_xyz(place.into());
            let distances = Equiangular::new(&ray, span, place).unwrap();
            let (from, to) = (distances.sample(low.min(high)), distances.sample(low.max(high)));
            prop_assert!(span.start <= from && from <= to && to <= span.end);
            // Simpson's rule.
            let steps = 2000;
            let dt = (to - from) / f64::from(steps);
            let sum: f64 = (0..steps)
                .map(|i| from + f64::from(i) * dt)
                .map(|t| {
                    let at = |x: f64| distances.pdf(t + x * dt);
                    (at(0.0) + 4.0 * at(0.5) + at(1.0)) * dt / 6.0
                })
                .sum();
            prop_assert!((sum - (high - low).abs()).abs() < 1e-4, "{sum} for {low} and {high}");
        }
    }

    /// Parts of a span have their shares of its integral, and the density of the whole over those.
    #[test]
    fn parts_are_as_dense_as_the_whole() {
        let ray = Ray::new(WorldPoint::new(0.0, 0.0, 0.0), DVec3::Z);
        let place = WorldPoint::new(1.0, 0.0, 2.0);
        let whole = Equiangular::around(&ray, Span::new(0.5, 7.0), place, 0.3).unwrap();
        let [near, far] =
            [Span::new(0.0, 2.5), Span::new(2.5, 9.0)].map(|part| whole.within(part).unwrap());
        assert!((near.total() + far.total() - whole.total()).abs() < 1e-12);
        for (part, t) in [(near, 0.6), (near, 2.4), (far, 2.6), (far, 6.9)] {
            let density = part.pdf(t) * part.total() / whole.total();
            assert!((density - whole.pdf(t)).abs() < 1e-12, "{density} at {t}");
        }
        assert!(whole.within(Span::new(7.5, 9.0)).is_none());
    }

    #[test]
    fn reaches_endless_rays_and_refuses_what_has_no_density() {
        let ray = Ray::new(WorldPoint::new(0.0, 0.0, 0.0), DVec3::Z);
        let beside = Equiangular::new(&ray, Span::AHEAD, WorldPoint::new(1.0, 0.0, 0.0)).unwrap();
        assert!((beside.sample(0.5) - 1.0).abs() < 1e-12, "half of the quarter turn");
        assert!(beside.sample(1.0).is_finite());
        assert!(Equiangular::new(&ray, Span::AHEAD, WorldPoint::new(0.0, 0.0, 3.0)).is_none());
        let nowhere = Span::new(2.0, 2.0);
        assert!(Equiangular::new(&ray, nowhere, WorldPoint::new(1.0, 0.0, 0.0)).is_none());
    }
}
