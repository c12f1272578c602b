//! What tests of pictures in parts share: a scene, renders of it, and merges.

use std::fs;
use std::path::Path;

use fogbow::image::{Layers, read_layers};
use serde_json::Value;
use tempfile::TempDir;

use crate::run;

/// A box of smoke over a floor, of this `albedo` in TOML, and so many rays and photons.
pub fn smoke(rays: u32, photons: u32, albedo: &str) -> String {
    format!(
        "\
[camera]
position = [0, 1, 8]
target = [0, 1, 0]
[film]
size = [24, 20]
[render]
rays = {rays}
photons = {photons}
seed = 5
[[medium]]
region = {{ box = {{ min = [-1.0, 0.0, -1.0], max = [1.0, 2.0, 1.0] }} }}
sigma_t = 3.0
albedo = {albedo}
phase = {{ type = \"henyey-greenstein\", g = 0.5 }}
[[surface]]
shape = \"plane\"
point = [0, 0, 0]
normal = [0, 1, 0]
material = {{ type = \"diffuse\", reflectance = 0.7 }}
[[light]]
type = \"area\"
center = [2, 5, 2]
u = [1, 0, 0]
v = [0, 0, 1]
radiance = [20, 16, 12]
"
    )
}

/// Renders the scene s.toml in `folder` with these arguments and without a warning; the report.
pub fn report(folder: &Path, args: &[&str]) -> Value {
    let args = [&["render", "s.toml", "--quiet", "--json"], args].concat();
    let (code, out, err) = run(folder, &args);
    assert_eq!((code, err.as_str()), (0, ""), "{args:?}");
    serde_json::from_str(&out).unwrap()
}

/// A folder with copies of all files of `folder`.
pub fn copied(folder: &Path) -> TempDir {
    let copy = tempfile::tempdir().unwrap();
    for entry in fs::read_dir(folder).unwrap() {
        let entry = entry.unwrap();
        fs::copy(entry.path(), copy.path().join(entry.file_name())).unwrap();
    }
    copy
}

/// Merges without a warning; what is printed.
pub fn merges(folder: &Path, parts: &[impl AsRef<str>], output: &str) -> String {
    let parts: Vec<&str> = parts.iter().map(AsRef::as_ref).collect();
    let (code, out, err) = run(folder, &[&["merge"], &parts[..], &["-o", output]].concat());
    assert_eq!((code, err.as_str()), (0, ""), "{parts:?}");
    out
}

/// That merging is refused with exit code 1 and one line that says all of `says`, and that an earlier output stays and
/// nothing else is left.
pub fn refuses(folder: &Path, parts: &[&str], says: &[&str]) {
    let listing = || fs::read_dir(folder).unwrap().count();
    fs::write(folder.join("out.exr"), "earlier").unwrap();
    let before = listing();
    let (code, out, err) = run(folder, &[&["merge"], parts, &["-o", "out.exr"]].concat());
    assert_eq!((code, out.as_str(), err.lines().count()), (1, "", 1), "{parts:?}: {err}");
    assert!(says.iter().all(|words| err.contains(words)), "{says:?}: {err}");
    assert_eq!(fs::read(folder.join("out.exr")).unwrap(), b"earlier");
    assert_eq!(listing(), before, "{err}");
}

pub fn layers(folder: &Path, name: &str) -> Layers {
    read_layers(&folder.join(name)).unwrap()
}

/// The sum of all luminances.
pub fn light(layers: &Layers) -> f64 {
    layers.image().unwrap().luminances().sum()
}
