//! Phase functions against what they must satisfy.

use std::f64::consts::{PI, TAU};

use fogbow::math::{Stage, Stream};
use fogbow::medium::phase::Phase;
use glam::DVec3;
use proptest::prelude::*;

use crate::chi2::Chi2;
use crate::mie;

/// One row a kind, narrow and odd ones included, and the parts of those that can be split.
fn all() -> Vec<(String, Phase)> {
    let mut rows = whole();
    for (name, phase) in whole() {
        let Some(split) = phase.split(MOST, Some(SMOOTH)) else { continue };
        rows.push((format!("peak of {name}"), split.peak));
        rows.push((format!("rest of {name}"), split.rest));
    }
    rows
}

fn whole() -> Vec<(String, Phase)> {
    let mut rows = vec![
        ("isotropic".to_string(), Phase::ISOTROPIC),
        ("rayleigh".to_string(), Phase::RAYLEIGH),
    ];
    for g in [-0.9999, -0.7, -1e-9, 0.0, 1e-3, 0.5, 0.99, 0.9999] {
        rows.push((format!("henyey-greenstein {g}"), Phase::henyey_greenstein(g).unwrap()));
    }
    for (g1, g2, weight) in [(0.8, -0.3, 0.7), (0.9999, -0.9999, 0.5), (0.2, 0.9, 0.0)] {
        let name = format!("two-lobe {g1} {g2} {weight}");
        rows.push((name, Phase::two_lobe(g1, g2, weight).unwrap()));
    }
    for diameter in DIAMETERS {
        rows.push((format!("fog {diameter} µm"), Phase::fog(diameter).unwrap()));
    }
    rows
}

/// Concentration above which functions are split, and that of what is left of one lobe.
const MOST: f64 = 30.0;
const SMOOTH: f64 = 8.0;

/// In and at the ends of each range of the fit.
const DIAMETERS: [f64; 13] =
    [1e-6, 0.01, 0.1, 0.101, 0.5, 1.0, 1.499, 1.5, 3.0, 4.81, 5.0, 20.0, 50.0];

/// Integral of `f` times the phase function over the sphere, by adaptive Simpson in 1 - cos on
/// intervals that shrink toward both poles, where the lobes are.
fn over_sphere(phase: &Phase, f: impl Fn(f64) -> f64) -> f64 {
    let integrand = |cos_theta: f64| TAU * phase.eval(cos_theta) * f(cos_theta);
    let mut edges: Vec<f64> = (0..48).map(|i| 0.5f64.powi(i)).collect();
    edges.push(0.0);
    edges.windows(2).fold(0.0, |sum, pair| {
        let (a, b) = (pair[1], pair[0]);
        sum + simpson(&|drop| integrand(1.0 - drop), a, b, 20)
            + simpson(&|drop| integrand(drop - 1.0), a, b, 20)
    })
}

fn simpson(f: &dyn Fn(f64) -> f64, a: f64, b: f64, depth: u32) -> f64 {
    let rule = |a: f64, b: f64| (b - a) / 6.0 * (f(a) + 4.0 * f(0.5 * (a + b)) + f(b));
    let middle = 0.5 * (a + b);
    let (whole, halves) = (rule(a, b), rule(a, middle) + rule(middle, b));
    if depth == 0 || (whole - halves).abs() < 1e-12 {
        halves + (halves - whole) / 15.0
    } else {
        simpson(f, a, middle, depth - 1) + simpson(f, middle, b, depth - 1)
    }
}

#[test]
fn integrate_to_one() {
    for (name, phase) in all() {
        let integral = over_sphere(&phase, |_| 1.0);
        assert!((integral - 1.0).abs() < 1e-9, "{name}: {integral}");
    }
}

#[test]
fn mean_cosine_is_that_of_the_function() {
    for (name, phase) in all() {
        let mean = over_sphere(&phase, |cos_theta| cos_theta);
        assert!((mean - phase.mean_cosine()).abs() < 1e-9, "{name}: {mean}");
    }
}

#[test]
fn legendre_coefficients_are_those_of_the_function() {
    for (name, phase) in all() {
        let polynomials: [fn(f64) -> f64; 3] =
            [|c| c, |c| 1.5 * c * c - 0.5, |c| 2.5 * c * c * c - 1.5 * c];
        for (polynomial, found) in polynomials.into_iter().zip(phase.legendre()) {
            let mean = over_sphere(&phase, polynomial);
            assert!((mean - found).abs() < 0.02, "{name}: {found} for {mean}");
        }
    }
}

#[test]
fn mean_cosine_is_that_of_the_samples() {
    const COUNT: u32 = 50_000;
    for (name, phase) in all() {
        let mut stream = Stream::new(2, Stage::Test, 0, 0);
        let incoming = DVec3::new(0.6, 0.0, -0.8);
        let (mut sum, mut squares) = (0.0, 0.0);
        for _ in 0..COUNT {
            let cos_theta = phase.sample(incoming, stream.uniform2()).0.dot(incoming);
            sum += cos_theta;
            squares += cos_theta * cos_theta;
        }
        let mean = sum / f64::from(COUNT);
        let sigma = ((squares / f64::from(COUNT) - mean * mean).max(0.0) / f64::from(COUNT)).sqrt();
        // 4.5 sigma: one false alarm in 150,000.
        let off = (mean - phase.mean_cosine()).abs();
        assert!(off < 4.5 * sigma + 1e-12, "{name}: {mean} not {}", phase.mean_cosine());
    }
}

#[test]
fn samples_follow_the_function() {
    let incoming = DVec3::new(2.0, -3.0, 6.0) / 7.0;
    for (name, phase) in all() {
        // Half a sphere at a time, its rings crowded to resolve a peak in front or behind.
        for axis in [incoming, -incoming] {
            Chi2 { axis, one_minus_cos: 1.0, crowding: 6, samples: 30_000, is_symmetric: true }
                .check(
                    &name,
                    |stream| Some(phase.sample(incoming, stream.uniform2()).0),
                    |direction| {
                        // The cosine from the chord is exact inside the peak.
                        let drop = 0.5 * (direction - axis).length_squared();
                        phase.eval((1.0 - drop) * axis.dot(incoming).signum())
                    },
                );
        }
    }
}

#[test]
fn density_of_a_sample_is_the_value_of_the_function() {
    let incoming = DVec3::NEG_Z;
    for (name, phase) in all() {
        let mut stream = Stream::new(3, Stage::Test, 0, 0);
        for _ in 0..1000 {
            let (direction, pdf) = phase.sample(incoming, stream.uniform2());
            let value = phase.eval(direction.dot(incoming));
            // Rounding a cosine by 1e-16 moves a peak 1e-8 wide by 1e-8 of its height.
            assert!((pdf - value).abs() <= 1e-6 * pdf, "{name}: {pdf} not {value}");
        }
    }
}

#[test]
fn ends_of_the_unit_square_give_directions() {
    let last = 1.0 - f64::EPSILON / 2.0;
    for (name, phase) in all() {
        for u in [[0.0, 0.0], [last, last], [0.0, last], [last, 0.0], [0.5, 0.5]] {
            let (direction, pdf) = phase.sample(DVec3::Y, u);
            assert!((direction.length() - 1.0).abs() < 1e-12, "{name} {u:?}: {direction}");
            // A tip is of no height where it was cut off.
            let cut = matches!(phase, Phase::Tip(_)) && pdf == 0.0;
            assert!((pdf > 0.0 || cut) && pdf.is_finite(), "{name} {u:?}: {pdf}");
        }
    }
}

#[test]
fn known_values() {
    assert!((Phase::ISOTROPIC.eval(0.3) - 1.0 / (4.0 * PI)).abs() < 1e-15);
    assert!((Phase::RAYLEIGH.eval(1.0) - 3.0 / (8.0 * PI)).abs() < 1e-15);
    // (1 - g²) / (4 pi (1 - g)³) straight on.
    let forward = Phase::henyey_greenstein(0.9999).unwrap().eval(1.0);
    assert!((forward / (1.9999 / (4.0 * PI * 1e-8)) - 1.0).abs() < 1e-9, "{forward}");
    assert!(Phase::henyey_greenstein(0.0).unwrap().is_isotropic());
    assert!(!Phase::henyey_greenstein(0.1).unwrap().is_isotropic());
}

/// The fit matches the shape of the phase function, not its mean cosine: it is 0.011 to 0.016 above Mie
/// theory from 5 µm on. Below, its pieces are coarser: 0.02 off, and 0.05 at 0.5 µm and 2 µm.
#[test]
fn fog_is_as_forward_as_mie_theory_says() {
    for (diameter, off) in [
        (0.5, 0.05),
        (1.0, 0.02),
        (1.4, 0.02),
        (2.0, 0.052),
        (3.0, 0.02),
        (4.0, 0.02),
        (5.0, 0.016),
        (7.0, 0.016),
        (10.0, 0.016),
        (20.0, 0.016),
        (50.0, 0.016),
    ] {
        let (g, theory) = (Phase::fog(diameter).unwrap().mean_cosine(), mie::droplets(diameter));
        assert!((g - theory).abs() < off, "{diameter} µm: {g}, by Mie theory {theory}");
    }
    // Toward Rayleigh's, which scatters as much ahead as back.
    assert!(Phase::fog(1e-3).unwrap().mean_cosine().abs() < 1e-3);
}

#[test]
fn values_out_of_range_are_refused_by_name() {
    for (found, word) in [
        (Phase::henyey_greenstein(1.0), "mean cosine"),
        (Phase::henyey_greenstein(f64::NAN), "mean cosine"),
        (Phase::two_lobe(0.5, -1.5, 0.5), "second lobe"),
        (Phase::two_lobe(0.5, 0.5, 1.01), "weight"),
        (Phase::fog(0.0), "droplet diameter"),
        (Phase::fog(50.1), "droplet diameter"),
        (Phase::fog(f64::NAN), "droplet diameter"),
    ] {
        let message = found.unwrap_err();
        assert!(message.contains(word) && message.contains("must"), "{message}");
    }
}

proptest! {
    #[test]
    fn fog_of_any_size_is_positive_and_samples_well(
        diameter in 1e-6f64..50.0,
        u in 0.0f64..1.0,
        v in 0.0f64..1.0,
    ) {
        let phase = Phase::fog(diameter).unwrap();
        let (direction, pdf) = phase.sample(DVec3::X, [u, v]);
        prop_assert!(direction.is_finite() && pdf > 0.0 && pdf.is_finite());
        prop_assert!(phase.mean_cosine().abs() < 1.0);
    }
}

/// Peak and rest add up to the whole, and the peak is what is more concentrated.
#[test]
fn functions_split_into_a_peak_and_the_rest() {
    let mut parted = 0;
    for (name, phase) in whole() {
        let Some(split) = phase.split(MOST, Some(SMOOTH)) else { continue };
        parted += 1;
        assert!(split.peak.concentration() > MOST && split.rest.concentration() <= MOST, "{name}");
        for i in 0..=2000 {
            let cos_theta = f64::from(i) / 1000.0 - 1.0;
            let parts = split.share * split.peak.eval(cos_theta)
                + (1.0 - split.share) * split.rest.eval(cos_theta);
            let whole = phase.eval(cos_theta);
            assert!((parts / whole - 1.0).abs() < 1e-12, "{name} at {cos_theta}: {parts}, {whole}");
        }
    }
    assert!(parted >= 6, "droplets of 5, 20 and 50 µm have a peak, as do three narrow lobes");
    for smooth in [Phase::two_lobe(0.8, -0.3, 0.7), Phase::henyey_greenstein(0.7)] {
        assert_eq!(smooth.unwrap().split(MOST, Some(SMOOTH)), None);
    }
}
