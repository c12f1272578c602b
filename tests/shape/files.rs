//! Mesh files: the shared ones load, broken ones are errors with one message.

use std::io::Write;
use std::path::Path;

use fogbow::shape::{TextureSource, load_mesh};
use glam::DAffine3;

use crate::skip;

const ASCII_PLY: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\n\
    property float y\nproperty float z\nelement face 1\n\
    property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n";

fn binary_ply() -> Vec<u8> {
    let mut bytes =
        ASCII_PLY.split("0 0 0").next().unwrap().replace("ascii", "binary_little_endian");
    bytes.truncate(bytes.find("end_header\n").unwrap() + 11);
    let mut bytes = bytes.into_bytes();
    for x in [0f32, 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.] {
        bytes.extend(x.to_le_bytes());
    }
    bytes.push(4);
    for i in 0i32..4 {
        bytes.extend(i.to_le_bytes());
    }
    bytes
}

fn glb() -> Vec<u8> {
    let mut json = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
        "nodes":[{"mesh":0,"translation":[10,0,0]}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"material":0}]}],
        "materials":[{"name":"red","pbrMetallicRoughness":{"baseColorFactor":[1,0.5,0,1]}}],
        "buffers":[{"byteLength":44}],
        "bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":6}],
        "accessors":[
        {"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
        {"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"}]}"#
        .as_bytes()
        .to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut bin = Vec::new();
    for x in [0f32, 0., 0., 1., 0., 0., 0., 1., 0.] {
        bin.extend(x.to_le_bytes());
    }
    for i in [0u16, 1, 2, 0] {
        bin.extend(i.to_le_bytes());
    }
    let mut out = b"glTF".to_vec();
    let total = 12 + 8 + json.len() + 8 + bin.len();
    out.extend([2u32, total as u32, json.len() as u32].iter().flat_map(|x| x.to_le_bytes()));
    out.extend(b"JSON");
    out.extend(json);
    out.extend((bin.len() as u32).to_le_bytes());
    out.extend(b"BIN\0");
    out.extend(bin);
    out
}

fn load(name: &str, bytes: &[u8]) -> Result<fogbow::shape::LoadedMesh, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::File::create(&path).unwrap().write_all(bytes).unwrap();
    load_mesh(&path, &DAffine3::IDENTITY).map_err(|e| {
        let message = e.to_string();
        assert!(message.contains(name) && !message.contains('\n'), "{message}");
        message
    })
}

#[test]
fn good_files_load() {
    assert_eq!(load("a.ply", ASCII_PLY.as_bytes()).unwrap().mesh.triangle_count(), 2);
    assert_eq!(load("a.ply", &binary_ply()).unwrap().mesh.triangle_count(), 2);
    let loaded = load("a.glb", &glb()).unwrap();
    assert_eq!(loaded.mesh.bounds().min.xyz.x, 10.0);
    assert_eq!(
        (loaded.materials[0].name.as_str(), loaded.materials[0].color),
        ("red", [1.0, 0.5, 0.0])
    );
}

#[test]
fn shared_meshes_load() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/meshes");
    if !folder.exists() {
        skip::skip(folder.display());
        return;
    }
    let table = [
        ("bunny.obj", 69_451, false),
        ("dragon.obj", 100_000, true),
        ("lucy.obj", 99_970, true),
        ("spot.obj", 5_856, true),
        ("teapot.obj", 6_320, false),
        ("road/vehicle-truck-yellow.obj", 989, false),
        ("road/track-straight.obj", 106, false),
        ("road/track-corner.obj", 1_136, false),
        ("road/decoration-forest.obj", 2_006, false),
    ];
    for (name, triangles, closed) in table {
        let loaded = load_mesh(&folder.join(name), &DAffine3::IDENTITY).expect(name);
        assert_eq!(loaded.mesh.triangle_count(), triangles, "{name}");
        assert_eq!(loaded.mesh.is_closed(), closed, "{name}");
        for material in loaded.materials {
            if let Some(TextureSource::Path(path)) = material.texture {
                assert!(path.exists(), "{}", path.display());
            }
        }
    }
}

#[test]
fn truncated_files_are_errors() {
    let good =
        [("a.ply", ASCII_PLY.as_bytes().to_vec()), ("a.ply", binary_ply()), ("a.glb", glb())];
    for (name, bytes) in good {
        for end in 0..bytes.len() {
            // Only the last bytes (a closing newline, padding) may be missing.
            assert!(load(name, &bytes[..end]).is_err() || end + 3 > bytes.len(), "{name} {end}");
        }
    }
}

#[test]
fn damaged_files_never_panic() {
    let good =
        [("a.ply", ASCII_PLY.as_bytes().to_vec()), ("a.ply", binary_ply()), ("a.glb", glb())];
    for (name, bytes) in good {
        for i in 0..bytes.len() {
            for byte in [0, b'9', b'-', 0xff] {
                let mut damaged = bytes.clone();
                damaged[i] = byte;
                drop(load(name, &damaged));
            }
        }
    }
}

#[test]
fn nodes_that_contain_themselves_are_an_error() {
    let text = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
        "nodes":[{"children":[0,0]}]}"#;
    assert!(load("a.gltf", text.as_bytes()).unwrap_err().contains("trees"));
}

#[test]
fn each_problem_has_its_message() {
    let cases: [(&str, &str, &str); 9] = [
        ("a.obj", "v 0 0 0\n", "no triangles"),
        ("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "out of bounds"),
        ("a.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "finite"),
        ("a.obj", "v 0 0 x\nf 1 1 1\n", "no OBJ file"),
        ("a.ply", &ASCII_PLY.replace("4 0 1 2 3", "4 0 1 2 7"), "vertex indices"),
        ("a.ply", &ASCII_PLY.replace("4 0 1 2 3", "4 0 1 2 -3"), "below 0"),
        ("a.ply", "plx\n", "no PLY file"),
        ("a.gltf", "{", "no glTF file"),
        ("a.stl", "solid", "must end in"),
    ];
    for (name, text, expected) in cases {
        let message = load(name, text.as_bytes()).unwrap_err();
        assert!(message.contains(expected), "{message}");
    }
    let missing = load_mesh(Path::new("nowhere.obj"), &DAffine3::IDENTITY).unwrap_err();
    assert_eq!(missing.to_string(), "nowhere.obj: does not exist");
}
