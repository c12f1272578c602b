//! Settings over a scene: flags, `--set`, and ramps as keys.

use std::path::Path;

use assert_cmd::Command;
use fogbow::math::{Ray, Span, WorldPoint};
use fogbow::scene::{LoadOptions, Scene};
use fogbow::vdb::{Block, GridToWrite, write};
use glam::{DVec3, IVec3};

const SCENE: &str = "
[camera]
position = [0, 0, 9]
target = [0, 0, 0]
[[medium]]
region = { sphere = { radius = 1.0 } }
[[light]]
type = \"sun\"
direction = [0, -1, 0]
irradiance = 1.0
";

/// Loads `text` from `folder` with settings over it.
fn load(folder: &Path, text: &str, settings: &[(&str, &str)]) -> fogbow::Result<Scene> {
    let path = folder.join("scene.toml");
    std::fs::write(&path, text).unwrap();
    let options = settings
        .iter()
        .fold(LoadOptions::default(), |options, (path, value)| options.with(path, value));
    Scene::load(&path, &options)
}

#[test]
fn settings_stand_over_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    let loaded = |settings: &[(&str, &str)]| load(folder.path(), SCENE, settings).unwrap();
    let scene = loaded(&[
        ("render.rays", "3"),
        ("film.size", "[20, 10]"),
        ("medium.0.sigma_t", "[1, 2, 3]"),
        ("light.0.irradiance", "7"),
        ("render.rays", "5"),
    ]);
    assert_eq!((scene.render.rays, scene.film.size), (5, [20, 10]));
    assert_eq!(scene.media.get(0).sigma_t, DVec3::new(1.0, 2.0, 3.0));
    // What is seen changes the hash of a scene; how it is rendered does not.
    let plain = loaded(&[]);
    assert_eq!(loaded(&[("render.rays", "3"), ("film.size", "[20, 10]")]).hash, plain.hash);
    assert_ne!(loaded(&[("medium.0.sigma_t", "2")]).hash, plain.hash);
    assert_ne!(loaded(&[("light.0.irradiance", "2")]).static_hash, plain.static_hash);
}

/// Each message names the setting, what was found and what would be right.
#[test]
fn wrong_settings_are_told() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("scene.toml"), SCENE).unwrap();
    for (set, says) in [
        (
            "medium.0.albedo=1.5",
            "--set medium.0.albedo=1.5: found `1.5`; give an albedo from 0 to 1",
        ),
        ("medium.0.albdeo=0.5", "did you mean `albedo`?"),
        ("medium.1.albedo=0.5", "the scene has 1 of medium, counted from 0"),
        ("surface.0.material=1", "the scene has no [[surface]]"),
        ("medium.0.albedo.x=1", "--set medium.0.albedo.x=1"),
        ("medium.0.region.sphere.radius=-1", "give a number above 0"),
        ("render.rays=many", "--set render.rays=many: found `\"many\"`; give a whole number"),
        ("renderer.rays=4", "unknown key of a scene"),
        ("rays", "give KEY=VALUE"),
    ] {
        let out = folder.path().join("out.exr");
        let mut command = Command::new(assert_cmd::cargo::cargo_bin!("fogbow"));
        command.arg("render").arg(folder.path().join("scene.toml")).arg("-o").arg(&out);
        let output = command.args(["--set", set]).output().unwrap();
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{set}: {message}");
        assert!(message.contains(says), "{set}: {message}");
        assert!(!out.exists());
    }
}

/// A line of voxels whose value is their x, from 0 to 1 over a metre; 16 by 16 of them side by side.
fn wedge(folder: &Path) {
    let mut grid = GridToWrite::fog("density", 0.125, DVec3::ZERO);
    for corner in 0..4 {
        let origin = IVec3::new(0, corner >> 1, corner & 1) * 8;
        let values = (0..512).map(|i| (i >> 6) as f32 / 8.0).collect();
        grid.blocks.push(Block { origin, values, active: Some([!0; 8]) });
    }
    write(&folder.join("wedge.vdb"), &[grid]).unwrap();
}

/// The integral of density along the wedge from x = 0 to 0.875, where its value is x.
fn along(scene: &Scene) -> f64 {
    let ray = Ray::new(WorldPoint::new(-1.0, 0.9, 0.9), DVec3::X);
    scene.media.optical_thickness(&ray, Span::new(1.0, 1.875)).x
}

/// Optical thickness through ramps that scenes give, against closed forms.
#[test]
fn ramps_of_scenes_have_their_closed_forms() {
    let folder = tempfile::tempdir().unwrap();
    wedge(folder.path());
    let thickness = |density: &str| {
        let text = format!(
            "[camera]\nposition = [0, 0, 9]\ntarget = [0, 0, 0]\n[[medium]]\nfile = \"wedge.vdb\"\n{density}\n"
        );
        along(&load(folder.path(), &text, &[]).unwrap())
    };
    let near = |found: f64, expected: f64| {
        assert!((found - expected).abs() < 1e-5, "{found} for {expected}");
    };
    near(thickness(""), 0.5 * 0.875 * 0.875);
    // A jump from 0 to 2 at the value 0.3, in the middle of a cell.
    near(
        thickness("density = { ramp = [[0, 0], [0.3, 0], [0.3, 2], [1, 2]] }"),
        2.0 * (0.875 - 0.3),
    );
    // (x - 0.25) / 0.5, from 0 to 1.
    near(thickness("density = { from = [0.25, 0.75], clamp = true }"), 0.25 + 0.125);
    // Without an end: up to (0.875 - 0.25) / 0.5.
    near(thickness("density = { from = [0.25, 0.75] }"), 0.5 * 0.625 * 0.625 / 0.5);
    // The square of x, in straight lines.
    let square = thickness("density = { clamp = true, gamma = 2.0 }");
    assert!((square - 0.875f64.powi(3) / 3.0).abs() < 2e-4, "{square}");
}

#[test]
fn wrong_ramps_are_told() {
    let folder = tempfile::tempdir().unwrap();
    wedge(folder.path());
    for (medium, says) in [
        ("density = { ramp = [] }", "stops [place, value]"),
        ("density = { ramp = [[0.5, 1], [0.2, 1]] }", "a place not below the one before"),
        ("density = { ramp = [[0, -1]] }", "a number of at least 0"),
        ("density = { ramp = [[0, [1, 0, 0]]] }", "a colour where a number is meant"),
        ("density = { from = [1, 1] }", "the smaller one first"),
        ("density = { gamma = 2.0 }", "clamp"),
        ("density = { curve = 1 }", "unknown key of a transfer function"),
        ("albedo = { grid = \"density\", ramp = [[0, 1.5]] }", "an albedo from 0 to 1"),
        ("region = \"everywhere\"\ndensity = { gamma = 1.0 }", "belongs to `file`"),
    ] {
        let file = if medium.starts_with("region") { "" } else { "file = \"wedge.vdb\"\n" };
        let text = format!(
            "[camera]\nposition = [0, 0, 9]\ntarget = [0, 0, 0]\n[[medium]]\n{file}{medium}\n"
        );
        let message = load(folder.path(), &text, &[]).unwrap_err().to_string();
        assert!(message.contains(says) && message.contains("scene.toml:"), "{medium}: {message}");
    }
}
