//! Answers of studies against theory: step errors, convergence with photons, the ablation.

#![allow(clippy::print_stderr)] // what is measured is told

use std::path::Path;

use fogbow::render::Silent;
use fogbow::scene::{LoadOptions, Scene};
use fogbow::study::{Estimate, Estimator, Request, Results, Study};

const BALL: &str = "
[camera]
position = [0, 0, 4]
target = [0, 0, 0]
fov = 40

[film]
size = [24, 24]

[render]
rays = 16
photons = 128000
strategy = 'fluence-toward-eye'

[[medium]]
region = { sphere = { center = [0, 0, 0], radius = 1 } }
sigma_t = 4
albedo = 0.98

[[light]]
type = \"point\"
position = [0, 3, 0]
intensity = [9, 9, 9]
";

fn studied(scene: &Path, options: &LoadOptions, request: &Request) -> Results {
    let folder = tempfile::tempdir().unwrap();
    let scene = Scene::load(scene, options).unwrap();
    let study = Study::new(&scene, &folder.path().join("out"), request, false).unwrap();
    study.run("a test", &Silent).unwrap()
}

fn names(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}

/// The README's figures are what this prints. With its fixed seeds it always says the same. Three seeds
/// leave noise: over 16 other triples the exponent of the noise is 0.01 above theory with a standard
/// deviation of 0.066, and that of the error 0.13 above the exponent of the noise with one of 0.09, so that
/// one triple in 7 and one in 100 would be off by more than the bound. Nine seeds, at three times the
/// cost, still leave 0.046. The next candidate of theory is 0.8 away: beams, whose noise stays.
#[test]
fn errors_fall_with_photons_as_theory_says() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ball.toml");
    std::fs::write(&path, BALL).unwrap();
    let candidates = names(&["photons"]);
    let request = Request { candidates, seeds: 3, reference: Some(2500), ..Request::default() };
    let results = studied(&path, &LoadOptions::default(), &request);
    let told = results.convergence.unwrap();
    eprintln!("{told:#?}");
    assert_eq!((told.estimator, told.points.len()), (Estimator::Lattice, 4));
    let [noise, bias] = told.expected.unwrap();
    let measured = told.mse.unwrap();
    assert!((noise - 0.1..bias + 0.1).contains(&measured), "{measured} of {noise} to {bias}");
    assert!((told.noise.unwrap() - noise).abs() < 0.1, "{:?} of {noise}", told.noise);
}

#[test]
fn a_coarse_step_is_told_from_noise_and_bias() {
    let smoke = Path::new(env!("CARGO_MANIFEST_DIR")).join("volumes/smoke.toml");
    let exact = LoadOptions::default().size([16, 16]).photons(20_000).rays(4);
    let request = Request {
        candidates: names(&["fixed", "xs-rays", "xs-step"]),
        budgets: vec![4, 2, 1],
        seeds: 2,
        reference: Some(200),
        ..Request::default()
    };
    let steps = |results: &Results, name: &str| {
        let of = |p: &&fogbow::study::PointResult| p.candidate == name;
        let point = results.points.iter().find(of).unwrap();
        assert_eq!(point.finest_step.is_empty(), point.mse_split.unwrap().step == Some(0.0));
        let split = point.mse_split.unwrap();
        // The parts make up the error, to what the target's own error is.
        let errors: Vec<f64> = point.runs.iter().map(|t| t.errors["reference"].mse).collect();
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        let sum = split.noise + split.step.unwrap() + split.bias + results.target().own.mse;
        assert!((sum - mean).abs() < 1e-6 * mean, "{sum} of {mean}");
        split.step.unwrap() / mean
    };
    let coarse = studied(&smoke, &exact.clone().with("render.step", 0.5), &request);
    let share = steps(&coarse, "fixed");
    assert!(share > 0.01, "steps of half a metre make {share} of the error");

    let fine = studied(&smoke, &exact, &request);
    assert_eq!((steps(&fine, "fixed"), steps(&fine, "xs-rays")), (0.0, 0.0));
    let directed = steps(&fine, "xs-step");
    assert!(directed.abs() < share, "directed steps make {directed}");

    // What was measured is told, what was not is not.
    let parts: Vec<&str> = fine.ablation.iter().map(|effect| effect.part.as_str()).collect();
    assert_eq!(parts, ["directed rays alone", "directed step alone"]);
    for effect in &fine.ablation {
        let is_told = matches!(effect.error_gain, Estimate::Found(_));
        assert_eq!(is_told, effect.outcome() != "not told");
    }
}
