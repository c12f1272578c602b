//! Stated against true errors.

use fogbow::study::Interval;
use serde::{Deserialize, Serialize};

use super::markdown::{decimals, figure, interval, table, whole};

/// Largest factor between stated and true errors that passes.
const WITHIN: f64 = 1.3;

/// Largest factor between what is foretold and what is taken that passes.
const FORETOLD_WITHIN: f64 = 1.5;

/// What was found of one scene.
#[derive(Debug, Serialize, Deserialize)]
pub struct Row {
    /// The scene in words.
    pub scene: String,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// The error that was asked for.
    pub goal: f64,
    /// Pictures, each with a seed of its own.
    pub seeds: u64,
    /// Those that ended without a known error, or with less than half of the truth's light.
    pub black: usize,
    /// Error that they state: the root of the mean square.
    pub stated: f64,
    /// Mean relative standard error that they state with it.
    pub uncertainty: f64,
    /// True error: the root of the mean square.
    pub found: Option<Interval>,
    /// Stated over true error.
    pub ratio: Option<Interval>,
    /// How much brighter the pictures are than references, in %, and its standard error.
    pub brighter_percent: [f64; 2],
    /// Root of the mean squared relative bias of blocks of 16 x 16 pixels against references, in %.
    pub bias_percent: f64,
    /// Mean rays of a pixel.
    pub rays: f64,
    /// Mean photon paths.
    pub photons: f64,
    /// Mean processor seconds of a picture.
    pub seconds: f64,
    /// What the plan says over that.
    pub foretold: Foretold,
}

/// What the plan says of a render over what the render took.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Foretold {
    /// Seconds, of the same seed.
    pub seconds: Option<Interval>,
    /// The peak of memory.
    pub memory: f64,
}

/// All tables.
pub fn tables(rows: &[Row]) -> String {
    let seeds = rows.first().map_or(0, |row| row.seeds);
    let errors = rows.iter().map(|row| {
        vec![
            row.scene.clone(),
            figure(row.goal, 2),
            figure(row.stated, 2),
            interval(row.found.as_ref(), 4),
            interval(row.ratio.as_ref(), 2),
            figure(row.rays, 2),
            whole(row.photons),
            figure(row.seconds, 2),
        ]
    });
    let errors = table(
        &["scene", "goal", "stated", "true", "stated over true", "rays", "photons", "CPU s"],
        errors,
    );
    let beside = rows.iter().map(|row| {
        let [brighter, sure] = row.brighter_percent;
        vec![
            row.scene.clone(),
            format!("{brighter:+.2} ± {sure:.2}"),
            decimals(row.bias_percent, 2),
            interval(row.foretold.seconds.as_ref(), 2),
            decimals(row.foretold.memory, 2),
        ]
    });
    let beside = table(
        &["scene", "brighter, %", "bias of blocks, %", "seconds foretold", "memory foretold"],
        beside,
    );
    format!(
        "Pictures of {seeds} seeds a scene, rendered to a goal by `--error`. Stated and true are roots of mean squares over the \
         seeds, of the same measure: the worst hundredth of blocks of 8 x 8 pixels, relative to the mean radiance of each and \
         half of that of the picture. The true square is the product of the differences from two pictures with half of the \
         error. Intervals are of 95 %.\n\n{errors}\n{}\n\n\
         ## Light that is missed, and what was foretold\n\
         Brightness and bias are against two traced references: the whole picture with its standard error, and blocks of \
         16 x 16 pixels, the root of the mean squared bias. Foretold by `fogbow plan --error`, over what the render \
         with the same seed took.\n\n{beside}\n{}\n",
        summary(rows),
        foretold_summary(rows)
    )
}

/// Whether `ratio` is at most the factor `within` off, both ways.
fn is_within(ratio: f64, within: f64) -> bool {
    (1.0 / within..=within).contains(&ratio)
}

/// How many are told as they are.
fn summary(rows: &[Row]) -> String {
    let ratios = || rows.iter().filter_map(|row| row.ratio.as_ref());
    let near = ratios().filter(|ratio| is_within(ratio.estimate, WITHIN)).count();
    let ends = |ratio: &&Interval| {
        ratio.range.is_some_and(|[low, high]| high >= 1.0 / WITHIN && low <= WITHIN)
    };
    let may = ratios().filter(ends).count();
    let black: usize = rows.iter().map(|row| row.black).sum();
    format!(
        "{near} of {} scenes state their error within a factor of {WITHIN}, and {may} have an interval that reaches into it. \
         {black} pictures ended on black.",
        rows.len()
    )
}

/// How many cost what was foretold.
fn foretold_summary(rows: &[Row]) -> String {
    let near = |value: fn(&Foretold) -> Option<f64>| {
        let ratios = rows.iter().filter_map(|row| value(&row.foretold));
        ratios.filter(|ratio| is_within(*ratio, FORETOLD_WITHIN)).count()
    };
    let seconds = near(|of| of.seconds.as_ref().map(|ratio| ratio.estimate));
    let memory = near(|of| Some(of.memory));
    format!(
        "Within a factor of {FORETOLD_WITHIN} are the seconds of {seconds} and the memory of {memory} of {} scenes.",
        rows.len()
    )
}
