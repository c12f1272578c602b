//! Point lights in endless media.

use std::f64::consts::PI;

use super::super::case::{Case, Effort};
use super::super::known::{POINT_FLUENCES, airlight};
use super::super::scenes;
use super::{Work, both};
use crate::image::Film;

pub(super) fn cases(effort: Effort) -> Vec<Case> {
    let mut cases = fluences(effort);
    cases.extend(airlights(effort));
    cases
}

/// Fluence is radiance over the sphere of directions: a latlong camera sees it, but for the light
/// that comes straight from the source, which is known.
fn fluences(effort: Effort) -> Vec<Case> {
    const HEIGHT: usize = 32;
    let case = |(distance, expected): (f64, f64)| {
        let straight = (-distance).exp() / (4.0 * PI * distance * distance);
        let measure = |film: &Film| {
            let row = |y: usize| (PI * (y as f64 + 0.5) / HEIGHT as f64).sin();
            4.0 * PI * scenes::weighted_mean(film, row)
        };
        let text = move |rays, photons| {
            format!(
                r#"
                [camera]
                type = "latlong"
                position = [0.0, 0.0, 0.0]
                target = [0.3, {distance:?}, 0.0]
                up = [0.0, 0.0, 1.0]
                [film]
                size = [{HEIGHT}, {HEIGHT}]
                [render]
                rays = {rays}
                photons = {photons}
                [[medium]]
                region = "everywhere"
                sigma_t = 1.0
                albedo = 0.9
                [[light]]
                type = "point"
                position = [0.0, {distance:?}, 0.0]
                power = 1.0
                "#
            )
        };
        let name = format!("point-source/r={distance}");
        let source = "transport round a point source, Case, de Hoffmann and Placzek 1953";
        // Far from the source little light is left, and rays that pass near it bring most.
        let far = distance > 4.0;
        let (photons, rays) = if far { (40_000, 16) } else { (20_000, 8) };
        let work = Work::new(effort, 4, photons, rays);
        let work = if far { Work { error: 2.0 * work.error, ..work } } else { work };
        both(&name, source, measure, expected - straight, work, vec![], text)
    };
    POINT_FLUENCES.map(case).into()
}

fn airlights(effort: Effort) -> Vec<Case> {
    let case = |angle: f64| {
        let expected = airlight(0.1, 0.1, 10.0, angle);
        let text = move |rays, _| {
            let (x, z) = (10.0 * angle.sin(), 10.0 * angle.cos());
            format!(
                r#"
                [camera]
                position = [0.0, 0.0, 0.0]
                target = [0.0, 0.0, 1.0]
                fov = 0.001
                [film]
                size = [4, 4]
                [render]
                max_scatter = 1
                rays = {rays}
                photons = 0
                [[medium]]
                region = "everywhere"
                sigma_t = 0.1
                albedo = 1.0
                [[light]]
                type = "point"
                position = [{x:?}, 0.0, {z:?}]
                intensity = 1.0
                "#
            )
        };
        let name = format!("airlight/angle={angle}");
        let work = Work::new(effort, 200, 0, 1000);
        both(&name, "Sun et al. 2005, equation 9", scenes::mean, expected, work, vec![], text)
    };
    [0.1, 0.5, 1.0, 2.0, 3.0].map(case).into()
}
