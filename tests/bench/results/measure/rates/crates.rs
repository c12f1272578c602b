//! What kiddo and obvhs do by themselves, in the way of their own benchmarks and examples.

use std::num::NonZero;
use std::time::Duration;

use fogbow::math::{Ray, Span, World};
use fogbow::photon::{BeamMap, PhotonAt, PhotonMap};
use glam::Vec3A;
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::cwbvh::builder::build_cwbvh;
use obvhs::ray::RayHit;
use rayon::prelude::*;

use super::bench::{Bench, Job};
use super::{AROUND, ORIGIN, RADIUS, around};
use crate::pages::Result;
use crate::pages::rates::Row;

/// Neighbours of a query for the nearest few.
const NEAREST: usize = 8;

/// How far along the ray the photon at `center` is nearest, where the ray crosses its ball.
fn crossed(center: Vec3A, ray: &obvhs::ray::Ray) -> Option<f32> {
    let to = center - ray.origin;
    let along = to.dot(ray.direction);
    let aside = to - ray.direction * along;
    (aside.length_squared() <= RADIUS * RADIUS).then_some(along)
}

/// fogbow's maps beside the trees that they are made of, on the same photons, places and rays.
pub fn compare(
    bench: &Bench,
    placed: &[PhotonAt],
    queries: &[PhotonAt],
    rays: &[Ray<World>],
) -> Result<Vec<Row>> {
    let mut rows = trees(bench, placed, queries)?;
    rows.extend(hierarchies(bench, placed, rays));
    Ok(rows)
}

fn trees(bench: &Bench, placed: &[PhotonAt], queries: &[PhotonAt]) -> Result<Vec<Row>> {
    type Tree = ImmutableKdTree<f32, 3>;
    let places: Vec<[f32; 3]> = placed.iter().map(|p| p.place).collect();
    let photons = ("photons/s", placed.len() as f64);
    let mut rows = bench.group(&[
        Job::new("build a surface map", photons, || PhotonMap::new(ORIGIN, placed)),
        Job::new("kiddo: build, serial", photons, || {
            Tree::builder().with_serial_construction().build_from_slice(&places)
        }),
        Job::new("kiddo: build, parallel", photons, || Tree::new_from_slice_parallel(&places)),
    ]);

    let (map, tree) = (PhotonMap::new(ORIGIN, placed), Tree::new_from_slice(&places));
    let tree = tree?;
    let asked = ("gathers/s", queries.len() as f64);
    let squared = AROUND * AROUND;
    let all = |each: &(dyn Fn(&PhotonAt) -> u64 + Sync)| queries.par_iter().map(each).sum::<u64>();
    let found = all(&|p| around(&map, p)) as f64;
    rows.extend(bench.group(&[
        Job::of("around a place", &[asked, ("photons/s", found)], || all(&|p| around(&map, p))),
        Job::new("kiddo: within, unsorted, visited", asked, || {
            all(&|p| {
                let mut found = 0;
                tree.query(&p.place)
                    .within::<SquaredEuclidean<f32>>(squared)
                    .unsorted()
                    .visit(|_| found += 1);
                found
            })
        }),
        Job::new("kiddo: within, unsorted, as a list", asked, || {
            all(&|p| {
                let found = tree.query(&p.place).within::<SquaredEuclidean<f32>>(squared);
                found.unsorted().execute().len() as u64
            })
        }),
        Job::new("kiddo: within, sorted", asked, || {
            all(&|p| {
                let found = tree.query(&p.place).within::<SquaredEuclidean<f32>>(squared);
                found.execute().len() as u64
            })
        }),
    ]));
    let nearest = NonZero::new(NEAREST).ok_or("no neighbour is asked for")?;
    rows.extend(bench.group(&[
        Job::new("the 8 nearest", asked, || {
            let origin = |p: &PhotonAt| p.at(ORIGIN);
            all(&|p| map.distance_to_nearest(origin(p), NEAREST).map_or(0, |d| u64::from(d > 0.0)))
        }),
        Job::new("kiddo: the 8 nearest", asked, || {
            all(&|p| {
                let found = tree.query(&p.place).nearest_n::<SquaredEuclidean<f32>>(nearest);
                found.execute().len() as u64
            })
        }),
    ]));
    Ok(rows)
}

fn hierarchies(bench: &Bench, placed: &[PhotonAt], rays: &[Ray<World>]) -> Vec<Row> {
    let center = |p: &PhotonAt| Vec3A::from(p.place);
    let ball = |p: &PhotonAt| Aabb::new(center(p) - RADIUS, center(p) + RADIUS);
    let balls: Vec<Aabb> = placed.iter().map(ball).collect();
    let radii = vec![RADIUS; placed.len()];
    let photons = ("photons/s", placed.len() as f64);
    let wide = |params| build_cwbvh(&balls, params, &mut Duration::default());
    let binary = |params| build_bvh2(&balls, params, &mut Duration::default());
    let mut told = bench.group(&[
        Job::new("build a beam map", photons, || BeamMap::new(ORIGIN, placed, &radii)),
        Job::new("obvhs: CWBVH, fastest", photons, || wide(BvhBuildParams::fastest_build())),
        Job::new("obvhs: CWBVH, very fast", photons, || wide(BvhBuildParams::very_fast_build())),
        Job::new("obvhs: CWBVH, medium", photons, || wide(BvhBuildParams::medium_build())),
        Job::new("obvhs: BVH2, very fast", photons, || binary(BvhBuildParams::very_fast_build())),
    ]);

    let map = BeamMap::new(ORIGIN, placed, &radii);
    let met = |ray: &Ray<World>| {
        let mut met = 0;
        map.along(ray, Span::AHEAD, 1.0, |_| met += 1);
        met
    };
    let found = rays.par_iter().map(met).sum::<u64>() as f64;
    let asked = ("gathers/s", rays.len() as f64);
    let (wide, binary) =
        (wide(BvhBuildParams::very_fast_build()), binary(BvhBuildParams::very_fast_build()));
    // In the order of the leaves, as the crate's examples advise.
    let sorted = |indices: &[u32]| -> Vec<Vec3A> {
        indices.iter().map(|index| center(&placed[*index as usize])).collect()
    };
    let (of_wide, of_binary) = (sorted(&wide.primitive_indices), sorted(&binary.primitive_indices));
    let local = |ray: &Ray<World>| {
        let origin = (ray.origin - ORIGIN).as_vec3a();
        obvhs::ray::Ray::new_inf(origin, ray.direction.as_vec3a())
    };
    let all = |each: &(dyn Fn(obvhs::ray::Ray) -> u64 + Sync)| {
        rays.par_iter().map(|ray| each(local(ray))).sum::<u64>()
    };
    told.extend(bench.group(&[
        Job::of("along a ray", &[asked, ("photons/s", found)], || {
            rays.par_iter().map(met).sum::<u64>()
        }),
        Job::new("obvhs: CWBVH, every hit", asked, || {
            all(&|ray| {
                let mut hits = 0;
                wide.ray_traverse_anyhit(ray, |ray, index| {
                    hits += u64::from(crossed(of_wide[index], ray).is_some());
                });
                hits
            })
        }),
        Job::new("obvhs: BVH2, every hit", asked, || {
            all(&|ray| {
                let mut hits = 0;
                binary.ray_traverse_anyhit(ray, |ray, index| {
                    hits += u64::from(crossed(of_binary[index], ray).is_some());
                });
                hits
            })
        }),
    ]));
    told.extend(bench.group(&[Job::new("obvhs: CWBVH, nearest hit", asked, || {
        all(&|ray| {
            let mut hit = RayHit::none();
            let near = |ray: &obvhs::ray::Ray, index: usize| {
                crossed(of_wide[index], ray).filter(|t| *t > 0.0).unwrap_or(f32::INFINITY)
            };
            u64::from(wide.ray_traverse(ray, &mut hit, near))
        })
    })]));
    told
}
