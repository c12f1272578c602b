//! All lights of a scene, and choosing among them.

use glam::DVec3;
use smallvec::SmallVec;

use super::Light;
use crate::math::{Rgb, WorldPoint};

/// Lights that are all sampled rather than chosen from.
const FEW: usize = 4;

/// The lights of a scene.
#[derive(Debug, Clone, Default)]
pub struct Lights {
    /// In the order of the scene file.
    pub lights: Vec<Light>,
    /// Indices of those infinitely far away that rays from the camera do not see.
    pub hidden: Vec<usize>,
}

impl Lights {
    /// One light for the place `at`, by [`Light::incident_estimate`], and its probability; nothing
    /// where no light can arrive.
    pub fn choose(&self, at: WorldPoint, u: f64) -> Option<(usize, f64)> {
        let (mut total, mut left) = (0.0, u);
        let mut chosen = None;
        for (index, light) in self.lights.iter().enumerate() {
            let weight = weight(light, at);
            if weight <= 0.0 {
                continue;
            }
            total += weight;
            // Take the newcomer with the share it has so far and stretch what is left of u.
            let share = weight / total;
            if left < share {
                chosen = Some((index, weight));
                left /= share;
            } else {
                left = (left - share) / (1.0 - share);
            }
        }
        chosen.map(|(index, weight)| (index, weight / total))
    }

    /// The lights to sample for the place `at`, each with the probability of being among them: all
    /// that can give light there where the scene has few, else one by [`Self::choose`].
    pub fn pick(&self, at: WorldPoint, u: f64) -> SmallVec<[(usize, f64); FEW]> {
        if self.lights.len() > FEW {
            return self.choose(at, u).into_iter().collect();
        }
        let gives = |index: &usize| weight(&self.lights[*index], at) > 0.0;
        (0..self.lights.len()).filter(gives).map(|index| (index, 1.0)).collect()
    }

    /// Probability with which [`Self::pick`] has the light `index` for the place `at`.
    pub fn pick_probability(&self, at: WorldPoint, index: usize) -> f64 {
        if self.lights.len() <= FEW { 1.0 } else { self.choice_probability(at, index) }
    }

    /// Probability with which [`Self::choose`] takes the light `index` for the place `at`.
    pub fn choice_probability(&self, at: WorldPoint, index: usize) -> f64 {
        let own = weight(&self.lights[index], at);
        if own <= 0.0 {
            return 0.0;
        }
        own / self.lights.iter().map(|light| weight(light, at)).sum::<f64>()
    }

    /// Whether a ray can find a light by chance.
    pub fn has_extended(&self) -> bool {
        self.lights.iter().any(|light| !light.is_delta())
    }

    /// Radiance, W/(m² sr), that a ray which escapes along the unit `direction` sees of all
    /// infinite lights.
    pub fn environment_radiance(&self, direction: DVec3) -> Rgb {
        self.lights.iter().map(|light| light.radiance_from(direction, None)).sum()
    }

    /// As [`environment_radiance`](Self::environment_radiance), for a ray from the camera: without hidden lights.
    pub fn seen_environment_radiance(&self, direction: DVec3) -> Rgb {
        let lights = self.lights.iter().enumerate();
        let seen = lights.filter(|(index, _)| !self.hidden.contains(index));
        seen.map(|(_, light)| light.radiance_from(direction, None)).sum()
    }
}

fn weight(light: &Light, at: WorldPoint) -> f64 {
    finite(light.incident_estimate(at))
}

/// `value` kept so small that sums of such stay finite.
fn finite(value: f64) -> f64 {
    value.min(1e290)
}
