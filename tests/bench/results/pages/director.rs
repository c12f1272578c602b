//! What directed rendering saves.

use serde::{Deserialize, Serialize};

use super::markdown::{decimals, figure, table};

/// A scene with and without the director.
#[derive(Debug, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Row {
    /// `--director xs` against `fixed`.
    Gain {
        /// The scene's title.
        scene: String,
        /// Run time of `fixed` over that of `xs`, the median of the pairs of runs.
        times: f64,
        /// The same of single pairs of runs.
        each: Vec<f64>,
        /// Seconds of `fixed`, run by run, without loading and writing.
        fixed_seconds: Vec<f64>,
        /// Seconds of `xs`.
        xs_seconds: Vec<f64>,
        /// Average squared error of 8-bit codes in % of the largest.
        code_mse_percent: f64,
        /// Pixels in which a code differs, in %.
        code_pixels_percent: f64,
        /// Mean LDR-FLIP.
        flip: f64,
        /// Pixels with P > 0.75 by the visible differences predictor, in %.
        vdp_visible_percent: f64,
    },
    /// The director's own time.
    Cost {
        /// The scene's title.
        scene: String,
        /// Seconds of the saliency map.
        saliency_seconds: Option<f64>,
        /// Seconds of the whole director.
        director_seconds: Option<f64>,
        /// Seconds of the `fixed` picture.
        fixed_seconds: Option<f64>,
        /// The director's share of that, in %.
        share_percent: f64,
    },
}

/// Both tables.
pub fn tables(rows: &[Row]) -> String {
    let gains = rows.iter().filter_map(|row| match row {
        Row::Gain {
            scene,
            times,
            each,
            code_mse_percent,
            code_pixels_percent,
            flip,
            vdp_visible_percent,
            ..
        } => Some(vec![
            scene.clone(),
            decimals(*times, 1),
            each.iter().map(|v| format!("{v:.1}")).collect::<Vec<_>>().join(", "),
            decimals(*code_mse_percent, 3),
            decimals(*code_pixels_percent, 0),
            decimals(*flip, 3),
            decimals(*vdp_visible_percent, 0),
        ]),
        Row::Cost { .. } => None,
    });
    let gains = table(
        &[
            "scene",
            "times faster",
            "pairs of runs",
            "MSE of 8-bit codes, %",
            "pixels in error, %",
            "FLIP",
            "pixels with a visible difference, %",
        ],
        gains,
    );
    let costs = rows.iter().filter_map(|row| match row {
        Row::Cost { scene, saliency_seconds, director_seconds, fixed_seconds, share_percent } => {
            Some(vec![
                scene.clone(),
                figure(*saliency_seconds, 2),
                figure(*director_seconds, 2),
                figure(*fixed_seconds, 3),
                decimals(*share_percent, 1),
            ])
        }
        Row::Gain { .. } => None,
    });
    let costs = table(
        &["scene", "saliency, s", "director, s", "`fixed`, s", "director of `fixed`, %"],
        costs,
    );
    format!(
        "Run time of `--director fixed` over that of `--director xs` with 16 rays, and the error of \
         `xs` against `fixed` by `fogbow error`.\n\n\
         {gains}\n## What the director takes\n{costs}"
    )
}

/// Times faster, scene by scene, and over the four scenes after the paper's.
pub fn quoted(rows: &[Row]) -> Vec<(String, String)> {
    let gains: Vec<(&str, f64)> = rows
        .iter()
        .filter_map(|row| match row {
            Row::Gain { scene, times, .. } => Some((scene.as_str(), *times)),
            Row::Cost { .. } => None,
        })
        .collect();
    let mut out: Vec<_> = gains
        .iter()
        .map(|(scene, times)| (format!("director.{}.gain", key(scene)), format!("{times:.1}")))
        .collect();
    let papers = ["Balls A", "Balls B", "Lucy", "Road"];
    let of_papers = || gains.iter().filter(|(scene, _)| papers.contains(scene)).map(|gain| gain.1);
    if let (Some(least), Some(most)) =
        (of_papers().min_by(f64::total_cmp), of_papers().max_by(f64::total_cmp))
    {
        out.push(("director.paper_scenes.least".into(), format!("{least:.1}")));
        out.push(("director.paper_scenes.most".into(), format!("{most:.1}")));
    }
    out
}

/// The scene's title as part of a key: what stands before a dot or comma, in small letters.
fn key(scene: &str) -> String {
    let name = scene.split(['.', ',']).next().unwrap_or_default();
    name.to_lowercase().replace([' ', '-'], "_")
}
