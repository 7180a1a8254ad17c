# SPDX-License-Identifier: MIT
"""Poses in a bag: ground truth, or a reference that is itself an estimate, in the camera's frame."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from edvo.errors import Error
from edvo.sources import messages
from edvo.sources.pairing import reads
from edvo.sources.transforms import TransformTree
from edvo.trajectory import Trajectory

POSES = (
    "nav_msgs/msg/Odometry",
    "geometry_msgs/msg/PoseStamped",
    "geometry_msgs/msg/TransformStamped",
)
TRUTH = ("truth", "vicon", "mocap", "optitrack", "qualisys", "vrpn")
TRUTH_TOKENS = ("gt",)  # whole words: "weight" holds none
ROOMS = ("world",)  # parent frames of what measures from outside
ESTIMATE = ("odom", "wheel", "slam")
ESTIMATE_TOKENS = ("vio", "vo")
OWN = "/edvo/"  # topics of edvo's own recordings


@dataclass(frozen=True)
class Reference:
    trajectory: Trajectory  # of the camera, where TF tells how it is mounted
    where: str  # "TF from world to camera", "/odom"
    flaw: str = ""  # why it is no ground truth
    note: str = ""  # what is not known of it

    @property
    def origin(self) -> str:
        if self.flaw:
            return f"reference: {self.where} ({self.flaw}, not ground truth)"
        return f"ground truth: {self.where}"


def says(names: list[str], words: tuple[str, ...], tokens: tuple[str, ...]) -> bool:
    text = " ".join(names).lower()
    return any(word in text for word in words) or bool(set(tokens) & set(re.split(r"[^a-z]+", text)))


def flaw_of(names: list[str]) -> str:
    """Empty where topics or frames say that their poses were measured from outside.

    A motion-capture system names its topic; /ground_truth/odom is ground truth, too.
    """
    if says(names, TRUTH, TRUTH_TOKENS):
        return ""
    if says(names, ESTIMATE, ESTIMATE_TOKENS):
        return "odometry"
    return "" if says(names, (), ROOMS) else "no name calls it ground truth"


def find_reference(reader: Any, tree: TransformTree, camera_frame: str) -> Reference | None:
    """Ground truth before what is none, TF before topics."""
    found = [reference_of_tf(reader, tree, camera_frame)]
    for name, topic in reader.topics.items():
        words = (*TRUTH, *ESTIMATE, "pose")
        if topic.msgtype in POSES and says([name], words, (*TRUTH_TOKENS, *ESTIMATE_TOKENS)):
            found.append(reference_of_topic(reader, name, tree, camera_frame))
    usable = [reference for reference in found if reference is not None]
    return min(usable, key=lambda reference: bool(reference.flaw), default=None)


def reference_of_tf(reader: Any, tree: TransformTree, camera_frame: str) -> Reference | None:
    trajectory = tree.trajectory_of(camera_frame)
    if trajectory is None:
        return None
    root = tree.root_of(camera_frame)
    is_own = any(name.startswith(OWN) for name in reader.topics)
    flaw = "edvo's own estimate" if is_own else flaw_of([root, *tree.path_up(camera_frame)])
    return Reference(trajectory, f"TF from {root} to {camera_frame}", flaw)


def reference_of_topic(
    reader: Any, topic: str, tree: TransformTree, camera_frame: str
) -> Reference | None:
    """The poses of a topic, carried to the camera where TF tells how it is mounted on their body."""
    stamps, poses, parent, body = read_poses(reader, topic)
    if len(stamps) < 3:
        return None
    flaw = flaw_of([topic, parent])
    body_from_camera = tree.between(body, camera_frame) if body else None
    note = ""
    if body_from_camera is None:
        body_from_camera = np.eye(4)
        note = f"{topic} does not name its body: it is taken as the pose of the camera"
    if body and note:
        flaw = flaw or f"of {body}"
        note = (
            f"{topic} is of {body}, and no TF says where the images' frame {camera_frame!r} is on "
            "it: turns of a camera beside it look like errors"
        )
    trajectory = Trajectory.from_poses(np.array(stamps, np.int64), poses @ body_from_camera)
    return Reference(trajectory, topic, flaw, note)


def pose_of(message: Any) -> NDArray[np.float64]:
    if hasattr(message, "transform"):
        return messages.pose_from(message.transform.translation, message.transform.rotation)
    inner = message.pose.pose if hasattr(message.pose, "pose") else message.pose
    return messages.pose_from(inner.position, inner.orientation)


def read_poses(reader: Any, topic: str) -> tuple[list[int], NDArray[np.float64], str, str]:
    """Stamps [ns] in order, N x 4 x 4 parent_from_body, and the frames' names ("" = not said)."""
    stamps: list[int] = []
    poses: list[NDArray[np.float64]] = []
    parent = body = ""
    connections = [c for c in reader.connections if c.topic == topic]
    for connection, _, raw in reader.messages(connections=connections):
        try:
            message = reads(reader, topic, raw, connection.msgtype)()
            pose = pose_of(message)
        except Error:
            continue  # a damaged message costs its own pose only
        parent, body = message.header.frame_id, getattr(message, "child_frame_id", "")
        if not stamps or messages.stamp_ns(message) > stamps[-1]:
            stamps.append(messages.stamp_ns(message))
            poses.append(pose)
    return stamps, np.array(poses).reshape(-1, 4, 4), parent, body
