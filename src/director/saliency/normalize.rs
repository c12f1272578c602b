//! The map normalisation operator N(.).

use super::plane::Plane;

/// Part of the greatest value below which local maxima are not counted: ripples of the floor.
///
/// Unit: none. Source: `maxNormalizeLocalMax` of the SaliencyToolbox, Walther and Koch 2006, "Modeling
/// Attention to Salient Proto-objects".
const COUNTED: f32 = 0.1;

/// N(.) of Itti et al. 1998 for a map of values that are at least 0: it is scaled so that `range`
/// becomes 1, then multiplied by (M - m)^2, where M is the greatest value and m the mean of all
/// other local maxima. A map with one strong peak keeps it, one with many alike is suppressed. A
/// map of 0 stays so.
pub fn normalized(map: Plane, range: f32) -> Plane {
    let greatest = map.greatest_modulus();
    if greatest == 0.0 {
        return map;
    }
    let weight = ((greatest - mean_of_other_maxima(&map, greatest)) / range).powi(2);
    map.map(|v| v / range * weight)
}

/// The mean of the local maxima but one of the `greatest`; 0 where there are no others.
fn mean_of_other_maxima(map: &Plane, greatest: f32) -> f32 {
    let (mut sum, mut count) = (0.0, 0_u32);
    for y in 0..map.height {
        for x in 0..map.width {
            let v = map.values[y * map.width + x];
            if v >= COUNTED * greatest && is_local_maximum(map, x, y) {
                sum += f64::from(v);
                count += 1;
            }
        }
    }
    if count <= 1 { 0.0 } else { ((sum - f64::from(greatest)) / f64::from(count - 1)) as f32 }
}

/// Whether no neighbour of eight is greater. Of neighbours alike only the first in reading order
/// counts.
fn is_local_maximum(map: &Plane, x: usize, y: usize) -> bool {
    let at = y * map.width + x;
    let v = map.values[at];
    (y.saturating_sub(1)..map.height.min(y + 2)).all(|ny| {
        (x.saturating_sub(1)..map.width.min(x + 2)).all(|nx| {
            let other = ny * map.width + nx;
            let w = map.values[other];
            if other < at { w < v } else { w <= v }
        })
    })
}
