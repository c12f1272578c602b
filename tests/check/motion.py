"""Renders smoke that velocities move by fogbow and by Cycles, and holds fogbow's pictures against the mean of many sharp ones by
Cycles, of smoke that is moved or turned (`FOLDER FOGBOW`); called by motion.sh, which names what it needs. How far Cycles' own blur
is from that mean is told beside: its ends are brighter."""

import math
import os
import sys

import numpy as np

import bpy

from usd import begin, camera, link, principled, rgb, run, sky

SIZE = 64
#: What a field does with the smoke in a frame: moves it in metres, or turns it about the line of sight in radians.
FIELDS = {"wind": ((0.9, 0.5, 0), 0), "spin": ((0, 0, 0), 0.8)}
#: Sharp pictures of a mean.
PICTURES = 16
#: Largest mean difference of two pictures, relative to what blur changes.
ALIKE = 0.2
#: Largest relative difference of their means.
MEANS = 0.02

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


def by_cycles(folder, name, shutter, time=None):
    """Blurred by Cycles itself, or sharp so many frames later."""
    scene = begin()
    if time is not None:
        scene.cycles.samples = 64
    scene.render.resolution_x = scene.render.resolution_y = SIZE
    scene.render.film_transparent = True
    scene.cycles.max_bounces = scene.cycles.volume_bounces = 64
    scene.cycles.volume_biased = False
    volume = bpy.data.volumes.new("Smoke")
    volume.filepath = os.path.join(folder, f"{name}.vdb")
    volume.velocity_grid, volume.velocity_unit, volume.velocity_scale = "vel", "FRAME", 1.0
    principled(volume, density=3, color=(0.8, 0.8, 0.8), anisotropy=0)
    move, turn = FIELDS[name]
    later = time or 0
    link(scene, "Smoke", volume, [later * axis for axis in move], (0, 0, later * turn))
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


def coarse(picture):
    """Means of 4 x 4 pixels, which have little noise."""
    return picture.reshape(SIZE // 4, 4, SIZE // 4, 4, 3).mean((1, 3))


def main(folder, fogbow):
    wrong = 0
    for name in FIELDS:
        cycles_sharp, cycles = [by_cycles(folder, name, shutter) for shutter in (0, 1)]
        our_sharp, ours = [by_fogbow(folder, fogbow, name, shutter) for shutter in (0, 1)]
        times = [(k + 0.5) / PICTURES - 0.5 for k in range(PICTURES)]
        truth = np.mean([by_cycles(folder, name, 0, time) for time in times], 0)
        save(os.path.join(folder, f"{name}.png"), [[cycles_sharp, cycles, truth], [our_sharp, ours, ours]])
        change = np.abs(coarse(truth - cycles_sharp)).mean()
        for what, a, b, judged in [
            ("sharp", our_sharp, cycles_sharp, True),
            ("blurred", ours, truth, True),
            ("blurred by Cycles itself", cycles, truth, False),
        ]:
            apart, mean = np.abs(coarse(a - b)).mean() / change, a.mean() / b.mean() - 1
            fails = judged and (apart > ALIKE or abs(mean) > MEANS)
            wrong += fails
            print(
                f"{name}, {what}: differs by {apart:.3f} of what blur changes, in the mean by {mean:+.4f}"
                + ("  WRONG" if fails else "")
            )
    sys.exit(int(wrong > 0))


main(*sys.argv[1:3])
