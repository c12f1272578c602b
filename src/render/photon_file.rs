//! Saved photons: what their paths left, in a file, from which renders make maps in place of shooting them.
//!
//! A [state file](super::state_file): its head is a key, the strategies, and how much follows. Its body is for each
//! part, which is all photons or a half of them: the photons in media, the indices of independent ones, the photons on
//! surfaces, and the sums of each medium's grid. Last, for one camera, come the [cells](super::cell_file) that it sees of
//! direct light and of the optical thickness to it, and where gathers start in those.
//!
//! Maps are made of the photons anew, since radii and trees follow from what the camera sees. Photons of one camera
//! are aimed at what it sees, and grids may hold what is scattered toward it: they serve all crops of its picture,
//! which have the bytes that they would have without the file. Photons for any camera are neither.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use crate::cache::{CellOrigins, FluenceBuilder, LazyCells};
use crate::error::{Error, Result};
use crate::file;
use crate::math::Spectrum;
use crate::photon::{
    MapLayout, PathSample, PhotonDirection, TracedHead, TracedPhotons, memory as photon_memory,
};
use crate::scene::plan::Needs;
use crate::scene::{Aov, PhotonsName, Planning, RenderSettings, Scene};
use crate::strategy::{Assignment, Choice};
use crate::work::Work;

use super::cell_file::{self, CellsHead};
use super::memory::{Memory, memory_with};
use super::pass_settings::PassSettings;
use super::planned_pass::{Flights, PlannedPass, Recorded};
use super::stage_settings::specialised;
use super::state_file::{FileKind, HASH, Hashing, Opened};

/// Saved photons, with name and version of their format.
const PHOTONS: FileKind = FileKind {
    magic: *b"fogbow ph 4\n",
    is_none: "is not a file of saved photons that can be read",
    remedy: "save them again by --photons-to, or leave out --photons-from",
    is_other: "holds the photons of another picture",
    other_remedy: "ask for the same, save photons for this one by --photons-to, or leave out --photons-from",
};

/// The head of a file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Head {
    /// Identifies the pictures that it serves.
    key: Map<String, Value>,
    /// Whether it serves any camera.
    any_camera: bool,
    /// Strategies of the media, and what was measured of them.
    strategies: Assignment,
    /// Estimated length of all flights through media together, in metres.
    flight_length: f64,
    /// Width in metres of the cells of each medium's grid.
    cell_widths: Vec<Option<f64>>,
    /// Whether grids hold light straight from the sky.
    records_sky: bool,
    /// Whether photons in media are stored.
    stores_photons: bool,
    /// Whether photons have three channels.
    colors: bool,
    /// Whether photons in media store their direction.
    directions: bool,
    parts: Vec<PartHead>,
    /// Cells of direct light and of optical thickness, of each medium that has any.
    cells: Vec<CellsHead>,
    /// Cells in which gathers start, of each medium that has any.
    origins: Vec<CellsHead>,
}

/// All photons, or a half of them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct PartHead {
    seed: u64,
    paths: Range<u64>,
    represents: f64,
    photons: TracedHead,
    /// Bytes of each medium's grid.
    grids: Vec<u64>,
}

impl Head {
    /// Bytes between head and hash; `None` where the number overflows.
    fn body(&self) -> Option<u64> {
        let parts = self.parts.iter().try_fold(0_u64, |sum, part| {
            let photons = specialised!(self, photon_bytes(&part.photons))?;
            let sum = sum.checked_add(photons)?;
            part.grids.iter().try_fold(sum, |sum, grid| sum.checked_add(*grid))
        });
        let mut cells = self.cells.iter().chain(&self.origins);
        cells.try_fold(parts?, |sum, cells| sum.checked_add(cells.bytes()?))
    }
}

fn photon_bytes<S: Spectrum, H: PhotonDirection>(photons: &TracedHead) -> Option<u64> {
    photons.bytes::<S, H>()
}

/// Photons to save, beside what their paths left.
#[derive(Debug, Clone, Copy)]
pub(super) struct PhotonsToSave<'a> {
    /// The scene that they were shot in, and its settings.
    pub scene: &'a Scene,
    /// Whether they serve any camera.
    pub any_camera: bool,
    /// The strategies of its media.
    pub strategies: &'a Assignment,
    /// How light in media is estimated by those.
    pub choice: &'a Choice,
    /// Estimated length of all flights through media together, in metres.
    pub flight_length: f64,
}

impl PhotonsToSave<'_> {
    /// Writes them with what was `recorded`, the `cells` that photons do not fill, and the `origins` of gathers that are kept
    /// of cells, to the file `path`, whole or not at all.
    ///
    /// # Errors
    /// Where that fails; an earlier file is intact then.
    pub fn write<S: Spectrum, H: PhotonDirection>(
        &self,
        recorded: &[Recorded<'_, S, H>],
        (cells, origins): (&[&LazyCells<S>], &[&CellOrigins<S>]),
        path: &Path,
    ) -> Result<()> {
        let Self { scene, any_camera, strategies, choice, flight_length } = *self;
        let part = |recorded: &Recorded<'_, S, H>| PartHead {
            seed: recorded.part.seed,
            paths: recorded.part.paths.clone(),
            represents: recorded.part.represents,
            photons: recorded.traced.head(),
            grids: grid_bytes(recorded),
        };
        let head = Head {
            key: key(scene, &scene.render, any_camera),
            any_camera,
            strategies: strategies.clone(),
            flight_length,
            cell_widths: choice.media.iter().map(|medium| medium.cell_width).collect(),
            records_sky: choice.records_sky,
            stores_photons: choice.stores_photons,
            colors: S::CHANNELS > 1,
            directions: H::KNOWN,
            parts: recorded.iter().map(part).collect(),
            cells: cells.iter().map(|cells| CellsHead::new(cells)).collect(),
            origins: origins.iter().map(|of| CellsHead::of_origins(of)).collect(),
        };
        file::write(path, |out| {
            PHOTONS.write(out, &head, |out| {
                for Recorded { traced, grids, .. } in recorded {
                    let put = &mut |bytes: &[u8]| out.put(bytes);
                    traced.write(put)?;
                    grids.iter().flatten().try_for_each(|grid| grid.write_state(put))?;
                }
                cells.iter().try_for_each(|cells| cell_file::write(out, cells))?;
                origins.iter().try_for_each(|of| cell_file::write_origins(out, of))
            })
        })
    }
}

/// Bytes of each medium's grid in a file; 0 where it has none.
fn grid_bytes<S: Spectrum, H: PhotonDirection>(recorded: &Recorded<'_, S, H>) -> Vec<u64> {
    let grids = recorded.grids.iter();
    grids.map(|grid| grid.as_ref().map_or(0, FluenceBuilder::state_bytes)).collect()
}

/// A file of saved photons, of which the head was read.
#[derive(Debug)]
pub struct SavedPhotons {
    path: PathBuf,
    head: Head,
    name: PhotonsName,
}

impl SavedPhotons {
    /// Opens the file `path`.
    ///
    /// # Errors
    /// Where it cannot be read, is damaged or none of saved photons, or those are of another picture than `scene`.
    pub fn open(path: &Path, scene: &Scene) -> Result<Self> {
        let Opened { head, .. } = PHOTONS.open(path, Head::body)?;
        PHOTONS.check_key(path, &head.key, &key(scene, &scene.render, head.any_camera))?;
        let needs = Needs::new(scene, &scene.render);
        if needs.parts {
            let (what, pass) = if scene.film.passes.has(Aov::Groups) {
                ("from which light they come", "groups")
            } else {
                ("how often they were scattered", "scattered")
            };
            return Err(Error::Usage(format!(
                "{}: saved photons do not tell {what}; leave {pass} out of the passes, or --photons-from",
                path.display()
            )));
        }
        if (head.colors, head.directions) != (needs.colors, needs.directions) {
            return Err(PHOTONS.damaged(path, "its photons are not as the scene needs them"));
        }
        let name = name(path).map_err(|e| PHOTONS.cut(path, &e))?;
        Ok(Self { path: path.to_path_buf(), head, name })
    }

    /// Their name, which tells them from others.
    pub const fn name(&self) -> PhotonsName {
        self.name
    }

    /// The strategies that they were shot for.
    pub const fn strategies(&self) -> &Assignment {
        &self.head.strategies
    }

    /// Whether they serve any camera.
    pub(super) const fn any_camera(&self) -> bool {
        self.head.any_camera
    }

    /// What is known of their flights.
    pub(super) fn flights(&self) -> Flights<'_> {
        Flights { length: self.head.flight_length, filled: Some(&self.head.cell_widths) }
    }

    /// Estimates the memory that rendering `scene` with them takes, as
    /// [`memory_needed`](super::memory_needed) does; without cells that rays fill.
    pub fn memory(&self, scene: &Scene, settings: &RenderSettings, program: u64) -> Memory {
        let parts = self.head.parts.iter();
        let work: Work = parts.clone().map(|part| part.photons.work).sum();
        let grids: u64 = parts.flat_map(|part| &part.grids).sum();
        let held = Work { tracks: 0, ..work };
        // Photons of all maps are read before the first is built.
        let photons =
            specialised!(self.head, photon_memory(&held, MapLayout::whole(), [2 * grids, 0], 0));
        memory_with(scene, settings, photons, program)
    }

    /// Reads what their paths left, for the pass that was `planned` by their strategies, whose other cells are filled where
    /// they are those of the file: the picture of other rays has others.
    ///
    /// # Errors
    /// Where they cannot be read or are damaged, or do not serve the camera of the scene.
    pub(super) fn read<'p, S: Spectrum, H: PhotonDirection>(
        &self,
        planned: &'p PlannedPass<'_, S>,
        settings: &PassSettings,
    ) -> Result<Vec<Recorded<'p, S, H>>> {
        self.check_use(&planned.choice)?;
        let Opened { mut input, head } = PHOTONS.open(&self.path, Head::body)?;
        if head != self.head {
            return Err(Error::file(&self.path, "changed while it was read; render again"));
        }
        let levels = settings.photons.levels;
        let read = |part: &PartHead| read_part(part, levels, planned, &mut input);
        let recorded: io::Result<Vec<_>> = head.parts.iter().map(read).collect();
        let recorded = recorded.map_err(|e| PHOTONS.cut(&self.path, &e))?;
        let cells_of = planned.camera_cells();
        let fits = head.cells.len() == cells_of.len()
            && head.cells.iter().zip(&cells_of).all(|(head, cells)| head.fits(cells));
        for (index, head) in head.cells.iter().enumerate() {
            let cells = cells_of.get(index).filter(|_| fits);
            let fill = |cell: usize, bits: &[u32]| {
                if let Some(cells) = cells {
                    cells.restore(cell, bits);
                }
            };
            head.read(&mut input, fill).map_err(|e| PHOTONS.cut(&self.path, &e))?;
        }
        let origins = head.origins.iter().map(|head| cell_file::read_origins(head, &mut input));
        let origins: io::Result<Vec<_>> = origins.collect();
        let origins = origins.map_err(|e| PHOTONS.cut(&self.path, &e))?;
        PHOTONS.check_hash(&self.path, &mut input)?;
        for (of, origins) in planned.origins().zip(origins).filter(|_| fits) {
            of.keep(origins);
        }
        Ok(recorded)
    }

    /// Refuses photons that leave out what `choice` reads.
    fn check_use(&self, choice: &Choice) -> Result<()> {
        let Head { records_sky, stores_photons, .. } = self.head;
        let has_all = stores_photons || !choice.stores_photons;
        if has_all && records_sky == choice.records_sky {
            return Ok(());
        }
        let problem = "was saved by a camera outside of the media or inside, and this one is not: rays here \
                       read other light; save photons by a camera like this one";
        Err(Error::file(&self.path, problem))
    }
}

/// Reads one part.
fn read_part<'p, S: Spectrum, H: PhotonDirection>(
    part: &PartHead,
    levels: u32,
    planned: &'p PlannedPass<'_, S>,
    input: &mut Hashing<BufReader<File>>,
) -> io::Result<Recorded<'p, S, H>> {
    let PartHead { seed, paths, represents, photons, grids } = part;
    let fill = &mut |bytes: &mut [u8]| input.fill(bytes);
    let paths = PathSample { seed: *seed, paths: paths.clone(), represents: *represents, levels };
    let mut recorded = Recorded {
        part: paths,
        traced: TracedPhotons::read(photons, fill)?,
        grids: planned.empty_grids(photons.origin()),
        flight_unit: photons.flight_unit(),
    };
    if grid_bytes(&recorded) != *grids {
        return Err(io::Error::new(io::ErrorKind::InvalidData, "other cells"));
    }
    recorded.grids.iter_mut().flatten().try_for_each(|grid| grid.read_state(fill))?;
    Ok(recorded)
}

/// The first bytes of the hash at the end of the file `path`.
fn name(path: &Path) -> io::Result<PhotonsName> {
    let mut file = File::open(path)?;
    file.seek(SeekFrom::End(-(HASH as i64)))?;
    let mut bytes = [0; 8];
    file.read_exact(&mut bytes)?;
    Ok(PhotonsName(bytes))
}

/// All that photons for the camera of `scene` depend on, in one line: pictures that differ in nothing of it may have the
/// same.
pub fn photons_key(scene: &Scene) -> String {
    Value::Object(key(scene, &scene.render, false)).to_string()
}

/// All that photons depend on, of a picture of `scene` under `settings`.
fn key(scene: &Scene, settings: &RenderSettings, any_camera: bool) -> Map<String, Value> {
    let camera = format!("{:?} {:?}", scene.camera, scene.film.size);
    let camera = blake3::hash(camera.as_bytes()).to_hex().to_string();
    let key = json!({
        "version": env!("CARGO_PKG_VERSION"),
        "light": scene.light_hash,
        "camera": if any_camera { "any".into() } else { camera },
        "photons": settings.photons,
        "seed": settings.seed,
        "radius": settings.radius,
        "max_scatter": settings.max_scatter,
        "strategy": settings.strategy.name(),
        "final_gather": settings.final_gather.name(),
        "halves": settings.in_halves(),
        "everything": settings.planning == Planning::Everything,
    });
    match key {
        Value::Object(key) => key,
        _ => Map::new(),
    }
}
