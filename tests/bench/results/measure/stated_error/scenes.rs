//! The scenes whose errors are compared, each with the error that it is rendered to.
//!
//! Goals are such that a picture takes about a second. The made scenes are what a measure of noise may miss or take for
//! done: faint light, light that few paths find, bright spots of few pixels, peaked phase functions.

use std::fs;
use std::path::{Path, PathBuf};

use fogbow::make::Kind;
use fogbow::scene::{LoadOptions, Scene};

use super::super::scene_text::{
    FLOOR, HIGHER, LAMP_ASIDE, LAMP_INSIDE, PANEL, SKY, SKY_ABOVE, SUN_BEHIND, grid, make_grids,
    photons, region,
};
use super::super::scenes::{scaled, shipped};
use crate::pages::Result;

/// Pixels along the longer side.
const SIDE: u32 = 96;

/// Scenes of `volumes/`, with their goals.
const SHIPPED: [(&str, f64); 6] = [
    ("smoke", 0.25),
    ("cloud", 0.2),
    ("fire", 0.6),
    ("road", 0.6),
    ("lucy", 0.3),
    ("balls_a", 2.0),
];

/// Made files that are rendered alone, with their goals.
const BARE: [(&str, Kind, f64); 2] = [("smoke", Kind::Smoke, 0.15), ("fire", Kind::Fire, 0.2)];

/// Voxels along the longest side of made grids, and the length of the plume in metres.
const RESOLUTION: u32 = 48;
const PLUME_LENGTH: f64 = 2.0;

const FILM: &str = "[film]\nsize = [96, 54]\n";
const WITHIN: &str =
    "[camera]\nposition = [0.2, 1.1, 1.2]\ntarget = [0.0, 1.0, -1.0]\nfov = 60.0\n";
const ROOM: &str = "box = { min = [-3.0, 0.0, -3.0], max = [3.0, 3.0, 6.0] }";
const BANK: &str = "box = { min = [-4.0, 0.0, 2.0], max = [4.0, 2.5, 8.0] }";
const BOX: &str = "box = { min = [-1.0, 0.0, -1.0], max = [1.0, 2.0, 1.0] }";
const BALL: &str = "sphere = { center = [0.0, 1.0, 0.0], radius = 1.0 }";
const FLAME: &str = "[[medium]]\nfile = \"flame.vdb\"\nsigma_t = 12.0\nalbedo = [0.55, 0.5, 0.45]\n\
                     emission = { temperature = \"temperature\", kelvin_scale = 1800.0, scale = 0.1 }\n";

const SMALL_LAMP: &str = "[[light]]\ntype = \"area\"\ncenter = [0.4, 1.6, 0.0]\nu = [0.1, 0.0, 0.0]\n\
                          v = [0.0, -0.1, 0.0]\nradiance = 100.0\n";
const HIDDEN_LAMP: &str =
    "[[light]]\ntype = \"point\"\nposition = [2.2, 1.5, -2.4]\nintensity = 20.0\n";
const COLOURED_LAMPS: &str = "[[light]]\ntype = \"point\"\nposition = [2.0, 2.0, 1.0]\n\
                              intensity = [20.0, 2.0, 0.5]\n\
                              [[light]]\ntype = \"point\"\nposition = [-2.0, 1.5, 1.0]\n\
                              intensity = [0.5, 2.0, 20.0]\n";
const SPOT: &str = "[[light]]\ntype = \"spot\"\nposition = [-2.0, 2.5, 0.0]\ntarget = [0.5, 0.0, 0.0]\n\
                    angle = 12.0\nfalloff = 4.0\nintensity = 60.0\n";
const SUN_ABOVE: &str =
    "[[light]]\ntype = \"sun\"\ndirection = [-0.5, -1.0, -0.6]\nirradiance = 3.0\nangle = 10.0\n";
const SUN_ASIDE: &str =
    "[[light]]\ntype = \"sun\"\ndirection = [1.0, -0.3, -0.2]\nirradiance = 3.0\n";

/// A scene, and the error that it is rendered to.
pub struct GoalScene {
    /// In words.
    pub title: String,
    /// Relative error.
    pub goal: f64,
    /// A scene, or a VDB file.
    pub path: PathBuf,
}

impl GoalScene {
    /// Width and height of its film with the longer side divided by `divisor`.
    pub fn size(&self, divisor: u32) -> Result<[u32; 2]> {
        scaled(&self.path, SIDE / divisor)
    }

    /// With a film of this size.
    pub fn load(&self, size: [u32; 2]) -> Result<Scene> {
        Ok(Scene::load(&self.path, &LoadOptions::default().size(size))?)
    }
}

/// The plume.
fn plume(sigma_t: f64, albedo: &str) -> String {
    grid("plume.vdb", sigma_t, albedo, 0.3)
}

/// A box of diffuse walls.
fn wall(min: [f64; 3], max: [f64; 3]) -> String {
    format!(
        "[[surface]]\nshape = \"box\"\nmin = {min:?}\nmax = {max:?}\n\
         material = {{ type = \"diffuse\", reflectance = 0.6 }}\n"
    )
}

/// A ball that stands on the floor.
fn ball(x: f64, z: f64, radius: f64, material: &str) -> String {
    format!(
        "[[surface]]\nshape = \"sphere\"\ncenter = {:?}\nradius = {radius:?}\nmaterial = {{ {material} }}\n",
        [x, radius, z]
    )
}

/// A room whose lamp stands behind a screen.
fn corner() -> String {
    [
        wall([-3.1, 0.0, -3.2], [3.1, 3.0, -3.0]),
        wall([-3.2, 0.0, -3.2], [-3.0, 3.0, 6.0]),
        wall([3.0, 0.0, -3.2], [3.2, 3.0, 6.0]),
        wall([-3.2, 3.0, -3.2], [3.2, 3.1, 6.0]),
        wall([0.6, 0.0, -1.6], [3.0, 3.0, -1.5]),
    ]
    .concat()
}

/// The made scenes: title, goal and text.
fn made() -> Vec<(&'static str, f64, String)> {
    let few = photons(100_000);
    let many = photons(200_000);
    let mirror = ball(0.8, 1.0, 0.4, "type = \"mirror\", reflectance = 0.9");
    let glass = ball(0.8, 0.5, 0.5, "type = \"glass\", ior = 1.5");
    let red = ball(-0.7, 0.0, 0.5, "type = \"diffuse\", reflectance = [0.7, 0.2, 0.1]");
    let back = wall([-3.0, 0.0, -2.1], [3.0, 3.0, -2.0]);
    let scenes: [(&str, f64, &[&str]); 14] = [
        ("faint smoke", 0.15, &[HIGHER, FILM, &few, &plume(0.2, "0.9"), PANEL]),
        (
            "lamp behind a corner, fog",
            0.4,
            &[HIGHER, FILM, &many, &region(ROOM, 0.2, "0.9", 0.3), FLOOR, &corner(), HIDDEN_LAMP],
        ),
        (
            "small lamp seen in fog",
            0.35,
            &[HIGHER, FILM, &many, &region(ROOM, 0.3, "0.95", 0.5), FLOOR, SMALL_LAMP],
        ),
        (
            "glint of the sun on a mirror",
            1.0,
            &[HIGHER, FILM, &few, &plume(4.0, "0.9"), FLOOR, &mirror, SUN_ABOVE, SKY],
        ),
        ("surfaces alone, glass", 0.4, &[HIGHER, FILM, &many, FLOOR, &back, &glass, &red, PANEL]),
        (
            "coloured lamps, coloured smoke",
            0.15,
            &[HIGHER, FILM, &many, &plume(20.0, "[0.95, 0.8, 0.5]"), FLOOR, COLOURED_LAMPS],
        ),
        ("spot in fog", 0.2, &[HIGHER, FILM, &many, &region(ROOM, 0.3, "0.95", 0.6), FLOOR, SPOT]),
        ("flame alone", 0.25, &[HIGHER, FILM, &few, FLAME]),
        (
            "thick cloud",
            0.4,
            &[HIGHER, FILM, &few, &region(BALL, 15.0, "0.9999", 0.85), SUN_ASIDE, SKY],
        ),
        (
            "forward peak, sun behind",
            0.2,
            &[HIGHER, FILM, &few, &region(BALL, 1.0, "0.95", 0.95), SUN_BEHIND],
        ),
        (
            "fog bank and plume",
            0.3,
            &[
                HIGHER,
                FILM,
                &few,
                &region(BANK, 0.3, "0.95", 0.3),
                &plume(20.0, "0.95"),
                FLOOR,
                LAMP_ASIDE,
            ],
        ),
        ("lamp inside a plume", 0.5, &[HIGHER, FILM, &few, &plume(40.0, "0.95"), LAMP_INSIDE, SKY]),
        (
            "box under the sky alone",
            0.1,
            &[HIGHER, FILM, &few, &region(BOX, 8.0, "0.999", 0.0), SKY_ABOVE],
        ),
        (
            "camera inside smoke",
            0.15,
            &[WITHIN, FILM, &few, &region(ROOM, 0.7, "0.95", 0.3), SUN_ASIDE, SKY],
        ),
    ];
    scenes.into_iter().map(|(title, goal, parts)| (title, goal, parts.concat())).collect()
}

/// All of them, those of made files with their files in `folder`.
pub fn scenes(folder: &Path) -> Result<Vec<GoalScene>> {
    fs::create_dir_all(folder)?;
    let grids =
        |name: &str, kind, longest| make_grids(&folder.join(name), kind, RESOLUTION, longest);
    grids("plume.vdb", Kind::Smoke, Some(PLUME_LENGTH))?;
    grids("flame.vdb", Kind::Fire, None)?;
    let mut scenes = Vec::new();
    for (name, goal) in SHIPPED {
        scenes.push(GoalScene { title: format!("{name}.toml"), goal, path: shipped(name) });
    }
    for (name, kind, goal) in BARE {
        let path = grids(&format!("bare_{name}.vdb"), kind, None)?;
        scenes.push(GoalScene { title: format!("made {name}, bare"), goal, path });
    }
    for (title, goal, text) in made() {
        let path = folder.join(format!("{}.toml", title.replace([' ', ','], "_")));
        fs::write(&path, text)?;
        scenes.push(GoalScene { title: title.into(), goal, path });
    }
    Ok(scenes)
}
