# SPDX-License-Identifier: Zlib
"""Makes small runs of limber-bench and checks their output: check_bench.py CHECK PROGRAM BENCH_FOLDER

Checks counts, states, fractions and errors; times must only be positive and consistent."""

import csv
import pathlib
import subprocess
import sys
import tempfile

COLUMNS = "bodies,points,springs,mode,tick_ms_mean,tick_ms_max,render_ms_mean,gpu_mb,realtime".split(",")
SMALL = ["scaling", "--quick", "--max-bodies", "4", "--size", "64x36"]
STABILITY = "case,engine,setting,finite,energy_ratio,momentum_drift,recovered,dt,seed,k,group".split(",")
SKIPPED = 77
CONTACT_COLUMNS = ("scene,engine,bodies,points,tick_ms_median,tick_ms_worst,ratio_to_btsoftbody,ratio_to_bare_bullet,"
                   "us_per_point,deepest_penetration_share,residual_speed").split(",")
ACCURACY_COLUMNS = "scene,engine,setting,dt,error,us_per_tick,us_step,hash,us_noise,kind,measure".split(",")

# part of the names of scenes, the measure, the setting of Limber, the largest error for any tick length
ACCURACY_BOUNDS = [
    ("oscillator", "period", "auto 1e-04", 1e-4),
    ("oscillator", "amplitude", "auto", 1e-3),
    ("hanging chain", "sag", "auto", 1e-4),
    ("stiff pendulum", "period", "auto", 1e-4),
    ("falling chain", "shape", "verlet x4", 1e-3),
    ("rest on a", "height", "auto", 1e-6),
    ("rest on a", "force", "auto", 1e-4),
    ("dropped cube 1e3", "rebound", "auto", 0.05),
    ("incline 0.97", "creep", "auto", 1e-5),
    ("incline 1.03", "acceleration", "auto", 5e-3),
]


def run(*command):
    return subprocess.run([str(c) for c in command], capture_output=True, text=True, check=False)


def expect(condition, message):
    if not condition:
        sys.exit(f"check_bench: {message}")


def small_run(program, folder, *options):
    done = run(program, *SMALL, "--out", folder, *options)
    expect(done.returncode == 0, f"exit status {done.returncode}: {done.stderr}")
    with open(folder / "scaling.csv", newline="") as file:
        return list(csv.DictReader(file)), done.stdout


def check_row(row):
    drawn = row["mode"] in ("shaded", "wireframe")
    bodies = int(row["bodies"])
    expect(int(row["points"]) == 8 * bodies, f"points: {row}")
    springs = int(row["springs"])
    expect(springs == 0 if row["mode"] == "bare" else springs > 18 * bodies and springs % bodies == 0, f"springs: {row}")
    expect(0 < float(row["tick_ms_median"]) <= float(row["tick_ms_max"]), f"median: {row}")
    expect(0 < float(row["tick_ms_mean"]) <= float(row["tick_ms_max"]) <= float(row["tick_ms_worst"]), f"ticks: {row}")
    expect(float(row["realtime"]) > 0, f"realtime: {row}")
    expect((row["render_ms_mean"] != "") == drawn and (row["gpu_mb"] != "") == drawn, f"cells of a renderer: {row}")
    expect(not drawn or (float(row["render_ms_mean"]) > 0 and float(row["gpu_mb"]) > 0), f"renderer: {row}")
    expect(float(row["asleep_share"]) == 0, f"a body is asleep: {row}")
    expect(row["complete"] == "1" and float(row["simulated_s"]) == 1, f"not complete: {row}")
    expect(float(row["contacts"]) > 0, f"nothing has reached the floor: {row}")


def check_hashes(rows):
    """Checks that drawing does not change the state of the scene."""
    for bodies in {row["bodies"] for row in rows}:
        hashes = {r["hash"] for r in rows if r["bodies"] == bodies and r["mode"] != "bare"}
        expect(len(hashes) == 1, f"{bodies} cubes end in different states: {hashes}")
    expect(len({r["hash"] for r in rows if r["mode"] == "none"}) == 3, "different scenes end in the same state")


def check_scaling(program, _):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name) / "made" / "on the way"
        rows, summary = small_run(program, folder)
        expect(list(rows[0])[: len(COLUMNS)] == COLUMNS, f"columns: {list(rows[0])}")
        measured = [(r["mode"], int(r["bodies"])) for r in rows]
        modes = ("bare", "none", "shaded", "wireframe")
        expect(set(measured) >= {(mode, n) for mode in modes for n in (1, 2, 4)}, f"rows: {measured}")
        for row in rows:
            check_row(row)
        check_hashes(rows)
        expect((folder / "scaling.txt").read_text() == summary, "scaling.txt is not what was printed")
        expect("WARNING: runs" not in summary, summary)


def check_counts(program, _):
    with tempfile.TemporaryDirectory() as folder:
        rows, summary = small_run(program, pathlib.Path(folder), "--counts", "3,5", "--modes", "none,bare")
        measured = [(int(r["bodies"]), r["mode"]) for r in rows]
        expect(measured == [(3, "bare"), (3, "none"), (5, "bare"), (5, "none")], f"rows: {measured}")
        expect("largest number" not in summary, "nothing was searched")


def check_sleep(program, _):
    with tempfile.TemporaryDirectory() as folder:
        options = ["--counts", "1", "--modes", "none", "--seconds", "20"]
        awake, _ = small_run(program, pathlib.Path(folder), *options)
        asleep, _ = small_run(program, pathlib.Path(folder), *options, "--sleep")
        expect(float(awake[0]["asleep_share"]) == 0, "a body that is kept awake sleeps")
        expect(0 < float(asleep[0]["asleep_share"]) < 1, f"a body at rest stays awake: {asleep}")


def check_networks(program, _):
    """Checks that a small body returns to its shape with the pipeline's braces, which stay inside, but not without."""
    with tempfile.TemporaryDirectory() as folder:
        done = run(program, "networks", "--quick", "--mesh", "cube26", "--runs", "10", "--out", folder)
        expect(done.returncode == 0, f"exit status {done.returncode}: {done.stderr}")
        with open(pathlib.Path(folder) / "networks.csv", newline="") as file:
            rows = {row["rule"]: row for row in csv.DictReader(file)}
        columns = "mesh,points,edges,braces,rule,return_rate,runs,mode_ratio,isotropy,outside,seconds".split(",")
        expect(list(rows["none"])[: len(columns)] == columns, f"columns: {list(rows['none'])}")
        expect(float(rows["none"]["return_rate"]) == 0 and rows["none"]["mechanisms"] == "6", f"bare: {rows['none']}")
        expect(float(rows["pipeline"]["return_rate"]) == 1 and rows["pipeline"]["outside"] == "0", f"{rows['pipeline']}")
        expect(rows["random"]["braces"] == rows["pipeline"]["braces"], "random braces are not as many")
        expect("hit   mechanisms" in done.stdout, done.stdout)


def check_plot(program, bench):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        small_run(program, folder)
        done = run(bench / "plot", "scaling", folder)
        if done.returncode == SKIPPED:
            sys.exit(SKIPPED)
        expect(done.returncode == 0, done.stderr)
        for picture in ("scaling.svg", "scaling.png"):
            expect((folder / picture).stat().st_size > 1000, f"{picture} is empty")


def accuracy_run(program, folder, scene):
    done = run(program, "accuracy", "--quick", "--scene", scene, "--out", folder)
    expect(done.returncode == 0, f"exit status {done.returncode}: {done.stderr}")
    with open(folder / "accuracy.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    expect(list(rows[0]) == ACCURACY_COLUMNS, f"columns: {list(rows[0])}")
    expect((folder / "accuracy.txt").read_text() == done.stdout, "accuracy.txt is not what was printed")
    return rows


def check_accuracy_row(row):
    expect(float(row["error"]) >= 0, f"error: {row}")
    expect(float(row["us_noise"]) >= 0 and float(row["us_per_tick"]) > 0, f"times: {row}")
    expect(row["engine"] == "limber" or row["us_step"] == row["us_per_tick"], f"step: {row}")
    expect(row["kind"] in ("free", "contact") and len(row["hash"]) == 16, f"row: {row}")


def check_accuracy(program, _):
    with tempfile.TemporaryDirectory() as name:
        for scene in dict.fromkeys(bound[0] for bound in ACCURACY_BOUNDS):
            rows = accuracy_run(program, pathlib.Path(name), scene)
            for row in rows:
                check_accuracy_row(row)
            for _, measure, setting, bound in [b for b in ACCURACY_BOUNDS if b[0] == scene]:
                own = [r for r in rows
                       if (r["engine"], r["setting"], r["measure"]) == ("limber", setting, measure)]
                expect(len(own) > 1, f"no {measure} of {setting} in {scene}")
                for row in own:
                    expect(float(row["error"]) <= bound, f"more than {bound}: {row}")


def check_accuracy_repeats(program, _):
    """Checks that a repeated run gives the same errors and states, and that all engines take part."""
    with tempfile.TemporaryDirectory() as name:
        first, second = (accuracy_run(program, pathlib.Path(name), "oscillator") for _ in range(2))
        expect({r["engine"] for r in first} == {"limber", "btSoftBody", "btDeformable"}, "engines")
        for a, b in zip(first, second):
            expect((a["error"], a["hash"]) == (b["error"], b["hash"]), f"{a} is not {b}")


def check_accuracy_plot(program, bench):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        accuracy_run(program, folder, "oscillator")
        done = run(bench / "plot", "accuracy", folder)
        if done.returncode == SKIPPED:
            sys.exit(SKIPPED)
        expect(done.returncode == 0, done.stderr)
        for ending in ("svg", "png"):
            expect((folder / f"accuracy-oscillator.{ending}").stat().st_size > 1000, f"{ending} is empty")


def check_springs(program, bench):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        done = run(program, "springs", "--quick", "--out", folder)
        expect(done.returncode == 0, done.stderr)
        with open(folder / "springs.csv", newline="") as file:
            rows = list(csv.DictReader(file))
        expect({r["damped"] for r in rows} == {"0", "1"}, "damped and undamped")
        expect({r["contacts"] for r in rows} == {"0", "4"}, "with and without contacts")
        expect("1 body scalar" in {r["stepped"] for r in rows}, "every machine can step spring by spring")
        expect(all(float(r["ns_per_spring_substep"]) > 0 for r in rows), "a spring costs something")
        done = run(bench / "plot", "springs", folder)
        if done.returncode == SKIPPED:
            sys.exit(SKIPPED)
        expect((folder / "springs.svg").stat().st_size > 1000, "svg is empty")


def check_threads(program, bench):
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        done = run(program, "threads", "--quick", "--repeats", "1", "--out", folder)
        expect(done.returncode == 0, done.stderr)
        with open(folder / "threads.csv", newline="") as file:
            rows = list(csv.DictReader(file))
        expect({"1", "2"} <= {r["threads"] for r in rows}, "one thread and two")
        expect(all(float(r["gain"]) == 1 for r in rows if r["threads"] == "1"), "one thread gains nothing")
        expect(all(0 <= float(r["share_outside"]) <= 1 for r in rows), "shares")
        expect(all(1 <= float(r["gain_at_most"]) <= int(r["threads"]) for r in rows), "foretold gains")
        expect(any("cloth" in r["scene"] for r in rows), "scenes of one body, too")
        none = run(program, "threads", "--scene", "nothing", "--out", folder)
        expect(none.returncode == 2 and "nothing" in none.stderr, "a scene that does not exist")
        done = run(bench / "plot", "threads", folder)
        if done.returncode == SKIPPED:
            sys.exit(SKIPPED)
        expect((folder / "threads.svg").stat().st_size > 1000, "svg is empty")


def contact_run(program, folder, *options):
    done = run(program, "contact", "--quick", "--repeats", "1", "--out", folder, *options)
    expect(done.returncode == 0, f"exit status {done.returncode}: {done.stderr}")
    expect((folder / "contact.txt").read_text() == done.stdout, "contact.txt is not what was printed")
    with open(folder / "contact.csv", newline="") as file:
        return list(csv.DictReader(file)), done.stdout


def check_contact_row(row, rows):
    expect(int(row["points"]) >= 8 * int(row["bodies"]) > 0, f"counts: {row}")
    expect(0 < float(row["tick_ms_median"]) <= float(row["tick_ms_worst"]), f"ticks: {row}")
    expect(abs(1e3 * float(row["tick_ms_median"]) / int(row["points"]) / float(row["us_per_point"]) - 1) < 1e-3,
           f"cost of a point: {row}")
    for column, other in (("ratio_to_btsoftbody", "btSoftBody 4 it"), ("ratio_to_bare_bullet", "loose spheres")):
        reference = [r for r in rows if r["scene"] == row["scene"] and r["engine"] == other and not r["error"]]
        expect(bool(row[column]) == bool(reference), f"{column}: {row}")
        if reference:
            ratio = float(row["tick_ms_median"]) / float(reference[0]["tick_ms_median"])
            expect(abs(ratio / float(row[column]) - 1) < 1e-3, f"{column} is not {ratio}: {row}")
    expect((row["role"] == "asleep") == (float(row["asleep_share"]) == 1), f"sleep: {row}")


def check_contact(program, _):
    """Checks that every engine runs or gives a reason, and that Limber runs in all scenes and does not sink in."""
    with tempfile.TemporaryDirectory() as name:
        rows, summary = contact_run(program, pathlib.Path(name))
        expect(list(rows[0])[: len(CONTACT_COLUMNS)] == CONTACT_COLUMNS, f"columns: {list(rows[0])}")
        expect({r["role"] for r in rows} == {"airborne", "landing", "rest", "asleep", "cloth", "dense", "pile"}, "roles")
        engines = {"limber points", "limber surface", "btSoftBody 1 it", "btSoftBody 4 it", "btSoftBody 10 it", "btDeformable implicit",
                   "loose spheres"} | {f"limber {n} substeps" for n in (5, 10, 20, 40)}
        expect({r["engine"] for r in rows} == engines, "engines")
        for row in rows:
            if not row["error"]:
                check_contact_row(row, rows)
        for row in [r for r in rows if r["engine"].startswith("limber") or r["engine"] == "loose spheres"]:
            expect(not row["error"], f"not run: {row}")
        for row in [r for r in rows if r["engine"].startswith("limber") and r["role"] in ("rest", "asleep", "landing")]:
            expect(float(row["deepest_penetration_share"]) < 1e-3, f"in the floor: {row}")
        for word in ("hit ", "MISS", "bytes a point"):
            expect(word in summary, f"no {word}: {summary}")


def check_contact_flags(program, _):
    with tempfile.TemporaryDirectory() as name:
        rows, _summary = contact_run(program, pathlib.Path(name), "--flags", "--scene", "rest")
        expect({r["engine"] for r in rows} >= {"SDF_RS", "SDF_RS | VF_SS", "SDF_RS | CL_SS", "CL_RS | CL_SS"}, "flags")
        expect(all(r["error"] or float(r["tick_ms_median"]) > 0 for r in rows), "no times")


def check_contact_plot(program, bench):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        contact_run(program, folder)
        done = run(bench / "plot", "contact", folder)
        if done.returncode == SKIPPED:
            sys.exit(SKIPPED)
        expect(done.returncode == 0, done.stderr)
        for picture in ("contact.svg", "contact.png"):
            expect((folder / picture).stat().st_size > 1000, f"{picture} is empty")


def check_contact_options(program, _):
    for options in ("--repeats 0", "--patience x", "--scene nothing", "--fast", "more"):
        done = run(program, "contact", *options.split(), "--out", tempfile.gettempdir())
        expect(done.returncode == 2, f"{options}: exit status {done.returncode}")


def check_unknown_name(program, _):
    for name in ("scalin", "", "../scaling"):
        done = run(program, name)
        expect(done.returncode == 2, f"{name!r}: exit status {done.returncode}")
        expect("scaling" in done.stderr, f"{name!r}: does not list what there is: {done.stderr}")
    expect(run(program).returncode == 2, "no name is no error")
    expect("scaling" in run(program, "--list").stdout, "--list does not list")


def check_unwritable_folder(program, _):
    with tempfile.TemporaryDirectory() as name:
        file = pathlib.Path(name) / "a_file"
        file.write_text("")
        blocked = pathlib.Path(name) / "blocked"
        (blocked / "scaling.csv").mkdir(parents=True)
        for folder in (file, file / "below", blocked, "/proc/limber"):
            done = run(program, *SMALL, "--out", folder)
            expect(done.returncode == 1, f"{folder}: exit status {done.returncode}")
            expect("cannot" in done.stderr, f"{folder}: no reason: {done.stderr}")


def check_bad_options(program, _):
    bad = ["--seconds 0", "--seconds nan", "--max-bodies 0", "--max-bodies -1", "--modes soft", "--modes",
           "--size 10", "--size 0x0", "--repeats 0", "--minutes 0", "--counts 0", "--counts 1,x", "--fast", "more"]
    for options in bad:
        done = run(program, "scaling", *options.split())
        expect(done.returncode == 2, f"{options}: exit status {done.returncode}")
    expect(run(program, "scaling", "--help").returncode == 0, "--help is an error")
    for options in ("--scene nothing", "--fast", "more"):
        done = run(program, "accuracy", *options.split(), "--out", tempfile.gettempdir())
        expect(done.returncode == 2, f"accuracy {options}: exit status {done.returncode}")
    expect(run(program, "accuracy", "--help").returncode == 0, "--help is an error")


def stability_run(program, folder, *options):
    done = run(program, "stability", "--quick", "--out", folder, *options)
    expect(done.returncode == 0, f"exit status {done.returncode}: {done.stderr}")
    expect((folder / "stability.txt").read_text() == done.stdout, "stability.txt is not what was printed")
    with open(folder / "stability.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    expect(rows and list(rows[0])[: len(STABILITY)] == STABILITY, f"columns: {rows[:1]}")
    bare = [t for t in done.stdout.splitlines() if t.endswith((":", " -")) or ":;" in t]
    expect(not bare, f"verdicts without a reason: {bare}")
    expect({round(1 / float(r["dt"])) for r in rows} == {30, 60}, "not at both ticks")
    return rows, done.stdout


def check_survivor(row):
    """Checks the guarantees of Limber for a body that only its own springs move."""
    expect(row["finite"] == "1", f"not finite: {row}")
    expect(0 < float(row["energy_ratio"]) <= 1.001 + float(row["rounding"]), f"energy: {row}")
    expect(float(row["rounding"]) < 1e-2, f"the allowance for rounding allows anything: {row}")
    expect(float(row["momentum_drift"]) <= 1e-6, f"momentum: {row}")
    expect(row["recovered"] in ("yes", "n/a"), f"shape: {row}")
    expect(row["recovered"] == "n/a" or float(row["shape_error"]) <= 1e-3, f"shape: {row}")


def check_stability(program, _):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for case, cases in (("stiffness k", 6), ("damping x", 5), ("mass ratio", 8)):
            rows, _summary = stability_run(program, folder, "--case", case, "--engine", "limber")
            expect(len(rows) == 2 * 4 * cases, f"{case}: {len(rows)} rows")
            for row in rows:
                check_survivor(row)
            expect(any(row["recovered"] == "yes" for row in rows), f"{case}: nothing was asked to recover")


def check_stability_counts(program, _):
    """Checks that the counts agree with the rows for all engines, and that unsupported cases have a reason."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        rows, summary = stability_run(program, folder, "--case", "impact plane")
        unseen = [r for r in rows if r["engine"] == "btSoftBody"]
        expect(unseen and all(r["finite"] == "n/a" and r["reason"] for r in unseen), f"planes: {unseen}")
        expect("btSoftBody does not see planes" in summary, summary)
        landed = [r for r in rows if r["engine"] == "limber"]
        expect(all(r["finite"] == "1" and r["wrong_side"] == "0" for r in landed), f"through a plane: {landed}")
        rows, summary = stability_run(program, folder, "--case", "stiffness k 1e+04")
        for engine in {(r["engine"], r["setting"]) for r in rows}:
            own = [r for r in rows if (r["engine"], r["setting"]) == engine]
            share = 100 * sum(r["passed"] == "1" for r in own) / len(own)
            line = [t for t in summary.splitlines() if t.split()[:1] == ["all"] and " ".join(engine) in " ".join(t.split())]
            expect(len(line) == 1 and line[0].endswith(f" {share:.1f}%"), f"{engine}: {share} {line}")
        drifts = [float(r["momentum_drift"]) for r in rows if r["momentum_drift"] != "n/a" and r["engine"] != "limber"]
        expect(0 < max(drifts) < 1e-2, f"no drift is seen, not even rounding: {max(drifts)}")


def check_stability_repeats(program, _):
    with tempfile.TemporaryDirectory() as name:
        first, second = pathlib.Path(name) / "1", pathlib.Path(name) / "2"
        for folder in (first, second):
            stability_run(program, folder, "--case", "misshapen scattered")
        expect((first / "stability.csv").read_bytes() == (second / "stability.csv").read_bytes(), "not repeatable")


def check_stability_plot(program, bench):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        stability_run(program, folder, "--case", "coincident one pair")
        done = run(bench / "plot", "stability", folder)
        if done.returncode == SKIPPED:
            sys.exit(SKIPPED)
        expect(done.returncode == 0, done.stderr)
        for picture in ("stability.svg", "stability.png"):
            expect((folder / picture).stat().st_size > 1000, f"{picture} is empty")


def check_stability_options(program, _):
    for options in ("--rate 0", "--rate x", "--seed -1", "--fast", "more"):
        done = run(program, "stability", *options.split())
        expect(done.returncode == 2, f"{options}: exit status {done.returncode}")
    names = run(program, "stability", "--cases").stdout.splitlines()
    expect(len(names) >= 300 and len(set(names)) == len(names), f"{len(names)} cases, {len(set(names))} names")


CHECKS = {
    "contact": check_contact,
    "contact_flags": check_contact_flags,
    "contact_plot": check_contact_plot,
    "contact_options": check_contact_options,
    "networks": check_networks,
    "scaling": check_scaling,
    "counts": check_counts,
    "sleep": check_sleep,
    "plot": check_plot,
    "accuracy": check_accuracy,
    "accuracy_repeats": check_accuracy_repeats,
    "accuracy_plot": check_accuracy_plot,
    "springs": check_springs,
    "threads": check_threads,
    "unknown_name": check_unknown_name,
    "unwritable_folder": check_unwritable_folder,
    "bad_options": check_bad_options,
    "stability": check_stability,
    "stability_counts": check_stability_counts,
    "stability_repeats": check_stability_repeats,
    "stability_plot": check_stability_plot,
    "stability_options": check_stability_options,
}

if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    CHECKS[sys.argv[1]](sys.argv[2], pathlib.Path(sys.argv[3]))
