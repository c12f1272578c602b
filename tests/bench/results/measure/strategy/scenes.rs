//! The scenes in which strategies are compared, each as the text of a scene file.
//!
//! Those that ship and the bare files are their own, with fewer pixels. The made ones vary optical
//! thickness, albedo, mean cosine, detail of the grid and where the light comes from.

use std::fs;
use std::path::{Path, PathBuf};

use fogbow::make::Kind;
use fogbow::scene::{LoadOptions, Look, LookOptions, Scene};
use toml::{Table, Value};

use super::super::scene_text::{
    FLOOR, HIGHER, LAMP_ASIDE, LAMP_INSIDE, PANEL, SKY, SKY_ABOVE, SUN_BEHIND, grid, make_grids,
    photons, region,
};
use super::super::scenes::{shared, shipped};
use crate::pages::Result;

/// A scene with its text, in which files are named by their whole path.
pub struct StrategyScene {
    pub name: String,
    pub text: String,
}

/// Pixels along the longer side of what ships and of the bare files.
const SIDE: i64 = 96;

/// Photons of what ships, and of bare files by default, over those here. Their pictures are larger: with all
/// photons here, shooting them would take nearly all of the time.
const PHOTONS_PART: i64 = 4;

/// Scenes of `volumes/`. That of the Stanford Lucy is left out: her mesh does not ship.
const SHIPPED: [&str; 7] = ["smoke", "cloud", "fire", "balls_a", "balls_b", "lucy", "road"];

/// Files beside the repository that are rendered alone with the look `none`.
const BARE: [&str; 3] =
    ["smoke/smoke_v222.vdb", "cloud/singlecloud.vdb", "gas_sequence/fluid_data_0010.vdb"];

/// The file of the scene that is lit from the side.
const SIDE_LIT: &str = "smoke/smoke_v222.vdb";

/// Grids of the made scenes: name, kind, voxels along the longest side and its length in metres.
const GRIDS: [(&str, Kind, u32, f64); 2] =
    [("plume.vdb", Kind::Smoke, 48, 2.0), ("detail.vdb", Kind::Cloud, 160, 2.0)];

const FRONT: &str = "[camera]\nposition = [0.0, 0.0, 5.0]\ntarget = [0.0, 0.0, 0.0]\nfov = 30.0\n";
const WITHIN: &str =
    "[camera]\nposition = [0.2, 0.1, 1.2]\ntarget = [0.0, 0.0, -1.0]\nfov = 60.0\n";
const FILM: &str = "[film]\nsize = [64, 64]\n";

const SUN_IN_FRONT: &str =
    "[[light]]\ntype = \"sun\"\ndirection = [0.2, -0.3, -1.0]\nirradiance = 3.0\n";
const SUN_ASIDE: &str =
    "[[light]]\ntype = \"sun\"\ndirection = [1.0, -0.3, 0.0]\nirradiance = 3.0\n";
const MIRROR: &str = "[[surface]]\nshape = \"quad\"\ncenter = [0.7, 1.0, -1.0]\nu = [0.8, 0.0, 0.4]\n\
                      v = [0.0, 1.2, 0.0]\nmaterial = { type = \"mirror\", reflectance = 0.9 }\n";

const BALL: &str = "sphere = { center = [0.0, 0.0, 0.0], radius = 1.0 }";
const BOX: &str = "box = { min = [-1.0, -1.0, -1.0], max = [1.0, 1.0, 1.0] }";
const ROOM: &str = "box = { min = [-3.0, -3.0, -3.0], max = [3.0, 3.0, 3.0] }";
const BANK: &str = "box = { min = [-4.0, -1.0, 2.0], max = [4.0, 2.5, 8.0] }";

/// The made scenes: name and text. Balls, boxes and plumes are about 2 m thick.
fn made() -> Vec<(&'static str, String)> {
    let scenes: [(&str, &[&str]); 9] = [
        (
            "thin ball, thickness 0.1, albedo 0.5, sun in front",
            &[FRONT, FILM, &photons(100_000), &region(BALL, 0.05, 0.5, 0.0), SUN_IN_FRONT],
        ),
        (
            "ball, thickness 1, g 0.85, sun behind",
            &[FRONT, FILM, &photons(100_000), &region(BALL, 0.5, 0.95, 0.85), SUN_BEHIND],
        ),
        (
            "box, thickness 16, albedo 0.9999, sky alone",
            &[FRONT, FILM, &photons(100_000), &region(BOX, 8.0, 0.9999, 0.0), SKY_ABOVE],
        ),
        (
            "ball, thickness 300, albedo 0.9999, g 0.85, sun aside",
            &[FRONT, FILM, &photons(20_000), &region(BALL, 150.0, 0.9999, 0.85), SUN_ASIDE, SKY],
        ),
        (
            "plume, g -0.5, lamp inside",
            &[
                HIGHER,
                FILM,
                &photons(100_000),
                &grid("plume.vdb", 40.0, 0.95, -0.5),
                LAMP_INSIDE,
                SKY,
            ],
        ),
        (
            "detailed cloud, albedo 0.9999, g 0.95, sun in front",
            &[
                HIGHER,
                FILM,
                &photons(100_000),
                &grid("detail.vdb", 24.0, 0.9999, 0.95),
                SUN_IN_FRONT,
            ],
        ),
        (
            "camera inside, thickness 4, g 0.3, sun aside",
            &[WITHIN, FILM, &photons(100_000), &region(ROOM, 0.7, 0.95, 0.3), SUN_ASIDE, SKY],
        ),
        (
            "fog bank round the camera and a plume, lamp",
            &[
                HIGHER,
                FILM,
                &photons(100_000),
                &region(BANK, 0.3, 0.95, 0.3),
                &grid("plume.vdb", 20.0, 0.95, 0.3),
                FLOOR,
                LAMP_ASIDE,
            ],
        ),
        (
            "plume and a mirror, lamp",
            &[
                HIGHER,
                FILM,
                &photons(100_000),
                &grid("plume.vdb", 20.0, 0.95, 0.3),
                MIRROR,
                FLOOR,
                PANEL,
            ],
        ),
    ];
    scenes.into_iter().map(|(name, parts)| (name, parts.concat())).collect()
}

/// All scenes, with their grids in `folder`, and a sentence for each that is left out.
pub fn scenes(folder: &Path) -> Result<(Vec<StrategyScene>, Vec<String>)> {
    let folder = made_grids(folder)?;
    let (mut scenes, left_out) = scenes_of_files()?;
    for (name, text) in made() {
        scenes.push(StrategyScene { name: name.into(), text: by_whole_paths(&text, &folder)? });
    }
    Ok((scenes, left_out))
}

/// Those that ship, and those of files beside the repository.
pub fn scenes_of_files() -> Result<(Vec<StrategyScene>, Vec<String>)> {
    let (mut scenes, mut left_out) = (Vec::new(), Vec::new());
    for name in SHIPPED {
        scenes.push(shipped_scene(name)?);
    }
    for file in BARE {
        match shared(file) {
            Some(path) => scenes.push(bare_scene(&path)?),
            None => left_out.push(format!("{file} was not there and is left out.")),
        }
    }
    match side_lit_smoke()? {
        Some(scene) => scenes.push(scene),
        None => left_out.push("The smoke lit from the side was not there and is left out.".into()),
    }
    Ok((scenes, left_out))
}

/// Frames of a flight from outside of the shipped cloud to its middle.
pub fn fly_in(frames: u32) -> Result<Vec<StrategyScene>> {
    let cloud = shipped_scene("cloud")?;
    let (from, to) = ([0.0, 90.0, 1500.0], [0.0, 255.0, 0.0]);
    (0..frames)
        .map(|frame| {
            let along = f64::from(frame) / f64::from(frames.max(2) - 1);
            let position = [0, 1, 2].map(|axis| from[axis] + along * (to[axis] - from[axis]));
            let mut scene: Table = cloud.text.parse()?;
            let camera = table(&mut scene, "camera");
            camera.insert("position".into(), position.to_vec().into());
            camera.insert("target".into(), vec![0.0, 255.0, -1000.0].into());
            let name = format!("flight into the cloud, frame {:02}", frame + 1);
            Ok(StrategyScene { name, text: toml::to_string(&scene)? })
        })
        .collect()
}

/// Makes the grids in `folder`, and returns it by its whole path.
fn made_grids(folder: &Path) -> Result<PathBuf> {
    fs::create_dir_all(folder)?;
    for (name, kind, resolution, longest) in GRIDS {
        make_grids(&folder.join(name), kind, resolution, Some(longest))?;
    }
    Ok(folder.canonicalize()?)
}

/// A scene of `volumes/`, with fewer pixels and photons.
fn shipped_scene(name: &str) -> Result<StrategyScene> {
    let path = shipped(name);
    let folder = path.parent().unwrap_or(Path::new("")).canonicalize()?;
    let mut scene: Table = by_whole_paths(&fs::read_to_string(&path)?, &folder)?.parse()?;
    let film = table(&mut scene, "film");
    let size: Vec<i64> = film["size"].clone().try_into()?;
    let longer = size.iter().copied().max().unwrap_or(1);
    let size: Vec<i64> = size.iter().map(|side| (side * SIDE / longer).max(1)).collect();
    film.insert("size".into(), size.into());
    let render = table(&mut scene, "render");
    let photons = render["photons"].as_integer().ok_or("photons are a number")?;
    render.insert("photons".into(), (photons / PHOTONS_PART).into());
    Ok(StrategyScene { name: format!("{name}.toml"), text: toml::to_string(&scene)? })
}

/// A VDB file alone with the look `none`.
fn bare_scene(path: &Path) -> Result<StrategyScene> {
    let size = [SIDE as u32, SIDE as u32 * 2 / 3];
    let look = LookOptions { look: Some(Look::None), ..LookOptions::default() };
    let options = LoadOptions { look, ..LoadOptions::default().size(size) };
    let scene = Scene::load(path, &options)?;
    let options = options.photons(scene.render.photons / PHOTONS_PART.unsigned_abs());
    let made = scene.made.as_ref().ok_or("a VDB file alone has a made scene")?;
    let mut draft = made.draft.clone().with(&options.settings);
    draft.set_file(&path.canonicalize()?.to_string_lossy());
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    Ok(StrategyScene { name: format!("{name}, bare"), text: draft.text() })
}

/// A smoke with the sun from the side, where its file is there.
pub fn side_lit_smoke() -> Result<Option<StrategyScene>> {
    let Some(path) = shared(SIDE_LIT) else { return Ok(None) };
    let path = path.canonicalize()?;
    let text = "[camera]\nposition = [0.0, 45.0, 210.0]\ntarget = [-7.0, 40.0, 0.0]\nfov = 36.0\n\
                [film]\nsize = [128, 128]\n"
        .to_owned()
        + &grid(&path.to_string_lossy(), 1.0, 0.95, 0.3)
        + SUN_ASIDE
        + SKY;
    Ok(Some(StrategyScene { name: "smoke_v222.vdb, sun aside".into(), text }))
}

/// The text of a scene in which files are named by their whole path.
fn by_whole_paths(text: &str, folder: &Path) -> Result<String> {
    let mut scene: Value = Value::Table(text.parse()?);
    name_whole(&mut scene, folder);
    Ok(toml::to_string(&scene)?)
}

fn name_whole(value: &mut Value, folder: &Path) {
    match value {
        Value::Table(table) => {
            for (key, value) in table.iter_mut() {
                match value {
                    Value::String(file) if ["file", "texture", "mesh"].contains(&key.as_str()) => {
                        *file = folder.join(&*file).to_string_lossy().into_owned();
                    }
                    _ => name_whole(value, folder),
                }
            }
        }
        Value::Array(values) => values.iter_mut().for_each(|value| name_whole(value, folder)),
        _ => {}
    }
}

/// The table of this name, which is there afterwards.
fn table<'a>(scene: &'a mut Table, name: &str) -> &'a mut Table {
    let entry = scene.entry(name).or_insert_with(|| Value::Table(Table::new()));
    if !entry.is_table() {
        *entry = Value::Table(Table::new());
    }
    entry.as_table_mut().expect("it was just made one")
}
