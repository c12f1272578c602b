//! Equiangular sampling of lights along a ray (Kulla and Fajardo 2012, "Importance Sampling Techniques for
//! Path Tracing in Participating Media"): their light in a medium peaks near them.
//!
//! Of a light with an extent a place is chosen first, and distances along the ray round that.

use smallvec::SmallVec;

use crate::light::{Light, LightBounds, LightOrigin, Lights};
use crate::math::{Equiangular, Ray, Span, World};

/// Number of lights along a ray up to which all are sampled; of more, one is chosen. It is the inline
/// capacity of lists of them too.
///
/// Unit: count. Limit: on the shadow rays of a camera ray.
pub(super) const MAX_SAMPLED: usize = 4;

/// Ratio of the inverse squares of the distances to a light, over a span, below which its light is not
/// sampled equiangularly.
///
/// Unit: none. Derivation: values evenly distributed between 1 and 2 have a relative variance of 1/27; so
/// little is gained by sampling in proportion to them.
const MIN_FALLOFF: f64 = 2.0;

/// Share of a span that a light reaches, below which it is sampled there even if it falls off little.
///
/// Unit: none. Derivation: half of the places on the span are dark.
const MAX_PART: f64 = 0.5;

/// The equiangular distributions over the distances along one ray, one for each light that reaches it.
#[derive(Debug)]
pub struct EquiangularLights<'a> {
    lights: &'a Lights,
    ray: Ray<World>,
    sampled: SmallVec<[SampledLight; MAX_SAMPLED]>,
}

/// A light that is sampled equiangularly along a ray.
#[derive(Debug, Clone, Copy)]
pub struct SampledLight {
    /// Its index among the scene's lights.
    pub index: usize,
    /// The part of the ray along which it is sampled, if it reaches that.
    span: Span,
    /// The distances of a punctual light, all of whose light comes from one place.
    punctual: Option<Equiangular>,
}

impl<'a> EquiangularLights<'a> {
    /// Of the punctual lights of `lights`, over the part of `span` of `ray` (unit direction) that each reaches.
    pub fn punctual(lights: &'a Lights, ray: &Ray<World>, span: Span) -> Self {
        Self::of(lights, ray, |_| span, |light, _, _| light.position().is_some())
    }

    /// Of the lights whose light along the ray varies with the distance to them, and of those that reach only
    /// a small part of it: each over the span that `span` gives for its index, which may be empty.
    pub fn near(lights: &'a Lights, ray: &Ray<World>, span: impl Fn(usize) -> Span) -> Self {
        Self::of(lights, ray, span, |light, span, reach| {
            light.bounds().is_some_and(|bounds| {
                falloff(&bounds, ray, reach) >= MIN_FALLOFF
                    || reach.length() < MAX_PART * span.length()
            })
        })
    }

    /// Of the lights that are sampled by their span and the part of it that they reach.
    fn of(
        lights: &'a Lights,
        ray: &Ray<World>,
        span: impl Fn(usize) -> Span,
        is_sampled: impl Fn(&Light, Span, Span) -> bool,
    ) -> Self {
        let sampled = |index: usize| {
            let (light, span) = (&lights.lights[index], span(index));
            if span.is_empty() {
                return None;
            }
            let origin = light.position().map(LightOrigin::punctual);
            let reach = origin.map_or(span, |origin| light.reach(&origin, ray, span));
            if !is_sampled(light, span, reach) {
                return None;
            }
            let punctual = match origin {
                Some(origin) => Some(Equiangular::new(ray, reach, origin.position)?),
                None => None,
            };
            Some(SampledLight { index, span, punctual })
        };
        let sampled = (0..lights.lights.len()).filter_map(sampled).collect();
        Self { lights, ray: *ray, sampled }
    }

    /// Whether the light of this index is among them.
    pub fn contains(&self, light: usize) -> bool {
        self.sampled.iter().any(|sampled| sampled.index == light)
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.sampled.is_empty()
    }

    /// The lights to sample: all where there are few, else one by `u`.
    pub fn pick(&self, u: f64) -> &[SampledLight] {
        if self.sampled.len() <= MAX_SAMPLED {
            return &self.sampled;
        }
        let index = ((u * self.sampled.len() as f64) as usize).min(self.sampled.len() - 1);
        &self.sampled[index..=index]
    }

    /// The distances at which light from `origin`, on one of the lights, is sampled; nothing where it does not
    /// reach the ray.
    pub fn distances(&self, light: &SampledLight, origin: &LightOrigin) -> Option<Equiangular> {
        if light.punctual.is_some() {
            return light.punctual;
        }
        let reach = self.lights.lights[light.index].reach(origin, &self.ray, light.span);
        Equiangular::new(&self.ray, reach, origin.position)
    }

    /// Density with which [`pick`](Self::pick) and the [`distances`](Self::distances) of the light with this
    /// index sample the distance `t` for light from `origin`, 1/m; 0 where the light is not sampled so.
    pub fn pdf(&self, light: usize, origin: &LightOrigin, t: f64) -> f64 {
        let Some(light) = self.sampled.iter().find(|sampled| sampled.index == light) else {
            return 0.0;
        };
        let choice =
            if self.sampled.len() <= MAX_SAMPLED { 1.0 } else { 1.0 / self.sampled.len() as f64 };
        self.distances(light, origin).map_or(0.0, |distances| choice * distances.pdf(t))
    }
}

/// Largest over smallest inverse square of the distance to any place of a light, over a span.
fn falloff(bounds: &LightBounds, ray: &Ray<World>, span: Span) -> f64 {
    let to = bounds.center - ray.origin;
    let foot = to.dot(ray.direction);
    let aside = (to - ray.direction * foot).length();
    let distance = |t: f64| aside.hypot(t - foot);
    let nearest = distance(foot.clamp(span.start, span.end.max(span.start)));
    let farthest = distance(span.start).max(distance(span.end));
    ((farthest + bounds.radius) / (nearest - bounds.radius).max(0.0)).powi(2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::{PointLight, QuadLight};
    use crate::math::{Rgb, WorldPoint};
    use glam::DVec3;

    /// A quad that shines toward +y, a lamp near the ray, one far from it, and the ray.
    fn lights() -> (Lights, Ray<World>) {
        let quad = QuadLight::new(WorldPoint::new(0.0, -1.0, 4.0), DVec3::Z, DVec3::X, Rgb::ONE);
        let lamp = |x: f64| PointLight::new(WorldPoint::new(x, 0.0, 5.0), Rgb::ONE).unwrap();
        let lights =
            vec![Light::Quad(quad.unwrap()), Light::Point(lamp(0.5)), Light::Point(lamp(100.0))];
        let direction = DVec3::new(0.0, -0.3, 1.0).normalize();
        (
            Lights { lights, ..Lights::default() },
            Ray::new(WorldPoint::new(0.0, 0.5, 0.0), direction),
        )
    }

    #[test]
    fn lights_that_fall_off_along_the_ray_are_sampled_where_they_reach() {
        let (lights, ray) = lights();
        let span = Span::new(0.0, 10.0);
        let near = EquiangularLights::near(&lights, &ray, |_| span);
        assert!(near.contains(0) && near.contains(1) && !near.contains(2));
        let punctual = EquiangularLights::punctual(&lights, &ray, span);
        assert!(!punctual.contains(0) && punctual.contains(1) && punctual.contains(2));
        // The ray passes through the plane of the quad where y is -1.
        let behind = 1.5 / -ray.direction.y;
        for u in [[0.1, 0.7], [0.5, 0.5], [0.99, 0.01]] {
            let origin = lights.lights[0].origin(u).unwrap();
            assert!(near.pdf(0, &origin, behind - 0.1) > 0.0);
            assert_eq!(near.pdf(0, &origin, behind + 0.1), 0.0);
            // The density is one over all distances.
            let (steps, dt) = (20_000, behind / 20_000.0);
            let pdf = |step: i32| near.pdf(0, &origin, (f64::from(step) + 0.5) * dt);
            let sum = (0..steps).map(pdf).sum::<f64>() * dt;
            assert!((sum - 1.0).abs() < 1e-3, "{sum}");
        }
        let nowhere = EquiangularLights::near(&lights, &ray, |_| Span::new(0.0, 0.0));
        assert!(nowhere.is_empty() && nowhere.pick(0.5).is_empty());
    }

    /// The place that a sample comes from is that of the same numbers.
    #[test]
    fn samples_come_from_their_origin() {
        let (lights, ray) = lights();
        let p = ray.at(1.0);
        for light in &lights.lights {
            let u = [0.3, 0.8];
            let (sample, origin) = (light.sample(p, u).unwrap(), light.origin(u).unwrap());
            let found = sample.origin(p);
            assert!((found.position - origin.position).length() < 1e-9);
            assert_eq!(found.normal, origin.normal);
        }
    }
}
