//! What is varied.

/// One thing that a render's cost depends on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
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

    /// The stage that does the work, as in [`STAGES`](super::STAGES): paths of photons or rays.
    pub const fn stage(self) -> usize {
        match self {
            Self::Photons => 0,
            Self::Pixels | Self::Rays | Self::Voxels | Self::Thickness => 2,
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
