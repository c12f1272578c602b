//! Differences between a centre and its surround over a dyadic Gaussian pyramid.

use std::iter;

use super::normalize::normalized;
use super::plane::Plane;

/// Levels of the pyramid at most: reductions by 1 to 256.
///
/// Unit: count. Source: Itti et al. 1998, section "Extraction of Early Visual Features".
const LEVELS: usize = 9;

/// Finest level of a centre in a large picture.
///
/// Unit: none. Source: as [`LEVELS`].
const FINEST_CENTRE: usize = 2;

/// Levels of centres.
///
/// Unit: count. Source: as [`LEVELS`].
const CENTRES: usize = 3;

/// Levels from a centre to its surrounds.
///
/// Unit: count. Source: as [`LEVELS`].
const SURROUNDS: [usize; 2] = [3, 4];

/// Least length in pixels of the shorter side of a picture at the level of its finest centre, for centres
/// above level 0.
///
/// Unit: pixels. Derivation: a picture as small as 256 pixels, about half as high as those of Itti et al.,
/// has all of their centres.
const FINEST_SIDE: usize = 64;

/// Largest difference of a channel from its surround, at any scale, that is nothing to see, as a share of
/// the display's range. N would blow rounding or the noise of a grey picture's hue up to the strength of
/// the other features.
///
/// Unit: none. Derivation: about the Weber fraction of brightness, a fiftieth.
const VISIBLE: f32 = 0.02;

/// Which levels of a dyadic pyramid are made and compared.
#[derive(Debug, Clone)]
pub struct Scales {
    /// Halvings before the finest level that is looked at.
    first: usize,
    /// Levels from there on.
    levels: usize,
    /// Centre and surround, counted from the finest level that is looked at.
    pairs: Vec<(usize, usize)>,
}

impl Scales {
    /// Centres 2, 3, 4 and surrounds 3 and 4 levels above (Itti et al. 1998), where the shorter side
    /// has at least 256 pixels. In a smaller picture the centres start at level 1 or 0, so that
    /// things are as large against the picture: below 256 and below 128 pixels. Halving ends at one
    /// pixel or at nine levels; a surround beyond the last level is the last level.
    pub fn new(width: usize, height: usize) -> Self {
        let halvings = width.max(height).next_power_of_two().ilog2() as usize;
        let last = halvings.min(LEVELS - 1);
        let finest = FINEST_SIDE.ilog2() as usize;
        let first = (width.min(height).ilog2() as usize).saturating_sub(finest).min(FINEST_CENTRE);
        let levels = last + 1 - first;
        let mut pairs: Vec<_> = (0..CENTRES)
            .flat_map(|centre| SURROUNDS.map(|delta| (centre, (centre + delta).min(levels - 1))))
            .filter(|(centre, surround)| centre < surround)
            .collect();
        pairs.dedup();
        Self { first, levels, pairs }
    }

    /// The levels of the Gaussian pyramid of `base` from the finest that is looked at.
    pub fn pyramid(&self, base: Plane) -> Vec<Plane> {
        let finest = (0..self.first).fold(base, |level, _| level.half());
        iter::successors(Some(finest), |level| Some(level.half())).take(self.levels).collect()
    }

    /// centre - surround of one channel for all pairs of scales (Itti et al. 1998, equations 1 to
    /// 4), from its pyramid.
    ///
    /// A double opponency is (R - G)(c) - (R - G)(s). Equation 2 swaps R and G in the surround,
    /// which read by the letter lets a red centre in a green surround cancel.
    pub fn features(&self, pyramid: &[Plane]) -> Features {
        let difference = |&(c, s): &(usize, usize)| difference(&pyramid[c], &pyramid[s]);
        let maps = self.pairs.iter().map(difference).collect();
        Features { width: pyramid[0].width, height: pyramid[0].height, maps }
    }
}

/// The differences between centre and surround of one channel.
#[derive(Debug, Clone)]
pub struct Features {
    /// Size of the finest centre.
    width: usize,
    height: usize,
    /// One for each pair of scales, at the size of its centre.
    maps: Vec<Plane>,
}

impl Features {
    /// The greatest difference at any scale.
    pub fn range(&self) -> f32 {
        range(&self.maps)
    }

    /// The sum of N of all differences across scales, at the size of the finest centre; `range` is
    /// what N scales to 1.
    ///
    /// Three departures from Itti et al. 1998 keep every target, as the table of
    /// `tests/check/saliency.py` shows:
    /// - Where the centre exceeds its surround and where it falls short go through N apart, as in
    ///   Frintrop 2006, "VOCUS". In the modulus one red bar among green ones on black is one of many.
    /// - The range that N scales to 1 is that of all scales, not of one map: a pair of scales at
    ///   which there is next to nothing to see stays next to nothing.
    /// - Maps are added at the finest centre instead of level 4, so that the greatest value falls on
    ///   the thing and not in a cell of 16 pixels: the director decides for single pixels.
    pub fn combined(&self, range: f32) -> Plane {
        let mut sum = Plane::zero(self.width, self.height);
        if range <= VISIBLE {
            return sum;
        }
        for map in &self.maps {
            for sign in [1.0, -1.0] {
                let part = normalized(map.map(|v| (sign * v).max(0.0)), range);
                sum.add(&part.enlarged(self.width, self.height));
            }
        }
        sum
    }
}

/// The greatest modulus in any of the maps.
pub fn range(maps: &[Plane]) -> f32 {
    maps.iter().map(Plane::greatest_modulus).fold(0.0, f32::max)
}

/// centre - surround, the surround interpolated to the centre's size.
fn difference(centre: &Plane, surround: &Plane) -> Plane {
    let mut map = surround.enlarged(centre.width, centre.height);
    for (value, c) in map.values.iter_mut().zip(&centre.values) {
        *value = c - *value;
    }
    map
}
