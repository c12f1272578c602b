#!/usr/bin/env python3
"""Renders a scene with Cycles on the CPU: null scattering, or the biased march of Blender before
5.0, with or without Open Image Denoise.

Clamping, the light threshold and adaptive sampling are off and every limit of bounces is at its
highest (for volumes Blender's default is 0). An area light wants watts: radiance x area x pi.
"""

import math
from pathlib import Path

import bpy
import mathutils

import scene as scenes
from measure import Meter, arguments

METHODS = ("null-scattering", "biased", "biased-oidn")
MOST_BOUNCES = 1024  # Blender allows no more


def grey(value: float) -> list[float]:
    return [value] * 3 + [1.0]


def looking(position: scenes.Vector, direction: scenes.Vector) -> mathutils.Matrix:
    """The matrix of an object whose -z looks along `direction`, as cameras and lights do."""
    z = -mathutils.Vector(direction).normalized()
    up = (0.0, 1.0, 0.0) if abs(z.y) < 1.0 else (0.0, 0.0, 1.0)
    x = mathutils.Vector(up).cross(z).normalized()
    matrix = mathutils.Matrix((x, z.cross(x), z)).transposed().to_4x4()
    matrix.translation = mathutils.Vector(position)
    return matrix


def add(name: str, data: bpy.types.ID, matrix: mathutils.Matrix | None = None) -> bpy.types.Object:
    thing = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(thing)
    if matrix is not None:
        thing.matrix_world = matrix
    return thing


def material(name: str, shader: str, socket: str) -> tuple[bpy.types.Material, bpy.types.Node]:
    """A material of one shader node, and the node."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True  # bpy 5 warns that 6 will not need it
    tree = made.node_tree
    tree.nodes.clear()
    node = tree.nodes.new(shader)
    tree.links.new(node.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs[socket])
    return made, node


def add_camera(camera: scenes.Camera) -> None:
    data = bpy.data.cameras.new("camera")
    data.sensor_fit = "HORIZONTAL"
    data.angle = math.radians(camera.fov)
    data.clip_start, data.clip_end = 0.01, 1000.0
    direction = scenes.subtract(camera.target, camera.position)
    bpy.context.scene.camera = add("camera", data, looking(camera.position, direction))


def add_volume(volume: scenes.Volume) -> None:
    made, node = material("smoke", "ShaderNodeVolumePrincipled", "Volume")
    values = {
        "Color": grey(volume.albedo),
        "Density": volume.sigma_t,
        "Density Attribute": "" if isinstance(volume.within, scenes.Box) else volume.grid,
        "Anisotropy": volume.g,
        "Absorption Color": grey(0.0),
        "Emission Strength": 0.0,
        "Blackbody Intensity": 0.0,
        "Temperature Attribute": "",
    }
    for name, value in values.items():
        node.inputs[name].default_value = value
    if isinstance(volume.within, scenes.Box):
        data = cube(volume.within)
    else:
        data = bpy.data.volumes.new("smoke")
        data.filepath = str(volume.within)
    data.materials.append(made)
    add("smoke", data)


def cube(box: scenes.Box) -> bpy.types.Mesh:
    """The surface of a box, whose normals point outward."""
    data = bpy.data.meshes.new("box")
    corners = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    corners = [
        tuple((box.low, box.high)[side][axis] for axis, side in enumerate(c)) for c in corners
    ]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    data.from_pydata(corners, [], faces)
    data.update()
    return data


def add_area_light(light: scenes.AreaLight) -> None:
    data = bpy.data.lights.new("light", "AREA")
    data.shape = "SQUARE"
    data.size = math.sqrt(light.quad.area)
    data.energy = light.radiance * light.quad.area * math.pi
    data.spread = math.pi
    add("light", data, looking(light.quad.center, light.quad.normal))


def add_ground(ground: scenes.Ground) -> None:
    made, node = material("ground", "ShaderNodeBsdfDiffuse", "Surface")
    node.inputs["Color"].default_value = grey(ground.reflectance)
    node.inputs["Roughness"].default_value = 0.0
    data = bpy.data.meshes.new("ground")
    data.from_pydata(ground.quad.corners, [], [(0, 1, 2, 3)])
    data.update()
    data.materials.append(made)
    add("ground", data)


def add_sun(sun: scenes.Sun) -> None:
    data = bpy.data.lights.new("sun", "SUN")
    data.energy = sun.irradiance
    data.angle = 0.0
    add("sun", data, looking((0.0, 0.0, 0.0), sun.direction))


def add_sky(radiance: float) -> None:
    world = bpy.data.worlds.new("sky")
    world.use_nodes = True
    tree = world.node_tree
    tree.nodes.clear()
    node = tree.nodes.new("ShaderNodeBackground")
    node.inputs["Color"].default_value = grey(1.0)
    node.inputs["Strength"].default_value = radiance
    tree.links.new(node.outputs[0], tree.nodes.new("ShaderNodeOutputWorld").inputs["Surface"])
    bpy.context.scene.world = world


def build(scene: scenes.Scene) -> None:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    add_camera(scene.camera)
    add_volume(scene.volume)
    add_sky(scene.sky)  # a black one too: without a world Cycles 5.0 leaves out volumes
    if scene.area_light:
        add_area_light(scene.area_light)
    if scene.ground:
        add_ground(scene.ground)
    if scene.sun:
        add_sun(scene.sun)


def set_sampling(method: str, rays: int, seed: int) -> None:
    cycles = bpy.context.scene.cycles
    cycles.device = "CPU"
    cycles.samples = rays
    cycles.seed = seed
    cycles.use_adaptive_sampling = False
    cycles.use_denoising = method == "biased-oidn"
    cycles.denoiser = "OPENIMAGEDENOISE"
    for kind in ("max", "diffuse", "glossy", "transmission", "volume", "transparent_max"):
        setattr(cycles, f"{kind}_bounces", MOST_BOUNCES)
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    cycles.light_sampling_threshold = 0.0
    cycles.blur_glossy = 0.0
    cycles.use_guiding = False
    cycles.pixel_filter_type = "BOX"
    cycles.filter_width = 1.0
    cycles.volume_biased = method != "null-scattering"
    cycles.volume_max_steps = 65536


def set_output(size: int, threads: int) -> None:
    scene, render = bpy.context.scene, bpy.context.scene.render
    render.engine = "CYCLES"
    render.resolution_x = render.resolution_y = size
    render.resolution_percentage = 100
    render.film_transparent = False
    render.threads_mode = "FIXED"
    render.threads = threads
    render.use_persistent_data = False
    scene.view_settings.view_transform = "Raw"
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_mode = "RGB"
    render.image_settings.color_depth = "32"


def fixed_cost() -> Meter:
    """What a render takes that traces next to nothing: reading the grid, building, starting."""
    scene = bpy.context.scene
    size, rays = scene.render.resolution_x, scene.cycles.samples
    scene.render.resolution_x = scene.render.resolution_y = 8
    scene.cycles.samples = 1
    bpy.ops.render.render()
    with Meter() as meter:
        bpy.ops.render.render()
    scene.render.resolution_x = scene.render.resolution_y = size
    scene.cycles.samples = rays
    return meter


def main() -> None:
    parser = arguments("Renders a scene with Cycles.")
    parser.add_argument("--method", choices=METHODS, required=True)
    options = parser.parse_args()
    scene = scenes.load(options.scene, options.size)
    build(scene)
    set_sampling(options.method, options.rays, options.seed)
    set_output(scene.size, options.threads)
    fixed = fixed_cost()
    with Meter() as meter:
        bpy.ops.render.render()
    bpy.data.images["Render Result"].save_render(str(Path(options.out).resolve()))
    meter.report(options.out, fixed_cpu_s=fixed.cpu)


if __name__ == "__main__":
    main()
