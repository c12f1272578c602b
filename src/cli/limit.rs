//! Renders that fit the memory there is.

use bytesize::ByteSize;

use super::header::Method;
use super::memory;
use crate::error::{Error, Result};
use crate::render::{self, Memory};
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

/// One part in so many by which an estimate may be too low.
const OFF: u64 = 8;

/// Bytes a pixel that taking off noise needs beside the film.
const DENOISING: u64 = 700;

/// Bytes that may come on top of it: what the look at the photons leaves behind.
const SPARE: u64 = 64 << 20;

/// Bytes in memory before anything is loaded.
pub(super) fn program() -> u64 {
    memory::resident().unwrap_or(PROGRAM)
}

/// Sees to it that rendering `scene` takes at most `asked` bytes, and asks for fewer photons where
/// it must; then a sentence says so. Where nothing is asked it must fit what the machine has free.
/// Where that is close a few photons are shot to see: their work is not counted, so that a picture
/// does not tell how much memory was free.
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
    let Some(limit) = asked.or_else(free) else { return Ok(None) };
    let without = render::memory_without_photons(scene, &scene.render, program);
    if !fits(&without, limit) {
        return Err(refusal(&without, &without, limit, asked.is_some()));
    }
    if scene.render.denoise {
        let denoising = denoising(scene, without);
        if !fits(&denoising, limit) {
            return Err(refusal(&denoising, &denoising, limit, asked.is_some()));
        }
    }
    let lattices = LATTICES.saturating_mul(scene.media.len() as u64);
    let most = scene.render.photons.saturating_mul(PHOTON).saturating_add(lattices);
    if method.reference || without.peak.saturating_add(most) <= limit {
        return Ok(None);
    }
    let all = scene.render.photons;
    if asked.is_none() {
        let needed = render::memory_needed(scene, &scene.render, program)?;
        return if fits(&needed, limit) {
            Ok(None)
        } else {
            Err(refusal(&needed, &without, limit, false))
        };
    }
    let (photons, peak) = most_photons(scene, limit, &without, program)?;
    scene.render.photons = photons;
    let thinned = format!(
        "{photons} photons instead of {all}, so that about {} of memory are enough",
        show(peak)
    );
    Ok((photons < all).then_some(thinned))
}

/// About as many photons as fit into `limit` bytes, at most those asked for, and the bytes that are
/// then needed.
///
/// # Errors
/// Where the fewest do not fit.
fn most_photons(scene: &Scene, limit: u64, without: &Memory, program: u64) -> Result<(u64, u64)> {
    let all = scene.render.photons;
    let room = limit.saturating_sub(SPARE + limit / OFF + without.peak) as f64;
    let mut photons = all.min(FIRST);
    let mut fitting = None;
    let mut refused = *without;
    for _ in 0..TRIES {
        let settings = RenderSettings { photons, ..scene.render };
        let needed = render::memory_needed(scene, &settings, program)?;
        let share = FILLED * room / (needed.peak - without.peak).max(1) as f64;
        // Lattices grow more slowly than photons do, so that more of these may be tried.
        let share = if share > 1.0 { share.powf(GROWTH) } else { share };
        let next = ((photons as f64 * share) as u64).clamp(FEWEST.min(all), all);
        if fits(&needed, limit) {
            fitting = fitting.max(Some((photons, needed.peak)));
            if photons == all || next <= photons + photons / SLIGHT {
                break;
            }
        } else {
            refused = needed;
            if photons <= FEWEST {
                break;
            }
        }
        photons = next;
    }
    fitting.ok_or_else(|| refusal(&refused, without, limit, true))
}

/// What `without` photons, which are gone by then, is needed while noise is taken off.
fn denoising(scene: &Scene, without: Memory) -> Memory {
    let film = without.film + DENOISING * scene.window().pixels();
    let peak = without.program + without.grids + without.surfaces + film;
    Memory { film, peak: peak.max(without.peak), ..without }
}

/// Whether so much is there, even if somewhat more is needed than was estimated.
fn fits(needed: &Memory, limit: u64) -> bool {
    needed.peak.saturating_add(needed.peak / OFF).saturating_add(SPARE) <= limit
}

/// What is needed, what takes most, what there is, and what would help.
fn refusal(needed: &Memory, without: &Memory, limit: u64, is_asked: bool) -> Error {
    let parts = [
        ("photons", needed.peak - without.peak, "fewer --photons"),
        ("the film", needed.film.max(needed.writing) + needed.maps, "a smaller --size or --crop"),
        ("grids", needed.grids, "a coarser or cropped grid"),
        ("surfaces", needed.surfaces, "simpler meshes"),
        ("the program", needed.program, "a machine with more memory"),
    ];
    let (name, bytes, remedy) = parts.into_iter().max_by_key(|part| part.1).unwrap_or(parts[0]);
    let (there, more) = if is_asked {
        (format!("--memory allows {}", show(limit)), "a larger --memory")
    } else {
        (format!("{} are free", show(limit)), "more free memory")
    };
    Error::Failed(format!(
        "the render needs about {} of memory, {} of them for {name}, and some to spare; {there}: \
         give {remedy} or {more}",
        show(needed.peak),
        show(bytes),
    ))
}

fn show(bytes: u64) -> String {
    ByteSize(bytes).to_string()
}
