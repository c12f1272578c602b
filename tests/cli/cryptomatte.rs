//! `--passes cryptomatte`: objects with their coverages, as compositing programs decode them.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use fogbow::image::{Layers, cryptomatte, read_header};

use crate::parts::{layers, merges, report, smoke};
use crate::{is_there, printed, run};

/// What a coverage may be off by: that of an f32.
const ROUNDING: f64 = 1e-6;

const PASS: [&str; 2] = ["--passes", "cryptomatte"];

/// A folder with a scene: two boxes of smoke that overlap, over a floor, beside glass, before a ball, with surfaces that the camera
/// does not see as they are, a lamp and a sky.
fn scene() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let more = "name = \"lamp above\"
[[medium]]
name = \"red \\\"smoke\\\"\"
region = { sphere = { center = [0.6, 1.4, 0.2], radius = 0.9 } }
sigma_t = [0.5, 2.0, 4.0]
[[surface]]
name = \"glass\"
shape = \"sphere\"
center = [2.2, 1, 0]
radius = 0.8
material = { type = \"glass\" }
[[surface]]
shape = \"sphere\"
center = [-1.5, 1, -1.5]
radius = 0.9
[[surface]]
shape = \"box\"
min = [-0.4, 0, 1.5]
max = [0.4, 0.5, 2]
holdout = true
[[surface]]
shape = \"box\"
min = [-9, 1, -4]
max = [9, 9, -3]
visible = false
[[light]]
type = \"environment\"
radiance = [0.1, 0.2, 0.4]
";
    // The lamp of the scene becomes a surface that shines.
    let text = smoke(6, 3000, "0.8").replace(
        "[[light]]\ntype = \"area\"\ncenter = [2, 5, 2]\nu = [1, 0, 0]\nv = [0, 0, 1]\nradiance = [20, 16, 12]\n",
        "[[surface]]\nshape = \"quad\"\ncenter = [0, 3, 1]\nu = [1, 0, 0]\nv = [0, 0, 1]\nemission = 20.0\n",
    );
    fs::write(folder.path().join("s.toml"), text + more).unwrap();
    folder
}

/// The coverages of each pixel by the bits of identifiers, as they are stored.
fn coverages(layers: &Layers) -> Vec<BTreeMap<u32, f64>> {
    let mut pixels = vec![BTreeMap::new(); layers.width * layers.height];
    for number in 0..3 {
        for [id, coverage] in [["R", "G"], ["B", "A"]] {
            let plane = |channel| layers.get(&format!("CryptoObject0{number}.{channel}")).unwrap();
            for ((pixel, id), coverage) in pixels.iter_mut().zip(plane(id)).zip(plane(coverage)) {
                if *coverage != 0.0 {
                    assert_eq!(pixel.insert(id.to_bits(), f64::from(*coverage)), None);
                } else {
                    assert_eq!(id.to_bits(), 0);
                }
            }
        }
    }
    pixels
}

/// The manifest of a picture: names by the bits of their identifiers.
fn manifest(layers: &Layers) -> BTreeMap<u32, String> {
    let attribute = |name: &str| {
        let mut of_name = layers
            .attributes
            .iter()
            .filter(|(key, _)| key.starts_with("cryptomatte/") && key.ends_with(name));
        let (key, value) = of_name.next().unwrap();
        assert!(of_name.next().is_none() && key.len() == 12 + 7 + name.len(), "{key}");
        value.clone()
    };
    assert_eq!(attribute("/name"), "CryptoObject");
    assert_eq!(attribute("/hash"), "MurmurHash3_32");
    assert_eq!(attribute("/conversion"), "uint32_to_float32");
    let names: BTreeMap<String, String> = serde_json::from_str(&attribute("/manifest")).unwrap();
    let decoded = names.into_iter().map(|(name, hex)| {
        assert_eq!(hex.len(), 8);
        let identifier = u32::from_str_radix(&hex, 16).unwrap();
        assert_eq!(identifier, cryptomatte::identifier(&name));
        (identifier, name)
    });
    decoded.collect()
}

/// That the coverages of each pixel are those of objects of the manifest and add up to `A`; which objects are seen.
fn seen(layers: &Layers) -> Vec<String> {
    let names = manifest(layers);
    let mut seen = BTreeMap::new();
    for (pixel, alpha) in coverages(layers).iter().zip(layers.get("A").unwrap()) {
        let sum: f64 = pixel.values().sum();
        assert!((sum - f64::from(*alpha)).abs() < ROUNDING, "{sum} for {alpha}");
        pixel.keys().for_each(|id| *seen.entry(&names[id]).or_insert(0) += 1);
    }
    seen.into_keys().cloned().collect()
}

#[test]
fn coverages_add_up_to_alpha_and_change_nothing_of_the_picture() {
    let folder = scene();
    let folder = folder.path();
    report(folder, &["-o", "plain.exr"]);
    report(folder, &[&["-o", "a.exr"], &PASS[..]].concat());
    report(folder, &[&["-o", "half.exr", "--half"], &PASS[..]].concat());
    report(folder, &["-o", "b.exr", "--threads", "1", "--passes", "cryptomatte,depth,media"]);
    let [plain, a, b] = ["plain.exr", "a.exr", "b.exr"].map(|name| layers(folder, name));
    assert_eq!(a.channels.len(), plain.channels.len() + 12);
    for (name, values) in &plain.channels {
        assert!(b.get(name) == Some(values), "{name} is another with the pass");
    }
    // No surface that is not seen, and none of the sky; the name that was chosen for the box is free.
    let names: Vec<String> = manifest(&a).into_values().collect();
    assert!(["box", "box_2"].iter().all(|name| names.contains(&(*name).to_owned())), "{names:?}");
    let expected = ["glass", "lamp above", "medium", "plane", "red \"smoke\"", "sphere"];
    assert_eq!(seen(&a), expected);
    assert_eq!(seen(&b), expected);
    // Half floats hold no identifiers; other passes change none of them.
    let header = read_header(&folder.join("half.exr")).unwrap();
    assert_eq!(header.half, ["A", "B", "G", "R"]);
    assert_eq!(coverages(&a), coverages(&layers(folder, "half.exr")));
    assert_eq!(coverages(&a), coverages(&b));
    let without = plain.attributes.keys().chain(b.attributes.keys());
    assert_eq!(without.filter(|name| name.starts_with("cryptomatte/")).count(), 4);

    // The reference, a reconstructed and a directed picture.
    for more in [&["--reference"][..], &["--reconstruct"], &["--director", "xs", "--x", "error"]] {
        report(folder, &[&["-o", "c.exr"], &PASS[..], more].concat());
        assert_eq!(seen(&layers(folder, "c.exr")), expected, "{more:?}");
    }
    // A deep picture tells of no objects.
    report(folder, &[&["-o", "d.exr", "--deep"], &PASS[..]].concat());
    let deep = read_header(&folder.join("d.deep.exr")).unwrap();
    assert!(!deep.attributes.keys().any(|name| name.starts_with("cryptomatte/")));

    if is_there("oiiotool") {
        let told = printed(folder, "oiiotool", &["--info", "-v", "a.exr"]);
        let line = |text: &str| told.lines().any(|line| line.contains(text));
        assert!(
            line("name: \"CryptoObject\"") && line("manifest: \"{") && line("lamp above"),
            "{told}"
        );
        assert!(line("channel, float openexr") && line("CryptoObject02.A"), "{told}");
    }
}

/// Even media seen along an axis by parallel rays: what each covers is known in closed form.
#[test]
fn media_share_what_they_hide_by_their_optical_depths() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let text = "
[camera]
type = \"orthographic\"
position = [0, 0, 8]
target = [0, 0, 0]
height = 1.0
[film]
size = [4, 4]
[render]
rays = 4
photons = 100
[[medium]]
name = \"a\"
region = { box = { min = [-1.0, -1.0, -1.0], max = [1.0, 1.0, 1.0] } }
sigma_t = 1.0
[[medium]]
name = \"b\"
region = { box = { min = [-1.0, -1.0, -1.0], max = [1.0, 1.0, 0.0] } }
sigma_t = 2.0
[[surface]]
name = \"wall\"
shape = \"quad\"
center = [0, 0, -2]
u = [4, 0, 0]
v = [0, 4, 0]
[[light]]
type = \"environment\"
radiance = 1
";
    fs::write(folder.join("s.toml"), text).unwrap();
    let (first, both) = ((-1.0_f64).exp(), 1.0 - (-3.0_f64).exp());
    let a = 1.0 - first + first * both / 3.0;
    let expected = [("a", a), ("b", first * both * 2.0 / 3.0), ("wall", (-4.0_f64).exp())];
    report(folder, &[&["-o", "a.exr"], &PASS[..]].concat());
    for pixel in coverages(&layers(folder, "a.exr")) {
        assert_eq!(pixel.len(), 3);
        for (name, coverage) in expected {
            let found = pixel[&cryptomatte::identifier(name)];
            assert!((found - coverage).abs() < ROUNDING, "{found} for {coverage} of {name}");
        }
    }
    // With a name in common they are one object.
    report(folder, &[&["-o", "b.exr", "--set", "medium.1.name=\"a\""], &PASS[..]].concat());
    let found = layers(folder, "b.exr");
    let names: Vec<String> = manifest(&found).into_values().collect();
    assert_eq!(names.len(), 2);
    for pixel in coverages(&found) {
        let found = pixel[&cryptomatte::identifier("a")];
        assert!((found - (1.0 - (-4.0_f64).exp())).abs() < ROUNDING, "{found}");
    }
}

#[test]
fn objects_go_through_crops_and_merges() {
    let folder = scene();
    let folder = folder.path();
    let render = |name: &str, more: &[&str]| {
        report(folder, &[&["-o", name], &PASS[..], more].concat());
    };
    render("whole.exr", &[]);
    for (name, crop) in [("0.exr", "0,0,24x9"), ("1.exr", "0,9,10x11"), ("2.exr", "10,9,14x11")] {
        render(name, &["--crop", crop]);
    }
    merges(folder, &["0.exr", "1.exr", "2.exr"], "merged.exr");
    let [whole, merged] = ["whole.exr", "merged.exr"].map(|name| layers(folder, name));
    assert!(whole.channels == merged.channels);
    assert_eq!(manifest(&whole), manifest(&merged));

    render("s1.exr", &["--seed", "1"]);
    render("s2.exr", &["--seed", "2", "--rays", "12"]);
    merges(folder, &["s1.exr", "s2.exr"], "mean.exr");
    merges(folder, &["s2.exr", "s1.exr"], "turned.exr");
    assert_eq!(
        fs::read(folder.join("mean.exr")).unwrap(),
        fs::read(folder.join("turned.exr")).unwrap()
    );
    let [mean, one, two] = ["mean.exr", "s1.exr", "s2.exr"].map(|name| layers(folder, name));
    seen(&mean);
    let passes: serde_json::Value =
        serde_json::from_str(&mean.attributes["fogbow:passes"]).unwrap();
    let weights = [0, 1].map(|pass| passes[pass]["weight"].as_f64().unwrap());
    let [mean, one, two] = [mean, one, two].map(|layers| coverages(&layers));
    for ((mean, one), two) in mean.iter().zip(&one).zip(&two) {
        let mut expected = BTreeMap::<u32, f64>::new();
        for (pass, weight) in [one, two].into_iter().zip(weights) {
            pass.iter()
                .for_each(|(id, coverage)| *expected.entry(*id).or_default() += weight * coverage);
        }
        assert!(mean.keys().eq(expected.keys()));
        assert!(mean.values().zip(expected.values()).all(|(a, b)| (a - b).abs() < ROUNDING));
    }
}

const SHOT: &str = r#"#usda 1.0
( upAxis = "Y" metersPerUnit = 1 )
def Camera "Camera"
{
    double3 xformOp:translate = (0, 0, 30)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
def Xform "World"
{
    def Cube "left"
    {
        double3 xformOp:translate = (-2, 0, 0)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
    def Cube "right"
    {
        double3 xformOp:translate = (2, 0, 0)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
    def Volume "smoke"
    {
        double3 xformOp:translate = (0, 0, 5)
        uniform token[] xformOpOrder = ["xformOp:translate"]
        rel field:density = </World/smoke/density>
        def OpenVDBAsset "density"
        {
            token fieldName = "density"
            asset filePath = @./smoke.vdb@
        }
    }
}
"#;

#[test]
fn objects_of_shots_are_their_prims() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("shot.usda"), SHOT).unwrap();
    let smoke = Path::new(env!("CARGO_MANIFEST_DIR")).join("volumes/smoke.vdb");
    fs::copy(smoke, folder.join("smoke.vdb")).unwrap();
    let small = ["--size", "32x24", "--rays", "4", "--photons", "500", "--exposure", "0"];
    for (scene, name) in [("shot.usda", "shot.exr"), ("scene.toml", "scene.exr")] {
        if scene == "scene.toml" {
            let (code, _, err) = run(folder, &["export", "shot.usda", "-o", scene, "--quiet"]);
            assert_eq!(code, 0, "{err}");
        }
        let (code, _, err) =
            run(folder, &[&["render", scene, "-o", name], &PASS[..], &small].concat());
        assert_eq!(code, 0, "{err}");
    }
    let [shot, scene] = ["shot.exr", "scene.exr"].map(|name| layers(folder, name));
    assert_eq!(shot.channels, scene.channels);
    assert_eq!(manifest(&shot), manifest(&scene));
    // Both cubes are one mesh, as they look alike.
    assert_eq!(seen(&shot), ["/World/left", "/World/right", "/World/smoke"]);
    let [left, right] = ["/World/left", "/World/right"].map(cryptomatte::identifier);
    for (index, pixel) in coverages(&shot).iter().enumerate() {
        let is_left = index % 32 < 16;
        assert!(!pixel.contains_key(if is_left { &right } else { &left }), "{index}");
    }
}
