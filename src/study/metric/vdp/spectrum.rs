//! Filtering by the Fourier transform.

use std::sync::Arc;

use rayon::prelude::*;
use rustfft::num_complex::Complex64;
use rustfft::{Fft, FftPlanner};

/// The Fourier transform of a picture continued by its mirror image to the right and below, which
/// repeats without a jump.
pub(super) struct Spectrum {
    width: usize,
    height: usize,
    /// Column by column, each over all vertical frequencies.
    columns: Vec<Complex64>,
    row_inverse: Arc<dyn Fft<f64>>,
    column_inverse: Arc<dyn Fft<f64>>,
}

impl Spectrum {
    /// Transforms `picture`, row by row.
    pub(super) fn from_image(picture: Vec<Complex64>, width: usize, height: usize) -> Self {
        let (across, down) = (2 * width, 2 * height);
        let mut planner = FftPlanner::new();
        let [row, column] = [across, down].map(|n| planner.plan_fft_forward(n));

        let mut rows = vec![Complex64::ZERO; across * height];
        rows.par_chunks_exact_mut(across).zip(picture.par_chunks_exact(width)).for_each(
            |(out, pixels)| {
                mirror(pixels, out);
                row.process(out);
            },
        );
        let halves = transposed(&rows, across);
        let mut columns = vec![Complex64::ZERO; across * down];
        columns.par_chunks_exact_mut(down).zip(halves.par_chunks_exact(height)).for_each(
            |(out, half)| {
                mirror(half, out);
                column.process(out);
            },
        );
        let [row_inverse, column_inverse] = [across, down].map(|n| planner.plan_fft_inverse(n));
        Self { width, height, columns, row_inverse, column_inverse }
    }

    /// Multiplies by a real, even function of frequency in cycles a pixel, x first. Real and
    /// imaginary part of the picture stay apart; at 1/2, which is its own negative, a mirrored
    /// picture has nothing.
    pub(super) fn multiply(&mut self, gain: impl Fn(f64, f64) -> f64 + Sync) {
        let down = 2 * self.height;
        let across = 2 * self.width;
        self.columns.par_chunks_exact_mut(down).enumerate().for_each(|(x, column)| {
            let fx = frequency(x, across);
            for (y, value) in column.iter_mut().enumerate() {
                *value *= gain(fx, frequency(y, down));
            }
        });
    }

    /// The picture, row by row, after a filter as in [`multiply`](Self::multiply).
    pub(super) fn filtered(&self, gain: impl Fn(f64, f64) -> f64 + Sync) -> Vec<Complex64> {
        let (across, down) = (2 * self.width, 2 * self.height);
        let mut halves = vec![Complex64::ZERO; across * self.height];
        let columns = self.columns.par_chunks_exact(down).enumerate();
        halves.par_chunks_exact_mut(self.height).zip(columns).for_each_init(
            || vec![Complex64::ZERO; down],
            |column, (half, (x, spectrum))| {
                let fx = frequency(x, across);
                for (y, (out, value)) in column.iter_mut().zip(spectrum).enumerate() {
                    *out = value * gain(fx, frequency(y, down));
                }
                if column.iter().any(|v| *v != Complex64::ZERO) {
                    self.column_inverse.process(column);
                    half.copy_from_slice(&column[..self.height]);
                }
            },
        );
        let mut rows = transposed(&halves, self.height);
        let scale = 1.0 / (across * down) as f64;
        let mut picture = vec![Complex64::ZERO; self.width * self.height];
        let pixels = picture.par_chunks_exact_mut(self.width);
        rows.par_chunks_exact_mut(across).zip(pixels).for_each(|(row, out)| {
            self.row_inverse.process(row);
            for (out, value) in out.iter_mut().zip(row) {
                *out = *value * scale;
            }
        });
        picture
    }
}

/// The frequency of a bin in cycles a pixel, -1/2 to 1/2.
fn frequency(bin: usize, bins: usize) -> f64 {
    let bin = if 2 * bin > bins { bin as f64 - bins as f64 } else { bin as f64 };
    bin / bins as f64
}

/// Writes values and their mirror image behind them.
fn mirror(values: &[Complex64], out: &mut [Complex64]) {
    let (head, tail) = out.split_at_mut(values.len());
    head.copy_from_slice(values);
    tail.copy_from_slice(values);
    tail.reverse();
}

/// Rows of `width` values to rows of what were columns.
fn transposed(values: &[Complex64], width: usize) -> Vec<Complex64> {
    let height = values.len() / width;
    let mut out = vec![Complex64::ZERO; values.len()];
    out.par_chunks_exact_mut(height).enumerate().for_each(|(x, column)| {
        for (out, value) in column.iter_mut().zip(values[x..].iter().step_by(width)) {
            *out = *value;
        }
    });
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 5 x 3 pixels.
    fn picture() -> Vec<Complex64> {
        (0..15).map(|i| Complex64::new(f64::from(i * i % 7), f64::from(i))).collect()
    }

    fn close(a: &[Complex64], b: &[Complex64]) -> bool {
        a.iter().zip(b).all(|(a, b)| (a - b).norm() < 1e-12)
    }

    #[test]
    fn a_filter_of_one_gives_the_picture_back() {
        assert!(close(&Spectrum::from_image(picture(), 5, 3).filtered(|_, _| 1.0), &picture()));
    }

    #[test]
    fn frequency_zero_is_the_mean() {
        let spectrum = Spectrum::from_image(picture(), 5, 3);
        let flat = spectrum.filtered(|x, y| f64::from(u8::from(x == 0.0 && y == 0.0)));
        let mean = picture().iter().sum::<Complex64>() / 15.0;
        assert!(close(&flat, &[mean; 15]));
    }

    #[test]
    fn real_even_filters_keep_the_parts_apart() {
        let mut whole = Spectrum::from_image(picture(), 5, 3);
        whole.multiply(|x, y| (-9.0 * (x * x + 2.0 * y * y)).exp());
        let real = picture().iter().map(|v| Complex64::from(v.re)).collect();
        let alone = Spectrum::from_image(real, 5, 3);
        let alone = alone.filtered(|x, y| (-9.0 * (x * x + 2.0 * y * y)).exp());
        let whole: Vec<_> =
            whole.filtered(|_, _| 1.0).iter().map(|v| Complex64::from(v.re)).collect();
        assert!(close(&whole, &alone));
    }
}
