//! Procedural volumes and a statue to stand in them, so that nothing must be downloaded to see
//! something.
//!
//! The same arguments give the same values on any number of threads. Each kind is a function of
//! space in units of its longest side, with y up from the ground.

mod cloud;
mod fire;
mod fog;
mod noise;
mod plume;
mod sparse;
mod statue;
mod surface;

use glam::DVec3;

use crate::error::{Error, Result};
use crate::shape::MeshData;
use crate::vdb::GridToWrite;
use cloud::Cloud;
use fire::Fire;
use fog::Fog;
use plume::Plume;
use sparse::{Domain, fill};
use statue::Statue;
use surface::surface;

/// The most voxels along the longest side.
pub const MAX_RESOLUTION: u32 = 4096;

/// The most voxels along the height of the statue: its grid is held whole.
pub const MAX_STATUE_RESOLUTION: u32 = 1024;

/// Height of the statue in metres where no voxel size is given.
pub const STATUE_HEIGHT: f64 = 2.0;

/// What volume can be made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A turbulent plume over a small source; grid `density`.
    Smoke,
    /// A cumulus with a flat base; grid `density`.
    Cloud,
    /// A layer of fog on the ground, in banks; grid `density`.
    Fog,
    /// A campfire with its smoke; grids `density` and `temperature`, which is 1 in the core: 1500 to
    /// 2000 kelvin for one unit give a flame.
    Fire,
}

impl Kind {
    /// Length of the longest side in metres where no voxel size is given.
    pub const fn natural_size(self) -> f64 {
        match self {
            Self::Smoke => 4.0,
            Self::Cloud => 800.0,
            Self::Fog => 80.0,
            Self::Fire => 2.0,
        }
    }

    /// Sides of the box that the volume fills; the longest is 1.
    pub const fn proportions(self) -> DVec3 {
        match self {
            Self::Smoke => DVec3::new(0.55, 1.0, 0.55),
            Self::Cloud => DVec3::new(1.0, 0.6, 0.8),
            Self::Fog => DVec3::new(1.0, fog::HEIGHT, 1.0),
            Self::Fire => DVec3::new(0.5, 1.0, 0.5),
        }
    }
}

/// How a volume or the statue is made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Chooses one of many alike.
    pub seed: u64,
    /// Voxels along the longest side, from 1 to [`MAX_RESOLUTION`], or [`MAX_STATUE_RESOLUTION`].
    pub resolution: u32,
    /// Edge of a voxel in metres; `None` for the kind's [natural size](Kind::natural_size),
    /// or [`STATUE_HEIGHT`].
    pub voxel: Option<f64>,
}

impl Settings {
    /// Edge of a voxel in metres, where `longest` is the natural length of the longest side.
    fn checked_voxel(&self, longest: f64, max_resolution: u32) -> Result<f64> {
        let resolution = self.resolution;
        if !(1..=max_resolution).contains(&resolution) {
            return Err(Error::Usage(format!(
                "--resolution {resolution}: give 1 to {max_resolution} voxels"
            )));
        }
        let voxel = self.voxel.unwrap_or(longest / f64::from(resolution));
        if !(voxel > 0.0 && voxel.is_finite()) {
            return Err(Error::Usage(format!(
                "--voxel {voxel}: give a positive edge length in metres"
            )));
        }
        Ok(voxel)
    }
}

/// Makes the grids of a `kind` of volume, each with values in [0, 1] and a maximum of 1, stored in
/// 16 bits, background 0.
///
/// The volume stands on y = 0 and the y axis runs through the middle of its floor; voxel (i, j, k)
/// has its sample at (i, j, k) times the voxel size in the world.
///
/// # Errors
/// Where the resolution is 0 or beyond [`MAX_RESOLUTION`], or the voxel size is not positive.
pub fn make(kind: Kind, settings: &Settings) -> Result<Vec<GridToWrite>> {
    let Settings { seed, resolution, .. } = *settings;
    let voxel = settings.checked_voxel(kind.natural_size(), MAX_RESOLUTION)?;
    let domain = Domain::standing(kind.proportions(), resolution);
    let detail = f64::from(resolution);
    let grid = |name: &str, blocks| GridToWrite {
        half: true,
        blocks,
        ..GridToWrite::fog(name, voxel, DVec3::ZERO)
    };
    Ok(match kind {
        Kind::Smoke => {
            let plume = Plume::on_ground(seed, detail);
            let [blocks] = fill(domain, |p| [plume.density(p)]);
            vec![grid("density", blocks)]
        }
        Kind::Cloud => {
            let cloud = Cloud::new(seed, detail);
            let [blocks] = fill(domain, |p| [cloud.density(p)]);
            vec![grid("density", blocks)]
        }
        Kind::Fog => {
            let fog = Fog::new(seed, detail);
            let [blocks] = fill(domain, |p| [fog.density(p)]);
            vec![grid("density", blocks)]
        }
        Kind::Fire => {
            let fire = Fire::new(seed, detail);
            let [density, temperature] = fill(domain, |p| fire.density_and_temperature(p));
            vec![grid("density", density), grid("temperature", temperature)]
        }
    })
}

/// Makes the statue: a winged figure that holds up a torch, facing +z, as a closed mesh with
/// normals in metres. It stands on y = 0 and the y axis runs through its pedestal. The seed chooses
/// the folds of the robe.
///
/// # Errors
/// Where the resolution is 0 or beyond [`MAX_STATUE_RESOLUTION`], the voxel size is not positive, or
/// the voxels are too large for anything to show.
pub fn make_statue(settings: &Settings) -> Result<MeshData> {
    let voxel = settings.checked_voxel(STATUE_HEIGHT, MAX_STATUE_RESOLUTION)?;
    let proportions = DVec3::new(2.0 * statue::HALF_WIDTH, 1.0, 2.0 * statue::HALF_DEPTH);
    let domain = Domain::standing(proportions, settings.resolution);
    let statue = Statue::new(settings.seed);
    let mesh = surface(domain, voxel * f64::from(settings.resolution), |p| statue.distance(p));
    if mesh.triangles.is_empty() {
        return Err(Error::Usage(format!(
            "--resolution {}: too coarse for a statue; give 32 or more",
            settings.resolution
        )));
    }
    Ok(mesh)
}
