# SPDX-License-Identifier: Zlib
"""Plots FOLDER/accuracy.csv: python3 plot_accuracy.py FOLDER

accuracy.svg and .png: all errors at 60 ticks a second. accuracy-SCENE.svg and .png, one picture per scene: error against the time of a tick, a panel for each kind of error. Filled markers: 60 ticks a second; hollow ones: the
other ticks. Limber twice: its springs alone, and (pale) the whole tick with Bullet's own work."""

import csv
import math
import pathlib
import re
import sys

import matplotlib

matplotlib.use("Agg")  # no window
from matplotlib import pyplot  # noqa: E402

MARKERS = "os^DvP*XphH8d<>"
BLUES = ["#0b4f8a", "#2f86c9", "#08306b", "#5aa9dd", "#1d6fb0", "#3d94c4", "#7cc0e8", "#9ad0ee", "#164a75"]
ORANGES = ["#a63603", "#e6550d", "#fd8d3c", "#d94801", "#f16913", "#8c2d04"]
GREENS = ["#1b7f4b", "#6bbf8a"]
COLOURS = {"limber": BLUES, "btSoftBody": ORANGES, "btDeformable": GREENS}
USUAL_TICK = 1 / 60
SMALLEST = 1e-12  # what is exact to the last bit is drawn here


def read_rows(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def unique(values):
    return list(dict.fromkeys(values))


def slug(name):
    return re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-")


def styles(rows):
    """A colour and a marker for each engine and setting."""
    found = {}
    for engine, colours in COLOURS.items():
        settings = unique(r["setting"] for r in rows if r["engine"] == engine)
        for i, setting in enumerate(settings):
            found[engine, setting] = (colours[i % len(colours)], MARKERS[i % len(MARKERS)])
    return found


def merge_equal(rows):
    """Settings of Limber with the same errors everywhere share one entry, as steppers that choose the same do."""
    results = {}
    for setting in unique(r["setting"] for r in rows if r["engine"] == "limber"):
        own = tuple((r["measure"], r["dt"], r["hash"]) for r in rows
                    if r["engine"] == "limber" and r["setting"] == setting)
        results.setdefault(own, []).append(setting)
    names = {group[0]: ", ".join(group) for group in results.values()}
    return names, [r for r in rows if r["engine"] != "limber" or r["setting"] in names]


def ceiling(rows):
    """Where to draw what has flown apart: a decade above all other errors."""
    errors = [float(r["error"]) for r in rows]
    if all(math.isfinite(error) for error in errors):
        return None
    return 10 ** (math.ceil(math.log10(max([SMALLEST] + [e for e in errors if math.isfinite(e)]))) + 1)


def shown(error, lost):
    return lost if math.isinf(float(error)) else max(float(error), SMALLEST)


def is_usual(row):
    return abs(float(row["dt"]) - USUAL_TICK) < 1e-6


def draw_points(axes, rows, column, lost, look, pale):
    colour, marker = look
    rows = sorted(rows, key=lambda r: float(r["dt"]))
    times = [float(r[column]) for r in rows]
    errors = [shown(r["error"], lost) for r in rows]
    axes.plot(times, errors, color=colour, linewidth=0.8, alpha=0.25 if pale else 0.6, zorder=2)
    for row, time, error in zip(rows, times, errors):
        face = colour if is_usual(row) else "white"
        axes.plot([time], [error], marker=marker, markersize=6.5, markerfacecolor=face, markeredgecolor=colour,
                  alpha=0.3 if pale else 1.0, linestyle="none", zorder=3)


def draw_setting(axes, rows, lost, look):
    if rows[0]["engine"] == "limber":
        draw_points(axes, rows, "us_per_tick", lost, look, pale=True)
    draw_points(axes, rows, "us_step", lost, look, pale=False)


def show_whole_decades(axis_limits, set_limits):
    low, high = axis_limits
    set_limits(10 ** math.floor(math.log10(low) + 1e-9), 10 ** math.ceil(math.log10(high) - 1e-9))


def show_times(axes):
    axes.set_xscale("log")
    low, high = axes.get_xlim()
    axes.set_xlim(0.8 * low, 1.25 * high)
    few = high / low > 200
    axes.xaxis.set_major_locator(matplotlib.ticker.LogLocator(subs=(1,) if few else (1, 2, 5)))
    axes.xaxis.set_minor_locator(matplotlib.ticker.LogLocator(subs=range(2, 10)))
    axes.xaxis.set_major_formatter(matplotlib.ticker.StrMethodFormatter("{x:g}"))
    axes.xaxis.set_minor_formatter(matplotlib.ticker.NullFormatter())
    axes.set_xlabel("\N{MICRO SIGN}s per tick", fontsize=8)


def finish(axes, title, lost):
    show_times(axes)
    axes.set_yscale("log")
    show_whole_decades(axes.get_ylim(), axes.set_ylim)
    if lost:
        axes.axhspan(lost / 3, axes.get_ylim()[1], color="#b00020", alpha=0.08, linewidth=0)
        axes.annotate("flown apart or never there", (0.99, lost / 2.7), xycoords=("axes fraction", "data"), ha="right",
                      va="bottom", fontsize=7, color="#b00020")
    axes.set_title(title, fontsize=9, loc="left")
    axes.tick_params(labelsize=8)
    axes.grid(True, which="major", color="#dfe2e6", linewidth=0.7)
    axes.set_axisbelow(True)


def legend_entries(rows, names, style):
    entries = []
    for engine in COLOURS:
        for setting in unique(r["setting"] for r in rows if r["engine"] == engine):
            colour, marker = style[engine, setting]
            label = f"{engine} {names.get(setting, setting) if engine == 'limber' else setting}"
            entries.append(pyplot.Line2D([], [], color=colour, marker=marker, linestyle="none", label=label))
    note = [("60 ticks a second", {"markerfacecolor": "#555"}), ("30, 120, 240", {"markerfacecolor": "white"}),
            ("limber: whole tick", {"markerfacecolor": "#555", "alpha": 0.3})]
    for label, look in note:
        entries.append(pyplot.Line2D([], [], color="#555", marker="o", linestyle="none", label=label, **look))
    return entries


def draw_scene(rows):
    style = styles(rows)
    names, rows = merge_equal(rows)
    measures = unique(r["measure"] for r in rows)
    widths = [4.6] * len(measures) + [2.4]  # the last one is for the legend
    figure, panels = pyplot.subplots(1, len(widths), figsize=(sum(widths), 4.6), squeeze=False,
                                     gridspec_kw={"width_ratios": widths}, layout="constrained")
    for axes, measure in zip(panels[0], measures):
        own = [r for r in rows if r["measure"] == measure]
        lost = ceiling(own)
        for engine in reversed(COLOURS):  # Limber on top
            for setting in unique(r["setting"] for r in own if r["engine"] == engine):
                rows_of_it = [r for r in own if r["engine"] == engine and r["setting"] == setting]
                draw_setting(axes, rows_of_it, lost, style[engine, setting])
        finish(axes, f"error of {measure}", lost)
    figure.suptitle(rows[0]["scene"] + (" (with contacts)" if rows[0]["kind"] == "contact" else ""), fontsize=11)
    panels[0][-1].axis("off")
    panels[0][-1].legend(handles=legend_entries(rows, names, style), loc="upper left", fontsize=7.5, frameon=False)
    return figure


def best_error(rows, engine, setting=None):
    errors = [float(r["error"]) for r in rows if r["engine"] == engine and setting in (None, r["setting"])]
    return min(errors) if errors else None


def overview_lines(rows):
    """Name, kind and the errors of Limber's auto, the best btSoftBody and the best btDeformable."""
    usual = [r for r in rows if is_usual(r)]
    lines = []
    for scene, measure in unique((r["scene"], r["measure"]) for r in usual):
        own = [r for r in usual if (r["scene"], r["measure"]) == (scene, measure)]
        errors = {"limber": best_error(own, "limber", "auto"), "btSoftBody": best_error(own, "btSoftBody"),
                  "btDeformable": best_error(own, "btDeformable")}
        if errors["btSoftBody"] is not None:  # what Limber has alone compares with nothing
            lines.append((f"{scene}: {measure}", own[0]["kind"], errors))
    return lines


def draw_overview(rows):
    lines = overview_lines(rows)
    if not lines:
        return None
    figure, axes = pyplot.subplots(figsize=(9.5, 0.19 * len(lines) + 1.4), layout="constrained")
    lost = 10 * max(e for _, _, errors in lines for e in errors.values() if e is not None and math.isfinite(e))
    looks = {"btSoftBody": ("^", "best btSoftBody"), "btDeformable": ("s", "best btDeformable"),
             "limber": ("o", "limber auto")}
    for engine, (marker, label) in looks.items():
        points = [(shown(errors[engine], lost), y) for y, (_, _, errors) in enumerate(lines)
                  if errors[engine] is not None]
        if points:
            axes.plot(*zip(*points), marker=marker, markersize=5, linestyle="none", color=COLOURS[engine][0],
                      label=label)
    contact = [y for y, (_, kind, _) in enumerate(lines) if kind == "contact"]
    if contact and contact[0] > 0:
        axes.axhline(contact[0] - 0.5, color="#555", linewidth=0.8)
        axes.annotate("with contacts", (0.005, contact[0] - 0.3), xycoords=("axes fraction", "data"), va="top",
                      fontsize=7, color="#555")
    axes.set_yticks(range(len(lines)), [name for name, _, _ in lines], fontsize=7)
    axes.set_ylim(len(lines) - 0.4, -0.6)
    axes.set_xscale("log")
    axes.xaxis.set_major_locator(matplotlib.ticker.LogLocator(numticks=12))
    axes.set_xlabel("error at 60 ticks a second (relative, of the size, or in m for heights and creep)", fontsize=8)
    axes.tick_params(axis="x", labelsize=8)
    axes.grid(True, color="#dfe2e6", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.legend(fontsize=8, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncol=3, frameon=False)
    return figure


def save(figure, folder, name):
    for ending in ("svg", "png"):
        path = folder / f"{name}.{ending}"
        figure.savefig(path, dpi=110)
    print(f"plot {path}")
    pyplot.close(figure)


def main(folder):
    rows = read_rows(folder / "accuracy.csv")
    overview = draw_overview(rows)
    if overview:
        save(overview, folder, "accuracy")
    for scene in unique(r["scene"] for r in rows):
        save(draw_scene([r for r in rows if r["scene"] == scene]), folder, f"accuracy-{slug(scene)}")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(pathlib.Path(sys.argv[1]))
