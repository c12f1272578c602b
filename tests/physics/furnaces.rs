//! White furnaces: what absorbs nothing is not seen in front of a sky that shines alike from all sides.
//!
//! Seeds are fixed.

use std::path::Path;

use fogbow::render::{Silent, render_reference};

use crate::pictures::{four_seeds, mean, mean_of_seeds, scene};

/// Rays of the reference and photons of each seed are as many as make both means scatter by 0.05 % at most:
/// the bound is 4 standard errors, a false alarm of 6e-5 a comparison. Photons of the thin ball are
/// scattered least often, and so the most of them are needed; in the others two hundred thousand scatter
/// by 0.08 %.
#[test]
fn a_white_furnace_stays_white() {
    let folder = tempfile::tempdir().unwrap();
    let shapes = [
        (
            700_000,
            "region = { sphere = { center = [0.0, 0.0, 0.0], radius = 1.0 } }\nsigma_t = 3.0",
        ),
        (
            350_000,
            "region = { box = { min = [-1.0, -0.5, -1.0], max = [1.0, 0.7, 1.0] } }\nsigma_t = 2.0\n\
             phase = { type = \"henyey-greenstein\", g = 0.6 }",
        ),
        (
            200_000,
            "region = { box = { min = [-1.0, -0.5, -1.0], max = [1.0, 0.7, 1.0] } }\nsigma_t = 6.0\n\
             phase = { type = \"henyey-greenstein\", g = 0.9 }",
        ),
    ];
    for (count, medium) in shapes {
        let text = format!(
            r#"
            [camera]
            position = [0.3, 0.4, 4.0]
            target = [0.0, 0.0, 0.0]
            fov = 30.0
            [film]
            size = [24, 24]
            [[medium]]
            albedo = 1.0
            {medium}
            [[light]]
            type = "environment"
            radiance = 1.0
            "#
        );
        let exact = scene(folder.path(), &text, 2048, 0);
        let (reference, error) = mean(&render_reference(&exact, &exact.render, &Silent).film);
        let photons = four_seeds(&scene(folder.path(), &text, 32, count));
        assert!(error < 0.0005, "{medium}: reference scatters by {error}");
        assert!((reference - 1.0).abs() < 0.002, "{medium}: reference {reference}");
        assert!((photons - 1.0).abs() < 0.002, "{medium}: photon map {photons}");
    }
}

/// Few photons make moments so noisy that much of what gathers read is negative: no part of it may be cut
/// off. One seed spreads by 6.9 % at most, the mean of eight by 2.5 %: with the bound of 11 % a false alarm in
/// 100,000. Were each gather clamped to 0, moments would be 34 % bright.
#[test]
fn a_white_furnace_stays_white_with_few_photons() {
    let folder = tempfile::tempdir().unwrap();
    for strategy in ["moments", "shared-gathers"] {
        let text = format!(
            r#"
            [camera]
            position = [0.3, 0.4, 4.0]
            target = [0.0, 0.0, 0.0]
            fov = 20.0
            [film]
            size = [24, 24]
            [[medium]]
            region = {{ sphere = {{ center = [0.0, 0.0, 0.0], radius = 1.0 }} }}
            sigma_t = 50.0
            albedo = 1.0
            phase = {{ type = "henyey-greenstein", g = 0.85 }}
            [[light]]
            type = "environment"
            radiance = 1.0
            [render]
            strategy = "{strategy}"
            "#
        );
        let light = mean_of_seeds(&scene(folder.path(), &text, 32, 2000), 8);
        assert!((light - 1.0).abs() < 0.11, "{strategy}: {light}");
    }
}

/// Over ground that swallows nothing it stays white however high: light of all the ground comes to it, and
/// no light of the sky that the ground hides. Four seeds together spread by at most 0.30 % over even ground
/// and 0.21 % over a mirror: of other seeds one comparison in 500 would fail falsely, at most.
#[test]
fn a_white_furnace_stays_white_over_endless_ground() {
    let folder = tempfile::tempdir().unwrap();
    let materials =
        [(0.0095, r#"type = "diffuse", reflectance = 1.0"#), (0.007, r#"type = "mirror""#)];
    for (height, (bound, material)) in
        [1.5, 20.0].into_iter().flat_map(|height| materials.map(|material| (height, material)))
    {
        let text = format!(
            r#"
            [camera]
            position = [0.3, {eye:?}, 4.0]
            target = [0.0, {height:?}, 0.0]
            fov = 24.0
            [film]
            size = [16, 16]
            [[medium]]
            region = {{ sphere = {{ center = [0.0, {height:?}, 0.0], radius = 1.0 }} }}
            sigma_t = 2.0
            albedo = 1.0
            [[surface]]
            shape = "plane"
            point = [0.0, 0.0, 0.0]
            normal = [0.0, 1.0, 0.0]
            material = {{ {material} }}
            [[light]]
            type = "environment"
            radiance = 1.0
            "#,
            eye = height + 0.4
        );
        let scene = scene(folder.path(), &text, 64, 250_000);
        let light = four_seeds(&scene);
        assert!((light - 1.0).abs() < bound, "{height} m over {material}: {light}");
    }
}

/// A ball of fog of one mean free path in a white furnace, seen from its middle.
fn ball_of_fog(phase: &str, strategy: &str) -> String {
    format!(
        r#"
        [camera]
        position = [0.0, 0.0, 0.0]
        target = [0.0, 0.0, -1.0]
        fov = 90.0
        [film]
        size = [24, 24]
        [render]
        strategy = "{strategy}"
        [[medium]]
        region = {{ sphere = {{ center = [0.0, 0.0, 0.0], radius = 10.0 }} }}
        sigma_t = 0.1
        albedo = 1.0
        phase = {phase}
        [[light]]
        type = "environment"
        radiance = 1.0
        "#
    )
}

/// From inside a ball of droplets in a white furnace all is as bright as the sky: half of the light
/// comes by a peak of few degrees, which rays follow; none of it may be lost or counted twice. What is
/// scattered again comes from photon beams. Seeds spread by 0.73 %, means of four by 0.37 %: a false alarm
/// in 1500.
#[test]
fn white_furnace_from_inside_fog() {
    let folder = tempfile::tempdir().unwrap();
    let text = ball_of_fog(r#"{ type = "fog", diameter = 20.0 }"#, "auto");
    let light = four_seeds(&scene(folder.path(), &text, 16, 300_000));
    assert!((light - 1.0).abs() < 0.0125, "{light}");
}

/// From inside a ball of fog whose phase function has no peak rays gather photons near the camera, and read cells
/// further away: where one begins the other ends, so that all stays as bright as the sky. Seeds spread by 1.3 %,
/// means of eight by .45 %: the bound of 2 % is 4.4 of that, a false alarm in 90,000.
#[test]
fn a_white_furnace_stays_white_from_inside_smooth_fog() {
    let folder = tempfile::tempdir().unwrap();
    let phase = r#"{ type = "henyey-greenstein", g = 0.5 }"#;
    let text = ball_of_fog(phase, "fluence-toward-eye");
    let light = mean_of_seeds(&scene(folder.path(), &text, 16, 100_000), 8);
    assert!((light - 1.0).abs() < 0.02, "{light}");
}

/// Inside a dense cloud few photons come near the eye, all of them from outside. What is chosen there follows
/// paths, which lose nothing. Moments asked for by name spread by 2.4 % a seed, the mean of eight by .85 %: the
/// bound of 4 % is 4.7 of that, a false alarm in 100,000.
#[test]
fn a_white_furnace_stays_white_from_inside_a_cloud() {
    let folder = tempfile::tempdir().unwrap();
    let cloud = Path::new(env!("CARGO_MANIFEST_DIR")).join("volumes/cloud.vdb");
    let light = |g: f64, strategy: &str| {
        let text = format!(
            r#"
            [camera]
            position = [0.0, 250.0, 0.0]
            target = [100.0, 250.0, 30.0]
            fov = 60
            [film]
            size = [12, 12]
            [[medium]]
            file = {cloud:?}
            sigma_t = 0.05
            albedo = 1.0
            phase = {{ type = "henyey-greenstein", g = {g:?} }}
            [[light]]
            type = "environment"
            radiance = 1.0
            {strategy}
            "#
        );
        mean_of_seeds(&scene(folder.path(), &text, 8, 100_000), 8)
    };
    for g in [0.0, 0.85] {
        let chosen = light(g, "");
        assert!((chosen - 1.0).abs() < 0.01, "g {g}: {chosen}");
    }
    let moments = light(0.0, "[render]\nstrategy = 'moments'");
    assert!((moments - 1.0).abs() < 0.04, "{moments}");
}
