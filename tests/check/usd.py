"""Makes shots in Blender, exports them and renders them by Cycles (`make FOLDER`), and holds what fogbow makes of
the files against them (`compare FOLDER FOGBOW`); called by usd.sh, which names what it needs."""

import contextlib
import glob
import json
import math
import os
import subprocess
import sys
import tomllib

import numpy as np

import bpy
import OpenEXR

sys.path[:0] = glob.glob(
    os.path.join(bpy.utils.resource_path("LOCAL"), "python", "lib", "python3*", "site-packages")
)
from ply import mesh_corners  # noqa: E402
from bpy_extras.object_utils import world_to_camera_view  # noqa: E402
from mathutils import Vector  # noqa: E402

ENDINGS = ["usda", "usdc", "usdz"]
SIZE = 48
#: Largest relative differences of mean radiance: of lights on a white plane, of smoke.
LIGHTS, SMOKE = 0.02, 0.03
#: Largest distance of a corner, in pixels.
CORNER = 0.5
#: Shift of the lens, in widths of the picture, and clipping distances, in metres.
SHIFT, CLIP = (0.06, -0.04), (0.5, 60)
#: Squares before, between and behind clipping distances: distance and grey.
SQUARES, BETWEEN = [(1.5, 0.9), (6, 0.5), (12, 0.9)], (2, 9)


def begin():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, 3
    scene.render.engine = "CYCLES"
    scene.render.resolution_x = scene.render.resolution_y = SIZE
    scene.render.resolution_percentage = 100
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.cycles.samples = 256
    scene.cycles.use_adaptive_sampling = False
    scene.cycles.use_denoising = False
    scene.cycles.pixel_filter_type = "BOX"
    scene.cycles.sample_clamp_direct = scene.cycles.sample_clamp_indirect = 0
    return scene


def link(scene, name, data, place=(0, 0, 0), turn=(0, 0, 0)):
    thing = bpy.data.objects.new(name, data)
    scene.collection.objects.link(thing)
    thing.location, thing.rotation_euler = place, turn
    return thing


def camera(scene, place, turn, lens=50):
    data = bpy.data.cameras.new("Camera")
    data.lens = lens
    scene.camera = link(scene, "Camera", data, place, turn)
    return scene.camera


def plane(scene, size, grey):
    bpy.ops.mesh.primitive_plane_add(size=size)
    material = bpy.data.materials.new("White")
    material.use_nodes = True
    node = material.node_tree.nodes["Principled BSDF"]
    node.inputs["Base Color"].default_value = (grey, grey, grey, 1)
    # Diffuse alone, as fogbow has it.
    node.inputs["Specular IOR Level"].default_value = 0
    node.inputs["Roughness"].default_value = 1
    bpy.context.object.data.materials.append(material)


def lamp(scene, kind, place, turn, **values):
    data = bpy.data.lights.new(kind.title(), kind)
    for name, value in values.items():
        setattr(data, name, value)
    link(scene, kind.title(), data, place, turn)


def sky(scene, color, strength):
    world = bpy.data.worlds.new("World")
    scene.world = world
    world.use_nodes = True
    node = world.node_tree.nodes["Background"]
    node.inputs["Color"].default_value = (*color, 1)
    node.inputs["Strength"].default_value = strength
    return world


def sky_picture(scene, folder):
    """A sky with one bright quarter, above the horizon."""
    # At strength 1: Blender leaves that of a picture out of the file.
    world = sky(scene, (1, 1, 1), 1.0)
    path = os.path.join(folder, "sky_in.exr")
    pixels = np.full((32, 64, 3), 0.05, np.float32)
    pixels[2:14, 8:20] = (1.0, 0.6, 0.2)
    OpenEXR.File({}, {"RGB": pixels}).write(path)
    tree = world.node_tree
    node = tree.nodes.new("ShaderNodeTexEnvironment")
    node.image = bpy.data.images.load(path)
    node.interpolation = "Closest"
    tree.links.new(node.outputs["Color"], tree.nodes["Background"].inputs["Color"])


LAMPS = {
    "area": lambda s, f: lamp(
        s, "AREA", (1, -1, 3), (0.3, 0.4, 0.2), energy=100, shape="RECTANGLE", size=1, size_y=2,
        color=(1, 0.8, 0.6)),
    "disk": lambda s, f: lamp(s, "AREA", (-1, 0, 3), (0, -0.3, 0), energy=100, shape="DISK", size=1.5),
    "ball": lambda s, f: lamp(s, "POINT", (1, 1, 3), (0, 0, 0), energy=80, shadow_soft_size=0.4),
    "point": lambda s, f: lamp(s, "POINT", (1, 1, 3), (0, 0, 0), energy=80, shadow_soft_size=0),
    "spot": lambda s, f: lamp(
        s, "SPOT", (0, -2, 3), (0.5, 0, 0), energy=200, spot_size=1.2, spot_blend=0.3,
        shadow_soft_size=0.05),
    "sun": lambda s, f: lamp(s, "SUN", (0, 0, 9), (0.3, 0.5, 0), energy=2, angle=0.1),
    "sky": lambda s, f: sky(s, (0.2, 0.3, 0.5), 0.7),
    "picture": sky_picture,
}


def hook():
    path = os.path.join("volumes", "blender", "fogbow_usd_hook.py")
    with open(path) as text:
        exec(compile(text.read(), path, "exec"), {"__name__": "__main__"})


def export(folder, name):
    for ending in ENDINGS:
        bpy.ops.wm.usd_export(filepath=os.path.join(folder, f"{name}.{ending}"), export_animation=True)


def make(folder):
    for name, add in LAMPS.items():
        scene = begin()
        # Below the lamps: fogbow's camera sees them, and that of Cycles does not.
        camera(scene, (0, -0.2, 2), (0.08, 0, 0))
        plane(scene, 40, 0.5)
        add(scene, folder)
        scene.cycles.max_bounces = 0
        export(folder, name)
        scene.render.filepath = os.path.join(folder, f"{name}.exr")
        bpy.ops.render.render(write_still=True)
    clipped(folder)
    shot(folder)


def clipped(folder):
    """Squares of which clipping distances and a shift leave part of one in the picture."""
    scene = begin()
    eye = camera(scene, (0, 0, 0), (math.pi / 2, 0, 0), lens=30)
    eye.data.shift_x, eye.data.shift_y = 0.3, -0.2
    eye.data.clip_start, eye.data.clip_end = BETWEEN
    for distance, grey in SQUARES:
        plane(scene, distance, grey)
        square = bpy.context.object
        square.location, square.rotation_euler = (0.4, distance, 0.2), (math.pi / 2, 0, 0)
    lamp(scene, "SUN", (0, 0, 9), (1.2, 0, 0), energy=2, angle=0.1)
    sky(scene, (0.2, 0.3, 0.5), 0.7)
    scene.cycles.max_bounces = 0
    export(folder, "clipped")
    scene.render.filepath = os.path.join(folder, "clipped.exr")
    bpy.ops.render.render(write_still=True)


def principled(volume, density, color, anisotropy):
    """Gives a volume a Principled Volume."""
    material = bpy.data.materials.new("Smoke")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    node = tree.nodes.new("ShaderNodeVolumePrincipled")
    tree.links.new(node.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs["Volume"])
    node.inputs["Density"].default_value = density
    node.inputs["Color"].default_value = (*color, 1)
    node.inputs["Anisotropy"].default_value = anisotropy
    volume.materials.append(material)


def shot(folder):
    """A sequence of smoke, a cube, and a camera that moves."""
    scene = begin()
    hook()
    volume = bpy.data.volumes.new("Smoke")
    volume.filepath = os.path.join(folder, "smoke_0001.vdb")
    volume.is_sequence, volume.frame_duration, volume.frame_start = True, 3, 1
    principled(volume, density=6, color=(0.9, 0.8, 0.7), anisotropy=0.4)
    link(scene, "Smoke", volume, (0, 0, 0), (math.pi / 2, 0, 0.4))
    lamp(scene, "SUN", (0, 0, 9), (0.6, 0.5, 0), energy=3, angle=0.1)
    sky(scene, (0.2, 0.3, 0.5), 0.5)
    bpy.ops.mesh.primitive_cube_add(size=0.6, location=(1.6, 0.3, 0.4), rotation=(0.2, 0.5, 0.3))
    cube = bpy.context.object
    eye = camera(scene, (0, -9, 2), (math.pi / 2, 0, 0))
    eye.data.shift_x, eye.data.shift_y = SHIFT
    eye.data.clip_start, eye.data.clip_end = CLIP
    for frame, across in [(1, 0.0), (3, 1.5)]:
        eye.location.x, eye.rotation_euler.z = across, 0.12 * across
        eye.keyframe_insert("location", frame=frame)
        eye.keyframe_insert("rotation_euler", frame=frame)
    scene.cycles.max_bounces = scene.cycles.volume_bounces = 64
    scene.cycles.volume_biased = False
    export(folder, "shot")
    corners = {}
    for frame in [1, 2, 3]:
        scene.frame_set(frame)
        places = [cube.matrix_world @ v.co for v in cube.data.vertices]
        seen = [world_to_camera_view(scene, scene.camera, Vector(p)) for p in places]
        corners[frame] = [[p.x * SIZE, (1 - p.y) * SIZE] for p in seen]
        cube.hide_render = True
        scene.render.filepath = os.path.join(folder, f"shot_{frame}.exr")
        bpy.ops.render.render(write_still=True)
        cube.hide_render = False
    # Without the cube, which is white in Cycles and not black where it is seen.
    bpy.data.objects.remove(cube)
    export(folder, "smoke_alone")
    with open(os.path.join(folder, "corners.json"), "w") as out:
        json.dump(corners, out)


def rgb(path):
    channels = OpenEXR.File(path, separate_channels=True).channels()
    names = {name.rsplit(".", 1)[-1]: name for name in channels if "." not in name or "Combined" in name}
    return np.stack([channels[names[c]].pixels.astype(float) for c in "RGB"], -1)


def channel(path, name):
    return OpenEXR.File(path, separate_channels=True).channels()[name].pixels


def run(command):
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{' '.join(command)}: {done.stderr}")
    return done.stderr


def projected(scene, corner):
    """Where a corner is in the picture, by the camera of an exported scene."""
    eye = scene["camera"]
    place, target, up = (np.array(eye[key]) for key in ["position", "target", "up"])
    ahead = (target - place) / np.linalg.norm(target - place)
    right = np.cross(ahead, up)
    right /= np.linalg.norm(right)
    seen = corner - place
    pixel = 2 * math.tan(math.radians(eye["fov"]) / 2) / SIZE
    depth = seen @ ahead
    across, upward = seen @ right / depth, seen @ np.cross(right, ahead) / depth
    rightward, up = eye.get("shift", [0, 0])
    return np.array([SIZE * (0.5 - rightward) + across / pixel, SIZE * (0.5 + up) - upward / pixel])


def compare(folder, fogbow):
    wrong = 0

    def judge(what, found, most):
        nonlocal wrong
        wrong += not found <= most
        print(f"{what}: {found:.4f}, at most {most}" + ("" if found <= most else "  WRONG"))

    size = ["--size", f"{SIZE}x{SIZE}", "--quiet"]
    for name in [*LAMPS, "clipped"]:
        truth = rgb(os.path.join(folder, f"{name}.exr")).mean((0, 1))
        for ending in ENDINGS:
            out = os.path.join(folder, f"{name}_{ending}.exr")
            command = [fogbow, "render", os.path.join(folder, f"{name}.{ending}"), "-o", out, *size]
            run([*command, "--reference", "--rays", "256", "--max-scatter", "1"])
            found = rgb(out).mean((0, 1))
            judge(f"{name}.{ending}: mean radiance", np.abs(found / truth - 1).max(), LIGHTS)
    with open(os.path.join(folder, "corners.json")) as file:
        corners = json.load(file)
    for ending in ENDINGS:
        for frame in [1, 2, 3]:
            scene_file = os.path.join(folder, f"{ending}_{frame}.toml")
            run([fogbow, "export", os.path.join(folder, f"shot.{ending}"), "-o", scene_file,
                 "--frame", str(frame), "--quiet"])
            with open(scene_file, "rb") as file:
                scene = tomllib.load(file)
            cube = next(s for s in scene["surface"])
            places = mesh_corners(os.path.join(folder, cube["file"]))
            found = np.array([projected(scene, place) for place in places])
            known = np.array(corners[str(frame)])
            distance = np.linalg.norm(found[:, None] - known[None], axis=-1)
            told = np.subtract(scene["camera"]["shift"] + scene["camera"]["clip"], SHIFT + CLIP)
            judge(f"shot.{ending}, frame {frame}: shift and clipping distances",
                  np.abs(told).max(), 1e-5)
            judge(f"shot.{ending}, frame {frame}: corners, pixels",
                  max(distance.min(0).max(), distance.min(1).max()), CORNER)
        out = os.path.join(folder, f"{ending}_####.exr")
        run([fogbow, "render", os.path.join(folder, f"smoke_alone.{ending}"), "--frames", "1-3",
             "-o", out, *size, "--reference", "--rays", "256"])
        for frame in [1, 2, 3]:
            picture = out.replace("####", f"{frame:04}")
            smoke = channel(picture, "A") > 0.1
            truth = rgb(os.path.join(folder, f"shot_{frame}.exr"))[smoke].mean(0)
            found = rgb(picture)[smoke].mean(0)
            judge(f"smoke.{ending}, frame {frame}: mean radiance", np.abs(found / truth - 1).max(), SMOKE)
    sys.exit(int(wrong > 0))


if __name__ == "__main__":
    with contextlib.chdir("."):
        {"make": make, "compare": compare}[sys.argv[1]](*sys.argv[2:])
