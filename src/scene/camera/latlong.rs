//! The full sphere by latitude and longitude.

use std::f64::consts::PI;

use glam::DVec3;

use crate::math::{Ray, World, WorldPoint};

/// A camera that sees everything: longitude runs from 0 to 2 pi across the width, rightward, with
/// the target's in the middle; latitude from up to down along the height.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LatLong {
    pub(super) origin: WorldPoint,
    pub(super) axes: [DVec3; 3],
    size: [f64; 2],
}

impl LatLong {
    pub(super) fn new(origin: WorldPoint, axes: [DVec3; 3], size: [f64; 2]) -> Self {
        Self { origin, axes, size }
    }

    pub(super) fn ray(&self, x: f64, y: f64) -> Ray<World> {
        let [right, up, forward] = self.axes;
        let longitude = (x / self.size[0] - 0.5) * 2.0 * PI;
        let latitude = (0.5 - y / self.size[1]) * PI;
        let level = forward * longitude.cos() + right * longitude.sin();
        let direction = level * latitude.cos() + up * latitude.sin();
        Ray::new(self.origin, direction.normalize())
    }
}
