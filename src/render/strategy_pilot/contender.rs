//! The assignments of strategies that a pilot measures.

use crate::medium::SparseCells;
use crate::render::pass_settings::PassSettings;
use crate::scene::Scene;
use crate::strategy::{
    self, Assignment, Choice, Evidence, MediumCells, Strategy, VarianceScale, shared,
};
use crate::work::Work;

/// Width of the pilot's cells of moments over that which suits its photons: the gathers of a pixel end in
/// cells everywhere, so that wider ones change the photons' noise that they share little, and are fewer.
const WIDENING: f64 = 2.0;

/// An assignment of strategies that the pilot measures.
pub struct Contender {
    pub choice: Choice,
    /// The same with gathers shared, and their cells, where it makes gathers that can be.
    pub shared: Option<(Choice, Vec<Option<SparseCells>>)>,
    /// From variances of the pilot to those of the picture.
    pub scale: VarianceScale,
    /// Flights through cells, each with every value that a cell holds, for all photons.
    crossings: f64,
    /// Photons that a gather of the picture meets for each that one of the pilot meets.
    pub gathered: f64,
}

impl Contender {
    /// As `self`, where the photons of a half have kernels of the first of these radii and all photons those
    /// of the second, in metres.
    pub fn with_kernels(
        mut self,
        scene: &Scene,
        settings: &PassSettings,
        evidence: &Evidence<'_>,
        [pilot, all]: [f64; 2],
    ) -> Self {
        let narrower = all / pilot;
        if self.choice.stores_photons {
            self.gathered *= narrower.powi(2);
        }
        if self.has_beams() {
            let noise = [all, pilot].map(|radius| {
                strategy::noise_of_kernels(scene, &settings.conditions(), evidence.visible, radius)
            });
            let scale = &mut self.scale;
            scale.shared *= noise[0] / noise[1];
            scale.of_rays /= narrower.powi(2);
        }
        self
    }

    /// The strategy of each medium.
    pub fn strategies(&self) -> Vec<Strategy> {
        self.choice.media.iter().map(|medium| medium.strategy).collect()
    }

    /// Whether rays gather photons in a medium.
    pub fn has_beams(&self) -> bool {
        self.choice.media.iter().any(|medium| medium.strategy == Strategy::Beams)
    }

    /// Whether gathers end at moments, so that they can be shared.
    pub fn has_moments(&self) -> bool {
        self.choice.media.iter().any(|medium| medium.strategy.holds_moments())
    }

    /// Whether rays read cells as narrow as the picture's, in which the pilot's photons have much noise.
    pub fn has_sharp_cells(&self) -> bool {
        self.choice.media.iter().any(|medium| medium.strategy == Strategy::FluenceTowardEye)
    }

    /// Whether anything depends on photons.
    pub fn reads_photons(&self, settings: &PassSettings) -> bool {
        let has_cells = self.choice.media.iter().any(|medium| medium.cell_width.is_some());
        self.choice.stores_photons || has_cells || settings.photons.needs.surface_photons
    }

    /// Cost of the photons of a render, in nanoseconds of a typical core, by the work of a half whose paths
    /// each represent so many; none where nothing depends on photons.
    pub fn photon_cost(&self, settings: &PassSettings, shot: &Work, represents: f64) -> f64 {
        if !self.reads_photons(settings) {
            return 0.0;
        }
        let in_media = if self.choice.stores_photons { shot.volume_photons } else { 0 };
        let stored = represents * (in_media + shot.surface_photons) as f64;
        represents * strategy::cost(shot, 1.0)
            + strategy::cost_of_storing(stored)
            + strategy::cost_of_crossings(self.crossings)
    }
}

/// What contenders are made of.
pub struct Contenders<'a> {
    pub scene: &'a Scene,
    pub settings: &'a PassSettings,
    pub evidence: &'a Evidence<'a>,
    /// Paths of the render for each path of a half.
    pub represents: f64,
}

impl Contenders<'_> {
    /// Assignments that differ, with their cells in the pilot.
    pub fn all(&self) -> Vec<(Contender, Vec<MediumCells>)> {
        let conditions = self.settings.conditions();
        let evidence = Evidence { moment_widening: self.widening(), ..*self.evidence };
        let mut contenders: Vec<(Contender, Vec<MediumCells>)> = Vec::new();
        for strategies in strategy::assignments(self.scene, &conditions) {
            let assignment = Assignment { strategies, ..Assignment::default() };
            let (choice, cells) = strategy::choose(self.scene, &conditions, &evidence, &assignment);
            let Some(contender) = self.contender(choice) else { continue };
            let strategies = contender.strategies();
            let contender = Contender { shared: self.shared(&strategies), ..contender };
            if contenders.iter().all(|(other, _)| other.strategies() != strategies) {
                contenders.push((contender, cells));
            }
        }
        contenders
    }

    /// Width of the pilot's cells of moments over that of the picture's.
    fn widening(&self) -> f64 {
        WIDENING * strategy::width_for_photons(1.0 / self.represents)
    }

    /// The choice with the gathers of these strategies shared, and their cells; `None` where that is not
    /// possible in each medium that has gathers.
    fn shared(&self, strategies: &[Strategy]) -> Option<(Choice, Vec<Option<SparseCells>>)> {
        let conditions = self.settings.conditions();
        let strategies: Vec<Strategy> = strategies.iter().map(|s| shared(*s)).collect();
        let assignment = Assignment { strategies, ..Assignment::default() };
        let (choice, cells) = strategy::choose(self.scene, &conditions, self.evidence, &assignment);
        let is_had = choice.media.iter().map(|medium| medium.strategy).eq(assignment.strategies);
        let has_any = cells.iter().any(|cells| cells.final_gathers.is_some());
        let cells = cells.into_iter().map(|cells| cells.final_gathers).collect();
        (is_had && has_any).then_some((choice, cells))
    }

    /// A contender with its factors from the pilot's photons to the render's; `None` where the render's cells,
    /// which may be narrower, are too many.
    fn contender(&self, choice: Choice) -> Option<Contender> {
        let conditions = self.settings.conditions();
        let mut crossings = 0.0;
        for (index, medium) in choice.media.iter().enumerate() {
            if medium.cell_width.is_none() {
                continue;
            }
            let (strategy, evidence) = (medium.strategy, self.evidence);
            let width = strategy::cell_width(self.scene, &conditions, evidence, index, strategy)?;
            let values = match strategy {
                Strategy::FluenceTowardEye => 1.0,
                _ => choice.termination.values(index) as f64,
            };
            // The mean chord of a cube is 2/3 of its edge.
            crossings += 3.0 / 2.0 * values * evidence.flight_length / width;
        }
        let shared = 1.0 / self.represents;
        let mut of_rays = shared;
        if choice.media.iter().any(|medium| medium.strategy.holds_moments()) {
            // The noise of the single cell that a gather reads.
            of_rays *= self.widening().powi(2);
        }
        let scale = VarianceScale { shared, of_rays };
        Some(Contender { choice, shared: None, scale, crossings, gathered: self.represents })
    }
}
