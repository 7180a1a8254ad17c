# SPDX-License-Identifier: MIT
"""Writes a run as a ROS 2 recording (MCAP), which Foxglove, Rerun and ROS 2 open."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from edvo.camera import Camera
from edvo.errors import Error, missing_extra
from edvo.observer import Image, Keyframe, Observer, SourceInfo
from edvo.odometry import FrameResult
from edvo.runner import Run
from edvo.trajectory import Trajectory, quaternion

WORLD, CAMERA = "odom", "camera_optical_frame"  # REP 105, REP 103: z forwards, y down


class Recording:
    """An MCAP file of ROS 2 messages."""

    def __init__(self, file: str | Path) -> None:
        try:
            from mcap.writer import Writer
            from rosbags.typesys import Stores, get_typestore
        except ImportError:
            raise missing_extra("writing MCAP", "rosbags", "ros") from None
        self._store = get_typestore(Stores.ROS2_HUMBLE)
        self._file = file
        with self._writing():
            self._stream = Path(file).open("wb")
            self._writer: Any = Writer(self._stream)
            self._writer.start(profile="ros2", library="edvo")
        self._channels: dict[str, int] = {}

    @contextmanager
    def _writing(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            raise Error(f"{self._file}: cannot be written: {error.strerror}", 7) from None

    def make(self, kind: str, **fields: Any) -> Any:
        return self._store.types[kind](**fields)

    def write(self, topic: str, message: Any, stamp_ns: int) -> None:
        kind = message.__msgtype__
        if topic not in self._channels:
            text, _ = self._store.generate_msgdef(kind, ros_version=2)
            schema = self._writer.register_schema(
                name=kind, encoding="ros2msg", data=text.encode("utf-8")
            )
            self._channels[topic] = self._writer.register_channel(
                topic=topic, message_encoding="cdr", schema_id=schema
            )
        data = bytes(self._store.serialize_cdr(message, kind))
        with self._writing():
            self._writer.add_message(
                channel_id=self._channels[topic],
                log_time=stamp_ns,
                publish_time=stamp_ns,
                data=data,
            )

    def close(self) -> None:
        with self._writing():
            try:
                self._writer.finish()
            finally:
                self._stream.close()

    def time(self, stamp_ns: int) -> Any:
        seconds, nanoseconds = divmod(stamp_ns, 10**9)
        return self.make("builtin_interfaces/msg/Time", sec=seconds, nanosec=nanoseconds)

    def header(self, stamp_ns: int, frame: str) -> Any:
        return self.make("std_msgs/msg/Header", stamp=self.time(stamp_ns), frame_id=frame)

    def image(self, stamp_ns: int, pixels: NDArray[Any], encoding: str) -> Any:
        data = np.ascontiguousarray(pixels)
        return self.make(
            "sensor_msgs/msg/Image",
            header=self.header(stamp_ns, CAMERA),
            height=data.shape[0],
            width=data.shape[1],
            encoding=encoding,
            is_bigendian=0,
            step=data.strides[0],
            data=data.view(np.uint8).reshape(-1),
        )

    def camera_info(self, stamp_ns: int, camera: Camera) -> Any:
        roi = self.make(
            "sensor_msgs/msg/RegionOfInterest",
            x_offset=0, y_offset=0, height=0, width=0, do_rectify=False,
        )  # fmt: skip
        coefficients = camera.distortion[:4] if camera.equidistant else camera.distortion
        is_long = any(camera.distortion[5:])
        return self.make(
            "sensor_msgs/msg/CameraInfo",
            header=self.header(stamp_ns, CAMERA),
            height=camera.height,
            width=camera.width,
            distortion_model=(
                "equidistant"
                if camera.equidistant
                else "rational_polynomial" if is_long else "plumb_bob"
            ),
            d=np.array(coefficients if camera.equidistant or is_long else coefficients[:5]),
            k=camera.matrix.reshape(-1),
            r=np.eye(3).reshape(-1),
            p=np.hstack([camera.matrix, np.zeros((3, 1))]).reshape(-1),
            binning_x=0,
            binning_y=0,
            roi=roi,
        )

    def _xyz(self, kind: str, values: NDArray[np.float64]) -> Any:
        x, y, z = (float(value) for value in values)
        return self.make(kind, x=x, y=y, z=z)

    def _rotation(self, pose: NDArray[np.float64]) -> Any:
        x, y, z, w = (float(value) for value in quaternion(pose[:3, :3]))
        return self.make("geometry_msgs/msg/Quaternion", x=x, y=y, z=z, w=w)

    def pose(self, pose: NDArray[np.float64]) -> Any:
        return self.make(
            "geometry_msgs/msg/Pose",
            position=self._xyz("geometry_msgs/msg/Point", pose[:3, 3]),
            orientation=self._rotation(pose),
        )

    def transform(self, stamp_ns: int, pose: NDArray[np.float64]) -> Any:
        link = self.make(
            "geometry_msgs/msg/TransformStamped",
            header=self.header(stamp_ns, WORLD),
            child_frame_id=CAMERA,
            transform=self.make(
                "geometry_msgs/msg/Transform",
                translation=self._xyz("geometry_msgs/msg/Vector3", pose[:3, 3]),
                rotation=self._rotation(pose),
            ),
        )
        return self.make("tf2_msgs/msg/TFMessage", transforms=[link])

    def path(self, trajectory: Trajectory) -> Any:
        poses = [
            self.make(
                "geometry_msgs/msg/PoseStamped",
                header=self.header(int(stamp), WORLD),
                pose=self.pose(pose),
            )
            for stamp, pose in zip(trajectory.stamps_ns, trajectory.poses)
        ]
        last = int(trajectory.stamps_ns[-1]) if len(trajectory) else 0
        return self.make("nav_msgs/msg/Path", header=self.header(last, WORLD), poses=poses)

    def cloud(
        self, stamp_ns: int, points: NDArray[np.float32], colours: NDArray[np.uint8]
    ) -> Any:
        """In the world."""
        packed = np.zeros(len(points), [("xyz", "<f4", 3), ("bgra", "u1", 4)])
        packed["xyz"] = points
        packed["bgra"][:, :3] = colours[:, ::-1]
        fields = [
            self.make("sensor_msgs/msg/PointField", name=name, offset=offset, datatype=7, count=1)
            for name, offset in (("x", 0), ("y", 4), ("z", 8), ("rgb", 12))
        ]
        return self.make(
            "sensor_msgs/msg/PointCloud2",
            header=self.header(stamp_ns, WORLD),
            height=1,
            width=len(points),
            fields=fields,
            is_bigendian=False,
            point_step=16,
            row_step=16 * len(points),
            data=np.frombuffer(packed.tobytes(), np.uint8),
            is_dense=True,
        )


def covariance(result: FrameResult) -> NDArray[np.float64]:
    """6 x 6 in row-major order, in the world's axes as ROS has it; of the pose against its keyframe,
    whose own error is not in it."""
    turn = np.kron(np.eye(2), result.pose[:3, :3])
    return np.asarray(turn @ np.linalg.inv(result.information) @ turn.T).reshape(-1)


class McapObserver(Observer):
    """Images and depth as they were recorded, camera, TF and poses as they come; at the end the
    path. File: MCAP."""

    def __init__(self, file: str | Path) -> None:
        self._out = Recording(file)
        self._camera: Camera | None = None

    def begin(self, source: SourceInfo) -> None:
        self._camera = source.camera

    def frame(self, result: FrameResult, image: Image) -> None:
        out, stamp = self._out, result.stamp_ns
        assert self._camera is not None
        out.write("/camera/color/image_raw", out.image(stamp, image.recorded_rgb, "rgb8"), stamp)
        out.write("/camera/color/camera_info", out.camera_info(stamp, self._camera), stamp)
        millimetres = np.nan_to_num(np.clip(np.round(image.recorded_depth * 1000), 0, 65534))
        depth = out.image(stamp, millimetres.astype(np.uint16), "16UC1")
        out.write("/camera/aligned_depth_to_color/image_raw", depth, stamp)
        if not result.ok:
            return
        out.write("/tf", out.transform(stamp, result.pose), stamp)
        stamped = out.make(
            "geometry_msgs/msg/PoseWithCovarianceStamped",
            header=out.header(stamp, WORLD),
            pose=out.make(
                "geometry_msgs/msg/PoseWithCovariance",
                pose=out.pose(result.pose),
                covariance=covariance(result),
            ),
        )
        out.write("/edvo/pose", stamped, stamp)

    def keyframe(self, keyframe: Keyframe) -> None:
        rotation, translation = keyframe.pose[:3, :3], keyframe.pose[:3, 3]
        points = (keyframe.points @ rotation.T + translation).astype(np.float32)
        message = self._out.cloud(keyframe.stamp_ns, points, keyframe.colours)
        self._out.write("/edvo/keyframe_points", message, keyframe.stamp_ns)

    def end(self, run: Run) -> None:
        if len(run.trajectory):
            last = int(run.trajectory.stamps_ns[-1])
            self._out.write("/edvo/path", self._out.path(run.trajectory), last)
        self._out.close()


def write_path(file: str | Path, trajectory: Trajectory) -> None:
    """A trajectory alone: TF at each stamp and the path at the end."""
    out = Recording(file)
    for stamp, pose in zip(trajectory.stamps_ns, trajectory.poses):
        out.write("/tf", out.transform(int(stamp), pose), int(stamp))
    if len(trajectory):
        out.write("/edvo/path", out.path(trajectory), int(trajectory.stamps_ns[-1]))
    out.close()
