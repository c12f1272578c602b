//! The truth of a scene: the mean of pictures of the gold standard, in two halves.

use std::fs;
use std::path::{Path, PathBuf};

use fogbow::image::{Image, read_exr, write_exr_image};
use fogbow::render::{Silent, render};
use fogbow::scene::{RenderSettings, Scene};

use super::super::halves::{Halves, Pixels, mean_of, wide};
use crate::pages::Result;

/// Seed of the first picture: far from those that are measured.
const FIRST_SEED: u64 = 2_000_000;

/// Both halves, with what is told of single pictures.
pub struct GoldTruth {
    halves: Halves,
    /// Distance of the first surface that pixels see.
    depth: Vec<f32>,
    /// Standard deviation of the luminance of each pixel, relative to what errors are relative to.
    deviations: Vec<f64>,
}

impl GoldTruth {
    /// The mean of `pairs` of pictures; those kept in `work` are not rendered again.
    pub fn open(work: &Path, scene: &Scene, pairs: u64) -> Result<Self> {
        let [width, height] = scene.film.size;
        let RenderSettings { rays, photons, .. } = scene.render;
        let folder = work.join(format!("{}_{width}x{height}_{rays}_{photons}", scene.hash));
        fs::create_dir_all(&folder)?;
        let pictures: Vec<Pixels> =
            (0..2 * pairs).map(|index| picture(&folder, scene, index)).collect::<Result<_>>()?;
        let half = |half: usize| mean_of(pictures.iter().skip(half).step_by(2));
        let halves = Halves::new([half(0), half(1)])?;
        let depth = read_exr(&path(&folder, "depth"))?.pixels().iter().map(|p| p[0]).collect();
        let deviations = deviations(&pictures, &halves);
        Ok(Self { halves, depth, deviations })
    }

    /// Both halves.
    pub fn halves(&self) -> &Halves {
        &self.halves
    }

    /// Distance of the first surface that pixels see, 1e10 where there is none.
    pub fn depth(&self) -> &[f32] {
        &self.depth
    }

    /// Standard deviation of each pixel of a picture of the gold standard, relative.
    pub fn deviations(&self) -> &[f64] {
        &self.deviations
    }
}

/// A picture, rendered where it is not kept; the first leaves the depth too.
fn picture(folder: &Path, scene: &Scene, index: u64) -> Result<Pixels> {
    let kept = path(folder, &index.to_string());
    if !kept.is_file() {
        let settings = RenderSettings { seed: FIRST_SEED + index, ..scene.render };
        let film = render(scene, &settings, &Silent)?.film;
        if index == 0 {
            let depth = film.layer("Z").ok_or("a film has a layer Z")?;
            let depth = depth.iter().map(|z| [*z; 3]).collect();
            let depth = Image::new(film.width(), film.height(), depth);
            write_exr_image(&path(folder, "depth"), &depth)?;
        }
        write_exr_image(&kept, &film.image())?;
    }
    Ok(wide(&read_exr(&kept)?))
}

fn path(folder: &Path, name: &str) -> PathBuf {
    folder.join(format!("{name}.exr"))
}

/// Relative standard deviation of each pixel over pictures.
fn deviations(pictures: &[Pixels], truth: &Halves) -> Vec<f64> {
    let mean = truth.mean();
    let of_mean = pictures.len() as f64 - 1.0;
    let mut squares = vec![0.0; truth.pixels()];
    for picture in pictures {
        for (sum, square) in squares.iter_mut().zip(truth.squares(picture, &mean)) {
            *sum += square / of_mean;
        }
    }
    squares.into_iter().map(f64::sqrt).collect()
}
