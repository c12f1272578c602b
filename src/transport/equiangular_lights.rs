//! Equiangular sampling of punctual lights along a ray (Kulla and Fajardo 2012, "Importance Sampling
//! Techniques for Path Tracing in Participating Media"): their light in a medium peaks near them.

use smallvec::SmallVec;

use crate::light::{Light, Lights};
use crate::math::{Equiangular, Ray, Span, World};

/// Number of punctual lights up to which all are sampled; of more, one is chosen. It is the inline
/// capacity of lists of them too.
///
/// Unit: count. Limit: on the shadow rays of a camera ray.
pub(super) const MAX_SAMPLED: usize = 4;

/// The equiangular distributions over the distances along one ray, one for each punctual light that reaches it.
#[derive(Debug)]
pub struct EquiangularLights {
    /// Index among the scene's lights, and the distribution over distances.
    distributions: SmallVec<[(usize, Equiangular); MAX_SAMPLED]>,
    /// Whether all lights of the scene are punctual.
    are_all: bool,
}

impl EquiangularLights {
    /// Distributions for the punctual lights of `lights`, each over the part of `span` of `ray` (unit direction) that it
    /// reaches.
    pub fn new(lights: &Lights, ray: &Ray<World>, span: Span) -> Self {
        let distribution = |(index, light): (usize, &Light)| {
            let reach = light.reach(ray, span);
            Some((index, Equiangular::new(ray, reach, light.position()?)?))
        };
        let distributions: SmallVec<_> =
            lights.lights.iter().enumerate().filter_map(distribution).collect();
        let are_all = lights.lights.iter().all(|light| light.position().is_some());
        Self { distributions, are_all }
    }

    /// Whether all lights of the scene are punctual.
    pub const fn are_all(&self) -> bool {
        self.are_all
    }

    /// Whether no punctual light reaches the ray.
    pub fn is_empty(&self) -> bool {
        self.distributions.is_empty()
    }

    /// The lights to sample, each with its distribution: all where there are few, else one by `u`.
    pub fn pick(&self, u: f64) -> &[(usize, Equiangular)] {
        if self.distributions.len() <= MAX_SAMPLED {
            return &self.distributions;
        }
        let index =
            ((u * self.distributions.len() as f64) as usize).min(self.distributions.len() - 1);
        &self.distributions[index..=index]
    }

    /// Density with which [`pick`](Self::pick) and the distribution of the light with this index sample
    /// the distance `t`, 1/m; 0 where the light is not punctual or does not reach it.
    pub fn pdf(&self, light: usize, t: f64) -> f64 {
        let choice = if self.distributions.len() <= MAX_SAMPLED {
            1.0
        } else {
            1.0 / self.distributions.len() as f64
        };
        let found = self.distributions.iter().find(|(index, _)| *index == light);
        found.map_or(0.0, |(_, distances)| choice * distances.pdf(t))
    }
}
