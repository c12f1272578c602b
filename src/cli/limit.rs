//! Renders that fit the memory there is.

use bytesize::ByteSize;

use super::header::Method;
use super::memory;
use crate::error::{Error, Result};
use crate::render::{self, Memory, MemoryParts};
use crate::scene::{RenderSettings, Scene};

/// Bytes of the program and its libraries where the system does not tell.
const PROGRAM: u64 = 36 << 20;

/// Bytes a photon asked for, at most: a path leaves several photons in thick media.
const PHOTON: u64 = 4096;

/// Bytes of a medium's lattices, at most: for direct light, gathers and flights, the last twice while
/// they are built, each of up to 256 MiB a channel and a table of 200 MB.
const LATTICES: u64 = 5 << 30;

/// Fewer photons show nothing.
const FEWEST: u64 = 1000;

/// So many are tried first where memory is limited, since a look at many takes much itself.
const FIRST: u64 = 20_000;

/// Photons grow with this power of the memory of lattices, whose cells' edge is as the -1/5th power of
/// their number.
const GROWTH: f64 = 5.0 / 3.0;

/// One part in so many by which more photons are not worth another try.
const SLIGHT: u64 = 8;

/// How often other numbers of photons are tried.
const TRIES: usize = 6;

/// Of the photons of one try, at most this share is taken for the next.
const FILLED: f64 = 0.9;

/// One part in so many by which an estimate may be too low: where photons are thinned, they are
/// thinned until so much is left over.
const OFF: u64 = 16;

/// Bytes a pixel that taking off noise needs beside the film.
const DENOISING: u64 = 700;

/// Bytes in memory before anything is loaded.
pub(super) fn program() -> u64 {
    memory::resident().unwrap_or(PROGRAM)
}

/// Sees to it that rendering `scene` takes at most `asked` bytes, and asks for fewer photons where
/// it must; then a sentence says so. Where nothing is asked it must fit what the machine has free.
/// Where that is close a few photons are shot to see: their work is not counted, so that a picture
/// does not tell how much memory was free. Refused is only what takes more by the estimate itself.
/// The program took `program` bytes before the scene was loaded.
///
/// # Errors
/// Where it does not fit.
pub(super) fn fit(
    scene: &mut Scene,
    asked: Option<u64>,
    method: Method,
    program: u64,
) -> Result<Option<String>> {
    let free = || memory::available().map(|free| free + memory::resident().unwrap_or(0));
    let Some(bytes) = asked.or_else(free) else { return Ok(None) };
    let limit = Limit { bytes, is_asked: asked.is_some() };
    let without = render::memory_without_photons(scene, &scene.render, program);
    limit.holds(&without.at_peak)?;
    if scene.render.denoise {
        limit.holds(&denoising(scene, &without))?;
    }
    let lattices = LATTICES.saturating_mul(scene.media.len() as u64);
    let most = scene.render.photons.saturating_mul(PHOTON).saturating_add(lattices);
    if method.reference || without.peak.saturating_add(most) <= bytes {
        return Ok(None);
    }
    if asked.is_none() {
        let needed = render::memory_needed(scene, &scene.render, program)?;
        return limit.holds(&needed.at_peak).map(|()| None);
    }
    let all = scene.render.photons;
    let (photons, peak) = most_photons(scene, limit, &without, program)?;
    scene.render.photons = photons;
    let thinned = format!(
        "{photons} photons instead of {all}, so that about {} of memory are enough",
        both(peak)
    );
    Ok((photons < all).then_some(thinned))
}

/// About as many photons as fit into `limit`, at most those asked for, and the bytes that are then
/// needed.
///
/// # Errors
/// Where the fewest do not fit.
fn most_photons(scene: &Scene, limit: Limit, without: &Memory, program: u64) -> Result<(u64, u64)> {
    let all = scene.render.photons;
    let room = limit.bytes.saturating_sub(limit.bytes / (OFF + 1) + without.peak) as f64;
    let mut photons = all.min(FIRST);
    let mut fitting = None;
    for _ in 0..TRIES {
        let settings = RenderSettings { photons, ..scene.render };
        let needed = render::memory_needed(scene, &settings, program)?;
        let share = FILLED * room / (needed.peak - without.peak).max(1) as f64;
        // Lattices grow more slowly than photons do, so that more of these may be tried.
        let share = if share > 1.0 { share.powf(GROWTH) } else { share };
        let next = ((photons as f64 * share) as u64).clamp(FEWEST.min(all), all);
        if limit.leaves(needed.peak / OFF, needed.peak) {
            fitting = fitting.max(Some((photons, needed.peak)));
            if photons == all || next <= photons + photons / SLIGHT {
                break;
            }
        } else if photons <= FEWEST {
            // Nothing is left to thin.
            limit.holds(&needed.at_peak)?;
            fitting = fitting.max(Some((photons, needed.peak)));
            break;
        }
        photons = next;
    }
    match fitting {
        Some(fitting) => Ok(fitting),
        None => {
            let photons = FEWEST.min(all);
            let settings = RenderSettings { photons, ..scene.render };
            let needed = render::memory_needed(scene, &settings, program)?;
            limit.holds(&needed.at_peak).map(|()| (photons, needed.peak))
        }
    }
}

/// What `without` photons, which are gone by then, is needed while noise is taken off.
fn denoising(scene: &Scene, without: &Memory) -> MemoryParts {
    let film = without.kept.film + DENOISING * scene.window().pixels();
    MemoryParts { film, photons: 0, maps: 0, ..without.kept }
}

/// The bytes that a render may take.
#[derive(Debug, Clone, Copy)]
struct Limit {
    bytes: u64,
    /// Whether `--memory` says so, and not what the machine has free.
    is_asked: bool,
}

impl Limit {
    /// Whether `peak` fits and leaves `spare` bytes.
    const fn leaves(self, spare: u64, peak: u64) -> bool {
        peak.saturating_add(spare) <= self.bytes
    }

    /// Whether what is `needed` at one time fits.
    ///
    /// # Errors
    /// Where it does not: what is needed by what, what there is, and what would help.
    fn holds(self, needed: &MemoryParts) -> Result<()> {
        if needed.sum() <= self.bytes {
            return Ok(());
        }
        let parts = [
            ("program", needed.program, "a machine with more memory"),
            ("grids", needed.grids, "a coarser or cropped grid"),
            ("surfaces", needed.surfaces, "simpler meshes"),
            ("photons", needed.photons, "fewer --photons"),
            ("film", needed.film, "a smaller --size or --crop"),
            ("maps", needed.maps, "a lower --resolution of the director's maps"),
        ];
        let (_, _, remedy) = parts.into_iter().max_by_key(|part| part.1).unwrap_or(parts[0]);
        // Tenths are rounded once, so that the parts add up to the sum.
        let tenths = parts.map(|(_, bytes, _)| tenths(bytes));
        let list: Vec<_> = parts
            .iter()
            .zip(tenths)
            .filter(|(_, tenths)| *tenths > 0)
            .map(|((name, ..), tenths)| format!("{name} {}", mebibytes(tenths)))
            .collect();
        let (there, more) = if self.is_asked {
            (format!("--memory allows {}", both(self.bytes)), "a larger --memory")
        } else {
            (format!("{} are free", both(self.bytes)), "more free memory")
        };
        Err(Error::Failed(format!(
            "the render needs about {} MiB of memory ({} MiB), and {there}: give {remedy} or {more}",
            mebibytes(tenths.iter().sum()),
            list.join(" + "),
        )))
    }
}

/// Tenths of a MiB, rounded up.
fn tenths(bytes: u64) -> u64 {
    (10 * u128::from(bytes)).div_ceil(1 << 20) as u64
}

fn mebibytes(tenths: u64) -> String {
    format!("{}.{}", tenths / 10, tenths % 10)
}

/// A size in binary and in decimal units: whoever gives 130M finds it again.
fn both(bytes: u64) -> String {
    format!("{} ({})", ByteSize(bytes).display().iec(), ByteSize(bytes).display().si())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refusal_adds_up() {
        let needed = MemoryParts {
            program: 44_100_001,
            grids: 6_543_210,
            photons: 70 << 20,
            film: 12_345,
            ..MemoryParts::default()
        };
        let limit = |bytes| Limit { bytes, is_asked: true };
        assert!(limit(needed.sum()).holds(&needed).is_ok(), "it fits to the byte");
        let message = limit(130_000_000 - 6_000_000).holds(&needed).unwrap_err().to_string();
        let list = message.split_once('(').unwrap().1.split_once(" MiB)").unwrap().0;
        let numbers: Vec<f64> = list
            .split(" + ")
            .map(|part| part.rsplit_once(' ').unwrap().1.parse().unwrap())
            .collect();
        assert_eq!(numbers.len(), 4, "{message}");
        let sum = format!("about {:.1} MiB", numbers.iter().sum::<f64>());
        assert!(message.contains(&sum), "{message}");
        assert!(message.contains("118.3 MiB (124.0 MB)"), "{message}");
        assert!(message.contains("fewer --photons"), "{message}");
    }
}
