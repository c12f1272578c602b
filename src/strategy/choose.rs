//! Which estimator lights each medium, decided once before photons are shot.

use crate::medium::{Medium, Phase, SparseCells};
use crate::scene::{Scene, Strategy};
use crate::transport::{PixelFootprint, is_camera_outside};

use super::cell_width::{
    final_gather_cells, max_fluence_width, nearest_toward_eye, pixel_width, sharing_pixels,
    width_for_flights,
};
use super::gather_termination::GatherTermination;
use super::kind::{Assignment, Conditions, Evidence, MediumStrategy, Summary};
use super::measured::Measured;
use super::phase_blur::{self, PhaseSplit};
use super::possible;

/// Values a cell of moments of the first degree.
///
/// Unit: count. Definition: one of fluence and three of flux.
const FIRST_DEGREE_VALUES: usize = 4;

/// The cells of a medium's caches of indirect light, as far as it has them.
#[derive(Debug, Default)]
pub struct MediumCells {
    /// Of photons' light, toward the camera or as moments.
    pub fluence: Option<SparseCells>,
    /// Of final gathers.
    pub final_gathers: Option<SparseCells>,
}

/// How light in media is estimated.
#[derive(Debug, Clone)]
pub struct Choice {
    /// Each medium's strategy, in the scene's order; empty where no photons are needed.
    pub media: Vec<MediumStrategy>,
    /// What a pilot measured of each assignment that was possible; empty where it did not measure.
    pub measured: Vec<Measured>,
    /// Whether flights straight from the sky are recorded in grids.
    pub records_sky: bool,
    /// When final gathers end, for the media that have them.
    pub termination: GatherTermination,
    /// Phase function of each medium, blurred for the number of photons.
    pub blurred: Vec<Phase>,
    /// How each medium scatters photons that rays gather.
    pub splits: Vec<PhaseSplit>,
    /// Distance from the camera, in metres, within which rays from there gather photons in each medium; further
    /// away they read its cells.
    pub beams_within: Vec<f64>,
    /// Whether photons are stored for beams, which rays near the camera or behind mirrors may need beside a
    /// cache.
    pub stores_photons: bool,
}

impl Choice {
    /// That of a picture without photons.
    pub const fn without_photons() -> Self {
        Self {
            media: Vec::new(),
            measured: Vec::new(),
            records_sky: false,
            termination: GatherTermination::NEVER,
            blurred: Vec::new(),
            splits: Vec::new(),
            beams_within: Vec::new(),
            stores_photons: false,
        }
    }

    /// What a report says of it.
    pub fn summary(&self) -> Summary {
        Summary { media: self.media.clone(), measured: self.measured.clone() }
    }
}

/// How light in the media of `scene` is estimated: as `assignment` says where that is possible, and as near as
/// possible elsewhere.
pub fn choose(
    scene: &Scene,
    conditions: &Conditions,
    evidence: &Evidence<'_>,
    assignment: &Assignment,
) -> (Choice, Vec<MediumCells>) {
    let blurred = phase_blur::phases(scene, conditions.photons);
    let chooser = Chooser { scene, conditions, evidence, assignment, blurred: &blurred };
    let media = 0..scene.media.iter().len();
    let (media, cells): (Vec<_>, Vec<_>) = media.map(|medium| chooser.decide(medium)).unzip();
    let is_beams = |medium: &MediumStrategy| medium.strategy == Strategy::Beams;
    // Peaks are followed only by rays that gather photons, and orders are not counted along rays.
    let follows_peaks = media.iter().all(is_beams) && conditions.max_scatter.is_none();
    let near = |medium: &Medium| !is_camera_outside(scene, medium);
    let decided = media.iter().zip(scene.media.iter());
    let beams_within: Vec<f64> =
        decided.map(|(decided, medium)| chooser.beams_within(decided, medium)).collect();
    let has_eye_cells = media.iter().any(|medium| medium.strategy == Strategy::FluenceTowardEye);
    let stores_photons = beams_within.iter().any(|distance| *distance > 0.0)
        || has_eye_cells && possible::needs_beams(scene);
    let choice = Choice {
        media,
        measured: assignment.measured.clone(),
        records_sky: chooser.records_sky(),
        termination: GatherTermination::new(scene, conditions.photons),
        splits: phase_blur::scatterings(scene, &blurred, follows_peaks, near),
        beams_within,
        stores_photons,
        blurred,
    };
    (choice, cells)
}

/// Width in metres of the cells that a strategy has in a medium; `None` where it has none or they are too
/// many.
pub fn cell_width(
    scene: &Scene,
    conditions: &Conditions,
    evidence: &Evidence<'_>,
    medium: usize,
    strategy: Strategy,
) -> Option<f64> {
    let blurred = phase_blur::phases(scene, conditions.photons);
    let assignment = &Assignment::default();
    let chooser = Chooser { scene, conditions, evidence, assignment, blurred: &blurred };
    let of = scene.media.get(medium);
    let (width, values) = match strategy {
        Strategy::FluenceTowardEye => (chooser.width(medium, &blurred[medium])?, 1),
        Strategy::Moments | Strategy::SharedGathers => {
            (chooser.width_of_moments(medium)?, FIRST_DEGREE_VALUES)
        }
        Strategy::Beams | Strategy::Traced => return None,
    };
    Some(width).filter(|width| SparseCells::fits(&of.density, *width, values))
}

/// Pixels whose gathers a pixel shares where final gathers are cached, the fewest of all media; `None`
/// where one of them cannot have cells for them.
pub fn shared_footprint(
    scene: &Scene,
    conditions: &Conditions,
    evidence: &Evidence<'_>,
) -> Option<f64> {
    let Conditions { film_pixels, rays, .. } = *conditions;
    let footprint = PixelFootprint::new(scene, film_pixels);
    let pixel = pixel_width(&footprint, evidence.visible)?;
    let area = |(index, medium): (usize, &Medium)| {
        evidence.direct[index].filter(|_| is_camera_outside(scene, medium))?;
        let cells = final_gather_cells(scene, index, evidence.visible, film_pixels, rays)?;
        Some(sharing_pixels(cells.edge, pixel))
    };
    let areas: Option<Vec<f64>> = scene.media.iter().enumerate().map(area).collect();
    areas?.into_iter().reduce(f64::min)
}

/// What the strategies of one picture are chosen by.
struct Chooser<'a> {
    scene: &'a Scene,
    conditions: &'a Conditions,
    evidence: &'a Evidence<'a>,
    assignment: &'a Assignment,
    blurred: &'a [Phase],
}

impl Chooser<'_> {
    /// The strategy of a medium and its cells: the first of those that are preferred whose cells exist.
    fn decide(&self, medium: usize) -> (MediumStrategy, MediumCells) {
        let direct_cell_width = self.evidence.direct[medium];
        let mut preferred = self.preferred(medium).iter();
        let (strategy, cells) = preferred
            .find_map(|&strategy| Some((strategy, self.cells(strategy, medium)?)))
            .unwrap_or_default();
        let width = |cells: &Option<SparseCells>| cells.as_ref().map(|cells| cells.edge);
        let decided = MediumStrategy {
            strategy,
            reason: self.reason(strategy, medium),
            cell_width: width(&cells.fluence),
            gather_cell_width: width(&cells.final_gathers),
            direct_cell_width,
        };
        (decided, cells)
    }

    /// Whether flights straight from the sky are recorded in grids.
    fn records_sky(&self) -> bool {
        self.evidence.direct.iter().any(Option::is_some)
    }

    /// Strategies for a medium, the best first.
    fn preferred(&self, medium: usize) -> &'static [Strategy] {
        use Strategy::{Beams, FluenceTowardEye, Moments, SharedGathers, Traced};
        match self.assignment.strategies[medium] {
            SharedGathers => &[SharedGathers, Moments, Traced],
            Moments => &[Moments, Traced],
            Traced => &[Traced],
            FluenceTowardEye => &[FluenceTowardEye, Beams],
            Beams => &[Beams],
        }
    }

    /// The cells that a strategy needs; `None` where they cannot exist.
    fn cells(&self, strategy: Strategy, index: usize) -> Option<MediumCells> {
        let medium = self.scene.media.get(index);
        let outside = is_camera_outside(self.scene, medium);
        let covering = |width, values| SparseCells::covering(&medium.density, width, values);
        let volume_photons = self.conditions.volume_photons;
        let (mut fluence, mut final_gathers) = (None, None);
        match strategy {
            Strategy::Beams => (),
            _ if !volume_photons => return None,
            Strategy::Traced => (),
            _ if self.conditions.photons == 0 => return None,
            // Such cells hold nothing toward one camera where all directions are alike.
            Strategy::FluenceTowardEye
                if self.conditions.any_camera && !medium.phase.is_isotropic() =>
            {
                return None;
            }
            Strategy::FluenceTowardEye => {
                let width = self.width(index, &self.blurred[index]);
                let width = width.filter(|_| outside || self.splits_rays(medium));
                fluence = Some(covering(width?, 1)?);
            }
            Strategy::Moments => {
                fluence = Some(covering(self.width_of_moments(index)?, FIRST_DEGREE_VALUES)?);
            }
            Strategy::SharedGathers => {
                let Conditions { film_pixels, rays, .. } = *self.conditions;
                let visible = self.evidence.visible;
                self.evidence.direct[index].filter(|_| outside)?;
                fluence = Some(covering(self.width_of_moments(index)?, FIRST_DEGREE_VALUES)?);
                final_gathers =
                    Some(final_gather_cells(self.scene, index, visible, film_pixels, rays)?);
            }
        }
        Some(MediumCells { fluence, final_gathers })
    }

    /// Whether rays from a camera in a medium can gather photons near it and read cells further away: not where
    /// grids hold the sky's straight light, which the rays would sample on the first part alone, nor where only
    /// rays that gather photons follow the peak of the phase function.
    fn splits_rays(&self, medium: &Medium) -> bool {
        let is_even = medium.phase.is_isotropic();
        is_even || !(self.records_sky() || phase_blur::is_peaked(&medium.phase))
    }

    /// Distance from the camera, in metres, within which rays gather photons in `medium`, for which so much is
    /// decided.
    fn beams_within(&self, decided: &MediumStrategy, medium: &Medium) -> f64 {
        match (decided.strategy, decided.cell_width) {
            (Strategy::Beams, _) => f64::INFINITY,
            (Strategy::FluenceTowardEye, Some(width)) if !is_camera_outside(self.scene, medium) => {
                nearest_toward_eye(width, &medium.phase)
            }
            _ => 0.0,
        }
    }

    /// Width, in metres, of cells that hold moments.
    fn width_of_moments(&self, medium: usize) -> Option<f64> {
        let width = self.width(medium, &Phase::ISOTROPIC)?;
        Some(self.evidence.moment_widening * width)
    }

    /// Width of cells, in metres: that of cells that are filled, that which is asked for, or noise-optimal for flights
    /// that `phase` weighs; `None` where more is asked for than light allows, or the medium has no end.
    fn width(&self, medium: usize, phase: &Phase) -> Option<f64> {
        if let Some(filled) = self.evidence.filled {
            return filled.get(medium).copied().flatten();
        }
        let medium = self.scene.media.get(medium);
        let most = max_fluence_width(medium, self.evidence.visible);
        let flight_length = self.evidence.flight_length;
        let suited = width_for_flights(self.scene, medium, flight_length, phase)?;
        match self.conditions.radius {
            Some(radius) => (radius <= most).then_some(radius),
            None => Some(suited.min(most)),
        }
    }

    fn reason(&self, strategy: Strategy, index: usize) -> String {
        let volume_photons = self.conditions.volume_photons;
        let reason = match strategy {
            Strategy::Beams if !volume_photons => "no photons are stored in media",
            _ if strategy == self.assignment.strategies[index] => &self.assignment.reason,
            _ => "the strategy that is asked for is not possible here",
        };
        reason.into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::WorldPoint;
    use crate::scene::FinalGather;
    use crate::strategy::direct_cells;

    const CONDITIONS: Conditions = Conditions {
        photons: 100_000,
        max_scatter: None,
        final_gather: FinalGather::Auto,
        radius: None,
        rays: 16,
        film_pixels: 1.0,
        volume_photons: true,
        any_camera: false,
    };

    /// What is chosen for a camera at this distance, where a strategy is asked for.
    fn chosen(position: f64, conditions: &Conditions, asked: Strategy) -> Choice {
        chosen_by(0.8, position, conditions, asked)
    }

    /// As [`chosen`], where the mean cosine is `g`.
    fn chosen_by(g: f64, position: f64, conditions: &Conditions, asked: Strategy) -> Choice {
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
            phase = {{ type = 'henyey-greenstein', g = {g:?} }}
            [[light]]
            type = 'environment'
            radiance = 1.0
            "
        ));
        let visible = [WorldPoint::new(0.0, 0.0, 0.9)];
        let direct = direct_cells(&scene, conditions, &visible);
        let direct: Vec<_> = direct.iter().map(|c| c.as_ref().map(|c| c.edge)).collect();
        let evidence = Evidence::new(&visible, &direct, 1e6);
        let assignment = Assignment { strategies: vec![asked], ..Assignment::default() };
        choose(&scene, conditions, &evidence, &assignment).0
    }

    #[test]
    fn cells_for_any_camera_hold_nothing_toward_one() {
        use Strategy::{Beams, FluenceTowardEye, Moments};
        let any = &Conditions { any_camera: true, ..CONDITIONS };
        let strategy = |g, asked| chosen_by(g, 6.0, any, asked).media[0].strategy;
        assert_eq!(strategy(0.8, FluenceTowardEye), Beams);
        assert_eq!(strategy(0.0, FluenceTowardEye), FluenceTowardEye);
        assert_eq!(strategy(0.8, Moments), Moments);
    }

    #[test]
    fn a_camera_within_a_medium_gathers_photons_near_it() {
        let within = |g, position| {
            let choice = chosen_by(g, position, &CONDITIONS, Strategy::FluenceTowardEye);
            let width = choice.media[0].cell_width;
            (choice.beams_within[0], width, choice.stores_photons)
        };
        let (even, Some(_), false) = within(0.0, 0.0) else { panic!("cells alone") };
        assert_eq!(even, 0.0);
        let (outside, Some(_), false) = within(0.5, 6.0) else { panic!("cells alone") };
        assert_eq!(outside, 0.0);
        let (near, Some(width), true) = within(0.5, 0.0) else { panic!("cells and photons") };
        assert!(near > width && near < 2.0 * width, "{near} of {width}");
        let (all, None, true) = within(0.9, 0.0) else { panic!("photons alone") };
        assert_eq!(all, f64::INFINITY);
    }

    #[test]
    fn what_is_asked_for_is_had_where_it_can_be() {
        use Strategy::{Beams, FluenceTowardEye, Moments, SharedGathers, Traced};
        let stored = &CONDITIONS;
        let none = &Conditions { volume_photons: false, ..CONDITIONS };
        for (position, conditions, asked, right) in [
            (6.0, stored, Beams, Beams),
            (6.0, stored, FluenceTowardEye, FluenceTowardEye),
            (0.0, stored, FluenceTowardEye, Beams),
            (6.0, stored, SharedGathers, SharedGathers),
            (0.0, stored, SharedGathers, Moments),
            (0.0, stored, Moments, Moments),
            (0.0, stored, Traced, Traced),
            (6.0, none, Moments, Beams),
        ] {
            let choice = chosen(position, conditions, asked);
            let [medium] = &choice.media[..] else { panic!("one medium") };
            assert_eq!(medium.strategy, right, "{asked:?} at {position}: {}", medium.reason);
            let has_cells = !matches!(right, Beams | Traced);
            assert_eq!(medium.cell_width.is_some(), has_cells, "{right:?}");
            assert_eq!(medium.gather_cell_width.is_some(), right == SharedGathers);
        }
    }
}
