# SPDX-License-Identifier: MIT
"""What is handed over and cannot be used is refused, by what, where and how to mend it."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import Memory

import edvo

Frames = list[edvo.Frame]


class Watcher(edvo.Observer):
    pass


class Half(edvo.Source):
    def __init__(self, camera: object) -> None:  # forgets its base
        self.camera = camera  # type: ignore[assignment]

    def __iter__(self):  # type: ignore[no-untyped-def]
        return iter(())


class NoCamera(Half):
    def __init__(self) -> None:
        edvo.Source.__init__(self)
        self.camera = None  # type: ignore[assignment]


def test_run_takes_the_keywords_of_its_source(sequence: Path) -> None:
    run = edvo.run(sequence, max_frames=3, depth_scale=2500, doctor=False)
    same = edvo.run(sequence, max_frames=3, source_options={"depth_scale": 2500}, doctor=False)
    other = edvo.run(sequence, max_frames=3, doctor=False)
    assert np.array_equal(run.trajectory.values, same.trajectory.values)
    assert not np.array_equal(run.trajectory.values, other.trajectory.values)
    with pytest.raises(TypeError, match="depth_scale: given as a keyword and in source_options"):
        edvo.run(sequence, depth_scale=1, source_options={"depth_scale": 1})


@pytest.mark.parametrize(
    ("keywords", "error", "words"),
    [
        ({"maxframes": 3}, TypeError, "unknown keyword 'maxframes'.*camera.*group.field"),
        ({"keyframes.perod": 3}, edvo.Error, "keyframes.period"),
        ({"detector": lambda rgb: rgb}, TypeError, "edvo.EdgeDetector is expected, got function"),
        ({"detector": edvo.EdgeDetector}, TypeError, "got the class EdgeDetector"),
        ({"observers": [Watcher]}, TypeError, r"Watcher is a class; .*Watcher\(\)"),
        ({"observers": [print]}, TypeError, "edvo.Observer are expected, got builtin"),
        ({"observers": Watcher()}, TypeError, "a list is expected, got Watcher"),
    ],
)
def test_run_checks_its_keywords_before_it_opens_anything(
    keywords: dict[str, Any], error: type[Exception], words: str
) -> None:
    with pytest.raises(error, match=words):
        edvo.run("/nowhere", **keywords)


def test_run_checks_the_source(camera: edvo.Camera, frames: Frames) -> None:
    with pytest.raises(TypeError, match="Half: its __init__ must call super"):
        edvo.run(Half(camera))
    with pytest.raises(TypeError, match="NoCamera: its camera must be an edvo.Camera, not NoneType"):
        edvo.run(NoCamera())
    with pytest.raises(TypeError, match="an edvo.Source is expected, got NoCamera"):
        edvo.run(NoCamera)  # type: ignore[arg-type]
    for keywords in ({"source_options": {"depth_scale": 5000}}, {"camera": camera}):
        with pytest.raises(TypeError, match="for open_source, which opens paths; Memory is open"):
            edvo.run(Memory(camera, frames[:2]), **keywords)  # type: ignore[arg-type]


def test_a_run_that_tracks_nothing_is_an_error(camera: edvo.Camera, frames: Frames) -> None:
    blind = [edvo.Frame(f.stamp_ns, f.rgb, np.full_like(f.depth, np.nan)) for f in frames[:3]]
    for given, words in (([], "none of 0 frames"), (blind, "none of 3 frames")):
        with pytest.raises(edvo.Error, match=words) as caught:
            edvo.run(Memory(camera, given))
        assert caught.value.code == 9
        assert caught.value.run is not None and len(caught.value.run.frames) == len(given)


def test_a_run_of_unusable_frames_says_why(camera: edvo.Camera, frames: Frames) -> None:
    grey = [edvo.Frame(f.stamp_ns, f.rgb / 255.0, f.depth) for f in frames[:3]]  # type: ignore[arg-type]
    with pytest.raises(edvo.Error, match="3 skipped.*; frame 0: rgb: dtype uint8 is expected"):
        edvo.run(Memory(camera, grey))


def test_a_run_and_a_trajectory_are_short_to_print(sequence: Path) -> None:
    run = edvo.run(sequence, max_frames=5, doctor=False)
    assert repr(run) == "Run('office': 5 tracked)"
    assert re.fullmatch(r"Trajectory\(5 poses, .* s to .* s\)", repr(run.trajectory))
    assert repr(edvo.Trajectory(np.zeros(0), np.zeros((0, 7)))) == "Trajectory(no poses)"


GOOD = {"fx": 525.0, "fy": 525.0, "cx": 319.5, "cy": 239.5, "width": 640, "height": 480}


@pytest.mark.parametrize(
    ("change", "error", "words"),
    [
        ({"fx": float("nan")}, edvo.Error, "fx = nan is no focal length"),
        ({"fy": float("inf")}, edvo.Error, "fy = inf is no focal length"),
        ({"fx": 0.001}, edvo.Error, "fx = 0.001 is no focal length in pixels of a 640 px"),
        ({"fx": -525}, edvo.Error, "fx = -525"),
        ({"cx": 3195}, edvo.Error, "cx = 3195 is far outside"),
        ({"distortion": (float("nan"),)}, edvo.Error, "distortion coefficient"),
        ({"width": 0, "height": 0}, edvo.Error, "0 x 0 is no size"),
        ({"width": 640.5}, ValueError, "width 640.5: a whole number"),
        ({"fx": "525"}, TypeError, "fx '525': a number is expected"),
        ({"cy": None}, TypeError, "cy None: a number is expected"),
    ],
)
def test_an_impossible_camera_is_refused(
    change: dict[str, Any], error: type[Exception], words: str
) -> None:
    with pytest.raises(error, match=words) as caught:
        edvo.Camera(**(GOOD | change))
    if isinstance(caught.value, edvo.Error):
        assert caught.value.code == 5
    assert edvo.Camera(**(GOOD | {"width": 640.0})) == edvo.Camera(**GOOD)


def test_what_is_masked_in_depth_is_none(camera: edvo.Camera, frames: Frames) -> None:
    hole = np.zeros(frames[0].depth.shape, bool)
    hole[40:120, 50:200] = True

    def track(depths: list[Any], **more: Any) -> Any:
        tracker = edvo.Odometry(camera)
        for frame, depth in zip(frames, depths):
            result = tracker.process_ns(frame.stamp_ns, 9, frame.rgb, depth, **more)
        return result.pose

    metres = [np.nan_to_num(f.depth) for f in frames[:8]]
    expected = track([np.where(hole, 0, z) for z in metres])
    assert np.array_equal(track([np.ma.array(z, mask=hole) for z in metres]), expected)
    units = [(z * 5000).round().astype(np.uint16) for z in metres]
    assert np.array_equal(
        track([np.ma.array(z, mask=hole) for z in units], depth_scale=5000),
        track([np.where(hole, 0, z).astype(np.uint16) for z in units], depth_scale=5000),
    )
    rgb = np.ma.array(frames[0].rgb, mask=False)
    edvo.Odometry(camera).process(0, rgb, metres[0])
    rgb.mask = np.repeat(hole[:, :, None], 3, axis=2)
    with pytest.raises(TypeError, match="rgb: a masked array"):
        edvo.Odometry(camera).process(0, rgb, metres[0])


def test_metres_have_no_scale(camera: edvo.Camera, frames: Frames) -> None:
    for odometry, scale in (
        (edvo.Odometry(camera), 1000), (edvo.Odometry(camera, depth_scale=1000), None)
    ):  # fmt: skip
        with pytest.raises(ValueError, match="float32 is in metres, but depth_scale is 1000"):
            odometry.process(0, frames[0].rgb, frames[0].depth * 1000, depth_scale=scale)
    edvo.Odometry(camera).process(0, frames[0].rgb, frames[0].depth, depth_scale=1)


def poses(count: int) -> np.ndarray[Any, Any]:
    return np.tile(np.eye(4), (count, 1, 1))


@pytest.mark.parametrize(
    ("stamps", "matrices", "error", "words"),
    [
        ([1.305e9, 1.306e9], poses(2), TypeError, r"nanoseconds are expected, got float64; .*1e9"),
        ([3, 2], poses(2), edvo.Error, r"stamps_ns\[1\]: 2 is not later than 3"),
        ([2, 2], poses(2), edvo.Error, r"stamps_ns\[1\]: 2 is not later than 2"),
        ([1, 2], poses(3), ValueError, r"\(2, 4, 4\) is expected for 2 stamps, got \(3, 4, 4\)"),
        ([1], np.ones((1, 4, 4)), ValueError, r"poses\[0\]: no rigid motion"),
        ([1, 2], poses(2) * [[[1]], [[2]]], ValueError, r"poses\[1\]: no rigid motion"),
        ([1], np.diag([1.0, 1, -1, 1])[None], ValueError, "no rigid motion"),
        ([1], np.full((1, 4, 4), np.nan), ValueError, "no rigid motion"),
    ],
)
def test_poses_that_are_none_are_refused(
    stamps: list[Any], matrices: Any, error: type[Exception], words: str
) -> None:
    with pytest.raises(error, match=words):
        edvo.Trajectory.from_poses(np.array(stamps), matrices)
    assert len(edvo.Trajectory.from_poses(np.array([1, 2]), [np.eye(4)] * 2)) == 2  # type: ignore[arg-type]
    assert len(edvo.Trajectory.from_poses(np.zeros(0), np.zeros((0, 4, 4)))) == 0  # type: ignore[arg-type]
