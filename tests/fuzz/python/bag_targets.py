# SPDX-License-Identifier: MIT
"""Recordings of ROS 1 and ROS 2 as files, their messages one by one, and depth as RVL."""

from __future__ import annotations

import struct
from functools import cache, partial
from pathlib import Path
from tempfile import TemporaryDirectory
from types import SimpleNamespace
from typing import Any

import bag_recorder
import numpy as np
from bag_recorder import PERIOD, START, Recorder
from rosbags.typesys import Stores, get_typestore

import edvo
from checks import attempt, check_camera, check_source, check_trajectory, require
from edvo.sources import messages
from edvo.sources.bag_cameras import info_camera
from edvo.sources.pairing import reads
from edvo.sources.references import pose_of
from edvo.sources.rvl import decode_rvl
from edvo.sources.transforms import TransformTree
from samples import DEPTH_PNG, HEIGHT, JPEG, METRES, RGB, UNITS, WIDTH, huge_png
from target import Target

bag_recorder.get_typestore = cache(get_typestore)  # it takes longer than all the rest
COLOUR, DEPTH = "/camera/color/image_raw", "/camera/depth/image_raw"
SIZE = (WIDTH, HEIGHT)
LENS = edvo.Camera(15, 15, 7.5, 5.5, WIDTH, HEIGHT)
RVL = bytes(12) + struct.pack("<II", 4, 1) + struct.pack("<I", 0x0402_8000)


def odometry(recorder: Recorder, topic: str, stamp: int, x: float) -> None:
    make = recorder.make
    zero = make("geometry_msgs/msg/Vector3", x=0.0, y=0.0, z=0.0)
    pose = make(
        "geometry_msgs/msg/Pose",
        position=make("geometry_msgs/msg/Point", x=x, y=0.0, z=0.0),
        orientation=make("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=0.0, w=1.0),
    )
    covariance = np.zeros(36)
    message = make(
        "nav_msgs/msg/Odometry",
        header=recorder.header(stamp, "odom"),
        child_frame_id="base",
        pose=make("geometry_msgs/msg/PoseWithCovariance", pose=pose, covariance=covariance),
        twist=make(
            "geometry_msgs/msg/TwistWithCovariance",
            twist=make("geometry_msgs/msg/Twist", linear=zero, angular=zero),
            covariance=covariance,
        ),
    )
    recorder.write(topic, message, stamp)


def record(kind: str, folder: Path, is_compressed: bool = False) -> Path:
    return fill(Recorder(kind, folder), is_compressed)


def fill(recorder: Recorder, is_compressed: bool = False) -> Path:
    """Three frames with cameras, TF and odometry."""
    for i in range(3):
        stamp = START + i * PERIOD
        recorder.info("/camera/color/camera_info", stamp, LENS, "optical")
        recorder.info("/camera/depth/camera_info", stamp, LENS, "depth")
        if is_compressed:
            recorder.compressed(COLOUR, stamp, JPEG, "rgb8; jpeg compressed bgr8", "optical")
            recorder.compressed(DEPTH, stamp, bytes(12) + DEPTH_PNG, "16UC1; compressedDepth png", "depth")
        else:
            recorder.image(COLOUR, stamp, RGB, "rgb8", "optical")
            recorder.image(DEPTH, stamp, UNITS, "16UC1", "depth")
        recorder.transform("/tf", stamp, "odom", "base", (0.1 * i, 0, 0))
        odometry(recorder, "/odom", stamp, 0.1 * i)
    for child, x in (("optical", 0.1), ("depth", 0.13)):
        recorder.transform("/tf_static", START, "base", child, (x, 0, 0))
    return recorder.close()


def realsense(folder: Path) -> Path:
    """As RealSense's recorder names things, with its unit and its extrinsics."""
    recorder = Recorder("ros1", folder)
    place = "/device_0/sensor_{}/{}_0/{}".format
    make = recorder.make
    unit = make("std_msgs/msg/Float32", data=0.0001)
    recorder.write("/device_0/sensor_0/option/Depth_Units/value", unit, START)
    for i, name in ((1, "Color"), (0, "Depth")):
        recorder.info(place(i, name, "info/camera_info"), START, LENS, "0")
        pose = make(
            "geometry_msgs/msg/Transform",
            translation=make("geometry_msgs/msg/Vector3", x=0.01, y=0.0, z=0.0),
            rotation=make("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=0.0, w=1.0),
        )
        recorder.write(place(i, name, "tf/0"), pose, START)
    recorder.image(place(1, "Color", "image/data"), START, RGB, "rgb8", "0")
    recorder.image(place(0, "Depth", "image/data"), START, UNITS, "mono16", "0")
    return recorder.close()


def storage(path: Path) -> Path:
    """The file of a recording, which is a folder for ROS 2."""
    return path if path.is_file() else next(f for f in path.iterdir() if f.suffix != ".yaml")


def bag_seeds(kind: str, folder: Path) -> list[bytes]:
    made = []
    for is_compressed in (False, True):
        place = folder / str(is_compressed)
        place.mkdir(parents=True)
        made.append(storage(record(kind, place, is_compressed)).read_bytes())
    if kind == "ros1":
        made.append(realsense(folder).read_bytes())
    return made


def test_bag(suffix: str, data: bytes, folder: Path) -> None:
    file = folder / f"walk{suffix}"
    file.write_bytes(data)
    check_source(file)


def metadata_seeds(folder: Path) -> list[bytes]:
    return [recorded()["metadata.yaml"]]


@cache
def recorded() -> dict[str, bytes]:
    """The files of a recording, which takes long to write."""
    with TemporaryDirectory() as folder:
        return {file.name: file.read_bytes() for file in record("db3", Path(folder)).iterdir()}


def test_metadata(data: bytes, folder: Path) -> None:
    for name, content in {**recorded(), "metadata.yaml": data}.items():
        (folder / name).write_bytes(content)
    check_source(folder)


@cache
def store() -> Any:
    return get_typestore(Stores.ROS2_HUMBLE)


class Kept:
    """In place of a recorder's file: what would have been written, topic by topic."""

    def __init__(self) -> None:
        self.raw: dict[str, tuple[str, bytes]] = {}

    def add_connection(self, topic: str, kind: str, typestore: Any) -> tuple[str, str]:
        return topic, kind

    def write(self, connection: tuple[str, str], stamp: int, raw: Any) -> None:
        self.raw[connection[0]] = (connection[1], bytes(raw))


def message_samples(folder: Path) -> dict[str, tuple[str, bytes]]:
    """Kind and bytes of a message of each topic."""
    recorder = Recorder("mcap", folder)
    recorder.writer.close()
    recorder.writer = kept = Kept()
    recorder.image("rgb8", START, RGB, "rgb8", "c")
    recorder.image("mono8", START, RGB[:, :, 0], "mono8", "c")
    recorder.image("bayer", START, RGB[:, :, 0], "bayer_rggb8", "c")
    recorder.image("16UC1", START, UNITS, "16UC1", "c")
    recorder.image("32FC1", START, METRES, "32FC1", "c")
    for name, data, text in (
        ("jpeg", JPEG, "rgb8; jpeg compressed bgr8"),
        ("png", DEPTH_PNG, "16UC1; png compressed "),
        ("depth png", bytes(12) + DEPTH_PNG, "16UC1; compressedDepth png"),
        ("depth float", struct.pack("<iff", 0, 1, 2) + DEPTH_PNG, "32FC1; compressedDepth png"),
        ("depth rvl", RVL, "16UC1; compressedDepth rvl"),
        ("huge png", bytes(12) + huge_png(30000), "16UC1; compressedDepth png"),
        ("huge colour", huge_png(30000), "rgb8; png compressed rgb8"),
        ("huge rvl", bytes(12) + struct.pack("<IIII", 8000, 8000, 0xFFFFFFF0, 0), "16UC1; compressedDepth rvl"),
    ):
        recorder.compressed(name, START, data, text, "c")
    recorder.info("camera", START, LENS, "c")
    recorder.transform("tf", START, "map", "c", (1, 0, 0))
    odometry(recorder, "odometry", START, 0.1)
    return kept.raw


KINDS = (
    "sensor_msgs/msg/Image",
    "sensor_msgs/msg/CompressedImage",
    "sensor_msgs/msg/CameraInfo",
    "tf2_msgs/msg/TFMessage",
    "nav_msgs/msg/Odometry",
)


def message_seeds(folder: Path) -> list[bytes]:
    return [bytes([KINDS.index(kind)]) + raw for kind, raw in message_samples(folder).values()]


def check_image(message: Any) -> None:
    messages.kind_of(message), messages.encoding_of(message), messages.is_picture(message)
    colour = attempt(lambda: messages.decode_colour(message), "image", "camera")
    if colour is not None:
        require(colour.dtype == np.uint8 and colour.ndim == 3 and colour.shape[2] == 3, "colour")
    depth = attempt(lambda: messages.decode_depth(message, None), "depth", "image")
    if depth is not None:
        require(depth.dtype == np.float32 and depth.ndim == 2, "depth")
        require(not (depth <= 0).any() and not np.isinf(depth).any(), "depth without a meaning")
    if not hasattr(message, "format"):
        size = (message.height, message.width)
        require(colour is None or colour.shape[:2] == size, "colour of another size")
        require(depth is None or depth.shape == size, "depth of another size")


def test_message(data: bytes, folder: Path) -> None:
    kind = KINDS[data[0] % len(KINDS)] if data else KINDS[0]
    reader: Any = SimpleNamespace(typestore=store(), is2=True)
    message = attempt(reads(reader, "/a", data[1:], kind), "/a")
    if message is None:
        return
    if kind.endswith("Image"):
        check_image(message)
    elif kind.endswith("CameraInfo"):
        for images in ("/a/image", "/a/image_rect"):
            camera = attempt(lambda: info_camera(message, "/a", images, SIZE, (0, 0), "--camera"), "/a")
            require(camera is None or (camera.width, camera.height) == SIZE, "camera of another size")
            if camera is not None:
                check_camera(camera)
    elif kind.endswith("TFMessage"):
        tree = TransformTree()
        for link in message.transforms:
            move = link.transform
            pose = attempt(lambda: messages.pose_from(move.translation, move.rotation), "pose")
            if pose is not None:
                tree.add(link.header.frame_id, link.child_frame_id, messages.stamp_ns(link), pose)
        for link in message.transforms:
            path = tree.trajectory_of(link.child_frame_id)
            if path is not None:
                check_trajectory(path)
            tree.between("map", link.child_frame_id)
    else:
        attempt(lambda: pose_of(message), "pose")


def embedded_seeds(folder: Path) -> list[bytes]:
    """Each topic of a whole recording, with one of its messages."""
    return [bytes([i]) + raw for i, (_, raw) in enumerate(topics_of(folder).values())]


def topics_of(folder: Path) -> dict[str, tuple[str, bytes]]:
    from rosbags.rosbag2 import Reader

    found = {}
    with Reader(record("db3", folder)) as reader:
        for connection, _, raw in reader.messages():
            found[connection.topic] = (connection.msgtype, bytes(raw))
    return found


def test_embedded(data: bytes, folder: Path) -> None:
    """A recording of which one topic has this message instead of its second one."""
    recorder = Recorder("mcap", folder)
    write, count = recorder.writer.write, 0
    topics = ("/camera/color/camera_info", "/camera/depth/camera_info", COLOUR, DEPTH, "/tf", "/odom", "/tf_static")
    chosen = topics[data[0] % len(topics)] if data else COLOUR

    def replaced(connection: Any, stamp: int, raw: Any) -> None:
        nonlocal count
        count += connection.topic == chosen
        hit = connection.topic == chosen and count == (2 if data[:1] < b"\x80" else 1)
        write(connection, stamp, data[1:] if hit else raw)

    recorder.writer.write = replaced
    check_source(fill(recorder))


def test_rvl(data: bytes, folder: Path) -> None:
    if len(data) < 4:
        return
    height, width = struct.unpack("<HH", data[:4])
    image = attempt(lambda: decode_rvl(np.frombuffer(data[4:], np.uint8), height, width), "RVL")
    if image is not None:
        require(image.dtype == np.uint16 and image.shape == (height, width), "another size")


TARGETS = {
    "bag1": Target(partial(test_bag, ".bag"), partial(bag_seeds, "ros1")),
    "db3": Target(partial(test_bag, ".db3"), partial(bag_seeds, "db3")),
    "mcap": Target(partial(test_bag, ".mcap"), partial(bag_seeds, "mcap")),
    "bag_metadata": Target(test_metadata, metadata_seeds),
    "bag_messages": Target(test_embedded, embedded_seeds),
    "messages": Target(test_message, message_seeds),
    "rvl": Target(test_rvl, lambda _: [struct.pack("<HH", 1, 4) + RVL[20:]]),
}
