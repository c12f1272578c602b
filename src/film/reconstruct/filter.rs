//! The filter: what all light of a picture decides, and what parts of it are filtered by too.

use super::levels::{Candidate, OutlierFactors};
use super::light::{FilteredComponents, FilteredLight, LightOf};
use super::media;
use super::scale::{self, Selected};
use super::surfaces::{self, SurfaceFeatures};
use crate::film::components::ComponentFilm;

/// How one component is filtered.
#[derive(Debug)]
struct ComponentFilter {
    outliers: OutlierFactors,
    /// The level of each pixel.
    levels: Vec<f32>,
}

/// How the components of a picture are filtered. Each is filtered by sums with weights that do not change with the light that
/// they are applied to, so that parts of a picture's light add up to it afterwards, too.
#[derive(Debug)]
pub(super) struct Filter {
    media: ComponentFilter,
    direct: ComponentFilter,
    indirect: ComponentFilter,
}

impl Filter {
    /// That of `film`, whose pixels see `surfaces`, and all light that it filters.
    pub fn new(
        film: &ComponentFilm,
        surfaces: &[Option<SurfaceFeatures>],
    ) -> (Self, FilteredLight) {
        let all = |pixel: usize| film.pixels[pixel].light();
        let select = |candidates: &[Candidate]| {
            let levels = scale::best_levels(film.width, candidates);
            let selected = scale::select(candidates, &levels);
            (levels, selected)
        };
        let outliers = media::outliers(film);
        let (levels, of_media) = select(&media::candidates(film, &all, &outliers));
        let media = ComponentFilter { outliers, levels };
        let outliers = surfaces::outliers(film);
        let candidates = surfaces::candidates(film, surfaces, &all, outliers.each_ref());
        let [direct, indirect] = candidates.map(|candidates| select(&candidates));
        let [outliers_direct, outliers_indirect] = outliers;
        let filter = Self {
            media,
            direct: ComponentFilter { outliers: outliers_direct, levels: direct.0 },
            indirect: ComponentFilter { outliers: outliers_indirect, levels: indirect.0 },
        };
        (filter, filtered(of_media, direct.1, indirect.1))
    }

    /// A part of the `light` of the same film.
    pub fn apply(
        &self,
        film: &ComponentFilm,
        surfaces: &[Option<SurfaceFeatures>],
        light: LightOf<'_>,
    ) -> FilteredLight {
        let Self { media, direct, indirect } = self;
        let of_media = media::candidates(film, light, &media.outliers);
        let of_media = scale::select(&of_media, &media.levels);
        let outliers = [&direct.outliers, &indirect.outliers];
        let [of_direct, of_indirect] = surfaces::candidates(film, surfaces, light, outliers);
        let [of_direct, of_indirect] = [(of_direct, direct), (of_indirect, indirect)]
            .map(|(candidates, component)| scale::select(&candidates, &component.levels));
        filtered(of_media, of_direct, of_indirect)
    }
}

/// Light of these components.
fn filtered(media: Selected, direct: Selected, indirect: Selected) -> FilteredLight {
    let [media_a, media_b] = media.halves;
    let [direct_a, direct_b] = direct.halves;
    let [indirect_a, indirect_b] = indirect.halves;
    let components = |media, direct, indirect| FilteredComponents { media, direct, indirect };
    FilteredLight {
        mean: components(media.mean, direct.mean, indirect.mean),
        halves: [
            components(media_a, direct_a, indirect_a),
            components(media_b, direct_b, indirect_b),
        ],
    }
}
