//! What a grid can hold.

use std::fmt::Debug;

use glam::{DVec2, DVec3};

/// A voxel's value: `f32` or `[f32; 3]`.
pub trait Voxel: Copy + Default + Debug + PartialEq + Send + Sync + 'static {
    /// The value as sampling hands it out.
    type Sample: Copy + Debug;

    /// Numbers a value.
    const COMPONENTS: usize;

    /// The value held by the first [`COMPONENTS`](Self::COMPONENTS) of these numbers.
    fn from_numbers(numbers: &[f32]) -> Self;

    /// The value in double precision.
    fn sample(self) -> Self::Sample;

    /// The value nearest to what sampling hands out.
    fn from_sample(sample: Self::Sample) -> Self;

    /// The trilinear blend of a cell's corners, numbered 4 x + 2 y + z, at `u` in [0, 1]³.
    fn blend(corners: [Self; 8], u: DVec3) -> Self::Sample;

    /// Smallest and largest component.
    fn range(self) -> [f32; 2];

    /// The bits of the value, to tell equal from equal without trusting NaN.
    fn bits(self) -> [u32; 3];

    /// The value with every NaN, infinite or negative component taken as 0.
    fn as_density(self) -> Self;

    /// The number statistics are made of: the scalar itself, a vector's length.
    fn magnitude(self) -> f64;
}

impl Voxel for f32 {
    type Sample = f64;
    const COMPONENTS: usize = 1;

    fn from_numbers(numbers: &[f32]) -> Self {
        numbers[0]
    }

    fn sample(self) -> f64 {
        f64::from(self)
    }

    fn from_sample(sample: f64) -> Self {
        sample as Self
    }

    #[inline]
    fn blend(c: [Self; 8], u: DVec3) -> f64 {
        // In pairs along z, which lie side by side in memory.
        let pair = |i: usize| DVec2::new(f64::from(c[i]), f64::from(c[i + 1]));
        let lerp = |a: DVec2, b: DVec2, w: f64| a + (b - a) * w;
        let (y0, y1) = (lerp(pair(0), pair(4), u.x), lerp(pair(2), pair(6), u.x));
        let z = lerp(y0, y1, u.y);
        z.x + (z.y - z.x) * u.z
    }

    fn range(self) -> [f32; 2] {
        [self, self]
    }

    fn bits(self) -> [u32; 3] {
        [self.to_bits(), 0, 0]
    }

    fn as_density(self) -> Self {
        if self >= 0.0 && self.is_finite() { self + 0.0 } else { 0.0 } // + 0.0 loses a minus zero
    }

    fn magnitude(self) -> f64 {
        f64::from(self)
    }
}

impl Voxel for [f32; 3] {
    type Sample = [f64; 3];
    const COMPONENTS: usize = 3;

    fn from_numbers(numbers: &[f32]) -> Self {
        [numbers[0], numbers[1], numbers[2]]
    }

    fn sample(self) -> [f64; 3] {
        self.map(f64::from)
    }

    fn from_sample(sample: [f64; 3]) -> Self {
        sample.map(|component| component as f32)
    }

    fn blend(corners: [Self; 8], u: DVec3) -> [f64; 3] {
        std::array::from_fn(|i| f32::blend(corners.map(|c| c[i]), u))
    }

    fn range(self) -> [f32; 2] {
        let [a, b, c] = self;
        [a.min(b).min(c), a.max(b).max(c)]
    }

    fn bits(self) -> [u32; 3] {
        self.map(f32::to_bits)
    }

    fn as_density(self) -> Self {
        self.map(Voxel::as_density)
    }

    fn magnitude(self) -> f64 {
        self.iter().map(|&c| f64::from(c).powi(2)).sum::<f64>().sqrt()
    }
}
