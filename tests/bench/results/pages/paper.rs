//! fogbow's figures for its four scenes after Anson et al. 2006.

use serde::{Deserialize, Serialize};

use super::markdown::{NONE, figure, table};

/// A scene rendered in one way: means over seeds, against the gold standard.
#[derive(Debug, Serialize, Deserialize)]
pub struct Row {
    /// The scene's title.
    pub scene: String,
    /// `gold`, `xs-paper` or `xs-scattering`.
    pub way: String,
    /// Run time.
    pub seconds: f64,
    /// Gold's run time over it.
    pub speed_up: Option<SpeedUp>,
    /// Average squared error of 8-bit sRGB codes in % of the largest.
    pub code_mse_percent: Option<f64>,
    /// Pixels in which a code differs, in %.
    pub code_pixels_percent: Option<f64>,
    /// Average chance of seeing a difference, in %, by Daly's model.
    pub vdp_mean_percent: Option<f64>,
    /// Pixels in which it is above 75 %, in %.
    pub vdp_visible_percent: Option<f64>,
    /// The average where only pixels that differ count.
    #[serde(default)]
    pub vdp_localized_mean_percent: Option<f64>,
    /// Pixels above 75 % where only pixels that differ count, in %.
    #[serde(default)]
    pub vdp_localized_visible_percent: Option<f64>,
}

/// A ratio of run times with its interval at 95 %.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct SpeedUp {
    /// The geometric mean over seeds.
    pub estimate: f64,
    /// The interval.
    pub range: Option<[f64; 2]>,
}

impl SpeedUp {
    /// Both in words.
    pub fn told(&self) -> String {
        let range = self.range.map_or_else(String::new, |[low, high]| {
            format!(" ({} to {})", figure(low, 3), figure(high, 3))
        });
        figure(self.estimate, 3) + &range
    }
}

/// The table.
pub fn tables(rows: &[Row]) -> String {
    let lines = rows.iter().map(|row| {
        let errors = [
            row.code_mse_percent,
            row.code_pixels_percent,
            row.vdp_mean_percent,
            row.vdp_visible_percent,
            row.vdp_localized_mean_percent,
            row.vdp_localized_visible_percent,
        ];
        [
            row.scene.clone(),
            format!("`{}`", row.way),
            figure(row.seconds, 3),
            row.speed_up.map_or_else(|| NONE.into(), |speed_up| speed_up.told()),
        ]
        .into_iter()
        .chain(errors.map(|error| figure(error, 3)))
        .collect()
    });
    format!(
        "Means over seeds, intervals at 95 %; errors against the gold standard, which has 16 rays in \
         every pixel. [volumes/PAPER.md](../../../volumes/PAPER.md) has them beside the paper's.\n\n{}",
        table(
            &[
                "scene",
                "way",
                "s",
                "times faster",
                "MSE of 8-bit codes, %",
                "pixels in error, %",
                "VDP, %",
                "P > 75 %",
                "VDP localised, %",
                "P > 75 %"
            ],
            lines
        )
    )
}
