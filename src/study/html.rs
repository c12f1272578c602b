//! What the pages of this room share: one file each, which opens offline.

use std::io::Write;
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use minijinja::value::Value;
use minijinja::{AutoEscape, Environment};
use serde::Serialize;

use crate::error::{Error, Result};
use crate::file;

/// Writes the page that `template` makes of `context`, in which all text is escaped that is not
/// marked as safe.
///
/// # Errors
/// Where the page cannot be made or written.
pub(super) fn write_page(path: &Path, template: &str, context: Value) -> Result<()> {
    let mut environment = Environment::new();
    environment.set_auto_escape_callback(|_| AutoEscape::Html);
    let page = environment
        .add_template("page", template)
        .and_then(|()| environment.get_template("page")?.render(context))
        .map_err(|e| unmade(path, &e))?;
    file::write(path, |out| out.write_all(page.as_bytes()))
}

/// `value` as JSON for a script element: `<` is escaped, so that no text ends the element.
pub(super) fn json(path: &Path, value: &impl Serialize) -> Result<String> {
    let text = serde_json::to_string(value).map_err(|e| unmade(path, &e))?;
    Ok(text.replace('<', "\\u003c"))
}

/// An RGB PNG as a data URI. It says nothing of colours, so that scripts read the bytes as stored.
pub(super) fn data_uri(path: &Path, width: usize, height: usize, bytes: &[u8]) -> Result<String> {
    let mut file = Vec::new();
    encode(&mut file, width as u32, height as u32, bytes).map_err(|e| unmade(path, &e))?;
    Ok(format!("data:image/png;base64,{}", STANDARD.encode(file)))
}

fn encode(
    file: &mut Vec<u8>,
    width: u32,
    height: u32,
    bytes: &[u8],
) -> Result<(), png::EncodingError> {
    let mut encoder = png::Encoder::new(file, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::High);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(bytes)?;
    writer.finish()
}

/// That the page at `path` cannot be made.
pub(super) fn unmade(path: &Path, problem: &dyn std::fmt::Display) -> Error {
    Error::file(path, format!("cannot be made: {problem}"))
}
