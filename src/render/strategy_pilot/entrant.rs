//! How far a contender got in the pixels of a strategy pilot.

use rayon::prelude::*;

use crate::cache::{Caches, FinalGatherCache};
use crate::math::Spectrum;
use crate::photon::{PhotonDirection, PhotonMaps};
use crate::render::integrator::Integrator;
use crate::strategy::{self, Observed, PixelSamples, RayLuminance};
use crate::work::Work;

use super::contender::Contender;
use super::pixels::PilotPixels;

/// Width of the cells by which the noise of rays is measured over those of the picture: the pilot's photons have
/// about as much noise in them as the picture's have in its own.
const SMOOTHING: f64 = 4.0;

/// Pixels that are traced before costs are looked at.
const CHUNK: usize = 4;

/// A contender with its photons, and what was traced so far.
pub struct Entrant<S: Spectrum> {
    pub contender: Contender,
    /// Whether it is traced on.
    pub is_racing: bool,
    /// By each half of the photons.
    caches: [Caches<S>; 2],
    /// Of the picture, in nanoseconds of a typical core.
    photon_cost: f64,
    samples: Vec<PixelSamples>,
    /// Work of the rays.
    work: Work,
    /// Work of rays that share gathers, and the pixels that they are of.
    shared_work: Work,
    shared_pixels: usize,
}

impl<S: Spectrum> Entrant<S> {
    /// Before it is traced.
    pub fn new(contender: Contender, caches: [Caches<S>; 2], photon_cost: f64) -> Self {
        Self {
            contender,
            is_racing: true,
            caches,
            photon_cost,
            samples: Vec::new(),
            work: Work::default(),
            shared_work: Work::default(),
            shared_pixels: 0,
        }
    }

    /// Traces it in pixels up to number `end`. It is given up where that costs more than `most` nanoseconds of
    /// a typical core.
    pub fn trace<H: PhotonDirection>(
        &mut self,
        pixels: &PilotPixels<'_>,
        maps: [&PhotonMaps<S, H>; 2],
        end: usize,
        most: f64,
    ) {
        let settings = pixels.settings;
        let reads_photons = self.contender.reads_photons(settings);
        let integrators = [0, 1].map(|half| {
            let (maps, caches) = (maps[half], &self.caches[half]);
            let needs = settings.photons.needs;
            Integrator::new(pixels.scene, maps, caches, &self.contender.choice, needs)
        });
        let is_sharp = self.contender.has_sharp_cells();
        let trace = |[pixel, set]: [usize; 2]| {
            let mut work = Work::default();
            let mut by_half = |half: usize, wider: f64| {
                let radius = wider * maps[half].volume_radius;
                let (rays, done) = pixels.luminances(&integrators[half], [pixel, set], radius);
                work += done;
                rays
            };
            // Without photons both halves are the same.
            let mut by_both = |wider: f64| {
                let a = by_half(0, wider);
                let b = if reads_photons { by_half(1, wider) } else { a.clone() };
                [a, b]
            };
            let smooth = by_both(if is_sharp { SMOOTHING } else { 1.0 });
            let sharp = is_sharp.then(|| by_both(1.0));
            (SetRays { smooth, sharp }, work)
        };
        while self.samples.len() < end && self.is_racing {
            let next = self.samples.len()..end.min(self.samples.len() + CHUNK);
            let runs: Vec<_> = next.flat_map(|pixel| [[pixel, 0], [pixel, 1]]).collect();
            let runs: Vec<(SetRays, Work)> = runs.into_par_iter().map(trace).collect();
            for sets in runs.chunks_exact(2) {
                let rays = |of: fn(&SetRays) -> &[Vec<RayLuminance>; 2]| {
                    [0, 1].map(|half| [0, 1].map(|set| &of(&sets[set].0)[half][..]))
                };
                let (smooth, sharp) = (rays(|set| &set.smooth), rays(SetRays::sharp));
                self.samples.push(PixelSamples::new(smooth, sharp, &pixels.picture));
            }
            runs.into_iter().for_each(|(_, done)| self.work += done);
            self.is_racing = self.spent() <= most;
        }
    }

    /// Traces the rays of the pixels up to number `end` with gathers shared, where that is possible: their
    /// work alone is looked at.
    pub fn trace_shared<H: PhotonDirection>(
        &mut self,
        pixels: &PilotPixels<'_>,
        maps: &PhotonMaps<S, H>,
        end: usize,
    ) {
        let Some((choice, _)) = &self.contender.shared else { return };
        let needs = pixels.settings.photons.needs;
        let integrator = Integrator::new(pixels.scene, maps, &self.caches[0], choice, needs);
        let radius = maps.volume_radius;
        let trace = |pixel| pixels.luminances(&integrator, [pixel, 0], radius).1;
        let works: Vec<Work> = (self.shared_pixels..end).into_par_iter().map(trace).collect();
        works.into_iter().for_each(|done| self.shared_work += done);
        self.shared_pixels = end;
    }

    /// Cost of the picture with gathers shared, in nanoseconds of a typical core, where it was measured.
    pub fn shared_cost(&self, pixels: &PilotPixels<'_>) -> Option<f64> {
        let ray = pixels.ray_cost(&self.shared_work, self.contender.gathered);
        let picture = pixels.picture;
        let cost = self.photon_cost + picture.pixels * picture.rays * ray;
        (self.shared_pixels > 0).then_some(cost)
    }

    /// Bytes of its own caches: all but those of direct light.
    pub fn memory_bytes(&self) -> u64 {
        let fluence = self.caches.iter().map(|caches| caches.memory_bytes()[0]);
        let gathers = self.caches.iter().flat_map(|caches| caches.final_gathers.iter().flatten());
        let lazy = gathers.map(FinalGatherCache::cells);
        fluence.chain(lazy.map(|cells| cells.memory_bytes() as u64)).sum()
    }

    /// Whether it was traced in any pixel.
    pub fn is_seen(&self) -> bool {
        !self.samples.is_empty()
    }

    /// Cost of all rays that were traced, in nanoseconds of a typical core.
    pub fn spent(&self) -> f64 {
        strategy::cost(&self.work, 1.0) + strategy::cost(&self.shared_work, 1.0)
    }

    /// What was seen so far.
    pub fn observed(&self, pixels: &PilotPixels<'_>) -> Observed<'_> {
        Observed {
            strategies: self.contender.strategies(),
            samples: &self.samples,
            scale: self.contender.scale,
            ray_cost: pixels.ray_cost(&self.work, self.contender.gathered),
            photon_cost: self.photon_cost,
        }
    }
}

/// The rays of a pixel by both halves of the photons, with one set of random numbers.
struct SetRays {
    smooth: [Vec<RayLuminance>; 2],
    /// By cells as narrow as the picture's, where the smooth ones are not.
    sharp: Option<[Vec<RayLuminance>; 2]>,
}

impl SetRays {
    fn sharp(&self) -> &[Vec<RayLuminance>; 2] {
        self.sharp.as_ref().unwrap_or(&self.smooth)
    }
}
