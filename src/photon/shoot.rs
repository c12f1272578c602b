//! Pass 1: many photon paths in parallel, and the maps made of them.

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::light::{Focus, Reach};
use crate::math::{Aabb, Spectrum, World, WorldPoint, warp};
use crate::medium::Medium;
use crate::scene::Scene;
use crate::surface::Material;
use crate::work::Work;

use super::emitters::Emitters;
use super::estimate::{THINNING, places};
use super::keep::{Keeper, eye, is_before, needs_beams};
use super::lattice::{Builder, Lattice, Track};
use super::path::{Deposits, Paths, Units};
use super::radius::{self, Radii};
use super::scout::Scouted;
use super::visible::Visible;
use super::zones::Zones;
use super::{
    BeamMap, Heading, Photon, PhotonMaps, Placed, Scattering, Shooting, SurfaceMap, soft, worth,
};

/// Radius, in metres, that stands for everything.
const ENDLESS: f64 = 1e15;

/// Radii of the scene, or heights over an infinite plane, within which ground counts as near.
const GROUND: f64 = 4.0;

/// Radii of the scene from which an infinite plane is at most thought to be away.
const HIGHEST: f64 = 1e4;

/// Radius of the halo round what is seen of a medium that the eye is inside of, in radii.
const HALO: f64 = 4.0;

/// How many times as many events splitting may make of the same paths.
const DEARER: f64 = 2.0;

/// How often the window for splitting is raised at most.
const RAISES: u32 = 8;

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
pub fn shoot<S: Spectrum, H: Heading>(
    scene: &Scene,
    shooting: &Shooting,
    advance: &(dyn Fn(u64) + Sync),
) -> Result<(PhotonMaps<S, H>, Work)> {
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
    let keeps = shooting.needs.volume_photons;
    let keeper = Keeper { scene, shooting, visible: &visible.media };
    let direct = keeper.direct();
    let reach = reach(scene, &visible, everything.grown(margin))?;
    let above_ground = reach.above_ground();
    let emitters = Emitters::new(scene, reach, !direct.is_empty())?;
    let units = Units::around(emitters.power() / shooting.photons.max(1) as f64, size);
    let is_round_eye = |medium: &Medium| !is_before(scene, medium);
    let depth = visible.depth(scene).min(size);
    let zones = Zones::around(&scene.media, margin);
    let inside = scene.media.iter().any(is_round_eye);
    let mut paths = Paths {
        scene,
        emitters,
        reach: above_ground,
        units,
        zones: if inside { zones.with_eye(eye(scene), depth) } else { zones },
        shooting: *shooting,
        origin,
        keep: 1.0,
        tracked: keeps.then(|| if scene.media.is_endless() { endless() } else { media }),
        window: None,
    };
    let phases = soft::phases(scene, shooting.photons);
    let count = if paths.emitters.is_empty() { 0 } else { shooting.photons };
    worth::share_out::<S, H>(&mut paths, &visible);
    let scouted = windowed::<S, H>(&mut paths, count);
    paths.keep = scouted.keep;
    let (gather, mut lattices) = keeper.flights(&phases, origin, scouted.flown);
    let gathered = match &gather {
        Some(_) if !direct.is_empty() => keeper.gathered(),
        _ => Vec::new(),
    };
    // Cells at a medium's border reach beyond it.
    paths.tracked = lattices.iter().map(Builder::bounds).reduce(Aabb::union);
    if !lattices.is_empty() && (gather.is_some() || !needs_beams(scene)) {
        paths.keep = 0.0;
    }
    // Lattices keep what is scattered by the blurred functions; orders are not counted along rays.
    let follows = lattices.is_empty() && shooting.max_scatter.is_none();
    let scatterings = soft::scatterings(scene, &phases, follows, is_round_eye);
    let count = shooting.traced.map_or(count, |traced| traced.min(count));
    let Deposits { volume, independent, surface, mut work, .. } =
        traced::<S, H>(&paths, count, &mut lattices, advance);
    let independent: Vec<Placed<S, H>> = independent.iter().map(|index| volume[*index]).collect();
    work += visible.work;
    let lattices: Vec<Lattice<S>> =
        lattices.into_iter().map(|l| l.finish(shooting.levels, units.surface)).collect();
    work.photon_paths = count;
    work.volume_photons = volume.len() as u64;
    work.surface_photons = surface.len() as u64;
    let in_media = || {
        let weight = |p: &Placed<S, H>| toward_camera(scene, &scatterings, p.at(origin), &p.photon);
        let radii = match radius {
            Some(radius) => Radii::constant(radius, volume.len()),
            None => {
                let seen = &visible.media;
                Radii::adaptive(origin, &volume, &independent, seen, depth, weight, margin)
            }
        };
        let maps = thinned_maps(origin, &volume, &radii.each, shooting.levels);
        (maps, radii.typical)
    };
    let on_surfaces = || {
        let radii = match radius {
            Some(radius) => vec![radius as f32; surface.len()],
            None => radius::on_surfaces(origin, &surface, 0.1 * extent(everything, media)),
        };
        SurfaceMap::new(origin, &surface, &radii)
    };
    let ((volume, typical), surface) = rayon::join(in_media, on_surfaces);
    let volume_radius = lattices.iter().map(Lattice::edge).fold(typical, f64::min);
    let maps = PhotonMaps {
        volume,
        lattices,
        gather,
        direct,
        gathered,
        places: places(shooting.denoise),
        scatterings,
        volume_radius,
        surface,
        volume_unit: units.volume,
        surface_unit: units.surface,
    };
    Ok((maps, work))
}

/// What `count` paths leave, their flights in `lattices`. `advance` is told how many are done.
fn traced<S: Spectrum, H: Heading>(
    paths: &Paths<'_>,
    count: u64,
    lattices: &mut [Builder<'_, S>],
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
        let tracks: Vec<&[Track<S>]> = traced.iter().map(|d| &d.tracks[..]).collect();
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

/// Gives `paths` a window round the usual power in media, raised where splitting heavier photons
/// would make them too dear, and tells what `count` paths then leave.
fn windowed<S: Spectrum, H: Heading>(paths: &mut Paths<'_>, count: u64) -> Scouted {
    let whole = Scouted::by::<S, H>(paths, count);
    let Some(power) = whole.usual_power else { return whole };
    let mut window = power * paths.units.surface;
    for _ in 0..RAISES {
        paths.window = Some(window);
        let split = Scouted::by::<S, H>(paths, count);
        let dearer = split.events / (DEARER * whole.events).max(1.0);
        if dearer <= 1.0 {
            return split;
        }
        window *= dearer.max(1.5);
    }
    paths.window = None;
    whole
}

/// The map of all `photons`, and as many `levels` more of fewer and wider ones.
fn thinned_maps<S: Spectrum, H: Heading>(
    origin: WorldPoint,
    photons: &[Placed<S, H>],
    radii: &[f32],
    levels: u32,
) -> Vec<BeamMap<S, H>> {
    let map = |level: u32| {
        let (step, wider) = (THINNING.pow(level), (1_u32 << level) as f32);
        let left: Vec<Placed<S, H>> = photons.iter().step_by(step).copied().collect();
        let radii: Vec<f32> = radii.iter().step_by(step).map(|r| r * wider).collect();
        BeamMap::new(origin, &left, &radii)
    };
    let all = BeamMap::new(origin, photons, radii);
    std::iter::once(all).chain((1..=levels).map(map)).collect()
}

/// How much more a photon's light scatters toward the camera than if it were spread evenly, by the
/// most peaked phase function.
fn toward_camera<S: Spectrum, H: Heading>(
    scene: &Scene,
    scatterings: &[Scattering],
    p: WorldPoint,
    photon: &Photon<S, H>,
) -> f64 {
    let (heading, toward) = (photon.heading(), scene.camera.toward(p));
    let phases = scatterings.iter().map(|scattering| &scattering.phase);
    let most = phases.map(|phase| heading.spread(phase, toward)).fold(0.0, f64::max);
    most / warp::uniform_sphere_pdf()
}

/// What photons should reach: above all what the camera sees of the media, and round it all media
/// and finite surfaces, with the ground about them where a plane is infinite; everything where a
/// medium is endless.
fn reach(scene: &Scene, visible: &Visible, bounds: Aabb<World>) -> Result<Reach> {
    let seen = visible.sphere();
    let (center, radius) = seen.unwrap_or_else(|| (middle(bounds), 0.0));
    let all = bounds.corners().iter().fold(radius, |r, c| r.max((*c - center).length()));
    if scene.media.is_endless() || !(all > 0.0 && all.is_finite()) {
        return Reach::new(center, ENDLESS).map_err(Error::Usage);
    }
    let away = scene.surfaces.infinite_feet(center).map(|(_, foot)| (foot - center).length());
    let height = away.min_by(f64::total_cmp).map(|height| height.min(HIGHEST * all));
    let outer = height.map_or(all, |height| GROUND * all.max(height));
    // Where nothing is seen all counts alike.
    let radius = if seen.is_some() { radius.clamp(1e-3 * all, all) } else { all };
    let reach = Reach::with_ring(center, radius, outer).map_err(Error::Usage)?;
    let reach = reach.over_ground(height);
    let mut foci = visible.foci();
    if !scene.media.iter().all(|medium| is_before(scene, medium)) {
        // Light beside what is seen is a scattering away from it.
        let halo = |focus: &Focus| Focus { radius: HALO * focus.radius, ..*focus };
        foci.extend(foci.clone().iter().map(halo));
    }
    let images: Vec<Focus> = foci.iter().flat_map(|focus| images(scene, focus)).collect();
    foci.extend(images);
    Ok(reach.focused_on(foci))
}

/// The images of a focus in infinite mirrors and panes, behind which light for it has to aim.
fn images(scene: &Scene, focus: &Focus) -> impl Iterator<Item = Focus> {
    let feet = scene.surfaces.infinite_feet(focus.center);
    let mirrors = feet.filter(|(surface, _)| surface.materials().iter().any(Material::is_specular));
    mirrors.map(|(_, foot)| Focus { center: foot + (foot - focus.center), ..*focus })
}

/// A box that stands for everything.
fn endless() -> Aabb<World> {
    let middle = WorldPoint::new(0.0, 0.0, 0.0);
    Aabb::new(middle, middle).grown(ENDLESS)
}

/// The centre of `bounds`, or the world's origin where they are empty: a scene of infinite planes.
fn middle(bounds: Aabb<World>) -> WorldPoint {
    if bounds.is_empty() { WorldPoint::new(0.0, 0.0, 0.0) } else { bounds.center() }
}

/// The diagonal of `first`, or of `second` where that is empty, or 1 m.
fn extent(first: Aabb<World>, second: Aabb<World>) -> f64 {
    [first, second].iter().find(|b| !b.is_empty()).map_or(1.0, |b| b.size().length())
}
