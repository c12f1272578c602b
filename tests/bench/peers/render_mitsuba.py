#!/usr/bin/env python3
"""Renders a scene with Mitsuba's volpath, without early Russian roulette.

Mitsuba's `gridvolume` puts a sample at the centre of its cell, so its cube is half a voxel wider on
every side than the box of the samples. Kernels are compiled before the clock starts.
"""

from pathlib import Path

import drjit
import mitsuba
import numpy

import scene as scenes
from measure import Meter, arguments

mitsuba.set_variant("llvm_ad_rgb")
Transform = mitsuba.ScalarTransform4f


def rectangle(quad: scenes.Quad) -> mitsuba.ScalarTransform4f:
    matrix = numpy.eye(4)
    matrix[:3] = numpy.array([quad.u, quad.v, quad.normal, quad.center]).T
    return Transform(matrix)


def rgb(value: float) -> dict:
    return {"type": "rgb", "value": value}


def phase(volume: scenes.Volume) -> dict:
    return {"type": "isotropic"} if volume.g == 0 else {"type": "hg", "g": volume.g}


def fog(volume: scenes.Volume) -> dict:
    return {
        "type": "homogeneous",
        "albedo": volume.albedo,
        "sigma_t": volume.sigma_t,
        "has_spectral_extinction": False,
        "phase": phase(volume),
    }


def filled(box: mitsuba.ScalarTransform4f, medium: dict) -> dict:
    """A box, to which the unit cube is taken, with a medium inside."""
    unit = Transform().translate([0.5] * 3).scale([0.5] * 3)  # from [-1, 1]^3 to [0, 1]^3
    return {"type": "cube", "to_world": box @ unit, "bsdf": {"type": "null"}, "interior": medium}


def smoke(volume: scenes.Volume, dense: Path) -> dict:
    with numpy.load(dense) as grid:
        density, origin, voxel = grid["density"], grid["origin"], float(grid["voxel"])
    extent = [n * voxel for n in density.shape]
    box = Transform().translate(list(origin - 0.5 * voxel)).scale(extent)
    medium = {
        "type": "heterogeneous",
        "albedo": volume.albedo,
        "scale": volume.sigma_t,
        "has_spectral_extinction": False,
        "phase": phase(volume),
        "sigma_t": {
            "type": "gridvolume",
            "grid": mitsuba.VolumeGrid(
                numpy.ascontiguousarray(density.transpose(2, 1, 0))[..., None]
            ),
            "raw": True,
            "filter_type": "trilinear",
            "wrap_mode": "clamp",
            "to_world": box,
        },
    }
    return filled(box, medium)


def build(scene: scenes.Scene, dense: Path | None) -> mitsuba.Scene:
    camera = scene.camera
    parts = {
        "type": "scene",
        "integrator": {
            "type": "volpath",
            "max_depth": -1,
            "rr_depth": 1000,
            "hide_emitters": scene.area_light is not None,
        },
        "sensor": {
            "type": "perspective",
            "fov": camera.fov,
            "fov_axis": "x",
            "near_clip": 0.01,
            "far_clip": 1000.0,
            "to_world": Transform().look_at(
                origin=list(camera.position), target=list(camera.target), up=[0, 1, 0]
            ),
            "film": {
                "type": "hdrfilm",
                "width": scene.size,
                "height": scene.size,
                "pixel_format": "rgb",
                "component_format": "float32",
                "rfilter": {"type": "box"},
            },
            "sampler": {"type": "independent"},
        },
    }
    within = scene.volume.within
    if isinstance(within, scenes.Box):
        medium = fog(scene.volume)
        size = scenes.subtract(within.high, within.low)
        parts["smoke"] = filled(Transform().translate(within.low).scale(size), medium)
        if within.holds(camera.position):
            parts["sensor"]["medium"] = medium
    else:
        parts["smoke"] = smoke(scene.volume, dense)
    if scene.area_light:
        parts["light"] = {
            "type": "rectangle",
            "to_world": rectangle(scene.area_light.quad),
            "emitter": {"type": "area", "radiance": rgb(scene.area_light.radiance)},
        }
    if scene.ground:
        parts["ground"] = {
            "type": "rectangle",
            "to_world": rectangle(scene.ground.quad),
            "bsdf": {"type": "diffuse", "reflectance": rgb(scene.ground.reflectance)},
        }
    if scene.sun:
        parts["sun"] = {
            "type": "directional",
            "direction": list(scene.sun.direction),
            "irradiance": rgb(scene.sun.irradiance),
        }
    if scene.sky:
        parts["sky"] = {"type": "constant", "radiance": rgb(scene.sky)}
    return mitsuba.load_dict(parts)


def main() -> None:
    parser = arguments("Renders a scene with Mitsuba.")
    parser.add_argument("--dense", type=Path, help="the grid, from dense_grid.py")
    options = parser.parse_args()
    drjit.set_thread_count(options.threads)
    built = build(scenes.load(options.scene, options.size), options.dense)
    numpy.array(mitsuba.render(built, spp=1, seed=987_654))
    with Meter() as meter:
        picture = numpy.array(mitsuba.render(built, spp=options.rays, seed=options.seed))
    mitsuba.Bitmap(picture).write(str(options.out))
    meter.report(options.out)


if __name__ == "__main__":
    main()
