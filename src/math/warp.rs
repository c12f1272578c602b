//! Warps of the unit square, each beside its density.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

/// The unit vector with this z and azimuth.
pub fn spherical(cos_theta: f64, phi: f64) -> DVec3 {
    let sin_theta = (1.0 - cos_theta * cos_theta).max(0.0).sqrt();
    DVec3::new(sin_theta * phi.cos(), sin_theta * phi.sin(), cos_theta)
}

/// Uniform over the unit sphere; density [`uniform_sphere_pdf`].
pub fn uniform_sphere(u: [f64; 2]) -> DVec3 {
    spherical(1.0 - 2.0 * u[0], 2.0 * PI * u[1])
}

/// Density of [`uniform_sphere`], 1/sr.
pub const fn uniform_sphere_pdf() -> f64 {
    1.0 / (4.0 * PI)
}

/// Uniform over the unit disk (Shirley and Chiu 1997); density 1/pi.
pub fn concentric_disk(u: [f64; 2]) -> DVec2 {
    let (a, b) = (2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0);
    if a == 0.0 && b == 0.0 {
        return DVec2::ZERO;
    }
    let (r, phi) = if a.abs() > b.abs() {
        (a, PI / 4.0 * (b / a))
    } else {
        (b, PI / 2.0 - PI / 4.0 * (a / b))
    };
    DVec2::new(r * phi.cos(), r * phi.sin())
}

/// Over the hemisphere round +z, proportional to the cosine; density [`cosine_hemisphere_pdf`].
pub fn cosine_hemisphere(u: [f64; 2]) -> DVec3 {
    let d = concentric_disk(u);
    DVec3::new(d.x, d.y, (1.0 - d.length_squared()).max(0.0).sqrt())
}

/// Density of [`cosine_hemisphere`], 1/sr.
pub fn cosine_hemisphere_pdf(cos_theta: f64) -> f64 {
    cos_theta.max(0.0) / PI
}

/// Uniform over the cone round +z whose half angle has 1 - cos equal to `one_minus_cos`; density
/// [`uniform_cone_pdf`]. The argument keeps narrow cones exact where a cosine would round to 1.
pub fn uniform_cone(u: [f64; 2], one_minus_cos: f64) -> DVec3 {
    let drop = u[0] * one_minus_cos;
    let sin_theta = (drop * (2.0 - drop)).max(0.0).sqrt();
    let phi = 2.0 * PI * u[1];
    DVec3::new(sin_theta * phi.cos(), sin_theta * phi.sin(), 1.0 - drop)
}

/// Density of [`uniform_cone`], 1/sr.
pub fn uniform_cone_pdf(one_minus_cos: f64) -> f64 {
    1.0 / (2.0 * PI * one_minus_cos)
}

/// Over [-1, 1], falling linearly from 0 to both ends; density [`tent_pdf`].
pub fn tent(u: f64) -> f64 {
    if u < 0.5 { (2.0 * u).sqrt() - 1.0 } else { 1.0 - (2.0 - 2.0 * u).sqrt() }
}

/// Density of [`tent`].
pub fn tent_pdf(x: f64) -> f64 {
    (1.0 - x.abs()).max(0.0)
}

/// Barycentric coordinates uniform over a triangle; density 1/area.
pub fn uniform_triangle(u: [f64; 2]) -> [f64; 3] {
    let s = u[0].sqrt();
    let (a, b) = (1.0 - s, u[1] * s);
    [a, b, 1.0 - a - b]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tents_have_their_density() {
        let n = 10_000;
        let at = |i: i32| tent(f64::from(i) / f64::from(n));
        assert_eq!([at(0), at(n / 2), at(n)], [-1.0, 0.0, 1.0]);
        for i in 0..n {
            // The same share of the numbers lies between neighbours, which the density at their middle tells.
            let (low, high) = (at(i), at(i + 1));
            let share = (high - low) * tent_pdf(0.5 * (low + high));
            assert!((share * f64::from(n) - 1.0).abs() < 1e-9, "{share} at {low}");
        }
    }
}
