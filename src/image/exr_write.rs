//! Writing EXR files: one flat part, 32-bit float or half, ZIP, rows from the top.

use std::collections::BTreeSet;
use std::io::{Cursor, Write};
use std::path::Path;

use exr::meta::header::standard_names;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image as ExrImage, IntegerBounds, Layer,
    LayerAttributes, Text, Vec2, WritableImage,
};

use super::exr_attribute::{REC_709, STANDARD, set_standard, typed};
use super::exr_storage::{Storage, half_layers, leave_out_constants};
use super::{Film, Image, Window, exr_header};
use half::f16;

use crate::error::{Error, Result};
use crate::file;

/// Writes a film with all its layers; see [`write_exr_layers`]. The data window is the film's, the
/// display window all of the film that it is part of.
///
/// # Errors
/// As [`write_exr_layers`].
pub fn write_exr(path: &Path, film: &Film, attributes: &[(&str, String)]) -> Result<()> {
    let bytes = exr_bytes(path, film, false, attributes)?;
    file::write(path, |out| out.write_all(&bytes))
}

/// What [`write_exr`] writes to `path`, with colours as `half` floats where those hold them. Layers that have one value everywhere
/// stand in the header instead; a part of a film has them all, so that any program can put parts together.
///
/// # Errors
/// Where a value is not finite or a name is not one; `path` is named then.
pub fn exr_bytes(
    path: &Path,
    film: &Film,
    half: bool,
    attributes: &[(&str, String)],
) -> Result<Vec<u8>> {
    let layers: Vec<(&str, &[f32])> = film.all_layers().collect();
    let (window, full) = (film.window(), film.full_size());
    let storage = Storage { leaves_out: window == Window::whole(full), half: &|_| half };
    bytes_of(path, window, full, &layers, attributes, storage)
}

/// Writes a picture as `R`, `G` and `B`; see [`write_exr_layers`].
///
/// # Errors
/// As [`write_exr_layers`].
pub fn write_exr_image(path: &Path, image: &Image) -> Result<()> {
    let [r, g, b] = image.channels();
    let layers: [(&str, &[f32]); 3] = [("R", &r), ("G", &g), ("B", &b)];
    write_exr_layers(path, image.width(), image.height(), &layers, &[])
}

/// Writes `layers`, each row by row from the top, as 32-bit float channels of one flat EXR part,
/// with `attributes` in its header, those that are numbers, vectors or matrices in JSON as such. The bytes depend on the arguments alone. Layers
/// named after channels are what every EXR reader expects; names are stored as given.
///
/// # Errors
/// Where a layer has the wrong number of values or one that is not finite, a name is empty, given
/// twice or reserved, or the file cannot be written; an earlier one is intact then.
pub fn write_exr_layers(
    path: &Path,
    width: usize,
    height: usize,
    layers: &[(&str, &[f32])],
    attributes: &[(&str, String)],
) -> Result<()> {
    let (window, full) = window_of([width, height]);
    let bytes = bytes_of(path, window, full, layers, attributes, Storage::FULL)?;
    file::write(path, |out| out.write_all(&bytes))
}

/// The file `path` of a whole picture of `size`, width and height, with `layers` and `attributes`, stored as a film is; layers whose
/// names are in `half` as half floats, where those hold them.
///
/// # Errors
/// As [`exr_bytes`], and where a layer has the wrong number of values.
pub fn exr_picture_bytes(
    path: &Path,
    size: [usize; 2],
    layers: &[(&str, &[f32])],
    attributes: &[(&str, String)],
    half: &BTreeSet<&str>,
) -> Result<Vec<u8>> {
    let storage = Storage { leaves_out: true, half: &|name| half.contains(name) };
    let (window, full) = window_of(size);
    bytes_of(path, window, full, layers, attributes, storage)
}

fn window_of(size: [usize; 2]) -> (Window, [u32; 2]) {
    let sides = size.map(|side| u32::try_from(side).unwrap_or(0));
    (Window::whole(sides), sides)
}

/// The file of `layers` of the data window `window` of a picture of the size `full`.
fn bytes_of(
    path: &Path,
    window: Window,
    full: [u32; 2],
    layers: &[(&str, &[f32])],
    attributes: &[(&str, String)],
    storage: Storage<'_>,
) -> Result<Vec<u8>> {
    check_layers(path, window.width as usize, window.height as usize, layers)?;
    let mut stored = layers.to_vec();
    let constants = if storage.leaves_out { leave_out_constants(&mut stored) } else { Vec::new() };
    let constants = constants.iter().map(|(name, value)| (name.as_str(), value.clone()));
    let attributes: Vec<_> = attributes.iter().cloned().chain(constants).collect();
    check_attributes(path, &attributes)?;
    let half = half_layers(&stored, storage.half);
    encode(window, full, &stored, &attributes, &half)
        .map_err(|e| Error::file(path, format!("cannot be encoded as EXR: {e}")))
}

fn encode(
    window: Window,
    full: [u32; 2],
    layers: &[(&str, &[f32])],
    attributes: &[(&str, String)],
    half: &BTreeSet<&str>,
) -> Result<Vec<u8>, exr::error::Error> {
    let samples = |name: &str, values: &[f32]| {
        if half.contains(name) {
            FlatSamples::F16(values.iter().map(|value| f16::from_f32(*value)).collect())
        } else {
            FlatSamples::F32(values.to_vec())
        }
    };
    let channel =
        |(name, values): &(&str, &[f32])| AnyChannel::new(text(name), samples(name, values));
    let channels = layers.iter().map(channel).collect();
    let layer_position = Vec2(window.left as i32, window.top as i32);
    let mut header = LayerAttributes { layer_position, ..LayerAttributes::default() };
    for (name, value) in attributes {
        if set_standard(&mut header, name, value).is_none() {
            header.other.insert(text(name), typed(value));
        }
    }
    let size = (window.width as usize, window.height as usize);
    let part = Layer::new(size, header, Encoding::SMALL_LOSSLESS, AnyChannels::sort(channels));
    let mut image = ExrImage::from_layer(part);
    image.attributes.display_window =
        IntegerBounds::from_dimensions((full[0] as usize, full[1] as usize));
    image.attributes.chromaticities =
        layers.iter().any(|(name, _)| *name == "R").then_some(REC_709);
    let mut bytes = Cursor::new(Vec::new());
    let writer = image.write();
    let writer = if rayon::current_num_threads() == 1 { writer.non_parallel() } else { writer };
    writer.to_buffered(&mut bytes)?;
    let mut bytes = bytes.into_inner();
    exr_header::sort_attributes(&mut bytes)
        .ok_or(exr::error::Error::Invalid("the header is not that of a single part".into()))?;
    Ok(bytes)
}

/// UTF-8 as the OpenEXR library reads it; the crate's own conversion knows Latin-1 alone.
fn text(string: &str) -> Text {
    Text::from_slice_unchecked(string.as_bytes())
}

fn check_layers(path: &Path, width: usize, height: usize, layers: &[(&str, &[f32])]) -> Result<()> {
    check_names(path, "layer", layers.iter().map(|(name, _)| *name))?;
    let pixels = width.checked_mul(height).filter(|&n| n > 0 && !layers.is_empty());
    let Some(pixels) = pixels else {
        return Err(Error::file(
            path,
            format!("{} layers of {width} x {height} pixels make no picture", layers.len()),
        ));
    };
    for (name, values) in layers {
        if values.len() != pixels {
            let found = values.len();
            return Err(Error::file(
                path,
                format!("layer \"{name}\" has {found} values; {width} x {height} are needed"),
            ));
        }
        if let Some(index) = values.iter().position(|v| !v.is_finite()) {
            let (x, y, value) = (index % width, index / width, values[index]);
            return Err(Error::file(
                path,
                format!("layer \"{name}\" is {value} at pixel {x}, {y}; values must be finite"),
            ));
        }
    }
    Ok(())
}

fn check_attributes(path: &Path, attributes: &[(&str, String)]) -> Result<()> {
    check_names(path, "attribute", attributes.iter().map(|(name, _)| *name))?;
    let mut header = LayerAttributes::default();
    for (name, value) in attributes {
        let is_known = STANDARD.contains(name);
        if is_known && set_standard(&mut header, name, value).is_none() {
            let problem =
                format!("attribute \"{name}\" is {value}, which the EXR format does not allow");
            return Err(Error::file(path, problem));
        }
        if !is_known && standard_names::ALL.contains(&name.as_bytes()) {
            let problem = format!("attribute \"{name}\" is reserved by the EXR format");
            return Err(Error::file(path, problem));
        }
    }
    Ok(())
}

fn check_names<'a>(path: &Path, kind: &str, names: impl Iterator<Item = &'a str>) -> Result<()> {
    let mut seen = BTreeSet::new();
    for name in names {
        if name.is_empty() || name.len() > 255 || name.contains('\0') {
            return Err(Error::file(
                path,
                format!("{kind} name \"{name}\" must have 1 to 255 bytes and no NUL"),
            ));
        }
        if !seen.insert(name) {
            return Err(Error::file(path, format!("{kind} \"{name}\" is given twice")));
        }
    }
    Ok(())
}
