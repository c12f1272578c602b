//! PNG files to look at.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::{Image, Picture, View};
use crate::error::{Error, Result};
use crate::file;

/// The PNG beside an EXR: the same path with the ending `.png`.
pub fn png_path_beside(exr: &Path) -> PathBuf {
    exr.with_extension("png")
}

/// The bytes of a PNG at `path` of `picture`: 8-bit RGB marked as sRGB.
///
/// # Errors
/// Where the picture is larger than a PNG can be.
pub fn png_bytes(path: &Path, picture: &Picture) -> Result<Vec<u8>> {
    let size = png_size(path, picture)?;
    let mut bytes = Vec::new();
    encode(&mut bytes, size, picture)
        .map_err(|e| Error::file(path, format!("cannot be written: {e}")))?;
    Ok(bytes)
}

/// Writes `image` as an opaque PNG. Radiance is premultiplied, so what is partly covered stands before black.
///
/// # Errors
/// As [`write_picture`].
pub fn write_png(path: &Path, image: &Image, view: &View) -> Result<()> {
    write_picture(path, &Picture::developed(image, view))
}

/// Writes `picture` as an 8-bit RGB PNG marked as sRGB.
///
/// # Errors
/// Where the file cannot be written; an earlier one is intact then.
pub fn write_picture(path: &Path, picture: &Picture) -> Result<()> {
    let size = png_size(path, picture)?;
    file::write(path, |out| encode(out, size, picture))
}

fn png_size(path: &Path, picture: &Picture) -> Result<[u32; 2]> {
    let too_large = || Error::file(path, "is wider or higher than a PNG can be");
    let width = u32::try_from(picture.width()).map_err(|_| too_large())?;
    let height = u32::try_from(picture.height()).map_err(|_| too_large())?;
    Ok([width, height])
}

fn encode(out: impl Write, [width, height]: [u32; 2], picture: &Picture) -> io::Result<()> {
    let mut encoder = ::png::Encoder::new(out, width, height);
    encoder.set_color(::png::ColorType::Rgb);
    encoder.set_depth(::png::BitDepth::Eight);
    encoder.set_source_srgb(::png::SrgbRenderingIntent::Perceptual);
    let mut writer = encoder.write_header().map_err(io::Error::from)?;
    writer.write_image_data(picture.bytes()).map_err(io::Error::from)?;
    writer.finish().map_err(io::Error::from)
}
