//! Materials of shots (USD) as those of scenes.

use fogbow::scene::{LoadOptions, Scene, read_shot};

/// The material that a surface shader with this id and these inputs becomes.
fn material(id: &str, inputs: &str) -> toml::Value {
    let shot = format!(
        r#"#usda 1.0
(
    upAxis = "Y"
    metersPerUnit = 1
)
def Camera "eye"
{{
    double3 xformOp:translate = (0, 0, 9)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}}
def SphereLight "lamp" {{ float inputs:intensity = 5 }}
def Sphere "ball"
{{
    rel material:binding = </paint>
}}
def Material "paint"
{{
    token outputs:surface.connect = </paint/s.outputs:surface>
    def Shader "s"
    {{
        uniform token info:id = "{id}"
        {inputs}
    }}
}}
"#
    );
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("shot.usda");
    std::fs::write(&path, shot).unwrap();
    let options = LoadOptions::default();
    let text = read_shot(&path, &options).unwrap().draft.text();
    let scene: toml::Table = text.parse().unwrap();
    // What is written is also what is read.
    Scene::load(&path, &options).unwrap();
    let surfaces = scene["surface"].as_array().unwrap();
    let paint = surfaces.iter().find(|s| s["file"].as_str().unwrap().contains("paint")).unwrap();
    paint["material"].clone()
}

#[test]
fn surface_shaders_become_the_materials_that_the_guide_says() {
    const PREVIEW: &str = "UsdPreviewSurface";
    const STANDARD: &str = "ND_standard_surface_surfaceshader";
    let color = "color3f inputs:diffuseColor = (0.5, 0.25, 0.75)";
    let metal = format!("{color}\nfloat inputs:metallic = 1");
    let rows: [(&str, &str, &str, Option<f64>); 9] = [
        (PREVIEW, color, "plastic", Some(0.5)),
        (PREVIEW, &format!("{color}\nfloat inputs:roughness = 0.001"), "plastic", Some(0.03)),
        (PREVIEW, &format!("{color}\nfloat inputs:specular = 0"), "diffuse", None),
        (PREVIEW, &format!("{color}\nfloat inputs:ior = 1"), "diffuse", None),
        (PREVIEW, &metal, "metal", Some(0.5)),
        (PREVIEW, &format!("{metal}\nfloat inputs:roughness = 0"), "mirror", None),
        (
            PREVIEW,
            "int inputs:useSpecularWorkflow = 1\ncolor3f inputs:specularColor = (0.5, 0.25, 0.75)",
            "metal",
            Some(0.5),
        ),
        (STANDARD, "color3f inputs:base_color = (0.5, 0.25, 0.75)", "plastic", Some(0.2)),
        (STANDARD, "float inputs:specular = 0", "diffuse", None),
    ];
    for (id, inputs, kind, roughness) in rows {
        let made = material(id, inputs);
        assert_eq!(made["type"].as_str(), Some(kind), "{inputs}");
        let found = made.get("roughness").and_then(toml::Value::as_float);
        let same = found.zip(roughness).is_some_and(|(a, b)| (a - b).abs() < 1e-6);
        assert!(same || found == roughness, "{inputs}: {found:?}");
        if inputs.contains("0.25, 0.75") {
            assert_eq!(made["reflectance"].to_string(), "[0.5, 0.25, 0.75]", "{inputs}");
        }
        if kind == "plastic" {
            let ior = made["ior"].as_float().unwrap();
            assert!((ior - 1.5).abs() < 1e-6, "{inputs}: {ior}");
        }
    }
}
