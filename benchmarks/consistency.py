#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""How well the information matrix of each frame foretells its error, sequence by sequence.

    python benchmarks/consistency.py DATA [--runs METHOD] (after benchmarks/sensors.py DATA)

For every tracked frame the error xi of keyframe_from_camera against the ground truth is normalized
by the information: xi' I xi / 6, which is 1 on average where the covariance is right. Printed are
the root of its mean and of its median (as a factor on sigma: above 1 the errors are larger than
foretold) and the share of frames with an error beyond three sigmas on any axis.
"""
import argparse
import json
import pathlib
import tomllib

import numpy as np
from sensors import matrix, read_tum


def logarithm(pose):
    """The tangent xi, translation first, of a small motion: exp(xi) = pose."""
    rotation = pose[:3, :3]
    axis = 0.5 * np.array([rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0],
                           rotation[1, 0] - rotation[0, 1]])
    # To first order in the translation, which a small rotation hardly turns.
    return np.concatenate([pose[:3, 3] - 0.5 * np.cross(axis, pose[:3, 3]), axis])


def symmetric(upper):
    full = np.zeros((6, 6))
    full[np.triu_indices(6)] = upper
    return full + np.triu(full, 1).T


def normalized_errors(folder, run):
    """One row per frame: xi' I xi / 6, and the largest error of an axis in its sigmas."""
    truth = read_tum(folder / "groundtruth.txt")
    keyframes, rows = {}, []
    for line in (run / "frames.jsonl").read_text().splitlines():
        frame = json.loads(line)
        true_pose = truth.get(round(float(frame["stamp"]), 6))
        if true_pose is None or frame["status"] not in ("first", "tracked"):
            continue
        if frame["status"] == "tracked" and frame["keyframe"] in keyframes:
            true_motion = np.linalg.inv(keyframes[frame["keyframe"]]) @ true_pose
            estimate = matrix(frame["keyframe_from_camera"])
            xi = logarithm(np.linalg.inv(estimate) @ true_motion)
            information = symmetric(frame["information"])
            sigmas = np.sqrt(np.diag(np.linalg.inv(information)))
            rows.append((xi @ information @ xi / 6, np.max(np.abs(xi) / sigmas)))
        if frame["new_keyframe"] is not None:
            keyframes[frame["new_keyframe"]] = true_pose
    return np.array(rows)


def main():
    here = pathlib.Path(__file__).parent
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=pathlib.Path, help="folder that benchmarks/sensors.py filled")
    parser.add_argument("--manifest", type=pathlib.Path, default=here / "sensors.toml")
    parser.add_argument("--runs", default="canny_corner", help="which of its runs")
    options = parser.parse_args()
    print("| sequence | frames | root mean | root median | beyond 3 sigmas |")
    print("| --- | ---: | ---: | ---: | ---: |")
    for sequence in tomllib.loads(options.manifest.read_text())["sequence"]:
        folder = options.data / sequence["name"]
        rows = normalized_errors(folder, folder / "runs" / options.runs)
        print(f"| {sequence['name']} | {len(rows)} | {np.sqrt(rows[:, 0].mean()):.2f} | "
              f"{np.sqrt(np.median(rows[:, 0])):.2f} | {100 * np.mean(rows[:, 1] > 3):.0f} % |")


if __name__ == "__main__":
    main()
