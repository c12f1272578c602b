//! Light at edges of thick media: round terminators, and at faces that are seen aslant.

use std::f64::consts::PI;

use fogbow::image::{Film, Window};
use fogbow::render::{Silent, render};
use fogbow::scene::Strategy::{self, Beams, FluenceTowardEye, Moments};
use fogbow::scene::{RenderSettings, Scene, StrategyRequest};

use crate::pictures::{Mean, agree, mean, scene};

/// Seeds of a mean: its error, which they tell, makes one false alarm in 350 comparisons (Student's t). They are fixed.
const SEEDS: u64 = 8;

/// Bias that is allowed.
const BIAS: f64 = 0.02;

/// The part of the ball's picture round its terminator: a sixth of the ball's width.
const TERMINATOR: Window = Window { left: 27, top: 0, width: 10, height: 64 };

/// The pictures of the first seeds, by one strategy.
fn films(scene: &Scene, settings: &RenderSettings, strategy: Strategy) -> Vec<Film> {
    let strategy = StrategyRequest::Asked(strategy);
    let of_seed = |seed| RenderSettings { seed, strategy, ..*settings };
    (0..SEEDS).map(|seed| render(scene, &of_seed(seed), &Silent).unwrap().film).collect()
}

/// Mean of the green channel over the picture within `rows` above and below the middle.
fn mean_over(film: &Film, rows: [f64; 2]) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for (index, light) in film.layer("G").unwrap().iter().enumerate() {
        let row = ((index / film.width()) as f64 - 31.5).abs();
        if (rows[0]..rows[1]).contains(&row) {
            sum += f64::from(*light);
            count += 1.0;
        }
    }
    sum / count
}

/// Where the sun grazes a thick ball light falls by orders of magnitude within a free path, and photons have wide
/// kernels. What is right at the terminator and its limb is of the reference with 32,000 rays a pixel.
#[test]
fn terminators_are_as_bright_as_the_reference() {
    let folder = tempfile::tempdir().unwrap();
    for (g, strategies, right) in [
        (0.0, &[FluenceTowardEye][..], [[2.2485e-2, 2.1e-5], [2.6779e-2, 2.8e-5]]),
        (-0.5, &[Moments, Beams], [[1.5584e-2, 1.8e-5], [1.9259e-2, 4.7e-5]]),
    ] {
        let text = format!(
            r#"
            [camera]
            position = [0.0, 0.0, 9.0]
            target = [0.0, 0.0, 0.0]
            fov = 15.0
            [film]
            size = [64, 64]
            [[medium]]
            region = {{ sphere = {{ center = [0.0, 0.0, 0.0], radius = 1.0 }} }}
            sigma_t = 20.0
            albedo = 0.99
            phase = {{ type = "henyey-greenstein", g = {g:?} }}
            [[light]]
            type = "sun"
            direction = [-1.0, 0.0, 0.0]
            irradiance = 1.0
            "#
        );
        let scene = scene(folder.path(), &text, 8, 100_000);
        let settings = RenderSettings { crop: Some(TERMINATOR), ..scene.render };
        for &strategy in strategies {
            let films = films(&scene, &settings, strategy);
            let parts = [("terminator", [0.0, 20.0]), ("its limb", [20.0, 27.0])];
            for ((part, rows), [value, error]) in parts.into_iter().zip(right) {
                let all: Vec<f64> = films.iter().map(|film| mean_over(film, rows)).collect();
                let what = format!("{strategy:?}, g {g}, {part}");
                agree([Mean::of(&all)], [Mean { value, error }], BIAS, &what);
            }
        }
    }
}

/// What a slab of thickness 16 sends toward 60° from its normal, under the sun at its zenith, by adding-doubling.
#[test]
fn kernels_of_photons_keep_light_within_faces() {
    let folder = tempfile::tempdir().unwrap();
    let (sine, cosine) = 60_f64.to_radians().sin_cos();
    for (side, expected) in [(1.0, 0.66319), (-1.0, 0.01187)] {
        let (face, x) = (0.5 * side, 20.0 * sine);
        let z = face + 20.0 * side * cosine;
        let text = format!(
            r#"
            [camera]
            type = "orthographic"
            position = [{x:?}, 0.0, {z:?}]
            target = [0.0, 0.0, {face:?}]
            up = [0.0, 1.0, 0.0]
            height = 1.0
            [film]
            size = [16, 16]
            [[medium]]
            region = {{ box = {{ min = [-4.0, -4.0, -0.5], max = [4.0, 4.0, 0.5] }} }}
            sigma_t = 16.0
            albedo = 0.99
            phase = {{ type = "henyey-greenstein", g = -0.5 }}
            [[light]]
            type = "sun"
            direction = [0.0, 0.0, -1.0]
            irradiance = 1.0
            "#
        );
        let scene = scene(folder.path(), &text, 4, 100_000);
        let films = films(&scene, &scene.render, Beams);
        let all: Vec<f64> = films.iter().map(|film| PI * mean(film).0).collect();
        let expected = Mean { value: expected, error: 0.0 };
        agree([Mean::of(&all)], [expected], BIAS, &format!("beams on the side {side}"));
    }
}
