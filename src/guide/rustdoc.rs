//! Makes of the guide's pages what rustdoc can show: used by the build script alone.
//!
//! Pages link to each other as files, and to pictures beside them. In rustdoc a page is a module, and
//! there is no place for pictures, so they are put into the text.

use std::fs;
use std::io::{Error, Result};
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

/// Page that links to all others.
const INDEX: &str = "README.md";

/// Writes each page of the folder `guide` to the folder `out`, as rustdoc wants it.
pub fn write_pages(guide: &Path, out: &Path) -> Result<()> {
    fs::create_dir_all(out)?;
    for entry in fs::read_dir(guide)? {
        let path = entry?.path();
        let Some(name) = path.file_name().and_then(|name| name.to_str()) else { continue };
        if name.ends_with(".md") {
            fs::write(out.join(name), page(guide, name)?)?;
        }
    }
    Ok(())
}

fn page(guide: &Path, name: &str) -> Result<String> {
    let text = fs::read_to_string(guide.join(name))?;
    let mut made = String::with_capacity(text.len());
    let mut rest = text.as_str();
    while let Some((before, after)) = rest.split_once("](") {
        let (target, behind) = after
            .split_once(')')
            .ok_or_else(|| Error::other(format!("{name}: a link without its end: {after:.40}")))?;
        made.push_str(before);
        if let Some(media) = picture(target) {
            let bytes = fs::read(guide.join(target))
                .map_err(|error| Error::other(format!("{name} shows {target}: {error}")))?;
            made.push_str(&format!("](data:{media};base64,{})", STANDARD.encode(bytes)));
        } else if let Some(path) = target.strip_prefix("../../") {
            unlink(&mut made, path);
        } else if let Some(module) = target.strip_suffix(".md") {
            let up = if name == INDEX { "" } else { "../" };
            made.push_str(&format!("]({up}{module}/index.html)"));
        } else {
            made.push_str(&format!("]({target})"));
        }
        rest = behind;
    }
    made.push_str(rest);
    Ok(made)
}

/// The media type of a picture, by the end of its name.
fn picture(target: &str) -> Option<&'static str> {
    let types = [(".png", "image/png"), (".svg", "image/svg+xml")];
    types.into_iter().find_map(|(end, media)| target.ends_with(end).then_some(media))
}

/// Turns the text of a link to a file of the repository, which `made` ends with, into plain text with
/// the file's path.
fn unlink(made: &mut String, path: &str) {
    if let Some(bracket) = made.rfind('[') {
        made.remove(bracket);
    }
    made.push_str(&format!(" (`{path}`)"));
}
