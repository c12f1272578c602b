#!/usr/bin/env python3
"""Renders a scene with fogbow, and measures the process.

The CPU seconds are those of the process without what comes before and after rendering: its start,
loading, writing and its end. These run on one thread and are known in wall seconds only; on a busy
machine every stage gets the same part of the CPU it could use, so the part of theirs follows from
wall seconds.
"""

import json
import os
import subprocess
import time
from pathlib import Path

import scene as scenes
from measure import arguments, write_report

APART = ("load", "write")


def numbers(vector: scenes.Vector) -> str:
    return "[" + ", ".join(repr(float(x)) for x in vector) + "]"


def quad(quad: scenes.Quad) -> str:
    return f"center = {numbers(quad.center)}\nu = {numbers(quad.u)}\nv = {numbers(quad.v)}\n"


def extent(volume: scenes.Volume) -> str:
    if isinstance(volume.within, scenes.Box):
        low, high = numbers(volume.within.low), numbers(volume.within.high)
        return f"region = {{ box = {{ min = {low}, max = {high} }} }}\n"
    return f"file = {json.dumps(str(volume.within))}\ngrid = {json.dumps(volume.grid)}\n"


def to_toml(scene: scenes.Scene) -> str:
    """The scene as fogbow reads it."""
    camera, volume = scene.camera, scene.volume
    phase = f'{{ type = "henyey-greenstein", g = {volume.g} }}' if volume.g else '"isotropic"'
    parts = [
        f"[camera]\nposition = {numbers(camera.position)}\ntarget = {numbers(camera.target)}\n"
        f"fov = {camera.fov}\n",
        f"[film]\nsize = [{scene.size}, {scene.size}]\n",
        f"[[medium]]\n{extent(volume)}"
        f"sigma_t = {volume.sigma_t}\nalbedo = {volume.albedo}\nphase = {phase}\n",
    ]
    if scene.ground:
        parts.append(
            f'[[surface]]\nshape = "quad"\n{quad(scene.ground.quad)}'
            f'material = {{ type = "diffuse", reflectance = {scene.ground.reflectance} }}\n'
        )
    if scene.area_light:
        light = scene.area_light
        parts.append(
            f'[[light]]\ntype = "area"\n{quad(light.quad)}radiance = {light.radiance}\nvisible = false\n'
        )
    if scene.sun:
        parts.append(
            f'[[light]]\ntype = "sun"\ndirection = {numbers(scene.sun.direction)}\n'
            f"irradiance = {scene.sun.irradiance}\nangle = 0.0\n"
        )
    if scene.sky:
        parts.append(f'[[light]]\ntype = "environment"\nradiance = {scene.sky}\n')
    return "\n".join(parts)


def of_rendering(cpu: float, wall: float, rendering: float, threads: int) -> float:
    """The CPU seconds that are of rendering, of a process that took `wall` seconds in all."""
    apart = wall - rendering
    return cpu * threads * rendering / (threads * rendering + apart)


def main() -> None:
    parser = arguments("Renders a scene with fogbow.")
    parser.add_argument("--fogbow", required=True, help="the program")
    parser.add_argument("--denoiser", required=True, help="library that it denoises with")
    parser.add_argument("--photons", type=int)
    methods = (
        "fixed",
        "fixed-reconstructed",
        "fixed-oidn",
        "xs",
        "xs-oidn",
        "reference",
        "reference-oidn",
    )
    parser.add_argument("--method", choices=methods, required=True)
    options = parser.parse_args()
    scene_file: Path = options.out.with_suffix(".toml")
    scene_file.write_text(to_toml(scenes.load(options.scene, options.size)))
    command = [
        options.fogbow,
        "render",
        str(scene_file),
        "-o",
        str(options.out),
        "--json",
        "--quiet",
    ]
    command += ["--rays", str(options.rays), "--seed", str(options.seed)]
    command += ["--threads", str(options.threads)]
    way, _, after = options.method.partition("-")
    if way == "reference":
        command += ["--reference"]
    else:
        command += ["--director", way, "--photons", str(options.photons)]
    command += {"": [], "oidn": ["--denoise"], "reconstructed": ["--reconstruct"]}[after]
    found = os.environ | {
        "FOGBOW_OIDN": options.denoiser,
        "OIDN_NUM_THREADS": str(options.threads),
    }
    start = time.perf_counter()
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=found)
    printed = process.stdout.read()
    _, status, usage = os.wait4(process.pid, 0)
    wall = time.perf_counter() - start
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise SystemExit(f"fogbow failed with exit code {process.returncode}: {' '.join(command)}")
    told = json.loads(printed)
    rendering = sum(seconds for stage, seconds in told["seconds"].items() if stage not in APART)
    write_report(
        options.out,
        cpu_s=of_rendering(usage.ru_utime + usage.ru_stime, wall, rendering, options.threads),
        wall_s=rendering,
        peak_mib=usage.ru_maxrss / 1024,
    )


if __name__ == "__main__":
    main()
