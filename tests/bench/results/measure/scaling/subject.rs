//! The scenes that are measured, and how they are made for a setting.

use std::path::{Path, PathBuf};

use fogbow::make::{self, Kind};
use fogbow::render::{Silent, render};
use fogbow::scene::{LoadOptions, Scene};
use fogbow::vdb;

use super::axis::Axis;
use crate::pages::Result;

/// A scene of `volumes/`.
pub struct Subject {
    pub name: &'static str,
    /// What its voxels are made as, where it has some.
    kind: Option<Kind>,
}

/// Smoke keeps light on a lattice, the cloud is thick, and the road is seen from inside its fog.
pub const SUBJECTS: [Subject; 3] = [
    Subject { name: "smoke", kind: Some(Kind::Smoke) },
    Subject { name: "cloud", kind: Some(Kind::Cloud) },
    Subject { name: "road", kind: None },
];

/// How a scene is rendered.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    photons: u64,
    /// Pixels along both sides.
    side: u32,
    rays: u32,
    /// Voxels in place of the scene's own.
    voxels: Option<PathBuf>,
    /// Times the scene's own extinction.
    thicker: f64,
}

/// Settings, each with what stands on the axis.
pub type Sweep = Vec<(f64, Settings)>;

/// What all sweeps start from.
const BASE: Settings = Settings { photons: 50_000, side: 96, rays: 2, voxels: None, thicker: 1.0 };

/// Share of the scene's own extinction at which its thickness is seen.
const THIN: f64 = 1.0 / 64.0;

impl Subject {
    /// The settings of a sweep; nothing where there is nothing to vary. Files that they need go to
    /// `folder`.
    pub fn sweep(&self, axis: Axis, quick: bool, folder: &Path) -> Result<Option<Sweep>> {
        let thickness = if axis == Axis::Thickness { self.thickness(folder)? } else { 1.0 };
        let mut sweep = Vec::new();
        for value in axis.values(quick) {
            let whole = value.round() as u32;
            sweep.push(match axis {
                Axis::Photons => (value, Settings { photons: value as u64, ..BASE }),
                Axis::Pixels => {
                    let side = value.sqrt().round() as u32;
                    (f64::from(side * side), Settings { side, ..BASE })
                }
                Axis::Rays => (f64::from(whole), Settings { rays: whole, ..BASE }),
                Axis::Voxels => {
                    let Some(kind) = self.kind else { return Ok(None) };
                    let (path, count) = make(kind, whole, folder)?;
                    (count, Settings { voxels: Some(path), ..BASE })
                }
                Axis::Thickness => (value * thickness, Settings { thicker: value, ..BASE }),
            });
        }
        Ok(Some(sweep))
    }

    /// The scene under `settings`; its file goes to `folder`.
    pub fn scene(&self, settings: &Settings, folder: &Path) -> Result<Scene> {
        let volumes = Path::new(env!("CARGO_MANIFEST_DIR")).join("volumes");
        let text = std::fs::read_to_string(volumes.join(self.name).with_extension("toml"))?;
        let mut scene: toml::Table = text.parse()?;
        let medium =
            scene.get_mut("medium").and_then(|media| media.get_mut(0)).ok_or("a medium")?;
        let sigma_t = medium.get("sigma_t").and_then(toml::Value::as_float).ok_or("sigma_t")?;
        let medium = medium.as_table_mut().ok_or("a table")?;
        medium.insert("sigma_t".into(), (sigma_t * settings.thicker).into());
        if let Some(own) = medium.get("file").and_then(toml::Value::as_str) {
            let file = settings.voxels.clone().unwrap_or_else(|| volumes.join(own));
            medium.insert("file".into(), file.display().to_string().into());
        }
        let path = folder.join("scene.toml");
        std::fs::write(&path, scene.to_string())?;
        let options = LoadOptions::default().size([settings.side; 2]);
        Ok(Scene::load(&path, &options.rays(settings.rays).photons(settings.photons))?)
    }

    /// The optical thickness that the camera sees of the medium, in the mean over the pixels that
    /// see any.
    fn thickness(&self, folder: &Path) -> Result<f64> {
        let settings = Settings { photons: 1000, rays: 4, thicker: THIN, ..BASE };
        let scene = self.scene(&settings, folder)?;
        let rendered = render(&scene, &scene.render, &Silent)?;
        let transmittance = rendered.film.layer("transmittance").ok_or("transmittance")?;
        let thick = transmittance.iter().map(|t| -f64::from(*t).ln()).filter(|tau| *tau > 1e-5);
        let (sum, count) = thick.fold((0.0, 0.0), |(sum, count), tau| (sum + tau, count + 1.0));
        Ok(sum / count / THIN)
    }
}

/// Voxels of this `kind`, so many along the longest side, all in the same metres: the file, and how
/// many of them hold anything.
fn make(kind: Kind, resolution: u32, folder: &Path) -> Result<(PathBuf, f64)> {
    let grids = make::make(kind, &make::Settings { seed: 1, resolution, voxel: None })?;
    let values = grids.iter().flat_map(|grid| &grid.blocks).flat_map(|block| &block.values);
    let count = values.filter(|value| **value != 0.0).count();
    let path = folder.join(format!("{kind:?}{resolution}.vdb"));
    vdb::write(&path, &grids)?;
    Ok((path, count as f64))
}
