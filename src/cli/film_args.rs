//! `--denoise`, `--reconstruct`, `--half` and `--deep`: what becomes of the samples of a picture.

use crate::scene::LoadOptions;

/// What becomes of the samples of a picture.
#[derive(Debug, clap::Args)]
pub(super) struct FilmArgs {
    /// Take noise off the picture in the end by Open Image Denoise; what was there stays in the layers
    /// noisy.R, noisy.G and noisy.B. The library is that of FOGBOW_OIDN, of the loader's path or of a
    /// Python environment (pip install pyoidn).
    #[arg(long)]
    pub(super) denoise: bool,
    /// Take noise off the picture in the end by fogbow itself, which needs no library: light of media, and direct
    /// and indirect light of surfaces, are each averaged over neighbours as widely as two halves of the rays and
    /// photons agree. What was there stays in the layers noisy.R, noisy.G and noisy.B.
    #[arg(long, conflicts_with = "denoise")]
    reconstruct: bool,
    /// Store colours as 16-bit floats; a layer that is too bright or too dark for those keeps 32 bits, as do Z and
    /// all that is no colour.
    #[arg(long)]
    half: bool,
    /// Write OUT.deep.exr beside the picture as well: samples of its light and opacity by distance, for compositing with
    /// other pictures in depth.
    #[arg(long)]
    deep: bool,
}

impl FilmArgs {
    /// The `options` with those that are given here.
    pub(super) fn apply(&self, options: LoadOptions) -> LoadOptions {
        let given = [
            ("render.denoise", self.denoise),
            ("render.reconstruct", self.reconstruct),
            ("film.half", self.half),
            ("film.deep", self.deep),
        ];
        let given = given.into_iter().filter(|(_, is_given)| *is_given);
        given.fold(options, |options, (key, _)| options.with(key, true))
    }
}
