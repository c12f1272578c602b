//! Saliency: pop-out wherever the odd one stands, nothing where there is nothing, any size.

use fogbow::director::Saliency;
use fogbow::image::{Image, read_exr};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use rayon::ThreadPoolBuilder;

const RED: [f32; 3] = [0.8, 0.05, 0.05];
const GREEN: [f32; 3] = [0.05, 0.8, 0.05];
const BLUE: [f32; 3] = [0.3, 0.3, 0.75];

/// A bar: its middle in pixels, its angle against the horizontal, its colour.
#[derive(Clone, Copy, Debug)]
struct Bar {
    middle: [f64; 2],
    angle: f64,
    color: [f32; 3],
}

/// Bars on a grid, one of them odd.
#[derive(Clone, Copy, Debug)]
struct Search {
    size: [usize; 2],
    rows: usize,
    /// Length of a bar over the side of a cell, and its width over its length.
    shape: [f64; 2],
    /// Where in the grid the odd one is, 0 to 1 from the upper left.
    odd: [f64; 2],
    background: f32,
    /// Every value is off by up to this part of it.
    noise: f32,
    seed: u64,
}

impl Search {
    fn cell(&self) -> f64 {
        self.size[0].min(self.size[1]) as f64 / self.rows as f64
    }

    /// All bars, those of the grid `usual`, the first `odd` and in its place. Every bar is shifted a
    /// little by `seed`.
    fn bars(&self, usual: Bar, odd: Bar) -> Vec<Bar> {
        let cell = self.cell();
        let grid = self.size.map(|s| (s as f64 / cell) as usize);
        let place = [0, 1].map(|i| ((self.odd[i] * grid[i] as f64) as usize).min(grid[i] - 1));
        let room = cell * (1.0 - self.shape[0]) / 4.0;
        let mut bars: Vec<Bar> = Vec::new();
        for y in 0..grid[1] {
            for x in 0..grid[0] {
                let number = (y * grid[0] + x) as u64 + self.seed;
                let shift = |i: u64| room * (unit(2 * number + i) * 2.0 - 1.0);
                let middle =
                    [(x as f64 + 0.5) * cell + shift(0), (y as f64 + 0.5) * cell + shift(1)];
                if [x, y] == place {
                    bars.insert(0, Bar { middle, ..odd });
                } else {
                    bars.push(Bar { middle, ..usual });
                }
            }
        }
        bars
    }

    /// Whether the most salient pixel is on the first bar, or one pixel beside it.
    fn pops_out(&self, bars: &[Bar]) -> Result<(), TestCaseError> {
        self.pops_out_in(bars, Image::clone)
    }

    /// The same where the picture of the bars is changed by `changed`.
    fn pops_out_in(
        &self,
        bars: &[Bar],
        changed: impl Fn(&Image) -> Image,
    ) -> Result<(), TestCaseError> {
        let [width, height] = self.size;
        let length = self.shape[0] * self.cell();
        let extent = [length, length * self.shape[1]];
        let image = noisy(&draw(self.size, self.background, bars, extent), self.noise);
        let saliency = Saliency::from_image(&changed(&image));
        let most = (0..width * height)
            .max_by(|&a, &b| saliency.map[a].total_cmp(&saliency.map[b]))
            .unwrap();
        let at = [(most % width) as f64 + 0.5, (most / width) as f64 + 0.5];
        let [along, across] = on_bar(&bars[0], at);
        prop_assert_eq!(saliency.map[most], 1.0);
        prop_assert!(
            along <= extent[0] / 2.0 + 1.0 && across <= extent[1] / 2.0 + 1.0,
            "{:?} is most salient, the odd one is {:?}, {:?} long and wide",
            at,
            bars[0],
            extent
        );
        Ok(())
    }
}

/// A number of 0 to 1 for every index (splitmix64).
fn unit(index: u64) -> f64 {
    let mut z = index.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}

/// Distances of a place from the middle of `bar`, along it and across.
fn on_bar(bar: &Bar, at: [f64; 2]) -> [f64; 2] {
    let (sin, cos) = bar.angle.sin_cos();
    let [dx, dy] = [at[0] - bar.middle[0], at[1] - bar.middle[1]];
    [(dx * cos - dy * sin).abs(), (dx * sin + dy * cos).abs()]
}

/// Bars with edges smoothed over a pixel.
fn draw(size: [usize; 2], background: f32, bars: &[Bar], [length, width]: [f64; 2]) -> Image {
    let mut pixels = vec![[background; 3]; size[0] * size[1]];
    let reach = (length + width) / 2.0 + 2.0;
    for bar in bars {
        let [xs, ys] = [0, 1].map(|i| {
            let bound = |v: f64| v.clamp(0.0, size[i] as f64) as usize;
            bound(bar.middle[i] - reach)..bound(bar.middle[i] + reach)
        });
        for y in ys {
            for x in xs.clone() {
                let [along, across] = on_bar(bar, [x as f64 + 0.5, y as f64 + 0.5]);
                let inside = |d: f64, extent: f64| (extent / 2.0 - d + 0.5).clamp(0.0, 1.0);
                let cover = (inside(along, length) * inside(across, width)) as f32;
                for (v, c) in pixels[y * size[0] + x].iter_mut().zip(bar.color) {
                    *v += cover * (c - *v);
                }
            }
        }
    }
    Image::new(size[0], size[1], pixels)
}

fn noisy(image: &Image, noise: f32) -> Image {
    let factor = |i: usize| 1.0 + noise * (2.0 * unit(i as u64) as f32 - 1.0);
    let off = |(i, p): (usize, &[f32; 3])| [0, 1, 2].map(|c| p[c] * factor(3 * i + c));
    let pixels = image.pixels().iter().enumerate().map(off).collect();
    Image::new(image.width(), image.height(), pixels)
}

fn searches() -> impl Strategy<Value = Search> {
    let size = prop::sample::select(vec![
        [128, 128],
        [200, 150],
        [181, 181],
        [256, 256],
        [333, 257],
        [400, 400],
    ]);
    let light =
        prop::sample::select(vec![(0.0_f32, 0.0_f32), (0.05, 0.0), (0.3, 0.0), (0.05, 0.05)]);
    let place = prop::array::uniform2(0.0..1.0);
    (size, 4_usize..8, 0.45..0.7, 0.25..0.33, place, light, 0_u64..1 << 32).prop_map(
        |(size, rows, length, width, odd, (background, noise), seed)| Search {
            size,
            rows,
            shape: [length, width],
            odd,
            background,
            noise,
            seed,
        },
    )
}

fn bar(degrees: f64, color: [f32; 3]) -> Bar {
    Bar { middle: [0.0; 2], angle: degrees.to_radians(), color }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, rng_seed: RngSeed::Fixed(3), ..ProptestConfig::default() })]

    #[test]
    fn one_colour_among_another_pops_out(search in searches(), swap: bool, degrees in 0.0..180.0) {
        let (usual, odd) = if swap { (RED, GREEN) } else { (GREEN, RED) };
        search.pops_out(&search.bars(bar(degrees, usual), bar(degrees, odd)))?;
    }

    /// One corner has a tint of another hue, which is nowhere else.
    #[test]
    fn a_tint_does_not_weigh_as_much_as_a_saturated_hue(search in searches(), tint in 0.0..0.3_f32) {
        let bars = search.bars(bar(90.0, GREEN), bar(90.0, RED));
        let tinted = |image: &Image| {
            let blue = |(i, p): (usize, &[f32; 3])| {
                let near = i % image.width() < image.width() / 4 && i / image.width() < image.height() / 4;
                [p[0], p[1], p[2] * if near { 1.0 + tint } else { 1.0 }]
            };
            let pixels = image.pixels().iter().enumerate().map(blue).collect();
            Image::new(image.width(), image.height(), pixels)
        };
        search.pops_out_in(&bars, tinted)?;
    }

    #[test]
    fn one_tilted_among_upright_pops_out(search in searches(), tilt in 45.0..=135.0) {
        let color = [0.8; 3];
        search.pops_out(&search.bars(bar(90.0, color), bar(90.0 + tilt, color)))?;
    }

    #[test]
    fn one_bright_among_dim_pops_out(search in searches(), degrees in 0.0..180.0, dim in 0.1..0.4_f32) {
        let color = [search.background + dim * (1.0 - search.background); 3];
        search.pops_out(&search.bars(bar(degrees, color), bar(degrees, [1.0; 3])))?;
    }

    #[test]
    fn any_picture_gives_values_from_0_to_1(
        width in 1_usize..70,
        height in 1_usize..70,
        wild in prop::collection::vec(prop::num::f32::ANY, 64),
    ) {
        let value = |i: usize| wild[(unit(i as u64) * 64.0) as usize];
        let pixels = (0..width * height).map(|i| [value(3 * i), value(3 * i + 1), value(3 * i + 2)]);
        let s = Saliency::from_image(&Image::new(width, height, pixels.collect()));
        for map in [&s.intensity, &s.color, &s.orientation, &s.map] {
            prop_assert_eq!(map.len(), width * height);
            prop_assert!(map.iter().all(|v| (0.0..=1.0 + 1e-6).contains(v)));
        }
    }
}

/// Red among green in the usual place, for what does not depend on the picture.
fn example(scale: f32) -> Image {
    let search = Search {
        size: [201, 150],
        rows: 5,
        shape: [0.6, 0.3],
        odd: [0.7, 0.3],
        background: 0.05,
        noise: 0.0,
        seed: 1,
    };
    let image =
        draw(search.size, 0.05, &search.bars(bar(90.0, GREEN), bar(90.0, RED)), [18.0, 5.0]);
    let pixels = image.pixels().iter().map(|p| p.map(|v| v * scale)).collect();
    Image::new(201, 150, pixels)
}

/// The contrast of the blue is a part of that of red and green, which are strewn at random: N on the
/// range of both opponencies loses it more often than the bound allows.
#[test]
fn a_pale_blue_one_among_red_and_green_mostly_pops_out() {
    const SEARCHES: u64 = 60;
    let found = (0..SEARCHES).filter(|&seed| {
        let number = |i: u64| unit(1000 * seed + i);
        let side = [128, 200, 256, 400][(number(0) * 4.0) as usize];
        let search = Search {
            size: [side, side],
            rows: 4 + (number(1) * 4.0) as usize,
            shape: [0.45 + 0.25 * number(2), 0.25 + 0.08 * number(3)],
            odd: [number(4), number(5)],
            background: [0.0, 0.05, 0.3][(number(6) * 3.0) as usize],
            noise: 0.0,
            seed,
        };
        let degrees = 180.0 * number(7);
        let mut bars = search.bars(bar(degrees, RED), bar(degrees, BLUE));
        for (i, bar) in bars.iter_mut().enumerate().skip(1) {
            bar.color = if number(10 + i as u64) < 0.5 { RED } else { GREEN };
        }
        search.pops_out(&bars).is_ok()
    });
    let found = found.count();
    assert!(found >= 54, "{found} of {SEARCHES} are found");
}

#[test]
fn a_flat_picture_has_none() {
    for (width, height) in [(1, 1), (2, 2), (1, 1000), (7, 1000), (65, 33), (256, 256)] {
        for color in [[0.0; 3], [1.0; 3], [0.3, 0.1, 0.7], [1e-30; 3], [f32::NAN; 3]] {
            let rounding = |i: usize| 1.0 + (unit(i as u64) as f32 - 0.5) * 4.0 * f32::EPSILON;
            let pixels = (0..width * height).map(|i| color.map(|v| v * rounding(i))).collect();
            let s = Saliency::from_image(&Image::new(width, height, pixels));
            for map in [&s.intensity, &s.color, &s.orientation, &s.map] {
                assert!(map.iter().all(|&v| v == 0.0), "{width} x {height} of {color:?}");
            }
        }
    }
}

#[test]
fn exposure_makes_no_difference() {
    let one = Saliency::from_image(&example(1.0));
    for scale in [1e-6, 0.37, 3.0, 1e6] {
        let other = Saliency::from_image(&example(scale));
        let off = one.map.iter().zip(&other.map).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(off < 1e-3, "{off} off at {scale}");
    }
}

#[test]
fn threads_make_no_difference() {
    let image = example(1.0);
    let [one, two, many] = [1, 2, 5].map(|threads| {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| Saliency::from_image(&image))
    });
    assert_eq!(one, two);
    assert_eq!(one, many);
}

#[test]
fn a_lamp_among_lit_walls_is_seen() {
    let mut pixels = vec![[0.2_f32; 3]; 300 * 200];
    for (i, p) in pixels.iter_mut().enumerate() {
        let (x, y) = (i % 300, i / 300);
        if x % 40 < 12 && y % 40 < 12 {
            *p = if (x / 40, y / 40) == (5, 3) { [1e4; 3] } else { [2.0; 3] };
        }
    }
    let s = Saliency::from_image(&Image::new(300, 200, pixels));
    let most = s.map.iter().position(|&v| v == 1.0).unwrap();
    let (x, y) = (most % 300, most / 300);
    assert!((200..212).contains(&x) && (120..132).contains(&y), "{x}, {y}");
}

#[test]
fn maps_are_smooth() {
    let s = Saliency::from_image(&example(1.0));
    let steps = s.map.chunks_exact(s.width).flat_map(|row| row.windows(2));
    let steepest = steps.map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f32::max);
    assert!(steepest < 0.35, "a step of {steepest} between neighbours");
}

/// For every NAME.exr in the folder `FOGBOW_PICTURES` writes NAME.maps: N(I), N(C), N(O) and S, row by
/// row as f32, lowest byte first.
#[test]
#[ignore = "tests/check/saliency.py runs it on a folder of pictures"]
fn maps_of_pictures() {
    let folder = std::env::var_os("FOGBOW_PICTURES").expect("FOGBOW_PICTURES names a folder");
    let mut pictures = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "exr") {
            let s = Saliency::from_image(&read_exr(&path).unwrap());
            let maps = [s.intensity, s.color, s.orientation, s.map].concat();
            let bytes: Vec<u8> = maps.into_iter().flat_map(f32::to_le_bytes).collect();
            std::fs::write(path.with_extension("maps"), bytes).unwrap();
            pictures += 1;
        }
    }
    assert!(pictures > 0, "the folder has no EXR");
}
