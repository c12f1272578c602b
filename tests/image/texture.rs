//! Textures and skies from files: what every format holds, and what is said of damage.

use std::fs;
use std::io::Cursor;
use std::path::Path;

use fogbow::image::{
    DecodedTexture, Encoding, Image, PICTURE_DECODER, View, decode_texture, srgb_decode,
    write_exr_layers, write_png,
};
use fogbow::math::{Rgb, Stage, Stream};
use fogbow::scene::{LoadOptions, Scene};
use half::f16;
use image::codecs::hdr::HdrEncoder;
use tiff::encoder::{Compression, DeflateLevel, Predictor, TiffEncoder, colortype};

const HEAD: &[u8] = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n";

fn decode(bytes: &[u8]) -> fogbow::Result<DecodedTexture> {
    decode_texture(bytes, Path::new("sky.xyz"))
}

fn assert_pixel(image: &Image, x: usize, expected: [f64; 3]) {
    let off = (image.get(x, 0) - Rgb::from_array(expected)).abs().max_element();
    assert!(off < 1e-4, "pixel {x} is {}, not {expected:?}", image.get(x, 0));
}

/// A Radiance picture of 8 x 1 pixels.
fn hdr(head: &[u8], scanline: &[u8]) -> Vec<u8> {
    [head, b"-Y 1 +X 8\n", scanline].concat()
}

/// RGBE of 1, 0.5, 0.25, and of 512 times as much.
const DIM: [u8; 4] = [128, 64, 32, 129];
const BRIGHT: [u8; 4] = [128, 64, 32, 138];

#[test]
fn hdr_is_read_flat_and_with_both_run_lengths() {
    let flat = [DIM, BRIGHT].concat().repeat(4);
    let old = [&DIM[..], &BRIGHT, &DIM, &BRIGHT, &DIM, &BRIGHT, &BRIGHT, &[1, 1, 1, 1]].concat();
    // Runs of eight are 128 + 8; pieces of eight are 8.
    let parts = |exponents: &[u8]| {
        let runs = [[136, 128], [136, 64], [136, 32]].concat();
        [&[2, 2, 0, 8][..], &runs, &[8], exponents].concat()
    };
    let new = parts(&[129, 138, 129, 138, 129, 138, 129, 138]);
    for (name, bytes) in [
        ("flat", hdr(HEAD, &flat)),
        ("old runs", hdr(HEAD, &old)),
        ("new runs", hdr(HEAD, &new)),
        ("RGBE", hdr(b"#?RGBE\nGAMMA=1\n# a comment\nEXPOSURE=2\n\n", &flat)),
    ] {
        let texture = decode(&bytes).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(texture.encoding, Encoding::Linear, "{name}");
        assert_pixel(&texture.image, 0, [1.0, 0.5, 0.25]);
        assert_pixel(&texture.image, 1, [512.0, 256.0, 128.0]);
        assert_pixel(&texture.image, 7, [512.0, 256.0, 128.0]);
    }
}

#[test]
fn hdr_that_cannot_be_read_is_an_error() {
    // Run lengths of 0 whose places in the length overflow.
    let runs = [&DIM[..], &[1, 1, 1, 0].repeat(9)].concat();
    let flat = [DIM; 8].concat();
    for (name, bytes) in [
        ("overflow", hdr(HEAD, &runs)),
        ("end", hdr(HEAD, &flat[..20])),
        ("XYZE", hdr(b"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n", &flat)),
        ("upside down", [HEAD, b"+Y 1 +X 8\n", &flat].concat()),
        ("too large", [HEAD, b"-Y 99999 +X 99999\n", &flat].concat()),
        ("too large for its bytes", [HEAD, b"-Y 9999 +X 9999\n", &flat].concat()),
        ("empty", [HEAD, b"-Y 0 +X 8\n"].concat()),
    ] {
        let error = decode(&bytes).expect_err(name).to_string();
        assert!(error.starts_with("sky.xyz: "), "{name}: {error}");
    }
}

/// How a TIFF holds its samples: channels, bits, the format's number, whether by planes.
#[derive(Debug, Clone, Copy)]
struct Layout {
    channels: u16,
    bits: u16,
    format: u16,
    is_planar: bool,
}

const UINT: u16 = 1;
const FLOAT: u16 = 3;

/// A TIFF of one row, not compressed, of samples that are already in its order.
fn tiff(width: u32, layout: Layout, samples: &[u8]) -> Vec<u8> {
    let Layout { channels, bits, format, is_planar } = layout;
    let short = |v: u16| (3u16, v.to_le_bytes().to_vec());
    let shorts = |v: u16| (3u16, v.to_le_bytes().repeat(channels.into()));
    let long = |v: u32| (4u16, v.to_le_bytes().to_vec());
    let planes = if is_planar { u32::from(channels) } else { 1 };
    let strip = samples.len() as u32 / planes;
    let longs =
        |of: &dyn Fn(u32) -> u32| (4u16, (0..planes).flat_map(|i| of(i).to_le_bytes()).collect());
    const DATA: u32 = 1024;
    let tags: Vec<(u16, (u16, Vec<u8>))> = vec![
        (256, long(width)),
        (257, long(1)),
        (258, shorts(bits)),
        (259, short(1)),
        (262, short(if channels < 3 { 1 } else { 2 })),
        (273, longs(&|i| DATA + i * strip)),
        (277, short(channels)),
        (278, long(1)),
        (279, longs(&|_| strip)),
        (284, short(if is_planar { 2 } else { 1 })),
        (338, short(2)), // alpha; taken out again where there is none
        (339, shorts(format)),
    ];
    let has_alpha = channels % 2 == 0;
    let tags: Vec<_> = tags.into_iter().filter(|(tag, _)| *tag != 338 || has_alpha).collect();
    let mut head = [b"II*\0\x08\0\0\0".as_slice(), &(tags.len() as u16).to_le_bytes()].concat();
    let mut values: Vec<u8> = Vec::new();
    for (tag, (kind, bytes)) in &tags {
        let size = if *kind == 3 { 2 } else { 4 };
        head.extend(tag.to_le_bytes());
        head.extend(kind.to_le_bytes());
        head.extend((bytes.len() as u32 / size).to_le_bytes());
        if bytes.len() <= 4 {
            head.extend([bytes.as_slice(), &[0; 4]].concat()[..4].iter());
        } else {
            head.extend((512 + values.len() as u32).to_le_bytes());
            values.extend(bytes);
        }
    }
    head.extend([0; 4]);
    head.resize(512, 0);
    head.extend(values);
    head.resize(DATA as usize, 0);
    head.extend(samples);
    head
}

#[test]
fn float_tiff_is_linear_in_every_width() {
    let colors = [[1.5f32, 0.25, 8.0, 0.5], [0.0, 1000.0, 0.125, 1.0]];
    for (channels, is_planar) in [(3, false), (4, false), (3, true), (1, false), (2, false)] {
        let mut values: Vec<f32> = colors.iter().flat_map(|c| c[..channels].to_vec()).collect();
        if is_planar {
            values = (0..channels).flat_map(|c| colors.map(|color| color[c])).collect();
        }
        let half: Vec<u8> = values.iter().flat_map(|v| f16::from_f32(*v).to_le_bytes()).collect();
        let single: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        let double: Vec<u8> = values.iter().flat_map(|v| f64::from(*v).to_le_bytes()).collect();
        for (bits, samples) in [(16, half), (32, single), (64, double)] {
            let layout = Layout { channels: channels as u16, bits, format: FLOAT, is_planar };
            let texture =
                decode(&tiff(2, layout, &samples)).unwrap_or_else(|e| panic!("{layout:?}: {e}"));
            assert_eq!(texture.encoding, Encoding::Linear, "{layout:?}");
            for (x, color) in colors.iter().enumerate() {
                let [r, g, b] =
                    [0, 1, 2].map(|c| f64::from(color[if channels < 3 { 0 } else { c }]));
                assert_pixel(&texture.image, x, [r, g, b]);
            }
        }
    }
}

#[test]
fn integer_tiff_is_srgb() {
    let layout = |bits| Layout { channels: 3, bits, format: UINT, is_planar: false };
    let eight = decode(&tiff(2, layout(8), &[255, 128, 0, 1, 2, 3])).unwrap();
    assert_eq!(eight.encoding, Encoding::Srgb { bits: 8 });
    assert_pixel(&eight.image, 0, [1.0, srgb_decode(128.0 / 255.0), 0.0]);
    let codes: Vec<u8> = [65535u16, 40000, 0].iter().flat_map(|v| v.to_le_bytes()).collect();
    let sixteen = decode(&tiff(1, layout(16), &codes)).unwrap();
    assert_eq!(sixteen.encoding, Encoding::Srgb { bits: 16 });
    assert_pixel(&sixteen.image, 0, [1.0, srgb_decode(40000.0 / 65535.0), 0.0]);
}

#[test]
fn tiff_that_cannot_be_read_is_an_error() {
    let layout = |bits, format| Layout { channels: 3, bits, format, is_planar: false };
    let not_finite = tiff(1, layout(32, FLOAT), &f32::NAN.to_le_bytes().repeat(3));
    let long = tiff(1, layout(32, UINT), &[0; 12]);
    let too_large = tiff(u32::MAX, layout(8, UINT), &[0; 12]);
    let too_large_for_its_bytes = tiff(1 << 26, layout(8, UINT), &[0; 12]);
    for (bytes, words) in [
        (not_finite, "must be finite"),
        (long, "32 bits; grey or RGB"),
        (too_large, "claims"),
        (too_large_for_its_bytes, "damaged or incomplete"),
        (b"II*\0\x08\0\0\0".to_vec(), "kind of TIFF"),
    ] {
        let error = decode(&bytes).unwrap_err().to_string();
        assert!(error.starts_with("sky.xyz: ") && error.contains(words), "{error}");
    }
}

/// Small pictures in the encodings that other programs write.
fn sound() -> Vec<Vec<u8>> {
    let size = [24, 17];
    let colors = |i: usize| [i as f32, (i % 7) as f32, 0.5];
    let floats: Vec<f32> = (0..size[0] * size[1]).flat_map(colors).collect();
    let codes: Vec<u8> = floats.iter().map(|v| *v as u8).collect();
    let mut pictures = Vec::new();
    let mut bytes = Vec::new();
    let pixels: Vec<_> = floats.chunks_exact(3).map(|c| image::Rgb([c[0], c[1], c[2]])).collect();
    HdrEncoder::new(&mut bytes).encode(&pixels, size[0], size[1]).unwrap();
    pictures.push(bytes);
    pictures.push([HEAD, b"-Y 17 +X 24\n", &[DIM; 24 * 17].concat()].concat());
    pictures.push([HEAD, b"-Y 17 +X 24\n", &[DIM, [1, 1, 1, 23]].concat().repeat(17)].concat());
    let deflate = Compression::Deflate(DeflateLevel::Balanced);
    for compression in [Compression::Uncompressed, Compression::Lzw, deflate, Compression::Packbits]
    {
        for predictor in [Predictor::None, Predictor::Horizontal] {
            let mut bytes = Cursor::new(Vec::new());
            let encoder = TiffEncoder::new(&mut bytes).unwrap().with_compression(compression);
            let mut encoder = encoder.with_predictor(predictor);
            let [width, height] = size.map(|s| s as u32);
            if predictor == Predictor::None {
                encoder.write_image::<colortype::RGB32Float>(width, height, &floats).unwrap();
            } else {
                encoder.write_image::<colortype::RGB8>(width, height, &codes).unwrap();
            }
            pictures.push(bytes.into_inner());
        }
    }
    pictures
}

/// 5500 damaged pictures: each is a picture or one line that names the file, never a panic beyond the
/// decoder's thread.
#[test]
fn damaged_pictures_are_read_or_refused() {
    let print = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        if std::thread::current().name() != Some(PICTURE_DECODER) {
            print(info);
        }
    }));
    let mut refused = 0;
    for (index, whole) in sound().into_iter().enumerate() {
        let texture = decode(&whole).unwrap_or_else(|e| panic!("picture {index}: {e}"));
        assert_eq!((texture.image.width(), texture.image.height()), (24, 17), "picture {index}");
        let mut random = Stream::new(1, Stage::Test, index as u64, 0);
        let mut below = |end: usize| (random.uniform() * end as f64) as usize;
        for _ in 0..500 {
            let mut bytes = whole.clone();
            for _ in 0..=below(6) {
                // Half of the damage in headers, which TIFF has at the end.
                let last = bytes.len().min(200);
                let at = match below(4) {
                    0 => below(last),
                    1 => bytes.len() - 1 - below(last),
                    _ => below(bytes.len()),
                };
                match below(4) {
                    0 => bytes[at] = below(256) as u8,
                    1 => bytes[at] ^= 1 << below(8),
                    2 => bytes[at] = [0, 1, 127, 255][below(4)],
                    _ if at > 0 => bytes.truncate(at.max(bytes.len() / 2)),
                    _ => bytes.swap(0, 1),
                }
            }
            if let Err(error) = decode(&bytes) {
                let message = error.to_string();
                assert!(message.starts_with("sky.xyz: "), "{message}");
                assert!(!message.chars().any(char::is_control), "{message:?}");
                refused += 1;
            }
        }
    }
    assert!(refused > 1000, "{refused} refused");
}

#[test]
fn a_sky_of_codes_comes_with_a_note() {
    let folder = tempfile::tempdir().unwrap();
    let image = Image::new(2, 1, vec![[0.25; 3]; 2]);
    write_png(&folder.path().join("sky.png"), &image, &View::default()).unwrap();
    let values: &[f32] = &[0.25; 2];
    write_exr_layers(&folder.path().join("grey.exr"), 2, 1, &[("Y", values)], &[]).unwrap();
    let channels = ["R", "G", "B", "A"].map(|name| (name, values));
    write_exr_layers(&folder.path().join("rgba.exr"), 2, 1, &channels, &[]).unwrap();
    fs::write(folder.path().join("sky.hdr"), hdr(HEAD, &[DIM; 8].concat())).unwrap();
    let float = Layout { channels: 3, bits: 32, format: FLOAT, is_planar: false };
    let grey = 0.25f32.to_le_bytes().repeat(3);
    fs::write(folder.path().join("sky.tif"), tiff(1, float, &grey)).unwrap();
    let load = |sky: &str| {
        let path = folder.path().join("scene.toml");
        let camera = "[camera]\nposition = [0, 0, 4]\ntarget = [0, 0, 0]\n";
        fs::write(&path, format!("{camera}[[light]]\ntype = \"environment\"\n{sky}\n")).unwrap();
        Scene::load(&path, &LoadOptions::default()).unwrap()
    };
    let up = |scene: &Scene| scene.lights.environment_radiance(glam::DVec3::Y);
    let scene = load("texture = \"sky.png\"");
    assert_eq!(scene.notes.len(), 1, "{:?}", scene.notes);
    assert!(scene.notes[0].contains("sky.png: 8-bit picture as a sky, taken as sRGB"));
    assert!((up(&scene) - 0.25).abs().max_element() < 3e-3);
    for (sky, expected) in [
        ("texture = \"grey.exr\"", [0.25; 3]),
        ("texture = \"rgba.exr\"", [0.25; 3]),
        ("texture = \"sky.hdr\"", [1.0, 0.5, 0.25]),
        ("texture = \"sky.tif\"\nscale = 2", [0.5; 3]),
        ("gradient = [[-90, 0.02], [0, [0.3, 0.32, 0.35]], [90, 0.05]]\nscale = 2", [0.1; 3]),
    ] {
        let scene = load(sky);
        assert!(scene.notes.is_empty(), "{sky}: {:?}", scene.notes);
        assert!((up(&scene) - Rgb::from_array(expected)).abs().max_element() < 1e-6, "{sky}");
    }
}
