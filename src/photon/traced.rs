//! What photon paths left, before maps are made of it: in memory, and as bytes of a file.

use std::io;
use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::file::{self, Fill, Put};
use crate::math::{Spectrum, WorldPoint};
use crate::work::Work;

use super::path::{Deposits, Units};
use super::{PhotonAt, PhotonDirection, PhotonMaps};

/// Bytes of the index of a photon in a file.
///
/// Unit: bytes. Definition: 64 bits.
const INDEX_BYTES: usize = 8;

/// Some photon paths that stand for all of a render.
#[derive(Debug, Clone)]
pub struct PathSample {
    /// Seed of their random streams.
    pub seed: u64,
    /// Their indices.
    pub paths: Range<u64>,
    /// Number of paths of the render that each represents: its light counts as often, and kernels on
    /// surfaces are as narrow as they are for all paths.
    pub represents: f64,
    /// Levels of thinned volume photons beside the full one.
    pub levels: u32,
}

/// What some photon paths leave.
#[derive(Debug)]
pub struct ShotPart<S: Spectrum, H: PhotonDirection> {
    /// Their photons.
    pub maps: PhotonMaps<S, H>,
    /// The work of shooting them.
    pub work: Work,
    /// Gather radius in metres in media that is typical of all paths that they stand for.
    pub radius_of_all: f64,
}

/// Photons that some paths stored.
#[derive(Debug)]
pub struct TracedPhotons<S: Spectrum, H: PhotonDirection> {
    pub(super) deposits: Deposits<S, H>,
    /// What their positions are relative to.
    pub(super) origin: WorldPoint,
    pub(super) units: Units,
}

/// How many photons there are, and what their numbers mean.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TracedHead {
    /// Photons in media.
    volume: u64,
    /// Those of them that are independent of each other.
    independent: u64,
    /// Photons on surfaces.
    surface: u64,
    /// What positions are relative to, in world space, in metres.
    origin: [f64; 3],
    /// W m for which a volume photon of power 1 stands, and W for which one on a surface does.
    units: [f64; 2],
    /// The work of shooting them.
    pub work: Work,
}

impl TracedHead {
    /// Bytes of the photons in a file; `None` where the number overflows.
    pub fn bytes<S: Spectrum, H: PhotonDirection>(&self) -> Option<u64> {
        let volume = self.volume.checked_mul(PhotonAt::<S, H>::FILE_BYTES as u64)?;
        let surface = self.surface.checked_mul(PhotonAt::<S>::FILE_BYTES as u64)?;
        volume.checked_add(self.independent.checked_mul(INDEX_BYTES as u64)?)?.checked_add(surface)
    }

    /// What their positions are relative to, in world space.
    pub fn origin(&self) -> WorldPoint {
        WorldPoint::from_xyz(DVec3::from(self.origin))
    }

    /// W for which a flight of power 1 stands.
    pub const fn flight_unit(&self) -> f64 {
        self.units[1]
    }
}

impl<S: Spectrum, H: PhotonDirection> TracedPhotons<S, H> {
    /// The work of shooting them.
    pub const fn work(&self) -> &Work {
        &self.deposits.work
    }

    /// How many there are, and what their numbers mean.
    pub fn head(&self) -> TracedHead {
        let Deposits { volume, independent, surface, work, .. } = &self.deposits;
        TracedHead {
            volume: volume.len() as u64,
            independent: independent.len() as u64,
            surface: surface.len() as u64,
            origin: self.origin.xyz.to_array(),
            units: [self.units.volume, self.units.surface],
            work: *work,
        }
    }

    /// Writes them, as many bytes as their head tells.
    ///
    /// # Errors
    /// Where writing fails.
    pub fn write(&self, put: &mut Put<'_>) -> io::Result<()> {
        let Deposits { volume, independent, surface, .. } = &self.deposits;
        write_photons(volume, put)?;
        let write = |index: &usize, bytes: &mut [u8]| {
            bytes.copy_from_slice(&(*index as u64).to_le_bytes());
        };
        file::write_blocks(independent, INDEX_BYTES, write, put)?;
        write_photons(surface, put)
    }

    /// Reads those of this `head`.
    ///
    /// # Errors
    /// Where reading fails, or they cannot be those.
    pub fn read(head: &TracedHead, fill: &mut Fill<'_>) -> io::Result<Self> {
        let volume = read_photons(head.volume, fill)?;
        let mut independent = Vec::with_capacity(head.independent as usize);
        let mut bytes = [0; INDEX_BYTES];
        for _ in 0..head.independent {
            fill(&mut bytes)?;
            let index = u64::from_le_bytes(bytes);
            if index >= head.volume {
                return Err(io::Error::new(io::ErrorKind::InvalidData, "no such photon"));
            }
            independent.push(index as usize);
        }
        let surface = read_photons(head.surface, fill)?;
        let (tracks, work) = (Vec::new(), head.work);
        let [volume_unit, surface_unit] = head.units;
        Ok(Self {
            deposits: Deposits { volume, independent, surface, tracks, work },
            origin: head.origin(),
            units: Units { volume: volume_unit, surface: surface_unit },
        })
    }
}

fn write_photons<S: Spectrum, H: PhotonDirection>(
    photons: &[PhotonAt<S, H>],
    put: &mut Put<'_>,
) -> io::Result<()> {
    file::write_blocks(photons, PhotonAt::<S, H>::FILE_BYTES, PhotonAt::write, put)
}

fn read_photons<S: Spectrum, H: PhotonDirection>(
    count: u64,
    fill: &mut Fill<'_>,
) -> io::Result<Vec<PhotonAt<S, H>>> {
    let (size, count) = (PhotonAt::<S, H>::FILE_BYTES, count as usize);
    let mut photons = Vec::with_capacity(count);
    let take = |_, bytes: &[u8]| {
        photons.par_extend(bytes.par_chunks_exact(size).map(PhotonAt::read));
    };
    file::read_blocks(count, size, take, fill)?;
    Ok(photons)
}
