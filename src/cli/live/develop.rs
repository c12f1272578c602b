//! Layers of a film as PNG pictures for the page.

use std::path::Path;

use crate::error::Result;
use crate::image::{FAR, Film, Image, NOISY_LAYERS, Picture, ScalarMap, View, png_bytes};

/// The layer of the picture itself.
const BEAUTY: &str = "beauty";

/// The picture before noise was taken off.
const NOISY: &str = "noisy";

/// The channels of [`BEAUTY`].
const RADIANCE: [&str; 3] = ["R", "G", "B"];

/// What is called otherwise than its layer.
const TITLES: [(&str, &str); 6] = [
    ("A", "alpha"),
    ("Z", "distance (Z), m"),
    ("xs", "XS"),
    ("rays", "rays a pixel"),
    ("radius", "gather radius, m"),
    ("step", "march step, m"),
];

/// A developed layer.
#[derive(Debug)]
pub(super) struct Developed {
    pub(super) png: Vec<u8>,
    /// Least and largest value, where it is in false colours.
    pub(super) range: Option<[f32; 2]>,
}

/// The layers of `film` that can be developed: name and title of each, the picture first.
pub(super) fn layers(film: &Film) -> Vec<[&'static str; 2]> {
    let noisy = film.layer(NOISY_LAYERS[0]).map(|_| [NOISY; 2]);
    let is_scalar = |name: &&str| !RADIANCE.contains(name) && !NOISY_LAYERS.contains(name);
    let scalars = film.layers().map(|(name, _)| name).filter(is_scalar);
    [[BEAUTY; 2]].into_iter().chain(noisy).chain(scalars.map(|name| [name, title(name)])).collect()
}

fn title(layer: &'static str) -> &'static str {
    TITLES.iter().find(|(name, _)| *name == layer).map_or(layer, |(_, title)| title)
}

/// The `layer` of `film` as a PNG; `None` where there is no such layer. A picture is shown by `view`, one number a pixel in
/// false colours, without distances where nothing is hit.
///
/// # Errors
/// Where the film is larger than a PNG can be.
pub(super) fn develop(film: &Film, layer: &str, view: &View) -> Result<Option<Developed>> {
    let channels = match layer {
        BEAUTY => Some(RADIANCE),
        NOISY => Some(NOISY_LAYERS),
        _ => None,
    };
    let (picture, range) = if let Some(channels) = channels {
        let Some(image) = image(film, channels) else { return Ok(None) };
        (Picture::developed(&image, view), None)
    } else {
        let Some(values) = film.layer(layer) else { return Ok(None) };
        let is_near = |value: &f32| f64::from(*value) < FAR;
        let values: Vec<f32> =
            values.iter().map(|value| if is_near(value) { *value } else { f32::NAN }).collect();
        let map = ScalarMap::fitted(layer, film.width(), &values);
        (map.colored(), Some(map.range))
    };
    let png = png_bytes(Path::new("the picture of --view"), &picture)?;
    Ok(Some(Developed { png, range }))
}

fn image(film: &Film, channels: [&str; 3]) -> Option<Image> {
    let [r, g, b] = channels.map(|name| film.layer(name));
    let pixels = r?.iter().zip(g?).zip(b?).map(|((r, g), b)| [*r, *g, *b]).collect();
    Some(Image::new(film.width(), film.height(), pixels))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::{FilmPixel, Image, ViewTransform, viridis};
    use crate::math::Rgb;

    /// A film of two pixels: one dark and near, one bright and without a surface.
    fn film() -> Film {
        let mut film = Film::new(2, 1);
        let near =
            FilmPixel { radiance: Rgb::splat(0.1), depth: 3.0, rays: 4.0, ..FilmPixel::default() };
        film.set(0, 0, &near);
        film.set(
            1,
            0,
            &FilmPixel { radiance: Rgb::splat(0.4), rays: 16.0, ..FilmPixel::default() },
        );
        film
    }

    fn bytes(png: &[u8]) -> Vec<u8> {
        let mut reader = ::png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut bytes).unwrap();
        bytes
    }

    #[test]
    fn layers_are_the_picture_and_what_the_film_has() {
        let mut film = film();
        let names = |film: &Film| layers(film).iter().map(|[name, _]| *name).collect::<Vec<_>>();
        let all = [
            "beauty",
            "A",
            "Z",
            "transmittance",
            "saliency",
            "xs",
            "rays",
            "radius",
            "step",
            "variance",
        ];
        assert_eq!(names(&film), all);
        film.set_denoised(&Image::new(2, 1, vec![[0.2; 3]; 2]), "a test");
        assert_eq!(names(&film)[..2], ["beauty", "noisy"]);
        let view = View::default();
        for [name, _] in layers(&film) {
            assert!(develop(&film, name, &view).unwrap().is_some(), "{name}");
        }
        assert!(develop(&film, "B", &view).unwrap().is_some_and(|layer| layer.range.is_some()));
        assert!(develop(&film, "none", &view).unwrap().is_none());
    }

    #[test]
    fn a_picture_is_developed_and_numbers_get_false_colours() {
        let film = film();
        let view = View { exposure: 1.0, transform: ViewTransform::Srgb };
        let beauty = develop(&film, "beauty", &view).unwrap().unwrap();
        let shown = [0.1_f32, 0.4].map(|v| view.develop(Rgb::splat(v.into())));
        assert_eq!((bytes(&beauty.png), beauty.range), (shown.concat(), None));
        let rays = develop(&film, "rays", &view).unwrap().unwrap();
        assert_eq!(bytes(&rays.png), [viridis(0.0), viridis(1.0)].concat());
        assert_eq!(rays.range, Some([4.0, 16.0]));
        let depth = develop(&film, "Z", &view).unwrap().unwrap();
        assert_eq!(bytes(&depth.png), [viridis(0.0), crate::image::NOT_FINITE].concat());
        assert_eq!(depth.range, Some([3.0, 3.0]));
    }
}
