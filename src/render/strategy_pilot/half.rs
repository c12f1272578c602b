//! The photons of one half of a strategy pilot.

use crate::cache::{FluenceBuilder, FluenceGrid};
use crate::math::{Aabb, Spectrum};
use crate::photon::{AimedPhotons, PathSample, PhotonDirection, PhotonMaps, Recording, ShotPart};
use crate::render::pass_settings::fluence_builders;
use crate::scene::Scene;
use crate::strategy::MediumCells;
use crate::transport::FlightSegment;
use crate::work::Work;

use super::contender::Contender;

/// Photons and what they fill.
pub struct Half<S: Spectrum, H: PhotonDirection> {
    pub maps: PhotonMaps<S, H>,
    /// Grids of each contender.
    pub fluence: Vec<Vec<Option<FluenceGrid<S>>>>,
    pub work: Work,
    /// Gather radius in metres that is typical of all photons.
    pub radius_of_all: f64,
}

impl<S: Spectrum, H: PhotonDirection> Half<S, H> {
    /// Shoots the photons of `part`, with what all `contenders` need in their `cells`.
    pub fn shoot<'a>(
        scene: &'a Scene,
        aimed: &mut AimedPhotons<'a>,
        contenders: &[Contender],
        cells: &[Vec<MediumCells>],
        part: &PathSample,
    ) -> Self {
        let (origin, unit) = (aimed.origin(), aimed.flight_unit() * part.represents);
        let mut builders: Vec<Vec<Option<FluenceBuilder<'_, S>>>> = Vec::new();
        for (contender, cells) in contenders.iter().zip(cells) {
            let cells = cells.iter().map(|cells| cells.fluence.clone()).collect();
            // What the camera sees of cells is of little account for their variance.
            builders.push(fluence_builders(scene, &contender.choice, cells, &[], origin));
        }
        let bounds = builders.iter().flatten().flatten().map(FluenceBuilder::bounds);
        let phases: Vec<_> = contenders[0].choice.splits.iter().map(|split| split.phase).collect();
        let recording = Recording {
            volume_photons: contenders.iter().any(|contender| contender.choice.stores_photons),
            flight_bounds: bounds.reduce(Aabb::union),
            flights: &mut |segments: &[&[FlightSegment<S>]]| {
                builders.iter_mut().flatten().flatten().for_each(|builder| builder.add(segments));
            },
        };
        let ShotPart { maps, work, radius_of_all } =
            aimed.shoot::<S, H>(recording, &phases, part, &|_| ());
        let finish = |builder: FluenceBuilder<'_, S>| builder.finish(part.levels, unit);
        let fluence = builders
            .into_iter()
            .map(|own| own.into_iter().map(|builder| builder.map(finish)).collect())
            .collect();
        Self { maps, fluence, work, radius_of_all }
    }
}
