# SPDX-License-Identifier: MIT
"""A whole sequence through the odometry."""

from __future__ import annotations

import queue
import threading
from collections.abc import Iterable, Iterator
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from edvo import _core
from edvo.errors import Error
from edvo.evaluation import Evaluation, evaluate
from edvo.odometry import FrameResult, Odometry, Options, Value
from edvo.sources import Frame, Source, open_source
from edvo.trajectory import Trajectory

AHEAD = 6  # frames read before their turn


class Observer:
    """Watches a run: subclass it and override what is of interest. Values cannot be changed."""

    def begin(self, source: Source) -> None:
        """Before the first frame."""

    def frame(self, result: FrameResult, frame: Frame) -> None:
        """A frame was processed: tracked or lost."""

    def skipped(self, frame: Frame, reason: str) -> None:
        """A frame could not be used."""

    def end(self, run: Run) -> None:
        """After the last frame, also of a run that was interrupted."""


@dataclass(frozen=True, eq=False)
class Run:
    """What a run leaves."""

    source: str
    trajectory: Trajectory  # as known at the end; lost frames left out
    keyframes: Trajectory
    frames: list[FrameResult]  # as known at the time
    skipped: list[str]  # why, one for each frame that could not be used
    evaluation: Evaluation | None  # against the source's ground truth, by the TUM protocol
    no_evaluation: str = ""  # why there is none
    interrupted: bool = False  # by ctrl-C
    notes: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)

    @property
    def tracked(self) -> int:
        return sum(result.ok for result in self.frames)

    @property
    def lost(self) -> int:
        return len(self.frames) - self.tracked

    def write(self, folder: str | Path) -> None:
        """trajectory.tum and keyframes.tum into a folder."""
        place = Path(folder)
        place.mkdir(parents=True, exist_ok=True)
        self.trajectory.write(place / "trajectory.tum")
        self.keyframes.write(place / "keyframes.tum")


def read_ahead(frames: Iterable[Frame], size: int = AHEAD) -> Iterator[Frame]:
    """The same frames, read by a thread of its own; closing it ends the thread."""
    waiting: queue.Queue[Any] = queue.Queue(size)
    stop = threading.Event()

    def put(item: Any) -> None:
        while not stop.is_set():
            try:
                waiting.put(item, timeout=0.1)
                return
            except queue.Full:
                continue

    def read() -> None:
        try:
            for frame in frames:
                put((frame, None))
                if stop.is_set():
                    return
            put((None, None))
        except BaseException as error:  # noqa: BLE001: handed to who asks for the next frame
            put((None, error))

    thread = threading.Thread(target=read, daemon=True)
    thread.start()
    try:
        while True:
            frame, error = waiting.get()
            if error is not None:
                raise error
            if frame is None:
                return
            yield frame
    finally:
        stop.set()
        thread.join()


def run(
    source: Source | str | Path,
    *,
    options: Options | None = None,
    method: str = _core.default_method,
    observers: Iterable[Observer] = (),
    max_frames: int | None = None,
    source_options: dict[str, Any] | None = None,
    **changes: Value,
) -> Run:
    """Tracks every frame of a recording and compares the path with ground truth, if there is any.

    ``source``: a ``Source``, or a path for ``open_source`` with ``source_options``. ``options``, or
    ``method`` and keywords "group.field", as for ``Odometry``. Frames that cannot be used are
    skipped and counted; ctrl-C ends the run, whose results so far are its results.
    """
    opened = source if isinstance(source, Source) else open_source(source, **source_options or {})
    watchers = list(observers)
    odometry = Odometry(opened.camera, options, method=method, **changes)
    for watcher in watchers:
        watcher.begin(opened)
    results: list[FrameResult] = []
    skipped: list[str] = []
    interrupted = False
    try:
        with closing(read_ahead(opened)) as frames:  # type: ignore[type-var]
            for count, frame in enumerate(frames):
                if max_frames is not None and count >= max_frames:
                    break
                try:
                    result = odometry.process_ns(
                        frame.stamp_ns, frame.decimals, frame.rgb, frame.depth
                    )
                except (Error, ValueError) as error:
                    skipped.append(f"frame {count}: {error}")
                    for watcher in watchers:
                        watcher.skipped(frame, str(error))
                    continue
                results.append(result)
                for watcher in watchers:
                    watcher.frame(result, frame)
    except KeyboardInterrupt:
        interrupted = True
    finished = finish(opened, odometry, results, skipped, interrupted)
    for watcher in watchers:
        watcher.end(finished)
    return finished


def finish(
    source: Source,
    odometry: Odometry,
    results: list[FrameResult],
    skipped: list[str],
    interrupted: bool,
) -> Run:
    odometry.finish()
    trajectory = odometry.trajectory()
    evaluation, reason = None, "no ground truth"
    if source.ground_truth is not None and len(trajectory):
        try:
            evaluation = evaluate(
                source.ground_truth, trajectory, frames=len(results) + len(skipped)
            )
            reason = ""
        except Error as error:
            reason = str(error)
    return Run(
        source=source.origin or source.name,
        trajectory=trajectory,
        keyframes=odometry.keyframes(),
        frames=results,
        skipped=skipped,
        evaluation=evaluation,
        no_evaluation=reason,
        interrupted=interrupted,
        notes=list(source.notes),
        warnings=list(source.warnings),
    )
