//! `fogbow error` from outside.

use std::path::Path;

use exr::prelude::write_rgb_file;
use serde_json::Value;

fn run(folder: &Path, args: &[&str]) -> (i32, String, String) {
    crate::run(folder, &[&["error"], args].concat())
}

/// A folder with a.exr, a grey ramp of 32 x 24 pixels, and b.exr, a tenth brighter; small.exr has
/// another size, nan.exr a NaN.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, width: usize, of: fn(usize, usize) -> f32| {
        let path = folder.path().join(name);
        write_rgb_file(path, width, 24, |x, y| [of(x, y); 3].into()).unwrap();
    };
    write("a.exr", 32, |x, _| (x + 1) as f32 / 64.0);
    write("b.exr", 32, |x, _| 1.1 * (x + 1) as f32 / 64.0);
    write("small.exr", 31, |x, _| x as f32);
    write("nan.exr", 32, |x, y| if (x, y) == (3, 4) { f32::NAN } else { 0.5 });
    folder
}

#[test]
fn the_table_names_every_metric_with_its_figure() {
    let folder = folder();
    let (code, table, message) = run(folder.path(), &["a.exr", "b.exr"]);
    assert_eq!((code, message.as_str()), (0, ""));
    let figure = |name: &str| {
        let line = table.lines().find(|line| line.trim_start().starts_with(name)).unwrap();
        let words = line.trim_start()[name.len()..].split_whitespace().next().unwrap();
        words.parse::<f64>().unwrap()
    };
    assert_eq!(figure("bias, mean ratio"), 1.1);
    assert!((figure("bias, mean difference") - 0.1 * 33.0 / 128.0).abs() < 1e-6);
    for name in [
        "MSE",
        "RMSE",
        "MAE",
        "relative MSE",
        "without the worst",
        "epsilon",
        "HDR-FLIP",
        "MSE of 8-bit codes",
        "pixels in error",
        "VDP, average",
        "VDP, pixels P > 0.75",
        "VDP localised, average",
        "VDP localised, P > 0.75",
        "SSIM",
        "LDR-FLIP",
        "ColorVideoVDP",
    ] {
        assert!(table.contains(name), "{name} is missing:\n{table}");
    }
}

#[test]
fn json_holds_figures_and_settings() {
    let folder = folder();
    let args = ["a.exr", "b.exr", "--json", "--distance", "1.2", "--epsilon", "0.25"];
    let (code, json, message) = run(folder.path(), &args);
    assert_eq!((code, message.as_str()), (0, ""));
    let report: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(report["reference"], "a.exr");
    assert_eq!(report["size"], serde_json::json!([32, 24]));
    assert_eq!(report["errors"]["epsilon"], 0.25);
    assert_eq!(report["settings"]["display"]["distance"], 1.2);
    assert!(report["errors"]["colorvideovdp_jod"].is_number());
}

#[test]
fn a_picture_compared_with_itself_has_no_error() {
    let folder = folder();
    let (_, json, _) = run(folder.path(), &["a.exr", "a.exr", "--json"]);
    let report: Value = serde_json::from_str(&json).unwrap();
    for key in [
        "mse",
        "relative_mse",
        "code_pixels_percent",
        "vdp_mean_percent",
        "vdp_localized_mean_percent",
        "vdp_localized_visible_percent",
        "flip_hdr",
    ] {
        assert_eq!(report["errors"][key].as_f64(), Some(0.0), "{key}");
    }
}

#[test]
fn pictures_that_cannot_be_compared_end_in_one_line() {
    let folder = folder();
    for (args, code, says) in [
        (
            ["a.exr", "small.exr"].as_slice(),
            1,
            "small.exr: has 31 x 24 pixels and a.exr has 32 x 24",
        ),
        (&["a.exr", "nan.exr"], 1, "nan.exr: pixel 3, 4 is [NaN, NaN, NaN]; every value must be"),
        (&["nan.exr", "a.exr"], 1, "nan.exr: pixel 3, 4"),
        (&["a.exr", "none.exr"], 1, "none.exr: cannot be read"),
        (&["a.exr", "b.exr", "--distance", "0"], 2, "seen from 0 m"),
        (&["a.exr", "b.exr", "--cvvdp-display", "tv"], 2, "no display \"tv\"; use one of"),
    ] {
        let (found, out, message) = run(folder.path(), args);
        assert_eq!((found, out.as_str()), (code, ""), "{args:?}: {message}");
        assert_eq!(message.lines().count(), 1, "{message}");
        assert!(message.contains(says), "{args:?}: {message}");
    }
    assert_eq!(run(folder.path(), &["a.exr"]).0, 2);
}
