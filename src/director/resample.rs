//! Resampling of maps to another size.

/// `map`, of the size `from` (width, height), resampled to the size `to`: bilinearly between the middles
/// of pixels where it grows, by the mean over the area of each new pixel where it shrinks.
pub fn resampled(map: &[f32], from: [u32; 2], to: [u32; 2]) -> Vec<f32> {
    if from == to {
        return map.to_vec();
    }
    if to[0] >= from[0] && to[1] >= from[1] { enlarged(map, from, to) } else { mean(map, from, to) }
}

fn enlarged(map: &[f32], from: [u32; 2], to: [u32; 2]) -> Vec<f32> {
    let along = |i: u32, axis: usize| {
        let last = f64::from(from[axis] - 1);
        let at = (f64::from(i) + 0.5) * f64::from(from[axis]) / f64::from(to[axis]) - 0.5;
        let at = at.clamp(0.0, last);
        (at.floor() as usize, (at.floor() + 1.0).min(last) as usize, (at - at.floor()) as f32)
    };
    let width = from[0] as usize;
    let mut large = Vec::with_capacity(to[0] as usize * to[1] as usize);
    for y in 0..to[1] {
        let (top, bottom, down) = along(y, 1);
        for x in 0..to[0] {
            let (left, right, across) = along(x, 0);
            let row = |y: usize| {
                let (a, b) = (map[y * width + left], map[y * width + right]);
                a + (b - a) * across
            };
            large.push(row(top) + (row(bottom) - row(top)) * down);
        }
    }
    large
}

fn mean(map: &[f32], from: [u32; 2], to: [u32; 2]) -> Vec<f32> {
    // Old pixels that a new one covers along an axis, each with the covered part of its width.
    let covered = |i: u32, axis: usize| {
        let scale = f64::from(from[axis]) / f64::from(to[axis]);
        let (start, end) = (f64::from(i) * scale, f64::from(i + 1) * scale);
        let pixels = start.floor() as u32..(end.ceil() as u32).min(from[axis]);
        pixels.map(move |p| {
            let part = end.min(f64::from(p + 1)) - start.max(f64::from(p));
            (p as usize, part.max(0.0))
        })
    };
    let width = from[0] as usize;
    let pixel = |x: u32, y: u32| {
        let (mut sum, mut area) = (0.0, 0.0);
        for (row, high) in covered(y, 1) {
            for (column, wide) in covered(x, 0) {
                sum += f64::from(map[row * width + column]) * high * wide;
                area += high * wide;
            }
        }
        (sum / area) as f32
    };
    (0..to[1]).flat_map(|y| (0..to[0]).map(move |x| (x, y))).map(|(x, y)| pixel(x, y)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_size_is_the_same_map() {
        let map = [0.1, 0.7, 0.3, 0.9, 0.2, 0.4];
        assert_eq!(resampled(&map, [3, 2], [3, 2]), map);
    }

    #[test]
    fn a_ramp_stays_a_ramp() {
        let ramp: Vec<f32> = (0..8).map(|x| x as f32).collect();
        assert_eq!(resampled(&ramp, [8, 1], [4, 1]), [0.5, 2.5, 4.5, 6.5]);
        let large = resampled(&ramp, [8, 1], [16, 1]);
        assert!((1..15).all(|i| (large[i] - (i as f32 / 2.0 - 0.25)).abs() < 1e-6), "{large:?}");
    }

    #[test]
    fn shrinking_keeps_the_mean_and_flat_stays_flat() {
        let map: Vec<f32> = (0..7 * 5).map(|i| (i * 13 % 11) as f32).collect();
        let mean = |map: &[f32]| map.iter().sum::<f32>() / map.len() as f32;
        assert!((mean(&resampled(&map, [7, 5], [3, 2])) - mean(&map)).abs() < 1e-5);
        for to in [[3, 2], [29, 13], [1, 1]] {
            assert!(resampled(&[0.25; 35], [7, 5], to).iter().all(|v| (v - 0.25).abs() < 1e-7));
        }
    }
}
