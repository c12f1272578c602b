//! Pixels that nothing is known of, filled from their neighbours.

use std::collections::VecDeque;

/// For each pixel of a picture, `width` a row, the index of the nearest one that is `known`, itself
/// where it is: counted in steps to any of the eight neighbours. Nothing where none is known.
pub(super) fn nearest(width: usize, known: &[bool]) -> Option<Vec<u32>> {
    const NONE: u32 = u32::MAX;
    let mut nearest = vec![NONE; known.len()];
    let mut queue = VecDeque::new();
    for (index, _) in known.iter().enumerate().filter(|(_, known)| **known) {
        nearest[index] = index as u32;
        queue.push_back(index);
    }
    if queue.is_empty() {
        return None;
    }
    let height = known.len() / width;
    while let Some(index) = queue.pop_front() {
        let (x, y) = (index % width, index / width);
        for row in y.saturating_sub(1)..(y + 2).min(height) {
            for column in x.saturating_sub(1)..(x + 2).min(width) {
                let beside = row * width + column;
                if nearest[beside] == NONE {
                    nearest[beside] = nearest[index];
                    queue.push_back(beside);
                }
            }
        }
    }
    Some(nearest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn each_pixel_is_filled_from_one_as_near_as_any(
            width in 1_usize..12, known in prop::collection::vec(prop::bool::weighted(0.1), 1..12),
        ) {
            let known: Vec<bool> = (0..width).flat_map(|_| known.clone()).collect();
            let distance = |a: usize, b: usize| {
                (a % width).abs_diff(b % width).max((a / width).abs_diff(b / width))
            };
            let there: Vec<usize> = (0..known.len()).filter(|i| known[*i]).collect();
            match nearest(width, &known) {
                None => prop_assert!(there.is_empty()),
                Some(nearest) => for (pixel, found) in nearest.iter().enumerate() {
                    let found = *found as usize;
                    let least = there.iter().map(|other| distance(pixel, *other)).min().unwrap();
                    prop_assert!(known[found] && distance(pixel, found) == least);
                },
            }
        }
    }
}
