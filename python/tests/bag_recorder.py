# SPDX-License-Identifier: MIT
"""Writes bags with the independent library rosbags."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import edvo

pytest.importorskip("rosbags")

from rosbags.rosbag1 import Writer as Writer1  # noqa: E402
from rosbags.rosbag2 import StoragePlugin  # noqa: E402
from rosbags.rosbag2 import Writer as Writer2  # noqa: E402
from rosbags.typesys import Stores, get_types_from_msg, get_typestore  # noqa: E402

START = 1_600_000_000_123_456_789
PERIOD = 33_333_333


class Recorder:
    """One bag of any kind."""

    def __init__(self, kind: str, folder: Path) -> None:
        self.is_ros1 = kind == "ros1"
        self.store = get_typestore(Stores.ROS1_NOETIC if self.is_ros1 else Stores.ROS2_HUMBLE)
        if self.is_ros1:  # TFMessage is not among the types of the library
            definition = "geometry_msgs/TransformStamped[] transforms"
            self.store.register(get_types_from_msg(definition, "tf2_msgs/msg/TFMessage"))
        self.types = self.store.types
        if self.is_ros1:
            self.path = folder / "recording.bag"
            self.writer: Any = Writer1(self.path)
        else:
            plugin = StoragePlugin.MCAP if kind == "mcap" else StoragePlugin.SQLITE3
            self.path = folder / "recording"
            self.writer = Writer2(self.path, version=9, storage_plugin=plugin)
        self.connections: dict[str, Any] = {}
        self.writer.open()

    def make(self, kind: str, **fields: Any) -> Any:
        return self.types[kind](**fields)

    def header(self, stamp: int, frame: str) -> Any:
        time = self.make("builtin_interfaces/msg/Time", sec=stamp // 10**9, nanosec=stamp % 10**9)
        fields = {"stamp": time, "frame_id": frame}
        if self.is_ros1:
            fields["seq"] = 0
        return self.make("std_msgs/msg/Header", **fields)

    def write(self, topic: str, message: Any, stamp: int) -> None:
        kind = message.__msgtype__
        if topic not in self.connections:
            self.connections[topic] = self.writer.add_connection(topic, kind, typestore=self.store)
        serialize = self.store.serialize_ros1 if self.is_ros1 else self.store.serialize_cdr
        self.writer.write(self.connections[topic], stamp, serialize(message, kind))

    def image(self, topic: str, stamp: int, pixels: Any, encoding: str, frame: str) -> None:
        data = np.ascontiguousarray(pixels)
        message = self.make(
            "sensor_msgs/msg/Image",
            header=self.header(stamp, frame),
            height=data.shape[0],
            width=data.shape[1],
            encoding=encoding,
            is_bigendian=0,
            step=data.strides[0],
            data=data.view(np.uint8).reshape(-1),
        )
        self.write(topic, message, stamp)

    def compressed(self, topic: str, stamp: int, data: bytes, format: str, frame: str) -> None:
        message = self.make(
            "sensor_msgs/msg/CompressedImage",
            header=self.header(stamp, frame),
            format=format,
            data=np.frombuffer(data, np.uint8),
        )
        self.write(topic, message, stamp)

    def info(
        self,
        topic: str,
        stamp: int,
        camera: edvo.Camera,
        frame: str,
        has_size: bool = True,
        is_calibrated: bool = True,
    ) -> None:
        k = camera.matrix.reshape(-1) * is_calibrated
        letters = str.upper if self.is_ros1 else str.lower
        values = {
            letters("d"): np.array(camera.distortion),
            letters("k"): k,
            letters("r"): np.eye(3).reshape(-1),
            letters("p"): np.hstack([camera.matrix, np.zeros((3, 1))]).reshape(-1),
        }
        roi = self.make(
            "sensor_msgs/msg/RegionOfInterest",
            x_offset=0, y_offset=0, height=0, width=0, do_rectify=False,
        )  # fmt: skip
        message = self.make(
            "sensor_msgs/msg/CameraInfo",
            header=self.header(stamp, frame),
            height=camera.height * has_size,
            width=camera.width * has_size,
            distortion_model="plumb_bob",
            binning_x=0,
            binning_y=0,
            roi=roi,
            **values,
        )
        self.write(topic, message, stamp)

    def transform(
        self, topic: str, stamp: int, parent: str, child: str, xyz: Any, q: Any = (0, 0, 0, 1)
    ) -> None:
        link = self.make(
            "geometry_msgs/msg/TransformStamped",
            header=self.header(stamp, parent),
            child_frame_id=child,
            transform=self.make(
                "geometry_msgs/msg/Transform",
                translation=self.make(
                    "geometry_msgs/msg/Vector3", **dict(zip("xyz", map(float, xyz)))
                ),
                rotation=self.make(
                    "geometry_msgs/msg/Quaternion", **dict(zip("xyzw", map(float, q)))
                ),
            ),
        )
        kind = "tf2_msgs/msg/TFMessage"
        self.write(topic, self.make(kind, transforms=[link]), stamp)

    def close(self) -> Path:
        self.writer.close()
        return self.path


def millimetres(frame: edvo.Frame) -> Any:
    return np.nan_to_num(np.round(frame.depth * 1000)).astype(np.uint16)


def record(
    kind: str,
    folder: Path,
    camera: edvo.Camera,
    frames: list[edvo.Frame],
    depth_image: Callable[[edvo.Frame], tuple[Any, str]] = lambda f: (millimetres(f), "16UC1"),
) -> Path:
    recorder = Recorder(kind, folder)
    for i, frame in enumerate(frames):
        stamp = START + i * PERIOD
        pixels, encoding = depth_image(frame)
        recorder.info("/camera/color/camera_info", stamp, camera, "colour")
        recorder.info("/camera/depth/camera_info", stamp, camera, "colour")
        recorder.image("/camera/color/image_raw", stamp, frame.rgb, "rgb8", "colour")
        recorder.image("/camera/depth/image_raw", stamp + 4_000_000, pixels, encoding, "colour")
        recorder.image("/camera/infra1/image_raw", stamp, frame.rgb[:, :, 0], "mono8", "infra")
        recorder.transform("/tf", stamp, "map", "colour", (0.01 * i, 0, 0))
    return recorder.close()
