# SPDX-License-Identifier: Zlib
"""Plots FOLDER/springs.csv into springs.svg and springs.png: python3 plot_springs.py FOLDER"""

import csv
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")  # no window
from matplotlib import pyplot  # noqa: E402

COLOURS = {"0": "#8fb8de", "1": "#1f6fb4"}
NAMES = {"0": "undamped", "1": "damped"}


def read_rows(path):
    with open(path, newline="") as file:
        return [row for row in csv.DictReader(file) if row["contacts"] == "0"]


def draw(axes, rows):
    ways = list(dict.fromkeys(row["stepped"] for row in rows))
    for damped, shift in (("0", -0.2), ("1", 0.2)):
        own = {r["stepped"]: r for r in rows if r["damped"] == damped}
        places = [i + shift for i, way in enumerate(ways) if way in own]
        values = [float(own[way]["ns_per_spring_substep"]) for way in ways if way in own]
        noise = [float(own[way]["ns_noise"]) for way in ways if way in own]
        bars = axes.barh(places, values, 0.38, xerr=noise, color=COLOURS[damped], label=NAMES[damped])
        axes.bar_label(bars, fmt="%.1f", padding=6, fontsize=8)
    axes.set_yticks(range(len(ways)), ways)
    axes.invert_yaxis()
    axes.margins(x=0.12)


def main(folder):
    folder = pathlib.Path(folder)
    rows = read_rows(folder / "springs.csv")
    figure, axes = pyplot.subplots(figsize=(7.5, 4.5), layout="constrained")
    draw(axes, rows)
    axes.set_xlabel("ns per spring and substep")
    axes.set_title("What a spring costs: cubes of 8 points and 28 springs", fontsize=11)
    axes.legend(frameon=False)
    axes.spines[["top", "right"]].set_visible(False)
    for ending in ("svg", "png"):
        figure.savefig(folder / f"springs.{ending}", dpi=150)


if __name__ == "__main__":
    main(sys.argv[1])
