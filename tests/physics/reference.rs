//! The unbiased reference where it samples in a way of its own.

use fogbow::render::{Silent, render_reference};
use fogbow::scene::{LoadOptions, RenderSettings, Scene};

/// A lamp in fog over a floor, seen from within the fog, with this anisotropy of its
/// Henyey-Greenstein phase function.
fn foggy(g: f64) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    let text = format!(
        "[camera]
        position = [0, 0.6, 3]
        target = [0, 0.3, 0]
        fov = 50
        [film]
        size = [24, 16]
        [[light]]
        type = 'spot'
        position = [-0.8, 1, 0.4]
        target = [0.4, 0, 0]
        angle = 50
        falloff = 40
        intensity = 2.0
        [[medium]]
        region = {{ box = {{ min = [-3, 0, -3], max = [3, 2, 4] }} }}
        sigma_t = 0.5
        albedo = 0.95
        phase = {{ type = 'henyey-greenstein', g = {g} }}
        [[surface]]
        shape = 'plane'
        point = [0, 0, 0]
        normal = [0, 1, 0]
        material = {{ type = 'diffuse', reflectance = 0.5 }}
        "
    );
    std::fs::write(&path, text).unwrap();
    Scene::load(&path, &LoadOptions::default()).unwrap()
}

/// Mean of a picture over 8 seeds, and its standard error.
fn mean(scene: &Scene) -> [f64; 2] {
    const SEEDS: u32 = 8;
    let means: Vec<f64> = (0..SEEDS)
        .map(|seed| {
            let settings = RenderSettings { rays: 1024, seed: seed.into(), ..scene.render };
            let image = render_reference(scene, &settings, &Silent).film.image();
            let green = &image.channels()[1];
            green.iter().map(|v| f64::from(*v)).sum::<f64>() / green.len() as f64
        })
        .collect();
    let count = f64::from(SEEDS);
    let mean = means.iter().sum::<f64>() / count;
    let spread = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>();
    [mean, (spread / (count * (count - 1.0))).sqrt()]
}

/// From a concentration of 50 on, which Henyey-Greenstein has at g = 0.9, rays are sent nearly at
/// lamps as well. Light differs by 0.3 % a little below and above that; what is found must agree, and
/// scatter much less above. A bound of 4 standard errors, estimated from 8 seeds each, makes a false
/// alarm of 1e-3 at these fixed seeds.
#[test]
fn rays_sent_at_lamps_change_nothing_but_noise() {
    let [below, above] = [foggy(0.885), foggy(0.903)];
    let concentration = |scene: &Scene| scene.media.get(0).phase.concentration();
    assert!(concentration(&below) < 50.0 && concentration(&above) > 50.0);
    let ([a, a_off], [b, b_off]) = (mean(&below), mean(&above));
    let off = a_off.hypot(b_off);
    assert!((a - b).abs() < 4.0 * off, "{a} below, {b} above, {off} their standard error");
    assert!(b_off < 0.02 * b && b_off < 0.5 * a_off, "{a_off} of {a}, {b_off} of {b}");
}
