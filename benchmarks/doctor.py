#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""How many planted faults `edvo doctor` finds, and what it says of clean sequences.

    python benchmarks/doctor.py rgbd_dataset_freiburg1_xyz icl_kt3:5000

SEQUENCE or SEQUENCE:UNITS (depth units per metre), with ground truth; needs the Python package.
Plants each fault of python/tests/planted.py in the first frames of each; prints what was missed and
the counts; leaves with 1 if less than 95 % are found or a clean sequence has a fault.
"""

from __future__ import annotations

import argparse
import sys
from itertools import islice
from pathlib import Path

import edvo

sys.path.insert(0, str(Path(__file__).parent.parent / "python" / "tests"))
from planted import FAULTS, Memory, findings_of  # noqa: E402

NEEDED = 0.95  # [1]


def open_named(name: str) -> edvo.Source:
    path, _, units = name.partition(":")
    return edvo.open_source(path, depth_scale=float(units) if units else None)


def first_frames(source: edvo.Source, count: int) -> Memory:
    memory = Memory(source.camera, list(islice(source, count)), source.ground_truth)
    memory.name = source.name
    return memory


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("sequences", nargs="+", metavar="SEQUENCE[:UNITS]")
    parser.add_argument("--frames", type=int, default=120)
    arguments = parser.parse_args()
    found, planted, alarms = 0, 0, 0
    for name in arguments.sequences:
        source = open_named(name)
        clean = findings_of(source, with_motion=True)  # the whole of it
        good = first_frames(source, arguments.frames)
        alarms += bool(clean)
        print(f"{good.name}: clean: {', '.join(sorted(clean)) or 'no fault'}", flush=True)
        missed = []
        for fault in FAULTS:
            planted += 1
            if fault.finding in findings_of(fault.plant(good), fault.needs_truth):
                found += 1
            else:
                missed.append(fault.name)
        print(f"{good.name}: missed: {', '.join(missed) or 'none'}", flush=True)
    share = found / planted
    print(f"{found} of {planted} planted faults named ({100 * share:.1f} %), ", end="")
    print(f"{alarms} of {len(arguments.sequences)} clean sequences with a fault")
    return 0 if share >= NEEDED and alarms == 0 else 1


if __name__ == "__main__":
    sys.exit(main())
