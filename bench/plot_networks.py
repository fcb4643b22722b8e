# SPDX-License-Identifier: Zlib
"""Plots FOLDER/networks.csv into networks.svg and networks.png: python3 plot_networks.py FOLDER"""

import csv
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")  # no window
from matplotlib import pyplot  # noqa: E402

KINDS = ["squash", "twist", "noise", "push", "mirror", "flatten", "inversion"]
NAMES = {"none": "edges alone", "equal": "equal length", "two-ring": "two-ring", "random": "random, as many",
         "pipeline": "pipeline"}


def read_rows(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def unique(values):
    return list(dict.fromkeys(values))


def share(row, kinds):
    return 100 * sum(float(row["return_" + kind]) for kind in kinds) / len(kinds)


def write_cells(axes, table):
    axes.imshow(table, cmap="RdYlGn", vmin=0, vmax=100, aspect="auto")
    for y, line in enumerate(table):
        for x, value in enumerate(line):
            axes.text(x, y, f"{value:.0f}", ha="center", va="center", fontsize=8)
    axes.tick_params(length=0)
    axes.spines[:].set_visible(False)


def braces(rows, mesh):
    for row in rows:
        if row["mesh"] == mesh and row["rule"] == "pipeline":
            return f"{mesh}\n+{int(row['braces']) / int(row['points']):.2f}"
    return mesh


def draw_rules(axes, rows, meshes):
    rules = [rule for rule in NAMES if any(row["rule"] == rule for row in rows)]
    found = {(row["mesh"], row["rule"]): row for row in rows}
    table = [[share(found[mesh, rule], KINDS) if (mesh, rule) in found else float("nan") for mesh in meshes]
             for rule in rules]
    write_cells(axes, table)
    axes.set_xticks(range(len(meshes)), [braces(rows, mesh) for mesh in meshes], rotation=45, ha="right", fontsize=8)
    axes.set_yticks(range(len(rules)), [NAMES[rule] for rule in rules])
    axes.set_title("Bodies that come back from large deformations, % of seeded runs (below: braces a point)",
                   fontsize=11)


def main(folder):
    folder = pathlib.Path(folder)
    rows = read_rows(folder / "networks.csv")
    meshes = unique(row["mesh"] for row in rows)
    figure, axes = pyplot.subplots(figsize=(max(6, 0.55 * len(meshes) + 2), 3.6), layout="constrained")
    draw_rules(axes, rows, meshes)
    for ending in ("svg", "png"):
        figure.savefig(folder / f"networks.{ending}", dpi=150)


if __name__ == "__main__":
    main(sys.argv[1])
