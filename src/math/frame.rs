//! Orthonormal frames.

use glam::DVec3;

/// A right-handed orthonormal frame whose z axis is given.
#[derive(Debug, Clone, Copy)]
pub struct Frame {
    /// First tangent.
    pub x: DVec3,
    /// Second tangent.
    pub y: DVec3,
    /// The axis the frame was built on.
    pub z: DVec3,
}

impl Frame {
    /// The frame around the unit vector `z` (Duff et al. 2017, "Building an Orthonormal Basis,
    /// Revisited").
    pub fn around(z: DVec3) -> Self {
        let sign = 1f64.copysign(z.z);
        let a = -1.0 / (sign + z.z);
        let b = z.x * z.y * a;
        Self {
            x: DVec3::new(1.0 + sign * z.x * z.x * a, sign * b, -sign * z.x),
            y: DVec3::new(b, sign + z.y * z.y * a, -z.y),
            z,
        }
    }

    /// A vector given in the frame, in the frame's surroundings.
    pub fn to_world(&self, v: DVec3) -> DVec3 {
        self.x * v.x + self.y * v.y + self.z * v.z
    }

    /// A vector of the surroundings, in the frame.
    pub fn to_local(&self, v: DVec3) -> DVec3 {
        DVec3::new(self.x.dot(v), self.y.dot(v), self.z.dot(v))
    }
}
