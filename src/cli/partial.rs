//! Unfinished pictures and previews: where they are written, so that no finished one is lost.

use std::path::Path;

use super::output::Output;
use crate::image::read_attributes;
use crate::render::Rendered;

/// The attribute of an unfinished picture; finished ones lack it.
pub(super) const COMPLETE: &str = "fogbow:complete";

/// The attribute of a preview.
pub(super) const PREVIEW: &str = "fogbow:preview";

/// The files of an interrupted picture: its own, or where a finished picture is there, beside it with
/// `.partial.exr`.
pub(super) fn place(output: &Output) -> Output {
    if !output.exr.exists() || is_partial(&output.exr) {
        return output.clone();
    }
    beside(output)
}

/// The files of a preview: its own, or those beside it; `None` where other pictures are at both.
pub(super) fn place_preview(output: &Output) -> Option<Output> {
    let is_free = |place: &Output| !place.exr.exists() || says(&place.exr, PREVIEW, "true");
    [output.clone(), beside(output)].into_iter().find(is_free)
}

/// Removes the unfinished picture that an interrupted render may have left beside the finished one.
pub(super) fn clear(output: &Output) {
    let partial = beside(output);
    if is_partial(&partial.exr) {
        // Left behind, it would do no harm.
        let _ = std::fs::remove_file(&partial.exr);
        let _ = std::fs::remove_file(&partial.png);
    }
}

/// The share of its rays that an unfinished picture has.
pub(super) fn share(rendered: &Rendered) -> String {
    let rays = rendered.film.layer("rays").unwrap_or_default();
    let share = format!("{:.1} % of its rays", rendered.percent());
    match rays.iter().filter(|rays| **rays == 0.0).count() {
        0 => share,
        bare => format!(
            "{share}, and {bare} of {} pixels have none yet and show what is beside them",
            rays.len()
        ),
    }
}

fn beside(output: &Output) -> Output {
    Output::at(output.exr.with_extension("partial.exr"))
}

fn is_partial(exr: &Path) -> bool {
    says(exr, COMPLETE, "false")
}

fn says(exr: &Path, attribute: &str, value: &str) -> bool {
    let attributes = read_attributes(exr).unwrap_or_default();
    attributes.get(attribute).is_some_and(|known| known == value)
}
