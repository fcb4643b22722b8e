# SPDX-License-Identifier: Zlib
"""Makes small runs of limber-bench-draw render: check_render.py CHECK PROGRAM DRAWING_PROGRAM BENCH_FOLDER

Checks bytes, memory and draw calls; times must only be positive and consistent."""

import os
import pathlib
import sys

from check_bench import Folder, expect, refuses

PATHS = {"Limber", "points body by body", "vertices body by body"}
TIMES = ("upload", "submit", "finish", "read")
FLOOR_POINTS, FLOOR_TRIANGLES = 4, 2
SKIN_METHODS = ("compute shader", "renderer on the CPU", "applySkin() and streamed")


def render_run(folder, *options):
    """Results and report of a quick run with one turn of each path."""
    return folder.bench("render", "--quick", "--set", "blocks=1", *options)


def check_bytes_run(one):
    value = one.values
    points, triangles, sent = value["points"], value["triangles"], value["sent per frame"]
    if one.group == "cubes":
        expect(points == 8 * value["bodies"] + FLOOR_POINTS, f"points: {value}")
        expect(triangles == 12 * value["bodies"] + FLOOR_TRIANGLES, f"triangles: {value}")
    normals = points - FLOOR_POINTS if one.group == "ball" else 0  # by the CPU with a software rasteriser
    written = {"Limber": 12 * (points + normals), "points body by body": 12 * points,
               "vertices body by body": 36 * 3 * triangles}
    expect(abs(sent / written[one.engine] - 1) < 1e-5, f"bytes: {one.fields} {value}")
    smallest = {"Limber": 3 * 12 * points, "points body by body": 12 * points,
                "vertices body by body": (36 + 4) * 3 * triangles}[one.engine]
    expect(smallest * 0.9999 <= value["buffers"] < 20 * smallest + 4096, f"buffers: {one.fields} {value}")


def check_draws_run(one):
    """Checks the number of draw calls: the floor casts no shadow, and the background is one draw call."""
    shapes = 1 if one.engine == "Limber" else one.values["bodies"]
    shadows = not one.scene.endswith("no shadows")
    expect(one.values["draw calls"] == shapes * (1 + shadows) + 2, f"draw calls: {one.fields} {one.values}")


def check_times_run(one):
    value = one.values
    expect(all(value[measure] >= 0 for measure in TIMES), f"times: {value}")
    expect(0 < max(value[measure] for measure in TIMES) <= value["frame"], f"frame: {value}")
    expect(0 < value["upload and submit, own time"] < value["frame, all threads"], f"samples: {value}")


def check_frames(_, drawing, bench):
    with Folder(drawing) as folder:
        found, text = render_run(folder, "--set", "part=frames", "--set", "context=osmesa")
        cases = {(one.scene, one.engine) for one in found.runs}
        bodies = ("64 cubes", "1024 cubes", "ball of 10000 triangles")
        expect(cases == {(f"{b}, 1280x720, {s}", p) for b in bodies for s in ("shadows", "no shadows") for p in PATHS},
               f"runs: {cases}")
        expect({one.setting for one in found.runs} == {"osmesa"}, "contexts")
        for one in found.runs:
            check_bytes_run(one)
            check_draws_run(one)
            check_times_run(one)
        expect("hit   bytes sent per point of a cube and frame" in text, text)
        folder.plots(bench, "render", "render")


def check_skins(folder):
    found, _ = render_run(folder, "--set", "part=skins")
    expect(len(found.runs) == 12 and [one.setting for one in found.runs[:3]] == list(SKIN_METHODS), "runs")
    for one in found.runs:
        value = one.values
        points, vertices = value["points"], value["vertices"]
        streamed = dict(zip(SKIN_METHODS, (points, points + 2 * vertices, 2 * vertices)))[one.setting]
        expect(value["sent per frame"] == 12 * (value["bodies"] * streamed + FLOOR_POINTS), f"bytes: {one.fields}")


def check_parts(_, drawing, __):
    """Checks memory, skins and files: each path is measured, and no picture file remains."""
    with Folder(drawing) as folder:
        found, _ = render_run(folder, "--set", "part=memory", "--set", "context=osmesa")
        buffers = {one.engine: one.values["buffers per cube"] for one in found.runs}
        expect(set(buffers) == PATHS, f"paths: {list(buffers)}")
        expect(buffers["Limber"] < buffers["vertices body by body"] / 4, f"buffers: {buffers}")
        check_skins(folder)
        found, _ = render_run(folder, "--set", "part=png")
        expect([one.setting for one in found.runs] == ["no files", "PNG files"], "runs")
        for one in found.runs:
            expect(0 < one.values["tick, wall time"] < one.values["tick and drawing, wall time"], f"times: {one.values}")
            expect(one.values["cores"] == os.cpu_count(), f"cores: {one.values}")
        expect(not list(folder.path.glob("*.png")), f"left over: {os.listdir(folder.path)}")


def check_options(_, drawing, __):
    for wrong in ("--set part=all", "--set context=window", "--set blocks=0", "--fast", "more", "--scene nothing"):
        refuses(drawing, "render", wrong)


CHECKS = {"frames": check_frames, "parts": check_parts, "options": check_options}

if __name__ == "__main__":
    if len(sys.argv) != 5:
        sys.exit(__doc__)
    CHECKS[sys.argv[1]](sys.argv[2], sys.argv[3], pathlib.Path(sys.argv[4]))
