//! Differences between a centre and its surround over a dyadic Gaussian pyramid.

use std::iter;

use super::normalize::normalized;
use super::plane::Plane;

/// Levels of the pyramid at most: reductions by 1 to 256.
const LEVELS: usize = 9;

/// A feature that differs from its surround by no more, at any scale, holds nothing to see: a fiftieth
/// of the display's range, about the Weber fraction of brightness. N would blow rounding or the
/// noise of a grey picture's hue up to the strength of the other features.
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
    pub fn of(width: usize, height: usize) -> Self {
        let halvings = width.max(height).next_power_of_two().ilog2() as usize;
        let last = halvings.min(LEVELS - 1);
        let first = (width.min(height).ilog2() as usize).saturating_sub(6).min(2);
        let levels = last + 1 - first;
        let mut pairs: Vec<_> = (0..3)
            .flat_map(|centre| [3, 4].map(|delta| (centre, (centre + delta).min(levels - 1))))
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

    /// For each channel of one feature (its pyramid from the finest level), the sum of
    /// N(centre - surround) over all pairs, at the size of the finest level.
    ///
    /// Itti et al. 1998, equations 1 to 4, with four departures that make one odd thing stand out
    /// wherever it is:
    /// - Where the centre exceeds its surround and where it falls short go through N apart, as in
    ///   Frintrop 2006, "VOCUS". In the modulus one red bar among green ones on black is one of many.
    /// - The range that N scales to 1 is that of the whole feature, not of a map: a pair of levels
    ///   or an angle at which there is next to nothing to see stays next to nothing.
    /// - Maps are added at the finest centre instead of level 4, so that the greatest value falls on
    ///   the thing and not a cell of 16 pixels.
    /// - A double opponency is (R - G)(c) - (R - G)(s). Equation 2 swaps R and G in the surround,
    ///   which read by the letter lets a red centre in a green surround cancel.
    pub fn contrasts(&self, channels: &[Vec<Plane>]) -> Vec<Plane> {
        let difference_maps = |levels: &Vec<Plane>| {
            self.pairs.iter().map(|&(c, s)| difference(&levels[c], &levels[s])).collect()
        };
        let differences: Vec<Vec<Plane>> = channels.iter().map(difference_maps).collect();
        let range = differences.iter().flatten().map(Plane::greatest_modulus).fold(0.0, f32::max);
        let finest = &channels[0][0];
        let mut sums = vec![Plane::zero(finest.width, finest.height); channels.len()];
        if range <= VISIBLE {
            return sums;
        }
        for (sum, maps) in sums.iter_mut().zip(&differences) {
            for map in maps {
                for sign in [1.0, -1.0] {
                    let part = normalized(map.map(|v| (sign * v).max(0.0)), range);
                    sum.add(&part.enlarged(finest.width, finest.height));
                }
            }
        }
        sums
    }
}

/// centre - surround, the surround interpolated to the centre's size.
fn difference(centre: &Plane, surround: &Plane) -> Plane {
    let mut map = surround.enlarged(centre.width, centre.height);
    for (value, c) in map.values.iter_mut().zip(&centre.values) {
        *value = c - *value;
    }
    map
}
