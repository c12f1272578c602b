//! Where in a cell final gathers start.

use glam::{DVec3, IVec3};

use crate::math::WorldPoint;
use crate::medium::Media;

/// Share of the way from a cell's centre to the mean of the places at which rays sample it, where
/// gathers start. At the centre, which can lie outside of the medium, they find too little light; at the
/// mean too much, as light falls off ever faster toward the medium's edge. Chosen by measuring the mean
/// of `gathers_lose_no_sunlight_in_thick_haze` (tests/physics/gather.rs) against its reference.
///
/// Unit: none. Bench: `gathers_lose_no_sunlight_in_thick_haze` of `tests/physics/gather.rs`.
const TOWARD_MEAN: f64 = 0.5;

/// Standard deviation along an axis, in widths of a cell, of the places at which trilinear
/// interpolation reads it: 1 / sqrt(6), that of a tent function.
///
/// Unit: none. Derivation: the variance of a tent function of half width 1 is 1/6.
const LOOKUP_DEVIATION: f64 = 0.408;

/// Optical thickness that hides everything.
///
/// Unit: none. Derivation: exp(-20) is 2e-9.
const OPAQUE: f64 = 20.0;

/// Places at which [`gather_origin`] looks up densities.
///
/// Unit: count. Definition: eight corners and the centre.
pub(super) const DENSITY_LOOKUPS: u64 = 9;

/// The place where gathers start for light that the medium of this index scatters in the cell of
/// `width` metres round `center`, toward the camera in the direction `wo`: part of the way to the mean
/// place at which rays sample the cell, for which eight corners stand. Extinction is the mean of the
/// channels.
pub(super) fn gather_origin(
    media: &Media,
    medium: usize,
    center: WorldPoint,
    width: f64,
    wo: DVec3,
) -> WorldPoint {
    // Of this medium, and of all.
    let extinction = |p| {
        let of_each = media.iter().map(|m| m.sigma_t_at(p).element_sum() / 3.0).enumerate();
        let add =
            |[own, all]: [f64; 2], (index, of)| [if index == medium { of } else { own }, all + of];
        of_each.fold([0.0; 2], add)
    };
    let [_, here] = extinction(center);
    let (mut moment, mut total) = (DVec3::ZERO, 0.0);
    for corner in 0..8 {
        let corner = IVec3::new(corner >> 2, corner >> 1 & 1, corner & 1) * 2 - 1;
        let offset = LOOKUP_DEVIATION * width * corner.as_dvec3();
        let [own, there] = extinction(center + offset);
        let nearer = 0.5 * (here + there) * offset.dot(wo);
        let weight = own * nearer.clamp(-OPAQUE, OPAQUE).exp();
        moment += weight * offset;
        total += weight;
    }
    if total > 0.0 { center + TOWARD_MEAN / total * moment } else { center }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Rgb;
    use crate::medium::{Albedo, Density, Medium, Phase};
    use crate::shape::{Cuboid, Region};
    use glam::DAffine3;
    use proptest::prelude::*;

    /// A box with a side at x = 0, of this extinction coefficient, 1/m.
    fn medium(sigma_t: f64) -> Medium {
        let (low, high) = (DVec3::new(-9.0, -9.0, -9.0), DVec3::new(0.0, 9.0, 9.0));
        let region = Cuboid::new(low, high, &DAffine3::IDENTITY).unwrap();
        Medium {
            density: Density::Homogeneous(Region::Box(region)),
            sigma_t: Rgb::splat(sigma_t),
            albedo: Albedo::Constant(Rgb::ONE),
            phase: Phase::ISOTROPIC,
            emission: None,
        }
    }

    fn origin(sigma_t: f64, x: f64, toward: DVec3) -> DVec3 {
        let center = WorldPoint::new(x, 0.0, 0.0);
        let media = Media::new(vec![medium(sigma_t)]);
        gather_origin(&media, 0, center, 1.0, toward) - WorldPoint::new(0.0, 0.0, 0.0)
    }

    #[test]
    fn gathers_start_in_the_medium() {
        // Well inside, thin: at the centre. At the side: inward, also from outside.
        assert!((origin(1e-9, -4.0, DVec3::Y) - DVec3::new(-4.0, 0.0, 0.0)).length() < 1e-6);
        for x in [-0.3, 0.0, 0.15] {
            let p = origin(1e-9, x, DVec3::Y);
            assert!(p.x < x - 0.1 && p.x < 0.0, "{p} for {x}");
        }
        // Thick: toward the eye, as far as the way there goes.
        let p = origin(1e9, -4.0, DVec3::Y);
        assert!((p.y - TOWARD_MEAN * LOOKUP_DEVIATION).abs() < 1e-6, "{p}");
    }

    #[test]
    fn another_medium_hides_what_lies_behind() {
        // Thin within a thick one: at the near side, as if thick itself.
        let media = Media::new(vec![medium(1e-9), medium(1e9)]);
        let center = WorldPoint::new(-4.0, 0.0, 0.0);
        let p = gather_origin(&media, 0, center, 1.0, DVec3::Y) - center;
        assert!((p.y - TOWARD_MEAN * LOOKUP_DEVIATION).abs() < 1e-6, "{p}");
    }

    proptest! {
        #[test]
        fn gathers_start_in_their_cell(log in -12.0..12.0f64, x in -2.0..2.0f64, angle in 0.0..6.3f64) {
            let p = origin(10.0_f64.powf(log), x, DVec3::new(angle.cos(), angle.sin(), 0.0));
            let off = (p - DVec3::new(x, 0.0, 0.0)).abs().max_element();
            prop_assert!(off <= TOWARD_MEAN * LOOKUP_DEVIATION + 1e-12, "{p}");
        }
    }
}
