"""Makes the picture of the guide's page on shots: one shot in Blender, by Cycles and by fogbow, side by side.

    python3.13 tests/check/usd_figure.py FOLDER FOGBOW PICTURE.png
"""

import math
import os
import sys

import bpy
import numpy as np

sys.path.insert(0, os.path.dirname(__file__))
import usd  # noqa: E402

WIDTH, HEIGHT = 232, 174
#: Samples of Cycles and rays of fogbow, a pixel.
SAMPLES = 512
#: Mean radiance that becomes middle grey, over that of the pictures.
EXPOSURE = 0.9


def painted(name, color, metal, roughness):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    node = material.node_tree.nodes["Principled BSDF"]
    node.inputs["Base Color"].default_value = (*color, 1)
    node.inputs["Metallic"].default_value = metal
    node.inputs["Roughness"].default_value = roughness
    node.inputs["IOR"].default_value = 1.5
    bpy.context.object.data.materials.append(material)


def make(folder):
    """A head of plastic, a ball of metal and a plume of smoke on a floor."""
    scene = usd.begin()
    usd.hook()
    scene.render.resolution_x, scene.render.resolution_y = WIDTH, HEIGHT
    scene.cycles.samples = SAMPLES
    bpy.ops.mesh.primitive_plane_add(size=30)
    painted("Floor", (0.35, 0.33, 0.3), 0, 0.9)
    bpy.ops.mesh.primitive_monkey_add(size=1.7, location=(-1.35, 0.1, 0.85), rotation=(-0.3, 0, 0.35))
    head = bpy.context.object
    head.modifiers.new("Smooth", "SUBSURF").levels = 2
    bpy.ops.object.modifier_apply(modifier="Smooth")
    bpy.ops.object.shade_smooth()
    painted("Plastic", (0.55, 0.05, 0.03), 0, 0.3)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=96, ring_count=48, radius=0.6, location=(1.7, -0.3, 0.6))
    bpy.ops.object.shade_smooth()
    painted("Brass", (0.9, 0.65, 0.3), 1, 0.35)
    volume = bpy.data.volumes.new("Smoke")
    volume.filepath = os.path.join(folder, "smoke_0001.vdb")
    usd.principled(volume, density=8, color=(0.8, 0.8, 0.8), anisotropy=0.3)
    smoke = usd.link(scene, "Smoke", volume, (0.3, 0.7, 0), (math.pi / 2, 0, 0.4))
    smoke.scale = (1.2, 1.2, 1.2)
    usd.lamp(scene, "AREA", (3, -3, 4), (0.75, 0, 0.75), energy=350, shape="RECTANGLE", size=1.5, size_y=1.5,
             color=(1, 0.85, 0.7))
    usd.sky(scene, (0.45, 0.6, 0.9), 0.35)
    usd.camera(scene, (0.15, -8, 1.9), (math.radians(84), 0, 0), 42)
    scene.cycles.max_bounces = 32
    scene.cycles.diffuse_bounces = scene.cycles.glossy_bounces = 32
    scene.cycles.volume_bounces = 32
    scene.cycles.volume_biased = False
    usd.export(folder, "figure")
    scene.render.filepath = os.path.join(folder, "figure.exr")
    bpy.ops.render.render(write_still=True)


def display(light):
    """sRGB codes of linear light."""
    light = np.clip(light, 0, 1)
    codes = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    return np.round(codes * 255) / 255


def main(folder, fogbow, picture):
    make(folder)
    ours = os.path.join(folder, "figure_fogbow.exr")
    size = ["--size", f"{WIDTH}x{HEIGHT}"]
    usd.run([fogbow, "render", os.path.join(folder, "figure.usdc"), "-o", ours, *size, "--quiet",
             "--rays", str(SAMPLES), "--photons", "4000000"])
    both = [usd.rgb(os.path.join(folder, "figure.exr")), usd.rgb(ours)]
    for name, light in zip(["Cycles", "fogbow"], both):
        print(name, "mean radiance", light.mean((0, 1)))
    scale = 0.18 / both[0].mean() / EXPOSURE
    gap = np.ones((HEIGHT, 8, 3))
    codes = np.concatenate([display(both[0] * scale), gap, display(both[1] * scale)], 1)
    image = bpy.data.images.new("Both", codes.shape[1], HEIGHT)
    image.colorspace_settings.name = "Non-Color"
    rows = np.concatenate([codes[::-1], np.ones((*codes.shape[:2], 1))], -1)
    image.pixels = rows.ravel().tolist()
    settings = bpy.context.scene.render.image_settings
    settings.file_format, settings.color_mode, settings.compression = "PNG", "RGB", 100
    bpy.context.scene.view_settings.view_transform = "Raw"
    image.save_render(picture)


if __name__ == "__main__":
    main(*sys.argv[1:])
