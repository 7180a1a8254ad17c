# SPDX-License-Identifier: MIT
"""edvo.Slam, and edge detectors written in Python."""

from __future__ import annotations

import pickle
import threading
from pathlib import Path

import numpy as np
import pytest
from conftest import Memory, synth
from numpy.typing import NDArray

import edvo

Frames = list[edvo.Frame]


@pytest.fixture(scope="module")
def interrupted(tmp_path_factory: pytest.TempPathFactory) -> Memory:
    """There, in the dark, and back: two visits of the same places between which tracking is lost."""
    folder = synth(
        tmp_path_factory.mktemp("slam") / "living_room", "--frames", "120", "--scene", "living_room"
    )  # fmt: skip
    source = edvo.open_source(folder)
    there = list(source)[:100]
    dark = [
        edvo.Frame(0, np.zeros_like(frame.rgb), np.full_like(frame.depth, np.nan))
        for frame in there[:12]
    ]
    step = there[1].stamp_ns - there[0].stamp_ns
    frames = [
        edvo.Frame(there[0].stamp_ns + i * step, frame.rgb, frame.depth)
        for i, frame in enumerate([*there, *dark, *there[5:25]])
    ]
    return Memory(source.camera, frames, None)


def track(tracker: edvo.Odometry | edvo.Slam, frames: Frames) -> list[edvo.FrameResult]:
    return [
        tracker.process_ns(frame.stamp_ns, frame.decimals, frame.rgb, frame.depth)
        for frame in frames
    ]


def test_by_hand_it_gives_what_a_run_gives(interrupted: Memory) -> None:
    slam = edvo.Slam(interrupted.camera)
    track(slam, interrupted.list)
    slam.finish()
    run = edvo.run(interrupted)
    assert np.array_equal(slam.trajectory().values, run.trajectory.values)
    assert np.array_equal(slam.keyframes().values, run.keyframes.values)
    assert [(link.first, link.second, link.status) for link in slam.links()] == [
        (link.first, link.second, link.status) for link in run.links
    ]


def test_places_seen_again_join_segments(interrupted: Memory) -> None:
    slam = edvo.Slam(interrupted.camera)
    results = track(slam, interrupted.list)
    assert results[-1].segment == 1 and len(slam.segments()) == 2
    assert slam.links() == []
    slam.finish()
    assert any(link.accepted for link in slam.links())
    (whole,) = slam.segments()
    assert len(whole) == len(slam.trajectory())
    # The second visit shows the images of the first, so that the poses must be equal.
    first, second = whole.poses[5:25], whole.poses[-20:]
    assert np.abs(first - second).max() < 0.01
    link = next(link for link in slam.links() if link.accepted)
    assert link.first_from_second.shape == (4, 4) and link.information.shape == (6, 6)
    again = pickle.loads(pickle.dumps(link))
    assert again.status == "accepted" and np.array_equal(again.information, link.information)
    slam.reset()
    assert len(slam.trajectory()) == 0 and slam.links() == []


def test_a_run_can_be_pickled(interrupted: Memory) -> None:
    run = edvo.run(Memory(interrupted.camera, interrupted.list[:8], None))
    again = pickle.loads(pickle.dumps(run))
    assert np.array_equal(again.trajectory.values, run.trajectory.values)
    assert again.counts == run.counts and again.source.camera == run.source.camera
    assert [result.status for result in again.frames] == [result.status for result in run.frames]


def test_a_method_without_keyframes_is_refused(camera: edvo.Camera) -> None:
    with pytest.raises(edvo.Error, match="edvo.Odometry") as caught:
        edvo.Slam(camera, method="origin")
    assert caught.value.code == 4


class Gradients(edvo.EdgeDetector):
    """Strong where the grey levels change."""

    def __init__(self) -> None:
        self.calls: list[str] = []

    def strength(self, rgb: NDArray[np.uint8]) -> NDArray[np.float32]:
        self.calls.append(threading.current_thread().name)
        grey = rgb.astype(np.float32).mean(axis=2)
        dy, dx = np.gradient(grey)
        return np.clip(np.hypot(dx, dy) / 32, 0, 1).astype(np.float32)


@pytest.mark.parametrize("kind", [edvo.Odometry, edvo.Slam])
def test_an_own_detector_finds_the_edges(
    kind: type[edvo.Odometry | edvo.Slam], camera: edvo.Camera, frames: Frames
) -> None:
    detector = Gradients()
    results = track(kind(camera, detector=detector), frames[:20])
    assert all(result.ok for result in results)
    assert len(detector.calls) >= 1
    others = track(kind(camera), frames[:20])
    assert not np.array_equal(results[-1].pose, others[-1].pose)
    assert np.abs(results[-1].pose - others[-1].pose).max() < 0.01


def test_an_own_detector_gives_the_same_bits_each_time_also_in_a_run(
    sequence: Path, camera: edvo.Camera, frames: Frames
) -> None:
    detector = Gradients()
    run = edvo.run(sequence, detector=detector, max_frames=20, threads=3)
    assert run.tracked == 20 and len(detector.calls) >= 1
    slam = edvo.Slam(camera, detector=Gradients())
    track(slam, frames[:20])
    slam.finish(threads=1)
    assert np.array_equal(slam.trajectory().values, run.trajectory.values)


@pytest.mark.parametrize(
    ("given", "error", "message"),
    [
        (np.zeros((2, 2), np.float32), ValueError, "shape"),
        (np.zeros((240, 320), np.uint8), TypeError, "floats"),
        (np.full((240, 320), 2.0), ValueError, r"\[0, 1\]"),
        (np.full((240, 320), np.nan), ValueError, r"\[0, 1\]"),
        ([[0.0]], TypeError, "numpy array"),
        (RuntimeError, RuntimeError, "no licence"),
    ],
)
def test_a_detector_that_fails_is_the_cause_of_an_error(
    given: object, error: type[Exception], message: str, camera: edvo.Camera, frames: Frames
) -> None:
    class Broken(edvo.EdgeDetector):
        def strength(self, rgb: NDArray[np.uint8]) -> NDArray[np.float32]:
            if isinstance(given, type):
                raise given("no licence")
            return given  # type: ignore[return-value]

    for attempt in (
        lambda: track(edvo.Odometry(camera, detector=Broken()), frames[:3]),
        lambda: edvo.run(Memory(camera, frames[:3], None), detector=Broken()),
    ):
        with pytest.raises(edvo.Error, match=message) as caught:
            attempt()
        assert caught.value.code == 6 and isinstance(caught.value.__cause__, error)


def test_ctrl_c_in_a_detector_is_ctrl_c(camera: edvo.Camera, frames: Frames) -> None:
    class Stopped(edvo.EdgeDetector):
        def strength(self, rgb: NDArray[np.uint8]) -> NDArray[np.float32]:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        track(edvo.Odometry(camera, detector=Stopped()), frames[:3])


def visit(interrupted: Memory, first: int, last: int) -> Memory:
    return Memory(interrupted.camera, interrupted.list[first:last], None)


def test_a_run_is_found_in_the_map_of_another(interrupted: Memory, tmp_path: Path) -> None:
    file = tmp_path / "room.edvomap"
    first = edvo.run(visit(interrupted, 0, 80), save_map=file)
    assert first.map_segments is None and file.is_file()
    second = edvo.run(visit(interrupted, 20, 100), map=file)
    assert second.map_segments == (0,)
    by_stamp = dict(zip(first.trajectory.stamps_ns.tolist(), first.trajectory.values))
    common = [
        (by_stamp[stamp][:3], values[:3])
        for stamp, values in zip(second.trajectory.stamps_ns.tolist(), second.trajectory.values)
        if stamp in by_stamp
    ]
    assert len(common) >= 50
    assert max(np.linalg.norm(a - b) for a, b in common) < 0.02
    size = file.stat().st_size
    edvo.run(visit(interrupted, 20, 100), map=file, update_map=True)
    assert file.stat().st_size > size


def test_a_map_made_by_hand_is_that_of_a_run(interrupted: Memory, tmp_path: Path) -> None:
    frames = interrupted.list[:60]
    by_run, by_hand = tmp_path / "run.edvomap", tmp_path / "hand.edvomap"
    edvo.run(visit(interrupted, 0, 60), save_map=by_run)
    slam = edvo.Slam(interrupted.camera, keep_colour=True)
    track(slam, frames)
    slam.finish()
    slam.save_map(by_hand)
    assert slam.map_segments() is None
    assert by_hand.stat().st_size == by_run.stat().st_size
    again = edvo.Slam(interrupted.camera, map=by_hand)
    track(again, frames)
    again.finish()
    assert again.map_segments() == [0]


def test_a_map_replaces_no_other_file_and_a_map_only_if_told_to(
    interrupted: Memory, tmp_path: Path
) -> None:
    few = visit(interrupted, 0, 20)
    notes, file = tmp_path / "notes.txt", tmp_path / "room.map"
    notes.write_text("of weeks")
    with pytest.raises(edvo.Error, match="is no map of edvo") as caught:
        edvo.run(few, save_map=notes, force=True)
    assert caught.value.code == 7
    edvo.run(few, save_map=file)
    with pytest.raises(edvo.Error, match="save_map .*replace it with force=True$") as caught:
        edvo.run(few, save_map=file)
    assert caught.value.code == 7
    edvo.run(few, save_map=file, force=True)
    slam = edvo.Slam(interrupted.camera)
    track(slam, few.list)
    slam.finish()
    with pytest.raises(edvo.Error, match="replace it with force=True$") as caught:
        slam.save_map(file)
    assert caught.value.code == 7
    slam.save_map(file, force=True)
    with pytest.raises(edvo.Error, match="is no map of edvo"):
        slam.save_map(notes, force=True)
    with pytest.raises(edvo.Error, match="nothing was tracked yet") as caught:
        edvo.Slam(interrupted.camera).save_map(tmp_path / "empty.map")
    assert caught.value.code == 2 and not (tmp_path / "empty.map").exists()
    assert notes.read_text() == "of weeks"


def test_a_run_that_is_not_in_the_map_says_so_and_keeps_its_result(
    interrupted: Memory, tmp_path: Path
) -> None:
    file = tmp_path / "room.edvomap"
    edvo.run(visit(interrupted, 0, 40), save_map=file)
    folder = synth(tmp_path / "boxes", "--frames", "40", "--scene", "boxes")
    with pytest.raises(edvo.Error, match="no part of this run was found in the map") as caught:
        edvo.run(folder, map=file, doctor=False)
    assert len(caught.value.run.trajectory) == 40
    with pytest.raises(edvo.Error, match="which map"):
        edvo.run(interrupted, update_map=True)


def test_loops_and_the_final_pass_can_be_left_out(interrupted: Memory) -> None:
    frames = visit(interrupted, 0, 60)
    odometry = edvo.Odometry(interrupted.camera)
    track(odometry, frames.list)
    odometry.finish()
    alone = edvo.run(frames, loops=False)
    assert np.array_equal(alone.trajectory.values, odometry.trajectory().values)
    short = edvo.run(frames, loops=False, final_pass=False)
    same = edvo.run(frames, loops=False, **{"window.final_iterations": 0})
    assert np.array_equal(short.trajectory.values, same.trajectory.values)
    assert not np.array_equal(short.trajectory.values, alone.trajectory.values)


def test_what_a_mask_hides_is_not_tracked(interrupted: Memory, tmp_path: Path) -> None:
    """Something textured moves with the camera over a quarter of the image, as a robot's arm."""
    cv2 = pytest.importorskip("cv2")
    height, width = interrupted.list[0].depth.shape
    shown = np.ones((height, width), bool)
    shown[height // 2 :, : width // 2] = False
    arm = np.random.default_rng(1).integers(0, 255, (height // 8, width // 8, 3), dtype=np.uint8)
    arm = cv2.resize(arm, (width, height), interpolation=cv2.INTER_CUBIC)
    frames = [
        edvo.Frame(
            frame.stamp_ns,
            np.where(shown[..., None], frame.rgb, arm),
            np.where(shown, frame.depth, np.float32(0.8)),
        )
        for frame in interrupted.list[:60]
    ]
    camera = interrupted.camera
    scene = edvo.run(visit(interrupted, 0, 60), mask=shown)
    with_arm = edvo.run(Memory(camera, frames, None), mask=shown)
    assert with_arm.tracked >= 59 and with_arm.lost == 0
    ends = [run.trajectory.values[-1, :3] for run in (scene, with_arm)]
    assert np.linalg.norm(ends[0] - ends[1]) < 0.01
    file = tmp_path / "mask.png"
    cv2.imwrite(str(file), np.where(shown, 255, 0).astype(np.uint8))
    by_file = edvo.run(Memory(camera, frames, None), mask=file)
    assert np.array_equal(by_file.trajectory.values, with_arm.trajectory.values)
    slam = edvo.Slam(camera, mask=shown)
    track(slam, frames)
    slam.finish()
    assert np.array_equal(slam.trajectory().values, with_arm.trajectory.values)
    for mask, error in ((np.zeros((height, width), bool), "hides everything"), (shown[1:], "shape")):
        with pytest.raises(ValueError, match=error):
            edvo.run(interrupted, mask=mask)
