//! A part: the header of its file, checked, and its layers.

use std::path::{Path, PathBuf};

use super::super::header::PREFIX;
use super::super::partial::{COMPLETE, PREVIEW};
use crate::error::{Error, Result};
use crate::image::{Layers, LayersHeader, View, Window, cryptomatte, read_header, read_layers};
use crate::scene::PicturePass;

/// The attribute that lists the passes of a merged picture.
pub(super) const PASSES: &str = "fogbow:passes";

/// A picture that is merged with others.
#[derive(Debug)]
pub(super) struct Part {
    /// Its file.
    pub(super) path: PathBuf,
    /// Where it lies on the frame.
    pub(super) window: Window,
    /// Width and height of the frame.
    pub(super) size: [u32; 2],
    /// The names of its layers, sorted.
    pub(super) layers: Vec<String>,
    /// Seed of its random streams.
    pub(super) seed: u64,
    /// Which pass it is of a picture of that seed, where that was rendered in equal passes.
    pub(super) pass: Option<PicturePass>,
    header: LayersHeader,
}

impl Part {
    /// The part in the file `path`, of which the header alone is read.
    ///
    /// # Errors
    /// Where the file cannot be read, is no picture of `fogbow render`, is unfinished, was rendered to an error, or is
    /// merged of passes.
    pub(super) fn read(path: &Path) -> Result<Self> {
        let header = read_header(path)?;
        if header.attributes.contains_key(PASSES) {
            return Err(Error::file(path, "is merged of passes already; give those themselves"));
        }
        let of_fogbow = ["version", "scene", "seed", "rays", "photons", "size"];
        let lacks = |name: &&str| !header.attributes.contains_key(&format!("{PREFIX}{name}"));
        if let Some(name) = of_fogbow.iter().find(|name| lacks(name)) {
            let problem = format!("has no {PREFIX}{name}; give pictures of fogbow render");
            return Err(Error::file(path, problem));
        }
        let says =
            |name: &str, value: &str| header.attributes.get(name).is_some_and(|v| v == value);
        if says(COMPLETE, "false") || says(PREVIEW, "true") {
            let problem = "is unfinished; finish it by fogbow render --resume";
            return Err(Error::file(path, problem));
        }
        if let Some(goal) = header.attributes.get(&format!("{PREFIX}error")) {
            let problem = format!(
                "was rendered to the error {goal}: its rays follow from its noise, and weights by them would bias the \
                 mean; give pictures whose rays and photons were asked for"
            );
            return Err(Error::file(path, problem));
        }
        let (window, size) = place(path, &header)?;
        let layers = header.channels.clone();
        let mut part =
            Self { path: path.to_path_buf(), window, size, layers, seed: 0, pass: None, header };
        part.seed = part.count("seed")?;
        part.pass = part.attribute("pass").map(|text| part.pass_of(text)).transpose()?;
        part.count("rays")?;
        part.count("photons")?;
        Ok(part)
    }

    /// Names, without `fogbow:`, and values of the attributes of fogbow.
    pub(super) fn attributes(&self) -> impl Iterator<Item = (&str, &str)> {
        let attributes = self.header.attributes.iter();
        attributes.filter_map(|(name, value)| Some((name.strip_prefix(PREFIX)?, value.as_str())))
    }

    /// The names of its attributes that tell of objects.
    pub(super) fn of_objects(&self) -> impl Iterator<Item = &str> {
        let names = self.header.attributes.keys().map(String::as_str);
        names.filter(|name| name.starts_with(cryptomatte::ATTRIBUTES))
    }

    /// The attribute of fogbow of that name.
    pub(super) fn attribute(&self, name: &str) -> Option<&str> {
        self.standard(&format!("{PREFIX}{name}"))
    }

    /// The attribute of this whole name.
    pub(super) fn standard(&self, name: &str) -> Option<&str> {
        self.header.attributes.get(name).map(String::as_str)
    }

    /// The names of its layers that are half floats.
    pub(super) fn half(&self) -> &[String] {
        &self.header.half
    }

    /// Bytes of its layers in memory.
    pub(super) fn bytes(&self) -> u64 {
        self.window.pixels() * (self.layers.len() * size_of::<f32>()) as u64
    }

    /// The whole number of an attribute; 0 where it is not there.
    ///
    /// # Errors
    /// Where it is something else.
    pub(super) fn count(&self, name: &str) -> Result<u64> {
        let text = self.attribute(name).unwrap_or("0");
        text.parse().map_err(|_| {
            Error::file(
                &self.path,
                format!("{PREFIX}{name} is `{text}`; it must be a whole number"),
            )
        })
    }

    /// The pass that `text` tells.
    fn pass_of(&self, text: &str) -> Result<PicturePass> {
        text.parse().map_err(|_| {
            let problem = format!("{PREFIX}pass is `{text}`; it must be a pass, such as 3/8");
            Error::file(&self.path, problem)
        })
    }

    /// The view of its PNG, where the header tells it.
    pub(super) fn view(&self) -> Option<View> {
        let exposure = self.attribute("exposure")?.parse().ok().filter(|e: &f64| e.is_finite())?;
        Some(View { exposure, transform: self.attribute("view")?.parse().ok()? })
    }

    /// Its layers.
    ///
    /// # Errors
    /// Where the file is damaged, has a value that is not finite, or another header than before.
    pub(super) fn read_layers(&self) -> Result<Layers> {
        let layers = read_layers(&self.path)?;
        let Layers { width, height, corner, attributes, channels, .. } = &layers;
        let is_same = [*width, *height] == self.header.size
            && *corner == self.header.corner
            && *attributes == self.header.attributes
            && channels.keys().eq(&self.layers);
        if !is_same {
            return Err(Error::file(&self.path, "changed while it was read; merge again"));
        }
        for (name, values) in channels {
            if let Some(index) = values.iter().position(|value| !value.is_finite()) {
                let (x, y, value) = (index % width, index / width, values[index]);
                let problem =
                    format!("layer \"{name}\" is {value} at pixel {x}, {y}; values must be finite");
                return Err(Error::file(&self.path, problem));
            }
        }
        Ok(layers)
    }
}

/// Where the picture of `header` lies on its frame, and the size of that.
fn place(path: &Path, header: &LayersHeader) -> Result<(Window, [u32; 2])> {
    let LayersHeader { size: [width, height], corner: [left, top], display, attributes, .. } =
        header;
    let wrong = || {
        let place = format!("{left},{top},{width}x{height}");
        let frame = format!("{}x{}", display[0], display[1]);
        Error::file(
            path,
            format!(
                "has the data window {place} on a display window of {frame}, which fogbow:size and fogbow:crop do \
                 not tell of; give it as fogbow render wrote it"
            ),
        )
    };
    let sides = |[a, b]: [usize; 2]| Some([u32::try_from(a).ok()?, u32::try_from(b).ok()?]);
    let text = |name: &str| attributes.get(&format!("{PREFIX}{name}"));
    let size = sides(*display).ok_or_else(wrong)?;
    let [width, height] = sides([*width, *height]).ok_or_else(wrong)?;
    let [left, top] = [left, top].map(|at| u32::try_from(*at).ok());
    let (left, top) = left.zip(top).ok_or_else(wrong)?;
    let window = Window { left, top, width, height };
    let told = match text("crop") {
        Some(crop) => crop.parse().ok(),
        None => Some(Window::whole(size)),
    };
    let told_size = text("size").and_then(|text| serde_json::from_str::<[u32; 2]>(text).ok());
    let is_right = window.fits(size) && told == Some(window) && told_size == Some(size);
    if is_right { Ok((window, size)) } else { Err(wrong()) }
}
