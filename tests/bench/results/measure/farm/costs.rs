//! What a picture for a farm takes: once, in each part, and for its rays.

use std::path::Path;

use fogbow::image::{Window, write_exr, write_png};
use fogbow::render::SavedPhotons;
use fogbow::scene::{LoadOptions, PicturePass, Scene};
use rayon::ThreadPool;

use super::merging;
use super::parts::Picture;
use crate::measure::scenes::shipped;
use crate::measure::spent::{Spent, median};
use crate::pages::Result;
use crate::pages::farm::Costs;

/// Rays of a pixel.
const RAYS: u32 = 1024;

/// Passes that are rendered of it: of 4 and of 8 rays a pixel.
const COUNTS: [u32; 2] = [256, 128];

/// Bands in which a pass is rendered again.
const BANDS: u32 = 16;

/// Times that what is short is measured.
const ROUNDS: usize = 3;

/// Measures the scene of this name in the size and with the photons of its file.
pub fn measure(name: &str, quick: bool, pool: &ThreadPool, folder: &Path) -> Result<Costs> {
    let path = shipped(name);
    let own = Scene::load(&path, &LoadOptions::default())?;
    let divisor = if quick { 8 } else { 1 };
    let size = own.film.size.map(|side| side / divisor);
    let photons = own.render.photons / u64::from(divisor);
    let load = || {
        let options = LoadOptions::default().size(size).rays(RAYS).photons(photons);
        pool.install(|| Scene::load(&path, &options))
    };
    let rounds = if quick { 1 } else { ROUNDS };
    let loads: Vec<f64> = (0..rounds).map(|_| Spent::on(load).1.unhindered()).collect();
    let picture = Picture { scene: load()?, pool };

    let file = folder.join(format!("{name}.fog"));
    let shot = picture.save(&file)?;
    let seconds = |stage: &str| {
        let found = shot.done.timings.iter().find(|(name, _)| *name == stage);
        found.map_or(0.0, |(_, time)| time.as_secs_f64())
    };
    let saved = SavedPhotons::open(&file, &picture.scene)?;

    // Passes.
    let pass = |count: u32| Some(PicturePass { count, number: 2 });
    let few = picture.part(pass(COUNTS[0]), None, Some(&saved))?;
    let many = picture.part(pass(COUNTS[1]), None, Some(&saved))?;
    let rays = COUNTS.map(|count| f64::from(RAYS / count));
    let [few_steps, many_steps] = [&few, &many].map(|part| part.done.work.march_steps as f64);
    // Steps are as rays and what a pass has once.
    let once = (rays[1] * few_steps - rays[0] * many_steps) / (many_steps - few_steps);
    let once = once.max(0.0);
    let ray = many.stage("rays").unhindered() / (rays[1] + once);

    // The same pass in bands.
    let [width, height] = size;
    let (mut bands, mut steps) = (Vec::new(), 0.0);
    for band in 0..BANDS {
        let top = height * band / BANDS;
        let height = height * (band + 1) / BANDS - top;
        let crop = Some(Window { left: 0, top, width, height });
        let part = picture.part(pass(COUNTS[1]), crop, Some(&saved))?;
        bands.push(part.stage("rays").ran);
        steps += part.done.work.march_steps as f64;
    }
    let all: f64 = bands.iter().sum();
    let cuts = f64::from(BANDS - 1);
    let border = ((steps / many_steps - 1.0) * f64::from(height) / cuts).max(0.0);

    let film = &many.done.film;
    let encode = || -> Result<f64> {
        let (written, took) = Spent::on(|| {
            pool.install(|| {
                let exr = folder.join(format!("{name}.exr"));
                let png = || {
                    write_png(
                        &exr.with_extension("png"),
                        &film.image(),
                        &picture.scene.film.shown(),
                    )
                };
                let (png, exr) = rayon::join(png, || write_exr(&exr, film, &[]));
                png.and(exr)
            })
        });
        written?;
        Ok(took.unhindered())
    };
    let encodes = (0..rounds).map(|_| encode()).collect::<Result<Vec<_>>>()?;
    let merging = merging::measure(&path, size, quick, folder)?;
    Ok(Costs {
        scene: name.into(),
        size,
        rays: RAYS,
        photons,
        load: median(loads),
        strategy: shot.before().unhindered(),
        shoot: (shot.whole - shot.before()).unhindered() - seconds("write"),
        write_photons: seconds("write"),
        read_photons: few.whole.unhindered() - few.stage("rays").unhindered(),
        ray,
        once,
        border,
        bands: bands.iter().map(|ran| ran / all).collect(),
        encode: median(encodes),
        merge_passes: merging.passes,
        merge_crops: merging.crops,
    })
}
