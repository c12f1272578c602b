//! Two independent references of a scene, and errors against both.
//!
//! The product of a picture's differences from both is in the mean its squared error alone, for the
//! noise of one reference has nothing to do with that of the other.

use std::fs;
use std::path::{Path, PathBuf};

use fogbow::image::{Image, read_exr, write_exr_image};
use fogbow::render::{Silent, render_reference};
use fogbow::scene::{RenderSettings, Scene};
use serde::{Deserialize, Serialize};

use super::super::spent::Spent;
use crate::pages::Result;

/// Squared errors are relative to the squared radiance and that of this share of the mean radiance, as in
/// studies.
const EPSILON: f64 = 0.5;

/// Share of the pixels, the worst ones, that a trimmed mean leaves out.
const TRIM: f64 = 0.002;

/// Rays a pixel of the first pair of pictures; each further pair has as many as all before.
const FIRST_RAYS: u32 = 32;

/// Seed of the first picture: far from those of candidates.
const FIRST_SEED: u64 = 1_000_000;

/// Both references, kept in a folder.
pub struct Truth {
    folder: PathBuf,
    spent: TruthSpent,
    /// Radiance of each pixel.
    halves: [Vec<[f64; 3]>; 2],
    /// What the squared error of a pixel is relative to.
    scales: Vec<f64>,
}

/// What the references took.
#[derive(Clone, Copy, Default, Serialize, Deserialize)]
pub struct TruthSpent {
    /// Rays a pixel of each of the two.
    pub rays: u32,
    /// Pairs of pictures that they are the mean of.
    pub pairs: u64,
    /// Processor seconds of all threads.
    pub seconds: f64,
}

impl Truth {
    /// Those kept in `folder`; the first rays of those where there are none.
    pub fn open(folder: &Path, scene: &Scene) -> Result<Self> {
        fs::create_dir_all(folder)?;
        let mut truth = Self {
            folder: folder.into(),
            spent: TruthSpent::default(),
            halves: [Vec::new(), Vec::new()],
            scales: Vec::new(),
        };
        if let Ok(json) = fs::read(truth.spent_path()) {
            truth.spent = serde_json::from_slice(&json)?;
            for (half, pixels) in truth.halves.iter_mut().enumerate() {
                *pixels = wide(&read_exr(&picture_path(folder, half))?);
            }
            truth.scale()?;
        } else {
            truth.grow(scene)?;
        }
        Ok(truth)
    }

    /// Doubles the rays.
    pub fn grow(&mut self, scene: &Scene) -> Result<()> {
        let TruthSpent { rays: before, pairs, .. } = self.spent;
        let rays = before.max(FIRST_RAYS);
        for half in 0..2 {
            let seed = FIRST_SEED + 2 * pairs + half as u64;
            let settings = RenderSettings { rays, seed, ..scene.render };
            let (rendered, spent) = Spent::on(|| render_reference(scene, &settings, &Silent));
            self.spent.seconds += spent.ran;
            let new = wide(&rendered.film.image());
            if before == 0 {
                self.halves[half] = new;
                continue;
            }
            for (old, new) in self.halves[half].iter_mut().zip(new) {
                *old = [0, 1, 2].map(|c| 0.5 * (old[c] + new[c]));
            }
        }
        self.spent.rays = before + rays;
        self.spent.pairs += 1;
        self.scale()?;
        self.save(scene.film.size)
    }

    /// What they took.
    pub fn spent(&self) -> TruthSpent {
        self.spent
    }

    /// Trimmed relative squared error of the mean of both.
    pub fn error(&self) -> f64 {
        let [a, b] = &self.halves;
        let halved: Vec<[f64; 3]> =
            a.iter().zip(b).map(|(a, b)| [0, 1, 2].map(|c| 0.5 * (a[c] - b[c]))).collect();
        trimmed_mean(self.products(&halved, &halved))
    }

    /// Differences of a picture from each of the two.
    pub fn differences(&self, picture: &Image) -> [Vec<[f64; 3]>; 2] {
        self.halves.each_ref().map(|half| {
            let pairs = picture.pixels().iter().zip(half);
            pairs.map(|(p, t)| [0, 1, 2].map(|c| f64::from(p[c]) - t[c])).collect()
        })
    }

    /// For each pixel the mean over channels of the products of both differences, relative.
    pub fn products(&self, a: &[[f64; 3]], b: &[[f64; 3]]) -> Vec<f64> {
        let pairs = a.iter().zip(b).zip(&self.scales);
        pairs
            .map(|((a, b), scale)| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() / 3.0 / scale)
            .collect()
    }

    /// How many pixels there are.
    pub fn pixels(&self) -> usize {
        self.scales.len()
    }

    /// Sum of the mean of both over pixels and channels.
    pub fn total(&self) -> f64 {
        0.5 * self.halves.iter().flatten().flatten().sum::<f64>()
    }

    /// Takes the scales from the mean of both.
    fn scale(&mut self) -> Result<()> {
        let [a, b] = &self.halves;
        let epsilon = EPSILON * self.total() / (3.0 * a.len() as f64);
        if epsilon <= 0.0 {
            return Err("the reference is black".into());
        }
        let grey = |(a, b): (&[f64; 3], &[f64; 3])| a.iter().chain(b).sum::<f64>() / 6.0;
        self.scales = a.iter().zip(b).map(|pair| grey(pair).powi(2) + epsilon * epsilon).collect();
        Ok(())
    }

    /// What they took is written last: without it the pictures don't count.
    fn save(&self, [width, height]: [u32; 2]) -> Result<()> {
        let _ = fs::remove_file(self.spent_path());
        for (half, pixels) in self.halves.iter().enumerate() {
            let pixels = pixels.iter().map(|pixel| pixel.map(|v| v as f32)).collect();
            let image = Image::new(width as usize, height as usize, pixels);
            write_exr_image(&picture_path(&self.folder, half), &image)?;
        }
        Ok(fs::write(self.spent_path(), serde_json::to_vec(&self.spent)?)?)
    }

    fn spent_path(&self) -> PathBuf {
        self.folder.join("spent.json")
    }
}

fn picture_path(folder: &Path, half: usize) -> PathBuf {
    folder.join(format!("half_{half}.exr"))
}

fn wide(image: &Image) -> Vec<[f64; 3]> {
    image.pixels().iter().map(|pixel| pixel.map(f64::from)).collect()
}

/// Mean without the largest magnitudes: one firefly can outweigh a whole picture.
pub fn trimmed_mean(mut values: Vec<f64>) -> f64 {
    values.sort_by(|p, q| p.abs().total_cmp(&q.abs()));
    let left = (values.len() as f64 * (1.0 - TRIM)).ceil() as usize;
    mean(&values[..left])
}

/// The mean.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}
