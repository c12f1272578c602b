//! Gather radius, march step, photons and pixels.

use glam::DVec3;

use super::judge::{Bounds, judge};
use super::places::puff;
use super::setup::Setup;
use crate::error::Result;
use crate::math::{Ray, Rgb, Span, WorldPoint};
use crate::photon::{BeamMap, Photon, PhotonAt, PhotonMap};
use crate::verify::case::{Case, Effort, Group};
use crate::verify::{Check, Parts, scenes};

pub(super) fn cases(effort: Effort) -> Vec<Case> {
    let mut cases = radius_and_step();
    cases.extend(photons_and_pixels(effort));
    cases.push(one_point());
    cases.extend((effort == Effort::Full).then(many));
    cases
}

fn furnace(render: String, photons: u64, size: [u32; 2]) -> Setup {
    Setup {
        camera: "position = [0.0, 0.0, 60.0]\ntarget = [0.0, 0.0, 0.0]\nfov = 12.0".into(),
        size,
        photons,
        render,
        medium: "file = \"grids.vdb\"\nsigma_t = 0.3\nalbedo = 1.0".into(),
        grids: vec![puff()],
        ..Setup::default()
    }
}

fn radius_and_step() -> Vec<Case> {
    let words = [
        "white furnace: L = 1; at least what is scattered once",
        "noise of 5000 photons; a gather as wide as the asset spreads light beyond its edge",
    ];
    let mut cases = Vec::new();
    for radius in [0.1, 1.0, 8.0, 32.0] {
        for step in [0.01, 0.5, 1.0, 4.0, 32.0] {
            let name = format!("matrix/gather/radius={radius}/step={step}");
            let case = Case::new(Group::Matrix, name, words, move |parts| {
                let render = format!("radius = {radius:?}\nstep = {step:?}");
                let low = if radius < 16.0 { 0.7 } else { single(parts, &render)? };
                judge(parts, &furnace(render, 5000, [8, 8]), Bounds::mean(low, 1.3))
            });
            let plane = "gather radius x march step, voxels";
            cases.push(case.at(plane, radius.to_string(), step.to_string()));
        }
    }
    cases
}

/// What the furnace shows of light scattered once or not at all, which no gather blurs, less
/// rounding.
fn single(parts: &Parts, render: &str) -> Result<f64> {
    let setup = furnace(format!("{render}\nmax_scatter = 1"), 0, [8, 8]);
    let scene = setup.scene()?;
    Ok(scenes::mean(&(parts.render)(&scene, &scene.render)?.film) - 1e-6)
}

fn photons_and_pixels(effort: Effort) -> Vec<Case> {
    let words = [
        "white furnace: L = 1; without photons light scattered once is left",
        "noise of the photons there are; energy alone where they are few",
    ];
    let most = if effort == Effort::Full { 1_000_000 } else { 100_000 };
    let mut cases = Vec::new();
    for photons in [0, 1, 33, most] {
        for size in [[1, 1], [1, 33], [16, 16]] {
            let [width, height] = size;
            let name = format!("matrix/counts/photons={photons}/size={width}x{height}");
            let case = Case::new(Group::Matrix, name, words, move |parts| {
                let bounds = match photons {
                    0 => Bounds::mean(0.2, 1.0 + 1e-6),
                    1..1000 => Bounds::mean(0.2, 3.0),
                    _ => Bounds::mean(0.9, 1.1),
                };
                judge(parts, &furnace(String::new(), photons, size), bounds)
            });
            let size = format!("{width} x {height}");
            cases.push(case.at("photons x size of the picture", photons.to_string(), size));
        }
    }
    cases
}

/// Ten million photons for one pixel; through so thin a medium that the map stays small.
fn many() -> Case {
    let words = ["white furnace: L = 1", "1 %: such a medium scatters little"];
    let name = "matrix/counts/photons=10000000/size=1x1";
    let case = Case::new(Group::Matrix, name, words, |parts| {
        let medium = "file = \"grids.vdb\"\nsigma_t = 0.005\nalbedo = 1.0".into();
        let setup = Setup { medium, ..furnace(String::new(), 10_000_000, [1, 1]) };
        judge(parts, &setup, Bounds::mean(0.99, 1.01))
    });
    case.at("photons x size of the picture", "10000000".into(), "1 x 1".into())
}

/// More photons on one point than a leaf of the tree holds.
fn one_point() -> Case {
    const N: usize = 33;
    let words = ["all photons on a point are found there", "counts are exact"];
    Case::new(Group::Matrix, "matrix/counts/33-photons-on-one-point", words, |_| {
        let origin = WorldPoint::new(1e7, 0.0, 0.0);
        let photon = Photon::new(Rgb::ONE, DVec3::X);
        let placed: [PhotonAt; N] = [PhotonAt { place: [0.5, 0.25, 0.125], photon }; N];
        let map = PhotonMap::new(origin, &placed);
        let at = placed[0].at(origin);
        let mut within = 0;
        map.within(at, 1e-3, |_, _| within += 1);
        let beams = BeamMap::new(origin, &placed, &[1e-3; N]);
        let mut along = 0;
        let ray = Ray::new(at + DVec3::new(-2.0, 1e-4, 0.0), DVec3::X);
        beams.along(&ray, Span::AHEAD, 1.0, |_| along += 1);
        let exact = |what, found: i32| Check::near(what, f64::from(found), N as f64, 0.0);
        Ok(vec![exact("found round the point", within), exact("found along a ray", along)])
    })
    .at("photons x size of the picture", "33 on one point".into(), "-".into())
}
