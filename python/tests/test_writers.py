# SPDX-License-Identifier: MIT
"""Trajectories and runs in other formats, read back by others."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import edvo
from edvo.cli import main
from planted import Memory, changed


@pytest.fixture(scope="module")
def finished(sequence: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("finished") / "run"
    edvo.run(sequence, output=folder, max_frames=30)
    return folder


def test_kitti_is_twelve_numbers_a_pose(finished: Path, tmp_path: Path) -> None:
    assert main(["export", str(finished), str(tmp_path / "kitti.txt"), "--format", "kitti"]) == 0
    rows = np.loadtxt(tmp_path / "kitti.txt").reshape(-1, 3, 4)
    poses = edvo.Trajectory.read(finished / "trajectory.tum").poses
    assert np.array_equal(rows, poses[:, :3])


def test_evo_reads_kitti_and_euroc(finished: Path, tmp_path: Path) -> None:
    file_interface = pytest.importorskip("evo.tools.file_interface")
    trajectory = edvo.Trajectory.read(finished / "trajectory.tum")
    trajectory.write(tmp_path / "kitti.txt", format="kitti")
    kitti = file_interface.read_kitti_poses_file(str(tmp_path / "kitti.txt"))
    assert np.allclose(kitti.positions_xyz, trajectory.positions, atol=1e-15)
    assert main(["export", str(finished), str(tmp_path / "euroc.csv")]) == 0
    euroc = file_interface.read_euroc_csv_trajectory(str(tmp_path / "euroc.csv"))
    assert np.allclose(euroc.timestamps, trajectory.stamps, atol=1e-6)
    assert np.array_equal(euroc.positions_xyz, trajectory.positions)
    assert np.array_equal(euroc.orientations_quat_wxyz[:, 1:], trajectory.quaternions[:, :3])


def test_euroc_comes_back(finished: Path, tmp_path: Path) -> None:
    trajectory = edvo.Trajectory.read(finished / "trajectory.tum")
    trajectory.write(tmp_path / "euroc.csv", format="euroc")
    back = edvo.Trajectory.read(tmp_path / "euroc.csv")
    assert np.array_equal(back.stamps_ns, trajectory.stamps_ns)
    assert np.allclose(back.values, trajectory.values, rtol=0, atol=1e-15)


def messages(file: Path) -> dict[str, list[tuple[int, object]]]:
    """By topic, decoded by the library mcap-ros2-support where it is there, else by rosbags."""
    bag_reader = pytest.importorskip("edvo.sources.bag_reader")
    found: dict[str, list[tuple[int, object]]] = {}
    with bag_reader.open_bag(file) as reader:
        for connection, stamp, raw in reader.messages():
            message = reader.deserialize(raw, connection.msgtype)
            found.setdefault(connection.topic, []).append((stamp, message))
    return found


def test_mcap_has_the_frames_and_the_path(sequence: Path, tmp_path: Path) -> None:
    pytest.importorskip("rosbags")
    file = tmp_path / "run.mcap"
    command = ["run", str(sequence), "--max-frames", "20", "-o", str(tmp_path / "out")]
    assert main([*command, "--mcap", str(file), "--quiet"]) == 0
    trajectory = edvo.Trajectory.read(tmp_path / "out" / "trajectory.tum")
    online = edvo.Trajectory.read(tmp_path / "out" / "trajectory_online.tum")
    found = messages(file)
    path = found["/edvo/path"][0][1].poses  # type: ignore[attr-defined]
    assert np.allclose([p.pose.position.x for p in path], trajectory.positions[:, 0], atol=1e-8)
    links = [message.transforms[0] for _, message in found["/tf"]]  # type: ignore[attr-defined]
    assert np.allclose([t.transform.translation.z for t in links], online.positions[:, 2], atol=1e-8)
    assert links[0].header.frame_id == "odom"
    covariance = found["/edvo/pose"][5][1].pose.covariance.reshape(6, 6)  # type: ignore[attr-defined]
    assert np.allclose(covariance, covariance.T) and (np.linalg.eigvalsh(covariance) > 0).all()
    cloud = found["/edvo/keyframe_points"][0][1]
    assert cloud.width > 500 and cloud.data.size == 16 * cloud.width  # type: ignore[attr-defined]
    # And it is a recording that can be tracked again: depth is in millimetres there.
    again = edvo.open_source(file)
    original = edvo.open_source(sequence)
    for a, b in zip(again, original):
        assert a.stamp_ns == b.stamp_ns and np.array_equal(a.rgb, b.rgb)
        assert np.nanmax(np.abs(a.depth - b.depth)) <= 0.00051
    assert again.ground_truth is not None and again.camera == original.camera


def test_mcap_is_what_its_own_library_writes_for(finished: Path, tmp_path: Path) -> None:
    reader_module = pytest.importorskip("mcap.reader")
    assert main(["export", str(finished), str(tmp_path / "path.mcap")]) == 0
    with (tmp_path / "path.mcap").open("rb") as stream:
        reader = reader_module.make_reader(stream)
        assert reader.get_header().profile == "ros2"
        summary = reader.get_summary()
    topics = {channel.topic for channel in summary.channels.values()}
    assert topics == {"/tf", "/edvo/path"}
    assert summary.statistics.message_count == 31


def test_a_format_or_a_place_that_cannot_be_is_named(finished: Path) -> None:
    trajectory = edvo.Trajectory.read(finished / "trajectory.tum")
    with pytest.raises(ValueError, match="one of tum, kitti, euroc, mcap"):
        trajectory.write("x", format="bvh")
    for format in ("tum", "kitti", "euroc"):
        with pytest.raises(edvo.Error, match="/proc/nowhere") as caught:
            trajectory.write("/proc/nowhere", format=format)
        assert caught.value.code == 7


@pytest.mark.parametrize(
    ("name", "start"),
    [("a.csv", "#timestamp [ns]"), ("a.kitti", "1."), ("a.TXT", "1300"), ("a", "1300")],
)
def test_the_name_says_the_format(name: str, start: str, finished: Path, tmp_path: Path) -> None:
    file = tmp_path / name
    edvo.Trajectory.read(finished / "trajectory.tum").write(file)
    assert file.read_text().startswith(start)
    assert main(["export", str(finished), str(tmp_path / f"b{name}")]) == 0
    assert (tmp_path / f"b{name}").read_bytes() == file.read_bytes()


def test_the_name_of_a_recording_is_one(finished: Path, tmp_path: Path) -> None:
    pytest.importorskip("mcap")
    edvo.Trajectory.read(finished / "trajectory.tum").write(tmp_path / "a.mcap")
    assert (tmp_path / "a.mcap").read_bytes().startswith(b"\x89MCAP0")


def test_an_unknown_ending_is_refused(
    finished: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(edvo.Error, match=r"o.json: no known format; .*\.csv \(euroc\)") as caught:
        edvo.Trajectory.read(finished / "trajectory.tum").write(tmp_path / "o.json")
    assert caught.value.code == 2 and not (tmp_path / "o.json").exists()
    assert main(["export", str(finished), str(tmp_path / "o.json")]) == 2
    assert "no known format" in capfd.readouterr().err


def test_no_file_is_replaced_unasked(
    sequence: Path, finished: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "notes.txt"
    file.write_text("of weeks")
    assert main(["export", str(finished), str(file)]) == 7
    recorded, bag = tmp_path / "a.rrd", tmp_path / "a.mcap"
    recorded.write_text("of weeks")
    bag.write_text("of weeks")
    command = ["run", str(sequence), "--max-frames", "4", "--quiet"]
    assert main([*command, "--mcap", str(bag)]) == 7
    assert main([*command, "--record", str(recorded)]) == 7
    assert main(["view", str(finished), "--record", str(recorded)]) == 7
    assert recorded.read_text() == bag.read_text() == "of weeks"
    said = capfd.readouterr().err
    assert said.count("replace it with --force") == 4
    assert file.read_text() == "of weeks"
    assert main(["export", str(finished), str(file), "--force"]) == 0
    assert file.read_bytes() == (finished / "trajectory.tum").read_bytes()


def test_formats_without_segments_are_warned_of(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pose = "0 0 0 0 0 0 1\n"
    (tmp_path / "two.tum").write_text(f"1 {pose}# segment 1\n2 {pose}")
    for name, is_warned in (("out.tum", False), ("out.csv", True), ("out.kitti", True)):
        assert main(["export", str(tmp_path / "two.tum"), str(tmp_path / name)]) == 0
        assert ("2 segments" in capsys.readouterr().err) == is_warned
    assert edvo.Trajectory.read(tmp_path / "out.tum").segments.tolist() == [0, 1]


@pytest.mark.parametrize("format", ["tum", "kitti", "euroc"])
def test_a_pose_that_is_not_finite_is_not_written(format: str, tmp_path: Path) -> None:
    values = np.tile([0.0, 0, 0, 0, 0, 0, 1], (2, 1))
    values[1, 0] = np.nan
    trajectory = edvo.Trajectory(np.array([0, 1_000_000_000]), values)
    with pytest.raises(edvo.Error, match="pose 1 at 1.000000 s is not finite") as refused:
        trajectory.write(tmp_path / "out", format=format)
    assert refused.value.code == 3
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["--record", "m.txt"], 2, "--record .*m.txt: .txt is not written here, only .rrd"),
        (["--mcap", "m.bag"], 2, "--mcap .*m.bag: .bag is not written here, only .mcap"),
        (["--record", "m", "--mcap", "m"], 2, "--record writes that file"),
        (["--mcap", "."], 7, "is a folder"),
        (["--mcap", "none/m.mcap"], 7, "there is no folder .*none"),
    ],
)
def test_an_output_that_cannot_be_is_refused_before_the_run(
    words: list[str], code: int, said: str, sequence: Path, tmp_path: Path,
    capfd: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    places = [word if word[:2] == "--" else str(tmp_path / word) for word in words]
    out = tmp_path / "out"
    assert main(["run", str(sequence), "--quiet", "-o", str(out), *places]) == code
    assert re.search(said, capfd.readouterr().err) and not out.exists()


def test_a_recording_is_not_recorded_again(
    finished: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "a.rrd").touch()
    assert main(["view", str(tmp_path / "a.rrd"), "--record", str(tmp_path / "b.rrd")]) == 2
    assert "is such a recording already" in capfd.readouterr().err
    assert main(["view", str(finished), "--record", str(tmp_path / "b.txt")]) == 2
    assert ".txt is not written here" in capfd.readouterr().err


@pytest.fixture(scope="module")
def bent(camera: edvo.Camera, frames: list[edvo.Frame]) -> Memory:
    """What a lens with distortion sees: each of its pixels takes the nearest of a pinhole's."""
    k1 = 0.15
    y, x = np.mgrid[: camera.height, : camera.width].astype(float)
    distorted = np.stack([(x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy])
    straight = distorted.copy()
    for _ in range(20):
        straight = distorted / (1 + k1 * (straight**2).sum(axis=0))
    columns = np.rint(straight[0] * camera.fx + camera.cx).astype(int)
    rows = np.rint(straight[1] * camera.fy + camera.cy).astype(int)

    def seen(image: Any) -> Any:
        return np.ascontiguousarray(image[rows, columns])

    lens = edvo.Camera(
        camera.fx, camera.fy, camera.cx, camera.cy, camera.width, camera.height, (k1, *[0.0] * 7)
    )
    return Memory(lens, changed(frames[:12], rgb=seen, depth=seen))


def test_mcap_of_a_distorted_camera_can_be_tracked_again_to_the_same_poses(
    bent: Memory, tmp_path: Path
) -> None:
    pytest.importorskip("rosbags")
    from edvo.mcap_file import McapObserver

    file = tmp_path / "bent.mcap"
    first = edvo.run(bent, observers=[McapObserver(file)])
    again = edvo.open_source(file)
    assert again.camera == bent.camera
    for a, b in zip(again, bent.list):
        assert np.array_equal(a.rgb, b.rgb)
        assert np.array_equal(np.isfinite(a.depth), np.isfinite(b.depth))
        assert np.nanmax(np.abs(a.depth - b.depth)) <= 0.00051
    second = edvo.run(again)
    assert first.tracked == second.tracked == 12
    apart = first.trajectory.positions - second.trajectory.positions
    assert np.abs(apart).max() < 5e-4


def test_watchers_get_colour_and_depth_of_one_camera(bent: Memory) -> None:
    seen: list[edvo.Image] = []

    class Keeper(edvo.Observer):
        def frame(self, result: edvo.FrameResult, image: edvo.Image) -> None:
            seen.append(image)

    edvo.run(bent, observers=[Keeper()], max_frames=1)
    frame, image = bent.list[0], seen[0]
    assert np.array_equal(image.recorded_rgb, frame.rgb)
    assert np.array_equal(image.recorded_depth, frame.depth, equal_nan=True)
    assert not np.array_equal(image.rgb, frame.rgb)
    assert not np.array_equal(image.depth, frame.depth, equal_nan=True)


LIMITED = """
import resource, sys
from edvo.cli import main
resource.setrlimit(resource.RLIMIT_FSIZE, (3_000_000, 3_000_000))
sys.exit(main(sys.argv[1:]))
"""


def test_a_recording_that_grows_too_large_costs_the_recording_only(
    sequence: Path, tmp_path: Path
) -> None:
    pytest.importorskip("rosbags")
    out = tmp_path / "out"
    words = ["run", str(sequence), "--quiet", "-o", str(out), "--mcap", str(tmp_path / "a.mcap")]
    result = subprocess.run(
        [sys.executable, "-c", LIMITED, *words], capture_output=True, text=True, check=False
    )
    assert result.returncode == 7, result.stderr
    assert "a.mcap: cannot be written: File too large" in result.stderr
    assert "Traceback" not in result.stderr
    assert (out / "summary.json").is_file() and len(edvo.Trajectory.read(out)) > 3


@pytest.mark.parametrize("stamps", [[0.1, 0.2], np.array([0.0, 1.0])])
def test_stamps_of_a_trajectory_are_whole_nanoseconds(stamps: Any) -> None:
    with pytest.raises(TypeError, match=r"round\(seconds \* 1e9\)"):
        edvo.Trajectory(stamps, np.zeros((2, 7)))


def test_a_trajectory_out_of_order_is_refused() -> None:
    values = np.tile([0.0, 0, 0, 0, 0, 0, 1], (2, 1))
    with pytest.raises(edvo.Error, match=r"stamps_ns\[1\]: 1 is not later than 2") as caught:
        edvo.Trajectory(np.array([2, 1]), values)
    assert caught.value.code == 3
