//! `fogbow render --deep`: the deep file beside the picture, as oiiotool of OpenImageIO reads it.

use std::fs;

use fogbow::image::read_layers;

use crate::{is_there, printed, run};

/// A ball of smoke half in front of a ball of clay, before a wall that ends within the picture.
const SCENE: &str = "\
[camera]
position = [0, 1, 8]
target = [0, 1, 0]
[film]
size = [37, 29]
[render]
rays = 4
photons = 4000
[[medium]]
region = { sphere = { center = [-0.4, 1.0, 1.0], radius = 1.0 } }
sigma_t = [2.5, 2.0, 1.5]
albedo = 0.8
[[surface]]
shape = \"sphere\"
center = [0.4, 1, 0]
radius = 0.7
[[surface]]
shape = \"quad\"
center = [-0.75, 1, -2]
u = [1.25, 0, 0]
v = [0, 2, 0]
[[light]]
type = \"area\"
center = [2, 5, 2]
u = [1, 0, 0]
v = [0, 0, 1]
radiance = [20, 16, 12]
";

#[test]
fn deep_files_flatten_to_the_picture() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("s.toml"), SCENE).unwrap();
    for (name, more) in [("a.exr", &[][..]), ("b.exr", &["--crop", "5,3,20x17"])] {
        let args = [&["render", "s.toml", "--deep", "-o", name], more].concat();
        let (code, told, err) = run(folder, &args);
        assert_eq!(code, 0, "{err}");
        let deep = name.replace(".exr", ".deep.exr");
        assert!(told.lines().any(|line| line == deep), "{told}");
        let flat = name.replace(".exr", ".flat.exr");
        if !is_there("oiiotool") {
            return;
        }
        let info = printed(folder, "oiiotool", &["--info", "-v", &deep]);
        assert!(info.contains("deep") && info.contains("Z, ZBack"), "{info}");
        assert!(info.contains("worldToNDC: 1.37"), "a matrix: {info}");
        printed(folder, "oiiotool", &[&deep, "--flatten", "-o", &flat]);
        let [picture, flat] = [name, &flat].map(|name| read_layers(&folder.join(name)).unwrap());
        for channel in ["R", "G", "B", "A"] {
            let [right, found] = [&picture, &flat].map(|file| &file.channels[channel]);
            assert_eq!(right.len(), found.len());
            for (right, found) in right.iter().zip(found) {
                assert!(
                    (right - found).abs() <= 1e-4 * right.max(1.0),
                    "{channel}: {found} for {right}"
                );
            }
        }
    }
}

#[test]
fn deep_files_are_bytes_of_the_scene_alone() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("s.toml"), SCENE).unwrap();
    let bytes = |threads: &str| {
        let (code, _, err) =
            run(folder, &["render", "s.toml", "--deep", "-o", "a.exr", "--threads", threads]);
        assert_eq!(code, 0, "{err}");
        fs::read(folder.join("a.deep.exr")).unwrap()
    };
    assert!(bytes("1") == bytes("3"));
}
