//! What merging takes.

use std::path::{Path, PathBuf};
use std::time::Instant;

use crate::measure::child::{argument, fogbow};
use crate::pages::Result;

/// Parts of the merges.
const FEW: u32 = 2;
const MANY: u32 = 16;

/// Merges of the same parts, of which the quickest counts: other programs on the machine only slow them down.
const ROUNDS: usize = 5;

/// Seconds of a merge: without parts, and for each.
pub struct Merging {
    /// Of equal passes.
    pub passes: [f64; 2],
    /// Of crops: of all together, and for each.
    pub crops: [f64; 2],
}

/// Merges parts of the scene `path` in `size` that have one ray a pixel.
pub fn measure(path: &Path, size: [u32; 2], quick: bool, folder: &Path) -> Result<Merging> {
    let rounds = if quick { 1 } else { ROUNDS };
    let [width, height] = size;
    let size = format!("{width}x{height}");
    let base = [argument(path)?, "--size", &size, "--photons", "20000", "--json", "--quiet"];
    let out = |name: String| folder.join(format!("{name}.exr"));
    let render = |file: &Path, more: &[&str]| -> Result<()> {
        fogbow(&[&["render"], &base[..], more, &["-o", argument(file)?]].concat()).map(|_| ())
    };
    let [mut passes, mut crops] = [Vec::new(), Vec::new()];
    for count in [FEW, MANY] {
        let photons = folder.join("merged.fog");
        let photons = argument(&photons)?;
        let rays = count.to_string();
        let shoot = ["--rays", &rays, "--photons-to", photons];
        fogbow(&[&["render"], &base[..], &shoot].concat())?;
        let (mut own_passes, mut own_crops) = (Vec::new(), Vec::new());
        for number in 1..=count {
            let file = out(format!("pass{number}"));
            let pass = format!("{number}/{count}");
            render(&file, &["--rays", &rays, "--pass", &pass, "--photons-from", photons])?;
            own_passes.push(file);
            let top = height * (number - 1) / count;
            let crop = format!("0,{top},{width}x{}", height * number / count - top);
            let file = out(format!("crop{number}"));
            render(&file, &["--rays", "1", "--crop", &crop, "--photons-from", photons])?;
            own_crops.push(file);
        }
        passes.push(quickest(&own_passes, rounds, folder)?);
        crops.push(quickest(&own_crops, rounds, folder)?);
    }
    let line = |[few, many]: [f64; 2]| {
        let each = ((many - few) / f64::from(MANY - FEW)).max(0.0);
        [few - f64::from(FEW) * each, each]
    };
    Ok(Merging { passes: line([passes[0], passes[1]]), crops: line([crops[0], crops[1]]) })
}

/// Seconds of merging these parts.
fn quickest(parts: &[PathBuf], rounds: usize, folder: &Path) -> Result<f64> {
    let merged = folder.join("merged.exr");
    let parts = parts.iter().map(|part| argument(part)).collect::<Result<Vec<_>>>()?;
    let command = [&["merge"], &parts[..], &["-o", argument(&merged)?, "--json"]].concat();
    let mut least = f64::INFINITY;
    for _ in 0..rounds {
        let start = Instant::now();
        fogbow(&command)?;
        least = least.min(start.elapsed().as_secs_f64());
    }
    Ok(least)
}
