//! Optical thickness and emission along a ray, piece by piece.

use std::cell::OnceCell;
use std::ops::ControlFlow;

use crate::math::{Ray, Rgb, Span, Spectrum, World};
use crate::work::Work;

use super::piece::thickness_of;
use super::piece::{Piece, Ramp};
use super::{Emission, Media, Medium};

/// A place on a ray where light may scatter toward its start.
#[derive(Debug, Clone, Copy)]
pub struct Place<S = Rgb> {
    /// Metres along the ray.
    pub t: f64,
    /// Density with which [`Profile::sample`] takes it, 1/m.
    pub pdf: f64,
    /// Transmittance times extinction there over `pdf`: the weight that makes an average of source
    /// functions S at sampled places the integral of T sigma_t S over the ray. In grey media it is
    /// the opacity.
    pub weight: S,
}

/// Optical thickness and emission along one ray: consecutive pieces, front to back, with gaps
/// where nothing is. Kept and traced anew, so that no memory is asked for per ray.
#[derive(Debug, Default)]
pub struct Profile<S = Rgb> {
    pieces: Vec<Piece<S>>,
    total: S,
    /// Of the whole ray, once it has been asked for.
    opacity: OnceCell<S>,
    /// Whether all channels have the same extinction.
    grey: bool,
    tracks: Vec<Track<S>>,
    borders: Vec<f64>,
    steps: u64,
    grid_lookups: u64,
    emission_lookups: u64,
}

/// One field along the ray: pieces with their values, and what a unit of the value amounts to.
#[derive(Debug, Default)]
struct Track<S> {
    pieces: Vec<(Span, Ramp)>,
    /// The emission of each piece, where they have one of their own.
    colors: Vec<S>,
    sigma_t: S,
    emission: EmissionRate<S>,
}

#[derive(Debug, Default, Clone, Copy)]
enum EmissionRate<S> {
    #[default]
    None,
    /// W/(m³ sr) per unit of the track's value.
    PerUnit(S),
    /// Asked of the medium of this index.
    OfMedium(usize),
    /// The track's own colours.
    OfPiece,
}

impl<S> EmissionRate<S> {
    const fn is_looked_up(&self) -> bool {
        matches!(self, Self::OfMedium(_))
    }
}

impl<S: Spectrum> Profile<S> {
    /// Traces `span` of `ray` (unit direction) through `media`. Grids are integrated exactly, cell
    /// by cell, where `step` (metres) is at most a voxel; else they are sampled once a step, at
    /// the fraction `jitter` of it.
    pub fn trace(&mut self, media: &Media, ray: &Ray<World>, span: Span, step: f64, jitter: f64) {
        self.pieces.clear();
        self.total = S::ZERO;
        self.opacity.take();
        self.grey = S::CHANNELS == 1 || media.iter().all(|m| m.sigma_t == Rgb::splat(m.sigma_t.x));
        (self.steps, self.grid_lookups, self.emission_lookups) = (0, 0, 0);
        if let [medium] = media.iter().as_slice()
            && medium.emission.is_none()
        {
            self.trace_dark(medium, ray, span, step, jitter);
        } else {
            self.trace_all(media, ray, span, step, jitter);
        }
    }

    /// Traces through the only medium, which gives off no light: its pieces are those of the ray.
    fn trace_dark(
        &mut self,
        medium: &Medium,
        ray: &Ray<World>,
        span: Span,
        step: f64,
        jitter: f64,
    ) {
        let (mut steps, mut total) = (0, S::ZERO);
        let sigma_t = S::from_rgb(medium.sigma_t);
        let thickest = medium.sigma_t.max_element();
        let pieces = &mut self.pieces;
        medium.density.pieces(ray, span, [step, jitter], thickest, |piece, value| {
            steps += 1;
            if value.mean > 0.0 && !piece.is_empty() {
                push(pieces, &mut total, piece, value.times(sigma_t), S::ZERO);
            }
        });
        (self.total, self.steps) = (total, steps);
        self.grid_lookups = if medium.density.is_voxel() { steps } else { 0 };
    }

    fn trace_all(&mut self, media: &Media, ray: &Ray<World>, span: Span, step: f64, jitter: f64) {
        let mut used = 0;
        for (index, medium) in media.iter().enumerate() {
            let track = next_track(&mut self.tracks, &mut used);
            let group = media.group(index);
            track.sigma_t = S::from_rgb(medium.sigma_t);
            track.emission = match &medium.emission {
                Some(Emission::Density(rate)) => EmissionRate::PerUnit(S::of_group(*rate, group)),
                Some(Emission::Blackbody { .. }) => EmissionRate::OfMedium(index),
                Some(Emission::Grid { .. } | Emission::Ramped(_)) | None => EmissionRate::None,
            };
            let (mut steps, thickest) = (0, medium.sigma_t.max_element());
            medium.density.pieces(ray, span, [step, jitter], thickest, |piece, value| {
                steps += 1;
                if value.mean > 0.0 && !piece.is_empty() {
                    track.pieces.push((piece, value));
                }
            });
            self.steps += steps;
            self.grid_lookups += if medium.density.is_voxel() { steps } else { 0 };
            if track.emission.is_looked_up() {
                self.emission_lookups += track.pieces.len() as u64;
            }
            if let Some(Emission::Grid { grid, color }) = &medium.emission {
                let track = next_track(&mut self.tracks, &mut used);
                track.sigma_t = S::ZERO;
                track.emission = EmissionRate::PerUnit(S::of_group(*color, group));
                let local = grid.transform().ray_to_local(ray);
                let mut steps = 0;
                let _ = grid.cells(&local, span, |piece, integral, _| {
                    steps += 1;
                    if integral > 0.0 && !piece.is_empty() {
                        track.pieces.push((piece, Ramp::flat(integral / piece.length())));
                    }
                    ControlFlow::Continue(())
                });
                self.steps += steps;
                self.grid_lookups += steps;
                self.emission_lookups += steps;
            }
            if let Some(Emission::Ramped(ramped)) = &medium.emission {
                let track = next_track(&mut self.tracks, &mut used);
                track.sigma_t = S::ZERO;
                track.emission = EmissionRate::OfPiece;
                let local = ramped.grid().transform().ray_to_local(ray);
                let mut steps = 0;
                let _ = ramped.cells(&local, span, |piece, integral, _| {
                    steps += 1;
                    if integral != Rgb::ZERO && !piece.is_empty() {
                        track.pieces.push((piece, Ramp::flat(1.0)));
                        track.colors.push(S::of_group(integral / piece.length(), group));
                    }
                    ControlFlow::Continue(())
                });
                self.steps += steps;
                self.grid_lookups += steps;
                self.emission_lookups += steps;
            }
        }
        self.tracks.truncate(used);
        let emission = |track: &Track<S>, at: usize, value: f64, piece: Span| match track.emission {
            EmissionRate::None => S::ZERO,
            EmissionRate::PerUnit(rate) => rate * value,
            EmissionRate::OfMedium(index) => {
                let at = ray.at(piece.start + jitter * piece.length());
                S::of_group(media.get(index).emission_of(value, at), media.group(index))
            }
            EmissionRate::OfPiece => track.colors[at],
        };
        if let [track] = &self.tracks[..] {
            for (at, &(piece, value)) in track.pieces.iter().enumerate() {
                push(
                    &mut self.pieces,
                    &mut self.total,
                    piece,
                    value.times(track.sigma_t),
                    emission(track, at, value.mean, piece),
                );
            }
        } else {
            self.merge(emission);
        }
    }

    /// Cuts all tracks at all borders and adds up what overlaps.
    fn merge(&mut self, emission: impl Fn(&Track<S>, usize, f64, Span) -> S) {
        self.borders.clear();
        let ends = self.tracks.iter().flat_map(|t| &t.pieces).flat_map(|p| [p.0.start, p.0.end]);
        self.borders.extend(ends);
        self.borders.sort_unstable_by(f64::total_cmp);
        self.borders.dedup();
        let mut at: Vec<usize> = vec![0; self.tracks.len()];
        for border in self.borders.windows(2) {
            let piece = Span::new(border[0], border[1]);
            let mut sigma_t = Ramp { mean: S::ZERO, rise: S::ZERO };
            let mut emitted = S::ZERO;
            for (track, at) in self.tracks.iter().zip(&mut at) {
                while track.pieces.get(*at).is_some_and(|p| p.0.end <= piece.start) {
                    *at += 1;
                }
                if let Some((whole, value)) =
                    track.pieces.get(*at).filter(|p| p.0.start <= piece.start)
                {
                    let value = value.part(*whole, piece);
                    let Ramp { mean, rise } = value.times(track.sigma_t);
                    sigma_t.mean += mean;
                    sigma_t.rise += rise;
                    emitted += emission(track, *at, value.mean, piece);
                }
            }
            if sigma_t.mean != S::ZERO || emitted != S::ZERO {
                push(&mut self.pieces, &mut self.total, piece, sigma_t, emitted);
            }
        }
    }

    /// Adds what tracing the ray took to `work`.
    pub const fn count(&self, work: &mut Work) {
        work.marches += 1;
        work.march_steps += self.steps;
        work.grid_lookups += self.grid_lookups;
        work.emission_lookups += self.emission_lookups;
    }

    /// The pieces, front to back.
    pub fn pieces(&self) -> &[Piece<S>] {
        &self.pieces
    }

    /// From the first piece to the last; empty where there is none.
    pub fn extent(&self) -> Span {
        let ends = self.pieces.first().zip(self.pieces.last());
        ends.map_or(Span::new(0.0, 0.0), |(first, last)| Span::new(first.span.start, last.span.end))
    }

    /// Optical thickness of the whole ray.
    pub const fn optical_thickness(&self) -> S {
        self.total
    }

    /// Transmittance of the whole ray.
    pub fn transmittance(&self) -> S {
        (-self.total).exp()
    }

    /// Light emitted along the ray that arrives at its start, W/(m² sr): exact where emission is
    /// proportional to extinction within each piece (the exponential integrator of Novák et al. 2018,
    /// section 2).
    pub fn emitted(&self) -> S {
        let mut sum = S::ZERO;
        for piece in &self.pieces {
            if piece.emission != S::ZERO {
                let length = piece.span.length();
                let reach = piece.sigma_t.map(|sigma_t| seen_length(sigma_t, length));
                sum += (-piece.before).exp() * piece.emission * reach;
            }
        }
        sum
    }

    /// Transmittance from the start of the ray to `t`, and the extinction coefficient there, 1/m;
    /// nothing where there is none.
    pub fn at(&self, t: f64) -> Option<(S, S)> {
        let index = self.pieces.partition_point(|p| p.span.start <= t).checked_sub(1)?;
        let piece = &self.pieces[index];
        (t <= piece.span.end).then(|| {
            let along = t - piece.span.start;
            let thickness = piece.thickness_to(along);
            let transmittance = if self.grey {
                S::splat((-thickness.channel(0)).exp())
            } else {
                (-thickness).exp()
            };
            (transmittance, piece.sigma_t_at(along))
        })
    }

    /// A place proportional to transmittance times extinction, by inverting the opacity at
    /// `u[0]` in a channel chosen by `u[1]` (balance heuristic over the channels, Veach 1997).
    /// Nothing where the ray meets no extinction.
    pub fn sample(&self, u: [f64; 2]) -> Option<Place<S>> {
        let opacity = self.opacity();
        let channel = if self.grey { 0 } else { (u[1] * 3.0) as usize };
        let opacity = opacity.channel(channel);
        if !opacity.is_normal() {
            return None;
        }
        let (piece, along) = self.reach(u[0] * opacity, channel)?;
        let flux = (-piece.thickness_to(along)).exp() * piece.sigma_t_at(along);
        self.place(piece.span.start + along, flux)
    }

    /// Opacity of the whole ray, in the middle channel where they differ.
    pub fn middle_opacity(&self) -> f64 {
        self.opacity().channel(self.middle_channel())
    }

    /// Distance in metres at which the opacity has reached this `opacity` in the channel of
    /// [`middle_opacity`](Self::middle_opacity); nothing where it does not.
    pub fn distance_at(&self, opacity: f64) -> Option<f64> {
        let reaches = opacity > 0.0 && opacity <= self.middle_opacity();
        let (piece, along) = reaches.then(|| self.reach(opacity, self.middle_channel()))??;
        Some(piece.span.start + along)
    }

    fn middle_channel(&self) -> usize {
        S::CHANNELS / 2
    }

    /// The piece in which the opacity from the start of the ray is `opacity` in `channel`, and metres from its start to there.
    fn reach(&self, opacity: f64, channel: usize) -> Option<(&Piece<S>, f64)> {
        let target = -(-opacity).ln_1p();
        let before = |piece: &Piece<S>| piece.before.channel(channel);
        let index = self.pieces.partition_point(|p| before(p) <= target).checked_sub(1)?;
        let piece = &self.pieces[index];
        Some((piece, piece.reach(target, channel)?))
    }

    /// The place at `t` with the density that [`sample`](Self::sample) has there; nothing where
    /// there is no extinction.
    pub fn place_at(&self, t: f64) -> Option<Place<S>> {
        let (transmittance, sigma_t) = self.at(t)?;
        self.place(t, transmittance * sigma_t)
    }

    /// The place at `t`, where transmittance times extinction is `flux`.
    fn place(&self, t: f64, flux: S) -> Option<Place<S>> {
        let opacity = self.opacity();
        if self.grey {
            let pdf = flux.channel(0) / opacity.channel(0);
            return pdf.is_normal().then_some(Place { t, pdf, weight: opacity });
        }
        let share = |c: usize| {
            let (flux, opacity) = (flux.channel(c), opacity.channel(c));
            if opacity > 0.0 { flux / opacity } else { 0.0 }
        };
        let pdf = (0..3).map(share).sum::<f64>() / 3.0;
        pdf.is_normal().then(|| Place { t, pdf, weight: flux / pdf })
    }

    fn opacity(&self) -> S {
        *self.opacity.get_or_init(|| self.total.map(|tau| -(-tau).exp_m1()))
    }
}

fn next_track<'a, S: Spectrum>(
    tracks: &'a mut Vec<Track<S>>,
    used: &mut usize,
) -> &'a mut Track<S> {
    if *used == tracks.len() {
        tracks.push(Track::default());
    }
    *used += 1;
    let track = &mut tracks[*used - 1];
    track.pieces.clear();
    track.colors.clear();
    track
}

fn push<S: Spectrum>(
    pieces: &mut Vec<Piece<S>>,
    total: &mut S,
    span: Span,
    sigma_t: Ramp<S>,
    emission: S,
) {
    let Ramp { mean, rise } = sigma_t;
    pieces.push(Piece { span, sigma_t: mean, rise, emission, before: *total });
    *total += thickness_of(mean, span.length());
}

/// The integral of exp(-sigma_t s) for s from 0 to `length`, in metres.
fn seen_length(sigma_t: f64, length: f64) -> f64 {
    if sigma_t > 0.0 { -(-sigma_t * length).exp_m1() / sigma_t } else { length }
}
