//! What the director costs before a picture is rendered.
//!
//! `cargo bench --bench director`

use criterion::{Criterion, criterion_group, criterion_main};
use fogbow::director::Saliency;
use fogbow::image::Image;

/// Coloured bars of many brightnesses, 512 x 512: no stage has nothing to do.
fn picture() -> Image {
    let pixel = |i: usize| {
        let (x, y) = (i % 512, i / 512);
        let bar = (x / 32 * 16 + y / 32) as f32;
        let inside = x % 32 < 10 && y % 32 < 24;
        let color = [0.3 + 0.2 * bar.sin(), 0.3 + 0.2 * bar.cos(), 0.001 * bar];
        if inside { color } else { [0.05; 3] }
    };
    Image::new(512, 512, (0..512 * 512).map(pixel).collect())
}

fn saliency(criterion: &mut Criterion) {
    let image = picture();
    criterion.bench_function("saliency 512x512", |b| b.iter(|| Saliency::of(&image)));
}

criterion_group!(benches, saliency);
criterion_main!(benches);
