//! Scattering by a sphere of any size, by Mie's series (Bohren and Huffman 1983, "Absorption and
//! Scattering of Light by Small Particles", chapter 4 and appendix A).

use std::f64::consts::PI;

/// Scattering efficiency and mean cosine of a sphere that does not absorb, of the size parameter `x`
/// (circumference over wavelength) and the refractive index `m`, both without unit.
pub(crate) fn sphere(x: f64, m: f64) -> [f64; 2] {
    // Terms until convergence (Wiscombe 1980); logarithmic derivatives by downward recurrence, the
    // Riccati-Bessel functions by upward recurrence.
    let terms = (x + 4.0 * x.cbrt() + 2.0) as usize;
    let last = terms.max((m * x) as usize) + 16;
    let mut derivative = vec![0.0; last + 1];
    for n in (1..=last).rev() {
        let ratio = n as f64 / (m * x);
        derivative[n - 1] = ratio - 1.0 / (derivative[n] + ratio);
    }
    let (mut psi, mut chi) = ([x.cos(), x.sin()], [-x.sin(), x.cos()]);
    let coefficients: Vec<[Complex; 2]> = (1..=terms)
        .map(|n| {
            let order = n as f64;
            let next = |f: [f64; 2]| (2.0 * order - 1.0) / x * f[1] - f[0];
            let (p, c) = (next(psi), next(chi));
            let coefficient = |t: f64| {
                let factor = t + order / x;
                let numerator = factor * p - psi[1];
                // The denominator is numerator - i (factor chi_n - chi_(n-1)).
                over(numerator, [numerator, chi[1] - factor * c])
            };
            let both = [coefficient(derivative[n] / m), coefficient(derivative[n] * m)];
            (psi, chi) = ([psi[1], p], [chi[1], c]);
            both
        })
        .collect();
    let (mut efficiency, mut forward) = (0.0, 0.0);
    for (index, [a, b]) in coefficients.iter().enumerate() {
        let n = index as f64 + 1.0;
        efficiency += (2.0 * n + 1.0) * (dot(*a, *a) + dot(*b, *b));
        forward += (2.0 * n + 1.0) / (n * (n + 1.0)) * dot(*a, *b);
        if let Some([next_a, next_b]) = coefficients.get(index + 1) {
            forward += n * (n + 2.0) / (n + 1.0) * (dot(*a, *next_a) + dot(*b, *next_b));
        }
    }
    [2.0 * efficiency / (x * x), 2.0 * forward / efficiency]
}

/// Mean cosine of visible light scattered by water droplets about `diameter` µm across: by their
/// scattering cross-sections over three wavelengths and diameters that spread by a tenth, which levels
/// the resonances of single spheres.
pub(crate) fn droplets(diameter: f64) -> f64 {
    const WATER: f64 = 1.333;
    let (mut sum, mut weight) = (0.0, 0.0);
    for wavelength in [0.45, 0.55, 0.65] {
        for step in -15..=15 {
            let deviation = f64::from(step) * 2.0 / 15.0;
            let diameter = diameter * (1.0 + 0.1 * deviation);
            let [efficiency, cosine] = sphere(PI * diameter / wavelength, WATER);
            let section = (-0.5 * deviation * deviation).exp() * efficiency * diameter.powi(2);
            sum += section * cosine;
            weight += section;
        }
    }
    sum / weight
}

/// Real and imaginary part.
type Complex = [f64; 2];

/// A real number over a complex one.
fn over(numerator: f64, [re, im]: Complex) -> Complex {
    let scale = numerator / (re * re + im * im);
    [re * scale, -im * scale]
}

/// The real part of `a` times the conjugate of `b`.
fn dot(a: Complex, b: Complex) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// The example of Bohren and Huffman's appendix A: 0.525 µm in radius, 632.8 nm, index 1.55.
#[test]
fn a_sphere_scatters_as_the_book_says() {
    let [efficiency, _] = sphere(2.0 * PI * 0.525 / 0.6328, 1.55);
    assert!((efficiency - 3.10543).abs() < 1e-5, "{efficiency}");
    // Rayleigh's limit: 8/3 x⁴ ((m² - 1) / (m² + 2))², and as much light ahead as back.
    let [efficiency, cosine] = sphere(1e-3, 1.333);
    let polarizability = (1.333f64.powi(2) - 1.0) / (1.333f64.powi(2) + 2.0);
    let expected = 8.0 / 3.0 * 1e-12 * polarizability.powi(2);
    assert!((efficiency / expected - 1.0).abs() < 1e-4, "{efficiency} for {expected}");
    assert!(cosine.abs() < 1e-5, "{cosine}");
}
