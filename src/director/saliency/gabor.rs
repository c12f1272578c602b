//! Local orientation: the energy of Gabor filters at four angles.
//!
//! A Gabor filter with a round envelope is the product of one complex filter along the rows and one
//! along the columns, so that all four share five passes over the rows.

use std::array;
use std::f32::consts::{FRAC_1_SQRT_2, PI};

use super::plane::Plane;

/// Wavelength of the filters, in pixels.
///
/// Unit: pixels. Source: Greenspan et al. 1994, whose oriented pyramid Itti et al. use.
const WAVELENGTH: f32 = 4.0;

/// The envelope's standard deviation, in pixels.
///
/// Unit: pixels. Derivation: a line turned by 23 degrees from the preferred angle, about halfway to the
/// next one, gives exp(-1/2) of the response.
const DEVIATION: f32 = 1.5;

/// Taps on either side of the middle.
///
/// Unit: pixels. Derivation: three times [`DEVIATION`], rounded up.
const RADIUS: usize = 5;

type Kernel = [f32; 2 * RADIUS + 1];

/// A Gaussian, and the Gaussian times cosine and sine of the wave along an axis and of a diagonal
/// wave's part along an axis.
struct Kernels {
    envelope: Kernel,
    axis: [Kernel; 2],
    diagonal: [Kernel; 2],
}

impl Kernels {
    fn new() -> Self {
        let place = |i: usize| i as f32 - RADIUS as f32;
        let envelope: Kernel = array::from_fn(|i| (-0.5 * (place(i) / DEVIATION).powi(2)).exp());
        let sum: f32 = envelope.iter().sum();
        let envelope = envelope.map(|w| w / sum);
        let wave = |k: f32| {
            [
                array::from_fn(|i| envelope[i] * (k * place(i)).cos()),
                array::from_fn(|i| envelope[i] * (k * place(i)).sin()),
            ]
        };
        let k = 2.0 * PI / WAVELENGTH;
        Self { envelope, axis: wave(k), diagonal: wave(k * FRAC_1_SQRT_2) }
    }
}

/// The Gabor energies of `plane` for lines that run at 0, 45, 90 and 135 degrees, counted from the
/// horizontal against the clock.
///
/// Energy is the modulus of the even and the odd response, so that a line and both its edges count
/// alike (complex filters, as those of Greenspan et al.). The even filter's
/// mean is taken out: uniform brightness has no orientation. The plane is mirrored at its border.
pub fn energies(plane: &Plane) -> [Plane; 4] {
    let k = Kernels::new();
    let smooth = along_rows(plane, &k.envelope);
    let [axis_cos, axis_sin] = k.axis.each_ref().map(|kernel| along_rows(plane, kernel));
    let [diagonal_cos, diagonal_sin] =
        k.diagonal.each_ref().map(|kernel| along_rows(plane, kernel));
    let mean = along_columns(&smooth, &k.envelope);
    let axis_mean: f32 = k.axis[0].iter().sum();
    let diagonal_mean = k.diagonal[0].iter().sum::<f32>().powi(2);

    let horizontal = {
        let [even, odd] = k.axis.each_ref().map(|kernel| along_columns(&smooth, kernel));
        modulus(&mean, axis_mean, |i| (even.values[i], odd.values[i]))
    };
    let vertical = {
        let even = along_columns(&axis_cos, &k.envelope);
        let odd = along_columns(&axis_sin, &k.envelope);
        modulus(&mean, axis_mean, |i| (even.values[i], odd.values[i]))
    };
    let [cos_cos, cos_sin] =
        k.diagonal.each_ref().map(|kernel| along_columns(&diagonal_cos, kernel));
    let [sin_cos, sin_sin] =
        k.diagonal.each_ref().map(|kernel| along_columns(&diagonal_sin, kernel));
    // exp(i(x + y)) and exp(i(x - y)); rows count downward, so the first wave's crests run upward.
    let [rising, falling] = [1.0, -1.0].map(|sign| {
        modulus(&mean, diagonal_mean, |i| {
            let even = cos_cos.values[i] - sign * sin_sin.values[i];
            let odd = sin_cos.values[i] + sign * cos_sin.values[i];
            (even, odd)
        })
    });
    [horizontal, rising, vertical, falling]
}

/// |even - kernel_mean * mean + i odd| at each pixel.
fn modulus(mean: &Plane, kernel_mean: f32, response: impl Fn(usize) -> (f32, f32)) -> Plane {
    let energy = |(i, m): (usize, &f32)| {
        let (even, odd) = response(i);
        (even - kernel_mean * m).hypot(odd)
    };
    let values = mean.values.iter().enumerate().map(energy).collect();
    Plane::new(mean.width, mean.height, values)
}

fn along_rows(plane: &Plane, kernel: &Kernel) -> Plane {
    let mut padded = vec![0.0; plane.width + 2 * RADIUS];
    let mut values = Vec::with_capacity(plane.values.len());
    for row in plane.values.chunks_exact(plane.width) {
        for (i, v) in padded.iter_mut().enumerate() {
            *v = row[mirrored(i, plane.width)];
        }
        let windows = padded.windows(kernel.len());
        values.extend(windows.map(|w| w.iter().zip(kernel).map(|(v, k)| v * k).sum::<f32>()));
    }
    Plane::new(plane.width, plane.height, values)
}

fn along_columns(plane: &Plane, kernel: &Kernel) -> Plane {
    let mut result = Plane::zero(plane.width, plane.height);
    for (y, target) in result.values.chunks_exact_mut(plane.width).enumerate() {
        for (tap, k) in kernel.iter().enumerate() {
            let start = mirrored(y + tap, plane.height) * plane.width;
            for (t, v) in target.iter_mut().zip(&plane.values[start..start + plane.width]) {
                *t += v * k;
            }
        }
    }
    result
}

/// The place in 0..size of place `padded - RADIUS`, mirrored at the edges as often as it takes.
fn mirrored(padded: usize, size: usize) -> usize {
    let period = 2 * size as isize;
    let at = (padded as isize - RADIUS as isize).rem_euclid(period);
    at.min(period - 1 - at) as usize
}
