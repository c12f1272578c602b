//! Cameras: where a place on the film looks.

mod frustum;
mod latlong;
mod matrices;
mod orthographic;
mod perspective;

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DQuat, DVec3, FloatExt};

use crate::math::{Ray, World, WorldPoint};

pub use frustum::Frustum;
use latlong::LatLong;
pub use matrices::CameraMatrices;
use orthographic::Orthographic;
use perspective::Perspective;

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

    /// The pose at the time `t`, where it is this at 0 and `next` at 1: moved in a straight line, and turned evenly about one
    /// axis. `None` where one of the two has no axes.
    pub fn toward(&self, next: &Self, t: f64) -> Option<Self> {
        let turns = [self, next].map(|pose| {
            let [right, up, forward] = pose.axes()?;
            Some(DQuat::from_mat3(&DMat3::from_cols(right, up, -forward)))
        });
        let [from, to] = [turns[0]?, turns[1]?];
        let (axis, angle) = (to * from.inverse()).to_axis_angle();
        // The shorter way round.
        let angle = if angle > PI { angle - TAU } else { angle };
        let turn = DQuat::from_axis_angle(axis, angle * t) * from;
        let distance = |pose: &Self| pose.position.distance(pose.target);
        let [here, there] = [distance(self), distance(next)];
        let position = self.position.lerp(next.position, t);
        let ahead = turn * -DVec3::Z * here.lerp(there, t).max(f64::MIN_POSITIVE);
        Some(Self { position, target: position + ahead, up: turn * DVec3::Y })
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
        /// How far the film is shifted rightward and upward, in widths of the picture.
        shift: [f64; 2],
    },
    /// Parallel rays.
    Orthographic {
        /// Height of the view in metres.
        height: f64,
        /// How far the film is shifted rightward and upward, in widths of the picture.
        shift: [f64; 2],
    },
    /// The full sphere of directions.
    LatLong,
}

/// A camera with the film it exposes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    kind: Kind,
    /// Distances in metres between which it sees, along the view; from the camera where it sees all round.
    clip: Option<[f64; 2]>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
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
        // The middle of the film, shifted.
        let middle =
            |[right, up]: [f64; 2]| [0.5 * size[0] - right * size[0], 0.5 * size[1] + up * size[0]];
        let kind = match *projection {
            Projection::Perspective { fov, aperture, focus, shift } => {
                let focus = focus.unwrap_or_else(|| pose.position.distance(pose.target));
                let pixel = 2.0 * (fov.to_radians() / 2.0).tan() / size[0];
                Kind::Perspective(Perspective {
                    origin,
                    axes,
                    middle: middle(shift),
                    pixel,
                    lens_radius: aperture / 2.0,
                    focus,
                })
            }
            Projection::Orthographic { height, shift } => {
                let pixel = height / size[1];
                Kind::Orthographic(Orthographic { origin, axes, middle: middle(shift), pixel })
            }
            Projection::LatLong => Kind::LatLong(LatLong::new(origin, axes, size)),
        };
        Some(Self { kind, clip: None })
    }

    /// The same camera, which sees nothing nearer or farther than these distances in metres: along the view, or from
    /// the camera where it sees all round.
    #[must_use]
    pub fn clipped(self, clip: Option<[f64; 2]>) -> Self {
        Self { clip, ..self }
    }

    /// The ray through (x, y) of the film, in pixels from its upper left corner: pixel (i, j)
    /// covers [i, i + 1) x [j, j + 1). `lens` picks the place on the lens, uniform in the unit
    /// square. The direction has unit length. The ray begins where the camera begins to see.
    pub fn ray(&self, x: f64, y: f64, lens: [f64; 2]) -> Ray<World> {
        let ray = self.ray_from_lens(x, y, lens);
        match self.clip {
            Some(_) => Ray::new(ray.at(self.near(&ray)), ray.direction),
            None => ray,
        }
    }

    /// The same from the lens on.
    pub fn ray_from_lens(&self, x: f64, y: f64, lens: [f64; 2]) -> Ray<World> {
        match &self.kind {
            Kind::Perspective(camera) => camera.ray(x, y, lens),
            Kind::Orthographic(camera) => camera.ray(x, y),
            Kind::LatLong(camera) => camera.ray(x, y),
        }
    }

    /// Distance from the lens to the origin of `ray`, one of this camera's, in metres.
    pub fn near(&self, ray: &Ray<World>) -> f64 {
        self.clip.map_or(0.0, |[near, _]| near / self.cosine(ray))
    }

    /// How far this camera sees along `ray`, one of its own, from the origin of that, in metres.
    pub fn end(&self, ray: &Ray<World>) -> f64 {
        self.clip.map_or(f64::INFINITY, |[near, far]| (far - near) / self.cosine(ray))
    }

    /// Share of a distance along `ray` by which that counts toward `clip`.
    fn cosine(&self, ray: &Ray<World>) -> f64 {
        match &self.kind {
            Kind::Perspective(_) | Kind::Orthographic(_) => ray.direction.dot(self.forward()),
            Kind::LatLong(_) => 1.0,
        }
    }

    /// Unit direction from `p` to the camera; for parallel rays, against them.
    pub fn toward(&self, p: WorldPoint) -> DVec3 {
        match &self.kind {
            Kind::Perspective(camera) => (camera.origin - p).normalize_or_zero(),
            Kind::Orthographic(camera) => -camera.axes[2],
            Kind::LatLong(camera) => (camera.origin - p).normalize_or_zero(),
        }
    }

    /// Where all rays come together; nothing for parallel rays.
    pub fn place(&self) -> Option<WorldPoint> {
        match &self.kind {
            Kind::Perspective(camera) => Some(camera.origin),
            Kind::Orthographic(_) => None,
            Kind::LatLong(camera) => Some(camera.origin),
        }
    }

    /// Centre and radius in metres of a ball in which all rays start: the lens. Nothing for parallel rays, and where the camera
    /// begins to see further away.
    pub fn lens(&self) -> Option<(WorldPoint, f64)> {
        let radius = match &self.kind {
            Kind::Perspective(camera) => camera.lens_radius,
            Kind::Orthographic(_) | Kind::LatLong(_) => 0.0,
        };
        self.place().filter(|_| self.clip.is_none()).map(|place| (place, radius))
    }

    /// Unit direction of the view, square to the film; of a camera that sees all round, at the centre of that.
    pub fn forward(&self) -> DVec3 {
        match &self.kind {
            Kind::Perspective(camera) => camera.axes[2],
            Kind::Orthographic(camera) => camera.axes[2],
            Kind::LatLong(camera) => camera.axes[2],
        }
    }
}

#[cfg(test)]
mod tests;
