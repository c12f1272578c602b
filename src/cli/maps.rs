//! `fogbow maps`.

use std::path::{Path, PathBuf};

use serde_json::{Map, Value, json};

use super::console;
use super::load;
use super::look::LookArgs;
use super::settings::{RunArgs, SettingArgs};
use crate::director::CachedSnapshot;
use crate::error::{Error, Result};
use crate::image::{
    Image, Picture, ScalarMap, View, ViewTransform, contact_sheet, titled, write_exr_image,
    write_exr_layers, write_picture,
};
use crate::render::{self, DirectorMaps, Earlier, Extent, Stages};
use crate::scene::{LoadOptions, OpenScene, Scene};
use crate::sequence::FrameTime;

/// Panels side by side on the contact sheet.
const COLUMNS: usize = 4;

/// Arguments of `fogbow maps`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// A scene (.toml), or a VDB file, which gets a camera and lights.
    #[arg(value_name = "SCENE|FILE.vdb")]
    scene: PathBuf,
    /// The folder to write to; it is made where it is missing.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// A z.exr that this command wrote for the same camera, surfaces, lights and seed: nothing is
    /// intersected.
    #[arg(long, value_name = "FILE.exr")]
    z: Option<PathBuf>,
    /// The frame to look at, where the scene names a sequence of files; 12.5 is a time
    /// between two.
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    frame: Option<FrameTime>,
    #[command(flatten)]
    settings: SettingArgs,
    #[command(flatten)]
    look: LookArgs,
    #[command(flatten)]
    run: RunArgs,
}

/// One map to write: its file name, its title, and what it shows.
struct Shown<'a> {
    name: &'a str,
    title: &'a str,
    content: Content<'a>,
}

enum Content<'a> {
    Values(&'a [f32], [f32; 2]),
    Light(&'a Image),
    /// What is written beside its picture in another way.
    Distances(&'a [f32]),
}

/// Makes the director's maps and writes them as EXR and PNG in their own resolution, with a contact
/// sheet.
pub(super) fn run(args: &Args) -> Result<()> {
    std::fs::create_dir_all(&args.output)
        .map_err(|e| Error::file(&args.output, format!("cannot be made: {e}; give a folder")))?;
    let (scene, maps, stages) = make(args, &mut OpenScene::of_file(&args.scene))?;
    let outputs = write(&args.output, &scene, &maps)?;
    if args.run.json {
        let seconds: Map<String, Value> = stages
            .timings
            .iter()
            .map(|(name, time)| ((*name).to_owned(), json!(time.as_secs_f64())))
            .collect();
        let mean = maps.xs.iter().map(|v| f64::from(*v)).sum::<f64>() / maps.xs.len() as f64;
        let outputs: Vec<String> = outputs.iter().map(|p| p.display().to_string()).collect();
        let report = json!({
            "scene": scene.hash, "size": maps.size, "mean_xs": mean,
            "seconds": seconds, "work": maps.work.less(&maps.spared), "pilot_work": maps.pilot_work, "outputs": outputs,
        });
        console::result(&report.to_string());
    } else {
        outputs.iter().for_each(|path| console::result(&path.display().to_string()));
    }
    Ok(())
}

/// The maps of the scene `open`; also that scene, and the times of the stages.
fn make(args: &Args, open: &mut OpenScene) -> Result<(Scene, DirectorMaps, Stages)> {
    let options = LoadOptions { frame: args.frame, ..load::options(&args.settings, &args.look) };
    let (scene, pool, _) = load::scene_to_show(open, options, &args.run)?;
    let snapshot = args
        .z
        .as_ref()
        .map(|path| CachedSnapshot::read(path, &scene, &scene.render))
        .transpose()?;
    let earlier = Earlier { snapshot, ..Earlier::default() };
    let mut stages = Stages::default();
    let maps =
        pool.install(|| render::maps(&scene, &scene.render, earlier, Extent::All, &mut stages))?;
    Ok((scene, maps, stages))
}

/// A map as numbers.
#[derive(Debug)]
pub struct MapValues {
    /// The name of its file, without an ending.
    pub name: String,
    /// Rows, pixels of a row, and where there are several channels of a pixel.
    pub shape: Vec<usize>,
    /// Row by row from the top.
    pub values: Vec<f32>,
}

/// The maps of the scene `open`, none of them written.
pub(super) fn values(args: &Args, open: &mut OpenScene) -> Result<Vec<MapValues>> {
    let (_, maps, _) = make(args, open)?;
    let width = maps.size[0] as usize;
    let depth = maps.snapshot.iter().flat_map(|cached| &cached.snapshot.depth);
    let distances: Vec<f32> = depth.map(|z| *z as f32).collect();
    let values = |shown: Shown<'_>| {
        let (shape, values) = match shown.content {
            Content::Values(values, _) | Content::Distances(values) => {
                (vec![values.len() / width, width], values.to_vec())
            }
            Content::Light(image) => {
                let values = image.pixels().iter().flatten().copied().collect();
                (vec![image.height(), image.width(), 3], values)
            }
        };
        MapValues { name: shown.name.into(), shape, values }
    };
    Ok(shown(&maps, &distances).into_iter().map(values).collect())
}

fn write(folder: &Path, scene: &Scene, maps: &DirectorMaps) -> Result<Vec<PathBuf>> {
    let mut outputs = Vec::new();
    let mut panels = Vec::new();
    let width = maps.size[0] as usize;
    let depth = maps.snapshot.iter().flat_map(|cached| &cached.snapshot.depth);
    let distances: Vec<f32> = depth.map(|z| *z as f32).collect();
    if let Some(cached) = &maps.snapshot {
        let path = folder.join("z.exr");
        cached.write(&path)?;
        outputs.push(path);
    }
    for shown in shown(maps, &distances) {
        let exr = folder.join(format!("{}.exr", shown.name));
        let panel = match shown.content {
            Content::Values(values, range) => {
                write_exr_layers(&exr, width, values.len() / width, &[("Y", values)], &[])?;
                outputs.push(exr);
                ScalarMap { name: shown.title, width, values, range }.panel()
            }
            Content::Light(image) => {
                write_exr_image(&exr, image)?;
                outputs.push(exr);
                let view =
                    View { exposure: scene.film.shown().exposure, transform: ViewTransform::Srgb };
                titled(shown.title, &Picture::developed(image, &view))
            }
            Content::Distances(values) => ScalarMap::fitted(shown.title, width, values).panel(),
        };
        let png = folder.join(format!("{}.png", shown.name));
        write_picture(&png, &panel)?;
        outputs.push(png);
        panels.push(panel);
    }
    let sheet = folder.join("sheet.png");
    write_picture(&sheet, &contact_sheet(&panels, COLUMNS))?;
    outputs.push(sheet);
    Ok(outputs)
}

/// All maps in the order of the contact sheet.
fn shown<'a>(maps: &'a DirectorMaps, distances: &'a [f32]) -> Vec<Shown<'a>> {
    let unit = |name, title, values: &'a [f32]| {
        let content = Content::Values(values, [0.0, 1.0]);
        Shown { name, title, content }
    };
    let mut all = vec![
        unit("x", "X: transmittance", &maps.transmittance),
        Shown { name: "z", title: "Z: distance, m", content: Content::Distances(distances) },
    ];
    if let Some(cached) = &maps.snapshot {
        let content = Content::Light(&cached.snapshot.snapshot);
        all.push(Shown { name: "snapshot", title: "snapshot", content });
    }
    if let Some(image) = &maps.false_medium {
        let content = Content::Light(image);
        all.push(Shown { name: "false_medium", title: "false medium", content });
    }
    if let Some(saliency) = &maps.saliency {
        all.push(unit("intensity", "conspicuity: intensity", &saliency.intensity));
        all.push(unit("color", "conspicuity: colour", &saliency.color));
        all.push(unit("orientation", "conspicuity: orientation", &saliency.orientation));
        all.push(unit("saliency", "S: saliency", &saliency.map));
    }
    if let Some(pilot) = &maps.pilot {
        all.push(Shown { name: "pilot", title: "pilot", content: Content::Light(pilot) });
    }
    all.push(unit("x_scattering", "X: uncertainty of visible light", &maps.scattering_x));
    if !maps.error_x.is_empty() {
        all.push(unit("x_error", "X: measured error", &maps.error_x));
    }
    all.push(unit("xs", "XS", &maps.xs));
    all
}
