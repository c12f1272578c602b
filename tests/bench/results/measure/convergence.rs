//! How the error of `fixed` falls with time, photons and rays growing together.
//!
//! Photons and rays of a pixel grow by factors of 4, over several seeds. Errors are relative squared
//! errors, taken against two references of different seeds at once: the product of the differences
//! from both is in the mean the squared error alone, for the noise of one has nothing to do with that
//! of the other. In the same way the product of the differences of two seeds is in the mean the
//! squared bias alone. "Trimmed" leaves out the worst 0.1 % of the pixels. "Bright" and "brightest"
//! tell by how many per cent all pixels together are brighter than the references, and the tenth of them that
//! is brightest: chosen by one reference, held against the other, lest noise choose. What a reference
//! itself is off is told beside.
//!
//! To be expected: light on a lattice whose cells' edge is made as N^(-1/5) has variance and squared
//! bias as N^(-4/5), rays without photons as 1 over their number: -0.8 to -1 together. Photons
//! gathered along rays within radii as N^(-1/2) are always as many, so that the variance of one gather
//! stays; it is averaged over what the film's pixel and its gathers see.

use fogbow::image::Image;
use fogbow::render::{Silent, render, render_reference};
use fogbow::scene::{LoadOptions, RenderSettings, Scene};
use fogbow::study::metric::{TRIM, default_epsilon};

use super::Kept;
use super::scenes::shipped;
use super::spent::{Spent, median};
use crate::pages::Result;
use crate::pages::convergence::Row;

/// Pixels along both sides.
const SIDE: u32 = 96;

/// What the first step has; each has [`GROWTH`] times as much as the one before.
const PHOTONS: u64 = 20_000;
const RAYS: u32 = 2;
const GROWTH: u32 = 4;

const SEEDS: u64 = 4;

/// Scenes of `volumes/` with their steps and rays of a pixel of each reference.
const SCENES: [(&str, u32, u32); 2] = [("smoke", 5, 1024), ("cloud", 4, 4096)];

/// A part for the references of a scene, and one a step.
pub fn measure(kept: &mut Kept<Row>, quick: bool) -> Result<()> {
    for (name, steps, rays) in SCENES {
        let (steps, rays) = if quick { (2, 16) } else { (steps, rays) };
        let scene = load(name)?;
        // Made where a part first asks for it.
        let mut made: Option<Truth> = None;
        kept.part(&format!("references of {name}"), || {
            let truth = made.insert(Truth::new(&scene, rays)?);
            let (noise, off_percent) = (Some(truth.noise), truth.uncertain());
            Ok(vec![Row::Reference { scene: name.into(), rays, noise, off_percent }])
        })?;
        for step in 0..steps {
            let grown = GROWTH.pow(step);
            let settings = RenderSettings {
                photons: PHOTONS * u64::from(grown),
                rays: RAYS * grown,
                ..scene.render
            };
            kept.part(&format!("{name}, {} photons", settings.photons), || {
                let truth = match made.take() {
                    Some(truth) => truth,
                    None => Truth::new(&scene, rays)?,
                };
                Ok(vec![measured(name, &scene, &settings, made.insert(truth))?])
            })?;
        }
    }
    Ok(())
}

fn load(name: &str) -> Result<Scene> {
    Ok(Scene::load(&shipped(name), &LoadOptions::default().size([SIDE; 2]))?)
}

/// Two references.
struct Truth {
    pictures: [Image; 2],
    /// What a pixel's squared error is relative to.
    scales: Vec<f64>,
    /// Relative squared error of one of them.
    noise: f64,
}

impl Truth {
    fn new(scene: &Scene, rays: u32) -> Result<Self> {
        let picture = |seed: u64| {
            let settings = RenderSettings { rays, seed, ..scene.render };
            render_reference(scene, &settings, &Silent).film.image()
        };
        let pictures = [picture(1_000_001), picture(1_000_002)];
        let [a, b] = &pictures;
        let epsilon = default_epsilon(a).ok_or("a reference is black")?;
        let scale = |(a, b): (&[f32; 3], &[f32; 3])| {
            let grey = a.iter().chain(b).map(|v| f64::from(*v)).sum::<f64>() / 6.0;
            grey * grey + epsilon * epsilon
        };
        let scales = a.pixels().iter().zip(b.pixels()).map(scale).collect();
        let mut truth = Self { pictures, scales, noise: 0.0 };
        let [a, b] = &truth.pictures;
        let differences = truth.differences(a, b);
        truth.noise = 0.5 * mean(&truth.products(&differences, &differences));
        Ok(truth)
    }

    /// The pixels that are told of as all and as the brightest, by the reference of this number.
    fn chosen(&self, by: usize) -> [Vec<usize>; 2] {
        let pixels = self.pictures[by].pixels();
        let mut brightest: Vec<usize> = (0..pixels.len()).collect();
        brightest.sort_by(|&i, &j| total(&pixels[j]).total_cmp(&total(&pixels[i])));
        brightest.truncate(pixels.len() / 10);
        [(0..pixels.len()).collect(), brightest]
    }

    /// By how many per cent a picture is brighter, for all pixels and for the brightest.
    fn brighter(&self, picture: &Image) -> [f64; 2] {
        let by = |by: usize| {
            let other = &self.pictures[1 - by];
            self.chosen(by).map(|pixels| {
                let sum =
                    |image: &Image| pixels.iter().map(|&i| total(&image.pixels()[i])).sum::<f64>();
                100.0 * (sum(picture) / sum(other) - 1.0)
            })
        };
        let [a, b] = [by(0), by(1)];
        [0, 1].map(|which| 0.5 * (a[which] + b[which]))
    }

    /// Standard error of that, from how the two references differ.
    fn uncertain(&self) -> [f64; 2] {
        let [a, b] = self.pictures.each_ref().map(Image::pixels);
        self.chosen(0).map(|pixels| {
            let squares =
                pixels.iter().map(|&i| (total(&a[i]) - total(&b[i])).powi(2)).sum::<f64>();
            100.0 * 0.5 * squares.sqrt() / pixels.iter().map(|&i| total(&b[i])).sum::<f64>()
        })
    }

    fn differences(&self, picture: &Image, from: &Image) -> Vec<[f64; 3]> {
        let pairs = picture.pixels().iter().zip(from.pixels());
        pairs.map(|(p, q)| [0, 1, 2].map(|c| f64::from(p[c]) - f64::from(q[c]))).collect()
    }

    /// For each pixel the mean over channels of the products of both differences, relative.
    fn products(&self, a: &[[f64; 3]], b: &[[f64; 3]]) -> Vec<f64> {
        let pairs = a.iter().zip(b).zip(&self.scales);
        pairs
            .map(|((a, b), scale)| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() / 3.0 / scale)
            .collect()
    }
}

/// What a step takes and how good it is, in the mean over the seeds.
fn measured(name: &str, scene: &Scene, settings: &RenderSettings, truth: &Truth) -> Result<Row> {
    let mut seconds = Vec::new();
    let mut off: Vec<[Vec<[f64; 3]>; 2]> = Vec::new();
    let mut brighter = [0.0; 2];
    for seed in 0..SEEDS {
        let settings = RenderSettings { seed, ..*settings };
        let (rendered, spent) = Spent::on(|| render(scene, &settings, &Silent));
        let picture = rendered?.film.image();
        seconds.push(spent.ran);
        for (mean, of_seed) in brighter.iter_mut().zip(truth.brighter(&picture)) {
            *mean += of_seed / SEEDS as f64;
        }
        off.push([0, 1].map(|which| truth.differences(&picture, &truth.pictures[which])));
    }
    let (mut errors, mut trimmed, mut biases) = (Vec::new(), Vec::new(), Vec::new());
    for (i, [from_a, from_b]) in off.iter().enumerate() {
        let mut products = truth.products(from_a, from_b);
        errors.push(mean(&products));
        products.sort_by(|p, q| p.abs().total_cmp(&q.abs()));
        let left = (products.len() as f64 * (1.0 - TRIM)).ceil() as usize;
        trimmed.push(mean(&products[..left]));
        let others = off.iter().enumerate().filter(|(j, _)| *j != i);
        biases.extend(others.map(|(_, [_, other])| mean(&truth.products(from_a, other))));
    }
    Ok(Row::Step {
        scene: name.into(),
        photons: Some(settings.photons),
        rays: settings.rays,
        seconds: Some(median(seconds)),
        error: Some(mean(&errors)),
        trimmed: Some(mean(&trimmed)),
        bias: Some(mean(&biases)),
        brighter_percent: Some(brighter[0]),
        brightest_percent: Some(brighter[1]),
    })
}

/// Of all channels.
fn total(pixel: &[f32; 3]) -> f64 {
    pixel.iter().map(|v| f64::from(*v)).sum()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}
