//! Stored photons.

use glam::DVec3;

use crate::math::{Rgb, WorldPoint};

/// A stored photon without its place, which the tree holds: 16 bytes, 28 with the place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Photon {
    power: [f32; 3],
    direction: [i16; 2],
}

impl Photon {
    /// A photon of `power` (W on surfaces, W m in media, or a unit of the map's of it) that flew
    /// along the unit `direction`.
    pub fn new(power: Rgb, direction: DVec3) -> Self {
        Self { power: power.as_vec3().to_array(), direction: encode(direction) }
    }

    /// Its power in the unit it was made with: on a surface power; in a medium power times length,
    /// the power over the rate of deposits there.
    pub fn power(&self) -> Rgb {
        Rgb::from(self.power.map(f64::from))
    }

    /// The unit direction of its flight, to about 3e-5 rad.
    pub fn direction(&self) -> DVec3 {
        decode(self.direction)
    }
}

/// A photon with its place: 28 bytes.
#[derive(Debug, Clone, Copy)]
pub struct Placed {
    /// Metres from the map's origin.
    pub place: [f32; 3],
    /// The photon.
    pub photon: Photon,
}

impl Placed {
    /// Its place in the world, `origin` being the map's.
    pub fn at(&self, origin: WorldPoint) -> WorldPoint {
        origin + DVec3::from(self.place.map(f64::from))
    }
}

/// Octahedral map of the unit sphere on a square (Cigolle et al. 2014).
fn encode(d: DVec3) -> [i16; 2] {
    let n = d / (d.x.abs() + d.y.abs() + d.z.abs());
    let (x, y) = if n.z < 0.0 {
        ((1.0 - n.y.abs()) * 1f64.copysign(n.x), (1.0 - n.x.abs()) * 1f64.copysign(n.y))
    } else {
        (n.x, n.y)
    };
    [x, y].map(|v| (v * f64::from(i16::MAX)).round() as i16)
}

fn decode(code: [i16; 2]) -> DVec3 {
    let [x, y] = code.map(|v| f64::from(v) / f64::from(i16::MAX));
    let z = 1.0 - x.abs() - y.abs();
    let fold = (-z).max(0.0);
    DVec3::new(x - fold.copysign(x), y - fold.copysign(y), z).normalize()
}
