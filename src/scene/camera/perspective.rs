//! Pinhole and thin lens.

use glam::DVec3;

use crate::math::{Ray, World, WorldPoint, warp};

/// A perspective camera with a thin lens (pbrt 4th edition, section 5.2.3).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Perspective {
    pub(super) origin: WorldPoint,
    pub(super) axes: [DVec3; 3],
    /// Where the axis of the view meets the film, in pixels.
    pub(super) middle: [f64; 2],
    /// Width of a pixel on the image plane at distance 1.
    pub(super) pixel: f64,
    pub(super) lens_radius: f64,
    pub(super) focus: f64,
}

impl Perspective {
    pub(super) fn ray(&self, x: f64, y: f64, lens: [f64; 2]) -> Ray<World> {
        let [right, up, forward] = self.axes;
        let across = (x - self.middle[0]) * self.pixel;
        let upward = (self.middle[1] - y) * self.pixel;
        let through = forward + right * across + up * upward;
        if self.lens_radius == 0.0 {
            return Ray::new(self.origin, through.normalize());
        }
        let on_lens = warp::concentric_disk(lens) * self.lens_radius;
        let offset = right * on_lens.x + up * on_lens.y;
        Ray::new(self.origin + offset, (through * self.focus - offset).normalize())
    }
}
