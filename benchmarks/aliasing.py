#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Counts wrong links between keyframes where places look alike.

    benchmarks/aliasing.py OUT [--edvo build/bin/edvo] [--seeds 5] [--kind rooms]

rooms: visits to two rooms of one layout whose posters, covers and furnishings' textures differ. A
link from one room to the other is wrong, unless the odometry did not notice the change itself.
corridor, boxes, office: one visit to and fro where doors, tiles or a carpet repeat.
twins, posters: a walk of 60 m through rooms of one flat that are equal, or equal but for a poster.
both_ways: to and fro in that flat's corridor, which looks alike both ways but for its ends.
desk_rows: to and fro between equal desks 2 m apart.
A link that is more than 10 cm and 10 % of its length off the ground truth is wrong.

Prints each trial's accepted and wrong links, the ATE with and without the search for loops in
trials of one recording, and of walks the recall: of the keyframes within 0.5 m and 20 degrees of
one at least 12 before, the share with a right link. The exit status is 1 if a wrong link was
accepted. Images are 320 x 240.
"""
import argparse
import bisect
import json
import math
import shutil
import subprocess
import sys
from pathlib import Path

# Scene, path, and its length [m] where it has one.
SCENES = {"rooms": ("office", "demo", 0), "corridor": ("corridor", "demo", 0),
          "boxes": ("boxes", "orbit", 0), "office": ("office", "orbit", 0),
          "twins": ("twins", "rounds", 60), "posters": ("posters", "rounds", 60),
          "both_ways": ("twins", "rounds", 30), "desk_rows": ("desk_rows", "rounds", 40)}
FRAMES, RATE, GAP = 120, 10, 12
RECENT = 12  # keyframes, with which no loop is looked for


def lines_of(path):
    return [line.split() for line in path.read_text().splitlines() if line and line[0] != "#"]


def run(command):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if done.returncode not in (0, 3):
        sys.exit(f"{' '.join(str(word) for word in command)}: {done.stderr}")


def render(edvo, folder, scene, path, length, seed):
    if not (folder / "groundtruth.txt").exists():
        run([edvo, "synth", "--scene", scene, "--path", path, "--seed", seed, "--frames", FRAMES,
             "--path-length", length, "--rate", RATE, "--size", "320x240", "--force", folder])


def chain(first, second, folder):
    """One recording of two, with a gap between them. Returns when the first one ends."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    shutil.copy(first / "camera.toml", folder)
    for name, part in (("a", first), ("b", second)):
        (folder / name).symlink_to(part.resolve())
    start = float(lines_of(first / "rgb.txt")[0][0])
    shift = (FRAMES + GAP) / RATE
    for kind in ("rgb", "depth"):
        rows = [(float(stamp), f"a/{name}") for stamp, name in lines_of(first / f"{kind}.txt")]
        begin = float(lines_of(second / f"{kind}.txt")[0][0])
        rows += [(start + shift + float(stamp) - begin, f"b/{name}")
                 for stamp, name in lines_of(second / f"{kind}.txt")]
        (folder / f"{kind}.txt").write_text("".join(f"{s:.6f} {n}\n" for s, n in rows))
    return start + shift - 1 / RATE


def pose(row):
    return [float(value) for value in row[1:8]]


def times(a, b):
    (ax, ay, az, aw), (bx, by, bz, bw) = a, b
    return (aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz)


def turned(q, v):
    return times(times(q, (*v, 0)), (-q[0], -q[1], -q[2], q[3]))[:3]


def position_in(from_pose, to_pose):
    """Of the second camera in the first [m]."""
    q = from_pose[3:]
    return turned((-q[0], -q[1], -q[2], q[3]),
                  [b - a for a, b in zip(from_pose[:3], to_pose[:3])])


def accepted_links(folder):
    path = folder / "links.jsonl"
    links = map(json.loads, path.read_text().splitlines()) if path.exists() else []
    return [link for link in links if link["status"] == "accepted"
            or (link["status"] == "known" and link["overlap"] > 0)]


def true_keyframes(sequence, result):
    """The ground truth of each keyframe of a run: tx ty tz qx qy qz qw."""
    truth = [(float(row[0]), pose(row)) for row in lines_of(sequence / "groundtruth.txt")]
    stamps = [stamp for stamp, _ in truth]

    def nearest(stamp):
        after = bisect.bisect_left(stamps, stamp)
        return min(truth[max(0, after - 1):after + 1], key=lambda entry: abs(entry[0] - stamp))[1]

    return [nearest(float(row[0])) for row in lines_of(result / "keyframes.tum")]


def is_wrong(keys, link):
    true = position_in(keys[link["from"]], keys[link["to"]])
    return math.dist(true, link["from_pose_to"][:3]) > 0.1 + 0.1 * math.hypot(*true)


def wrong_links(keys, links):
    return [link for link in links if is_wrong(keys, link)]


def are_near(a, b):
    """Whether two poses are within 0.5 m and 20 degrees."""
    cosine = abs(sum(p * q for p, q in zip(a[3:], b[3:])))
    return math.dist(a[:3], b[:3]) < 0.5 and cosine > math.cos(math.radians(20) / 2)


def recall(keys, links):
    again = {to for to in range(len(keys))
             if any(are_near(keys[to], keys[i]) for i in range(to - RECENT))}
    found = {link["to"] for link in links if not is_wrong(keys, link)}
    return len(again & found) / len(again) if again else math.nan


def ate_of(folder):
    summary = json.loads((folder / "summary.json").read_text())
    return summary["evaluation"]["final"]["ate_rmse_m"] if summary["evaluation"] else math.nan


def trial_of_rooms(edvo, out, seed):
    for number in (seed, seed + 100):
        render(edvo, out / f"room{number}", *SCENES["rooms"], number)
    border = chain(out / f"room{seed}", out / f"room{seed + 100}", out / f"rooms{seed}")
    result = out / f"rooms{seed}_run"
    run([edvo, "run", out / f"rooms{seed}", "-o", result, "--force", "--no-report", "--quiet"])
    stamps = [float(row[0]) for row in lines_of(result / "keyframes.tum")]
    links = accepted_links(result)
    if json.loads((result / "summary.json").read_text())["frames"]["restarted"] == 0:
        return len(links), 0, "(the odometry tracked from one room into the other)"
    wrong = [k for k in links if (stamps[k["from"]] < border) != (stamps[k["to"]] < border)]
    return len(links), len(wrong), ""


def trial_of_one(edvo, out, kind, seed):
    folder = out / f"{kind}{seed}"
    render(edvo, folder, *SCENES[kind], seed)
    result = out / f"{kind}{seed}_run"
    run([edvo, "run", folder, "-o", result, "--force", "--no-report", "--quiet", "--no-loops"])
    before = ate_of(result)
    run([edvo, "run", folder, "-o", result, "--force", "--no-report", "--quiet"])
    keys, links = true_keyframes(folder, result), accepted_links(result)
    rest = f"ATE {1e3 * before:.2f} -> {1e3 * ate_of(result):.2f} mm"
    if SCENES[kind][1] == "rounds":
        rest += f"  recall {recall(keys, links):.2f}"
    return len(links), len(wrong_links(keys, links)), rest


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path)
    parser.add_argument("--edvo", default="build/bin/edvo")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--kind", choices=SCENES, action="append")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    all_wrong = 0
    for kind in options.kind or SCENES:
        for seed in range(1, options.seeds + 1):
            if kind == "rooms":
                links, wrong, rest = trial_of_rooms(options.edvo, options.out, seed)
            else:
                links, wrong, rest = trial_of_one(options.edvo, options.out, kind, seed)
            print(f"{kind:10} seed {seed:2}: {links:4} links, {wrong} wrong  {rest}", flush=True)
            all_wrong += wrong
    print(f"{all_wrong} wrong links")
    sys.exit(all_wrong > 0)


if __name__ == "__main__":
    main()
