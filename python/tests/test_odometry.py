# SPDX-License-Identifier: MIT
from __future__ import annotations

import os
import pickle
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import edvo
from edvo import _core
from edvo.stamp import nanoseconds


def test_numbers_equal_the_programs_to_the_bit(sequence: Path, tmp_path: Path) -> None:
    program = os.environ.get("EDVO_PROGRAM")
    command = ["run", str(sequence), "-o", str(tmp_path / "cpp"), "--quiet", "--no-report"]
    if program:
        subprocess.run([program, *command], check=True, stdout=subprocess.DEVNULL)
    else:
        assert _core.main(["edvo", *command]) == 0
    run = edvo.run(sequence)
    run.write(tmp_path / "python")
    for name in ("trajectory.tum", "keyframes.tum"):
        ours = (tmp_path / "python" / name).read_bytes()
        assert ours == (tmp_path / "cpp" / name).read_bytes(), name
    assert run.tracked == 64 and run.lost == 0
    assert run.evaluation is not None and run.evaluation.ate.rmse < 0.02


def test_uint16_with_its_scale_is_the_same_as_metres(
    camera: edvo.Camera, frames: list[edvo.Frame]
) -> None:
    a, b = edvo.Odometry(camera), edvo.Odometry(camera, depth_scale=5000)
    for frame in frames[:3]:
        units = np.nan_to_num(np.round(frame.depth.astype(np.float64) * 5000)).astype(np.uint16)
        first = a.process(frame.stamp_ns * 1e-9, frame.rgb, frame.depth)
        second = b.process(frame.stamp_ns * 1e-9, frame.rgb, units)
        assert np.array_equal(first.pose, second.pose)


def test_results_have_their_shapes_and_meanings(
    camera: edvo.Camera, frames: list[edvo.Frame]
) -> None:
    odometry = edvo.Odometry(camera)
    first = odometry.process("10.5", frames[0].rgb, frames[0].depth)
    second = odometry.process(10.6, frames[1].rgb, frames[1].depth)
    assert first.status == "first" and first.new_keyframe == "first"
    assert np.array_equal(first.pose, np.eye(4))
    assert second.status == "tracked" and second.ok and second.stamp_ns == 10_600_000_000
    assert second.information.shape == (6, 6)
    assert np.allclose(second.information, second.information.T)
    assert np.all(np.linalg.eigvalsh(second.information) > 0)
    assert second.levels and second.levels[-1].level == 0
    assert second.milliseconds["total"] > 0
    assert len(odometry.trajectory()) == 2


def test_any_strides_give_the_same(camera: edvo.Camera, frames: list[edvo.Frame]) -> None:
    frame = frames[0]
    wide = np.zeros((*frame.depth.shape, 6), np.uint8)
    wide[:, :, ::2] = frame.rgb
    depth = np.asfortranarray(frame.depth)
    results = []
    for rgb, z in ((frame.rgb, frame.depth), (wide[:, :, ::2], depth)):
        odometry = edvo.Odometry(camera)
        odometry.process(0, rgb, z)
        results.append(odometry.process(0.1, frames[1].rgb, frames[1].depth).pose)
    assert np.array_equal(*results)


@pytest.mark.parametrize(
    ("rgb", "depth", "error", "words"),
    [
        (np.zeros((240, 320, 3), np.float32), None, TypeError, "rgb: dtype uint8"),
        (np.zeros((240, 320, 4), np.uint8), None, ValueError, "4 channels"),
        (np.zeros((240, 320, 2), np.uint8), None, ValueError, "rgb: shape"),
        (np.zeros((24, 32, 3), np.uint8), None, ValueError, "32 x 24 pixels, but the camera"),
        ([[1]], None, TypeError, "a numpy array is expected, got list"),
        (None, np.zeros((240, 320), np.int32), TypeError, "depth: dtype float32"),
        (None, np.zeros((240, 320), np.uint16), ValueError, "needs depth_scale"),
        (None, np.zeros((120, 160), np.float32), ValueError, "register_depth"),
        (None, np.zeros((240, 320, 3), np.float32), ValueError, "depth: shape"),
    ],
)
def test_arrays_that_do_not_fit_are_named(
    camera: edvo.Camera, rgb: object, depth: object, error: type[Exception], words: str
) -> None:
    odometry = edvo.Odometry(camera)
    rgb = np.zeros((240, 320, 3), np.uint8) if rgb is None else rgb
    depth = np.ones((240, 320), np.float32) if depth is None else depth
    with pytest.raises(error, match=words):
        odometry.process(0, rgb, depth)  # type: ignore[arg-type]


def test_images_out_of_order_change_nothing(
    camera: edvo.Camera, frames: list[edvo.Frame]
) -> None:
    odometry = edvo.Odometry(camera)
    odometry.process(1, frames[0].rgb, frames[0].depth)
    with pytest.raises(edvo.Error) as caught:
        odometry.process(0.5, frames[1].rgb, frames[1].depth)
    assert caught.value.code == 3
    assert odometry.process(1.1, frames[1].rgb, frames[1].depth).status == "tracked"


def test_options_are_checked_and_pickled() -> None:
    options = edvo.Options("canny", **{"keyframes.period": 7})
    assert "period = 7" in options.toml
    assert pickle.loads(pickle.dumps(options)) == options
    with pytest.raises(edvo.Error) as caught:
        edvo.Options(**{"keyframes.perod": 7})
    assert caught.value.code == 4 and "period" in str(caught.value)
    assert pickle.loads(pickle.dumps(caught.value)).code == 4


def test_results_are_pickled(camera: edvo.Camera, frames: list[edvo.Frame]) -> None:
    result = edvo.Odometry(camera).process(0, frames[0].rgb, frames[0].depth)
    again = pickle.loads(pickle.dumps(result))
    assert again.status == result.status and np.array_equal(again.pose, result.pose)
    assert again.levels == result.levels


def test_other_threads_run_meanwhile(camera: edvo.Camera, frames: list[edvo.Frame]) -> None:
    ticks, stop = [0], threading.Event()

    def tick() -> None:
        while not stop.is_set():
            ticks[0] += 1
            time.sleep(1e-4)

    odometry = edvo.Odometry(camera)
    thread = threading.Thread(target=tick)
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1000)  # no thread is interrupted: others run only where C++ lets them
    try:
        thread.start()
        during = 0
        for i, frame in enumerate(frames):
            before = ticks[0]
            odometry.process(i, frame.rgb, frame.depth)
            during += ticks[0] - before
    finally:
        stop.set()
        sys.setswitchinterval(interval)
        thread.join()
    assert during > 0


@pytest.mark.parametrize(
    ("stamp", "expected"),
    [
        ("1305031102.175304", (1305031102175304000, 6)),
        (1305031102.175304, (1305031102175304000, 6)),
        (3, (3_000_000_000, 6)),
        ("0.123456789", (123456789, 9)),
    ],
)
def test_stamps_keep_their_digits(stamp: str | float, expected: tuple[int, int]) -> None:
    assert nanoseconds(stamp) == expected


def test_observers_see_every_frame(camera: edvo.Camera, frames: list[edvo.Frame]) -> None:
    from conftest import Memory

    class Count(edvo.Observer):
        seen: list[str] = []

        def begin(self, source: edvo.Source) -> None:
            self.seen.append(source.name)

        def frame(self, result: edvo.FrameResult, frame: edvo.Frame) -> None:
            self.seen.append(result.status)

        def end(self, run: edvo.Run) -> None:
            self.seen.append(f"{run.tracked}")

    count = Count()
    edvo.run(Memory(camera, frames[:5]), observers=[count])
    assert count.seen == ["memory", "first", "tracked", "tracked", "tracked", "tracked", "5"]


def test_an_error_of_the_source_reaches_the_caller(
    camera: edvo.Camera, frames: list[edvo.Frame]
) -> None:
    from conftest import Memory

    class Broken(Memory):
        def __iter__(self):  # type: ignore[no-untyped-def]
            yield from self.list[:2]
            raise OSError("unplugged")

    with pytest.raises(OSError, match="unplugged"):
        edvo.run(Broken(camera, frames))
