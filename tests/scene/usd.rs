//! Shots (USD): what is understood of a stage, and what is wrong with damaged ones.

use std::path::{Path, PathBuf};

use fogbow::scene::{LoadOptions, Scene, read_shot};
use fogbow::sequence::FrameTime;
use glam::DVec3;
use tempfile::TempDir;

/// A stage with a bit of everything; `@smoke@` stands for the path of a VDB file.
const SHOT: &str = r#"#usda 1.0
(
    upAxis = "Z"
    metersPerUnit = 0.1
    startTimeCode = 1
    endTimeCode = 3
    subLayers = [@./over.usda@]
)
def Xform "set"
{
    double3 xformOp:translate = (0, 0, 10)
    uniform token[] xformOpOrder = ["xformOp:translate"]

    def Camera "eye"
    {
        float horizontalAperture = 36
        float verticalAperture = 18
        float focalLength = 18
        double3 xformOp:translate.timeSamples = { 1: (0, 0, 0), 3: (20, 0, 0) }
        float xformOp:rotateX = 90
        uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateX"]
    }
    def Xform "free"
    {
        uniform token[] xformOpOrder = ["!resetXformStack!"]
        def Mesh "quad" (
            prepend apiSchemas = ["MaterialBindingAPI"]
        )
        {
            int[] faceVertexCounts = [4, 3]
            int[] faceVertexIndices = [0, 1, 2, 3, 0, 1, 4]
            point3f[] points = [(0, 0, 0), (10, 0, 0), (10, 10, 0), (0, 10, 0), (5, -5, 0)]
            uniform token subdivisionScheme = "none"
            rel material:binding = </mirror>
            def GeomSubset "grey"
            {
                uniform token familyName = "materialBind"
                int[] indices = [1]
                rel material:binding = </glass>
            }
        }
    }
    def Sphere "hidden" { token visibility.timeSamples = { 1: "inherited", 2: "invisible" } }
    def Sphere "guide" { uniform token purpose = "guide" }
    def RectLight "lamp"
    {
        float inputs:intensity = 8
        float inputs:exposure = 1
        bool inputs:normalize = 1
        float inputs:width = 2
        float inputs:height = 4
    }
    def SphereLight "bulb"
    {
        float inputs:intensity = 3
        float inputs:radius = 2
        bool treatAsPoint = 1
    }
    def Volume "smoke"
    {
        rel field:density = </set/smoke/density>
        def OpenVDBAsset "density"
        {
            token fieldName = "density"
            asset filePath.timeSamples = { 1: @smoke@, 2: @smoke@ }
        }
        rel material:binding = </vapour>
    }
    def "copy" (
        prepend references = @./part.usda@</part>
        variants = {
            string size = "large"
        }
    )
    {
    }
}
def Material "mirror"
{
    token outputs:surface.connect = </mirror/s.outputs:surface>
    def Shader "s"
    {
        uniform token info:id = "UsdPreviewSurface"
        float inputs:metallic = 1
        float inputs:roughness = 0
        color3f inputs:diffuseColor = (0.9, 0.8, 0.7)
    }
}
def Material "glass"
{
    token outputs:surface.connect = </glass/s.outputs:surface>
    def Shader "s" {
        uniform token info:id = "UsdPreviewSurface"
        float inputs:opacity = 0
        float inputs:roughness = 0
    }
}
def Material "vapour"
{
    token outputs:volume.connect = </vapour/s.outputs:volume>
    def Shader "s"
    {
        float inputs:density = 0.5
        color3f inputs:color = (0.5, 0.5, 0.5)
        color3f inputs:absorption_color = (1, 0, 0.25)
        float inputs:anisotropy = 0.3
    }
}
"#;

const OVER: &str = r#"#usda 1.0
def Xform "weaker" { def Sphere "ball" { double radius = 3 } }
"#;

const PART: &str = r#"#usda 1.0
def Xform "part" (
    prepend variantSets = "size"
    variants = {
        string size = "small"
    }
)
{
    variantSet "size" = {
        "small" { def Cube "box" { double size = 1 } }
        "large" { def Cube "box" { double size = 7 } }
    }
}
"#;

fn smoke() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("volumes/smoke.vdb")
}

/// A folder with `shot` as shot.usda, the layers it names, and its path.
fn folder(shot: &str) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("over.usda"), OVER).unwrap();
    std::fs::write(folder.path().join("part.usda"), PART).unwrap();
    let path = folder.path().join("shot.usda");
    let shot = shot.replace("@smoke@", &format!("@{}@", smoke().display()));
    std::fs::write(&path, shot).unwrap();
    (folder, path)
}

fn at(frame: i64) -> LoadOptions {
    LoadOptions { frame: Some(FrameTime::from(frame)), ..LoadOptions::default() }
}

fn table(path: &Path, frame: i64) -> toml::Table {
    read_shot(path, &at(frame)).unwrap().draft.text().parse().unwrap()
}

fn numbers(value: &toml::Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_float().unwrap()).collect()
}

#[test]
fn cameras_lights_and_media_are_those_of_the_stage() {
    let (_folder, path) = folder(SHOT);
    let scene = table(&path, 2);
    let camera = scene["camera"].as_table().unwrap();
    // (10, 0, 10) tenths of a metre, z up; turned about x it looks along y, which is -z here.
    assert_eq!(numbers(&camera["position"]), [1.0, 1.0, 0.0]);
    let target = DVec3::from_slice(&numbers(&camera["target"]));
    assert!(target.abs_diff_eq(DVec3::new(1.0, 1.0, -1.0), 1e-12), "{target}");
    assert_eq!(camera["fov"].as_float().unwrap(), 90.0);
    assert_eq!(scene["film"]["size"].to_string(), "[960, 480]");

    let medium = &scene["medium"][0];
    assert_eq!(medium["name"].as_str(), Some("/set/smoke"));
    // Red absorbs nothing, green all that it does not scatter, blue half of that; per tenth of a metre.
    assert_eq!(numbers(&medium["sigma_t"]), [2.5, 5.0, 3.75]);
    let albedo = numbers(&medium["albedo"]);
    assert!((albedo[0] - 1.0).abs() < 1e-12 && (albedo[2] - 2.0 / 3.0).abs() < 1e-12, "{albedo:?}");
    assert_eq!(medium["scale"].to_string(), "[0.1, 0.1, 0.1]");

    let lights = scene["light"].as_array().unwrap();
    let of = |kind: &str| lights.iter().find(|l| l["type"].as_str() == Some(kind)).unwrap();
    // Normalised: 16 over an area of 8.
    assert_eq!(numbers(&of("area")["radiance"]), [2.0; 3]);
    let bulb = numbers(&of("point")["intensity"]);
    assert!((bulb[0] - 3.0 * std::f64::consts::PI * 0.04).abs() < 1e-12, "{bulb:?}");
    let loaded = Scene::load(&path, &at(2)).unwrap();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
}

/// The field of a volume has a transform of its own, below that of the volume.
#[test]
fn a_volume_is_placed_as_its_density_is() {
    let name = "token fieldName = \"density\"\n";
    let moved = format!(
        "{name}double3 xformOp:translate = (0, 0, 5)\ndouble3 xformOp:scale = (2, 2, 2)\n\
         uniform token[] xformOpOrder = [\"xformOp:translate\", \"xformOp:scale\"]\n"
    );
    let shot = SHOT.replace(name, &moved);
    let other = "rel field:density = </set/smoke/density>\n";
    let second = format!(
        "{other}rel field:heat = </set/smoke/heat>\ndef OpenVDBAsset \"heat\" {{ \
         token fieldName = \"density\"\nasset filePath = @smoke@ }}\n"
    );
    for (shot, is_warned) in [(shot.clone(), false), (shot.replace(other, &second), true)] {
        let (_folder, path) = folder(&shot);
        let medium = &table(&path, 2)["medium"][0];
        // Ten and five tenths of a metre upward; twice as large.
        let translate = DVec3::from_slice(&numbers(&medium["translate"]));
        assert!(translate.abs_diff_eq(DVec3::new(0.0, 1.5, 0.0), 1e-12), "{translate}");
        assert_eq!(medium["scale"].to_string(), "[0.2, 0.2, 0.2]");
        // Extinction is that of a unit of the stage, however large the volume.
        assert_eq!(numbers(&medium["sigma_t"]), [2.5, 5.0, 3.75]);
        let warnings = Scene::load(&path, &at(2)).unwrap().warnings;
        let said = "/set/smoke: field:heat has another transform than field:density";
        assert_eq!(warnings.iter().any(|line| line.contains(said)), is_warned, "{warnings:?}");
    }
}

#[test]
fn surfaces_are_composed_placed_and_told_apart_by_material() {
    let (_folder, path) = folder(SHOT);
    let titles = |frame| {
        let text = read_shot(&path, &at(frame)).unwrap().draft.text();
        let titles = text.lines().filter_map(|line| line.strip_prefix("# "));
        titles.map(str::to_owned).collect::<Vec<_>>()
    };
    let has = |titles: &[String], title: &str| titles.iter().any(|known| known == title);
    let (first, second) = (titles(1), titles(2));
    // The cube of the reference, and while it is shown the hidden ball; never the guide.
    assert!(has(&first, "/weaker/ball: surface and 2 more"), "{first:?}");
    assert!(has(&second, "/weaker/ball: surface and 1 more"), "{second:?}");

    let shot = read_shot(&path, &at(2)).unwrap();
    let mesh = |name: &str| shot.files.meshes().find(|(file, _)| file.contains(name)).unwrap().1;
    assert_eq!(mesh("/mirror.ply").triangles.len(), 2);
    assert_eq!(mesh("/glass.ply").triangles.len(), 1);
    // It is out of the set, which is raised by 10.
    assert!(mesh("/mirror.ply").positions.iter().all(|p| p.y == 0.0 && p.x <= 1.0));
    // The ball of the sublayer and the cube of the reference have no material.
    let grey = mesh("/surface.ply");
    let largest = grey.positions.iter().map(|p| p.x).fold(0.0, f64::max);
    assert!((largest - 0.35).abs() < 1e-6, "a cube of 7 tenths: {largest}");
    assert!(grey.positions.iter().any(|p| (p.y - 1.35).abs() < 1e-6), "raised with the set");
}

#[test]
fn binary_layers_and_packages_are_the_same() {
    let (folder, path) = folder(SHOT);
    let text = std::fs::read_to_string(&path).unwrap();
    // The writer of the binary takes no assets among time samples.
    let plain = text.replace("filePath.timeSamples = { 1: ", "filePath = ");
    let plain = plain.replace(&format!(", 2: @{}@ }}", smoke().display()), "");
    std::fs::write(&path, &plain).unwrap();
    let binary = folder.path().join("shot.usdc");
    let data = openusd::usda::parse(&plain).unwrap();
    openusd::usdc::CrateWriter::write_to_file(&data, &binary).unwrap();
    let texts = [&path, &binary].map(|path| read_shot(path, &at(2)).unwrap().draft.text());
    assert_eq!(texts[0], texts[1]);

    let package = folder.path().join("shot.usdz");
    let mut archive = openusd::usdz::ArchiveWriter::create(&package).unwrap();
    archive.add_layer("shot.usdc", &std::fs::read(&binary).unwrap()).unwrap();
    archive.add_layer("over.usda", OVER.as_bytes()).unwrap();
    archive.add_layer("part.usda", PART.as_bytes()).unwrap();
    archive.finish().unwrap();
    assert_eq!(read_shot(&package, &at(2)).unwrap().draft.text(), texts[0]);
}

/// The message of a shot that cannot be read: one line that names the file.
pub(crate) fn refusal(path: &Path) -> String {
    let message = match Scene::load(path, &at(2)) {
        Err(problem) => problem.to_string(),
        Ok(_) => panic!("{} was taken", path.display()),
    };
    let name = path.file_name().unwrap().to_str().unwrap();
    assert!(message.contains(name) && message.lines().count() == 1, "{message}");
    assert!(message.len() < 1000, "{message}");
    message
}

#[test]
fn damaged_files_end_in_one_line() {
    let (folder, path) = folder(SHOT);
    let text = std::fs::read_to_string(&path).unwrap();
    let whole = text.trim_end().len();
    for length in (0..whole).step_by(7) {
        let cut = &text[..length];
        // Behind a root prim a cut file is a whole stage with fewer prims.
        if cut.trim_end().ends_with("\n}") {
            continue;
        }
        std::fs::write(&path, cut).unwrap();
        refusal(&path);
    }
    let plain = text.replace("filePath.timeSamples = { 1: ", "filePath = ");
    let plain = plain.replace(&format!(", 2: @{}@ }}", smoke().display()), "");
    let binary = folder.path().join("cut.usdc");
    let data = openusd::usda::parse(&plain).unwrap();
    openusd::usdc::CrateWriter::write_to_file(&data, &binary).unwrap();
    let bytes = std::fs::read(&binary).unwrap();
    for length in (0..bytes.len()).step_by(31) {
        std::fs::write(&binary, &bytes[..length]).unwrap();
        refusal(&binary);
    }
    let package = folder.path().join("cut.usdz");
    let mut archive = openusd::usdz::ArchiveWriter::create(&package).unwrap();
    archive.add_layer("shot.usda", plain.as_bytes()).unwrap();
    archive.finish().unwrap();
    let bytes = std::fs::read(&package).unwrap();
    for length in (0..bytes.len()).step_by(97) {
        std::fs::write(&package, &bytes[..length]).unwrap();
        refusal(&package);
    }
}

#[test]
fn what_cannot_be_is_said_with_its_prim() {
    let missing = "@./none.usda@";
    let deep = format!("{}{}", "def \"a\" {".repeat(5000), "}".repeat(5000));
    let rows: Vec<(&str, &str, &str)> = vec![
        ("@./part.usda@", missing, "/set/copy"),
        ("@./over.usda@", missing, "none.usda"),
        ("@./part.usda@</part>", "@./shot.usda@</set>", "/set"),
        (
            "[0, 1, 2, 3, 0, 1, 4]",
            "[0, 1, 2, 3, 0, 1, 5]",
            "/set/free/quad: a face has the point 5 of 5",
        ),
        ("[4, 3]", "[4, 4]", "/set/free/quad: its faceVertexCounts need 8"),
        ("[4, 3]", "[-4, 11]", "/set/free/quad: its faceVertexCounts need 11"),
        ("indices = [1]", "indices = [7]", "/set/free/quad/grey: has face 7 of a mesh of 2"),
        ("focalLength = 18", "focalLength = 0", "/set/eye: focalLength is 0"),
        ("(0, 0, 10)", "(0, 0, inf)", "/set: its transform is not finite"),
        ("def Camera", "def Scope", "has no camera"),
        (
            "float inputs:density = 0.5",
            "string inputs:density = \"a\"",
            "/vapour/s: inputs:density is a string",
        ),
        ("2: @smoke@", "2: @./no.vdb@", "no.vdb"),
        (
            "def Sphere \"hidden\" {",
            "def Sphere \"hidden\" ( inherits = </set/hidden/in> ) {",
            "/set/hidden inherits from /set/hidden/in",
        ),
        (
            "prepend references = @./part.usda@</part>",
            "specializes = </set>",
            "/set/copy inherits from /set",
        ),
        ("def Material \"glass\"", &deep, "nested"),
    ];
    for (old, new, said) in rows {
        assert!(SHOT.contains(old), "{old}");
        let (_folder, path) = folder(&SHOT.replacen(old, new, 1));
        let message = refusal(&path);
        assert!(message.contains(said), "{old} as {new}: {message}");
    }
}

#[test]
fn a_point_instancer_places_its_prototypes() {
    let shot = SHOT.replace(
        "def Sphere \"guide\"",
        "def PointInstancer \"many\"
    {
        rel prototypes = [</set/many/box>]
        int[] protoIndices = [0, 0, 0]
        point3f[] positions = [(0, 0, 0), (0, 0, 100), (0, 0, 200)]
        int64[] invisibleIds = [1]
        def Cube \"box\" { double size = 2 }
    }
    def Sphere \"guide\"",
    );
    let (_folder, path) = folder(&shot);
    let shot = read_shot(&path, &at(2)).unwrap();
    let (_, mesh) = shot.files.meshes().find(|(file, _)| file.contains("/surface.ply")).unwrap();
    let highest = mesh.positions.iter().map(|p| p.y).fold(0.0, f64::max);
    assert!((highest - 21.1).abs() < 1e-5, "{highest}");
    assert!(
        !mesh.positions.iter().any(|p| (5.0..15.0).contains(&p.y)),
        "the hidden one is left out"
    );
}
