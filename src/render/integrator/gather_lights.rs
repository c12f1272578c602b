//! Light of lamps inside media that final gathers find along their rays.
//!
//! Near a lamp light is as one over the squared distance, and few gathers scatter there. So along each ray of a
//! gather a place near each such lamp is sampled too, equiangularly (Kulla and Fajardo 2012), and combined with
//! the light sampled where the gather scatters by the balance heuristic (Veach 1997, section 9.2.2).

use smallvec::SmallVec;

use crate::light::LightOrigin;
use crate::math::{Ray, Rgb, Span, Spectrum, World};
use crate::photon::PhotonDirection;
use crate::transport::{EquiangularLights, LightNumbers, PathContext, PathState, direct_light};

use super::setup::Integrator;

impl<S: Spectrum, H: PhotonDirection> Integrator<'_, S, H> {
    /// The lamps in media that the ray of a gather passes before `end`, in metres.
    pub(super) fn lamps_along(&self, ray: &Ray<World>, end: f64) -> EquiangularLights<'_> {
        let media = &self.scene.media;
        let all = Span::new(0.0, end);
        let span = |light: usize| {
            if !self.lamps_in_media[light] {
                Span::new(0.0, 0.0)
            } else if media.is_endless() {
                all
            } else {
                media.bounds().clip(ray).intersect(all)
            }
        };
        EquiangularLights::near(&self.scene.lights, ray, span)
    }

    /// Light of `lamps` that media scatter once along the path's ray to its origin, W/(m² sr): the part of it that
    /// equiangular sampling has by the balance heuristic.
    pub(super) fn sampled_lamps(
        &self,
        path: &PathState<S>,
        lamps: &EquiangularLights<'_>,
        ctx: &mut PathContext,
    ) -> S {
        if lamps.is_empty() {
            return S::ZERO;
        }
        let (media, lights) = (&self.scene.media, &self.scene.lights);
        let ray = path.ray;
        let u = LightNumbers::varied(ctx.rng.uniform(), ctx.rng.uniform2());
        let mut sum = S::ZERO;
        for lamp in lamps.pick(u.among) {
            let u = u.position(lamp.index);
            let Some((t, sample)) = lamps.sample(lamp, ctx.rng.uniform(), u) else { continue };
            let p = ray.at(t);
            let mixture = media.mixture_at(p);
            ctx.work.grid_lookups += media.scattering_grids();
            let scatterer = |(medium, sigma_s): &(usize, Rgb)| {
                (&media.get(*medium).phase, S::from_rgb(*sigma_s))
            };
            let scatterers: SmallVec<[_; 1]> = mixture.iter().map(scatterer).collect();
            let wo = -ray.direction;
            let light_in = direct_light::in_scattered(self.scene, p, wo, &scatterers, &sample, ctx);
            if light_in == S::ZERO {
                continue;
            }
            let (through, flux) = self.through(&ray, t, ctx);
            let choice = lights.pick_probability(p, lamp.index);
            let pdf = lamps.pdf(lamp.index, &sample.origin(p), t) + choice * flux;
            let light = through * light_in / (pdf * sample.pdf);
            let light = light.in_group(self.scene.groups.of_light(lamp.index));
            sum += self.scene.groups.scattered(light);
        }
        sum
    }

    /// Weight of light from `origin` on the light of this index, sampled where the path's ray is scattered at the
    /// distance `t`, against [`sampled_lamps`](Self::sampled_lamps). `choice` is the probability of choosing the light.
    pub(super) fn weight_at_scattering(
        &self,
        path: &PathState<S>,
        t: f64,
        lamps: &EquiangularLights<'_>,
        (light, origin, choice): (usize, &LightOrigin, f64),
        ctx: &mut PathContext,
    ) -> f64 {
        let equiangular = lamps.pdf(light, origin, t);
        if equiangular == 0.0 {
            return 1.0;
        }
        let (_, flux) = self.through(&path.ray, t, ctx);
        choice * flux / (choice * flux + equiangular)
    }

    /// Transmittance along `ray` to the distance `t`, and the density of scatterings there, 1/m, mean over channels.
    fn through(&self, ray: &Ray<World>, t: f64, ctx: &mut PathContext) -> (S, f64) {
        let media = &self.scene.media;
        let through: S = media.transmittance_counted(ray, Span::new(0.0, t), &mut ctx.work);
        ctx.work.grid_lookups += media.density_grids();
        let flux = through * S::from_rgb(media.sigma_t_at(ray.at(t)));
        (through, flux.element_sum() / 3.0)
    }
}
