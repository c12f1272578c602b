//! Error with and without Open Image Denoise, by fogbow's own commands.

use std::path::Path;

use serde_json::Value;

use super::child::{argument, fogbow};
use super::scenes::{PAPER, scaled, shipped};
use super::{Kept, LeftOut};
use crate::pages::Result;
use crate::pages::denoise::Row;

/// Scenes with photons and rays of what pictures are held against.
const SCENES: [(&str, &str, &str, &str); 6] = [
    (PAPER[0].0, PAPER[0].1, "2000000", "64"),
    (PAPER[2].0, PAPER[2].1, "2000000", "64"),
    (PAPER[3].0, PAPER[3].1, "2000000", "64"),
    ("smoke", "smoke", "2000000", "64"),
    ("fire", "fire", "2000000", "64"),
    ("cloud", "cloud", "500000", "512"),
];

/// How each picture is rendered.
const WAYS: [(&str, &[&str]); 5] = [
    ("xs", &["--photons", "200000", "--director", "xs"]),
    ("xs-denoised", &["--photons", "200000", "--director", "xs", "--denoise"]),
    ("few-photons-denoised", &["--photons", "20000", "--denoise"]),
    ("traced", &["--reference"]),
    ("traced-denoised", &["--reference", "--denoise"]),
];

/// A part a scene.
pub fn measure(kept: &mut Kept<Row>, quick: bool) -> Result<()> {
    let folder = tempfile::tempdir()?;
    let probe = folder.path().join("probe.exr");
    let tiny = ["--size", "16x16", "--photons", "100", "--rays", "1", "--denoise"];
    let scene = shipped("smoke");
    if let Err(error) = render(&scene, &probe, &tiny) {
        return Err(LeftOut(format!("fogbow renders nothing with --denoise: {error}")).into());
    }
    for (title, name, photons, rays) in &SCENES[..if quick { 1 } else { SCENES.len() }] {
        kept.part(title, || rows(title, &shipped(name), [photons, rays], folder.path(), quick))?;
    }
    Ok(())
}

fn rows(
    title: &str,
    scene: &Path,
    [photons, rays]: [&str; 2],
    folder: &Path,
    quick: bool,
) -> Result<Vec<Row>> {
    let [width, height] = scaled(scene, if quick { 32 } else { 192 })?;
    let size = format!("{width}x{height}");
    let [photons, rays] = if quick { ["20000", "4"] } else { [photons, rays] };
    let reference = folder.join("reference.exr");
    let settings = ["--size", &size, "--photons", photons, "--rays", rays, "--seed", "1"];
    render(scene, &reference, &settings)?;
    let mut rows = Vec::new();
    for (way, settings) in WAYS {
        let picture = folder.join("picture.exr");
        render(scene, &picture, &[&["--size", &size, "--rays", "8"], settings].concat())?;
        let told = fogbow(&["error", argument(&reference)?, argument(&picture)?, "--json"])?;
        let error = |name: &str| {
            let figure = told["errors"][name].as_f64();
            figure.ok_or_else(|| format!("fogbow error tells no {name}"))
        };
        rows.push(Row {
            scene: title.into(),
            way: way.into(),
            relative_mse_trimmed: error("relative_mse_trimmed")?,
            flip_hdr: error("flip_hdr")?,
        });
    }
    Ok(rows)
}

fn render(scene: &Path, picture: &Path, settings: &[&str]) -> Result<Value> {
    let own = ["render", argument(scene)?, "-o", argument(picture)?, "--json", "--quiet"];
    fogbow(&[&own, settings].concat())
}
