//! What is varied.

use serde::{Deserialize, Serialize};

/// One thing that a render's cost depends on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Axis {
    Photons,
    Pixels,
    Rays,
    Voxels,
    Thickness,
}

/// All of them.
pub const AXES: [Axis; 5] =
    [Axis::Photons, Axis::Pixels, Axis::Rays, Axis::Voxels, Axis::Thickness];

impl Axis {
    /// In words.
    pub const fn title(self) -> &'static str {
        match self {
            Self::Photons => "photons",
            Self::Pixels => "pixels",
            Self::Rays => "rays a pixel",
            Self::Voxels => "voxels",
            Self::Thickness => "optical thickness",
        }
    }

    /// What theory says of the slope.
    pub const fn expected(self) -> &'static str {
        match self {
            Self::Photons => {
                "paths 1, for they are independent; maps 1 and a little, for hierarchies are sorted; \
                 rays 0 to 0.2, for radii shrink so that each finds as many photons, and the edge \
                 of cells as N^(-1/5). The whole: the photons' share of the time"
            }
            Self::Pixels => {
                "rays 1, less where light kept on cells is found once; photons 0. The whole: the \
                 rays' share of the time"
            }
            Self::Rays => {
                "below 1: up to 4 rays of a pixel gather, of more only 4 do; photons 0. The whole: \
                 the rays' share of the time, times that"
            }
            Self::Voxels => {
                "1/3 at most: a line through n voxels in all crosses as many as n^(1/3), and blocks \
                 that are empty are skipped; flights of photons jump from collision to collision"
            }
            Self::Thickness => {
                "0 while thin, where most photons fly through; then up to 1, for a path scatters as \
                 often as the medium is thick, until absorption ends it after 1/(1 - albedo) times \
                 and rays see only the front. Where cells become thick light moves from the lattice \
                 to beams, at one step"
            }
        }
    }

    /// Slopes that the plot shows beside those measured.
    pub const fn guide(self) -> f64 {
        match self {
            Self::Voxels => 1.0 / 3.0,
            _ => 1.0,
        }
    }

    /// The values of a sweep, evenly spread by their logarithms.
    pub fn values(self, quick: bool) -> Vec<f64> {
        let (first, last, count) = match self {
            Self::Photons => (5e4, 8e5, 5),
            Self::Pixels => (4096.0, 131_072.0, 6), // sides 64 to 362
            Self::Rays => (2.0, 64.0, 6),
            Self::Voxels => (64.0, 512.0, 7), // along the longest side
            Self::Thickness => (0.125, 32.0, 9), // times that of the scene
        };
        let last = if quick { first * 4.0 } else { last };
        let (ratio, count): (f64, usize) = (last / first, if quick { 3 } else { count });
        let at = |i: usize| first * ratio.powf(i as f64 / (count - 1) as f64);
        (0..count).map(at).collect()
    }
}
