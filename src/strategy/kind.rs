//! The strategies, what their choice depends on, and what a report says of it.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::scene::FinalGather;

/// Estimator of the light that a medium scatters after it was scattered, reflected or emitted before.
/// Light that is scattered once comes from sampling lights, or from a cache of that.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Strategy {
    /// The beam radiance estimate: photons are gathered along each ray (Jarosz, Zwicker and Jensen
    /// 2008). The only one for a camera inside of a medium.
    Beams,
    /// Flights of photons leave the light that they scatter toward the camera on a sparse grid, which
    /// rays read by trilinear interpolation.
    FluenceTowardEye,
    /// Flights leave moments of radiance on a sparse grid. Each ray makes a final gather (Jensen 1996)
    /// that is scattered on until those moments tell the rest.
    Moments,
    /// As [`Moments`](Self::Moments), with final gathers that start in cells and are shared by all
    /// rays that read those (Keller, Dahm and Binder 2014, "Path Space Filtering").
    SharedGathers,
}

impl Strategy {
    /// The estimator for rays whose light is not scattered toward the camera, as behind a mirror:
    /// what caches toward the camera hold does not apply to them.
    #[must_use]
    pub const fn away_from_camera(self) -> Self {
        match self {
            Self::FluenceTowardEye => Self::Beams,
            Self::SharedGathers => Self::Moments,
            Self::Beams | Self::Moments => self,
        }
    }

    /// In words, for a table.
    pub const fn about(self) -> &'static str {
        match self {
            Self::Beams => "photon beams gathered along rays",
            Self::FluenceTowardEye => "light scattered toward the camera, cached on a grid",
            Self::Moments => "a final gather a ray, ended by moments on a grid",
            Self::SharedGathers => "final gathers cached on a grid, ended by moments",
        }
    }
}

/// What the choice depends on beside the scene.
#[derive(Debug, Clone, Copy)]
pub struct Conditions {
    /// Photon paths.
    pub photons: u64,
    /// Highest order of volume scattering in the picture; `None` means all.
    pub max_scatter: Option<u32>,
    /// Whether final gathers are forced, forbidden or chosen.
    pub final_gather: FinalGather,
    /// Whether the picture is denoised.
    pub denoise: bool,
    /// Gather radius and cell width in metres, where one is given.
    pub radius: Option<f64>,
    /// Rays a pixel, at most.
    pub rays: u32,
    /// Pixels of the film, along each side, that one pixel of the picture covers.
    pub film_pixels: f64,
    /// Whether photons are stored in media at all.
    pub volume_photons: bool,
}

/// The strategy of one medium, for reports.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MediumStrategy {
    /// The estimator.
    pub strategy: Strategy,
    /// Width of the grid's cells in metres; `None` for beams, whose radii vary.
    pub cell_width: Option<f64>,
    /// Width of the cells of shared gathers in metres, where those are.
    pub gather_cell_width: Option<f64>,
    /// Width of the cells of direct light in metres, where that is cached.
    pub direct_cell_width: Option<f64>,
}

impl fmt::Display for MediumStrategy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.strategy.about())?;
        let widths = [
            ("cells", self.cell_width),
            ("gathers' cells", self.gather_cell_width),
            ("direct light's cells", self.direct_cell_width),
        ];
        let mut widths = widths.iter().filter_map(|(name, width)| Some((name, (*width)?)));
        widths.try_for_each(|(name, width)| write!(f, ", {name} {width:.3} m wide"))
    }
}

/// How light in media was estimated, for reports.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Why, as one sentence.
    pub reason: String,
    /// Each medium's strategy, in the scene's order.
    pub media: Vec<MediumStrategy>,
}

impl Summary {
    /// One line for each medium, then the reason; the reason alone where no medium needs photons.
    pub fn lines(&self) -> Vec<String> {
        let medium =
            |(index, medium): (usize, &MediumStrategy)| format!("medium {}: {medium}", index + 1);
        let media = self.media.iter().enumerate().map(medium);
        media.chain([format!("reason: {}", self.reason)]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_summary_names_estimator_widths_and_reason() {
        let medium = MediumStrategy {
            strategy: Strategy::SharedGathers,
            cell_width: Some(0.25),
            gather_cell_width: Some(0.0625),
            direct_cell_width: None,
        };
        let summary = Summary { reason: "it is so".into(), media: vec![medium] };
        let [medium, reason] = &summary.lines()[..] else { panic!("two lines") };
        assert!(medium.starts_with("medium 1: final gathers"), "{medium}");
        assert!(medium.ends_with("cells 0.250 m wide, gathers' cells 0.062 m wide"), "{medium}");
        assert_eq!(reason, "reason: it is so");
        let json = serde_json::to_value(&summary).unwrap();
        assert_eq!(json["media"][0]["strategy"], "shared-gathers");
        assert_eq!(serde_json::from_value::<Summary>(json).unwrap(), summary);
    }
}
