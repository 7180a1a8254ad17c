# SPDX-License-Identifier: MIT
"""Time from the start of the process to the first pose on disk, as a user waits for it.

python3 benchmarks/first_pose.py SEQUENCE [--edvo build/bin/edvo] [--runs 5] [-- MORE OPTIONS]

Runs `edvo run SEQUENCE` and looks at trajectory.tum every half millisecond; prints the median and all.
"""
import argparse
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

LOOK = 0.0005  # [s]


def first_pose(command, folder):
    begin = time.perf_counter()
    process = subprocess.Popen(command + ["-o", str(folder)], stdout=subprocess.DEVNULL,
                               stderr=subprocess.DEVNULL)
    poses = folder / "trajectory.tum"
    while not (poses.exists() and poses.stat().st_size > 0):
        if process.poll() is not None:
            raise SystemExit(f"{' '.join(command)}: ended with {process.returncode}, no pose")
        time.sleep(LOOK)
    seconds = time.perf_counter() - begin
    process.terminate()
    process.wait()
    return seconds


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("sequence")
    parser.add_argument("--edvo", default="build/bin/edvo")
    parser.add_argument("--runs", type=int, default=5)
    words = sys.argv[1:]
    own = words.index("--") if "--" in words else len(words)
    arguments = parser.parse_args(words[:own])
    command = [arguments.edvo, "run", arguments.sequence, "--quiet", "--no-report",
               *words[own + 1:]]
    with tempfile.TemporaryDirectory() as folder:
        seconds = [first_pose(command, pathlib.Path(folder) / str(i))
                   for i in range(arguments.runs)]
    print(f"{statistics.median(seconds):.3f} s (median of {len(seconds)}: "
          f"{', '.join(f'{s:.3f}' for s in sorted(seconds))})")


if __name__ == "__main__":
    main()
