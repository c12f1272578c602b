//! Where a ray is in a cone.

use glam::DVec3;

use super::{Ray, Span, World, WorldPoint};

/// A cone from its apex, without an end.
#[derive(Debug, Clone, Copy)]
pub struct Cone {
    /// Where it begins.
    pub apex: WorldPoint,
    /// Unit vector along it.
    pub axis: DVec3,
    /// 1 - cos of its half angle, at most 1: a half space.
    pub one_minus_cos: f64,
}

impl Cone {
    /// The span of `ray`, before and behind its origin, that is in the cone; empty where it meets none. A cone
    /// is convex, so that there is one.
    pub fn clip(&self, ray: &Ray<World>) -> Span {
        const NOTHING: Span = Span::new(f64::INFINITY, f64::NEG_INFINITY);
        const EVERYWHERE: Span = Span::new(f64::NEG_INFINITY, f64::INFINITY);
        let cosine = 1.0 - self.one_minus_cos;
        let (sine2, cosine2) = (self.one_minus_cos * (1.0 + cosine), cosine * cosine);
        // Along the axis and across it, of the start from the apex and of the direction.
        let to = ray.origin - self.apex;
        let (start, rise) = (to.dot(self.axis), ray.direction.dot(self.axis));
        let (side, aside) = (to - self.axis * start, ray.direction - self.axis * rise);
        // In the cone and its mirror image a t² + 2 b t + c is not negative.
        let a = sine2 * rise * rise - cosine2 * aside.length_squared();
        let b = sine2 * start * rise - cosine2 * side.dot(aside);
        let c = sine2 * start * start - cosine2 * side.length_squared();
        let discriminant = b * b - a * c;
        if a < 0.0 {
            // Both ends are in the same half.
            if discriminant <= 0.0 || start - rise * b / a <= 0.0 {
                return NOTHING;
            }
            let q = -(b + discriminant.sqrt().copysign(b));
            let ends = [q / a, c / q];
            return Span::new(ends[0].min(ends[1]), ends[0].max(ends[1]));
        }
        if rise == 0.0 {
            // Along the face of a half space.
            return if start > 0.0 { EVERYWHERE } else { NOTHING };
        }
        // One end is in each half, and the ray stays in that to which it rises. Along the surface there is one.
        let q = -(b + discriminant.max(0.0).sqrt().copysign(b));
        let ends = [q / a, c / q].into_iter().filter(|t| t.is_finite());
        if rise > 0.0 {
            ends.reduce(f64::max).map_or(NOTHING, |end| Span::new(end, f64::INFINITY))
        } else {
            ends.reduce(f64::min).map_or(NOTHING, |end| Span::new(f64::NEG_INFINITY, end))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn unit(along: [f64; 3]) -> DVec3 {
        DVec3::from(along).try_normalize().unwrap_or(DVec3::X)
    }

    proptest! {
        /// Places on the ray are in the span where their direction from the apex is in the cone.
        #[test]
        fn the_span_is_what_lies_in_the_cone(
            apex in prop::array::uniform3(-3.0..3.0f64),
            axis in prop::array::uniform3(-1.0..1.0f64),
            direction in prop::array::uniform3(-1.0..1.0f64),
            angle in 0.01..90.0f64,
        ) {
            let one_minus_cos = 2.0 * (0.5 * angle.to_radians()).sin().powi(2);
            let apex = WorldPoint::from_xyz(apex.into());
            let cone = Cone { apex, axis: unit(axis), one_minus_cos };
            let ray = Ray::new(WorldPoint::new(0.1, -0.2, 0.3), unit(direction));
            let span = cone.clip(&ray);
            for step in -400..=400 {
                let t = 0.025 * f64::from(step);
                let off = 0.5 * ((ray.at(t) - apex).normalize() - cone.axis).length_squared();
                if (off - one_minus_cos).abs() > 1e-9 {
                    let is_in = t > span.start && t < span.end;
                    prop_assert_eq!(is_in, off < one_minus_cos, "{} of {:?}", t, span);
                }
            }
        }
    }

    #[test]
    fn rays_along_the_face_of_a_half_space_are_in_it_or_not() {
        let apex = WorldPoint::new(0.0, 1.0, 0.0);
        let below = Cone { apex, axis: DVec3::NEG_Y, one_minus_cos: 1.0 };
        for (height, is_in) in [(0.0, true), (2.0, false)] {
            let span = below.clip(&Ray::new(WorldPoint::new(0.0, height, 5.0), DVec3::NEG_Z));
            assert_eq!(!span.is_empty(), is_in, "{span:?}");
        }
    }
}
