# SPDX-License-Identifier: MIT
"""A run in Rerun: live in its viewer or in a browser, recorded to a file, or after its end."""

from __future__ import annotations

import atexit
import os
import queue
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from edvo.camera import Camera
from edvo.errors import Error
from edvo.finished_run import log_run
from edvo.observer import Image, Keyframe, KeyframePose, Observer, SourceInfo
from edvo.odometry import FrameResult
from edvo.rerun_log import FINAL, TRUTH, Log, Rows, rerun
from edvo.runner import Run
from edvo.trajectory import Trajectory

WAITING = 8  # frames that the viewer may be behind; further ones are not shown
GRPC_PORT, WEB_PORT = 9876, 9090
IMAGE_PERIOD = 0.3  # [s], between images and moved keyframes that a live viewer gets: they cost time
ROWS_PERIOD = 0.1  # [s], between two sendings of poses and curves to a live viewer
PATH_PERIOD = 10  # frames between two drawings of the path in a recording
SWITCH_SECONDS = 5e-5  # [s] after which a thread of Python lets another run; Python's own is 5e-3
FLUSH_SECONDS = 10.0  # that a viewer has to take the last frames
MOVED = 1e-4  # [m, rad] of a keyframe that is shown anew
PATH, LOST = [255, 160, 60], [220, 50, 50]


def blueprint(with_images: bool = True) -> Any:
    """3-D left; colour, depth and curves right."""
    import rerun.blueprint as rrb

    curves = [
        rrb.TimeSeriesView(origin="/inliers", name="share of inliers, overlap"),
        rrb.TimeSeriesView(origin="/time", name="time of a frame [ms]"),
        rrb.TextLogView(origin="/events", name="keyframes, losses"),
    ]
    images = rrb.Horizontal(
        rrb.Spatial2DView(origin="/world/camera/image", name="colour, selected pixels"),
        rrb.Spatial2DView(origin="/depth", name="depth"),
    )
    return rrb.Blueprint(
        rrb.Horizontal(
            rrb.Spatial3DView(origin="/world", name="path and keyframes"),
            rrb.Vertical(*([images] if with_images else []), *curves),
            column_shares=[3, 2],
        ),
        collapse_panels=True,
    )


def has_display() -> bool:
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def open_sinks(recording: Any, record: str | Path | None, live: bool, with_images: bool) -> None:
    """To a file, a viewer of its own, or a page for browsers; says which."""
    rr = rerun()
    sinks = []
    plan = blueprint(with_images)
    if record is not None:
        try:
            Path(record).open("wb").close()
        except OSError as error:
            raise Error(f"{record}: cannot be written: {error.strerror}", 7) from None
        sinks.append(rr.FileSink(str(record)))
    if live:
        port = free_port(GRPC_PORT)
        if has_display():
            rr.spawn(connect=False, port=port)
        else:
            serve_pages(port)
        sinks.append(rr.GrpcSink(f"rerun+http://127.0.0.1:{port}/proxy"))
    recording.set_sinks(*sinks, default_blueprint=plan)


SERVER: list[subprocess.Popen[bytes]] = []


def free_port(usual: int) -> int:
    """The usual one, or any other if a program has it: a second view has a server of its own."""
    for port in (usual, 0):
        with socket.socket() as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                probe.bind(("127.0.0.1", port))
            except OSError:
                continue
            return int(probe.getsockname()[1])
    raise Error("view: no port of 127.0.0.1 is free", 10)


def page_options(port: int) -> tuple[list[str], str]:
    """Of Rerun's program that serves on this port, and where its page is."""
    page = free_port(WEB_PORT)
    options = ["--serve-web", "--bind", "127.0.0.1", "--port", str(port), "--web-viewer-port", str(page)]
    address = (
        f"view: http://localhost:{page}/?url=rerun%2Bhttp://localhost:{port}/proxy\n"
        f"      from another machine first: ssh -L {page}:localhost:{page} "
        f"-L {port}:localhost:{port} HOST"
    )
    return options, address


def serve_pages(port: int) -> None:
    """Rerun's server and page, in a process of their own that ends with this one."""
    options, address = page_options(port)
    command = [*politely(), *rerun_program(), *options]
    server = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    SERVER.append(server)
    atexit.register(server.terminate)
    print(address, file=sys.stderr, flush=True)


def politely() -> list[str]:
    """Tracking goes first where cores are few; `nice` becomes the program that it starts."""
    return ["nice", "-n", "10"] if shutil.which("nice") else []


def rerun_program() -> list[str]:
    """Rerun's own program: that of `python -m rerun` is a child, which would outlive its end."""
    import rerun_cli

    program = Path(rerun_cli.__file__).parent / "rerun"
    return [str(program)] if program.is_file() else [sys.executable, "-m", "rerun"]


def wait_for_pages() -> None:
    """Until ctrl-C, while a page may still be looked at."""
    if not SERVER or not sys.stdin.isatty():
        return
    print("view: still there; ctrl-C ends it", file=sys.stderr)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # the program has its own
    try:
        SERVER[-1].wait()
    except KeyboardInterrupt:
        pass
    finally:
        signal.signal(signal.SIGINT, before)


class RerunObserver(Observer):
    """Hands frames to a thread of its own: a slow or dead viewer never holds up a run.

    ``record``: a file, which gets every frame (writing it is waited for). ``live``: a viewer, which
    gets those that it has time for, some with their images; ``dropped`` counts the others.
    """

    def __init__(self, record: str | Path | None = None, *, live: bool = False) -> None:
        self._log = Log()
        open_sinks(self._log.out, record, live, with_images=True)
        self._queue: queue.Queue[Any] = queue.Queue(WAITING)
        self._lossless = record is not None and not live
        self._live = live
        self.dropped = 0  # frames that were not shown, as the viewer was behind
        self.failure = ""  # why the viewer got no more
        self._camera: Camera | None = None
        self._truth: Trajectory | None = None
        self._path: dict[int, list[NDArray[np.float64]]] = {}  # by segment
        self._shown: dict[int, NDArray[np.float64]] = {}  # keyframes' poses
        self._map: list[KeyframePose] = []  # that is not shown yet
        self._count = 0
        self._rows = Rows(self._log)
        self._last_rows = self._last_image = -1e9  # [s]
        self._switch_interval = sys.getswitchinterval()
        self._thread = threading.Thread(target=self._work, daemon=True)

    def begin(self, source: SourceInfo) -> None:
        self._camera, self._truth = source.camera, source.ground_truth
        self._log.out.log("world", self._log.rr.ViewCoordinates.RDF, static=True)
        sys.setswitchinterval(SWITCH_SECONDS)  # tracking waits no longer than that to hand over
        self._thread.start()

    def frame(self, result: FrameResult, image: Image) -> None:
        self._hand_over(("frame", result, image))

    def keyframe(self, keyframe: Keyframe) -> None:
        self._hand_over(("keyframe", keyframe, None))

    def map_changed(self, keyframes: list[KeyframePose]) -> None:
        self._hand_over(("map", keyframes, None))

    def skipped(self, index: int, stamp: str, reason: str) -> None:
        self._hand_over(("event", f"frame {index} skipped: {reason}", "WARN"))

    def warning(self, text: str) -> None:
        self._hand_over(("event", text, "WARN"))

    def _hand_over(self, item: Any) -> None:
        if self.failure:
            return
        if self._lossless:
            self._queue.put(item)
            return
        try:
            self._queue.put_nowait(item)
        except queue.Full:
            self.dropped += item[0] == "frame"

    def end(self, run: Run) -> None:
        sys.setswitchinterval(self._switch_interval)
        deadline = time.monotonic() + FLUSH_SECONDS
        try:
            self._queue.put(None, timeout=None if self._lossless else FLUSH_SECONDS)
            self._thread.join(None if self._lossless else max(0.0, deadline - time.monotonic()))
            if not self.failure and not self._thread.is_alive():
                self._log_end(run)
            self._log.out.flush(timeout_sec=max(1.0, deadline - time.monotonic()))
        except Exception as error:  # noqa: BLE001: a dead viewer ends no run
            self.failure = self.failure or str(error)
        if self.failure:
            print(f"view: {self.failure}", file=sys.stderr)
        if self._live:
            wait_for_pages()

    def _log_end(self, run: Run) -> None:
        log = self._log
        log.lines("world/path_at_the_end", run.trajectory, FINAL)
        if run.evaluation is not None and self._truth is not None:
            pose = np.linalg.inv(run.evaluation.truth_from_estimate)
            log.line("world/ground_truth", self._truth.positions @ pose[:3, :3].T + pose[:3, 3], TRUTH)
            log.event(f"ATE {run.evaluation.ate.rmse:.4f} m")

    def _work(self) -> None:
        while (item := self._queue.get()) is not None:
            self._try(self._show, item)
        self._try(self._rows.send)
        self._try(self._log_map)

    def _try(self, act: Callable[..., None], *arguments: Any) -> None:
        if self.failure:
            return
        try:
            act(*arguments)
        except Exception as error:  # noqa: BLE001: the run goes on
            self.failure = f"no more is shown: {error}"

    def _show(self, item: Any) -> None:
        kind, value, extra = item
        if kind == "frame":
            self._log_frame(value, extra)
        elif kind == "keyframe":
            self._log_keyframe(value)
        elif kind == "map":
            self._map = value
            if not self._live:
                self._log_map()
        else:
            self._log.event(value, extra)

    def _log_frame(self, result: FrameResult, image: Image) -> None:
        log, rr, camera = self._log, self._log.rr, self._camera
        assert camera is not None
        log.at(result.stamp_ns)
        self._rows.add(
            result.stamp_ns,
            result.pose,
            result.inlier_ratio,
            result.overlap,
            result.milliseconds["total"],
        )
        now = time.monotonic()
        if self._live and now - self._last_rows >= ROWS_PERIOD:
            self._last_rows = now
            self._rows.send()
        shows_images = not self._live or now - self._last_image >= IMAGE_PERIOD
        shows_path = shows_images if self._live else self._count % PATH_PERIOD == 0
        if shows_images:
            self._last_image = now
            log.frustum("world/camera/image", camera, 0.3)
            log.out.log("world/camera/image", rr.Image(image.rgb).compress(jpeg_quality=75))
            step = 2 if self._live else 1
            metres = image.depth[::step, ::step]
            millimetres = np.nan_to_num(np.clip(metres * 1000, 0, 65534)).astype(np.uint16)
            log.out.log("depth", rr.DepthImage(millimetres, meter=1000.0))
            self._log_map()
        if result.status == "lost":
            log.event(f"lost: {result.loss_cause}", "WARN")
        else:
            path = self._path.setdefault(result.segment, [])
            path.append(result.pose[:3, 3])
            if shows_path:
                log.line(f"world/path/{result.segment}", np.array(path), PATH)
        self._count += 1
        if result.status in ("restarted", "relocalized"):
            log.event(f"{result.status}, segment {result.segment}", "WARN")
        if result.new_keyframe is not None:
            log.event(f"keyframe: {result.new_keyframe}")

    def _log_keyframe(self, keyframe: Keyframe) -> None:
        log, rr, camera = self._log, self._log.rr, self._camera
        assert camera is not None
        name = f"world/keyframes/{keyframe.id}"
        log.at(keyframe.stamp_ns)
        log.pose(name, keyframe.pose)
        self._shown[keyframe.id] = keyframe.pose
        log.frustum(f"{name}/frustum", camera, 0.1)
        points = keyframe.points
        log.out.log(f"{name}/points", rr.Points3D(points, colors=keyframe.colours, radii=0.004))
        pixels = points @ camera.matrix.T.astype(np.float32)
        pixels = pixels[:, :2] / pixels[:, 2:]
        # Selected pixels of the newest keyframe, at the place where its own image has them.
        log.out.log("world/camera/image/selected", rr.Points2D(pixels, colors=[PATH], radii=0.8))

    def _log_map(self) -> None:
        for keyframe in self._map:
            shown = self._shown.get(keyframe.id)
            if shown is not None and np.abs(keyframe.pose - shown).max() > MOVED:
                self._log.pose(f"world/keyframes/{keyframe.id}", keyframe.pose)
                self._shown[keyframe.id] = keyframe.pose
        self._map = []


def show_file(file: Path) -> None:
    """A recording, in Rerun's own viewer or on a page."""
    rerun()
    if not file.is_file():
        raise Error(f"{file}: no such file", 3)
    command = [*rerun_program(), str(file)]
    if not has_display():
        options, address = page_options(free_port(GRPC_PORT))
        command += options
        print(address, flush=True)
    else:
        command += ["--port", str(free_port(GRPC_PORT))]
    subprocess.run(command, check=False)


def show_run(folder: Path, record: str | Path | None = None) -> None:
    """A run's folder: paths, keyframes and curves; images are in a recording only."""
    for name in ("frames.jsonl", "trajectory.tum"):
        if not (folder / name).is_file():
            raise Error(f"{folder}: no run here ({name} is missing); edvo run -o writes one", 3)
    log = Log()
    open_sinks(log.out, record, live=record is None, with_images=False)
    log.out.log("world", log.rr.ViewCoordinates.RDF, static=True)
    log_run(log, folder)
    log.out.flush()
    if record is None:
        wait_for_pages()
