//! Stored photons.

use std::fmt::Debug;

use glam::DVec3;

use crate::math::{Rgb, Spectrum, WorldPoint, warp};
use crate::medium::Phase;

/// A photon without its position: 16 bytes in colour and with its direction, 4 without either.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Photon<S: Spectrum = Rgb, H = Octahedral> {
    power: S::Stored,
    direction: H,
}

impl<S: Spectrum, H: PhotonDirection> Photon<S, H> {
    /// A photon of `power` (W on surfaces, W m in media, or a unit of the map's of it) that flew
    /// along the unit `direction`.
    pub fn new(power: S, direction: DVec3) -> Self {
        Self { power: S::pack(power.to_f32()), direction: H::new(direction) }
    }

    /// Its power in the unit that it was made with: in a medium power times length, the power over the
    /// rate of deposits there.
    pub fn power(&self) -> S {
        S::to_f64(S::unpack(self.power))
    }

    /// The direction of its flight, as far as it is stored.
    pub const fn stored_direction(&self) -> H {
        self.direction
    }
}

impl<S: Spectrum> Photon<S> {
    /// The unit direction of its flight, to about 3e-5 rad.
    pub fn direction(&self) -> DVec3 {
        decode(self.direction.0)
    }
}

/// What is stored of the direction that a photon flew along.
pub trait PhotonDirection: Copy + Debug + Send + Sync + 'static {
    /// Whether a direction is stored.
    ///
    /// Unit: none. Definition: of each kind of direction.
    const KNOWN: bool;

    /// That of the unit `direction`.
    fn new(direction: DVec3) -> Self;

    /// Value of `phase`, 1/sr, for scattering into the unit direction `wo`.
    fn scattered(self, phase: &Phase, wo: DVec3) -> f64;
}

/// A direction in 4 bytes, to about 3e-5 rad.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Octahedral([i16; 2]);

impl PhotonDirection for Octahedral {
    const KNOWN: bool = true;

    fn new(direction: DVec3) -> Self {
        Self(encode(direction))
    }

    fn scattered(self, phase: &Phase, wo: DVec3) -> f64 {
        phase.eval(decode(self.0).dot(wo))
    }
}

/// No direction, in no bytes: enough where all phase functions are isotropic.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NoDirection;

impl PhotonDirection for NoDirection {
    const KNOWN: bool = false;

    fn new(_: DVec3) -> Self {
        Self
    }

    fn scattered(self, _: &Phase, _: DVec3) -> f64 {
        warp::uniform_sphere_pdf()
    }
}

/// A photon with its position: 28 bytes in colour and with its direction, 16 without either.
#[derive(Debug, Clone, Copy)]
pub struct PhotonAt<S: Spectrum = Rgb, H = Octahedral> {
    /// Metres from the map's origin.
    pub place: [f32; 3],
    /// The photon.
    pub photon: Photon<S, H>,
}

impl<S: Spectrum, H: PhotonDirection> PhotonAt<S, H> {
    /// Its position in world space, `origin` being the map's.
    pub fn at(&self, origin: WorldPoint) -> WorldPoint {
        origin + DVec3::from(self.place.map(f64::from))
    }
}

/// Octahedral map of the unit sphere on a square (Cigolle et al. 2014, "A Survey of Efficient
/// Representations for Independent Unit Vectors").
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
