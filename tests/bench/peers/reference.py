"""The reference of a scene: the independent results of two unbiased renderers, mixed.

Each renders several parts from different seeds, whose scatter tells the variance of their mean,
pixel by pixel; from it follow the weights of the mix, its noise, and by how many standard errors
the renderers differ.
"""

from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

import numpy

from metrics import Picture, grey, read, relative

BLOCKS = 8
MOST_DEVIATIONS, MOST_DIFFERENCE = 5.0, 0.01


@dataclass(frozen=True)
class Reference:
    """`noise` is the relative MSE of the reference itself."""

    picture: Picture
    noise: float
    about: str


@dataclass(frozen=True)
class Part:
    """What one renderer says: its mean, and the variance of that, of grey."""

    renderer: str
    picture: Picture
    variance: numpy.ndarray


def _part(renderer: str, records: list[dict]) -> Part:
    pictures = numpy.stack([read(record["picture"]) for record in records])
    scatter = grey(pictures).var(axis=0, ddof=1)
    return Part(renderer, pictures.mean(0), scatter / len(records))


def _blocks(values: numpy.ndarray) -> numpy.ndarray:
    edge = values.shape[0] // BLOCKS
    cut = values[: edge * BLOCKS, : edge * BLOCKS]
    return cut.reshape(BLOCKS, edge, BLOCKS, edge).sum((1, 3))


def _difference(a: numpy.ndarray, b: numpy.ndarray, variance: numpy.ndarray) -> tuple:
    """Relative difference of the sums `a` and `b`, and the same in standard errors."""
    known = variance > (1e-4 * b) ** 2  # elsewhere there is only rounding
    ratio = a[known] / b[known] - 1
    return ratio, (a - b)[known] / numpy.sqrt(variance[known])


def _compare(a: Part, b: Part) -> str:
    """How far two renderers are apart; ends the run where that is no noise."""
    ga, gb, variance = grey(a.picture), grey(b.picture), a.variance + b.variance
    whole = [numpy.array([x.sum()]) for x in (ga, gb, variance)]
    (mean,), (deviations,) = _difference(*whole)
    ratios, far = _difference(_blocks(ga), _blocks(gb), _blocks(variance))
    worst = int(numpy.abs(far).argmax())
    text = (
        f"{a.renderer} over {b.renderer}: {100 * mean:+.2f} % in the mean "
        f"({deviations:+.1f} standard errors), {100 * ratios[worst]:+.2f} % in the most deviating "
        f"of {len(far)} blocks ({far[worst]:+.1f})"
    )
    if abs(deviations) > MOST_DEVIATIONS and abs(mean) > MOST_DIFFERENCE:
        raise SystemExit(f"the references do not agree: {text}")
    return text


def mix(records: list[dict]) -> Reference:
    """The mix of all renderers among `records`, with two parts or more of each."""
    renderers = list(dict.fromkeys(record["renderer"] for record in records))
    parts = [_part(name, [r for r in records if r["renderer"] == name]) for name in renderers]
    agreement = [_compare(a, b) for a, b in combinations(parts, 2)]
    first = sum(part.picture for part in parts) / len(parts)
    noises = [float(relative(part.variance, first).mean()) for part in parts]
    weights = numpy.array([1 / noise for noise in noises])
    weights /= weights.sum()
    picture = sum(weight * part.picture for weight, part in zip(weights, parts))
    noise = float(sum(weight**2 * own for weight, own in zip(weights, noises)))
    shares = ", ".join(
        f"{100 * weight:.0f} % {part.renderer} (relMSE of its noise {own:.1e})"
        for weight, part, own in zip(weights, parts, noises)
    )
    return Reference(picture, noise, f"a mix of {shares}; {'; '.join(agreement)}")


def given(file: str, noise: float) -> Reference:
    """A reference made elsewhere."""
    return Reference(read(file), noise, f"{Path(file).name}, given with the scene")
