//! Pass 1: many photon paths in parallel, and the maps made of them.

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::light::Reach;
use crate::math::{Aabb, World, WorldPoint, warp};
use crate::scene::Scene;
use crate::scene::plan::Needs;
use crate::work::Work;

use super::emitters::Emitters;
use super::estimate::THINNING;
use super::path::{Deposits, Paths, Units};
use super::radius::{Radii, around};
use super::visible::Visible;
use super::zones::Zones;
use super::{BeamMap, Photon, PhotonMap, PhotonMaps, Placed};

/// Radius, in metres, that stands for everything.
const ENDLESS: f64 = 1e15;

/// Radii of the scene within which light on an infinite plane counts.
const GROUND: f64 = 4.0;

/// Volume photons, about, kept of one path.
const KEPT: f64 = 4.0;

/// Volume photons, about, that are kept at least, if there are so many: those of thick media lie
/// mostly where nobody sees them, so that of few paths many must be kept.
const SPARED: f64 = 200_000.0;

/// Volume photons after which enough is known of how many a path leaves.
const PROBED: usize = 1_000_000;

/// Paths that are traced as one piece of work.
const CHUNK: u64 = 2048;

/// How photons are shot.
#[derive(Debug, Clone, Copy)]
pub struct Shooting {
    /// Paths sent out; about as many photons are kept in media.
    pub photons: u64,
    /// Seed of the random streams.
    pub seed: u64,
    /// Highest order of volume scattering that the picture holds; nothing means all.
    pub max_scatter: Option<u32>,
    /// Gather radius in metres, where it is given.
    pub radius: Option<f64>,
    /// Levels of thinned volume photons beside the full one, for gathers up to 2^levels times as
    /// wide.
    pub levels: u32,
    /// Which photons are needed.
    pub needs: Needs,
}

/// Shoots photons into `scene` and builds the maps. `advance` is told how many paths are done.
///
/// # Errors
/// Where an emitter cannot be sampled: a medium that glows without end.
pub fn shoot(
    scene: &Scene,
    shooting: &Shooting,
    advance: &(dyn Fn(u64) + Sync),
) -> Result<(PhotonMaps, Work)> {
    if !shooting.needs.photons() {
        return Ok((PhotonMaps::empty(shooting.radius.unwrap_or(0.0)), Work::default()));
    }
    let media = scene.media.bounds();
    let everything = media.union(scene.surfaces.bounds());
    let visible = Visible::look(scene, shooting.seed, shooting.needs);
    // An endless medium is as large as what is seen of it.
    let seen = visible.sphere().map(|(_, radius)| (2.0 * radius).min(ENDLESS));
    let size = seen.filter(|_| scene.media.is_endless()).unwrap_or(extent(media, everything));
    // A gather wider than all there is finds nothing more and spoils the rest.
    let radius = shooting.radius.map(|radius| radius.min(size));
    let margin = radius.unwrap_or(0.02 * size);
    let origin = visible.sphere().map_or_else(|| middle(everything), |(center, _)| center);
    let emitters = Emitters::new(scene, reach(scene, &visible, everything.grown(margin))?)?;
    let units = Units::around(emitters.power() / shooting.photons.max(1) as f64, size);
    let mut paths = Paths {
        scene,
        emitters,
        units,
        zones: Zones::around(&scene.media, margin),
        shooting: *shooting,
        origin,
        keep: 1.0,
    };
    let count = if paths.emitters.is_empty() { 0 } else { shooting.photons };
    // The first paths tell how many photons one leaves, so that few of them are kept. Where a path
    // leaves very many, as at a spike of density, few paths tell.
    let (mut traced, mut left) = (0, 0);
    while traced < CHUNK.min(count) && left < PROBED {
        left += paths.trace(traced..traced + 1).volume.len();
        traced += 1;
    }
    let expected = left as f64 * count as f64 / traced.max(1) as f64;
    paths.keep = ((KEPT * count as f64).max(SPARED) / expected.max(1.0)).min(1.0);
    let chunks: Vec<Deposits> = (0..count.div_ceil(CHUNK))
        .into_par_iter()
        .map(|chunk| {
            let range = chunk * CHUNK..count.min((chunk + 1) * CHUNK);
            advance(range.end - range.start);
            paths.trace(range)
        })
        .collect();
    let mut work: Work = chunks.iter().map(|c| c.work).sum();
    let mut volume: Vec<Placed> = Vec::new();
    let mut independent: Vec<Placed> = Vec::new();
    for chunk in &chunks {
        volume.extend(&chunk.volume);
        independent.extend(chunk.independent.iter().map(|index| chunk.volume[*index]));
    }
    let surface: Vec<Placed> = chunks.iter().flat_map(|c| &c.surface).copied().collect();
    drop(chunks);
    work += visible.work;
    work.photon_paths = count;
    work.volume_photons = volume.len() as u64;
    work.surface_photons = surface.len() as u64;
    let surface = PhotonMap::new(origin, &surface);
    let radii = match radius {
        Some(radius) => Radii::constant(radius, volume.len()),
        None => {
            let depth = visible.depth(scene).min(size);
            let weight = |p: &Placed| toward_camera(scene, p.at(origin), &p.photon);
            Radii::adaptive(origin, &volume, &independent, &visible.media, depth, weight, margin)
        }
    };
    let surface_radius = radius
        .or_else(|| around(&surface, &visible.surfaces))
        .unwrap_or_else(|| 0.02 * extent(everything, media));
    let thinner = |level: u32| {
        let wider = (1_u32 << level) as f32;
        let radii: Vec<f32> = thinned(&radii.each, level).map(|r| r * wider).collect();
        BeamMap::new(origin, &thinned(&volume, level).copied().collect::<Vec<_>>(), &radii)
    };
    let mut levels = vec![BeamMap::new(origin, &volume, &radii.each)];
    levels.extend((1..=shooting.levels).map(thinner));
    let volume = levels;
    let (volume_radius, volume_unit, surface_unit) = (radii.typical, units.volume, units.surface);
    let maps =
        PhotonMaps { volume, volume_radius, surface, surface_radius, volume_unit, surface_unit };
    Ok((maps, work))
}

/// What is left of `all` in a level.
fn thinned<T>(all: &[T], level: u32) -> impl Iterator<Item = &T> {
    all.iter().step_by(THINNING.pow(level))
}

/// How much more a photon's light scatters toward the camera than if it were spread evenly, by the
/// most peaked phase function.
fn toward_camera(scene: &Scene, p: WorldPoint, photon: &Photon) -> f64 {
    let cosine = photon.direction().dot(scene.camera.toward(p));
    let most = scene.media.iter().map(|m| m.phase.eval(cosine)).fold(0.0, f64::max);
    most / warp::uniform_sphere_pdf()
}

/// What photons should reach: above all what the camera sees of the media, and round it all media
/// and finite surfaces, with the ground about them where a plane is infinite; everything where a
/// medium is endless.
fn reach(scene: &Scene, visible: &Visible, bounds: Aabb<World>) -> Result<Reach> {
    let (center, seen) = visible.sphere().unwrap_or((middle(bounds), f64::INFINITY));
    let mut all = bounds.corners().iter().fold(seen, |r, c| r.max((*c - center).length()));
    if scene.surfaces.surfaces().iter().any(|s| s.shape().bounds().is_none()) {
        all *= GROUND;
    }
    if scene.media.is_endless() || !all.is_finite() {
        return Reach::new(center, ENDLESS).map_err(Error::Usage);
    }
    Reach::with_ground(center, seen.clamp(1e-3 * all, all), all).map_err(Error::Usage)
}

/// The centre of `bounds`, or the world's origin where they are empty: a scene of infinite planes.
fn middle(bounds: Aabb<World>) -> WorldPoint {
    if bounds.is_empty() { WorldPoint::new(0.0, 0.0, 0.0) } else { bounds.center() }
}

/// The diagonal of `first`, or of `second` where that is empty, or 1 m.
fn extent(first: Aabb<World>, second: Aabb<World>) -> f64 {
    [first, second].iter().find(|b| !b.is_empty()).map_or(1.0, |b| b.size().length())
}
