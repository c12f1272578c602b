//! How the error of `fixed` falls with time, photons and rays growing together.
//!
//!     cargo bench --bench convergence                      # half an hour for smoke and cloud
//!     cargo bench --bench convergence -- road              # another scene of volumes/
//!     cargo bench --bench convergence -- --quick           # that it works
//!
//! Photons and rays of a pixel grow by factors of 4, over several seeds. Errors are relative squared
//! errors, taken against two references of different seeds at once: the product of the differences
//! from both is in the mean the squared error alone, for the noise of one has nothing to do with that
//! of the other. In the same way the product of the differences of two seeds is in the mean the
//! squared bias alone. "Trimmed" leaves out the worst 0.1 % of the pixels. "Bright" and "brightest"
//! tell by how many per cent all pixels together are brighter than the references, and the tenth of them that
//! is brightest: chosen by one reference, held against the other, lest noise choose. What a reference
//! itself is off is printed first. The slope is that of the logarithm of the error over that of the time, by
//! least squares, and from each step to the next, where a plateau would show as 0.
//!
//! To be expected: light on a lattice whose cells' edge is made as N^(-1/5) has variance and squared
//! bias as N^(-4/5), rays without photons as 1 over their number: -0.8 to -1 together. Photons
//! gathered along rays within radii as N^(-1/2) are always as many, so that the variance of one gather
//! stays; it is averaged over what the film's pixel and its gathers see.

#![allow(clippy::print_stdout)]

mod spent;

use std::path::Path;

use fogbow::image::Image;
use fogbow::render::{Silent, render, render_reference};
use fogbow::scene::{LoadOptions, RenderSettings, Scene};
use fogbow::study::metric::{TRIM, default_epsilon};
use fogbow::study::{significant, slope};

use spent::{Spent, median};

/// Pixels along both sides.
const SIDE: u32 = 96;

/// What the first step has; each has [`GROWTH`] times as much as the one before.
const PHOTONS: u64 = 20_000;
const RAYS: u32 = 2;
const GROWTH: u32 = 4;

const SEEDS: u64 = 4;

/// Scenes of `volumes/` with their steps and rays of a pixel of each reference.
const SCENES: [(&str, u32, u32); 2] = [("smoke", 5, 1024), ("cloud", 4, 4096)];

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let quick = words.iter().any(|word| word == "--quick");
    let named = words.iter().map(String::as_str).filter(|word| !word.starts_with('-'));
    let known = |name| SCENES.into_iter().find(|scene| scene.0 == name).unwrap_or((name, 4, 256));
    let mut scenes: Vec<_> = named.map(known).collect();
    if scenes.is_empty() {
        scenes = SCENES.to_vec();
    }
    for (name, steps, rays) in scenes {
        if quick { converge(name, 3, 16) } else { converge(name, steps, rays) }
    }
}

/// A scene's table.
fn converge(name: &str, steps: u32, rays: u32) {
    let scene = load(name);
    let truth = Truth::of(&scene, rays);
    println!("\n{name}, {SIDE} x {SIDE} pixels, {SEEDS} seeds. Processor seconds of all threads.");
    let [all, brightest] = truth.uncertain().map(|percent| significant(percent, 1));
    println!(
        "A reference of {rays} rays is off by {} itself; both together are by {all} % for all pixels, \
         {brightest} % for the brightest (standard error).",
        significant(truth.noise, 2)
    );
    println!(
        "| photons | rays | seconds | error | trimmed | squared bias | bright | brightest | slope | trimmed |"
    );
    println!("|{}", " --- |".repeat(10));
    let mut points: Vec<Point> = Vec::new();
    for step in 0..steps {
        let grown = GROWTH.pow(step);
        let settings = RenderSettings {
            photons: PHOTONS * u64::from(grown),
            rays: RAYS * grown,
            ..scene.render
        };
        let point = Point::measured(&scene, &settings, &truth);
        let before = points.last();
        let since = |error: fn(&Point) -> f64| {
            let Some(before) = before else { return "–".into() };
            let pair = [before, &point].map(|point| (point.seconds, error(point)));
            slope(&pair).map_or_else(|| "–".into(), |slope| format!("{slope:.2}"))
        };
        println!(
            "| {} | {} | {} | {} | {} | {} | {:+.2} | {:+.2} | {} | {} |",
            settings.photons,
            settings.rays,
            significant(point.seconds, 3),
            significant(point.error, 2),
            significant(point.trimmed, 2),
            significant(point.bias, 1),
            point.brighter[0],
            point.brighter[1],
            since(|point| point.error),
            since(|point| point.trimmed)
        );
        points.push(point);
    }
    let all = |error: fn(&Point) -> f64| {
        let places: Vec<_> = points.iter().map(|point| (point.seconds, error(point))).collect();
        slope(&places).unwrap_or(f64::NAN)
    };
    println!(
        "slope over all: {:.2}, trimmed {:.2}",
        all(|point| point.error),
        all(|point| point.trimmed)
    );
}

fn load(name: &str) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("volumes/{name}.toml"));
    Scene::load(&path, &LoadOptions::default().size([SIDE; 2])).expect("a shipped scene")
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
    fn of(scene: &Scene, rays: u32) -> Self {
        let picture = |seed: u64| {
            let settings = RenderSettings { rays, seed, ..scene.render };
            render_reference(scene, &settings, &Silent).film.image()
        };
        let pictures = [picture(1_000_001), picture(1_000_002)];
        let [a, b] = &pictures;
        let epsilon = default_epsilon(a).expect("some light");
        let scale = |(a, b): (&[f32; 3], &[f32; 3])| {
            let grey = a.iter().chain(b).map(|v| f64::from(*v)).sum::<f64>() / 6.0;
            grey * grey + epsilon * epsilon
        };
        let scales = a.pixels().iter().zip(b.pixels()).map(scale).collect();
        let mut truth = Self { pictures, scales, noise: 0.0 };
        let [a, b] = &truth.pictures;
        let differences = truth.differences(a, b);
        truth.noise = 0.5 * mean(&truth.products(&differences, &differences));
        truth
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
struct Point {
    seconds: f64,
    error: f64,
    trimmed: f64,
    bias: f64,
    /// In per cent: see [`Truth::brighter`].
    brighter: [f64; 2],
}

impl Point {
    fn measured(scene: &Scene, settings: &RenderSettings, truth: &Truth) -> Self {
        let mut seconds = Vec::new();
        let mut off: Vec<[Vec<[f64; 3]>; 2]> = Vec::new();
        let mut brighter = [0.0; 2];
        for seed in 0..SEEDS {
            let settings = RenderSettings { seed, ..*settings };
            let (rendered, spent) = Spent::on(|| render(scene, &settings, &Silent));
            let picture = rendered.expect("a picture").film.image();
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
        Self {
            seconds: median(seconds),
            error: mean(&errors),
            trimmed: mean(&trimmed),
            bias: mean(&biases),
            brighter,
        }
    }
}

/// Of all channels.
fn total(pixel: &[f32; 3]) -> f64 {
    pixel.iter().map(|v| f64::from(*v)).sum()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}
