//! Meshes, pictures and settings that cannot be, from outside: one line, exit 1, nothing written.

use std::path::Path;
use std::process::Command as Process;

use assert_cmd::Command;

const CAMERA: &str = "[camera]\nposition = [0, 1, 8]\ntarget = [0, 1, 0]\n";

/// Renders `scene` in `folder`: exit code 1 and one line that says all of `says`; nothing new.
fn refuses(folder: &Path, scene: &str, says: &[&str]) {
    std::fs::write(folder.join("s.toml"), format!("{CAMERA}{scene}\n")).unwrap();
    let files = || std::fs::read_dir(folder).unwrap().count();
    let before = files();
    let output = Command::new(assert_cmd::cargo::cargo_bin!("fogbow"))
        .current_dir(folder)
        .args(["render", "s.toml", "-o", "a.exr", "--quiet"])
        .timeout(std::time::Duration::from_secs(30))
        .output()
        .unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{says:?}: {message}");
    assert!(message.starts_with("error: s.toml:"), "{message}");
    assert_eq!(message.lines().count(), 1, "{message}");
    assert!(says.iter().all(|words| message.contains(words)), "{says:?}: {message}");
    assert_eq!(files(), before, "something was left: {message}");
}

const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
    property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
    0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

const GLTF: &str = r#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
    "buffers":[{"byteLength":36,"uri":"FILE"}],"bufferViews":[{"buffer":0,"byteLength":36}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3",
    "min":[0,0,0],"max":[1,1,0]}]}"#;

#[test]
fn meshes() {
    let folder = tempfile::tempdir().unwrap();
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let binary = PLY.replace("ascii", "binary_little_endian");
    let binary = &binary[..binary.find("0 0 0").unwrap()];
    let bare = "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000000\nend_header\n";
    let below = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/-11 3/1\n";
    let rows: [(&str, String, &str); 15] = [
        ("empty.obj", String::new(), "no triangles"),
        ("cut.obj", triangle[..20].into(), "no OBJ file"),
        ("index.obj", triangle.replace('3', "4"), "out of bounds"),
        ("huge.obj", triangle.replace("1 2 3", "1 2 99999999999999999999"), "no OBJ file"),
        ("nan.obj", triangle.replace("v 1 0", "v nan 0"), "finite"),
        ("far.obj", triangle.replace("v 1 0", "v 1e39 0"), "finite"),
        ("below.obj", below.into(), "is"), // tobj panics where overflow is checked
        ("cut.ply", PLY[..PLY.len() - 12].into(), "no PLY file"),
        ("binary.ply", binary.into(), "no PLY file"),
        ("count.ply", PLY.replace("vertex 3", "vertex 4000000000000"), "claims 4000000000000"),
        ("bare.ply", bare.into(), "claims 4000000000000"),
        ("index.ply", PLY.replace("3 0 1 2", "3 0 1 7"), "vertex indices"),
        ("nan.ply", PLY.replace("1 0 0", "1 nan 0"), "no PLY file"),
        ("cut.gltf", GLTF[..200].into(), "no glTF file"),
        ("device.gltf", GLTF.replace("FILE", "file:///dev/zero"), "is a pipe or a device"),
    ];
    for (name, text, says) in rows {
        std::fs::write(folder.path().join(name), text).unwrap();
        let scene = format!("[[surface]]\nshape = \"mesh\"\nfile = \"{name}\"");
        refuses(folder.path(), &scene, &["s.toml:6:8: surface[0].file", name, says]);
    }
}

#[test]
fn pipes_are_not_waited_for() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    for name in ["pipe.obj", "pipe.png", "pipe.bin"] {
        assert!(Process::new("mkfifo").arg(path(name)).status().unwrap().success());
    }
    std::fs::write(path("a.gltf"), GLTF.replace("FILE", "pipe.bin")).unwrap();
    let texture = "newmtl m\nmap_Kd pipe.png\n";
    std::fs::write(path("a.mtl"), texture).unwrap();
    let mesh = "mtllib a.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    std::fs::write(path("a.obj"), mesh).unwrap();
    let surface = |file: &str| format!("[[surface]]\nshape = \"mesh\"\nfile = \"{file}\"");
    refuses(folder.path(), &surface("pipe.obj"), &["pipe.obj", "is not a file"]);
    refuses(folder.path(), &surface("a.gltf"), &["pipe.bin", "is a pipe or a device"]);
    refuses(folder.path(), &surface("a.obj"), &["pipe.png", "is a pipe or a device"]);
}

#[test]
fn pictures() {
    use exr::prelude::*;
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, value: f32| {
        write_rgb_file(folder.path().join(name), 16, 8, |_, _| (value, value, value)).unwrap();
        std::fs::read(folder.path().join(name)).unwrap()
    };
    let sky = write("sky.exr", 1.0);
    write("nan.exr", f32::NAN);
    std::fs::write(folder.path().join("cut.exr"), &sky[..sky.len() / 2]).unwrap();
    std::fs::write(folder.path().join("head.exr"), &sky[..20]).unwrap();
    std::fs::write(folder.path().join("text.exr"), "no picture").unwrap();
    std::fs::write(folder.path().join("empty.exr"), "").unwrap();
    // The data window, a box of four numbers, claims 30000 x 30000 pixels.
    let window = sky.windows(10).position(|w| w == b"dataWindow").unwrap() + 10 + 1 + 6 + 4;
    let mut claims = sky;
    for at in [window + 8, window + 12] {
        claims[at..at + 4].copy_from_slice(&29_999i32.to_le_bytes());
    }
    std::fs::write(folder.path().join("claims.exr"), claims).unwrap();
    let rows = [
        ("nan.exr", "NaN"),
        ("cut.exr", "damaged"),
        ("head.exr", "damaged"),
        ("text.exr", "EXR, HDR, TIFF, PNG or JPEG"),
        ("empty.exr", "EXR, HDR, TIFF, PNG or JPEG"),
        ("claims.exr", "claims"),
    ];
    for (name, says) in rows {
        let scene = format!("[[light]]\ntype = \"environment\"\ntexture = \"{name}\"");
        refuses(folder.path(), &scene, &["s.toml:6:11: light[0].texture", name, says]);
    }
}

#[test]
fn counts_beyond_all_memory() {
    let folder = tempfile::tempdir().unwrap();
    let rows: [(&str, &[&str]); 6] = [
        ("[film]\nsize = [1000000000, 1000000000]", &["film.size[0]", "`1000000000`", "65536"]),
        ("[film]\nsize = [65536, 65536]", &["film.size", "268435456 pixels"]),
        ("[render]\nphotons = 1e18", &["render.photons", "`1e18`", "200000000"]),
        ("[render]\nphotons = 1_000_000_000_000_000_000", &["render.photons", "200000000"]),
        ("[render]\nrays = 1_000_000_000_000", &["render.rays", "1048576"]),
        ("[render]\nmax_scatter = 9223372036854775807", &["render.max_scatter", "1000000"]),
    ];
    for (scene, says) in rows {
        refuses(folder.path(), scene, says);
    }
    let many = "[[light]]\ntype = \"point\"\nposition = [0, 0, 0]\npower = 1\n".repeat(5000);
    refuses(folder.path(), &many, &["light", "5000 of them", "4096"]);
}
