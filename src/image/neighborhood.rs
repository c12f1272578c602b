//! The pixels around each pixel of a picture, and means over them.

use rayon::prelude::*;

/// The pixels at most `reach` columns and rows from one of a map of the size (width, height), itself among them.
pub fn within(
    [width, height]: [usize; 2],
    pixel: usize,
    reach: usize,
) -> impl Iterator<Item = usize> {
    let (x, y) = (pixel % width, pixel / width);
    let rows = y.saturating_sub(reach)..height.min(y + reach + 1);
    rows.flat_map(move |row| {
        let columns = x.saturating_sub(reach)..width.min(x + reach + 1);
        columns.map(move |column| row * width + column)
    })
}

/// The mean of `values` over the pixels [`within`] `reach` of each.
pub fn averages(size: [usize; 2], values: &[f64], reach: usize) -> Vec<f64> {
    let average = |pixel: usize| {
        let near = within(size, pixel, reach).map(|near| values[near]);
        let (sum, count) = near.fold((0.0, 0.0), |(sum, count), v| (sum + v, count + 1.0));
        sum / count
    };
    (0..values.len()).into_par_iter().map(average).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_is_averaged_as_far_as_the_picture_goes() {
        let mut values = vec![0.0; 10 * 9];
        values[4 * 10 + 5] = 49.0;
        let found = averages([10, 9], &values, 3);
        // Column, row and the pixels of the square about it.
        for (x, y, pixels) in [(5, 4, 49.0), (2, 7, 30.0), (8, 4, 35.0), (5, 1, 35.0)] {
            assert!((found[y * 10 + x] - 49.0 / pixels).abs() < 1e-12, "{x} {y}: {found:?}");
        }
        assert_eq!([found[4 * 10 + 9], found[4 * 10 + 1], found[0]], [0.0; 3]);
        assert!(averages([3, 2], &[7.0; 6], 3).iter().all(|v| (v - 7.0_f64).abs() < 1e-12));
    }
}
