//! How linear radiance is shown on an sRGB display.

use std::fmt::{self, Display, Formatter};
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use super::{agx, srgb};
use crate::error::Error;
use crate::math::Rgb;

/// The curve from scene light to display light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ViewTransform {
    /// The sRGB curve alone (IEC 61966-2-1); what is brighter than 1 clips. For measuring.
    #[default]
    Srgb,
    /// AgX of Troy Sobotka, as in Blender 4 without a look: highlights roll off to white over 16.5
    /// stops. For looking at.
    Agx,
}

impl FromStr for ViewTransform {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self, Error> {
        match name {
            "srgb" => Ok(Self::Srgb),
            "agx" => Ok(Self::Agx),
            _ => {
                Err(Error::Usage(format!("view transform \"{name}\" is unknown; use srgb or agx")))
            }
        }
    }
}

impl Display for ViewTransform {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Srgb => "srgb",
            Self::Agx => "agx",
        })
    }
}

/// How a picture is developed into 8 bit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct View {
    /// Exposure in stops: radiance is multiplied by 2 to this power.
    pub exposure: f64,
    /// The curve that follows.
    pub transform: ViewTransform,
}

impl View {
    /// The sRGB bytes of a linear Rec.709 radiance, rounded to nearest without dither.
    pub fn develop(&self, radiance: Rgb) -> [u8; 3] {
        let exposed = radiance * self.exposure.exp2();
        let display = match self.transform {
            ViewTransform::Srgb => exposed,
            ViewTransform::Agx => agx::display_linear(exposed),
        };
        display.to_array().map(|v| (srgb::encode(v) * 255.0).round() as u8)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AGX: View = View { exposure: 0.0, transform: ViewTransform::Agx };

    #[test]
    fn agx_is_monotone_from_black_to_white() {
        let grey = |stops: f64| AGX.develop(Rgb::splat(0.18 * stops.exp2()));
        let mut last = [0; 3];
        for step in -150..=100 {
            let byte = grey(f64::from(step) / 10.0);
            assert!(byte.iter().zip(last).all(|(b, l)| *b >= l), "{byte:?} after {last:?}");
            last = byte;
        }
        assert_eq!(AGX.develop(Rgb::ZERO), [0; 3]);
        assert_eq!(last, [255; 3]);
    }

    #[test]
    fn agx_keeps_greys_grey_and_middle_grey_in_the_middle() {
        let [r, g, b] = AGX.develop(Rgb::splat(0.18));
        assert!(r.abs_diff(g) <= 1 && g.abs_diff(b) <= 1, "{r} {g} {b}");
        assert!((120..=135).contains(&g), "middle grey is shown as {g}");
    }

    #[test]
    fn agx_takes_bright_colours_to_white() {
        let [_, g, b] = AGX.develop(Rgb::new(4.0, 0.1, 0.1));
        let [_, bright_g, bright_b] = AGX.develop(Rgb::new(400.0, 10.0, 10.0));
        assert!(bright_g > g && bright_b > b);
    }

    #[test]
    fn exposure_is_in_stops() {
        let view = View { exposure: 1.0, ..View::default() };
        assert_eq!(view.develop(Rgb::splat(0.25)), [188; 3]);
    }

    #[test]
    fn names_go_both_ways() {
        for transform in [ViewTransform::Srgb, ViewTransform::Agx] {
            assert_eq!(transform.to_string().parse::<ViewTransform>().unwrap(), transform);
            assert_eq!(serde_json::to_value(transform).unwrap(), transform.to_string());
        }
        assert!("filmic".parse::<ViewTransform>().unwrap_err().to_string().contains("srgb or agx"));
    }
}
