//! Parallel projection.

use glam::DVec3;

use crate::math::{Ray, World, WorldPoint};

/// A camera whose rays all run along the view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Orthographic {
    origin: WorldPoint,
    pub(super) axes: [DVec3; 3],
    size: [f64; 2],
    /// Width of a pixel in metres.
    pixel: f64,
}

impl Orthographic {
    pub(super) fn new(origin: WorldPoint, axes: [DVec3; 3], size: [f64; 2], height: f64) -> Self {
        Self { origin, axes, size, pixel: height / size[1] }
    }

    pub(super) fn ray(&self, x: f64, y: f64) -> Ray<World> {
        let [right, up, forward] = self.axes;
        let across = right * ((x - self.size[0] / 2.0) * self.pixel);
        let upward = up * ((self.size[1] / 2.0 - y) * self.pixel);
        Ray::new(self.origin + across + upward, forward)
    }
}
