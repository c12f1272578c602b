//! A scene for a VDB file alone, or a sequence of them: framed, lit, of a visible thickness, at any
//! scale of the world.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;

use super::camera::{Camera, Pose, Projection};
use super::hash::Sources;
use super::load::bad_values;
use super::{FilmSettings, LoadOptions, RenderSettings, Scene};
use crate::error::{Error, Result};
use crate::light::{Environment, Light, Lights, Sun};
use crate::math::{Aabb, IndexPoint, Ray, Rgb, Span, World, WorldPoint, luminance};
use crate::medium::blackbody::{Blackbody, blackbody_radiance};
use crate::medium::{Albedo, Density, Emission, Media, Medium, Phase};
use crate::surface::Surfaces;
use crate::vdb::{Grid, ReadAs, VdbFile};

/// Full angle of view across the width, in degrees.
const FOV: f64 = 35.0;
/// Share of the picture that the asset may fill.
const FILL: f64 = 0.8;
/// From the asset toward the camera: three quarters, from a little above.
const TOWARD_CAMERA: DVec3 = DVec3::new(0.55, 0.3, 1.0);
/// Travel of the key light in the camera's (right, up, forward): from the upper left, in front.
const KEY_TRAVEL: DVec3 = DVec3::new(0.7, -0.8, 0.6);
/// Irradiance of the key light, W/m².
const KEY: f64 = 5.0;
/// Angular diameter of the key light, in degrees.
const KEY_DIAMETER: f64 = 2.0;
/// Radiance of the sky, W/(m² sr).
const SKY: Rgb = Rgb::new(0.06, 0.08, 0.11);
/// Optical thickness along the densest axis, mean over the rays that meet anything.
const THICKNESS: f64 = 6.0;
/// Albedo of smoke that is to look white.
const ALBEDO: f64 = 0.95;
/// Rays along each side of a face that measure the thickness.
const PROBES: u32 = 48;
/// Temperature of the hottest voxel where a grid does not hold kelvin.
const HOTTEST: f64 = 1900.0;
/// A grid whose largest value is below this does not hold kelvin.
const COLDEST_KELVIN: f64 = 100.0;
/// Radiance that a thick part of the hottest voxels would have: brighter than the key makes smoke.
const GLOW: f64 = 10.0;
/// Kelvin where a normalised temperature is 0: too cold to glow.
const COLD: f64 = 300.0;

/// How a bare volume is seen: what is chosen for one and may hold for a sequence of them.
#[derive(Debug)]
pub(super) struct Look {
    /// The file it was chosen for.
    path: PathBuf,
    pose: Pose,
    /// 1/m for density 1.
    sigma_t: f64,
    glow: Option<Glow>,
    notes: Vec<String>,
}

/// What glows, as a blackbody.
#[derive(Debug)]
struct Glow {
    grid: &'static str,
    kelvin_scale: f64,
    kelvin_offset: f64,
    scale: f64,
}

/// A file with its density.
struct Volume {
    file: VdbFile,
    grid: Grid<f32>,
    label: String,
}

/// The scene of the VDB file `path`.
pub(super) fn load(path: &Path, options: &LoadOptions) -> Result<Scene> {
    let volume = Volume::read(path, options)?;
    let look = Look::of(&volume, options)?;
    scene(volume, &look, options)
}

/// The scene of the VDB file `path`, which may be empty, seen as `look` says.
pub(super) fn load_like(path: &Path, look: &Look, options: &LoadOptions) -> Result<Scene> {
    scene(Volume::read(path, options)?, look, options)
}

impl Volume {
    fn read(path: &Path, options: &LoadOptions) -> Result<Self> {
        let file = VdbFile::open(path)?.within(options.memory);
        let index = density_index(&file, options.level_set_as_fog)?;
        let read_as =
            if options.level_set_as_fog { ReadAs::LevelSetAsFog } else { ReadAs::Density };
        let grid = file.read_scalar(index, read_as)?;
        let label = file.grids()[index].label();
        Ok(Self { file, grid, label })
    }
}

impl Look {
    /// What suits the VDB file `path`.
    ///
    /// # Errors
    /// Where it cannot be read, or there is nothing to see in it.
    pub(super) fn at(path: &Path, options: &LoadOptions) -> Result<Self> {
        Self::of(&Volume::read(path, options)?, options)
    }

    fn of(volume: &Volume, options: &LoadOptions) -> Result<Self> {
        let Volume { file, grid, label } = volume;
        let path = file.path();
        let empty = || {
            Error::grid(
                path,
                label,
                "has no density above 0 to render; give another file, or name another grid in a \
                 scene",
            )
        };
        let bounds = world_bounds(grid).ok_or_else(empty)?;
        let thickness = mean_thickness(grid, &bounds);
        if !(thickness > 0.0 && thickness.is_finite()) {
            return Err(empty());
        }
        let sigma_t = THICKNESS / thickness;
        let size = FilmSettings::default().overridden(&options.overrides).size;
        let pose = framed(&bounds, size);
        let mut notes = vec![format!(
            "{}: grid \"{label}\", sigma_t = {sigma_t:.4} 1/m for density 1, so that the optical \
             thickness is about {THICKNESS}; albedo {ALBEDO}, y up; camera at {:.4}",
            path.display(),
            pose.position
        )];
        let glow = glow(file, &mut notes)?;
        Ok(Self { path: path.to_path_buf(), pose, sigma_t, glow, notes })
    }
}

fn scene(volume: Volume, look: &Look, options: &LoadOptions) -> Result<Scene> {
    let Volume { file, grid, label } = volume;
    let path = file.path();
    let mut warnings: Vec<_> = bad_values(path, &label, &grid, "taken as 0").into_iter().collect();
    let emission = match &look.glow {
        Some(glow) => emission(glow, &file, &mut warnings)?,
        None => None,
    };
    let medium = Medium {
        density: Density::Voxel(grid),
        sigma_t: Rgb::splat(look.sigma_t),
        albedo: Albedo::Constant(Rgb::splat(ALBEDO)),
        phase: Phase::ISOTROPIC,
        emission,
    };
    let place = |problem: String| Error::file(path, problem);
    let film = FilmSettings::default().overridden(&options.overrides);
    let projection = Projection::Perspective { fov: FOV, aperture: 0.0, focus: None };
    let camera = Camera::new(&look.pose, &projection, film.size)
        .ok_or_else(|| place("is placed where no camera can look at it".into()))?;
    let mut sources = Sources::default();
    sources.add(path);
    sources.add(&look.path);
    Ok(Scene {
        camera,
        media: Media::new(vec![medium]),
        surfaces: Arc::new(Surfaces::new(Vec::new())),
        lights: Arc::new(Lights { lights: lights(&look.pose).map_err(place)? }),
        film,
        render: RenderSettings {
            planning: options.planning,
            ..RenderSettings::default().overridden(&options.overrides)
        },
        path: path.to_path_buf(),
        hash: sources.hash("")?,
        still: Sources::default().hash(&format!("{camera:?} {:?}", film.size))?,
        unseen: None,
        warnings,
        notes: look.notes.clone(),
    })
}

/// The default density, or with `as_fog` the only level set where there is no density.
fn density_index(file: &VdbFile, as_fog: bool) -> Result<usize> {
    let problem = match file.default_density() {
        Ok(index) => return Ok(index),
        Err(problem) => problem,
    };
    let grids = file.grids().iter().enumerate();
    let level_sets: Vec<_> =
        grids.filter(|(_, g)| g.is_level_set() && g.is_scalar()).map(|(i, _)| i).collect();
    match level_sets[..] {
        [only] if as_fog => Ok(only),
        [only] => Err(Error::grid(
            file.path(),
            file.grids()[only].label(),
            "is a level set, the distance to a surface and no density; --level-set fog, in a scene \
             level_set = \"fog\", turns it into a fog volume",
        )),
        _ => Err(problem),
    }
}

/// The world box round the active voxels, half a voxel more on each side.
fn world_bounds(grid: &Grid<f32>) -> Option<Aabb<World>> {
    let [min, max] = grid.statistics().bounds?;
    let corner = |p: [i32; 3]| IndexPoint::from_xyz(DVec3::from(p.map(f64::from)));
    let bounds = grid.transform().box_to_world(&Aabb::new(corner(min), corner(max)).grown(0.5));
    let sound = bounds.min.xyz.is_finite() && bounds.max.xyz.is_finite();
    (sound && grid.max_value() > 0.0).then_some(bounds)
}

/// The integral of density, in metres, along the axis where it is largest: mean over a raster of
/// rays, those that meet nothing left out.
fn mean_thickness(grid: &Grid<f32>, bounds: &Aabb<World>) -> f64 {
    (0..3).map(|axis| mean_along(grid, bounds, axis)).fold(0.0, f64::max)
}

fn mean_along(grid: &Grid<f32>, bounds: &Aabb<World>, axis: usize) -> f64 {
    let size = bounds.size();
    let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
    let (mut sum, mut hits) = (0.0, 0u32);
    for i in 0..PROBES * PROBES {
        let share = |k: u32| (f64::from(k) + 0.5) / f64::from(PROBES);
        let mut origin = bounds.min.xyz;
        origin[u] += share(i % PROBES) * size[u];
        origin[v] += share(i / PROBES) * size[v];
        let ray = Ray::new(WorldPoint::from_xyz(origin), DVec3::AXES[axis]);
        let local = grid.transform().ray_to_local(&ray);
        let thickness = grid.integrate(&local, Span::new(0.0, size[axis]));
        if thickness > 0.0 {
            sum += thickness;
            hits += 1;
        }
    }
    if hits == 0 { 0.0 } else { sum / f64::from(hits) }
}

/// A view of the box from which its corners stay within [`FILL`] of a picture of `size`.
fn framed(bounds: &Aabb<World>, size: [u32; 2]) -> Pose {
    let target = bounds.center().xyz;
    let toward = TOWARD_CAMERA.normalize();
    let pose = |distance: f64| Pose { position: target + toward * distance, target, up: DVec3::Y };
    let right = DVec3::Y.cross(toward).normalize();
    let up = toward.cross(right);
    let across = FILL * (FOV.to_radians() / 2.0).tan();
    let upward = across * f64::from(size[1]) / f64::from(size[0]);
    let distance = bounds.corners().map(|corner| {
        let c = corner.xyz - target;
        c.dot(toward) + (c.dot(right).abs() / across).max(c.dot(up).abs() / upward)
    });
    pose(distance.into_iter().fold(0.0, f64::max))
}

fn lights(pose: &Pose) -> Result<Vec<Light>, String> {
    let [right, up, forward] = pose.axes().ok_or("the camera has no axes")?;
    let travel = right * KEY_TRAVEL.x + up * KEY_TRAVEL.y + forward * KEY_TRAVEL.z;
    Ok(vec![
        Light::Sun(Sun::new(travel, Rgb::splat(KEY), KEY_DIAMETER)?),
        Light::Environment(Environment::constant(SKY)?),
    ])
}

/// The glow of a temperature grid, else of a flame grid, where there is one that is not empty.
/// Simulations leave temperatures normalised; those are taken to run from 300 K to
/// 1900 K, and larger values as kelvin.
fn glow(file: &VdbFile, notes: &mut Vec<String>) -> Result<Option<Glow>> {
    for name in ["temperature", "flame"] {
        let Some(grid) = glowing(file, name)? else { continue };
        let max = f64::from(grid.max_value());
        if max <= 0.0 {
            continue;
        }
        let kelvin = max >= COLDEST_KELVIN;
        let hottest = if kelvin { max } else { HOTTEST };
        let offset = if kelvin { 0.0 } else { COLD };
        let kelvin_scale = (hottest - offset) / max;
        let scale = GLOW / luminance(blackbody_radiance(hottest)).max(f64::MIN_POSITIVE);
        if !scale.is_finite() || scale > 1e12 {
            return Ok(None); // too cold to glow visibly
        }
        notes.push(format!(
            "{}: grid \"{name}\" glows as a blackbody of {kelvin_scale:.4} K per unit + {offset} K, \
             times {scale:.3e}",
            file.path().display()
        ));
        return Ok(Some(Glow { grid: name, kelvin_scale, kelvin_offset: offset, scale }));
    }
    Ok(None)
}

/// The scalar grid of that name, if there is one.
fn glowing(file: &VdbFile, name: &str) -> Result<Option<Grid<f32>>> {
    let index = file.grids().iter().position(|g| g.name == name && g.is_scalar());
    index.map(|index| file.read_scalar(index, ReadAs::Density)).transpose()
}

/// What glows in `file` as `glow` says, if anything does.
fn emission(glow: &Glow, file: &VdbFile, warnings: &mut Vec<String>) -> Result<Option<Emission>> {
    let Some(grid) = glowing(file, glow.grid)?.filter(|grid| grid.max_value() > 0.0) else {
        return Ok(None);
    };
    warnings.extend(bad_values(file.path(), glow.grid, &grid, "taken as 0"));
    Ok(Some(Emission::Blackbody {
        grid,
        ramp: None,
        kelvin_scale: glow.kelvin_scale,
        kelvin_offset: glow.kelvin_offset,
        scale: glow.scale,
        table: Blackbody::new(),
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_asset_fills_the_picture_at_any_scale_and_aspect() {
        for scale in [1e-6, 1.0, 1e6] {
            for size in [[960, 540], [100, 400]] {
                let corner = |x, y, z| WorldPoint::from_xyz(DVec3::new(x, y, z) * scale);
                let bounds = Aabb::new(corner(100.0, -3.0, 5.0), corner(104.0, 2.0, 6.0));
                let pose = framed(&bounds, size);
                let [right, up, forward] = pose.axes().unwrap();
                let tan = (FOV.to_radians() / 2.0).tan();
                let most = bounds.corners().map(|c| {
                    let d = c.xyz - pose.position;
                    let x = d.dot(right).abs() / d.dot(forward) / tan;
                    let y = d.dot(up).abs() / d.dot(forward) / tan * f64::from(size[0])
                        / f64::from(size[1]);
                    assert!(d.dot(forward) > 0.0);
                    x.max(y)
                });
                let most = most.into_iter().fold(0.0, f64::max);
                assert!((most - FILL).abs() < 1e-6, "{most}");
            }
        }
    }
}
