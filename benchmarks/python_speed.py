#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Frame rates of the C++ program, of the Python package's, and of that with --view: alternating runs.

    build/venv/bin/python benchmarks/python_speed.py SEQUENCE --edvo build/bin/edvo

Prints the median of each, its share of the C++ program's, and whether the trajectories are the same to
the bit. For --view without a display Rerun's server runs on the same machine; no page is open.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import shlex
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path


def run(command: list[str], folder: Path) -> tuple[float, str]:
    """Frames per second with reading, and a hash of the trajectory."""
    environment = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
    words = [*command, "-o", str(folder), "--force", "--quiet", "--no-report", "--json"]
    result = subprocess.run(
        words, capture_output=True, text=True, check=True, env=environment, stdin=subprocess.DEVNULL
    )
    trajectory = (folder / "trajectory.tum").read_bytes()
    return json.loads(result.stdout)["frames_per_second"], hashlib.sha256(trajectory).hexdigest()


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("sequence")
    parser.add_argument("--edvo", default="build/bin/edvo", help="the C++ program")
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--arguments", default="", help="of edvo run")
    arguments = parser.parse_args()
    flags = ["run", arguments.sequence, *shlex.split(arguments.arguments)]
    python = [sys.executable, "-m", "edvo", *flags, "--no-doctor"]
    systems = {
        "C++": [arguments.edvo, *flags],
        "Python": python,
        "Python --view": [*python, "--view"],
    }
    rates: dict[str, list[float]] = {name: [] for name in systems}
    hashes = set()
    with tempfile.TemporaryDirectory() as folder:
        for i in range(arguments.repeats):
            for name, command in systems.items():
                rate, digest = run(command, Path(folder) / "run")
                rates[name].append(rate)
                hashes.add(digest)
                print(f"{i + 1}/{arguments.repeats} {name}: {rate:.1f}", file=sys.stderr, flush=True)
    base = statistics.median(rates["C++"])
    print("| | frames/s (median) | all runs | of C++ |\n| --- | --- | --- | --- |")
    for name, values in rates.items():
        listed = ", ".join(f"{value:.0f}" for value in sorted(values))
        median = statistics.median(values)
        print(f"| {name} | {median:.1f} | {listed} | {100 * median / base:.1f} % |")
    print("same bits" if len(hashes) == 1 else f"{len(hashes)} different trajectories")
    return 0 if len(hashes) == 1 else 1


if __name__ == "__main__":
    sys.exit(main())
