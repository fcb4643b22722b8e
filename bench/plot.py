# SPDX-License-Identifier: Zlib
"""Plots FOLDER/BENCH.csv into FOLDER/BENCH.svg and .png: plot.py BENCH FOLDER [PICTURES]

Three kinds of plots: errors against times, lines against a count, bars of categories. Engines differ in colour (Okabe
and Ito, for colour-blind people), marker and hatch, so that a grey print is readable. With PICTURES, the PNG is also
copied there."""

import math
import pathlib
import re
import shutil
import sys
import textwrap

import matplotlib

matplotlib.use("Agg")  # no window
from matplotlib import pyplot, ticker  # noqa: E402

from report import load  # noqa: E402
from results import unique  # noqa: E402

BLUE, ORANGE, GREEN, PURPLE, SKY, BLACK = "#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#222222"
# colour, marker, fill of the marker, line, hatch
STYLES = {"Limber": (BLUE, "o", BLUE, "-", ""), "btSoftBody": (ORANGE, "^", "white", "--", "////"),
          "btDeformable": (GREEN, "s", "white", ":", "...."), "loose spheres": (BLACK, "x", BLACK, "-.", "xx")}
SERIES = [(BLUE, "o", BLUE, "-", ""), (ORANGE, "^", "white", "--", "////"), (GREEN, "s", "white", ":", "...."),
          (BLACK, "x", BLACK, "-.", "xx"), (PURPLE, "D", "white", "-", "\\\\\\\\")]
SMALLEST = 1e-12  # what is exact to the last bit is drawn here
WIDTH = 8.5       # inches


def style_of(name, index):
    """An engine has the same look in all plots; its second setting, and all else, the looks of the series."""
    if name.startswith("btSoftBody, 10"):
        return SERIES[4]
    return STYLES.get(name.split(",")[0], SERIES[index % len(SERIES)]) if name.startswith("bt") else SERIES[index % len(SERIES)]


def titled(figure, sentence):
    figure.suptitle("\n".join(textwrap.wrap(sentence, 84)), fontsize=12, x=0.02, ha="left")


def finish(axes, title, x_label, y_label=None):
    axes.set_title(title, fontsize=9.5, loc="left")
    axes.set_xlabel(x_label, fontsize=9)
    if y_label:
        axes.set_ylabel(y_label, fontsize=9)
    axes.tick_params(labelsize=8.5)
    axes.grid(True, which="major", color="#d8dbe0", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)


def legend_below(figure, axes, columns):
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="upper center", bbox_to_anchor=(0.5, 0.0), ncol=columns, fontsize=9, frameon=False)


def panels(count, across, height=2.6):
    rows = math.ceil(count / across)
    figure, axes = pyplot.subplots(rows, across, figsize=(WIDTH, height * rows + 1.1), squeeze=False, layout="constrained")
    for unused in axes.flat[count:]:
        unused.axis("off")
    return figure, axes.flat[:count]


# --- errors against times -------------------------------------------------------------------------------------------

def front(points):
    """The points that none beats in both time and error, by time."""
    best, kept = math.inf, []
    for time, error in sorted(points):
        if error < best:
            best = error
            kept.append((time, error))
    return kept


def draw_errors(axes, runs, time, error, title, units):
    lost = 10 * max([v for run in runs if (v := run.get(error)) is not None and math.isfinite(v)] + [SMALLEST])
    for engine in STYLES:
        points = [(run.values[time], min(max(run.values[error], SMALLEST), lost)) for run in runs
                  if run.engine == engine and run.get(error) is not None and time in run.values]
        if not points:
            continue
        colour, marker, fill, line, _ = STYLES[engine]
        axes.plot(*zip(*front(points)), color=colour, linestyle=line, linewidth=1.4)
        axes.plot(*zip(*points), color=colour, marker=marker, markerfacecolor=fill, markersize=5.5, linestyle="none",
                  label=engine)
    axes.set(xscale="log", yscale="log")
    show_numbers(axes)
    if any(math.isinf(run.get(error) or 0.0) for run in runs):
        axes.axhline(lost, color="#888", linewidth=0.8)
        axes.annotate("flown apart", (0.99, lost), xycoords=("axes fraction", "data"), ha="right", va="bottom", fontsize=8)
    finish(axes, title, *units)


def show_numbers(axes):
    """Numbers at 1, 2, 5, 10 ... where the decades alone would be too few."""
    low, high = axes.get_xlim()
    axes.xaxis.set_major_locator(ticker.LogLocator(subs=(1, 2, 5) if high / low < 60 else (1,)))
    axes.xaxis.set_major_formatter(ticker.StrMethodFormatter("{x:g}"))
    axes.xaxis.set_minor_formatter(ticker.NullFormatter())
    low, high = axes.get_ylim()
    if high / low > 60:
        axes.yaxis.set_major_locator(ticker.LogLocator(numticks=7))
    else:
        axes.yaxis.set_major_locator(ticker.LogLocator(subs=(1, 2, 5)))
        axes.yaxis.set_major_formatter(ticker.StrMethodFormatter("{x:g}"))
    axes.yaxis.set_minor_formatter(ticker.NullFormatter())


def first_error(run):
    return next(measure for measure in run.values if measure.startswith("error of "))


SHOWN = ("oscillator", "hanging chain 1e5", "spinning cubes 1e3", "falling chain 1e3", "block cantilever 1e3", "cloth",
         "bar against a wall", "dropped cube 1e3", "stack of 5 cubes")


def is_default(run):
    return run.engine == "Limber" and run.setting == "default"


def compare_engines(usual):
    """In how many scenes Limber's default has a smaller error than all settings of the others, and of how many."""
    better, scenes = 0, 0
    for own in filter(is_default, usual):
        error = first_error(own)
        others = [run.values[error] for run in usual if run.scene == own.scene and run.engine != "Limber" and error in run.values]
        scenes += bool(others)
        better += bool(others) and own.values[error] < min(others)
    return better, scenes


def plot_accuracy(results):
    usual = [run for run in results.select(ticks="60") if run.setting != "all numbers of substeps" and run.values]
    scenes = [scene for scene in SHOWN if any(run.scene == scene for run in usual)] or unique(run.scene for run in usual)[:9]
    figure, axes = panels(len(scenes), min(3, len(scenes)))
    for one, scene in zip(axes, scenes):
        runs = [run for run in usual if run.scene == scene]
        error = first_error(next(filter(is_default, runs), runs[0]))
        draw_errors(one, runs, "tick", error, re.sub(r" 1e(\d)$", r", $10^\1$ N/m", scene),
                    ("time of a tick, µs", error + (", m" if runs[0].units[error] else ", relative")))
    titled(figure, "In {} of {} scenes with a known outcome, Limber by default is more exact than every setting of Bullet's "
                   "soft bodies (60 ticks a second)".format(*compare_engines(usual)))
    legend_below(figure, axes[0], 3)
    yield "accuracy", figure
    for scene in unique(run.scene for run in usual):
        yield f"accuracy-{re.sub('[^a-z0-9]+', '-', scene.lower()).strip('-')}", plot_scene(results, scene)


def plot_scene(results, scene):
    runs = [run for run in results.select(scene=scene) if run.setting != "all numbers of substeps" and run.values]
    errors = unique(m for run in runs for m in run.values if m.startswith("error of "))
    figure, axes = panels(len(errors), len(errors), 3.6)
    for one, error in zip(axes, errors):
        unit = next(run.units[error] for run in runs if error in run.units)
        draw_errors(one, runs, "tick", error, error, ("time of a tick, µs", f"error, {unit or 'relative'}"))
    titled(figure, f"{scene}: all settings, 30 to 240 ticks a second; lines join the best")
    legend_below(figure, axes[0], 3)
    return figure


def plot_contact(results):
    scenes = unique(run.scene for run in results.runs if run.group in ("cloth", "dense") and run.values)
    yield "contact", plot_strains(results, scenes) if scenes else plot_contact_times(results)


def plot_strains(results, scenes):
    figure, axes = panels(len(scenes), 2, 3.0)
    for one, scene in zip(axes, scenes):
        # Stepping::fast() is a budget of ten; Collision::Points has the strain of the default
        runs = [run for run in results.select(scene=scene) if run.engine != "loose spheres" and "::" not in run.setting]
        draw_errors(one, runs, "tick", "strain", scene, ("time of a tick, ms", "strain at rest, %"))
        for run in runs:
            setting = re.sub(r"at most (\d+) substeps", r"\1", run.setting).replace(" iterations", "").replace(" iteration", "")
            if "strain" in run.values:
                one.annotate(setting, (run.values["tick"], run.values["strain"]), xytext=(4, 4), textcoords="offset points",
                             fontsize=7.5)
    titled(figure, "A budget of substeps trades Limber's exactness for time; more iterations hardly help btSoftBody "
                   "(numbers: substeps or iterations)")
    legend_below(figure, axes[0], 3)
    return figure


def plot_contact_times(results):
    runs = [run for run in results.runs if "tick" in run.values]
    return bars(runs, "tick", lambda run: run.scene, lambda run: run.name, "Time of a tick", "time of a tick, ms")


# --- lines against a count ------------------------------------------------------------------------------------------

def draw_lines(axes, runs, x, y, title, units):
    for i, name in enumerate(unique(run.name for run in runs)):
        points = sorted((run.values[x], run.values[y]) for run in runs if run.name == name and y in run.values)
        colour, marker, fill, line, _ = SERIES[i % len(SERIES)]
        if points:
            axes.plot(*zip(*points), color=colour, marker=marker, markerfacecolor=fill, markersize=5, linestyle=line,
                      linewidth=1.4, label=name)
    axes.set_xscale("log", base=2)
    axes.set_yscale("log")
    low, high = axes.get_ylim()
    if high / low < 4:  # a decade has no numbers then
        axes.set_yscale("linear")
        axes.set_ylim(bottom=0)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter(ticker.StrMethodFormatter("{x:g}"))
    finish(axes, title, *units)


def plot_scaling(results):
    runs = results.select(group="cubes")
    figure, axes = panels(2, 2, 3.6)
    draw_lines(axes[0], runs, "bodies", "tick", "simulation", ("cubes", "time of a tick, ms"))
    axes[0].axhline(20, color=BLACK, linewidth=0.8)
    axes[0].annotate("20 ms: real time", (0.01, 20), xycoords=("axes fraction", "data"), va="bottom", fontsize=8)
    draw_lines(axes[1], runs, "bodies", "frame", "drawing", ("cubes", "time of a frame, ms"))
    ends = results.select(group="largest number in real time", engine="Limber", setting="not drawn")
    titled(figure, f"{ends[0].values['cubes in real time']:.0f} soft cubes fall in real time at 50 ticks a second" if ends
           else "Time of soft cubes by their number")
    legend_below(figure, axes[0], 4)
    yield "scaling", figure


# --- bars of categories ---------------------------------------------------------------------------------------------

def draw_bars(axes, runs, measure, category, series, percent=False):
    categories, names = unique(map(category, runs)), unique(map(series, runs))
    height = 0.84 / len(names)
    for i, name in enumerate(names):
        found = {category(run): run.values[measure] for run in runs if series(run) == name and measure in run.values}
        y = [categories.index(c) - 0.42 + height * (i + 0.5) for c in found]
        colour, _, _, _, hatch = style_of(name, i)
        drawn = axes.barh(y, found.values(), 0.92 * height, color=colour, hatch=hatch, edgecolor="white", linewidth=0.3,
                          label=name)
        labels = [f"{v:.0f}" if percent or v >= 100 else f"{v:.2g}" if v < 10 else f"{v:.3g}" for v in found.values()]
        axes.bar_label(drawn, labels, padding=2, fontsize=7)
    axes.set_yticks(range(len(categories)), categories)
    axes.set_ylim(len(categories) - 0.5, -0.5)
    axes.margins(x=0.1)


def bars(runs, measure, category, series, sentence, x_label, percent=False):
    names, categories = unique(map(series, runs)), unique(map(category, runs))
    height = max(3.2, 0.12 * len(names) * len(categories) + 1.6)
    figure, axes = pyplot.subplots(figsize=(WIDTH, height), layout="constrained")
    draw_bars(axes, runs, measure, category, series, percent)
    finish(axes, "", x_label)
    axes.grid(False, axis="y")
    titled(figure, sentence)
    legend_below(figure, axes, min(3, len(names)))
    return figure


class Share:
    """The share of the runs of a group that pass, as if it were a run."""

    def __init__(self, group, name, runs):
        passed = [run.values["passed"] for run in runs if "passed" in run.values]
        self.group, self.name = group, name
        self.values = {"passed": 100 * sum(passed) / len(passed)} if passed else {}


def plot_stability(results):
    names = [name for name in unique(run.name for run in results.runs)
             if not name.startswith("Limber") or name == "Limber, default"]
    groups = unique(run.group for run in results.runs)
    shares = [Share(group, name, [run for run in results.runs if run.name == name and group in (run.group, "all cases")])
              for group in groups + ["all cases"] for name in names]
    total = {share.name: share.values.get("passed", 0.0) for share in shares if share.group == "all cases"}
    own = total.get("Limber, default", 0.0)
    others = [value for name, value in total.items() if name != "Limber, default"]
    sentence = f"Limber passes {own:.0f} % of the hard cases" + (
        f", Bullet's soft bodies {min(others):.0f} to {max(others):.0f} %" if others else "")
    yield "stability", bars(shares, "passed", lambda s: s.group, lambda s: s.name, sentence,
                            "cases without a miss, % of those that the engine can take part in", percent=True)


SHAPES = {"ico": "sphere", "cyl": "cylinder", "lshape": "L", "noise": "bumpy sphere", "hull": "convex body"}


def shape_name(scene):
    name, points, rest = re.fullmatch(r"([a-z]+)(\d+)(.*)", scene).groups()
    return f"{SHAPES.get(name, name)}{rest}, {points} points"


def plot_networks(results):
    runs = results.select(group="returns")
    scenes, rules = unique(run.scene for run in runs), unique(run.setting for run in runs)
    rules.sort(key=lambda rule: not rule.startswith("pipeline"))  # its markers are behind the others
    figure, axes = pyplot.subplots(figsize=(WIDTH, 0.27 * len(scenes) + 2.0), layout="constrained")
    for (colour, marker, fill, _, _), rule in zip(SERIES, rules):
        own = [run for run in runs if run.setting == rule]
        axes.plot([run.values["returns"] for run in own], [scenes.index(run.scene) for run in own], color=colour,
                  marker=marker, markerfacecolor=fill if marker == "o" else "none", markersize=10 if marker == "o" else 7,
                  markeredgewidth=1.5, linestyle="none", label=rule, clip_on=False)
    axes.set_yticks(range(len(scenes)), [shape_name(scene) for scene in scenes])
    axes.set_ylim(len(scenes) - 0.5, -0.5)
    axes.set_xlim(-2, 102)
    finish(axes, "", "bodies that come back from large deformations, % of the seeded runs")
    full = sum(run.values["returns"] >= 99 for run in runs if run.setting.startswith("pipeline"))
    titled(figure, f"With braces of the pipeline, {full} of {len(scenes)} shapes come back from at least 99 % of the "
                   "deformations")
    legend_below(figure, axes, 5)
    yield "networks", figure


def plot_render(results):
    runs = [run for run in results.runs if run.group in ("cubes", "ball")]
    context = runs[-1].setting if runs else ""
    largest = "1920x1080" if any("1920x1080" in run.scene for run in runs) else "1280x720"
    runs = [run for run in runs if run.setting == context and largest in run.scene and not run.scene.startswith("64 ")]
    if not runs:
        return
    figure, axes = pyplot.subplots(1, 2, figsize=(WIDTH, 0.25 * len(runs) + 1.8), sharey=True, layout="constrained")
    for one, (measure, title) in zip(axes, (("upload and submit, own time", "sending bodies to the driver"),
                                            ("frame, all threads", "whole frame, with a rasteriser on the CPU"))):
        draw_bars(one, runs, measure, lambda run: run.scene.replace(f", {largest}", "").replace(", ", ",\n"),
                  lambda run: run.engine)
        finish(one, title, "time of all threads, ms" if "all" in measure else "time of the calling thread, ms")
        one.grid(False, axis="y")
    titled(figure, f"Limber sends many bodies in a fraction of the time; pixels take most of the frame ({context})")
    legend_below(figure, axes[0], 3)
    yield "render", figure


def plot_springs(results):
    runs = results.select(scene="free")
    figure = bars(runs, "spring and substep", lambda run: run.setting, lambda run: run.group,
                  "Lanes of several bodies make springs cheapest", "time per spring and substep, ns")
    yield "springs", figure


def plot_threads(results):
    runs = [run for run in results.runs if "gain" in run.values and run.setting != "1 thread"]
    figure = bars(runs, "gain", lambda run: run.scene, lambda run: run.setting,
                  "Several threads help many bodies and large ones", "speed over one thread; bar ends: measured, "
                  "vertical strokes: the most that is possible")
    axes, scenes, settings = figure.axes[0], unique(run.scene for run in runs), unique(run.setting for run in runs)
    height = 0.84 / len(settings)
    y = [scenes.index(run.scene) - 0.42 + height * (settings.index(run.setting) + 0.5) for run in runs]
    axes.scatter([run.values["largest possible gain"] for run in runs], y, marker="|", s=110, color=BLACK)
    yield "threads", figure


PLOTS = {name.removeprefix("plot_"): globals()[name] for name in (
    "plot_accuracy", "plot_contact", "plot_networks", "plot_render", "plot_scaling", "plot_springs", "plot_stability",
    "plot_threads")}


def main(bench, folder, pictures=None):
    folder = pathlib.Path(folder)
    for name, figure in PLOTS[bench](load(bench, folder)):
        for ending in ("svg", "png"):
            figure.savefig(folder / f"{name}.{ending}", dpi=100, bbox_inches="tight")
        pyplot.close(figure)
        if pictures and name == bench:
            shutil.copy(folder / f"{name}.png", pictures)
    print(f"plots in {folder}", file=sys.stderr)


if __name__ == "__main__":
    if len(sys.argv) not in (3, 4) or sys.argv[1] not in PLOTS:
        sys.exit(__doc__)
    main(*sys.argv[1:])
