//! One picture of parts that were rendered apart.
//!
//! A *pass* is a frame rendered with one seed, or with a share of its rays and photons; a *part* is one file: a pass, or
//! a crop of it. The crops of a pass must fill its display window once ([`check_coverage`]). One pass is pasted together,
//! with the values of the parts as they are. Several are averaged ([`PassMean`]) with a weight each that follows
//! from the work that was asked for ([`pass_weights`]).
//!
//! Parts are added one at a time. In memory is the whole picture: as f32 where it is pasted, and as f64 sums where passes are
//! averaged, one more a pixel than there are layers.

mod coverage;
mod pass_mean;
mod pasted;
mod variance;
mod weights;

use super::{Channels, Layers, Window};

pub use coverage::{CoverageError, check_coverage};
pub use pass_mean::PassMean;
pub use pasted::Pasted;
pub use weights::{PassWork, pass_weights};

/// A picture that parts are added to.
#[derive(Debug)]
pub enum LayerMerge {
    /// The crops of one pass.
    Pasted(Pasted),
    /// Several passes.
    Mean(PassMean),
}

impl LayerMerge {
    /// A picture of `size`, width and height, with `layers`, of so many `passes`.
    ///
    /// # Errors
    /// The name of a layer that cannot be averaged, where there are several passes.
    pub fn new(size: [u32; 2], layers: &[String], passes: usize) -> Result<Self, String> {
        if passes > 1 {
            PassMean::new(size, layers).map(Self::Mean)
        } else {
            Ok(Self::Pasted(Pasted::new(size, layers)))
        }
    }

    /// Begins a pass of `weight`. Passes come in an order that does not depend on that of the files: it is the order
    /// of summation.
    pub fn begin_pass(&mut self, weight: f64) {
        if let Self::Mean(mean) = self {
            mean.begin_pass(weight);
        }
    }

    /// Adds the part of the pass that lies in `window`.
    ///
    /// # Panics
    /// Where the part is not as large as `window`, or that reaches beyond the picture.
    pub fn add(&mut self, window: Window, part: &Layers) {
        match self {
            Self::Pasted(pasted) => pasted.add(window, part),
            Self::Mean(mean) => mean.add(window, part),
        }
    }

    /// The layers of the merged picture.
    pub fn finish(self) -> Channels {
        match self {
            Self::Pasted(pasted) => pasted.finish(),
            Self::Mean(mean) => mean.finish(),
        }
    }
}
