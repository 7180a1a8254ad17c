#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Renders the sequences of sensors.toml into a folder, follows them with edvo and with the
odometries of OpenCV and Open3D, and prints how they compare, worst first.

    python benchmarks/sensors.py DATA --edvo build/bin/edvo

What is rendered and what the others did is kept in DATA and made anew when the flags change.
"""
import argparse
import concurrent.futures
import json
import math
import pathlib
import shlex
import shutil
import subprocess
import sys
import tomllib

import numpy as np

DEPTH_UNITS = 5000  # per metre, as edvo synth writes
WRONG_METRES, WRONG_DEGREES = 0.10, 5.0
RPE_SECONDS = 1.0
PEERS = ("rgbd", "rgbd_icp", "open3d")


# Trajectories: stamp -> 4x4 world from camera.


def matrix(values):
    x, y, z, w = np.asarray(values[3:]) / np.linalg.norm(values[3:])
    pose = np.eye(4)
    pose[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    pose[:3, 3] = values[:3]
    return pose


def read_tum(path):
    poses = {}
    for line in pathlib.Path(path).read_text().splitlines():
        if line and not line.startswith("#"):
            numbers = [float(field) for field in line.split()]
            poses[round(numbers[0], 6)] = matrix(numbers[1:])
    return poses


def angle_degrees(rotation):
    return math.degrees(math.acos(np.clip((np.trace(rotation) - 1) / 2, -1, 1)))


def absolute_error(truth, estimate):
    """RMSE of positions after the best rigid alignment [m] (Horn, as the TUM scripts)."""
    stamps = sorted(truth.keys() & estimate.keys())
    if len(stamps) < 3:
        return math.nan
    a = np.array([truth[s][:3, 3] for s in stamps])
    b = np.array([estimate[s][:3, 3] for s in stamps])
    a_middle, b_middle = a - a.mean(0), b - b.mean(0)
    u, _, vt = np.linalg.svd(a_middle.T @ b_middle)
    rotation = u @ np.diag([1, 1, np.sign(np.linalg.det(u @ vt))]) @ vt
    return float(np.sqrt(np.mean(np.sum((a_middle - b_middle @ rotation.T) ** 2, axis=1))))


def relative_error(truth, estimate):
    """RMSE of the motion's translation over a second [m/s]."""
    stamps = np.array(sorted(truth.keys() & estimate.keys()))
    squares = []
    for first in stamps:
        index = int(np.argmin(np.abs(stamps - first - RPE_SECONDS)))
        second = stamps[index]
        if abs(second - first - RPE_SECONDS) > 0.02:
            continue
        true_motion = np.linalg.inv(truth[first]) @ truth[second]
        motion = np.linalg.inv(estimate[first]) @ estimate[second]
        squares.append(np.sum((np.linalg.inv(true_motion) @ motion)[:3, 3] ** 2))
    return float(np.sqrt(np.mean(squares))) if squares else math.nan


# What is run.


def render(edvo, data, sequence):
    folder, flags = data / sequence["name"], sequence["flags"]
    stamp = folder / "synth_flags.txt"
    if stamp.exists() and stamp.read_text() == flags:
        return folder
    shutil.rmtree(folder, ignore_errors=True)
    command = [edvo, "synth", folder, *shlex.split(flags)]
    subprocess.run(command, check=True, capture_output=True, text=True)
    stamp.write_text(flags)  # last, so that an interrupted rendering is made anew
    return folder


def run_edvo(edvo, folder, method):
    """The final trajectory, and how many frames were lost or were tracked but wrong."""
    out = folder / "runs" / method.replace("+", "_")
    command = [edvo, "run", folder, "--method", method, "-o", out, "--force", "--no-report",
               "--quiet", "--threads", "1"]
    finished = subprocess.run(command, capture_output=True, text=True)
    if finished.returncode not in (0, 9):  # 9: no frame could be tracked
        raise RuntimeError(f"{folder.name}: edvo run: {finished.stderr.strip()}")
    truth = read_tum(folder / "groundtruth.txt")
    lines = (out / "frames.jsonl").read_text().splitlines()
    lost, wrong, truth_from_world = 0, 0, None
    for frame in map(json.loads, lines):
        if frame["status"] not in ("first", "tracked"):
            lost += 1
            continue
        pose, true_pose = matrix(frame["pose"]), truth[round(float(frame["stamp"]), 6)]
        if truth_from_world is None:
            truth_from_world = true_pose @ np.linalg.inv(pose)
        error = np.linalg.inv(true_pose) @ truth_from_world @ pose
        off = np.linalg.norm(error[:3, 3]) > WRONG_METRES
        wrong += bool(off or angle_degrees(error[:3, :3]) > WRONG_DEGREES)
    trajectory = out / "trajectory.tum"
    estimate = read_tum(trajectory) if trajectory.exists() else {}
    return {"ate": absolute_error(truth, estimate), "rpe": relative_error(truth, estimate),
            "lost": lost, "wrong": wrong, "frames": len(lines)}


def frames_of(folder):
    import cv2

    for line in (folder / "rgb.txt").read_text().splitlines():
        if line.startswith("#"):
            continue
        stamp, colour = line.split()
        bgr = cv2.imread(str(folder / colour))
        depth = cv2.imread(str(folder / "depth" / f"{stamp}.png"), cv2.IMREAD_UNCHANGED)
        yield round(float(stamp), 6), bgr, depth.astype(np.float32) / DEPTH_UNITS


def intrinsics(folder):
    camera = tomllib.loads((folder / "camera.toml").read_text())
    camera = camera.get("camera", camera)
    return [camera[name] for name in ("fx", "fy", "cx", "cy")]


def opencv_step(folder, peer):
    """A function (frame before, frame) -> 4x4 current from previous, or None if it failed."""
    import cv2

    fx, fy, cx, cy = intrinsics(folder)
    camera = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]], np.float32)
    create = {"rgbd": cv2.rgbd.RgbdOdometry_create, "rgbd_icp": cv2.rgbd.RgbdICPOdometry_create}
    odometry = create[peer](camera)

    def step(before, after):
        images = [(cv2.cvtColor(bgr, cv2.COLOR_BGR2GRAY), np.where(depth > 0, depth, np.nan))
                  for bgr, depth in (before, after)]
        masks = [np.where(depth > 0, 255, 0).astype(np.uint8) for _, depth in (before, after)]
        found, pose = odometry.compute(*images[0], masks[0], *images[1], masks[1])
        return pose if found and pose is not None and np.isfinite(pose).all() else None

    return step


def open3d_step(folder):
    import open3d

    fx, fy, cx, cy = intrinsics(folder)

    def image_of(bgr, depth):
        return open3d.geometry.RGBDImage.create_from_color_and_depth(
            open3d.geometry.Image(np.ascontiguousarray(bgr[:, :, ::-1])),
            open3d.geometry.Image(depth), depth_scale=1, depth_trunc=8,
            convert_rgb_to_intensity=True)

    def step(before, after):
        height, width = before[1].shape
        camera = open3d.camera.PinholeCameraIntrinsic(width, height, fx, fy, cx, cy)
        found, pose, _ = open3d.pipelines.odometry.compute_rgbd_odometry(
            image_of(*before), image_of(*after), camera, np.eye(4),
            open3d.pipelines.odometry.RGBDOdometryJacobianFromHybridTerm())
        return pose if found else None

    return step


def run_peer(folder, peer):
    """Frame to frame with the peer's own defaults; where it fails the camera stands still."""
    cache = folder / "peers" / f"{peer}.json"
    if cache.exists():
        return json.loads(cache.read_text())
    step = open3d_step(folder) if peer == "open3d" else opencv_step(folder, peer)
    world_from_camera, before, estimate, failed = np.eye(4), None, {}, 0
    for stamp, bgr, depth in frames_of(folder):
        if before is not None:
            current_from_previous = step(before, (bgr, depth))
            if current_from_previous is None:
                failed += 1
            else:
                world_from_camera = world_from_camera @ np.linalg.inv(current_from_previous)
        before = (bgr, depth)
        estimate[stamp] = world_from_camera.copy()
    truth = read_tum(folder / "groundtruth.txt")
    result = {"ate": absolute_error(truth, estimate), "rpe": relative_error(truth, estimate),
              "lost": failed}
    cache.parent.mkdir(exist_ok=True)
    cache.write_text(json.dumps(result))
    return result


def measure(options, sequence):
    folder = render(options.edvo, options.data, sequence)
    row = {**sequence, "edvo": {}, "peers": {}}
    for method in options.methods:
        row["edvo"][method] = run_edvo(options.edvo, folder, method)
    for peer in options.peers:
        row["peers"][peer] = run_peer(folder, peer)
    return row


# What is printed.


def ratio(row, method):
    """The worse of ATE and RPE against the best peer's; no result is worst of all."""
    ratios = []
    for error in ("ate", "rpe"):
        best = min((peer[error] for peer in row["peers"].values()), default=math.nan)
        own = row["edvo"][method][error]
        ratios.append(math.inf if math.isnan(own) else own / best)
    return max(ratios)


def print_table(title, rows, options):
    print(f"\n{title}: ATE [m] / RPE [m/s]; ratio: the worse of both against the best peer's\n")
    columns = ["sequence", "sensor", *options.methods, *options.peers,
               *(f"ratio {method}" for method in options.methods), "lost", "wrong, tracked"]
    print("| " + " | ".join(columns) + " |\n|" + " --- |" * len(columns))
    for row in sorted(rows, key=lambda row: -max(ratio(row, m) for m in options.methods)):
        results = [*row["edvo"].values(), *row["peers"].values()]
        cells = [row["name"] + (" (hard)" if row.get("hard") else ""), row["sensor"]]
        cells += [f"{result['ate']:.4f} / {result['rpe']:.4f}" for result in results]
        cells += [f"{ratio(row, method):.2f}" for method in options.methods]
        for count in ("lost", "wrong"):
            cells.append(", ".join(str(result[count]) for result in row["edvo"].values()))
        print("| " + " | ".join(cells) + " |")


def main():
    here = pathlib.Path(__file__).parent
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=pathlib.Path, help="folder of the rendered sequences")
    parser.add_argument("--edvo", default="build/bin/edvo", help="the program")
    parser.add_argument("--manifest", type=pathlib.Path, default=here / "sensors.toml")
    parser.add_argument("--methods", nargs="+", default=["canny+corner", "cnn+corner"])
    parser.add_argument("--peers", nargs="*", default=list(PEERS), choices=PEERS)
    parser.add_argument("--only", default="", help="sequences whose name has this in it")
    parser.add_argument("--jobs", type=int, default=2, help="sequences at a time")
    parser.add_argument("--json", type=pathlib.Path, help="write all results there")
    options = parser.parse_args()
    sequences = tomllib.loads(options.manifest.read_text())["sequence"]
    sequences = [s for s in sequences if options.only in s["name"]]
    options.data.mkdir(parents=True, exist_ok=True)
    with concurrent.futures.ProcessPoolExecutor(options.jobs) as pool:
        rows = []
        for row in pool.map(measure, [options] * len(sequences), sequences):
            print(f"{row['name']}: done", file=sys.stderr)
            rows.append(row)
    for title in ("choose", "held-out"):
        of_set = [row for row in rows if row["set"] == title]
        if of_set:
            print_table(title, of_set, options)
    if options.json:
        options.json.write_text(json.dumps(rows, indent=1))


if __name__ == "__main__":
    main()
