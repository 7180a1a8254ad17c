#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Runs a sequence with each number of the options at half and at twice its value.

    python benchmarks/sensitivity.py SEQUENCE [--edvo build/bin/edvo] [--arguments="--depth-scale 5000"]

Prints the errors with the defaults, and every option with which one of them is more than --worse
times as large. Needs Python 3.11.
"""
import argparse
import json
import pathlib
import shlex
import subprocess
import tempfile
import tomllib


def errors_of(edvo, sequence, arguments):
    """ATE, RPE in translation and in rotation as edvo run prints them, and the lost frames."""
    with tempfile.TemporaryDirectory() as run:
        finished = subprocess.run([edvo, "run", sequence, *arguments, "-o", run, "--force",
                                   "--no-report", "--quiet"], capture_output=True, text=True)
        path = pathlib.Path(run) / "frames.jsonl"
        lines = path.read_text().splitlines() if path.exists() else []
    lost = sum(json.loads(line)["status"] == "lost" for line in lines)
    found = {}
    for line in finished.stdout.splitlines():
        words = line.split()
        if line.startswith("ATE"):
            found["ATE [m]"] = float(words[2])
        elif line.startswith("RPE"):
            found[f"RPE [{words[2]}]"] = float(words[3])
    return found, lost


def numbers(edvo):
    """(name, value) of every option that is a number other than 0."""
    text = subprocess.run([edvo, "config"], capture_output=True, text=True, check=True).stdout
    for group, options in tomllib.loads(text).items():
        if not isinstance(options, dict):
            continue
        for name, value in options.items():
            if isinstance(value, (int, float)) and not isinstance(value, bool) and value != 0:
                yield f"{group}.{name}", value


def scaled(value, factor):
    return max(1, round(value * factor)) if isinstance(value, int) else value * factor


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("sequence", type=pathlib.Path)
    parser.add_argument("--edvo", default="build/bin/edvo")
    parser.add_argument("--worse", type=float, default=1.1, help="times the default's error")
    parser.add_argument("--arguments", default="", help="of edvo run")
    options = parser.parse_args()
    arguments = shlex.split(options.arguments)
    usual, lost = errors_of(options.edvo, options.sequence, arguments)
    print("defaults:", ", ".join(f"{name} {value:.5f}" for name, value in usual.items()),
          f"({lost} lost)", flush=True)
    tried = 0
    for name, value in numbers(options.edvo):
        for factor in (0.5, 2):
            setting = f"{name}={scaled(value, factor)}"
            found, lost = errors_of(options.edvo, options.sequence,
                                    [*arguments, "--set", setting])
            tried += bool(found)
            worse = [key for key in usual if found.get(key, 0) > options.worse * usual[key]]
            if worse or lost:
                print(f"{setting}:", ", ".join(f"{k} {found[k]:.5f}" for k in found),
                      f"({lost} lost)", flush=True)
            elif not found:
                print(f"{setting}: refused", flush=True)
    print(f"{tried} runs")


if __name__ == "__main__":
    main()
