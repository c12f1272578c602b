//! A point light in, on and beside a medium.

use std::f64::consts::PI;

use glam::DVec3;

use super::judge::soundness;
use super::places::{REACH, puff};
use super::setup::Setup;
use crate::error::Result;
use crate::math::{Ray, Span, WorldPoint};
use crate::render::Rendered;
use crate::scene::Scene;
use crate::verify::case::{Case, Group};
use crate::verify::{Check, Parts, scenes};

/// Edge of the square that is seen, in metres: all of the medium.
const SEEN: f64 = 64.0;

/// Tentative collisions a path: optical thicknesses here are below 4.
const COLLISIONS: f64 = 1e3;

/// Directions over which unscattered light is averaged.
const DIRECTIONS: u32 = 4000;

pub(super) fn cases() -> Vec<Case> {
    let words = [
        "energy: of I W/sr all that is scattered leaves, I (1 - mean T) in the mean of six views",
        "noise of 3000 photons; six views for all; a gather as wide as the asset spreads light out",
    ];
    // Six views see more than the mean of a lamp at the edge, which lights one side alone.
    let places = [
        ("middle", 0.0, 1.15),
        ("inside", 5.0, 1.15),
        ("face", REACH, 1.4),
        ("voxel outside", 15.0, 1.4),
    ];
    let mut cases = Vec::new();
    for (row, at, most) in places {
        // Light that the gather may lose, in proportion to what is scattered.
        for (column, radius, loss) in
            [("0.1 voxel", 0.1, 0.2), ("1", 1.0, 0.15), ("8", 8.0, 0.35), ("asset", 32.0, 0.9)]
        {
            let name = format!("matrix/light/at={row}/radius={column}");
            let case = Case::new(Group::Matrix, name, words, move |parts| {
                lit(parts, at, radius, [1.0 - loss, most])
            });
            cases.push(case.at("place of a light x gather radius", row.into(), column.into()));
        }
    }
    cases
}

/// The light that leaves along six axes stands for that in all directions: harmonics up to the third
/// cancel in their mean, and those above are small.
fn lit(parts: &Parts, at: f64, radius: f64, bounds: [f64; 2]) -> Result<Vec<Check>> {
    let place = DVec3::new(0.1, at, 0.2);
    let mut sum = 0.0;
    let mut found: Vec<Check> = Vec::new();
    let mut expected = 0.0;
    for view in [DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y, DVec3::Z, -DVec3::Z] {
        let scene = seen(place, view, radius).scene()?;
        expected = 1.0 - unscattered(&scene, place);
        let rendered = (parts.render)(&scene, &scene.render)?;
        sum += leaving(&rendered) / 6.0;
        if view == DVec3::X {
            found.extend(soundness(&rendered, COLLISIONS));
        }
    }
    let [low, high] = bounds.map(|share| share * expected);
    found.insert(0, Check::within("share of the light that is scattered", sum, low, high));
    Ok(found)
}

/// The puff with the light, by an orthographic camera in the direction `view` from it.
fn seen(place: DVec3, view: DVec3, radius: f64) -> Setup {
    let up = if view.y == 0.0 { DVec3::Y } else { DVec3::X };
    Setup {
        camera: format!(
            "type = \"orthographic\"\nposition = {:?}\ntarget = [0.0, 0.0, 0.0]\nup = {:?}\n\
             height = {SEEN:?}",
            (view * 100.0).to_array(),
            up.to_array()
        ),
        size: [8, 8],
        rays: 16,
        photons: 3000,
        render: format!("radius = {radius:?}"),
        medium: "file = \"grids.vdb\"\nsigma_t = 0.5\nalbedo = 1.0".into(),
        light: format!("type = \"point\"\nposition = {:?}\nintensity = 1.0", place.to_array()),
        grids: vec![puff()],
    }
}

/// Light that leaves toward the camera, W/sr.
fn leaving(rendered: &Rendered) -> f64 {
    scenes::mean(&rendered.film) * SEEN * SEEN
}

/// Mean transmittance from `place` to outside, over directions on a spiral.
fn unscattered(scene: &Scene, place: DVec3) -> f64 {
    let golden = PI * (3.0 - 5f64.sqrt());
    let toward = |i: u32| {
        let z = 1.0 - 2.0 * (f64::from(i) + 0.5) / f64::from(DIRECTIONS);
        let (sin, cos) = (golden * f64::from(i)).sin_cos();
        let across = (1.0 - z * z).sqrt();
        let ray = Ray::new(WorldPoint::from_xyz(place), DVec3::new(across * cos, across * sin, z));
        scene.media.transmittance(&ray, Span::AHEAD).x
    };
    (0..DIRECTIONS).map(toward).sum::<f64>() / f64::from(DIRECTIONS)
}
