# SPDX-License-Identifier: MIT
"""Bags written by the independent library rosbags and read back."""

from __future__ import annotations

import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import edvo
from edvo.sources import BagSource

pytest.importorskip("rosbags")
cv2 = pytest.importorskip("cv2")

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


@pytest.mark.parametrize("kind", ["ros1", "db3", "mcap"])
def test_frames_stamps_and_units_come_back(
    kind: str, tmp_path: Path, camera: edvo.Camera, frames: list[edvo.Frame]
) -> None:
    source = edvo.open_source(record(kind, tmp_path, camera, frames[:6]))
    assert isinstance(source, BagSource)
    assert source.camera == camera
    back = list(source)
    assert [frame.stamp_ns for frame in back] == [START + i * PERIOD for i in range(6)]
    for frame, original in zip(back, frames):
        assert np.array_equal(frame.rgb, original.rgb)
        both = np.isfinite(original.depth) & (original.depth < 65)
        assert np.allclose(frame.depth[both], original.depth[both], atol=0.00051)
        assert np.array_equal(np.isfinite(frame.depth), np.isfinite(original.depth))
    assert source.ground_truth is not None
    assert np.allclose(source.ground_truth.positions[:, 0], 0.01 * np.arange(6))


@pytest.mark.parametrize("kind", ["db3", "mcap"])
def test_a_single_file_of_a_ros2_bag_is_enough(
    kind: str, tmp_path: Path, camera: edvo.Camera, frames: list[edvo.Frame]
) -> None:
    folder = record(kind, tmp_path, camera, frames[:3])
    (file,) = folder.glob(f"*.{kind}")
    alone = tmp_path / f"alone.{kind}"
    file.rename(alone)
    assert len(list(edvo.open_source(alone))) == 3


def test_floats_are_metres(
    tmp_path: Path, camera: edvo.Camera, frames: list[edvo.Frame]
) -> None:
    path = record("mcap", tmp_path, camera, frames[:2], lambda f: (f.depth, "32FC1"))
    for frame, original in zip(edvo.open_source(path), frames):
        assert np.array_equal(frame.depth, original.depth, equal_nan=True)


def test_floats_in_millimetres_are_mended_as_the_doctor_says(
    tmp_path: Path, camera: edvo.Camera, frames: list[edvo.Frame]
) -> None:
    path = record("mcap", tmp_path, camera, frames[:6], lambda f: (1000 * f.depth, "32FC1"))
    (finding,) = [f for f in edvo.diagnose(path) if f.fault == "depth_in_millimetres"]
    assert "--depth-scale 1000" in finding.advice
    for frame, original in zip(edvo.open_source(path, depth_scale=1000), frames):
        assert np.allclose(frame.depth, original.depth, equal_nan=True)


def test_the_doctor_names_the_likely_scale_of_a_bag(
    tmp_path: Path, camera: edvo.Camera, frames: list[edvo.Frame]
) -> None:
    tenths = lambda f: (np.nan_to_num(np.round(f.depth * 10000)).astype(np.uint16), "16UC1")  # noqa: E731
    path = record("mcap", tmp_path, camera, frames[:6], tenths)
    (finding,) = [f for f in edvo.diagnose(path) if f.fault == "depth_scale"]
    assert "--depth-scale 10000 would" in finding.advice


def test_compressed_images_and_both_kinds_of_compressed_depth(
    tmp_path: Path, camera: edvo.Camera, frames: list[edvo.Frame]
) -> None:
    frame = frames[0]
    for i, inverse in enumerate((False, True)):
        recorder = Recorder("db3", tmp_path / str(i)) if (tmp_path / str(i)).mkdir() is None else None
        assert recorder is not None
        recorder.info("/camera/color/camera_info", START, camera, "colour")
        _, png = cv2.imencode(".png", frame.rgb[:, :, ::-1])
        topic = "/camera/color/image_raw/compressed"
        recorder.compressed(topic, START, png.tobytes(), "rgb8; png compressed bgr8", "colour")
        if inverse:
            a, b = 100.0 * 101.0, 101.0 * 100.0 / 100.0 - 101.0 + 1
            with np.errstate(invalid="ignore"):
                units = np.nan_to_num(np.round(a / frame.depth + b)).astype(np.uint16)
            format, head = "32FC1; compressedDepth png", struct.pack("<iff", 0, a, b)
        else:
            units = millimetres(frame)
            format, head = "16UC1; compressedDepth png", struct.pack("<iff", 0, 0, 0)
        _, png = cv2.imencode(".png", units)
        topic = "/camera/depth/image_raw/compressedDepth"
        recorder.compressed(topic, START, head + png.tobytes(), format, "colour")
        (back,) = list(edvo.open_source(recorder.close()))
        assert np.array_equal(back.rgb, frame.rgb)
        known = np.isfinite(frame.depth)
        assert np.array_equal(np.isfinite(back.depth), known)
        assert np.allclose(back.depth[known], frame.depth[known], rtol=0.001, atol=0.0006)


def test_depth_as_png_of_image_transport_is_read(
    tmp_path: Path, camera: edvo.Camera, frames: list[edvo.Frame]
) -> None:
    recorder = Recorder("mcap", tmp_path)
    recorder.info("/c/camera_info", START, camera, "c")
    for topic, pixels, format in (
        ("/c/rgb/compressed", frames[0].rgb[:, :, ::-1], "rgb8; png compressed bgr8"),
        ("/c/z/compressed", millimetres(frames[0]), "png"),
    ):
        png = cv2.imencode(".png", pixels)[1].tobytes()
        recorder.compressed(topic, START, png, format, "c")
    (back,) = list(edvo.open_source(recorder.close()))
    known = np.isfinite(frames[0].depth)
    assert np.allclose(back.depth[known], frames[0].depth[known], atol=0.0006)


def test_pictures_of_depth_are_refused_at_once(
    tmp_path: Path, camera: edvo.Camera, frames: list[edvo.Frame]
) -> None:
    recorder = Recorder("mcap", tmp_path)
    recorder.info("/c/camera_info", START, camera, "c")
    recorder.image("/c/rgb", START, frames[0].rgb, "rgb8", "c")
    recorder.image("/c/deep", START, frames[0].rgb[:, :, 0], "8UC1", "c")
    path = recorder.close()
    with pytest.raises(edvo.Error, match=r"/c/deep \(8UC1\).*; 8-bit or JPEG depth is a picture"):
        edvo.open_source(path)
    with pytest.raises(edvo.Error, match="/c/deep: depth encoding 8UC1"):
        edvo.open_source(path, depth_topic="/c/deep")


def test_depth_of_its_own_camera_is_registered_by_tf(
    tmp_path: Path, camera: edvo.Camera
) -> None:
    recorder = Recorder("mcap", tmp_path)
    depth_camera = edvo.Camera(300, 300, 150, 110, 320, 240)
    recorder.info("/c/color/camera_info", START, camera, "colour")
    recorder.info("/c/depth/camera_info", START, depth_camera, "depth")
    recorder.transform("/tf_static", START, "link", "depth", (0, 0, 0))
    recorder.transform("/tf_static", START, "link", "colour", (-0.05, 0, 0))
    rgb = np.full((240, 320, 3), 90, np.uint8)
    recorder.image("/c/color/image_raw", START, rgb, "rgb8", "colour")
    wall = np.full((240, 320), 2000, np.uint16)
    wall[100:140, 140:180] = 1000
    recorder.image("/c/depth/image_raw", START, wall, "16UC1", "depth")
    source = edvo.open_source(recorder.close())
    (frame,) = list(source)
    assert any("baseline 50.0 mm" in note for note in source.notes)
    # The box's middle: depth pixel (159.5, 119.5) at 1 m, 0.05 m further right for colour.
    x = camera.fx * ((159.5 - 150) / 300 + 0.05) + camera.cx
    y = camera.fy * (119.5 - 110) / 300 + camera.cy
    assert frame.depth[round(y), round(x)] == pytest.approx(1.0, abs=1e-4)
    assert frame.depth[round(y), round(x) + 60] == pytest.approx(2.0, abs=1e-4)


def info_bag(
    folder: Path,
    frames: list[edvo.Frame],
    info: edvo.Camera,
    depth_info: edvo.Camera | None = None,
    **filled_in: bool,
) -> Path:
    """Images of 320 x 240 px with CameraInfo of anything."""
    recorder = Recorder("mcap", folder)
    recorder.info("/c/color/camera_info", START, info, "c", **filled_in)
    if depth_info is not None:
        recorder.info("/c/depth/camera_info", START, depth_info, "c")
    recorder.image("/c/color/image", START, frames[0].rgb, "rgb8", "c")
    recorder.image("/c/depth/image", START, millimetres(frames[0]), "16UC1", "c")
    return recorder.close()


@pytest.mark.parametrize("has_depth_info", [False, True])
def test_camera_info_of_another_size_is_named_and_can_be_mended(
    has_depth_info: bool, tmp_path: Path, camera: edvo.Camera, frames: list[edvo.Frame]
) -> None:
    large = camera.scaled_to(640, 480)
    path = info_bag(tmp_path, frames, large, large if has_depth_info else None)
    said = "CameraInfo of /c/color/camera_info is for 640 x 480 px, but the images of /c/color/image are 320 x 240"
    with pytest.raises(edvo.Error, match=said):
        edvo.open_source(path)
    scaled = edvo.open_source(path, camera_size=(640, 480))
    assert scaled.camera.fx == pytest.approx(camera.fx) and len(list(scaled)) == 1
    given = edvo.open_source(path, camera=camera)
    assert len(list(given)) == 1 and not any("baseline" in note for note in given.notes)


def test_camera_info_without_a_size_is_that_of_the_images(
    tmp_path: Path, camera: edvo.Camera, frames: list[edvo.Frame]
) -> None:
    source = edvo.open_source(info_bag(tmp_path, frames, camera, has_size=False))
    assert source.camera == camera and len(list(source)) == 1


def test_camera_info_without_a_calibration_names_its_topic(
    tmp_path: Path, camera: edvo.Camera, frames: list[edvo.Frame]
) -> None:
    path = info_bag(tmp_path, frames, camera, is_calibrated=False)
    with pytest.raises(edvo.Error, match="/c/color/camera_info: .* with --camera FILE"):
        edvo.open_source(path)
    assert len(list(edvo.open_source(path, camera=camera))) == 1


def test_a_depth_camera_of_another_size_is_refused(
    tmp_path: Path, camera: edvo.Camera, frames: list[edvo.Frame]
) -> None:
    path = info_bag(tmp_path, frames, camera)
    with pytest.raises(edvo.Error, match="--depth-camera.* is for 640 x 480 px"):
        edvo.open_source(path, depth_camera=camera.scaled_to(640, 480))


def test_colour_and_depth_are_of_one_camera(
    tmp_path: Path, camera: edvo.Camera, frames: list[edvo.Frame]
) -> None:
    recorder = Recorder("mcap", tmp_path)
    recorder.info("/front/color/camera_info", START, camera, "front")
    for place in ("front", "up"):
        recorder.image(f"/{place}/color/image_raw", START, frames[0].rgb, "rgb8", place)
        recorder.image(f"/{place}/depth/image_raw", START, millimetres(frames[0]), "16UC1", place)
    path = recorder.close()
    source = edvo.open_source(path)
    said = "left out: /up/color/image_raw, /up/depth/image_raw; --colour-topic and --depth-topic"
    assert "(/front/color/image_raw, /front/depth/image_raw)" in source.origin
    assert any(said in note for note in source.notes)
    other = edvo.open_source(path, colour_topic="/up/color/image_raw", camera=camera)
    assert "/up/depth/image_raw" in other.origin


def test_realsense_topics_say_their_unit(tmp_path: Path, camera: edvo.Camera) -> None:
    recorder = Recorder("ros1", tmp_path)
    base = "/device_0/sensor_{}/{}_0/{}"
    recorder.info(base.format(1, "Color", "info/camera_info"), START, camera, "0")
    recorder.info(base.format(0, "Depth", "info/camera_info"), START, camera, "0")
    unit = recorder.make("std_msgs/msg/Float32", data=0.0001)
    recorder.write("/device_0/sensor_0/option/Depth_Units/value", unit, START)
    rgb = np.full((240, 320, 3), 90, np.uint8)
    recorder.image(base.format(1, "Color", "image/data"), START, rgb, "rgb8", "0")
    depth = np.full((240, 320), 15000, np.uint16)
    recorder.image(base.format(0, "Depth", "image/data"), START, depth, "mono16", "0")
    source = edvo.open_source(recorder.close())
    (frame,) = list(source)
    assert np.nanmedian(frame.depth) == pytest.approx(1.5, rel=1e-6)


def test_topics_can_be_chosen_and_wrong_ones_are_named(
    tmp_path: Path, camera: edvo.Camera, frames: list[edvo.Frame]
) -> None:
    path = record("mcap", tmp_path, camera, frames[:2])
    source = edvo.open_source(path, colour_topic="/camera/infra1/image_raw", camera=camera)
    assert np.array_equal(next(iter(source)).rgb[:, :, 1], frames[0].rgb[:, :, 0])
    with pytest.raises(edvo.Error, match="/camera/color/image_raw"):
        edvo.open_source(path, colour_topic="/nothing")


@pytest.mark.parametrize("name", ["broken.bag", "broken.db3", "broken.mcap"])
def test_files_that_are_no_bags_are_refused_in_one_sentence(name: str, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(b"not a bag at all" * 10)
    with pytest.raises(edvo.Error) as caught:
        edvo.open_source(tmp_path / name)
    assert caught.value.code == 3 and "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("kind", "whole", "mender"),
    [
        ("ros1", False, "rosbag reindex "),
        ("mcap", False, "mcap recover "),
        ("mcap", True, "mcap recover "),
        ("db3", False, "sqlite3 "),
    ],
)
def test_what_mends_a_cut_recording_is_said_with_its_file(
    kind: str, whole: bool, mender: str, tmp_path: Path, camera: edvo.Camera, frames: list[edvo.Frame]
) -> None:
    """``whole``: the folder, with metadata.yaml, is opened."""
    path = record(kind, tmp_path, camera, frames[:3])
    file = next(path.glob(f"*.{kind}")) if path.is_dir() else path
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    with pytest.raises(edvo.Error) as caught:
        list(edvo.open_source(path if whole else file))
    assert f"{file}: damaged or cut off" in str(caught.value)
    assert f"`{mender}{file}" in str(caught.value) and "\n" not in str(caught.value)


def test_a_bag_is_tracked(tmp_path: Path, camera: edvo.Camera, frames: list[edvo.Frame]) -> None:
    run = edvo.run(record("mcap", tmp_path, camera, frames[:12]))
    assert run.tracked == 12 and run.evaluation is not None


def rvl(depth: Any) -> bytes:
    """RVL, number by number, as its paper describes it."""
    nibbles: list[int] = []

    def put(number: int) -> None:
        while True:
            nibble, number = number & 7, number >> 3
            nibbles.append(nibble | (8 if number else 0))
            if not number:
                return

    values = [int(value) for value in depth.reshape(-1)]
    at, last = 0, 0
    while at < len(values):
        begin = at
        while at < len(values) and values[at] == 0:
            at += 1
        put(at - begin)
        begin = at
        while at < len(values) and values[at] != 0:
            at += 1
        put(at - begin)
        for value in values[begin:at]:
            put((value - last) << 1 if value >= last else ((last - value) << 1) - 1)
            last = value
    nibbles += [0] * (-len(nibbles) % 8)
    words = [sum(n << (28 - 4 * k) for k, n in enumerate(nibbles[i : i + 8])) for i in range(0, len(nibbles), 8)]
    return np.array(words, "<u4").tobytes()


def damaged_bag(folder: Path, camera: edvo.Camera, frames: list[edvo.Frame], where: int) -> Path:
    """JPEG and PNG, of which one each is cut off, and one message that is no message."""
    recorder = Recorder("mcap", folder)
    recorder.info("/camera/color/camera_info", START, camera, "c")
    for i, frame in enumerate(frames):
        stamp = START + i * PERIOD
        jpeg = cv2.imencode(".jpg", frame.rgb[:, :, ::-1])[1].tobytes()
        png = bytes(12) + cv2.imencode(".png", millimetres(frame))[1].tobytes()
        jpeg = {where: jpeg[: len(jpeg) // 3], where + 1: b""}.get(i, jpeg)
        png = png[: len(png) // 3] if i == where + 2 else png
        topic = "/camera/color/image/compressed"
        recorder.compressed(topic, stamp, jpeg, "rgb8; jpeg compressed bgr8", "c")
        topic = "/camera/depth/image/compressedDepth"
        recorder.compressed(topic, stamp, png, "16UC1; compressedDepth png", "c")
        if i == where + 3:
            broken = stamp + PERIOD // 2
            recorder.compressed(topic, broken, png, "16UC1; compressedDepth png", "c")
            connection = recorder.connections["/camera/color/image/compressed"]
            header = struct.pack("<BBHII", 0, 1, 0, *divmod(broken, 10**9))
            recorder.writer.write(connection, broken, header + b"\xff" * 40)
    return recorder.close()


@pytest.mark.parametrize("where", [0, 3])
def test_damaged_images_are_skipped_and_counted(
    where: int, tmp_path: Path, camera: edvo.Camera, frames: list[edvo.Frame]
) -> None:
    path = damaged_bag(tmp_path, camera, frames[:10], where)
    run = edvo.run(path, doctor=False)
    assert run.tracked == 7 and len(run.skipped) == 4
    assert all("/camera/" in reason and "OpenCV" not in reason for reason in run.skipped)
    (finding,) = [f for f in edvo.diagnose(path) if f.fault == "unreadable"]
    assert finding.measured.startswith("4 images cannot be read")


def clock_bag(
    folder: Path, camera: edvo.Camera, frames: list[edvo.Frame], late: int, has_stamps: bool = True
) -> Path:
    """Depth ``late`` [ns], every other one missing."""
    recorder = Recorder("mcap", folder)
    recorder.info("/c/color/camera_info", START, camera, "c")
    write = recorder.write
    for i, frame in enumerate(frames):
        stamp = START + i * PERIOD
        for topic, time, pixels, encoding in (
            ("/c/color/image", stamp, frame.rgb, "rgb8"),
            ("/c/depth/image", stamp + late, millimetres(frame), "16UC1"),
        ):
            recorder.write = lambda topic, m, _, time=time: write(topic, m, time)  # type: ignore
            if encoding == "rgb8" or i % 2 == 0:
                recorder.image(topic, time if has_stamps else 0, pixels, encoding, "c")
    return recorder.close()


def test_pairs_are_counted_as_in_folders(
    tmp_path: Path, camera: edvo.Camera, frames: list[edvo.Frame]
) -> None:
    source = edvo.open_source(clock_bag(tmp_path, camera, frames[:6], 4_000_000))
    assert source.frames == 3 == len(list(source))
    text = "3 pairs of 6 colour and 3 depth images, depth +4 ms from colour"
    assert any(text in note for note in source.notes)


def test_clocks_without_a_pair_are_named(
    tmp_path: Path, camera: edvo.Camera, frames: list[edvo.Frame]
) -> None:
    path = clock_bag(tmp_path, camera, frames[:6], 100 * 10**9)
    with pytest.raises(edvo.Error, match=r"from 1600000000\.123 to .* \+100\.000 s from colour"):
        edvo.open_source(path)


def test_headers_without_time_take_that_of_the_recording(
    tmp_path: Path, camera: edvo.Camera, frames: list[edvo.Frame]
) -> None:
    source = edvo.open_source(clock_bag(tmp_path, camera, frames[:6], 0, has_stamps=False))
    assert [f.stamp_ns for f in source] == [START + i * PERIOD for i in (0, 2, 4)]
    assert any("headers have no time" in note for note in source.notes)


@pytest.mark.parametrize("name", ["scene", "empty", "full", "noise"])
def test_depth_as_rvl_comes_back(name: str, frames: list[edvo.Frame]) -> None:
    from edvo.sources.rvl import decode_rvl

    random = np.random.default_rng(1)
    scene = np.nan_to_num(1000 * frames[0].depth).round().astype(np.uint16)
    depth = {
        "scene": scene,
        "empty": np.zeros((7, 9), np.uint16),
        "full": np.full((5, 5), 65535, np.uint16),
        "noise": random.integers(0, 65536, (40, 30)).astype(np.uint16) * random.integers(0, 2, (40, 30)).astype(np.uint16),
    }[name]
    data = np.frombuffer(rvl(depth), np.uint8)
    assert np.array_equal(decode_rvl(data, *depth.shape), depth)
    if name == "scene":
        for damaged in (data[:-400], data[4:], random.integers(0, 256, 4000).astype(np.uint8)):
            with pytest.raises(edvo.Error, match="RVL"):
                decode_rvl(damaged, *depth.shape)


def test_a_bag_with_rvl_depth_is_read(
    camera: edvo.Camera, frames: list[edvo.Frame], tmp_path: Path
) -> None:
    recorder = Recorder("mcap", tmp_path)
    recorder.info("/camera/color/camera_info", START, camera, "camera")
    recorder.info("/camera/aligned_depth/camera_info", START, camera, "camera")
    for i, frame in enumerate(frames[:3]):
        stamp = START + i * PERIOD
        millimetres = np.nan_to_num(1000 * frame.depth).round().astype(np.uint16)
        height, width = millimetres.shape
        data = struct.pack("<iffII", 0, 0.0, 0.0, width, height) + rvl(millimetres)
        recorder.image("/camera/color/image_raw", stamp, frame.rgb, "rgb8", "camera")
        recorder.compressed(
            "/camera/aligned_depth/image_raw/compressedDepth", stamp, data,
            "16UC1; compressedDepth rvl", "camera",
        )  # fmt: skip
    recorder.writer.close()
    for read, frame in zip(BagSource(recorder.path), frames[:3], strict=True):
        known = np.isfinite(frame.depth)
        assert np.abs(read.depth - frame.depth)[known].max() <= 0.0006
