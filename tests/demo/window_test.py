# SPDX-License-Identifier: Zlib
"""Plays with the demo's window as a user does: python3 window_test.py limber-demo FOLDER

It pulls a cube, pauses, moves sliders, shoots, pins, cuts, goes to the next scene and closes the window; then it
replays the recording without a display, and another one with btSoftBody beside it in a window. It waits for lines of
the program's log, never for a time. The exit code is 77 if Xvfb or libxtst6 is not installed.
"""
import math
import os
import pathlib
import re
import subprocess
import sys
import time

import x_client

PATIENCE = 120  # s, on a busy machine; nothing waits that long unless it fails
NUMBER = r"(-?[\d.]+)"


class Log:
    """The lines of the program's log, as they come."""

    def __init__(self, file, program):
        self.file, self.program = file, program

    def lines(self):
        return self.file.read_text().splitlines() if self.file.exists() else []

    def wait(self, pattern, accepts=lambda match: True, after=0):
        """The match of the first line behind `after` lines that is accepted."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            for line in self.lines()[after:]:
                match = re.search(pattern, line)
                if match and accepts(match):
                    return match
            if self.program.poll() is not None:
                raise AssertionError(f"the program ended with {self.program.returncode}, before: {pattern}")
            time.sleep(0.02)
        raise AssertionError(f"there was no line: {pattern}\nthe last ones:\n" + "\n".join(self.lines()[-20:]))

    def wait_new(self, pattern, accepts=lambda match: True):
        return self.wait(pattern, accepts, len(self.lines()))


def numbers(match):
    return [float(text) for text in match.groups()]


def restart(mouse, log):
    before = len(log.lines())
    mouse.press("r")
    log.wait(r": restart", after=before)


def pull_cube(mouse, log):
    """Pulls the cube and waits until it has followed the mouse."""
    x, y = numbers(log.wait_new(rf"body 0 at .* pixel {NUMBER} {NUMBER}"))
    mouse.move(x, y)
    before = len(log.lines())
    mouse.button(1, True)
    log.wait(r"grab .*: body 0 point", after=before)
    begin = numbers(log.wait(rf"held at {NUMBER} {NUMBER} {NUMBER}", after=before))
    for step in range(1, 11):
        mouse.move(x + 25 * step, y - 12 * step)

    def follows(match):
        at = numbers(match)
        pulled = math.dist(at[3:], begin)
        return pulled > 0.2 and math.dist(at[:3], begin) > 0.5 * pulled and math.dist(at[:3], at[3:]) < 0.5 * pulled

    log.wait(rf"held at {NUMBER} {NUMBER} {NUMBER}, pulled to {NUMBER} {NUMBER} {NUMBER}", follows, before)
    mouse.button(1, False)
    log.wait(r": release", after=before)
    restart(mouse, log)  # the cube may have been thrown out of the picture


def pause(mouse, log):
    """The ticks stop, one can be made, and they go on."""
    before = len(log.lines())
    mouse.press(" ")
    tick, = numbers(log.wait(rf"tick {NUMBER}: paused", after=before))
    log.wait_new(rf"tick {NUMBER}: body 0", lambda match: numbers(match) == [tick])
    mouse.press(".")
    log.wait_new(rf"tick {NUMBER}: body 0", lambda match: numbers(match) == [tick + 1])
    mouse.press(" ")
    log.wait(r"goes on", after=before)


def move_slider(mouse, log):
    """A click on the right part of the slider makes the body stiffer."""
    x, y, width, height = numbers(
        log.wait(rf"slider stiffness at {NUMBER} {NUMBER}, {NUMBER} x {NUMBER}"))
    before, = numbers(log.wait(rf"stiffness {NUMBER}$"))
    mouse.move(x + 0.75 * width, y + 0.5 * height)
    mouse.button(1, True)
    factor, = numbers(log.wait(rf"set stiffness {NUMBER}", lambda match: numbers(match)[0] > 2))
    log.wait(rf"body 0 .* stiffness {NUMBER}$", lambda match: numbers(match)[0] > 2 * before)
    mouse.button(1, False)
    return factor


def throw_slider(mouse, log):
    """A press counts where it happened, even if the mouse has left the panel within the same frame."""
    x, y, width, height = numbers(
        log.wait(rf"slider stiffness at {NUMBER} {NUMBER}, {NUMBER} x {NUMBER}"))
    mouse.move(x + 0.5 * width, y + 0.5 * height)
    before = len(log.lines())
    mouse.button(1, True)
    mouse.move(600, y)
    mouse.button(1, False)
    log.wait(rf"set stiffness {NUMBER}", lambda match: numbers(match)[0] > 99, before)
    assert not any("grab" in line or "camera" in line for line in log.lines()[before:]), "the scene got the press"


def shoot_pin_and_cut(mouse, log):
    restart(mouse, log)
    x, y = numbers(log.wait_new(rf"body 0 at .* pixel {NUMBER} {NUMBER}", lambda match: numbers(match)[1] > 200))
    mouse.move(x, y)
    mouse.press("p")
    log.wait(r"pin .*: pinned body 0 point")
    mouse.move(640, 100)
    mouse.press("b")
    log.wait(r"shoot .*: a ball of")
    mouse.hold("Control", True)
    mouse.move(x, y - 170)
    before = len(log.lines())
    mouse.button(1, True)
    mouse.move(x, y + 170)
    mouse.button(1, False)
    log.wait(r"cut .* divided", after=before)
    mouse.hold("Control", False)


def replay(program, recording, folder):
    """The recording ends in the same state without a window."""
    done = subprocess.run([program, "--replay", recording, "--mode", "none"], capture_output=True, text=True)
    last = recording.read_text().splitlines()[-1]
    assert done.returncode == 0 and done.stdout.strip() == last, done.stdout + done.stderr + last
    broken = folder / "broken.recording"
    broken.write_text(recording.read_text().replace("set stiffness", "set stifness"))
    done = subprocess.run([program, "--replay", broken, "--mode", "none"], capture_output=True, text=True)
    assert done.returncode == 1 and "there is no setting stifness" in done.stderr, done.stderr


def play(program, folder, server):
    recording, log_file = folder / "window.recording", folder / "window.log"
    log_file.unlink(missing_ok=True)
    command = [program, "--window", "--count", "1", "--size", "960x640", "--record", recording, "--log", log_file]
    run = subprocess.Popen(command, env=dict(os.environ, DISPLAY=server.name))
    log, mouse = Log(log_file, run), x_client.Client(server)
    try:
        log.wait("opened 960 x 640")
        pull_cube(mouse, log)
        pause(mouse, log)
        factor = move_slider(mouse, log)
        shoot_pin_and_cut(mouse, log)
        throw_slider(mouse, log)
        mouse.press("n")
        log.wait(r"scene \w")
        window = next(w for w in mouse.windows() if "limber-demo" in mouse.title(w))
        mouse.close(window)
        assert run.wait(PATIENCE) == 0, f"exit code {run.returncode}"
        assert "closed after" in log.lines()[-1]
    finally:
        run.kill()
        run.wait()
    replay(program, recording, folder)
    print(f"stiffness x {factor}; {log.lines()[-1]}")


def play_split(program, folder, server):
    """btSoftBody beside Limber, islands, a pause and slow motion: a replay in the window ends with the same picture."""
    recording, log_file = folder / "split.recording", folder / "split.log"
    pictures = [folder / "split.png", folder / "split-again.png"]
    log_file.unlink(missing_ok=True)
    environment = dict(os.environ, DISPLAY=server.name)
    command = [program, "--window", "--split", "--count", "2", "--size", "480x320", "--record", recording, "--log",
               log_file, "--picture", pictures[0]]
    run = subprocess.Popen(command, env=environment)
    log, mouse = Log(log_file, run), x_client.Client(server)
    try:
        log.wait(r"tick \d+: body 0 at")
        for key, line in [("h", "show panel 0"), ("7", "show islands 1"), (" ", "pause 1"), (".", ": tick$"),
                          (" ", "pause 0"), ("m", "speed 0.25")]:
            mouse.press(key)
            log.wait(line)
        after = rf"btSoftBody's body 0 at {NUMBER} {NUMBER} {NUMBER}"
        start = numbers(log.wait(after))
        log.wait_new(after, lambda match: numbers(match)[1] < start[1])  # it falls, too
        mouse.press("q")
        assert run.wait(PATIENCE) == 0, f"exit code {run.returncode}"
    finally:
        run.kill()
        run.wait()
    assert re.search(r" wait \d+", recording.read_text()), "no pause was recorded"
    subprocess.run([program, "--window", "--replay", recording, "--picture", pictures[1]], env=environment, check=True)
    assert pictures[0].read_bytes() == pictures[1].read_bytes(), "the replay ends with another picture"


def main():
    if x_client.missing():
        print("not installed: " + " ".join(x_client.missing()))
        return 77
    program, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    server = x_client.Server()
    try:
        play(program, folder, server)
        play_split(program, folder, server)
    finally:
        server.stop()
    return 0


if __name__ == "__main__":
    sys.exit(main())
