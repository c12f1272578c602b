//! Reading EXR files.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::io::{BufRead as _, BufReader, Cursor};
use std::path::Path;

use exr::meta::MetaData;
use exr::meta::attribute::SampleType;
use exr::meta::header::{Header, standard_names};
use exr::prelude::{
    AnyChannels, AttributeValue, FlatSamples, Layer, ReadChannels, ReadLayers as _, Text, Vec2,
    read as read_with,
};

use super::Image;
use super::decoder::{MAX_BYTES, check_packing, check_size, on_decoder};
use super::exr_attribute::{STANDARD, told};
use super::exr_storage::take_constants;
use crate::error::{Error, Result};
use crate::file;

/// The most values, pixels times channels over all parts, that a file may hold: 4 GiB as f32.
const MAX_VALUES: usize = 1 << 30;

/// The layers of an EXR file, one f32 per pixel each.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Column and row of the upper left pixel on the display window's.
    pub corner: [i32; 2],
    /// Width and height of the display window: larger than the picture's where it is a part.
    pub display: [usize; 2],
    /// Channels by name, row by row from the top, with those of one value everywhere that stand in the header.
    pub channels: Channels,
    /// The header's attributes that are strings, numbers, vectors or matrices, as text: numbers as JSON has them.
    pub attributes: BTreeMap<String, String>,
}

/// Values of channels by name, row by row from the top.
pub type Channels = BTreeMap<String, Vec<f32>>;

/// The header of an EXR file's first part.
#[derive(Clone, Debug, PartialEq)]
pub struct LayersHeader {
    /// Width and height of the data window.
    pub size: [usize; 2],
    /// Column and row of the upper left pixel on the display window's.
    pub corner: [i32; 2],
    /// Width and height of the display window.
    pub display: [usize; 2],
    /// The names of the channels, sorted, with those that have one value everywhere and stand in the header.
    pub channels: Vec<String>,
    /// The names of those that are half floats, sorted.
    pub half: Vec<String>,
    /// The attributes, as [`Layers::attributes`].
    pub attributes: BTreeMap<String, String>,
}

impl LayersHeader {
    fn new(header: &Header) -> Self {
        let display = header.shared_attributes.display_window;
        let origin = header.own_attributes.layer_position;
        let corner = [0, 1].map(|axis| {
            let at = |v: Vec2<i32>| [v.x(), v.y()][axis];
            at(origin).saturating_sub(at(display.position))
        });
        let mut attributes = texts(header);
        let constants = take_constants(&mut attributes).into_iter().map(|(name, _)| name);
        let stored = &header.channels.list;
        let mut channels: Vec<String> =
            stored.iter().map(|channel| string(&channel.name)).chain(constants).collect();
        channels.sort();
        channels.dedup();
        let halves = stored.iter().filter(|channel| channel.sample_type == SampleType::F16);
        let mut half: Vec<String> = halves.map(|channel| string(&channel.name)).collect();
        half.sort();
        Self {
            size: [header.layer_size.width(), header.layer_size.height()],
            corner,
            display: [display.size.width(), display.size.height()],
            channels,
            half,
            attributes,
        }
    }
}

impl Layers {
    /// The values of a channel.
    pub fn get(&self, name: &str) -> Option<&[f32]> {
        self.channels.get(name).map(Vec::as_slice)
    }

    /// The picture of `R`, `G`, `B`, or of `Y` as a grey; `None` where neither is there.
    pub fn image(&self) -> Option<Image> {
        let grey = self.get("Y");
        let [r, g, b] = ["R", "G", "B"].map(|name| self.get(name));
        let (r, g, b) = r.zip(g).zip(b).map(|((r, g), b)| (r, g, b)).or(grey.map(|y| (y, y, y)))?;
        let pixels = r.iter().zip(g).zip(b).map(|((&r, &g), &b)| [r, g, b]).collect();
        Some(Image::new(self.width, self.height, pixels))
    }
}

/// Reads the picture of an EXR file: `R`, `G`, `B`, or `Y` as a grey, of the first part that has
/// them, half or float, taken as linear Rec.709. The picture is the data window.
///
/// # Errors
/// Where the file cannot be read, is no flat EXR, is damaged, holds more than [`MAX_PIXELS`](super::MAX_PIXELS) or has
/// no such channels.
pub fn read_exr(path: &Path) -> Result<Image> {
    decode_exr(&file::read(path, MAX_BYTES)?, path)
}

/// Reads every channel of the first part of an EXR file, and the attributes of its header.
///
/// # Errors
/// As [`read_exr`], whatever the channels are.
pub fn read_layers(path: &Path) -> Result<Layers> {
    decode_parts(&file::read(path, MAX_BYTES)?, path)?
        .into_iter()
        .next()
        .ok_or_else(|| Error::file(path, "is an EXR file without a picture"))
}

/// Reads the attributes of the header of an EXR file's first part, and nothing else of it.
///
/// # Errors
/// As [`read_header`].
pub fn read_attributes(path: &Path) -> Result<BTreeMap<String, String>> {
    Ok(read_header(path)?.attributes)
}

/// Reads the header of an EXR file's first part, and no pixels.
///
/// # Errors
/// Where the file cannot be read, is no EXR or its header is damaged.
pub fn read_header(path: &Path) -> Result<LayersHeader> {
    let mut file = BufReader::new(file::open(path)?);
    let begin = file.fill_buf().map_err(|e| Error::file(path, format!("cannot be read: {e}")))?;
    if !is_exr(begin) {
        return Err(not_exr(path));
    }
    let damaged = |e: &dyn Display| Error::file(path, format!("has a damaged header: {e}"));
    on_decoder(path, &damaged, || {
        let meta = MetaData::read_from_buffered(file, false).map_err(|e| damaged(&e))?;
        let first = meta.headers.first().map(LayersHeader::new);
        first.ok_or_else(|| damaged(&"it has no part"))
    })
}

/// Whether the bytes begin as those of an EXR file.
pub(super) fn is_exr(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01])
}

fn not_exr(path: &Path) -> Error {
    Error::file(path, "is not an EXR file: its first bytes are others")
}

/// [`read_exr`] on the bytes of a file.
pub(super) fn decode_exr(bytes: &[u8], path: &Path) -> Result<Image> {
    let parts = decode_parts(bytes, path)?;
    parts.iter().find_map(Layers::image).ok_or_else(|| {
        let names: Vec<&str> =
            parts.iter().flat_map(|p| p.channels.keys()).map(String::as_str).collect();
        let names = names.join(", ");
        Error::file(path, format!("has the channels {names}; R, G and B, or Y, are needed"))
    })
}

/// Decodes on a thread of its own: a panic of the exr crate ends there. It must not decode in
/// parallel then, as a panic in its thread pool ends the process.
fn decode_parts(bytes: &[u8], path: &Path) -> Result<Vec<Layers>> {
    if !is_exr(bytes) {
        return Err(not_exr(path));
    }
    let damaged = |e: &dyn Display| {
        Error::file(path, format!("is damaged or of a kind of EXR that cannot be read: {e}"))
    };
    on_decoder(path, &damaged, || decode_here(bytes, path, &damaged))
}

fn decode_here(
    bytes: &[u8],
    path: &Path,
    damaged: &dyn Fn(&dyn Display) -> Error,
) -> Result<Vec<Layers>> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(|e| damaged(&e))?;
    check_sizes(&meta, bytes.len(), path)?;
    let image = read_with()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(|e| damaged(&e))?;
    let parts = image.layer_data.into_iter().zip(&meta.headers);
    Ok(parts.map(|(part, header)| layers(part, header)).collect())
}

fn layers(part: Layer<AnyChannels<FlatSamples>>, header: &Header) -> Layers {
    let LayersHeader { corner, display, attributes, .. } = LayersHeader::new(header);
    let (width, height) = (part.size.width(), part.size.height());
    let stored = part.channel_data.list.into_iter();
    let mut channels: Channels =
        stored.map(|channel| (string(&channel.name), floats(channel.sample_data))).collect();
    for (name, value) in take_constants(&mut texts(header)) {
        channels.entry(name).or_insert_with(|| vec![value; width * height]);
    }
    Layers { width, height, corner, display, channels, attributes }
}

/// The attributes of a header that text can tell, without those that the format needs.
fn texts(header: &Header) -> BTreeMap<String, String> {
    let attributes = header.all_named_attributes();
    let text = |(name, value): (&[u8], AttributeValue)| {
        let is_text = matches!(value, AttributeValue::Text(_));
        let is_own = STANDARD.iter().any(|known| known.as_bytes() == name);
        if standard_names::ALL.contains(&name) && !is_text && !is_own {
            return None;
        }
        Some((String::from_utf8_lossy(name).into_owned(), told(&value)?))
    };
    attributes.filter_map(text).collect()
}

/// Checks the claims of the header before memory is taken for them.
fn check_sizes(meta: &MetaData, bytes: usize, path: &Path) -> Result<()> {
    let mut values = 0_usize;
    for header in &meta.headers {
        let (width, height) = (header.layer_size.width(), header.layer_size.height());
        check_size(width, height, path)?;
        let channels = header.channels.list.len();
        let channels = channels + take_constants(&mut texts(header)).len();
        values = values.saturating_add((width * height).saturating_mul(channels));
        if values > MAX_VALUES {
            return Err(Error::file(
                path,
                format!(
                    "claims {channels} channels of {width} x {height} pixels; \
                     at most {MAX_VALUES} values can be read"
                ),
            ));
        }
    }
    check_packing(values, bytes, path)
}

fn floats(samples: FlatSamples) -> Vec<f32> {
    match samples {
        FlatSamples::F32(values) => values,
        FlatSamples::F16(values) => values.into_iter().map(half::f16::to_f32).collect(),
        FlatSamples::U32(values) => values.into_iter().map(|v| v as f32).collect(),
    }
}

fn string(text: &Text) -> String {
    String::from_utf8_lossy(text.bytes()).into_owned()
}
