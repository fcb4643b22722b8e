# SPDX-License-Identifier: Zlib
"""Makes small runs of limber-bench render and checks their output: check_render.py CHECK PROGRAM BENCH_FOLDER

Checks bytes, memory and draw calls; times must only be positive and consistent."""

import csv
import os
import pathlib
import sys
import tempfile

from check_bench import SKIPPED, expect, run

COLUMNS = ("bodies,vertices,size,path,context,upload_ms,submit_ms,finish_ms,read_ms,frame_ms,mb_per_frame,shadows,"
           "buffer_mb,draw_calls").split(",")
PATHS = {"limber", "naive_points", "naive"}
TIMES = ("upload_ms", "submit_ms", "finish_ms", "read_ms")
FLOOR_POINTS, FLOOR_TRIANGLES = 4, 2


def render_run(program, folder, *options):
    """Returns the summary of a quick run with one block of each path."""
    done = run(program, "render", "--quick", "--blocks", "1", "--out", folder, *options)
    expect(done.returncode == 0, f"exit status {done.returncode}: {done.stderr}")
    expect((folder / "render.txt").read_text() == done.stdout, "render.txt is not what was printed")
    return done.stdout


def read_rows(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def check_bytes(row):
    points, triangles, sent = int(row["vertices"]), int(row["triangles"]), int(row["bytes_per_frame"])
    if row["scene"] == "cubes":
        expect(points == 8 * int(row["bodies"]) + FLOOR_POINTS, f"points: {row}")
        expect(triangles == 12 * int(row["bodies"]) + FLOOR_TRIANGLES, f"triangles: {row}")
    normals = points - FLOOR_POINTS if row["scene"] == "ball" else 0  # by the CPU with a software rasteriser
    written = {"limber": 12 * (points + normals), "naive_points": 12 * points, "naive": 36 * 3 * triangles}
    expect(sent == written[row["path"]], f"bytes: {row}")
    expect(abs(float(row["mb_per_frame"]) - 1e-6 * sent) <= 1e-5 * 1e-6 * sent, f"megabytes: {row}")
    buffers = 1e6 * float(row["buffer_mb"])
    smallest = {"limber": 3 * 12 * points, "naive_points": 12 * points, "naive": (36 + 4) * 3 * triangles}
    expect(smallest[row["path"]] * 0.9999 <= buffers < 20 * smallest[row["path"]] + 4096, f"buffers: {row}")


def check_draws(row):
    """Checks the number of draw calls: the floor casts no shadow, and the background is one draw call."""
    shapes = 1 if row["path"] == "limber" else int(row["bodies"])
    expect(int(row["draw_calls"]) == shapes * (1 + int(row["shadows"])) + 2, f"draw calls: {row}")


def check_times(row):
    expect(all(float(row[column]) >= 0 for column in TIMES), f"times: {row}")
    expect(0 < max(float(row[column]) for column in TIMES) <= float(row["frame_ms"]), f"frame: {row}")
    expect(0 < float(row["own_ms"]) < float(row["process_ms"]) and int(row["frames"]) > 0, f"samples: {row}")


def check_frames(program, _):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        summary = render_run(program, folder, "--part", "frames", "--context", "osmesa")
        rows = read_rows(folder / "render.csv")
        expect(list(rows[0])[: len(COLUMNS)] == COLUMNS, f"columns: {list(rows[0])}")
        cases = {(r["scene"], r["bodies"], r["size"], r["shadows"], r["path"]) for r in rows}
        bodies = {("cubes", "64"), ("cubes", "1024"), ("ball", "1")}
        expect(cases == {(*b, "1280x720", s, p) for b in bodies for s in "01" for p in PATHS}, f"rows: {cases}")
        expect({r["context"] for r in rows} == {"osmesa"}, "contexts")
        for row in rows:
            check_bytes(row)
            check_draws(row)
            check_times(row)
        expect("hit   bytes sent for a point of a cube and frame" in summary, summary)


def check_parts(program, _):
    """Checks memory, skins and files: each path is measured, and no picture file remains."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        render_run(program, folder, "--part", "memory", "--context", "osmesa")
        rows = {r["path"]: r for r in read_rows(folder / "render_memory.csv")}
        expect(set(rows) == PATHS, f"paths: {list(rows)}")
        expect(int(rows["limber"]["buffer_bytes"]) < int(rows["naive"]["buffer_bytes"]) / 4, f"buffers: {rows}")
        render_run(program, folder, "--part", "skins")
        rows = read_rows(folder / "render_skins.csv")
        ways = ("gpu", "cpu", "streamed")
        expected = [(bodies, weights, way) for bodies in "12" for weights in ("dense", "sparse") for way in ways]
        expect([(r["bodies"], r["weights"], r["way"]) for r in rows] == expected, f"rows: {rows}")
        for row in rows:
            points, vertices = int(row["points"]), int(row["vertices"])
            streamed = {"gpu": points, "cpu": points + 2 * vertices, "streamed": 2 * vertices}[row["way"]]
            expect(int(row["bytes_per_frame"]) == 12 * (int(row["bodies"]) * streamed + FLOOR_POINTS), f"bytes: {row}")
        render_run(program, folder, "--part", "png")
        rows = read_rows(folder / "render_png.csv")
        expect([r["writes_png"] for r in rows] == ["0", "1"], f"rows: {rows}")
        expect(all(0 < float(r["tick_ms"]) < float(r["frame_ms"]) for r in rows), f"times: {rows}")
        expect(all(int(r["cores"]) == os.cpu_count() for r in rows), f"cores: {rows}")
        expect(not list(folder.glob("*.png")), f"left over: {os.listdir(folder)}")


def check_plot(program, bench):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        render_run(program, folder, "--part", "frames", "--context", "osmesa")
        done = run(bench / "plot", "render", folder)
        if done.returncode == SKIPPED:
            sys.exit(SKIPPED)
        expect(done.returncode == 0, done.stderr)
        for picture in ("render.svg", "render.png"):
            expect((folder / picture).stat().st_size > 1000, f"{picture} is empty")


def check_options(program, _):
    for options in ("--part all", "--context window", "--blocks 0", "--fast", "more"):
        done = run(program, "render", *options.split(), "--out", tempfile.gettempdir())
        expect(done.returncode == 2, f"{options}: exit status {done.returncode}")


CHECKS = {"frames": check_frames, "parts": check_parts, "plot": check_plot, "options": check_options}

if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    CHECKS[sys.argv[1]](sys.argv[2], pathlib.Path(sys.argv[3]))
