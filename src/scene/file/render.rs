//! `[film]` and `[render]`.

use crate::error::Result;
use crate::image::ViewTransform;
use crate::scene::aov::{Aov, Aovs};
use crate::scene::directing::{Directing, Director};
use crate::scene::keys::{film as film_keys, render as keys};
use crate::scene::reader::Section;
use crate::scene::settings::{
    ErrorGoal, FilmSettings, FinalGather, Planning, RenderSettings, StrategyRequest,
};

/// Reads the table `[film]`.
pub(super) fn film(section: &Section<'_>) -> Result<FilmSettings> {
    section.only(&film_keys::FILM)?;
    let passes: Option<Aovs> = section.maybe(&film_keys::PASSES, |v| {
        v.string(&film_keys::PASSES.kind.right())?.parse().map_err(|e: String| v.error(e))
    })?;
    let deep = section.switch(&film_keys::DEEP)?;
    // A deep picture is made of it.
    let media = deep.then_some(Aov::Media);
    Ok(FilmSettings {
        size: section.size(&film_keys::SIZE)?,
        exposure: section
            .read(&film_keys::EXPOSURE, |v| v.number_or_of(&film_keys::EXPOSURE.kind))?,
        view: section.word(
            &film_keys::VIEW,
            &[("agx", ViewTransform::Agx), ("srgb", ViewTransform::Srgb)],
        )?,
        passes: passes.unwrap_or_default().iter().chain(media).collect(),
        half: section.switch(&film_keys::HALF)?,
        deep,
    })
}

/// Reads the table `[render]`; `directing` is what `[director]` says.
pub(super) fn render(section: &Section<'_>, directing: Directing) -> Result<RenderSettings> {
    section.only(&keys::RENDER)?;
    if section.switch(&keys::DENOISE)? && section.switch(&keys::RECONSTRUCT)? {
        section.at_most_one(&[&keys::DENOISE, &keys::RECONSTRUCT])?;
    }
    let error = section.maybe(&keys::ERROR, |v| v.number_or_of(&keys::ERROR.kind))?;
    let director = section.word(&keys::DIRECTOR, Director::ALL)?;
    if let Some(value) = section.get(&keys::ERROR).filter(|_| director != Director::Fixed) {
        return Err(value.error(format!(
            "with an error as the goal all pixels have the same rays; leave out `director = \"{}\"` or the error",
            director.name()
        )));
    }
    let max_scatter = section.maybe_whole(&keys::MAX_ORDER)?.map(|orders| orders as u32);
    let strategy = section.word(&keys::STRATEGY, StrategyRequest::ALL)?;
    if let (StrategyRequest::Asked(asked), Some(2..)) = (strategy, max_scatter)
        && asked.makes_gathers()
        && let Some(value) = section.get(&keys::STRATEGY)
    {
        return Err(value.error(format!(
            "`{}` does not count orders of scattering; leave out `max_scatter`, or take `beams` or \
             `fluence-toward-eye`",
            asked.name()
        )));
    }
    Ok(RenderSettings {
        rays: section.whole(&keys::RAYS)? as u32,
        photons: section.whole(&keys::PHOTONS)?,
        radius: section.maybe_number(&keys::RADIUS)?,
        step: section.maybe_number(&keys::STEP)?,
        director,
        directing,
        seed: section.whole(&keys::SEED)?,
        max_scatter,
        strategy,
        final_gather: section.word(&keys::FINAL_GATHER, FinalGather::ALL)?,
        denoise: section.switch(&keys::DENOISE)?,
        reconstruct: section.switch(&keys::RECONSTRUCT)?,
        error: error.map(|number| number.map_or(ErrorGoal::Visible, ErrorGoal::Relative)),
        planning: Planning::Needed,
        crop: None,
        pass: None,
        saved_photons: None,
    })
}
