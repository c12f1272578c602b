//! This build beside an earlier one.

use serde::{Deserialize, Serialize};

use super::markdown::{decimals, figure, table};
use super::ratio::Ratio;

/// What was found of one scene.
#[derive(Debug, Serialize, Deserialize)]
pub struct Row {
    /// The scene in words.
    pub scene: String,
    /// The earlier build.
    pub earlier: Side,
    /// This one.
    pub now: Side,
    /// Trimmed relative squared difference of the means of both.
    pub difference: f64,
    /// Processor seconds of this build over those of the earlier one.
    pub seconds: Ratio,
    /// The same of noise.
    pub noise: Ratio,
    /// The same of seconds times noise, to which the difference is added for this build: the seconds to the same error.
    pub cost: Ratio,
    /// The same of the light of pictures.
    pub light: Ratio,
}

/// Pictures of one build.
#[derive(Debug, Serialize, Deserialize)]
pub struct Side {
    /// Mean of the trimmed relative variances.
    pub noise: f64,
    /// Mean of the processor seconds.
    pub seconds: f64,
    /// Median of the peaks of memory, in MiB.
    pub memory: f64,
}

/// A summary, ratios and figures.
pub fn tables(rows: &[Row]) -> String {
    let ratios = rows.iter().map(|row| {
        vec![
            row.scene.clone(),
            row.cost.cell(2),
            row.noise.cell(2),
            row.seconds.cell(2),
            decimals(row.now.memory / row.earlier.memory, 2),
            row.light.cell(3),
        ]
    });
    let ratios = table(&["scene", "cost", "noise", "CPU seconds", "memory", "light"], ratios);
    let figures = rows.iter().map(|row| {
        let of = |side: &Side| {
            [figure(side.noise, 3), figure(side.seconds, 3), decimals(side.memory, 0)]
        };
        let [earlier, now] = [&row.earlier, &row.now].map(of);
        let cells = [earlier, now].concat();
        [vec![row.scene.clone()], cells, vec![figure(row.difference, 2)]].concat()
    });
    let head =
        ["scene", "noise, earlier", "CPU s", "MiB", "noise, now", "CPU s", "MiB", "of the means"];
    let figures = table(&head, figures);
    let count = |is: fn(&Ratio) -> bool| rows.iter().filter(|row| is(&row.cost)).count();
    let (lower, higher) =
        (count(|cost| cost.interval[1] < 1.0), count(|cost| cost.interval[0] > 1.0));
    let halved = count(|cost| cost.interval[1] <= 0.5);
    format!(
        "This build over an earlier one at the same settings, as programs of their own that take turns: what noise, processor \
         seconds and memory became. Noise is the relative variance between seeds, without the worst 0.2 % of the pixels. Cost \
         is the seconds to the same error: noise times seconds, where the squared difference between the means of both builds \
         counts as an error of this one. Of {} scenes it is lower on {lower}, at most half on {halved}, and higher on {higher}, \
         by intervals of 95 % of a bootstrap over seeds. Light is that of whole pictures: where its interval leaves out 1, one of \
         both builds or their errors of bias differ.\n\n\
         {ratios}\n{figures}",
        rows.len()
    )
}
