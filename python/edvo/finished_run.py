# SPDX-License-Identifier: MIT
"""A finished run's folder in Rerun."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from edvo.errors import Error
from edvo.evaluation import evaluate
from edvo.rerun_log import FINAL, TRUTH, Log, Rows
from edvo.sources.untrusted import reading
from edvo.stamp import from_seconds
from edvo.trajectory import Trajectory


def log_run(log: Log, folder: Path) -> None:
    """Raises edvo.Error naming a file that no run writes like that."""
    rows = Rows(log)
    file = folder / "frames.jsonl"
    with reading(file), file.open(encoding="utf-8") as lines:
        for number, line in enumerate(lines, 1):
            with reading(f"{file}:{number}"):
                log_frame(log, rows, line)
        rows.send()
    trajectory = Trajectory.read(folder / "trajectory.tum")
    log.lines("world/path_at_the_end", trajectory, FINAL)
    if (folder / "keyframes.tum").is_file():
        keyframes = Trajectory.read(folder / "keyframes.tum")
        for i, pose in enumerate(keyframes.poses):
            log.pose(f"world/keyframes/{i}", pose)
    truth = truth_of(folder / "summary.json")
    if truth is not None and truth.is_file():
        log_truth(log, Trajectory.read(truth), trajectory)


def log_frame(log: Log, rows: Rows, line: str) -> None:
    frame = json.loads(line)
    stamp = from_seconds(float(frame["stamp"]))
    log.at(stamp)
    if frame["status"] == "skipped":
        log.event(f"frame {frame['index']} skipped: {frame['reason']}", "WARN")
        return
    if frame["status"] == "lost":
        log.event(f"lost: {frame['loss_cause']}", "WARN")
    if frame["keyframe_reason"]:
        log.event(f"keyframe: {frame['keyframe_reason']}")
    pose = Trajectory(np.zeros(1, np.int64), np.array([frame["pose"]])).poses[0]
    inliers, overlap = float(frame["inlier_ratio"] or np.nan), float(frame["overlap"] or np.nan)
    rows.add(stamp, pose, inliers, overlap, float(frame["ms"]["total"]))


def truth_of(summary: Path) -> Path | None:
    """The ground truth that a run was compared with."""
    if not summary.is_file():
        return None
    with reading(summary):
        evaluation = json.loads(summary.read_text(encoding="utf-8"))["evaluation"]
        return Path(evaluation["ground_truth"]) if evaluation else None


def log_truth(log: Log, truth: Trajectory, trajectory: Trajectory) -> None:
    try:
        pose = np.linalg.inv(evaluate(truth, trajectory).truth_from_estimate)
    except Error:
        return
    log.line("world/ground_truth", truth.positions @ pose[:3, :3].T + pose[:3, 3], TRUTH)
