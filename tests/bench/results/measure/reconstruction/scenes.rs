//! The scenes whose noise is measured.

use std::fs;
use std::path::{Path, PathBuf};

use fogbow::scene::{LoadOptions, Look, LookOptions, Scene};

use super::super::scene_text::LAMP_IN_FOG;
use super::super::scenes::{BARE, PAPER, scaled, shared, shipped};
use super::super::strategy::side_lit_smoke;
use crate::pages::Result;

/// Further scenes of `volumes/`.
const SHIPPED: [&str; 3] = ["smoke", "cloud", "fire"];

/// A scene with its file.
pub struct NoiseScene {
    pub title: String,
    path: PathBuf,
    options: LoadOptions,
}

impl NoiseScene {
    /// With `side` pixels along the longer side and its photons divided by `part`.
    pub fn load(&self, side: u32, rays: u32, part: u64) -> Result<Scene> {
        let size = scaled(&self.path, side)?;
        let options = self.options.clone().size(size).rays(rays);
        let all = Scene::load(&self.path, &options)?;
        if part == 1 {
            return Ok(all);
        }
        let options = options.photons((all.render.photons / part).max(1));
        Ok(Scene::load(&self.path, &options)?)
    }
}

/// All of them, those of made files with their files in `folder`, and a sentence for each that is left out.
pub fn scenes(folder: &Path) -> Result<(Vec<NoiseScene>, Vec<String>)> {
    let named = SHIPPED.map(|name| (name, name));
    let of_file = |(title, name): (&str, &str)| NoiseScene {
        title: title.into(),
        path: shipped(name),
        options: LoadOptions::default(),
    };
    let mut scenes: Vec<NoiseScene> = PAPER.into_iter().chain(named).map(of_file).collect();
    let mut left_out = Vec::new();
    for (title, file) in BARE {
        match shared(file) {
            Some(path) => {
                let look = LookOptions { look: Some(Look::None), ..LookOptions::default() };
                let options = LoadOptions { look, ..LoadOptions::default() };
                scenes.push(NoiseScene { title: title.into(), path, options });
            }
            None => left_out.push(format!("{file} was not there and is left out.")),
        }
    }
    let mut made = vec![("lamp in fog".to_owned(), LAMP_IN_FOG.to_owned())];
    match side_lit_smoke()? {
        Some(scene) => made.push((scene.name, scene.text)),
        None => left_out.push("The smoke lit from the side was not there and is left out.".into()),
    }
    for (title, text) in made {
        let path = folder.join(format!("{}.toml", title.replace([' ', '.', ','], "_")));
        fs::write(&path, text)?;
        scenes.push(NoiseScene { title, path, options: LoadOptions::default() });
    }
    Ok((scenes, left_out))
}
