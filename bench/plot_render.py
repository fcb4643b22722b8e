# SPDX-License-Identifier: Zlib
"""Plots FOLDER/render.csv into render.svg and render.png: python3 plot_render.py FOLDER

Left, the whole frame by number of cubes; middle, the calling thread's own time to upload and submit a body; right,
what the frame of one large body consists of. The largest picture and the first context count."""

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
PARTS = {"upload_ms": ("upload", "#16437a"), "submit_ms": ("submit", "#2ba7c9"),
         "finish_ms": ("finish", "#c3cad3"), "read_ms": ("read", "#8a8f98")}


def read_rows(path):
    """Those of the first context, in the largest size."""
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    size = max((r["size"] for r in rows), key=lambda s: int(s.split("x")[0]))
    return [r for r in rows if r["context"] == rows[0]["context"] and r["size"] == size]


def draw_by_count(axes, rows, value):
    for path, (_, colour, marker) in PATHS.items():
        for shadows, (line, _) in SHADOW_LINES.items():
            own = [r for r in rows if r["path"] == path and r["shadows"] == shadows]
            axes.plot([int(r["bodies"]) for r in own], [value(r) for r in own], color=colour, marker=marker,
                      markersize=4, linewidth=1.4, linestyle=line)
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
    axes.legend(handles=lines, fontsize=7.5, loc="upper center", bbox_to_anchor=(0.5, -0.13), ncols=2, frameon=False)


def draw_parts(axes, rows):
    bars = [(path, shadows) for shadows in SHADOW_LINES for path in PATHS]
    chosen = {(r["path"], r["shadows"]): r for r in rows}
    start = [0.0] * len(bars)
    for column, (name, colour) in PARTS.items():
        widths = [float(chosen[bar][column]) for bar in bars]
        axes.barh(range(len(bars)), widths, left=start, height=0.62, color=colour, label=name)
        start = [a + b for a, b in zip(start, widths)]
    axes.set_yticks(range(len(bars)), [f"{path}\n{SHADOW_LINES[shadows][1]}" for path, shadows in bars], fontsize=8)
    axes.invert_yaxis()
    axes.set_xlabel("ms")
    axes.set_title(f"one body of {int(rows[0]['triangles']) - 2} triangles", fontsize=10, loc="left")
    axes.legend(fontsize=7.5, ncols=4, loc="upper center", bbox_to_anchor=(0.5, -0.13), frameon=False)


def draw(rows):
    cubes, ball = [r for r in rows if r["scene"] == "cubes"], [r for r in rows if r["scene"] == "ball"]
    figure, (frame, cost, parts) = pyplot.subplots(1, 3, figsize=(13, 4.6), layout="constrained")
    draw_by_count(frame, cubes, lambda r: float(r["frame_ms"]))
    frame.set_title(f"whole frame, {rows[0]['size']}", fontsize=10, loc="left")
    frame.set_ylabel("ms")
    add_legend(frame)
    draw_by_count(cost, cubes, lambda r: 1e3 * float(r["own_ms"]) / int(r["bodies"]))
    cost.set_title("upload and submit per body, the thread's own time", fontsize=10, loc="left")
    cost.set_ylabel("microseconds")
    draw_parts(parts, ball)
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
