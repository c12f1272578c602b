//! Pictures that are not finished, and where they go.

use std::path::Path;

use super::output::Output;
use crate::image::{png_path_beside, read_attributes};

/// Says in the header of a picture, only where it is not finished, that it is not.
pub(super) const COMPLETE: &str = "fogbow:complete";

/// Where a picture goes that was interrupted: to its own place, unless a finished picture is there;
/// then beside it, as `.partial.exr`.
pub(super) fn place(output: &Output) -> Output {
    if !output.exr.exists() || is_partial(&output.exr) {
        return Output { exr: output.exr.clone(), png: output.png.clone() };
    }
    beside(output)
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
    let attributes = read_attributes(exr).unwrap_or_default();
    attributes.get(COMPLETE).is_some_and(|complete| complete == "false")
}
