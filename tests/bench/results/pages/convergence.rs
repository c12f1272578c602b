//! How the error falls with time, and the bias that is left.

use serde::{Deserialize, Serialize};

use super::markdown::{NONE, decimals, figure, table, whole};

/// What was found of one scene.
#[derive(Debug, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Row {
    /// The references of a scene.
    Reference {
        /// A scene of `volumes/`.
        scene: String,
        /// Rays of a pixel of each of the two.
        rays: u32,
        /// Relative squared error of one of them.
        noise: Option<f64>,
        /// Standard error of both together, in %, of all pixels and of the brightest tenth.
        off_percent: [f64; 2],
    },
    /// Photons and rays of a step.
    Step {
        /// A scene of `volumes/`.
        scene: String,
        /// Photons.
        photons: Option<u64>,
        /// Rays of a pixel.
        rays: u32,
        /// Processor seconds of all threads.
        seconds: Option<f64>,
        /// Relative squared error.
        error: Option<f64>,
        /// The same without the worst 0.1 % of the pixels.
        trimmed: Option<f64>,
        /// Relative squared bias.
        bias: Option<f64>,
        /// How much brighter the picture is than the references, in %.
        brighter_percent: Option<f64>,
        /// The same of the brightest tenth of the pixels.
        brightest_percent: Option<f64>,
    },
}

/// Both tables.
pub fn tables(rows: &[Row]) -> String {
    let steps = rows.iter().filter_map(|row| match row {
        Row::Step {
            scene,
            photons,
            rays,
            seconds,
            error,
            trimmed,
            bias,
            brighter_percent,
            brightest_percent,
        } => Some(vec![
            scene.clone(),
            photons.map_or_else(|| NONE.into(), |photons| whole(photons as f64)),
            rays.to_string(),
            figure(*seconds, 3),
            figure(*error, 2),
            figure(*trimmed, 2),
            figure(*bias, 1),
            decimals(*brighter_percent, 2),
            decimals(*brightest_percent, 2),
        ]),
        Row::Reference { .. } => None,
    });
    let steps = table(
        &[
            "scene",
            "photons",
            "rays",
            "CPU s",
            "error",
            "trimmed",
            "squared bias",
            "brighter, %",
            "the brightest tenth, %",
        ],
        steps,
    );
    let references = rows.iter().filter_map(|row| match row {
        Row::Reference { scene, rays, noise, off_percent: [all, brightest] } => Some(vec![
            scene.clone(),
            rays.to_string(),
            figure(*noise, 2),
            figure(*all, 1),
            figure(*brightest, 1),
        ]),
        Row::Step { .. } => None,
    });
    let references = table(
        &["scene", "rays", "error of one", "both are off by, %", "in the brightest tenth, %"],
        references,
    );
    format!(
        "Photons and rays of a pixel grow by factors of 4; 96 x 96 pixels, means over four seeds. \
         Errors are relative squared errors against two references of different seeds at once, so \
         that the references' own noise falls out.\n\n{steps}\n## References\n{references}"
    )
}
