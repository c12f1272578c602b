//! Pictures that are not finished, and where they go.

use std::path::Path;

use super::output::Output;
use crate::image::{png_path_beside, read_attributes};

/// Says in the header of a picture, only where it is not finished, that it is not.
pub(super) const COMPLETE: &str = "fogbow:complete";

/// Says in the header of a picture that it is a first look, without photons.
pub(super) const PREVIEW: &str = "fogbow:preview";

/// Where a picture goes that was interrupted: to its own place, unless a finished picture is there;
/// then beside it, as `.partial.exr`.
pub(super) fn place(output: &Output) -> Output {
    if !output.exr.exists() || is_partial(&output.exr) {
        return Output { exr: output.exr.clone(), png: output.png.clone() };
    }
    beside(output)
}

/// Where a first look goes: to its own place, or beside it; nowhere if other pictures are at both.
pub(super) fn place_preview(output: &Output) -> Option<Output> {
    let is_free = |place: &Output| !place.exr.exists() || says(&place.exr, PREVIEW, "true");
    [output.clone(), beside(output)].into_iter().find(is_free)
}

/// Removes the unfinished picture that an interrupted render may have left beside the finished one.
pub(super) fn clear(output: &Output) {
    let partial = beside(output);
    if is_partial(&partial.exr) {
        // It is of no more use, but does no harm either.
        let _ = std::fs::remove_file(&partial.exr);
        let _ = std::fs::remove_file(&partial.png);
    }
}

fn beside(output: &Output) -> Output {
    let exr = output.exr.with_extension("partial.exr");
    let png = png_path_beside(&exr);
    Output { exr, png }
}

fn is_partial(exr: &Path) -> bool {
    says(exr, COMPLETE, "false")
}

fn says(exr: &Path, attribute: &str, value: &str) -> bool {
    let attributes = read_attributes(exr).unwrap_or_default();
    attributes.get(attribute).is_some_and(|known| known == value)
}
