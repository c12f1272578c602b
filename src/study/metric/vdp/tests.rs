use std::f64::consts::TAU;

use super::*;
use crate::math::{Stage, Stream};

const SIDE: usize = 96;

/// A grey picture of display-linear values at pixel centres.
fn picture(of: impl Fn(f64, f64) -> f64) -> Image {
    let at = |i: usize| [of((i % SIDE) as f64 + 0.5, (i / SIDE) as f64 + 0.5) as f32; 3];
    Image::new(SIDE, SIDE, (0..SIDE * SIDE).map(at).collect())
}

/// White noise from -1 to 1, the same at every call.
fn noise(x: f64, y: f64) -> f64 {
    2.0 * Stream::new(7, Stage::Test, x as u64, y as u64).uniform() - 1.0
}

fn seen(reference: &Image, test: &Image) -> Map {
    vdp_map(reference, test, 0.0, &Display::default())
}

/// The highest probability for a grating of frequency (fx, fy), in halves of a cycle over the
/// picture's side, on a field of `luminance`, at `times` its threshold contrast.
fn grating(fx: f64, fy: f64, luminance: f64, times: f64) -> f32 {
    let display = Display::default();
    let [fx, fy] = [fx, fy].map(|f| f / (2 * SIDE) as f64);
    let sensitivity = Viewing::new(&display, luminance, SIDE, SIDE).sensitivity(fx, fy);
    let shown = |l: f64| (l - display.black) / (display.white - display.black);
    let test = picture(|x, y| {
        let wave = (TAU * fx * x).cos() * (TAU * fy * y).cos();
        shown(luminance * (1.0 + times * wave / sensitivity))
    });
    let map = seen(&picture(|_, _| shown(luminance)), &test);
    map.values.into_iter().fold(0.0, f32::max)
}

#[test]
fn half_of_the_viewers_see_a_grating_at_threshold() {
    // Frequencies beside the middle of a ring, 1/12, 1/6 and 1/3 cycles a pixel, along the axes.
    for frequency in [17.0, 33.0, 65.0] {
        for luminance in [5.0, 40.0] {
            for (fx, fy) in [(frequency, 0.0), (0.0, frequency)] {
                let at = |times| grating(fx, fy, luminance, times);
                let threshold = at(1.0);
                assert!((0.45..0.55).contains(&threshold), "{fx} {fy} {luminance}: {threshold}");
                assert!(at(0.5) < 0.1 && at(2.0) > 0.98, "{fx} {fy} {luminance}");
            }
        }
    }
}

#[test]
fn between_two_rings_the_threshold_is_at_most_1_6_times_as_high() {
    // 1/4 cycle a pixel: halved by two rings, so that 2 (c / 2)^3.5 = 1 at c = 2^(5/7) = 1.64.
    assert!(grating(49.0, 0.0, 40.0, 1.0) < 0.2);
    assert!((0.45..0.55).contains(&grating(49.0, 0.0, 40.0, 1.64)));
}

#[test]
fn the_same_picture_is_never_seen_to_differ() {
    let same = picture(|x, y| 0.5 + 0.4 * noise(x, y));
    assert!(seen(&same, &same).values.iter().all(|p| *p == 0.0));
}

#[test]
fn differences_order_as_they_look() {
    let grey = picture(|_, _| 0.3);
    let offset = seen(&grey, &picture(|_, _| 0.301)).mean();
    let faint = seen(&grey, &picture(|x, y| 0.3 + 0.001 * noise(x, y))).mean();
    let visible = seen(&grey, &picture(|x, y| 0.3 + 0.02 * noise(x, y))).mean();
    assert!(offset < 1e-3 && faint < 0.01, "{offset} {faint}");
    assert!(visible > 0.5, "{visible}");

    // The same noise over a texture of its own frequencies.
    let texture = |x: f64, y: f64| 0.3 + 0.25 * noise(x + 1000.0, y);
    let masked = picture(|x, y| texture(x, y) + 0.02 * noise(x, y));
    let masked = seen(&picture(texture), &masked).mean();
    assert!(masked < 0.7 * visible, "{masked} {visible}");

    let blurred = picture(|x, y| {
        let around = (0..9).map(|i| texture(x + f64::from(i % 3), y + f64::from(i / 3)));
        around.sum::<f64>() / 9.0
    });
    let blurred = seen(&picture(texture), &blurred).mean();
    assert!(blurred > 0.5, "{blurred}");
}

#[test]
fn a_global_shift_of_brightness_is_barely_seen() {
    let texture = |x: f64, y: f64| 0.3 + 0.02 * noise(x, y);
    let brighter = picture(|x, y| 1.1 * texture(x, y));
    let shift = seen(&picture(texture), &brighter).mean();
    assert!(shift < 0.02, "{shift}");
}

#[test]
fn borders_do_not_ring() {
    // A ramp jumps where a picture is simply repeated; the only difference is in the middle.
    let ramp = |x: f64, y: f64| 0.05 + 0.9 * (x + y) / (2 * SIDE) as f64;
    let middle = |v: f64| (v - 48.0).abs() < 12.0;
    let test =
        picture(|x, y| ramp(x, y) + if middle(x) && middle(y) { 0.05 * noise(x, y) } else { 0.0 });
    let map = seen(&picture(ramp), &test);
    let at = |x: usize, y: usize| map.values[y * SIDE + x];
    let rim = (0..SIDE).flat_map(|i| [at(i, 0), at(i, SIDE - 1), at(0, i), at(SIDE - 1, i)]);
    let rim = rim.fold(0.0, f32::max);
    assert!(rim < 0.05, "{rim}");
    assert!((40..56).map(|i| at(i, i)).fold(0.0, f32::max) > 0.9);
}

#[test]
fn the_localised_map_is_the_map_where_luminance_differs() {
    let texture = |x: f64, y: f64| 0.3 + 0.02 * noise(x, y);
    let middle = |v: f64| (v - 48.0).abs() < 8.0;
    let test = |x: f64, y: f64| texture(x, y) * if middle(x) && middle(y) { 1.5 } else { 1.0 };
    let (reference, test) = (picture(texture), picture(test));
    let plain = seen(&reference, &test);
    let localized = vdp_localized_map(&plain, &reference, &test, 0.0, &Display::default());
    for (i, (plain, localized)) in plain.values.iter().zip(&localized.values).enumerate() {
        let differs = reference.pixels()[i] != test.pixels()[i];
        assert_eq!(*localized, if differs { *plain } else { 0.0 }, "pixel {i}");
    }
    let beside = plain.values[48 * SIDE + 57];
    assert!(beside > 0.5, "the plain map is {beside} beside the square");
    assert!(localized.share_above(VISIBLE) > 0.0);
}

#[test]
fn any_size_will_do() {
    for (width, height) in [(1, 1), (1, 7), (37, 53), (5, 2)] {
        let grey = |v| Image::new(width, height, vec![[v; 3]; width * height]);
        let map = seen(&grey(0.2), &grey(0.7));
        assert_eq!((map.width, map.height, map.values.len()), (width, height, width * height));
        assert!(map.values.iter().all(|p| (0.0..=1.0).contains(p)));
    }
}
