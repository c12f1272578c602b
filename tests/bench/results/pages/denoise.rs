//! Error with and without Open Image Denoise.

use serde::{Deserialize, Serialize};

use super::markdown::{NONE, error, table};

/// A scene rendered in one way.
#[derive(Debug, Serialize, Deserialize)]
pub struct Row {
    /// The scene's title.
    pub scene: String,
    /// How it was rendered: see [`WAYS`].
    pub way: String,
    /// Relative MSE without the worst 0.1 % of the pixels.
    pub relative_mse_trimmed: f64,
    /// Mean HDR-FLIP.
    pub flip_hdr: f64,
}

/// Ways with the heads of their columns.
const WAYS: [(&str, &str); 5] = [
    ("xs", "`xs`"),
    ("xs-denoised", "denoised"),
    ("few-photons-denoised", "few photons, denoised"),
    ("traced", "traced"),
    ("traced-denoised", "denoised"),
];

/// The table.
pub fn tables(rows: &[Row]) -> String {
    let mut scenes: Vec<&str> = Vec::new();
    for row in rows {
        if !scenes.contains(&row.scene.as_str()) {
            scenes.push(&row.scene);
        }
    }
    let head: Vec<&str> = ["scene"].into_iter().chain(WAYS.map(|way| way.1)).collect();
    let lines = scenes.iter().map(|scene| {
        let cells = WAYS.map(|(way, _)| {
            let found = rows.iter().find(|row| row.scene == *scene && row.way == way);
            found.map_or_else(
                || NONE.into(),
                |row| format!("{}, {}", error(row.relative_mse_trimmed), error(row.flip_hdr)),
            )
        });
        [(*scene).to_owned()].into_iter().chain(cells).collect()
    });
    format!(
        "Trimmed relative MSE and FLIP (HDR) by `fogbow error`, 192 pixels on the longer side, each \
         without the denoiser and with it: `--photons 200000 --rays 8 --director xs`; \
         `--photons 20000 --rays 8`, denoised; `--reference --rays 8`. All against 2 million photons \
         and 64 rays of another seed (cloud: 500 000 and 512).\n\n{}",
        table(&head, lines)
    )
}
