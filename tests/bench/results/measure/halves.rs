//! Two independent pictures of the truth, and errors against both.
//!
//! The product of a picture's differences from both is in the mean its squared error alone, for the
//! noise of one has nothing to do with that of the other.

use fogbow::image::Image;

use crate::pages::Result;

/// Squared errors are relative to the squared radiance and that of this share of the mean radiance, as in
/// studies.
const EPSILON: f64 = 0.5;

/// Share of the pixels, the worst ones, that a trimmed mean leaves out.
const TRIM: f64 = 0.002;

/// Radiance of each pixel.
pub type Pixels = Vec<[f64; 3]>;

/// Both pictures of the truth.
pub struct Halves {
    halves: [Pixels; 2],
    /// What the squared error of a pixel is relative to.
    scales: Vec<f64>,
}

impl Halves {
    /// These two.
    ///
    /// # Errors
    /// Where both are black.
    pub fn new(halves: [Pixels; 2]) -> Result<Self> {
        let [a, b] = &halves;
        let total = 0.5 * halves.iter().flatten().flatten().sum::<f64>();
        let epsilon = EPSILON * total / (3.0 * a.len() as f64);
        if epsilon <= 0.0 {
            return Err("the truth is black".into());
        }
        let grey = |(a, b): (&[f64; 3], &[f64; 3])| a.iter().chain(b).sum::<f64>() / 6.0;
        let scales = a.iter().zip(b).map(|pair| grey(pair).powi(2) + epsilon * epsilon).collect();
        Ok(Self { halves, scales })
    }

    /// Each of the two.
    pub fn pictures(&self) -> &[Pixels; 2] {
        &self.halves
    }

    /// The mean of both.
    pub fn mean(&self) -> Pixels {
        mean_of(self.halves.iter())
    }

    /// Trimmed relative squared error of the mean of both.
    pub fn error(&self) -> f64 {
        let [a, b] = &self.halves;
        0.25 * trimmed_mean(self.squares(a, b))
    }

    /// Trimmed and untrimmed relative squared error of `picture`.
    pub fn errors_of(&self, picture: &Pixels) -> [f64; 2] {
        let errors = self.squared_errors(picture);
        let whole = mean(&errors);
        [trimmed_mean(errors), whole]
    }

    /// The same of each of `pictures`.
    pub fn errors_of_each(&self, pictures: &[Pixels]) -> [Vec<f64>; 2] {
        let errors = pictures.iter().map(|picture| self.errors_of(picture));
        let (trimmed, whole) = errors.map(|[trimmed, whole]| (trimmed, whole)).unzip();
        [trimmed, whole]
    }

    /// Trimmed relative squared error of `picture`, in which pixels count by `weights`.
    pub fn weighted_error(&self, picture: &Pixels, weights: &[f32]) -> f64 {
        let total: f64 = weights.iter().copied().map(f64::from).sum();
        let count = weights.len() as f64;
        let errors = self.squared_errors(picture);
        let weighted = errors.iter().zip(weights);
        trimmed_mean(weighted.map(|(of, weight)| of * f64::from(*weight) * count / total).collect())
    }

    /// Relative squared bias of each pixel of `pictures`, which differ in their seeds: the mean over all
    /// pairs of different ones of the product of their differences from different halves.
    pub fn squared_bias<'a>(&self, pictures: impl Iterator<Item = &'a Pixels>) -> Vec<f64> {
        let mut sums = [(); 2].map(|()| vec![[0.0; 3]; self.pixels()]);
        let mut same = vec![0.0; self.pixels()];
        let mut count = 0.0;
        for picture in pictures {
            count += 1.0;
            let differences = self.differences(picture);
            let products = self.products(&differences[0], &differences[1]);
            same.iter_mut().zip(products).for_each(|(sum, product)| *sum += product);
            for (sums, differences) in sums.iter_mut().zip(&differences) {
                for (sum, difference) in sums.iter_mut().zip(differences) {
                    *sum = [0, 1, 2].map(|c| sum[c] + difference[c]);
                }
            }
        }
        let all = self.products(&sums[0], &sums[1]);
        let pairs: f64 = count * (count - 1.0);
        all.iter().zip(&same).map(|(all, same)| (all - same) / pairs).collect()
    }

    /// Relative squared difference of each pixel of two pictures.
    pub fn squares(&self, a: &Pixels, b: &Pixels) -> Vec<f64> {
        let differences = minus(a, b);
        self.products(&differences, &differences)
    }

    /// Relative squared difference of each pixel of two ways, each of which has two independent pictures.
    pub fn squared_difference(&self, a: &[Pixels; 2], b: &[Pixels; 2]) -> Vec<f64> {
        let [first, second] = [0, 1].map(|half| minus(&a[half], &b[half]));
        self.products(&first, &second)
    }

    /// How many pixels there are.
    pub fn pixels(&self) -> usize {
        self.scales.len()
    }

    /// How much brighter `pictures` are, in %.
    pub fn brighter_percent(&self, pictures: &[Pixels]) -> f64 {
        let totals: Vec<f64> = pictures.iter().map(|p| p.iter().flatten().sum()).collect();
        let total = 0.5 * self.halves.iter().flatten().flatten().sum::<f64>();
        100.0 * (mean(&totals) / total - 1.0)
    }

    /// Relative squared error of each pixel of `picture`.
    fn squared_errors(&self, picture: &Pixels) -> Vec<f64> {
        let [from_a, from_b] = self.differences(picture);
        self.products(&from_a, &from_b)
    }

    /// Differences of a picture from each of the two.
    fn differences(&self, picture: &Pixels) -> [Pixels; 2] {
        self.halves.each_ref().map(|half| minus(picture, half))
    }

    /// For each pixel the mean over channels of the products of both differences, relative.
    fn products(&self, a: &[[f64; 3]], b: &[[f64; 3]]) -> Vec<f64> {
        let pairs = a.iter().zip(b).zip(&self.scales);
        pairs
            .map(|((a, b), scale)| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() / 3.0 / scale)
            .collect()
    }
}

/// The pixels of a picture.
pub fn wide(image: &Image) -> Pixels {
    image.pixels().iter().map(|pixel| pixel.map(f64::from)).collect()
}

/// The picture of pixels, `width` in a row.
pub fn narrow(pixels: &Pixels, width: usize) -> Image {
    let narrow = pixels.iter().map(|pixel| pixel.map(|v| v as f32)).collect();
    Image::new(width, pixels.len() / width, narrow)
}

/// The mean of pictures.
pub fn mean_of<'a>(pictures: impl Iterator<Item = &'a Pixels>) -> Pixels {
    let mut count = 0.0;
    let mut sums = Pixels::new();
    for picture in pictures {
        count += 1.0;
        sums.resize(picture.len(), [0.0; 3]);
        for (sum, pixel) in sums.iter_mut().zip(picture) {
            *sum = [0, 1, 2].map(|c| sum[c] + pixel[c]);
        }
    }
    sums.iter().map(|sum| sum.map(|v| v / count)).collect()
}

/// The difference of two pictures.
fn minus(a: &Pixels, b: &Pixels) -> Pixels {
    a.iter().zip(b).map(|(a, b)| [0, 1, 2].map(|c| a[c] - b[c])).collect()
}

/// Mean without the largest magnitudes: one firefly can outweigh a whole picture.
pub fn trimmed_mean(mut values: Vec<f64>) -> f64 {
    values.sort_by(|p, q| p.abs().total_cmp(&q.abs()));
    let left = (values.len() as f64 * (1.0 - TRIM)).ceil() as usize;
    mean(&values[..left])
}

/// The mean.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}
