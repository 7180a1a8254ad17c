# SPDX-License-Identifier: MIT
"""What the benchmarks of single trials share: rendering, running, and judging each frame.

A frame is wrong if it is called tracked and its pose, relative to the first one of its segment, is
more than 10 cm or 5 degrees off the ground truth.
"""
import json
import shutil
import subprocess
import sys
from dataclasses import dataclass, field

import numpy as np

WRONG_METRES, WRONG_DEGREES = 0.10, 5.0


# That no frame could be tracked, or that a run shows no place of a map, is a result.
RESULTS = (0, 9, 11)


def call(*command):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True,
                          check=False)
    if done.returncode not in RESULTS:
        sys.exit(f"{' '.join(str(word) for word in command)}: {done.stderr}")


def synth(edvo, folder, **options):
    """Renders 320 x 240 images; options as of `edvo synth`, with _ for -."""
    words = [word for name, value in options.items()
             for word in ("--" + name.replace("_", "-"), value)]
    shutil.rmtree(folder, ignore_errors=True)
    call(edvo, "synth", folder, "--size", "320x240", "--threads", 1, *words)


def run(edvo, folder, out, *arguments):
    call(edvo, "run", folder, "-o", out, "--force", "--no-report", "--quiet", *arguments)


def matrix(numbers):
    """4 x 4, of tx ty tz qx qy qz qw."""
    x, y, z, w = np.array(numbers[3:7]) / np.linalg.norm(numbers[3:7])
    pose = np.eye(4)
    pose[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                    [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                    [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    pose[:3, 3] = numbers[:3]
    return pose


def between(a, b):
    """Distance [m] and angle [deg] between two poses."""
    motion = np.linalg.inv(a) @ b
    cosine = np.clip((np.trace(motion[:3, :3]) - 1) / 2, -1, 1)
    return float(np.linalg.norm(motion[:3, 3])), float(np.degrees(np.arccos(cosine)))


def is_wrong(error):
    return error[0] > WRONG_METRES or error[1] > WRONG_DEGREES


class Truth:
    """Ground truth of a sequence: the pose nearest to a stamp."""

    def __init__(self, folder):
        rows = np.loadtxt(folder / "groundtruth.txt")
        self.stamps = rows[:, 0]
        self.poses = [matrix(row[1:8]) for row in rows]

    def at(self, stamp):
        return self.poses[int(np.argmin(abs(self.stamps - float(stamp))))]


@dataclass
class Counts:
    frames: int = 0
    tracked: int = 0
    wrong: int = 0  # among those tracked
    lost: int = 0
    worst: float = 0  # position error of tracked frames [m]
    wrong_frames: list = field(default_factory=list)

    def add(self, other):
        for name in ("frames", "tracked", "wrong", "lost"):
            setattr(self, name, getattr(self, name) + getattr(other, name))
        self.worst = max(self.worst, other.worst)


def frames_of(run_folder):
    return [json.loads(line) for line in (run_folder / "frames.jsonl").read_text().splitlines()]


def judge(frames, truth, skip=lambda frame: False):
    """Counts of frames of a run. Of a restarted frame the pose is a guess: not tracked, nor lost."""
    counts = Counts()
    first = {}  # pose and ground truth of each segment's first frame
    for frame in frames:
        counts.frames += 1
        if frame["status"] in ("lost", "skipped"):
            counts.lost += 1
            continue
        if skip(frame):
            continue
        true, pose = truth.at(frame["stamp"]), matrix(frame["pose"])
        begin, true_begin = first.setdefault(frame["segment"], (pose, true))
        if frame["status"] == "restarted":
            continue
        error = between(np.linalg.inv(true_begin) @ true, np.linalg.inv(begin) @ pose)
        counts.tracked += 1
        counts.worst = max(counts.worst, error[0])
        if is_wrong(error):
            counts.wrong += 1
            counts.wrong_frames.append(frame["index"])
    return counts
