//! `fogbow verify`: all that it checks quickly holds, and planted faults are found.

use assert_cmd::Command;
use fogbow::math::{Ray, Rgb, Span, Stream, World};
use fogbow::medium::{Emission, Media};
use fogbow::vdb::{Grid, GridToWrite, ReadAs, VdbFile, write};
use fogbow::verify::{Effort, Marched, Outcome, Parts, cases, page, run};

/// Names of the cases, among those that begin with one of `prefixes`, that fail on `parts`.
fn red(parts: &Parts, prefixes: &[&str]) -> Vec<String> {
    let chosen = cases(Effort::Quick);
    let chosen = chosen.iter().filter(|c| prefixes.iter().any(|p| c.name.starts_with(p)));
    let outcomes: Vec<Outcome> = chosen.map(|case| case.run(parts)).collect();
    assert!(!outcomes.is_empty(), "no case begins with {prefixes:?}");
    outcomes.into_iter().filter(|o| !o.holds()).map(|o| o.name).collect()
}

/// All but whole pictures, which planted faults here do not reach.
const QUICKEST: [&str; 6] =
    ["beer-lambert", "transmittance", "free-flight", "phase", "film", "stiff"];

#[test]
fn the_quick_cases_hold() {
    let parts = Parts::fogbow();
    let outcomes = run(&cases(Effort::Quick), &parts, |_| ());
    let wrong = outcomes.iter().filter(|o| !o.holds());
    let wrong: Vec<_> = wrong.map(|o| format!("{}: {}", o.name, o.worst_in_words())).collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Steps with 1 - sigma_t dt in place of the exponential.
fn explicit_march(media: &Media, ray: &Ray<World>, span: Span, step: f64, jitter: f64) -> Marched {
    let steps = (span.length() / step).ceil().clamp(1.0, 1e5);
    let dt = span.length() / steps;
    let (mut transmittance, mut emitted) = (Rgb::ONE, Rgb::ZERO);
    for index in 0..steps as u32 {
        let p = ray.at(span.start + (f64::from(index) + jitter) * dt);
        for medium in media.iter() {
            if let Some(Emission::Density(rate)) = &medium.emission {
                emitted += transmittance * *rate * medium.density.value(p) * dt;
            }
        }
        transmittance *= Rgb::ONE - media.sigma_t_at(p) * dt;
    }
    Marched { transmittance, emitted }
}

#[test]
fn a_march_by_explicit_steps_is_found() {
    let parts = Parts { march: Box::new(explicit_march), ..Parts::fogbow() };
    let red = red(&parts, &QUICKEST);
    for name in ["beer-lambert/constant", "stiff/bounds", "stiff/constant"] {
        assert!(red.iter().any(|r| r == name), "{name} is not among {red:?}");
    }
}

#[test]
fn a_phase_function_off_by_4_pi_is_found() {
    let off = 4.0 * std::f64::consts::PI;
    let parts =
        Parts { phase: Box::new(move |phase, cosine| off * phase.eval(cosine)), ..Parts::fogbow() };
    assert_eq!(red(&parts, &QUICKEST), ["phase/normalization", "phase/mean-cosine"]);
}

/// Forgets active tiles.
fn leaves_alone(grid: &GridToWrite) -> fogbow::Result<Grid<f32>> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("leaves.vdb");
    write(&path, &[GridToWrite { tiles: Vec::new(), ..grid.clone() }])?;
    VdbFile::open(&path)?.read_scalar(0, ReadAs::Density)
}

#[test]
fn an_export_of_leaves_alone_is_found() {
    let parts = Parts { export: Box::new(leaves_alone), ..Parts::fogbow() };
    assert_eq!(red(&parts, &QUICKEST), ["beer-lambert/tiles"]);

    let chosen: Vec<_> =
        cases(Effort::Quick).into_iter().filter(|c| c.name == "beer-lambert/tiles").collect();
    let html = page(&run(&chosen, &parts, |_| ()), "fogbow verify --quick").unwrap();
    let again = "fogbow verify --quick --case &#x27;beer-lambert&#x2f;tiles&#x27;";
    assert!(html.contains("1 failed") && html.contains(again), "{html}");
}

#[test]
fn accumulation_in_float_is_found() {
    let mean = |radiances: &mut dyn Iterator<Item = f64>| {
        let (sum, count) = radiances.fold((0f32, 0f32), |(s, n), v| (s + v as f32, n + 1.0));
        f64::from(sum / count)
    };
    let parts = Parts { mean: Box::new(mean), ..Parts::fogbow() };
    assert_eq!(red(&parts, &QUICKEST), ["film/mean-of-many"]);
}

#[test]
fn a_clamp_on_radiance_is_found() {
    let fogbow = Parts::fogbow().mean;
    let mean = move |radiances: &mut dyn Iterator<Item = f64>| {
        fogbow(&mut radiances.map(|radiance| radiance.min(100.0)))
    };
    let parts = Parts { mean: Box::new(mean), ..Parts::fogbow() };
    let red = red(&parts, &QUICKEST);
    assert!(red.iter().any(|name| name == "film/rare-bright-sample"), "{red:?}");
}

/// Null-collision tracking with a tenth of the majorant: where density exceeds it, collisions are
/// missed.
fn low_majorant(media: &Media, ray: &Ray<World>, span: Span, rng: &mut Stream) -> Option<f64> {
    let medium = media.get(0);
    let majorant = 0.1 * medium.sigma_t.x * medium.density.maximum();
    let inside = medium.density.bounds()?.clip(ray).intersect(span);
    let mut t = inside.start;
    loop {
        t += rng.exponential() / majorant;
        if t >= inside.end {
            return None;
        }
        if rng.uniform() * majorant < media.sigma_t_at(ray.at(t)).x {
            return Some(t);
        }
    }
}

#[test]
fn a_majorant_too_small_is_found() {
    let parts = Parts { free_flight: Box::new(low_majorant), ..Parts::fogbow() };
    assert_eq!(red(&parts, &QUICKEST), ["free-flight/spikes"]);
}

/// The program with these arguments.
fn verify(arguments: &[&str]) -> std::process::Output {
    Command::cargo_bin("fogbow").unwrap().arg("verify").args(arguments).output().unwrap()
}

#[test]
fn the_command_prints_a_table_json_and_a_page() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("page.html");
    let output = verify(&["--quick", "--case", "stiff", "--html", page.to_str().unwrap()]);
    let table = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(0), "{table}");
    assert!(table.contains("holds") && table.contains("stiff/bounds"), "{table}");
    assert!(table.contains("0 failed"), "{table}");
    let html = std::fs::read_to_string(&page).unwrap();
    assert!(html.contains("<svg") && html.contains("stiff&#x2f;constant"), "{html}");
    assert!(!html.contains("src=") && !html.contains("href="), "the page needs nothing else");

    let output = verify(&["--quick", "--case", "beer-lambert/ramp", "--json"]);
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["failed"], 0);
    assert_eq!(report["cases"][0]["name"], "beer-lambert/ramp");
    assert!(report["cases"][0]["checks"][0]["found"].is_number(), "{report}");
}

#[test]
fn a_name_that_no_case_has_is_misuse() {
    let output = verify(&["--case", "nothing"]);
    assert_eq!(output.status.code(), Some(2));
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(message.contains("--case nothing"), "{message}");
}
