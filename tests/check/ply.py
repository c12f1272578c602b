"""Corners of the meshes that fogbow writes, for the checks of shots."""

import numpy as np


def mesh_corners(path):
    with open(path, "rb") as file:
        head, body = file.read().split(b"end_header\n", 1)
    lines = head.decode().split("\n")
    count = next(int(line.split()[-1]) for line in lines if line.startswith("element vertex"))
    width = sum(line.startswith("property float") for line in lines)
    return np.frombuffer(body, "<f4", count * width).reshape(count, width)[:, :3].astype(float)
