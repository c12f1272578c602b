//! AgX, the display transform of Troy Sobotka, in the form that Blender 4 and Filament use.
//!
//! Linear Rec.2020, an inset matrix, log2 of the range below, a sigmoid, the outset matrix. The
//! matrices and the range are those of Filament's `ToneMapper.cpp` (2023), the sigmoid is the
//! sixth-order fit of Benjamin Wrensch, "Minimal AgX Implementation" (2023), mean square error
//! 3.7e-6.

use glam::DMat3;
use serde::Serialize;

use super::srgb;
use crate::math::Rgb;

/// Exposure range, log2 of linear Rec.2020 values: 10 stops below middle grey to 6.5 above.
const MIN_EV: f64 = -12.473_93;
const MAX_EV: f64 = 4.026_069;

/// ITU-R BT.2087-0, section 2, written by columns.
const REC709_TO_REC2020: DMat3 = DMat3::from_cols(
    Rgb::new(0.6274, 0.0691, 0.0164),
    Rgb::new(0.3293, 0.9195, 0.0880),
    Rgb::new(0.0433, 0.0114, 0.8956),
);

const INSET: DMat3 = DMat3::from_cols(
    Rgb::new(0.856_627_153_315_983, 0.137_318_972_929_847, 0.111_898_212_999_95),
    Rgb::new(0.095_121_240_538_158_8, 0.761_241_990_602_591, 0.076_799_418_603_190_3),
    Rgb::new(0.048_251_606_145_858_3, 0.101_439_036_467_562, 0.811_302_368_396_859),
);

const OUTSET: DMat3 = DMat3::from_cols(
    Rgb::new(1.127_100_581_814_436_8, -0.141_329_763_498_438_3, -0.141_329_763_498_438_26),
    Rgb::new(-0.110_606_643_096_603_23, 1.157_823_702_216_272, -0.110_606_643_096_602_94),
    Rgb::new(-0.016_493_938_717_834_573, -0.016_493_938_717_834_257, 1.251_936_406_595_040_5),
);

/// Coefficients of the sigmoid, that of the sixth power first.
const SIGMOID: [f64; 7] = [15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.002_32];

/// From scene-linear Rec.709 to display-linear Rec.709, 0 to 1 before small excursions out of
/// gamut, which the encoding clips.
pub(super) fn display_linear(scene: Rgb) -> Rgb {
    let inset = INSET * (REC709_TO_REC2020 * scene);
    let log = inset.map(|v| ((v.max(1e-10).log2() - MIN_EV) / (MAX_EV - MIN_EV)).clamp(0.0, 1.0));
    let display = (OUTSET * log.map(sigmoid)).map(|v| v.max(0.0).powf(2.2));
    REC709_TO_REC2020.inverse() * display
}

fn sigmoid(x: f64) -> f64 {
    SIGMOID.iter().fold(0.0, |sum, c| sum * x + c)
}

/// The numbers of the transform, for others who show linear Rec.709 radiance as fogbow does. All
/// matrices are by rows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct AgxCurve {
    /// From scene-linear Rec.709 to what the logarithm is taken of.
    pub to_log: [[f64; 3]; 3],
    /// The range of log2 that is taken to 0 to 1.
    pub range: [f64; 2],
    /// Coefficients of the polynomial that follows, that of the highest power first.
    pub sigmoid: [f64; 7],
    /// From its values to the 1/2.2th power of display-linear Rec.2020.
    pub outset: [[f64; 3]; 3],
    /// From that to display-linear Rec.709.
    pub to_display: [[f64; 3]; 3],
}

impl AgxCurve {
    /// The numbers that [`ViewTransform::Agx`](super::ViewTransform::Agx) works with.
    pub fn new() -> Self {
        let rows = |matrix: DMat3| matrix.transpose().to_cols_array_2d();
        Self {
            to_log: rows(INSET * REC709_TO_REC2020),
            range: [MIN_EV, MAX_EV],
            sigmoid: SIGMOID,
            outset: rows(OUTSET),
            to_display: rows(REC709_TO_REC2020.inverse()),
        }
    }
}

impl Default for AgxCurve {
    fn default() -> Self {
        Self::new()
    }
}

/// The scene-linear grey that is shown on a display level: an sRGB code value from 0 to 1.
pub(super) fn scene_grey(level: f64) -> f64 {
    let shown = |log: f64| srgb::encode(display_linear(Rgb::splat(log.exp2())).y);
    let (mut low, mut high) = (MIN_EV, MAX_EV);
    // Half of the range each time, down to less than rounding.
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if shown(middle) < level { low = middle } else { high = middle }
    }
    low.exp2()
}
