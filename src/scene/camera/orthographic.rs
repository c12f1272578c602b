//! Parallel projection.

use glam::DVec3;

use crate::math::{Ray, World, WorldPoint};

/// A camera whose rays all run along the view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Orthographic {
    pub(super) origin: WorldPoint,
    pub(super) axes: [DVec3; 3],
    /// Where the axis of the view meets the film, in pixels.
    pub(super) middle: [f64; 2],
    /// Width of a pixel in metres.
    pub(super) pixel: f64,
}

impl Orthographic {
    pub(super) fn ray(&self, x: f64, y: f64) -> Ray<World> {
        let [right, up, forward] = self.axes;
        let across = right * ((x - self.middle[0]) * self.pixel);
        let upward = up * ((self.middle[1] - y) * self.pixel);
        Ray::new(self.origin + across + upward, forward)
    }
}
