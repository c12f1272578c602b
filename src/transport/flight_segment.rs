//! Straight pieces of photon flights.

use glam::DVec3;

use crate::math::{Rgb, Spectrum, WorldPoint};

/// A stretch along which a photon flew with one power: 36 bytes in colour, 28 without.
#[derive(Debug, Clone, Copy)]
pub struct FlightSegment<S: Spectrum = Rgb> {
    /// Metres from the maps' origin.
    from: [f32; 3],
    to: [f32; 3],
    power: S::Stored,
}

impl<S: Spectrum> FlightSegment<S> {
    /// The stretch from `from` to `to` flown with `power`, in any unit; places are kept relative to
    /// `origin`.
    pub fn new(origin: WorldPoint, from: WorldPoint, to: WorldPoint, power: S) -> Self {
        let local = |p: WorldPoint| (p - origin).as_vec3().to_array();
        Self { from: local(from), to: local(to), power: S::pack(power.to_f32()) }
    }

    /// Its start, in metres from the maps' origin.
    pub fn start(&self) -> DVec3 {
        DVec3::from(self.from.map(f64::from))
    }

    /// Its end, in metres from the maps' origin.
    pub fn end(&self) -> DVec3 {
        DVec3::from(self.to.map(f64::from))
    }

    /// Its length, in metres.
    pub fn length(&self) -> f64 {
        (self.end() - self.start()).length()
    }

    /// The photon's power.
    pub fn power(&self) -> S::F32 {
        S::unpack(self.power)
    }
}
