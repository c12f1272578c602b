//! Gather radii where none is given.

use std::f64::consts::PI;

use rayon::prelude::*;

use crate::math::WorldPoint;

use super::{PhotonMap, Placed};

/// Photons that a gather along a ray should find.
const ALONG: f64 = 64.0;

/// How much wider a photon is spread that counts for more than its neighbours.
const WIDEST: f64 = 8.0;

/// Photons that a gather on a surface should find.
const AROUND: f64 = 100.0;

/// Photons that the sphere of one volume photon holds at most, where few are near any ray.
const WITHIN: f64 = 100.0;

/// Photons by whose distance their number per volume is measured.
const NEIGHBOURS: usize = 8;

/// Photons, about, by which the spacing is measured.
const PROBED: usize = 50_000;

/// Places at which the spacing of the photons is measured.
const PLACES: usize = 512;

/// The radius of each volume photon, in metres: wide where photons are sparse (Jarosz, Zwicker and
/// Jensen 2008, section 5).
#[derive(Debug)]
pub(super) struct Radii {
    /// One a photon, or the same for all.
    pub each: Vec<f32>,
    /// What suits the places that the camera sees.
    pub typical: f64,
}

impl Radii {
    /// The same radius for all of `count` photons.
    pub fn constant(radius: f64, count: usize) -> Self {
        Self { each: vec![radius as f32; count], typical: radius }
    }

    /// Radii within which a ray that sees the photons over `depth` metres finds about as many as it
    /// should, at most `most`. Photons that count for more than their neighbours, by power and by
    /// `weight` (1 where light is spread evenly), are spread wider, so that none stands out.
    ///
    /// How dense they lie is told by `independent` ones, one a path: those of one path cluster
    /// where free paths are short, and radii that fit the clusters would leave gaps between paths.
    pub fn adaptive(
        origin: WorldPoint,
        photons: &[Placed],
        independent: &[Placed],
        visible: &[WorldPoint],
        depth: f64,
        weight: impl Fn(&Placed) -> f64 + Sync,
        most: f64,
    ) -> Self {
        let step = (independent.len() / PROBED).max(1);
        let thin: Vec<Placed> = independent.iter().step_by(step).copied().collect();
        let thinning = photons.len() as f64 / thin.len().max(1) as f64;
        let map = PhotonMap::new(origin, &thin);
        let radius = |p: &Placed| {
            let mut power = 0.0;
            let near = map.nearest_photons(p.at(origin), NEIGHBOURS + 1, |photon| {
                power += photon.power().element_sum() / (NEIGHBOURS + 1) as f64;
            });
            let near = near.unwrap_or(most);
            // Volume that belongs to one photon.
            let volume = 4.0 / 3.0 * PI * near.powi(3) / (NEIGHBOURS as f64 * thinning);
            let along = (ALONG * volume / (PI * depth)).sqrt();
            let within = (WITHIN * volume * 3.0 / (4.0 * PI)).cbrt();
            (along.min(within), power)
        };
        let thin: Vec<(f64, f64)> = thin.par_iter().map(radius).collect();
        let nearest = |p: WorldPoint| map.nearest(p).map_or((most, 1.0), |index| thin[index]);
        let wide = |p: &Placed| {
            let (radius, power) = nearest(p.at(origin));
            let counts = weight(p) * p.photon.power().element_sum() / power;
            let radius = radius * counts.sqrt().clamp(1.0, WIDEST);
            radius.min(most).max(f64::from(f32::MIN_POSITIVE)) as f32
        };
        let each = photons.par_iter().map(wide).collect();
        let stride = (visible.len() / PLACES).max(1);
        let seen = visible.iter().step_by(stride).map(|p| nearest(*p).0.min(most)).collect();
        Self { each, typical: median(seen).unwrap_or(most) }
    }
}

/// The radius of each photon on a surface, in metres, at most `most`: within it about as many lie
/// as a gather should find, and the more the more a photon's power exceeds its neighbours'.
pub(super) fn on_surfaces(origin: WorldPoint, photons: &[Placed], most: f64) -> Vec<f32> {
    let step = (photons.len() / PROBED).max(1);
    let thin: Vec<Placed> = photons.iter().step_by(step).copied().collect();
    let thinning = photons.len() as f64 / thin.len().max(1) as f64;
    let map = PhotonMap::new(origin, &thin);
    let spacing = |p: &Placed| {
        let mut power = 0.0;
        let near = map.nearest_photons(p.at(origin), NEIGHBOURS + 1, |photon| {
            power += photon.power().element_sum() / (NEIGHBOURS + 1) as f64;
        });
        let around = (AROUND / (NEIGHBOURS as f64 * thinning)).sqrt();
        (near.map_or(most, |near| near * around), power)
    };
    let spacings: Vec<(f64, f64)> = thin.par_iter().map(spacing).collect();
    let wide = |p: &Placed| {
        let (radius, power) = map.nearest(p.at(origin)).map_or((most, 1.0), |i| spacings[i]);
        let counts = p.photon.power().element_sum() / power;
        let radius = radius * counts.sqrt().clamp(1.0, WIDEST);
        radius.min(most).max(f64::from(f32::MIN_POSITIVE)) as f32
    };
    photons.par_iter().map(wide).collect()
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_unstable_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}
