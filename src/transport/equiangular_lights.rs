//! Equiangular sampling of lights along a ray (Kulla and Fajardo 2012, "Importance Sampling Techniques for
//! Path Tracing in Participating Media"): their light in a medium peaks near them.
//!
//! Distances are sampled round the centres of a quad's parts. Of a mesh a place is chosen first, and distances round
//! that. They may be [weighed](EquiangularLights::weighed) by the opacity along the ray.

use smallvec::SmallVec;

use crate::light::{Light, LightBounds, LightOrigin, LightPart, LightSample, Lights};
use crate::math::{Equiangular, Ray, Span, World};

use super::opacity_steps::OpacitySteps;

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

/// Share of the distances along a ray that are sampled in proportion to its opacity too. The others are dense near the
/// light, which a thick medium hides; these are dense at the front of the medium, where a far light is weak.
///
/// Unit: none. Derivation: by half and half each needs at most twice the samples that the better one alone would.
const WEIGHED_SHARE: f64 = 0.5;

/// The equiangular distributions over the distances along one ray, one for each light that reaches it.
#[derive(Debug)]
pub struct EquiangularLights<'a> {
    lights: &'a Lights,
    ray: Ray<World>,
    sampled: SmallVec<[SampledLight; MAX_SAMPLED]>,
}

/// A light that is sampled equiangularly along a ray.
#[derive(Debug)]
pub struct SampledLight {
    /// Its index among the scene's lights.
    pub index: usize,
    /// The part of the ray along which it is sampled, if it reaches that.
    span: Span,
    /// The distances by the parts of the light; none of a light that has no parts, whose places have their own.
    distances: Option<DistanceMixture>,
}

/// Equiangular distances by the parts of a light, each in proportion to its light were nothing in between; where they are
/// weighed, by the steps of the ray as well.
#[derive(Debug, Clone)]
struct DistanceMixture {
    /// With the probability of each.
    parts: SmallVec<[(f64, Equiangular); 1]>,
}

impl DistanceMixture {
    /// Of these parts of a light, over the `reach` of its light along `ray`; nothing where none reaches it.
    fn new(parts: &[LightPart], ray: &Ray<World>, reach: Span) -> Option<Self> {
        let of_part =
            |part: &LightPart| Equiangular::around(ray, reach, part.origin.position, part.spread);
        let parts: SmallVec<[Equiangular; 1]> = parts.iter().filter_map(of_part).collect();
        let total: f64 = parts.iter().map(Equiangular::total).sum();
        let with_share = |distances: Equiangular| (distances.total() / total, distances);
        (total > 0.0).then(|| Self { parts: parts.into_iter().map(with_share).collect() })
    }

    /// The same, but [a share](WEIGHED_SHARE) of the distances is in proportion to the means of `steps` too.
    fn weighed(self, steps: &OpacitySteps) -> Self {
        let mut cut = SmallVec::<[_; 8]>::new();
        for (share, distances) in &self.parts {
            for (step, mean) in steps.iter() {
                let Some(part) = distances.within(step) else { continue };
                cut.push((share * part.total() / distances.total(), mean, part));
            }
        }
        let all: f64 = cut.iter().map(|(share, ..)| share).sum();
        let seen: f64 = cut.iter().map(|(share, mean, _)| share * mean).sum();
        if !(all > 0.0 && seen.is_normal()) {
            return self;
        }
        let with_share = |(share, mean, part): &(f64, f64, Equiangular)| {
            let factor = (1.0 - WEIGHED_SHARE) / all + WEIGHED_SHARE * mean / seen;
            (share * factor, *part)
        };
        Self { parts: cut.iter().map(with_share).collect() }
    }

    /// A distance along the ray, and its part by the same number.
    fn sample(&self, mut u: f64) -> f64 {
        let (last, others) = self.parts.split_last().expect("there is one");
        for (share, distances) in others {
            if u < *share {
                return distances.sample(u / share);
            }
            u -= share;
        }
        let (share, distances) = last;
        distances.sample((u / share).min(1.0))
    }

    /// Density of [`sample`](Self::sample) at a distance, 1/m.
    fn pdf(&self, t: f64) -> f64 {
        self.parts.iter().map(|(share, distances)| share * distances.pdf(t)).sum()
    }
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
            let parts = light.parts();
            let reach = parts.first().map_or(span, |part| light.reach(&part.origin, ray, span));
            if !is_sampled(light, span, reach) {
                return None;
            }
            let distances = match parts[..] {
                [] => None,
                _ => Some(DistanceMixture::new(&parts, ray, reach)?),
            };
            Some(SampledLight { index, span, distances })
        };
        let sampled = (0..lights.lights.len()).filter_map(sampled).collect();
        Self { lights, ray: *ray, sampled }
    }

    /// The same, but half of the distances are in proportion to the means of `steps` too, for estimates that have no other
    /// samples at the front of thick media. Lights without parts stay as they are.
    #[must_use]
    pub fn weighed(mut self, steps: &OpacitySteps) -> Self {
        for light in &mut self.sampled {
            light.distances = light.distances.take().map(|distances| distances.weighed(steps));
        }
        self
    }

    /// Whether distances are sampled round parts of all of them.
    pub fn have_parts(&self) -> bool {
        self.sampled.iter().all(|light| light.distances.is_some())
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

    /// A distance along the ray by the first of these numbers, and light that arrives there by the others; nothing where
    /// none does.
    pub fn sample(
        &self,
        light: &SampledLight,
        distance: f64,
        position: [f64; 2],
    ) -> Option<(f64, LightSample)> {
        let shines = &self.lights.lights[light.index];
        let t = match &light.distances {
            Some(mixture) => mixture.sample(distance),
            None => self.around(light, &shines.origin(position)?)?.sample(distance),
        };
        let sample = shines.sample(self.ray.at(t), position).filter(LightSample::shines)?;
        Some((t, sample))
    }

    /// The distances around `origin`, a place on this light, that its light reaches.
    fn around(&self, light: &SampledLight, origin: &LightOrigin) -> Option<Equiangular> {
        let reach = self.lights.lights[light.index].reach(origin, &self.ray, light.span);
        Equiangular::new(&self.ray, reach, origin.position)
    }

    /// Density with which [`pick`](Self::pick) and [`sample`](Self::sample) of the light with this index give the
    /// distance `t` for light from `origin`, 1/m; 0 where the light is not sampled so.
    pub fn pdf(&self, light: usize, origin: &LightOrigin, t: f64) -> f64 {
        let Some(light) = self.sampled.iter().find(|sampled| sampled.index == light) else {
            return 0.0;
        };
        let choice =
            if self.sampled.len() <= MAX_SAMPLED { 1.0 } else { 1.0 / self.sampled.len() as f64 };
        choice
            * match &light.distances {
                Some(mixture) => mixture.pdf(t),
                None => self.around(light, origin).map_or(0.0, |distances| distances.pdf(t)),
            }
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
    use crate::medium::Profile;
    use crate::scene::Scene;
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

    /// A ray's first 3 m through fog of this extinction.
    fn through_fog(sigma_t: f64, ray: &Ray<World>) -> Profile<f64> {
        let scene = Scene::of_text(&format!(
            "
            [camera]
            position = [0.0, 0.0, 9.0]
            target = [0.0, 0.0, 0.0]
            [[medium]]
            region = {{ box = {{ min = [-9.0, -9.0, -9.0], max = [9.0, 9.0, 9.0] }} }}
            sigma_t = {sigma_t:?}
            "
        ));
        let mut profile = Profile::default();
        profile.trace(&scene.media, ray, Span::new(0.0, 3.0), 0.0, 0.5);
        profile
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
        let numbers = [[0.1, 0.7, 0.2], [0.5, 0.5, 0.5], [0.99, 0.01, 0.9]];
        for light in &near.sampled {
            for [distance, x, y] in numbers {
                let (t, sample) = near.sample(light, distance, [x, y]).unwrap();
                let origin = sample.origin(ray.at(t));
                assert!(near.pdf(light.index, &origin, t) > 0.0);
                let end = if light.index == 0 { behind } else { span.end };
                assert!(t < end);
                assert_eq!(near.pdf(light.index, &origin, end + 0.1), 0.0);
                // The density is one over all distances.
                let (steps, dt) = (20_000, end / 20_000.0);
                let pdf = |step: i32| near.pdf(light.index, &origin, (f64::from(step) + 0.5) * dt);
                let sum = (0..steps).map(pdf).sum::<f64>() * dt;
                assert!((sum - 1.0).abs() < 1e-3, "{sum}");
            }
        }
        let nowhere = EquiangularLights::near(&lights, &ray, |_| Span::new(0.0, 0.0));
        assert!(nowhere.is_empty() && nowhere.pick(0.5).is_empty());
    }

    /// Distances follow their density: between those of two numbers it integrates to the difference of these. A tube has
    /// several parts, and steps of a thick medium make more.
    #[test]
    fn distances_follow_their_density() {
        let tube = QuadLight::new(
            WorldPoint::new(0.0, -1.0, 4.0),
            DVec3::Z * 4.0,
            DVec3::X * 0.2,
            Rgb::ONE,
        );
        let lights = Lights { lights: vec![Light::Quad(tube.unwrap())], ..Lights::default() };
        let direction = DVec3::new(0.4, -0.1, 0.5).normalize();
        let ray = Ray::new(WorldPoint::new(-1.0, -0.6, 2.0), direction);
        let near = EquiangularLights::near(&lights, &ray, |_| Span::new(0.0, 3.0));
        let profile = through_fog(2.0, &ray);
        let weighed = EquiangularLights::near(&lights, &ray, |_| Span::new(0.0, 3.0))
            .weighed(&OpacitySteps::along(&profile));
        let mixture = |near: &EquiangularLights<'_>| near.sampled[0].distances.clone().unwrap();
        let [even, weighed] = [mixture(&near), mixture(&weighed)];
        assert!(even.parts.len() > 1 && weighed.parts.len() > 4 * even.parts.len());
        let within = |mixture: &DistanceMixture, from: f64, to: f64| {
            // Parts follow each other in the numbers, each over all distances.
            let samples = (0..100_000).map(|i| mixture.sample((f64::from(i) + 0.5) / 100_000.0));
            samples.filter(|t| (from..to).contains(t)).count() as f64 / 100_000.0
        };
        for [low, high] in [[0.0, 1.0], [0.1, 0.15], [0.3, 0.8]] {
            let [from, to] = [3.0 * low, 3.0 * high];
            for mixture in [&even, &weighed] {
                let (steps, dt) = (20_000, (to - from) / 20_000.0);
                let pdf = |step: i32| mixture.pdf(from + (f64::from(step) + 0.5) * dt);
                let expected = (0..steps).map(pdf).sum::<f64>() * dt;
                let found = within(mixture, from, to);
                assert!((found - expected).abs() < 2e-4, "{found} not {expected}");
            }
        }
        // More of them are at the front of the fog, and no fewer than half as many anywhere.
        assert!(within(&weighed, 0.0, 0.5) > 1.5 * within(&even, 0.0, 0.5));
        for t in [0.01, 0.7, 1.6, 2.4] {
            assert!(weighed.pdf(t) > 0.499 * even.pdf(t), "at {t}");
        }
    }
}
