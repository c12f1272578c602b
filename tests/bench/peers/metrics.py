"""Errors of a linear picture against its reference."""

from dataclasses import dataclass

import flip_evaluator
import numpy
import OpenEXR
from numpy.typing import NDArray

Picture = NDArray[numpy.float64]
TRIMMED = 0.001  # the part of the pixels, worst first, that the trimmed error leaves out


def read(path: str) -> Picture:
    """R, G and B of an EXR, (height, width, 3)."""
    with OpenEXR.File(path, separate_channels=True) as file:
        channels = file.channels()
        picture = [numpy.asarray(channels[name].pixels, dtype=numpy.float64) for name in "RGB"]
    return numpy.stack(picture, -1)


def grey(picture: Picture) -> NDArray[numpy.float64]:
    """The mean of the channels: the scenes have no colour."""
    return picture.mean(-1)


def relative(square: NDArray[numpy.float64], reference: Picture) -> NDArray[numpy.float64]:
    """Squared errors over r² + eps², eps half the reference's mean, lest black pixels decide."""
    r = grey(reference)
    return square / (r**2 + (0.5 * r.mean()) ** 2)


@dataclass(frozen=True)
class Errors:
    """`relmse` and `trimmed` are relative MSE, of all pixels and without the worst of them."""

    relmse: float
    trimmed: float
    rmse: float
    flip: float
    mean_ratio: float


def errors(picture: Picture, reference: Picture) -> Errors:
    if not numpy.isfinite(picture).all():
        raise SystemExit("a picture holds values that are not finite")
    square = (grey(picture) - grey(reference)) ** 2
    each = numpy.sort(relative(square, reference), axis=None)
    as_float = (reference.astype(numpy.float32), picture.astype(numpy.float32))
    _, flip, _ = flip_evaluator.evaluate(*as_float, "HDR")
    return Errors(
        relmse=float(each.mean()),
        trimmed=float(each[: int(len(each) * (1 - TRIMMED))].mean()),
        rmse=float(numpy.sqrt(square.mean())),
        flip=float(flip),
        mean_ratio=float(grey(picture).mean() / grey(reference).mean()),
    )
