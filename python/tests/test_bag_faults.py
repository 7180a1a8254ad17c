# SPDX-License-Identifier: MIT
"""Bags with calibrations of other images, several cameras, damaged messages and odd clocks."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest

import edvo

pytest.importorskip("rosbags")
cv2 = pytest.importorskip("cv2")

from bag_recorder import PERIOD, START, Recorder, millimetres  # noqa: E402


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


def test_a_camera_that_is_impossible_at_the_size_of_the_images_names_its_topic(
    tmp_path: Path, camera: edvo.Camera, frames: list[edvo.Frame]
) -> None:
    flat = edvo.Camera(250, 250, 160, 500_000, 320, 1_000_000)
    with pytest.raises(edvo.Error, match="/c/color/camera_info: .*fy = 0.06"):
        edvo.open_source(info_bag(tmp_path, frames, flat), camera_size=(320, 1_000_000))


def test_a_unit_of_depth_that_is_none_is_named(
    tmp_path: Path, camera: edvo.Camera, frames: list[edvo.Frame]
) -> None:
    recorder = Recorder("ros1", tmp_path)
    recorder.info("/c/color/camera_info", START, camera, "c")
    unit = recorder.make("std_msgs/msg/Float32", data=0.0)
    recorder.write("/device_0/sensor_0/option/Depth_Units/value", unit, START)
    recorder.image("/c/color/image", START, frames[0].rgb, "rgb8", "c")
    recorder.image("/c/depth/image", START, millimetres(frames[0]), "mono16", "c")
    path = recorder.close()
    with pytest.raises(edvo.Error, match="Depth_Units/value: 0.0 m is no unit; give --depth-scale"):
        edvo.open_source(path)
    assert len(list(edvo.open_source(path, depth_scale=1000))) == 1


def test_a_bag_may_have_any_name(tmp_path: Path, camera: edvo.Camera, frames: list[edvo.Frame]) -> None:
    (tmp_path / "of").mkdir()
    recorder = Recorder("db3", tmp_path / "of")
    recorder.info("/c/color/camera_info", START, camera, "c")
    recorder.image("/c/color/image", START, frames[0].rgb, "rgb8", "c")
    recorder.image("/c/depth/image", START, millimetres(frames[0]), "16UC1", "c")
    (file,) = recorder.close().glob("*.db3")
    odd = file.rename(tmp_path / "it's a #1? walk: 50%41.db3")
    assert len(list(edvo.open_source(odd))) == 1


def test_poses_that_are_no_numbers_are_left_out(
    tmp_path: Path, camera: edvo.Camera, frames: list[edvo.Frame]
) -> None:
    recorder = Recorder("mcap", tmp_path)
    recorder.info("/c/color/camera_info", START, camera, "c")
    for i, frame in enumerate(frames[:5]):
        stamp = START + i * PERIOD
        recorder.image("/c/color/image", stamp, frame.rgb, "rgb8", "c")
        recorder.image("/c/depth/image", stamp, millimetres(frame), "16UC1", "c")
        x = {1: float("nan"), 2: 1e300}.get(i, 0.1 * i)
        recorder.transform("/tf", stamp, "world", "c", (x, 0, 0))
    connection = recorder.connections["/tf"]
    recorder.writer.write(connection, START + 5 * PERIOD, b"\0\1\0\0\xff\xff\xff\xff")
    source = edvo.open_source(recorder.close())
    assert source.ground_truth is not None and len(source.ground_truth) == 3
    assert len(list(source)) == 5


def test_messages_whose_definition_lacks_a_field_are_named(
    tmp_path: Path, camera: edvo.Camera, frames: list[edvo.Frame]
) -> None:
    recorder = Recorder("ros1", tmp_path)
    recorder.info("/c/color/camera_info", START, camera, "c")
    recorder.image("/c/color/image", START, frames[0].rgb, "rgb8", "c")
    recorder.image("/c/depth/image", START, millimetres(frames[0]), "16UC1", "c")
    file = recorder.close()
    file.write_bytes(file.read_bytes().replace(b"uint32 binning_x", b"uint32 binning_q"))
    with pytest.raises(edvo.Error, match="recording.bag"):
        edvo.open_source(file, camera_size=(100, 100))


def test_an_image_of_another_size_costs_its_own_frame_only(
    tmp_path: Path, camera: edvo.Camera, frames: list[edvo.Frame]
) -> None:
    recorder = Recorder("mcap", tmp_path)
    recorder.info("/c/color/camera_info", START, camera, "c")
    for i, frame in enumerate(frames[:3]):
        stamp = START + i * PERIOD
        rgb = frame.rgb[:100] if i == 1 else frame.rgb
        recorder.image("/c/color/image", stamp, rgb, "rgb8", "c")
        recorder.image("/c/depth/image", stamp, millimetres(frame), "16UC1", "c")
    source = edvo.open_source(recorder.close())
    with pytest.raises(edvo.Error, match="/c/color/image and .*: image of 320 x 100 px, but the camera"):
        list(source)
    run = edvo.run(source, doctor=False)
    assert len(run.skipped) == 1
