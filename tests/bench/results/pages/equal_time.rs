//! Error against run time, director by director.

use serde::{Deserialize, Serialize};

use super::markdown::{self, NONE, decimals, range, table};

/// What a study found.
#[derive(Debug, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Row {
    /// A candidate at one budget.
    Point {
        /// The scene's title.
        scene: String,
        /// Its name among the study's candidates, or `gold`.
        candidate: String,
        /// The most rays of a pixel.
        rays: u32,
        /// Run time.
        seconds: f64,
        /// The error against the gold standard.
        error: f64,
        /// Which error.
        metric: String,
    },
    /// What a part of the director brings.
    Part {
        /// The scene's title.
        scene: String,
        /// The part.
        part: String,
        /// The candidate with it.
        with: String,
        /// The one without.
        without: String,
        /// Error without over error with, at equal time.
        gain: f64,
        /// Its interval at 95 %.
        range: Option<[f64; 2]>,
    },
}

/// Columns: candidates with their rays.
const COLUMNS: [(&str, u32, &str); 7] = [
    ("gold", 16, "gold, 16 rays"),
    ("fixed", 8, "uniform, 8"),
    ("fixed", 4, "uniform, 4"),
    ("x-scattering", 16, "`x`"),
    ("x-transmittance", 16, "`x`, transmittance"),
    ("xs-scattering", 16, "`xs`"),
    ("xs-paper", 16, "as in the paper"),
];

/// Both tables.
pub fn tables(rows: &[Row]) -> String {
    let mut scenes: Vec<(&str, &str)> = Vec::new();
    for row in rows {
        if let Row::Point { scene, metric, .. } = row
            && !scenes.iter().any(|known| known.0 == scene)
        {
            scenes.push((scene, metric));
        }
    }
    let head: Vec<&str> =
        ["scene", "error"].into_iter().chain(COLUMNS.map(|column| column.2)).collect();
    let lines = scenes.iter().map(|&(scene, metric)| {
        let cells = COLUMNS.map(|(candidate, rays, _)| cell(rows, scene, candidate, rays));
        [scene.to_owned(), metric.to_owned()].into_iter().chain(cells).collect()
    });
    let points = table(&head, lines);
    let parts = rows.iter().filter_map(|row| match row {
        Row::Part { scene, part, without, gain, range: interval, .. } => {
            let outcome = match interval {
                Some([low, _]) if *low > 1.0 => "wins",
                Some([_, high]) if *high < 1.0 => "loses",
                _ => "open",
            };
            Some(vec![
                scene.clone(),
                part.clone(),
                format!("`{without}`"),
                decimals(*gain, 2),
                range(*interval, 2),
                outcome.into(),
            ])
        }
        Row::Point { .. } => None,
    });
    let parts = table(&["scene", "part", "against", "gain in error", "95 %", ""], parts);
    format!(
        "Seconds and error against the gold standard, whose own noise is its column's. Directed ways \
         have up to 16 rays.\n\n{points}\n## What each part of the director brings\n\
         Error without the part over error with it, at equal time: above 1 it wins, where the whole \
         interval is above 1. Every other gain is open.\n\n{parts}"
    )
}

fn cell(rows: &[Row], in_scene: &str, of: &str, with: u32) -> String {
    rows.iter()
        .find_map(|row| match row {
            Row::Point { scene, candidate, rays, seconds, error, .. }
                if scene == in_scene && candidate == of && *rays == with =>
            {
                Some(format!("{} s, {}", decimals(*seconds, 2), markdown::error(*error)))
            }
            _ => None,
        })
        .unwrap_or_else(|| NONE.into())
}
