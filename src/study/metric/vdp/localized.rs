//! The VDP confined to the pixels that differ, as the program HDR VDP prints it.

use super::super::{Display, Map};
use super::luminances;
use crate::image::Image;

/// Luminances in cd/m² that differ by less count as the same.
const SAME: f64 = 1e-4;

/// `vdp`, the [`vdp_map`](super::vdp_map) of the two pictures, with 0 wherever they show the same
/// luminance to within 1e-4 cd/m²: `exposure` and `display` are those of the map.
///
/// Daly's model spreads the difference of one pixel over the low bands, so that neighbours which
/// are the same in both pictures get a probability too. This map leaves them out. A single wrong
/// pixel counts as one pixel, whatever its glare.
///
/// It is the last step of Mantiuk and Krawczyk's program HDR VDP from version 1.5 (21 February
/// 2006) to 1.7 (2008): `fixPredictionWithRMS` in `vdpcmp.cpp`, in its ChangeLog "ABS fix, which
/// compares target and mask and zeros predictions if the pixels are almost identical". It compares
/// the luminance that goes into the program, in cd/m² (80 for the white of pictures of 8 bit),
/// before any filter. The option `--no-abs-fix` and versions 1.0 to 1.4 (2004 and 2005) leave the
/// step out, and give what [`vdp_map`](super::vdp_map) gives. Which one Anson et al. 2006 used is
/// unknown. Nothing but this step is taken from the program: all bands are those of Daly 1993.
pub fn vdp_localized_map(
    vdp: &Map,
    reference: &Image,
    test: &Image,
    exposure: f64,
    display: &Display,
) -> Map {
    let [seen, tested] = [reference, test].map(|image| luminances(image, exposure, display));
    let values = vdp.values.iter().zip(seen.zip(tested));
    let values = values.map(|(&p, (a, b))| if (a - b).abs() < SAME { 0.0 } else { p }).collect();
    Map { width: vdp.width, height: vdp.height, values }
}
