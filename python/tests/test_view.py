# SPDX-License-Identifier: MIT
"""Rerun as an observer: it changes nothing, and may die."""

from __future__ import annotations

import subprocess
import sys
import time
import urllib.request
from pathlib import Path
from typing import Any

import pytest

import edvo
from edvo.cli import main

pytest.importorskip("rerun")
from edvo import rerun_log, view  # noqa: E402


def rerun(*words: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "rerun", *words]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def entities(file: Path) -> str:
    result = rerun("rrd", "print", str(file))
    assert result.returncode == 0, result.stderr
    return result.stdout + result.stderr


@pytest.fixture(scope="module")
def plain(sequence: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("plain") / "run"
    assert main(["run", str(sequence), "-o", str(folder), "--quiet", "--max-frames", "30"]) == 0
    return folder


def trajectory(folder: Path) -> bytes:
    return (folder / "trajectory.tum").read_bytes()


def test_a_recording_has_everything_and_changes_no_bit(
    sequence: Path, plain: Path, tmp_path: Path
) -> None:
    file, out = tmp_path / "run.rrd", tmp_path / "out"
    command = ["run", str(sequence), "-o", str(out), "--quiet", "--max-frames", "30"]
    assert main([*command, "--record", str(file)]) == 0
    assert trajectory(out) == trajectory(plain)
    assert rerun("rrd", "verify", str(file)).returncode == 0
    text = entities(file)
    for name in (
        "/world/camera/image", "/depth", "/world/path/0", "/world/path_at_the_end",
        "/world/ground_truth", "/world/keyframes/0/points", "/world/keyframes/0/frustum",
        "/world/camera/image/selected", "/inliers/inliers", "/time/total", "/events",
    ):  # fmt: skip
        assert name in text, name


def test_every_frame_is_in_a_recording(
    camera: edvo.Camera,
    frames: list[edvo.Frame],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    import rerun as rr
    from conftest import Memory

    sent: dict[str, int] = {}
    send = rr.send_columns

    def counting(name: str, *, indexes: list[Any], columns: Any, recording: Any) -> None:
        sent[name] = sent.get(name, 0) + len(indexes[0].times)
        send(name, indexes=indexes, columns=columns, recording=recording)

    monkeypatch.setattr(rr, "send_columns", counting)
    monkeypatch.setattr(rerun_log, "MOST_ROWS", 4)
    watcher = view.RerunObserver(tmp_path / "run.rrd")
    edvo.run(Memory(camera, frames), observers=[watcher])
    assert watcher.dropped == 0 and watcher.failure == ""
    assert sent == dict.fromkeys(("world/camera", *view.Rows.CURVES), len(frames))


def test_a_finished_run_can_be_shown(plain: Path, tmp_path: Path) -> None:
    file = tmp_path / "later.rrd"
    assert main(["view", str(plain), "--record", str(file)]) == 0
    text = entities(file)
    for name in ("/world/path_at_the_end", "/world/ground_truth", "/world/keyframes/0", "/time/total"):
        assert name in text, name
    assert main(["view", str(tmp_path)]) == 3


def wait_for(address: str) -> bytes:
    for _ in range(100):
        try:
            with urllib.request.urlopen(address, timeout=2) as answer:
                return bytes(answer.read(4096))
        except OSError:
            time.sleep(0.1)
    raise AssertionError(f"{address}: no answer")


def test_a_viewer_killed_on_the_way_ends_nothing(
    sequence: Path, plain: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(view, "GRPC_PORT", 19876)
    monkeypatch.setattr(view, "WEB_PORT", 19090)
    monkeypatch.setattr(view, "FLUSH_SECONDS", 2.0)

    class Killer(edvo.Observer):
        count = 0

        def frame(self, result: edvo.FrameResult, image: edvo.Image) -> None:
            self.count += 1
            if self.count == 10:
                view.SERVER[-1].kill()
                view.SERVER[-1].wait()

    watcher = view.RerunObserver(live=True)
    page = wait_for("http://127.0.0.1:19090/")
    assert b"<html" in page.lower() or b"<!doctype" in page.lower()
    run = edvo.run(sequence, observers=[watcher, Killer()], max_frames=30)
    run.write(tmp_path)
    assert trajectory(tmp_path) == trajectory(plain)
    with pytest.raises(OSError):  # it was the viewer that was killed, not something before it
        urllib.request.urlopen("http://127.0.0.1:19090/", timeout=2)


def test_an_observer_that_fails_inside_says_so_and_goes_on(
    camera: edvo.Camera, frames: list[edvo.Frame], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from conftest import Memory

    watcher = view.RerunObserver(tmp_path / "run.rrd")

    def broken(*_: object) -> None:
        raise RuntimeError("no pixels")

    monkeypatch.setattr(watcher, "_log_frame", broken)
    assert edvo.run(Memory(camera, frames[:20]), observers=[watcher]).tracked == 20
    assert "no pixels" in watcher.failure


def test_a_second_view_has_a_port_of_its_own() -> None:
    import socket

    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        busy = other.getsockname()[1]
        port = view.free_port(busy)
        assert port != busy
        options, address = view.page_options(port)
        assert str(port) in options and f":{port}/proxy" in address
    assert view.free_port(busy) == busy
