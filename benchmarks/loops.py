#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""How much SLAM lowers the drift of long walks that see places again.

    benchmarks/loops.py OUT [--edvo build/bin/edvo] [--lengths 50 100 250 500] [--seeds 5]

Renders walks through a flat of six rooms, with a Kinect's noise, and runs the odometry alone (no
final pass) and SLAM. Printed for each: ATE of both, their ratio, ATE in per cent of the path,
links, wrong links (more than 10 cm and 10 % of their length off the truth), recall (see aliasing.py),
keyframes, peak memory and time. A loop counts as closed if a link joins the first and the last tenth
of the walk. The bars: all closed, ratio <= 0.3, ATE <= 0.15 % of the path, no wrong link; the exit
status is 1 if one is missed. Images are deleted unless --keep is given.
"""
import argparse
import json
import shutil
import sys
import time
from pathlib import Path

from aliasing import accepted_links, ate_of, recall, run, true_keyframes, wrong_links

MOST_RATIO, MOST_SHARE = 0.3, 0.15  # of the odometry's ATE; [%] of the path


def measured_run(edvo, folder, result, *more):
    start = time.monotonic()
    run([edvo, "run", folder, "-o", result, "--force", "--no-report", "--quiet", *more])
    return time.monotonic() - start


def is_closed(links, keyframes):
    return any(link["from"] < keyframes / 10 and link["to"] > keyframes * 9 / 10 for link in links)


def trial(options, length, seed):
    folder = options.out / f"walk{length}_{seed}"
    if not (folder / "groundtruth.txt").exists():
        run([options.edvo, "synth", "--scene", options.scene, "--path", "rounds", "--path-length",
             length, "--seed", seed, "--rate", options.rate, "--size", options.size, "--force",
             folder])
    alone, slam = Path(f"{folder}_odometry"), Path(f"{folder}_slam")
    seconds = [measured_run(options.edvo, folder, alone, "--no-loops", "--no-final-pass",
                            *options.run_options),
               measured_run(options.edvo, folder, slam, *options.run_options)]
    before, after = ate_of(alone), ate_of(slam)
    summary = json.loads((slam / "summary.json").read_text())
    links = accepted_links(slam)
    keys = true_keyframes(folder, slam)
    row = {"length": length, "seed": seed, "frames": summary["frames"]["total"],
           "lost": summary["frames"]["lost"], "before": before, "after": after,
           "ratio": after / before, "share": 100 * after / length,
           "links": len(links), "wrong": len(wrong_links(keys, links)), "recall": recall(keys, links),
           "keyframes": len(keys), "closed": is_closed(links, len(keys)), "seconds": seconds,
           "megabytes": summary["peak_memory_mb"]}
    if not options.keep:
        shutil.rmtree(folder / "rgb")
        shutil.rmtree(folder / "depth")
        (folder / "groundtruth.txt").rename(folder / "truth.txt")
    return row


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path)
    parser.add_argument("--edvo", default="build/bin/edvo")
    parser.add_argument("--lengths", type=int, nargs="+", default=[50, 100, 250, 500])
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--scene", default="flat")
    parser.add_argument("--size", default="320x240")
    parser.add_argument("--rate", default=10)
    parser.add_argument("--keep", action="store_true")
    parser.add_argument("--run-options", nargs=argparse.REMAINDER, default=[],
                        help="the rest of the line, for edvo run")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    print("path [m] seed frames lost | ATE odometry, SLAM [cm] ratio % of path | links wrong recall "
          "closed | keyframes MB, time of both [s]")
    missed = 0
    for length in options.lengths:
        for seed in range(1, options.seeds + 1):
            r = trial(options, length, seed)
            print(f"{length:8} {seed:4} {r['frames']:6} {r['lost']:4} | {1e2 * r['before']:8.2f} "
                  f"{1e2 * r['after']:8.2f} {r['ratio']:8.2f} {r['share']:9.3f} | {r['links']:5} "
                  f"{r['wrong']:5} {r['recall']:6.2f} {'yes' if r['closed'] else 'no':>6} | "
                  f"{r['keyframes']:9} {r['megabytes']:4.0f} {r['seconds'][0]:5.0f} "
                  f"{r['seconds'][1]:5.0f}", flush=True)
            missed += not (r["closed"] and r["wrong"] == 0 and r["ratio"] <= MOST_RATIO
                           and r["share"] <= MOST_SHARE)
    print(f"{missed} walks miss a bar")
    sys.exit(missed > 0)


if __name__ == "__main__":
    main()
