//! The solid angle of a rectangle, and directions that are uniform in it.
//!
//! Ureña, Fajardo and King 2013, "An Area-Preserving Parametrization for Spherical Rectangles". Places that are
//! uniform by area give light whose variance grows without bound toward the rectangle; of these it is bounded.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};

/// A rectangle as it is seen from a place.
#[derive(Debug, Clone, Copy)]
pub(super) struct SphericalRectangle {
    /// Axes along both edges and away from the place.
    axes: DMat3,
    /// Ends of both edges and the distance of the plane, along the axes.
    x: [f64; 2],
    y: [f64; 2],
    z: f64,
    /// Sines of the angles off the plane's normal under which the ends of the second edge are seen.
    sine_y: [f64; 2],
    /// Angle in rad at which solid angle begins, from which it grows along the first edge.
    start: f64,
    solid_angle: f64,
}

impl SphericalRectangle {
    /// The rectangle with the edges `u` and `v` at right angles, whose centre is at `center` from the place.
    pub(super) fn new(center: DVec3, u: DVec3, v: DVec3) -> Self {
        let [width, height] = [u.length(), v.length()];
        let (along_u, along_v) = (u / width, v / height);
        let normal = along_u.cross(along_v);
        let away = if center.dot(normal) < 0.0 { -normal } else { normal };
        let axes = DMat3::from_cols(along_u, along_v, away);
        let middle = axes.transpose() * center;
        let ends = |middle: f64, length: f64| [middle - 0.5 * length, middle + 0.5 * length];
        let (x, y, z) = (ends(middle.x, width), ends(middle.y, height), middle.z);
        let sine = |end: f64| end / end.hypot(z);
        let (sine_x, sine_y) = (x.map(sine), y.map(sine));
        // Solid angle from the plane's normal to each corner.
        let corners = sine_x.map(|x| sine_y.map(|y| (x * y).asin()));
        let [before, up_to] = corners.map(|[low, high]| high - low);
        Self { axes, x, y, z, sine_y, start: PI + before, solid_angle: up_to - before }
    }

    /// Solid angle in sr.
    pub(super) const fn solid_angle(&self) -> f64 {
        self.solid_angle
    }

    /// A place on the rectangle from the place that sees it, in a direction that is uniform in the solid angle.
    pub(super) fn sample(&self, [u, v]: [f64; 2]) -> DVec3 {
        let Self { x, y, z, sine_y, .. } = self;
        // The plane through the place and along the second edge that has this share of the solid angle before it.
        let angle = self.start + u * self.solid_angle;
        let slope = (-angle.cos() * sine_y[0] - sine_y[1]) / angle.sin();
        let cosine = slope.signum() / slope.hypot(sine_y[0]);
        let across = cosine * z / (1.0 - cosine * cosine).max(0.0).sqrt();
        let across = if across.is_nan() { x[0] } else { across.clamp(x[0], x[1]) };
        // A place in that plane: the sine of the elevation is uniform.
        let depth = across.hypot(*z);
        let [low, high] = y.map(|end| end / depth.hypot(end));
        let sine = low + v * (high - low);
        let along = depth * sine / (1.0 - sine * sine).max(0.0).sqrt();
        let along = if along.is_nan() { y[1] } else { along.clamp(y[0], y[1]) };
        self.axes * DVec3::new(across, along, *z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The rectangle from `from` to `to` along x and y, in the plane z = `z`.
    fn rectangle(from: [f64; 2], to: [f64; 2], z: f64) -> SphericalRectangle {
        let center = DVec3::new(0.5 * (from[0] + to[0]), 0.5 * (from[1] + to[1]), z);
        SphericalRectangle::new(center, DVec3::X * (to[0] - from[0]), DVec3::Y * (to[1] - from[1]))
    }

    proptest! {
        /// As many samples lie in a part of the rectangle as its share of the solid angle says.
        #[test]
        fn samples_are_uniform_in_the_solid_angle(
            from in prop::array::uniform2(-3.0..1.0f64), size in prop::array::uniform2(0.2..3.0f64),
            z in prop_oneof![-2.0..-0.05f64, 0.05..2.0f64],
            inside in prop::array::uniform2(0.1..1.0f64),
        ) {
            let to = [from[0] + size[0], from[1] + size[1]];
            let whole = rectangle(from, to, z);
            let middle = [from[0] + inside[0] * size[0], from[1] + inside[1] * size[1]];
            let share = rectangle(from, middle, z).solid_angle() / whole.solid_angle();
            let grid = 200;
            let mut count = 0;
            for cell in 0..grid * grid {
                let u = [cell % grid, cell / grid].map(|i| (f64::from(i) + 0.5) / f64::from(grid));
                let place = whole.sample(u);
                prop_assert!((place.z - z).abs() < 1e-9);
                for axis in 0..2 {
                    prop_assert!((from[axis] - 1e-9..=to[axis] + 1e-9).contains(&place[axis]));
                }
                count += i32::from(place.x < middle[0] && place.y < middle[1]);
            }
            let found = f64::from(count) / f64::from(grid * grid);
            // A curve through the grid cuts at most two cells of each of its rows and columns.
            prop_assert!((found - share).abs() < 4.0 / f64::from(grid), "{} not {}", found, share);
        }
    }

    /// A rectangle all around the foot of a place near its plane fills half of the sphere, a face of a cube a sixth.
    #[test]
    fn solid_angles_are_right() {
        let half = rectangle([-1.0; 2], [1.0; 2], 1e-9).solid_angle();
        assert!((half - 2.0 * PI).abs() < 1e-8, "{half}");
        let face = rectangle([-1.0; 2], [1.0; 2], 1.0).solid_angle();
        assert!((face - 4.0 * PI / 6.0).abs() < 1e-12, "{face}");
    }
}
