//! What stands for denoising where fogbow was built without Open Image Denoise.

use super::{Film, Image};
use crate::error::{Error, Result};

/// Whether pictures can be denoised here: not in this build.
///
/// # Errors
/// Always.
pub fn can_denoise() -> Result<()> {
    Err(absent())
}

/// What a film shows without its noise, in another build.
///
/// # Errors
/// Always.
pub fn denoised(_: &Film) -> Result<Image> {
    Err(absent())
}

fn absent() -> Error {
    Error::Usage(
        "--denoise: this fogbow was built without Open Image Denoise; where that library is installed, \
         build it with --features denoise"
            .into(),
    )
}
