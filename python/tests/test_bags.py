# SPDX-License-Identifier: MIT
"""Bags written by the independent library rosbags and read back."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import edvo
from edvo.sources import BagSource

pytest.importorskip("rosbags")
cv2 = pytest.importorskip("cv2")

from bag_recorder import PERIOD, START, Recorder, millimetres, record  # noqa: E402


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


def test_types_as_old_recorders_named_them_are_known(
    tmp_path: Path, camera: edvo.Camera, frames: list[edvo.Frame]
) -> None:
    folder = record("mcap", tmp_path, camera, frames[:3])
    (file,) = folder.glob("*.mcap")
    old = tmp_path / "old.mcap"
    rename_types(file, old)
    assert len(list(edvo.open_source(old))) == 3


def rename_types(file: Path, old: Path) -> None:
    """pkg/msg/Type becomes pkg/Type."""
    from mcap.reader import make_reader
    from mcap.writer import Writer

    with file.open("rb") as source, old.open("wb") as target:
        writer = Writer(target)
        writer.start(profile="ros2")
        channels: dict[str, int] = {}
        for schema, channel, message in make_reader(source).iter_messages():
            if channel.topic not in channels:
                name = schema.name.replace("/msg/", "/")
                known = writer.register_schema(name, schema.encoding, schema.data)
                channels[channel.topic] = writer.register_channel(
                    channel.topic, channel.message_encoding, known
                )
            writer.add_message(
                channels[channel.topic], message.log_time, message.data, message.publish_time
            )
        writer.finish()


@pytest.mark.parametrize("storage", ["SQLITE3", "MCAP"])
@pytest.mark.parametrize("mode", ["MESSAGE", "FILE"])
def test_the_file_of_a_compressed_bag_is_opened_as_its_folder_is(
    storage: str, mode: str, tmp_path: Path, camera: edvo.Camera, frames: list[edvo.Frame]
) -> None:
    from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer

    plain = record("db3", tmp_path, camera, frames[:3])
    folder = tmp_path / "packed"
    writer = Writer(folder, version=9, storage_plugin=StoragePlugin[storage])
    if (storage, mode) == ("MCAP", "FILE"):
        pytest.skip("MCAP compresses itself")
    writer.set_compression(CompressionMode[mode], CompressionFormat.ZSTD)
    from edvo.sources.bag_reader import open_bag

    with open_bag(plain) as reader, writer:
        copies = {
            c.topic: writer.add_connection(c.topic, c.msgtype, typestore=reader.typestore)
            for c in reader.connections
        }
        for connection, stamp, raw in reader.messages():
            writer.write(copies[connection.topic], stamp, raw)
    (file,) = (f for f in folder.iterdir() if f.name != "metadata.yaml")
    for place in (folder, file):
        assert len(list(edvo.open_source(place))) == 3
    if mode == "FILE":
        alone = tmp_path / file.name
        file.rename(alone)
        with pytest.raises(edvo.Error, match="give the folder with its metadata.yaml"):
            edvo.open_source(alone)
