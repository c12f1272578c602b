//! The report on a picture: what `--json` prints.

use std::time::Duration;

use serde_json::{Map, Value, json};

use super::load::Preparation;
use crate::image::Denoiser;
use crate::render::Rendered;
use crate::scene::Scene;

/// Times of the stages around a render.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seconds {
    /// Times of the stages before it.
    pub(super) preparation: Preparation,
    /// Time to fit photons to the limits.
    pub(super) fitting: Duration,
    /// Time to write the files, where they are written.
    pub(super) writing: Option<Duration>,
}

/// The report on a picture of `scene` that was rendered under `settings`.
pub(super) fn report(
    scene: &Scene,
    rendered: &Rendered,
    settings: Map<String, Value>,
    stages: &Seconds,
    warnings: &[String],
) -> Value {
    let mut report = json!({
        "settings": settings,
        "complete": rendered.is_complete(),
        "seconds": seconds(stages, rendered),
        "work": rendered.work,
        "peak_memory": null,
        "warnings": warnings,
        "notes": scene.notes,
        "outputs": null,
    });
    if let Some(strategy) = &rendered.strategy {
        report["strategy"] = json!(strategy);
    }
    if let Some(directed) = rendered.director {
        report["director"] = json!(directed);
    }
    report
}

/// Version and place of a denoiser.
pub(super) fn about(denoiser: &Denoiser) -> Value {
    json!({ "version": denoiser.version(), "path": denoiser.path() })
}

/// Seconds of each stage.
fn seconds(stages: &Seconds, rendered: &Rendered) -> Map<String, Value> {
    let Seconds { preparation, fitting, writing } = *stages;
    let stages = rendered.timings.iter().map(|(name, time)| (*name, *time));
    let metering = preparation.metering.map(|time| ("meter", time));
    std::iter::once(("load", preparation.loading))
        .chain(metering)
        .chain([("fit", fitting)])
        .chain(stages)
        .chain(writing.map(|time| ("write", time)))
        .map(|(name, time)| (name.to_owned(), json!(time.as_secs_f64())))
        .collect()
}
