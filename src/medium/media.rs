//! Several media at once: their coefficients add.

use std::sync::OnceLock;

use smallvec::SmallVec;

use crate::error::Result;
use crate::math::{Aabb, Group, Ray, Rgb, Span, Spectrum, Stream, World, WorldPoint};

use crate::work::Work;

use super::piece::thickness_of;
use super::{Collision, EmissionSampler, Flights, Medium, SharedVoxels};

/// All media of a scene; where they overlap their coefficients add.
#[derive(Debug, Default)]
pub struct Media {
    media: Vec<Medium>,
    /// Of the emission of each; missing ones are the first group.
    groups: Vec<Group>,
    /// Made when photons are first aimed: it takes a look at all voxels that may glow.
    emission_samplers: OnceLock<Vec<Option<EmissionSampler>>>,
}

/// What scatters at one place: each medium's scattering coefficient there.
pub type Mixture = SmallVec<[(usize, Rgb); 1]>;

impl Media {
    /// The media.
    pub const fn new(media: Vec<Medium>) -> Self {
        Self { media, groups: Vec::new(), emission_samplers: OnceLock::new() }
    }

    /// The same, whose emission is in these groups, one a medium.
    #[must_use]
    pub fn in_groups(self, groups: Vec<Group>) -> Self {
        Self { groups, ..self }
    }

    /// The group of the emission of the medium of this index.
    pub fn group(&self, index: usize) -> Group {
        self.groups.get(index).copied().unwrap_or_default()
    }

    /// Each medium in turn.
    pub fn iter(&self) -> std::slice::Iter<'_, Medium> {
        self.media.iter()
    }

    /// The medium of an index.
    pub fn get(&self, index: usize) -> &Medium {
        &self.media[index]
    }

    /// How many there are.
    pub const fn len(&self) -> usize {
        self.media.len()
    }

    /// Whether there are none.
    pub const fn is_empty(&self) -> bool {
        self.media.is_empty()
    }

    /// What samples the emission of each medium; `None` for those that emit nothing.
    ///
    /// # Errors
    /// Where an unbounded medium emits light.
    pub fn emission_samplers(&self) -> Result<&[Option<EmissionSampler>]> {
        if let Some(samplers) = self.emission_samplers.get() {
            return Ok(samplers);
        }
        let samplers: Result<Vec<_>> = self.media.iter().map(EmissionSampler::new).collect();
        let samplers = samplers?;
        Ok(self.emission_samplers.get_or_init(|| samplers))
    }

    /// Bytes of each of the grids in memory, in the order in which media first name them: voxels
    /// that media share count once.
    pub fn grid_bytes(&self) -> Vec<usize> {
        let mut counted: Vec<SharedVoxels> = Vec::new();
        for voxels in self.media.iter().flat_map(Medium::grids) {
            if !counted.contains(&voxels) {
                counted.push(voxels);
            }
        }
        counted.into_iter().map(|voxels| voxels.bytes).collect()
    }

    /// The optical thickness of `span` of `ray` (unit direction) per channel, exact.
    pub fn optical_thickness(&self, ray: &Ray<World>, span: Span) -> Rgb {
        self.thickness_counted(ray, span, &mut Work::default())
    }

    /// The transmittance of `span` of `ray` (unit direction) per channel, exact.
    pub fn transmittance(&self, ray: &Ray<World>, span: Span) -> Rgb {
        (-self.optical_thickness(ray, span)).exp()
    }

    /// As [`transmittance`](Self::transmittance); `work` counts the march and its steps.
    pub fn transmittance_counted<S: Spectrum>(
        &self,
        ray: &Ray<World>,
        span: Span,
        work: &mut Work,
    ) -> S {
        (-self.thickness_counted::<S>(ray, span, work)).exp()
    }

    /// As [`optical_thickness`](Self::optical_thickness); `work` counts the march and its steps.
    pub fn thickness_counted<S: Spectrum>(
        &self,
        ray: &Ray<World>,
        span: Span,
        work: &mut Work,
    ) -> S {
        work.marches += u64::from(!self.media.is_empty());
        let mut thickness = S::ZERO;
        for medium in &self.media {
            let depth = medium.density.integrate(ray, span, work);
            thickness += thickness_of(S::from_rgb(medium.sigma_t), depth);
        }
        thickness
    }

    /// An unbiased estimate of the transmittance by ratio tracking (Novák et al. 2014, "Residual
    /// Ratio Tracking"): the product of 1 - sigma_t / sigma_maj over tentative collisions.
    /// `work` counts them.
    pub fn ratio_tracking<S: Spectrum>(
        &self,
        ray: &Ray<World>,
        span: Span,
        rng: &mut Stream,
        work: &mut Work,
    ) -> S {
        let mut transmittance = S::ONE;
        let mut flights = Flights::start(&self.media, ray, span, transmittance, rng);
        loop {
            let next = flights.next(rng);
            work.grid_lookups += flights.take_lookups();
            let Some(c) = next else { return transmittance };
            work.collisions += 1;
            transmittance *=
                S::ONE - S::from_rgb(self.get(c.medium).sigma_t) * (c.density / c.majorant);
            // Russian roulette keeps thick media from costing time for nothing.
            let left = transmittance.max_element();
            if left < 0.05 {
                let survive = left.max(0.01);
                if left <= 0.0 || rng.uniform() >= survive {
                    return S::ZERO;
                }
                transmittance /= survive;
            }
            flights.carry_on(transmittance, c.t, rng);
        }
    }

    /// Starts free flight along `ray` (unit direction) of light that carries `power`, in any unit.
    pub fn flights<S: Spectrum>(
        &self,
        ray: &Ray<World>,
        span: Span,
        power: S,
        rng: &mut Stream,
    ) -> Flights<'_> {
        Flights::start(&self.media, ray, span, power, rng)
    }

    /// What scatters at `p`, from the densities there.
    pub fn mixture_at(&self, p: WorldPoint) -> Mixture {
        let scattering = |(index, medium): (usize, &Medium)| {
            let sigma_s = medium.sigma_t_at(p) * medium.albedo.at(p);
            (sigma_s != Rgb::ZERO).then_some((index, sigma_s))
        };
        self.media.iter().enumerate().filter_map(scattering).collect()
    }

    /// How many grids [`sigma_t_at`](Self::sigma_t_at) looks up.
    pub fn density_grids(&self) -> u64 {
        self.media.iter().filter(|m| m.density.is_voxel()).count() as u64
    }

    /// How many grids [`mixture_at`](Self::mixture_at) looks up.
    pub fn scattering_grids(&self) -> u64 {
        let albedos = self.media.iter().filter(|m| !m.albedo.is_constant()).count() as u64;
        self.density_grids() + albedos
    }

    /// Extinction coefficient at `p`, 1/m.
    pub fn sigma_t_at(&self, p: WorldPoint) -> Rgb {
        self.media.iter().map(|m| m.sigma_t_at(p)).sum()
    }

    /// The sum of all majorants of bricks and regions at `p`, 1/m, over the channels in which
    /// there is `power`.
    pub fn majorant_at<S: Spectrum>(&self, p: WorldPoint, power: S) -> f64 {
        let channels = power.nonzero();
        self.media.iter().map(|m| m.sigma_t_max(channels) * m.density.majorant(p)).sum()
    }

    /// The scattering coefficient of a tentative collision's medium at its place, 1/m.
    pub fn sigma_s(&self, c: &Collision, p: WorldPoint) -> Rgb {
        let medium = self.get(c.medium);
        medium.sigma_t * c.density * medium.albedo.at(p)
    }

    /// The box round all media that have an end; empty where none has.
    pub fn bounds(&self) -> Aabb<World> {
        self.media.iter().filter_map(|m| m.density.bounds()).fold(Aabb::EMPTY, Aabb::union)
    }

    /// Whether a medium has no end.
    pub fn is_endless(&self) -> bool {
        self.media.iter().any(|m| m.density.bounds().is_none())
    }

    /// The finest detail of all media, in metres; nothing where there is no grid.
    pub fn detail(&self) -> Option<f64> {
        self.media.iter().filter_map(|m| m.density.detail()).min_by(f64::total_cmp)
    }
}

impl IntoIterator for Media {
    type Item = Medium;
    type IntoIter = std::vec::IntoIter<Medium>;

    fn into_iter(self) -> Self::IntoIter {
        self.media.into_iter()
    }
}
