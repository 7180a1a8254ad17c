# SPDX-License-Identifier: MIT
"""A tree of coordinate frames that move in time (ROS tf)."""

from __future__ import annotations

from bisect import bisect_left
from collections import defaultdict

import numpy as np
from numpy.typing import NDArray

from edvo.trajectory import Trajectory

Pose = NDArray[np.float64]  # 4 x 4


class TransformTree:
    """Transforms parent_from_child by child; names without leading slashes."""

    def __init__(self) -> None:
        self._parent: dict[str, str] = {}
        self._stamps: defaultdict[str, list[int]] = defaultdict(list)
        self._poses: defaultdict[str, list[Pose]] = defaultdict(list)
        self._unsorted: set[str] = set()

    def add(self, parent: str, child: str, stamp_ns: int, parent_from_child: Pose) -> None:
        child = child.strip("/")
        if self._stamps[child] and stamp_ns < self._stamps[child][-1]:
            self._unsorted.add(child)
        self._parent[child] = parent.strip("/")
        self._stamps[child].append(stamp_ns)
        self._poses[child].append(parent_from_child)

    def path_up(self, frame: str) -> list[str]:
        """The frame, its parent and so on, without the root."""
        path: list[str] = []
        frame = frame.strip("/")
        while frame in self._parent and frame not in path:
            path.append(frame)
            frame = self._parent[frame]
        return path

    def root_of(self, frame: str) -> str:
        path = self.path_up(frame)
        return self._parent[path[-1]] if path else frame.strip("/")

    def moves(self, child: str) -> bool:
        poses = self._poses[child]
        return any(np.abs(pose - poses[0]).max() > 1e-6 for pose in poses[1:])

    def _at(self, child: str, stamp_ns: int) -> Pose:
        stamps = self._stamps[child]
        if child in self._unsorted:
            self._unsorted.remove(child)
            order = np.argsort(stamps, kind="stable")
            self._stamps[child] = stamps = [stamps[i] for i in order]
            self._poses[child] = [self._poses[child][i] for i in order]
        after = min(bisect_left(stamps, stamp_ns), len(stamps) - 1)
        before = max(after - 1, 0)
        nearest = min((before, after), key=lambda i: abs(stamps[i] - stamp_ns))
        return self._poses[child][nearest]

    def root_from(self, frame: str, stamp_ns: int) -> Pose:
        pose = np.eye(4)
        for child in self.path_up(frame):
            pose = self._at(child, stamp_ns) @ pose
        return pose

    def between(self, target: str, source: str) -> Pose | None:
        """target_from_source of two frames that do not move against each other, if known."""
        if target.strip("/") == source.strip("/"):
            return np.eye(4)
        if self.root_of(target) != self.root_of(source):
            return None
        up_target, up_source = self.path_up(target), self.path_up(source)
        apart = set(up_target) ^ set(up_source)
        if any(self.moves(child) for child in apart):
            return None
        return np.asarray(np.linalg.inv(self.root_from(target, 0)) @ self.root_from(source, 0))

    def trajectory_of(self, frame: str) -> Trajectory | None:
        """The frame in the root, at the stamps of the link that is known most often."""
        moving = [child for child in self.path_up(frame) if self.moves(child)]
        if not moving:
            return None
        densest = max(moving, key=lambda child: len(self._stamps[child]))
        self._at(densest, 0)  # puts its stamps in order
        stamps = sorted(set(self._stamps[densest]))
        poses = np.array([self.root_from(frame, stamp) for stamp in stamps])
        return Trajectory.from_poses(np.array(stamps, np.int64), poses)
