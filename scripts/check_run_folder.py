#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Checks that what a run has left on disk is whole: every line and every file parses, no number is
NaN or infinite, and each frame that is on disk has its pose there, too.

Usage: scripts/check_run_folder.py FOLDER; exits with 1 and one line per problem. A folder that is
not there, or an empty one, is whole.
"""
import json
import math
import sys
from pathlib import Path


def no_constant(name):
    raise ValueError(f"{name} is no JSON")


def lines_of(path, problems):
    text = path.read_text(encoding="utf-8")
    if text and not text.endswith("\n"):
        problems.append(f"{path}: the last line is not whole")
    return text.splitlines()


def frames_in(path, problems):
    frames = []
    for number, line in enumerate(lines_of(path, problems), 1):
        try:
            frames.append(json.loads(line, parse_constant=no_constant))
        except ValueError as error:
            problems.append(f"{path}:{number}: {error}")
    return frames


def poses_in(path, problems):
    count = 0
    for number, line in enumerate(lines_of(path, problems), 1):
        if line.startswith("#"):  # where a segment begins
            continue
        count += 1
        try:
            values = [float(word) for word in line.split()]
        except ValueError:
            values = []
        if len(values) != 8 or not all(map(math.isfinite, values)):
            problems.append(f"{path}:{number}: no pose: {line[:80]}")
    return count


def problems_in(folder):
    problems = []
    poses = {path.name: poses_in(path, problems) for path in sorted(folder.glob("*.tum"))}
    frames = []
    if (folder / "frames.jsonl").exists():
        frames = frames_in(folder / "frames.jsonl", problems)
        with_pose = sum(frame.get("status") not in ("lost", "skipped") for frame in frames)
        # The frame in flight may have its line and not yet its pose.
        if poses.get("trajectory.tum", 0) < with_pose - 1:
            problems.append(f"{folder}: {with_pose} frames with a pose, but "
                            f"{poses.get('trajectory.tum', 0)} poses")
    if (folder / "summary.json").exists():
        try:
            json.loads((folder / "summary.json").read_text(), parse_constant=no_constant)
        except ValueError as error:
            problems.append(f"{folder}/summary.json: {error}")
    report = folder / "report.html"
    if report.exists() and not report.read_text(encoding="utf-8").rstrip().endswith("</html>"):
        problems.append(f"{report}: is not whole")
    return problems


def main():
    found = problems_in(Path(sys.argv[1]))
    for problem in found:
        print(problem)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
