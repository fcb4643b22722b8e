# SPDX-License-Identifier: Zlib
"""Makes small runs of limber-bench and checks their output: check_bench.py CHECK PROGRAM DRAWING_PROGRAM BENCH_FOLDER

Checks counts, states, fractions and errors; times must only be positive and consistent."""

import csv
import os
import pathlib
import re
import subprocess
import sys
import tempfile

sys.path.insert(0, sys.argv[-1])
import report  # noqa: E402  (of the bench's folder)
import results  # noqa: E402

COLUMNS = ("bench,group,scene,ticks_per_s,engine,setting,measure,unit,value,lower_quartile,upper_quartile,"
           "samples").split(",")
SMALL = ["--quick", "--set", "maxBodies=4", "--set", "width=64", "--set", "height=36"]
SKIPPED = 77

# part of the names of scenes, the measure, the setting of Limber, the largest error for any tick length
ACCURACY_BOUNDS = [
    ("oscillator", "period", "period tolerance 1e-04", 1e-4),
    ("oscillator", "amplitude", "default", 1e-3),
    ("hanging chain", "sag", "default", 1e-4),
    ("stiff pendulum", "period", "default", 1e-4),
    ("falling chain", "shape", "Verlet, 4 x substeps", 1e-3),
    ("rest on a triangle mesh", "height", "default", 1e-6),
    ("rest on a triangle mesh", "force", "default", 1e-4),
    ("dropped cube 1e3", "rebound", "default", 0.05),
    ("incline 0.97", "creep", "default", 1e-5),
    ("incline 1.03", "acceleration", "default", 5e-3),
]
FLOOR_BOUNDS = [(scene, *bound) for scene in ("rest on a plane", "rest on a box", "rest on a hull")
                for bound in (("height", "default", 1e-6), ("force", "default", 1e-4))]


ANY_TICK = re.compile("[0-9]+")


def run(*command):
    return subprocess.run([str(c) for c in command], capture_output=True, text=True, check=False)


def expect(condition, message):
    if not condition:
        sys.exit(f"check_bench: {message}")


class Folder:
    """A temporary folder with the results of runs."""

    def __init__(self, program):
        self.program = program

    def __enter__(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.path = pathlib.Path(self.temporary.name) / "made" / "on the way"
        return self

    def __exit__(self, *_):
        self.temporary.cleanup()

    def bench(self, name, *options):
        """Runs a bench; returns its results and the report on them."""
        done = run(self.program, name, *options, "--out", self.path)
        expect(done.returncode == 0, f"exit status {done.returncode}: {done.stderr}")
        with open(self.path / f"{name}.csv", newline="") as file:
            rows = list(csv.DictReader(file))
        expect(list(rows[0]) == COLUMNS, f"columns: {list(rows[0])}")
        for row in rows:
            check_row(row, name)
        return report.load(name, self.path), report.report(name, self.path)

    def plots(self, bench, name, *pictures):
        """Draws the plots of a bench and checks that they are there. Short tests draw those of one bench only."""
        if name not in os.environ.get("LIMBER_PLOTS", name).split(","):
            return
        done = run(bench / "plot", name, self.path)
        if done.returncode == SKIPPED:
            sys.exit(SKIPPED)
        expect(done.returncode == 0, done.stderr)
        for picture in pictures:
            for ending in ("svg", "png"):
                file = self.path / f"{picture}.{ending}"
                expect(file.exists() and file.stat().st_size > 1000, f"{file.name} is empty")


def check_row(row, bench):
    expect(row["bench"] == bench and row["group"] and row["measure"] and row["value"], f"incomplete: {row}")
    if row["samples"]:
        quartiles = [float(row[name]) for name in ("lower_quartile", "value", "upper_quartile")]
        expect(sorted(quartiles) == quartiles and int(row["samples"]) > 0, f"quartiles: {row}")


def timed(one, *measures):
    expect(all(one.values[measure] > 0 for measure in measures), f"times: {one.fields} {one.values}")


def refuses(program, bench, wrong, word=""):
    done = run(program, *bench.split(), *wrong.split(), "--out", tempfile.gettempdir())
    expect(done.returncode == 2, f"{bench} {wrong}: exit status {done.returncode}")
    expect(word in done.stderr + done.stdout, f"{bench} {wrong}: does not name {word}: {done.stderr}")


# --- the report -----------------------------------------------------------------------------------------------------

def check_report(*_):
    """Checks orders, numbers and verdicts on made-up results."""
    expect(abs(results.order([1, 0.5, 0.25], [8e-3, 2e-3, 5e-4]) - 2) < 1e-12, "order")
    expect(abs(results.order([1, 0.5, 0.25], [float("inf"), 2e-3, 1e-3]) - 1) < 1e-12, "what flew apart is left out")
    expect(results.order([1, 0.5], [0.0, 1e-3]) is None, "no order of one point")
    expect([results.number(x) for x in (0, 512, 0.0123, 7.4e-5, 1e5)] == ["0", "512", "0.0123", "7.4e-5", "100000"], "numbers")
    made = ["accuracy,free motion,cloth,60,Limber,default,error of shape,,1e-4,,,",
            "accuracy,free motion,cloth,60,Limber,default,springs,us,5,,,",
            "accuracy,free motion,cloth,60,btSoftBody,a,error of shape,,2e-2,,,",
            "accuracy,free motion,cloth,60,btSoftBody,a,tick,us,9,,,",
            "accuracy,free motion,cloth,60,btSoftBody,b,error of shape,,3e-2,,,"]
    for springs, word in (("5", "hit"), ("10", "MISS")):
        with tempfile.TemporaryDirectory() as name:
            path = pathlib.Path(name) / "accuracy.csv"
            path.write_text("\n".join([",".join(COLUMNS)] + made).replace(",us,5,", f",us,{springs},"))
            verdict = report.verdicts("accuracy", results.Results(path))[0]
            expect(verdict.cells()[2].startswith(word) and abs(verdict.value - 0.005) < 1e-12, f"{word}: {verdict.cells()}")
    shapes = [results.Run(("free", str(i), "60", "Limber", "default")) for i in range(6)]
    for one, shape in zip(shapes, ("yes", "mirrored", "other balance", "saddle", "spinning", "no")):
        one.texts["shape"] = shape
    expect(report.stability_line(shapes, "Limber")[-3:-1] == ["1", "3"], "mirrored, and held in another shape")


def check_names(program, drawing, _):
    for name in ("scalin", "", "../scaling"):
        done = run(program, name)
        expect(done.returncode == 2, f"{name!r}: exit status {done.returncode}")
        expect("accuracy" in done.stderr, f"{name!r}: does not list what there is: {done.stderr}")
    expect(run(program).returncode == 2, "no name is no error")
    expect("springs" in run(program, "--list").stdout, "--list does not list")
    expect("scaling" in run(drawing, "--list").stdout, "--list does not list what draws")


def check_unwritable_folder(_, drawing, __):
    with tempfile.TemporaryDirectory() as name:
        file = pathlib.Path(name) / "a_file"
        file.write_text("")
        blocked = pathlib.Path(name) / "blocked"
        (blocked / "scaling.csv").mkdir(parents=True)
        for folder in (file, file / "below", blocked, "/proc/limber"):
            done = run(drawing, "scaling", *SMALL, "--out", folder)
            expect(done.returncode == 1, f"{folder}: exit status {done.returncode}")
            expect("cannot" in done.stderr, f"{folder}: no reason: {done.stderr}")


def check_bad_options(program, drawing, _):
    bad = ("seconds=0", "seconds=nan", "maxBodies=0", "maxBodies=-1", "width=10", "height=0", "repeats=0", "minutes=0",
           "counts=0", "counts=1,x", "sleep=maybe")
    for pair in bad:
        refuses(drawing, "scaling", f"--set {pair}", pair.split("=")[0])
    refuses(drawing, "scaling", "--set hurry=1", "counts, seconds, maxBodies")
    for bench in ("accuracy", "contact", "threads", "stability", "networks"):
        for wrong in ("--scene nothing", "--fast", "more", "--set", "--set repeats", "--set nonsense=1"):
            refuses(program, bench, wrong)
        expect(run(program, bench, "--help").returncode == 0, "--help is an error")
    refuses(program, "accuracy --quick --scene oscillator", "--engine nothing", "engine")
    for pair in ("repeats=0", "patience=x", "stepper=euler", "iterations=0"):
        refuses(program, "contact", f"--set {pair}", pair.split("=")[0])
    for pair in ("ticks=0", "ticks=x", "seed=-1"):
        refuses(program, "stability", f"--set {pair}", pair.split("=")[0])
    names = run(program, "stability", "--scenes").stdout.splitlines()
    expect(len(names) >= 300 and len(set(names)) == len(names), f"{len(names)} cases, {len(set(names))} names")


def check_sets(program, *_):
    """Checks that --set changes engines, and --engine and --scene choose."""
    with Folder(program) as folder:
        options = ["--quick", "--scene", "oscillator", "--engine", "limber default,1 iteration", "--set", "ticks=30"]
        plain, _ = folder.bench("accuracy", *options)
        expect([r.setting for r in plain.select(ticks="30")] == ["default", "1 iteration, full stiffness",
                                                                 "1 iteration, calibrated"], "engines")
        changed, _ = folder.bench("accuracy", *options, "--set", "minSubsteps=20", "--set", "iterations=3")
        for before, after in zip(plain.select(ticks="30"), changed.select(ticks="30")):
            # a single stiff link is as long as one iteration makes it
            same = "full stiffness" in after.setting
            expect((before.texts["hash"] == after.texts["hash"]) == same, f"hash: {after.fields}")
        expect(changed.runs[0].values["error of period"] < 0.2 * plain.runs[0].values["error of period"], "substeps")


# --- scaling --------------------------------------------------------------------------------------------------------

def check_scaling_run(one):
    value = one.values
    drawn, soft = one.setting in ("shaded", "wireframe"), one.engine == "Limber"
    expect(value["points"] == 8 * value["bodies"], f"points: {value}")
    springs = value["springs per cube"]
    expect(springs > 18 and springs == int(springs) if soft else springs == 0, f"springs: {value}")
    expect(0 < value["tick"] <= value["tick, largest sample"], f"median: {value}")
    expect(0 < value["tick, mean"] <= value["tick, largest sample"] <= value["worst tick"], f"ticks: {value}")
    expect(value["simulated over real time"] > 0, f"real time: {value}")
    expect(("frame" in value, "buffers" in value) == (drawn, drawn), f"values of a renderer: {value}")
    expect(not drawn or value["frame"] > 0 < value["buffers"], f"renderer: {value}")
    expect(value["asleep"] == 0, f"a body is asleep: {value}")
    expect(value["complete"] == 1 and value["simulated"] == 1, f"not complete: {value}")
    expect(value["touching pairs"] > 0, f"nothing has reached the floor: {value}")


def check_hashes(runs):
    """Checks that drawing does not change the state of the scene."""
    for scene in {one.scene for one in runs}:
        hashes = {one.texts["hash"] for one in runs if one.scene == scene and one.engine == "Limber"}
        expect(len(hashes) == 1, f"{scene} end in different states: {hashes}")
    expect(len({one.texts["hash"] for one in runs if one.setting == "not drawn"}) == 3, "scenes end in the same state")


def check_scaling(_, drawing, bench):
    with Folder(drawing) as folder:
        found, text = folder.bench("scaling", *SMALL)
        runs = found.select(group="cubes")
        names = ("loose spheres", "Limber, not drawn", "Limber, shaded", "Limber, wireframe")
        expected = {(scene, name) for scene in ("1 cube", "2 cubes", "4 cubes") for name in names}
        expect({(one.scene, one.name) for one in runs} >= expected, f"runs: {[one.fields for one in runs]}")
        for one in runs:
            check_scaling_run(one)
        check_hashes(runs)
        expect("WARNING: runs" not in text and "Largest number in real time" in text, text)
        folder.plots(bench, "scaling", "scaling")


def check_counts(_, drawing, __):
    with Folder(drawing) as folder:
        found, text = folder.bench("scaling", *SMALL, "--set", "counts=3,5", "--engine", "loose,not drawn")
        measured = [(one.scene, one.engine) for one in found.runs]
        expect(measured == [(f"{n} cubes", e) for n in (3, 5) for e in ("loose spheres", "Limber")], f"{measured}")
        expect("Largest number" not in text, "nothing was searched")


def check_sleep(_, drawing, __):
    with Folder(drawing) as folder:
        options = [*SMALL, "--set", "counts=1", "--engine", "not drawn", "--set", "seconds=20"]
        awake, _ = folder.bench("scaling", *options)
        asleep, _ = folder.bench("scaling", *options, "--set", "sleep=yes")
        expect(awake.runs[0].values["asleep"] == 0, "a body that is kept awake sleeps")
        expect(0 < asleep.runs[0].values["asleep"] < 100, f"a body at rest stays awake: {asleep.runs[0].values}")


# --- networks -------------------------------------------------------------------------------------------------------

def check_networks(program, _, bench):
    """Checks that a small body returns to its shape with the pipeline's braces, which stay inside, but not without."""
    with Folder(program) as folder:
        found, text = folder.bench("networks", "--quick", "--scene", "cube26", "--set", "runs=10", "--set", "part=mechanisms,returns,masses,skins,materials")
        rules = {one.setting: one.values for one in found.select(group="returns")}
        bare, braced, random = (rules[name] for name in ("edges alone", "pipeline (default)", "random, as many"))
        expect(bare["returns"] == 0 and bare["mechanisms"] == 6, f"bare: {bare}")
        expect(braced["returns"] == 100 and braced["braces outside the body"] == 0, f"braced: {braced}")
        expect(random["braces"] == braced["braces"], "random braces are not as many")
        expect("hit   mechanisms" in text, text)
        folder.plots(bench, "networks", "networks")


# --- accuracy -------------------------------------------------------------------------------------------------------

def check_accuracy_run(one):
    errors = [value for measure, value in one.values.items() if measure.startswith("error of")]
    expect(errors and all(error >= 0 for error in errors), f"errors: {one.values}")
    timed(one, "tick")
    expect(("springs" in one.values) == (one.engine == "Limber"), f"springs: {one.fields}")
    expect(one.group in ("free motion", "with contacts") and len(one.texts["hash"]) == 16, f"{one.fields}")


def expect_bounds(program, bounds):
    with Folder(program) as folder:
        for scene in dict.fromkeys(bound[0] for bound in bounds):
            engines = [] if scene == "oscillator" else ["--engine", "limber"]  # the bounds are for Limber
            found, _ = folder.bench("accuracy", "--quick", "--scene", scene, *engines)
            runs = [one for one in found.select(ticks=ANY_TICK) if one.setting != "all numbers of substeps"]
            for one in runs:
                check_accuracy_run(one)
            for _, measure, setting, bound in [b for b in bounds if b[0] == scene]:
                errors = [one.values["error of " + measure] for one in runs
                          if one.setting == setting and one.engine == "Limber" and "error of " + measure in one.values]
                expect(len(errors) > 1, f"no {measure} of {setting} in {scene}")
                expect(max(errors) <= bound, f"{measure} of {setting} in {scene}: {max(errors)} is more than {bound}")


def check_accuracy(program, *_):
    expect_bounds(program, ACCURACY_BOUNDS)


def check_accuracy_floors(program, *_):
    """Checks the other floors, on which bodies rest alike."""
    expect_bounds(program, FLOOR_BOUNDS)


def check_accuracy_repeats(program, _, bench):
    """Checks that a repeated run gives the same errors and states, and that all engines take part."""
    with Folder(program) as folder:
        first, second = (folder.bench("accuracy", "--quick", "--scene", "oscillator")[0] for _ in range(2))
        expect({one.engine for one in first.runs} == {"Limber", "btSoftBody", "btDeformable"}, "engines")
        for a, b in zip(first.runs, second.runs):
            errors = [[v for m, v in one.values.items() if m.startswith("error")] for one in (a, b)]
            expect(a.fields == b.fields and a.texts == b.texts and errors[0] == errors[1], f"{a.fields} has changed")
        folder.plots(bench, "accuracy", "accuracy", "accuracy-oscillator")


# --- springs and threads --------------------------------------------------------------------------------------------

def check_springs(program, _, bench):
    with Folder(program) as folder:
        found, _ = folder.bench("springs", "--quick")
        expect({one.group for one in found.runs} == {"damped", "undamped"}, "damped and undamped")
        expect({one.scene for one in found.runs} == {"free", "at rest on four points"}, "with and without contacts")
        expect("one body, spring by spring" in {one.setting for one in found.runs}, "every machine can step one by one")
        for one in found.runs:
            timed(one, "spring and substep")
        folder.plots(bench, "springs", "springs")


def check_threads(program, _, bench):
    with Folder(program) as folder:
        found, _ = folder.bench("threads", "--quick", "--set", "repeats=1")
        expect({"1 thread", "2 threads"} <= {one.setting for one in found.runs}, "one thread and two")
        for one in found.runs:
            timed(one, "tick, wall time", "gain")
            expect(one.setting != "1 thread" or one.values["gain"] == 1, "one thread gains nothing")
            expect(0 <= one.values.get("outside the parallel parts", 0) <= 100, "shares")
            expect(1 <= one.values["largest possible gain"] <= one.values["threads"], "foretold gains")
        expect(any("cloth" in one.scene for one in found.runs), "scenes of one body, too")
        folder.plots(bench, "threads", "threads")


# --- contact --------------------------------------------------------------------------------------------------------

def check_contact_run(one, found):
    value = one.values
    expect(value["points"] >= 8 * value["bodies"] > 0, f"counts: {value}")
    expect(0 < value["tick"] <= value["worst tick"], f"ticks: {value}")
    expect(abs(1e3 * value["tick"] / value["points"] / value["tick per point"] - 1) < 1e-3, f"cost of a point: {value}")
    for measure, other in (("tick over btSoftBody's", ("btSoftBody", "4 iterations")),
                           ("tick over loose spheres'", ("loose spheres", ""))):
        reference = found.by_fields.get((one.group, one.scene, one.ticks) + other)
        expect((measure in value) == bool(reference and reference.values), f"{measure}: {one.fields}")
        if measure in value:
            ratio = value["tick"] / reference.values["tick"]
            expect(abs(ratio / value[measure] - 1) < 1e-3, f"{measure} is not {ratio}: {value}")
    expect((one.group == "asleep") == (value["asleep"] == 100), f"sleep: {one.fields} {value}")


def check_contact(program, _, bench):
    """Checks that every engine runs or gives a reason, and that Limber runs in all scenes and does not sink in."""
    with Folder(program) as folder:
        found, text = folder.bench("contact", "--quick", "--set", "repeats=1")
        runs = [one for one in found.runs if one.group != "memory"]
        expect({one.group for one in runs} == {"airborne", "landing", "rest", "asleep", "cloth", "dense", "pile"}, "roles")
        engines = ({"Limber, default", "Limber, Stepping::fast()", "Limber, Collision::Points", "btSoftBody, 1 iteration", "btSoftBody, 4 iterations",
                    "btSoftBody, 10 iterations", "btDeformable, implicit", "loose spheres"}
                   | {f"Limber, at most {n} substeps" for n in (5, 10, 20, 40)})
        expect({one.name for one in runs} == engines, "engines")
        for one in runs:
            expect(bool(one.values) != ("no result" in one.texts), f"neither results nor a reason: {one.fields}")
            expect(one.values or one.engine not in ("Limber", "loose spheres"), f"not run: {one.fields}")
            if one.values:
                check_contact_run(one, found)
            if one.engine == "Limber" and one.group in ("rest", "asleep", "landing"):
                expect(one.values["deepest penetration"] < 0.1, f"in the floor: {one.fields}")
        for word in ("hit ", "MISS", "Memory of Limber"):
            expect(word in text, f"no {word}: {text}")
        folder.plots(bench, "contact", "contact")


def check_contact_flags(program, *_):
    with Folder(program) as folder:
        found, _ = folder.bench("contact", "--quick", "--set", "repeats=1", "--set", "flags=yes", "--scene", "rest")
        flags = {"SDF_RS", "SDF_RS | VF_SS", "SDF_RS | CL_SS", "CL_RS | CL_SS"}
        expect({one.setting for one in found.runs} >= flags, "flags")
        for one in found.runs:
            expect("no result" in one.texts or one.values["tick"] > 0, "no times")


# --- stability ------------------------------------------------------------------------------------------------------

def stability_run(folder, *options):
    found, text = folder.bench("stability", "--quick", *options)
    expect({one.ticks for one in found.runs} == {"30", "60"}, "not at both ticks")
    return found, text


def check_survivor(one):
    """Checks the guarantees of Limber for a body that only its own springs move."""
    value = one.values
    expect(value["finite"] == 1, f"not finite: {one.fields}")
    expect(0 < value["energy"] <= 1.001 + value["energy, rounding"], f"energy: {one.fields} {value}")
    expect(value["energy, rounding"] < 1e-2, f"the allowance for rounding allows anything: {one.fields}")
    expect(value["momentum drift"] <= 1e-6, f"momentum: {one.fields}")
    expect(one.texts.get("shape", "yes") == "yes" and value.get("shape error", 0) <= 1e-3, f"shape: {one.fields}")


def check_stability(program, *_):
    with Folder(program) as folder:
        for scene, cases in (("stiffness k", 6), ("damping x", 5), ("mass ratio", 8)):
            found, _ = stability_run(folder, "--scene", scene, "--engine", "Limber")
            expect(len(found.runs) == 2 * 4 * cases, f"{scene}: {len(found.runs)} runs")
            for one in found.runs:
                check_survivor(one)
            expect(any(one.texts.get("shape") == "yes" for one in found.runs), f"{scene}: nothing had to recover")


def check_stability_counts(program, *_):
    """Checks that the counts agree with the runs for all engines, and that unsupported cases have a reason."""
    with Folder(program) as folder:
        found, text = stability_run(folder, "--scene", "impact plane")
        unseen = found.select(engine="btSoftBody")
        expect(unseen and all(not one.values and one.texts["no result"] for one in unseen), "planes")
        expect("btSoftBody does not see planes" in text, text)
        for one in found.select(engine="Limber"):
            expect(one.values["finite"] == 1 and one.values["points on the wrong side"] == 0, f"through: {one.fields}")
        found, text = stability_run(folder, "--scene", "stiffness k 1e+04")
        total = text[text.index("all cases"):].splitlines()
        for name in {one.name for one in found.runs}:
            passed = [one.values["passed"] for one in found.runs if one.name == name]
            line = next(line for line in total if line.strip().startswith(name + "  "))
            expect(line.endswith(f" {100 * sum(passed) / len(passed):.1f} %"), f"{name}: {passed} {line}")
        drifts = [one.get("momentum drift") or 0.0 for one in found.runs if one.engine != "Limber"]
        expect(0 < max(drifts) < 1e-2, f"no drift is seen, not even rounding: {max(drifts)}")


def check_stability_repeats(program, _, bench):
    with Folder(program) as folder:
        files = []
        for _ in range(2):
            stability_run(folder, "--scene", "misshapen scattered")
            files.append((folder.path / "stability.csv").read_bytes())
        expect(files[0] == files[1], "not repeatable")
        folder.plots(bench, "stability", "stability")


CHECKS = {name.removeprefix("check_"): check for name, check in list(globals().items())
          if name.startswith("check_") and not name.endswith(("_row", "_run", "_survivor", "_hashes"))}

if __name__ == "__main__":
    if len(sys.argv) != 5:
        sys.exit(__doc__)
    CHECKS[sys.argv[1]](sys.argv[2], sys.argv[3], pathlib.Path(sys.argv[4]))
