//! What directed rendering saves.

use serde::{Deserialize, Serialize};

use super::markdown::{decimals, figure, table};
use super::ratio::Ratio;

/// What was found of one scene.
#[derive(Debug, Serialize, Deserialize)]
pub struct Row {
    /// The scene's title.
    pub scene: String,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Rays of a pixel of the gold standard.
    pub rays: u32,
    /// Photon paths of the gold standard.
    pub photons: u64,
    /// Trimmed relative squared error of the mean of both halves of the truth.
    pub truth_error: f64,
    /// Processor seconds of the photons and their map, of the gold standard.
    pub photon_seconds: f64,
    /// Those of its rays.
    pub ray_seconds: f64,
    /// Mean of the squared deviation of pixels over the square of their mean: by as much rays fewer give the same error,
    /// where they are shot in proportion to it.
    pub allocation_gain: f64,
    /// What a picture takes on one thread.
    pub one_thread: OneThread,
    /// The gold standard, `xs`, and others.
    pub ways: Vec<Way>,
}

/// Seconds of pictures on one thread.
#[derive(Debug, Serialize, Deserialize)]
pub struct OneThread {
    /// Of the gold standard.
    pub gold: f64,
    /// Of each stage of `xs`, by name.
    pub stages: Vec<(String, f64)>,
}

/// Pictures of one way of rendering.
#[derive(Debug, Serialize, Deserialize)]
pub struct Way {
    /// Its name.
    pub name: String,
    /// Mean of the processor seconds of all threads.
    pub seconds: f64,
    /// Mean of the trimmed relative squared errors.
    pub error: f64,
    /// The same of all pixels.
    pub untrimmed: f64,
    /// The trimmed one, in which pixels count by the saliency of the truth.
    pub salient_error: f64,
    /// HDR-FLIP.
    pub flip: f64,
    /// Pixels in % that visibly differ from the truth.
    pub vdp_percent: f64,
    /// Seconds of the gold standard over its own.
    pub gain: Ratio,
    /// Its error over that of the gold standard.
    pub error_of_gold: Ratio,
    /// Its error times seconds over those of `xs`.
    pub cost_of_xs: Ratio,
}

impl Row {
    fn way(&self, name: &str) -> Option<&Way> {
        self.ways.iter().find(|way| way.name == name)
    }

    fn directed(&self) -> Option<&Way> {
        self.way("`xs`")
    }

    fn by_scattering(&self) -> Option<&Way> {
        self.way("`xs` by scattering")
    }

    /// The rival with the least error times seconds.
    fn best_rival(&self) -> Option<&Way> {
        let is_own = |way: &&Way| way.name == "gold" || way.name.starts_with("`xs`");
        let rivals = self.ways.iter().filter(|way| !is_own(way));
        rivals.min_by(|a, b| a.cost_of_xs.ratio.total_cmp(&b.cost_of_xs.ratio))
    }
}

/// Gains, bounds and all figures.
pub fn tables(rows: &[Row]) -> String {
    let gain = |row: &Row, xs: Option<&Way>| {
        let (gold, xs, rival) = (row.way("gold")?, xs?, row.best_rival()?);
        Some(vec![
            row.scene.clone(),
            figure(gold.seconds, 3),
            figure(xs.seconds, 3),
            xs.gain.cell(2),
            xs.error_of_gold.cell(2),
            decimals(xs.flip / gold.flip, 2),
            format!("{} / {}", decimals(xs.vdp_percent, 1), decimals(gold.vdp_percent, 1)),
            rival.name.clone(),
            decimals(rival.cost_of_xs.ratio / xs.cost_of_xs.ratio, 2),
        ])
    };
    let gains_table = |xs: fn(&Row) -> Option<&Way>| {
        table(
            &[
                "scene",
                "gold, CPU s",
                "`xs`, CPU s",
                "gain",
                "error over gold's",
                "FLIP over gold's",
                "visible, %: `xs` / gold",
                "best rival",
                "its cost over that of `xs`",
            ],
            rows.iter().filter_map(|row| gain(row, xs(row))),
        )
    };
    let [gains, by_scattering] = [gains_table(Row::directed), gains_table(Row::by_scattering)];
    let bounds = rows.iter().filter_map(|row| {
        let one = row.way("one ray")?;
        Some(vec![
            row.scene.clone(),
            figure(row.photon_seconds, 3),
            figure(row.ray_seconds, 3),
            one.gain.cell(2),
            decimals(row.allocation_gain, 2),
        ])
    });
    let bounds = table(
        &["scene", "photons, CPU s", "rays, CPU s", "gain of one ray everywhere", "allocation"],
        bounds,
    );
    let stages = stages_table(rows);
    let ablation = ablation_table(rows);
    let all = rows.iter().flat_map(|row| {
        row.ways.iter().map(|way| {
            vec![
                row.scene.clone(),
                way.name.clone(),
                figure(way.seconds, 3),
                figure(way.error, 2),
                figure(way.untrimmed, 2),
                decimals(way.flip, 4),
                decimals(way.vdp_percent, 1),
                decimals(way.gain.ratio, 2),
                way.cost_of_xs.cell(2),
            ]
        })
    });
    let all = table(
        &[
            "scene",
            "way",
            "CPU s",
            "error",
            "of all pixels",
            "FLIP",
            "visible, %",
            "gain",
            "cost over `xs`",
        ],
        all,
    );
    let rays = rows.first().map_or(0, |row| row.rays);
    let side = rows.first().map_or(0, |row| row.size[0].max(row.size[1]));
    format!(
        "Gold has {rays} rays in every pixel; `xs` the same, as the most. Pictures have {side} pixels along the longer side, and a \
         seventh of the scene's photons, as pictures of 512 pixels have seven times as many pixels. Gain is the processor \
         seconds of gold over those of the way, cost is error times seconds, errors are relative squared ones without the worst \
         0.2 % of the pixels, against two halves of a truth at once: the mean of many pictures of gold. Intervals are of 95 %, of a \
         bootstrap over seeds.\n\n\
         `xs` measures error: rays go where the first ones leave it after reconstruction, and photons are as many as the pilot of \
         strategies asks for: a sixteenth of gold's, up to four times as many.\n\n\
         {gains}\n\
         ## By scattering\n\
         `--x scattering`: rays go where scattered light is uncertain and where something is salient. Nothing is reconstructed.\n\n\
         {by_scattering}\n\
         ## What bounds it\n\
         One ray in every pixel, with all photons, is the least that a map of rays can ask for. Allocation is the gain of rays in \
         proportion to the noise of each pixel, at the error of gold.\n\n\
         {bounds}\n\
         Seconds of gold and of the stages of `xs` on one thread. The last column names the longest stage, and the gain if all \
         others took nothing.\n\n\
         {stages}\n\
         ## What each part brings\n\
         Cost of `xs` with a part of it changed, over that of `xs`. Salient error weighs pixels by the saliency of the truth; it and \
         the seconds are those without saliency over those of `xs`. With as many photons as gold, the strategy is given too, so \
         that no pilot of strategies runs, and all pixels have four rays first.\n\n\
         {ablation}\n\
         ## All ways\n{all}"
    )
}

/// Seconds of the stages of `xs`, scene by scene.
fn stages_table(rows: &[Row]) -> String {
    const STAGES: [&str; 6] = ["strategy", "photons", "pilot", "director", "march", "reconstruct"];
    let cells = rows.iter().filter_map(|row| {
        let OneThread { gold, stages } = &row.one_thread;
        let of = |name: &str| stages.iter().filter(|(own, _)| own == name).map(|(_, s)| s).sum();
        let seconds: [f64; STAGES.len()] = STAGES.map(of);
        let (longest, most) = STAGES.iter().zip(seconds).max_by(|(_, a), (_, b)| a.total_cmp(b))?;
        let mut cells = vec![row.scene.clone(), figure(*gold, 3)];
        cells.extend(seconds.map(|seconds| figure(seconds, 2)));
        cells.push(format!("{longest}: {}", decimals(gold / most, 1)));
        Some(cells)
    });
    let mut head = vec!["scene", "gold"];
    head.extend(STAGES);
    head.push("longest stage, and gain by it alone");
    table(&head, cells)
}

/// What `xs` costs with a part of it changed, scene by scene.
fn ablation_table(rows: &[Row]) -> String {
    let cells = rows.iter().filter_map(|row| {
        let cost = |name: &str| row.way(name).map(|way| way.cost_of_xs.ratio);
        let (xs, plain) = (row.directed()?, row.way("`xs` without saliency")?);
        Some(vec![
            row.scene.clone(),
            decimals(plain.cost_of_xs.ratio, 2),
            decimals(plain.salient_error / xs.salient_error, 2),
            decimals(plain.seconds / xs.seconds, 2),
            decimals(cost("`xs`, photons as gold's"), 2),
            decimals(cost("`xs`, radius and step too"), 2),
            decimals(cost("`xs` by scattering"), 2),
        ])
    });
    table(
        &[
            "scene",
            "without saliency",
            "salient error without saliency",
            "seconds without saliency",
            "photons as gold's",
            "radius and step too",
            "by scattering, raw",
        ],
        cells,
    )
}

/// What `xs` gains, scene by scene, and over the four scenes after the paper's, with the error beside gold's.
pub fn quoted(rows: &[Row]) -> Vec<(String, String)> {
    let mut out = Vec::new();
    for row in rows {
        if let Some(xs) = row.directed() {
            let key = format!("director.{}.gain", key(&row.scene));
            out.push((key, decimals(xs.gain.ratio, 1)));
        }
    }
    let papers = ["Balls A", "Balls B", "Lucy", "Road"];
    let mut quote = |name: &str, way: fn(&Row) -> Option<&Way>, figure: fn(&Way) -> f64| {
        let of_papers = rows.iter().filter(|row| papers.contains(&row.scene.as_str()));
        let mut values: Vec<f64> = of_papers.filter_map(way).map(figure).collect();
        values.sort_unstable_by(f64::total_cmp);
        if let [least, .., most] = values[..] {
            out.push((format!("director.paper_scenes.{name}.least"), decimals(least, 1)));
            out.push((format!("director.paper_scenes.{name}.most"), decimals(most, 1)));
        }
    };
    quote("gain", Row::directed, |way| way.gain.ratio);
    quote("error", Row::directed, |way| way.error_of_gold.ratio);
    out
}

/// The scene's title as part of a key: what stands before a dot or comma, in small letters.
fn key(scene: &str) -> String {
    let name = scene.split(['.', ',']).next().unwrap_or_default();
    name.to_lowercase().replace([' ', '-'], "_")
}
