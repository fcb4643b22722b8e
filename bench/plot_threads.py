# SPDX-License-Identifier: Zlib
"""Plots FOLDER/threads.csv into threads.svg and threads.png: python3 plot_threads.py FOLDER"""

import csv
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")  # no window
from matplotlib import pyplot  # noqa: E402


def read_rows(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def draw(axes, rows):
    scenes = list(dict.fromkeys(row["scene"] for row in rows))
    counts = sorted({int(row["threads"]) for row in rows} - {1})
    height = 0.8 / len(counts)
    for i, threads in enumerate(counts):
        own = [row for row in rows if int(row["threads"]) == threads]
        places = [scenes.index(row["scene"]) - 0.4 + height * (i + 0.5) for row in own]
        bars = axes.barh(places, [float(row["gain"]) for row in own], 0.9 * height, label=f"{threads} threads")
        axes.bar_label(bars, fmt="%.2f", padding=3, fontsize=8)
        axes.scatter([float(row["gain_at_most"]) for row in own], places, marker="|", s=120, color="#333",
                     label="at most, by the share outside" if i == 0 else None)
    axes.axvline(1.0, color="#8a8f98", linewidth=0.8)
    axes.set_yticks(range(len(scenes)), scenes)
    axes.invert_yaxis()
    axes.margins(x=0.12)


def main(folder):
    folder = pathlib.Path(folder)
    rows = read_rows(folder / "threads.csv")
    figure, axes = pyplot.subplots(figsize=(8, 6), layout="constrained")
    draw(axes, rows)
    axes.set_xlabel("gain over one thread")
    axes.set_title("What several threads gain, whole ticks", fontsize=11)
    axes.legend(frameon=False)
    axes.spines[["top", "right"]].set_visible(False)
    for ending in ("svg", "png"):
        figure.savefig(folder / f"threads.{ending}", dpi=150)


if __name__ == "__main__":
    main(sys.argv[1])
