# SPDX-License-Identifier: MIT
"""Which poses of a bag are ground truth of the camera, and which are only compared with."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import edvo
from planted import Memory

pytest.importorskip("rosbags")

from bag_recorder import PERIOD, START, Recorder, millimetres  # noqa: E402

Q = (-0.5, 0.5, -0.5, 0.5)  # of a camera that looks along x of its robot: z forwards, y down


def odometry(recorder: Recorder, topic: str, stamp: int, parent: str, body: str, x: float) -> None:
    make = recorder.make
    pose = make(
        "geometry_msgs/msg/Pose",
        position=make("geometry_msgs/msg/Point", x=x, y=0.0, z=0.0),
        orientation=make("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=1.0, w=0.0),
    )
    zero = make("geometry_msgs/msg/Vector3", x=0.0, y=0.0, z=0.0)
    message = make(
        "nav_msgs/msg/Odometry",
        header=recorder.header(stamp, parent),
        child_frame_id=body,
        pose=make("geometry_msgs/msg/PoseWithCovariance", pose=pose, covariance=np.zeros(36)),
        twist=make(
            "geometry_msgs/msg/TwistWithCovariance",
            twist=make("geometry_msgs/msg/Twist", linear=zero, angular=zero),
            covariance=np.zeros(36),
        ),
    )
    recorder.write(topic, message, stamp)


def record(folder: Path, camera: edvo.Camera, frames: list[edvo.Frame], **poses: Any) -> edvo.Source:
    """``topic``, ``parent`` and ``body`` of an odometry, ``static``: with TF from body to camera."""
    recorder = Recorder("mcap", folder)
    recorder.info("/camera/color/camera_info", START, camera, "optical")
    for i, frame in enumerate(frames):
        stamp = START + i * PERIOD
        recorder.image("/camera/color/image_raw", stamp, frame.rgb, "rgb8", "optical")
        recorder.image("/camera/depth/image_raw", stamp, millimetres(frame), "16UC1", "optical")
        if "topic" in poses:
            names = poses["topic"], stamp, poses["parent"], poses["body"]
            odometry(recorder, *names, 0.1 * i)
        if "tf" in poses:
            recorder.transform("/tf", stamp, poses["tf"], "base_link", (0.1 * i, 0, 0))
    if poses.get("static", True):
        recorder.transform("/tf_static", START, "base_link", "optical", (0.3, 0, 0.5), Q)
    return edvo.open_source(recorder.close())


def test_odometry_is_a_reference_and_is_carried_to_the_camera(
    tmp_path: Path, camera: edvo.Camera, frames: list[edvo.Frame]
) -> None:
    source = record(tmp_path, camera, frames[:4], topic="/odom", parent="odom", body="base_link")
    assert source.is_reference_only
    assert source.ground_truth_origin == "reference: /odom (odometry, not ground truth)"
    assert source.ground_truth is not None
    # The robot is turned by half a turn about z: its camera, 0.3 m ahead, is at -0.3 m.
    assert np.allclose(source.ground_truth.positions[0], [-0.3, 0, 0.5], atol=1e-9)
    assert np.allclose(source.ground_truth.poses[0][:3, 2], [-1, 0, 0], atol=1e-9)


def test_a_body_that_tf_does_not_connect_is_no_ground_truth_and_said(
    tmp_path: Path, camera: edvo.Camera, frames: list[edvo.Frame]
) -> None:
    poses = {"topic": "/ground_truth/odom", "parent": "map", "body": "base_link"}
    source = record(tmp_path, camera, frames[:4], **poses, static=False)
    assert source.is_reference_only
    assert any("no TF says where the images' frame 'optical' is" in note for note in source.notes)


@pytest.mark.parametrize(
    ("poses", "origin"),
    [
        ({"topic": "/ground_truth/odom", "parent": "map", "body": "base_link"}, "ground truth: /gr"),
        ({"topic": "/gt_odom", "parent": "map", "body": "base_link"}, "ground truth: /gt_odom"),
        ({"tf": "world"}, "ground truth: TF from world to optical"),
        ({"tf": "mocap"}, "ground truth: TF from mocap to optical"),
        ({"tf": "odom"}, "reference: TF from odom to optical (odometry"),
        ({"tf": "map"}, "reference: TF from map to optical (no name calls it ground truth"),
        ({"topic": "/rover/vio/pose", "parent": "world", "body": "base_link"}, "reference: /rover"),
        (
            {"tf": "odom", "topic": "/vicon/odom", "parent": "vicon", "body": "base_link"},
            "ground truth: /vicon/odom",
        ),
    ],
)
def test_only_names_that_say_so_are_ground_truth(
    poses: dict[str, str], origin: str, tmp_path: Path, camera: edvo.Camera, frames: list[edvo.Frame]
) -> None:
    source = record(tmp_path, camera, frames[:4], **poses)
    assert source.ground_truth_origin.startswith(origin)
    assert source.is_reference_only == origin.startswith("reference")


def test_a_recording_of_edvo_is_not_compared_with_itself_as_truth(
    tmp_path: Path, camera: edvo.Camera, frames: list[edvo.Frame]
) -> None:
    from edvo.mcap_file import McapObserver

    file = tmp_path / "own.mcap"
    edvo.run(Memory(camera, frames[:5]), observers=[McapObserver(file)])
    source = edvo.open_source(file)
    assert source.is_reference_only and "edvo's own estimate" in source.ground_truth_origin


def test_a_reference_makes_no_fault_of_scale(camera: edvo.Camera, frames: list[edvo.Frame]) -> None:
    path = edvo.run(Memory(camera, frames)).trajectory
    values = path.values.copy()
    values[:, :3] *= 1.3
    wheels = Memory(camera, frames, edvo.Trajectory(path.stamps_ns, values))

    def scale() -> edvo.Finding:
        return next(f for f in edvo.diagnose(wheels) if f.fault == "scale")

    assert scale().verdict == "fault"
    wheels.is_reference_only = True
    assert scale().verdict == "unknown" and "reference" in scale().measured
