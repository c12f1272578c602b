//! Flights sorted by the layers of bricks that they cross.

use std::ops::Range;

/// Indices of flights by layers, ascending in each.
pub(super) struct Bins {
    /// Where the indices of each layer begin, and where those of the last end.
    first: Vec<usize>,
    numbers: Vec<u32>,
}

impl Bins {
    /// Counting sort of flights that each cross a range of `layers` layers.
    pub fn new(crossed: impl Iterator<Item = Range<usize>>, layers: usize) -> Self {
        let crossed: Vec<Range<usize>> = crossed.collect();
        let mut first = vec![0; layers + 1];
        crossed.iter().cloned().flatten().for_each(|layer| first[layer + 1] += 1);
        for layer in 0..layers {
            first[layer + 1] += first[layer];
        }
        let mut next = first.clone();
        let mut numbers = vec![0; first[layers]];
        for (number, layer) in (0..).zip(crossed).flat_map(|(n, c)| c.map(move |layer| (n, layer)))
        {
            numbers[next[layer]] = number;
            next[layer] += 1;
        }
        Self { first, numbers }
    }

    /// The flights that cross this layer.
    pub fn of(&self, layer: usize) -> &[u32] {
        &self.numbers[self.first[layer]..self.first[layer + 1]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn each_layer_has_the_flights_that_cross_it(
            ends in prop::collection::vec((0..9_usize, 0..9_usize), 0..20)
        ) {
            let crossed = || ends.iter().map(|&(a, b)| a.min(b)..a.max(b));
            let bins = Bins::new(crossed(), 8);
            for layer in 0..8 {
                let right: Vec<u32> = (0..).zip(crossed())
                    .filter_map(|(number, crossed)| crossed.contains(&layer).then_some(number))
                    .collect();
                prop_assert_eq!(bins.of(layer), &right[..]);
            }
        }
    }
}
