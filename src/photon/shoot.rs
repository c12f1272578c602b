//! Pass 1: many photon paths in parallel, and the maps made of them.

use rayon::prelude::*;

use crate::error::Result;
use crate::math::{Aabb, Spectrum};
use crate::medium::Medium;
use crate::scene::Scene;
use crate::work::Work;

use super::camera_importance::CameraImportance;
use super::deposit_regions::DepositRegions;
use super::emitters::Emitters;
use super::extents::{Extents, endless};
use super::maps::places;
use super::path::{Deposits, PhotonTracer, Units};
use super::pilot::PathPilot;
use super::{
    PhotonDirection, PhotonMaps, PhotonSettings, build, emission_target, emitter_importance,
};
use crate::cache::{FluenceBuilder, FluenceGrid};
use crate::strategy;
use crate::strategy::{CachePlanner, eye, is_before, needs_beams};
use crate::transport::FlightSegment;

/// Paths that are traced as one piece of work.
const CHUNK: u64 = 512;

/// Pieces of work whose flights are kept together.
const BATCH: usize = 32;

/// Paths whose flights are in memory at once: of one batch while they are kept, of the next while it
/// is traced.
pub(super) const MOST_PATHS: u64 = 2 * BATCH as u64 * CHUNK;

/// Shoots photons into `scene` and builds the maps. `advance` is told how many paths are done. One
/// channel is right where the scene is grey, photons without heading where all media that scatter
/// do so to all sides alike.
///
/// # Errors
/// Where an emitter cannot be sampled: a medium that glows without end.
pub fn shoot<S: Spectrum, H: PhotonDirection>(
    scene: &Scene,
    shooting: &PhotonSettings,
    advance: &(dyn Fn(u64) + Sync),
) -> Result<(PhotonMaps<S, H>, Work)> {
    if !shooting.needs.photons() {
        return Ok((PhotonMaps::empty(shooting.radius.unwrap_or(0.0)), Work::default()));
    }
    let visible = CameraImportance::look(scene, shooting.seed, shooting.needs);
    let extents = Extents::of(scene, &visible, shooting.radius);
    let keeper = CachePlanner { scene, shooting, visible: &visible.media };
    let direct = keeper.direct();
    let mut paths = all_paths(scene, shooting, &visible, &extents, !direct.is_empty())?;
    let count = if paths.emitters.is_empty() { 0 } else { shooting.photons };
    emitter_importance::share_out::<S, H>(&mut paths, &visible);
    let scouted = PathPilot::windowed::<S, H>(&mut paths, count);
    paths.keep = scouted.keep;
    let phases = strategy::phases(scene, shooting.photons);
    let (gather, mut lattices) = keeper.flights(&phases, extents.origin, scouted.flown);
    let gathered = match &gather {
        Some(_) if !direct.is_empty() => keeper.gathered(),
        _ => Vec::new(),
    };
    // Cells at a medium's border reach beyond it.
    paths.tracked = lattices.iter().map(FluenceBuilder::bounds).reduce(Aabb::union);
    if !lattices.is_empty() && (gather.is_some() || !needs_beams(scene)) {
        paths.keep = 0.0;
    }
    // Lattices keep what is scattered by the blurred functions; orders are not counted along rays.
    let follows = lattices.is_empty() && shooting.max_scatter.is_none();
    let scatterings = strategy::scatterings(scene, &phases, follows, |m| is_round_eye(scene, m));
    let count = shooting.traced.map_or(count, |traced| traced.min(count));
    let deposits = traced::<S, H>(&paths, count, &mut lattices, advance);
    let units = paths.units;
    let lattices: Vec<FluenceGrid<S>> =
        lattices.into_iter().map(|l| l.finish(shooting.levels, units.surface)).collect();
    let mut work = deposits.work;
    work += visible.work;
    work.photon_paths = count;
    work.volume_photons = deposits.volume.len() as u64;
    work.surface_photons = deposits.surface.len() as u64;
    let ((volume, typical), surface) = rayon::join(
        || build::in_media(scene, shooting, &extents, &visible, &scatterings, &deposits),
        || build::on_surfaces(&extents, &deposits.surface),
    );
    let maps = PhotonMaps {
        volume,
        volume_radius: lattices.iter().map(FluenceGrid::edge).fold(typical, f64::min),
        lattices,
        gather,
        direct,
        gathered,
        places: places(shooting.denoise),
        scatterings,
        surface,
        volume_unit: units.volume,
        surface_unit: units.surface,
    };
    Ok((maps, work))
}

/// Whether the eye is inside of a medium or near it.
fn is_round_eye(scene: &Scene, medium: &Medium) -> bool {
    !is_before(scene, medium)
}

/// What all paths share, before it is known which photons and flights are to be kept. `keeps_sky` says
/// whether lattices keep light that comes straight from the sky.
fn all_paths<'a>(
    scene: &'a Scene,
    shooting: &PhotonSettings,
    visible: &CameraImportance,
    extents: &Extents,
    keeps_sky: bool,
) -> Result<PhotonTracer<'a>> {
    let reach = emission_target::reach(scene, visible, extents)?;
    let above_ground = reach.above_ground();
    let emitters = Emitters::new(scene, reach, keeps_sky)?;
    let zones = DepositRegions::around(&scene.media, extents.margin);
    let inside = scene.media.iter().any(|medium| is_round_eye(scene, medium));
    let flown_in = if scene.media.is_endless() { endless() } else { extents.media };
    Ok(PhotonTracer {
        scene,
        units: Units::around(emitters.power() / shooting.photons.max(1) as f64, extents.size),
        emitters,
        reach: above_ground,
        zones: if inside { zones.with_eye(eye(scene), extents.depth) } else { zones },
        shooting: *shooting,
        origin: extents.origin,
        keep: 1.0,
        tracked: shooting.needs.volume_photons.then_some(flown_in),
        window: None,
    })
}

/// What `count` paths leave, their flights in `lattices`. `advance` is told how many are done.
fn traced<S: Spectrum, H: PhotonDirection>(
    paths: &PhotonTracer<'_>,
    count: u64,
    lattices: &mut [FluenceBuilder<'_, S>],
    advance: &(dyn Fn(u64) + Sync),
) -> Deposits<S, H> {
    let mut all = Deposits::none();
    let trace = |batch: &[u64]| -> Vec<Deposits<S, H>> {
        let piece = |chunk: &u64| {
            let range = chunk * CHUNK..count.min((chunk + 1) * CHUNK);
            advance(range.end - range.start);
            paths.trace(range)
        };
        // One at a time, lest a thread that has none left waits for one that took many.
        batch.par_iter().with_max_len(1).map(piece).collect()
    };
    let mut keep = |traced: Vec<Deposits<S, H>>| {
        traced.iter().for_each(|deposits| all.append(deposits));
        let tracks: Vec<&[FlightSegment<S>]> = traced.iter().map(|d| &d.tracks[..]).collect();
        all.work.tracks += tracks.iter().map(|tracks| tracks.len() as u64).sum::<u64>();
        for lattice in &mut *lattices {
            lattice.add(&tracks);
        }
    };
    let chunks: Vec<u64> = (0..count.div_ceil(CHUNK)).collect();
    // Neither has threads wait for the last pieces of the other.
    let mut traced = Vec::new();
    for batch in chunks.chunks(BATCH) {
        (traced, ()) = rayon::join(|| trace(batch), || keep(traced));
    }
    keep(traced);
    all
}
