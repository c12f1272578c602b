//! The camera of a bare render.

use glam::DVec3;
use rayon::prelude::*;

use super::look::{Look, LookOptions};
use super::measure::stray_entries;
use super::subject::Subject;
use crate::math::{Ray, Span, WorldPoint};
use crate::scene::camera::Pose;

/// Full angle of view across the width where no focal length is given, in degrees.
const FOV: f64 = 35.0;
/// Width of the sensor that focal lengths refer to, in millimetres.
const SENSOR: f64 = 36.0;
/// Share of the picture's width or height, whichever is reached first, that the medium fills.
const FILL: f64 = 0.8;
/// From the medium toward the camera, seen from above: degrees from +z toward +x.
const AZIMUTH: f64 = 28.8;
/// Angle of the camera above the horizon, in degrees: low, so that the horizon is in the picture.
const ELEVATION: f64 = 4.0;
/// The same for the look of sky: from below.
const ELEVATION_SKY: f64 = -12.0;
/// The same for the look of measurements.
const ELEVATION_NONE: f64 = 14.7;
/// Rays along each side of the raster by which the visible part is found.
const RASTER: u32 = 96;
/// Rounds of the search for the visible part, each with the raster over the part found before.
const ROUNDS: u32 = 6;
/// Opacity from which a place counts as visible.
const VISIBLE: f64 = 0.02;
/// Share of the opacity that may lie beyond each edge of the visible part, for stray voxels.
const STRAY: f64 = 0.002;

/// The camera of a bare render.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    pub(super) pose: Pose,
    /// Full angle of view across the width, in degrees.
    pub(super) fov: f64,
    /// Height of the lowest visible place, in metres.
    pub(super) bottom: f64,
}

/// A rectangle in the tangents of the camera's angles, right and up.
#[derive(Debug, Clone, Copy)]
struct Rectangle {
    min: [f64; 2],
    max: [f64; 2],
}

/// A view of the visible part of `subject` in a picture of `size`.
pub(super) fn frame(subject: &Subject, options: &LookOptions, size: [u32; 2]) -> Frame {
    let fov = options.focal.map_or(FOV, |focal| 2.0 * (0.5 * SENSOR / focal).atan().to_degrees());
    let usual = match subject.look {
        Look::Studio | Look::Dusk => ELEVATION,
        Look::Sky => ELEVATION_SKY,
        Look::None => ELEVATION_NONE,
    };
    let elevation = options.elevation.unwrap_or(usual).to_radians();
    let azimuth = (AZIMUTH + options.orbit).to_radians();
    let (sin, cos) = elevation.sin_cos();
    let toward = DVec3::new(cos * azimuth.sin(), sin, cos * azimuth.cos());
    let across = FILL * (0.5 * fov.to_radians()).tan();
    let half = [across, across * f64::from(size[1]) / f64::from(size[0])];

    let mut view = View::around_box(subject, toward, half);
    for _ in 0..ROUNDS {
        let Some(visible) = view.visible(subject) else { break };
        view = view.centered(&visible, half);
    }
    let pose = Pose { position: view.eye(), target: view.target, up: DVec3::Y };
    Frame { pose, fov, bottom: subject.bounds.min.xyz.y }
}

/// A camera during the search for its position.
#[derive(Debug, Clone, Copy)]
struct View {
    target: DVec3,
    toward: DVec3,
    right: DVec3,
    up: DVec3,
    distance: f64,
    /// The part of the picture that the raster covers.
    raster: Rectangle,
}

impl View {
    /// A view in which all corners of the subject's box stay within `half` of the axis.
    fn around_box(subject: &Subject, toward: DVec3, half: [f64; 2]) -> Self {
        let target = subject.bounds.center().xyz;
        let right = DVec3::Y.cross(toward).normalize();
        let up = toward.cross(right);
        let needed = subject.bounds.corners().map(|corner| {
            let c = corner.xyz - target;
            c.dot(toward) + (c.dot(right).abs() / half[0]).max(c.dot(up).abs() / half[1])
        });
        let distance = needed.into_iter().fold(0.0, f64::max);
        let raster = Rectangle { min: half.map(|h| -h), max: half };
        Self { target, toward, right, up, distance, raster }
    }

    fn eye(&self) -> DVec3 {
        self.target + self.toward * self.distance
    }

    fn ray(&self, x: f64, y: f64) -> Ray<crate::math::World> {
        let direction = self.right * x + self.up * y - self.toward;
        Ray::new(WorldPoint::from_xyz(self.eye()), direction.normalize())
    }

    /// The part of the raster in which the medium is visible; `None` where it is nowhere.
    fn visible(&self, subject: &Subject) -> Option<Rectangle> {
        let at = |axis: usize, k: u32, within: f64| {
            let [min, max] = [self.raster.min[axis], self.raster.max[axis]];
            min + (f64::from(k) + within) / f64::from(RASTER) * (max - min)
        };
        let opacity: Vec<f64> = (0..RASTER * RASTER)
            .into_par_iter()
            .map(|i| {
                let ray = self.ray(at(0, i % RASTER, 0.5), at(1, i / RASTER, 0.5));
                let local = subject.density.transform().ray_to_local(&ray);
                let length = subject.density.integrate(&local, Span::new(0.0, f64::INFINITY));
                let opacity = -(-subject.sigma_t * length).exp_m1();
                if opacity >= VISIBLE { opacity } else { 0.0 }
            })
            .collect();
        let sum: f64 = opacity.iter().sum();
        if sum <= 0.0 {
            return None;
        }
        let edges = |axis: usize| {
            let mut marginal = vec![0.0; RASTER as usize];
            for (i, opacity) in opacity.iter().enumerate() {
                let place = if axis == 0 { i % RASTER as usize } else { i / RASTER as usize };
                marginal[place] += opacity;
            }
            let low = stray_entries(marginal.iter().copied(), STRAY * sum) as u32;
            let high = RASTER - stray_entries(marginal.iter().rev().copied(), STRAY * sum) as u32;
            [at(axis, low, 0.0), at(axis, high, 0.0)]
        };
        let ([left, right], [low, high]) = (edges(0), edges(1));
        Some(Rectangle { min: [left, low], max: [right, high] })
    }

    /// The view centred on `visible`, at the distance from which that fills `half` along one axis.
    fn centered(&self, visible: &Rectangle, half: [f64; 2]) -> Self {
        let middle = [0, 1].map(|axis| 0.5 * (visible.min[axis] + visible.max[axis]));
        let extent = [0, 1].map(|axis| 0.5 * (visible.max[axis] - visible.min[axis]));
        let target = self.target + (self.right * middle[0] + self.up * middle[1]) * self.distance;
        let scale = (extent[0] / half[0]).max(extent[1] / half[1]);
        let distance = scale * self.distance;
        let raster = Rectangle {
            min: [0, 1].map(|axis| -1.25 * half[axis]),
            max: [0, 1].map(|axis| 1.25 * half[axis]),
        };
        Self { target, distance, raster, ..*self }
    }
}
