//! Cameras of shots (USD) as those of scenes.

use fogbow::scene::{LoadOptions, Scene, read_shot};

/// The camera that these attributes become, in a stage of centimetres, and what is said of it.
fn camera(attributes: &str) -> (toml::Value, Vec<String>) {
    let shot = format!(
        r#"#usda 1.0
(
    upAxis = "Y"
    metersPerUnit = 0.01
)
def Camera "eye"
{{
    float horizontalAperture = 20
    float verticalAperture = 10
    {attributes}
}}
def SphereLight "lamp" {{ float inputs:intensity = 5 }}
"#
    );
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("shot.usda");
    std::fs::write(&path, shot).unwrap();
    let made = read_shot(&path, &LoadOptions::default()).unwrap();
    Scene::load(&path, &LoadOptions::default()).unwrap();
    let scene: toml::Table = made.draft.text().parse().unwrap();
    (scene["camera"].clone(), made.warnings)
}

fn pair(value: &toml::Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_float().unwrap()).collect()
}

#[test]
fn offsets_of_the_aperture_are_a_shift() {
    let offsets = "float horizontalApertureOffset = 5\nfloat verticalApertureOffset = -2.5";
    for projection in ["perspective", "orthographic"] {
        let of_kind = format!("{offsets}\ntoken projection = \"{projection}\"");
        let (camera, warnings) = camera(&of_kind);
        assert_eq!(camera["type"].as_str(), Some(projection));
        assert_eq!(pair(&camera["shift"]), [0.25, -0.125]);
        assert!(camera.get("clip").is_none() && warnings.is_empty(), "{warnings:?}");
    }
}

#[test]
fn a_clipping_range_is_in_metres_and_a_wrong_one_is_told() {
    let (clipped, warnings) = camera("float2 clippingRange = (50, 2000)");
    assert_eq!(pair(&clipped["clip"]), [0.5, 20.0]);
    assert!(clipped.get("shift").is_none() && warnings.is_empty(), "{warnings:?}");
    for range in ["(5, 5)", "(-1, 5)", "(9, 5)"] {
        let (camera, warnings) = camera(&format!("float2 clippingRange = {range}"));
        let is_told = warnings.iter().any(|w| w.contains("/eye: clippingRange is left out"));
        assert!(camera.get("clip").is_none() && is_told, "{range}: {warnings:?}");
    }
}
