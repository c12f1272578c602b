//! Metrics against values worked out by hand.

use fogbow::image::Image;
use fogbow::study::metric::{
    Display, Errors, Map, Options, code_errors, compare, default_epsilon, flip_hdr_map,
    flip_ldr_map, jod, mae, mean_difference, mean_ratio, mse, relative_map, ssim,
    vdp_localized_map,
};
use proptest::prelude::*;

fn grey(width: usize, values: &[f32]) -> Image {
    Image::new(width, values.len() / width, values.iter().map(|&v| [v; 3]).collect())
}

/// Reference and test of four pixels; differences 0.5, -0.25, 0 and 1.
fn pair() -> (Image, Image) {
    (grey(2, &[0.5, 0.75, 1.0, 1.75]), grey(2, &[1.0, 0.5, 1.0, 2.75]))
}

#[test]
fn errors_of_radiance() {
    let (r, t) = pair();
    assert_eq!(mse(&r, &t), (0.25 + 0.0625 + 1.0) / 4.0);
    assert_eq!(mae(&r, &t), 1.75 / 4.0);
    assert_eq!(mean_difference(&r, &t), 1.25 / 4.0);
    assert_eq!(mean_ratio(&r, &t), Some(5.25 / 4.0));
    assert_eq!(mean_ratio(&grey(1, &[0.0]), &t), None);
}

#[test]
fn channels_count_alike() {
    let r = Image::new(1, 1, vec![[1.0, 2.0, 3.0]]);
    let t = Image::new(1, 1, vec![[1.0, 2.0, 6.0]]);
    assert_eq!(mse(&r, &t), 3.0);
    assert_eq!(mean_difference(&r, &t), 1.0);
    // 3 over (grey 2)² + 1².
    assert!((relative_map(&r, &t, 1.0).values[0] - 0.6).abs() < 1e-7);
}

#[test]
fn relative_error_and_its_epsilon() {
    let (r, t) = pair();
    assert_eq!(default_epsilon(&r), Some(0.5));
    assert_eq!(default_epsilon(&grey(1, &[0.0])), None);
    let map = relative_map(&r, &t, 0.5);
    let expected = [0.25 / 0.5, 0.0625 / 0.8125, 0.0, 1.0 / 3.3125];
    for (found, expected) in map.values.iter().zip(expected) {
        assert!((f64::from(*found) - expected).abs() < 1e-7, "{found} {expected}");
    }
}

#[test]
fn trimming_leaves_out_the_worst_thousandth() {
    let mut values = vec![1.0; 1999];
    values.push(1000.0);
    values[7] = 500.0;
    let map = Map { width: 2000, height: 1, values };
    assert_eq!(map.trimmed_mean(0.001), 1.0);
    assert_eq!(map.mean(), (1998.0 + 1500.0) / 2000.0);
    assert_eq!(map.share_above(500.0), 1.0 / 2000.0);
    assert_eq!(Map { width: 1, height: 1, values: vec![3.0] }.trimmed_mean(0.001), 3.0);
}

#[test]
fn a_pixel_in_error_is_one_code_off_in_one_channel() {
    // Codes of linear 0, 0.5 and 1 are 0, 188 and 255; 0.501 is still 188, 3 clips to 255.
    let r = Image::new(2, 2, vec![[0.0; 3], [0.5; 3], [1.0; 3], [0.5; 3]]);
    let t = Image::new(2, 2, vec![[0.0; 3], [0.501; 3], [3.0; 3], [0.5, 0.5, 1.0]]);
    let errors = code_errors(&r, &t, 0.0);
    assert_eq!(errors.share, 0.25);
    let expected = 67.0 * 67.0 / (12.0 * 255.0 * 255.0);
    assert!((errors.mse - expected).abs() < 1e-15);
    let white = code_errors(&grey(1, &[0.0]), &grey(1, &[1.0]), 0.0);
    assert_eq!((white.mse, white.share), (1.0, 1.0));
    // A stop more shows 0.5 as white.
    assert_eq!(code_errors(&grey(1, &[0.5]), &grey(1, &[0.7]), 1.0).share, 0.0);
}

#[test]
fn ssim_of_flat_pictures_is_that_of_luminance() {
    // Codes 0 and 1, no variance: C1 / (1 + C1) with C1 = 1e-4.
    let [black, white] = [0.0, 1.0].map(|v| grey(11, &[v; 121]));
    let found = ssim(&black, &white, 0.0).unwrap();
    assert!((found - 1e-4 / 1.0001).abs() < 1e-12, "{found}");
    assert_eq!(ssim(&white, &white, 0.0), Some(1.0));
    assert_eq!(ssim(&grey(10, &[0.0; 120]), &grey(10, &[0.0; 120]), 0.0), None);
}

#[test]
fn flip_of_black_and_white_is_nearly_its_worst() {
    let [black, white] = [0.0, 1.0].map(|v| grey(8, &[v; 64]));
    let map = flip_ldr_map(&black, &white, 0.0, 67.02).unwrap();
    // flip-evaluator 1.7 has 0.967388.
    assert!((map.mean() - 0.967_388).abs() < 1e-5, "{}", map.mean());
    assert_eq!(flip_hdr_map(&black, &white, 67.02).unwrap(), None);
    assert!(flip_hdr_map(&white, &black, 67.02).unwrap().unwrap().mean() > 0.5);
    assert_eq!(flip_ldr_map(&white, &white, 0.0, 67.02).unwrap().mean(), 0.0);
}

#[test]
fn the_same_picture_has_10_jod() {
    let same = grey(8, &[0.25; 64]);
    assert_eq!(jod(&same, &same, 0.0, "standard_4k").unwrap(), Some(10.0));
    assert_eq!(jod(&grey(3, &[0.5; 12]), &grey(3, &[0.6; 12]), 0.0, "standard_4k").unwrap(), None);
    let message = jod(&same, &same, 0.0, "tv").unwrap_err().to_string();
    assert!(message.contains("\"tv\"") && message.contains("standard_4k"), "{message}");
}

#[test]
fn the_same_picture_has_no_error() {
    let values: Vec<f32> = (0..400).map(|i| (i * i % 97) as f32 / 40.0).collect();
    let same = grey(20, &values);
    let errors = compare(&same, &same, &Options::default()).unwrap().errors;
    let expected = Errors {
        mse: 0.0,
        rmse: 0.0,
        mae: 0.0,
        mean_difference: 0.0,
        mean_ratio: Some(1.0),
        epsilon: default_epsilon(&same),
        relative_mse: Some(0.0),
        relative_mse_trimmed: Some(0.0),
        code_mse_percent: 0.0,
        code_pixels_percent: 0.0,
        vdp_mean_percent: 0.0,
        vdp_visible_percent: 0.0,
        vdp_localized_mean_percent: 0.0,
        vdp_localized_visible_percent: 0.0,
        ssim: errors.ssim.filter(|s| (s - 1.0).abs() < 1e-12),
        flip_ldr: 0.0,
        flip_hdr: Some(0.0),
        colorvideovdp_jod: Some(10.0),
    };
    assert_eq!(errors, expected);
    assert!(errors.ssim.is_some());
}

/// Twenty pixels that are 50 times too bright on a ramp of 0.2 to 0.6, 512 x 384. An independent
/// implementation of Daly's model has 1.6 % on average and 1.1 % visible. The localised map can hold
/// no more than the share of the twenty pixels.
#[test]
fn bright_pixels_spread_in_the_vdp_and_stay_where_they_are_in_the_localised() {
    let (width, height) = (512, 384);
    let at = |i: usize| 0.2 + 0.4 * ((i % width) as f32 + 0.5) / width as f32;
    let ramp: Vec<f32> = (0..width * height).map(at).collect();
    let mut spoilt = ramp.clone();
    let places: Vec<usize> =
        (0..20).map(|k| (97 * k + 60) % width + width * (19 * k + 11)).collect();
    places.iter().for_each(|&place| spoilt[place] *= 50.0);
    let (ramp, spoilt) = (grey(width, &ramp), grey(width, &spoilt));
    let comparison = compare(&ramp, &spoilt, &Options::default()).unwrap();

    let errors = &comparison.errors;
    let plain = [errors.vdp_mean_percent, errors.vdp_visible_percent];
    assert!((1.4..2.4).contains(&plain[0]) && (0.9..1.5).contains(&plain[1]), "{plain:?}");
    let share = 100.0 * 20.0 / (width * height) as f64;
    let localized = [errors.vdp_localized_mean_percent, errors.vdp_localized_visible_percent];
    // All twenty are seen; the last digit of the sum is free.
    let all_seen = |v: &f64| (0.85..1.0 + 1e-9).contains(&(v / share));
    assert!(localized.iter().all(all_seen), "{localized:?} {share}");

    for (i, localized) in comparison.vdp_localized.values.iter().enumerate() {
        let expected = if places.contains(&i) { comparison.vdp.values[i] } else { 0.0 };
        assert_eq!(*localized, expected, "pixel {i}");
    }
    let beside = comparison.vdp.values[places[0] + 1];
    assert!(beside > 0.5, "the plain map is {beside} beside a bright pixel");
}

#[test]
fn luminances_within_a_ten_thousandth_are_the_same_to_the_localised_vdp() {
    let probability = |r: [f32; 3], t: [f32; 3]| {
        let [r, t] = [r, t].map(|p| Image::new(16, 16, vec![p; 256]));
        let mut spoilt = r.pixels().to_vec();
        spoilt[136] = t.pixels()[136];
        let map = Map { width: 16, height: 16, values: vec![0.5; 256] };
        let spoilt = Image::new(16, 16, spoilt);
        vdp_localized_map(&map, &r, &spoilt, 0.0, &Display::default()).values[136]
    };
    // White is 80 cd/m² and black 0.2: 1e-4 cd/m² are 1.253e-6 of the range.
    assert_eq!(probability([0.5; 3], [0.5 + 1.1e-6; 3]), 0.0);
    assert_eq!(probability([0.5; 3], [0.5 + 1.4e-6; 3]), 0.5);
    // Beyond white all is white, and colour of the same luminance does not enter.
    assert_eq!(probability([3.0; 3], [40.0; 3]), 0.0);
    let red = [0.5 + 0.0722, 0.5, 0.5 - 0.2126];
    assert_eq!(probability([0.5; 3], red), 0.0);
}

#[test]
fn pictures_that_cannot_be_compared_are_refused() {
    let message =
        |r: &Image, t: &Image| compare(r, t, &Options::default()).unwrap_err().to_string();
    let (r, _) = pair();
    let sizes = message(&r, &grey(1, &[0.5, 0.5, 0.5]));
    assert_eq!(
        sizes,
        "test: has 1 x 3 pixels and reference has 2 x 2; both must have the same size"
    );
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let broken = grey(2, &[0.5, 0.5, 0.5, bad]);
        assert!(message(&r, &broken).starts_with("test: pixel 1, 1 is "));
        assert!(message(&broken, &r).ends_with("every value must be finite"));
    }
}

#[test]
fn options_out_of_range_are_refused() {
    let (r, t) = pair();
    for options in [
        Options { exposure: f64::NAN, ..Options::default() },
        Options { epsilon: Some(0.0), ..Options::default() },
        Options { flip_pixels_per_degree: -1.0, ..Options::default() },
        Options { flip_pixels_per_degree: 1e-9, ..Options::default() },
        Options { colorvideovdp_display: "tv".into(), ..Options::default() },
        Options { display: Display { black: 0.0, ..Display::default() }, ..Options::default() },
    ] {
        assert_eq!(compare(&r, &t, &options).unwrap_err().exit_code(), 2, "{options:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..Default::default() })]

    /// Whatever is finite gives figures that are finite and in range.
    #[test]
    fn every_figure_is_finite(
        width in 1_usize..24,
        values in prop::collection::vec((-1.0_f32..1e3, 0.0_f32..2.0), 24..150),
    ) {
        let whole = values.len() / width * width;
        let [r, t] = [0, 1].map(|which| {
            let pick = |&(a, b): &(f32, f32)| if which == 0 { a } else { b };
            grey(width, &values[..whole].iter().map(pick).collect::<Vec<_>>())
        });
        let comparison = compare(&r, &t, &Options::default()).unwrap();
        let json = serde_json::to_value(&comparison.errors).unwrap();
        for (key, value) in json.as_object().unwrap() {
            prop_assert!(value.is_null() || value.as_f64().is_some_and(f64::is_finite), "{key}");
        }
        let shares = |map: &Map| map.values.iter().all(|v| (0.0..=1.0).contains(v));
        prop_assert!(shares(&comparison.vdp) && shares(&comparison.flip_ldr));
        let maps = comparison.vdp.values.iter().zip(&comparison.vdp_localized.values);
        for ((plain, localized), (r, t)) in maps.zip(r.pixels().iter().zip(t.pixels())) {
            prop_assert!(*localized == 0.0 || localized == plain);
            prop_assert!(*localized == 0.0 || r != t);
        }
        let back: Errors = serde_json::from_value(json).unwrap();
        prop_assert!((back.mse / comparison.errors.mse - 1.0).abs() < 1e-12);
    }
}
