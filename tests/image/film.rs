//! Film, EXR, PNG and textures through files, and the accumulator against a two-pass reference.

use std::fs;
use std::io::Cursor;
use std::path::Path;

use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Layer, LayerAttributes,
    LineOrder, Vec2, WritableImage, f16,
};
use fogbow::film::{Accumulator, Sample};
use fogbow::image::{
    FAR, Film, FilmPixel, Image, View, ViewTransform, decode_texture, exr_bytes, png_path_beside,
    read_exr, read_header, read_layers, read_texture, write_exr, write_exr_layers, write_png,
};
use fogbow::math::{Rgb, Stage, Stream, luminance};
use proptest::prelude::*;

fn sample(radiance: Rgb) -> Sample {
    Sample { radiance, alpha: 0.5, transmittance: 0.5, depth: 2.0, ..Sample::default() }
}

/// 37 x 21 pixels, more than one block of ZIP, with a hole that nothing hits.
fn film() -> Film {
    let mut film = Film::new(37, 21);
    for y in 0..21 {
        for x in 0..37 {
            let v = (y * 37 + x) as f64;
            let pixel = FilmPixel {
                radiance: Rgb::new(v, 0.5 * v, 0.25 * v),
                visible_emission: Rgb::ZERO,
                alpha: v / 777.0,
                depth: if x < 5 { f64::INFINITY } else { v },
                transmittance: 0.1,
                saliency: 0.2,
                xs: 0.3,
                rays: 16.0,
                radius: 0.4,
                step: 0.5,
                variance: v * v,
            };
            film.set(x, y, &pixel);
        }
    }
    film
}

fn attributes() -> Vec<(&'static str, String)> {
    vec![
        ("fogbow:version", "0.1.0".into()),
        ("fogbow:scene", "hash of Nebelbogen über Köln".into()),
        ("fogbow:seed", "7".into()),
        ("fogbow:settings", "x".repeat(1000)),
    ]
}

#[test]
fn a_film_comes_back_with_its_layers_and_attributes() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.exr");
    let film = film();
    write_exr(&path, &film, &attributes()).unwrap();
    let back = read_layers(&path).unwrap();
    assert_eq!((back.width, back.height), (37, 21));
    assert_eq!(back.channels.len(), 12);
    for (name, values) in film.layers() {
        assert_eq!(back.get(name), Some(values), "{name}");
    }
    for (name, value) in attributes() {
        assert_eq!(back.attributes.get(name), Some(&value));
    }
    assert_eq!(back.get("Z").unwrap()[0], FAR as f32);
    assert_eq!(read_exr(&path).unwrap(), film.image());
}

#[test]
fn layers_of_one_value_are_no_planes_of_the_file() {
    let film = film();
    let bytes = exr_bytes(Path::new("a.exr"), &film, false, &[]).unwrap();
    // Saliency, xs, transmittance, rays, radius and step.
    let constants = bytes.windows(16).filter(|at| *at == b"fogbow:constant.").count();
    assert_eq!(constants, 6);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    fs::write(&path, &bytes).unwrap();
    let header = read_header(&path).unwrap();
    let read = read_layers(&path).unwrap();
    assert!(header.attributes == read.attributes && read.channels.keys().eq(&header.channels));
    assert!(header.attributes.keys().all(|name| !name.starts_with("fogbow:constant")));
    for (name, values) in film.layers() {
        assert_eq!(read.get(name), Some(values), "{name}");
    }
}

#[test]
fn half_floats_hold_colours_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let mut film = film();
    let written = |film: &Film| {
        fs::write(&path, exr_bytes(&path, film, true, &[]).unwrap()).unwrap();
        (read_header(&path).unwrap().half, read_layers(&path).unwrap())
    };
    let (half, layers) = written(&film);
    assert_eq!(half, ["A", "B", "G", "R"]);
    assert_eq!(layers.get("Z"), film.layer("Z"));
    let pairs = layers.get("R").unwrap().iter().zip(film.layer("R").unwrap());
    assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() <= 2_f32.powi(-11) * b));
    // One pixel that half floats would make infinite.
    let bright = FilmPixel { radiance: Rgb::splat(1e5), ..FilmPixel::default() };
    film.set(0, 0, &bright);
    let (half, layers) = written(&film);
    assert_eq!((half.len(), layers.get("G").unwrap()[0]), (0, 1e5));
}

#[test]
fn bytes_do_not_depend_on_threads_or_repetition() {
    let folder = tempfile::tempdir().unwrap();
    let film = film();
    let bytes = |threads: usize, name: &str| {
        let path = folder.path().join(name);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| write_exr(&path, &film, &attributes())).unwrap();
        fs::read(path).unwrap()
    };
    let one = bytes(1, "one.exr");
    for round in 0..8 {
        assert!(one == bytes(1 + round % 2, "again.exr"), "round {round}");
    }
}

#[test]
fn what_is_not_finite_never_reaches_a_layer() {
    let mut film = Film::new(1, 1);
    let pixel = FilmPixel {
        radiance: Rgb::new(f64::NAN, f64::INFINITY, 1.0),
        depth: f64::NAN,
        ..FilmPixel::default()
    };
    film.set(0, 0, &pixel);
    assert_eq!(film.repaired(), 3);
    assert!(film.layers().all(|(_, values)| values[0].is_finite()));

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.exr");
    let error = write_exr_layers(&path, 2, 1, &[("X", &[0.0, f32::NAN])], &[]).unwrap_err();
    assert!(error.to_string().contains("layer \"X\" is NaN at pixel 1, 0"), "{error}");
    assert!(!path.exists());
}

#[test]
fn names_that_exr_cannot_hold_are_refused() {
    let path = Path::new("never-written.exr");
    let layer: &[(&str, &[f32])] = &[("Y", &[1.0])];
    let refused = |attributes: &[(&str, String)]| {
        write_exr_layers(path, 1, 1, layer, attributes).unwrap_err().to_string()
    };
    assert!(refused(&[("channels", String::new())]).contains("reserved"));
    assert!(refused(&[("a", String::new()), ("a", String::new())]).contains("twice"));
    assert!(refused(&[("", String::new())]).contains("1 to 255 bytes"));
    let error = write_exr_layers(path, 2, 1, layer, &[]).unwrap_err().to_string();
    assert!(error.contains("1 values; 2 x 1"), "{error}");
}

#[test]
fn a_failed_write_names_the_path_and_leaves_the_earlier_file() {
    let folder = tempfile::tempdir().unwrap();
    let missing = folder.path().join("missing/out.exr");
    let error = write_exr(&missing, &film(), &[]).unwrap_err().to_string();
    assert!(error.contains("missing/out.exr"), "{error}");

    let path = folder.path().join("out.exr");
    fs::write(&path, "earlier").unwrap();
    write_exr_layers(&path, 1, 1, &[("Y", &[f32::INFINITY])], &[]).unwrap_err();
    assert_eq!(fs::read(&path).unwrap(), b"earlier");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn damaged_exr_files_are_errors() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.exr");
    write_exr(&path, &film(), &attributes()).unwrap();
    let whole = fs::read(&path).unwrap();
    for length in (0..whole.len()).step_by(97) {
        fs::write(&path, &whole[..length]).unwrap();
        let error = read_layers(&path).unwrap_err().to_string();
        assert!(error.contains("out.exr"), "{error}");
    }
    fs::write(&path, "not a picture").unwrap();
    assert!(read_layers(&path).unwrap_err().to_string().contains("not an EXR file"));
    assert!(
        read_texture(&path).unwrap_err().to_string().contains("use EXR, HDR, TIFF, PNG or JPEG")
    );
    assert!(read_exr(&folder.path().join("none.exr")).is_err());
}

/// One byte changed anywhere: an error or a picture, never a panic.
#[test]
fn changed_bytes_do_not_panic() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.exr");
    write_exr(&path, &film(), &[]).unwrap();
    let whole = fs::read(&path).unwrap();
    for index in (0..whole.len().min(1500)).chain((1500..whole.len()).step_by(211)) {
        for value in [0, 0x7f, 0xff] {
            let mut bytes = whole.clone();
            bytes[index] = value;
            let _ = decode_texture(&bytes, &path);
        }
    }
}

/// A small EXR in an encoding that fogbow does not write itself.
fn encoded(compression: Compression, blocks: Blocks) -> Vec<u8> {
    let values = |name| {
        let values = (0..37 * 21).map(|i| f16::from_f32((i as f32).sin())).collect();
        AnyChannel::new(name, FlatSamples::F16(values))
    };
    let channels = AnyChannels::sort(["R", "G", "B"].map(values).into_iter().collect());
    let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
    let part = Layer::new((37, 21), LayerAttributes::default(), encoding, channels);
    let mut bytes = Cursor::new(Vec::new());
    exr::image::Image::from_layer(part).write().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

/// Damage of tiles and of B44 blocks makes the exr crate itself panic.
#[test]
fn damage_that_makes_the_decoder_panic_is_an_error() {
    let path = Path::new("odd.exr");
    let tiles = Blocks::Tiles(Vec2(16, 16));
    for (compression, blocks) in [
        (Compression::Uncompressed, tiles),
        (Compression::B44, Blocks::ScanLines),
        (Compression::PIZ, Blocks::ScanLines),
        (Compression::PXR24, tiles),
    ] {
        let whole = encoded(compression, blocks);
        assert!(decode_texture(&whole, path).is_ok(), "{compression:?}");
        let mut rng = Stream::new(1, Stage::Test, whole.len() as u64, 0);
        for _ in 0..1000 {
            let mut bytes = whole.clone();
            for _ in 0..3 {
                let end = if rng.uniform() < 0.5 { 500.0 } else { whole.len() as f64 };
                bytes[(rng.uniform() * end) as usize] = (rng.uniform() * 256.0) as u8;
            }
            if let Err(error) = decode_texture(&bytes, path) {
                assert!(error.to_string().starts_with("odd.exr: "), "{error}");
            }
        }
    }
}

#[test]
fn a_picture_that_claims_too_much_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.exr");
    write_exr_layers(&path, 1, 1, &[("Y", &[1.0])], &[]).unwrap();
    let mut bytes = fs::read(&path).unwrap();
    for name in [&b"dataWindow\0"[..], b"displayWindow\0"] {
        let at = bytes.windows(name.len()).position(|w| w == name).unwrap();
        let max = at + name.len() + b"box2i\0".len() + 4 + 8;
        bytes[max..max + 8].copy_from_slice(&[0xfe, 0xff, 0xff, 0x0f, 0xfe, 0xff, 0xff, 0x0f]);
    }
    let error = decode_texture(&bytes, &path).unwrap_err().to_string();
    assert!(error.contains("out.exr"), "{error}");
}

#[test]
fn grey_exr_and_missing_channels() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.exr");
    write_exr_layers(&path, 2, 1, &[("Y", &[0.25, 4.0])], &[]).unwrap();
    assert_eq!(read_exr(&path).unwrap().get(1, 0), Rgb::splat(4.0));
    write_exr_layers(&path, 2, 1, &[("xs", &[0.25, 4.0])], &[]).unwrap();
    let error = read_exr(&path).unwrap_err().to_string();
    assert!(error.contains("has the channels xs; R, G and B, or Y, are needed"), "{error}");
}

#[test]
fn png_goes_out_as_srgb_and_comes_back_linear() {
    let folder = tempfile::tempdir().unwrap();
    let path = png_path_beside(&folder.path().join("odd.exr"));
    assert!(path.ends_with("odd.png"));
    let pixels = (0..7 * 3).map(|i| [i as f32 / 20.0, 0.5, 0.18]).collect();
    let image = Image::new(7, 3, pixels);
    write_png(&path, &image, &View::default()).unwrap();
    assert!(fs::read(&path).unwrap().windows(4).any(|w| w == b"sRGB"));
    let back = read_texture(&path).unwrap().image;
    assert_eq!((back.width(), back.height()), (7, 3));
    for (a, b) in image.pixels().iter().zip(back.pixels()) {
        for (a, b) in a.iter().zip(b) {
            assert!((a - b).abs() < 5e-3, "{a} came back as {b}");
        }
    }
}

#[test]
fn dropped_samples_are_counted_and_leave_no_trace() {
    let mut pixel = Accumulator::default();
    pixel.add(sample(Rgb::ONE));
    pixel.add(sample(Rgb::new(1.0, f64::NAN, 1.0)));
    pixel.add(sample(Rgb::new(f64::INFINITY, 1.0, 1.0)));
    pixel.add(Sample { alpha: f64::NAN, ..sample(Rgb::ONE) });
    pixel.add(Sample { depth: f64::INFINITY, ..sample(Rgb::splat(3.0)) });
    assert_eq!((pixel.count(), pixel.dropped()), (2, 3));
    assert_eq!(pixel.mean(), Rgb::splat(2.0));
    assert_eq!(pixel.variance(), Rgb::ONE);
    assert_eq!(pixel.depth(), 2.0);
}

#[test]
fn a_million_bright_samples_keep_their_variance() {
    let mut pixel = Accumulator::default();
    let n = 1_000_000_u32;
    for i in 0..n {
        pixel.add(sample(Rgb::splat(1e8 + f64::from(i % 2))));
    }
    let expected = 0.25 / f64::from(n - 1); // population variance 1/4
    assert!((pixel.mean().x - (1e8 + 0.5)).abs() < 1e-6);
    assert!((pixel.variance().y / expected - 1.0).abs() < 1e-6);
    assert!((pixel.luminance_variance() / expected - 1.0).abs() < 1e-6);
}

proptest! {
    #[test]
    fn accumulator_agrees_with_two_passes(
        values in prop::collection::vec([0.0..1e3_f64, 0.0..1e3, 0.0..1e3], 2..60)
    ) {
        let values: Vec<Rgb> = values.into_iter().map(Rgb::from_array).collect();
        let mut pixel = Accumulator::default();
        values.iter().for_each(|&v| pixel.add(sample(v)));
        let n = values.len() as f64;
        let mean = values.iter().sum::<Rgb>() / n;
        let squares: Rgb = values.iter().map(|&v| (v - mean) * (v - mean)).sum();
        let grey: f64 = values.iter().map(|&v| luminance(v - mean).powi(2)).sum();
        let per_mean = 1.0 / (n * (n - 1.0));
        prop_assert!((pixel.mean() - mean).length() < 1e-9);
        prop_assert!((pixel.variance() - squares * per_mean).length() < 1e-6);
        prop_assert!((pixel.luminance_variance() - grey * per_mean).abs() < 1e-6);
    }
}

/// Both transforms over a ramp of 20 stops.
#[test]
fn ramps_grow_to_the_right() {
    for transform in [ViewTransform::Srgb, ViewTransform::Agx] {
        let view = View { exposure: 0.0, transform };
        let ramp: Vec<u8> = (0..256)
            .map(|x| view.develop(Rgb::splat(0.18 * (f64::from(x) / 12.8 - 10.0).exp2()))[1])
            .collect();
        assert!(ramp.is_sorted(), "{transform}");
        assert_eq!(ramp[255], 255, "{transform}");
    }
}
