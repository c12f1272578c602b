//! What the choice of strategies depends on, and what a report says of it.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::measured::Measured;
use crate::math::WorldPoint;
use crate::scene::{FinalGather, Strategy};

/// The estimator for rays whose light is not scattered toward the camera, as behind a mirror: what
/// caches toward the camera hold does not apply to them.
#[must_use]
pub const fn away_from_camera(strategy: Strategy) -> Strategy {
    match strategy {
        Strategy::FluenceTowardEye => Strategy::Beams,
        other => unshared(other),
    }
}

/// The strategy with its final gathers shared, where it makes any that end at moments.
#[must_use]
pub const fn shared(strategy: Strategy) -> Strategy {
    match strategy {
        Strategy::Moments => Strategy::SharedGathers,
        other => other,
    }
}

/// The strategy whose gathers no rays share.
#[must_use]
pub const fn unshared(strategy: Strategy) -> Strategy {
    match strategy {
        Strategy::SharedGathers => Strategy::Moments,
        other => other,
    }
}

/// The strategy in words, for a table.
const fn about(strategy: Strategy) -> &'static str {
    match strategy {
        Strategy::Beams => "photon beams gathered along rays",
        Strategy::FluenceTowardEye => "light scattered toward the camera, cached on a grid",
        Strategy::Moments => "a final gather a ray, ended by moments on a grid",
        Strategy::SharedGathers => "final gathers cached on a grid, ended by moments",
        Strategy::Traced => "paths traced on from rays, without photons",
    }
}

/// What the choice depends on beside the scene.
#[derive(Debug, Clone, Copy)]
pub struct Conditions {
    /// Photon paths.
    pub photons: u64,
    /// Highest order of volume scattering in the picture; `None` means all.
    pub max_scatter: Option<u32>,
    /// Whether final gathers may be chosen.
    pub final_gather: FinalGather,
    /// Gather radius and cell width in metres, where one is given.
    pub radius: Option<f64>,
    /// Rays a pixel, at most.
    pub rays: u32,
    /// Pixels of the film, along each side, that one pixel of the picture covers.
    pub film_pixels: f64,
    /// Whether photons are stored in media at all.
    pub volume_photons: bool,
    /// Whether photons and the grids that they fill serve any camera.
    pub any_camera: bool,
}

/// What the camera and a pilot of the photons tell of a scene.
#[derive(Debug, Clone, Copy)]
pub struct Evidence<'a> {
    /// Places in media that the camera sees.
    pub visible: &'a [WorldPoint],
    /// Width in metres of each medium's cells of direct light, where that is cached.
    pub direct: &'a [Option<f64>],
    /// Length of all flights of photons together, in metres.
    pub flight_length: f64,
    /// Width of cells of moments over that which suits those flights.
    pub moment_widening: f64,
    /// Width in metres of the cells of each medium's grid, where that was filled before; `None` where none was.
    pub filled: Option<&'a [Option<f64>]>,
}

impl<'a> Evidence<'a> {
    /// With cells that are as wide as suits the flights.
    pub const fn new(
        visible: &'a [WorldPoint],
        direct: &'a [Option<f64>],
        flight_length: f64,
    ) -> Self {
        Self { visible, direct, flight_length, moment_widening: 1.0, filled: None }
    }
}

/// A strategy for each medium, and why.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Assignment {
    /// The strategies, in the scene's order of media.
    pub strategies: Vec<Strategy>,
    /// Why, as one sentence.
    pub reason: String,
    /// What a pilot measured of each assignment; empty where it did not measure.
    pub measured: Vec<Measured>,
    /// Bytes that the pilot took, which are freed again.
    pub pilot_bytes: u64,
}

impl Assignment {
    /// One strategy for all `media`, which are so many.
    pub fn uniform(strategy: Strategy, media: usize, reason: &str) -> Self {
        let strategies = vec![strategy; media];
        Self { strategies, reason: reason.into(), ..Self::default() }
    }
}

/// The strategy of one medium, for estimators and reports.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MediumStrategy {
    /// The estimator.
    pub strategy: Strategy,
    /// Why, as one sentence.
    pub reason: String,
    /// Width of the grid's cells in metres; `None` for beams, whose radii vary, and for traced paths.
    pub cell_width: Option<f64>,
    /// Width of the cells of shared gathers in metres, where those are.
    pub gather_cell_width: Option<f64>,
    /// Width of the cells of direct light in metres, where that is cached.
    pub direct_cell_width: Option<f64>,
}

impl fmt::Display for MediumStrategy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(about(self.strategy))?;
        let widths = [
            ("cells", self.cell_width),
            ("gathers' cells", self.gather_cell_width),
            ("direct light's cells", self.direct_cell_width),
        ];
        let mut widths = widths.iter().filter_map(|(name, width)| Some((name, (*width)?)));
        widths.try_for_each(|(name, width)| write!(f, ", {name} {width:.3} m wide"))?;
        write!(f, ": {}", self.reason)
    }
}

/// How light in media was estimated, for reports.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Each medium's strategy, in the scene's order; empty where no medium needs photons.
    pub media: Vec<MediumStrategy>,
    /// What a pilot measured of each assignment that was possible.
    #[serde(default)]
    pub measured: Vec<Measured>,
}

impl Summary {
    /// One line for each medium and for each assignment that was measured, or one that says that no medium
    /// needs photons.
    pub fn lines(&self) -> Vec<String> {
        if self.media.is_empty() {
            return vec!["no photons are needed in media".into()];
        }
        let media = (1..).zip(&self.media);
        let media = media.map(|(number, medium)| format!("medium {number}: {medium}"));
        media
            .chain(self.measured.iter().map(|assignment| format!("measured: {assignment}")))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_summary_names_estimator_widths_and_reason() {
        let medium = MediumStrategy {
            strategy: Strategy::SharedGathers,
            reason: "it is so".into(),
            cell_width: Some(0.25),
            gather_cell_width: Some(0.0625),
            direct_cell_width: None,
        };
        let summary = Summary { media: vec![medium], measured: Vec::new() };
        let [medium] = &summary.lines()[..] else { panic!("one line") };
        assert!(medium.starts_with("medium 1: final gathers"), "{medium}");
        assert!(
            medium.ends_with("cells 0.250 m wide, gathers' cells 0.062 m wide: it is so"),
            "{medium}"
        );
        let json = serde_json::to_value(&summary).unwrap();
        assert_eq!(json["media"][0]["strategy"], "shared-gathers");
        assert_eq!(serde_json::from_value::<Summary>(json).unwrap(), summary);
    }
}
