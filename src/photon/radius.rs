//! Kernel radii of photons, where the scene gives none.

use std::f64::consts::PI;

use rayon::prelude::*;

use crate::math::{Spectrum, WorldPoint, quantile};

use super::{Octahedral, PhotonAt, PhotonDirection, PhotonMap};

/// Photons to be found along a ray.
///
/// Unit: count. Bench: `cargo bench --bench results -- --only equal-time`.
const PHOTONS_ALONG_RAY: f64 = 64.0;

/// Largest factor by which a photon brighter than its neighbours is widened.
///
/// Unit: none. Limit: on gathers: the rays that find a photon grow by a factor of 64.
const MAX_WIDENING: f64 = 8.0;

/// Photons within the radius of one: the most in the sphere of one in a medium, where few are near any ray, and on
/// surfaces where [`FEW_ON_SURFACES`] are found.
///
/// Unit: count. Bench: `cargo bench --bench results -- --only equal-time`.
const PHOTONS_IN_RADIUS: f64 = 100.0;

/// Photons on surfaces up to which [`PHOTONS_IN_RADIUS`] lie within the radius of one.
///
/// Unit: count. Definition: the number for which the photons within a radius are stated.
const FEW_ON_SURFACES: f64 = 50_000.0;

/// Exponent by which the photons within a radius grow with all photons on surfaces, so that both noise and blur fade.
///
/// Unit: none. Source: Silverman 1986, "Density Estimation for Statistics and Data Analysis", section 4.3: in two
/// dimensions the best width of a kernel is as the number to the power of -1/6.
const GROWTH: f64 = 2.0 / 3.0;

/// Nearest photons by whose distance the density of photons is measured.
///
/// Unit: count. Derivation: a density by 8 neighbours has a relative error of 1 / sqrt(8), and a radius,
/// as its square root, half of that.
const NEIGHBOURS: usize = 8;

/// Photons, about, at which that density is measured.
///
/// Unit: count. Limit: on the searches for neighbours.
const PROBES: usize = 50_000;

/// Places that the camera sees, about, of which the typical radius is the median.
///
/// Unit: count. Derivation: the median of 512 values is known to 1.25 / sqrt(512) of their standard
/// deviation, a twentieth.
const VISIBLE_PLACES: usize = 512;

/// Photons by which the density of others is measured.
pub(super) struct Probes<'a, S: Spectrum, H> {
    pub photons: &'a [PhotonAt<S, H>],
    /// Number of photons whose distribution they sample.
    pub count: f64,
    /// Number of photons that those stand for.
    pub all: f64,
}

/// The radius of each volume photon, in metres: wide where photons are sparse (the adaptive kernels of
/// Jarosz, Zwicker and Jensen 2008, "The Beam Radiance Estimate for Volumetric Photon Mapping").
#[derive(Debug)]
pub(super) struct Radii {
    /// One a photon, or the same for all.
    pub each: Vec<f32>,
    /// What suits the places that the camera sees.
    pub typical: f64,
    /// The same for all photons that these stand for.
    pub typical_of_all: f64,
}

impl Radii {
    /// The same radius for all of `count` photons.
    pub fn constant(radius: f64, count: usize) -> Self {
        Self { each: vec![radius as f32; count], typical: radius, typical_of_all: radius }
    }

    /// Radii within which a ray that sees the photons over `depth` metres finds
    /// [`PHOTONS_ALONG_RAY`], at most `most`. Photons that contribute more than their neighbours, by
    /// power and by `weight` (1 for an isotropic phase function), are widened, so that none stands
    /// out.
    ///
    /// The density is that of `probes`, one a path: photons of one path cluster where
    /// free paths are short, and radii that fit the clusters would leave gaps between paths.
    pub fn adaptive<S: Spectrum, H: PhotonDirection>(
        origin: WorldPoint,
        photons: &[PhotonAt<S, H>],
        probes: &Probes<'_, S, H>,
        visible: &[WorldPoint],
        depth: f64,
        weight: impl Fn(&PhotonAt<S, H>) -> f64 + Sync,
        most: f64,
    ) -> Self {
        let radius = |near: f64, crowd: f64| {
            // Volume that belongs to one photon.
            let volume = 4.0 / 3.0 * PI * near.powi(3) / crowd;
            let along = (PHOTONS_ALONG_RAY * volume / (PI * depth)).sqrt();
            let within = (PHOTONS_IN_RADIUS * volume * 3.0 / (4.0 * PI)).cbrt();
            along.min(within)
        };
        let spacing = |count| Spacing::new(origin, probes.photons, count, most, radius);
        let stride = (visible.len() / VISIBLE_PLACES).max(1);
        let typical = |spacing: &Spacing<S, H>| {
            let seen = visible.iter().step_by(stride).map(|p| spacing.at(*p).0.min(most));
            quantile(seen.collect(), 0.5).unwrap_or(most)
        };
        let own = spacing(probes.count);
        let each = photons.par_iter().map(|p| own.widened(p, weight(p))).collect();
        let typical_of_own = typical(&own);
        let typical_of_all = match probes.all == probes.count {
            true => typical_of_own,
            false => typical(&spacing(probes.all)),
        };
        Self { each, typical: typical_of_own, typical_of_all }
    }
}

/// The radius of each photon on a surface, in metres, at most `most`: about [`PHOTONS_IN_RADIUS`]
/// lie within it, more where there are many or where a photon's power exceeds its neighbours'.
pub(super) fn on_surfaces<S: Spectrum>(
    origin: WorldPoint,
    photons: &[PhotonAt<S>],
    probes: &Probes<'_, S, Octahedral>,
    most: f64,
) -> Vec<f32> {
    let within = PHOTONS_IN_RADIUS * (probes.all / FEW_ON_SURFACES).max(1.0).powf(GROWTH);
    let radius = |near: f64, crowd: f64| near * (within / crowd).sqrt();
    let spacing = Spacing::new(origin, probes.photons, probes.all, most, radius);
    photons.par_iter().map(|p| spacing.widened(p, 1.0)).collect()
}

/// Radii at some of the photons, from which those of others are taken.
struct Spacing<S: Spectrum, H> {
    map: PhotonMap<S, H>,
    origin: WorldPoint,
    /// At each probe the radius in metres and the mean power of its neighbours.
    probed: Vec<(f64, f64)>,
    /// The largest radius, in metres.
    most: f64,
}

impl<S: Spectrum, H: PhotonDirection> Spacing<S, H> {
    /// Measured at some of `photons`, which sample the distribution of `count`; `radius` is a radius by the
    /// distance within which a number of photons lie.
    fn new(
        origin: WorldPoint,
        photons: &[PhotonAt<S, H>],
        count: f64,
        most: f64,
        radius: impl Fn(f64, f64) -> f64 + Sync,
    ) -> Self {
        let step = (photons.len() / PROBES).max(1);
        let thin: Vec<PhotonAt<S, H>> = photons.iter().step_by(step).copied().collect();
        let crowd = NEIGHBOURS as f64 * (count / thin.len().max(1) as f64);
        let map = PhotonMap::new(origin, &thin);
        let probe = |p: &PhotonAt<S, H>| {
            let mut power = 0.0;
            let near = map.nearest_photons(p.at(origin), NEIGHBOURS + 1, |photon| {
                power += photon.power().element_sum() / (NEIGHBOURS + 1) as f64;
            });
            (radius(near.unwrap_or(most), crowd), power)
        };
        let probed = thin.par_iter().map(probe).collect();
        Self { map, origin, probed, most }
    }

    /// Radius and mean power at `p`: those of the nearest probe.
    fn at(&self, p: WorldPoint) -> (f64, f64) {
        self.map.nearest(p).map_or((self.most, 1.0), |index| self.probed[index])
    }

    /// The radius of a photon whose power contributes with this `weight`.
    fn widened(&self, p: &PhotonAt<S, H>, weight: f64) -> f32 {
        let (radius, power) = self.at(p.at(self.origin));
        let contribution = weight * p.photon.power().element_sum() / power;
        let radius = radius * contribution.sqrt().clamp(1.0, MAX_WIDENING);
        radius.min(self.most).max(f64::from(f32::MIN_POSITIVE)) as f32
    }
}
