//! Studies that were begun before a metric was known go on.

use std::path::Path;

use fogbow::render::Silent;
use fogbow::scene::{LoadOptions, Scene};
use fogbow::study::{Request, Results, Study, TRIALS};
use serde_json::Value;

const SCENE: &str = "
[camera]
position = [0, 0, 4]
target = [0, 0, 0]
fov = 40

[film]
size = [16, 12]

[render]
rays = 4
photons = 200

[[medium]]
region = { sphere = { center = [0, 0, 0], radius = 1 } }
sigma_t = 2
albedo = 0.8

[[light]]
type = \"point\"
position = [0, 3, 0]
intensity = [9, 9, 9]
";

fn study(folder: &Path, resume: bool) -> Results {
    let path = folder.join("ball.toml");
    std::fs::write(&path, SCENE).unwrap();
    let scene = Scene::load(&path, &LoadOptions::default()).unwrap();
    let request = Request {
        candidates: vec!["fixed".into()],
        budgets: vec![2],
        seeds: 2,
        ..Request::default()
    };
    Study::new(&scene, &folder.join("out"), &request, resume)
        .unwrap()
        .run("a test", &Silent)
        .unwrap()
}

/// A trial on disk holds no figure of any metric: all are counted anew from the pictures.
#[test]
fn metrics_are_counted_from_the_stored_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let whole = study(folder.path(), false);
    let out = folder.path().join("out");
    let trials = std::fs::read_to_string(out.join(TRIALS)).unwrap();
    assert!(!trials.contains("vdp") && !trials.contains("mse"), "{trials}");
    for file in ["results.json", "results.csv"] {
        std::fs::remove_file(out.join(file)).unwrap();
    }
    assert!(study(folder.path(), true) == whole, "every figure is the same");
    assert_eq!(std::fs::read_to_string(out.join(TRIALS)).unwrap(), trials, "nothing is rendered");
    let csv = std::fs::read_to_string(out.join("results.csv")).unwrap();
    assert!(csv.contains(",vdp-localized-mean,vdp-localized-visible,"), "{csv}");
}

/// Results without a figure are refused by its name: 0 would say that no difference is seen.
#[test]
fn results_without_a_figure_are_refused_by_its_name() {
    let folder = tempfile::tempdir().unwrap();
    study(folder.path(), false);
    let text = std::fs::read_to_string(folder.path().join("out/results.json")).unwrap();
    let mut json: Value = serde_json::from_str(&text).unwrap();
    let own = json["targets"][0]["own"].as_object_mut().unwrap();
    assert!(own.remove("vdp_localized_mean_percent").is_some_and(|v| v.is_number()));
    let message = serde_json::from_value::<Results>(json).unwrap_err().to_string();
    assert!(message.contains("vdp_localized_mean_percent"), "{message}");
}
