#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Counts frames that are wrong while tracked where something moves before the camera.

    benchmarks/moving.py OUT [--edvo build/bin/edvo] [--seeds 12] [--kind box] [--keep]

A box that hides 25 to 95 % of the image and a person cross before a camera that moves, or stands
still; a turntable that hides as much turns before a camera that stands still. Scene, motion and
noise go with the seed. Images are 320 x 240; they are removed after each trial unless --keep is
given. A frame is wrong if its pose, relative to the first one of its segment, is more than 10 cm or
5 degrees off. The worst trials are printed first; the exit status is 1 if more than 1 % of all
frames are wrong. Needs numpy.
"""
import argparse
import shutil
import sys
from pathlib import Path

from trials import Counts, Truth, frames_of, judge, run, synth

SCENES = ("office", "living_room", "desk", "boxes", "corridor")
PATHS = ("demo", "orbit", "xyz", "still")
KINDS = [("box", 0.25), ("box", 0.5), ("box", 0.75), ("box", 0.95), ("person", 0.25),
         ("person", 0.45), ("turntable", 0.25), ("turntable", 0.5), ("turntable", 0.95)]
FRAMES = 90
SHOWN = 15  # of the worst trials


def trial(edvo, out, thing, share, seed, keep):
    path = "still" if thing == "turntable" else PATHS[seed % len(PATHS)]
    scene = SCENES[seed % len(SCENES)]
    name = f"{thing}{100 * share:.0f}-{scene}-{path}-{seed}"
    folder, result = out / name, out / (name + "_run")
    synth(edvo, folder, scene=scene, path=path, seed=seed, frames=FRAMES, moving=thing,
          moving_share=share)
    run(edvo, folder, result)
    counts = judge(frames_of(result), Truth(folder))
    if not keep:
        shutil.rmtree(folder)
        shutil.rmtree(result)
    return name, counts


def line_of(name, counts):
    return (f"{name:36} {counts.frames:6} {counts.tracked:8} {counts.wrong:6} {counts.lost:6}"
            f" {counts.worst:9.3f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path, metavar="OUT")
    parser.add_argument("--edvo", default="build/bin/edvo", metavar="PROGRAM")
    parser.add_argument("--seeds", type=int, default=12, help="trials of each kind")
    parser.add_argument("--first", type=int, default=1, help="the first seed")
    parser.add_argument("--kind", default="", help="only kinds that begin like this (box95)")
    parser.add_argument("--keep", action="store_true", help="keep images and runs")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    kinds, trials = {}, []
    for thing, share in KINDS:
        kind = f"{thing}{100 * share:.0f}"
        if not kind.startswith(options.kind):
            continue
        for seed in range(options.first, options.first + options.seeds):
            trials.append(trial(options.edvo, options.out, thing, share, seed, options.keep))
            kinds.setdefault(kind, Counts()).add(trials[-1][1])
    print(f"{'trial or kind':36} {'frames':>6} {'tracked':>8} {'wrong':>6} {'lost':>6} worst [m]")
    trials.sort(key=lambda named: (-named[1].wrong, -named[1].worst))
    for name, counts in trials[:SHOWN]:
        print(line_of(name, counts))
    everything = Counts()
    for kind, counts in kinds.items():
        print(line_of(kind, counts))
        everything.add(counts)
    print(line_of("all", everything))
    share = everything.wrong / max(everything.frames, 1)
    print(f"{len(trials)} trials, {sum(c.wrong > 0 for _, c in trials)} with wrong frames; "
          f"{100 * share:.2f} % of all frames are wrong while tracked")
    sys.exit(share > 0.01)


if __name__ == "__main__":
    main()
