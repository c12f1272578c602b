"""Time to equal error, by straight lines between measured budgets on logarithmic axes."""

import math
from dataclasses import dataclass
from itertools import pairwise

BELOW, EXACT, ABOVE = "<", "", ">"


@dataclass(frozen=True)
class Reached:
    """Seconds to an error. `bound` tells that it takes less than the cheapest, or more than the
    dearest of what was measured: nothing is extrapolated."""

    seconds: float
    bound: str

    def ratio(self, peer: float) -> str:
        """How many times longer the peer took with its `peer` seconds."""
        turned = {BELOW: "> ", EXACT: "", ABOVE: "< "}[self.bound]
        return f"{turned}{peer / self.seconds:.3g}"

    def __str__(self) -> str:
        space = " " if self.bound else ""
        return f"{self.bound}{space}{self.seconds:.3g}"


def front(curve: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """The points that are better than all sooner ones, by time."""
    front: list[tuple[float, float]] = []
    for seconds, error in sorted(curve):
        if not front or error < front[-1][1]:
            front.append((seconds, error))
    return front


def time_to(curve: list[tuple[float, float]], error: float) -> Reached:
    """When `curve`, points of seconds and error, first gets to `error`."""
    points = front(curve)
    if points[0][1] <= error:
        return Reached(points[0][0], BELOW)
    for (t0, e0), (t1, e1) in pairwise(points):
        if e1 <= error:
            part = math.log(e0 / error) / math.log(e0 / e1)
            return Reached(t0 * (t1 / t0) ** part, EXACT)
    return Reached(max(curve)[0], ABOVE)


def both(a: Reached, b: Reached) -> Reached:
    """When the later of two errors is reached."""
    if ABOVE in (a.bound, b.bound):
        return Reached(max(a.seconds, b.seconds), ABOVE)
    return max(a, b, key=lambda reached: reached.seconds)
