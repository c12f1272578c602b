//! What light of a scene is kept on lattices.

use crate::math::{Aabb, Spectrum, World, WorldPoint};
use crate::medium::{Medium, Phase};
use crate::scene::Scene;

use super::gather_termination::GatherTermination;
use crate::cache::{
    CellContents, DirectLightCache, FinalGatherCache, FluenceBuilder, SparseCells,
    edge_for_flights, thin_edge, thin_edge_for_moments,
};
use crate::photon::PhotonSettings;

/// Distance from a medium, in its smallest extents, within which the eye counts as inside.
const NEAR: f64 = 0.02;

/// How many times as fine as suits the flights cells may be, so that they are thin, where lattices
/// of moments can be had instead.
const FINER: f64 = 1.4;

/// As [`FINER`], where beams are what is left: noise of cells costs less than to gather.
const FINEST: f64 = 2.0;

/// Chooses what is kept.
pub struct CachePlanner<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// How its photons are shot.
    pub shooting: &'a PhotonSettings,
    /// Places that the camera sees of the media.
    pub visible: &'a [WorldPoint],
}

impl<'a> CachePlanner<'a> {
    /// For each medium, light straight from lights; nothing where one of them cannot keep it.
    pub fn direct<S: Spectrum>(&self) -> Vec<DirectLightCache<S>> {
        let PhotonSettings { pixels, rays, seed, .. } = *self.shooting;
        let new =
            |medium| DirectLightCache::new(self.scene, medium, self.visible, pixels, rays, seed);
        self.each(new)
    }

    /// For each medium what final gathers find; nothing where one of them cannot keep it, and where
    /// noise is taken off: it goes where each ray has its own, not where rays share it.
    pub fn gathered<S: Spectrum>(&self) -> Vec<FinalGatherCache<S>> {
        let PhotonSettings { pixels, rays, seed, denoise, traced, .. } = *self.shooting;
        let looks = traced.is_some();
        let new = |medium| {
            FinalGatherCache::new(self.scene, medium, self.visible, pixels, rays, seed, looks)
        };
        if denoise { Vec::new() } else { self.each(new) }
    }

    /// One for each medium, where all lie before the eye and have one.
    fn each<T>(&self, new: impl Fn(usize) -> Option<T>) -> Vec<T> {
        let media = &self.scene.media;
        let keeps = |medium: &usize| {
            self.shooting.needs.volume_photons && is_before(self.scene, media.get(*medium))
        };
        let all = (0..media.len()).map(|medium| Some(medium).filter(keeps).and_then(&new));
        all.collect::<Option<_>>().unwrap_or_default()
    }

    /// Empty lattices for light that has been scattered before, by these blurred phase functions,
    /// where all flights together are `flown` metres long, and how far rays are followed before
    /// those are asked. None where photons are to be gathered.
    pub fn flights<S: Spectrum>(
        &self,
        phases: &'a [Phase],
        origin: WorldPoint,
        flown: f64,
    ) -> (Option<GatherTermination>, Vec<FluenceBuilder<'a, S>>) {
        let choices = GatherTermination::choices(self.scene, self.shooting);
        let finer = if choices.iter().any(Option::is_some) { FINER } else { FINEST };
        let empty = |gather: Option<GatherTermination>| {
            let lattices = self.each(|medium| {
                let (edge, holds) = match &gather {
                    None => self.toward_eye(medium, &phases[medium], finer, flown)?,
                    Some(depth) => self.moments(medium, depth, flown)?,
                };
                let density = &self.scene.media.get(medium).density;
                let cells = SparseCells::around(density, edge, holds.planes())?;
                Some(FluenceBuilder::new(cells, origin, holds))
            });
            (gather, lattices)
        };
        choices.into_iter().map(empty).find(|(_, l)| !l.is_empty()).unwrap_or_default()
    }

    /// Edge, in metres, of cells that hold what a phase function scatters toward the eye, where they
    /// are at most `finer` times as fine as suits the flights.
    fn toward_eye(
        &self,
        medium: usize,
        phase: &'a Phase,
        finer: f64,
        flown: f64,
    ) -> Option<(f64, CellContents<'a>)> {
        let of = self.scene.media.get(medium);
        let edge = self.edge(of, thin_edge(of, self.visible), phase, finer, flown)?;
        Some((edge, CellContents::TowardEye(phase, &self.scene.camera)))
    }

    /// Edge, in metres, of cells that hold moments. Fluence varies over the way in which light
    /// forgets where it came from. Moments are asked at many places, which even out what wide cells
    /// blur.
    fn moments(
        &self,
        medium: usize,
        depth: &GatherTermination,
        flown: f64,
    ) -> Option<(f64, CellContents<'a>)> {
        let of = self.scene.media.get(medium);
        let holds = if depth.degree(medium) > 1 {
            CellContents::Moments
        } else {
            CellContents::FirstMoments
        };
        let thin = thin_edge_for_moments(of, self.visible);
        Some((self.edge(of, thin, &Phase::ISOTROPIC, f64::INFINITY, flown)?, holds))
    }

    /// Edge of cells, in metres, that suits flights of which a phase function decides what each
    /// counts, at most `thin`; nothing where they would be more than `finer` times as fine as suits.
    fn edge(
        &self,
        medium: &Medium,
        thin: f64,
        phase: &Phase,
        finer: f64,
        flown: f64,
    ) -> Option<f64> {
        if let Some(radius) = self.shooting.radius {
            return (radius <= thin).then_some(radius);
        }
        let edge = edge_for_flights(medium.density.volume()?, flown, phase);
        (edge <= finer * thin).then_some(edge.min(thin))
    }
}

/// Whether a medium has an end and lies before the eye: near it cells would show.
pub fn is_before(scene: &Scene, medium: &Medium) -> bool {
    let apart = |b: Aabb<World>| !b.grown(NEAR * b.size().min_element()).contains(eye(scene));
    medium.density.bounds().is_some_and(apart)
}

/// Where the ray through the middle of the film starts.
pub fn eye(scene: &Scene) -> WorldPoint {
    let [width, height] = scene.film.size.map(|side| 0.5 * f64::from(side));
    scene.camera.ray(width, height, [0.5; 2]).origin
}

/// Whether rays ask for light that lattices do not hold: scattered toward other places than the
/// camera.
pub fn needs_beams(scene: &Scene) -> bool {
    let isotropic = scene.media.iter().all(|m| m.phase.is_isotropic());
    !isotropic && scene.surfaces.has_specular()
}
