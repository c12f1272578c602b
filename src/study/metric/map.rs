//! One figure a pixel.

/// An error for every pixel of a picture, row 0 on top.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Row by row from the top.
    pub values: Vec<f32>,
}

impl Map {
    /// The average over all pixels.
    pub fn mean(&self) -> f64 {
        self.values.iter().map(|&v| f64::from(v)).sum::<f64>() / self.values.len() as f64
    }

    /// The share of pixels, 0 to 1, whose value is above `bound`.
    pub fn share_above(&self, bound: f32) -> f64 {
        self.values.iter().filter(|&&v| v > bound).count() as f64 / self.values.len() as f64
    }

    /// The average without the worst `share`, 0 to 1, of the pixels; at least one pixel is kept.
    pub fn trimmed_mean(&self, share: f64) -> f64 {
        let mut sorted = self.values.clone();
        sorted.sort_by(f32::total_cmp);
        let kept = ((sorted.len() as f64 * (1.0 - share)) as usize).max(1);
        sorted[..kept].iter().map(|&v| f64::from(v)).sum::<f64>() / kept as f64
    }
}
