# SPDX-License-Identifier: MIT
"""What must hold of whatever is read, and a look at what reading it takes."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

import edvo

MOST_SECONDS = 5.0  # of one input
MOST_MEGABYTES = 150.0  # of one input, of those that are in use at once
MOST_FRAMES = 20  # that are looked at
LATEST_NS = 9_200_000_000_000_000_000  # of stamps that 64 bits hold


class Broken(AssertionError):
    """Something that must hold does not."""


def require(holds: Any, what: str) -> None:
    if not holds:
        raise Broken(what)


def check_error(error: edvo.Error, *names: str) -> None:
    """One line that names the file (or the topic, which stands for it)."""
    text = str(error)
    require(any(name in text for name in names), f"names none of {names}: {text!r}")
    require(len(text.splitlines()) == 1, f"more than one line: {text!r}")
    require(error.code in range(2, 10), f"code {error.code}: {text!r}")


def attempt(read: Callable[[], Any], *names: str) -> Any:
    """What it gives, or None after an error as it should be."""
    try:
        return read()
    except edvo.Error as error:
        check_error(error, *names)
        return None


def check_trajectory(trajectory: edvo.Trajectory) -> None:
    require(np.isfinite(trajectory.poses).all(), "a pose that is not finite")
    require((np.diff(trajectory.stamps_ns) > 0).all(), "poses out of order")


def check_camera(camera: edvo.Camera) -> None:
    numbers = [camera.fx, camera.fy, camera.cx, camera.cy, *camera.distortion]
    require(np.isfinite(numbers).all(), f"{camera}: not finite")
    require(camera.width >= 1 and camera.height >= 1, f"{camera}: no size")


def check_frame(frame: edvo.Frame, camera: edvo.Camera) -> None:
    require(isinstance(frame.stamp_ns, int), f"stamp {frame.stamp_ns!r}")
    require(abs(frame.stamp_ns) < LATEST_NS, f"stamp {frame.stamp_ns}")
    size = (camera.height, camera.width)
    require(frame.rgb.dtype == np.uint8 and frame.rgb.shape == (*size, 3), f"rgb {frame.rgb.shape}")
    require(frame.depth.dtype == np.float32 and frame.depth.shape == size, f"depth {frame.depth.shape}")


def frames_of(source: edvo.Source) -> Iterator[Callable[[], edvo.Frame]]:
    """What reads each frame, by itself where a source can do that, as runs do."""
    if hasattr(source, "__getitem__"):
        for index in range(min(len(source), MOST_FRAMES)):  # type: ignore[arg-type]
            yield lambda index=index: source[index]  # type: ignore[index,misc]
        return
    frames = iter(source)
    for _ in range(MOST_FRAMES):
        yield lambda: next(frames)


def check_source(path: Path, **options: Any) -> None:
    """Opens it and reads its frames. Errors of frames may name a topic instead of the path."""
    source = attempt(lambda: edvo.open_source(path, **options), path.name)
    if source is None:
        return
    check_camera(source.camera)
    if source.ground_truth is not None:
        check_trajectory(source.ground_truth)
    for note in (*source.notes, *source.warnings, source.origin, source.name):
        require(isinstance(note, str), f"note {note!r}")
    topics = source.origin.rpartition("(")[2].rstrip(")").split(", ")
    for read in frames_of(source):
        try:
            frame = attempt(read, path.name, *topics)
        except StopIteration:
            return
        if frame is not None:
            check_frame(frame, source.camera)


def memory(line: str) -> float:
    """VmRSS or VmHWM [MB]"""
    text = Path("/proc/self/status").read_text(encoding="ascii")
    return int(text.split(line + ":")[1].split()[0]) / 1e3


@contextmanager
def watched() -> Iterator[None]:
    """Raises Broken after what takes too long or too much at once."""
    Path("/proc/self/clear_refs").write_text("5", encoding="ascii")  # forgets the peak until now
    before, begin = memory("VmRSS"), time.monotonic()
    yield
    seconds, megabytes = time.monotonic() - begin, memory("VmHWM") - before
    require(seconds < MOST_SECONDS, f"{seconds:.1f} s")
    require(megabytes < MOST_MEGABYTES, f"{megabytes:.0f} MB at once")
