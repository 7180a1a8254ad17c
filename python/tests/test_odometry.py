# SPDX-License-Identifier: MIT
from __future__ import annotations

import os
import pickle
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import edvo
from edvo import _core
from edvo.stamp import nanoseconds


@pytest.fixture(scope="module")
def written(sequence: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What the C++ program writes for the sequence."""
    folder = tmp_path_factory.mktemp("program") / "out"
    command = ["run", str(sequence), "-o", str(folder), "--quiet", "--no-report"]
    if program := os.environ.get("EDVO_PROGRAM"):
        subprocess.run([program, *command], check=True, stdout=subprocess.DEVNULL)
    else:
        assert _core.main(["edvo", *command]) == 0
    return folder


TRAJECTORIES = ("trajectory.tum", "trajectory_online.tum", "keyframes.tum")


@pytest.mark.parametrize("threads", [1, 3])
def test_numbers_equal_the_programs_to_the_bit(
    sequence: Path, written: Path, tmp_path: Path, threads: int
) -> None:
    run = edvo.run(sequence, threads=threads)
    run.write(tmp_path)
    for name in TRAJECTORIES:
        assert (tmp_path / name).read_bytes() == (written / name).read_bytes(), name
    assert run.tracked == 64 and run.lost == 0
    assert run.evaluation is not None and run.evaluation.ate.rmse < 0.02


def test_frames_by_hand_or_by_a_source_of_python_give_the_same_bits(
    camera: edvo.Camera, frames: list[edvo.Frame], written: Path, tmp_path: Path
) -> None:
    from conftest import Memory

    edvo.run(Memory(camera, frames)).write(tmp_path / "source")
    odometry = edvo.Odometry(camera)
    for frame in frames:
        odometry.process_ns(frame.stamp_ns, frame.decimals, frame.rgb, frame.depth)
    odometry.finish()
    odometry.trajectory().write(tmp_path / "trajectory.tum")
    expected = (written / "trajectory.tum").read_bytes()
    assert (tmp_path / "trajectory.tum").read_bytes() == expected
    assert (tmp_path / "source" / "trajectory.tum").read_bytes() == expected


def test_output_is_the_programs_folder(sequence: Path, written: Path, tmp_path: Path) -> None:
    edvo.run(sequence, output=tmp_path / "out")
    for name in (*TRAJECTORIES, "config.toml"):
        assert (tmp_path / "out" / name).read_bytes() == (written / name).read_bytes(), name
    assert (tmp_path / "out" / "report.html").stat().st_size > 10000
    with pytest.raises(edvo.Error) as caught:
        edvo.run(sequence, output=tmp_path / "out", max_frames=2)
    assert caught.value.code == 7
    assert edvo.run(sequence, output=tmp_path / "out", max_frames=2, force=True).tracked == 2


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


def test_observers_see_what_happens(camera: edvo.Camera, frames: list[edvo.Frame]) -> None:
    from conftest import Memory

    class Watcher(edvo.Observer):
        def __init__(self) -> None:
            self.seen: list[str] = []
            self.keyframes: list[edvo.Keyframe] = []
            self.maps: list[int] = []

        def begin(self, source: edvo.SourceInfo) -> None:
            self.seen.append(source.name)
            assert source.camera == camera

        def frame(self, result: edvo.FrameResult, image: edvo.Image) -> None:
            frame = frames[len(self.seen) - 1]
            assert np.array_equal(image.rgb, frame.rgb)
            assert np.array_equal(image.depth, frame.depth, equal_nan=True)
            self.seen.append(result.status)

        def skipped(self, index: int, stamp: str, reason: str) -> None:
            self.seen.append(f"skipped {index}: {reason}")

        def keyframe(self, keyframe: edvo.Keyframe) -> None:
            self.keyframes.append(keyframe)

        def map_changed(self, keyframes: list[edvo.KeyframePose]) -> None:
            self.maps.append(len(keyframes))

        def end(self, run: edvo.Run) -> None:
            self.seen.append(f"{run.tracked}")

    small = edvo.Frame(frames[4].stamp_ns, frames[4].rgb[::2, ::2], frames[4].depth[::2, ::2])
    watcher = Watcher()
    edvo.run(Memory(camera, [*frames[:4], small]), observers=[watcher])
    tracked = ["first", "tracked", "tracked", "tracked"]
    assert watcher.seen[:5] == ["memory", *tracked] and watcher.seen[6:] == ["4"]
    assert watcher.seen[5].startswith("skipped 4: rgb: 160 x 120 pixels, but the camera has")
    first = watcher.keyframes[0]
    assert first.id == 0 and first.points.shape == (len(first.colours), 3) and len(first.points) > 500
    assert np.isfinite(first.points).all() and (first.points[:, 2] > 0).all()
    assert watcher.maps and watcher.maps[-1] == len(watcher.keyframes)


def test_an_observer_that_raises_ends_the_run(
    camera: edvo.Camera, frames: list[edvo.Frame]
) -> None:
    from conftest import Memory

    class Broken(edvo.Observer):
        def frame(self, result: edvo.FrameResult, image: edvo.Image) -> None:
            raise ZeroDivisionError("of an observer")

    with pytest.raises(edvo.Error, match="ZeroDivisionError: of an observer") as caught:
        edvo.run(Memory(camera, frames), observers=[Broken()])
    assert isinstance(caught.value.__cause__, ZeroDivisionError) and caught.value.code == 1


@pytest.mark.parametrize("when", ["begin", "frame", "keyframe", "end"])
def test_an_observer_that_cannot_write_is_code_7_and_what_was_done_is_kept(
    camera: edvo.Camera, frames: list[edvo.Frame], tmp_path: Path, when: str
) -> None:
    from conftest import Memory

    def fail(self: Any, *arguments: Any) -> None:
        raise OSError(28, "No space left on device")

    ended = []

    class Listener(edvo.Observer):
        def end(self, run: edvo.Run) -> None:
            ended.append(run)

    broken = type("Broken", (edvo.Observer,), {when: fail})()
    with pytest.raises(edvo.Error, match="No space left on device") as caught:
        edvo.run(
            Memory(camera, frames),
            observers=[broken, Listener()],
            output=tmp_path / "run",
            save_map=tmp_path / "a.map",
        )
    assert caught.value.code == 7 and isinstance(caught.value.__cause__, OSError)
    if when == "begin":  # nothing was done yet
        assert caught.value.run is None and not ended
        return
    done = caught.value.run
    assert done is not None and not done.interrupted and len(ended) == 1
    assert len(done.trajectory) == (len(frames) if when == "end" else 1)
    assert (tmp_path / "run" / "summary.json").is_file() and (tmp_path / "a.map").is_file()


def unplugged(camera: edvo.Camera, frames: list[edvo.Frame]) -> edvo.Source:
    """Gives two frames, then fails."""
    from conftest import Memory

    class Broken(Memory):
        def __iter__(self):  # type: ignore[no-untyped-def]
            yield from self.list[:2]
            raise OSError("unplugged")

    return Broken(camera, frames)


def test_an_error_of_the_source_keeps_what_was_done(
    camera: edvo.Camera, frames: list[edvo.Frame]
) -> None:
    with pytest.raises(edvo.Error, match="OSError: unplugged") as caught:
        edvo.run(unplugged(camera, frames))
    assert caught.value.run is not None and caught.value.run.tracked == 2


def test_a_live_source_drops_what_comes_too_fast(
    camera: edvo.Camera, frames: list[edvo.Frame]
) -> None:
    from conftest import Memory

    class Live(Memory):
        is_live = True

    run = edvo.run(Live(camera, frames))
    assert run.counts["tracked"] + run.counts["dropped"] == len(frames)
    assert run.counts["dropped"] > 0


def test_runs_of_two_threads_do_not_meet(sequence: Path) -> None:
    source = edvo.open_source(sequence)
    results: list[edvo.Run] = []
    threads = [
        threading.Thread(target=lambda: results.append(edvo.run(source, max_frames=20)))
        for _ in range(2)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    a, b = results
    assert np.array_equal(a.trajectory.values, b.trajectory.values) and len(a.trajectory) == 20


@pytest.mark.parametrize("kind", [edvo.Odometry, edvo.Slam])
def test_threads_take_turns_with_one_object(
    kind: type[edvo.Odometry | edvo.Slam],
    camera: edvo.Camera,
    frames: list[edvo.Frame],
    tmp_path: Path,
) -> None:
    tracker = kind(camera)
    alone = kind(camera)
    for frame in frames[:30]:
        alone.process_ns(frame.stamp_ns, 9, frame.rgb, frame.depth)
    stop = threading.Event()

    def look() -> None:
        while not stop.is_set():
            assert len(tracker.trajectory()) <= 30 and len(tracker.keyframes()) <= 30
            if isinstance(tracker, edvo.Slam) and len(tracker.keyframes()) > 0:
                tracker.links()
                tracker.save_map(tmp_path / "live.map", force=True)

    lookers = [threading.Thread(target=look) for _ in range(2)]
    for thread in lookers:
        thread.start()
    late: list[edvo.Error] = []

    def feed() -> None:
        for frame in frames[:30]:
            try:
                tracker.process_ns(frame.stamp_ns, 9, frame.rgb, frame.depth)
            except edvo.Error as error:  # the other thread was first
                late.append(error)

    feeders = [threading.Thread(target=feed) for _ in range(2)]
    for thread in feeders:
        thread.start()
    for thread in feeders:
        thread.join()
    stop.set()
    for thread in lookers:
        thread.join()
    tracker.finish()
    assert len(tracker.trajectory()) + len(late) == 60
    assert all("not later" in str(error) for error in late)


def test_a_detector_cannot_call_who_asks_it(
    camera: edvo.Camera, frames: list[edvo.Frame]
) -> None:
    class Curious(edvo.EdgeDetector):
        def strength(self, rgb):  # type: ignore[no-untyped-def]
            return np.full(rgb.shape[:2], len(known[0].trajectory()) + 0.5)

    odometry = edvo.Odometry(camera, detector=Curious())
    known = [odometry]
    with pytest.raises(edvo.Error, match="called by its own detector") as caught:
        odometry.process(0, frames[0].rgb, frames[0].depth)
    known.clear()  # no circle, which would keep both for ever
    assert caught.value.code == 2


def test_a_source_may_fill_the_same_arrays_again(
    camera: edvo.Camera, frames: list[edvo.Frame]
) -> None:
    from conftest import Memory

    class Reusing(Memory):
        def __iter__(self):  # type: ignore[no-untyped-def]
            rgb, depth = frames[0].rgb.copy(), frames[0].depth.copy()
            for frame in self.list:
                rgb[:], depth[:] = frame.rgb, frame.depth
                yield edvo.Frame(frame.stamp_ns, rgb, depth)

    expected = edvo.run(Memory(camera, frames[:30])).trajectory.values
    for threads in (1, 2, 4):
        run = edvo.run(Reusing(camera, frames[:30]), threads=threads)
        assert np.array_equal(run.trajectory.values, expected)


def test_what_a_source_raised_is_the_cause(camera: edvo.Camera, frames: list[edvo.Frame]) -> None:
    with pytest.raises(edvo.Error, match="OSError: unplugged") as caught:
        edvo.run(unplugged(camera, frames))
    assert isinstance(caught.value.__cause__, OSError)
    assert caught.value.__cause__.__traceback__ is not None


def test_a_source_that_gives_no_frames_is_named(
    camera: edvo.Camera, frames: list[edvo.Frame]
) -> None:
    from conftest import Memory

    with pytest.raises(edvo.Error, match="Memory: __iter__ gave tuple, but edvo.Frame"):
        edvo.run(Memory(camera, [(1, frames[0].rgb, frames[0].depth)]))  # type: ignore[list-item]


@pytest.mark.parametrize("stamp", [0.1, np.float64(0.1), "0.1"])
def test_stamps_of_frames_are_whole_nanoseconds(
    stamp: object, camera: edvo.Camera, frames: list[edvo.Frame]
) -> None:
    from conftest import Memory

    frame = edvo.Frame(stamp, frames[0].rgb, frames[0].depth)  # type: ignore[arg-type]
    with pytest.raises(edvo.Error, match=r"frame 0: stamp_ns .*0.1.*: whole nanoseconds"):
        edvo.run(Memory(camera, [frame]))


def test_an_error_is_pickled_with_its_run(camera: edvo.Camera, frames: list[edvo.Frame]) -> None:
    with pytest.raises(edvo.Error) as caught:
        edvo.run(unplugged(camera, frames))
    again = pickle.loads(pickle.dumps(caught.value))
    assert (str(again), again.code) == (str(caught.value), caught.value.code)
    assert again.run.tracked == 2


SILENT = """
import os, signal, sys, threading, time, edvo
signal.signal(signal.SIGINT, signal.default_int_handler)
class Silent(edvo.Source):
    is_live = sys.argv[2] == "live"
    def __init__(self):
        super().__init__()
        self.list = list(edvo.open_source(sys.argv[1]))[:3]
        self.camera = edvo.open_source(sys.argv[1]).camera
    def __iter__(self):
        for frame in self.list:
            time.sleep(0.5)
            yield frame
        threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT)).start()
        time.sleep(3600)
run = edvo.run(Silent())
assert run.interrupted and run.tracked == 3, run
print("kept")
"""


@pytest.mark.parametrize("kind", ["live", "recorded"])
def test_ctrl_c_ends_the_wait_for_a_source(kind: str, sequence: Path) -> None:
    command = [sys.executable, "-c", SILENT, str(sequence), kind]
    result = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
    assert (result.returncode, result.stdout) == (0, "kept\n"), result.stderr


def test_a_live_source_that_falls_silent_is_given_up(
    camera: edvo.Camera, frames: list[edvo.Frame], monkeypatch: pytest.MonkeyPatch
) -> None:
    from conftest import Memory

    monkeypatch.setattr("edvo.sources.base.SILENCE", 0.5)
    ended = threading.Event()

    class Silent(Memory):
        is_live = True

        def __iter__(self):  # type: ignore[no-untyped-def]
            try:
                yield self.list[0]
                ended.wait(60)
            finally:
                ended.set()

        def stop(self) -> None:
            ended.set()

    with pytest.raises(edvo.Error, match="no frame for 0.5 s") as caught:
        edvo.run(Silent(camera, frames))
    assert caught.value.code == 3 and caught.value.run is not None
    assert caught.value.run.tracked == 1 and ended.wait(5)
