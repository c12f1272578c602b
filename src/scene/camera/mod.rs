//! Cameras: where a place on the film looks.

mod frustum;
mod latlong;
mod orthographic;
mod perspective;

use glam::DVec3;

use crate::math::{Ray, World, WorldPoint};

pub use frustum::Frustum;
pub use latlong::LatLong;
pub use orthographic::Orthographic;
pub use perspective::Perspective;

/// Where a camera stands and how it is turned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Where it stands, in metres.
    pub position: DVec3,
    /// What it looks at, in metres.
    pub target: DVec3,
    /// What is upward in the picture; need not be square to the view.
    pub up: DVec3,
}

impl Pose {
    /// The axes (right, up, forward), of unit length and square to each other, or nothing where
    /// position and target coincide or `up` is parallel to the view.
    pub fn axes(&self) -> Option<[DVec3; 3]> {
        let forward = (self.target - self.position).try_normalize()?;
        let across = forward.cross(self.up.try_normalize()?);
        // Below this angle (radians) rounding would turn the picture by a visible amount.
        if across.length() < 1e-6 {
            return None;
        }
        let right = across.normalize();
        Some([right, right.cross(forward), forward])
    }
}

/// What kind of camera it is, with what only that kind has.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Projection {
    /// Rays from a pinhole or a thin lens.
    Perspective {
        /// Full angle of view along the width of the image, in degrees, in (0, 180).
        fov: f64,
        /// Diameter of the lens in metres; 0 is a pinhole.
        aperture: f64,
        /// Distance of the plane in focus in metres, along the view; by default the target's.
        focus: Option<f64>,
    },
    /// Parallel rays.
    Orthographic {
        /// Height of the view in metres.
        height: f64,
    },
    /// The full sphere of directions.
    LatLong,
}

/// A camera with the film it exposes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Camera {
    /// Pinhole or thin lens.
    Perspective(Perspective),
    /// Parallel rays.
    Orthographic(Orthographic),
    /// Latitude and longitude.
    LatLong(LatLong),
}

impl Camera {
    /// The camera, or nothing where the pose is degenerate. `size` is the film's width and height
    /// in pixels; pixels are square but for the latitude-longitude camera's.
    pub fn new(pose: &Pose, projection: &Projection, size: [u32; 2]) -> Option<Self> {
        let axes = pose.axes()?;
        let origin = WorldPoint::from_xyz(pose.position);
        let size = size.map(f64::from);
        Some(match *projection {
            Projection::Perspective { fov, aperture, focus } => {
                let focus = focus.unwrap_or_else(|| pose.position.distance(pose.target));
                Self::Perspective(Perspective::new(origin, axes, size, fov, aperture, focus))
            }
            Projection::Orthographic { height } => {
                Self::Orthographic(Orthographic::new(origin, axes, size, height))
            }
            Projection::LatLong => Self::LatLong(LatLong::new(origin, axes, size)),
        })
    }

    /// The ray through (x, y) of the film, in pixels from its upper left corner: pixel (i, j)
    /// covers [i, i + 1) x [j, j + 1). `lens` picks the place on the lens, uniform in the unit
    /// square. The direction has unit length.
    pub fn ray(&self, x: f64, y: f64, lens: [f64; 2]) -> Ray<World> {
        match self {
            Self::Perspective(camera) => camera.ray(x, y, lens),
            Self::Orthographic(camera) => camera.ray(x, y),
            Self::LatLong(camera) => camera.ray(x, y),
        }
    }

    /// Unit direction from `p` to the camera; for parallel rays, against them.
    pub fn toward(&self, p: WorldPoint) -> DVec3 {
        match self {
            Self::Perspective(camera) => (camera.origin - p).normalize_or_zero(),
            Self::Orthographic(camera) => -camera.axes[2],
            Self::LatLong(camera) => (camera.origin - p).normalize_or_zero(),
        }
    }

    /// Where all rays begin; nothing for parallel rays.
    pub fn place(&self) -> Option<WorldPoint> {
        match self {
            Self::Perspective(camera) => Some(camera.origin),
            Self::Orthographic(_) => None,
            Self::LatLong(camera) => Some(camera.origin),
        }
    }

    /// Unit direction of the view, at the centre of the film.
    pub fn forward(&self) -> DVec3 {
        match self {
            Self::Perspective(camera) => camera.axes[2],
            Self::Orthographic(camera) => camera.axes[2],
            Self::LatLong(camera) => camera.axes[2],
        }
    }
}

#[cfg(test)]
mod tests;
