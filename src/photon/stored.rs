//! Stored photons.

use std::fmt::Debug;

use glam::DVec3;

use crate::math::{Rgb, Spectrum, WorldPoint, warp};
use crate::medium::Phase;

/// A photon without its position: 16 bytes in colour and with its direction, 4 without either.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Photon<S: Spectrum = Rgb, H = Octahedral> {
    power: S::Single,
    direction: H,
}

impl<S: Spectrum, H: PhotonDirection> Photon<S, H> {
    /// A photon of `power` (W on surfaces, W m in media, or a unit of the map's of it) that flew
    /// along the unit `direction`.
    pub fn new(power: S, direction: DVec3) -> Self {
        Self { power: S::pack_single(power.to_f32()), direction: H::new(direction) }
    }

    /// Its power in the unit that it was made with: in a medium power times length, the power over the
    /// rate of deposits there.
    pub fn power(&self) -> S {
        S::to_f64(S::unpack_single(self.power))
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

    /// What is stored, as a number for a file.
    fn to_bits(self) -> u32;

    /// The direction of which [`to_bits`](Self::to_bits) made this number.
    fn from_bits(bits: u32) -> Self;
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

    fn to_bits(self) -> u32 {
        let [x, y] = self.0.map(|v| u32::from(v as u16));
        x | y << 16
    }

    fn from_bits(bits: u32) -> Self {
        Self([bits as u16 as i16, (bits >> 16) as i16])
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

    fn to_bits(self) -> u32 {
        0
    }

    fn from_bits(_: u32) -> Self {
        Self
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
    /// Bytes of it in a file.
    ///
    /// Unit: bytes. Definition: 32 bits for each coordinate and channel, and for the direction where that is stored.
    pub(super) const FILE_BYTES: usize = 4 * (3 + S::CHANNELS + H::KNOWN as usize);

    /// Writes its bits to `bytes`, of which there are [`FILE_BYTES`](Self::FILE_BYTES).
    pub(super) fn write(&self, bytes: &mut [u8]) {
        let Photon { power, direction } = self.photon;
        let power = S::unpack_single(power);
        let channels = (0..S::CHANNELS).map(|channel| S::number_f32(power, channel));
        let numbers = self.place.into_iter().chain(channels).map(f32::to_bits);
        let words = numbers.chain(H::KNOWN.then(|| direction.to_bits()));
        for (bytes, word) in bytes.chunks_exact_mut(4).zip(words) {
            bytes.copy_from_slice(&word.to_le_bytes());
        }
    }

    /// The photon that [`write`](Self::write) wrote.
    pub(super) fn read(bytes: &[u8]) -> Self {
        let word = |index: usize| {
            let bytes = &bytes[4 * index..4 * index + 4];
            u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])
        };
        let number = |index: usize| f32::from_bits(word(index));
        let power = S::pack_single(S::from_numbers_f32(|channel| {
            if channel < S::CHANNELS { number(3 + channel) } else { 0.0 }
        }));
        let direction = H::from_bits(if H::KNOWN { word(3 + S::CHANNELS) } else { 0 });
        Self { place: [0, 1, 2].map(number), photon: Photon { power, direction } }
    }

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

#[cfg(test)]
mod tests {
    use super::*;

    fn check<S: Spectrum, H: PhotonDirection>(power: S) {
        let direction = DVec3::new(-0.3, 0.4, -0.87).normalize();
        let photon =
            PhotonAt { place: [1.5, -2e-9, 3e7], photon: Photon::<S, H>::new(power, direction) };
        let mut bytes = vec![0xff; PhotonAt::<S, H>::FILE_BYTES];
        photon.write(&mut bytes);
        let read = PhotonAt::<S, H>::read(&bytes);
        assert_eq!((read.place, read.photon.power()), (photon.place, photon.photon.power()));
        let bits = |photon: &PhotonAt<S, H>| photon.photon.stored_direction().to_bits();
        assert_eq!(bits(&read), bits(&photon));
    }

    #[test]
    fn photons_in_files_keep_every_bit() {
        check::<Rgb, Octahedral>(Rgb::new(0.1, 2e-30, 7.0));
        check::<Rgb, NoDirection>(Rgb::new(0.1, 2e-30, 7.0));
        check::<f64, Octahedral>(0.3);
        check::<f64, NoDirection>(0.3);
        assert_eq!(
            [PhotonAt::<Rgb, Octahedral>::FILE_BYTES, PhotonAt::<f64, NoDirection>::FILE_BYTES],
            [28, 16]
        );
    }
}
