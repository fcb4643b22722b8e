# SPDX-License-Identifier: Zlib
"""Plots FOLDER/render.csv into render.svg and render.png: python3 plot_render.py FOLDER

By number of cubes: the frame, what all threads together spend on it, and what of that the calling thread spends on
uploading and submitting a body; at the lower right the threads' time of one large body. The largest picture and the
first context count."""

import csv
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")  # no window
from matplotlib import pyplot  # noqa: E402

# path: name in the legend, colour, marker
PATHS = {
    "limber": ("limber: mapped buffer, a draw per shape", "#1f6fb4", "o"),
    "naive_points": ("points body by body, normals on the GPU", "#e8b04c", "s"),
    "naive": ("vertices body by body, normals on the CPU", "#d9602b", "^"),
}
# 1: with shadows
SHADOW_LINES = {"1": ("-", "shadows"), "0": (":", "no shadows")}
# of the time of all threads
PARTS = {
    "upload and submit, calling thread": ("#1f6fb4", lambda r: float(r["own_ms"])),
    "the rest: a software driver's rasteriser, reading": ("#c3cad3",
                                                          lambda r: float(r["process_ms"]) - float(r["own_ms"])),
}


def read_rows(path):
    """Those of the first context, in the largest size."""
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    size = max((r["size"] for r in rows), key=lambda s: int(s.split("x")[0]))
    return [r for r in rows if r["context"] == rows[0]["context"] and r["size"] == size]


def draw_by_count(axes, rows, value, title, unit):
    for path, (_, colour, marker) in PATHS.items():
        for shadows, (line, _) in SHADOW_LINES.items():
            own = [r for r in rows if r["path"] == path and r["shadows"] == shadows]
            axes.plot([int(r["bodies"]) for r in own], [value(r) for r in own], color=colour, marker=marker,
                      markersize=4, linewidth=1.4, linestyle=line)
    axes.set_title(title, fontsize=10, loc="left")
    axes.set_ylabel(unit)
    axes.set_xscale("log", base=2)
    axes.set_xticks(sorted({int(r["bodies"]) for r in rows}))
    axes.xaxis.set_major_formatter(matplotlib.ticker.StrMethodFormatter("{x:g}"))
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("cubes (8 points, 12 triangles each)")
    axes.grid(True, which="major", color="#dfe2e6", linewidth=0.7)
    axes.set_axisbelow(True)


def add_legend(axes):
    lines = [matplotlib.lines.Line2D([], [], color=colour, marker=marker, markersize=4, label=name)
             for name, colour, marker in PATHS.values()]
    lines += [matplotlib.lines.Line2D([], [], color="#555", linestyle=line, label=name)
              for line, name in SHADOW_LINES.values()]
    axes.legend(handles=lines, fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=2, frameon=False)


def draw_parts(axes, rows):
    bars = [r for shadows in SHADOW_LINES for path in PATHS for r in rows
            if (r["path"], r["shadows"]) == (path, shadows)]
    start = [0.0] * len(bars)
    for name, (colour, value) in PARTS.items():
        widths = [value(r) for r in bars]
        axes.barh(range(len(bars)), widths, left=start, height=0.62, color=colour, label=name)
        start = [a + b for a, b in zip(start, widths)]
    names = [f"{r['path']}\n{SHADOW_LINES[r['shadows']][1]}" for r in bars]
    axes.set_yticks(range(len(bars)), names, fontsize=8)
    axes.invert_yaxis()
    axes.set_xlabel("ms")
    axes.set_title(f"one body of {int(rows[0]['triangles']) - 2} triangles, all threads", fontsize=10, loc="left")
    axes.legend(fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.14), frameon=False)


def draw(rows):
    cubes, ball = [r for r in rows if r["scene"] == "cubes"], [r for r in rows if r["scene"] == "ball"]
    figure, axes = pyplot.subplots(2, 2, figsize=(11, 7.5), layout="constrained")
    draw_by_count(axes[0, 0], cubes, lambda r: float(r["frame_ms"]), f"frame, {rows[0]['size']}, wall", "ms")
    draw_by_count(axes[0, 1], cubes, lambda r: float(r["process_ms"]), "frame, all threads", "ms")
    draw_by_count(axes[1, 0], cubes, lambda r: 1e3 * float(r["own_ms"]) / int(r["bodies"]),
                  "upload and submit per body, calling thread", "microseconds")
    draw_parts(axes[1, 1], ball)
    add_legend(axes[1, 0])
    return figure


def main(folder):
    figure = draw(read_rows(folder / "render.csv"))
    for ending in ("svg", "png"):
        path = folder / f"render.{ending}"
        figure.savefig(path, dpi=130)
        print(f"plot {path}")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(pathlib.Path(sys.argv[1]))
