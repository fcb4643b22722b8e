# SPDX-License-Identifier: Zlib
"""Plots FOLDER/contact.csv into contact.svg and .png: python3 plot_contact.py FOLDER

Left, what a point costs in each scene: a dot for the median tick, a whisker up to the worst. Right, how deep things
were in one another where they should lie still."""

import csv
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")  # no window
from matplotlib import pyplot  # noqa: E402

# in the order of the file; Limber's kinds of collision take the first ones
LIMBER_COLOURS = ["#1f6fb4", "#2ba7c9", "#16437a"]
OTHER_COLOURS = {"btSoftBody 1 it": "#e8b04c", "btSoftBody 4 it": "#d9602b", "btSoftBody 10 it": "#9c2f1f",
                 "btDeformable implicit": "#2b9a66", "loose spheres": "#8a8f98"}
MARKERS = {"loose spheres": "s", "btDeformable implicit": "^"}
SPARE_COLOUR = "#7a4fa0"
LEAST_DEPTH = 1e-5  # of the body's size: less is drawn as that much


def read_rows(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def unique(values):
    return list(dict.fromkeys(values))


def colours_of(engines):
    limber = [e for e in engines if e.startswith("limber")]
    colours = {e: LIMBER_COLOURS[i % len(LIMBER_COLOURS)] for i, e in enumerate(limber)}
    return {e: colours.get(e) or OTHER_COLOURS.get(e, SPARE_COLOUR) for e in engines}


def offsets_of(engines):
    """Engines of a scene stand a little below one another."""
    return {e: 0.62 * ((i + 0.5) / len(engines) - 0.5) for i, e in enumerate(engines)}


def draw_cost(axes, rows, scenes, engines):
    colours, offsets = colours_of(engines), offsets_of(engines)
    for engine in engines:
        own = [r for r in rows if r["engine"] == engine and r["us_per_point"]]
        y = [scenes.index(r["scene"]) + offsets[engine] for r in own]
        x = [float(r["us_per_point"]) for r in own]
        worst = [1e3 * float(r["tick_ms_worst"]) / float(r["points"]) for r in own]
        axes.hlines(y, x, worst, color=colours[engine], linewidth=0.8, alpha=0.6)
        axes.scatter(x, y, s=26 if engine.startswith("limber") else 16, color=colours[engine],
                     marker=MARKERS.get(engine, "o"), label=engine, zorder=3)
    axes.set_title("cost of a point, median tick to worst tick", fontsize=10, loc="left")
    axes.set_xlabel("microseconds of a thread per point and tick")


def draw_depth(axes, rows, scenes, engines):
    colours, offsets = colours_of(engines), offsets_of(engines)
    for engine in engines:
        own = [r for r in rows if r["engine"] == engine and r["deepest_penetration_share"]
               and r["role"] not in ("airborne", "asleep")]
        y = [scenes.index(r["scene"]) + offsets[engine] for r in own]
        x = [max(LEAST_DEPTH, float(r["deepest_penetration_share"])) for r in own]
        axes.scatter(x, y, s=26 if engine.startswith("limber") else 16, color=colours[engine],
                     marker=MARKERS.get(engine, "o"), zorder=3)
    axes.set_title("deepest penetration at the end", fontsize=10, loc="left")
    axes.set_xlabel("of a body's size (left edge: less)")
    axes.set_xlim(left=LEAST_DEPTH * 0.8)


def finish(axes, scenes):
    axes.set_xscale("log")
    axes.set_ylim(len(scenes) - 0.5, -0.5)
    for i in range(1, len(scenes)):
        axes.axhline(i - 0.5, color="#dfe2e6", linewidth=0.7)
    axes.grid(True, axis="x", which="major", color="#dfe2e6", linewidth=0.7)
    axes.set_axisbelow(True)


def draw(rows):
    scenes, engines = unique(r["scene"] for r in rows), unique(r["engine"] for r in rows)
    figure, (cost, depth) = pyplot.subplots(1, 2, figsize=(12, 1.6 + 0.52 * len(scenes)), sharey=True,
                                            gridspec_kw={"width_ratios": (3, 2)}, layout="constrained")
    draw_cost(cost, rows, scenes, engines)
    draw_depth(depth, rows, scenes, engines)
    for axes in (cost, depth):
        finish(axes, scenes)
    # the upper scenes are those in the air, which have no depth
    depth.legend(*cost.get_legend_handles_labels(), fontsize=7.5, loc="upper right")
    cost.set_yticks(range(len(scenes)), scenes, fontsize=8.5)
    return figure


def main(folder):
    figure = draw(read_rows(folder / "contact.csv"))
    for ending in ("svg", "png"):
        path = folder / f"contact.{ending}"
        figure.savefig(path, dpi=130)
        print(f"plot {path}")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(pathlib.Path(sys.argv[1]))
