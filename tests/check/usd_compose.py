"""Holds corners of meshes and the camera of a composed stage, as fogbow exports them, against usd-core; called by
usd.sh with a folder and the program."""

import os
import subprocess
import sys
import tomllib

import numpy as np
from ply import mesh_corners
from pxr import Usd, UsdGeom

PART = """#usda 1.0
( defaultPrim = "part" )
def Xform "part" (
    variantSets = "size"
    variants = {
        string size = "small"
    }
)
{
    double3 xformOp:translate.timeSamples = { 0: (0, 0, 0), 10: (0, 30, 0) }
    uniform token[] xformOpOrder = ["xformOp:translate"]
    def Mesh "roof" (inherits = </_shape>)
    {
        float3 xformOp:scale = (1, 2, 3)
        uniform token[] xformOpOrder = ["xformOp:scale"]
    }
    variantSet "size" = {
        "small" {
            def Mesh "box" (inherits = </_shape>)
            {
            }
        }
        "large" {
            def Mesh "box" (inherits = </_shape>)
            {
                float xformOp:rotateZ = 30
                double3 xformOp:translate = (4, 0, 0)
                uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateZ"]
            }
        }
    }
}
class Mesh "_shape"
{
    int[] faceVertexCounts = [4, 4]
    int[] faceVertexIndices = [0, 1, 2, 3, 3, 2, 4, 5]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (1, 1, 1), (0, 1, 1)]
    uniform token subdivisionScheme = "none"
}
"""

WEAK = """#usda 1.0
over "set"
{
    over "a" (
        variants = {
            string size = "large"
        }
    )
    {
    }
    def Xform "late" (
        payload = @./part.usda@ (offset = 1; scale = 2)
    )
    {
    }
}
"""

ROOT = """#usda 1.0
(
    subLayers = [@./weak.usda@]
    upAxis = "Z"
    metersPerUnit = 0.01
    startTimeCode = 1
    endTimeCode = 3
)
def Xform "set"
{
    float3 xformOp:rotateXYZ = (10, 20, 30)
    double3 xformOp:translate:pivot = (1, 2, 3)
    uniform token[] xformOpOrder = ["xformOp:translate:pivot", "xformOp:rotateXYZ", "!invert!xformOp:translate:pivot"]
    def "a" (
        references = @./part.usda@
    )
    {
    }
    def "b" (
        instanceable = true
        references = @./part.usda@
        variants = {
            string size = "large"
        }
    )
    {
        double3 xformOp:translate = (0, 0, 50)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
    def "off" (
        references = @./part.usda@
    )
    {
        token visibility = "invisible"
    }
    def "gone" (
        active = false
        references = @./part.usda@
    )
    {
    }
    def Camera "eye"
    {
        matrix4d xformOp:transform.timeSamples = {
            1: ( (1, 0, 0, 0), (0, 0, 1, 0), (0, -1, 0, 0), (0, -100, 10, 1) ),
            3: ( (1, 0, 0, 0), (0, 0, 1, 0), (0, -1, 0, 0), (40, -100, 10, 1) ) }
        uniform token[] xformOpOrder = ["xformOp:transform"]
    }
}
"""


def here(place):
    """From centimetres with z up to metres with y up."""
    x, y, z = place
    return [0.01 * x, 0.01 * z, -0.01 * y]


def main(folder, fogbow):
    for name, text in [("part.usda", PART), ("weak.usda", WEAK), ("root.usda", ROOT)]:
        with open(os.path.join(folder, name), "w") as out:
            out.write(text)
    path = os.path.join(folder, "root.usda")
    stage = Usd.Stage.Open(path)
    for frame in [1, 2, 3]:
        known, eye = [], None
        for prim in stage.Traverse(Usd.TraverseInstanceProxies()):
            to_world = UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(frame)
            shown = UsdGeom.Imageable(prim).ComputeVisibility(frame) != "invisible"
            if prim.IsA(UsdGeom.Mesh) and shown:
                points = UsdGeom.Mesh(prim).GetPointsAttr().Get(frame)
                known += [here(to_world.Transform(p)) for p in points]
            if prim.IsA(UsdGeom.Camera):
                eye = here(to_world.ExtractTranslation())
        scene_file = os.path.join(folder, f"composed_{frame}.toml")
        command = [fogbow, "export", path, "-o", scene_file, "--frame", str(frame), "--quiet"]
        subprocess.run(command, check=True)
        with open(scene_file, "rb") as file:
            scene = tomllib.load(file)
        found = np.concatenate([mesh_corners(os.path.join(folder, s["file"])) for s in scene["surface"]])
        known = np.array(known)
        distance = np.linalg.norm(found[:, None] - known[None], axis=-1)
        farthest = max(distance.min(0).max(), distance.min(1).max())
        off = np.abs(np.array(scene["camera"]["position"]) - eye).max()
        good = len(found) == len(known) and farthest < 1e-5 and off < 1e-9
        print(f"composed, frame {frame}: {len(found)} of {len(known)} corners, {farthest:.1e} m off, camera {off:.1e} m"
              + ("" if good else "  WRONG"))
        if not good:
            sys.exit(1)


main(*sys.argv[1:])
