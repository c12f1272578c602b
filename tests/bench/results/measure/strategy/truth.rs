//! Two independent references of a scene, kept from run to run.

use std::fs;
use std::path::{Path, PathBuf};

use fogbow::image::{read_exr, write_exr_image};
use fogbow::render::{Silent, render_reference};
use fogbow::scene::{RenderSettings, Scene};
use serde::{Deserialize, Serialize};

use super::super::halves::{Halves, Pixels, mean_of, narrow, wide};
use super::super::spent::Spent;
use crate::pages::Result;

/// Rays a pixel of the first pair of pictures; each further pair has as many as all before.
const FIRST_RAYS: u32 = 32;

/// Seed of the first picture: far from those of candidates.
const FIRST_SEED: u64 = 1_000_000;

/// Both references, kept in a folder.
pub struct Truth {
    folder: PathBuf,
    spent: TruthSpent,
    halves: Halves,
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
        if let Ok(json) = fs::read(spent_path(folder)) {
            let kept = |half| read_exr(&picture_path(folder, half));
            let halves = Halves::new([wide(&kept(0)?), wide(&kept(1)?)])?;
            return Ok(Self {
                folder: folder.into(),
                spent: serde_json::from_slice(&json)?,
                halves,
            });
        }
        let mut spent = TruthSpent::default();
        let halves = Halves::new(pair(scene, FIRST_RAYS, &mut spent))?;
        let truth = Self { folder: folder.into(), spent, halves };
        truth.save(scene.film.size)?;
        Ok(truth)
    }

    /// Doubles the rays.
    pub fn grow(&mut self, scene: &Scene) -> Result<()> {
        let new = pair(scene, self.spent.rays, &mut self.spent);
        let [a, b] = self.halves.pictures();
        let both = [[a, &new[0]], [b, &new[1]]].map(|both| mean_of(both.into_iter()));
        self.halves = Halves::new(both)?;
        self.save(scene.film.size)
    }

    /// What they took.
    pub fn spent(&self) -> TruthSpent {
        self.spent
    }

    /// Both.
    pub fn halves(&self) -> &Halves {
        &self.halves
    }

    /// What they took is written last: without it the pictures don't count.
    fn save(&self, [width, _]: [u32; 2]) -> Result<()> {
        let spent = spent_path(&self.folder);
        let _ = fs::remove_file(&spent);
        for (half, pixels) in self.halves.pictures().iter().enumerate() {
            let image = narrow(pixels, width as usize);
            write_exr_image(&picture_path(&self.folder, half), &image)?;
        }
        Ok(fs::write(spent, serde_json::to_vec(&self.spent)?)?)
    }
}

/// A picture of each half with as many rays, which count as `spent`.
fn pair(scene: &Scene, rays: u32, spent: &mut TruthSpent) -> [Pixels; 2] {
    let pictures = [0, 1].map(|half| {
        let seed = FIRST_SEED + 2 * spent.pairs + half;
        let settings = RenderSettings { rays, seed, ..scene.render };
        let (rendered, took) = Spent::on(|| render_reference(scene, &settings, &Silent));
        spent.seconds += took.ran;
        wide(&rendered.film.image())
    });
    spent.rays += rays;
    spent.pairs += 1;
    pictures
}

fn spent_path(folder: &Path) -> PathBuf {
    folder.join("spent.json")
}

fn picture_path(folder: &Path, half: usize) -> PathBuf {
    folder.join(format!("half_{half}.exr"))
}
