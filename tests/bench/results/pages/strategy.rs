//! The regret of the choice of strategies.

use fogbow::scene::Strategy;
use serde::{Deserialize, Serialize};

use super::markdown::{NONE, decimals, figure, range, table};

/// Largest regret that passes.
const MAX_REGRET: f64 = 1.2;

/// What was found of one scene.
#[derive(Debug, Serialize, Deserialize)]
pub struct Row {
    /// The scene in words.
    pub scene: String,
    /// Rays a pixel of each of the two references.
    pub reference_rays: u32,
    /// Trimmed relative squared error of their mean.
    pub reference_error: f64,
    /// Whether that is a tenth of the candidates' or less, and at most 0.003.
    pub is_reference_enough: bool,
    /// What is chosen, then the requests that could be followed, over all seeds.
    pub candidates: Vec<Measured>,
    /// By errors without the worst pixels.
    #[serde(flatten)]
    pub trimmed: Comparison,
    /// By errors of all pixels.
    pub of_all_pixels: Option<Comparison>,
}

/// What is chosen beside the best that can be asked for.
#[derive(Debug, Serialize, Deserialize)]
pub struct Comparison {
    /// The request with the least cost on the first half of the seeds.
    pub best: String,
    /// What is chosen and the best request, on the second half.
    pub compared: [Figures; 2],
    /// Cost of what is chosen over that of the best request, on the second half.
    pub regret: f64,
    /// Its interval of 95 %.
    pub interval: [f64; 2],
}

/// A candidate over all seeds.
#[derive(Debug, Serialize, Deserialize)]
pub struct Measured {
    /// What was asked for, by its name.
    pub request: String,
    /// The strategy that each medium had with the seed of the scene.
    pub media: Vec<Strategy>,
    /// Seeds with which the media had others.
    pub other_seeds: usize,
    /// Means over the seeds, of the trimmed error.
    pub figures: Figures,
    /// Relative squared error of all pixels.
    pub untrimmed: f64,
    /// Trimmed relative squared bias.
    pub bias: f64,
    /// How much brighter the pictures are than the references, in %.
    pub brighter_percent: f64,
}

/// Error and time of a candidate.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct Figures {
    /// Relative squared error.
    pub error: f64,
    /// Processor seconds of all threads.
    pub seconds: f64,
}

impl Figures {
    /// Error times seconds.
    pub fn cost(&self) -> f64 {
        self.error * self.seconds
    }
}

/// The regrets, a summary, and all candidates.
pub fn tables(rows: &[Row]) -> String {
    let regrets = rows.iter().map(|row| {
        let Comparison { best: request, compared: [chosen, best], regret, interval } = &row.trimmed;
        let whole = row.of_all_pixels.as_ref();
        let media = row.candidates.first().map_or(String::new(), chosen_names);
        vec![
            row.scene.clone(),
            media,
            figure(chosen.error, 3),
            figure(chosen.seconds, 3),
            request.clone(),
            figure(best.error, 3),
            figure(best.seconds, 3),
            decimals(*regret, 2),
            range(Some(*interval), 2),
            if passes(&row.trimmed) { "yes" } else { "no" }.into(),
            whole.map_or_else(|| NONE.into(), |whole| whole.best.clone()),
            decimals(whole.map(|whole| whole.regret), 2),
            range(whole.map(|whole| whole.interval), 2),
            whole.map_or(NONE, |whole| if passes(whole) { "yes" } else { "no" }).into(),
        ]
    });
    let regrets = table(
        &[
            "scene",
            "chosen, a medium",
            "error",
            "CPU s",
            "best request",
            "error",
            "CPU s",
            "regret",
            "95 %",
            "at most 1.2",
            "best, all pixels",
            "regret",
            "95 %",
            "at most 1.2",
        ],
        regrets,
    );
    let candidates = table(
        &[
            "scene",
            "candidate",
            "error",
            "of all pixels",
            "squared bias",
            "brighter, %",
            "CPU s",
            "cost over the least",
        ],
        rows.iter().flat_map(candidates),
    );
    let references = rows.iter().map(|row| {
        vec![
            row.scene.clone(),
            row.reference_rays.to_string(),
            figure(row.reference_error, 2),
            if row.is_reference_enough { "yes" } else { "no" }.into(),
        ]
    });
    let references =
        table(&["scene", "rays of each", "error of the mean", "small enough"], references);
    format!(
        "Cost is the relative squared error times CPU seconds, both means over the seeds; regret is the \
         cost of what is chosen over that of the best strategy asked for by name, on other seeds than \
         those that say which is the best. The intervals are those of a bootstrap over seeds, and leave \
         out the noise of the references. It passes where their lower end is at most {MAX_REGRET}. Errors \
         are relative to the squared radiance and half its mean, without the worst 0.2 % of \
         the pixels, against two independent references at once; the last four columns are of the errors \
         of all pixels. References are small enough in \
         error where theirs is a tenth of the smallest of the candidates' and 0.003 at most.\n\n{regrets}\n{}\n\n\
         ## All candidates\nOver all seeds.\n\n{candidates}\n## References\n{references}",
        summary(rows)
    )
}

fn passes(comparison: &Comparison) -> bool {
    comparison.interval[0] <= MAX_REGRET
}

fn summary(rows: &[Row]) -> String {
    let passed = rows.iter().filter(|row| passes(&row.trimmed)).count();
    let mean = rows.iter().map(|row| row.trimmed.regret.ln()).sum::<f64>() / rows.len() as f64;
    let worst = rows.iter().max_by(|a, b| a.trimmed.regret.total_cmp(&b.trimmed.regret));
    let worst = worst.map_or(String::new(), |row| {
        format!("; the largest is {:.2}, of {}", row.trimmed.regret, row.scene)
    });
    let whole: Vec<&Comparison> =
        rows.iter().filter_map(|row| row.of_all_pixels.as_ref()).collect();
    let of_all_pixels = if whole.is_empty() {
        String::new()
    } else {
        let passed = whole.iter().filter(|comparison| passes(comparison)).count();
        format!(" By the errors of all pixels {passed} pass.")
    };
    format!(
        "{passed} of {} scenes pass; the geometric mean of the regrets is {:.2}{worst}.{of_all_pixels}",
        rows.len(),
        mean.exp(),
    )
}

fn candidates(row: &Row) -> Vec<Vec<String>> {
    let cost = |measured: &Measured| measured.figures.cost();
    let least = row.candidates.iter().map(cost).fold(f64::INFINITY, f64::min);
    let cells = |measured: &Measured| {
        let media = names(&measured.media);
        let name = if media == measured.request {
            media
        } else {
            format!("{} ({media})", measured.request)
        };
        vec![
            row.scene.clone(),
            name,
            figure(measured.figures.error, 3),
            figure(measured.untrimmed, 3),
            figure(measured.bias, 2),
            decimals(measured.brighter_percent, 2),
            figure(measured.figures.seconds, 3),
            decimals(cost(measured) / least, 2),
        ]
    };
    row.candidates.iter().map(cells).collect()
}

/// What is chosen, and whether that depends on the seed.
fn chosen_names(chosen: &Measured) -> String {
    let names = names(&chosen.media);
    match chosen.other_seeds {
        0 => names,
        seeds => format!("{names}; others with {seeds} seeds"),
    }
}

/// The names of the media's strategies; one where all have the same.
fn names(media: &[Strategy]) -> String {
    let mut names: Vec<&str> = media.iter().map(|strategy| strategy.name()).collect();
    if names.windows(2).all(|pair| pair[0] == pair[1]) {
        names.truncate(1);
    }
    names.join(", ")
}
