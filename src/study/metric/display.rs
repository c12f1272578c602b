//! The display that pictures are looked at on.

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::math::{Rgb, luminance};

/// A flat display with square pixels, seen from the front. A picture's pixels are shown one to one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Display {
    /// Pixels across and down.
    pub resolution: [u32; 2],
    /// Diagonal in inches.
    pub diagonal: f64,
    /// Distance from the eye in metres.
    pub distance: f64,
    /// Luminance of white in cd/m².
    pub white: f64,
    /// Luminance of black in cd/m², with the room's light on the glass.
    pub black: f64,
}

impl Default for Display {
    /// The display of Anson et al. 2006, 17 inch with 1280 x 1024 pixels seen from 60 cm. They
    /// don't tell its luminance; white is that of the sRGB reference display and black its veiling
    /// glare (IEC 61966-2-1:1999: 80 and 0.2 cd/m²).
    fn default() -> Self {
        Self { resolution: [1280, 1024], diagonal: 17.0, distance: 0.6, white: 80.0, black: 0.2 }
    }
}

impl Display {
    /// Pixels that one degree of the visual field holds, in the middle of the display.
    pub fn pixels_per_degree(&self) -> f64 {
        let [across, down] = self.resolution.map(f64::from);
        let pitch = self.diagonal * 0.0254 / across.hypot(down);
        self.distance * 1.0_f64.to_radians() / pitch
    }

    /// Luminance in cd/m² of a linear colour whose channels are 0 to 1.
    pub(super) fn luminance(&self, linear: Rgb) -> f64 {
        self.black + (self.white - self.black) * luminance(linear)
    }

    /// Checks that every length is above 0 and white is brighter than black.
    ///
    /// # Errors
    /// Where one is not.
    pub fn check(&self) -> Result<()> {
        let lengths = [self.diagonal, self.distance, self.black, self.white];
        let sound = lengths.iter().all(|v| v.is_finite() && *v > 0.0)
            && self.resolution.iter().all(|n| *n > 0)
            && self.black < self.white;
        if sound {
            return Ok(());
        }
        Err(Error::Usage(format!(
            "a display of {:?} pixels, {} inch, seen from {} m, black at {} and white at {} cd/m² \
             cannot be; all must be above 0, and white above black",
            self.resolution, self.diagonal, self.distance, self.black, self.white
        )))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_display_has_40_pixels_a_degree() {
        // 17 inch are 431.8 mm over 1639.2 pixels: 0.26342 mm each; a degree at 60 cm is 10.472 mm.
        assert!((Display::default().pixels_per_degree() - 39.754).abs() < 1e-3);
    }

    #[test]
    fn impossible_displays_are_refused() {
        for display in [
            Display { distance: 0.0, ..Display::default() },
            Display { diagonal: f64::NAN, ..Display::default() },
            Display { black: 80.0, ..Display::default() },
            Display { resolution: [0, 1024], ..Display::default() },
        ] {
            let message = display.check().unwrap_err().to_string();
            assert!(message.contains("above 0"), "{message}");
        }
        Display::default().check().unwrap();
    }
}
