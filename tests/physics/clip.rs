//! Cameras that see between two distances alone.

use fogbow::image::Film;
use fogbow::render::{Silent, render, render_reference};
use fogbow::scene::{RenderSettings, Scene};

use crate::pictures::{agree, means, scene};

/// Haze all round a camera that sees from 2 m to 5 m, under an even sky, with squares before, between and behind.
fn haze(camera: &str, squares: &[f64]) -> String {
    let square = |z: &f64| {
        format!(
            r#"
            [[surface]]
            shape = "quad"
            center = [0.0, 0.0, -{z}]
            u = [90.0, 0.0, 0.0]
            v = [0.0, 90.0, 0.0]
            material = {{ type = "diffuse", reflectance = 0.0 }}
            "#
        )
    };
    format!(
        r#"
        [camera]
        {camera}
        position = [0.0, 0.0, 0.0]
        target = [0.0, 0.0, -1.0]
        clip = [2.0, 5.0]
        [film]
        size = [8, 8]
        [[medium]]
        region = {{ sphere = {{ center = [0.0, 0.0, 0.0], radius = 40.0 }} }}
        sigma_t = 0.2
        albedo = 0.0
        [[light]]
        type = "environment"
        radiance = 1.0
        {}
        "#,
        squares.iter().map(square).collect::<String>()
    )
}

fn layer(film: &Film, name: &str) -> Vec<f64> {
    film.layer(name).unwrap().iter().map(|v| f64::from(*v)).collect()
}

/// 3 m of haze are before the sky, or 2 m before a square in 4 m, and distances count from the camera. The reference is
/// within 4.5 standard errors, a false alarm of 7e-6 at a fixed seed.
#[test]
fn what_is_nearer_or_farther_is_not_seen() {
    let folder = tempfile::tempdir().unwrap();
    for camera in ["type = 'orthographic'\nheight = 0.1", "fov = 0.1", "type = 'latlong'"] {
        let is_flat = !camera.contains("latlong");
        for (squares, depth) in [(&[][..], None), (&[1.0, 6.0], None), (&[1.0, 4.0], Some(4.0))] {
            if !is_flat && !squares.is_empty() {
                continue;
            }
            let scene = scene(folder.path(), &haze(camera, squares), 256, 100);
            let film = render(&scene, &scene.render, &Silent).unwrap().film;
            let through = (-0.2 * (depth.unwrap_or(5.0) - 2.0_f64)).exp();
            let light = if depth.is_some() { 0.0 } else { through };
            let covered = if depth.is_some() { 1.0 } else { 1.0 - through };
            for (name, expected) in [("G", light), ("A", covered), ("transmittance", through)] {
                for value in layer(&film, name) {
                    assert!(
                        (value - expected).abs() < 1e-5,
                        "{camera} {squares:?} {name}: {value}"
                    );
                }
            }
            let reference = render_reference(&scene, &scene.render, &Silent).film;
            for film in [&film, &reference] {
                for z in layer(film, "Z") {
                    let is_right = depth.map_or(z > 1e6, |depth| (z - depth).abs() < 1e-4);
                    assert!(is_right, "{camera} {squares:?}: {z}");
                }
            }
            // Each ray is absorbed or not.
            let found = layer(&reference, "G").iter().sum::<f64>() / 64.0;
            let error = (light * (1.0 - light) / (64.0 * 256.0)).sqrt();
            assert!((found - light).abs() <= 4.5 * error, "{camera} {squares:?}: {found} {light}");
        }
    }
}

/// Light that is scattered on both planes of a camera amid a cloud is that of the reference.
#[test]
fn clouds_are_cut_as_the_reference_cuts_them() {
    let text = r#"
        [camera]
        position = [0.0, 0.0, 3.0]
        target = [0.0, 0.0, 0.0]
        fov = 30.0
        clip = [2.4, 3.3]
        shift = [0.1, -0.05]
        [film]
        size = [8, 8]
        [[medium]]
        region = { sphere = { center = [0.0, 0.0, 0.0], radius = 1.0 } }
        sigma_t = 2.0
        albedo = [0.9, 0.8, 0.7]
        phase = { type = "henyey-greenstein", g = 0.4 }
        [[light]]
        type = "sun"
        direction = [0.3, -1.0, -0.4]
        irradiance = 3.0
        [[light]]
        type = "environment"
        radiance = 0.3
        "#;
    let folder = tempfile::tempdir().unwrap();
    let scene: Scene = scene(folder.path(), text, 64, 20_000);
    let settings = |seed| RenderSettings { seed, ..scene.render };
    let ours = means(|seed| render(&scene, &settings(seed), &Silent).unwrap().film);
    let reference = means(|seed| render_reference(&scene, &settings(seed), &Silent).film);
    agree(ours, reference, 0.01, "a cloud between two planes");
}
