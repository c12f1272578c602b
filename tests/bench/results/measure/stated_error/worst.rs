//! The true error of the worst blocks of a picture, counted apart from the renderer's own statement.

use fogbow::math::luminance;

use crate::measure::halves::{Pixels, mean, mean_of};

/// Pixels along each side of a block.
const BLOCK: usize = 8;

/// Pixels along each side of the blocks whose brightness is compared.
const COARSE: usize = 16;

/// Blocks for each of the worst.
const BLOCKS_PER_WORST: usize = 100;

/// Errors are relative to the mean radiance of the block and this share of that of the picture.
const EPSILON: f64 = 0.5;

/// Two pictures of the truth with as much less noise, `width` pixels in a row.
pub struct Truths {
    width: usize,
    /// Luminances of both.
    halves: [Vec<f64>; 2],
    /// What squared errors of each block are relative to.
    scales: Vec<f64>,
}

impl Truths {
    /// These two.
    pub fn new(halves: [&Pixels; 2], width: usize) -> Self {
        let light = luminances(&mean_of(halves.into_iter()));
        let whole = mean(&light);
        let blocks = block_means(&light, width, BLOCK);
        let scales = blocks.iter().map(|own| own.powi(2) + (EPSILON * whole).powi(2)).collect();
        Self { width, halves: halves.map(luminances), scales }
    }

    /// Mean squared error of the worst blocks of `picture`: the product of its differences from both truths, which is in the
    /// mean its squared error alone. The worst are chosen by these products, which favours blocks where the truths' noise adds
    /// to them, and by the difference from the mean of `others`, rendered as it was, which misses some: the mean of both.
    pub fn worst_square(&self, picture: &Pixels, others: &Pixels) -> f64 {
        let own = luminances(picture);
        let [a, b] = self.halves.each_ref().map(|half| minus(&own, half));
        let apart = minus(&own, &luminances(others));
        let squares = self.squares(&a, &b);
        let chosen =
            [worst_of(&squares, &squares), worst_of(&squares, &self.squares(&apart, &apart))];
        mean(&chosen)
    }

    /// Mean relative products of each block.
    fn squares(&self, a: &[f64], b: &[f64]) -> Vec<f64> {
        let products: Vec<f64> = a.iter().zip(b).map(|(a, b)| a * b).collect();
        let means = block_means(&products, self.width, BLOCK);
        means.iter().zip(&self.scales).map(|(mean, scale)| mean / scale).collect()
    }
}

/// The mean over the worst hundredth of `squares`, where `by` is largest.
fn worst_of(squares: &[f64], by: &[f64]) -> f64 {
    let mut order: Vec<usize> = (0..squares.len()).collect();
    order.sort_by(|&p, &q| by[q].total_cmp(&by[p]));
    order.truncate(squares.len().div_ceil(BLOCKS_PER_WORST));
    mean(&order.iter().map(|&block| squares[block]).collect::<Vec<f64>>())
}

/// Luminance of each pixel.
fn luminances(pixels: &Pixels) -> Vec<f64> {
    pixels.iter().map(|&pixel| luminance(pixel.into())).collect()
}

/// The differences of two pictures.
fn minus(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

/// The means over the blocks of `side` x `side` of a picture with `width` pixels in a row, those at its right and lower edge
/// with fewer.
fn block_means(values: &[f64], width: usize, side: usize) -> Vec<f64> {
    let rows: Vec<&[f64]> = values.chunks(width).collect();
    let mut means = Vec::new();
    for rows in rows.chunks(side) {
        for left in (0..width).step_by(side) {
            let columns = left..width.min(left + side);
            let block: Vec<f64> =
                rows.iter().flat_map(|row| &row[columns.clone()]).copied().collect();
            means.push(mean(&block));
        }
    }
    means
}

/// The luminance of a picture in blocks of 16 x 16 pixels.
pub fn coarse(picture: &Pixels, width: usize) -> Pixels {
    let means = block_means(&luminances(picture), width, COARSE);
    means.into_iter().map(|mean| [mean; 3]).collect()
}
