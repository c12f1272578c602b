//! The first look at a picture: without photons, in a moment, and before its exposure is metered.

use std::time::Duration;

use super::header;
use super::limit_args::checkpoint_path;
use super::partial;
use super::picture::PictureJob;
use super::progress::Console;
use crate::image::View;
use crate::render::{self, Control, Deadline};
use crate::scene::Scene;

/// Time of a first look: with writing it, what somebody who waits for a picture hardly notices.
const TIME: Duration = Duration::from_millis(500);

/// Shows a first look at `scene` where somebody looks, and writes it with `--preview`, unless a checkpoint holds more. An
/// open exposure is metered in the look itself. Where it cannot be written, the next preview says why.
pub(super) fn show(scene: &Scene, job: &PictureJob<'_>) {
    let PictureJob { output, live, limits, method, clock, .. } = *job;
    let resumes = limits.resume && checkpoint_path(&output.exr).exists();
    let writes = limits.preview.is_some() && !resumes;
    if !writes && live.every().is_none() {
        return;
    }
    let deadline = Deadline { clock, at: clock.elapsed() + TIME };
    let control = Control { deadline: Some(deadline), ..Control::silent() };
    let look = render::preview(scene, &scene.render, control);
    let metered = || render::metered(scene, &look.film);
    let exposure = scene.film.exposure.unwrap_or_else(metered);
    let view = View { exposure, ..scene.film.shown() };
    if writes {
        let settings = header::settings(scene, None, method.reference, scene.render.photons);
        let mut named = header::attributes(scene, &settings, &look);
        named.push((partial::PREVIEW.into(), "true".into()));
        let _ = partial::place(output).write(&view, &look, scene.film.half, &named);
    }
    live.begin(&output.exr, view, Console::new(clock.clone(), true).watch());
    live.show(&output.exr, look.film);
}
