#!/usr/bin/env python3
"""Compares the figures of `fogbow error` with those of independent programs.

    python3 -m venv .venv
    .venv/bin/pip install numpy OpenEXR scikit-image flip-evaluator==1.7 cvvdp==0.5.7
    cargo build --release
    .venv/bin/python tests/check/metrics.py target/release/fogbow

Four pairs of pictures are made from fixed seeds and written as EXR. numpy counts the errors of radiance and codes,
scikit-image SSIM, NVIDIA's flip-evaluator FLIP and its authors' package ColorVideoVDP. A figure that is off by more than 1e-4,
relatively, fails the check. The VDP has no second program to compare with; its tests are in src/study/metric/vdp/tests.rs. Of
the localised VDP numpy counts the bound, the share of pixels whose luminance differs; twenty bright pixels reach it.
"""
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import flip_evaluator
import numpy as np
import OpenEXR
import pycvvdp
import torch
from skimage.metrics import structural_similarity

TOLERANCE = 1e-4


def plume(height, width):
    """A grey glow over a dark ground, beyond white in its middle."""
    y, x = np.mgrid[0:height, 0:width] / max(height, width)
    glow = 3.0 * np.exp(-40 * ((x - 0.4) ** 2 + (y - 0.35) ** 2))
    return (glow + 0.05 * y)[..., None] * np.ones(3)


def texture(height, width):
    """Coloured stripes and a hard edge."""
    y, x = np.mgrid[0:height, 0:width] / 32.0
    stripes = [0.35 + 0.3 * np.sin(3 * x + y), 0.4 + 0.25 * np.sin(x * y), 0.3 + 0.2 * np.cos(5 * y)]
    return np.stack(stripes, -1) * np.where(x > 3, 1.0, 0.3)[..., None]


def blurred(image):
    padded = np.pad(image, ((1, 1), (1, 1), (0, 0)), "edge")
    rows = padded[:-2] + padded[1:-1] + padded[2:]
    return (rows[:, :-2] + rows[:, 1:-1] + rows[:, 2:]) / 9


def pairs():
    """(name, reference, test): noise with fireflies, blur, a shift of brightness with faint noise."""
    random = np.random.default_rng(4)
    reference = plume(200, 256)
    noisy = reference * random.gamma(8.0, 1 / 8.0, reference.shape[:2])[..., None]
    noisy[random.random(reference.shape[:2]) < 5e-4] += 20.0
    yield "noise", reference, noisy
    reference = texture(180, 170)
    yield "blur", reference, 0.99 * blurred(reference)
    reference = 0.5 * plume(131, 177) + 0.2 * texture(131, 177)
    yield "brightness", reference, np.abs(1.06 * reference + random.normal(0, 0.002, reference.shape))
    reference = np.linspace(0.2, 0.6, 512)[None, :, None] * np.ones((384, 1, 3))
    spoilt = reference.copy()
    spoilt.reshape(-1, 3)[random.choice(384 * 512, 20, replace=False)] *= 50.0
    yield "bright pixels", reference, spoilt


def write(path, image):
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with OpenEXR.File(header, {"RGB": np.ascontiguousarray(image)}) as file:
        file.write(str(path))


def srgb(linear):
    linear = np.clip(linear, 0, 1)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def expected(reference, test):
    r, t = reference.astype(np.float64), test.astype(np.float64)
    mse = np.mean((t - r) ** 2)
    epsilon = 0.5 * r.mean()
    relative = np.mean((t - r) ** 2, -1) / (r.mean(-1) ** 2 + epsilon**2)
    kept = int(relative.size * 0.999)
    codes_r, codes_t = (np.round(255 * srgb(image)) for image in (r, t))
    shown_r, shown_t = srgb(r), srgb(t)
    float_r, float_t = shown_r.astype(np.float32), shown_t.astype(np.float32)
    metric = pycvvdp.cvvdp(display_name="standard_4k", device=torch.device("cpu"))
    jod, _ = metric.predict(float_t, float_r, dim_order="HWC")
    return {
        "mse": mse,
        "rmse": np.sqrt(mse),
        "mae": np.mean(np.abs(t - r)),
        "mean_difference": np.mean(t - r),
        "mean_ratio": t.mean() / r.mean(),
        "epsilon": epsilon,
        "relative_mse": relative.mean(),
        "relative_mse_trimmed": np.sort(relative, None)[:kept].mean(),
        "code_mse_percent": 100 * np.mean((codes_t - codes_r) ** 2) / 255**2,
        "code_pixels_percent": 100 * np.mean(np.any(codes_t != codes_r, -1)),
        "ssim": structural_similarity(
            shown_r, shown_t, gaussian_weights=True, sigma=1.5, use_sample_covariance=False, data_range=1, channel_axis=-1
        ),
        "flip_ldr": flip_evaluator.evaluate(float_r, float_t, "LDR", inputsRGB=True)[1],
        "flip_hdr": flip_evaluator.evaluate(reference, test, "HDR")[1],
        "colorvideovdp_jod": jod.item(),
    }


def differing_percent(reference, test):
    """Pixels whose luminance on the display, 0.2 to 80 cd/m², differs by 1e-4 cd/m² or more."""
    r, t = (79.8 * np.clip(image.astype(np.float64), 0, 1) @ (0.2126, 0.7152, 0.0722) for image in (reference, test))
    return 100 * np.mean(abs(t - r) >= 1e-4)


def check_localized(name, found, bound):
    """How far the localised VDP is off, relatively, where it must reach its bound; 1 where it is beyond a bound."""
    worst = 0.0
    for key in ("mean", "visible"):
        plain, localized = found[f"vdp_{key}_percent"], found[f"vdp_localized_{key}_percent"]
        most = min(plain, bound)
        off = abs(localized / most - 1) if name == "bright pixels" else float(localized > most + 1e-9)
        worst = max(worst, off)
        label = f"vdp {key}, localised"
        print(f"  {label:<22}{localized:>16.8g}{most:>15.8g}<  {off:.1e}{'' if off < TOLERANCE else '  TOO FAR'}")
    return worst


def main():
    fogbow = sys.argv[1]
    worst = 0.0
    with tempfile.TemporaryDirectory() as folder:
        for name, reference, test in pairs():
            reference, test = reference.astype(np.float32), test.astype(np.float32)
            paths = [str(Path(folder, f"{name}_{which}.exr")) for which in ("reference", "test")]
            write(paths[0], reference)
            write(paths[1], test)
            found = json.loads(subprocess.check_output([fogbow, "error", *paths, "--json"]))["errors"]
            print(f"{name:<24}{'fogbow':>16}{'the other':>16}  relative difference")
            for key, other in expected(reference, test).items():
                off = abs(found[key] / other - 1)
                worst = max(worst, off)
                print(f"  {key:<22}{found[key]:>16.8g}{other:>16.8g}  {off:.1e}{'' if off < TOLERANCE else '  TOO FAR'}")
            worst = max(worst, check_localized(name, found, differing_percent(reference, test)))
    print(f"worst relative difference {worst:.1e}, allowed {TOLERANCE:.0e}")
    sys.exit(int(worst >= TOLERANCE))


if __name__ == "__main__":
    main()
