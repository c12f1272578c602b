"""Error against time, a column a scene."""

from pathlib import Path

import matplotlib

matplotlib.use("svg")
matplotlib.rcParams["svg.hashsalt"] = "fogbow"
from matplotlib import pyplot  # noqa: E402
from matplotlib.ticker import NullFormatter  # noqa: E402

from equal_error import front  # noqa: E402

# Colour, marker and line of each renderer: fogbow's in warm colours, peers in cold ones.
STYLES = {
    "fogbow-fixed": ("#d1495b", "o", "-"),
    "fogbow-xs": ("#edae49", "o", "-"),
    "fogbow-reconstructed": ("#8f2d56", "v", "-"),
    "fogbow-oidn": ("#d81159", "^", "-"),
    "fogbow-xs-oidn": ("#a63d40", "s", "-"),
    "fogbow-traced-oidn": ("#f26419", "D", "-"),
    "cycles-biased-oidn": ("#003d5b", "s", "--"),
    "cycles-biased": ("#30638e", "^", "--"),
    "cycles": ("#00798c", "v", "--"),
    "mitsuba": ("#6a4c93", "D", "--"),
}
ROWS = (("relmse", "relative MSE"), ("flip", "FLIP"))


def draw(scenes: list[dict], path: Path) -> None:
    """`scenes` hold a title and points with renderer, seconds and errors. Lines join those points of
    a renderer that are better than all sooner ones; the others are faint."""
    size = (4.2 * len(scenes), 3.4 * len(ROWS))
    figure, grid = pyplot.subplots(len(ROWS), len(scenes), figsize=size, squeeze=False)
    for column, scene in enumerate(scenes):
        for (error, label), axes in zip(ROWS, grid[:, column]):
            for renderer, (color, marker, line) in STYLES.items():
                own = [p for p in scene["points"] if p["renderer"] == renderer]
                points = [(p["seconds"], p[error]) for p in own]
                if points:
                    look = {"color": color, "marker": marker, "ms": 4}
                    axes.loglog(*zip(*points), ls="", alpha=0.3, **look)
                    axes.loglog(*zip(*front(points)), ls=line, label=renderer, **look)
            axes.set_ylabel(label)
            axes.xaxis.set_minor_formatter(NullFormatter())
            axes.grid(which="both", alpha=0.25)
        grid[0, column].set_title(scene["title"], fontsize=10)
        grid[-1, column].set_xlabel("seconds (CPU seconds over threads)")
    handles, labels = grid[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncols=len(labels), fontsize=8, frameon=False)
    figure.tight_layout(rect=(0, 0.05, 1, 1))
    figure.savefig(path, metadata={"Date": None})
