//! One channel of a picture, and its resampling to another size.

use fast_image_resize::images::{TypedImage, TypedImageRef};
use fast_image_resize::pixels::F32;
use fast_image_resize::{Filter, FilterType, ResizeAlg, ResizeOptions, Resizer};

/// One value a pixel, row 0 on top.
#[derive(Debug, Clone)]
pub struct Plane {
    pub width: usize,
    pub height: usize,
    pub values: Vec<f32>,
}

impl Plane {
    pub fn new(width: usize, height: usize, values: Vec<f32>) -> Self {
        debug_assert_eq!(values.len(), width * height);
        Self { width, height, values }
    }

    pub fn zero(width: usize, height: usize) -> Self {
        Self::new(width, height, vec![0.0; width * height])
    }

    /// The next level of a dyadic Gaussian pyramid: half as wide and high, rounded up, each value a
    /// Gaussian mean with a standard deviation of one pixel of this level.
    pub fn half(&self) -> Self {
        self.resampled(self.width.div_ceil(2), self.height.div_ceil(2), FilterType::Gaussian)
    }

    /// The plane interpolated to a larger size by the uniform cubic B-spline: smooth in value and
    /// slope, and never beyond the values that it mixes.
    pub fn enlarged(&self, width: usize, height: usize) -> Self {
        let spline = Filter::new("cubic B-spline", cubic_b_spline, 2.0);
        let spline = spline.expect("a support of 2 is valid");
        self.resampled(width, height, FilterType::Custom(spline))
    }

    /// Adds `other`, which has the same size.
    pub fn add(&mut self, other: &Self) {
        debug_assert_eq!((self.width, self.height), (other.width, other.height));
        for (value, more) in self.values.iter_mut().zip(&other.values) {
            *value += more;
        }
    }

    /// Each value through `f`.
    pub fn map(&self, f: impl Fn(f32) -> f32) -> Self {
        Self::new(self.width, self.height, self.values.iter().map(|&v| f(v)).collect())
    }

    /// The greatest absolute value.
    pub fn greatest_modulus(&self) -> f32 {
        self.values.iter().fold(0.0, |greatest, v| v.abs().max(greatest))
    }

    /// Both planes cover the same area, edge to edge. Weights that would fall outside are left out
    /// and the rest scaled up to 1, so that a border is nothing to see. Sums are f64 and unfused:
    /// the vector unit that is found makes no difference beyond the order of a sum.
    fn resampled(&self, width: usize, height: usize, filter: FilterType) -> Self {
        if (width, height) == (self.width, self.height) {
            return self.clone();
        }
        let pixels: Vec<F32> = self.values.iter().copied().map(F32::new).collect();
        let size = |c: usize| u32::try_from(c).expect("a side of an image fits 32 bits");
        let source = TypedImageRef::new(size(self.width), size(self.height), &pixels)
            .expect("a plane has as many values as its size says");
        let mut target = TypedImage::<F32>::new(size(width), size(height));
        let options = ResizeOptions::new().resize_alg(ResizeAlg::Convolution(filter));
        Resizer::new()
            .resize_typed(&source, &mut target, &options)
            .expect("the whole source is a valid crop");
        Self::new(width, height, target.pixels().iter().map(|p| p.0).collect())
    }
}

/// The uniform cubic B-spline, around 0.
fn cubic_b_spline(x: f64) -> f64 {
    let x = x.abs();
    if x < 1.0 {
        (4.0 - 6.0 * x * x + 3.0 * x * x * x) / 6.0
    } else if x < 2.0 {
        (2.0 - x).powi(3) / 6.0
    } else {
        0.0
    }
}
