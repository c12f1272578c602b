//! Reading Radiance pictures (`.hdr`, `.pic`).

use std::io::Cursor;
use std::path::Path;

use ::image::codecs::hdr::HdrDecoder;
use ::image::{DynamicImage, ImageDecoder};

use super::Image;
use super::decoder::{check_packing, check_size};
use crate::error::{Error, Result};

/// Whether the bytes begin as those of a Radiance picture: `#?RADIANCE`, or `#?RGBE` of other
/// programs.
pub(super) fn is_hdr(bytes: &[u8]) -> bool {
    bytes.starts_with(b"#?RADIANCE") || bytes.starts_with(b"#?RGBE")
}

/// Decodes RGBE pixels, flat or with either run-length encoding, as linear Rec.709. `EXPOSURE` and
/// `COLORCORR` are left out of account, as in other programs that take such files as skies.
pub(super) fn decode_hdr(bytes: &[u8], path: &Path) -> Result<Image> {
    let damaged = |e: ::image::ImageError| {
        Error::file(path, format!("is damaged or of a kind of HDR that cannot be read: {e}"))
    };
    let decoder = HdrDecoder::new_nonstrict(Cursor::new(bytes)).map_err(damaged)?;
    let (width, height) = decoder.dimensions();
    let (width, height) = (width as usize, height as usize);
    check_size(width, height, path)?;
    check_packing(3 * width * height, bytes.len(), path)?;
    let picture = DynamicImage::from_decoder(decoder).map_err(damaged)?.into_rgb32f();
    Ok(Image::new(width, height, picture.pixels().map(|p| p.0).collect()))
}
