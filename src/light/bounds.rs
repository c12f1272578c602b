//! Where lights are, and where they are sampled.

use crate::math::{Aabb, Ray, Span, World, WorldPoint};

/// A sphere round a light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightBounds {
    /// Its centre.
    pub center: WorldPoint,
    /// Its radius in metres; 0 where the light has no extent.
    pub radius: f64,
}

impl LightBounds {
    /// The sphere grown by `margin` metres.
    #[must_use]
    pub fn grown(self, margin: f64) -> Self {
        Self { radius: self.radius + margin, ..self }
    }

    /// Whether `p` is in the sphere.
    pub fn contains(&self, p: WorldPoint) -> bool {
        (p - self.center).length_squared() < self.radius * self.radius
    }

    /// Whether the box round the sphere touches `bounds`, as the sphere does or nearly does.
    pub fn touches(&self, bounds: &Aabb<World>) -> bool {
        bounds.grown(self.radius).contains(self.center)
    }

    /// The part of `span` of `ray` (unit direction) in the sphere; empty where it misses that.
    pub fn clip(&self, ray: &Ray<World>, span: Span) -> Span {
        let to = self.center - ray.origin;
        let foot = to.dot(ray.direction);
        let aside = (to - ray.direction * foot).length();
        let half = ((self.radius - aside) * (self.radius + aside)).max(0.0).sqrt();
        Span::new(foot - half, foot + half).intersect(span)
    }
}

/// Where a light is sampled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LightRegion {
    /// At all places.
    Everywhere,
    /// At none.
    Nowhere,
    /// At places in a sphere.
    Within(LightBounds),
}

impl LightRegion {
    /// Whether `p` is in it.
    pub fn contains(&self, p: WorldPoint) -> bool {
        match self {
            Self::Everywhere => true,
            Self::Nowhere => false,
            Self::Within(bounds) => bounds.contains(p),
        }
    }

    /// The part of `span` of `ray` (unit direction) in it.
    pub fn clip(&self, ray: &Ray<World>, span: Span) -> Span {
        match self {
            Self::Everywhere => span,
            Self::Nowhere => Span::new(0.0, 0.0),
            Self::Within(bounds) => bounds.clip(ray, span),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use proptest::prelude::*;

    proptest! {
        /// Places on a ray are in the span where they are in the sphere.
        #[test]
        fn the_span_is_what_lies_in_the_sphere(
            center in prop::array::uniform3(-3.0..3.0f64),
            direction in prop::array::uniform3(-1.0..1.0f64),
            radius in 0.0..3.0f64,
        ) {
            let direction = DVec3::from(direction).try_normalize().unwrap_or(DVec3::X);
            let ray = Ray::new(WorldPoint::new(0.1, -0.2, 0.3), direction);
            let bounds = LightBounds { center: WorldPoint::from_xyz(center.into()), radius };
            let span = LightRegion::Within(bounds).clip(&ray, Span::new(-10.0, 10.0));
            for step in -400..=400 {
                let t = 0.025 * f64::from(step);
                let distance = (ray.at(t) - bounds.center).length();
                if (distance - radius).abs() > 1e-6 {
                    let is_in = t > span.start && t < span.end;
                    prop_assert_eq!(is_in, bounds.contains(ray.at(t)), "{} of {:?}", t, span);
                }
            }
        }
    }
}
