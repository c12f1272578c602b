//! Ratios with their intervals.

use serde::{Deserialize, Serialize};

use super::markdown::{decimals, range};

/// A ratio of means over seeds.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct Ratio {
    /// The ratio.
    pub ratio: f64,
    /// Its interval of 95 %.
    pub interval: [f64; 2],
}

impl Ratio {
    /// Both in so many decimals.
    pub fn cell(&self, digits: usize) -> String {
        format!("{} ({})", decimals(self.ratio, digits), range(Some(self.interval), digits))
    }
}
