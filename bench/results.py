# SPDX-License-Identifier: Zlib
"""Reads the table that all benches write, see results.h."""

import csv
import math
import re

FIELDS = ("group", "scene", "ticks_per_s", "engine", "setting")


class Run:
    """All values of one engine and setting in one scene."""

    def __init__(self, fields):
        self.group, self.scene, self.ticks, self.engine, self.setting = self.fields = fields
        self.values, self.units, self.texts, self.quartiles = {}, {}, {}, {}

    def get(self, measure):
        return self.values.get(measure)

    @property
    def name(self):
        return ", ".join(part for part in (self.engine, self.setting) if part)


class Results:
    """The runs of a bench in the order of the file."""

    def __init__(self, path):
        self.runs, self.about = [], {}
        found = {}
        with open(path, newline="") as file:
            for row in csv.DictReader(file):
                if row["group"] == "run":
                    self.about[row["measure"]] = row["value"]
                    continue
                fields = tuple(row[field] for field in FIELDS)
                if fields not in found:
                    found[fields] = Run(fields)
                    self.runs.append(found[fields])
                store(found[fields], row)
        self.by_fields = found

    def select(self, **wanted):
        """Runs whose fields match; a value is a text, or a compiled regular expression."""
        return [run for run in self.runs if all(matches(getattr(run, field), value) for field, value in wanted.items())]


def store(run, row):
    measure = row["measure"]
    if is_text(row):
        run.texts[measure] = row["value"]
        return
    run.values[measure] = float(row["value"])
    run.units[measure] = row["unit"].replace("us", "µs")
    if row["samples"]:
        run.quartiles[measure] = float(row["lower_quartile"]), float(row["upper_quartile"])


def is_text(row):
    return row["measure"] in ("hash", "driver", "shape", "form", "no result", "remark", "or more", "end check")


def matches(text, wanted):
    return text == wanted if isinstance(wanted, str) else wanted.fullmatch(text) is not None


def unique(values):
    return list(dict.fromkeys(values))


def order(steps, errors):
    """The slope of log(error) over log(step) by least squares, or None; errors of 0 and infinity are left out."""
    points = [(math.log(s), math.log(e)) for s, e in zip(steps, errors) if 0 < e < math.inf]
    if len(points) < 2:
        return None
    mean_x, mean_y = (sum(axis) / len(points) for axis in zip(*points))
    return sum((x - mean_x) * (y - mean_y) for x, y in points) / sum((x - mean_x) ** 2 for x, _ in points)


def number(value):
    """Three digits, as people write them."""
    if value is None:
        return "-"
    if math.isinf(value):
        return "lost"
    if value == int(value) and abs(value) < 1e7:
        return f"{value:.0f}"
    if 1e-3 <= abs(value) < 1e4:
        text = f"{value:.3g}"
        return f"{value:.0f}" if "e" in text else text
    return re.sub(r"e([+-])0*(\d)", lambda m: "e" + m[1].replace("+", "") + m[2], f"{value:.1e}")
