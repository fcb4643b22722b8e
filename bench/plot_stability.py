# SPDX-License-Identifier: Zlib
"""Plots FOLDER/stability.csv into stability.svg and .png: python3 plot_stability.py FOLDER

A row for each group of cases, a column for each engine and setting: the runs that missed no target, of all that the
engine could take part in."""

import csv
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")  # no window
from matplotlib import colors, pyplot  # noqa: E402

# from none to all; the last step is kept for nothing missed at all
SHADES = colors.LinearSegmentedColormap.from_list("passed", ["#b2382f", "#e59866", "#f4e3a1", "#b9dba0"])
ALL_PASSED = "#4f9d5d"
NOT_ASKED = "#eceff1"


def read_rows(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def unique(values):
    return list(dict.fromkeys(values))


def counts(rows):
    ran = [r for r in rows if r["passed"] != "n/a"]
    return sum(r["passed"] == "1" for r in ran), len(ran)


def colour_of(passed, ran):
    if ran == 0:
        return NOT_ASKED
    return ALL_PASSED if passed == ran else SHADES(passed / ran)


def draw_cell(axes, x, y, rows):
    passed, ran = counts(rows)
    axes.add_patch(pyplot.Rectangle((x, y), 1, 1, facecolor=colour_of(passed, ran), edgecolor="white", linewidth=1.5))
    dark = ran > 0 and (passed == ran or passed < 0.2 * ran)
    text = f"{100 * passed // ran} %" if ran else "n/a"
    axes.text(x + 0.5, y + 0.42, text, ha="center", va="center", fontsize=9, color="white" if dark else "#222")
    if ran:
        axes.text(x + 0.5, y + 0.76, f"{passed} of {ran}", ha="center", va="center", fontsize=6.5,
                  color="white" if dark else "#444")


def label(engine):
    return "\n".join(engine).replace(" it ", " iterations\n") if engine[0] == "btSoftBody" else "\n".join(engine)


def draw(rows):
    engines = unique((r["engine"], r["setting"]) for r in rows)
    groups = unique(r["group"] for r in rows) + ["all"]
    figure, axes = pyplot.subplots(figsize=(2.2 + 1.05 * len(engines), 1.5 + 0.5 * len(groups)), layout="constrained")
    tops = [y + (0.25 if group == "all" else 0) for y, group in enumerate(groups)]
    for y, group in zip(tops, groups):
        for x, engine in enumerate(engines):
            own = [r for r in rows if (r["engine"], r["setting"]) == engine and group in (r["group"], "all")]
            draw_cell(axes, x, y, own)
    axes.set_xlim(0, len(engines))
    axes.set_ylim(tops[-1] + 1, 0)
    axes.set_xticks([x + 0.5 for x in range(len(engines))], [label(e) for e in engines], fontsize=8)
    axes.set_yticks([y + 0.5 for y in tops], groups, fontsize=9)
    axes.xaxis.tick_top()
    axes.tick_params(length=0)
    for side in axes.spines.values():
        side.set_visible(False)
    axes.set_title("hard cases survived without missing a target", fontsize=10, loc="left", pad=12)
    return figure


def main(folder):
    figure = draw(read_rows(folder / "stability.csv"))
    for ending in ("svg", "png"):
        path = folder / f"stability.{ending}"
        figure.savefig(path, dpi=130)
        print(f"plot {path}")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(pathlib.Path(sys.argv[1]))
