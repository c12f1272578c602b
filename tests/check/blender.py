"""Writes smoke, fire and a coloured cloud into the folder that is named, by Blender's own OpenVDB where
the module bpy is found and by another Python module of OpenVDB otherwise; called by blender.sh."""

import glob
import importlib
import os
import sys

import numpy as np


def module():
    """OpenVDB, as Blender brings it or as the system has it."""
    try:
        import bpy

        folders = os.path.join(bpy.utils.resource_path("LOCAL"), "python", "lib", "python3*")
        sys.path += glob.glob(os.path.join(folders, "site-packages"))
        return importlib.import_module("openvdb")
    except ImportError:
        pass
    for name in ["pyopenvdb", "openvdb"]:
        try:
            return importlib.import_module(name)
        except ImportError:
            continue
    sys.exit("no Python module of OpenVDB")


vdb = module()
SIZE = 40
AT = np.stack(np.meshgrid(*3 * [np.linspace(-1, 1, SIZE)], indexing="ij"), -1)


def blob(centre, radius):
    """1 at a place, falling to 0 at a radius, with waves in it."""
    distance = np.linalg.norm(AT - centre, axis=-1) / radius
    waves = 0.8 + 0.2 * np.sin(9 * AT[..., 0]) * np.cos(7 * AT[..., 1] + 2 * AT[..., 2])
    return np.clip(1 - distance, 0, 1) * waves


def grid(kind, name, values):
    made = kind()
    made.copyFromArray(np.ascontiguousarray(values, np.float32))
    made.name = name
    made.transform = vdb.createLinearTransform(voxelSize=0.05)
    if kind is vdb.FloatGrid:
        made.gridClass = vdb.GridClass.FOG_VOLUME
    return made


smoke = blob(np.array([0, 0, -0.1]), 0.8)
flame = blob(np.array([0, 0, -0.4]), 0.4)
colour = np.stack([smoke, 0.5 * smoke + 0.1 * flame, 0.2 * smoke], -1)
files = {
    "smoke": [grid(vdb.FloatGrid, "density", 4 * smoke)],
    "fire": [
        grid(vdb.FloatGrid, "density", 2 * smoke),
        grid(vdb.FloatGrid, "temperature", 900 * smoke + 1200 * flame),
        grid(vdb.FloatGrid, "flame", flame),
    ],
    "cloud": [grid(vdb.FloatGrid, "density", 8 * smoke), grid(vdb.Vec3SGrid, "Cd", colour)],
}
for name, grids in files.items():
    vdb.write(os.path.join(sys.argv[1], name + ".vdb"), grids=grids)
print(f"OpenVDB {'.'.join(map(str, vdb.LIBRARY_VERSION))}, file format {vdb.FILE_FORMAT_VERSION}")
