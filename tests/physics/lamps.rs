//! Lamps in fog: single scattering against quadrature, all orders against the reference.

use std::f64::consts::PI;

use fogbow::render::{Silent, render, render_reference};
use fogbow::scene::Strategy::{self, Beams, FluenceTowardEye, Moments, SharedGathers, Traced};
use fogbow::scene::{RenderSettings, StrategyRequest};
use glam::DVec3;

use crate::pictures::{ERRORS, Mean, agree, mean, scene};

/// Half of the box of fog.
const HALF: f64 = 4.0;

/// Extinction coefficient and albedo of the fog.
const FOG: (f64, f64) = (0.3, 0.9);

/// Mean cosine of the fog.
const G: f64 = 0.5;

/// Middle of the lamp and half of its edges, the first times the second its normal: it shines toward -y.
const LAMP: [DVec3; 3] =
    [DVec3::new(0.4, 0.8, 0.2), DVec3::new(0.3, 0.0, 0.1), DVec3::new(-0.1, 0.0, 0.3)];

/// Radiance of the lamp.
const RADIANCE: f64 = 30.0;

const CAMERA: DVec3 = DVec3::new(2.0, -0.5, 9.0);

/// Where the camera looks: past the lamp on the side on which it shines, so that it is not seen.
const TARGET: DVec3 = DVec3::new(0.3, -0.6, 0.0);

/// A place just past an edge of the lamp, toward which the camera looks along the side on which it shines.
const PAST_EDGE: DVec3 = DVec3::new(0.3, 0.8, -0.4);

/// The lamp in the fog, seen in a narrow picture from outside, in whose middle `target` is.
fn fog(target: DVec3, fov: f64, render: &str) -> String {
    let [center, u, v] = LAMP.map(|v| v.to_array());
    let (sigma_t, albedo) = FOG;
    format!(
        r#"
        [camera]
        position = {:?}
        target = {:?}
        fov = {fov:?}
        [film]
        size = [16, 16]
        [render]
        {render}
        [[medium]]
        region = {{ box = {{ min = [-{HALF:?}, -{HALF:?}, -{HALF:?}], max = [{HALF:?}, {HALF:?}, {HALF:?}] }} }}
        sigma_t = {sigma_t:?}
        albedo = {albedo:?}
        phase = {{ type = "henyey-greenstein", g = {G:?} }}
        [[surface]]
        shape = "quad"
        center = {center:?}
        u = {u:?}
        v = {v:?}
        emission = {RADIANCE:?}
        material = {{ type = "diffuse", reflectance = 0.0 }}
        "#,
        CAMERA.to_array(),
        target.to_array(),
    )
}

/// The sum over the midpoints of `steps` parts of [-1, 1], times 2 over their number.
fn integral(steps: u32, f: impl Fn(f64) -> f64) -> f64 {
    let at = |step: u32| 2.0 * (f64::from(step) + 0.5) / f64::from(steps) - 1.0;
    (0..steps).map(|step| f(at(step))).sum::<f64>() * 2.0 / f64::from(steps)
}

/// Radiance of the lamp's light that is scattered once along the middle of the picture, by so many places along each edge
/// of the lamp.
fn scattered_once(target: DVec3, places: u32) -> f64 {
    let (sigma_t, albedo) = FOG;
    let direction = (target - CAMERA).normalize();
    // The camera looks in through the side toward it, and out through the opposite one.
    let (enter, leave) = ((HALF - CAMERA.z) / direction.z, (-HALF - CAMERA.z) / direction.z);
    let [center, u, v] = LAMP;
    let normal = u.cross(v);
    let area = 4.0 * normal.length();
    let normal = normal.normalize();
    let half = 0.5 * (leave - enter);
    half * integral(2000, |along| {
        let t = enter + half * (along + 1.0);
        let p = CAMERA + direction * t;
        let through = sigma_t * albedo * (-sigma_t * (t - enter)).exp();
        let from_lamp = |a: f64, b: f64| {
            let to = center + u * a + v * b - p;
            let distance = to.length();
            let w = to / distance;
            let cosine = (-w.dot(normal)).max(0.0);
            // Light goes on along -w, and to the camera along -direction.
            let mu = w.dot(direction);
            let phase = (1.0 - G * G) / (4.0 * PI * (1.0 + G * G - 2.0 * G * mu).powf(1.5));
            RADIANCE * cosine / (distance * distance) * phase * (-sigma_t * distance).exp()
        };
        through * 0.25 * area * integral(places, |a| integral(places, |b| from_lamp(a, b)))
    })
}

/// The mean of the picture by one strategy over `seeds` seeds.
fn seen(text: &str, strategy: Strategy, [rays, photons, seeds]: [u32; 3]) -> Mean {
    let folder = tempfile::tempdir().unwrap();
    let scene = scene(folder.path(), text, rays, photons.into());
    let of_seed = |seed| {
        let strategy = StrategyRequest::Asked(strategy);
        let settings = RenderSettings { seed, strategy, ..scene.render };
        mean(&render(&scene, &settings, &Silent).unwrap().film).0
    };
    Mean::of(&(0..u64::from(seeds)).map(of_seed).collect::<Vec<f64>>())
}

/// By light that is sampled along the ray alone, and by that which is cached but near the lamp.
#[test]
fn light_scattered_once_is_that_by_quadrature() {
    for (target, places) in [(TARGET, 24), (PAST_EDGE, 96)] {
        let expected = scattered_once(target, places);
        let text = fog(target, 0.05, "max_scatter = 1");
        for (strategy, bias) in [(Beams, 0.0), (FluenceTowardEye, 0.01)] {
            let light = seen(&text, strategy, [64, 1000, 8]);
            assert!(light.error < 0.005 * expected, "{strategy:?}: {light:?}");
            let right = Mean { value: expected, error: 0.0 };
            agree([light], [right], bias, &format!("{strategy:?} toward {target}"));
        }
        let folder = tempfile::tempdir().unwrap();
        let exact = scene(folder.path(), &text, 20_000, 0);
        let (value, error) = mean(&render_reference(&exact, &exact.render, &Silent).film);
        assert!((value - expected).abs() < ERRORS * error, "{value} ± {error} not {expected}");
    }
}

/// Scattered once, the light of the lamp and a sky together is the sum of each alone: points on a ray are sampled equiangularly
/// for the lamp and by opacity for the sky. Within 4.5 standard errors, by 8 seeds each: one false alarm in 1000 at these.
#[test]
fn light_of_a_lamp_and_a_sky_adds_up() {
    let lamp = fog(TARGET, 0.05, "max_scatter = 1");
    let dark = lamp.replace(&format!("emission = {RADIANCE:?}"), "emission = 0.0");
    assert_ne!(lamp, dark);
    let sky = "[[light]]\ntype = \"environment\"\nradiance = 0.15\n";
    for (strategy, bias) in [(Beams, 0.0), (FluenceTowardEye, 0.01)] {
        let texts = [format!("{lamp}{sky}"), lamp.clone(), format!("{dark}{sky}")];
        let [both, of_lamp, of_sky] = texts.map(|text| seen(&text, strategy, [64, 1000, 8]));
        let value = of_lamp.value + of_sky.value;
        for part in [&of_lamp, &of_sky] {
            assert!(part.value > 0.2 * value && part.error < 0.005 * value, "{part:?} of {value}");
        }
        let sum = Mean { value, error: of_lamp.error.hypot(of_sky.error) };
        agree([both], [sum], bias, &format!("{strategy:?}"));
    }
}

/// Within 2 % and the noise of six seeds. The right one is of the reference with 64,000 rays a pixel.
#[test]
fn lamps_in_fog_are_as_bright_as_the_reference() {
    let text = fog(TARGET, 30.0, "");
    let right = Mean { value: 0.09171, error: 1.0e-4 };
    for strategy in [Beams, FluenceTowardEye, Moments, SharedGathers, Traced] {
        let light = seen(&text, strategy, [64, 30_000, 6]);
        agree([light], [right], 0.02, &format!("{strategy:?}"));
    }
}
