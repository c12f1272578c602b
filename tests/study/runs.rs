//! A study from outside: nothing is lost, files parse, the page has what it must.

use std::path::Path;

use assert_cmd::Command;
use fogbow::image::read_layers;
use fogbow::render::Silent;
use fogbow::scene::{LoadOptions, Scene};
use fogbow::study::{Estimate, Outcome, RUNS, Request, Results, Study, write_report};

const SCENE: &str = "
[camera]
position = [0, 0, 4]
target = [0, 0, 0]
fov = 40

[film]
size = [16, 12]

[render]
rays = 8
photons = 400

[[medium]]
region = { sphere = { center = [0, 0, 0], radius = 1 } }
sigma_t = 2
albedo = 0.8

[[light]]
type = \"point\"
position = [0, 3, 0]
intensity = [9, 9, 9]
";

fn scene_in(folder: &Path) -> Scene {
    let path = folder.join("ball.toml");
    std::fs::write(&path, SCENE).unwrap();
    Scene::load(&path, &LoadOptions::default()).unwrap()
}

fn request() -> Request {
    let candidates = ["fixed", "xs-scattering", "xs-step", "variance"].map(str::to_owned).to_vec();
    Request { candidates, budgets: vec![8, 2], seeds: 2, reference: Some(64), ..Request::default() }
}

fn study(scene: &Scene, out: &Path, resume: bool) -> Results {
    Study::new(scene, out, &request(), resume).unwrap().run("a test", &Silent).unwrap()
}

/// What does not depend on the clock: who was rendered, and its errors.
fn untimed(results: &Results) -> Vec<String> {
    let trials = results.points.iter().flat_map(|point| &point.runs);
    let told = |t: &fogbow::study::RunResult| {
        format!(
            "{} {} {} {:?} {:?}",
            t.run.candidate, t.run.point, t.run.seed, t.run.work, t.errors
        )
    };
    trials.map(told).collect()
}

#[test]
fn a_killed_study_goes_on_as_if_it_had_not_been() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scene_in(folder.path());
    let whole = study(&scene, &folder.path().join("whole"), false);

    let killed = folder.path().join("killed");
    study(&scene, &killed, false);
    let log = killed.join(RUNS);
    let lines = std::fs::read_to_string(&log).unwrap();
    // Four trials whole, the fifth torn; the picture of the third lost.
    let kept: usize = lines.lines().take(4).map(|line| line.len() + 1).sum();
    std::fs::write(&log, &lines[..kept + 25]).unwrap();
    for (number, line) in lines.lines().enumerate().filter(|(number, _)| *number != 0) {
        let trial: serde_json::Value = serde_json::from_str(line).unwrap();
        if number == 2 || number > 4 {
            std::fs::remove_file(killed.join(trial["exr"].as_str().unwrap())).unwrap();
        }
    }
    let resumed = study(&scene, &killed, true);
    assert_eq!(untimed(&resumed), untimed(&whole));
    let again = std::fs::read_to_string(&log).unwrap();
    let kept: Vec<&str> = lines.lines().take(4).collect();
    assert_eq!(again.lines().take(4).collect::<Vec<_>>(), kept, "done trials are not done again");

    // All is there: nothing is rendered, and every figure is the same.
    assert!(study(&scene, &killed, true) == resumed, "every figure is the same");
    assert_eq!(std::fs::read_to_string(&log).unwrap(), again);
}

#[test]
fn another_study_is_not_resumed() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scene_in(folder.path());
    let out = folder.path().join("out");
    let request = Request { reference: None, ..request() };
    drop(Study::new(&scene, &out, &request, false).unwrap());
    let told = |scene: &Scene, request: &Request, resume| {
        Study::new(scene, &out, request, resume).unwrap_err().to_string()
    };
    let message = told(&scene, &request, false);
    assert!(message.contains("--resume"), "{message}");
    let other = Request { budgets: vec![8, 4], ..request.clone() };
    let message = told(&scene, &other, true);
    assert!(message.contains("study.json") && message.contains("request"), "{message}");
    std::fs::write(folder.path().join("ball.toml"), SCENE.replace("sigma_t = 2", "sigma_t = 3"))
        .unwrap();
    let path = folder.path().join("ball.toml");
    let changed = Scene::load(&path, &LoadOptions::default()).unwrap();
    let message = told(&changed, &request, true);
    assert!(message.contains("scene hash"), "{message}");
}

#[test]
fn results_and_page_have_what_they_must() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scene_in(folder.path());
    let out = folder.path().join("out");
    let results = study(&scene, &out, false);
    write_report(&results, &out).unwrap();

    let text = std::fs::read_to_string(out.join("results.json")).unwrap();
    assert!(serde_json::from_str::<Results>(&text).unwrap() == results, "JSON keeps every bit");
    let headline = results.headline.as_ref().unwrap();
    assert!(results.verdict.len() >= 2 && results.verdict[0].contains(&headline.candidate));
    assert_eq!(headline.candidate, "xs-scattering");
    assert!(headline.error_gain.ratio.is_some() && headline.error_cost.ratio.is_some());
    assert_eq!(results.targets.len(), 2);
    assert!(results.target().name == "reference" && results.target().rays == 64);

    // One row for a trial and a target; gold is measured in as many rounds as there are seeds.
    let mut csv = csv::Reader::from_path(out.join("results.csv")).unwrap();
    let head = csv.headers().unwrap().clone();
    for column in ["candidate", "seed", "seconds", "relative-mse", "flip", "machine", "command"] {
        assert!(head.iter().any(|name| name == column), "{column}");
    }
    let rows: Vec<_> = csv.records().map(Result::unwrap).collect();
    let trials: usize = results.points.iter().map(|point| point.runs.len()).sum();
    assert_eq!((rows.len(), trials), (2 * trials, 2 * (1 + 1 + 2 + 2 + 4)));

    for point in &results.points {
        assert!(point.seconds.estimate > 0.0 && point.seconds.samples == 2);
        if point.candidate == "gold" || point.candidate == "fixed" {
            assert!(matches!(point.gain_at_equal_error, Estimate::None(_)));
        }
        for trial in &point.runs {
            let layers = read_layers(&out.join(&trial.run.exr)).unwrap();
            assert!(layers.get("rays").is_some() && layers.width == 16);
        }
    }

    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    let names = ["gold", "fixed", "xs-scattering", "xs-step", "variance", "reference"];
    let parts =
        ["const PLOTS", "data:image/png;base64,", "aria-sort", "relative error", "march step"];
    for part in names.iter().chain(&parts).chain(&["a test", &scene.hash]) {
        assert!(page.contains(part), "{part}");
    }
    let away = ["src=\"http", "href=\"http", "@import", "url(http", "<link rel=\"stylesheet"];
    for link in away {
        assert!(!page.contains(link), "the page reaches out: {link}");
    }
}

#[test]
fn the_command_makes_a_report_in_a_given_time() {
    let folder = tempfile::tempdir().unwrap();
    scene_in(folder.path());
    let run = |args: &[&str]| {
        Command::new(assert_cmd::cargo::cargo_bin!("fogbow"))
            .current_dir(folder.path())
            .args(["study", "ball.toml", "-o", "out", "--quiet"])
            .args(["--candidates", "fixed,x-transmittance", "--budgets", "8,4"])
            .args(args)
            .output()
            .unwrap()
    };
    let done = run(&["--time", "20s", "--seeds", "2", "--json"]);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let told: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
    assert_eq!(told["plan"]["seeds"], 2, "{told}");
    assert!(folder.path().join("out/report.html").is_file());

    let refused = run(&["--seeds", "2"]);
    assert_eq!(refused.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("--resume"));
    assert_eq!(run(&["--time", "0"]).status.code(), Some(2));
    assert_eq!(run(&["--errors", "-1"]).status.code(), Some(2));
}

/// A small study as a user runs it.
fn command(folder: &Path, args: &[&str]) -> std::process::Command {
    let mut command = std::process::Command::new(assert_cmd::cargo::cargo_bin!("fogbow"));
    command
        .current_dir(folder)
        .args(["study", "ball.toml", "-o", "out", "--quiet", "--json"])
        .args(["--candidates", "fixed,x-transmittance", "--budgets", "8,4,2", "--seeds", "8"])
        .args(args);
    command
}

#[test]
fn a_study_killed_with_minus_9_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    scene_in(folder.path());
    let mut running = command(folder.path(), &[]).spawn().unwrap();
    let log = folder.path().join("out").join(RUNS);
    let lines = || std::fs::read_to_string(&log).unwrap_or_default();
    while lines().lines().count() < 5 {
        assert!(running.try_wait().unwrap().is_none(), "it was done too soon to be killed");
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    running.kill().unwrap(); // SIGKILL
    running.wait().unwrap();
    let before = lines();
    let whole: Vec<&str> = before.split_inclusive('\n').filter(|l| l.ends_with('\n')).collect();
    let pictures = |line: &str| {
        let trial: serde_json::Value = serde_json::from_str(line).unwrap();
        folder.path().join("out").join(trial["exr"].as_str().unwrap())
    };
    let written = |line: &&str| pictures(line).metadata().unwrap().modified().unwrap();
    let dates: Vec<_> = whole.iter().map(written).collect();
    assert!(!folder.path().join("out/report.html").exists());

    let done = command(folder.path(), &["--resume"]).output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let after = lines();
    assert!(after.starts_with(&whole.concat()), "the trials done are not done again");
    assert_eq!(whole.iter().map(written).collect::<Vec<_>>(), dates);
    let mut exrs: Vec<_> = after.lines().map(pictures).collect();
    // Gold with eight seeds, fixed with two budgets below the ceiling, x with three.
    assert_eq!(exrs.len(), 8 * (1 + 2 + 3));
    exrs.sort();
    exrs.dedup();
    assert_eq!(exrs.len(), 8 * (1 + 2 + 3), "every trial is there once");
    assert!(folder.path().join("out/report.html").is_file());
}

#[test]
fn more_seeds_are_added_to_a_study() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scene_in(folder.path());
    let out = folder.path().join("out");
    let of = |seeds: u32, resume: bool| {
        let request = Request { seeds, reference: None, ..request() };
        Study::new(&scene, &out, &request, resume).unwrap().run("a test", &Silent).unwrap()
    };
    let two = of(2, false);
    let log = std::fs::read_to_string(out.join(RUNS)).unwrap();
    let four = of(4, true);
    assert_eq!((two.plan.seeds, four.plan.seeds), (2, 4));
    assert!(std::fs::read_to_string(out.join(RUNS)).unwrap().starts_with(&log), "none anew");
    assert_eq!(four.headline.unwrap().seconds.samples, 4);
}

/// Gold, the directed candidate and uniform sampling have three seeds and an answer, whatever else
/// there was time for.
#[test]
fn a_study_in_a_given_time_answers() {
    let folder = tempfile::tempdir().unwrap();
    // Of one strategy, so that what directing costs is known.
    let scene = SCENE.replace("rays = 8\n", "rays = 8\nstrategy = 'fluence-toward-eye'\n");
    std::fs::write(folder.path().join("ball.toml"), scene).unwrap();
    let study = |more: &[&str]| {
        let done = std::process::Command::new(assert_cmd::cargo::cargo_bin!("fogbow"))
            .current_dir(folder.path())
            .args(["study", "ball.toml", "-o", "out", "--quiet", "--time", "15s"])
            .args(more)
            .output()
            .unwrap();
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        let text = std::fs::read_to_string(folder.path().join("out/results.json")).unwrap();
        let results: Results = serde_json::from_str(&text).unwrap();
        (String::from_utf8(done.stdout).unwrap(), results)
    };
    let (told, first) = study(&[]);
    assert!(first.plan.seeds >= 3, "{:?}", first.plan);
    for name in ["gold", "fixed", "xs-error"] {
        let mut points = first.points.iter().filter(|point| point.candidate == name).peekable();
        assert!(points.peek().is_some(), "{name}");
        assert!(points.all(|point| point.runs.len() >= 3), "{name}: {:?}", first.plan);
    }
    let headline = first.headline.as_ref().unwrap();
    for contrast in [&headline.time_saved, &headline.error_gain, &headline.error_cost] {
        let ratio = contrast.ratio.as_ref().unwrap();
        assert!(ratio.samples >= 3 && ratio.range.is_some(), "{ratio:?}");
    }
    // Which of the two is faster is what the study measures.
    let verb = match headline.time_saved.outcome {
        Outcome::Above | Outcome::Open => "is ",
        Outcome::Below | Outcome::Equal => "takes ",
    };
    assert!(told.starts_with(&format!("xs-error with 8 rays {verb}")), "{told}");
    if headline.settling.is_some_and(|settling| settling.seeds.is_some()) {
        assert!(told.contains("--time") && told.contains("--resume"), "{told}");
    }

    // More time brings more seeds, on top of those there are.
    let (_, more) = study(&["--resume"]);
    assert!(more.plan.seeds > first.plan.seeds, "{:?} after {:?}", more.plan, first.plan);
}

/// A study of uniform rays alone in `folder`.
fn fixed(folder: &Path, resume: bool) -> Results {
    let request = Request {
        candidates: vec!["fixed".into()],
        budgets: vec![2],
        seeds: 2,
        ..Request::default()
    };
    let scene = scene_in(folder);
    let study = Study::new(&scene, &folder.join("out"), &request, resume).unwrap();
    study.run("a test", &Silent).unwrap()
}

/// A trial on disk holds no figure of any metric: all are counted anew from the pictures.
#[test]
fn metrics_are_counted_from_the_stored_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let whole = fixed(folder.path(), false);
    let out = folder.path().join("out");
    let trials = std::fs::read_to_string(out.join(RUNS)).unwrap();
    assert!(!trials.contains("vdp") && !trials.contains("mse"), "{trials}");
    for file in ["results.json", "results.csv"] {
        std::fs::remove_file(out.join(file)).unwrap();
    }
    assert!(fixed(folder.path(), true) == whole, "every figure is the same");
    assert_eq!(std::fs::read_to_string(out.join(RUNS)).unwrap(), trials, "nothing is rendered");
    let csv = std::fs::read_to_string(out.join("results.csv")).unwrap();
    assert!(csv.contains(",vdp-localized-mean,vdp-localized-visible,"), "{csv}");
}

/// Results without a figure are refused by its name: 0 would say that no difference is seen.
#[test]
fn results_without_a_figure_are_refused_by_its_name() {
    let folder = tempfile::tempdir().unwrap();
    fixed(folder.path(), false);
    let text = std::fs::read_to_string(folder.path().join("out/results.json")).unwrap();
    let mut json: serde_json::Value = serde_json::from_str(&text).unwrap();
    let own = json["targets"][0]["own"].as_object_mut().unwrap();
    assert!(own.remove("vdp_localized_mean_percent").is_some_and(|v| v.is_number()));
    let message = serde_json::from_value::<Results>(json).unwrap_err().to_string();
    assert!(message.contains("vdp_localized_mean_percent"), "{message}");
}
