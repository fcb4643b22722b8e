# SPDX-License-Identifier: Zlib
"""Tables and targets of FOLDER/BENCH.csv: report.py BENCH FOLDER [READMES...]

Prints them, and writes FOLDER/BENCH.txt. Renews what lies between the markers of READMEs:  <!-- table BENCH -->,
<!-- targets BENCH -->, <!-- misses -->  and  <!-- end -->."""

import csv
import pathlib
import re
import sys

from results import Results, Run, number, order, unique

ROUNDING = 2e-8  # errors below are those of Bullet's floats
BEST = "the best setting"


class Table:
    """`brief`: also for the README."""

    def __init__(self, title, header, rows, brief=False):
        self.title, self.header, self.rows, self.brief = title, header, rows, brief

    def text(self):
        lines = [self.header] + self.rows
        widths = [max(len(line[i]) for line in lines) for i in range(len(self.header))]
        cells = ["  ".join([line[0].ljust(widths[0])] + [c.rjust(w) for c, w in zip(line[1:], widths[1:])])
                 for line in lines]
        return "\n".join([self.title] + [("  " + line).rstrip() for line in cells]) + "\n"

    def markdown(self):
        lines = [self.header, ["---"] * len(self.header)] + self.rows
        return self.title + ":\n\n" + "".join("| " + " | ".join(line) + " |\n" for line in lines)


# --- two kinds of tables -------------------------------------------------------------------------------------------

def with_unit(runs, measure):
    unit = next((run.units[measure] for run in runs if measure in run.units), "")
    return f"{measure}, {unit}" if unit else measure


def columns(title, runs, measures=(), label=lambda run: f"{run.scene}: {run.name}", brief=False):
    """A line for each run, a column for each measure."""
    measures = measures or unique(m for run in runs for m in run.values)
    rows = [[label(run)] + [number(run.get(m)) for m in measures] for run in runs if "no result" not in run.texts]
    return Table(title, [""] + [with_unit(runs, m) for m in measures], rows, brief)


def grid(title, runs, cell, row=lambda run: run.scene, column=lambda run: run.name, brief=False):
    """A line for each scene, a column for each engine."""
    names = unique(column(run) for run in runs)
    found = {(row(run), column(run)): cell(run) for run in runs}
    rows = [[line] + [found.get((line, name), "") for name in names] for line in unique(row(run) for run in runs)]
    return Table(title, [""] + names, rows, brief)


# --- tables of the benches ------------------------------------------------------------------------------------------

def errors_of(run):
    return [m for m in run.values if m.startswith("error of ")]


def best(runs, measure):
    return min((run for run in runs if run.get(measure) is not None), key=lambda run: run.values[measure], default=None)


def best_cells(run, measure):
    return [run.setting, number(run.get(measure)), number(run.get("tick"))] if run else ["-"] * 3


def accuracy_line(results, own, measure):
    others = [best(results.select(scene=own.scene, ticks=own.ticks, engine=engine), measure)
              for engine in ("btSoftBody", "btDeformable")]
    cells = [f"{own.scene}: {with_unit([own], measure).removeprefix('error of ')}", number(own.values[measure]),
             number(own.get("springs")), number(own.get("tick"))]
    return cells + [cell for other in others for cell in best_cells(other, measure)]


def accuracy_tables(results):
    header = ["error of", "Limber", "springs, µs", "tick, µs", "btSoftBody, best", "error", "tick, µs",
              "btDeformable, best", "error", "tick, µs"]
    tables = []
    for group in ("free motion", "with contacts"):
        runs = results.select(group=group, engine="Limber", setting="default", ticks="60")
        lines = {(run, measure): accuracy_line(results, run, measure) for run in runs for measure in errors_of(run)}
        compared = [line for (run, measure), line in lines.items() if measure == errors_of(run)[0] and line[4] != "-"]
        tables += [Table(f"{group}, 60 ticks a second", header, list(lines.values())),
                   Table(f"Errors and times, {group}, 60 ticks a second", header, compared, brief=True)]
    orders = [run for run in results.runs if run.setting == "all numbers of substeps"]
    tables.append(columns("order of the error with Limber's substep (Verlet, 60 ticks a second)", orders,
                          label=lambda run: run.scene))
    tables.append(tick_orders(results))
    remarks = [[run.scene, run.texts["remark"]] for run in results.select(group="remarks")]
    return tables + [Table("for orientation", ["scene", ""], remarks)]


def short_table(results):
    """For the front page: some scenes, times as springs / whole tick."""
    rows = []
    for scene in ("oscillator", "chain with 10 000 x end mass", "spinning cubes 1e3", "spinning cubes 1e5",
                  "block cantilever 1e3", "block cantilever 1e5", "cloth", "dropped cube 1e3", "dropped cube 1e4",
                  "dropped cube 1e5", "cube on a free box of 1 kg"):
        for own in results.select(scene=scene, engine="Limber", setting="default", ticks="60"):
            line = accuracy_line(results, own, errors_of(own)[0])
            rows.append([line[0], line[1], line[5], f"{line[2]} / {line[3]}", line[6]])
    header = ["Scene: error of", "Limber", "btSoftBody", "Limber's time, µs", "btSoftBody's time, µs"]
    return Table("Errors, and times of a tick (Limber's springs / whole tick)", header, rows)


def tick_orders(results):
    engines = [("Limber", "default"), ("Limber", "Verlet, 8 x substeps"), ("btDeformable", "implicit"),
               ("btDeformable", "explicit"), ("btSoftBody", "10 iterations, calibrated")]
    rows = []
    for scene in unique(run.scene for run in results.runs if run.setting == "all numbers of substeps"):
        slopes = []
        for engine, setting in engines:
            runs = results.select(scene=scene, engine=engine, setting=setting)
            errors = [run.values[errors_of(run)[0]] for run in runs]
            slopes.append(number(order([1 / float(run.ticks) for run in runs], errors)))
        rows.append([scene] + slopes)
    return Table("order of the error with the tick", [""] + [", ".join(engine) for engine in engines], rows)


def add_orders(results):
    """Adds a run for each scene that was played with 1, 2, 4 ... times the substeps that it needs."""
    refined = re.compile(r"Verlet, (\d+) x substeps")
    for scene in unique(run.scene for run in results.select(setting=refined, ticks="60")):
        runs = results.select(scene=scene, setting="Verlet", ticks="60") + results.select(
            scene=scene, setting=refined, ticks="60")
        measure = errors_of(runs[0])[0]
        steps = [1 / int(m[1]) if (m := refined.fullmatch(run.setting)) else 1.0 for run in runs]
        errors = [run.get(measure) or 0.0 for run in runs]
        # coarse steps may be too large to show the order, and rounding hides the smallest errors
        finest = [(s, e) for s, e in zip(steps, errors) if e >= ROUNDING][-3:]
        derived = Run((runs[0].group, scene, "60", "Limber", "all numbers of substeps"))
        slope = order(*zip(*finest)) if len(finest) > 1 else None
        if slope is not None:
            derived.values["order"] = slope
        for step, error in zip(steps, errors):
            derived.values[f"error, {1 / step:.0f} x substeps"] = error
        results.runs.append(derived)


def miss_ratio(runs, measure):
    asked = [run.values[measure] for run in runs if measure in run.values]
    return f"{sum(asked):.0f} / {len(asked)}" if asked else "-"


def stability_line(runs, name):
    checks = ("finite", "energy", "momentum drift", "angular momentum drift", "shape error", "points on the wrong side")
    ran = [run.values["passed"] for run in runs if "passed" in run.values]
    shapes = [run.texts.get("shape") for run in runs]
    held = sum(shapes.count(shape) for shape in ("other balance", "saddle", "spinning"))
    return ([name, str(len(runs) - len(ran))] + [miss_ratio(runs, "missed: " + check) for check in checks]
            + [str(shapes.count("mirrored")), str(held), f"{100 * sum(ran) / max(1, len(ran)):.1f} %"])


def stability_tables(results):
    header = ["missed / asked", "not run", "not finite", "energy above 1.001", "momentum drift above 1e-6",
              "angular momentum off by 1e-3", "shape not back within 1e-3", "on the wrong side", "mirrored",
              "held in another shape", "passed"]
    names = unique(run.name for run in results.runs)
    of = {name: [run for run in results.runs if run.name == name] for name in names}
    tables = [Table("all cases", header, [stability_line(of[name], name) for name in names], brief=True)]
    for group in unique(run.group for run in results.runs):
        lines = [stability_line([run for run in of[name] if run.group == group], name) for name in names]
        tables.append(Table(group, header, lines))
    lines = [[reason, str(len(runs))] for reason, runs in reasons(results.runs).items()]
    return tables + [Table("cases that an engine does not support", ["", "runs"], lines), first_misses(results)]


def first_misses(results):
    rows = []
    for setting, group in unique((run.setting, run.group) for run in results.select(engine="Limber")):
        missed = [run for run in results.select(engine="Limber", setting=setting, group=group) if not run.get("passed")]
        if missed:
            run = missed[0]
            flaws = [f"{m[8:]} {number(run.get(m[8:]))}" for m in run.values if m.startswith("missed") and run.values[m]]
            rows.append([f"{setting}: {run.scene}, {run.ticks} ticks a second", "; ".join(flaws), str(len(missed) - 1)])
    return Table("where Limber misses: the first of each group", ["", "", "more"], rows)


def reasons(runs):
    found = {}
    for run in runs:
        if "no result" in run.texts:
            found.setdefault(f"{run.name}: {run.texts['no result']}", []).append(run)
    return found


def contact_cell(run):
    if "no result" in run.texts:
        return run.texts["no result"]
    return f"{number(run.get('tick'))} ({number(run.get('worst tick'))})"


def is_budget(run):
    return run.setting.startswith("at most")


def cloth_cell(run):
    strain = f", {number(run.get('strain'))} %" if "strain" in run.values else ""
    return contact_cell(run) + strain


def contact_tables(results):
    runs = [run for run in results.runs if run.group != "memory"]
    usual = [run for run in runs if not is_budget(run) and run.setting not in ("1 iteration", "10 iterations")]
    sheets = [run for run in runs if run.group == "cloth" and run.engine != "loose spheres"]
    tables = [grid("Milliseconds a tick, median (worst)", usual, contact_cell, brief=True),
              grid("Strain of the springs along edges, %", [r for r in usual if r.get("strain") and r.group != "airborne"],
                   lambda run: number(run.get("strain")), brief=True),
              grid("Deepest penetration, % of the size", [r for r in usual if r.get("deepest penetration")],
                   lambda run: number(run.get("deepest penetration")), brief=True),
              grid("Cloths: milliseconds a tick (worst), strain", sheets, cloth_cell, row=lambda run: run.name,
                   column=lambda run: run.scene, brief=True)]
    for scene in unique(run.scene for run in runs):
        own = [run for run in runs if run.scene == scene]
        tables.append(columns(scene, own, label=lambda run: run.name))
    return tables + [columns("Memory of Limber", results.select(group="memory"), label=lambda run: run.name, brief=True)]


def networks_tables(results):
    shapes = results.select(group="returns")
    tables = [grid("Returns from large deformations, % of the runs", shapes, lambda run: number(run.get("returns")),
                   column=lambda run: run.setting, brief=True)]
    by_scene = ("mechanisms", "any mesh", "bars", "cooking")
    for group in unique(run.group for run in results.runs):
        label = (lambda run: run.scene) if group in by_scene else (lambda run: f"{run.scene}: {run.setting}")
        measures = [m for m in unique(m for run in results.select(group=group) for m in run.values)
                    if group not in ("cooking", "any mesh") or not m.startswith(("returns, ", "failed"))]
        tables.append(columns(group.capitalize(), results.select(group=group), measures, label=label,
                              brief=group in ("any mesh", "bars", "cooking", "skins")))
    return tables


def springs_tables(results):
    def cell(run):
        free = results.by_fields[(run.group, "free") + run.fields[2:]].values["spring and substep"]
        own = run.values["spring and substep"]
        return number(own) if run.scene == "free" else f"{100 * (own / free - 1):+.0f} %"
    return [grid("Nanoseconds per spring and substep, cubes of 8 points and 28 springs; at rest: what the contacts "
                 "add", results.runs, cell, row=lambda run: run.setting,
                 column=lambda run: f"{run.group}, {run.scene}", brief=True)]


def gain_cell(run):
    return run.texts.get("no result") or f"{number(run.get('gain'))} ({number(run.get('largest possible gain'))})"


def threads_tables(results):
    single = [run for run in results.runs if "outside the parallel parts" in run.values]
    return [grid("Gain over one thread (largest possible gain)", results.runs, gain_cell, column=lambda run: run.setting, brief=True),
            columns("One thread", single, ["tick, wall time"] + [m for m in single[0].values if "outside" in m or
                                                                 "gain of" in m], label=lambda run: run.scene,
                    brief=True)]


def render_tables(results):
    measures = ["upload", "upload and submit, own time", "frame", "frame, all threads", "sent per frame", "buffers"]
    frames = [run for run in results.runs if "draw calls" in run.values and "1920x1080" in run.scene
              and not re.match("(64|128) ", run.scene)]
    skins = results.select(group="skins")
    tables = [columns("Frames of 1920x1080", frames, measures, brief=True),
              columns("Memory", results.select(group="memory"), brief=True),
              grid("Frames of smooth bodies on 100 points, 1280x720 without shadows, ms of all threads", skins,
                   lambda run: number(run.get("frame, all threads")), column=lambda run: run.setting, brief=True),
              columns("64 cubes dropped, 1920x1080", results.select(group="files"), label=lambda run: run.setting, brief=True)]
    return tables + [columns(group, results.select(group=group)) for group in unique(run.group for run in results.runs)]


def scaling_cell(run):
    frame = run.get("frame")
    return number(run.get("tick")) + (f" / {number(frame)}" if frame is not None else "")


def scaling_tables(results):
    cubes = [run for run in results.select(group="cubes") if "no result" not in run.texts]
    cubes.sort(key=lambda run: run.values["bodies"])
    tables = [grid("Milliseconds a tick, and a frame where one is drawn", cubes, scaling_cell, brief=True),
              columns("Largest number in real time (the paper, on its author's machine: 64 cubes at 1.43 ms a tick)",
                      results.select(group="largest number in real time"), label=lambda run: run.name, brief=True)]
    tables += [columns(name, [run for run in cubes if run.name == name], label=lambda run: run.scene)
               for name in unique(run.name for run in cubes)]
    return tables + [warnings(results)]


def warnings(results):
    rows = []
    for scene in unique(run.scene for run in results.select(group="cubes", engine="Limber")):
        runs = [run for run in results.select(group="cubes", scene=scene, engine="Limber") if run.get("complete")]
        if len({run.texts["hash"] for run in runs}) > 1 or any(not run.values["runs end alike"] for run in runs):
            rows.append([scene, "WARNING: runs do not end in the same state"])
    return Table("warnings", ["", ""], rows)


TABLES = {"accuracy": accuracy_tables, "contact": contact_tables, "networks": networks_tables, "render": render_tables,
          "scaling": scaling_tables, "springs": springs_tables, "stability": stability_tables, "threads": threads_tables}


def busy_warning(results):
    """Other programs affect even a thread's own time, through shared caches."""
    pairs = [(run.get("tick, wall time"), run.get("tick") or run.get("tick, own time")) for run in results.runs]
    pairs = [(wall, own) for wall, own in pairs if wall and own]
    ratio = sum(wall for wall, _ in pairs) / sum(own for _, own in pairs) if pairs else 1.0
    return f"WARNING: the machine was busy: ticks took {ratio:.2f} times their own time\n" if ratio > 1.1 else ""


# --- targets --------------------------------------------------------------------------------------------------------

class Verdict:
    def __init__(self, target, run, value, hit):
        self.target, self.run, self.value, self.hit = target, run, value, hit

    def setting(self):
        """The setting, where the target does not name it."""
        return [] if self.run.setting in ("", self.target["setting"]) else [self.run.setting]

    def reached(self):
        if self.value is None:
            return "not measured"
        is_small_ratio = self.target["compare"].startswith("ratio") and 0 < self.value < 0.1
        value = f"1/{number(1 / self.value)}" if is_small_ratio else number(self.value)
        return value + (f" ({', '.join([self.run.scene] + self.setting())})" if self.run else "")

    def word(self):
        return "-" if self.value is None else "hit" if self.hit else "MISS"

    def cells(self):
        why = f": {self.target['why']}" if self.word() == "MISS" and self.target["why"] else ""
        return [self.target["what"], self.reached(), self.word() + why]


def merged(found):
    """A line for each target: its misses, or a hit; of several hits alone the number and the weakest."""
    lines = []
    for target in unique(verdict.target["what"] for verdict in found):
        own = [verdict for verdict in found if verdict.target["what"] == target]
        missed = [verdict for verdict in own if not verdict.hit]
        hits = len(own) - len(missed)
        shown = missed or [own[0] if len(own) == 1 else weakest(own)]
        text = ", ".join(verdict.reached() for verdict in shown)
        if hits and len(own) > 1:
            text += f"; {hits} of {len(own)} hit" if missed else f" is the weakest of {hits}"
        lines.append([target, text, shown[0].cells()[2]])
    return lines


def weakest(found):
    largest = found[0].target["relation"] == "<="
    return (max if largest else min)(found, key=lambda verdict: verdict.value)


def partner(results, run, rule, measure):
    """The run that a target compares with: FIELD=VALUE or FIELD:OLD>NEW, separated by semicolons."""
    wanted = dict(zip(("group", "scene", "ticks", "engine", "setting"), run.fields))
    for change in rule.split(";"):
        if ":" in change:
            field, old, new = re.split("[:>]", change)
            wanted[field] = wanted[field].replace(old, new)
        else:
            field, wanted[field] = change.split("=")
    if wanted["setting"] == BEST:
        del wanted["setting"]
    return best(results.select(**wanted), measure)


def judge_run(results, target, run):
    """Value and whether it hits, or None if there is nothing to compare."""
    value, in_time = run.get(target["measure"]), True
    if value is not None and target["against"]:
        other = partner(results, run, target["against"], target["measure"])
        reference = other.get(target["of"] or target["measure"]) if other else None
        if not reference:
            return None
        value = value - reference if target["compare"] == "difference" else value / reference
        if target["compare"] == "ratio in no more time":
            in_time = run.values["springs"] <= other.values["tick"]
    elif value is not None and target["of"]:
        value /= run.values[target["of"]]
    if value is None:
        return None
    bound = float(target["bound"])
    return value, in_time and (value <= bound if target["relation"] == "<=" else value >= bound)


def wanted_runs(results, target):
    fields = {field: re.compile(target[field]) for field in ("group", "scene", "engine", "setting", "ticks")
              if target[field]}
    return results.select(**fields)


def judge(results, target):
    judged = [(run, *found) for run in wanted_runs(results, target)
              if (found := judge_run(results, target, run)) is not None]
    if not judged:
        return [] if target["show"] == "if measured" else [Verdict(target, None, None, False)]
    if target["over"] == "each":
        return [Verdict(target, *one) for one in judged]
    if target["over"] == "any":
        scenes = unique(run.scene for run, _, _ in judged)
        return [Verdict(target, *min((one for one in judged if one[0].scene == scene),
                                     key=lambda one: (not one[2], one[1]))) for scene in scenes]
    if target["over"] == "sum":
        total = sum(value for _, value, _ in judged)
        return [Verdict(target, None, total, total <= float(target["bound"]))]
    sign = 1 if target["relation"] == "<=" else -1
    return [Verdict(target, *max(judged, key=lambda one: (not one[2], sign * one[1])))]


def verdicts(bench, results, brief=False):
    """`brief`: without the targets that only the text report shows."""
    with open(pathlib.Path(__file__).with_name("targets.csv"), newline="") as file:
        targets = [row for row in csv.DictReader(file)
                   if row["bench"] == bench and not (brief and row["show"] == "text")]
    return [verdict for target in targets for verdict in judge(results, target)]


# --- output ---------------------------------------------------------------------------------------------------------

def load(bench, folder):
    results = Results(folder / f"{bench}.csv")
    if bench == "accuracy":
        add_orders(results)
    for run in results.runs:
        if bench == "render" and "upload" in run.values:
            run.values["upload and submit"] = run.values["upload"] + run.values["submit"]
    return results


def report(bench, folder):
    results = load(bench, folder)
    text = "\n".join(f"{name}: {value}" for name, value in results.about.items()) + "\n"
    tables = [table for table in TABLES[bench](results) if table.rows]
    text += "".join("\n" + table.text() for table in tables)
    lines = [verdict.cells() for verdict in verdicts(bench, results)]
    if lines:
        text += "\ntargets\n" + "".join(f"  {w[:4]:4}  {what}: {value}{w[4:]}\n" for what, value, w in lines)
    return text + busy_warning(results)


def renew(readme, marker, content):
    pattern = re.compile(rf"(<!-- {marker} -->\n).*?(<!-- end -->)", re.S)
    return pattern.sub(lambda m: m[1] + content + m[2], readme)


def head(results):
    options = results.about.get("options", "none")
    text = f"Measured on {results.about['machine']}, commit {results.about['commit']}"
    if options != "none":
        text += f", with `{options}`"
    return text + ".\n" + busy_warning(results) + "\n"


def renew_readme(path, bench, folder):
    results, text = load(bench, folder), path.read_text()
    tables = [table.markdown() for table in TABLES[bench](results) if table.brief and table.rows]
    text = renew(text, f"table {bench}", head(results) + "\n".join(tables))
    if bench == "accuracy":
        text = renew(text, "table accuracy short", head(results) + short_table(results).markdown())
    lines = merged(verdicts(bench, results, brief=True))
    text = renew(text, f"targets {bench}", Table("Targets", ["Target", "Reached", ""], lines).markdown())
    path.write_text(text)


def renew_misses(path):
    """All missed targets of the page, whichever run measured them."""
    text, rows = path.read_text(), []
    for bench in TABLES:
        targets = re.search(rf"<!-- targets {bench} -->\n(.*?)<!-- end -->", text, re.S)
        cells = [line.strip("| ").split(" | ") for line in targets[1].splitlines()] if targets else []
        rows += [[bench] + line[:2] for line in cells if line[-1].startswith("MISS")]
    table = Table("All missed targets", ["Bench", "Target", "Reached"], rows)
    path.write_text(renew(text, "misses", table.markdown()))


def main(bench, folder, *readmes):
    folder = pathlib.Path(folder)
    text = report(bench, folder)
    (folder / f"{bench}.txt").write_text(text)
    print(text, end="")
    for path in readmes:
        renew_readme(pathlib.Path(path), bench, folder)
        renew_misses(pathlib.Path(path))


if __name__ == "__main__":
    if len(sys.argv) < 3 or sys.argv[1] not in TABLES:
        sys.exit(__doc__)
    main(*sys.argv[1:])
