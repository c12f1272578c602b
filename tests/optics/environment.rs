//! Environments: their integrals against what is seen of them.

use std::f64::consts::PI;

use fogbow::light::{EmissionTarget, Environment, Light};
use fogbow::math::{Rgb, WorldPoint};
use glam::DVec3;

const WHITE: Rgb = Rgb::ONE;

/// Integrals over all directions and, with the cosine, over the upper ones, by the midpoint rule in the
/// sine of the elevation.
fn by_midpoints(environment: &Environment) -> [Rgb; 2] {
    const STEPS: [u32; 2] = [20_000, 64];
    let mut sums = [Rgb::ZERO; 2];
    for i in 0..STEPS[0] {
        let y = 2.0 * (f64::from(i) + 0.5) / f64::from(STEPS[0]) - 1.0;
        for j in 0..STEPS[1] {
            let (sin, cos) = (2.0 * PI * (f64::from(j) + 0.5) / f64::from(STEPS[1])).sin_cos();
            let across = (1.0 - y * y).sqrt();
            let radiance = environment.radiance(DVec3::new(across * sin, y, across * cos));
            sums = [sums[0] + radiance, sums[1] + radiance * y.max(0.0)];
        }
    }
    sums.map(|sum| sum * (4.0 * PI / f64::from(STEPS[0] * STEPS[1])))
}

#[test]
fn integrals_of_environments_are_those_of_what_is_seen() {
    let texels = (0..40).map(|i| [i as f32 % 7.0, 1.0, i as f32 % 3.0]).collect();
    let smooth =
        [(-90.0, WHITE), (0.0, Rgb::new(0.3, 0.2, 0.1)), (30.0, WHITE * 2.0), (90.0, Rgb::ZERO)];
    let edged = [(-20.0, WHITE), (10.0, WHITE), (10.0, WHITE * 3.0), (50.0, WHITE)];
    // Stops at sines of even steps leave the midpoint rule exact but for the cosine; edges and
    // rows of pictures cost it a step.
    for (name, environment, slack) in [
        ("constant", Environment::constant(WHITE), 1e-8),
        ("smooth gradient", Environment::gradient(&smooth), 1e-8),
        ("gradient with an edge", Environment::gradient(&edged), 1e-3),
        // Its middle row lies on both sides of the horizon.
        ("picture", Environment::picture(8, 5, texels, WHITE * 0.5, 33.0), 1e-3),
    ] {
        let environment = environment.unwrap();
        let [all, up] = by_midpoints(&environment);
        let reach = EmissionTarget::new(WorldPoint::new(0.0, 0.0, 0.0), 1.0).unwrap();
        let found = Light::Environment(environment.clone()).power(&reach) / PI;
        assert!(((found - all) / all).abs().max_element() < slack, "{name}: {found} not {all}");
        let found = environment.irradiance_up();
        assert!(((found - up) / up).abs().max_element() < slack, "{name}: {found} not {up}");
    }
}

#[test]
fn a_gradient_goes_through_its_stops_by_the_sine() {
    let (low, high) = (Rgb::new(0.1, 0.2, 0.3), Rgb::new(2.0, 1.0, 0.5));
    let sky = Environment::gradient(&[(-30.0, low), (30.0, high)]).unwrap();
    let at = |sine: f64| sky.radiance(DVec3::new((1.0 - sine * sine).sqrt(), sine, 0.0));
    for (sine, expected) in [
        (-1.0, low),
        (-0.7, low),
        (-0.5, low),
        (0.0, low.midpoint(high)),
        (0.25, low.lerp(high, 0.75)),
        (0.5, high),
        (1.0, high),
    ] {
        assert!((at(sine) - expected).abs().max_element() < 1e-12, "{sine}: {}", at(sine));
    }
    // Two stops at one place are an edge; the turn about the vertical changes nothing.
    let edge = Environment::gradient(&[(0.0, low), (0.0, high)]).unwrap();
    for turn in [0.0f64, 1.0, 4.0] {
        let around = |y: f64| DVec3::new(turn.cos(), y, turn.sin()).normalize();
        assert_eq!(edge.radiance(around(-1e-6)), low);
        assert_eq!(edge.radiance(around(1e-6)), high);
    }
}
