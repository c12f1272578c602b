"""Renders smoke that velocities move by Cycles and by fogbow, and holds the pictures against each other (`FOLDER FOGBOW`);
called by motion.sh, which names what it needs."""

import math
import os
import sys

import numpy as np

import bpy

from usd import begin, camera, link, principled, rgb, run, sky

SIZE = 64
FIELDS = ["wind", "spin"]
#: Largest mean difference of two pictures, relative to what blur changes.
ALIKE = 0.25
#: Largest relative difference of their means.
MEANS = 0.03

SCENE = """
[camera]
position = [0, 0, 6]
target = [0, 0, 0]
fov = 32
[film]
size = [{size}, {size}]
exposure = 0.0
[render]
rays = 128
photons = 400000
[motion]
shutter = {shutter}
fps = 1
[[medium]]
file = "{name}.vdb"
sigma_t = 3.0
albedo = 0.8
[[light]]
type = "environment"
radiance = 1.0
visible = false
"""


def by_cycles(folder, name, shutter):
    scene = begin()
    scene.render.resolution_x = scene.render.resolution_y = SIZE
    scene.render.film_transparent = True
    scene.cycles.max_bounces = scene.cycles.volume_bounces = 64
    scene.cycles.volume_biased = False
    volume = bpy.data.volumes.new("Smoke")
    volume.filepath = os.path.join(folder, f"{name}.vdb")
    volume.velocity_grid, volume.velocity_unit, volume.velocity_scale = "vel", "FRAME", 1.0
    principled(volume, density=3, color=(0.8, 0.8, 0.8), anisotropy=0)
    link(scene, "Smoke", volume)
    sky(scene, (1, 1, 1), 1.0)
    eye = camera(scene, (0, 0, 6), (0, 0, 0))
    eye.data.angle = math.radians(32)
    scene.render.use_motion_blur = shutter > 0
    if shutter > 0:
        scene.render.motion_blur_shutter = shutter
        scene.render.motion_blur_position = "CENTER"
    path = os.path.join(folder, f"{name}_{shutter}_cycles.exr")
    scene.render.filepath = path
    bpy.ops.render.render(write_still=True)
    return rgb(path)


def by_fogbow(folder, fogbow, name, shutter):
    text = SCENE.format(size=SIZE, shutter=shutter, name=name)
    scene = os.path.join(folder, f"{name}.toml")
    with open(scene, "w") as out:
        out.write(text)
    path = os.path.join(folder, f"{name}_{shutter}_fogbow.exr")
    run([fogbow, "render", scene, "-o", path, "--quiet"])
    return rgb(path)


def save(path, rows):
    """A PNG of rows of pictures, each pixel four."""
    picture = np.concatenate([np.concatenate(row, 1) for row in rows], 0)
    picture = picture.repeat(2, 0).repeat(2, 1)
    height, width, _ = picture.shape
    image = bpy.data.images.new("rows", width, height, float_buffer=False)
    shown = np.clip(picture, 0, 1) ** (1 / 2.2)
    pixels = np.concatenate([shown, np.ones((height, width, 1))], 2)[::-1]
    image.pixels = pixels.astype(np.float32).ravel()
    image.filepath_raw, image.file_format = path, "PNG"
    image.save()


def main(folder, fogbow):
    wrong = 0
    for name in FIELDS:
        pictures = [[by_cycles(folder, name, s) for s in (0, 1)], [by_fogbow(folder, fogbow, name, s) for s in (0, 1)]]
        save(os.path.join(folder, f"{name}.png"), pictures)
        (cycles_sharp, cycles), (our_sharp, ours) = pictures
        change = np.abs(cycles - cycles_sharp).mean()
        for what, a, b in [("sharp", our_sharp, cycles_sharp), ("blurred", ours, cycles)]:
            apart, mean = np.abs(a - b).mean() / change, a.mean() / b.mean() - 1
            fits = apart <= ALIKE and abs(mean) <= MEANS
            wrong += not fits
            print(f"{name}, {what}: differs by {apart:.3f} of what blur changes, in the mean by {mean:+.4f}" + ("" if fits else "  WRONG"))
    sys.exit(wrong > 0)


main(*sys.argv[1:3])
