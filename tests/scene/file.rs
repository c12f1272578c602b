//! The scene file: what is accepted, and the message for every way to get it wrong.

use std::path::Path;

use fogbow::scene::file::{DensitySection, LightKind, RegionSection, SceneFile, parse};
use proptest::prelude::*;

const CAMERA: &str = "[camera]\nposition = [0, 1, 8]\ntarget = [0, 1, 0]\n";

/// A folder with the files that the scenes below name.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for name in ["smoke.vdb", "mesh.obj", "sky.exr", "wood.png"] {
        std::fs::write(folder.path().join(name), "").unwrap();
    }
    folder
}

fn read(folder: &Path, text: &str) -> fogbow::Result<SceneFile> {
    parse(&folder.join("test.toml"), text)
}

#[test]
fn the_documented_scene_is_read() {
    let folder = folder();
    let file = read(
        folder.path(),
        r#"
        [camera]
        type = "perspective"
        position = [0.0, 1.5, 8.0]
        target = [0, 1, 0]
        fov = 28.0
        [film]
        size = [64, 32]
        view = "srgb"
        [render]
        rays = 4
        photons = 1_000
        director = "fixed"
        [[medium]]
        file = "smoke.vdb"
        grid = "density"
        level_set = "fog"
        sigma_t = [1, 2, 3]
        albedo = { grid = "Cd" }
        phase = { type = "two-lobe", g = [0.8, -0.2], weight = 0.7 }
        emission = { temperature = "temperature", kelvin_scale = 1000 }
        rotate = [0, 90, 0]
        scale = 2
        [[medium]]
        region = { box = { min = [-1, 0, -1], max = [1, 2, 1] } }
        phase = { type = "fog", diameter = 20.0 }
        emission = { color = 1.0, scale = 2.0 }
        [[surface]]
        shape = "mesh"
        file = "mesh.obj"
        emission = [1, 2, 3]
        [[surface]]
        shape = "plane"
        material = { type = "diffuse", reflectance = { texture = "wood.png" } }
        [[light]]
        type = "spot"
        position = [0, 3, 0]
        direction = [0, -1, 0]
        power = 20
        angle = 20
        falloff = 5
        [[light]]
        type = "environment"
        texture = "sky.exr"
        scale = 0.5
        "#,
    )
    .unwrap();
    assert_eq!(file.film.size, [64, 32]);
    assert_eq!(file.render.rays, 4);
    assert_eq!(file.media.len(), 2);
    assert_eq!(file.media[1].name, "medium[1]");
    let x = file.media[0].placement.transform_point3(glam::DVec3::X);
    assert!(x.distance(glam::DVec3::new(0.0, 0.0, -2.0)) < 1e-12);
    assert!(matches!(file.media[1].density, DensitySection::Region(RegionSection::Box { .. })));
    assert!(matches!(&file.lights[1].kind, LightKind::Environment { radiance, .. }
        if *radiance == glam::DVec3::splat(0.5)));
}

#[test]
fn rotation_is_about_x_then_y_then_z() {
    let folder = folder();
    let text = format!("{CAMERA}[[medium]]\nregion = \"everywhere\"\nrotate = [90, 90, 0]\n");
    let placement = read(folder.path(), &text).unwrap().media[0].placement;
    // y goes to z about x, and z to x about y.
    assert!(placement.transform_vector3(glam::DVec3::Y).distance(glam::DVec3::X) < 1e-12);
}

/// Rows of (tables after the camera, line and column of the message, key, what it must say).
const WRONG: &[(&str, &str, &str, &[&str])] = &[
    // Unknown keys, tables and syntax.
    ("[film]\nsiz = [1, 1]", "5:1", "film.siz", &["unknown", "`size`", "exposure"]),
    ("[lights]", "4:2", "lights", &["unknown", "`light`"]),
    ("[[medium]]\nregion = \"everywhere\"\nsigma = 1", "6:1", "medium[0].sigma", &["`sigma_t`"]),
    ("[film\nsize = 1", "4:6", "TOML", &[]),
    ("[film]\nsize = [1, 1]\nsize = [1, 1]", "6:1", "TOML", &["duplicate"]),
    ("film = 3", "4:1", "camera.film", &["unknown"]),
    // Film.
    ("[film]\nsize = [0, 10]", "5:9", "film.size[0]", &["`0`", "1 to 65536"]),
    ("[film]\nsize = [10, 70000]", "5:13", "film.size[1]", &["`70000`", "1 to 65536"]),
    ("[film]\nsize = [65536, 65536]", "5:8", "film.size", &["268435456 pixels"]),
    ("[film]\nsize = [1.5, 10]", "5:9", "film.size[0]", &["`1.5`", "whole"]),
    ("[film]\nsize = 10", "5:8", "film.size", &["`10`", "[width, height]"]),
    ("[film]\nexposure = 1e9", "5:12", "film.exposure", &["-100 to 100"]),
    ("[film]\nview = \"filmic\"", "5:8", "film.view", &["`\"filmic\"`", "\"agx\" or \"srgb\""]),
    // Render.
    ("[render]\nrays = 0", "5:8", "render.rays", &["`0`", "1 to"]),
    ("[render]\nphotons = -1", "5:11", "render.photons", &["`-1`", "0 to"]),
    ("[render]\nphotons = 10_000_000_000", "5:11", "render.photons", &["200000000"]),
    ("[render]\nradius = 0", "5:10", "render.radius", &["above 0"]),
    ("[render]\nstep = nan", "5:8", "render.step", &["`nan`", "above 0"]),
    ("[render]\ndirector = \"z\"", "5:12", "render.director", &["\"fixed\"", "\"xs\""]),
    ("[director]\nx = \"fog\"", "5:5", "director.x", &["\"transmittance\"", "\"scattering\""]),
    ("[director]\nweights = [1, -1]", "5:15", "director.weights[1]", &["at least 0"]),
    ("[director]\nop = \"-\"", "5:6", "director.op", &["\"+\" or \"*\" or \"tolerance\""]),
    ("[director]\ndirects = \"light\"", "5:11", "director.directs", &["rays, radius, step"]),
    ("[director]\nfloor = 0", "5:9", "director.floor", &["1 to"]),
    ("[director]\nradius = 0.5", "5:10", "director.radius", &["from 1 to 256"]),
    ("[director]\ntolerance = 0", "5:13", "director.tolerance", &["above 0"]),
    ("[director]\nresolution = 5", "5:14", "director.resolution", &["0.0625 (1/16) to 4"]),
    (
        "[[medium]]\nfile = \"a_##.vdb\"",
        "5:8",
        "medium[0].file",
        &["is a sequence of files", "--frames"],
    ),
    ("[render]\nseed = \"a\"", "5:8", "render.seed", &["whole number"]),
    ("[render]\nmax_scatter = -2", "5:15", "render.max_scatter", &["0 to"]),
    (
        "[render]\nmax_scatter = 2\nstrategy = \"traced\"",
        "6:12",
        "render.strategy",
        &["`traced` does not count orders", "`max_scatter`", "`beams`"],
    ),
    // Media.
    ("[[medium]]", "4:1", "medium[0].file", &["missing", "region"]),
    ("[medium]\nfile = \"smoke.vdb\"", "4:1", "medium", &["[[medium]]"]),
    ("[[medium]]\nfile = \"gone.vdb\"", "5:8", "medium[0].file", &["gone.vdb", "no such file"]),
    ("[[medium]]\nfile = \"\"", "5:8", "medium[0].file", &["a VDB file"]),
    (
        "[[medium]]\nfile = \"smoke.vdb\"\nregion = \"everywhere\"",
        "6:10",
        "medium[0].region",
        &["exclude"],
    ),
    ("[[medium]]\nregion = \"all\"", "5:10", "medium[0].region", &["`\"all\"`", "everywhere"]),
    ("[[medium]]\nregion = \"everywhere\"\ngrid = \"d\"", "6:8", "medium[0].grid", &["`region`"]),
    (
        "[[medium]]\nregion = { box = { min = [0, 0, 0], max = [1, 0, 1] } }",
        "5:43",
        "medium[0].region.box.max",
        &["above `min`"],
    ),
    (
        "[[medium]]\nregion = { sphere = { radius = -1 } }",
        "5:32",
        "medium[0].region.sphere.radius",
        &["`-1`", "above 0"],
    ),
    ("[[medium]]\nregion = {}", "5:10", "medium[0].region", &["everywhere"]),
    (
        "[[medium]]\nregion = \"everywhere\"\nsigma_t = -1",
        "6:11",
        "medium[0].sigma_t",
        &["`-1`", "at least 0"],
    ),
    ("[[medium]]\nregion = \"everywhere\"\nsigma_t = inf", "6:11", "medium[0].sigma_t", &["`inf`"]),
    (
        "[[medium]]\nregion = \"everywhere\"\nsigma_t = [1, 1e30, 1]",
        "6:15",
        "medium[0].sigma_t[1]",
        &["1e18"],
    ),
    (
        "[[medium]]\nregion = \"everywhere\"\nalbedo = -0.1",
        "6:10",
        "medium[0].albedo",
        &["`-0.1`", "0 to 1"],
    ),
    (
        "[[medium]]\nregion = \"everywhere\"\nalbedo = [0.5, 1.5, 0.5]",
        "6:16",
        "medium[0].albedo[1]",
        &["`1.5`", "0 to 1", "create energy"],
    ),
    (
        "[[medium]]\nregion = \"everywhere\"\nalbedo = { grid = \"Cd\" }",
        "6:10",
        "medium[0].albedo.file",
        &["missing", "VDB"],
    ),
    (
        "[[medium]]\nregion = \"everywhere\"\nphase = \"hg\"",
        "6:9",
        "medium[0].phase",
        &["isotropic"],
    ),
    (
        "[[medium]]\nregion = \"everywhere\"\nphase = { type = \"henyey-greenstein\", g = 1 }",
        "6:43",
        "medium[0].phase.g",
        &["`1`", "below 1"],
    ),
    (
        "[[medium]]\nregion = \"everywhere\"\nphase = { type = \"fog\", g = 0.5 }",
        "6:25",
        "medium[0].phase.g",
        &["unknown", "diameter"],
    ),
    (
        "[[medium]]\nregion = \"everywhere\"\nphase = { type = \"fog\", diameter = 51 }",
        "6:36",
        "medium[0].phase.diameter",
        &["50 micrometres"],
    ),
    (
        "[[medium]]\nfile = \"smoke.vdb\"\nemission = { grid = \"a\", temperature = \"b\" }",
        "6:40",
        "medium[0].emission.temperature",
        &["exclude"],
    ),
    (
        "[[medium]]\nfile = \"smoke.vdb\"\nemission = { temperature = \"b\", color = 1 }",
        "6:33",
        "medium[0].emission.color",
        &["unknown", "kelvin_scale"],
    ),
    ("[[medium]]\nfile = \"smoke.vdb\"\nscale = [1, 0, 1]", "6:13", "medium[0].scale[1]", &["0"]),
    (
        "[[medium]]\nfile = \"smoke.vdb\"\nlevel_set = \"sdf\"",
        "6:13",
        "medium[0].level_set",
        &["fog"],
    ),
    ("[[medium]]\nfile = \"smoke.vdb\"\nindex = -1", "6:9", "medium[0].index", &["0 to"]),
    // Surfaces.
    ("[[surface]]\nshape = \"cone\"", "5:9", "surface[0].shape", &["sphere", "mesh"]),
    ("[[surface]]\nshape = \"sphere\"", "4:1", "surface[0].radius", &["missing", "metres"]),
    ("[[surface]]\nshape = \"sphere\"\nradius = 0", "6:10", "surface[0].radius", &["above 0"]),
    ("[[surface]]\nshape = \"sphere\"\nradius = 1\nu = 1", "7:1", "surface[0].u", &["a sphere"]),
    (
        "[[surface]]\nshape = \"quad\"\nu = [1, 0, 0]\nv = [2, 0, 0]",
        "7:5",
        "surface[0].v",
        &["spans an area"],
    ),
    (
        "[[surface]]\nshape = \"plane\"\nnormal = [0, 0, 0]",
        "6:10",
        "surface[0].normal",
        &["length above 0"],
    ),
    ("[[surface]]\nshape = \"mesh\"", "4:1", "surface[0].file", &["missing", ".obj"]),
    (
        "[[surface]]\nshape = \"plane\"\nmaterial = { type = \"mirror\", reflectance = 2 }",
        "6:45",
        "surface[0].material.reflectance",
        &["`2`", "0 to 1"],
    ),
    (
        "[[surface]]\nshape = \"plane\"\nmaterial = { type = \"glass\", ior = 0.5 }",
        "6:36",
        "surface[0].material.ior",
        &["1 to 10"],
    ),
    (
        "[[surface]]\nshape = \"plane\"\nemission = 1",
        "6:12",
        "surface[0].emission",
        &["quad or a mesh"],
    ),
    (
        "[[surface]]\nshape = \"plane\"\nvisible = 0",
        "6:11",
        "surface[0].visible",
        &["`0`", "true or false"],
    ),
    (
        "[[surface]]\nshape = \"plane\"\nvisible = false\nholdout = true",
        "7:11",
        "surface[0].holdout",
        &["`visible = false` and `holdout = true` exclude each other"],
    ),
    (
        "[[surface]]\nshape = \"plane\"\nvisible = false\nshadow_catcher = true",
        "7:18",
        "surface[0].shadow_catcher",
        &["`visible = false` and `shadow_catcher = true` exclude each other"],
    ),
    (
        "[[surface]]\nshape = \"plane\"\nholdout = true\nshadow_catcher = true",
        "7:18",
        "surface[0].shadow_catcher",
        &["`holdout = true` and `shadow_catcher = true` exclude each other"],
    ),
    (
        "[[surface]]\nshape = \"plane\"\nshadow_catcher = true\nmaterial = { type = \"mirror\" }",
        "7:12",
        "surface[0].material",
        &["diffuse surface alone", "leave out `shadow_catcher`"],
    ),
    (
        "[[surface]]\nshape = \"quad\"\nu = [1, 0, 0]\nv = [0, 1, 0]\nshadow_catcher = true\nemission = 1",
        "9:12",
        "surface[0].emission",
        &["catches no shadows", "leave out `emission`"],
    ),
    // Lights.
    (
        "[[light]]\ntype = \"environment\"\nradiance = 1\nholdout = true",
        "7:1",
        "light[0].holdout",
        &["unknown key of an environment"],
    ),
    ("[[light]]\nposition = [0, 0, 0]", "4:1", "light[0].type", &["missing", "environment"]),
    (
        "[[light]]\ntype = \"point\"\nposition = [0, 0, 0]\nintensity = 1\npower = 1",
        "8:9",
        "light[0].power",
        &["exclude"],
    ),
    ("[[light]]\ntype = \"point\"\nposition = [0, 0]", "6:12", "light[0].position", &["[x, y, z]"]),
    (
        "[[light]]\ntype = \"spot\"\nposition = [0, 0, 0]\nangle = 10\nfalloff = 20\n\
         direction = [0, 1, 0]\npower = 1",
        "8:11",
        "light[0].falloff",
        &["10 degrees"],
    ),
    (
        "[[light]]\ntype = \"spot\"\nposition = [0, 0, 0]\ntarget = [0, 0, 0]\npower = 1",
        "7:10",
        "light[0].target",
        &["position"],
    ),
    (
        "[[light]]\ntype = \"sun\"\ndirection = [0, -1, 0]\nirradiance = -5",
        "7:14",
        "light[0].irradiance",
        &["`-5`", "at least 0"],
    ),
    (
        "[[light]]\ntype = \"environment\"\nradiance = 1\ntexture = \"sky.exr\"",
        "7:11",
        "light[0].texture",
        &["exclude"],
    ),
    (
        "[[light]]\ntype = \"environment\"\ngradient = [[0, 1]]",
        "6:12",
        "light[0].gradient",
        &["at least two stops"],
    ),
    (
        "[[light]]\ntype = \"environment\"\ngradient = [1, 2]",
        "6:13",
        "light[0].gradient[0]",
        &["`1`", "a stop [elevation, colour]"],
    ),
    (
        "[[light]]\ntype = \"environment\"\ngradient = [[-91, 1], [0, 1]]",
        "6:14",
        "light[0].gradient[0][0]",
        &["`-91`", "-90 to 90 degrees"],
    ),
    (
        "[[light]]\ntype = \"environment\"\ngradient = [[10, 1], [0, 1]]",
        "6:23",
        "light[0].gradient[1][0]",
        &["`0`", "not below the one before, 10"],
    ),
    (
        "[[light]]\ntype = \"environment\"\ngradient = [[0, 1], [1, 1]]\nrotate = 3",
        "7:10",
        "light[0].rotate",
        &["exclude"],
    ),
];

#[test]
fn every_wrong_key_is_told_with_its_place_and_what_would_be_right() {
    let folder = folder();
    let path = folder.path().join("test.toml");
    let mut wrong = Vec::new();
    for (tables, place, key, says) in WRONG {
        let text = format!("{CAMERA}{tables}\n");
        let Err(error) = read(folder.path(), &text) else {
            wrong.push(format!("accepted: {tables}"));
            continue;
        };
        let message = error.to_string();
        let start = format!("{}:{place}: {key}: ", path.display());
        let right = message.starts_with(&start)
            && says.iter().all(|words| message[start.len()..].contains(words))
            && !message.contains('\n')
            && error.exit_code() == 1;
        if !right {
            wrong.push(format!("{tables}\n  wanted {place} {key} {says:?}\n  got    {message}"));
        }
    }
    assert!(wrong.is_empty(), "{} wrong messages:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn every_wrong_camera_is_told() {
    let rows: &[(&str, &str)] = &[
        ("", "camera: missing"),
        ("camera = 1", "camera: found `1`"),
        ("[camera]\ntarget = [0, 0, 0]", "camera.position: missing"),
        ("[camera]\nposition = [0, 0, 0]\ntarget = [0, 0, 0]", "camera.target: found"),
        ("[camera]\nposition = [0, 1, 0]\ntarget = [0, 0, 0]", "camera.up: missing"),
        ("[camera]\nposition = [0, 1, 0]\ntarget = [0, 0, 0]\nup = [0, 2, 0]", "camera.up: found"),
        ("[camera]\nposition = [0, 1, 0]\ntarget = [0, 0, 0]\nup = [0, 0, 0]", "camera.up: found"),
        (
            "[camera]\nposition = [0, 1, 1]\ntarget = [0, 0, 0]\nfov = 180",
            "camera.fov: found `180`",
        ),
        ("[camera]\nposition = [0, 1, 1]\ntarget = [0, 0, 0]\nfov = 0", "camera.fov: found `0`"),
        ("[camera]\nposition = [0, nan, 1]\ntarget = [0, 0, 0]", "camera.position[1]: found `nan`"),
        ("[camera]\nposition = [0, 1, 1]\ntarget = [0, 0, 0]\naperture = -1", "camera.aperture"),
        (
            "[camera]\nposition = [0, 1, 1]\ntarget = [0, 0, 0]\nclip = [3, 3]",
            "camera.clip: found `[3, 3]`",
        ),
        (
            "[camera]\ntype = \"orthographic\"\nposition = [0, 1, 1]\ntarget = [0, 0, 0]",
            "camera.height: missing",
        ),
        (
            "[camera]\ntype = \"latlong\"\nposition = [0, 1, 1]\ntarget = [0, 0, 0]\nfov = 3",
            "camera.fov: unknown",
        ),
    ];
    for (text, says) in rows {
        let message = read(Path::new("nowhere"), text).unwrap_err().to_string();
        assert!(message.contains(says), "{text}\n  wanted {says}\n  got {message}");
    }
}

#[test]
fn messages_count_lines_of_windows_files_and_columns_in_characters() {
    let text = "[camera]\r\nposition = [0, 1, 8]\r\ntarget = [0, 1, 0]\r\n\
                [[medium]]\r\nfile = \"ä.vdb\"\r\n\"größe\" = 1\r\n";
    let message = read(Path::new("nowhere"), text).unwrap_err().to_string();
    assert!(message.contains("test.toml:6:1: medium[0].größe: unknown"), "{message}");
}

/// Pieces that scene files are made of, and some that they are not.
fn piece() -> impl Strategy<Value = String> {
    const WORDS: &[&str] = &[
        "[camera]\n",
        "[film]\n",
        "[render]\n",
        "[[medium]]\n",
        "[[surface]]\n",
        "[[light]]\n",
        "position",
        "target",
        "size",
        "file",
        "region",
        "albedo",
        "sigma_t",
        "phase",
        "emission",
        "shape",
        "type",
        "material",
        "u",
        "v",
        "scale",
        "rotate",
        " = ",
        "{",
        "}",
        "[",
        "]",
        ", ",
        "\n",
        "\"",
        "\"sphere\"",
        "\"spot\"",
        "\"everywhere\"",
        "grid = ",
        "0",
        "1",
        "-1",
        "1e308",
        "nan",
        "inf",
        "0x10",
        "1979-05-27",
        "true",
        "'''",
        "\u{fe0f}",
        "ß",
        "\r\n",
        "#",
    ];
    prop_oneof![proptest::sample::select(WORDS).prop_map(str::to_owned), ".{0,6}"]
}

proptest! {
    #[test]
    fn no_text_makes_the_reader_panic(pieces in prop::collection::vec(piece(), 0..40)) {
        let text = pieces.concat();
        for text in [text.clone(), format!("{CAMERA}{text}")] {
            if let Err(error) = read(Path::new("nowhere"), &text) {
                prop_assert!(!error.to_string().contains('\n'));
            }
        }
    }
}
