# SPDX-License-Identifier: Zlib
"""Plots FOLDER/scaling.csv into scaling.svg and scaling.png: python3 plot_scaling.py FOLDER"""

import csv
import math
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")  # no window
from matplotlib import pyplot  # noqa: E402

TICK_BUDGET_MS = 20.0  # 50 ticks a second

# mode: name in the legend, colour, marker
MODES = {
    "bare": ("loose Bullet spheres, no springs", "#8a8f98", "s"),
    "none": ("soft cubes, not drawn", "#1f6fb4", "o"),
    "shaded": ("soft cubes, shaded", "#d9602b", "^"),
    "wireframe": ("soft cubes, wireframe", "#2b9a66", "v"),
}


def read_rows(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def series(rows, mode, column):
    """Counts and values of a mode, by count; rows without a value are left out."""
    own = [r for r in rows if r["mode"] == mode and r[column]]
    points = sorted((int(r["bodies"]), float(r[column])) for r in own)
    return [p[0] for p in points], [p[1] for p in points]


def draw_column(axes, rows, column):
    for mode, (name, colour, marker) in MODES.items():
        counts, values = series(rows, mode, column)
        if counts:
            axes.plot(counts, values, color=colour, marker=marker, markersize=4, linewidth=1.4, label=name)


def draw_given_up(axes, rows, column):
    """A ring around what was only measured while the cubes fell."""
    own = [r for r in rows if r["complete"] == "0" and r[column]]
    if own:
        counts = [int(r["bodies"]) for r in own]
        values = [float(r[column]) for r in own]
        axes.scatter(counts, values, s=70, facecolors="none", edgecolors="#b00020", label="given up early")


def draw_budget(axes):
    axes.axhline(TICK_BUDGET_MS, color="#b00020", linewidth=1.0, linestyle="--")
    axes.annotate("20 ms: 50 a second", (0.01, TICK_BUDGET_MS), xycoords=("axes fraction", "data"),
                  xytext=(4, 4), textcoords="offset points", color="#b00020", fontsize=8)


def show_whole_decades(axes):
    axes.set_yscale("log")  # first: on a linear scale the limits may be below zero
    low, high = axes.get_ylim()
    axes.set_ylim(10 ** math.floor(math.log10(low)), 10 ** math.ceil(math.log10(high)))


def finish(axes, title, unit):
    show_whole_decades(axes)
    axes.set_title(title, fontsize=10, loc="left")
    axes.set_ylabel(unit)
    axes.set_xscale("log", base=2)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter(matplotlib.ticker.StrMethodFormatter("{x:g}"))
    axes.yaxis.set_minor_formatter(matplotlib.ticker.NullFormatter())
    axes.grid(True, which="major", color="#dfe2e6", linewidth=0.7)
    axes.set_axisbelow(True)


def draw_tick(axes, rows):
    # a mean shows what else ran on the machine, too
    draw_column(axes, rows, "tick_ms_median")
    draw_given_up(axes, rows, "tick_ms_median")
    draw_budget(axes)
    finish(axes, "Tick, median of samples", "ms")
    axes.set_xlabel("cubes (8 points, 24 springs each)")
    axes.legend(fontsize=8, loc="lower right")


def draw_render(axes, rows):
    draw_column(axes, rows, "render_ms_mean")
    draw_budget(axes)
    finish(axes, "Frame, mean of samples", "ms")


def draw_memory(axes, rows):
    draw_column(axes, rows, "gpu_mb")
    finish(axes, "GPU buffers", "MB")
    axes.set_xlabel("cubes")


def draw_all(rows):
    figure = pyplot.figure(figsize=(11, 5.5), layout="constrained")
    grid = figure.add_gridspec(2, 2, width_ratios=(3, 2))
    draw_tick(figure.add_subplot(grid[:, 0]), rows)
    if any(r["render_ms_mean"] for r in rows):
        draw_render(figure.add_subplot(grid[0, 1]), rows)
        draw_memory(figure.add_subplot(grid[1, 1]), rows)
    return figure


def main(folder):
    figure = draw_all(read_rows(folder / "scaling.csv"))
    for name in ("scaling.svg", "scaling.png"):
        figure.savefig(folder / name, dpi=150)
        print(f"plot {folder / name}")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(pathlib.Path(sys.argv[1]))
