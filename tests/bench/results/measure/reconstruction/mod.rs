//! Pictures of few rays and photons against the truth: as they are, reconstructed, and denoised.
//!
//! The truth is the mean of pictures of the gold standard with different seeds, in two halves; it is kept
//! by the hash of the scene in the folder `gold-truth`, from run to run. What its photon maps are biased
//! by is told by its own page, [`convergence`](super::convergence).

mod gold;
mod scenes;

use std::path::PathBuf;
use std::slice;

use fogbow::image::Denoiser;
use fogbow::render::{Rendered, Silent, exposure, render};
use fogbow::scene::{RenderSettings, Scene};
use fogbow::study::metric::{Options, compare};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::halves::{Halves, Pixels, mean, narrow, trimmed_mean, wide};
use super::spent::Spent;
use super::stages::timed;
use super::{Kept, LeftOut};
use crate::pages::Result;
use crate::pages::reconstruction::{Bias, Floor, Gold, Row, Way};
pub use gold::GoldTruth;
use scenes::{NoiseScene, scenes};

/// Side of the blocks whose bias is told, in pixels.
const BLOCK: usize = 8;

/// How near to an edge pixels are that count as near it, in pixels.
const NEAR_EDGES: usize = 3;

/// Extent of a run.
pub struct Extent {
    /// Pixels along the longer side.
    side: u32,
    /// Rays a pixel of each picture of the truth.
    gold_rays: u32,
    /// Pictures of each half of the truth.
    gold_pairs: u64,
    /// Rays a pixel of the pictures that are measured.
    rays: u32,
    /// What the scene's photons are divided by in those.
    photons_part: u64,
    /// Seeds of each way.
    seeds: u64,
    /// Seeds of reconstructed pictures, for their bias.
    bias_seeds: u64,
    /// Pictures that are compared by FLIP and VDP.
    seen_seeds: usize,
    /// Every how many-th scene is taken.
    stride: usize,
}

const WHOLE: Extent = Extent {
    side: 192,
    gold_rays: 16,
    gold_pairs: 6,
    rays: 4,
    photons_part: 5,
    seeds: 8,
    bias_seeds: 32,
    seen_seeds: 2,
    stride: 1,
};
const QUICK: Extent = Extent {
    side: 40,
    gold_rays: 4,
    gold_pairs: 1,
    rays: 2,
    photons_part: 50,
    seeds: 2,
    bias_seeds: 2,
    seen_seeds: 1,
    stride: 6,
};

/// A part a scene.
pub fn measure(kept: &mut Kept<Row>, quick: bool) -> Result<()> {
    let extent = if quick { QUICK } else { WHOLE };
    let denoiser = Denoiser::find().map_err(|error| LeftOut(error.to_string()))?;
    let (scenes, work) = noise_scenes(kept)?;
    for scene in scenes.iter().step_by(extent.stride) {
        kept.part(&scene.title, || {
            let gold = scene.load(extent.side, extent.gold_rays, 1)?;
            let truth = GoldTruth::open(&work, &gold, extent.gold_pairs)?;
            let few = scene.load(extent.side, extent.rays, extent.photons_part)?;
            Ok(vec![row(scene, &truth, &gold, &few, &denoiser, &extent)?])
        })?;
    }
    Ok(())
}

/// The scenes, and the folder of their truths; notes those that are left out.
pub fn noise_scenes<R: Serialize + DeserializeOwned>(
    kept: &mut Kept<R>,
) -> Result<(Vec<NoiseScene>, PathBuf)> {
    let work = kept.lasting("gold-truth");
    std::fs::create_dir_all(&work)?;
    let (scenes, left_out) = scenes(&work)?;
    left_out.into_iter().for_each(|sentence| kept.note(sentence));
    Ok((scenes, work))
}

/// Pictures of one way.
struct Pictures {
    pictures: Vec<Pixels>,
    seconds: Vec<f64>,
    /// Wall seconds of the stage that makes the noise less.
    filter_seconds: Vec<f64>,
}

fn row(
    scene: &NoiseScene,
    truth: &GoldTruth,
    gold: &Scene,
    few: &Scene,
    denoiser: &Denoiser,
    extent: &Extent,
) -> Result<Row> {
    let [mut raw, mut reconstructed, mut denoised] = [(); 3].map(|()| Pictures {
        pictures: Vec::new(),
        seconds: Vec::new(),
        filter_seconds: Vec::new(),
    });
    for seed in 0..extent.bias_seeds.max(extent.seeds) {
        let settings = RenderSettings { seed, ..few.render };
        let with = RenderSettings { reconstruct: true, ..settings };
        reconstructed.take("reconstruct", || Ok(render(few, &with, &Silent)?))?;
        if seed < extent.seeds {
            raw.take("", || Ok(render(few, &settings, &Silent)?))?;
            let with = RenderSettings { denoise: true, ..settings };
            denoised.take("denoise", || {
                let mut rendered = render(few, &with, &Silent)?;
                rendered.denoise(denoiser)?;
                Ok(rendered)
            })?;
        }
    }
    let options = Options { exposure: exposure(gold)?, ..Options::default() };
    let halves = truth.halves();
    let width = gold.film.size[0] as usize;
    let mean_truth = halves.mean();
    let way = |name: &str, taken: &Pictures| -> Result<Way> {
        let [trimmed, untrimmed] = halves.errors_of_each(&taken.pictures);
        let seen = &taken.pictures[..extent.seen_seeds];
        let [flip, vdp_percent] = seen_errors(&mean_truth, seen, width, &options)?;
        Ok(Way {
            name: name.into(),
            seconds: mean(&taken.seconds),
            trimmed: mean(&trimmed),
            untrimmed: mean(&untrimmed),
            flip,
            vdp_percent,
            brighter_percent: halves.brighter_percent(&taken.pictures),
            microseconds: 1e6 * mean(&taken.filter_seconds) / halves.pixels() as f64,
        })
    };
    let ways =
        vec![way("raw", &raw)?, way("reconstructed", &reconstructed)?, way("denoised", &denoised)?];
    let [a, b] = halves.pictures();
    let [flip, vdp_percent] = seen_errors(a, slice::from_ref(b), width, &options)?;
    Ok(Row {
        scene: scene.title.clone(),
        size: gold.film.size,
        rays: few.render.rays,
        photons: few.render.photons,
        floor: Floor {
            pictures: 2 * extent.gold_pairs,
            rays: gold.render.rays,
            photons: gold.render.photons,
            error: halves.error(),
            flip,
            vdp_percent,
        },
        gold: gold_stages(gold, truth)?,
        ways,
        bias: ["raw", "reconstructed", "denoised"]
            .into_iter()
            .zip([&raw, &reconstructed, &denoised])
            .map(|(name, taken)| bias(name, taken, truth, width))
            .collect::<Result<_>>()?,
    })
}

impl Pictures {
    /// Renders another one; `filter` names the stage that makes its noise less.
    fn take(&mut self, filter: &str, render: impl FnOnce() -> Result<Rendered>) -> Result<()> {
        let (rendered, spent) = Spent::on(render);
        let rendered = rendered?;
        self.pictures.push(wide(&rendered.film.image()));
        self.seconds.push(spent.ran);
        let stages = rendered.timings.iter().filter(|(name, _)| *name == filter);
        self.filter_seconds.push(stages.map(|(_, took)| took.as_secs_f64()).sum());
        Ok(())
    }
}

/// HDR-FLIP of `pictures`, and the pixels in % whose difference is visible by the VDP: means over them.
pub fn seen_errors(
    truth: &Pixels,
    pictures: &[Pixels],
    width: usize,
    options: &Options,
) -> Result<[f64; 2]> {
    let (truth, mut flip, mut visible) = (narrow(truth, width), Vec::new(), Vec::new());
    for picture in pictures {
        let told = compare(&truth, &narrow(picture, width), options)?.errors;
        flip.push(told.flip_hdr.ok_or("the truth is black")?);
        visible.push(told.vdp_visible_percent);
    }
    Ok([mean(&flip), mean(&visible)])
}

/// Bias of pictures of `width`: the root of what its square is relative to the truth.
fn bias(name: &str, taken: &Pictures, truth: &GoldTruth, width: usize) -> Result<Bias> {
    let root = |squared: f64| 100.0 * squared.max(0.0).sqrt();
    let blocks: Vec<Pixels> = taken.pictures.iter().map(|p| blocks(p, width)).collect();
    let [a, b] = truth.halves().pictures();
    let of_blocks = Halves::new([self::blocks(a, width), self::blocks(b, width)])?;
    let of_pixels = truth.halves().squared_bias(taken.pictures.iter());
    let near = near_edges(truth.depth(), width);
    let select = |wanted: bool| -> Vec<f64> {
        let pixels = of_pixels.iter().zip(&near);
        pixels.filter(|(_, near)| **near == wanted).map(|(squared, _)| *squared).collect()
    };
    let told = |pixels: Vec<f64>| (!pixels.is_empty()).then(|| root(trimmed_mean(pixels)));
    Ok(Bias {
        way: name.into(),
        seeds: taken.pictures.len(),
        blocks_percent: root(trimmed_mean(of_blocks.squared_bias(blocks.iter()))),
        near_edges_percent: told(select(true)),
        elsewhere_percent: told(select(false)),
    })
}

/// Means over blocks.
fn blocks(pixels: &Pixels, width: usize) -> Pixels {
    let height = pixels.len() / width;
    let block = |index: usize| {
        let across = width.div_ceil(BLOCK);
        let [left, top] = [index % across * BLOCK, index / across * BLOCK];
        let rows = top..height.min(top + BLOCK);
        let mut sum = [0.0; 3];
        let mut count = 0.0;
        for y in rows {
            for x in left..width.min(left + BLOCK) {
                sum = [0, 1, 2].map(|c| sum[c] + pixels[y * width + x][c]);
                count += 1.0;
            }
        }
        sum.map(|sum| sum / count)
    };
    (0..width.div_ceil(BLOCK) * height.div_ceil(BLOCK)).map(block).collect()
}

/// Whether each pixel is near an edge: one where the distance of the first surface changes by more than a
/// tenth from a pixel to the next.
fn near_edges(depth: &[f32], width: usize) -> Vec<bool> {
    let differs = |a: f32, b: f32| (a - b).abs() > 0.1 * a.min(b);
    let is_edge = |index: usize| {
        let right = !(index + 1).is_multiple_of(width) && differs(depth[index], depth[index + 1]);
        right || depth.get(index + width).is_some_and(|below| differs(depth[index], *below))
    };
    let edges: Vec<usize> = (0..depth.len()).filter(|&index| is_edge(index)).collect();
    let mut near = vec![false; depth.len()];
    let height = depth.len() / width;
    for edge in edges {
        let (x, y) = (edge % width, edge / width);
        for row in y.saturating_sub(NEAR_EDGES)..height.min(y + NEAR_EDGES + 1) {
            for column in x.saturating_sub(NEAR_EDGES)..width.min(x + NEAR_EDGES + 1) {
                near[row * width + column] = true;
            }
        }
    }
    near
}

/// What a picture of the gold standard takes, and what its error leaves to directors.
pub fn gold_stages(gold: &Scene, truth: &GoldTruth) -> Result<Gold> {
    let pool = rayon::ThreadPoolBuilder::new().build()?;
    let timed = timed(gold, &pool)?;
    let [photons, map, rays] = timed.stages.map(|stage| stage.ran);
    let deviations = truth.deviations();
    let square = mean(&deviations.iter().map(|d| d * d).collect::<Vec<_>>());
    Ok(Gold {
        seconds: timed.whole.ran,
        photon_seconds: photons + map,
        ray_seconds: rays,
        allocation_gain: square / mean(deviations).powi(2),
        microseconds_for_ten: 1e5 * timed.whole.ran / deviations.len() as f64,
    })
}
