//! Which estimator lights each medium, decided once before photons are shot.

use crate::math::WorldPoint;
use crate::medium::{Medium, Phase, SparseCells};
use crate::scene::{FinalGather, Scene};
use crate::transport::is_camera_outside;

use super::cell_width::{
    direct_light_cells, final_gather_cells, thin_width, thin_width_for_moments, width_for_flights,
};
use super::gather_termination::GatherTermination;
use super::kind::{Conditions, MediumStrategy, Strategy, Summary};
use super::phase_blur::{self, PhaseSplit};

/// Largest ratio of the noise-optimal to the thin cell width of [`Strategy::FluenceTowardEye`], where
/// [`Strategy::Moments`] is the alternative.
const MAX_REFINEMENT_BEFORE_MOMENTS: f64 = 1.4;

/// As [`MAX_REFINEMENT_BEFORE_MOMENTS`], where [`Strategy::Beams`] is the alternative: noise of finer
/// cells costs less than gathers of photons along every ray.
const MAX_REFINEMENT_BEFORE_BEAMS: f64 = 2.0;

/// Values a cell of moments of the first degree: fluence and the three components of flux.
const FIRST_DEGREE_VALUES: usize = 4;

/// Places along a ray at which caches of the finest level are sampled.
const PLACES: u32 = 8;

/// Fewest places along a ray at which caches are sampled: at the widest level, and where the picture
/// is denoised, which removes the noise of few places.
const MIN_PLACES: u32 = 2;

/// The cells of the caches that a choice asks for: one grid a medium, or none.
#[derive(Debug, Default)]
pub struct CacheCells {
    /// Of direct light.
    pub direct: Vec<SparseCells>,
    /// Of photons' light, toward the camera or as moments.
    pub fluence: Vec<SparseCells>,
    /// Of final gathers.
    pub final_gathers: Vec<SparseCells>,
}

/// How light in media is estimated.
#[derive(Debug, Clone)]
pub struct Choice {
    /// The estimator: all media have the same, as rays cross several of them at once.
    pub strategy: Strategy,
    /// Why, as one sentence.
    pub reason: &'static str,
    /// Whether direct light is cached.
    pub caches_direct: bool,
    /// When final gathers end; with moments only.
    pub termination: Option<GatherTermination>,
    /// Phase function of each medium, blurred for the number of photons.
    pub blurred: Vec<Phase>,
    /// How each medium scatters photons that rays gather.
    pub splits: Vec<PhaseSplit>,
    /// Whether photons are stored for beams, which rays behind mirrors may need beside a cache.
    pub stores_photons: bool,
    /// Each medium's strategy with its cell widths.
    pub media: Vec<MediumStrategy>,
    places: u32,
}

impl Choice {
    /// That of a picture without photons.
    pub const fn without_photons() -> Self {
        Self {
            strategy: Strategy::Beams,
            reason: "no photons are needed",
            caches_direct: false,
            termination: None,
            blurred: Vec::new(),
            splits: Vec::new(),
            stores_photons: false,
            media: Vec::new(),
            places: 0,
        }
    }

    /// Number of places along a ray at which caches of this level are sampled: fewer where cells are
    /// wider.
    pub fn places_at(&self, level: usize) -> u32 {
        (self.places >> level).max(MIN_PLACES)
    }

    /// What a report says of it.
    pub fn summary(&self) -> Summary {
        Summary { reason: self.reason.into(), media: self.media.clone() }
    }
}

/// Decides how light in the media of `scene` is estimated. `visible` are places in media that the
/// camera sees; `direct` are the cells of [`direct_cells`]; all flights of photons together are
/// `flight_length` metres long.
pub fn choose(
    scene: &Scene,
    conditions: &Conditions,
    visible: &[WorldPoint],
    direct: Vec<SparseCells>,
    flight_length: f64,
) -> (Choice, CacheCells) {
    let question = Question { scene, conditions, visible, flight_length };
    let blurred = phase_blur::phases(scene, conditions.photons);
    let (termination, fluence) = question.fluence_cells(&blurred);
    let final_gathers = match &termination {
        Some(_) if !direct.is_empty() => question.gather_cells(),
        _ => Vec::new(),
    };
    let strategy = match (&termination, fluence.is_empty(), final_gathers.is_empty()) {
        (Some(_), _, false) => Strategy::SharedGathers,
        (Some(_), _, true) => Strategy::Moments,
        (None, false, _) => Strategy::FluenceTowardEye,
        (None, true, _) => Strategy::Beams,
    };
    // Peaks are followed only by rays that gather photons, and orders are not counted along rays.
    let follows_peaks = strategy == Strategy::Beams && conditions.max_scatter.is_none();
    let near = |medium: &Medium| !is_camera_outside(scene, medium);
    let width = |cells: &[SparseCells], medium: usize| cells.get(medium).map(|cells| cells.edge);
    let medium = |medium: usize| MediumStrategy {
        strategy,
        cell_width: width(&fluence, medium),
        gather_cell_width: width(&final_gathers, medium),
        direct_cell_width: width(&direct, medium),
    };
    let choice = Choice {
        strategy,
        reason: question.reason(strategy),
        caches_direct: !direct.is_empty(),
        splits: phase_blur::scatterings(scene, &blurred, follows_peaks, near),
        stores_photons: match strategy {
            Strategy::Beams => true,
            Strategy::FluenceTowardEye => needs_beams(scene),
            Strategy::Moments | Strategy::SharedGathers => false,
        },
        termination,
        blurred,
        media: (0..scene.media.len()).map(medium).collect(),
        places: if conditions.denoise { MIN_PLACES } else { PLACES },
    };
    (choice, CacheCells { direct, fluence, final_gathers })
}

/// Cells for direct light in each medium; none where one of them cannot be cached.
pub fn direct_cells(
    scene: &Scene,
    conditions: &Conditions,
    visible: &[WorldPoint],
) -> Vec<SparseCells> {
    let Conditions { film_pixels, rays, .. } = *conditions;
    for_all_media(scene, conditions, |medium| {
        direct_light_cells(scene, medium, visible, film_pixels, rays)
    })
}

/// What decides about one picture.
struct Question<'a> {
    scene: &'a Scene,
    conditions: &'a Conditions,
    visible: &'a [WorldPoint],
    /// Length of all flights together, in metres.
    flight_length: f64,
}

impl Question<'_> {
    /// Cells for final gathers; none where one medium cannot have them, and where the picture is
    /// denoised: that removes noise which is independent from ray to ray, not noise that rays share.
    fn gather_cells(&self) -> Vec<SparseCells> {
        let Conditions { film_pixels, rays, denoise, .. } = *self.conditions;
        if denoise {
            return Vec::new();
        }
        for_all_media(self.scene, self.conditions, |medium| {
            final_gather_cells(self.scene, medium, self.visible, film_pixels, rays)
        })
    }

    /// Cells for photons' light in each medium, of moments where the termination of final gathers
    /// comes along; none where photons are to be gathered along rays.
    fn fluence_cells(&self, blurred: &[Phase]) -> (Option<GatherTermination>, Vec<SparseCells>) {
        let choices = GatherTermination::choices(self.scene, self.conditions);
        let refinement = if choices.iter().any(Option::is_some) {
            MAX_REFINEMENT_BEFORE_MOMENTS
        } else {
            MAX_REFINEMENT_BEFORE_BEAMS
        };
        let cells = |termination: Option<GatherTermination>| {
            let cells = for_all_media(self.scene, self.conditions, |index| {
                let medium = self.scene.media.get(index);
                let (width, values) = match &termination {
                    None => (self.width_toward_eye(medium, &blurred[index], refinement)?, 1),
                    Some(_) => (self.width_of_moments(medium)?, FIRST_DEGREE_VALUES),
                };
                SparseCells::covering(&medium.density, width, values)
            });
            (termination, cells)
        };
        choices.into_iter().map(cells).find(|(_, cells)| !cells.is_empty()).unwrap_or_default()
    }

    /// Width, in metres, of cells that hold light scattered toward the camera; `None` where the
    /// noise-optimal width is more than `refinement` times the thin one.
    fn width_toward_eye(&self, medium: &Medium, phase: &Phase, refinement: f64) -> Option<f64> {
        self.width(medium, thin_width(medium, self.visible), phase, refinement)
    }

    /// Width, in metres, of cells that hold moments. They are read at many places, whose mean evens
    /// out what wide cells blur.
    fn width_of_moments(&self, medium: &Medium) -> Option<f64> {
        let thin = thin_width_for_moments(medium, self.visible);
        self.width(medium, thin, &Phase::ISOTROPIC, f64::INFINITY)
    }

    /// Width of cells, in metres: noise-optimal for flights that `phase` weighs, at most `thin`.
    /// `None` where the noise-optimal width is more than `refinement` times `thin`.
    fn width(&self, medium: &Medium, thin: f64, phase: &Phase, refinement: f64) -> Option<f64> {
        if let Some(radius) = self.conditions.radius {
            return (radius <= thin).then_some(radius);
        }
        let optimal = width_for_flights(medium.density.volume()?, self.flight_length, phase);
        (optimal <= refinement * thin).then_some(optimal.min(thin))
    }

    fn reason(&self, strategy: Strategy) -> &'static str {
        let forced = self.conditions.final_gather == FinalGather::Always;
        let peaked = GatherTermination::is_peaked(self.scene);
        let outside = |medium: &Medium| is_camera_outside(self.scene, medium);
        match strategy {
            Strategy::Beams if !self.conditions.volume_photons => "no photons are stored in media",
            Strategy::Beams if !self.scene.media.iter().all(outside) => {
                "the camera is in a medium or near one, where cells of a cache would show"
            }
            Strategy::Beams => {
                "cells that are optically thin would be crossed by too few photons, or be too many"
            }
            Strategy::FluenceTowardEye => {
                "cells that are optically thin are crossed by enough photons"
            }
            Strategy::Moments | Strategy::SharedGathers if forced => "final gathers are asked for",
            Strategy::Moments | Strategy::SharedGathers if peaked => {
                "a phase function is peaked: few photons fly so that much is scattered toward the \
                 camera"
            }
            Strategy::Moments | Strategy::SharedGathers => {
                "optically thin cells would be crossed by too few photons, and the denoiser removes \
                 the noise of gathers"
            }
        }
    }
}

/// Cells for each medium; none where one of them has none, or the camera is not outside of it.
fn for_all_media(
    scene: &Scene,
    conditions: &Conditions,
    cells: impl Fn(usize) -> Option<SparseCells>,
) -> Vec<SparseCells> {
    let media = &scene.media;
    let can_cache =
        |medium: &usize| conditions.volume_photons && is_camera_outside(scene, media.get(*medium));
    let all = (0..media.len()).map(|medium| Some(medium).filter(can_cache).and_then(&cells));
    all.collect::<Option<_>>().unwrap_or_default()
}

/// Whether rays behind mirrors and glass read light that a cache toward the camera does not hold.
fn needs_beams(scene: &Scene) -> bool {
    let isotropic = scene.media.iter().all(|m| m.phase.is_isotropic());
    !isotropic && scene.surfaces.has_specular()
}

#[cfg(test)]
mod tests {
    use super::*;

    const CONDITIONS: Conditions = Conditions {
        photons: 100_000,
        max_scatter: None,
        final_gather: FinalGather::Auto,
        denoise: false,
        radius: None,
        rays: 16,
        film_pixels: 1.0,
        volume_photons: true,
    };

    fn chosen(position: f64, g: f64, conditions: &Conditions, flight_length: f64) -> Choice {
        let scene = Scene::of_text(&format!(
            "
            [camera]
            position = [0.0, 0.0, {position}]
            target = [0.0, 0.0, -100.0]
            fov = 30.0
            [film]
            size = [64, 64]
            [[medium]]
            region = {{ box = {{ min = [-1.0, -1.0, -1.0], max = [1.0, 1.0, 1.0] }} }}
            sigma_t = 2.0
            albedo = 0.9
            phase = {{ type = 'henyey-greenstein', g = {g} }}
            [[light]]
            type = 'environment'
            radiance = 1.0
            "
        ));
        let visible = [WorldPoint::new(0.0, 0.0, 0.9)];
        let direct = direct_cells(&scene, conditions, &visible);
        choose(&scene, conditions, &visible, direct, flight_length).0
    }

    #[test]
    fn each_strategy_is_chosen_where_it_fits() {
        let auto = &CONDITIONS;
        let never = &Conditions { final_gather: FinalGather::Never, ..CONDITIONS };
        let denoised = &Conditions { denoise: true, ..CONDITIONS };
        for (position, g, conditions, flight_length, right) in [
            (6.0, 0.0, auto, 1e6, Strategy::FluenceTowardEye),
            (6.0, 0.0, auto, 1.0, Strategy::Beams),
            (0.0, 0.0, auto, 1e6, Strategy::Beams),
            (6.0, 0.8, auto, 1e6, Strategy::SharedGathers),
            (6.0, 0.8, denoised, 1e6, Strategy::Moments),
            (6.0, 0.8, never, 1e8, Strategy::FluenceTowardEye),
        ] {
            let choice = chosen(position, g, conditions, flight_length);
            assert_eq!(choice.strategy, right, "at {position}, g = {g}: {}", choice.reason);
            assert_eq!(choice.media.len(), 1);
            assert_eq!(choice.media[0].cell_width.is_some(), right != Strategy::Beams);
        }
    }
}
