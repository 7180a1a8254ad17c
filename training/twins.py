# SPDX-License-Identifier: MIT
"""Renders twins for robust.py: sequences with faults, and NAME-clean beside them without.

python3 training/twins.py build/bin/edvo OUT [--pairs 96] [--jobs 2]
"""
import argparse
import concurrent.futures
import subprocess
from pathlib import Path

import numpy as np

SCENES = ("desk", "office", "living_room", "boxes")  # the corridor is left for tests
FIRST_SEED = 50000  # the benchmarks' are below


def flags_of(number):
    """(what both have, faults)"""
    rng = np.random.default_rng([FIRST_SEED, number])
    size, frames = ("640x480", 6) if number % 6 == 5 else ("320x240", 14)
    both = ["--scene", SCENES[number % len(SCENES)], "--seed", str(FIRST_SEED + number),
            "--frames", str(frames), "--rate", "2", "--size", size]
    if rng.random() < 0.4:
        both += ["--texture", f"{rng.uniform(0, 0.5):.3f}"]
    faults = ["--light", f"{rng.uniform(0.1, 1) ** 1.5 if rng.random() < 0.6 else 1:.3f}",
              "--shot-noise", "0.05"]
    if rng.random() < 0.5:
        faults += ["--exposure-time", f"{rng.uniform(0.005, 0.05):.4f}"]
    if rng.random() < 0.4:
        faults += ["--shadows", "on"]
    return both, faults


def render(edvo, out, number):
    both, faults = flags_of(number)
    for name, more in ((f"{number:03}", faults), (f"{number:03}-clean", ["--sensor", "clean"])):
        subprocess.run([edvo, "synth", out / name, *both, *more, "--threads", "1", "--force"],
                       check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("edvo", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--pairs", type=int, default=96)
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        list(pool.map(lambda n: render(options.edvo, options.out, n), range(options.pairs)))


if __name__ == "__main__":
    main()
