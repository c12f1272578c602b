//! Spectra of one or three channels: light is traced in one where all three are equal, and in three and those of each group
//! of emitters where these are told apart.

use std::fmt::Debug;
use std::iter::Sum;
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub};

use glam::{BVec3, Vec3A};

use super::{Group, GroupParts, MAX_GROUPS, Rgb};

/// Numbers of the widest spectrum: three channels, in all and of each group.
///
/// Unit: count. Definition: of the type.
pub const MOST_NUMBERS: usize = 3 * (1 + MAX_GROUPS);

/// Light or a coefficient per channel: [`Rgb`], one number that stands for three equal ones, or
/// [`GroupedRgb`](super::GroupedRgb).
/// Code that is generic over it does for one channel what it does for each of three, so that a grey
/// scene gives the same numbers either way.
pub trait Spectrum:
    Copy
    + Debug
    + Default
    + PartialEq
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + AddAssign
    + Sub<Output = Self>
    + Neg<Output = Self>
    + Mul<Output = Self>
    + MulAssign
    + Mul<f64, Output = Self>
    + MulAssign<f64>
    + Div<f64, Output = Self>
    + DivAssign<f64>
    + Sum
{
    /// How many channels there are.
    const CHANNELS: usize;
    /// How many numbers it is, from 1 to [`MOST_NUMBERS`]: those of its channels come first.
    const NUMBERS: usize = Self::CHANNELS;
    /// 0 in all.
    const ZERO: Self;
    /// 1 in all.
    const ONE: Self;

    /// The packed f32 form that bulk data is stored in.
    type Stored: Copy + Debug + Default + PartialEq + Send + Sync;
    /// The packed f32 form of the light of one emitter.
    type Single: Copy + Debug + PartialEq + Send + Sync;
    /// The f32 form for arithmetic.
    type F32: Copy
        + Debug
        + Default
        + Send
        + Sync
        + Add<Output = Self::F32>
        + AddAssign
        + Sum
        + Mul<f32, Output = Self::F32>
        + Div<f32, Output = Self::F32>;

    /// `color` as a spectrum; one of a single channel takes the first, which must equal the others.
    fn from_rgb(color: Rgb) -> Self;
    /// `color` as light of emitters of this group.
    fn of_group(color: Rgb, _group: Group) -> Self {
        Self::from_rgb(color)
    }
    /// A coefficient as light of emitters of this group; what is light keeps its parts.
    #[must_use]
    fn in_group(self, _group: Group) -> Self {
        self
    }
    /// The same, whose order of scattering is so much higher, where its parts are [`ORDERS`](super::ORDERS).
    #[must_use]
    fn raised(self, _orders: u8) -> Self {
        self
    }
    /// The parts of it that groups of emitters or orders of scattering have, where they are told apart.
    fn parts(self) -> Option<GroupParts> {
        None
    }
    /// The spectrum as a colour; a single channel stands for three.
    fn rgb(self) -> Rgb;
    /// The channel `index`, from 0 to [`CHANNELS`](Self::CHANNELS) - 1.
    fn channel(self, index: usize) -> f64;
    /// Applies `f` to each channel.
    #[must_use]
    fn map(self, f: impl Fn(f64) -> f64) -> Self;
    /// Rounds to f32.
    fn to_f32(self) -> Self::F32;
    /// Widens from f32.
    fn to_f64(value: Self::F32) -> Self;
    /// Packs for storage.
    fn pack(value: Self::F32) -> Self::Stored;
    /// Unpacks from storage.
    fn unpack(stored: Self::Stored) -> Self::F32;
    /// Packs light of one emitter.
    fn pack_single(value: Self::F32) -> Self::Single;
    /// Unpacks light of one emitter.
    fn unpack_single(single: Self::Single) -> Self::F32;
    /// The number `index`, below [`NUMBERS`](Self::NUMBERS).
    fn number(self, index: usize) -> f64 {
        self.channel(index)
    }
    /// That of these numbers, which `f` is called for by index.
    fn from_numbers(f: impl Fn(usize) -> f64) -> Self;
    /// Builds an f32 spectrum of these numbers, which `f` is called for by index.
    fn from_numbers_f32(f: impl Fn(usize) -> f32) -> Self::F32;
    /// The number `index` of an f32 spectrum.
    fn number_f32(value: Self::F32, index: usize) -> f32;
    /// Sum over the three channels of the colour.
    fn element_sum(self) -> f64;
    /// The largest channel.
    fn max_element(self) -> f64;
    /// Mask of the colour's channels that are above 0.
    fn nonzero(self) -> BVec3;

    /// `value` in all channels.
    fn splat(value: f64) -> Self {
        Self::ONE * value
    }

    /// exp of each channel.
    #[must_use]
    fn exp(self) -> Self {
        self.map(f64::exp)
    }

    /// Clamps negative channels to 0.
    #[must_use]
    fn not_negative(self) -> Self {
        self.map(|value| value.max(0.0))
    }

    /// Whether all channels are finite.
    fn is_finite(self) -> bool {
        self.rgb().is_finite()
    }
}

impl Spectrum for Rgb {
    const CHANNELS: usize = 3;
    const ZERO: Self = Self::ZERO;
    const ONE: Self = Self::ONE;

    type Stored = [f32; 3];
    type Single = [f32; 3];
    type F32 = Vec3A;

    fn from_rgb(color: Rgb) -> Self {
        color
    }

    fn rgb(self) -> Rgb {
        self
    }

    fn channel(self, index: usize) -> f64 {
        self[index]
    }

    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Self::new(f(self.x), f(self.y), f(self.z))
    }

    fn to_f32(self) -> Vec3A {
        self.as_vec3a()
    }

    fn to_f64(value: Vec3A) -> Self {
        value.as_dvec3()
    }

    fn pack(value: Vec3A) -> [f32; 3] {
        value.to_array()
    }

    fn unpack(stored: [f32; 3]) -> Vec3A {
        Vec3A::from(stored)
    }

    fn pack_single(value: Vec3A) -> [f32; 3] {
        value.to_array()
    }

    fn unpack_single(single: [f32; 3]) -> Vec3A {
        Vec3A::from(single)
    }

    fn from_numbers(f: impl Fn(usize) -> f64) -> Self {
        Self::new(f(0), f(1), f(2))
    }

    fn from_numbers_f32(f: impl Fn(usize) -> f32) -> Vec3A {
        Vec3A::new(f(0), f(1), f(2))
    }

    fn number_f32(value: Vec3A, index: usize) -> f32 {
        value[index]
    }

    fn element_sum(self) -> f64 {
        Self::element_sum(self)
    }

    fn max_element(self) -> f64 {
        Self::max_element(self)
    }

    fn nonzero(self) -> BVec3 {
        self.cmpgt(Self::ZERO)
    }
}

impl Spectrum for f64 {
    const CHANNELS: usize = 1;
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;

    type Stored = f32;
    type Single = f32;
    type F32 = f32;

    fn from_rgb(color: Rgb) -> Self {
        color.x
    }

    fn rgb(self) -> Rgb {
        Rgb::splat(self)
    }

    fn channel(self, _: usize) -> f64 {
        self
    }

    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        f(self)
    }

    fn to_f32(self) -> f32 {
        self as f32
    }

    fn to_f64(value: f32) -> Self {
        Self::from(value)
    }

    fn pack(value: f32) -> f32 {
        value
    }

    fn unpack(stored: f32) -> f32 {
        stored
    }

    fn pack_single(value: f32) -> f32 {
        value
    }

    fn unpack_single(single: f32) -> f32 {
        single
    }

    fn from_numbers(f: impl Fn(usize) -> f64) -> Self {
        f(0)
    }

    fn from_numbers_f32(f: impl Fn(usize) -> f32) -> f32 {
        f(0)
    }

    fn number_f32(value: f32, _: usize) -> f32 {
        value
    }

    fn element_sum(self) -> f64 {
        self + self + self // rounded as for three
    }

    fn max_element(self) -> f64 {
        self
    }

    fn nonzero(self) -> BVec3 {
        BVec3::splat(self > 0.0)
    }
}
