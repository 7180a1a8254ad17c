#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""How well a trajectory agrees with the depth images of its recording: a check without ground truth.

    benchmarks/depth_agreement.py SOURCE TRAJECTORY [--camera FILE] [--depth-scale UNITS] [--step 1 10 40 100]

Depth of some frames is carried by the poses into the frame `step` frames later and compared with what
is measured there. Printed is the median of |z expected - z measured| over the pixels of a pair, as median
and 90 % value over the pairs, and the same as if the camera had not moved. Errors of depth are in it. Needs
the edvo package.
"""

from __future__ import annotations

import argparse

import numpy as np

import edvo

GRID, PAIRS = 8, 60  # [px] between pixels, pairs of frames of each step
LEAST_SEEN = 200  # pixels of a pair


def points_of(depth, camera):
    """4 x N, homogeneous, of a grid of pixels with depth [m]."""
    rows, columns = np.mgrid[GRID // 2 : camera.height : GRID, GRID // 2 : camera.width : GRID]
    z = depth[rows, columns]
    rays = [(columns - camera.cx) / camera.fx, (rows - camera.cy) / camera.fy]
    points = np.stack([rays[0] * z, rays[1] * z, z, np.ones_like(z)])
    return points[:, np.isfinite(z)]


def error_of(points, depth, camera):
    """Median distance along z [m] of points in a camera from the depth that it measured."""
    x, y, z = points[:3]
    with np.errstate(all="ignore"):
        column = np.round(x / z * camera.fx + camera.cx)
        row = np.round(y / z * camera.fy + camera.cy)
    seen = (z > 0) & (column >= 0) & (column < camera.width) & (row >= 0) & (row < camera.height)
    difference = depth[row[seen].astype(int), column[seen].astype(int)] - z[seen]
    difference = np.abs(difference[np.isfinite(difference)])
    return np.median(difference) if len(difference) >= LEAST_SEEN else np.nan


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("source")
    parser.add_argument("trajectory")
    parser.add_argument("--camera")
    parser.add_argument("--depth-scale", type=float)
    parser.add_argument("--step", type=int, nargs="+", default=[1, 10, 40, 100])
    arguments = parser.parse_args()
    source = edvo.open_source(
        arguments.source, camera=arguments.camera, depth_scale=arguments.depth_scale
    )
    trajectory = edvo.Trajectory.read(arguments.trajectory)
    poses = dict(zip((int(ns) // 1000 for ns in trajectory.stamps_ns), trajectory.poses))
    stamps_us, depths = [], []
    for frame in source:
        if frame.stamp_ns // 1000 in poses:
            stamps_us.append(frame.stamp_ns // 1000)
            depths.append(frame.depth)
    print("| step | pairs | median [m] | 90 % [m] | unmoved [m] |\n| ---: | ---: | ---: | ---: | ---: |")
    for step in arguments.step:
        errors, unmoved = [], []
        for i in range(0, len(depths) - step, max(1, (len(depths) - step) // PAIRS)):
            points = points_of(depths[i], source.camera)
            second_from_first = np.linalg.inv(poses[stamps_us[i + step]]) @ poses[stamps_us[i]]
            errors.append(error_of(second_from_first @ points, depths[i + step], source.camera))
            unmoved.append(error_of(points, depths[i + step], source.camera))
        if np.isfinite(errors).any():
            median, most = np.nanmedian(errors), np.nanquantile(errors, 0.9)
            print(f"| {step} | {len(errors)} | {median:.4f} | {most:.4f} | {np.nanmedian(unmoved):.4f} |")


if __name__ == "__main__":
    main()
