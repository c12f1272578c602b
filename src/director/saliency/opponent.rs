//! Intensity and the two colour opponencies.

use super::plane::Plane;

/// Hue is not perceived where intensity is below this part of its greatest value.
///
/// Unit: none. Source: Itti et al. 1998, section "Extraction of Early Visual Features".
const HUE_VISIBLE: f32 = 0.1;

/// The early visual channels of a picture (Itti et al. 1998, section "Extraction of Early Visual
/// Features").
pub struct Channels {
    /// I = (r + g + b) / 3.
    pub intensity: Plane,
    /// R - G of the broadly tuned channels.
    pub red_green: Plane,
    /// B - Y of the broadly tuned channels.
    pub blue_yellow: Plane,
}

impl Channels {
    /// Channels of display code values.
    pub fn new(width: usize, height: usize, pixels: &[[f32; 3]]) -> Self {
        let intensity: Vec<f32> = pixels.iter().map(|[r, g, b]| (r + g + b) / 3.0).collect();
        let hue_visible = HUE_VISIBLE * intensity.iter().copied().fold(0.0, f32::max);
        let (red_green, blue_yellow) = pixels
            .iter()
            .zip(&intensity)
            .map(|(p, &i)| if i > hue_visible { opponency(p.map(|c| c / i)) } else { (0.0, 0.0) })
            .unzip();
        Self {
            intensity: Plane::new(width, height, intensity),
            red_green: Plane::new(width, height, red_green),
            blue_yellow: Plane::new(width, height, blue_yellow),
        }
    }
}

/// R - G and B - Y, where each of the broadly tuned channels R, G, B and Y is at least 0.
fn opponency([r, g, b]: [f32; 3]) -> (f32, f32) {
    let red = (r - (g + b) / 2.0).max(0.0);
    let green = (g - (r + b) / 2.0).max(0.0);
    let blue = (b - (r + g) / 2.0).max(0.0);
    let yellow = ((r + g) / 2.0 - (r - g).abs() / 2.0 - b).max(0.0);
    (red - green, blue - yellow)
}
