//! Lamps beside a ray: lights that shine from one place, whose light in a medium peaks there.

use smallvec::SmallVec;

use crate::light::{Light, Lights};
use crate::math::{Equiangular, Ray, Span, World};

/// Lamps that are all sampled rather than chosen from.
const FEW: usize = 4;

/// Ways to find the light of lamps by places along a ray that are dense near them.
#[derive(Debug)]
pub struct EquiangularLights {
    /// Each lamp's index among the lights and its distribution over distances.
    lamps: SmallVec<[(usize, Equiangular); FEW]>,
    /// Whether there is no light but these.
    are_all: bool,
}

impl EquiangularLights {
    /// The lamps of `lights` that `span` of `ray` (unit direction) passes.
    pub fn beside(lights: &Lights, ray: &Ray<World>, span: Span) -> Self {
        let beside = |(index, light): (usize, &Light)| {
            Some((index, Equiangular::new(ray, span, light.place()?)?))
        };
        let lamps: SmallVec<_> = lights.lights.iter().enumerate().filter_map(beside).collect();
        let are_all = lamps.len() == lights.lights.len();
        Self { lamps, are_all }
    }

    /// Whether there is no light but these.
    pub const fn are_all(&self) -> bool {
        self.are_all
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.lamps.is_empty()
    }

    /// The lamps to sample, each with its distribution: all where there are few, else one.
    pub fn pick(&self, u: f64) -> &[(usize, Equiangular)] {
        if self.lamps.len() <= FEW {
            return &self.lamps;
        }
        let index = ((u * self.lamps.len() as f64) as usize).min(self.lamps.len() - 1);
        &self.lamps[index..=index]
    }

    /// Density with which [`pick`](Self::pick) and the lamp's distribution find the light of this
    /// index at the distance `t`, 1/m; 0 where it is not a lamp.
    pub fn pdf(&self, light: usize, t: f64) -> f64 {
        let chance = if self.lamps.len() <= FEW { 1.0 } else { 1.0 / self.lamps.len() as f64 };
        let found = self.lamps.iter().find(|(index, _)| *index == light);
        found.map_or(0.0, |(_, distances)| chance * distances.pdf(t))
    }
}
