//! Slabs by adding-doubling: an oracle that shares nothing with the renderer.
//!
//! Van de Hulst 1980, "Multiple Light Scattering", chapter 4, and Prahl, van Gemert and Welch 1993,
//! "Determining the optical properties of turbid media by using the adding-doubling method". Light is
//! held in the azimuthal mean at Gauss-Legendre directions over each half sphere, with those from which
//! slabs are seen as further directions of weight 0. A very thin layer scatters once or not at all;
//! doubling it gives any thickness.

use std::f64::consts::PI;

/// Directions in a half sphere: with more nothing changes by 1e-5 up to g = 0.9.
const NODES: usize = 48;
/// Angles from the normal, in degrees, from which slabs are seen; the first is that of the light.
pub const SEEN_FROM: [f64; 3] = [0.0, 30.0, 60.0];
/// With those.
const SIZE: usize = NODES + SEEN_FROM.len();

/// Reflection or transmission from each direction (column) to each (row), as radiance per flux.
type Matrix = Vec<[f64; SIZE]>;

/// What becomes of light that falls normally on a slab.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlabLight {
    /// Share that goes back to where it came from.
    pub reflectance: f64,
    /// Share that leaves on the other side, what was not scattered included.
    pub transmittance: f64,
    /// Pi times the reflected radiance over the irradiance, seen from [`SEEN_FROM`].
    pub reflected: [f64; SEEN_FROM.len()],
    /// The same on the other side, of what was scattered.
    pub transmitted: [f64; SEEN_FROM.len()],
}

/// What becomes of light that falls normally on a slab of an optical thickness, an albedo and
/// Henyey-Greenstein scattering of mean cosine `g`.
pub fn slab(thickness: f64, albedo: f64, g: f64) -> SlabLight {
    let (mu, weight) = directions();
    let doublings = (thickness / 1e-9).log2().ceil().max(0.0);
    let thin = thickness / doublings.exp2();
    let (forward, backward) = (phase(&mu, &weight, g, 1.0), phase(&mu, &weight, g, -1.0));
    let layer = |p: &Matrix| -> Matrix {
        let entry = |i: usize, j: usize| albedo * thin * p[i][j] / (4.0 * mu[i] * mu[j]);
        (0..SIZE).map(|i| std::array::from_fn(|j| entry(i, j))).collect()
    };
    let (mut r, mut t) = (layer(&backward), layer(&forward));
    let mut depth = thin;
    for _ in 0..doublings as u32 {
        (r, t) = doubled(&r, &t, depth, &mu, &weight);
        depth *= 2.0;
    }
    let flux = |m: &Matrix| (0..NODES).map(|i| 2.0 * weight[i] * mu[i] * m[i][NODES]).sum::<f64>();
    let seen = |m: &Matrix| std::array::from_fn(|i| m[NODES + i][NODES]);
    SlabLight {
        reflectance: flux(&r),
        transmittance: flux(&t) + (-thickness).exp(),
        reflected: seen(&r),
        transmitted: seen(&t),
    }
}

/// Two equal layers, each of optical thickness `depth`, upon each other: light that goes between
/// them is summed by solving for it.
fn doubled(r: &Matrix, t: &Matrix, depth: f64, mu: &[f64], weight: &[f64]) -> (Matrix, Matrix) {
    let beam: Vec<f64> = mu.iter().map(|mu| (-depth / mu).exp()).collect();
    let times = |a: &Matrix, b: &Matrix| -> Matrix {
        let entry = |i: usize, j: usize| -> f64 {
            (0..NODES).map(|k| a[i][k] * 2.0 * weight[k] * mu[k] * b[k][j]).sum()
        };
        (0..SIZE).map(|i| std::array::from_fn(|j| entry(i, j))).collect()
    };
    let sum = |a: &Matrix, b: &Matrix| -> Matrix {
        (0..SIZE).map(|i| std::array::from_fn(|j| a[i][j] + b[i][j])).collect()
    };
    let after = |m: &Matrix| -> Matrix {
        (0..SIZE).map(|i| std::array::from_fn(|j| beam[i] * m[i][j])).collect()
    };
    let before = |m: &Matrix| -> Matrix {
        (0..SIZE).map(|i| std::array::from_fn(|j| m[i][j] * beam[j])).collect()
    };
    // Light up and down between the layers, of what comes down through the first:
    // down = t + r up, up = r (beam + down), so down = t + r r beam + r r down.
    let rr = times(r, r);
    let down = solve(&rr, weight, mu, &sum(t, &before(&rr)));
    let up = sum(&before(r), &times(r, &down));
    let reflected = sum(r, &sum(&after(&up), &times(t, &up)));
    let transmitted = sum(&before(t), &sum(&after(&down), &times(t, &down)));
    (reflected, transmitted)
}

/// The solution x of x = b + a x by its series, which converges since a layer never gives back more
/// than it was given; squared at each turn.
fn solve(a: &Matrix, weight: &[f64], mu: &[f64], b: &Matrix) -> Matrix {
    let times = |a: &Matrix, b: &Matrix| -> Matrix {
        let entry = |i: usize, j: usize| -> f64 {
            (0..NODES).map(|k| a[i][k] * 2.0 * weight[k] * mu[k] * b[k][j]).sum()
        };
        (0..SIZE).map(|i| std::array::from_fn(|j| entry(i, j))).collect()
    };
    let (mut power, mut x) = (a.clone(), b.clone());
    for _ in 0..40 {
        let more = times(&power, &x);
        let mut largest: f64 = 0.0;
        for (x, more) in x.iter_mut().zip(&more) {
            for (x, more) in x.iter_mut().zip(more) {
                *x += more;
                largest = largest.max((more / x.abs().max(1e-300)).abs());
            }
        }
        if largest < 1e-15 {
            break;
        }
        power = times(&power, &power);
    }
    x
}

/// Henyey-Greenstein scattering between directions, in the azimuthal mean, times 4 pi; `side` is 1
/// where light goes on into the same half sphere, -1 where it turns back. Each column is normalised,
/// so that no light is lost to the quadrature (Wiscombe 1976).
fn phase(mu: &[f64], weight: &[f64], g: f64, side: f64) -> Matrix {
    let value =
        |i: usize, j: usize, side: f64| mean_over_azimuth(side * mu[i] * mu[j], mu[i], mu[j], g);
    let whole: Vec<f64> = (0..SIZE)
        .map(|j| {
            let both = |i: usize| value(i, j, 1.0) + value(i, j, -1.0);
            (0..NODES).map(|i| 0.5 * weight[i] * both(i)).sum()
        })
        .collect();
    (0..SIZE).map(|i| std::array::from_fn(|j| value(i, j, side) / whole[j])).collect()
}

fn mean_over_azimuth(cosines: f64, a: f64, b: f64, g: f64) -> f64 {
    const STEPS: u32 = 256;
    let sines = ((1.0 - a * a) * (1.0 - b * b)).max(0.0).sqrt();
    let value = |step: u32| {
        let phi = (f64::from(step) + 0.5) * PI / f64::from(STEPS);
        let cos_theta = cosines + sines * phi.cos();
        (1.0 - g * g) / (1.0 + g * g - 2.0 * g * cos_theta).powf(1.5)
    };
    (0..STEPS).map(value).sum::<f64>() / f64::from(STEPS)
}

/// Gauss-Legendre cosines and weights over (0, 1), and those of [`SEEN_FROM`] with weight 0.
fn directions() -> (Vec<f64>, Vec<f64>) {
    let n = NODES as f64;
    let (mut mu, mut weight) = (Vec::new(), Vec::new());
    for i in 0..NODES {
        let mut x = (PI * (i as f64 + 0.75) / (n + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..100 {
            let (mut p, mut q) = (1.0, 0.0);
            for k in 1..=NODES {
                let k = k as f64;
                (p, q) = (((2.0 * k - 1.0) * x * p - (k - 1.0) * q) / k, p);
            }
            slope = n * (x * p - q) / (x * x - 1.0);
            let next = x - p / slope;
            if (next - x).abs() < 1e-16 {
                break;
            }
            x = next;
        }
        mu.push(0.5 * (1.0 + x));
        weight.push(1.0 / ((1.0 - x * x) * slope * slope));
    }
    mu.extend(SEEN_FROM.map(|angle| angle.to_radians().cos()));
    weight.resize(SIZE, 0.0);
    (mu, weight)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Van de Hulst 1980, table 12 (isotropic) and table 35 (g = 0.75), as quoted by Prahl et al.
    #[test]
    fn slabs_are_those_of_van_de_hulst() {
        for (thickness, albedo, g, reflectance, transmittance) in [
            (1.0, 0.9, 0.0, 0.26741, 0.59163),
            (1.0, 1.0, 0.0, 0.34133, 0.65867),
            (2.0, 0.9, 0.75, 0.09740, 0.66096),
        ] {
            let found = slab(thickness, albedo, g);
            assert!((found.reflectance - reflectance).abs() < 2e-5, "{found:?}");
            assert!((found.transmittance - transmittance).abs() < 2e-5, "{found:?}");
        }
    }

    /// Values of another implementation of adding-doubling, which lists them to five digits.
    #[test]
    fn radiance_is_that_of_another_implementation() {
        for ([thickness, albedo, g], reflected, transmitted) in [
            ([16.0, 1.0, 0.0], [0.93558, 0.92882, 0.89147], [0.12134, 0.11143, 0.08399]),
            ([16.0, 0.99, -0.5], [1.22300, 0.89976, 0.66319], [0.01835, 0.01652, 0.01187]),
            ([16.0, 0.99, 0.9], [0.30269, 0.32136, 0.33891], [0.57846, 0.49236, 0.33899]),
            ([4.0, 0.9, 0.5], [0.22846, 0.24405, 0.28041], [0.35781, 0.28139, 0.18353]),
        ] {
            let found = slab(thickness, albedo, g);
            for (found, expected) in
                [(found.reflected, reflected), (found.transmitted, transmitted)]
            {
                for (found, expected) in found.into_iter().zip(expected) {
                    assert!((found / expected - 1.0).abs() < 3e-4, "{found} for {expected}");
                }
            }
        }
    }

    #[test]
    fn thick_slabs_are_half_spaces_and_white_ones_lose_nothing() {
        for (albedo, expected) in super::super::known::HALF_SPACES {
            let found = slab(2000.0, albedo, 0.0).reflectance;
            assert!((found - expected).abs() < 1e-5, "{albedo}: {found} for {expected}");
        }
        let white = slab(16.0, 1.0, 0.85);
        assert!((white.reflectance + white.transmittance - 1.0).abs() < 1e-6, "{white:?}");
    }
}
