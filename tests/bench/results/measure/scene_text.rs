//! Parts of the text of made scenes.

use std::fmt::Display;
use std::path::{Path, PathBuf};

use fogbow::make::{Kind, Settings, make};
use fogbow::vdb;

use crate::pages::Result;

/// A camera in front of what stands on the floor, 2 m high.
pub const HIGHER: &str =
    "[camera]\nposition = [0.0, 1.0, 5.0]\ntarget = [0.0, 1.0, 0.0]\nfov = 30.0\n";

pub const FLOOR: &str = "[[surface]]\nshape = \"plane\"\npoint = [0.0, 0.0, 0.0]\n\
                         normal = [0.0, 1.0, 0.0]\n\
                         material = { type = \"diffuse\", reflectance = 0.4 }\n";

pub const SUN_BEHIND: &str =
    "[[light]]\ntype = \"sun\"\ndirection = [0.3, -0.3, 1.0]\nirradiance = 3.0\n";
pub const SKY: &str = "[[light]]\ntype = \"environment\"\nradiance = 0.1\n";
pub const SKY_ABOVE: &str = "[[light]]\ntype = \"environment\"\n\
                             gradient = [[-90.0, 0.05], [0.0, 0.2], [90.0, 1.0]]\n";
pub const LAMP_INSIDE: &str =
    "[[light]]\ntype = \"point\"\nposition = [0.0, 0.8, 0.0]\nintensity = 5.0\n";
pub const LAMP_ASIDE: &str =
    "[[light]]\ntype = \"point\"\nposition = [2.0, 3.0, 1.0]\nintensity = 20.0\n";
pub const PANEL: &str = "[[light]]\ntype = \"area\"\ncenter = [-2.0, 2.6, 1.0]\nu = [0.0, 0.0, 0.5]\n\
     v = [-0.3, -0.4, 0.0]\nradiance = 30.0\n";

/// A homogeneous medium in a region.
pub fn region(shape: &str, sigma_t: f64, albedo: impl Display, g: f64) -> String {
    medium(&format!("region = {{ {shape} }}"), sigma_t, albedo, g)
}

/// The medium of a grid.
pub fn grid(file: &str, sigma_t: f64, albedo: impl Display, g: f64) -> String {
    medium(&format!("file = \"{file}\""), sigma_t, albedo, g)
}

fn medium(density: &str, sigma_t: f64, albedo: impl Display, g: f64) -> String {
    format!(
        "[[medium]]\n{density}\nsigma_t = {sigma_t:?}\nalbedo = {albedo}\n\
         phase = {{ type = \"henyey-greenstein\", g = {g:?} }}\n"
    )
}

pub fn photons(photons: u64) -> String {
    format!("[render]\nphotons = {photons}\n")
}

/// Makes grids in a file, with so many voxels along the longest side, which has the length `longest` in metres where that is
/// given.
pub fn make_grids(
    path: &Path,
    kind: Kind,
    resolution: u32,
    longest: Option<f64>,
) -> Result<PathBuf> {
    let voxel = longest.map(|longest| longest / f64::from(resolution));
    vdb::write(path, &make(kind, &Settings { seed: 1, resolution, voxel })?)?;
    Ok(path.into())
}

/// A small lamp in a box of fog, over a floor.
pub const LAMP_IN_FOG: &str = "\
[camera]
position = [0.0, 1.6, 7.0]
target = [0.0, 1.4, 0.0]
fov = 40.0
[film]
size = [128, 128]
[render]
rays = 16
photons = 500_000
[[medium]]
region = { box = { min = [-8.0, -8.0, -8.0], max = [8.0, 8.0, 8.0] } }
sigma_t = 0.15
albedo = 0.97
phase = { type = \"henyey-greenstein\", g = 0.5 }
[[surface]]
shape = \"plane\"
point = [0.0, 0.0, 0.0]
normal = [0.0, 1.0, 0.0]
material = { type = \"diffuse\", reflectance = 0.5 }
[[light]]
type = \"area\"
center = [0.0, 3.0, 0.0]
u = [0.2, 0.0, 0.0]
v = [0.0, 0.0, 0.2]
radiance = 100.0
";
