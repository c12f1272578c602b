//! The cells around a place, and their weights in trilinear interpolation between their centres.

use glam::{DVec3, IVec3};

/// Offsets from the first to each of the numbers by which a sample draws its cells.
///
/// Unit: none. Definition: the quarters of [0, 1), so that the numbers are stratified.
pub(super) const OFFSETS: [f64; 4] = [0.0, 0.5, 0.25, 0.75];

/// The corners of a cube, opposite ones next to each other: they differ most.
///
/// Unit: count. Definition: the corners of the unit cube, in cells.
pub(super) const CORNERS: [IVec3; 8] = [
    IVec3::new(0, 0, 0),
    IVec3::new(1, 1, 1),
    IVec3::new(0, 0, 1),
    IVec3::new(1, 1, 0),
    IVec3::new(0, 1, 0),
    IVec3::new(1, 0, 1),
    IVec3::new(1, 0, 0),
    IVec3::new(0, 1, 1),
];

/// One of the eight lattice points around `local`, drawn by its weight in trilinear interpolation with `u` in [0, 1).
pub(super) fn draw_corner(local: DVec3, u: f64) -> IVec3 {
    let low = local.floor();
    let mut left = u;
    // Below or above on each axis, by what the axes before have left of the number.
    let above = (local - low).to_array().map(|share| {
        let is_above = left < share;
        left = if is_above { left / share } else { (left - share) / (1.0 - share) };
        i32::from(is_above)
    });
    low.as_ivec3() + IVec3::from_array(above)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Evenly spaced numbers draw each corner as often as its weight says, but for one number at each of the three
    /// divisions between corners.
    #[test]
    fn corners_are_drawn_by_their_weights() {
        const COUNT: u32 = 4096;
        let local = DVec3::new(-1.3, 2.5, 7.9);
        let (low, share) = (local.floor().as_ivec3(), local - local.floor());
        let draws: Vec<IVec3> = (0..COUNT)
            .map(|i| draw_corner(local, (f64::from(i) + 0.5) / f64::from(COUNT)) - low)
            .collect();
        for corner in CORNERS {
            let far = corner.as_dvec3();
            let weight = (far * share + (1.0 - far) * (1.0 - share)).element_product();
            let drawn = draws.iter().filter(|drawn| **drawn == corner).count() as f64;
            assert!((drawn - weight * f64::from(COUNT)).abs() <= 3.0, "{drawn} of {corner}");
        }
        assert!(draws.iter().all(|drawn| CORNERS.contains(drawn)));
        // At the centre of a cell that is all there is.
        assert_eq!(draw_corner(DVec3::new(-1.0, 2.0, 7.0), 0.7), IVec3::new(-1, 2, 7));
    }
}
