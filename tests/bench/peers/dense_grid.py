#!/usr/bin/env python3
"""Writes the density grid of a VDB file as a dense array, for Mitsuba, by OpenVDB inside bpy."""

import argparse
import sys
from pathlib import Path

import bpy
import numpy

sys.path += map(
    str, Path(bpy.utils.resource_path("LOCAL")).glob("python/lib/python3*/site-packages")
)
import openvdb  # noqa: E402


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("vdb", type=Path)
    parser.add_argument("npz", type=Path)
    parser.add_argument("--grid", default="density")
    options = parser.parse_args()
    grid = openvdb.read(str(options.vdb), options.grid)
    low, high = grid.evalActiveVoxelBoundingBox()
    low = numpy.array(low) - 1  # a layer of background all around, to which values fall off
    density = numpy.zeros(numpy.array(high) + 2 - low, dtype=numpy.float32)
    grid.copyToArray(density, ijk=tuple(int(i) for i in low))
    voxel = grid.transform.voxelSize()
    origin = numpy.array(grid.transform.indexToWorld(tuple(float(i) for i in low)))
    step = numpy.array(grid.transform.indexToWorld(tuple(float(i) + 1 for i in low))) - origin
    if max(voxel) - min(voxel) > 1e-6 * voxel[0] or not numpy.allclose(step, voxel[0]):
        raise SystemExit(f"{options.vdb}: wants cubic voxels along the axes, found steps of {step}")
    numpy.savez(options.npz, density=density, origin=origin, voxel=voxel[0])


if __name__ == "__main__":
    main()
