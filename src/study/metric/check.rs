//! What must hold before two pictures are compared.

use std::path::Path;

use super::Options;
use crate::error::{Error, Result};
use crate::image::Image;

/// The most stops either way that pictures are exposed by.
const MAX_STOPS: f64 = 100.0;

/// Checks that a reference and a test, each with the name that messages give it, can be compared.
///
/// # Errors
/// Where they differ in size or hold a value that is not finite.
pub fn check_pair(reference: (&Image, &Path), test: (&Image, &Path)) -> Result<()> {
    let size = |image: &Image| (image.width(), image.height());
    let ((width, height), (across, down)) = (size(reference.0), size(test.0));
    if (width, height) != (across, down) {
        return Err(Error::file(
            test.1,
            format!(
                "has {across} x {down} pixels and {} has {width} x {height}; both must have the \
                 same size",
                reference.1.display()
            ),
        ));
    }
    reference.0.check_finite(reference.1)?;
    test.0.check_finite(test.1)
}

/// Checks the ranges of options.
///
/// # Errors
/// Where one is out of range.
pub(super) fn check_options(options: &Options) -> Result<()> {
    options.display.check()?;
    if options.exposure.is_nan() || options.exposure.abs() > MAX_STOPS {
        return Err(Error::Usage(format!(
            "an exposure of {} stops; give -{MAX_STOPS} to {MAX_STOPS}",
            options.exposure
        )));
    }
    let positive = |what: &str, value: f64| {
        if value.is_finite() && value > 0.0 {
            return Ok(());
        }
        Err(Error::Usage(format!("{what} is {value}; give a number above 0")))
    };
    positive("epsilon of the relative error", options.epsilon.unwrap_or(1.0))?;
    positive("FLIP's number of pixels a degree", options.flip_pixels_per_degree)
}
