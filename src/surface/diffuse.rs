//! Lambertian reflection.
//!
//! Light is reflected only between directions that lie on the same side of the geometric and of
//! the shading normal alike: nothing leaks through, and the two ends of a path agree.

use std::f64::consts::PI;

use glam::DVec3;

use super::scattered::{facing, reflects};
use super::{Scattered, SurfaceHit, Texture};
use crate::math::{Frame, Rgb, warp};

pub(super) fn scatter(
    reflectance: &Texture,
    incoming: DVec3,
    hit: &SurfaceHit<'_>,
    u: [f64; 3],
) -> Option<Scattered> {
    let (_, ns) = facing(incoming, hit);
    let local = warp::cosine_hemisphere([u[0], u[1]]);
    let direction = Frame::around(ns).to_world(local);
    let reflects = reflects(incoming, direction, hit) && local.z > 0.0;
    reflects.then(|| Scattered {
        direction,
        weight: reflectance.at(hit.uv),
        specular: false,
        pdf: warp::cosine_hemisphere_pdf(local.z),
        crossing: 0,
    })
}

pub(super) fn eval(
    reflectance: &Texture,
    incoming: DVec3,
    outgoing: DVec3,
    hit: &SurfaceHit<'_>,
) -> Rgb {
    if reflects(incoming, outgoing, hit) { reflectance.at(hit.uv) / PI } else { Rgb::ZERO }
}

pub(super) fn pdf(incoming: DVec3, outgoing: DVec3, hit: &SurfaceHit<'_>) -> f64 {
    let (_, ns) = facing(incoming, hit);
    if reflects(incoming, outgoing, hit) {
        warp::cosine_hemisphere_pdf(outgoing.dot(ns))
    } else {
        0.0
    }
}
