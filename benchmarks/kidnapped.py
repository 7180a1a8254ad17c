#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Takes the camera away from rendered rooms, and counts how often it is found again, and where.

    benchmarks/kidnapped.py OUT [--edvo build/bin/edvo] [--seeds 4] [--kind covered] [--keep]

covered: 150 frames, 60 without light and depth, then 40 frames from elsewhere, where a keyframe lies
    within 0.5 m and 20 degrees (by the ground truth; other trials are left out).
wall: the same, but the 60 frames show a white wall.
    Found: of the first ten frames afterwards one has a pose in the frame of the map. Each such pose
    within 40 frames has to be right to 5 cm and 2 degrees; one off by 10 cm or 5 degrees is wrong.
gap: 0.3 to 1 s of a motion are missing. slow: 5 Hz. fast: turning at 180 deg/s, 30 Hz.
    Frames are counted as in moving.py, those after the gap or all, apart by whether the view shares
    40 % with the frame before it.
light: localization in a saved map of the room: another path, another seed of noise, a quarter of the
    light, exposure that jumps. Share of frames within 3 cm.

Images are 320 x 240 and are removed after each trial unless --keep is given. Needs numpy and
opencv-python.
"""
import argparse
import json
import math
import shutil
from pathlib import Path

import cv2
import numpy as np

from trials import (Counts, Truth, between, frames_of, is_wrong, judge, matrix, run, synth)

SCENES = ("office", "living_room", "desk", "boxes")
BEFORE, AWAY, AFTER = 150, 60, 40  # frames
LONG = 560                         # frames of the motion that trials are taken from
NEAR_METRES, NEAR_DEGREES = 0.5, 20
RIGHT_METRES, RIGHT_DEGREES = 0.05, 2
SOON = 10            # frames
RIGHT_IN_MAP = 0.03  # [m]
SHARED = 0.4
TRIALS_PER_SEED = 6
CAMERA = (262.5, 262.5, 159.5, 119.5)  # of edvo synth --size 320x240


def read_list(folder, name):
    lines = (folder / f"{name}.txt").read_text().splitlines()
    return [line.split()[1] for line in lines if line and line[0] != "#"]


def sources_of(folder):
    """(colour, depth) of each frame, and its pose."""
    rows = zip(read_list(folder, "rgb"), read_list(folder, "depth"))
    pairs = [(folder / colour, folder / depth) for colour, depth in rows]
    truth = Truth(folder)
    return pairs, [truth.at(pair[0].stem) for pair in pairs]


def compose(folder, camera, pairs, stamps):
    """A recording of images that are there: links to them, in the order given."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    shutil.copy(camera, folder / "camera.toml")
    for k, name in enumerate(("rgb", "depth")):
        (folder / name).mkdir()
        lines = []
        for i, pair in enumerate(pairs):
            (folder / name / f"{i:04}.png").symlink_to(pair[k].resolve())
            lines.append(f"{stamps[i]:.6f} {name}/{i:04}.png\n")
        (folder / f"{name}.txt").write_text("".join(lines))


def black_pair(out):
    colour, depth = out / "black_rgb.png", out / "black_depth.png"
    cv2.imwrite(str(colour), np.zeros((240, 320, 3), np.uint8))
    cv2.imwrite(str(depth), np.zeros((240, 320), np.uint16))
    return colour, depth


def shared_view(pair, before, after):
    """Share of a frame's pixels with depth that are seen from another pose, by nothing but geometry."""
    depth = cv2.imread(str(pair[1]), cv2.IMREAD_UNCHANGED)[2::4, 2::4].astype(float) / 5000
    fx, fy, cx, cy = CAMERA
    v, u = np.mgrid[2:240:4, 2:320:4][:, :depth.shape[0], :depth.shape[1]]
    points = np.stack([(u - cx) / fx * depth, (v - cy) / fy * depth, depth, np.ones_like(depth)], -1)
    points = points[depth > 0] @ (np.linalg.inv(after) @ before).T
    z = points[:, 2]
    x, y = fx * points[:, 0] / z + cx, fy * points[:, 1] / z + cy
    inside = (z > 0.1) & (x >= 0) & (x < 320) & (y >= 0) & (y < 240)
    return float(inside.mean()) if len(inside) else 0.0


def poses_by_segment(path):
    """(segment, pose) of each stamp [ms]."""
    poses, segment = {}, 0
    for line in path.read_text().splitlines():
        if line.startswith("# segment"):
            segment = int(line.split()[2])
        elif line and line[0] != "#":
            words = [float(word) for word in line.split()]
            poses[round(1000 * words[0])] = (segment, matrix(words[1:8]))
    return poses


def poses_in_map(path):
    """Pose of each stamp [ms] whose segment is the first one."""
    return {stamp: pose for stamp, (segment, pose) in poses_by_segment(path).items()
            if segment == 0}


def places_to_go(poses, random):
    """Frames after which the camera goes on elsewhere, near to what it saw before."""
    seen = poses[:BEFORE:5]
    good = []
    for begin in range(BEFORE + AWAY, LONG - AFTER):
        nearest = min((between(pose, poses[begin]) for pose in seen),
                      key=lambda d: d[0] / NEAR_METRES + d[1] / NEAR_DEGREES)
        moved = between(poses[BEFORE - 1], poses[begin])
        if (nearest[0] < NEAR_METRES and nearest[1] < NEAR_DEGREES
                and (moved[0] > 0.2 or moved[1] > 15)):
            good.append(begin)
    return [int(begin) for begin in random.choice(good, min(TRIALS_PER_SEED, len(good)), False)]


def kidnap(edvo, out, kind, seed, away, keep):
    scene = SCENES[seed % len(SCENES)]
    folder = out / f"{scene}{seed}"
    synth(edvo, folder, scene=scene, seed=seed, frames=LONG)
    pairs, poses = sources_of(folder)
    rows = []
    for begin in places_to_go(poses, np.random.default_rng(seed)):
        chosen = list(range(BEFORE)) + [None] * AWAY + list(range(begin, begin + AFTER))
        stamps = [1 + i / 30 for i in range(len(chosen))]
        trial, result = out / f"{kind}{seed}-{begin}", out / f"{kind}{seed}-{begin}_run"
        compose(trial, folder / "camera.toml",
                [away[i % len(away)] if k is None else pairs[k] for i, k in enumerate(chosen)],
                stamps)
        run(edvo, trial, result)
        rows.append((f"{kind} {scene} {seed} {begin}", outcome_of(result, stamps, chosen, poses)))
        if not keep:
            shutil.rmtree(trial)
            shutil.rmtree(result)
    if not keep:
        shutil.rmtree(folder)
    return rows


def outcome_of(result, stamps, chosen, poses):
    """Frames until found (or none), largest errors in the map, wrong frames; None: no keyframe near."""
    live = poses_in_map(result / "trajectory_online.tum")
    final = poses_in_map(result / "trajectory.tum")
    keys = [float(line.split()[0]) for line in (result / "keyframes.tum").read_text().splitlines()
            if line and line[0] != "#"]
    begin = BEFORE + AWAY
    near = [between(poses[chosen[round((key - 1) * 30)]], poses[chosen[begin]])
            for key in keys if round((key - 1) * 30) < BEFORE]
    if not any(d < NEAR_METRES and a < NEAR_DEGREES for d, a in near):
        return None
    found, errors, final_errors, wrong = None, [], [], 0
    for i in range(begin, begin + AFTER):
        true = np.linalg.inv(poses[0]) @ poses[chosen[i]]
        stamp = round(1000 * stamps[i])
        if stamp in live:
            found = i - begin + 1 if found is None else found
            errors.append(between(true, live[stamp]))
            wrong += is_wrong(errors[-1])
        if stamp in final:
            final_errors.append(between(true, final[stamp]))
    largest = tuple(max(e) for e in zip(*errors)) if errors else (math.nan, math.nan)
    at_end = tuple(max(e) for e in zip(*final_errors)) if final_errors else (math.nan, math.nan)
    return {"found": found, "largest": largest, "final": at_end, "wrong": wrong,
            "frames": len(errors)}


def kidnapped(options, kind):
    out = options.out
    if kind == "covered":
        away = [black_pair(out)]
    else:
        synth(options.edvo, out / "wall", scene="wall", seed=1, frames=AWAY)
        away = sources_of(out / "wall")[0]
    rows = []
    for seed in range(options.first, options.first + options.seeds):
        for name, outcome in kidnap(options.edvo, out, kind, seed, away, options.keep):
            rows.append((name, outcome))
            print(name, outcome or "no keyframe near", flush=True)
    rows = [outcome for _, outcome in rows if outcome]
    soon = [r for r in rows if r["found"] and r["found"] <= SOON]
    right = [r for r in soon
             if r["largest"][0] <= RIGHT_METRES and r["largest"][1] <= RIGHT_DEGREES]
    print(f"{kind}: {len(rows)} trials with a keyframe near, {len(soon)} found within {SOON} frames, "
          f"{len(right)} of them within {100 * RIGHT_METRES:.0f} cm and {RIGHT_DEGREES} degrees in "
          f"all frames; {sum(r['frames'] for r in rows)} frames in the map, "
          f"{sum(r['wrong'] for r in rows)} wrong")


def gaps(options, kind):
    """Frames that share enough with the frame before them, and those that do not."""
    enough, less = Counts(), Counts()
    for seed in range(options.first, options.first + options.seeds):
        scene = SCENES[seed % len(SCENES)]
        folder = options.out / f"{scene}{seed}"
        synth(options.edvo, folder, scene=scene, seed=seed, **{
            "gap": {"frames": 150}, "slow": {"frames": 60, "rate": 5},
            "fast": {"frames": 60, "path": "pure_rotation", "rate": 10}}[kind])
        pairs, poses = sources_of(folder)
        random = np.random.default_rng(seed)
        if kind == "gap":  # at three places of each room
            choices = [(int(random.integers(30, 60)), length)
                       for length in random.choice([9, 15, 20, 25, 30], 3, False)]
            orders = [list(range(at)) + list(range(at + length, at + length + 40))
                      for at, length in choices]
            rate = 30
        else:
            orders, rate = [list(range(len(pairs)))], 5 if kind == "slow" else 30
        for order in orders:
            begin = next((i for i in range(1, len(order)) if order[i] > order[i - 1] + 1), 1)
            trial, result = options.out / f"{kind}{seed}", options.out / f"{kind}{seed}_run"
            compose(trial, folder / "camera.toml", [pairs[k] for k in order],
                    [1 + (k if kind == "gap" else i) / rate for i, k in enumerate(order)])
            write_truth(trial, [poses[k] for k in order],
                        [1 + (k if kind == "gap" else i) / rate for i, k in enumerate(order)])
            run(options.edvo, trial, result)
            share = min(shared_view(pairs[order[i - 1]], poses[order[i - 1]], poses[order[i]])
                        for i in (range(begin, begin + 1) if kind == "gap" else
                                  range(1, len(order))))
            frames = frames_of(result)
            counts = judge(frames, Truth(trial), lambda frame: frame["index"] < begin)
            counts.frames -= begin
            segments = len({frame["segment"] for frame in frames})
            missing = f"{order[begin] - order[begin - 1] - 1} frames missing, " * (kind == "gap")
            print(f"{kind} {scene} {seed}: {missing}at least {100 * share:.0f} % shared, "
                  f"{counts.tracked} tracked, {counts.wrong} wrong, {counts.lost} lost, "
                  f"{segments} segments, worst {counts.worst:.3f} m", flush=True)
            (enough if share >= SHARED else less).add(counts)
            if not options.keep:
                shutil.rmtree(trial)
                shutil.rmtree(result)
        if not options.keep:
            shutil.rmtree(folder)
    for name, counts in ((f"{100 * SHARED:.0f} % shared", enough), ("less", less)):
        print(f"{kind}, {name}: {counts.frames} frames, {counts.tracked} tracked, "
              f"{counts.wrong} wrong, {counts.lost} lost")


def write_truth(folder, poses, stamps):
    lines = []
    for pose, stamp in zip(poses, stamps):
        x, y, z, w = quaternion(pose[:3, :3])
        tx, ty, tz = pose[:3, 3]
        lines.append(f"{stamp:.6f} {tx:.6f} {ty:.6f} {tz:.6f} {x:.8f} {y:.8f} {z:.8f} {w:.8f}\n")
    (folder / "groundtruth.txt").write_text("".join(lines))


def quaternion(R):
    vector, _ = cv2.Rodrigues(R)
    angle = float(np.linalg.norm(vector))
    axis = vector[:, 0] / angle if angle > 0 else np.zeros(3)
    return [*(math.sin(angle / 2) * axis), math.cos(angle / 2)]


def localized_poses(result):
    """Pose of each stamp [ms] that is in the map's frame; none if the run was not found in it."""
    path = result / "localization.jsonl"
    lines = map(json.loads, path.read_text().splitlines()) if path.exists() else []
    stamps = {round(1000 * float(line["stamp"])) for line in lines if line["localized"]}
    poses = poses_by_segment(result / "trajectory.tum")
    return {stamp: poses[stamp][1] for stamp in stamps if stamp in poses}


def light(options):
    """Share of a session's frames within 3 cm in the map of another one."""
    everything = [0, 0]
    for seed in range(options.first, options.first + options.seeds):
        scene = SCENES[seed % len(SCENES)]
        first, second = options.out / f"{scene}{seed}a", options.out / f"{scene}{seed}b"
        saved, result = options.out / f"{scene}{seed}.map", options.out / f"{scene}{seed}_run"
        synth(options.edvo, first, scene=scene, seed=seed, frames=300)
        synth(options.edvo, second, scene=scene, seed=seed, frames=150, path="orbit", light=0.25,
              exposure_jump=1.4)
        run(options.edvo, first, result, "--save-map", saved)
        run(options.edvo, second, result, "--map", saved)
        world, truth = np.linalg.inv(Truth(first).poses[0]), Truth(second)
        poses = localized_poses(result)
        right = sum(between(world @ truth.at(stamp / 1000), pose)[0] < RIGHT_IN_MAP
                    for stamp, pose in poses.items())
        print(f"light {scene} {seed}: {len(poses)} of 150 in the map, {right} within 3 cm",
              flush=True)
        everything[0] += right
        everything[1] += 150
        if not options.keep:
            for folder in (first, second, result):
                shutil.rmtree(folder)
            saved.unlink()
    print(f"light: {everything[0]} of {everything[1]} frames within 3 cm")


def main():
    kinds = {"covered": kidnapped, "wall": kidnapped, "gap": gaps, "slow": gaps, "fast": gaps,
             "light": lambda options, _: light(options)}
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path, metavar="OUT")
    parser.add_argument("--edvo", default="build/bin/edvo", metavar="PROGRAM")
    parser.add_argument("--seeds", type=int, default=4, help="rooms of each kind")
    parser.add_argument("--first", type=int, default=1, help="the first seed")
    parser.add_argument("--kind", choices=kinds, action="append")
    parser.add_argument("--keep", action="store_true", help="keep images and runs")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    for kind in options.kind or kinds:
        kinds[kind](options, kind)


if __name__ == "__main__":
    main()
