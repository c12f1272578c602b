//! `fogbow render` and `fogbow export` of a shot (USD).

use std::path::Path;

use fogbow::image::read_layers;

use super::run;

const SHOT: &str = r#"#usda 1.0
(
    upAxis = "Y"
    metersPerUnit = 1
    startTimeCode = 1
    endTimeCode = 3
)
def Camera "Camera"
{
    float horizontalAperture = 20
    float verticalAperture = 20
    float focalLength = 30
    double3 xformOp:translate.timeSamples = { 1: (0, 2, 9), 3: (1, 2, 9) }
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
def Camera "Other" { }
def DistantLight "Sun"
{
    float inputs:intensity = 3
    bool inputs:normalize = 1
    float3 xformOp:rotateXYZ = (-40, 30, 0)
    uniform token[] xformOpOrder = ["xformOp:rotateXYZ"]
}
def Mesh "floor"
{
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 3, 2, 1]
    point3f[] points = [(-9, 0, -9), (9, 0, -9), (9, 0, 9), (-9, 0, 9)]
    uniform token subdivisionScheme = "none"
}
def Volume "smoke"
{
    rel field:density = </smoke/density>
    def OpenVDBAsset "density"
    {
        token fieldName = "density"
        asset filePath.timeSamples = { 1: @./smoke_0001.vdb@, 2: @./smoke_0002.vdb@, 3: @./smoke_0003.vdb@ }
    }
}
"#;

/// A folder with the shot, and the VDB files of so many of its frames.
fn shot(frames: u32) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("shot.usda"), SHOT).unwrap();
    let smoke = Path::new(env!("CARGO_MANIFEST_DIR")).join("volumes/smoke.vdb");
    for frame in 1..=frames {
        std::fs::copy(&smoke, folder.path().join(format!("smoke_000{frame}.vdb"))).unwrap();
    }
    folder
}

/// The sequence of the guide: what its page of shots tells a user to type.
#[test]
fn a_shot_renders_by_frames_and_its_export_gives_the_same_pixels() {
    let folder = shot(3);
    let here = folder.path();
    let small = ["--size", "24x24", "--rays", "2", "--photons", "2000", "--exposure", "0"];
    let with = |words: &[&'static str]| [words, &small].concat();
    let frames = with(&["render", "shot.usda", "--frames", "1-3", "-o", "frame_####.exr"]);
    let (code, _, err) = run(here, &frames);
    assert_eq!(code, 0, "{err}");
    assert!(err.contains("/smoke: no volume material"), "{err}");
    assert!(here.join("frame_0003.exr").is_file());

    let (code, _, err) =
        run(here, &["export", "shot.usda", "-o", "scene.toml", "--frame", "2", "--quiet"]);
    assert_eq!(code, 0, "{err}");
    let (code, _, err) = run(here, &with(&["render", "scene.toml", "-o", "scene.exr"]));
    assert_eq!(code, 0, "{err}");
    let [shot, scene] =
        ["frame_0002.exr", "scene.exr"].map(|name| read_layers(&here.join(name)).unwrap());
    assert_eq!(shot.channels, scene.channels);
    let first = read_layers(&here.join("frame_0001.exr")).unwrap();
    assert_ne!(shot.channels, first.channels, "the camera moves");

    let (code, _, err) =
        run(here, &with(&["render", "shot.usda", "-o", "a.exr", "--camera", "Other"]));
    assert_eq!(code, 0, "{err}");
    let (code, _, err) =
        run(here, &with(&["render", "shot.usda", "-o", "a.exr", "--camera", "No"]));
    assert!(code == 2 && err.contains("it has /Camera, /Other"), "{err}");
}

#[test]
fn a_missing_file_is_told_with_its_frame() {
    let folder = shot(1);
    let (code, _, err) =
        run(folder.path(), &["render", "shot.usda", "--frames", "1-2", "-o", "f_####.exr"]);
    assert!(code == 1 && err.contains("frame 2") && err.contains("smoke_0002.vdb"), "{err}");
}

#[test]
fn a_scene_adds_to_a_shot_and_stands_over_parts_of_it() {
    let folder = shot(3);
    let here = folder.path();
    let render = ["render", "more.toml", "--frames", "2", "-o", "m_####.exr", "--exposure", "0"];
    let small = ["--rays", "1", "--photons", "1000"];
    let picture = |text: &str| {
        std::fs::write(here.join("more.toml"), text).unwrap();
        let (code, _, err) = run(here, &[&render[..], &small].concat());
        assert_eq!(code, 0, "{err}");
        read_layers(&here.join("m_0002.exr")).unwrap()
    };
    let film = "usd = \"shot.usda\"\n[film]\nsize = [16, 12]\n";
    let plain = picture(film);
    assert_eq!((plain.width, plain.height), (16, 12));
    let lit = picture(&format!("{film}[[light]]\ntype = \"environment\"\nradiance = 9.0\n"));
    assert_ne!(plain.channels["R"], lit.channels["R"]);
    let medium = "[[medium]]\nname = \"/smoke\"\nfile = \"smoke_####.vdb\"\nsigma_t = 0.0\n";
    let clear = picture(&format!("{film}{medium}"));
    assert!(clear.channels["transmittance"].iter().all(|t| *t == 1.0), "it is replaced");

    for (text, said) in [
        ("usd = \"none.usda\"\n", "more.toml:1:7: usd"),
        ("usd = 3\n", "more.toml:1:7: usd"),
        ("usd = \"shot.usda\"\nusd_camera = \"No\"\n", "it has /Camera, /Other"),
        ("usd = \"shot.usda\"\n[film]\nsizes = 1\n", "more.toml:3:1: film.sizes"),
    ] {
        std::fs::write(here.join("more.toml"), text).unwrap();
        let (code, _, err) = run(here, &render);
        assert!(code != 0 && err.contains(said) && err.lines().count() == 1, "{text}: {err}");
    }
}
