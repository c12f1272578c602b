//! Noise taken off pictures by Open Image Denoise.

use oidn::{Device, RayTracing};

use super::{Film, Image};
use crate::error::{Error, Result};

/// Whether pictures can be denoised here.
///
/// # Errors
/// Where the library finds no module for this processor.
pub fn can_denoise() -> Result<()> {
    device().map(drop)
}

/// What `film` shows without its noise, by Open Image Denoise's filter for ray tracing in high dynamic
/// range. It is shown nothing but the picture: the transmittance as a guide made it no better.
///
/// # Errors
/// Where the library fails; its message is handed on.
pub fn denoised(film: &Film) -> Result<Image> {
    let device = device()?;
    let noisy = film.image();
    let color = noisy.pixels().as_flattened();
    let mut clean = vec![0.0; color.len()];
    RayTracing::try_new(&device)
        .map_err(failed)?
        .image_dimensions(film.width(), film.height())
        .hdr(true)
        .filter(color, &mut clean)
        .map_err(failed)?;
    let pixels = clean.as_chunks().0.to_vec();
    Ok(Image::new(film.width(), film.height(), pixels))
}

fn device() -> Result<Device> {
    Device::cpu().map_err(failed)
}

fn failed(error: oidn::Error) -> Error {
    Error::Failed(format!("Open Image Denoise: {}", error.message()))
}
