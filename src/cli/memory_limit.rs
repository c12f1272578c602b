//! The memory limit: photons are reduced until a render fits, or it is refused.

use bytesize::ByteSize;

use super::header::Method;
use super::memory;
use crate::error::{Error, Result};
use crate::render::{self, Memory, MemoryParts, SavedPhotons};
use crate::scene::{RenderSettings, Scene};

/// Bytes of the program and its libraries where the system does not tell.
const PROGRAM: u64 = 36 << 20;

/// Upper bound of the bytes of a photon path, which leaves several photons in thick media.
const PATH_BYTES: u64 = 4096;

/// Upper bound of the bytes of a medium's caches: for direct light, final gathers and fluence, the last
/// twice while they are built, each of up to 256 MiB a channel and a table of 200 MB.
const CACHE_BYTES: u64 = 5 << 30;

/// Photon paths below which their number is not reduced: so few are noise.
const MIN_PATHS: u64 = 1000;

/// Photon paths of the first try: an estimate for many takes much memory itself.
const FIRST_TRY: u64 = 20_000;

/// Exponent by which photon paths grow with the memory of the fluence cache: the edge of its cells goes
/// with the -1/5th power of the number of paths.
const CACHE_EXPONENT: f64 = 5.0 / 3.0;

/// Share, as its inverse, by which the next try must have more photons to be worth it.
const WORTH_TRYING: u64 = 8;

/// Most numbers of photons that are tried.
const TRIES: usize = 6;

/// Share of the memory left for photons that the next try aims at.
const FILL: f64 = 0.9;

/// Share, as its inverse, by which an estimate may be too low. Photons are reduced until so much memory is
/// left over.
const MARGIN: u64 = 16;

/// Bytes of a pixel that denoising takes beside the film.
const DENOISING: u64 = 700;

/// Bytes in memory before anything is loaded.
pub(super) fn program() -> u64 {
    memory::resident().unwrap_or(PROGRAM)
}

/// Reduces the photons of `scene` until rendering it takes at most `limit` bytes, and returns a warning
/// where it did. Without a limit the render must fit into the machine's free memory as it is.
///
/// Where a bound does not settle it, the memory is estimated from a few photons; their work is not
/// counted, so that a picture does not depend on how much memory was free. A render is refused only where
/// the estimate itself exceeds the limit. The program took `program` bytes before the scene was loaded.
///
/// # Errors
/// Where it does not fit.
pub(super) fn fit_photons(
    scene: &mut Scene,
    limit: Option<u64>,
    method: Method,
    program: u64,
) -> Result<Option<String>> {
    let Some(limit) = Limit::new(limit) else { return Ok(None) };
    let Limit { bytes, is_given } = limit;
    let without = render::memory_without_photons(scene, &scene.render, program);
    limit.holds(&without.at_peak)?;
    if scene.render.denoise {
        limit.holds(&denoising(scene, &without))?;
    }
    let caches = CACHE_BYTES.saturating_mul(scene.media.len() as u64);
    let most = scene.render.path_count().saturating_mul(PATH_BYTES).saturating_add(caches);
    if method.reference || without.peak.saturating_add(most) <= bytes {
        return Ok(None);
    }
    if !is_given {
        let needed = render::memory_needed(scene, &scene.render, program)?;
        return limit.holds(&needed.at_peak).map(|()| None);
    }
    let all = scene.render.photons;
    let (photons, peak) = most_photons(scene, limit, &without, program)?;
    scene.render.photons = photons;
    let warning = format!(
        "{photons} photons instead of {all}, so that about {} of memory are enough",
        both(peak)
    );
    Ok((photons < all).then_some(warning))
}

/// Checks that a render of `scene` with `saved` photons fits into `limit`, or without one into the machine's free memory.
/// The program took `program` bytes before the scene was loaded.
///
/// # Errors
/// Where it does not fit.
pub(super) fn hold_saved(
    scene: &Scene,
    saved: &SavedPhotons,
    limit: Option<u64>,
    program: u64,
) -> Result<()> {
    let Some(limit) = Limit::new(limit) else { return Ok(()) };
    limit.holds(&saved.memory(scene, &scene.render, program).at_peak)
}

/// The number of photons that fits into `limit`, at most as many as `scene` has, and the bytes that the
/// render then needs.
///
/// # Errors
/// Where the fewest do not fit.
fn most_photons(scene: &Scene, limit: Limit, without: &Memory, program: u64) -> Result<(u64, u64)> {
    let all = scene.render.photons;
    let room = limit.bytes.saturating_sub(limit.bytes / (MARGIN + 1) + without.peak) as f64;
    let mut photons = all.min(FIRST_TRY);
    let mut fitting = None;
    for _ in 0..TRIES {
        let settings = RenderSettings { photons, ..scene.render };
        let needed = render::memory_needed(scene, &settings, program)?;
        let share = FILL * room / (needed.peak - without.peak).max(1) as f64;
        // Caches grow more slowly than photons do, so more of these may fit.
        let share = if share > 1.0 { share.powf(CACHE_EXPONENT) } else { share };
        let next = ((photons as f64 * share) as u64).clamp(MIN_PATHS.min(all), all);
        // Where all but a few may fit, all are tried.
        let next = if next > photons && all - next <= next / WORTH_TRYING { all } else { next };
        if limit.leaves(needed.peak / MARGIN, needed.peak) {
            fitting = fitting.max(Some((photons, needed.peak)));
            if photons == all || next <= photons + photons / WORTH_TRYING {
                break;
            }
        } else if photons <= MIN_PATHS {
            // No further reduction is possible.
            limit.holds(&needed.at_peak)?;
            fitting = fitting.max(Some((photons, needed.peak)));
            break;
        }
        photons = next;
    }
    match fitting {
        Some(fitting) => Ok(fitting),
        None => {
            let photons = MIN_PATHS.min(all);
            let settings = RenderSettings { photons, ..scene.render };
            let needed = render::memory_needed(scene, &settings, program)?;
            limit.holds(&needed.at_peak).map(|()| (photons, needed.peak))
        }
    }
}

/// Memory in use while the picture is denoised: photons and maps are freed by then.
fn denoising(scene: &Scene, without: &Memory) -> MemoryParts {
    let film = without.kept.film + DENOISING * scene.window().pixels();
    MemoryParts { film, photons: 0, maps: 0, ..without.kept }
}

/// The bytes that a render may take.
#[derive(Debug, Clone, Copy)]
struct Limit {
    bytes: u64,
    /// Whether `--memory` gave it, and not the machine's free memory.
    is_given: bool,
}

impl Limit {
    /// The one that is given, else the free memory of the machine; `None` where the system does not tell that.
    fn new(given: Option<u64>) -> Option<Self> {
        let free = || memory::available().map(|free| free + memory::resident().unwrap_or(0));
        given.or_else(free).map(|bytes| Self { bytes, is_given: given.is_some() })
    }

    /// Whether `peak` fits and leaves `spare` bytes.
    const fn leaves(self, spare: u64, peak: u64) -> bool {
        peak.saturating_add(spare) <= self.bytes
    }

    /// Checks that the parts `needed` at one time fit.
    ///
    /// # Errors
    /// Where they do not; it names the parts, the limit and what would help.
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
        let (there, more) = if self.is_given {
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

/// A size in binary and in decimal units, so that a `--memory 130M` is recognised.
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
        let limit = |bytes| Limit { bytes, is_given: true };
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
